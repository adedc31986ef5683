"""Export STACK questions as a question bank and as a quiz: a question for every part of every variant, with tests.

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
from qdot.exercises.exports.items import ItemCategory, group_by_category, make_category
from qdot.exercises.exports.moodle import MAX_ID_LENGTH, make_category_names, make_category_path, make_moodle_name
from qdot.exercises.exports.moodle_quiz import Category, MoodleQuestion, make_quiz_backup
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
    """A STACK question: one part of a variant, in the form that the templates need, with texts as HTML.

    `question_note` is STACK's term for a line that identifies the variant. `files` and `solution_files` are pairs of a
    name and the content in base 64.
    """

    stack_part: StackPart
    name: str
    id: str
    category: ItemCategory
    question_note: str
    body: str
    files: tuple[tuple[str, str], ...]
    solution: str
    solution_files: tuple[tuple[str, str], ...]
    tests: tuple[QuestionTest, ...]

    @property
    def content(self) -> tuple[str, str]:
        """The text that students see, and the answer; they are equal for variants with the same arm."""
        return self.body, repr(self.stack_part.part.answer)


def export_stack(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield two files for Moodle: a question bank to import, and the backup of a quiz to restore.

    For each slot, report once which parts STACK can't ask or grades differently from qdot.
    """
    messages: dict[str, None] = {}  # in order and without copies
    questions: list[StackQuestion] = []
    for variant, (variant_questions, new_messages) in convert_bank(request, _make_questions):
        messages |= dict.fromkeys(new_messages)
        questions += [_add_variant_key(request, variant, question) for question in variant_questions]
    for message in messages:
        request.report(message)
    if not questions:
        raise QdotError(
            "STACK supports none of the questions of this assignment; `qdot export --help` lists other export formats"
        )
    groups = group_by_category(
        questions, lambda question: question.category, lambda question: question.content, request.report
    )
    category_records = [
        {"path": make_category_path(make_category_names(category)), "questions": group}
        for category, group in groups.items()
    ]
    key = f"{request.assignment.key}-stack"
    text = render("exports/stack.xml.j2", categories=category_records, version=STACK_VERSION, penalty=PENALTY)
    yield ExportedFile(f"{key}.xml", text, is_private=True)
    categories = [
        Category(make_category_names(category), tuple(map(_make_moodle_question, group)))
        for category, group in groups.items()
    ]
    yield ExportedFile(f"{key}.mbz", make_quiz_backup(request, key, categories), is_private=True)


def _make_moodle_question(question: StackQuestion) -> MoodleQuestion:
    """Return a question in the form that a Moodle quiz needs."""

    def write_plugin(question_id: int) -> str:
        return render(
            "exports/moodle-quiz/stack.xml.j2", question=question, id=question_id, version=STACK_VERSION,
            penalty=PENALTY,
        )  # fmt: skip

    return MoodleQuestion(
        question.name, "stack", question.stack_part.part.points, question.body, question.body, question.files,
        question.solution, question.solution_files, question.id,
        ("qdot", question.category.slot_title, question.category.question_title), penalty=PENALTY,
        write_plugin=write_plugin,
    )  # fmt: skip


def _make_questions(request: ExportRequest, slot: Slot, problem: Problem) -> tuple[list[StackQuestion], list[str]]:
    """Return the questions of a problem that STACK can ask, and messages to the staff.

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
    return questions, messages


def _convert_part(request: ExportRequest, slot: Slot, problem: Problem, part: Part) -> StackQuestion | Reason:
    """Return the question of a part, or the reason why there is none, so that the other questions are exported."""
    try:
        stack_part = convert_part(problem, remove_rounding_if_exact(part), request.compute_earned_share)
        return stack_part if isinstance(stack_part, Reason) else _make_question(request, slot, problem, stack_part)
    except QdotError as error:
        return Reason(error)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return Reason(describe_internal_error(error))


def _make_question(request: ExportRequest, slot: Slot, problem: Problem, stack_part: StackPart) -> StackQuestion:
    part = stack_part.part
    prompt_figure = draw_prompt_figure(problem, part, part.name)
    solution_figure = draw_solution_figure(problem, part, f"{part.name}-solution")
    arm_figure = draw_arm(problem)
    hints = write_hints(problem, part) if request.assignment.hints else ()
    body = render(
        "exports/stack-text.html.j2", stack_part=stack_part, title=question_of(part).title,
        statement=_write_html(write_statement(problem, "")), prompt=_write_html(_write_prompt(problem, part)),
        hints=list(map(_write_html, hints)), arm_figure=arm_figure, prompt_figure=prompt_figure,
    )  # fmt: skip
    solution = render(
        "exports/stack-solution.html.j2", solution=_write_html(write_solution(problem, part)), figure=solution_figure
    )
    tests = (*stack_part.question_tests, *([UNPARSED_ANSWER] if stack_part.has_single_box else []))
    return StackQuestion(
        stack_part, part.name, part.name, make_category(request, slot, problem, part), _describe_arm(problem), body,
        _encode_figures(arm_figure, prompt_figure), solution, _encode_figures(solution_figure), tests,
    )  # fmt: skip


def _encode_figures(*figures: Picture | None) -> tuple[tuple[str, str], ...]:
    return tuple((f"{figure.name}.svg", base64.b64encode(figure.svg.encode()).decode()) for figure in figures if figure)


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
