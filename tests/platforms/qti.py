"""TAO's QTI engine: it validates, renders and scores every item, and selects a student's items from a test.

`software` is the folder of the engine, with its dependencies in `vendor` (composer install); php is on the path.
"""

import json
import subprocess
import zipfile
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from qdot.exercises.exports.export_format import DEFAULT_ATTEMPTS, ExportRequest
from qdot.exercises.exports.items import (
    ChoiceForm,
    MatchingForm,
    NumberField,
    NumberForm,
    QuizItem,
    TextForm,
    make_items,
)
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.reference_answers import LETTERS
from tests.platforms.assignments import EVERYTHING, PLAIN, make_request, write_files
from tests.platforms.records import Counts, Record, describe_checkout, today

Responses = dict[str, Any]
SCRIPT = Path(__file__).with_suffix(".php")
MAX_WRONG_ATTEMPTS = 3
TOLERANCE = 1e-6
"""For shares of points, which are written with ten digits."""


def run(software: Path, work: Path) -> Record:
    """Export everything once, and the default set in three variants."""
    counts = Counts()
    for kind, variants in ((EVERYTHING, 1), (PLAIN, 3)):
        request = make_request(work / kind, kind, variants)
        _check_package(software, _write_package(request, work / f"{kind}-package"), request, counts)
    return Record("qti", f"TAO's QTI SDK of {describe_checkout(software)}", today(), counts.freeze())


def _write_package(request: ExportRequest, folder: Path) -> Path:
    (archive,) = write_files(EXPORT_FORMATS["qti"].export(request), folder.parent)
    with zipfile.ZipFile(archive) as zip_file:
        zip_file.extractall(folder)
    return folder


# --- attempts ---


@dataclass(frozen=True)
class _Attempt:
    """Responses to an item, the check as which they are counted, and the share of the points that they should earn."""

    check: str
    responses: Responses
    expected_share: float


def _make_attempts(item: QuizItem) -> list[_Attempt]:
    """Return attempts at an item. The first is wrong, so that no solution may be shown after it."""
    form = item.form
    if isinstance(form, ChoiceForm):
        return _make_choice_attempts(form)
    if isinstance(form, MatchingForm):
        return _make_matching_attempts(form)
    return _make_number_attempts(form) if isinstance(form, NumberForm) else []


def _make_choice_attempts(form: ChoiceForm) -> list[_Attempt]:
    right = [LETTERS[k] for k, option in enumerate(form.options) if option.is_correct]
    wrong = [LETTERS[k] for k, option in enumerate(form.options) if not option.is_correct]
    if not form.allows_several:
        wrong_attempts = [_Attempt("wrong < full", {"RESPONSE": letter}, 0) for letter in wrong[:MAX_WRONG_ATTEMPTS]]
        return [
            *wrong_attempts,
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


def _make_matching_attempts(form: MatchingForm) -> list[_Attempt]:
    rotated = [*form.correct_indices[1:], form.correct_indices[0]]
    hits = sum(option == correct for option, correct in zip(rotated, form.correct_indices, strict=True))
    return [
        _Attempt(
            "wrong < full", {"RESPONSE": [f"S{k} T{index}" for k, index in enumerate(rotated)]}, hits / len(rotated)
        ),
        _Attempt("right = full", {"RESPONSE": [f"S{k} T{index}" for k, index in enumerate(form.correct_indices)]}, 1),
        _Attempt("blank = 0", {"RESPONSE": []}, 0),
    ]


def _make_number_attempts(form: NumberForm) -> list[_Attempt]:
    fields = form.fields
    attempts = []
    for number in range(MAX_WRONG_ATTEMPTS):
        values = [_make_wrong_number(field, number) for field in fields]
        attempts.append(_make_number_attempt("wrong < full", form, values))
    for digits in (".6g", ".10g"):
        attempts.append(
            _make_number_attempt("right = full", form, [float(f"{field.value:{digits}}") for field in fields])
        )
    zeros = [0.0 for _ in fields]
    if not all(field.is_zero for field in fields):
        attempts.append(_make_number_attempt("wrong < full", form, zeros))
    return [*attempts, _Attempt("blank = 0", {f"R{k}": None for k in range(1, len(fields) + 1)}, 0)]


def _make_wrong_number(field: NumberField, number: int) -> float:
    known = next(islice(field.wrong_values, number, None), None)
    return known.value if known is not None else field.value + (number + 1) * max(1.0, abs(field.value))


def _make_number_attempt(check: str, form: NumberForm, values: list[float]) -> _Attempt:
    is_right = [abs(value - field.value) <= field.tolerance for field, value in zip(form.fields, values, strict=True)]
    earns_points = list(map(form.earns_points, form.fields))
    earned_count = sum(right if earns else right - 1 for right, earns in zip(is_right, earns_points, strict=True))
    share = max(0.0, earned_count / form.correct_count)
    return _Attempt(check, {f"R{k}": value for k, value in enumerate(values, 1)}, share)


# --- results ---


def _check_package(software: Path, package: Path, request: ExportRequest, counts: Counts) -> None:
    items = list(make_items(request))
    attempts = [_make_attempts(item) for item in items]
    responses = [
        [item.key, [attempt.responses for attempt in item_attempts]]
        for item, item_attempts in zip(items, attempts, strict=True)
    ]
    command = ["php", "-d", "memory_limit=2G", str(SCRIPT), str(software), str(package)]
    done = subprocess.run(command, input=json.dumps(responses), capture_output=True, text=True, check=True)
    results = json.loads(done.stdout[done.stdout.index('{"items"') :])
    for item, item_attempts, result in zip(items, attempts, results["items"], strict=True):
        counts.add("imported", "error" not in result, f"{item.key}: {result.get('error')}")
        if "error" not in result:
            counts.add("shown", _is_shown(item, result["page"]), item.key)
            _check_attempts(item, item_attempts, result["attempts"], counts)
    _check_selection(results["tests"], items, request, counts)


def _is_shown(item: QuizItem, page: str) -> bool:
    if isinstance(item.form, NumberForm):
        return page.count("qti-textEntryInteraction") >= len(item.form.fields)
    names = {ChoiceForm: "choice", MatchingForm: "match", TextForm: "extendedText"}
    return f"qti-{names[type(item.form)]}Interaction" in page


def _check_attempts(item: QuizItem, attempts: list[_Attempt], results: list[dict[str, Any]], counts: Counts) -> None:
    for number, (attempt, result) in enumerate(zip(attempts, results, strict=True), 1):
        share, details = result["score"] / item.points, f"{item.key} {attempt.responses}: {result}"
        as_expected = {
            "right = full": share > 1 - TOLERANCE,
            "wrong < full": share < 1 - TOLERANCE,
            "blank = 0": share == 0,
        }
        counts.add(attempt.check, as_expected[attempt.check], details)
        counts.add(
            "scores as ours",
            abs(share - attempt.expected_share) < TOLERANCE,
            f"{details}, not {attempt.expected_share}",
        )
        is_done = number >= DEFAULT_ATTEMPTS or attempt.expected_share == 1
        counts.add("solution when done", ("solution" in result["feedback"]) == is_done, details)


def _check_selection(tests: Any, items: list[QuizItem], request: ExportRequest, counts: Counts) -> None:
    """Check that a test selects one variant for each slot, with all of its parts in order."""
    counts.add("test loaded", isinstance(tests, list), f"test: {tests}")
    for test in tests if isinstance(tests, list) else ():
        variants = list(dict.fromkeys("-".join(item.split("-")[:2]) for item in test["items"]))
        expected = [item.key for variant in variants for item in items if item.key.startswith(f"{variant}-")]
        slots = [variant.split("-")[0] for variant in variants]
        is_complete = slots == [slot.name for slot in request.assignment.slots] and test["items"] == expected
        counts.add("one variant a place", is_complete and test["attempts"] == DEFAULT_ATTEMPTS, f"{test}")
