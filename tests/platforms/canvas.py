"""The converter through which Canvas imports QTI 1.2 into classic quizzes: it keeps right answers and comments.

`software` is its folder; it runs with the Python of `.venvs/readers`, which has lxml.
"""

import html
import re
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberForm, QuizItem, TextForm, make_items
from qdot.exercises.exports.platform_markup import find_pictures, format_decimal, format_limits, name_picture_file
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.typed_numbers import list_accepted_texts
from qdot.exercises.reference_answers import LETTERS
from tests.platforms.assignments import EVERYTHING, PLAIN, make_request, write_files
from tests.platforms.records import Counts, Record, describe_checkout, today

PYTHON = Path(__file__).parents[2] / ".venvs/readers/bin/python"
OPTIONS = ("--ucvars", "--nogui", "--overwrite")
"""Options with which Canvas calls the converter."""
EXPECTED_WARNINGS = re.compile(
    r"Warning: var[gl]te not supported on String|Warning: CP Directory"
    r"|Unsupported element <(quiz|metadata|organizations|dependency)>"
)
"""Warnings about every package, even Canvas's own exports. They concern the bounds of numbers (Canvas takes them from
the operators in the converted item), Canvas's own file about the quiz, and elements of the manifest."""


def run(software: Path, work: Path) -> Record:
    """Export everything once, and the default set in three variants."""
    counts = Counts()
    for kind, variants in ((EVERYTHING, 1), (PLAIN, 3)):
        request = make_request(work / kind, kind, variants)
        archive, _ = write_files(EXPORT_FORMATS["canvas"].export(request), work / f"{kind}-exported")
        converted = work / f"{kind}-converted"
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(work / f"{kind}-package")
        command = [PYTHON, software / "migrate.py", *OPTIONS, f"--cpout={converted}", work / f"{kind}-package"]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        messages = [line for line in done.stdout.splitlines() if re.match("Warning|Unsupported|Error|Problem", line)]
        for line in messages or [""]:
            counts.add("no other warnings", not line or EXPECTED_WARNINGS.match(line) is not None, line)
        for item in make_items(request):
            _check_item(item, f"{request.assignment.key}-{item.key}", converted, counts)
    return Record(
        "canvas", f"Instructure's QTIMigrationTool of {describe_checkout(software)}", today(), counts.freeze()
    )


def _check_item(item: QuizItem, ident: str, converted: Path, counts: Counts) -> None:
    path = converted / "assessmentItems" / f"{ident}.xml"
    counts.add("imported", path.exists(), ident)
    if path.exists():
        body = path.read_text(encoding="utf-8")
        converted_item = ElementTree.fromstring(body)
        converted_answers, right_answers = _find_scored_answers(converted_item), _list_right_answers(item, ident)
        same = converted_answers == right_answers
        counts.add("answers kept", same, f"{ident}: {converted_answers}, not {right_answers}")
        names = {name_picture_file(picture) for picture in find_pictures(item.body)}
        counts.add("figures kept", all(name in body for name in names), ident)
        if isinstance(item.form, ChoiceForm):
            comments = {f"{ident}-{letter}_fb": option.feedback for letter, _, option in item.form.lettered_options}
            expected_comments = {name: feedback for name, feedback in comments.items() if feedback}
            counts.add("comments kept", _find_comments(converted_item) == expected_comments, ident)
        if isinstance(item.form, NumberForm) and len(item.form.fields) > 1:
            expected_texts = [list_accepted_texts(field.value, field.tolerance) for field in item.form.fields]
            counts.add("blanks kept", _find_blanks(converted_item) == expected_texts, ident)


def _list_right_answers(item: QuizItem, ident: str) -> list[str]:
    """Return the right answers as the package names them: options, pairs, blanks, or a number and its bounds."""
    form = item.form
    if isinstance(form, ChoiceForm):
        return [f"{ident}-{LETTERS[k]}" for k, option in enumerate(form.options) if option.is_correct]
    if isinstance(form, MatchingForm):
        return [f"response_{ident}-{LETTERS[k]} {ident}-o{index}" for k, index in enumerate(form.correct_indices)]
    if isinstance(form, TextForm):
        return []
    if len(form.fields) > 1:
        return [f"response_n{number} {ident}-n{number}-1" for number in range(1, len(form.fields) + 1)]
    (field,) = form.fields
    return [format_decimal(field.value), *format_limits(field.value, field.tolerance)]


def _find_comments(item: ElementTree.Element) -> dict[str, str]:
    """Return the comments on answers in a converted item, by identifier, without the comment on the question."""
    elements = [element for element in item.iter() if _get_tag(element) == "modalFeedback"]
    texts = {str(element.get("identifier")): "".join(element.itertext()).strip() for element in elements}
    return {name: html.unescape(text) for name, text in texts.items() if name != "general_fb"}


def _find_blanks(item: ElementTree.Element) -> list[tuple[str, ...]]:
    question = "".join(
        text for element in item.iter() if _get_tag(element) == "itemBody" for text in element.itertext()
    )
    blanks = []
    for interaction in (element for element in item.iter() if _get_tag(element) == "choiceInteraction"):
        name = str(interaction.get("responseIdentifier")).removeprefix("response_")
        choices = [element for element in interaction if _get_tag(element) == "simpleChoice"]
        if f"[{name}]" in question:
            blanks.append(tuple("".join(choice.itertext()).strip() for choice in choices))
    return blanks


def _find_scored_answers(item: ElementTree.Element) -> list[str]:
    answers = []
    for branch in (element for element in item.iter() if _get_tag(element) in ("responseIf", "responseElseIf")):
        condition, *outcomes = list(branch)
        if not any(outcome.get("identifier") == "SCORE" for outcome in outcomes) or _get_tag(condition) == "gt":
            continue
        values = _list_values(condition)
        variable = next(element for element in condition.iter() if _get_tag(element) == "variable")
        response = str(variable.get("identifier"))
        answers += values if response == "response1" else [f"{response} {value}" for value in values]
    return answers


def _list_values(condition: ElementTree.Element) -> list[str]:
    if _get_tag(condition) == "not":
        return []
    if _get_tag(condition) == "baseValue":
        return [str(condition.text)]
    return [value for child in condition for value in _list_values(child)]


def _get_tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]
