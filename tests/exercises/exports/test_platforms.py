"""Exports for learning platforms satisfy the platforms' rules, and real readers accept them.

The readers are in a separate environment (`make .venvs/readers/.installed`); without them tests are skipped.
tests/platforms import the files into real platforms.
"""

import base64
import hashlib
import html
import io
import json
import operator
import re
import subprocess
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.exports import canvas, common_cartridge, moodle, qti
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
from qdot.exercises.exports.typed_numbers import list_accepted_texts
from qdot.exercises.reference_answers import LETTERS
from tests.exercises.exports.test_items import make_request
from tests.support import read_data
from tests.support.programs import require_reader
from tests.support.suites import sample_for_suite

TOML = read_data("assignments/platforms.toml")
Element = ElementTree.Element
Package = dict[str, bytes]
parsed = ElementTree.fromstring


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    return make_request(tmp_path_factory.mktemp("platforms"), TOML, 2)


@pytest.fixture(scope="module")
def items(export_request: ExportRequest) -> list[QuizItem]:
    """The assignment's items, one hand-made matching item, because those take long, and one with special characters."""
    items = list(make_items(export_request))
    form = MatchingForm(
        (r"$\begin{bmatrix} a_{1} \\ 0 \end{bmatrix}$", "$b < c$"), ("joint 1", "joint 2", "no joint"), (1, 2)
    )
    matching = replace(items[0], key="p3-001-match", title="Match", form=form, single_number_item=None)
    matching = replace(matching, category=ItemCategory("T", "p3", "Match", 1))
    nasty_option = QuizOption(r"$a < b$ & c", False, 'Say } # ~ / \\ " <b> & {1:NUMERICAL:=1}')
    nasty_form, category = ChoiceForm((nasty_option, QuizOption("$c$", True))), ItemCategory("T", "p4", "Nasty", 1)
    nasty_choice = replace(matching, key="p4-001-nasty", category=category, form=nasty_form)
    return [*items, matching, nasty_choice]


def export_items(
    export_format: Callable[[ExportRequest], Iterator[Any]], export_request: ExportRequest, items: list[QuizItem]
) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(made, "make_items", lambda _: iter(items))
        files = list(export_format(export_request))
    assert all(file.is_private for file in files)  # they contain the answers
    return {file.path: file.content for file in files}


def unzip(content: bytes) -> Package:
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        return {name: package.read(name) for name in package.namelist()}


@pytest.fixture(scope="module")
def moodle_files(export_request: ExportRequest, items: list[QuizItem]) -> dict[str, Any]:
    return export_items(moodle.export_moodle, export_request, items)


@pytest.fixture(scope="module")
def bank(moodle_files: dict[str, Any]) -> Element:
    return parsed(moodle_files["hw.xml"])


@pytest.fixture(scope="module")
def backup(moodle_files: dict[str, Any]) -> Package:
    return unzip(moodle_files["hw.mbz"])


@pytest.fixture(scope="module")
def canvas_package(export_request: ExportRequest, items: list[QuizItem]) -> Package:
    return unzip(export_items(canvas.export_canvas, export_request, items)["hw.zip"])


@pytest.fixture(scope="module")
def qti_file(export_request: ExportRequest, items: list[QuizItem]) -> bytes:
    content: bytes = export_items(qti.export_qti, export_request, items)["hw.zip"]
    return content


def list_elements(root: Element, tag: str) -> list[Element]:
    return [element for element in root.iter() if element.tag.rpartition("}")[2] == tag]


@pytest.mark.parametrize("level", sample_for_suite(FEEDBACK_LEVELS, 3))
def test_feedback_level_of_assignment_applies_to_every_platform(export_request: ExportRequest, level: str) -> None:
    """Mistakes, values and solutions appear from their levels on; solutions also if the request has them."""
    at = FEEDBACK_LEVELS.index(level)
    leveled = replace(export_request, assignment=replace(export_request.assignment, feedback=level))
    items = list(make_items(leveled))
    forms = [item.form for item in items]
    wrong = [option.feedback for form in forms if isinstance(form, ChoiceForm) for option in form.options]
    fields = [field for form in forms if isinstance(form, NumberForm) for field in form.fields]
    wrong += [each.feedback for field in fields for each in field.wrong_values]
    assert any(wrong) == (at >= FEEDBACK_LEVELS.index("mistake"))

    quiz, ordered_quiz = (
        unzip(export_items(moodle.export_moodle, variant, items)["hw.mbz"])
        for variant in (leveled, replace(leveled, has_solutions=True))
    )
    settings = parsed(quiz["activities/quiz_1/quiz.xml"])
    assert ordered_quiz == quiz  # its settings are the teacher's
    values, solutions = (settings.findtext(f"quiz/review{name}") for name in ("rightanswer", "generalfeedback"))
    after, closed = str(0x01110), str(0x00010)
    assert values == (after if at >= FEEDBACK_LEVELS.index("values") else closed)
    assert solutions == (after if level == "solutions" else closed)

    for ordered in (leveled, replace(leveled, has_solutions=True)):
        has_solutions = level == "solutions" or ordered.has_solutions
        package = unzip(export_items(qti.export_qti, ordered, items)["hw.zip"])
        each = [text for name, text in package.items() if name.startswith("items/")]
        assert {b'identifier="solution"' in text for text in each} == {has_solutions}
        package = unzip(export_items(canvas.export_canvas, ordered, items)["hw.zip"])
        assert (b'"general_fb"' in package["qdot-hw/qdot-hw.xml"]) == has_solutions
        shown = b"<show_correct_answers>true" in package["qdot-hw/assessment_meta.xml"]
        assert shown == (at >= FEEDBACK_LEVELS.index("values") or ordered.has_solutions)


# --- Moodle ---

GRADES = {
    "100", "90", "83.33333", "80", "75", "70", "66.66667", "60", "50", "40", "33.33333", "30", "25", "20", "16.66667",
    "14.28571", "12.5", "11.11111", "10", "5", "0",
}  # fmt: skip
"""Moodle refuses other grades on import."""
NUMBER = r"-?\d+(?:\.\d+)?"
IMPOSSIBLE_NUMBER = r"-1\.\d+E\+99"
CLOZE = re.compile(
    rf"\{{(\d+):NUMERICAL:=({NUMBER}):({NUMBER})((?:~%0%{NUMBER}:{NUMBER}#(?:[^}}~#\\]|\\.)*)*)~%0%({IMPOSSIBLE_NUMBER}):0\}}"
)


def check_for_moodle(question: Element) -> None:
    """Check that Moodle's importer would not refuse the question or lose parts of it."""
    name = question.findtext("name/text", "")
    for part in ("questiontext", "generalfeedback"):
        text = question.findtext(f"{part}/text", "")
        assert text.strip(), (name, part)
        files = {str(file.get("name")): file.text or "" for file in question.findall(f"{part}/file")}
        assert set(re.findall(r'src="@@PLUGINFILE@@/([^"]+)"', text)) == set(files), (name, part)
        assert all(b"<svg" in base64.b64decode(data) for data in files.values()), (name, part)
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
        stems = [pair for pair in pairs if (pair.findtext("text") or "").strip()]
        assert len(stems) >= 2 and len({pair.findtext("answer/text") for pair in pairs}) >= 3, name
    elif kind == "cloze":
        text = question.findtext("questiontext/text", "")
        assert len(CLOZE.findall(text)) == text.count(":NUMERICAL:") > 1, name
    else:
        assert kind == "multichoice", name


def test_moodle_xml_satisfies_moodles_rules(bank: Element) -> None:
    questions = [question for question in bank if question.get("type") != "category"]
    for question in questions:
        check_for_moodle(question)
    kinds = {question.get("type") for question in bank}
    assert kinds == {"category", "cloze", "numerical", "multichoice", "truefalse", "matching"}
    categories = [text.text or "" for text in bank.findall("question/category/text")]
    assert categories[0] == "$course$/top/Arms & ‹signs› // more/p1 planar-2r/1. Jacobian by differentiation"
    assert all(category.startswith("$course$/top/") for category in categories)
    assert len(bank.findall("question/hint")) >= 3
    text = bank.findtext("question[@type='cloze']/questiontext/text", "")
    assert r"\[" in text and len(CLOZE.findall(text)) == 4
    assert all(word in text for word in ("decimal with a point", "minus sign", "fraction (1/4)", "v = 0.25"))
    feedback = [text.text for text in bank.iter("text") if text.text and "Say }" in text.text]
    assert feedback == ["Say } # ~ / \\ &quot; &lt;b&gt; &amp; {1:NUMERICAL:=1}"]


def test_options_in_moodle_have_the_letters_of_the_solutions(
    bank: Element, backup: Package, items: list[QuizItem]
) -> None:
    for shuffled in (*bank.iter("shuffleanswers"), *parsed(backup["questions.xml"]).iter("shuffleanswers")):
        assert shuffled.text in ("false", "0")
    assert parsed(backup["activities/quiz_1/quiz.xml"]).findtext("quiz/shuffleanswers") == "0"
    lettered = [f"{letter}. " for letter in LETTERS]
    chosen = [item for item in items if isinstance(item.form, ChoiceForm) and not item.form.has_fixed_order]
    for question in bank.findall("question[@type='multichoice']"):
        item = next(item for item in items if question.findtext("idnumber", "").endswith(item.key))
        begins = [answer.findtext("text", "")[:3] for answer in question.findall("answer")]
        assert begins == lettered[: len(begins)] if item in chosen else not {*begins} & {*lettered}
        assert question.findtext("answernumbering") == "none"
    stems = [stem.findtext("text", "")[:3] for stem in bank.findall("question[@type='matching']/subquestion")]
    assert [stem for stem in stems if stem] == lettered[:2]


def test_pages_in_moodle_are_complete_and_fit_small_screens(
    moodle_files: dict[str, Any], items: list[QuizItem]
) -> None:
    page: str = moodle_files["hw.xml"]
    assert "&" not in re.sub(r"<!\[CDATA\[.*?\]\]>", "", page, flags=re.DOTALL)  # it drops the space in `&gt; &lt;`
    assert r"A. \(a &lt; b\) &amp; c" in list(parsed(page).itertext())
    tables = re.findall(r"<table[^>]*>\s*<thead", page)
    assert len(tables) == 12 and all("generaltable" in table for table in tables)  # Moodle draws lines for this class
    # DH tables and matrices of boxes are wider than a phone, so each scrolls separately.
    moved = re.findall(r'<div style="overflow-x: auto; position: relative">\s*<table', page)
    assert page.count("<table") == len(moved) and "</tbody>" in page
    assert page.count("</table>") == len(re.findall(r"</table>\s*</div>", page))
    figures = re.findall(r"<img [^>]*>", page)  # Moodle's column is narrower
    assert len(figures) >= len(items)
    assert all('style="max-width: 100%; height: auto"' in figure for figure in figures)


def test_a_question_with_decimals_in_moodle_says_when_to_type_a_comma(bank: Element) -> None:
    # In German, Moodle calls -0.25 incomplete; in English, it reads -0,25 as -25.
    pages = [text for text in bank.itertext() if "<p>Type only the number" in text]
    assert pages and all(
        "-0.25" in page and "a decimal comma (1,00), type a comma instead of the point (-0,25)" in page
        for page in pages
    )


def make_boxes_with_change(item: QuizItem, **changes: Any) -> list[str]:
    """Return Moodle's notation of the boxes of a matrix after a change of the first."""
    assert isinstance(item.form, NumberForm)
    ((first, *rest), *rows) = item.form.rows
    form = replace(item.form, rows=((replace(first, **changes), *rest), *rows))  # type: ignore[type-var]
    return [box.notation for box in moodle._make_boxes(form)]


def test_cloze_boxes_have_equal_width_and_escape_feedback(items: list[QuizItem]) -> None:
    for value, tolerance, width in ((0.5, 0.0025, 12), (-0.00012345678, 5e-12, 14)):
        boxes = [CLOZE.fullmatch(box) for box in make_boxes_with_change(items[0], value=value, tolerance=tolerance)]
        assert {len(box[5]) for box in boxes if box} == {width}
        numbers = [number for box in boxes if box for number in re.findall(rf"(?:=|%)({NUMBER})(?=:)", box[0])]
        assert max(map(len, numbers)) <= width
    wrong = WrongValue(9.0, 0.045, 'ends } here # or ~ there / \\ "q" <b> & {2:NUMERICAL:=5}')
    notations = make_boxes_with_change(items[0], wrong_values=(wrong,))
    assert all(CLOZE.fullmatch(notation) for notation in notations)
    read = html.unescape(notations[0]).replace(r"\}", "}").replace(r"\#", "#")  # as Moodle reads it
    assert 'ends } here # or ∼ there / \\ "q" &lt;b&gt; &amp; {2:NUMERICAL:=5}' in read


def check_ids_and_marks(question: Element, questions: dict[str, Element]) -> None:
    """Check the ids in a question of a backup, and the sum of its points."""
    number = question.get("id")
    answers = {str(answer.get("id")) for answer in question.iter("answer") if answer.get("id")}
    paths = (".//numerical_record/answer", ".//trueanswer", ".//falseanswer")
    assert {element.text for path in paths for element in question.findall(path)} <= answers, number
    if question.findtext("qtype") == "multianswer":
        parts = [questions[part] for part in question.findtext(".//sequence", "").split(",")]
        assert all(part.findtext("parent") == number for part in parts), number
        boxes = re.findall(r"{#(\d+)}", question.findtext("questiontext", ""))
        assert boxes == [str(i + 1) for i in range(len(parts))], number
        points = sum(float(part.findtext("defaultmark", "")) for part in parts)
        assert abs(points - float(question.findtext("defaultmark", ""))) < 1e-5, number


def test_moodle_backup_refers_only_to_its_own_content(bank: Element, backup: Package) -> None:
    xml = {name: parsed(data) for name, data in backup.items() if name.endswith(".xml")}
    quiz, of = xml["activities/quiz_1/quiz.xml"], xml["questions.xml"]
    categories = {str(element.get("id")): element for element in of.findall("question_category")}
    parents = [element.findtext("parent") for element in categories.values()]
    assert parents.count("0") == 1 and {*parents} <= {"0", *categories}
    named = [element.text for element in xml["activities/quiz_1/inforef.xml"].findall(".//question_category/id")]
    assert named == list(categories)
    for file in xml["files.xml"]:
        digest = file.findtext("contenthash", "")
        assert hashlib.sha1(backup[f"files/{digest[:2]}/{digest}"]).hexdigest() == digest
    questions = {str(element.get("id")): element for element in of.iter("question")}
    for element in questions.values():
        check_ids_and_marks(element, questions)
    slots = quiz.findall(".//question_instance")
    for slot in slots:
        category = categories[json.loads(slot.findtext(".//filtercondition", ""))["questioncategoryid"]]
        points = {q.findtext("defaultmark") for q in category.iter("question") if q.findtext("parent") == "0"}
        assert points == {slot.findtext("maxmark")}
    whole = sum(float(slot.findtext("maxmark", "")) for slot in slots)
    assert float(quiz.findtext("quiz/grade", "")) == whole
    imported = [each for each in bank if each.get("type") != "category"]
    restored = [each for each in questions.values() if each.findtext("parent") == "0"]
    for in_bank, in_backup in (("name/text", "name"), ("generalfeedback/text", "generalfeedback")):
        assert [each.findtext(in_bank, "") for each in imported] == [each.findtext(in_backup, "") for each in restored]


def test_moodle_quiz_picks_each_question_for_its_points(
    export_request: ExportRequest, items: list[QuizItem], backup: Package
) -> None:
    names = ("attempts_number", "grademethod", "delay1", "delay2", "timeclose")
    settings = parsed(backup["activities/quiz_1/quiz.xml"])
    assert settings.findtext("quiz/name") == "Arms & ‹signs› / more"
    points = [item.points for item in {item.category: item for item in items}.values()]
    assert [float(slot.text or "") for slot in settings.iter("maxmark")] == points
    assert [settings.findtext(f"quiz/{name}") for name in names] == ["0", "4", "0", "0", "0"]  # the last counts
    due_date = datetime(2027, 1, 15, 12, tzinfo=UTC)
    limited = replace(
        export_request.assignment, attempt_policy=AttemptPolicy(best_of=3, min_interval=3600), due_date=due_date
    )
    content = export_items(moodle.export_moodle, replace(export_request, assignment=limited), items)["hw.mbz"]
    settings = parsed(unzip(content)["activities/quiz_1/quiz.xml"])
    values = [settings.findtext(f"quiz/{name}") for name in names]
    assert values == ["3", "1", "3600", "3600", str(int(due_date.timestamp()))]


# --- Canvas ---


def list_paths(root: Element, above: str = "") -> Iterator[str]:
    here = f"{above}/{root.tag.rpartition('}')[2]}"
    yield here
    yield from (f"{here}@{name.rpartition('}')[2]}" for name in root.attrib)
    for child in root:
        yield from list_paths(child, here)


def list_package_paths(package: Package) -> set[str]:
    return {path for name, data in package.items() if name.endswith(".xml") for path in list_paths(parsed(data))}


TEXT2QTI = read_data("text2qti.txt")


def test_canvas_package_has_the_structure_of_text2qti(
    export_request: ExportRequest, items: list[QuizItem], tmp_path: Path
) -> None:
    (tmp_path / "quiz.txt").write_text(TEXT2QTI)
    subprocess.run([require_reader("text2qti"), "quiz.txt"], cwd=tmp_path, check=True, capture_output=True)
    golden = unzip((tmp_path / "quiz.zip").read_bytes())
    known_to_text2qti = [
        item
        for item in items
        if not isinstance(item.form, MatchingForm) and (not isinstance(item.form, NumberForm) or not item.form.rows[1:])
    ]
    ours = unzip(export_items(canvas.export_canvas, export_request, known_to_text2qti)["hw.zip"])
    assert sorted(list_package_paths(ours) - list_package_paths(golden)) == []


def test_canvas_export_says_which_package_is_for_which_quizzes(
    export_request: ExportRequest, items: list[QuizItem]
) -> None:
    notes: list[str] = []
    files = export_items(canvas.export_canvas, replace(export_request, report=notes.append), items)
    assert [note.partition(" is for ") for note in notes] == [
        ("hw.zip", " is for ", "classic quizzes"), ("hw-new-quizzes.zip", " is for ", "New Quizzes"),
    ]  # fmt: skip
    assert set(files) == {"hw.zip", "hw-new-quizzes.zip"}


def test_canvas_package_contains_everything_it_refers_to(canvas_package: Package) -> None:
    """All named files, answers and feedback exist."""
    listed = {str(file.get("href")) for file in list_elements(parsed(canvas_package["imsmanifest.xml"]), "file")}
    assert listed | {"imsmanifest.xml"} == set(canvas_package)
    quiz = parsed(canvas_package["qdot-hw/qdot-hw.xml"])
    names = [str(item.get("ident")) for item in list_elements(quiz, "item")]
    assert len(set(names)) == len(names)
    types = set()
    for item in list_elements(quiz, "item"):
        name = str(item.get("ident"))
        labels = {str(label.get("ident")) for label in list_elements(item, "response_label")}
        feedback_ids = {str(feedback.get("ident")) for feedback in list_elements(item, "itemfeedback")}
        assert {display.get("linkrefid") for display in list_elements(item, "displayfeedback")} <= feedback_ids, name
        (kind,) = [
            field[1].text for field in list_elements(item, "qtimetadatafield") if field[0].text == "question_type"
        ]
        types.add(kind)
        equal = [str(each.text) for each in list_elements(item, "varequal")]
        if kind == "numerical_question":
            low, high = (float(list_elements(item, tag)[0].text or "nan") for tag in ("vargte", "varlte"))
            assert low < float(equal[0]) < high, name
        else:
            assert equal and set(equal) <= labels, name
        assert round(sum(float(each.text or 0) for each in list_elements(item, "setvar")), 6) == 100, name
        for text in list_elements(item, "mattext"):
            sources = re.findall(r'src="([^"]*)"', text.text or "")
            assert {source.removeprefix("%24IMS-CC-FILEBASE%24/") for source in sources} <= set(canvas_package), name
    assert types == {
        "multiple_choice_question", "multiple_answers_question", "true_false_question", "matching_question",
        "numerical_question", "fill_in_multiple_blanks_question",
    }  # fmt: skip
    assert [number.text for number in list_elements(quiz, "selection_number")] == ["1"] * 7
    written = " ".join(str(text.text) for text in list_elements(quiz, "mattext"))
    assert r"\(\theta_{1}\)" in written and "$" not in written


@pytest.mark.parametrize("kind", canvas.QUIZ_KINDS, ids=["classic", "new"])
def test_a_matrix_in_canvas_is_one_question_with_a_blank_for_each_entry(
    export_request: ExportRequest, items: list[QuizItem], kind: canvas.CanvasQuizKind
) -> None:
    """Classic quizzes compare with listed texts, of which all are right; New Quizzes compare with a pattern."""
    package = unzip(export_items(canvas.export_canvas, export_request, items)[f"hw{kind.file_suffix}.zip"])
    matrix = next(item for item in items if isinstance(item.form, NumberForm) and len(item.form.fields) == 4)
    assert isinstance(matrix.form, NumberForm)
    elements = {str(item.get("ident")): item for item in list_elements(parsed(package["qdot-hw/qdot-hw.xml"]), "item")}
    element = elements[f"hw-{matrix.key}"]
    question, *texts = [str(text.text) for text in list_elements(element, "mattext")]
    assert [re.findall(r"\[(n\d+)\]", row) for row in question.split("</tr>")[-3:-1]] == [["n1", "n2"], ["n3", "n4"]]
    assert "Type each number as a decimal" in question
    for number, field in enumerate(matrix.form.fields, 1):
        (blank,) = [each for each in element.iter() if each.get("ident") == f"response_n{number}"]
        labels = list_elements(blank, "response_label")
        accepted = [str(list_elements(label, "mattext")[0].text) for label in labels]
        assert accepted == list(kind.list_texts(field)) and set(accepted) < set(texts)
        assert {label.get("scoring_algorithm") for label in labels} == {"TextRegex" if kind.uses_patterns else None}


# --- Common Cartridge ---

CARTRIDGE_PART = r"(bank|version-\d+)/assessment\.xml"
CARTRIDGE_PROFILES = {"multiple_choice", "multiple_response", "true_false", "fib", "essay"}


@pytest.fixture(scope="module")
def cartridges(export_request: ExportRequest, items: list[QuizItem]) -> dict[str, Package]:
    files = export_items(common_cartridge.export_common_cartridge, export_request, items)
    return {path: unzip(content) for path, content in files.items()}


def read_metadata(element: Element) -> dict[str, str]:
    return {str(field[0].text): str(field[1].text) for field in list_elements(element, "qtimetadatafield")}


def test_a_cartridge_has_a_quiz_for_each_version_and_each_bank_a_cartridge(cartridges: dict[str, Package]) -> None:
    manifest = parsed(cartridges["hw.imscc"]["imsmanifest.xml"])
    titles = [title.text for title in list_elements(manifest, "title") if title.text and title.text.strip()]
    assert titles == [f"Arms & ‹signs› / more, version {number}" for number in (1, 2)]
    for number in (1, 2):
        quiz = parsed(cartridges["hw.imscc"][f"version-{number}/assessment.xml"])
        names = [str(item.get("ident")) for item in list_elements(quiz, "item")]
        assert len(names) == 6 and {name.split("-")[2] for name in names[:5]} == {f"00{number}"}  # p4 has one variant
    banks = [path for path in cartridges if path.startswith("banks/")]
    assert banks[0] == "banks/p1-jacobian.imscc" and len(banks) == 6
    for path in banks:  # a cartridge may have one bank, which no item of the organization may refer to
        manifest = parsed(cartridges[path]["imsmanifest.xml"])
        types = [str(resource.get("type")) for resource in list_elements(manifest, "resource")]
        assert [name.rpartition("/")[2] for name in types if "/" in name] == ["question-bank"]
        assert not [item for item in list_elements(manifest, "item") if item.get("identifierref")]


def test_cartridges_are_complete_and_use_only_profiles_of_the_standard(
    cartridges: dict[str, Package], items: list[QuizItem]
) -> None:
    item_by_key = {item.key: item for item in items}
    for path, package in cartridges.items():
        manifest = parsed(package["imsmanifest.xml"])
        assert {str(file.get("href")) for file in list_elements(manifest, "file")} | {"imsmanifest.xml"} == set(package)
        idents = {str(resource.get("identifier")) for resource in list_elements(manifest, "resource")}
        assert {str(each.get("identifierref")) for each in list_elements(manifest, "dependency")} <= idents, path
        parts = [parsed(content) for name, content in package.items() if re.fullmatch(CARTRIDGE_PART, name)]
        for item in (item for part in parts for item in list_elements(part, "item")):
            name = str(item.get("ident"))
            metadata, form = read_metadata(item), item_by_key[name.removeprefix("hw-")].form
            assert metadata["cc_profile"].removeprefix("cc.").removesuffix(".v0p1") in CARTRIDGE_PROFILES
            feedback_ids = {str(feedback.get("ident")) for feedback in list_elements(item, "itemfeedback")}
            assert {each.get("linkrefid") for each in list_elements(item, "displayfeedback")} <= feedback_ids, name
            texts = " ".join(str(text.text) for text in list_elements(item, "mattext"))
            sources = {source.removeprefix("$IMS-CC-FILEBASE$../") for source in re.findall(r'src="([^"]*)"', texts)}
            assert sources and sources <= set(package), name
            assert "\\(" not in texts and "$" not in re.sub("[$]IMS", "", texts).replace("BASE$", ""), name
            (scored,) = [each for each in list_elements(item, "respcondition") if list_elements(each, "setvar")]
            if isinstance(form, NumberForm):
                number_item = item_by_key[name.removeprefix("hw-")].single_number_item
                field = (number_item.form if number_item else form).fields[0]  # type: ignore[union-attr]
                listed = tuple(str(each.text) for each in list_elements(scored, "varequal"))
                assert listed == list_accepted_texts(field.value, field.tolerance), name
                assert "Type each number as a decimal" in texts


def test_what_a_cartridge_cannot_ask_is_noted_once(export_request: ExportRequest, items: list[QuizItem]) -> None:
    notes: list[str] = []
    export_items(common_cartridge.export_common_cartridge, replace(export_request, report=notes.append), items)
    categories = dict.fromkeys(item.category for item in items if item.single_number_item)
    reduced = ", ".join(f"{category.slot_title} ({category.question_title})" for category in categories)
    assert reduced and notes == [
        "p3: Match is left out, because a Common Cartridge has no matching questions",
        f"a question of a Common Cartridge has one number, so these ask for one entry only: {reduced}",
    ]


# --- QTI 2.1 ---


def test_qti_package_is_converted_by_citolab(qti_file: bytes, tmp_path: Path) -> None:
    (tmp_path / "two.zip").write_bytes(qti_file)
    command = [require_reader("qti-convert"), "upgrade", str(tmp_path / "two.zip"), str(tmp_path / "three.zip")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    three = unzip((tmp_path / "three.zip").read_bytes())
    assert {name for name in unzip(qti_file) if name.startswith("items/")} <= set(three)
    item = parsed(three["items/p1-001-jacobian.xml"])
    assert len(list_elements(item, "qti-text-entry-interaction")) == 4 and list_elements(item, "math")


def test_qti_package_is_complete_and_marks_correctly(qti_file: bytes, items: list[QuizItem]) -> None:
    package = unzip(qti_file)
    manifest = parsed(package["imsmanifest.xml"])
    assert {str(each.get("href")) for each in list_elements(manifest, "file")} | {"imsmanifest.xml"} == set(package)
    for quiz_item in items:
        item = parsed(package[f"items/{quiz_item.key}.xml"])
        images = list_elements(item, "img")
        assert {f"images/{str(image.get('src')).rpartition('/')[2]}" for image in images} <= set(package)
        assert all(image.get("alt") for image in images)
        assert not [element for element in item.iter() if element.get("style")]
        declared = {str(each.get("identifier")) for each in list_elements(item, "responseDeclaration")}
        asks = [each for each in item.iter() if each.tag.endswith("Interaction")]
        assert {str(each.get("responseIdentifier")) for each in asks} == declared
        feedback_ids = {
            str(each.text) for each in list_elements(item, "baseValue") if each.get("baseType") == "identifier"
        }
        assert {str(each.get("identifier")) for each in list_elements(item, "modalFeedback")} <= feedback_ids
        if isinstance(quiz_item.form, NumberForm):
            for (value, held), field in zip(read_correct_numbers(item), quiz_item.form.fields, strict=True):
                assert abs(value - field.value) < 1e-8 and held
        elif (
            isinstance(quiz_item.form, ChoiceForm) and not quiz_item.form.has_fixed_order
        ):  # solutions say that the answer is B
            letters = ["".join(each.itertext()).strip()[:2] for each in list_elements(item, "simpleChoice")]
            assert letters == [f"{letter}." for letter in LETTERS[: len(letters)]]
            assert not [each for each in item.iter() if each.get("shuffle") == "true"]


def score_in_qti(item: Element, numbers: Sequence[float | None]) -> float:
    """Return the score that an item's response processing gives to numbers; None is a blank."""
    values = {f"R{k}": number for k, number in enumerate(numbers, 1)} | {"SCORE": 0.0, "numAttempts": 1}
    correct = {f"R{k}": number for k, (number, _) in enumerate(read_correct_numbers(item), 1)}

    def compute(node: Element) -> Any:
        kind, operands = node.tag.rpartition("}")[2], list(node)
        if kind in ("variable", "correct"):
            return (values if kind == "variable" else correct)[str(node.get("identifier"))]
        if kind == "baseValue":
            return float(node.text or "nan")
        results = list(map(compute, operands))
        if kind == "equal":
            tolerance = float(str(node.get("tolerance")).split()[0])
            return results[0] is not None and abs(results[0] - results[1]) <= tolerance
        functions: dict[str, Callable[..., Any]] = {
            "sum": lambda *n: sum(n), "and": lambda *n: all(n), "or": lambda *n: any(n), "not": operator.not_,
            "lt": operator.lt, "gte": operator.ge, "isNull": lambda value: value is None,
        }  # fmt: skip
        return functions[kind](*results)

    (processing,) = list_elements(item, "responseProcessing")
    for condition in processing:
        rules = next((list(branch)[1:] for branch in condition if compute(branch[0])), [])
        for rule in rules:
            if rule.get("identifier") == "SCORE":
                values["SCORE"] = compute(rule[0])
    return float(values["SCORE"] or 0)


def test_zeros_alone_earn_nothing_in_qti(export_request: ExportRequest, items: list[QuizItem]) -> None:
    """As in `qdot grade`, a zero earns nothing, and another number in its place cancels a right one."""
    matrix = next(item for item in items if isinstance(item.form, NumberForm) and len(item.form.fields) == 4)
    assert isinstance(matrix.form, NumberForm)
    first, *others = matrix.form.fields
    zero_field = replace(first, value=0.0, tolerance=0.001)
    form = NumberForm(((zero_field, others[0]), (others[1], others[2])))
    package = unzip(export_items(qti.export_qti, export_request, [replace(matrix, form=form)])["hw.zip"])
    item = parsed(package[f"items/{matrix.key}.xml"])
    correct, points = [field.value for field in others], matrix.points
    assert score_in_qti(item, [0, 0, 0, 0]) == 0 == score_in_qti(item, [7, 7, 7, 7])
    assert score_in_qti(item, [0, *correct]) == pytest.approx(points) == score_in_qti(item, [None, *correct])
    assert score_in_qti(item, [7, *correct]) == pytest.approx(points * 2 / 3)
    assert score_in_qti(item, [0, *correct[:2], 77]) == pytest.approx(points * 2 / 3)


def test_qti_test_selects_one_variant_of_each_problem(qti_file: bytes, items: list[QuizItem]) -> None:
    test = parsed(unzip(qti_file)["test.xml"])
    assert len(list_elements(test, "assessmentItemRef")) == len(items)
    places = [each for each in list_elements(test, "assessmentSection") if list_elements(each, "selection")]
    assert {str(each.get("identifier")) for each in places} == {item.key[:2] for item in items}
    for listed in places:
        keys = [item.key for item in items if item.key[:2] == listed.get("identifier")]
        assert [each.get("select") for each in list_elements(listed, "selection")] == ["1"]
        variants = [each for each in list_elements(listed, "assessmentSection") if each is not listed]
        assert len(variants) == len({key[:6] for key in keys})
        refs = [
            str(each.get("identifier")) for variant in variants for each in list_elements(variant, "assessmentItemRef")
        ]
        assert refs == keys
    (control,) = list_elements(test, "itemSessionControl")
    assert control.get("maxAttempts") == str(DEFAULT_ATTEMPTS)
    (outcome,) = list_elements(test, "outcomeDeclaration")
    points = {item.key[:2] + item.category[2]: item.points for item in items}
    assert float(str(outcome.get("normalMaximum"))) == sum(points.values())


def read_correct_numbers(item: Element) -> list[tuple[float, bool]]:
    """Return the correct numbers of an item, and whether the tolerance accepts three digits of each."""
    numbers = []
    conditions = list_elements(item, "responseIf")
    for declared, condition in zip(list_elements(item, "responseDeclaration"), conditions, strict=False):
        value = float(list_elements(declared, "value")[0].text or "nan")
        (equal,) = list_elements(condition, "equal")
        low, _ = map(float, str(equal.get("tolerance")).split())
        numbers.append((value, abs(float(f"{value:.2e}") - value) <= low))
    return numbers
