"""Export of STACK questions in one Moodle XML file: a question for every part of every variant, and its question tests.

Each part is a separate question, because STACK limits the time for one question. The variants of a part are separate
questions in one category, from which a quiz picks one at random. STACK could also pick a variant by a seed, but then
all variants would share a response tree. Its nodes could not recognise mistakes, because the same answer results from
different mistakes for different arms.
"""

import base64
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import Variant
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.bank import process_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.markup import Picture, draw_arm, draw_prompt_figure, draw_solution_figure
from qdot.exercises.exports.moodle import MAX_ID_LENGTH, make_category_path, make_moodle_name
from qdot.exercises.exports.stack_parts import QuestionTest, StackPart, convert_part, remove_rounding
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_product
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.writing.markup import to_html_for_mathjax
from qdot.exercises.writing.problem_texts import hints, prompt, statement, worked_solution
from qdot.exercises.writing.render import render

STACK_VERSION = "2023060500"
"""The version of STACK that the questions need."""
PENALTY = 0.1
UNPARSED_ANSWER = QuestionTest("answers that STACK can't parse are not graded", "qdot_unknown(1)", None, "NULL")


@dataclass(frozen=True)
class StackQuestion:
    """A part of a variant as the template needs it: in STACK's terms, with texts as HTML."""

    stack_part: StackPart
    name: str
    id: str
    category: str
    note: str
    title: str
    statement: str
    prompt: str
    solution: str
    hints: tuple[str, ...]
    arm_figure: Picture
    prompt_figure: Picture | None
    solution_figure: Picture | None
    tests: tuple[QuestionTest, ...]


def export_stack(order: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the file; report once per slot what STACK can't ask or grades differently."""
    notes: dict[str, None] = {}
    questions: dict[str, list[StackQuestion]] = {}
    for variant, (variant_questions, new_notes) in process_bank(order, _make_questions):
        notes |= new_notes
        for question in variant_questions:
            questions.setdefault(question.category, []).append(_add_variant_name(order, variant, question))
    for note in notes:
        order.report(note)
    if not questions:
        raise QdotError(
            "STACK supports none of the questions of this assignment; `qdot export --help` lists other export formats"
        )
    text = render(
        "exports/stack.xml.j2", categories=questions, version=STACK_VERSION, penalty=PENALTY,
        encode=lambda svg: base64.b64encode(svg.encode()).decode(),
    )  # fmt: skip
    yield ExportedFile(f"{order.assignment.key}-stack.xml", text, is_private=True)


def _make_questions(order: ExportRequest, slot: Slot, problem: Problem) -> tuple[list[StackQuestion], dict[str, None]]:
    """Return the questions that STACK can ask of a problem, without the variant's name, and notes on the slot."""
    notes: dict[str, None] = {}
    return [_make_question(order, slot, problem, part) for part in _make_stack_parts(slot, problem, notes)], notes


def _make_stack_parts(slot: Slot, problem: Problem, notes: dict[str, None]) -> Iterator[StackPart]:
    for part in problem.parts:
        stack_part, note = convert_part(problem, remove_rounding(part)), f"{slot.name}: STACK"
        if isinstance(stack_part, str):
            notes[f"{note} leaves out {part.name!r}: {stack_part}"] = None
            continue
        if part.rounding is not None and remove_rounding(part) is not part:
            notes[f"{note} does not accept rounded decimals in {part.name!r}; qdot does, {part.rounding.words}"] = None
        if is_product(part):
            notes[f"{note} marks {part.name!r} right or wrong; right factors earn no partial credit"] = None
        yield stack_part


def _make_question(order: ExportRequest, slot: Slot, problem: Problem, stack_part: StackPart) -> StackQuestion:
    assignment, part = order.assignment, stack_part.part
    number = [problem_part.name for problem_part in problem.parts].index(part.name) + 1
    title = ALL_QUESTIONS[part.kind].title
    category_names = assignment.title, slot.name, f"{number}. {title}"
    category = make_category_path(list(map(make_moodle_name, category_names)))
    html_statement, html_prompt = _write_html(statement(problem, "")), _write_html(_write_prompt(problem, part))
    part_hints = hints(problem, part) if assignment.hints else ()
    prompt_figure = draw_prompt_figure(problem, part, part.name)
    solution_figure = draw_solution_figure(problem, part, f"{part.name}-solution")
    tests = (*stack_part.question_tests, *([UNPARSED_ANSWER] if stack_part.has_single_box else []))
    return StackQuestion(
        stack_part, part.name, part.name, category, _describe_arm(problem), title, html_statement, html_prompt,
        _write_html(worked_solution(problem, part)), tuple(map(_write_html, part_hints)), draw_arm(problem),
        prompt_figure, solution_figure, tests,
    )  # fmt: skip


def _add_variant_name(order: ExportRequest, variant: Variant, question: StackQuestion) -> StackQuestion:
    """Return a question with the variant's key in its name, id and note."""
    return replace(
        question,
        name=make_moodle_name(f"{variant.key}, {question.name}: {order.assignment.title}"),
        id=f"{order.assignment.key}-{variant.key}-{question.id}"[-MAX_ID_LENGTH:],
        note=f"{variant.key}: {question.note}",
    )


def _write_html(text: str) -> str:
    """Return HTML with escaped brackets, so that STACK doesn't find blocks or variables of CASText in it."""
    return to_html_for_mathjax(text).replace("[[", "&#91;&#91;").replace("]]", "&#93;&#93;").replace("{@", "{&#64;")


def _write_prompt(problem: Problem, part: Part) -> str:
    """Return the prompt, without instructions on typing the answer in Python if STACK's input differs."""
    text = prompt(problem, part)
    return text.split("**Answer:**")[0] if (part.answer.offered_options or part.answer.is_set) else text


def _describe_arm(problem: Problem) -> str:
    """Return a line that identifies the arm: its title and given values."""
    values = ", ".join(f"{name} = {info.value}" for name, info in problem.symbols.items() if info.value is not None)
    return f"{problem.chain.title or 'arm'}{'; ' if values else ''}{values}"
