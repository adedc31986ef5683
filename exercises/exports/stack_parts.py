"""Convert parts to STACK's form: the input, Maxima code for marking, nodes of the response tree, and question tests.

STACK compares formulas at a few points, and matrices entry by entry with qdot's partial credit. It compares numbers
within their tolerance, and sets of joint values modulo full turns. A question test is a sample answer with the mark
that STACK must give it. Question tests submit names of question variables, because STACK stores only 255 characters of
an answer.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import sympy as sp

from qdot.exercises import reference_answers
from qdot.exercises.arm.chain import is_joint_angle
from qdot.exercises.common.errors import Reason
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports import stack_maxima
from qdot.exercises.exports.export_format import ShareOfTypedAnswer
from qdot.exercises.exports.known_wrong_answers import (
    KnownWrongAnswer,
    compare_entry_by_entry,
    find_known_wrong_answers,
    list_tolerances,
    make_domain,
    parse_entries,
)
from qdot.exercises.formula.equality import READABLE_POINTS
from qdot.exercises.formula.printers.maxima import print_maxima, print_maxima_matrix
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.exercises.problem.credit import SIGN_OR_FACTOR_COST
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS
from qdot.exercises.short_questions.options import list_blames
from qdot.exercises.singularities.singular_set import Component
from qdot.exercises.writing.units import format_unit

ShareOfMistake = Callable[[KnownWrongAnswer], Fraction]
"""A function that returns the share of the points for a known wrong answer."""
MAX_MISTAKES = 6
"""Maximum number of known mistakes in a part's response tree. Each mistake adds a node and a question test."""
CORRECT_NOTE, UNEXPLAINED_NOTE = "prt1-right", "prt1-other"
"""STACK's answer notes for a correct answer, and for an answer that no known mistake explains."""
POINT_COUNT, MAX_TRIES = 3, 20
"""Number of points at which formulas are compared, and maximum number of attempts to sample usable points."""
NO_POINTS = Reason("no configurations were found at which formulas could be compared")
MIN_PIVOT, MAX_ENTRY = 1e-2, 1e4
"""At a usable point, no entry of the answer exceeds MAX_ENTRY, and the pivot, if there is one, exceeds MIN_PIVOT.

The pivot is the entry that is compared to find a constant factor between two matrices.
"""
MIN_BOX_WIDTH, MAX_BOX_WIDTH = 8, 60
"""Minimum and maximum width in characters of an input box for a formula or an entry of a vector."""
MIN_CELL_WIDTH, MAX_CELL_WIDTH = 6, 24
"""Minimum and maximum width in characters of an input box for an entry of a matrix."""
UNRELATED_VALUE = 7
"""A value that no mistake leads to, for the question test of an answer that no known mistake explains."""


@dataclass(frozen=True)
class ResponseNode:
    """A node of a response tree. It compares two Maxima expressions, `left` and `right`, by STACK's answer test `test`.

    If the expressions are equal, the answer gets the node's note, score and feedback. `options` are options of the
    test.
    """

    test: str
    left: str
    right: str
    answer_note: str
    score: str
    feedback: str = ""
    options: str = ""


@dataclass(frozen=True)
class QuestionTest:
    """A question test: an answer with its expected score (None if STACK must not mark the answer) and answer note.

    `value` is the answer as a Maxima expression.
    """

    title: str
    value: str
    score: float | None
    answer_note: str


# ta1, ans1 and prt1 are STACK's names for the reference, the typed answer and the response tree.
REFERENCE_TEST = QuestionTest("the reference", "ta1", 1.0, CORRECT_NOTE)
UNUSUAL_FORM_TEST = QuestionTest("another form of the reference", "form1", 1.0, CORRECT_NOTE)
UNKNOWN_NAME_TEST = QuestionTest("answers with unknown names are not graded", "unknown1", None, "NULL")
UNRELATED_TEST = QuestionTest("an answer without a known mistake", "other1", 0.0, UNEXPLAINED_NOTE)


@dataclass(frozen=True)
class StackPart:
    """A part in STACK's terms. The first node and the first question test are for the reference answer.

    `expected_answer` says what students must type. `variables` and `marking_lines` are Maxima code. If no node matches
    an answer, the answer gets `fallback_feedback` and the value of `score_variable` as score.
    """

    part: Part
    input_type: str
    expected_answer: str
    variables: list[str]
    marking_lines: list[str]
    nodes: list[ResponseNode]
    question_tests: list[QuestionTest]
    fallback_feedback: str = ""
    score_variable: str = "0"
    box_width: int = 15
    validator: str = ""
    """Name of the Maxima function that explains why an answer is invalid; invalid answers don't count as attempts."""
    typing_help: str = ""
    """Instructions on how to type formulas."""

    @property
    def has_single_box(self) -> bool:
        """Whether students type into one free box, so that STACK may be unable to parse the answer."""
        return self.input_type in ("algebraic", "numerical")

    def add_mistake(
        self, index: int, known_answer: KnownWrongAnswer, answer: str, comparison: str, target: str, share: Fraction
    ) -> None:
        """Add a known wrong answer, as the variable wrongN (N is `index`), with the share of the points that it earns.

        `answer`, `comparison` and `target` are Maxima expressions. A student gave this wrong answer if `comparison`
        equals `target`.
        """
        name, note = f"wrong{index}", f"prt1-{known_answer.mistake}"
        self.variables.append(f"{name}: {answer};")
        self.marking_lines.append(f"like{index}: {comparison};")
        if share:
            self.marking_lines.append(f"share: if like{index} = {target} then max(share, {share}) else share;")
        feedback = known_answer.feedback
        self.nodes.append(ResponseNode("AlgEquiv", f"like{index}", target, note, self.score_variable, feedback))
        self.question_tests.append(QuestionTest(known_answer.title, name, float(share), note))


def convert_part(problem: Problem, part: Part, compute_earned_share: ShareOfTypedAnswer) -> StackPart | Reason:
    """Return a part in STACK's form, or the reason why STACK can't ask it.

    `compute_earned_share` returns the share of the points that a known wrong answer earns.
    """

    def compute_share(known_answer: KnownWrongAnswer) -> Fraction:
        return compute_earned_share(problem, part, known_answer.make_answer(part.answer).as_typed())

    match part.answer:
        case reference_answers.Number():
            return _convert_numbers(problem, part, compute_share)
        case reference_answers.ConditionSet():
            return _convert_set(problem, part, compute_share)
        case reference_answers.Direction(is_numeric=True):
            return Reason("numeric directions are not supported")
        case reference_answers.Direction():
            return _convert_direction(problem, part)
        case reference_answers.Choice():
            return _convert_choice(part)
        case reference_answers.Selection() | reference_answers.Matching():
            return Reason("questions with several right letters are not supported; use an export format for quizzes")
        case reference_answers.Words():
            return Reason("a person has to mark it")
        case answer if answer.is_symbolic:
            return _convert_formulas(problem, part, compute_share)
        case answer:
            raise TypeError(f"STACK does not support answers of type {answer.type}")


def _find_varying_indices(problem: Problem, reference: sp.Matrix) -> list[int]:
    """Return the indices (from 0, row by row) of entries that depend on joint variables, joint rates or velocities."""
    constants = problem.constants
    return [k for k, entry in enumerate(reference) if {symbol.name for symbol in entry.free_symbols} - constants]


def _find_pivot_position(problem: Problem, reference: sp.Matrix) -> int | None:
    """Return the position of the pivot, which is the first nonzero entry.

    Return None if all entries are zero, or if the only nonzero entry is a constant. Positions count the entries row by
    row from 1, as Maxima does.
    """
    nonzero_positions = [k for k, entry in enumerate(reference, 1) if entry != 0]
    has_pivot = len(nonzero_positions) > 1 or (nonzero_positions and _find_varying_indices(problem, reference))
    return nonzero_positions[0] if has_pivot else None


def _separate_zeros(reference: sp.Matrix) -> tuple[list[int], list[int]]:
    """Return the indices of the entries that earn points, and those of the zeros, which earn nothing.

    If all entries are zero, all earn points.
    """
    nonzero_indices = [k for k, entry in enumerate(reference) if entry != 0]
    zero_indices = [k for k in range(len(reference)) if k not in nonzero_indices]
    return (nonzero_indices, zero_indices) if nonzero_indices else (zero_indices, [])


def _list_nonzero_columns(reference: sp.Matrix) -> list[list[int]]:
    """Return the indices of the entries of each nonzero column."""
    columns = (list(range(j, len(reference), reference.cols)) for j in range(reference.cols))
    return [column for column in columns if any(reference[k] != 0 for k in column)]


# --- formulas ---


def _convert_formulas(problem: Problem, part: Part, compute_share: ShareOfMistake) -> StackPart | Reason:
    """Return a part that asks for a formula or a matrix of formulas, or the reason why STACK can't ask it."""
    is_single, reference = part.shape is None, part.answer.as_matrix()
    pivot_position = _find_pivot_position(problem, reference) or 1  # without a pivot, the first entry
    points = _sample_points(problem, reference, pivot_position)
    if points is None:
        return NO_POINTS
    variables = stack_maxima.write_definitions(problem, stack_maxima.FORMULA_FUNCTIONS, points)
    variables += [f"ta1: {_write_maxima(reference, is_single)};", f"other1: 0*ta1 + {UNRELATED_VALUE};"]
    variables.append("unknown1: ta1 + unknown_name;")
    marking = [
        "typed: qdot_values(qdot_read(ans1));", "expected: qdot_values(ta1);", "agree: qdot_agree(typed, expected);",
    ]  # fmt: skip
    marking.append(f"same: if qdot_count(agree) = {len(reference)} then 1 else 0;")
    score, feedback = "0", ""
    if part.credit.rule != "whole":
        lines, feedback = _write_partial_credit_lines(problem, part, reference)
        marking += lines
        score = "share"
    boxes_text = f"one formula in each of the {reference.rows} × {reference.cols} boxes"
    max_length = max(len(print_maxima(entry)) for entry in reference)
    is_column = is_single or reference.cols == 1
    min_width, max_width = (MIN_BOX_WIDTH, MAX_BOX_WIDTH) if is_column else (MIN_CELL_WIDTH, MAX_CELL_WIDTH)
    tests = [REFERENCE_TEST]
    stack_part = StackPart(
        part, "algebraic" if is_single else "matrix", "a formula" if is_single else boxes_text, variables, marking,
        [ResponseNode("AlgEquiv", "same", "1", CORRECT_NOTE, "1")], tests, feedback, score,
        min(max_width, max(min_width, max_length)), validator="qdot_check_formulas",
        typing_help=explain_typing(problem),
    )  # fmt: skip
    for index, known_answer in enumerate(find_known_wrong_answers(problem, part, MAX_MISTAKES), 1):
        maxima, comparison = _write_maxima(known_answer.matrix, is_single), f"qdot_same(typed, wrong{index})"
        stack_part.add_mistake(index, known_answer, maxima, comparison, "1", compute_share(known_answer))
    unusual_form = _write_unusual_form(problem, reference)
    if unusual_form is not None:
        variables.append(f"form1: {_write_maxima(unusual_form, is_single)};")
        tests.append(UNUSUAL_FORM_TEST)
    tests += [UNRELATED_TEST, UNKNOWN_NAME_TEST]
    return stack_part


def explain_typing(problem: Problem) -> str:
    """Return instructions on how to type formulas, with this arm's names as examples."""
    joint = problem.chain.q[0]
    rule = f"Type names as in the statement, such as {joint}; write * in products, as in 2*{joint}."
    meanings = stack_maxima.list_short_names(problem)
    # c1, s1, c12, s12, for example
    examples = [name for name in meanings if len(name) == 2][:2] + [name for name in meanings if len(name) == 3][:2]
    explanations = ", ".join(f"{name} is {meanings[name]}" for name in examples)
    return f"{rule} Abbreviations: {explanations}." if explanations else rule


def _write_maxima(matrix: sp.Matrix, is_single: bool) -> str:
    return print_maxima(matrix[0]) if is_single else print_maxima_matrix(matrix)


def _sample_points(problem: Problem, reference: sp.Matrix, pivot_position: int) -> str | None:
    """Return the line with the points at which formulas are compared; None if no usable points were found.

    The first two points share the arm's constants, so a ratio of answer and reference that is equal at both doesn't
    depend on the joint variables. Positions in a matrix are counted row by row from 1.
    """
    domain = make_domain(problem)
    program = compile_program(parse_entries(problem, reference))
    for attempt in range(MAX_TRIES):
        stream = Stream(f"stack/{problem.id}/{reference.shape}/{attempt}")
        samples = domain.sample(set(domain.roles), READABLE_POINTS, stream)
        points = [{name: float(values[i]) for name, values in samples.items()} for i in range(POINT_COUNT)]
        points[1].update({name: value for name, value in points[0].items() if name in problem.constants})
        if _are_usable(program, points, None if reference[pivot_position - 1] == 0 else pivot_position - 1):
            point_texts = (", ".join(f"{name} = {value}" for name, value in point.items()) for point in points)
            return f"points: [{', '.join(f'[{text}]' for text in point_texts)}];"
    return None


def _are_usable(program: Program, points: Sequence[dict[str, float]], pivot_index: int | None) -> bool:
    """Return whether all entries are moderate real numbers at all points, and the pivot (if any) is far from zero."""
    values_by_name = {name: np.array([point[name] for point in points]) for name in points[0]}
    values, _ = evaluate(program, values_by_name, len(points))
    are_moderate = np.isfinite(values) & (values.imag == 0) & (np.abs(values) < MAX_ENTRY)
    return bool(are_moderate.all() and (pivot_index is None or (np.abs(values[pivot_index]) > MIN_PIVOT).all()))


def _write_partial_credit_lines(problem: Problem, part: Part, reference: sp.Matrix) -> tuple[list[str], str]:
    """Return the lines that compute the share of partly correct formulas, and the feedback on such formulas."""
    lines, feedback = (["share: 0;"], "") if part.shape is None else _write_entry_lines(problem, part, reference)
    if _find_pivot_position(problem, reference) is None:
        return lines, feedback
    varying_positions, factor = [k + 1 for k in _find_varying_indices(problem, reference)], part.credit.factor
    # qdot_sign_and_factor_errors returns 0 if the answer has errors of other kinds.
    lines += [
        f"error_count: qdot_sign_and_factor_errors(typed, expected, agree, {varying_positions});",
        f"share: max(share, if error_count = 0 then 0 else {factor}*(1 - {SIGN_OR_FACTOR_COST}*error_count));",
    ]
    factor_feedback = "Your answer is right except for signs, a common factor, or both."
    return lines, feedback + f'[[if test="error_count>0"]]<p>{factor_feedback}</p>[[/if]]'


def _write_entry_lines(problem: Problem, part: Part, reference: sp.Matrix) -> tuple[list[str], str]:
    """Return the lines that compute the share of a partly correct matrix, and the feedback on the matrix.

    A zero of the reference is spoiled if it is not zero in the answer. Each spoiled zero cancels one right entry.
    """
    credit = part.credit
    counted_indices, zero_indices = _separate_zeros(reference)

    def write_agreeing_count(indices: Sequence[int]) -> str:
        return f"qdot_count(makelist(agree[i], i, {[k + 1 for k in indices]}))"

    factor_text = "" if credit.factor == 1 else f"*{credit.factor}"
    if credit.rule == "columns" and reference.cols > 1:
        columns = _list_nonzero_columns(reference)
        n = len(columns)
        tests = ", ".join(f"is({write_agreeing_count(column)} = {len(column)})" for column in columns)
        lines = [f"right: qdot_count([{tests}]);", f"share: min(right, {n - 1})/{n}{factor_text};"]
        feedback = f"{n} columns are right"
    else:
        n = len(counted_indices)
        spoiled_count = f"{len(zero_indices)} - {write_agreeing_count(zero_indices)}" if zero_indices else "0"
        lines = [f"right: {write_agreeing_count(counted_indices)};", f"spoiled: {spoiled_count};"]
        lines.append(f"share: max(0, min(right - spoiled, {n - 1}))/{n}{factor_text};")
        feedback = f"{n} entries are right"
        if zero_indices:
            feedback = (
                f"{n} nonzero entries are right; {{@spoiled@}} of {len(zero_indices)} zeros are not zero in your answer"
            )
    if varying_indices := _find_varying_indices(problem, reference):
        lines.append(f"share: if share > 0 and {write_agreeing_count(varying_indices)} = 0 then 0 else share;")
    return lines, f"<p>{{@right@}} of {feedback}.</p>"


def _write_unusual_form(problem: Problem, reference: sp.Matrix) -> sp.Matrix | None:
    """Return the reference in an unusual form that the grader judges as equal; None if the arm has no such form."""
    first_angle = next(filter(is_joint_angle, problem.chain.q), None)
    if first_angle is None:
        return None
    one_as_squares = sp.sin(first_angle) ** 2 + sp.cos(first_angle) ** 2
    unusual_form = reference.applyfunc(lambda entry: sp.expand_trig(entry) * one_as_squares if entry != 0 else entry)
    return unusual_form if all(compare_entry_by_entry(problem, unusual_form, reference)) else None


def _convert_direction(problem: Problem, part: Part) -> StackPart | Reason:
    """Return a part that asks for a direction: any nonzero multiple of the reference is correct."""
    reference = part.answer_as(reference_answers.Direction).reference
    pivot_position = next(i for i, entry in enumerate(reference, 1) if entry != 0)
    points = _sample_points(problem, reference, pivot_position)
    if points is None:
        return NO_POINTS
    same_line = f"same: if qdot_parallel_everywhere(typed, qdot_values(ta1), {pivot_position}) then 1 else 0;"
    variables = stack_maxima.write_definitions(problem, stack_maxima.FORMULA_FUNCTIONS, points)
    variables += [f"ta1: {print_maxima_matrix(reference)};", "form1: -3*ta1;", "other1: 0*ta1;"]
    variables.append("unknown1: ta1 + unknown_name;")
    return StackPart(
        part, "matrix", "a vector; any nonzero multiple is also correct", variables,
        ["typed: qdot_values(qdot_read(ans1));", same_line], [ResponseNode("AlgEquiv", "same", "1", CORRECT_NOTE, "1")],
        [REFERENCE_TEST, UNUSUAL_FORM_TEST, UNRELATED_TEST, UNKNOWN_NAME_TEST], validator="qdot_check_formulas",
        typing_help=explain_typing(problem),
    )  # fmt: skip


# --- numbers ---


def _convert_numbers(problem: Problem, part: Part, compute_share: ShareOfMistake) -> StackPart:
    """Return a part that asks for a number or a vector of numbers."""
    answer = part.answer_as(reference_answers.Number)
    n = len(answer.reference)
    is_single = n == 1
    tolerances = [sp.Rational(f"{tolerance:.12g}") for tolerance in list_tolerances(part)]
    known_answers = find_known_wrong_answers(problem, part, MAX_MISTAKES)
    exact_reference = sp.Matrix([sp.Rational(f"{float(value):.12g}") for value in answer.reference])
    subscript = "" if is_single else "[i, 1]"

    def write_near_count(variable: str) -> str:
        return f"qdot_count(makelist(qdot_near(typed{subscript}, float({variable}{subscript}), room[i]), i, 1, {n}))"

    absolute_tolerances = answer.find_allowed_errors(part.rounding).absolute
    pairs = zip(answer.reference, absolute_tolerances, strict=True)
    is_zero = [abs(float(value)) <= tolerance for value, tolerance in pairs]
    lines = ["typed: qdot_read(ans1);", f"room: [{', '.join(map(print_maxima, tolerances))}];"]
    lines += [f"right: {write_near_count('ta1')};", *_write_number_share_lines(part, is_zero)]
    variables = stack_maxima.write_definitions(problem, stack_maxima.NUMBER_FUNCTIONS)
    reference_floats = _write_floats(exact_reference, is_single)
    variables.append(f"ta1: {reference_floats};")
    first_node = ResponseNode("AlgEquiv", "right", str(n), CORRECT_NOTE, "1")
    if is_single:
        first_node = ResponseNode("NumAbsolute", "typed", "ta1", CORRECT_NOTE, "1", options=print_maxima(tolerances[0]))
    unit = "; ".join(dict.fromkeys(format_unit(unit) for unit in answer.units if unit))
    unit_text = f", in {unit}, without the unit" if unit else ""
    expected_answer = f"{'a number' if is_single else f'{n} numbers'}{unit_text}"
    feedback = "" if is_single else f"<p>{{@right@}} of {n} numbers are right.</p>"
    tests = [replace(REFERENCE_TEST, value=_choose_test_value("ta1", reference_floats))]
    stack_part = StackPart(
        part, "numerical" if is_single else "matrix", expected_answer, variables, lines, [first_node], tests,
        feedback, "share", box_width=12, validator="" if is_single else "qdot_check_numbers",
        typing_help="" if is_single else "Type tiny numbers as 2.7*10^-5, not as 2.7e-5.",
    )  # fmt: skip
    for index, known_answer in enumerate(known_answers, 1):
        floats, comparison = _write_floats(known_answer.matrix, is_single), write_near_count(f"wrong{index}")
        stack_part.add_mistake(index, known_answer, floats, comparison, str(n), compute_share(known_answer))
        tests[-1] = replace(tests[-1], value=_choose_test_value(tests[-1].value, floats))
    values_outside = exact_reference + 50 * sp.Matrix(tolerances)  # clearly wrong
    values_inside = exact_reference + sp.Matrix(tolerances) / 2
    floats = _write_floats(values_inside, is_single)
    variables.append(f"form1: {floats};")
    tests.append(QuestionTest("off by half the tolerance", _choose_test_value("form1", floats), 1.0, CORRECT_NOTE))
    if not any(_are_near(values_outside, known_answer.matrix, tolerances) for known_answer in known_answers):
        floats = _write_floats(values_outside, is_single)
        variables.append(f"other1: {floats};")
        tests.append(replace(UNRELATED_TEST, value=_choose_test_value("other1", floats)))
    if not is_single:
        variables.append("unknown1: ta1 + unknown_name;")
        tests.append(UNKNOWN_NAME_TEST)
    return stack_part


def _write_number_share_lines(part: Part, is_zero: Sequence[bool]) -> list[str]:
    """Return the lines that compute the share of numbers that are not all correct."""
    n = len(is_zero)
    if n == 1 or part.credit.rule == "whole":
        return ["share: 0;"]
    counted_positions = [i for i, zero in enumerate(is_zero, 1) if not zero] or list(range(1, n + 1))
    zero_positions = [i for i in range(1, n + 1) if i not in counted_positions]
    near_count_template = "qdot_count(makelist(qdot_near(typed[i, 1], float(ta1[i, 1]), room[i]), i, {}))"
    spoiled_count = f"{len(zero_positions)} - {near_count_template.format(zero_positions)}"
    earned_count = f"{near_count_template.format(counted_positions)} - ({spoiled_count})"
    lines = [f"share: max(0, min({earned_count}, {len(counted_positions) - 1}))/{len(counted_positions)};"]
    if not all(is_zero):
        same_size_test = "qdot_near(abs(typed[i, 1]), float(abs(ta1[i, 1])), room[i])"
        condition = f"qdot_count(makelist({same_size_test}, i, 1, {n})) = {n}"
        lines.append(f"share: if {condition} then max(share, {1 - SIGN_OR_FACTOR_COST}) else share;")
    credit_factor = part.credit.factor
    return lines if credit_factor == 1 else [*lines, f"share: share*{credit_factor};"]


def _write_floats(matrix: sp.Matrix, is_single: bool) -> str:
    """Return a number, or a column of numbers, as Maxima code (see `_write_float`)."""
    values = [_write_float(float(value)) for value in matrix]
    return values[0] if is_single else f"matrix({', '.join(f'[{value}]' for value in values)})"


def _write_float(value: float) -> str:
    """Return a number as Maxima code, with a power of ten if Maxima would otherwise print it with an exponent.

    >>> _write_float(0.25), _write_float(-0.00027), _write_float(0.0)
    ('0.25', '-2.7*10^(-4)', '0')
    """
    if value == 0 or 1e-3 <= abs(value) < 1e6:
        return f"{value:.12g}"
    mantissa, _, power = f"{value:.11e}".partition("e")
    return f"{mantissa.rstrip('0').rstrip('.')}*10^({int(power)})"


def _choose_test_value(variable: str, floats: str) -> str:
    """Return the answer that a question test submits: the variable or, if there are powers of ten, the numbers.

    STACK would write the value of such a variable as 2.7e-5, which its boxes for vectors do not accept.
    """
    return floats if "*10^" in floats else variable


def _are_near(numbers: sp.Matrix, other_numbers: sp.Matrix, tolerances: Sequence[sp.Expr]) -> bool:
    """Return whether two vectors differ by at most twice the tolerances, so that one answer could match both."""
    return all(abs(a - b) <= 2 * tolerance for a, b, tolerance in zip(numbers, other_numbers, tolerances, strict=True))


# --- options and sets ---


def _convert_choice(part: Part) -> StackPart:
    """Return a part that asks for the letter of an option."""
    answer = part.answer_as(reference_answers.Choice)
    flags = ("true" if i == answer.correct else "false" for i in range(len(answer.options)))
    options = [f'[{i}, {flag}, "{letter}"]' for i, (flag, letter) in enumerate(zip(flags, LETTERS, strict=False), 1)]
    correct = str(answer.correct + 1)
    nodes = [ResponseNode("AlgEquiv", "ans1", correct, CORRECT_NOTE, "1")]
    tests = [replace(REFERENCE_TEST, value=correct)]
    for i in range(len(answer.options)):
        if i == answer.correct:
            continue
        blames = list_blames(part, i)
        feedback = add_chapter_to_citation(" ".join(dict.fromkeys(blame.sentence for blame in blames)))
        note = "-".join(["prt1", LETTERS[i], *dict.fromkeys(blame.mistake for blame in blames)])
        nodes.append(ResponseNode("AlgEquiv", "ans1", str(i + 1), note, "0", feedback))
        tests.append(QuestionTest(f"option {LETTERS[i]}", str(i + 1), 0.0, note))
    return StackPart(
        part, "radio", "the letter of the right option", [f"ta1: [{', '.join(options)}];"], [], nodes, tests,
    )  # fmt: skip


def _convert_set(problem: Problem, part: Part, compute_share: ShareOfMistake) -> StackPart | Reason:
    """Return a part that asks for a set of equations, each with a joint variable on the left and a value on the right.

    If STACK can't ask it, return the reason.
    """
    answer = part.answer_as(reference_answers.ConditionSet)
    if not all(map(_has_numeric_values_of_one_joint, answer.components)):
        return Reason("a condition does not consist of values of a single joint, so STACK can't grade it fairly")

    def write_equations(components: tuple[Component, ...], full_turns: int = 0) -> str:
        equations = [
            f"{joint} = {print_maxima(value + 2 * sp.pi * (full_turns if is_joint_angle(joint) else 0))}"
            for joint, value in _iterate_joint_values(components)
        ]
        return "{" + ", ".join(dict.fromkeys(equations)) + "}"

    values_by_condition = [_list_joint_values((component,)) for component in answer.components]
    coverage = ", ".join(
        f"[qdot_count_found(typed_conditions, args({write_equations((component,))})), {len(joint_values)}]"
        for component, joint_values in zip(answer.components, values_by_condition, strict=True)
    )
    factor = part.credit.factor if part.credit.rule != "whole" else 0
    lines = [
        "typed_conditions: qdot_conditions(ans1);", "right: qdot_count_found(typed_conditions, args(ta1));",
        "false_count: qdot_false_conditions(typed_conditions, args(ta1));",
        f"share: qdot_set_share([{coverage}], false_count);", *([] if factor == 1 else [f"share: share*{factor};"]),
    ]  # fmt: skip
    value_count = len(list(_iterate_joint_values(answer.components)))
    nodes = [ResponseNode("AlgEquiv", "[right, false_count]", f"[{value_count}, 0]", CORRECT_NOTE, "1")]
    joint_lines = [
        f"joints: [{', '.join(q.name for q in problem.chain.q)}];",
        f"revolute: [{', '.join(q.name for q in problem.chain.q if is_joint_angle(q))}];",
    ]
    variables = stack_maxima.write_definitions(problem, stack_maxima.SET_FUNCTIONS, *joint_lines)
    variables.append(f"ta1: {write_equations(answer.components)};")
    feedback = (
        "<p>Right values that you found: {@right@}. Conditions that are wrong or not in the form that the question "
        "asks for: {@false_count@}.</p>"
    )
    tests = [REFERENCE_TEST]
    stack_part = StackPart(
        part, "algebraic", _explain_set_typing(problem), variables, lines, nodes, tests, feedback, "share",
        box_width=50, validator="qdot_check_set",
    )  # fmt: skip
    # Twice as many mistakes are tried, because some lead to conditions that STACK can't compare.
    for index, known_answer in enumerate(find_known_wrong_answers(problem, part, 2 * MAX_MISTAKES), 1):
        assert isinstance(known_answer.answer, tuple)
        if len(nodes) > MAX_MISTAKES or not all(map(_has_numeric_values_of_one_joint, known_answer.answer)):
            continue
        arguments = f"(typed_conditions, args(wrong{index}))"
        comparison = f"[qdot_count_found{arguments} - length(wrong{index}), qdot_false_conditions{arguments}]"
        equations = write_equations(known_answer.answer)
        stack_part.add_mistake(index, known_answer, equations, comparison, "[0, 0]", compute_share(known_answer))
    variables += [f"form1: {write_equations(answer.components, 1)};", f"other1: {{{problem.chain.q[0]} = 1/7}};"]
    variables.append(f"unknown1: {{{problem.chain.q[0]} = unknown_name}};")
    tests += [UNUSUAL_FORM_TEST, UNRELATED_TEST, UNKNOWN_NAME_TEST]
    return stack_part


def _explain_set_typing(problem: Problem) -> str:
    """Return instructions on how to type a set, with an example for each kind of joint of the arm."""
    angles = [q.name for q in problem.chain.q if is_joint_angle(q)]
    lengths = [q.name for q in problem.chain.q if not is_joint_angle(q)]
    units = "; type angles in radians, within one turn" * bool(angles) + "; type lengths in metres" * bool(lengths)
    examples = [f"{name} = pi/3" for name in angles[-1:]] + [f"{name} = 1/2" for name in lengths[-1:]]
    if len(examples) == 1:
        examples.insert(0, f"{angles[-1]} = 1/2" if angles else f"{lengths[-1]} = 1/3")
    return (
        f"a set of equations with all values, such as {{{', '.join(examples)}}}; put the joint variable on the "
        f"left{units}"
    )


def _has_numeric_values_of_one_joint(component: Component) -> bool:
    """Return whether a component consists of numeric values of a single joint."""
    is_single_joint = component.solutions is not None and len(component.solutions) == 1
    return is_single_joint and not any(value.free_symbols for _, value in _iterate_joint_values([component]))


def _iterate_joint_values(components: Iterable[Component]) -> Iterator[tuple[sp.Symbol, sp.Expr]]:
    """Yield each joint with each of its values in a singular set."""
    for component in components:
        for joint, values in component.solutions or ():
            yield from ((joint, value) for value in values)


def _list_joint_values(components: tuple[Component, ...]) -> set[tuple[str, float]]:
    """Return the pairs of a joint variable and a rounded value in a singular set, with angles wrapped to one turn."""
    full_turn, joint_values = 2 * float(sp.pi), set()
    for joint, value in _iterate_joint_values(components):
        wrapped_value = float(value) % full_turn if is_joint_angle(joint) else float(value)
        # an angle that is rounded up to a full turn becomes 0
        joint_values.add((joint.name, round(wrapped_value, 9) % round(full_turn, 9)))
    return joint_values


def remove_rounding_if_exact(part: Part) -> Part:
    """Return a part without allowed rounding if its answer is exact, because STACK compares exact answers exactly."""
    return replace(part, rounding=None) if part.answer.is_exact else part
