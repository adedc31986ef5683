"""The backup of a complete quiz with its questions, which Moodle 4 can restore into any course.

Moodle has no other file format for quizzes. The questions are in the quiz's own bank, and each slot picks one variant
at random. The slot stores the points: Moodle would give a question with embedded answers a point for each box.
"""

import base64
import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.lateness import with_zone
from qdot.exercises.exports.export_format import Order, archive
from qdot.exercises.writing.render import render

RELEASE, VERSION = "4.0", 2022041900
"""The oldest Moodle that can restore the backup. Later versions store questions and random slots in the same way."""
QUIZ, CONTEXT = 1, 2
"""Ids of the quiz, and of the context to which its bank belongs."""
HIGHEST, LAST = 1, 4
"""Moodle's codes for the attempt that counts."""
CLOSED = 0x00010
AFTER = 0x01100 | CLOSED
ALWAYS = 0x10000 | AFTER
"""Moodle's bits for when something is shown: once the quiz is closed; also right after the attempt; also during it."""
TYPES = {"cloze": "multianswer", "matching": "match"}
"""Moodle's internal names of question types, if they differ from those in XML."""
OF_BACKUP, OF_QUIZ = ("moodle_backup", "questions", "files"), ("quiz", "module", "inforef", "grades")
EMPTY = {
    "roles": "roles_definition", "users": "users", "groups": "groups", "scales": "scales_definition",
    "outcomes": "outcomes_definition", "completion": "course_completion", "badges": "badges",
    "grade_history": "grade_history",
}  # fmt: skip
EMPTY_OF_QUIZ = {
    "roles": "roles", "filters": "filters", "comments": "comments", "calendar": "events",
    "completion": "completions", "competencies": "course_module_competencies", "xapistate": "states",
    "grade_history": "grade_history",
}  # fmt: skip
"""Files that a backup and its quiz must have; for empty ones, with the name of their root element."""

Json = dict[str, Any]


@dataclass(frozen=True)
class Answer:
    """An answer that Moodle recognises: its text or number, percentage of the marks, feedback (HTML), and tolerance."""

    text: str
    fraction: str
    feedback: str
    tolerance: str = ""


@dataclass(frozen=True)
class Box:
    """An input box for a number: its answers, its weight, and both in Moodle's notation for embedded answers."""

    answers: tuple[Answer, ...]
    weight: int
    notation: str


@dataclass(frozen=True)
class Question:
    """A question in HTML, with boxes in Moodle's notation (`body`) or with numbered boxes (`numbered`).

    Files are pairs of a name and the content in base 64. `pairs` are stems and options; a wrong option has an empty
    stem. `several` means that several options may be chosen.
    """

    name: str
    type: str
    body: str
    numbered: str
    files: tuple[tuple[str, str], ...]
    solution: str
    solution_files: tuple[tuple[str, str], ...]
    points: float
    idnumber: str
    tags: tuple[str, ...]
    hints: tuple[str, ...]
    answers: tuple[Answer, ...]
    several: bool
    pairs: tuple[tuple[str, str], ...]
    boxes: tuple[Box, ...]


@dataclass(frozen=True)
class Category:
    """The variants of a question, and the path to their category: names, the outermost first."""

    names: tuple[str, ...]
    questions: tuple[Question, ...]


def quiz_backup(order: Order, categories: Sequence[Category]) -> bytes:
    """Return the backup of a quiz that picks one question from each category, in this order.

    Values and solutions that the assignment hides are shown once the quiz is closed.
    """
    assignment = order.assignment
    folders = _folders(assignment.key, categories)
    question_folders = [folder for folder in folders if folder["questions"]]
    files = [file for folder in question_folders for entry in folder["questions"] for file in _files(entry)]
    context = {
        "title": categories[0].names[0],
        "key": assignment.key,
        "release": RELEASE,
        "version": VERSION,
        "quiz": QUIZ,
        "context": CONTEXT,
        "folders": folders,
        "files": files,
        "slots": [
            {"draws": _draws(folder), "points": folder["questions"][0]["question"].points}
            for folder in question_folders
        ],
        "points": sum(category.questions[0].points for category in categories),
        "types": TYPES,
        "after": AFTER,
        "always": ALWAYS,
        "values": AFTER if order.tells("values") else CLOSED,
        "solutions": AFTER if order.tells("solutions") else CLOSED,
        **_attempts(assignment),
    }
    activity = f"activities/quiz_{QUIZ}"
    contents: dict[str, str | bytes] = {f"files/{file['hash'][:2]}/{file['hash']}": file["content"] for file in files}
    contents |= {f"{name}.xml": render(f"exports/moodle-quiz/{name}.xml.j2", **context) for name in OF_BACKUP}
    contents |= {f"{activity}/{name}.xml": render(f"exports/moodle-quiz/{name}.xml.j2", **context) for name in OF_QUIZ}
    contents |= {f"{name}.xml": _empty(root) for name, root in EMPTY.items()}
    contents |= {f"{activity}/{name}.xml": _empty(root) for name, root in EMPTY_OF_QUIZ.items()}
    return archive(contents)


def _empty(root: str) -> str:
    return render("exports/moodle-quiz/empty.xml.j2", root=root)


def _draws(folder: Json) -> str:
    """Return the category from which a slot picks, in the notation of Moodle 4.0, which later versions also accept."""
    return json.dumps({"questioncategoryid": str(folder["id"]), "includingsubcategories": "0", "tags": []})


def _attempts(assignment: Assignment) -> Json:
    """Return the settings for attempts: their number (0 is unlimited), which one counts, the delay, and the end."""
    policy, due_date = assignment.attempts, assignment.due_date
    is_best_of = policy.best_of is not None
    return {
        "attempts": policy.best_of or 0,
        "counts": HIGHEST if is_best_of else LAST,
        "apart": policy.apart if is_best_of else 0,
        "closes": 0 if due_date is None else int(with_zone(due_date).timestamp()),
    }


def _folders(key: str, categories: Sequence[Category]) -> list[Json]:
    """Return the categories of the bank, each after its parent; categories and questions are numbered together."""
    ids = count(1)
    folders: dict[tuple[str, ...], Json] = {(): {"id": next(ids), "name": "top", "parent": 0, "questions": []}}
    for category in categories:
        for depth in range(1, len(category.names) + 1):
            names = category.names[:depth]
            if names not in folders:
                folders[names] = {
                    "id": next(ids), "name": names[-1], "parent": folders[names[:-1]]["id"], "questions": [],
                }  # fmt: skip
        folders[category.names]["questions"] = [_entry(question, ids) for question in category.questions]
    for names, folder in folders.items():
        folder["stamp"] = "qdot+" + hashlib.sha256(repr((key, names)).encode()).hexdigest()[:40]
    return list(folders.values())


def _entry(question: Question, ids: Iterator[int]) -> Json:
    """Return a question with ids for itself, its answers and its boxes, which Moodle treats as questions."""
    total_weight = sum(box.weight for box in question.boxes)
    boxes = [
        {
            "id": next(ids), "question": question, "box": box, "points": question.points * box.weight / total_weight,
            "answers": _number_answers(box.answers, ids),
        }
        for box in question.boxes
    ]  # fmt: skip
    has_several_boxes = len(boxes) > 1
    return {
        "id": next(ids),
        "question": question,
        "boxes": boxes if has_several_boxes else [],
        "answers": _number_answers(
            question.boxes[0].answers if boxes and not has_several_boxes else question.answers, ids
        ),
        "hints": [(next(ids), hint) for hint in question.hints],
        "pairs": [(next(ids), *pair) for pair in question.pairs],
    }


def _number_answers(answers: Sequence[Answer], ids: Iterator[int]) -> list[Json]:
    return [{"id": next(ids), "share": float(answer.fraction) / 100, "answer": answer} for answer in answers]


def _files(entry: Json) -> Iterator[Json]:
    question = entry["question"]
    for area, files in (("questiontext", question.files), ("generalfeedback", question.solution_files)):
        for name, encoded in files:
            content = base64.b64decode(encoded)
            digest = hashlib.sha1(content, usedforsecurity=False).hexdigest()
            yield {"area": area, "question": entry["id"], "name": name, "hash": digest, "content": content}
