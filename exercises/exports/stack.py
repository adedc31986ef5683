"""Export STACK questions in one Moodle XML file: a question for every part of every variant, with question tests.

Each part is a separate question, because STACK limits the time for one question. The variants of a part are separate
questions in one category, from which a quiz picks a variant at random. STACK could also pick a variant by a seed, but
then all variants would share a response tree. Such a tree could not recognise mistakes, because for different arms,
different mistakes lead to the same answer.
"""

import base64
from collections.abc import Generator
from dataclasses import dataclass, replace

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.certified_problems import Variant, describe_internal_error
from qdot.exercises.common.errors import QdotError, Reason
from qdot.exercises.exports.bank import convert_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.moodle import MAX_ID_LENGTH, make_category_path, make_moodle_name
from qdot.exercises.exports.platform_markup import Picture, draw_arm, draw_prompt_figure, draw_solution_figure
from qdot.exercises.exports.stack_parts import QuestionTest, StackPart, convert_part, remove_rounding_if_exact
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_product
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing.markup import to_html_for_mathjax
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution, write_statement
from qdot.exercises.writing.render import render

STACK_VERSION = "2023060500"
"""The version of STACK that the questions need."""
PENALTY = 0.1
"""The share of the points that each wrong attempt costs."""
UNPARSED_ANSWER = QuestionTest("answers that STACK can't parse are not graded", "qdot_unknown(1)", None, "NULL")


@dataclass(frozen=True)
class StackQuestion:
    """A STACK question: one part of a variant, in the form that the template needs, with texts as HTML.

    `question_note` is STACK's term for a line that identifies the variant.
    """

    stack_part: StackPart
    name: str
    id: str
    category: str
    question_note: str
    title: str
    statement: str
    prompt: str
    solution: str
    hints: tuple[str, ...]
    arm_figure: Picture
    prompt_figure: Picture | None
    solution_figure: Picture | None
    tests: tuple[QuestionTest, ...]


def export_stack(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the file. For each slot, report once which parts STACK can't ask or grades differently from qdot."""
    messages: dict[str, None] = {}
    questions: dict[str, list[StackQuestion]] = {}
    for variant, (variant_questions, new_messages) in convert_bank(request, _make_questions):
        messages |= new_messages
        for question in variant_questions:
            questions.setdefault(question.category, []).append(_add_variant_key(request, variant, question))
    for message in messages:
        request.report(message)
    if not questions:
        raise QdotError(
            "STACK supports none of the questions of this assignment; `qdot export --help` lists other export formats"
        )
    text = render(
        "exports/stack.xml.j2", categories=questions, version=STACK_VERSION, penalty=PENALTY,
        encode=lambda svg: base64.b64encode(svg.encode()).decode(),
    )  # fmt: skip
    yield ExportedFile(f"{request.assignment.key}-stack.xml", text, is_private=True)


def _make_questions(
    request: ExportRequest, slot: Slot, problem: Problem
) -> tuple[list[StackQuestion], dict[str, None]]:
    """Return the questions of a problem that STACK can ask, and messages to the staff as keys of a dict.

    The questions do not contain the variant's key yet.
    """
    questions: list[StackQuestion] = []
    messages: list[str] = []
    prefix = f"{slot.name}: STACK"
    for part in problem.parts:
        question = _convert_part(request, slot, problem, part)
        if isinstance(question, Reason):
            messages.append(f"{prefix} leaves out {part.name!r}: {question}")
            continue
        questions.append(question)
        if part.rounding is not None and part.answer.is_exact:
            name, rounding = repr(part.name), part.rounding.words
            messages.append(f"{prefix} does not accept rounded decimals in {name}; qdot does, {rounding}")
        if is_product(part):
            messages.append(f"{prefix} marks {part.name!r} right or wrong; right factors earn no partial credit")
    return questions, dict.fromkeys(messages)


def _convert_part(request: ExportRequest, slot: Slot, problem: Problem, part: Part) -> StackQuestion | Reason:
    """Return the question of a part, or the reason why there is none, so that the other questions are exported."""
    try:
        stack_part = convert_part(problem, remove_rounding_if_exact(part))
        return stack_part if isinstance(stack_part, Reason) else _make_question(request, slot, problem, stack_part)
    except QdotError as error:
        return Reason(error)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return Reason(describe_internal_error(error))


def _make_question(request: ExportRequest, slot: Slot, problem: Problem, stack_part: StackPart) -> StackQuestion:
    assignment, part = request.assignment, stack_part.part
    number = [problem_part.name for problem_part in problem.parts].index(part.name) + 1
    title = question_of(part).title
    category_names = assignment.title, slot.name, f"{number}. {title}"
    return StackQuestion(
        stack_part, part.name, part.name, make_category_path(list(map(make_moodle_name, category_names))),
        _describe_arm(problem), title, _write_html(write_statement(problem, "")),
        _write_html(_write_prompt(problem, part)), _write_html(write_solution(problem, part)),
        tuple(map(_write_html, write_hints(problem, part) if assignment.hints else ())), draw_arm(problem),
        draw_prompt_figure(problem, part, part.name),
        draw_solution_figure(problem, part, f"{part.name}-solution"),
        (*stack_part.question_tests, *([UNPARSED_ANSWER] if stack_part.has_single_box else [])),
    )  # fmt: skip


def _add_variant_key(request: ExportRequest, variant: Variant, question: StackQuestion) -> StackQuestion:
    """Return a question with the variant's key in its name, id and note."""
    return replace(
        question,
        name=make_moodle_name(f"{variant.key}, {question.name}: {request.assignment.title}"),
        id=f"{request.assignment.key}-{variant.key}-{question.id}"[-MAX_ID_LENGTH:],
        question_note=f"{variant.key}: {question.question_note}",
    )


def _write_html(text: str) -> str:
    """Return HTML with escaped brackets, so that STACK doesn't find blocks or variables of CASText in it."""
    return to_html_for_mathjax(text).replace("[[", "&#91;&#91;").replace("]]", "&#93;&#93;").replace("{@", "{&#64;")


def _write_prompt(problem: Problem, part: Part) -> str:
    """Return the prompt, without instructions on how to type the answer if they do not apply to STACK."""
    text = write_prompt(problem, part)
    return text.split("**Answer:**")[0] if (part.answer.offered_options or part.answer.is_set) else text


def _describe_arm(problem: Problem) -> str:
    """Return a line that identifies the arm: its title and given values."""
    values = ", ".join(f"{name} = {info.value}" for name, info in problem.symbols.items() if info.value is not None)
    return f"{problem.chain.title or 'arm'}{'; ' if values else ''}{values}"
