"""STACK questions in one Moodle XML file: a question for every variant, with all its parts, and its question tests.

A variant is a question of its own, in a category for each place of the assignment from which a quiz draws one at
random. A question that holds all variants and picks one by its seed could not have the mistakes of each arm as nodes of
its tree: other arms make other mistakes give the same answer.
"""

import base64
from collections.abc import Generator, Iterable
from dataclasses import dataclass, replace
from itertools import zip_longest

from exercises.errors import QdotError
from exercises.exports.bank import Variant, bank
from exercises.exports.outlet import File, Order
from exercises.exports.stack_parts import FUNCTIONS, Case, StackPart, asked, without_rounding
from exercises.figure import alt_text, figure_svg, part_alt, part_svg
from exercises.formula.printers.maxima import maxima_text
from exercises.notebook import solution_figure
from exercises.problem import Part, Problem
from exercises.questions.results import is_product
from exercises.quizzes import ASKED
from exercises.render import render
from exercises.writing.markup import to_html_for_mathjax
from exercises.writing.statement import hints, prompt, statement, worked_solution

VERSION = "2023060500"
"""The version of STACK whose features the questions use."""
PENALTY = 0.1
MOST_JOINTS = 6
"""Joints up to which sums of neighbouring angles have a short name, as c123."""


@dataclass(frozen=True)
class Picture:
    """A drawing that a text shows: name of the file, SVG in base64, and what it shows in words."""

    name: str
    data: str
    alt: str


@dataclass(frozen=True)
class Shown:
    """A part as the template writes it: STACK's terms, and texts as HTML."""

    asked: StackPart
    title: str
    prompt: str
    hints: tuple[str, ...]
    solution: str
    picture: Picture | None
    solution_picture: Picture | None


@dataclass(frozen=True)
class Test:
    """A question test: for each part its value ("" where it is left blank), and what is expected."""

    title: str
    given: tuple[tuple[StackPart, Case], ...]


@dataclass(frozen=True)
class StackQuestion:
    """A variant as the template writes it."""

    name: str
    id: str
    category: str
    grade: float
    statement: str
    picture: Picture
    variables: tuple[str, ...]
    note: str
    parts: tuple[Shown, ...]
    tests: tuple[Test, ...]


def stack_questions(order: Order) -> Generator[File, None, None]:
    """Yield the file; what STACK can't ask or judges otherwise is told once for each place."""
    notes: dict[str, None] = {}
    made = [_question(order, variant, notes) for variant in bank(order)]
    for said in notes:
        order.note(said)
    questions = [question for question in made if question is not None]
    if not questions:
        raise QdotError("STACK can ask nothing of this assignment; `qdot export --help` lists other outlets")
    text = render("exports/stack.xml.j2", questions=questions, version=VERSION, penalty=PENALTY)
    yield File(f"{order.assignment.key}-stack.xml", text, private=True)


def _question(order: Order, variant: Variant, notes: dict[str, None]) -> StackQuestion | None:
    problem, slot = variant.problem, variant.slot.name
    parts: list[StackPart] = []
    for part in problem.parts:
        one = asked(problem, without_rounding(part), len(parts) + 1)
        if isinstance(one, str):
            notes[f"{slot}: STACK does not ask {part.name!r}: {one}"] = None
            continue
        if part.rounding is not None and without_rounding(part) is not part:
            notes[f"{slot}: STACK takes no rounded decimals in {part.name!r}; qdot would, {part.rounding.words}"] = None
        if is_product(part):
            notes[f"{slot}: in STACK {part.name!r} is right or wrong; factors that are right earn nothing"] = None
        parts.append(one)
    if not parts:
        return None
    title = order.assignment.title.replace("/", "//")
    return StackQuestion(
        f"{order.assignment.title}: {variant.key}",
        f"{order.assignment.key}-{variant.key}",
        f"$course$/top/{title}/{slot}",
        sum(one.part.points for one in parts),
        _html(statement(problem, "")),
        _picture("arm", figure_svg(problem.chain), alt_text(problem.chain)),
        _variables(problem, parts),
        _note(variant),
        tuple(_shown(problem, one, order.assignment.hints) for one in parts),
        tuple(_tests(parts)),
    )


def _html(text: str) -> str:
    """Return HTML in which nothing is taken for a block or a variable of CASText."""
    return to_html_for_mathjax(text).replace("[[", "&#91;&#91;").replace("]]", "&#93;&#93;").replace("{@", "{&#64;")


def _picture(name: str, svg: str, alt: str) -> Picture:
    return Picture(f"{name}.svg", base64.b64encode(svg.encode()).decode(), alt)


def _shown(problem: Problem, one: StackPart, hinted: bool) -> Shown:
    part = one.part
    name = part.name
    own, solved = part_svg(problem.chain, part, name), solution_figure(problem, part, f"{name}-solution")
    return Shown(
        one,
        ASKED[part.kind].title,
        _html(_prompt(problem, part)),
        tuple(_html(hint) for hint in hints(problem, part)) if hinted else (),
        _html(worked_solution(problem, part)),
        _picture(name, own, part_alt(problem.chain, part)) if own else None,
        _picture(f"{name}-solution", solved, "The arm in a regular and in its singular configurations")
        if solved
        else None,
    )


def _prompt(problem: Problem, part: Part) -> str:
    """Return what is asked, without how it would be typed in Python where that is another thing in STACK."""
    text = prompt(problem, part)
    return text.split("**Answer:**")[0] if (part.answer.offered or part.answer.is_a_set) else text


def _variables(problem: Problem, parts: Iterable[StackPart]) -> tuple[str, ...]:
    """Return the question variables: given lengths, short names of sines and cosines, and the answers."""
    given = ", ".join(
        f"{name} = {maxima_text(info.value)}" for name, info in problem.symbols().items() if info.value is not None
    )
    angles = {i: q.name for i, q in enumerate(problem.chain.q, 1) if q.name.startswith("theta")}
    known, short = problem.symbols(), []
    for first in angles:
        for last in range(first, min(first + MOST_JOINTS, 10)):
            run = range(first, last + 1)
            if not all(i in angles for i in run):
                break
            total, digits = " + ".join(angles[i] for i in run), "".join(map(str, run))
            short += [
                f"{letter}{digits} = {trig}({total})"
                for letter, trig in (("c", "cos"), ("s", "sin"))
                if f"{letter}{digits}" not in known
            ]
    own = (line for one in parts for line in one.variables)
    return (f"given: [{given}];", f"short: [{', '.join(short)}];", *FUNCTIONS, *own)


def _note(variant: Variant) -> str:
    """Return what tells a variant from others, in one line."""
    given = ", ".join(
        f"{name} = {info.value}" for name, info in variant.problem.symbols().items() if info.value is not None
    )
    return f"{variant.key}: {variant.problem.chain.title or 'arm'}{'; ' if given else ''}{given}"


def _tests(parts: list[StackPart]) -> Iterable[Test]:
    """Yield tests with a case of every part each, then what can't be read, and an answer to the first part alone."""
    for row in zip_longest(*(one.cases for one in parts)):
        given = tuple((one, case or one.cases[0]) for one, case in zip(parts, row, strict=True))
        titles = dict.fromkeys(case.title for case in row if case is not None)
        yield Test("; ".join(titles), given)
    typed = next((one for one in parts if one.kind in ("algebraic", "numerical")), None)
    blank = Case("blank", "", None, "NULL")
    if len(parts) > 1:
        yield Test(
            "the first part alone: the others are blank, and not marked",
            tuple((one, one.cases[0] if one is parts[0] else blank) for one in parts),
        )
    if typed is not None:
        bad = replace(blank, value="qdot_unknown(1)")
        yield Test(
            "what can't be read is not marked", tuple((one, bad if one is typed else one.cases[0]) for one in parts)
        )
