"""Check a notebook before it is submitted: find the answers and report how qdot parses them (`qdot check`).

A student has no assignment folder. The symbols and the form of each answer are therefore taken from the notebook's
metadata, which the student may have edited. They are called claims here, and they are checked before use.
"""

import keyword
import re
from collections.abc import Container, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeGuard

import sympy as sp

from qdot.exercises.common.errors import QdotError, shorten
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.trees import has_blank
from qdot.exercises.notebook.setup_cell import write_setup_cell_for_names
from qdot.exercises.problem.problem import name_answer_variable
from qdot.exercises.reference_answers import (
    LETTERS,
    TRUE_FALSE,
    Answer,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Letters,
    Matching,
    Matrix,
    Number,
    Selection,
    Words,
)
from qdot.grader.judging.answer_parser import OR_HINT, ParsedAnswer, combine_with_and, read_any
from qdot.grader.judging.expected_form import ExpectedForm, read_in_form
from qdot.grader.judging.formulas import describe_unknown_symbols
from qdot.grader.judging.functions import is_function_table
from qdot.grader.judging.verdict import Outcome
from qdot.grader.sandbox.sandbox import Sandbox
from qdot.grader.submissions.answer_locator import find_answers, guess_parts
from qdot.grader.submissions.cells import OverLimit, Unreadable, dict_or_empty
from qdot.grader.submissions.submission import Submission, find_python_files, read_submission

STATEMENT_KINDS = ("eq", "and", "or", "in", "pair", "dict", "set")
"""Kinds of tree nodes that are conditions, and so can't be entries of a matrix."""


@dataclass(frozen=True)
class CheckedAnswer:
    """One answer cell: the part, whether its answer can be parsed, and a message for the student."""

    part: str
    is_readable: bool
    message: str


@dataclass(frozen=True)
class CheckedNotebook:
    """The answers that `qdot grade` will find in a notebook, and notes on how they are found."""

    rows: tuple[CheckedAnswer, ...]
    notes: tuple[str, ...]


def check_notebook(path: Path) -> CheckedNotebook:
    r"""Run a notebook and return the answers that the grader would find. Raises QdotError if it can't be checked.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "mine.md"
    ...     _ = path.write_text("```python\np1_determinant = 'a1*a2*sin(theta2'\n```")
    ...     check_notebook(path).rows[0].message
    "qdot couldn't parse your answer: ')' is missing at the end (at character 17, near '…1*a2*sin(theta2')"
    """
    try:
        submission = read_submission(path, siblings=find_python_files(path))
    except Unreadable as error:
        raise QdotError(str(error)) from None
    parts = guess_parts(submission.cells, _load_questions)
    if not parts:
        raise QdotError(f"{path} has no answer cells; check that it is a notebook that qdot generated")
    forms = {part: find_claimed_form(submission.qdot_metadata, *part.split(".", 1)) for part in parts}
    parts_in_words = {part for part, form in forms.items() if form is not None and isinstance(form.answer, Words)}
    with Sandbox(warm_up=False) as sandbox:
        setup = write_setup_cell_for_names(_list_claimed_symbols(submission))
        run = partial(sandbox.run, setup=setup, modules=submission.modules)
        try:
            answers = find_answers(submission.cells, parts, run, parts_in_words)
        except OverLimit as error:
            raise QdotError(f"{path}: {error}") from None
    rows = []
    for part in parts:
        name = name_answer_variable(*part.split(".", 1))
        if name in answers.run.answers:
            rows.append(_check_answer(part, answers.run.answers[name], forms[part]))
        else:
            rows.append(CheckedAnswer(part, False, answers.missing_reasons[name]))
    return CheckedNotebook(tuple(rows), tuple(note for note in (*submission.notes, *answers.notes) if note))


def _load_questions() -> Container[str]:
    from qdot.exercises.short_questions import ALL_QUESTIONS  # loads half of qdot, which few notebooks need

    return ALL_QUESTIONS


def _list_claimed_symbols(submission: Submission) -> list[str]:
    """Return the symbols that a notebook's metadata claim for its problems, without invalid names."""
    claim = dict_or_empty(submission.qdot_metadata.get("symbols"))
    texts = {name for names in claim.values() if isinstance(names, list) for name in names if isinstance(name, str)}
    valid_names = (name for name in texts if re.fullmatch(r"[a-z]{1,20}\d{0,3}", name) and not keyword.iskeyword(name))
    return sorted(valid_names)[:MAX_SYMBOLS]


MAX_SYMBOLS = 100
"""Maximum number of symbols that are taken from a notebook's metadata."""


def find_claimed_form(claims: Mapping[str, object], slot: str, part: str) -> ExpectedForm | None:
    """Return the form of the expected answer according to `claims`, a notebook's metadata; None if there is no form.

    Older notebooks have no form in their metadata, or no options.
    """
    forms, symbols, joints = (dict_or_empty(claims.get(key)).get(slot) for key in ("answers", "symbols", "joints"))
    form = dict_or_empty(forms).get(part)
    if not isinstance(form, dict) or not _is_name_list(symbols) or not symbols or not _is_name_list(joints):
        return None
    labels, columns, metre_power = form.get("labels", []), form.get("columns", []), form.get("metres")
    answer = _make_example_answer(form)
    if answer is None or not _is_name_list(labels) or not _is_name_list(columns):
        return None
    if metre_power not in (None, *range(7)):  # a Jacobian has at most six rows
        return None
    domain = Domain(dict.fromkeys(symbols, "signed"))
    return ExpectedForm(answer, domain, tuple(joints), tuple(labels), tuple(columns), metre_power)


SIZE_BOUND = 100
"""Numbers of rows and columns claimed for an answer must be below this; arms have fewer joints."""


def _make_example_answer(form: Mapping[str, object]) -> Answer | None:
    """Return an answer of the claimed form, with zeros or the first options; None for an invalid form.

    A form has the name of the type, the numbers of rows and columns, the units of numbers, and the options and items.
    """
    answer_type, shape, units = form.get("type"), form.get("shape", []), form.get("units", [])
    options, items = form.get("options", []), form.get("items", [])
    if answer_type == Expression.type:
        return Expression(sp.S.Zero)
    if answer_type == ConditionSet.type:
        return ConditionSet(())
    if answer_type == Words.type:
        return Words()
    if answer_type in (Choice.type, Selection.type, Matching.type):
        if not _is_name_list(options) or not _is_name_list(items) or len(options) not in range(1, len(LETTERS) + 1):
            return None
        if answer_type == Matching.type:
            return Matching(tuple(items), tuple(options), tuple(range(len(items)))) if items else None
        return Choice(tuple(options), 0) if answer_type == Choice.type else Selection(tuple(options), (0,))
    if not isinstance(shape, list) or len(shape) != 2 or any(n not in range(1, SIZE_BOUND) for n in shape):
        return None
    zeros = sp.zeros(*map(int, shape))  # a notebook's numbers may be floats such as 3.0
    if answer_type == Number.type and _is_name_list(units) and len(units) == len(zeros):
        return Number(zeros, tuple(units), tolerance=0, floor=0)
    return {Matrix.type: Matrix(zeros), Direction.type: Direction(zeros)}.get(str(answer_type))


def _is_name_list(claim: object) -> TypeGuard[list[str]]:
    return isinstance(claim, list) and all(isinstance(name, str) for name in claim)


def is_readable(text: str, expected: ExpectedForm) -> bool:
    """Return whether a text can be parsed as the expected answer."""
    return _check_answer("", text, expected).is_readable


def _check_answer(part: str, text: str, expected: ExpectedForm | None) -> CheckedAnswer:
    """Return whether and how a text can be parsed as the answer to a part; the form may be unknown (None)."""
    if not text.strip():
        return CheckedAnswer(part, False, "left blank")
    if is_function_table(text):
        return CheckedAnswer(part, True, "a Python function, which qdot calls when it grades the answer")
    if expected is None and text.strip().casefold() in TRUE_FALSE:
        return CheckedAnswer(part, True, text.strip())
    parsed_answer = read_any(text) if expected is None else read_in_form(expected, text)
    if parsed_answer.refusal is not None:
        is_blank = parsed_answer.refusal.outcome is Outcome.MISSING
        return CheckedAnswer(part, False, "left blank" if is_blank else parsed_answer.refusal.reason)
    has_known_symbols = expected is not None and expected.answer.takes_symbols and not expected.answer.is_set
    symbol_error = describe_unknown_symbols(parsed_answer, expected.domain) if expected and has_known_symbols else ""
    if symbol_error:
        return CheckedAnswer(part, False, symbol_error)
    excerpt = shorten(text, 300)
    if expected is not None and isinstance(expected.answer, Words):
        return CheckedAnswer(part, True, f"a text, which a person marks: {excerpt}")
    if expected is not None and isinstance(expected.answer, Letters):
        options = expected.answer.options
        names = options if options == TRUE_FALSE else LETTERS
        chosen_names = ", ".join(names[index] for index in parsed_answer.chosen_indices)
        is_typed = chosen_names.casefold() == text.strip().casefold()
        return CheckedAnswer(part, True, excerpt if is_typed else f"{chosen_names} (from {excerpt})")
    if parsed_answer.tree is not None and has_blank(parsed_answer.tree):
        return CheckedAnswer(part, False, f"partly left blank: {excerpt}")
    if expected is not None and expected.answer.is_set:
        # Commas between conditions on different joints may be meant as "and", except in brackets.
        tree = None if text.strip().startswith(("[", "{")) else parsed_answer.tree
        may_mean_and = tree is not None and combine_with_and(tree, expected.joints) is not None
        return CheckedAnswer(part, True, excerpt + (f" ({OR_HINT})" if may_mean_and else ""))
    # If the form is unknown, only the name of the part shows that a list is not a matrix, but a list of conditions.
    return CheckedAnswer(part, True, ("" if ".singular" in part else _describe_shape(parsed_answer)) + excerpt)


def _describe_shape(parsed: ParsedAnswer) -> str:
    """Return the shape of a matrix of expressions as text; "" for anything else, such as a list of conditions."""
    is_list = parsed.tree is not None and parsed.tree.kind == "list" and len(parsed.entries) > 1
    if not is_list or parsed.rows is None or any(entry.kind in STATEMENT_KINDS for entry in parsed.entries):
        return ""
    return f"{len(parsed.rows)} × {len(parsed.rows[0])} matrix "
