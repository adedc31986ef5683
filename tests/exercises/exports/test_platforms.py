"""Exports for learning platforms: held against the platforms' rules, and read by programs that read them there.

The readers are in an environment of their own (`make .venvs/readers/.installed`); where they aren't, tests say so.
With QDOT_QTI=FILE, the schema imsqti_v2p1.xsd with what it imports beside it (as in a checkout of TAO's
extension-tao-itemqti), packages are validated against it; no registry has it.
"""

import base64
import hashlib
import html
import io
import json
import os
import re
import subprocess
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.exports import canvas, moodle, qti
from qdot.exercises.exports import items as made
from qdot.exercises.exports.export_format import DEFAULT_ATTEMPTS, ExportRequest
from qdot.exercises.exports.items import (
    ChoiceForm,
    ItemCategory,
    MatchingForm,
    NumberForm,
    QuizItem,
    QuizOption,
    WrongValue,
    make_items,
)
from qdot.exercises.reference_answers import LETTERS
from tests.exercises.exports.test_items import an_order
from tests.support.programs import require_reader

TOML = """title = "Arms & <signs> / more"
key = "hw"
hints = true
feedback = "solutions"
problem = [
    {family = "planar-2r", questions = ["jacobian", "determinant", "joint-effect"]},
    {family = "planar-2r", questions = ["dependence", "true-or-false"]},
]
"""
Element = ElementTree.Element
Package = dict[str, bytes]
parsed = ElementTree.fromstring


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    return an_order(tmp_path_factory.mktemp("platforms"), TOML, 2)


@pytest.fixture(scope="module")
def asked(order: ExportRequest) -> list[QuizItem]:
    """The assignment's items, and one of columns to match, which takes long to draw."""
    made = list(make_items(order))
    form = MatchingForm(
        (r"$\begin{bmatrix} a_{1} \\ 0 \end{bmatrix}$", "$b < c$"), ("joint 1", "joint 2", "no joint"), (1, 2)
    )
    one = replace(
        made[0],
        key="p3-001-match",
        category=ItemCategory("T", "p3", "Match"),
        form=form,
        single_number_item=None,
        title="Match",
    )
    nasty = QuizOption(r"$a < b$ & c", False, 'Say } # ~ / \\ " <b> & {1:NUMERICAL:=1}')
    several = replace(
        one,
        key="p4-001-nasty",
        category=ItemCategory("T", "p4", "Nasty"),
        form=ChoiceForm((nasty, QuizOption("$c$", True))),
    )
    return [*made, one, several]


def files_of(
    export_format: Callable[[ExportRequest], Iterator[Any]], order: ExportRequest, asked: list[QuizItem]
) -> dict[str, Any]:
    """Return what an export format writes for these items: the contents of its files by their names."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(made, "make_items", lambda _: iter(asked))
        files = list(export_format(order))
    assert all(file.is_private for file in files)  # what is right is in them
    return {file.path: file.content for file in files}


def unzipped(content: bytes) -> Package:
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        return {name: package.read(name) for name in package.namelist()}


@pytest.fixture(scope="module")
def moodles(order: ExportRequest, asked: list[QuizItem]) -> dict[str, Any]:
    return files_of(moodle.export_moodle, order, asked)


@pytest.fixture(scope="module")
def bank(moodles: dict[str, Any]) -> Element:
    """Moodle's question bank."""
    return parsed(moodles["hw.xml"])


@pytest.fixture(scope="module")
def backup(moodles: dict[str, Any]) -> Package:
    """Moodle's quiz."""
    return unzipped(moodles["hw.mbz"])


@pytest.fixture(scope="module")
def canvass(order: ExportRequest, asked: list[QuizItem]) -> Package:
    return unzipped(files_of(canvas.export_canvas, order, asked)["hw.zip"])


@pytest.fixture(scope="module")
def qti_file(order: ExportRequest, asked: list[QuizItem]) -> bytes:
    content: bytes = files_of(qti.export_qti, order, asked)["hw.zip"]
    return content


def local(root: Element, tag: str) -> list[Element]:
    return [element for element in root.iter() if element.tag.rpartition("}")[2] == tag]


@pytest.mark.parametrize("level", FEEDBACK)
def test_platforms_tell_as_much_as_the_assignment_does(order: ExportRequest, level: str) -> None:
    """Mistakes, values and solutions from their levels on; solutions also where they are ordered."""
    at = FEEDBACK.index(level)
    told = replace(order, assignment=replace(order.assignment, feedback=level))
    asked = list(make_items(told))
    forms = [one.form for one in asked]
    wrong = [option.feedback for form in forms if isinstance(form, ChoiceForm) for option in form.options]
    fields = [field for form in forms if isinstance(form, NumberForm) for field in form.fields]
    wrong += [each.feedback for field in fields for each in field.wrong_values]
    assert any(wrong) == (at >= FEEDBACK.index("mistake"))

    quiz, ordered_quiz = (
        unzipped(files_of(moodle.export_moodle, given, asked)["hw.mbz"])
        for given in (told, replace(told, has_solutions=True))
    )
    settings = parsed(quiz["activities/quiz_1/quiz.xml"])
    assert ordered_quiz == quiz  # its settings are the teacher's
    values, solutions = (settings.findtext(f"quiz/review{name}") for name in ("rightanswer", "generalfeedback"))
    after, closed = str(0x01110), str(0x00010)
    assert values == (after if at >= FEEDBACK.index("values") else closed)
    assert solutions == (after if level == "solutions" else closed)

    for ordered in (told, replace(told, has_solutions=True)):
        tells = level == "solutions" or ordered.has_solutions
        package = unzipped(files_of(qti.export_qti, ordered, asked)["hw.zip"])
        each = [text for name, text in package.items() if name.startswith("items/")]
        assert {b'identifier="solution"' in text for text in each} == {tells}
        package = unzipped(files_of(canvas.export_canvas, ordered, asked)["hw.zip"])
        assert (b'"general_fb"' in package["qdot-hw/qdot-hw.xml"]) == tells
        shown = b"<show_correct_answers>true" in package["qdot-hw/assessment_meta.xml"]
        assert shown == (at >= FEEDBACK.index("values") or ordered.has_solutions)


# --- Moodle ---

GRADES = {
    "100", "90", "83.33333", "80", "75", "70", "66.66667", "60", "50", "40", "33.33333", "30", "25", "20", "16.66667",
    "14.28571", "12.5", "11.11111", "10", "5", "0",
}  # fmt: skip
"""Moodle's list; any other is refused on import."""
NUMBER = r"-?\d+(?:\.\d+)?"
NOBODYS = r"-1\.\d+E\+99"
CLOZE = re.compile(
    rf"\{{(\d+):NUMERICAL:=({NUMBER}):({NUMBER})((?:~%0%{NUMBER}:{NUMBER}#(?:[^}}~#\\]|\\.)*)*)~%0%({NOBODYS}):0\}}"
)


def check_for_moodle(question: Element) -> None:
    """Hold a question against what Moodle's importer would refuse or lose."""
    name = question.findtext("name/text", "")
    for part in ("questiontext", "generalfeedback"):
        text = question.findtext(f"{part}/text", "")
        assert text.strip(), (name, part)
        given = {str(file.get("name")): file.text or "" for file in question.findall(f"{part}/file")}
        assert set(re.findall(r'src="@@PLUGINFILE@@/([^"]+)"', text)) == set(given), (name, part)
        assert all(b"<svg" in base64.b64decode(data) for data in given.values()), (name, part)
        assert not re.search(r'<img(?![^>]*alt="[^"]+)', text), f"{name}: image without words"
        assert "$" not in text and "<math" not in text, f"{name}: formula left"
    check_answers_for_moodle(question, name)


def check_answers_for_moodle(question: Element, name: str) -> None:
    kind, answers = question.get("type"), question.findall("answer")
    fractions = [str(answer.get("fraction")) for answer in answers]
    assert {fraction.removeprefix("-") for fraction in fractions} <= GRADES, name
    if kind in ("multichoice", "numerical", "truefalse"):
        assert abs(sum(float(f) for f in fractions if float(f) > 0) - 100) < 0.01, name
    if kind == "numerical":
        assert all(re.fullmatch(NUMBER, answer.findtext("text", "")) for answer in answers), name
        assert all(answer.findtext("tolerance") is not None for answer in answers), name
    elif kind == "truefalse":
        assert [answer.findtext("text") for answer in answers] == ["true", "false"], name
    elif kind == "matching":
        pairs = question.findall("subquestion")
        asked = [pair for pair in pairs if (pair.findtext("text") or "").strip()]
        assert len(asked) >= 2 and len({pair.findtext("answer/text") for pair in pairs}) >= 3, name
    elif kind == "cloze":
        text = question.findtext("questiontext/text", "")
        assert len(CLOZE.findall(text)) == text.count(":NUMERICAL:") > 1, name
    else:
        assert kind == "multichoice", name


def test_moodle_xml_keeps_moodles_rules(bank: Element) -> None:
    questions = [question for question in bank if question.get("type") != "category"]
    for question in questions:
        check_for_moodle(question)
    kinds = {question.get("type") for question in bank}
    assert kinds == {"category", "cloze", "numerical", "multichoice", "truefalse", "matching"}
    categories = [text.text or "" for text in bank.findall("question/category/text")]
    assert categories[0] == "$course$/top/Arms & ‹signs› // more/p1 planar-2r/Jacobian by differentiation"
    assert all(category.startswith("$course$/top/") for category in categories)
    assert len(bank.findall("question/hint")) >= 3
    text = bank.findtext("question[@type='cloze']/questiontext/text", "")
    assert r"\[" in text and len(CLOZE.findall(text)) == 4
    feedback = [text.text for text in bank.iter("text") if text.text and "Say }" in text.text]
    assert feedback == ["Say } # ~ / \\ &quot; &lt;b&gt; &amp; {1:NUMERICAL:=1}"]


def test_options_in_moodle_have_the_letters_of_their_solutions(
    bank: Element, backup: Package, asked: list[QuizItem]
) -> None:
    for shuffled in (*bank.iter("shuffleanswers"), *parsed(backup["questions.xml"]).iter("shuffleanswers")):
        assert shuffled.text in ("false", "0")
    assert parsed(backup["activities/quiz_1/quiz.xml"]).findtext("quiz/shuffleanswers") == "0"
    lettered = [f"{letter}. " for letter in LETTERS]
    chosen = [one for one in asked if isinstance(one.form, ChoiceForm) and not one.form.has_fixed_order]
    for question in bank.findall("question[@type='multichoice']"):
        one = next(one for one in asked if question.findtext("idnumber", "").endswith(one.key))
        begins = [answer.findtext("text", "")[:3] for answer in question.findall("answer")]
        assert begins == lettered[: len(begins)] if one in chosen else not {*begins} & {*lettered}
        assert question.findtext("answernumbering") == "none"
    stems = [stem.findtext("text", "")[:3] for stem in bank.findall("question[@type='matching']/subquestion")]
    assert [stem for stem in stems if stem] == lettered[:2]


def test_pages_in_moodle_lose_nothing_and_fit_a_small_window(moodles: dict[str, Any], asked: list[QuizItem]) -> None:
    page: str = moodles["hw.xml"]
    assert "&" not in re.sub(r"<!\[CDATA\[.*?\]\]>", "", page, flags=re.DOTALL)  # it drops the space in `&gt; &lt;`
    assert r"A. \(a &lt; b\) &amp; c" in list(parsed(page).itertext())
    tables = re.findall(r"<table[^>]*>\s*<thead", page)
    assert len(tables) == 12 and all("generaltable" in table for table in tables)  # which Moodle shows with lines
    # DH tables and matrices of boxes are wider than a telephone: each moves by itself.
    moved = re.findall(r'<div style="overflow-x: auto; position: relative">\s*<table', page)
    assert page.count("<table") == len(moved) and "</tbody>" in page
    assert page.count("</table>") == len(re.findall(r"</table>\s*</div>", page))
    figures = re.findall(r"<img [^>]*>", page)  # its column is narrower than they are
    assert len(figures) >= len(asked)
    assert all('style="max-width: 100%; height: auto"' in figure for figure in figures)


def first_changed(item: QuizItem, **changes: Any) -> list[str]:
    """Return what Moodle is told of the boxes of a matrix, the first of them changed."""
    assert isinstance(item.form, NumberForm)
    ((first, *rest), *rows) = item.form.rows
    form = replace(item.form, rows=((replace(first, **changes), *rest), *rows))  # type: ignore[type-var]
    return [box.notation for box in moodle._make_boxes(form)]


def test_no_box_is_as_wide_as_its_answer_nor_ended_by_its_advice(asked: list[QuizItem]) -> None:
    for value, tolerance, width in ((0.5, 0.0025, 12), (-0.00012345678, 5e-12, 14)):
        boxes = [CLOZE.fullmatch(box) for box in first_changed(asked[0], value=value, tolerance=tolerance)]
        assert {len(box[5]) for box in boxes if box} == {width}
        numbers = [number for box in boxes if box for number in re.findall(rf"(?:=|%)({NUMBER})(?=:)", box[0])]
        assert max(map(len, numbers)) <= width
    wrong = WrongValue(9.0, 0.045, 'ends } here # or ~ there / \\ "q" <b> & {2:NUMERICAL:=5}')
    notations = first_changed(asked[0], wrong_values=(wrong,))
    assert all(CLOZE.fullmatch(notation) for notation in notations)
    read = html.unescape(notations[0]).replace(r"\}", "}").replace(r"\#", "#")  # as Moodle reads it
    assert 'ends } here # or ∼ there / \\ "q" &lt;b&gt; &amp; {2:NUMERICAL:=5}' in read


def check_ids_and_marks(one: Element, asked: dict[str, Element]) -> None:
    """Hold a question of a backup against those that it names."""
    number = one.get("id")
    answers = {str(answer.get("id")) for answer in one.iter("answer") if answer.get("id")}
    paths = (".//numerical_record/answer", ".//trueanswer", ".//falseanswer")
    assert {found.text for path in paths for found in one.findall(path)} <= answers, number
    if one.findtext("qtype") == "multianswer":
        parts = [asked[part] for part in one.findtext(".//sequence", "").split(",")]
        assert all(part.findtext("parent") == number for part in parts), number
        boxes = re.findall(r"{#(\d+)}", one.findtext("questiontext", ""))
        assert boxes == [str(i + 1) for i in range(len(parts))], number
        points = sum(float(part.findtext("defaultmark", "")) for part in parts)
        assert abs(points - float(one.findtext("defaultmark", ""))) < 1e-5, number


def test_a_backup_for_moodle_names_nothing_that_is_not_in_it(bank: Element, backup: Package) -> None:
    xml = {name: parsed(data) for name, data in backup.items() if name.endswith(".xml")}
    quiz, of = xml["activities/quiz_1/quiz.xml"], xml["questions.xml"]
    categories = {str(one.get("id")): one for one in of.findall("question_category")}
    parents = [one.findtext("parent") for one in categories.values()]
    assert parents.count("0") == 1 and {*parents} <= {"0", *categories}
    named = [one.text for one in xml["activities/quiz_1/inforef.xml"].findall(".//question_category/id")]
    assert named == list(categories)
    for file in xml["files.xml"]:
        digest = file.findtext("contenthash", "")
        assert hashlib.sha1(backup[f"files/{digest[:2]}/{digest}"]).hexdigest() == digest
    asked = {str(one.get("id")): one for one in of.iter("question")}
    for one in asked.values():
        check_ids_and_marks(one, asked)
    slots = quiz.findall(".//question_instance")
    for slot in slots:
        drawn = categories[json.loads(slot.findtext(".//filtercondition", ""))["questioncategoryid"]]
        points = {q.findtext("defaultmark") for q in drawn.iter("question") if q.findtext("parent") == "0"}
        assert points == {slot.findtext("maxmark")}
    whole = sum(float(slot.findtext("maxmark", "")) for slot in slots)
    assert float(quiz.findtext("quiz/grade", "")) == whole
    wanted = [texts(one, "name/text", "generalfeedback/text") for one in bank if one.get("type") != "category"]
    given = [texts(one, "name", "generalfeedback") for one in asked.values() if one.findtext("parent") == "0"]
    assert wanted == given


def texts(question: Element, *paths: str) -> list[str]:
    return [question.findtext(path, "") for path in paths]


def test_moodles_quiz_draws_each_question_for_its_points(
    order: ExportRequest, asked: list[QuizItem], backup: Package
) -> None:
    names = ("attempts_number", "grademethod", "delay1", "delay2", "timeclose")
    settings = parsed(backup["activities/quiz_1/quiz.xml"])
    assert settings.findtext("quiz/name") == "Arms & ‹signs› / more"
    points = [one.points for one in {one.category: one for one in asked}.values()]
    assert [float(slot.text or "") for slot in settings.iter("maxmark")] == points
    assert [settings.findtext(f"quiz/{name}") for name in names] == ["0", "4", "0", "0", "0"]  # the last counts
    due = datetime(2027, 1, 15, 12, tzinfo=UTC)
    limited = replace(order.assignment, attempts=AttemptPolicy(best_of=3, min_interval=3600), due_date=due)
    content = files_of(moodle.export_moodle, replace(order, assignment=limited), asked)["hw.mbz"]
    settings = parsed(unzipped(content)["activities/quiz_1/quiz.xml"])
    told = [settings.findtext(f"quiz/{name}") for name in names]
    assert told == ["3", "1", "3600", "3600", str(int(due.timestamp()))]


# --- Canvas ---


def paths(root: Element, above: str = "") -> Iterator[str]:
    here = f"{above}/{root.tag.rpartition('}')[2]}"
    yield here
    yield from (f"{here}@{name.rpartition('}')[2]}" for name in root.attrib)
    for child in root:
        yield from paths(child, here)


def paths_in(package: Package) -> set[str]:
    return {path for name, data in package.items() if name.endswith(".xml") for path in paths(parsed(data))}


TEXT2QTI = """Quiz title: T

1.  True
*a) True
b) False

GROUP
pick: 1
points per question: 2

1.  Another choice
... general
a)  6
... told
*c) 5

2.  Several more
... general
[*] 2
... told
[ ] 3
[*] 4

3.  Another number
... general
=   1.4142 +- 0.0001

END_GROUP
"""


def test_canvas_is_given_what_text2qti_gives_it(order: ExportRequest, asked: list[QuizItem], tmp_path: Path) -> None:
    (tmp_path / "quiz.txt").write_text(TEXT2QTI)
    subprocess.run([require_reader("text2qti"), "quiz.txt"], cwd=tmp_path, check=True, capture_output=True)
    golden = unzipped((tmp_path / "quiz.zip").read_bytes())
    unmatched = [one for one in asked if not isinstance(one.form, MatchingForm)]
    ours = unzipped(files_of(canvas.export_canvas, order, unmatched)["hw.zip"])
    assert sorted(paths_in(ours) - paths_in(golden)) == []


def test_canvas_finds_all_that_is_named(canvass: Package) -> None:
    """Files, answers and feedback."""
    listed = {str(file.get("href")) for file in local(parsed(canvass["imsmanifest.xml"]), "file")}
    assert listed | {"imsmanifest.xml"} == set(canvass)
    quiz = parsed(canvass["qdot-hw/qdot-hw.xml"])
    names = [str(item.get("ident")) for item in local(quiz, "item")]
    assert len(set(names)) == len(names)
    types = set()
    for item in local(quiz, "item"):
        name = str(item.get("ident"))
        labels = {str(label.get("ident")) for label in local(item, "response_label")}
        told = {str(feedback.get("ident")) for feedback in local(item, "itemfeedback")}
        assert {display.get("linkrefid") for display in local(item, "displayfeedback")} <= told, name
        (kind,) = [field[1].text for field in local(item, "qtimetadatafield") if field[0].text == "question_type"]
        types.add(kind)
        equal = [str(each.text) for each in local(item, "varequal")]
        if kind == "numerical_question":
            low, high = (float(local(item, tag)[0].text or "nan") for tag in ("vargte", "varlte"))
            assert low < float(equal[0]) < high, name
        else:
            assert equal and set(equal) <= labels, name
        assert round(sum(float(each.text or 0) for each in local(item, "setvar")), 6) == 100, name
        for text in local(item, "mattext"):
            sources = re.findall(r'src="([^"]*)"', text.text or "")
            assert {source.removeprefix("%24IMS-CC-FILEBASE%24/") for source in sources} <= set(canvass), name
    assert types == {
        "multiple_choice_question", "multiple_answers_question", "true_false_question", "matching_question",
        "numerical_question",
    }  # fmt: skip
    assert [number.text for number in local(quiz, "selection_number")] == ["1"] * 7
    written = " ".join(str(text.text) for text in local(quiz, "mattext"))
    assert r"\(\theta_{1}\)" in written and "$" not in written


def test_that_vectors_are_asked_for_by_one_entry_is_told_once(order: ExportRequest, asked: list[QuizItem]) -> None:
    notes: list[str] = []
    files_of(canvas.export_canvas, replace(order, report=notes.append), asked)
    assert len(notes) == 1


# --- QTI 2.1 ---


def test_qti_is_read_by_citolab(qti_file: bytes, tmp_path: Path) -> None:
    (tmp_path / "two.zip").write_bytes(qti_file)
    command = [require_reader("qti-convert"), "upgrade", str(tmp_path / "two.zip"), str(tmp_path / "three.zip")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    three = unzipped((tmp_path / "three.zip").read_bytes())
    assert {name for name in unzipped(qti_file) if name.startswith("items/")} <= set(three)
    item = parsed(three["items/p1-001-jacobian.xml"])
    assert len(local(item, "qti-text-entry-interaction")) == 4 and local(item, "math")


VALIDATE = """
import sys
from lxml import etree
schema = etree.XMLSchema(etree.parse(sys.argv[1]))
for path in sys.argv[2:]:
    schema.assertValid(etree.parse(path))
"""


@pytest.mark.integration
@pytest.mark.skipif("QDOT_QTI" not in os.environ, reason="QDOT_QTI doesn't name the schema of QTI 2.1")
def test_qti_holds_to_its_schema(qti_file: bytes, tmp_path: Path) -> None:
    paths = []
    for name, content in unzipped(qti_file).items():
        if name == "test.xml" or name.startswith("items/"):
            paths.append(tmp_path / name.replace("/", "-"))
            paths[-1].write_bytes(content)
    command = [require_reader("python", "lxml"), "-c", VALIDATE, os.environ["QDOT_QTI"]]
    done = subprocess.run([*command, *map(str, paths)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_qti_names_nothing_that_is_not_there_and_marks_as_it_should(qti_file: bytes, asked: list[QuizItem]) -> None:
    package = unzipped(qti_file)
    manifest = parsed(package["imsmanifest.xml"])
    assert {str(each.get("href")) for each in local(manifest, "file")} | {"imsmanifest.xml"} == set(package)
    for one in asked:
        item = parsed(package[f"items/{one.key}.xml"])
        images = local(item, "img")
        assert {f"images/{str(image.get('src')).rpartition('/')[2]}" for image in images} <= set(package)
        assert all(image.get("alt") for image in images)
        assert not [element for element in item.iter() if element.get("style")]
        declared = {str(each.get("identifier")) for each in local(item, "responseDeclaration")}
        asks = [each for each in item.iter() if each.tag.endswith("Interaction")]
        assert {str(each.get("responseIdentifier")) for each in asks} == declared
        told = {str(each.text) for each in local(item, "baseValue") if each.get("baseType") == "identifier"}
        assert {str(each.get("identifier")) for each in local(item, "modalFeedback")} <= told
        if isinstance(one.form, NumberForm):
            for (value, held), field in zip(right_numbers(item), one.form.fields, strict=True):
                assert abs(value - field.value) < 1e-8 and held
        elif isinstance(one.form, ChoiceForm) and not one.form.has_fixed_order:  # solutions say that the answer is B
            letters = ["".join(each.itertext()).strip()[:2] for each in local(item, "simpleChoice")]
            assert letters == [f"{letter}." for letter in LETTERS[: len(letters)]]
            assert not [each for each in item.iter() if each.get("shuffle") == "true"]


def test_qtis_test_asks_one_variant_of_each_problem_for_its_points(qti_file: bytes, asked: list[QuizItem]) -> None:
    test = parsed(unzipped(qti_file)["test.xml"])
    assert len(local(test, "assessmentItemRef")) == len(asked)
    places = [each for each in local(test, "assessmentSection") if local(each, "selection")]
    assert {str(each.get("identifier")) for each in places} == {one.key[:2] for one in asked}
    for listed in places:
        keys = [one.key for one in asked if one.key[:2] == listed.get("identifier")]
        assert [each.get("select") for each in local(listed, "selection")] == ["1"]
        variants = [each for each in local(listed, "assessmentSection") if each is not listed]
        assert len(variants) == len({key[:6] for key in keys})
        refs = [str(each.get("identifier")) for variant in variants for each in local(variant, "assessmentItemRef")]
        assert refs == keys
    (control,) = local(test, "itemSessionControl")
    assert control.get("maxAttempts") == str(DEFAULT_ATTEMPTS)
    (outcome,) = local(test, "outcomeDeclaration")
    points = {one.key[:2] + one.category[2]: one.points for one in asked}
    assert float(str(outcome.get("normalMaximum"))) == sum(points.values())


def right_numbers(item: Element) -> list[tuple[float, bool]]:
    """Return the right numbers of an item, and whether three digits of each are within what is allowed."""
    found = []
    conditions = local(item, "responseIf")
    for declared, condition in zip(local(item, "responseDeclaration"), conditions, strict=False):
        value = float(local(declared, "value")[0].text or "nan")
        (equal,) = local(condition, "equal")
        low, _ = map(float, str(equal.get("tolerance")).split())
        found.append((value, abs(float(f"{value:.2e}") - value) <= low))
    return found
