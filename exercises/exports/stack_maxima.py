"""Select the Maxima functions with which a STACK question marks an answer, for its field "question variables".

Formulas are compared by their values at a few points that the exporter samples. That takes milliseconds for any form
of an answer. STACK's AlgEquiv would prove equality entry by entry. This takes seconds for each entry, but STACK allows
only 30 seconds for a question. The functions have these arguments and variables:

    points          for each point, the values of all symbols; the first two points have the same lengths, so a factor
                    that is the same at both is a constant
    short, given    substitutions for short names such as c12, and for lengths with given numbers
    turning         the names of the revolute joints' variables
    u, w            submitted and correct answer: for each point, a list of entries; false for an entry without a value
"""

from pathlib import Path

from qdot.exercises.arm.chain import is_joint_angle
from qdot.exercises.formula.printers.maxima import print_maxima
from qdot.exercises.problem.problem import Problem

MAX_JOINTS_IN_NAME, MAX_JOINT_NUMBER = 6, 9
"""Maximum number of joints in a short name for a sum of adjacent angles, such as c123, and their maximum number.

Numbers with two digits would be ambiguous: c110 could be joint 110, or joints 1 and 10.
"""
FUNCTIONS_FILE = Path(__file__).with_name("stack_functions.mac")
_DEFINITIONS = [" ".join(text.split()) for text in FUNCTIONS_FILE.read_text(encoding="utf-8").split("\n\n")]


def _select_functions(names: str) -> tuple[str, ...]:
    """Return the definitions of some functions, in the order of the file. `names` are their names without `qdot_`."""
    beginnings = tuple(f"qdot_{name}(" for name in names.split())
    return tuple(definition for definition in _DEFINITIONS if definition.startswith(beginnings))


FORMULA_FUNCTIONS = _select_functions("count read number values close agree same parallel along signed amiss")
NUMBER_FUNCTIONS = _select_functions("count read near")
SET_FUNCTIONS = _select_functions("count read fits covered beyond set_share")
"""The functions for marking formulas, numbers and sets of joint values.

- `qdot_along` returns whether two vectors are parallel at all points; `qdot_parallel` compares them at a single point.
- `qdot_amiss` returns 1 for wrong signs plus 1 for a wrong constant factor. It returns 0 if the answer is correct, and
  if the answer has other errors. The argument `agree` says which entries are correct. The argument `moving` has the
  indices of the entries that depend on the configuration.
- `qdot_fits` returns whether two conditions have the same joint and value. `qdot_covered` counts the correct conditions
  that were found, and `qdot_beyond` counts the false ones (all false values of a joint count as one).
"""


def write_definitions(problem: Problem, functions: tuple[str, ...], *constants: str) -> list[str]:
    """Return the lines that define `given` and `short`, followed by the constants and functions."""
    values = {name: info.value for name, info in problem.symbols.items() if info.value is not None}
    given_equations = ", ".join(f"{name} = {print_maxima(value)}" for name, value in values.items())
    short_names = ", ".join(f"{name} = {meaning}" for name, meaning in list_short_names(problem).items())
    return [f"given: [{given_equations}];", f"short: [{short_names}];", *constants, *functions]


def list_short_names(problem: Problem) -> dict[str, str]:
    """Return short names such as c12 and their meanings: sines and cosines of angles and of sums of adjacent angles."""
    angles = {i: q for i, q in enumerate(problem.chain.q, 1) if is_joint_angle(q)}
    meanings = {}
    for first_joint in angles:
        for last_joint in range(first_joint, min(first_joint + MAX_JOINTS_IN_NAME, MAX_JOINT_NUMBER + 1)):
            joints = range(first_joint, last_joint + 1)
            if not all(i in angles for i in joints):
                break
            digits = "".join(map(str, joints))
            angle_sum = " + ".join(angles[i].name for i in joints)
            meanings.update({f"c{digits}": f"cos({angle_sum})", f"s{digits}": f"sin({angle_sum})"})
    return {name: meaning for name, meaning in meanings.items() if name not in problem.symbols}
