"""Make the backup of a complete quiz with its questions, which Moodle 4 can restore into any course.

Moodle has no other file format for quizzes. The questions are in a bank that belongs to the quiz, and each slot of the
quiz picks one variant at random. The slots also store the points, because for a question with several boxes, Moodle
would otherwise give a point for each box.
"""

import base64
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.late_rule import add_time_zone
from qdot.exercises.common.files import make_zip
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.problem.record import Json
from qdot.exercises.writing.render import render

MOODLE_RELEASE, MOODLE_VERSION = "4.0", 2022041900
"""The oldest Moodle that can restore the backup. Later versions store questions and random slots in the same way."""
QUIZ_ID, CONTEXT_ID = 1, 2
"""Ids of the quiz, and of the context (Moodle's term) to which the quiz's bank belongs."""
HIGHEST_ATTEMPT, LAST_ATTEMPT = 1, 4
"""Moodle's codes for the attempt that counts."""
SHOWN_WHEN_CLOSED = 0x00010
SHOWN_AFTER_ATTEMPT = 0x01100 | SHOWN_WHEN_CLOSED
SHOWN_ALWAYS = 0x10000 | SHOWN_AFTER_ATTEMPT
"""Moodle's bits for when something is shown: after the quiz is closed; also after an attempt; also during attempts."""
INTERNAL_TYPES = {"cloze": "multianswer", "matching": "match"}
"""Moodle's internal names of question types, if they differ from those in XML."""
BACKUP_FILES, QUIZ_FILES = ("moodle_backup", "questions", "files"), ("quiz", "module", "inforef", "grades")
EMPTY_BACKUP_FILES = {
    "roles": "roles_definition", "users": "users", "groups": "groups", "scales": "scales_definition",
    "outcomes": "outcomes_definition", "completion": "course_completion", "badges": "badges",
    "grade_history": "grade_history",
}  # fmt: skip
EMPTY_QUIZ_FILES = {
    "roles": "roles", "filters": "filters", "comments": "comments", "calendar": "events",
    "completion": "completions", "competencies": "course_module_competencies", "xapistate": "states",
    "grade_history": "grade_history",
}  # fmt: skip
"""Files that a backup and its quiz must contain although they are empty, each with the name of its root element."""


@dataclass(frozen=True)
class MoodleAnswer:
    """An answer that Moodle recognises: its text or number, percentage of the marks, feedback (HTML), and tolerance."""

    text: str
    percentage: str
    feedback: str
    tolerance: str = ""


@dataclass(frozen=True)
class InputBox:
    """An input box for a number: its answers, its weight, and the box in Moodle's notation for embedded answers."""

    answers: tuple[MoodleAnswer, ...]
    weight: int
    notation: str


@dataclass(frozen=True)
class MoodleQuestion:
    """A question in HTML, with boxes in Moodle's notation (`body`) or with numbered boxes (`body_with_numbered_boxes`).

    `files` and `solution_files` are pairs of a name and the content in base 64. `pairs` are stems and their options; an
    option without a stem has the stem "". `allows_several` means that students may choose several options. For a
    question type that is not part of Moodle, `write_plugin` returns the type's part of a backup, given a question's id.
    """

    name: str
    type: str
    points: float
    body: str
    body_with_numbered_boxes: str
    files: tuple[tuple[str, str], ...]
    solution: str
    solution_files: tuple[tuple[str, str], ...]
    id_number: str
    tags: tuple[str, ...]
    hints: tuple[str, ...] = ()
    answers: tuple[MoodleAnswer, ...] = ()
    allows_several: bool = False
    pairs: tuple[tuple[str, str], ...] = ()
    boxes: tuple[InputBox, ...] = ()
    penalty: float = 1 / 3
    """The share of the points that each wrong attempt costs, if the quiz allows several attempts at a question."""
    write_plugin: Callable[[int], str] | None = None


@dataclass(frozen=True)
class Category:
    """A category of the bank with the variants of a question. `names` is its path, from the outermost category."""

    names: tuple[str, ...]
    questions: tuple[MoodleQuestion, ...]


def make_quiz_backup(request: ExportRequest, key: str, categories: Sequence[Category]) -> bytes:
    """Return the backup of a quiz that picks one question from each category, in this order. `key` names the quiz.

    Values and solutions that the assignment hides are shown once the quiz is closed.
    """
    assignment = request.assignment
    categories_with_ids = _list_categories_with_ids(key, categories)
    question_categories = [entry for entry in categories_with_ids if entry["questions"]]
    question_records = [record for entry in question_categories for record in entry["questions"]]
    files = [file for record in question_records for file in _list_files(record)]
    context = {
        "title": categories[0].names[0], "key": key, "categories": categories_with_ids, "files": files,
        "release": MOODLE_RELEASE, "version": MOODLE_VERSION, "quiz_id": QUIZ_ID, "context_id": CONTEXT_ID,
        "slots": [
            {"filter": _write_category_filter(entry), "points": entry["questions"][0]["question"].points}
            for entry in question_categories
        ],
        "points": sum(category.questions[0].points for category in categories),
        "types": INTERNAL_TYPES, "shown_after_attempt": SHOWN_AFTER_ATTEMPT, "shown_always": SHOWN_ALWAYS,
        "values_shown": SHOWN_AFTER_ATTEMPT if request.includes_feedback("values") else SHOWN_WHEN_CLOSED,
        "solutions_shown": SHOWN_AFTER_ATTEMPT if request.includes_feedback("solutions") else SHOWN_WHEN_CLOSED,
        **_describe_attempts(assignment),
    }  # fmt: skip
    activity = f"activities/quiz_{QUIZ_ID}"
    contents: dict[str, str | bytes] = {f"files/{file['hash'][:2]}/{file['hash']}": file["content"] for file in files}
    names = {name: name for name in BACKUP_FILES} | {f"{activity}/{name}": name for name in QUIZ_FILES}
    contents |= {f"{path}.xml": render(f"exports/moodle-quiz/{name}.xml.j2", **context) for path, name in names.items()}
    roots = EMPTY_BACKUP_FILES | {f"{activity}/{name}": root for name, root in EMPTY_QUIZ_FILES.items()}
    contents |= {f"{path}.xml": render("exports/moodle-quiz/empty.xml.j2", root=root) for path, root in roots.items()}
    return make_zip(contents)


def _write_category_filter(category: Json) -> str:
    """Return the category from which a slot picks, in the notation of Moodle 4.0, which later versions also accept."""
    return json.dumps({"questioncategoryid": str(category["id"]), "includingsubcategories": "0", "tags": []})


def _describe_attempts(assignment: Assignment) -> Json:
    """Return the settings for attempts: their number (0 is unlimited), which attempt counts, the delay, and the end."""
    policy, due_date = assignment.attempt_policy, assignment.due_date
    closing_time = 0 if due_date is None else int(add_time_zone(due_date).timestamp())
    settings = {"attempts": policy.best_of, "counting_attempt": HIGHEST_ATTEMPT, "delay": policy.min_interval}
    if policy.best_of is None:
        settings = {"attempts": 0, "counting_attempt": LAST_ATTEMPT, "delay": 0}
    return settings | {"closing_time": closing_time}


def _list_categories_with_ids(key: str, categories: Sequence[Category]) -> list[Json]:
    """Return the categories of the bank with their questions and with ids; each category follows its parent."""
    ids = count(1)
    categories_by_path: dict[tuple[str, ...], Json] = {
        (): {"id": next(ids), "name": "top", "parent": 0, "questions": []}
    }
    for category in categories:
        for depth in range(1, len(category.names) + 1):
            names = category.names[:depth]
            if names not in categories_by_path:
                parent = categories_by_path[names[:-1]]["id"]
                categories_by_path[names] = {"id": next(ids), "name": names[-1], "parent": parent, "questions": []}
        categories_by_path[category.names]["questions"] = [
            _add_ids_to_question(question, ids) for question in category.questions
        ]
    for names, record in categories_by_path.items():
        record["stamp"] = "qdot+" + hashlib.sha256(repr((key, names)).encode()).hexdigest()[:40]
    return list(categories_by_path.values())


def _add_ids_to_question(question: MoodleQuestion, ids: Iterator[int]) -> Json:
    """Return a question with ids for itself, its answers and its boxes, which Moodle treats as questions."""
    total_weight = sum(box.weight for box in question.boxes)
    boxes = [
        {
            "id": next(ids), "question": question, "box": box, "points": question.points * box.weight / total_weight,
            "answers": _add_ids_to_answers(box.answers, ids),
        }
        for box in question.boxes
    ]  # fmt: skip
    answers = question.boxes[0].answers if len(boxes) == 1 else question.answers
    question_id = next(ids)
    return {
        "id": question_id, "plugin": question.write_plugin(question_id) if question.write_plugin else "",
        "question": question, "boxes": boxes if len(boxes) > 1 else [],
        "answers": _add_ids_to_answers(answers, ids), "hints": [(next(ids), hint) for hint in question.hints],
        "pairs": [(next(ids), *pair) for pair in question.pairs],
    }  # fmt: skip


def _add_ids_to_answers(answers: Sequence[MoodleAnswer], ids: Iterator[int]) -> list[Json]:
    return [{"id": next(ids), "share": float(answer.percentage) / 100, "answer": answer} for answer in answers]


def _list_files(question_record: Json) -> Iterator[Json]:
    question = question_record["question"]
    for area, files in (("questiontext", question.files), ("generalfeedback", question.solution_files)):
        for name, encoded_content in files:
            content = base64.b64decode(encoded_content)
            digest = hashlib.sha1(content, usedforsecurity=False).hexdigest()
            yield {"area": area, "question": question_record["id"], "name": name, "hash": digest, "content": content}
