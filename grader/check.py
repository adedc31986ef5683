"""What a student can know before handing in: which answers are found, and how they are read."""

from dataclasses import dataclass
from pathlib import Path

from exercises.answers import TRUE_FALSE
from exercises.errors import QdotError
from exercises.formula.expression import read
from exercises.formula.trees import Node, ReadError, as_matrix, has_blank
from exercises.problem import variable
from exercises.quizzes import ASKED
from grader.cells import Unreadable
from grader.finding import asked_in, find_answers
from grader.functions import is_table
from grader.sandbox import Sandbox
from grader.submission import read_submission

STATEMENTS = ("eq", "and", "or", "in", "pair", "dict", "set")
"""Kinds of nodes that are conditions, and no entries of a matrix."""


@dataclass(frozen=True)
class Row:
    """One answer cell: the part, whether it can be read, and what is to be said of it."""

    part: str
    readable: bool
    said: str


@dataclass(frozen=True)
class Checked:
    """What will be read of a notebook, and what is to be said of how it was found: the notes of `qdot grade`."""

    rows: tuple[Row, ...]
    notes: tuple[str, ...]


def check_notebook(path: Path) -> Checked:
    """Run a notebook and tell for each answer cell what the grader would read. Raises QdotError for no notebook."""
    try:
        submission = read_submission(path)
    except Unreadable as error:
        raise QdotError(str(error)) from None
    parts = asked_in(submission.cells, tuple(ASKED))
    if not parts:
        raise QdotError(f"{path} has no answer cells; is it a notebook that qdot made?")
    with Sandbox() as sandbox:
        found = find_answers(submission.cells, parts, sandbox.run)
    rows = []
    for part in parts:
        name = variable(*part.split(".", 1))
        answer = found.run.answers.get(name)
        rows.append(_row(part, answer) if answer is not None else Row(part, False, found.reasons[name]))
    return Checked(tuple(rows), (*submission.notes, *found.notes))


def _row(part: str, text: str) -> Row:
    shown = text if len(text) <= 300 else text[:300] + " …"
    if not text.strip():
        return Row(part, False, "left blank")
    if is_table(text):
        return Row(part, True, "a Python function; it is called when it is graded")
    if text.strip().casefold() in TRUE_FALSE:
        return Row(part, True, text.strip())
    try:
        node = read(text)
    except ReadError as error:
        return Row(part, False, str(error))
    if has_blank(node):
        return Row(part, False, "left blank" if _all_blank(node) else f"partly left blank: {shown}")
    return Row(part, True, ("" if ".singular" in part else _shape(node)) + shown)


def _all_blank(node: Node) -> bool:
    return node.kind == "blank" or (bool(node.args) and all(map(_all_blank, node.args)))


def _shape(node: Node) -> str:
    """Return the shape of a matrix of expressions in words; a list of conditions has none."""
    if node.kind != "list":
        return ""
    try:
        rows = as_matrix(node)
    except ReadError:
        return ""
    if len(rows) * len(rows[0]) < 2 or any(entry.kind in STATEMENTS for row in rows for entry in row):
        return ""
    return f"{len(rows)} x {len(rows[0])} matrix "
