"""Export a PrairieLearn course folder: assessments, and a question that calls qdot for each slot."""

import hashlib
import json
import re
import uuid
from collections.abc import Generator, Mapping, Sequence

from qdot.exercises.assignment.assignment import SECRET_FILE, Assignment, Slot
from qdot.exercises.exports.assignment_files import read_problem_files
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.notebook.notebook import write_points
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import Answer, Choice, Matching, Number, Selection
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing.render import render

BANK_FILE = "bank.json"
"""The file that lists the seeds of the certified variants of each slot."""
TOPIC = "Velocity kinematics"
INSTANCE_FOLDER = "courseInstances/qdot"
"""The folder of the course instance, which is PrairieLearn's name for a course in one semester."""


def export_prairielearn(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the course's files. They contain the seeds of the bank's problems, but not the secret."""
    supported_request = request.without_text_questions("PrairieLearn")
    assignment = supported_request.assignment
    key = assignment.key.lower()
    seeds_by_slot: dict[str, list[str]] = {slot.name: [] for slot in assignment.slots}
    parts_by_slot: dict[str, tuple[Part, ...]] = {}
    for variant in iterate_bank(supported_request):
        parts_by_slot.setdefault(variant.slot.name, variant.problem.parts)
        seeds_by_slot[variant.slot.name].append(str(variant.problem.id.seed))  # text: JavaScript rounds integers
    topic = {"name": TOPIC, "color": "blue3", "description": "Velocities and singularities of robot arms"}
    tag = {"name": "qdot", "color": "gray2", "description": "Made and graded by qdot"}
    course = {"name": assignment.key, "title": assignment.title, "topics": [topic], "tags": [tag]}
    instance = {"uuid": _make_uuid(assignment, "course instance"), "longName": assignment.title}
    yield ExportedFile("infoCourse.json", _write_json(course))
    for slot in assignment.slots:
        yield from _make_question_files(assignment, slot, parts_by_slot[slot.name])
    yield ExportedFile(f"{INSTANCE_FOLDER}/infoCourseInstance.json", _write_json(instance))
    for kind, assessment in _make_assessments(assignment, supported_request.attempt_count).items():
        yield ExportedFile(f"{INSTANCE_FOLDER}/assessments/{key}-{kind}/infoAssessment.json", _write_json(assessment))
    yield from _make_server_files(assignment, f"serverFilesCourse/qdot/{key}", seeds_by_slot)


def _make_question_files(
    assignment: Assignment, slot: Slot, parts: tuple[Part, ...]
) -> Generator[ExportedFile, None, None]:
    folder = f"questions/{make_question_id(assignment, slot)}"
    title = f"{assignment.title}: {slot.name} ({slot.family.name})"
    info = {
        "uuid": _make_uuid(assignment, slot.name), "title": title, "topic": TOPIC, "tags": ["qdot"], "type": "v3",
    }  # fmt: skip
    yield ExportedFile(f"{folder}/info.json", _write_json(info))
    elements = [
        {
            "name": part.name, "title": question_of(part).title, "points": write_points(part.points),
            "element": choose_element(part.answer), "weight": max(1, round(part.points)),
        }
        for part in parts
    ]  # fmt: skip
    yield ExportedFile(f"{folder}/question.html", render("exports/prairielearn/question.html.j2", parts=elements))
    server = render(
        "exports/prairielearn/server.py.j2", title=title.replace("\\", " ").replace('"', "'"), slot=slot.name,
        folder=f"qdot/{assignment.key.lower()}",
    )  # fmt: skip
    yield ExportedFile(f"{folder}/server.py", server)


# --- the elements in which answers are given ---


def choose_element(answer: Answer) -> str:
    """Return the name of the element in question.html that asks for an answer; all variants of a slot have the same."""
    if isinstance(answer, Number):
        return "wholes" if answer.is_count else "numbers"
    kinds = ((Matching, "match"), (Selection, "several"), (Choice, "choice"))
    return next((element for kind, element in kinds if isinstance(answer, kind)), "text")


def list_input_names(part: Part) -> list[str]:
    """Return the names of a part's inputs: the part's name, or a numbered name for each number or matched item.

    The names for matched items follow the rule of PrairieLearn's element pl-matching.
    """
    if part.answer.matched_items:
        return [f"{part.name}-dropdown-{index}" for index in range(len(part.answer.matched_items))]
    count = len(part.answer.expected_units)
    return [f"{part.name}-{number}" for number in range(1, count + 1)] if count > 1 else [part.name]


# --- files beside the questions ---


def _make_server_files(
    assignment: Assignment, folder: str, seeds_by_slot: dict[str, list[str]]
) -> Generator[ExportedFile, None, None]:
    for path, data in read_problem_files(assignment).items():
        yield ExportedFile(f"{folder}/{path}", data, is_private=True)
    # An assignment needs a roster, but the server generates problems without it.
    yield ExportedFile(f"{folder}/roster.csv", "student\nprairielearn\n", is_private=True)
    yield ExportedFile(f"{folder}/{SECRET_FILE}", _derive_hash(assignment, "seed") + "\n", is_private=True)
    bank = _write_json({"digest": assignment.notebook_digest, "seeds": seeds_by_slot})
    yield ExportedFile(f"{folder}/{BANK_FILE}", bank, is_private=True)
    yield ExportedFile(f"{folder}/README.md", render("exports/prairielearn/assignment-README.md.j2"))


def _derive_hash(assignment: Assignment, purpose: str) -> str:
    """Return a hash that depends on the secret and the purpose, but does not reveal the secret."""
    return hashlib.sha256(f"qdot/prairielearn/{purpose}/{assignment.secret}".encode()).hexdigest()


def make_question_id(assignment: Assignment, slot: Slot) -> str:
    """Return the name of the question's folder, which assessments refer to."""
    return f"{assignment.key.lower()}-{slot.name}"


def _make_uuid(assignment: Assignment, name: str) -> str:
    """Return a UUID that is the same at every export, even if the questions of a slot change."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"qdot:{_derive_hash(assignment, 'uuid')}:{assignment.key}:{name}"))


def _make_assessments(assignment: Assignment, attempt_count: int) -> dict[str, dict[str, object]]:
    """Return a homework assessment, in which students may practise with new variants, and an exam with one variant.

    `attempt_count` is the number of attempts at a variant. The best attempt counts.
    """
    points_by_question = {make_question_id(assignment, slot): sum(slot.max_points) for slot in assignment.slots}
    homework_questions = [
        {"id": name, "autoPoints": points, "triesPerVariant": attempt_count}
        for name, points in points_by_question.items()
    ]
    exam_questions = [  # with the same points for a right answer at each attempt
        {"id": name, "autoPoints": [points] * attempt_count} for name, points in points_by_question.items()
    ]
    exam_settings = {"shuffleQuestions": False, "requireHonorCode": False}
    return {
        "homework": _make_assessment(assignment, "Homework", homework_questions),
        "exam": _make_assessment(assignment, "Exam", exam_questions) | exam_settings,
    }


def _make_assessment(assignment: Assignment, kind: str, questions: Sequence[Mapping[str, object]]) -> dict[str, object]:
    return {
        "uuid": _make_uuid(assignment, kind), "type": kind, "title": assignment.title, "set": kind,
        "number": find_assignment_number(assignment), "zones": [{"questions": questions}],
    }  # fmt: skip


def find_assignment_number(assignment: Assignment) -> str:
    """Return the number of the homework or exam from its title or key: `6` of "Homework 6", else `1`.

    PrairieLearn writes this number right after the abbreviation of a set, as in HW6.
    """
    number = re.search(r"(?<![\w.,-])\d+(?!\w)", assignment.title) or re.search(r"\d+$", assignment.key)
    return number[0] if number else "1"


def _write_json(content: object) -> str:
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
