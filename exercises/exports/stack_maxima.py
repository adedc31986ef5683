"""Select the Maxima functions that a STACK question needs in its field "question variables" to mark an answer.

Formulas are compared by their values at a few points that the exporter samples. That takes milliseconds for any form
of an answer. STACK's AlgEquiv would prove equality entry by entry. This takes seconds for each entry, but STACK allows
only 30 seconds for a question. The functions have these arguments and variables:

    points          for each point, the values of all symbols; the first two points have the same lengths, so a factor
                    that is the same at both is a constant
    short, given    substitutions for short names such as c12 and theta_2, and for lengths with given numbers
    known           the names that an answer may contain, besides the short ones
    joints          the names of all joint variables
    revolute        the names of the variables of revolute joints
    u, w            submitted and correct answer: for each point, a list of entries; false for an entry without a value
"""

from collections.abc import Iterator
from pathlib import Path

from qdot.exercises.arm.chain import is_joint_angle
from qdot.exercises.formula.names import split_name
from qdot.exercises.formula.printers.maxima import print_maxima
from qdot.exercises.problem.problem import Problem

MAX_JOINTS_IN_NAME, MAX_JOINT_NUMBER = 6, 9
"""Maximum number of joints in a short name for a sum of angles, such as c123, and highest joint number in such a name.

Numbers with two digits would be ambiguous: c110 could be joint 110, or joints 1 and 10.
"""
NAME_BEGINNINGS = ("theta", "th", "t", "q", "d", "a", "alpha", "beta")
"""Beginnings of names that students may type before a number; `formula.names` decides which of them have a meaning."""
RATE_PATTERNS = (
    *(f"{letter}{dot}" for letter in ("theta", "th", "q") for dot in ("dot{}", "_dot{}", "dot_{}", "{}dot", "{}_dot")),
    "dtheta{}", "dth{}", "dq{}", "dtheta_{}", "dth_{}", "dq_{}", "qd_{}", "d{}_dot", "ddot{}",
)  # fmt: skip
"""How students may type the rate of a joint; `{}` is the joint's number."""
VELOCITY_NAMES = ("xdot", "ydot", "zdot", "x_dot", "y_dot", "z_dot", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
WHOLE_NUMBERS = ("k", "n", "m")
"""The names of whole numbers in conditions, as in theta2 = k*pi."""
FUNCTIONS_FILE = Path(__file__).with_name("stack_functions.mac")
_DEFINITIONS = [" ".join(text.split()) for text in FUNCTIONS_FILE.read_text(encoding="utf-8").split("\n\n")]


def _select_functions(names: str) -> tuple[str, ...]:
    """Return the definitions of some functions, in the order of the file. `names` are their names without `qdot_`."""
    beginnings = tuple(f"qdot_{name}(" for name in names.split())
    return tuple(definition for definition in _DEFINITIONS if definition.startswith(beginnings))


_READING = "count read number is has unknown_names report_names"
FORMULA_FUNCTIONS = _select_functions(
    f"{_READING} check_formulas values close agree same parallel parallel_everywhere signed sign_and_factor_errors"
)
NUMBER_FUNCTIONS = _select_functions("count read number check_numbers near")
SET_FUNCTIONS = _select_functions(
    f"{_READING} sign each_integer split is_value is_read solve conditions has_decimal check_set "
    "same_condition count_found false_conditions set_share"
)
"""The functions for marking formulas, numbers and sets of joint values.

- `qdot_check_formulas`, `qdot_check_numbers` and `qdot_check_set` validate an answer for STACK: they return "" or, if
  qdot can't mark the answer, what the student should type. STACK doesn't count such an answer as an attempt.
- `qdot_conditions` returns the conditions in a set as equations with a joint on the left, if they can be parsed. Values
  that differ by full turns are one condition.
- `qdot_parallel_everywhere` returns whether two vectors are parallel at all points; `qdot_parallel` compares them at a
  single point.
- `qdot_sign_and_factor_errors` returns 1 for wrong signs plus 1 for a wrong constant factor. It returns 0 if the answer
  is correct, and if the answer has other errors. The argument `agree` says which entries are correct. The argument
  `moving` has the indices of the entries that depend on the configuration.
- `qdot_same_condition` returns whether two conditions have the same joint and value. `qdot_count_found` counts the
  correct conditions that were found, and `qdot_false_conditions` counts the false ones (all false values of a joint
  count as one).
"""


def write_definitions(problem: Problem, functions: tuple[str, ...], *constants: str) -> list[str]:
    """Return the lines that define `given`, `short` and `known`, followed by the constants and functions."""
    values = {name: info.value for name, info in problem.symbols.items() if info.value is not None}
    given_equations = ", ".join(f"{name} = {print_maxima(value)}" for name, value in values.items())
    short_names = ", ".join(f"{name} = {meaning}" for name, meaning in list_short_names(problem).items())
    names = [*problem.domain.roles, *(WHOLE_NUMBERS if functions is SET_FUNCTIONS else ())]
    return [
        f"given: [{given_equations}];", f"short: [{short_names}];", f"known: [{', '.join(dict.fromkeys(names))}];",
        *constants, *functions,
    ]  # fmt: skip


def list_short_names(problem: Problem) -> dict[str, str]:
    """Return short names such as c12 and other spellings such as theta_2, each with its meaning in Maxima.

    The names mean the same as in answers that qdot grades.
    """
    symbols = frozenset(problem.domain.roles)
    meanings = {}
    for typed_name in _iterate_typed_names(problem):
        parts = split_name(typed_name, symbols)
        if typed_name in symbols or len(parts) != 1 or not symbols.issuperset(parts[0].names):
            continue
        angle_sum = " + ".join(parts[0].names)
        meanings[typed_name] = f"{parts[0].kind}({angle_sum})" if parts[0].kind in ("cos", "sin") else angle_sum
    return meanings


def _iterate_typed_names(problem: Problem) -> Iterator[str]:
    """Yield names that students may type: sines and cosines of angles and of sums, then symbols of the problem."""
    angle_numbers = [i for i, q in enumerate(problem.chain.q, 1) if is_joint_angle(q) and i <= MAX_JOINT_NUMBER]
    for first_index in range(len(angle_numbers)):
        for count in range(1, min(MAX_JOINTS_IN_NAME, len(angle_numbers) - first_index) + 1):
            digits = "".join(map(str, angle_numbers[first_index : first_index + count]))
            yield from (f"{letter}{digits}" for letter in ("c", "s", "C", "S", "c_", "s_", "C_", "S_"))
            if count > 1:
                yield from (f"{letter}{digits}" for letter in ("theta", "theta_", "th", "th_"))
    for number in map(str, range(1, MAX_JOINT_NUMBER + 1)):
        yield from (f"{letters}{separator}{number}" for letters in NAME_BEGINNINGS for separator in ("", "_"))
        yield from (pattern.format(number) for pattern in RATE_PATTERNS)
    yield from VELOCITY_NAMES
