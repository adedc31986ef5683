"""Instructure's importer of QTI, through which New Quizzes imports: it keeps questions, right answers and comments.

`software` is a copy of its Ruby gem `qti`. Ruby needs activesupport, actionview, nokogiri, sanitize and rubyzip;
new_quizzes.rb does the work, and stands in for two gems of which the gem needs nothing to import.
"""

import json
import re
import subprocess
import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberField, NumberForm, QuizItem, make_items
from qdot.exercises.exports.platform_markup import format_decimal
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.reference_answers import LETTERS
from tests.platforms.assignments import EVERYTHING, PLAIN, make_request, write_files
from tests.platforms.records import Counts, Record, describe_checkout, today

SCRIPT = Path(__file__).with_name("new_quizzes.rb")
WRONG_FACTORS = (-1.0, 0.9, 1.1, 10.0)


def run(software: Path, work: Path) -> Record:
    """Import every question once, and the default set in two variants."""
    counts = Counts()
    for kind, variants in ((EVERYTHING, 1), (PLAIN, 2)):
        request = make_request(work / kind, kind, variants)
        _, archive = write_files(EXPORT_FORMATS["canvas"].export(request), work / f"{kind}-exported")
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(work / f"{kind}-package")
        command = ["ruby", "-I", software / "lib", SCRIPT, work / f"{kind}-package"]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True)
        imported = {question["ident"]: question for question in json.loads(done.stdout)}
        for item in make_items(request):
            ident = f"{request.assignment.key}-{item.key}"
            counts.add(
                "imported", ident in imported and not imported[ident].get("error"), f"{ident}: {done.stderr[:200]}"
            )
            if ident in imported and not imported[ident].get("error"):
                _check_question(item, ident, imported[ident], counts)
    name = f"Instructure's `qti` gem of {describe_checkout(software)}, for New Quizzes"
    return Record("canvas", name, today(), counts.freeze())


def _check_question(item: QuizItem, ident: str, question: dict[str, Any], counts: Counts) -> None:
    form, answers = item.form, question["answers"]
    counts.add("points kept", float(question["points"]) == item.points, ident)
    counts.add("one variant per student", question["pick_count"] == 1, ident)
    if isinstance(form, ChoiceForm):
        right_answers = [f"{ident}-{LETTERS[k]}" for k, option in enumerate(form.options) if option.is_correct]
        counts.add("answers kept", [answer["values"] for answer in answers] == right_answers, f"{ident}: {answers}")
        comments = [option.feedback for option in form.options if option.feedback]
        counts.add("comments kept", question["comments"] == comments, f"{ident}: {question['comments']}")
    elif isinstance(form, MatchingForm):
        right_answers = [form.options[index] for index in form.correct_indices]
        counts.add("answers kept", list(answers[0]["values"].values()) == right_answers, f"{ident}: {answers}")
    elif isinstance(form, NumberForm) and len(form.fields) > 1:
        counts.add("blanks kept", question["blanks"] == [f"response_n{k + 1}" for k in range(len(form.fields))], ident)
        for field, answer in zip(form.fields, answers, strict=True):
            counts.add("compared by pattern", answer["scoring_algorithm"] == "TextRegex", ident)
            _check_pattern(field, re.compile(answer["values"]), ident, counts)
    elif isinstance(form, NumberForm):
        (field,), (answer,) = form.fields, answers
        value, margin = Fraction(answer["value"]), float(answer.get("margin", 0))
        kept = (
            value == Fraction(format_decimal(field.value)) and abs(margin - field.tolerance) <= 0.01 * field.tolerance
        )
        counts.add("answers kept", kept, f"{ident}: {answer}")


def _check_pattern(field: NumberField, pattern: re.Pattern[str], ident: str, counts: Counts) -> None:
    """Check that a pattern accepts the value with more or fewer digits, and none of the wrong values."""
    for digits in (3, 6, 10):
        text = format_decimal(field.value, digits)
        if abs(Fraction(text) - Fraction(str(field.value))) <= Fraction(str(0.9 * field.tolerance)):
            counts.add("right accepted", pattern.search(text) is not None, f"{ident}: {text}: {pattern.pattern}")
    wrong_values = [wrong.value for wrong in field.wrong_values] + [factor * field.value for factor in WRONG_FACTORS]
    for wrong_value in wrong_values:
        if abs(wrong_value - field.value) > 1.01 * field.tolerance:
            text = format_decimal(wrong_value, 8)
            counts.add("wrong refused", pattern.search(text) is None, f"{ident}: {text}: {pattern.pattern}")
