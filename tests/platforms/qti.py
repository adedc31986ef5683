"""TAO's QTI engine: every item loaded by its schema, shown, tried and scored; what a student is given of a test.

`software` is a folder of the engine with what it needs in `vendor` (composer install); php is on the path.
"""

import json
import subprocess
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from qdot.exercises.exports.export_format import DEFAULT_ATTEMPTS, ExportRequest
from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberField, NumberForm, QuizItem, make_items
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.reference_answers import LETTERS
from tests.platforms.given import EVERYTHING, PLAIN, order
from tests.platforms.records import Counts, Record, today

Responses = dict[str, Any]
SCRIPT = Path(__file__).with_suffix(".php")
MOST_WRONG = 3
NEAR = 1e-6
"""Shares of points are written with ten digits."""


def run(software: Path, work: Path) -> Record:
    """Export everything once, and the default set in three variants."""
    counts = Counts()
    for which, variants in ((EVERYTHING, 1), (PLAIN, 3)):
        made = order(work / which, which, variants)
        _score(software, _package(made, work / f"{which}-package"), made, counts)
    told = subprocess.run(["git", "-C", software, "log", "-1", "--format=%cs (%h)"], capture_output=True, text=True)
    return Record("qti", f"TAO's QTI SDK of {told.stdout.strip()}", today(), counts.told())


def _package(made: ExportRequest, folder: Path) -> Path:
    (file,) = EXPORT_FORMATS["qti"].export(made)
    archive = folder.with_suffix(".zip")
    archive.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
    return folder


# --- what is handed in ---


@dataclass(frozen=True)
class _Attempt:
    """Responses to an item, as what they are counted, and the share of the points that they are worth."""

    what: str
    given: Responses
    worth: float


def _attempts(one: QuizItem) -> list[_Attempt]:
    """Return attempts, the first of them wrong: nothing is told after it."""
    form = one.form
    if isinstance(form, ChoiceForm):
        return _chosen(form)
    if isinstance(form, MatchingForm):
        return _matched(form)
    return _typed(form) if isinstance(form, NumberForm) else []


def _chosen(form: ChoiceForm) -> list[_Attempt]:
    right = [LETTERS[k] for k, option in enumerate(form.options) if option.is_correct]
    wrong = [LETTERS[k] for k, option in enumerate(form.options) if not option.is_correct]
    if not form.allows_several:
        tries = [_Attempt("wrong < full", {"RESPONSE": letter}, 0) for letter in wrong[:MOST_WRONG]]
        return [
            *tries,
            _Attempt("right = full", {"RESPONSE": right[0]}, 1),
            _Attempt("blank = 0", {"RESPONSE": None}, 0),
        ]
    share = 1 / len(right)
    return [
        _Attempt("wrong < full", {"RESPONSE": wrong}, 0),
        *([_Attempt("wrong < full", {"RESPONSE": right[:1]}, share)] if len(right) > 1 else []),
        _Attempt("wrong < full", {"RESPONSE": [*right, wrong[0]]}, 1 - share),
        _Attempt("right = full", {"RESPONSE": right}, 1),
        _Attempt("blank = 0", {"RESPONSE": []}, 0),
    ]


def _matched(form: MatchingForm) -> list[_Attempt]:
    turned = [*form.correct_options[1:], form.correct_options[0]]
    hits = sum(mine == due for mine, due in zip(turned, form.correct_options, strict=True))
    return [
        _Attempt(
            "wrong < full", {"RESPONSE": [f"S{k} T{index}" for k, index in enumerate(turned)]}, hits / len(turned)
        ),
        _Attempt("right = full", {"RESPONSE": [f"S{k} T{index}" for k, index in enumerate(form.correct_options)]}, 1),
        _Attempt("blank = 0", {"RESPONSE": []}, 0),
    ]


def _typed(form: NumberForm) -> list[_Attempt]:
    fields = form.fields
    made = []
    for number in range(MOST_WRONG):
        values = [_wrong(field, number) for field in fields]
        made.append(_numbers("wrong < full", fields, values))
    for digits in (".6g", ".10g"):
        made.append(_numbers("right = full", fields, [float(f"{field.value:{digits}}") for field in fields]))
    return [*made, _Attempt("blank = 0", {f"R{k}": None for k in range(1, len(fields) + 1)}, 0)]


def _wrong(field: NumberField, number: int) -> float:
    """Return what a mistake makes of a number; where it is none that a mistake makes otherwise, another number."""
    known = next(islice(field.wrong_values, number, None), None)
    return known.value if known is not None else field.value + (number + 1) * max(1.0, abs(field.value))


def _numbers(what: str, fields: Iterable[NumberField], values: list[float]) -> _Attempt:
    near = [abs(value - field.value) <= field.tolerance for field, value in zip(fields, values, strict=True)]
    return _Attempt(what, {f"R{k}": value for k, value in enumerate(values, 1)}, sum(near) / len(near))


# --- what becomes of it ---


def _score(software: Path, package: Path, made: ExportRequest, counts: Counts) -> None:
    asked = list(make_items(made))
    tried = [_attempts(one) for one in asked]
    told = [[one.key, [attempt.given for attempt in attempts]] for one, attempts in zip(asked, tried, strict=True)]
    command = ["php", "-d", "memory_limit=2G", str(SCRIPT), str(software), str(package)]
    done = subprocess.run(command, input=json.dumps(told), capture_output=True, text=True, check=True)
    results = json.loads(done.stdout[done.stdout.index('{"items"') :])
    for one, attempts, result in zip(asked, tried, results["items"], strict=True):
        counts.add("imported", "error" not in result, f"{one.key}: {result.get('error')}")
        if "error" not in result:
            counts.add("shown", _is_shown(one, result["page"]), one.key)
            _hold(one, attempts, result["attempts"], counts)
    _drawn(results["tests"], asked, made, counts)


def _is_shown(one: QuizItem, page: str) -> bool:
    if isinstance(one.form, NumberForm):
        return page.count("qti-textEntryInteraction") >= len(one.form.fields)
    return "qti-matchInteraction" in page if isinstance(one.form, MatchingForm) else "qti-choiceInteraction" in page


def _hold(one: QuizItem, attempts: list[_Attempt], results: list[dict[str, Any]], counts: Counts) -> None:
    for number, (attempt, result) in enumerate(zip(attempts, results, strict=True), 1):
        share, where = result["score"] / one.points, f"{one.key} {attempt.given}: {result}"
        is_due = {"right = full": share > 1 - NEAR, "wrong < full": share < 1 - NEAR, "blank = 0": share == 0}
        counts.add(attempt.what, is_due[attempt.what], where)
        counts.add("scores as ours", abs(share - attempt.worth) < NEAR, f"{where}, {attempt.worth} is due")
        told_now = number >= DEFAULT_ATTEMPTS or attempt.worth == 1
        counts.add("solution when done", ("solution" in result["told"]) == told_now, where)


def _drawn(tests: Any, asked: list[QuizItem], made: ExportRequest, counts: Counts) -> None:
    """Hold that a student is given one variant of each place, with all of its parts in their order."""
    counts.add("test loaded", isinstance(tests, list), f"test: {tests}")
    for test in tests if isinstance(tests, list) else ():
        variants = list(dict.fromkeys("-".join(item.split("-")[:2]) for item in test["items"]))
        due = [one.key for variant in variants for one in asked if one.key.startswith(f"{variant}-")]
        places = [variant.split("-")[0] for variant in variants]
        whole = places == [slot.name for slot in made.assignment.slots] and test["items"] == due
        counts.add("one variant a place", whole and test["attempts"] == DEFAULT_ATTEMPTS, f"{test}")
