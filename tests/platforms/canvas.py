"""The converter through which Canvas imports QTI 1.2: every item converted, and right answers as we gave them.

`software` is its folder; Python finds lxml where `.venvs/readers` has it.
"""

import re
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberForm, QuizItem, make_items
from qdot.exercises.exports.platform_markup import find_pictures, format_decimal, format_limits, name_picture_file
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.reference_answers import LETTERS
from tests.platforms.given import EVERYTHING, PLAIN, order
from tests.platforms.records import Counts, Record, today

PYTHON = Path(__file__).parents[2] / ".venvs/readers/bin/python"
CALLED = ("--ucvars", "--nogui", "--overwrite")
"""How Canvas calls the converter."""
EXPECTED = re.compile(
    r"Warning: var[gl]te not supported on String|Warning: CP Directory"
    r"|Unsupported element <(quiz|metadata|organizations|dependency)>"
)
"""What is said of every package that Canvas is given, its own exports, too: of bounds, which it reads out of the
operators that the converter makes of them, of its own file about the quiz, and of what a manifest holds."""


def run(software: Path, work: Path) -> Record:
    """Export everything once, and the default set in three variants."""
    counts = Counts()
    for which, variants in ((EVERYTHING, 1), (PLAIN, 3)):
        made = order(work / which, which, variants)
        (file,) = EXPORT_FORMATS["canvas"].export(made)
        archive, converted = work / f"{which}.zip", work / f"{which}-converted"
        archive.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(work / f"{which}-package")
        command = [PYTHON, software / "migrate.py", *CALLED, f"--cpout={converted}", work / f"{which}-package"]
        done = subprocess.run([str(each) for each in command], capture_output=True, text=True)
        said = [line for line in done.stdout.splitlines() if re.match("Warning|Unsupported|Error|Problem", line)]
        for line in said or [""]:
            counts.add("no other warnings", not line or EXPECTED.match(line) is not None, line)
        for one in make_items(made):
            _hold(one, f"{made.assignment.key}-{one.key}", converted, counts)
    told = subprocess.run(["git", "-C", software, "log", "-1", "--format=%cs (%h)"], capture_output=True, text=True)
    return Record("canvas", f"Instructure's QTIMigrationTool of {told.stdout.strip()}", today(), counts.told())


def _hold(whole: QuizItem, ident: str, converted: Path, counts: Counts) -> None:
    path, one = converted / "assessmentItems" / f"{ident}.xml", whole.single_number_item or whole
    counts.add("imported", path.exists(), ident)
    if path.exists():
        item = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        counts.add("answers kept", _right(item) == _due(one, ident), f"{ident}: {_right(item)}, not {_due(one, ident)}")
        body = path.read_text(encoding="utf-8")
        drawn = {name_picture_file(picture) for picture in find_pictures(one.body)}
        counts.add("figures kept", all(name in body for name in drawn), ident)


def _due(one: QuizItem, ident: str) -> list[str]:
    """Return right answers as they are named in the package: options, pairs, a number and its bounds."""
    form = one.form
    if isinstance(form, ChoiceForm):
        return [f"{ident}-{LETTERS[k]}" for k, option in enumerate(form.options) if option.is_correct]
    if isinstance(form, MatchingForm):
        return [f"response_{ident}-{LETTERS[k]} {ident}-o{index}" for k, index in enumerate(form.correct_options)]
    assert isinstance(form, NumberForm)
    (field,) = form.fields
    return [format_decimal(field.value), *format_limits(field.value, field.tolerance)]


def _right(item: ElementTree.Element) -> list[str]:
    """Return what earns points in a converted item."""
    found = []
    for branch in (each for each in item.iter() if _tag(each) in ("responseIf", "responseElseIf")):
        condition, *outcomes = list(branch)
        if not any(each.get("identifier") == "SCORE" for each in outcomes) or _tag(condition) == "gt":
            continue
        values, asked = _values(condition), next(each for each in condition.iter() if _tag(each) == "variable")
        response = str(asked.get("identifier"))
        found += values if response == "response1" else [f"{response} {value}" for value in values]
    return found


def _values(condition: ElementTree.Element) -> list[str]:
    """Return the values that a condition asks for, without those that it excludes."""
    if _tag(condition) == "not":
        return []
    if _tag(condition) == "baseValue":
        return [str(condition.text)]
    return [value for each in condition for value in _values(each)]


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]
