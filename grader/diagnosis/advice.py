"""Advise, like a teacher, what to look at in a wrong answer that no mistake of the catalogue gives.

Each remark is true, because the answer was compared numerically with the reference, which is the correct answer. No
remark gives the reference away. A remark names a factor common to all entries, a joint on which the answer should or
should not depend, or a simple configuration.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import chain, islice, product

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.figure.lettering import write_symbol
from qdot.exercises.formula.conditions import ConfigurationSpace, compare_sets
from qdot.exercises.formula.order import make_natural_sort_key
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.formula.set_parser import parse_typed_set
from qdot.exercises.formula.trees import Node, ParseError, find_names
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step, solves_equations
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.diagnosis.evaluated_answer import THREE_DIGITS_TOLERANCE
from qdot.grader.diagnosis.numbers import normalize
from qdot.grader.judging.answer_parser import ParsedAnswer, assign_values_to_joint
from qdot.grader.judging.verdict import Diagnosis, name_entry

SAMPLE_COUNT = 5
"""Number of configurations at which an answer is compared with the reference."""
SINGLE_NUMBER_TOLERANCE = 1e-3
"""Relative tolerance for the factor between a single number and the reference."""
FORMULA_TOLERANCE = 1e-7
"""Relative error up to which values of formulas count as equal."""
JOINT_CHANGE = 0.37
"""Change of a joint value (rad or m) that shows whether a result depends on the joint; not a fraction of a turn."""
FACTOR_WORDS = {
    2.0: "2.",
    100.0: "100. Did you mix metres and centimetres?",
    1000.0: "1000. Did you mix metres and millimetres?",
    180 / np.pi: "180/pi. Did you mix degrees and radians?",
    2 * np.pi: "2 pi. Did you mix revolutions and radians?",
}
"""The words for a factor between an answer and the reference, or for its reciprocal."""
REWORK_ADVICE = "Calculate your answer again step by step, and check each number that you took from the problem."
MAX_MISSING_SYMBOLS = 4
"""Maximum number of symbols of the reference that a remark names; an answer that lacks more of them is a different
formula."""
FACTORS_OF_LENGTHS = (100.0, 1000.0)
"""The factors between units of length, by which an angle can't be wrong."""
SIMPLE_ANGLES = (0.0, np.pi / 2, np.pi / 6)
"""The joint angles of configurations that are easy to draw."""
MAX_CONFIGURATIONS = 81
"""Maximum number of configurations with simple angles that are tried."""


def advise(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str = "") -> Diagnosis | None:
    """Return advice on a wrong answer; None if the answer consists of option letters or could not be parsed."""
    if part.answer.is_set:
        remark = _advise_on_set(problem, part, parsed_answer, seed)
    elif parsed_answer.rows is None or any(parsed_answer.is_blank):
        remark = None
    elif is_derived_step_by_step(part):
        remark = _advise_on_formulas(problem, part, parsed_answer, seed)
    else:
        remark = _advise_on_numbers(part, parsed_answer) if part.type == "number" else None
    return None if remark is None else Diagnosis((), remark)


def _advise_on_numbers(part: Part, parsed_answer: ParsedAnswer) -> str | None:
    """Return advice on numbers that are not derived step by step, such as a factor by which they are wrong.

    Return None if there are too few or too many numbers.
    """
    try:
        typed_numbers = evaluate(compile_program(parsed_answer.entries), {}, 1).values
    except (KeyError, ParseError):  # the numbers contain names
        return None
    expected = part.answer.as_matrix()
    if len(typed_numbers) != len(expected):
        return None
    if all(entry.is_Integer for entry in expected):  # a count, such as a rank
        return REWORK_ADVICE
    expected_numbers = np.array([complex(entry) for entry in expected])[:, None]
    return next(_remark_on_factor(typed_numbers, expected_numbers, THREE_DIGITS_TOLERANCE, part), REWORK_ADVICE)


def _advise_on_formulas(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> str | None:
    """Return advice on an answer that is derived step by step; None if it has unknown symbols or another shape."""
    values = sample_configurations(problem.chain, part, problem.domain, SAMPLE_COUNT, Stream(f"{seed}/advice"))
    if parsed_answer.symbols - set(values):
        return None
    pair = _AnswerAndReference(problem.chain, part, compile_program(parsed_answer.entries))
    expected_names = _find_names_of_reference(problem, part)
    typed_names = {name for name in parsed_answer.symbols if isinstance(problem.domain.roles.get(name), str)}
    surplus_names = set() if part.details.given_joints else typed_names - expected_names
    try:
        answer_values, expected_values = pair.evaluate(values)
        if answer_values.shape != expected_values.shape:
            return None  # the verdict's reason says so
        tolerance = THREE_DIGITS_TOLERANCE if part.answer.is_numeric else FORMULA_TOLERANCE
        remarks = chain(
            _remark_on_factor(answer_values, expected_values, tolerance, part),
            _remark_on_joints(pair, values),
            _remark_on_symbols(pair, values, expected_names - parsed_answer.symbols, are_missing=True),
            _remark_on_symbols(pair, values, surplus_names, are_missing=False),
            _remark_on_configuration(pair, values),
        )
        return next(remarks)
    except ParseError:
        return None


@dataclass(frozen=True)
class _AnswerAndReference:
    """An answer, compiled as `program`, and its reference, which are evaluated at the same configurations."""

    chain: Chain
    part: Part
    program: Program

    def evaluate(self, values: SymbolValues) -> tuple[np.ndarray, np.ndarray]:
        """Return the values of the answer and of the reference that are compared, (entries, N) each."""
        with np.errstate(all="ignore"):
            answer = np.asarray(evaluate(self.program, values, len(next(iter(values.values())))).values)
            expected = compute_answer(compute_numeric_stages(self.chain, values), self.part)
            return self._remove_factor(answer), self._remove_factor(expected.reshape(-1, expected.shape[-1]))

    def _remove_factor(self, entries: np.ndarray) -> np.ndarray:
        """Return the values unchanged, unless they are a direction.

        For a direction, return the products of any two entries of the unit vector, which don't depend on its sign.
        """
        if not self.part.answer.is_direction:
            return entries
        direction = normalize(entries)
        return (direction[:, None] * direction[None]).reshape(-1, entries.shape[-1])


def _remark_on_factor(answer: np.ndarray, expected: np.ndarray, tolerance: float, part: Part) -> Iterator[str]:
    """Yield a remark if all entries of an answer differ from the expected entries by the same factor."""
    if answer.shape != expected.shape:
        return
    is_nonzero = np.abs(expected) > FORMULA_TOLERANCE * np.abs(expected).max(initial=0.0)
    if not is_nonzero.any() or (np.abs(answer[~is_nonzero]) > FORMULA_TOLERANCE).any():
        return
    ratios = answer[is_nonzero] / expected[is_nonzero]
    factor = float(ratios[0].real)
    is_common = np.isfinite(ratios).all() and (np.abs(ratios - factor) <= tolerance * abs(factor)).all()
    if not is_common or factor in (0.0, 1.0):
        return
    # A single wrong number always differs by some factor, so this factor must be more precise.
    factor_tolerance = SINGLE_NUMBER_TOLERANCE if len(ratios) == 1 else tolerance
    are_angles = set(part.answer.expected_units) == {"rad"}
    for candidate, words in FACTOR_WORDS.items():
        if are_angles and candidate in FACTORS_OF_LENGTHS:
            continue
        for size_word, known_factor in (("large", candidate), ("small", 1 / candidate)):
            if abs(factor / known_factor - 1) < factor_tolerance:
                yield f"Your answer is too {size_word} by a factor of {words}"
    # Equal numbers may have the same wrong factor by chance.
    if len(ratios) > 1 and np.ptp(expected[is_nonzero].real) > FORMULA_TOLERANCE:
        yield (
            "Your answer is wrong by a constant factor. Check units, roots and squares, and whether a vector must have "
            "length 1."
        )


def _remark_on_joints(pair: _AnswerAndReference, values: SymbolValues) -> Iterator[str]:
    """Yield a remark on the first joint on which the answer depends but the reference doesn't, or vice versa."""
    values_before = pair.evaluate(values)
    for i, q in enumerate(() if pair.part.details.list_given_values(pair.chain) else pair.chain.q, 1):
        if q in pair.part.details.given_joints:
            return
        values_after = pair.evaluate({**values, q.name: values[q.name] + JOINT_CHANGE})
        answer_changes, expected_changes = map(_has_changed, values_after, values_before)
        if expected_changes and not answer_changes:
            yield f"Your answer does not depend on {_write_name(q.name)}. What changes if only joint {i} moves?"
            return
        if answer_changes and not expected_changes:
            name = _write_name(q.name)
            yield f"Your answer depends on {name}. If only joint {i} moves, the requested result does not change."
            return


def _find_names_of_reference(problem: Problem, part: Part) -> set[str]:
    """Return the names of the symbols without a given value in a reference that consists of formulas."""
    names = {symbol.name for entry in part.answer.list_entries() for symbol in entry.free_symbols}
    return {name for name in names if isinstance(problem.domain.roles.get(name), str)}


def _remark_on_symbols(
    pair: _AnswerAndReference, values: SymbolValues, names: Collection[str], are_missing: bool
) -> Iterator[str]:
    """Yield a remark on the symbols on which only the reference depends (`are_missing`) or only the answer depends.

    Only `names` are considered, and nothing is yielded for many symbols.
    """
    values_before = pair.evaluate(values)
    relevant_names = []
    for name in sorted(names, key=make_natural_sort_key):
        values_after = pair.evaluate({**values, name: values[name] + JOINT_CHANGE})
        answer_changes, expected_changes = map(_has_changed, values_after, values_before)
        if (answer_changes, expected_changes) == (not are_missing, are_missing):
            relevant_names.append(name)
    if 0 < len(relevant_names) <= MAX_MISSING_SYMBOLS:
        verbs = ("does not contain", "depends") if are_missing else ("contains", "does not depend")
        conjunction = " or " if are_missing else " and "
        listing = conjunction.join(filter(None, [", ".join(relevant_names[:-1]), relevant_names[-1]]))
        pronoun = "it" if len(relevant_names) == 1 else "them"
        yield f"Your answer {verbs[0]} {listing}, but the requested result {verbs[1]} on {pronoun}."


def _write_name(symbol: str) -> str:
    """Return the name of a joint variable as in the drawings, such as θ1."""
    return "".join(text for text, _, _ in write_symbol(symbol))


def _has_changed(values_after: np.ndarray, values_before: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(values_after - values_before) > FORMULA_TOLERANCE * (1 + np.abs(values_before))).any())


def _remark_on_configuration(pair: _AnswerAndReference, values: SymbolValues) -> Iterator[str]:
    """Yield a remark that names a configuration with simple angles at which the answer is wrong."""
    if pair.part.details.list_given_values(pair.chain) or pair.part.details.given_joints:
        check = "To check them, substitute them into the equation that they solve."
        solves_several = solves_equations(pair.part) and pair.part.shape not in (None, (1, 1))
        yield f"Calculate the numbers again step by step. {check}" if solves_several else REWORK_ADVICE
        return
    revolute_joints = [q for q, joint in zip(pair.chain.q, pair.chain.joints, strict=True) if joint.is_revolute]
    first_values = {name: value[:1] for name, value in values.items()}
    for angles in islice(product(SIMPLE_ANGLES, repeat=len(revolute_joints)), MAX_CONFIGURATIONS):
        joint_angles = dict(zip(revolute_joints, angles, strict=True))
        joint_values = {q.name: np.array([angle]) for q, angle in joint_angles.items()}
        answer_values, expected_values = pair.evaluate(first_values | joint_values)
        errors, sizes = np.abs(answer_values - expected_values)[:, 0], np.abs(expected_values)[:, 0]
        is_correct = errors <= FORMULA_TOLERANCE * (1 + sizes)
        if not is_correct.all() and np.isfinite(expected_values).all():
            angles_text = ", ".join(
                f"{_write_name(q.name)} = {round(np.degrees(angle))}°" for q, angle in joint_angles.items()
            )
            location, adverb = (f" at {angles_text}", " there") if angles_text else ("", "")
            entry = _name_entry(pair.part, int(is_correct.argmin()))
            yield f"Draw the arm{location} and calculate {entry}{adverb} by hand. Your answer gives another value."
            return
    yield "Substitute a configuration that is easy to draw, and compare your answer with the drawing term by term."


def _name_entry(part: Part, index: int) -> str:
    if part.shape is None or part.shape == (1, 1) or part.answer.is_direction:
        return "the result"
    return name_entry(index, 1 if 1 in part.shape else part.shape[1])


def _advise_on_set(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> str | None:
    """Return advice on a set of configurations: on the joints that it names, or else on its values."""
    if parsed_answer.refusal is not None or parsed_answer.tree is None:
        return None
    answer = part.answer_as(ConditionSet)
    components = answer.components
    expressions = [condition for component in components for condition in component.conditions]
    expected_joints = {symbol.name for expression in expressions for symbol in expression.free_symbols}
    named_joints = find_names(parsed_answer.tree)
    joint_names = [q.name for q in problem.chain.q]
    differing_names = [name for name in joint_names if (name in expected_joints) != (name in named_joints)]
    if differing_names:
        name = differing_names[0]
        fact = f"Your answer {'does not contain' if name in expected_joints else 'contains'} {_write_name(name)}."
        is_square = problem.chain.has_square_jacobian
        zeros = "zeros of the determinant" if is_square else "common zeros of the maximal minors"
        return f"{fact} Do the {zeros if answer.is_singular_set else 'requested configurations'} depend on it?"
    are_simultaneous = any(len(component.conditions) > 1 for component in components)
    return _advise_on_claims(problem, part, parsed_answer.tree, seed, are_simultaneous)


def _advise_on_claims(problem: Problem, part: Part, tree: Node, seed: str, are_simultaneous: bool) -> str | None:
    """Return advice that depends on whether the configurations in the answer are right.

    `are_simultaneous` is whether some of the expected conditions have to hold simultaneously.
    """
    joints, domain = [q.name for q in problem.chain.q], problem.domain
    try:
        claimed_pieces = parse_typed_set(assign_values_to_joint(tree, joints), joints)
        conditions = [condition for (condition,) in part.answer.parse_trees(domain.roles)]
        space = ConfigurationSpace(joints, domain, part.rounding)
        expected_pieces = space.parse_reference(conditions)
        comparison = compare_sets(claimed_pieces, expected_pieces, space, seed)
    except ParseError:
        return None
    if comparison.is_only_rounded:
        return "Rounded values earn fewer points. Write exact values, such as pi/3 or acos(1/3)."
    advice = "Set each factor to zero by itself, and look for all angles in a full turn."
    if are_simultaneous:
        advice = "Look for all angles in a full turn, and for factors that are zero at the same time."
    if comparison.surplus is None:
        return f"All configurations in your answer are right, but some are missing. {advice}"
    formula, result = "condition", "The condition must hold"
    if part.answer_as(ConditionSet).is_singular_set:
        has_determinant = problem.chain.has_square_jacobian
        formula = "determinant" if has_determinant else "maximal minors"
        result = "The result must be zero" if has_determinant else "The results must all be zero"
    sentences = [f"Substitute each configuration in your answer into the {formula}."]
    if are_simultaneous or any(len(piece) > 1 for piece in claimed_pieces):
        sentences.append("If several values must hold together, substitute all of them.")
    return " ".join([*sentences, f"{result} for all values of the other joints.", advice])
