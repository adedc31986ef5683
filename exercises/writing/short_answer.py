"""Write the answer to a part without its derivation, in Markdown with LaTeX, as in an answer key."""

import re
from dataclasses import dataclass
from typing import Any

from qdot.exercises import answer_types
from qdot.exercises.answer_types import TRUE_FALSE, AnswerVisitor, Choice, Direction, Expression, Matrix, Number
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions.options import Options
from qdot.exercises.writing.problem_texts import add_angle_legend, option_text, solution_steps
from qdot.exercises.writing.render import render
from qdot.exercises.writing.solution_steps import three_digits

_TEXT_FIELDS = ("letters", "words", "remark")


def short_answer(problem: Problem, part: Part) -> str:
    """Return the reference answer: a displayed formula, numbers with their units, conditions, or letters."""
    fields: dict[str, Any] = {"components": None, "formula": None, "values": []} | dict.fromkeys(_TEXT_FIELDS, "")
    answer_fields: dict[str, Any] = _AnswerFields(problem, part).visit(part.answer)
    fields |= answer_fields
    steps = solution_steps(problem.chain)
    text = render("writing/short-answer.md.j2", chain=problem.chain, angles=steps.angles, **fields)
    return add_angle_legend(steps, text)


@dataclass(frozen=True)
class _AnswerFields(AnswerVisitor[dict[str, Any]]):
    """The fields that the template shows for each form of answer."""

    problem: Problem
    part: Part

    def visit_expression(self, answer: Expression | Matrix) -> dict[str, Any]:
        return {"formula": answer.reference}

    visit_matrix = visit_expression

    def visit_direction(self, answer: Direction) -> dict[str, Any]:
        remark = {"remark": "Any multiple other than zero is as good."}
        if answer.is_numeric:
            return {"values": [three_digits(value) for value in answer.reference], **remark}
        return {"formula": answer.reference, **remark}

    def visit_number(self, answer: Number) -> dict[str, Any]:
        values = zip(answer.reference, answer.units, strict=True)
        return {"values": [_number_text(value, answer.tolerance) + _unit_latex(unit) for value, unit in values]}

    def visit_singular(self, answer: answer_types.ConditionSet) -> dict[str, Any]:
        return {"components": answer.components}

    def visit_choice(self, answer: Choice) -> dict[str, Any]:
        has_words = answer.options != TRUE_FALSE and not self.part.details.has_drawn_options
        details = self.part.details
        has_words = has_words and not (isinstance(details, Options) and details.offered[answer.correct].is_tall)
        words = option_text(self.problem, self.part, answer.correct) if has_words else ""
        return {"letters": answer.typed_text, "words": words}

    def visit_letters(self, answer: answer_types.Letters) -> dict[str, Any]:
        return {"letters": answer.letters}


def _number_text(value: object, tolerance: float) -> str:
    """Return a number as precisely as it is compared: in full if it must match exactly, else to three digits."""
    return str(value) if tolerance < 1e-6 else three_digits(value)


def plain_unit(unit: str) -> str:
    """Return a unit as plain text.

    >>> plain_unit("m^2/s")
    'm²/s'
    """
    return unit.replace("^2", "²").replace("^3", "³")


def _unit_latex(unit: str) -> str:
    r"""Return the LaTeX of a unit after its number.

    >>> _unit_latex("m^2/s")
    '\\,\\text{m}^{2}\\text{/s}'
    """
    pieces = re.split(r"\^(\d)", unit)
    latex = "".join(rf"^{{{piece}}}" if k % 2 else rf"\text{{{piece}}}" for k, piece in enumerate(pieces) if piece)
    return rf"\,{latex}" if unit else ""
