"""Moodle: its own importers import our exports, and its question engine shows and marks the questions.

`MOODLE` is the folder of an installed copy with a running database. Each run adds a course and leaves it there.
moodle.php and moodle_feedback.php do the work inside Moodle.
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
from itertools import chain
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.common.input_file import format_csv
from qdot.exercises.exports.items import (
    ChoiceForm,
    MatchingForm,
    NumberField,
    NumberForm,
    QuizItem,
    group_items,
    make_items,
)
from qdot.exercises.exports.moodle import NONZERO_WEIGHT, ZERO_WEIGHT, export_moodle
from qdot.exercises.exports.platform_markup import format_decimal
from tests.platforms.assignments import EVERYTHING, PLAIN, make_request, write_files
from tests.platforms.records import Counts, Record, today
from tests.platforms.typed_answers import NUMBERS_READ_BY_MOODLE, write_numbers
from tests.support.submitting import make_class, make_correct_notebook, submit

Json = dict[str, Any]

PHP = ("php", "-d", "max_input_vars=5000")
QUIZ_SCRIPT, FEEDBACK_SCRIPT = (Path(__file__).with_name(name) for name in ("moodle.php", "moodle_feedback.php"))
VARIANTS = {PLAIN: 2, EVERYTHING: 1}
POINT, COMMA = "en", "de"
"""Languages with a decimal point (0.5) and with a decimal comma (0,5)."""


@dataclass(frozen=True)
class SampleAnswer:
    """An answer, the check as which it is counted, and the fraction of the points and the feedback that it should get.

    The fraction is None if a person has to mark the answer.
    """

    check: str
    fraction: float | None
    numbers: tuple[str, ...] = ()
    chosen_indices: tuple[int, ...] = ()
    options: tuple[str | None, ...] = ()
    text: str = ""
    feedback: str = ""
    language: str = POINT

    def make_request(self) -> Json:
        fields = {"numbers": self.numbers, "chosen": self.chosen_indices, "options": self.options, "text": self.text}
        return {**fields, "language": self.language}


def run(software: Path, work: Path) -> Record:
    """Import the ready-made set and the assignment with every question, answer all questions, and import marks."""
    counts = Counts()
    software_name = ""
    for kind, variants in VARIANTS.items():
        request = make_request(work / kind, kind, variants)
        items = list(chain.from_iterable(group_items(make_items(request), request.report).values()))
        bank, quiz = write_files(export_moodle(request), work)
        answers = {item.title: list(make_answers(item)) for item in items}
        answer_requests = {
            name: [answer.make_request() for answer in item_answers] for name, item_answers in answers.items()
        }
        response = call_moodle(software, xml=str(bank), quiz=str(quiz), answers=answer_requests)
        software_name = response["software"]
        for file_kind, check in (("xml", "bank"), ("quiz", "quiz")):
            if not response[file_kind]["done"] or response[file_kind]["messages"]:
                raise RuntimeError(f"{file_kind}: {response[file_kind]['messages']}")
            _check_questions(counts, check, items, response[file_kind], answers)
        _check_slots(counts, items, response["quiz"])
    _check_gradebook(counts, software, work / "graded")
    _check_handing_out_and_return(counts, software, work / "returned")
    return Record("moodle", software_name, today(), counts.freeze())


def call_moodle(software: Path, script: Path = QUIZ_SCRIPT, **request: object) -> Json:
    text = json.dumps({"config": str(software / "config.php"), **request})
    done = subprocess.run((*PHP, str(script)), input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr + done.stdout[-3000:])
    response: Json = json.JSONDecoder().raw_decode(done.stdout, done.stdout.index("{"))[0]  # Moodle may print more
    return response


# --- answers ---


def make_answers(item: QuizItem) -> Iterator[SampleAnswer]:
    """Yield answers to a question: right ones in several forms, each known wrong one, and a blank one."""
    form = item.form
    if isinstance(form, NumberForm):
        yield from _make_number_answers(form)
    elif isinstance(form, ChoiceForm):
        yield from _make_choice_answers(form)
    elif isinstance(form, MatchingForm):
        yield from _make_matching_answers(form)
    else:
        yield SampleAnswer("left to a person", None, text="By the chain rule.")


def _make_number_answers(form: NumberForm) -> Iterator[SampleAnswer]:
    fields = form.fields
    full, rounded = [format_decimal(field.value) for field in fields], [_format_rounded(field) for field in fields]
    comma = [number.replace(".", ",") for number in rounded]
    for numbers, language in (
        (rounded, POINT),
        (full, POINT),
        ([f"  {number} " for number in rounded], POINT),
        (comma, COMMA),
        (rounded, COMMA),
    ):
        yield SampleAnswer("right = full", 1.0, numbers=tuple(numbers), language=language)
    typed_numbers = [write_numbers(field.value) for field in fields]
    for typed_form in NUMBERS_READ_BY_MOODLE:
        yield SampleAnswer("right = full", 1.0, numbers=tuple(numbers[typed_form] for numbers in typed_numbers))
    weights = [ZERO_WEIGHT if round(field.value, 9) == 0 else NONZERO_WEIGHT for field in fields]
    for index, field in enumerate(fields):
        for wrong in field.wrong_values:
            numbers = [*rounded[:index], format_decimal(wrong.value), *rounded[index + 1 :]]
            fraction = 1 - weights[index] / sum(weights)
            yield SampleAnswer("wrong < full", fraction, numbers=tuple(numbers), feedback=wrong.feedback)
    yield SampleAnswer("blank = 0", 0.0, numbers=("",) * len(fields))


def _format_rounded(field: NumberField) -> str:
    """Return a number to three digits, as a student types it, or to all digits if it has no tolerance."""
    return format_decimal(field.value, 3) if field.tolerance else format_decimal(field.value)


def _make_choice_answers(form: ChoiceForm) -> Iterator[SampleAnswer]:
    right = tuple(index for index, option in enumerate(form.options) if option.is_correct)
    yield SampleAnswer("right = full", 1.0, chosen_indices=right)
    for index, option in enumerate(form.options):
        if not option.is_correct:
            yield SampleAnswer("wrong < full", 0.0, chosen_indices=(index,), feedback=option.feedback)
    yield SampleAnswer("blank = 0", 0.0)


def _make_matching_answers(form: MatchingForm) -> Iterator[SampleAnswer]:
    right = tuple(form.options[index] for index in form.correct_indices)
    wrong_option = next(option for option in form.options if option != right[0])
    yield SampleAnswer("right = full", 1.0, options=right)
    yield SampleAnswer("wrong < full", 1 - 1 / len(right), options=(wrong_option, *right[1:]))
    yield SampleAnswer("blank = 0", 0.0, options=(None,) * len(right))


# --- checks of the results ---


def _check_questions(
    counts: Counts, place: str, items: Sequence[QuizItem], imported: Json, answers: Mapping[str, Sequence[SampleAnswer]]
) -> None:
    """Check the imported questions of a place ("bank" or "quiz") and the results of all answers."""
    several_boxes = 0
    for item in items:
        name = item.title
        stored, results = imported["questions"].get(name), imported["answers"].get(name, [])
        counts.add("imported", stored is not None, f"{place}: {name}")
        if stored is None:
            continue
        points = float(stored["defaultmark"])
        as_assigned = abs(points - item.points) < 1e-6
        counts.add(f"points of the {place}", as_assigned, f"{name}: {points}, not {item.points}")
        several_boxes += not as_assigned and isinstance(item.form, NumberForm) and len(item.form.fields) > 1
        faults = find_faults(item, results[0]["blank"])
        counts.add("shown", not faults, f"{place}: {name}: {faults}")
        for answer, result in zip(answers[name], results, strict=True):
            earned = result["fraction"]
            if answer.fraction is None:
                as_expected = earned is None
            else:
                as_expected = abs(float(earned or 0) - answer.fraction) < 1e-4
            counts.add(answer.check, as_expected, f"{place}: {name}: {earned} for {answer}")
            if answer.feedback:
                is_shown = extract_text(answer.feedback) in extract_text(result["shown"])
                counts.add("mistake named", is_shown, f"{place}: {name}: {answer}")
    if place == "bank":
        reason = "the question bank gives each answer box one point. The quiz has the right points."
        counts.excuse("points of the bank", several_boxes, reason)


def _check_slots(counts: Counts, items: Sequence[QuizItem], quiz: Json) -> None:
    """Check the slots of a quiz: their number, order and points, and the questions chosen in an attempt."""
    expected_items = list({item.category: item for item in items}.values())
    counts.add("slots of the quiz", len(quiz["slots"]) == len(expected_items), f"{len(quiz['slots'])} slots")
    for slot, item in zip(quiz["slots"], expected_items, strict=True):
        same = (slot["category"], float(slot["points"])) == (item.category.path[-1], item.points)
        counts.add("slots of the quiz", same, f"{slot} for {item.title}")
    total = sum(item.points for item in expected_items)
    totals = {float(quiz["highest"]), float(quiz["quiz"]["grade"]), float(quiz["quiz"]["sumgrades"])}
    counts.add("slots of the quiz", totals == {total}, f"{totals}, not {total}")


def extract_text(page: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", html.unescape(html.unescape(page))).split())


def find_faults(item: QuizItem, page: str) -> list[str]:
    """Return the faults in a question's page: unprocessed markup, missing figures, wrong input boxes."""
    form = item.form
    text_boxes = re.findall(r'<input type="text"[^>]*>', page)
    sizes = {int(size) for box in text_boxes for size in re.findall(r'size="(\d+)"', box)}
    faults = [
        f"unprocessed: {markup}" for markup in ("@@PLUGINFILE@@", ":NUMERICAL:", "]]>", "<table>") if markup in page
    ]
    faults += [f"no figure {name}" for name in ("arm.svg",) if name not in page]
    if isinstance(form, NumberForm):
        faults += [f"{len(text_boxes)} boxes"] if len(text_boxes) != len(form.fields) else []
        faults += [f"boxes of {sizes}"] if sizes and max(sizes) > 1.15 * min(sizes) else []
    elif isinstance(form, MatchingForm):
        faults += [] if page.count("<select") == len(form.stems) else ["stems"]
    return faults


# --- marks ---


def _check_gradebook(counts: Counts, software: Path, folder: Path) -> None:
    students = [Student(name, name.title(), f"{name}@marks.example.org") for name in ("ada", "henri", "sofja")]
    assignment = make_class(folder, students)
    submit(assignment, "ada.ipynb", make_correct_notebook(assignment, "ada"))
    submit(assignment, "henri.ipynb", make_correct_notebook(assignment, "henri", lambda cells: cells.pop()))
    book = folder / "moodle.csv"
    _run_qdot("grade", folder, folder / "submitted", "--report", f"moodle={book}")
    rows = list(csv.DictReader(io.StringIO(book.read_text(encoding="utf-8"))))
    (column,) = [name for name in rows[0] if name.endswith("(percent)")]
    student_rows = [{"id": student.id, "name": student.name, "email": student.email} for student in students]
    gradebook = call_moodle(software, gradebook=str(book), students=student_rows)["gradebook"]
    if not gradebook["done"]:
        raise RuntimeError(str(gradebook["messages"]))
    for row in rows:
        mark = gradebook["grades"].get(row["Email address"])
        same = mark is None if row[column] == "-" else mark is not None and abs(float(mark) - float(row[column])) < 1e-3
        counts.add("marks in its gradebook", same, f"{row} {mark}")


NAMES_IN_MOODLE = ("Ada Lovelace", "Wei Li", "Wei Li", "Zoë Núñez O'Brien", "Jean_Luc Dupont-Martin")
"""Two equal names, and names with accents, an apostrophe, an underscore and a hyphen."""


def _check_handing_out_and_return(counts: Counts, software: Path, folder: Path) -> None:
    """Hand out notebooks as feedback files; then submit them, grade Moodle's download, and return the pages."""
    students = [Student(f"s{number}", name, f"s{number}@example.org") for number, name in enumerate(NAMES_IN_MOODLE)]
    assignment = make_class(folder, students)
    _run_qdot("generate", folder)
    people = [{"id": s.id, "name": s.name, "email": s.email, "notebook": ""} for s in students]
    course = call_moodle(software, FEEDBACK_SCRIPT, students=people, download="")
    rows = [[f"Participant {course['numbers'][s.email]}", s.name, s.email, "No submission"] for s in students]
    worksheet = folder / "worksheet.csv"
    worksheet.write_text(format_csv([["Identifier", "Full name", "Email address", "Status"], *rows]), encoding="utf-8")
    _run_qdot("release", folder, worksheet, "--to", "moodle")
    notebooks_zip = folder / "handout" / "moodle" / "moodle-notebooks.zip"
    uploaded = call_moodle(software, FEEDBACK_SCRIPT, module=course["module"], feedback=str(notebooks_zip))
    for student in students:
        notebook = (folder / "released" / student.id / "hw.ipynb").read_text(encoding="utf-8")
        files = uploaded["feedback"].get(student.email, {})
        counts.add("notebooks handed out", files == {"hw.ipynb": notebook}, f"{student.id} {[*files]}")

    for person, student in zip(people, students, strict=True):
        person["notebook"] = str(
            submit(assignment, f"{student.id}.ipynb", make_correct_notebook(assignment, student.id))
        )
    download = folder / "download.zip"
    course = call_moodle(software, FEEDBACK_SCRIPT, students=people, download=str(download))
    lines = [f"{s.id},{s.name},{s.email},{course['numbers'][s.email]}" for s in students]
    (folder / "roster.csv").write_text("\n".join(("student,name,email,moodle id", *lines)) + "\n", encoding="utf-8")
    _run_qdot("grade", folder, download)
    _run_qdot("return", folder, download, "--to", "moodle")
    pages_zip = folder / "returned" / "moodle" / "moodle-feedback.zip"
    uploaded = call_moodle(software, FEEDBACK_SCRIPT, module=course["module"], feedback=str(pages_zip))
    for student in students:
        page = (folder / "graded" / "feedback" / f"{student.id}.html").read_text(encoding="utf-8")
        files = uploaded["feedback"].get(student.email, {})
        counts.add("feedback pages returned", files == {"hw-feedback.html": page}, f"{student.id} {[*files]}")


def _run_qdot(*arguments: str | Path) -> None:
    subprocess.run((str(Path(sys.executable).with_name("qdot")), *map(str, arguments)), check=True, capture_output=True)
