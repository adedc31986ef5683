"""Write the reference answer to a part without its derivation, for answer keys; the text is Markdown with LaTeX."""

from dataclasses import dataclass
from typing import Any

import sympy as sp

from qdot.exercises import reference_answers
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import TRUE_FALSE, AnswerVisitor, Choice, Direction, Expression, Matrix, Number
from qdot.exercises.short_questions.options import Options
from qdot.exercises.writing.problem_texts import add_angle_legend, get_solution_steps, write_option, write_solution
from qdot.exercises.writing.render import render
from qdot.exercises.writing.solution_steps import format_number
from qdot.exercises.writing.units import tex_unit

_TEXT_FIELDS = ("letters", "words", "remark")


def write_short_answer(problem: Problem, part: Part) -> str:
    """Return the reference answer: a displayed formula, numbers with units, conditions, or letters."""
    fields: dict[str, Any] = {"components": None, "formula": None, "values": []} | dict.fromkeys(_TEXT_FIELDS, "")
    answer_fields: dict[str, Any] = _AnswerFields(problem, part).visit(part.answer)
    fields |= answer_fields
    steps = get_solution_steps(problem.chain)
    text = render("writing/short-answer.md.j2", chain=problem.chain, angles=steps.angles, **fields)
    return add_angle_legend(steps, text)


@dataclass(frozen=True)
class _AnswerFields(AnswerVisitor[dict[str, Any]]):
    """For each type of answer, the fields that the template shows."""

    problem: Problem
    part: Part

    def visit_expression(self, answer: Expression | Matrix) -> dict[str, Any]:
        return {"formula": answer.reference}

    visit_matrix = visit_expression

    def visit_direction(self, answer: Direction) -> dict[str, Any]:
        remark = {"remark": "Any nonzero multiple is also correct."}
        if answer.is_numeric:
            return {"values": [self._format_number(value) for value in answer.reference], **remark}
        return {"formula": answer.reference, **remark}

    def visit_number(self, answer: Number) -> dict[str, Any]:
        values = zip(answer.reference, answer.units, strict=True)
        format_value = str if answer.is_count else self._format_number
        return {"values": [format_value(value) + tex_unit(unit) for value, unit in values]}

    def visit_singular(self, answer: reference_answers.ConditionSet) -> dict[str, Any]:
        return {"components": answer.components}

    def visit_choice(self, answer: Choice) -> dict[str, Any]:
        details = self.part.details
        is_tall = isinstance(details, Options) and details.offered_options[answer.correct].is_tall
        has_words = answer.options != TRUE_FALSE and not details.has_drawn_options and not is_tall
        words = write_option(self.problem, self.part, answer.correct) if has_words else ""
        return {"letters": answer.typed_text, "words": words}

    def visit_text(self, answer: reference_answers.Words) -> dict[str, Any]:
        return {"remark": write_solution(self.problem, self.part).strip() or "A person marks this answer."}

    def visit_letters(self, answer: reference_answers.Letters) -> dict[str, Any]:
        return {"letters": answer.letters}

    def _format_number(self, value: sp.Expr) -> str:
        return format_number(value, self.part.count_digits(float(value)))
