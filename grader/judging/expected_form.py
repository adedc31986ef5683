"""Parse a text as the answer to one part of a problem, according to the type of the part's correct answer."""

import re
from dataclasses import dataclass, replace

from qdot.exercises import reference_answers
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import ParseError
from qdot.exercises.formula.units import write_power_of_metres
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging import answer_parser
from qdot.grader.judging.choices import is_blank_text, read_choice, read_matching, read_selection
from qdot.grader.judging.functions import find_constant_value, is_function_table, read_table


@dataclass(frozen=True)
class ExpectedForm:
    """The form in which the answer to a part is expected, and the names that the answer may contain.

    `answer` is the correct answer or any other answer of the same form. `domain` contains the symbols. The entries of a
    vector may be named by `labels`, and the columns of a matrix by `columns`. The unit of a determinant is m to the
    power `metre_power`, which is None for other answers.
    """

    answer: reference_answers.Answer
    domain: Domain
    joints: tuple[str, ...]
    labels: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    metre_power: int | None = None


def find_expected_form(problem: Problem, part: Part) -> ExpectedForm:
    """Return the form in which the answer to a part is expected."""
    from qdot.exercises.questions.differentiation import find_determinant_power_of_metres  # not for `qdot check`
    from qdot.exercises.short_questions import question_of

    question, joints = question_of(part), tuple(q.name for q in problem.chain.q)
    labels, columns = question.list_names_to_type(problem.chain, part), question.name_columns(problem.chain)
    metre_power = find_determinant_power_of_metres(problem.chain, part)
    return ExpectedForm(part.answer, problem.domain, joints, labels, columns, metre_power)


def read_answer(problem: Problem, part: Part, text: str, functions_seed: str = "") -> answer_parser.ParsedAnswer:
    """Parse a text as the answer to a part. `functions_seed` determines at which values a Python function was called.

    >>> from qdot import generate
    >>> problem = generate("planar-2r/7", ["position"])
    >>> read_answer(problem, problem["position"], "[a1, a2, a3]").refusal
    Judgement(wrong, 0: your answer has 3 entries, but it must have 2; write it like [a, b])
    """
    return read_in_form(find_expected_form(problem, part), text, functions_seed)


def explain_unparsed_entry(problem: Problem, part: Part, text: str) -> str:
    """Return which entry of a matrix, made by a web page from its fields, can't be parsed, and why; "" for others.

    >>> from qdot import generate
    >>> problem = generate("planar-2r/7", ["position"])
    >>> explain_unparsed_entry(problem, problem["position"], "[[a1], [theta1*(]]").partition(" (at")[0]
    "qdot couldn't parse entry 2 of your answer: a number, a symbol or a bracket is missing at the end"
    """
    rows = [row.split(", ") for row in text.removeprefix("[[").removesuffix("]]").split("], [")]
    if part.shape is None or [len(row) for row in rows] != [part.shape[1]] * part.shape[0]:
        return ""
    for i, row in enumerate(rows, 1):
        for j, entry in enumerate(row, 1):
            try:
                parse_formula(entry, problem.domain.roles)
            except ParseError as error:
                name = f"({i}, {j})" if part.shape[1] > 1 else str(i)
                return f"qdot couldn't parse entry {name} of your answer: {error}"
    return ""


def read_in_form(expected: ExpectedForm, text: str, functions_seed: str = "") -> answer_parser.ParsedAnswer:
    """Parse a text in the expected form, as `read_answer` does."""
    if is_function_table(text):
        constant = find_constant_value(text)
        if constant is None:
            return answer_parser.ParsedAnswer(text, table=read_table(text, expected.domain, functions_seed))
        return replace(read_in_form(expected, constant), text=text)
    if expected.metre_power is not None and expected.metre_power != _CUBIC_POWER and _CUBIC_METRES.search(text):
        unit = write_power_of_metres(expected.metre_power)
        unit_words = f"is in {unit}" if unit else "has no unit"
        return answer_parser.refuse(text, f"the unit m^3 does not fit: the result {unit_words}; write only the formula")
    parsed = _AnswerReader(text, expected).visit(expected.answer)
    is_formula = isinstance(expected.answer, reference_answers.Expression | reference_answers.Matrix)
    text_with_points = answer_parser.replace_decimal_commas(text)  # pages in many languages print decimal commas
    if parsed.refusal is not None and is_formula and text_with_points != text:
        parsed_again = _AnswerReader(text_with_points, expected).visit(expected.answer)
        return parsed if parsed_again.refusal is not None else replace(parsed_again, text=text)
    return parsed


_CUBIC_METRES = re.compile(r"(?<![\w])(?:m|\\mathrm\{m\}|\\text\{m\})(?:\^\(?3\)?|\^\{3\}|³|\*\*3)[\])]?[ .$]{0,9}$")
"""Matches cubic metres at the end of an answer; the parser removes this unit without a check."""
_CUBIC_POWER = 3
"""The power of metres that `_CUBIC_METRES` matches."""


@dataclass(frozen=True)
class _AnswerReader(reference_answers.AnswerVisitor[answer_parser.ParsedAnswer]):
    """Parses a text in the form of the expected answer; each method is for one type of answer."""

    text: str
    expected: ExpectedForm

    def visit_expression(self, answer: reference_answers.Expression) -> answer_parser.ParsedAnswer:
        """Parse a formula."""
        return answer_parser.read_formula(self.text, self.expected.domain, self.expected.labels)

    def visit_matrix(self, answer: reference_answers.Matrix) -> answer_parser.ParsedAnswer:
        """Parse a matrix of formulas."""
        return answer_parser.read_matrix(
            self.text, answer.shape, self.expected.domain, self.expected.labels, self.expected.columns
        )

    def visit_direction(self, answer: reference_answers.Direction) -> answer_parser.ParsedAnswer:
        """Parse a vector that is a direction."""
        return answer_parser.read_matrix(self.text, answer.shape, self.expected.domain, self.expected.labels)

    def visit_number(self, answer: reference_answers.Number) -> answer_parser.ParsedAnswer:
        """Parse numbers."""
        return answer_parser.read_numbers(self.text, len(answer.reference), self.expected.labels, answer.units)

    def visit_singular(self, answer: reference_answers.ConditionSet) -> answer_parser.ParsedAnswer:
        """Parse conditions."""
        return answer_parser.read_conditions(self.text, self.expected.domain, self.expected.joints)

    def visit_choice(self, answer: reference_answers.Choice) -> answer_parser.ParsedAnswer:
        """Parse the letter or the text of one option."""
        return read_choice(self.text, answer.options)

    def visit_selection(self, answer: reference_answers.Selection) -> answer_parser.ParsedAnswer:
        """Parse the letters of several options."""
        return read_selection(self.text, len(answer.options))

    def visit_matching(self, answer: reference_answers.Matching) -> answer_parser.ParsedAnswer:
        """Parse a letter for each item."""
        return read_matching(self.text, answer.items, len(answer.options))

    def visit_text(self, answer: reference_answers.Words) -> answer_parser.ParsedAnswer:
        """Accept any text that is not blank."""
        is_blank = is_blank_text(self.text)
        return answer_parser.ParsedAnswer(self.text, answer_parser.BLANK_JUDGEMENT if is_blank else None)
