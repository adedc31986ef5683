"""The answer to a part without the way to it, in Markdown with LaTeX, as a key shows it."""

import re
from typing import Any

from exercises.answers import (
    TRUE_FALSE,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Matching,
    Matrix,
    Number,
    Selection,
)
from exercises.problem import Part, Problem
from exercises.render import render
from exercises.writing.statement import option_text, with_meanings, worked_steps
from exercises.writing.worked import three_digits

_WORDS = ("letters", "words", "remark")


def short_answer(problem: Problem, part: Part) -> str:
    """Return the reference: a formula on lines of its own, numbers with their units, conditions, or letters."""
    answer = part.answer
    given: dict[str, Any] = {"components": None, "formula": None, "values": []} | dict.fromkeys(_WORDS, "")
    if isinstance(answer, ConditionSet):
        given["components"] = answer.components
    elif isinstance(answer, Choice):
        plain = answer.options == TRUE_FALSE
        given["letters"] = answer.options[answer.correct] if plain else answer.letter
        tall = part.has_drawn_options or _is_tall(part, answer.correct)
        given["words"] = "" if plain or tall else option_text(problem, part, answer.correct)
    elif isinstance(answer, (Selection, Matching)):
        given["letters"] = answer.letters
    elif isinstance(answer, Number):
        units = [_unit(unit) for unit in answer.units]
        given["values"] = [_digits(v, answer.tolerance) + u for v, u in zip(answer.reference, units, strict=True)]
    elif isinstance(answer, Direction) and answer.tolerance is not None:
        given["values"] = [three_digits(value) for value in answer.reference]
    else:
        assert isinstance(answer, (Expression, Matrix, Direction))
        given["formula"] = answer.reference
    if isinstance(answer, Direction):
        given["remark"] = "Any multiple other than zero is as good."
    steps = worked_steps(problem.chain)
    return with_meanings(steps, render("short-answer.md.j2", chain=problem.chain, angles=steps.angles, **given))


def _digits(value: object, tolerance: float) -> str:
    """Return a number as it is compared: a whole one that must be met exactly, any other to three digits."""
    return str(value) if tolerance < 1e-6 else three_digits(value)


def _unit(unit: str) -> str:
    r"""Return a unit behind its number.

    >>> _unit("m^2/s")
    '\\,\\text{m}^{2}\\text{/s}'
    """
    pieces = re.split(r"\^(\d)", unit)
    shown = "".join(rf"^{{{piece}}}" if k % 2 else rf"\text{{{piece}}}" for k, piece in enumerate(pieces) if piece)
    return rf"\,{shown}" if unit else ""


def _is_tall(part: Part, index: int) -> bool:
    offered = part.details.get("offered")
    return bool(offered and offered[index].is_tall)  # type: ignore[index]
