"""Moodle: what we export is imported by its own importers, shown and marked by its own question engine.

`MOODLE` is the folder of an installed copy, whose database runs. A course is made in it for each run, and stays.
What PHP does of it is in moodle.php.
"""

import csv
import html
import io
import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.exports.export_format import ExportedFile
from qdot.exercises.exports.items import ChoiceForm, MatchingForm, NumberField, NumberForm, QuizItem, make_items
from qdot.exercises.exports.moodle import NONZERO_WEIGHT, ZERO_WEIGHT, export_moodle
from qdot.exercises.exports.platform_markup import format_decimal
from tests.platforms.given import EVERYTHING, PLAIN, order
from tests.platforms.records import Counts, Record, today
from tests.support.submitting import make_class, make_correct_notebook, submit

Json = dict[str, Any]

PHP = ("php", "-d", "max_input_vars=5000", str(Path(__file__).with_suffix(".php")))
VARIANTS = {PLAIN: 2, EVERYTHING: 1}
POINT, COMMA = "en", "de"
"""Languages of which one writes 0.5 and the other 0,5."""


@dataclass(frozen=True)
class Try:
    """An answer, what it is to earn, what is to be said of it, and under which name it is counted."""

    counted: str
    fraction: float | None
    numbers: tuple[str, ...] = ()
    chosen: tuple[int, ...] = ()
    options: tuple[str | None, ...] = ()
    text: str = ""
    advice: str = ""
    language: str = POINT

    def request(self) -> Json:
        """Return it as moodle.php reads it."""
        sent = {"numbers": self.numbers, "chosen": self.chosen, "options": self.options, "text": self.text}
        return {**sent, "language": self.language}


def run(software: Path, work: Path) -> Record:
    """Import the ready-made set and one of every question, answer all of it, and import marks."""
    counts = Counts()
    software_name = ""
    for which, variants in VARIANTS.items():
        one = order(work / which, which, variants)
        asked = list(make_items(one))
        bank, quiz = [_written(work, file) for file in export_moodle(one)]
        tries = {item.title: list(tries_of(item)) for item in asked}
        requests = {name: [one.request() for one in given] for name, given in tries.items()}
        answer = ask(software, xml=str(bank), quiz=str(quiz), tries=requests)
        software_name = answer["software"]
        for form, what in (("xml", "bank"), ("quiz", "quiz")):
            if not answer[form]["done"] or answer[form]["said"]:
                raise RuntimeError(f"{form}: {answer[form]['said']}")
            _see(counts, what, asked, answer[form], tries)
        _see_quiz(counts, asked, answer["quiz"])
    _gradebook(counts, software, work / "graded")
    return Record("moodle", software_name, today(), counts.told())


def _written(work: Path, file: ExportedFile) -> Path:
    path = work / file.path
    path.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
    return path


def ask(software: Path, **request: object) -> Json:
    """Return what Moodle made of a request."""
    given = json.dumps({"config": str(software / "config.php"), **request})
    done = subprocess.run(PHP, input=given, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    answer: Json = json.loads(done.stdout[done.stdout.index("{") :])
    return answer


# --- what is answered ---


def tries_of(item: QuizItem) -> Iterator[Try]:
    """Yield answers to a question: right ones in several forms, each wrong one that we know of, and none."""
    form = item.form
    if isinstance(form, NumberForm):
        yield from _in_numbers(form)
    elif isinstance(form, ChoiceForm):
        yield from _chosen(form)
    elif isinstance(form, MatchingForm):
        yield from _matched(form)
    else:
        yield Try("left to a person", None, text="By the chain rule.")


def _in_numbers(form: NumberForm) -> Iterator[Try]:
    fields = form.fields
    full, short = [format_decimal(field.value) for field in fields], [_rounded(field) for field in fields]
    comma = [number.replace(".", ",") for number in short]
    for numbers, language in (
        (short, POINT),
        (full, POINT),
        ([f"  {number} " for number in short], POINT),
        (comma, COMMA),
        (short, COMMA),
    ):
        yield Try("right = full", 1.0, numbers=tuple(numbers), language=language)
    weights = [ZERO_WEIGHT if round(field.value, 9) == 0 else NONZERO_WEIGHT for field in fields]
    for index, field in enumerate(fields):
        for wrong in field.wrong_values:
            numbers = [*short[:index], format_decimal(wrong.value), *short[index + 1 :]]
            earned = 1 - weights[index] / sum(weights)
            yield Try("wrong < full", earned, numbers=tuple(numbers), advice=wrong.feedback)
    yield Try("blank = 0", 0.0, numbers=("",) * len(fields))


def _rounded(field: NumberField) -> str:
    """Return a number as a student types it, to three digits."""
    return format_decimal(field.value, 3) if field.tolerance else format_decimal(field.value)


def _chosen(form: ChoiceForm) -> Iterator[Try]:
    right = tuple(index for index, option in enumerate(form.options) if option.is_correct)
    yield Try("right = full", 1.0, chosen=right)
    for index, option in enumerate(form.options):
        if not option.is_correct:
            yield Try("wrong < full", 0.0, chosen=(index,), advice=option.feedback)
    yield Try("blank = 0", 0.0)


def _matched(form: MatchingForm) -> Iterator[Try]:
    right = tuple(form.options[index] for index in form.correct_options)
    other = next(option for option in form.options if option != right[0])
    yield Try("right = full", 1.0, options=right)
    yield Try("wrong < full", 1 - 1 / len(right), options=(other, *right[1:]))
    yield Try("blank = 0", 0.0, options=(None,) * len(right))


# --- what came of it ---


def _see(counts: Counts, what: str, asked: Sequence[QuizItem], made: Json, tries: Mapping[str, Sequence[Try]]) -> None:
    """Count what became of the questions of a `bank`, or of those of a `quiz`."""
    boxes = 0
    for item in asked:
        name = item.title
        stored, results = made["questions"].get(name), made["tries"].get(name, [])
        counts.add("imported", stored is not None, f"{what}: {name}")
        if stored is None:
            continue
        there = float(stored["defaultmark"])
        as_assigned = abs(there - item.points) < 1e-6
        counts.add(f"points of the {what}", as_assigned, f"{name}: {there}, not {item.points}")
        boxes += not as_assigned and isinstance(item.form, NumberForm) and len(item.form.fields) > 1
        faults = faults_of(item, results[0]["blank"])
        counts.add("shown", not faults, f"{what}: {name}: {faults}")
        for one, result in zip(tries[name], results, strict=True):
            earned = result["fraction"]
            if one.fraction is None:
                counts.add(one.counted, earned is None, f"{what}: {name}: {earned} for {one}")
            else:
                is_as_expected = abs(float(earned or 0) - one.fraction) < 1e-4
                counts.add(one.counted, is_as_expected, f"{what}: {name}: {earned} for {one}")
            if one.advice:
                counts.add("mistake named", plain(one.advice) in plain(result["shown"]), f"{what}: {name}: {one}")
    if what == "bank":
        why = "the bank gives every box one point; the quiz sets the right points."
        counts.excuse("points of the bank", boxes, why)


def _see_quiz(counts: Counts, asked: Sequence[QuizItem], made: Json) -> None:
    """Count the slots of a quiz: their order, points, and what was drawn."""
    wanted = list({item.category: item for item in asked}.values())
    counts.add("slots of the quiz", len(made["slots"]) == len(wanted), f"{len(made['slots'])} slots")
    for slot, item in zip(made["slots"], wanted, strict=True):
        same = (slot["category"], float(slot["points"])) == (item.category[-1], item.points)
        counts.add("slots of the quiz", same, f"{slot} for {item.title}")
    whole = sum(item.points for item in wanted)
    told = {float(made["highest"]), float(made["quiz"]["grade"]), float(made["quiz"]["sumgrades"])}
    counts.add("slots of the quiz", told == {whole}, f"{told}, not {whole}")


def plain(page: str) -> str:
    """Return the words of HTML that may be quoted in attributes of HTML, too."""
    return " ".join(re.sub(r"<[^>]*>", " ", html.unescape(html.unescape(page))).split())


def faults_of(item: QuizItem, page: str) -> list[str]:
    """Return what a student would not see as we wrote it."""
    form = item.form
    text_boxes = re.findall(r'<input type="text"[^>]*>', page)
    sizes = {int(size) for box in text_boxes for size in re.findall(r'size="(\d+)"', box)}
    faults = [f"left: {sign}" for sign in ("@@PLUGINFILE@@", ":NUMERICAL:", "]]>", "<table>") if sign in page]
    faults += [f"no figure {name}" for name in ("arm.svg",) if name not in page]
    if isinstance(form, NumberForm):
        faults += [f"{len(text_boxes)} boxes"] if len(text_boxes) != len(form.fields) else []
        faults += [f"boxes of {sizes}"] if sizes and max(sizes) > 1.15 * min(sizes) else []
    elif isinstance(form, MatchingForm):
        faults += [] if page.count("<select") == len(form.stems) else ["stems"]
    return faults


# --- marks ---


def _gradebook(counts: Counts, software: Path, folder: Path) -> None:
    """Import the marks of a class of three; one student submits nothing."""
    students = [Student(name, name.title(), f"{name}@example.org") for name in ("ada", "henri", "sofja")]
    assignment = make_class(folder, students)
    submit(assignment, "ada.ipynb", make_correct_notebook(assignment, "ada"))
    submit(assignment, "henri.ipynb", make_correct_notebook(assignment, "henri", lambda cells: cells.pop()))
    book = folder / "moodle.csv"
    command = [
        str(Path(sys.executable).with_name("qdot")),
        "grade",
        str(folder),
        str(folder / "submitted"),
        "--report",
        f"moodle={book}",
    ]
    subprocess.run(command, check=False, capture_output=True)
    rows = list(csv.DictReader(io.StringIO(book.read_text(encoding="utf-8"))))
    (column,) = [name for name in rows[0] if name.endswith("(percent)")]
    people = [{"id": one.id, "name": one.name, "email": one.email} for one in students]
    answer = ask(software, gradebook=str(book), students=people)["gradebook"]
    if not answer["done"]:
        raise RuntimeError(str(answer["said"]))
    for row in rows:
        there = answer["grades"].get(row["Email address"])
        same = (
            there is None if row[column] == "-" else there is not None and abs(float(there) - float(row[column])) < 1e-3
        )
        counts.add("marks in its gradebook", same, f"{row} {there}")
