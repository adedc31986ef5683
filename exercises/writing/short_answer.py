"""Write the answer to a part without its derivation, in Markdown with LaTeX, as in an answer key."""

import re
from dataclasses import dataclass
from typing import Any

from qdot.exercises.short_questions.options import Options

from qdot.exercises.answer_types import (
    TRUE_FALSE,
    AnswerVisitor,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Letters,
    Matrix,
    Number,
)
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.problem_texts import add_angle_legend, option_text, solution_steps
from qdot.exercises.writing.render import render
from qdot.exercises.writing.solution_steps import three_digits

_TEXT_FIELDS = ("letters", "words", "remark")


def short_answer(problem: Problem, part: Part) -> str:
    """Return the reference answer: a displayed formula, numbers with their units, conditions, or letters."""
    fields: dict[str, Any] = {"components": None, "formula": None, "values": []} | dict.fromkeys(_TEXT_FIELDS, "")
    answer_fields: dict[str, Any] = part.answer.accept(_AnswerFields(problem, part))
    fields |= answer_fields
    steps = solution_steps(problem.chain)
    return add_angle_legend(
        steps, render("writing/short-answer.md.j2", chain=problem.chain, angles=steps.angles, **fields)
    )


@dataclass(frozen=True)
class _AnswerFields(AnswerVisitor[dict[str, Any]]):
    """The fields that the template shows for each form of answer."""

    problem: Problem
    part: Part

    def formula(self, answer: Expression) -> dict[str, Any]:
        return {"formula": answer.reference}

    def matrix(self, answer: Matrix) -> dict[str, Any]:
        return {"formula": answer.reference}

    def direction(self, answer: Direction) -> dict[str, Any]:
        remark = {"remark": "Any multiple other than zero is as good."}
        if answer.is_numeric:
            return {"values": [three_digits(value) for value in answer.reference], **remark}
        return {"formula": answer.reference, **remark}

    def numbers(self, answer: Number) -> dict[str, Any]:
        units = map(_unit_latex, answer.units)
        digits = (_number_text(value, answer.tolerance) for value in answer.reference)
        return {"values": [shown + unit for shown, unit in zip(digits, units, strict=True)]}

    def conditions(self, answer: ConditionSet) -> dict[str, Any]:
        return {"components": answer.components}

    def choice(self, answer: Choice) -> dict[str, Any]:
        needs_no_words = (
            answer.options == TRUE_FALSE or self.part.has_drawn_options or _is_tall(self.part, answer.correct)
        )
        return {
            "letters": answer.typed_text,
            "words": "" if needs_no_words else option_text(self.problem, self.part, answer.correct),
        }

    def letters(self, answer: Letters) -> dict[str, Any]:
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


def _is_tall(part: Part, index: int) -> bool:
    return isinstance(part.details, Options) and part.details.offered[index].is_tall
