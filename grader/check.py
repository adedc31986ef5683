"""What a student can know before handing in: which answers are found, and how they are read."""

import keyword
import re
from dataclasses import dataclass
from pathlib import Path

from exercises.answers import TRUE_FALSE, Direction, Expression, Matrix
from exercises.errors import QdotError
from exercises.families import FAMILIES
from exercises.formula.identity import Domain
from exercises.formula.trees import has_blank
from exercises.generation import generate
from exercises.notebook import setup_of
from exercises.problem import Part, Problem, ProblemId, variable
from exercises.quizzes import ASKED
from grader.answer import LINEAR, Given, read_any
from grader.cells import Unreadable
from grader.finding import asked_in, find_answers
from grader.formulas import unknown_symbols
from grader.function_values import is_table
from grader.reading import read_answer
from grader.sandbox import Sandbox
from grader.submission import Submission, read_submission
from grader.verdict import Outcome

STATEMENTS = ("eq", "and", "or", "in", "pair", "dict", "set")
"""Kinds of nodes that are conditions, and no entries of a matrix."""


@dataclass(frozen=True)
class CheckedAnswer:
    """One answer cell: the part, whether it can be read, and what is to be said of it."""

    part: str
    readable: bool
    said: str


@dataclass(frozen=True)
class Checked:
    """What will be read of a notebook, and what is to be said of how it was found: the notes of `qdot grade`."""

    rows: tuple[CheckedAnswer, ...]
    notes: tuple[str, ...]


def check_notebook(path: Path) -> Checked:
    r"""Run a notebook and tell for each answer cell what the grader would read. Raises QdotError for no notebook.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "mine.md"
    ...     _ = path.write_text("```python\np1_determinant = 'a1*a2*sin(theta2'\n```")
    ...     check_notebook(path).rows[0].said
    "this can't be read as an answer: expected ')', found 'the end', at character 17, near '1*a2*sin(theta2'"
    """
    try:
        submission = read_submission(path)
    except Unreadable as error:
        raise QdotError(str(error)) from None
    parts = asked_in(submission.cells, tuple(ASKED))
    if not parts:
        raise QdotError(f"{path} has no answer cells; is it a notebook that qdot made?")
    with Sandbox() as sandbox:
        setup = setup_of(_claimed_symbols(submission))
        answers = find_answers(submission.cells, parts, lambda cells, names: sandbox.run(cells, names, setup=setup))
    rows = []
    for part in parts:
        slot, kind = part.split(".", 1)
        answer = answers.run.answers.get(variable(slot, kind))
        if answer is None:
            rows.append(CheckedAnswer(part, False, answers.reasons[variable(slot, kind)]))
        else:
            family, symbols, names = (_claimed(submission, key, slot) for key in ("problems", "symbols", "names"))
            rows.append(_row(part, answer, _due(family, symbols, names, kind)))
    return Checked(tuple(rows), tuple(note for note in (*submission.notes, *answers.notes) if note))


def _claimed(submission: Submission, key: str, slot: str) -> object:
    """Return what a notebook says of its problem: anything, as whoever wrote it could."""
    said = submission.claims.get(key)
    return said.get(slot) if isinstance(said, dict) else None


def _claimed_symbols(submission: Submission) -> list[str]:
    """Return the symbols that a notebook says its problems have; what is no name is none."""
    said = submission.claims.get("symbols")
    listed = [names for names in said.values() if isinstance(names, list)] if isinstance(said, dict) else []
    named = {
        name
        for names in listed
        for name in names
        if isinstance(name, str) and re.fullmatch(r"[a-z]{1,20}\d{0,3}", name)
    }
    return sorted(name for name in named if not keyword.iskeyword(name))[:MOST_SYMBOLS]


MOST_SYMBOLS = 100
"""Names that are taken from what a notebook says of itself."""


@dataclass(frozen=True)
class _Due:
    """A part of any problem of the family, with what the notebook names of the student's own: symbols, entries.

    `labels` are the names that the entries may have: one choice where they are known, else all that there are.
    """

    problem: Problem
    part: Part
    symbols: Domain | None = None
    labels: tuple[tuple[str, ...] | None, ...] = (None,)

    def read(self, text: str) -> Given:
        given = [read_answer(self.problem, self.part, text, domain=self.symbols, labels=each) for each in self.labels]
        return next((one for one in given if one.refusal is None), given[-1])

    def unknown(self, given: Given) -> str:
        """Say which symbols the student's problem does not have; nothing where that is not known."""
        if self.symbols is None or not isinstance(self.part.answer, Expression | Matrix | Direction):
            return ""
        return unknown_symbols(given, self.symbols)


def _due(family: object, symbols: object, names: object, kind: str) -> _Due | None:
    """Return what is due in the form in which it is, as in any problem of the family; None where that varies.

    Of a notebook without its assignment is known which family an arm is of, and no more: which options there are, and
    the shape of answers for arms that are drawn with their structure, are not.
    """
    known = FAMILIES.get(family) if isinstance(family, str) else None
    if known is None or known.varied:
        return None
    try:
        problem = generate(ProblemId(known.name, 0, (kind,)))
    except QdotError:
        return None
    (part,) = problem.parts
    if part.answer.offered:
        return None
    return _Due(problem, part, _domain(symbols, problem), _labels(names, problem, part))


def _labels(names: object, like: Problem, part: Part) -> tuple[tuple[str, ...] | None, ...]:
    """Return the names of the entries that the notebook tells; of one of an older edition, whatever is asked in any."""
    own = ASKED[part.kind].typed_labels(like.chain, part)
    told = names.get(part.name) if isinstance(names, dict) else None
    if isinstance(told, list) and len(told) == len(own) and all(isinstance(name, str) for name in told):
        return (tuple(told),)
    return tuple((name,) for name in LINEAR) if len(own) == 1 and own[0] in LINEAR else (None,)


def _domain(symbols: object, like: Problem) -> Domain | None:
    if not isinstance(symbols, list) or not symbols or not all(isinstance(name, str) for name in symbols):
        return None
    return Domain({name: like.domain().roles.get(name, "signed") for name in symbols})


def readable(text: str, problem: Problem, part: Part) -> bool:
    """Tell whether a text is said to be readable as the answer that is due."""
    return _row("", text, _Due(problem, part)).readable


def _row(part: str, text: str, due: _Due | None) -> CheckedAnswer:
    if not text.strip():
        return CheckedAnswer(part, False, "left blank")
    if is_table(text):
        return CheckedAnswer(part, True, "a Python function; it is called when it is graded")
    if due is None and text.strip().casefold() in TRUE_FALSE:
        return CheckedAnswer(part, True, text.strip())
    given = read_any(text) if due is None else due.read(text)
    if given.refusal is not None:
        left = given.refusal.outcome is Outcome.MISSING
        return CheckedAnswer(part, False, "left blank" if left else given.refusal.reason)
    if due is not None and (unknown := due.unknown(given)):
        return CheckedAnswer(part, False, unknown)
    shown = text if len(text) <= 300 else text[:300] + " …"
    if given.tree is not None and has_blank(given.tree):
        return CheckedAnswer(part, False, f"partly left blank: {shown}")
    return CheckedAnswer(part, True, ("" if ".singular" in part else _shape(given)) + shown)


def _shape(given: Given) -> str:
    """Return the shape of a matrix of expressions in words; a list of conditions has none."""
    if given.tree is None or given.tree.kind != "list" or given.rows is None or len(given.entries) < 2:
        return ""
    if any(entry.kind in STATEMENTS for entry in given.entries):
        return ""
    return f"{len(given.rows)} x {len(given.rows[0])} matrix "
