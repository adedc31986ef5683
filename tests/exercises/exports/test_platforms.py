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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from exercises.answers import LETTERS
from exercises.assignment import FEEDBACK
from exercises.exports import canvas, jupyterquiz, moodle, qti
from exercises.exports import items as made
from exercises.exports.items import Choose, Item, Match, Numeric, Option, Wrong, items
from exercises.exports.outlet import Order
from exercises.several import Several
from tests.exercises.exports.test_items import an_order
from tests.support.programs import reader

pytestmark = pytest.mark.xdist_group("platforms")  # exported once

TOML = """title = "Arms & <signs> / more"
key = "hw"
hints = true
feedback = "solutions"
[[problem]]
family = "planar-2r"
questions = ["jacobian", "determinant", "joint-effect"]
[[problem]]
family = "planar-2r"
questions = ["dependence", "true-or-false"]
"""


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> Order:
    return an_order(tmp_path_factory.mktemp("platforms"), TOML, 2)


@pytest.fixture(scope="module")
def asked(order: Order) -> list[Item]:
    """The assignment's items, and one of columns to match, which takes long to draw."""
    made = list(items(order))
    form = Match((r"$\begin{bmatrix} a_{1} \\ 0 \end{bmatrix}$", "$b < c$"), ("joint 1", "joint 2", "no joint"), (1, 2))
    one = replace(made[0], key="p3-001-match", category=("T", "p3", "Match"), form=form, number=None, title="Match")
    nasty = Option(r"$a < b$ & c", False, 'Say } # ~ / \\ " <b> & {1:NUMERICAL:=1}')
    several = replace(one, key="p4-001-nasty", category=("T", "p4", "Nasty"), form=Choose((nasty, Option("$c$", True))))
    return [*made, one, several]


def file_of(outlet: Callable[[Order], Iterator[Any]], order: Order, asked: list[Item]) -> list[Any]:
    with pytest.MonkeyPatch.context() as patch:
        for module in (made, moodle, jupyterquiz):
            patch.setattr(module, "items", lambda _: iter(asked))
        return list(outlet(order))


def unzipped(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        assert {info.date_time for info in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        return {name: package.read(name) for name in package.namelist()}


def at_level(order: Order, level: str, **more: Any) -> Order:
    return replace(order, assignment=replace(order.assignment, feedback=level), **more)


@pytest.mark.parametrize("level", FEEDBACK)
def test_platforms_tell_as_much_as_the_assignment_does(order: Order, level: str) -> None:
    """Mistakes, values and solutions from their levels on; solutions also where they are ordered."""
    at = FEEDBACK.index(level)
    told = at_level(order, level)
    asked = list(items(told))
    forms = [one.form for one in asked]
    wrong = [option.feedback for form in forms if isinstance(form, Choose) for option in form.options]
    wrong += [
        each.advice for form in forms if isinstance(form, Numeric) for field in form.fields for each in field.wrong
    ]
    assert any(wrong) == (at >= FEEDBACK.index("mistake"))
    _, ordered_quiz = file_of(moodle.moodle_files, replace(told, solutions=True), asked)

    _, quiz = file_of(moodle.moodle_files, told, asked)
    settings = ElementTree.fromstring(unzipped(quiz.content)["activities/quiz_1/quiz.xml"])
    assert unzipped(ordered_quiz.content) == unzipped(quiz.content)  # its settings are the teacher's
    values, solutions = (settings.findtext(f"quiz/review{name}") for name in ("rightanswer", "generalfeedback"))
    after, closed = str(0x01110), str(0x00010)
    assert values == (after if at >= FEEDBACK.index("values") else closed)
    assert solutions == (after if level == "solutions" else closed)

    for ordered in (told, replace(told, solutions=True)):
        tells = level == "solutions" or ordered.solutions
        (file,) = file_of(qti.qti_zip, ordered, asked)
        each = [text for name, text in unzipped(file.content).items() if name.startswith("items/")]
        assert {b'identifier="solution"' in text for text in each} == {tells}
        (file,) = file_of(canvas.canvas_zip, ordered, asked)
        package = unzipped(file.content)
        assert (b'"general_fb"' in package["qdot-hw/qdot-hw.xml"]) == tells
        shown = b"<show_correct_answers>true" in package["qdot-hw/assessment_meta.xml"]
        assert shown == (at >= FEEDBACK.index("values") or ordered.solutions)


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


def moodle_faults(page: str) -> list[str]:
    """Return what Moodle's importer would refuse or lose."""
    faults: list[str] = []
    root = ElementTree.fromstring(page)
    known: set[str] = set()
    for question in root.findall("question"):
        kind, name = question.get("type"), question.findtext("name/text", "")
        if kind == "category":
            category = question.findtext("category/text", "")
            faults += [] if category.startswith("$course$/top/") else [f"category {category}"]
            continue
        faults += [
            f"{name}: no {tag}" for tag in ("questiontext", "generalfeedback", "idnumber") if not have(question, tag)
        ]
        number = question.findtext("idnumber", "")
        faults += [f"{name}: idnumber {number}"] if number in known or len(number) > 100 else []
        known.add(number)
        for part in ("questiontext", "generalfeedback"):
            text = question.findtext(f"{part}/text", "")
            wanted = set(re.findall(r'src="@@PLUGINFILE@@/([^"]+)"', text))
            given = {str(file.get("name")): file.text or "" for file in question.findall(f"{part}/file")}
            faults += [f"{name}: files {wanted ^ set(given)}"] if wanted != set(given) else []
            faults += [
                f"{name}: {file} is no drawing" for file, data in given.items() if b"<svg" not in base64.b64decode(data)
            ]
            faults += [f"{name}: image without words"] if re.search(r'<img(?![^>]*alt="[^"]+)', text) else []
            faults += [f"{name}: formula left"] if "$" in text or "<math" in text else []
        faults += answers_faults(question, str(kind), name)
    return faults


def have(question: ElementTree.Element, tag: str) -> bool:
    found = question.find(tag)
    return found is not None and bool((found.findtext("text") or found.text or "").strip())


def answers_faults(question: ElementTree.Element, kind: str, name: str) -> list[str]:
    fractions = [str(answer.get("fraction")) for answer in question.findall("answer")]
    faults = [f"{name}: fraction {f}" for f in fractions if f.removeprefix("-") not in GRADES]
    right = sum(float(f) for f in fractions if float(f) > 0)
    text = question.findtext("questiontext/text", "")
    if kind in ("multichoice", "numerical", "truefalse"):
        faults += [] if abs(right - 100) < 0.01 else [f"{name}: {right} in all"]
    if kind == "numerical":
        values = [answer.findtext("text", "") for answer in question.findall("answer")]
        faults += [f"{name}: {value}" for value in values if not re.fullmatch(NUMBER, value)]
        tolerances = [answer.findtext("tolerance") for answer in question.findall("answer")]
        faults += [f"{name}: no tolerance"] if None in tolerances else []
    elif kind == "truefalse":
        faults += [] if [a.findtext("text") for a in question.findall("answer")] == ["true", "false"] else [name]
    elif kind == "matching":
        pairs = question.findall("subquestion")
        asked = [pair for pair in pairs if (pair.findtext("text") or "").strip()]
        faults += (
            [] if len(asked) >= 2 and len({p.findtext("answer/text") for p in pairs}) >= 3 else [f"{name}: few pairs"]
        )
    elif kind == "cloze":
        faults += [] if len(CLOZE.findall(text)) == text.count(":NUMERICAL:") > 1 else [f"{name}: embedded answers"]
    elif kind != "multichoice":
        faults.append(f"{name}: type {kind}")
    return faults


def test_moodle_xml_keeps_moodles_rules(order: Order, asked: list[Item]) -> None:
    file, _ = file_of(moodle.moodle_files, order, asked)
    assert file.path == "hw.xml"
    assert file.private
    assert moodle_faults(file.content) == []
    root = ElementTree.fromstring(file.content)
    kinds = {question.get("type") for question in root.findall("question")}
    assert kinds == {"category", "cloze", "numerical", "multichoice", "truefalse", "matching"}
    category = root.findtext("question/category/text", "")
    assert category == "$course$/top/Arms & ‹signs› // more/p1 planar-2r/Jacobian by differentiation"
    names = [*root.findall("question/category"), *root.findall("question/name")]
    assert not any("<" in name.findtext("text", "") for name in names)  # Moodle takes it for a tag, and cuts it
    assert len(root.findall("question/hint")) >= 3
    text = root.findtext("question[@type='cloze']/questiontext/text", "")
    assert r"\[" in text
    assert len(CLOZE.findall(text)) == 4
    feedback = [f.text for f in root.iter("text") if f.text and "Say }" in f.text]
    assert feedback == ["Say } # ~ / \\ &quot; &lt;b&gt; &amp; {1:NUMERICAL:=1}"]


@pytest.mark.parametrize(
    ("broken", "into", "said"),
    [
        ('fraction="100"', 'fraction="15"', "fraction 15"),
        ("@@PLUGINFILE@@/arm.svg", "@@PLUGINFILE@@/other.svg", "files"),
        ("<tolerance>", "<tol>", "no tolerance"),
        (":NUMERICAL:=", ":NUMERICAL:=x", "embedded answers"),
        ('alt="', 'title="', "image without words"),
    ],
)
def test_what_moodle_would_refuse_is_found(order: Order, asked: list[Item], broken: str, into: str, said: str) -> None:
    file, _ = file_of(moodle.moodle_files, order, asked)
    page = file.content.replace(broken, into).replace("</tolerance>", "</tol>" if into == "<tol>" else "</tolerance>")
    page = page.replace("alt=&#34;", "title=&#34;") if said.startswith("image") else page
    assert any(said in fault for fault in moodle_faults(page))


def test_options_in_moodle_have_the_letters_of_their_solutions(order: Order, asked: list[Item]) -> None:
    bank, quiz = file_of(moodle.moodle_files, order, asked)
    root, package = ElementTree.fromstring(bank.content), unzipped(quiz.content)
    restored = ElementTree.fromstring(package["questions.xml"])
    for shuffled in (*root.iter("shuffleanswers"), *restored.iter("shuffleanswers")):
        assert shuffled.text in ("false", "0")
    settings = ElementTree.fromstring(package["activities/quiz_1/quiz.xml"])
    assert settings.findtext("quiz/shuffleanswers") == "0"
    lettered = [f"{letter}. " for letter in LETTERS]
    chosen = [one for one in asked if isinstance(one.form, Choose) and not one.form.fixed]
    for question in root.findall("question[@type='multichoice']"):
        one = next(one for one in asked if question.findtext("idnumber", "").endswith(one.key))
        begins = [answer.findtext("text", "")[:3] for answer in question.findall("answer")]
        assert begins == lettered[: len(begins)] if one in chosen else not {*begins} & {*lettered}
        assert question.findtext("answernumbering") == "none"
    stems = [stem.findtext("text", "")[:3] for stem in root.findall("question[@type='matching']/subquestion")]
    assert [stem for stem in stems if stem] == lettered[:2]


def test_moodles_reader_loses_no_space(order: Order, asked: list[Item]) -> None:
    file, _ = file_of(moodle.moodle_files, order, asked)
    whole = re.sub(r"<!\[CDATA\[.*?\]\]>", "", file.content, flags=re.DOTALL)
    assert "&" not in whole  # it drops the space in `&gt; &lt;`
    assert r"A. \(a &lt; b\) &amp; c" in list(ElementTree.fromstring(file.content).itertext())


def test_tables_have_the_class_that_moodle_shows_them_by(order: Order, asked: list[Item]) -> None:
    file, _ = file_of(moodle.moodle_files, order, asked)
    tables = re.findall(r"<table[^>]*>\s*<thead", file.content)
    assert len(tables) == 12
    assert all("generaltable" in table for table in tables)


def test_a_small_window_moves_a_wide_table_and_nothing_else(order: Order, asked: list[Item]) -> None:
    """DH tables and matrices of boxes are wider than a telephone; a page as wide as they are is hard to read."""
    file, _ = file_of(moodle.moodle_files, order, asked)
    assert "</tbody>" in file.content
    assert file.content.count("<table") == len(
        re.findall(r'<div style="overflow-x: auto; position: relative">\s*<table', file.content)
    )
    assert file.content.count("</table>") == len(re.findall(r"</table>\s*</div>", file.content))


def test_figures_are_no_wider_than_the_page(order: Order, asked: list[Item]) -> None:
    """Moodle's column on a small window is narrower than our figures, which would cover what is beside it."""
    file, _ = file_of(moodle.moodle_files, order, asked)
    figures = re.findall(r"<img [^>]*>", file.content)
    assert len(figures) >= len(asked)
    assert [figure for figure in figures if 'style="max-width: 100%; height: auto"' not in figure] == []


def first_changed(item: Item, **changes: Any) -> list[str]:
    """Return what Moodle is told of the boxes of a matrix, the first of them changed."""
    assert isinstance(item.form, Numeric)
    ((first, *rest), *rows) = item.form.rows
    form = replace(item.form, rows=((replace(first, **changes), *rest), *rows))  # type: ignore[type-var]
    return [box.notation for box in moodle._boxes(form)]


def test_no_box_is_as_wide_as_its_answer(asked: list[Item]) -> None:
    for value, tolerance, width in ((0.5, 0.0025, 12), (-0.00012345678, 5e-12, 14)):
        boxes = [CLOZE.fullmatch(box) for box in first_changed(asked[0], value=value, tolerance=tolerance)]
        assert {len(box[5]) for box in boxes if box} == {width}
        numbers = [number for box in boxes if box for number in re.findall(rf"(?:=|%)({NUMBER})(?=:)", box[0])]
        assert max(map(len, numbers)) <= width


def test_an_embedded_answers_advice_cannot_end_it(asked: list[Item]) -> None:
    wrong = Wrong(9.0, 0.045, "Nasty", 'ends } here # or ~ there / \\ "q" <b> & {2:NUMERICAL:=5}')
    boxes = first_changed(asked[0], wrong=(wrong,))
    assert all(CLOZE.fullmatch(box) for box in boxes)
    read = html.unescape(boxes[0]).replace(r"\}", "}").replace(r"\#", "#")  # as Moodle reads it
    assert 'ends } here # or ∼ there / \\ "q" &lt;b&gt; &amp; {2:NUMERICAL:=5}' in read


def quiz_faults(package: dict[str, bytes], bank: ElementTree.Element) -> list[str]:
    """Return what Moodle would not find in a backup of a quiz, and what is not as in the bank that it imports."""
    read = {name: ElementTree.fromstring(data) for name, data in package.items() if name.endswith(".xml")}
    quiz, of = read["activities/quiz_1/quiz.xml"], read["questions.xml"]
    categories = {str(one.get("id")): one for one in of.findall("question_category")}
    parents = [one.findtext("parent") for one in categories.values()]
    faults = [] if parents.count("0") == 1 and {*parents} <= {"0", *categories} else [f"categories in {parents}"]
    named = [one.text for one in read["activities/quiz_1/inforef.xml"].findall(".//question_category/id")]
    faults += [] if named == list(categories) else [f"categories {named}"]
    for file in read["files.xml"]:
        digest = file.findtext("contenthash", "")
        content = package[f"files/{digest[:2]}/{digest}"]
        faults += [] if hashlib.sha1(content).hexdigest() == digest else [f"file {digest}"]
    asked = {str(one.get("id")): one for one in of.iter("question")}
    for one in asked.values():
        faults += question_faults(one, asked)
    slots = quiz.findall(".//question_instance")
    for slot in slots:
        drawn = categories[json.loads(slot.findtext(".//filtercondition", ""))["questioncategoryid"]]
        points = {q.findtext("defaultmark") for q in drawn.iter("question") if q.findtext("parent") == "0"}
        faults += [] if points == {slot.findtext("maxmark")} else [f"slot of {slot.findtext('maxmark')}: {points}"]
    whole = sum(float(slot.findtext("maxmark", "")) for slot in slots)
    faults += [] if float(quiz.findtext("quiz/grade", "")) == whole else [f"{whole} points in all"]
    wanted = [texts(one, "name/text", "generalfeedback/text") for one in bank if one.get("type") != "category"]
    given = [texts(one, "name", "generalfeedback") for one in asked.values() if one.findtext("parent") == "0"]
    return faults + ([] if wanted == given else ["texts"])


def texts(question: ElementTree.Element, *paths: str) -> list[str]:
    return [question.findtext(path, "") for path in paths]


def question_faults(one: ElementTree.Element, asked: dict[str, ElementTree.Element]) -> list[str]:
    """Return what is wrong with ids and marks in a question of a backup."""
    number, text = one.get("id"), one.findtext("questiontext", "")
    answers = {str(answer.get("id")) for answer in one.iter("answer") if answer.get("id")}
    paths = (".//numerical_record/answer", ".//trueanswer", ".//falseanswer")
    meant = [found.text for path in paths for found in one.findall(path)]
    faults = [] if {*meant} <= answers else [f"{number}: answers {meant}"]
    if one.findtext("qtype") == "multianswer":
        parts = [asked[part] for part in one.findtext(".//sequence", "").split(",")]
        faults += [f"{number}: parent"] if any(part.findtext("parent") != number for part in parts) else []
        faults += (
            [] if re.findall(r"{#(\d+)}", text) == [str(i + 1) for i in range(len(parts))] else [f"{number}: boxes"]
        )
        points = sum(float(part.findtext("defaultmark", "")) for part in parts)
        faults += [] if abs(points - float(one.findtext("defaultmark", ""))) < 1e-5 else [f"{number}: {points} points"]
    return faults


def test_moodles_quiz_draws_each_question_for_its_points(order: Order, asked: list[Item]) -> None:
    bank, quiz = file_of(moodle.moodle_files, order, asked)
    assert quiz.path == "hw.mbz"
    assert quiz.private
    package = unzipped(quiz.content)
    assert quiz_faults(package, ElementTree.fromstring(bank.content)) == []
    settings = ElementTree.fromstring(package["activities/quiz_1/quiz.xml"])
    assert settings.findtext("quiz/name") == "Arms & ‹signs› / more"
    points = [one.points for one in {one.category: one for one in asked}.values()]
    assert [float(slot.text or "") for slot in settings.iter("maxmark")] == points
    assert {settings.findtext(f"quiz/{name}") for name in ("attempts_number", "delay1", "timeclose")} == {"0"}
    assert settings.findtext("quiz/grademethod") == "4"  # the last counts


def test_moodles_quiz_has_the_assignments_attempts_and_end(order: Order, asked: list[Item]) -> None:
    due = datetime(2027, 1, 15, 12, tzinfo=UTC)
    limited = replace(order.assignment, attempts=Several(best_of=3, apart=3600), due=due)
    _, quiz = file_of(moodle.moodle_files, replace(order, assignment=limited), asked)
    settings = ElementTree.fromstring(unzipped(quiz.content)["activities/quiz_1/quiz.xml"])
    names = ("attempts_number", "grademethod", "delay1", "delay2", "timeclose")
    said = [settings.findtext(f"quiz/{name}") for name in names]
    assert said == ["3", "1", "3600", "3600", str(int(due.timestamp()))]


@pytest.mark.parametrize(
    ("broken", "into", "said"),
    [
        ("<contenthash>", "<contenthash>0", "file"),
        ("<sequence>", "<sequence>1,", "1"),
        ("{#1}", "{#2}", "boxes"),
        ("<maxmark>", "<maxmark>1", "slot"),
        ("<parent>1</parent>", "<parent>0</parent>", "categories"),
    ],
)
def test_what_moodle_would_not_find_in_a_backup_is_found(
    order: Order, asked: list[Item], broken: str, into: str, said: str
) -> None:
    bank, quiz = file_of(moodle.moodle_files, order, asked)
    package = {
        name: data.replace(broken.encode(), into.encode()) if name.endswith(".xml") else data
        for name, data in unzipped(quiz.content).items()
    }
    try:
        faults = quiz_faults(package, ElementTree.fromstring(bank.content))
    except KeyError as error:
        faults = [f"file {error}", "1"]
    assert any(said in fault for fault in faults)


# --- Canvas ---


def paths(root: ElementTree.Element, above: str = "") -> Iterator[str]:
    here = f"{above}/{root.tag.rpartition('}')[2]}"
    yield here
    yield from (f"{here}@{name.rpartition('}')[2]}" for name in root.attrib)
    for child in root:
        yield from paths(child, here)


TEXT2QTI = """Quiz title: T

1.  Choice
a)  6
... told
*c) 5

2.  Several
[*] 2
[ ] 3

3.  Numeric
... general
=   1.4142 +- 0.0001

4.  True
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


def test_canvas_is_given_what_text2qti_gives_it(order: Order, asked: list[Item], tmp_path: Path) -> None:
    (tmp_path / "quiz.txt").write_text(TEXT2QTI)
    subprocess.run([reader("text2qti"), "quiz.txt"], cwd=tmp_path, check=True, capture_output=True)
    golden = unzipped_any((tmp_path / "quiz.zip").read_bytes())
    known = {
        path for name, data in golden.items() if name.endswith(".xml") for path in paths(ElementTree.fromstring(data))
    }
    package = canvas_package(order, [one for one in asked if not isinstance(one.form, Match)])
    ours = {
        path for name, data in package.items() if name.endswith(".xml") for path in paths(ElementTree.fromstring(data))
    }
    assert sorted(ours - known) == []


def unzipped_any(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        return {name: package.read(name) for name in package.namelist()}


def canvas_package(order: Order, asked: list[Item]) -> dict[str, bytes]:
    (file,) = file_of(canvas.canvas_zip, order, asked)
    return unzipped(file.content)


def local(root: ElementTree.Element, tag: str) -> list[ElementTree.Element]:
    return [element for element in root.iter() if element.tag.rpartition("}")[2] == tag]


def canvas_faults(package: dict[str, bytes]) -> list[str]:
    """Return what Canvas would not find: files, answers, feedback that are named."""
    faults: list[str] = []
    manifest = ElementTree.fromstring(package["imsmanifest.xml"])
    listed = {str(file.get("href")) for file in local(manifest, "file")}
    faults += [f"files {sorted(listed ^ set(package))}"] if listed | {"imsmanifest.xml"} != set(package) else []
    quiz = ElementTree.fromstring(package["qdot-hw/qdot-hw.xml"])
    names = [str(item.get("ident")) for item in local(quiz, "item")]
    faults += ["two items of a name"] if len(set(names)) < len(names) else []
    for item in local(quiz, "item"):
        name = str(item.get("ident"))
        labels = {str(label.get("ident")) for label in local(item, "response_label")}
        said = {str(feedback.get("ident")) for feedback in local(item, "itemfeedback")}
        faults += [
            f"{name}: no feedback {d.get('linkrefid')}"
            for d in local(item, "displayfeedback")
            if d.get("linkrefid") not in said
        ]
        kind = [field[1].text for field in local(item, "qtimetadatafield") if field[0].text == "question_type"]
        equal = [str(each.text) for each in local(item, "varequal")]
        if kind == ["numerical_question"]:
            low, high = (float(local(item, tag)[0].text or "nan") for tag in ("vargte", "varlte"))
            faults += [] if low < float(equal[0]) < high else [f"{name}: range"]
        else:
            faults += [f"{name}: no answer {each}" for each in equal if each not in labels]
        score = sum(float(each.text or 0) for each in local(item, "setvar"))
        faults += [] if round(score, 6) == 100 else [f"{name}: {score} in all"]
        for text in local(item, "mattext"):
            for source in re.findall(r'src="([^"]*)"', text.text or ""):
                path = source.removeprefix("%24IMS-CC-FILEBASE%24/")
                faults += [] if path in package else [f"{name}: no image {path}"]
    return faults


def test_canvas_finds_all_that_is_named(order: Order, asked: list[Item]) -> None:
    notes: list[str] = []
    package = canvas_package(replace(order, note=notes.append), asked)
    assert canvas_faults(package) == []
    assert notes == ["Canvas takes one number a question: of vectors and matrices one entry is asked for"]
    quiz = ElementTree.fromstring(package["qdot-hw/qdot-hw.xml"])
    types = {f[1].text for f in local(quiz, "qtimetadatafield") if f[0].text == "question_type"}
    assert types == {
        "multiple_choice_question", "multiple_answers_question", "true_false_question", "matching_question",
        "numerical_question",
    }  # fmt: skip
    assert [number.text for number in local(quiz, "selection_number")] == ["1"] * 7
    texts = " ".join(str(text.text) for text in local(quiz, "mattext"))
    assert r"\(\theta_{1}\)" in texts
    assert "$" not in texts


@pytest.mark.parametrize(
    ("broken", "into", "said"),
    [
        (b'linkrefid="g', b'linkrefid="x', "feedback"),
        (b"images/arm", b"images/leg", "image"),
        (b"<vargte", b"<varlte", "range"),
    ],
)
def test_a_broken_package_for_canvas_is_found(
    order: Order, asked: list[Item], broken: bytes, into: bytes, said: str
) -> None:
    package = canvas_package(order, asked)
    quiz = (
        package["qdot-hw/qdot-hw.xml"]
        .replace(broken, into)
        .replace(b"</vargte", b"</varlte" if said == "range" else b"</vargte")
    )
    try:
        faults = canvas_faults(package | {"qdot-hw/qdot-hw.xml": quiz})
    except IndexError:
        faults = ["range"]
    assert any(said in fault for fault in faults)


# --- QTI 2.1 ---


def test_qti_is_read_by_citolab(order: Order, asked: list[Item], tmp_path: Path) -> None:
    (file,) = file_of(qti.qti_zip, order, asked)
    (tmp_path / "two.zip").write_bytes(file.content)
    command = [reader("qti-convert"), "upgrade", str(tmp_path / "two.zip"), str(tmp_path / "three.zip")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    three = unzipped_any((tmp_path / "three.zip").read_bytes())
    assert {name for name in unzipped(file.content) if name.startswith("items/")} <= set(three)
    item = ElementTree.fromstring(three["items/p1-001-jacobian.xml"])
    assert len(local(item, "qti-text-entry-interaction")) == 4
    assert local(item, "math")
    broken = file.content[: len(file.content) // 2]
    (tmp_path / "two.zip").write_bytes(broken)
    assert subprocess.run(command, capture_output=True).returncode != 0


VALIDATE = """
import sys
from lxml import etree
schema = etree.XMLSchema(etree.parse(sys.argv[1]))
for path in sys.argv[2:]:
    schema.assertValid(etree.parse(path))
"""


@pytest.mark.skipif("QDOT_QTI" not in os.environ, reason="QDOT_QTI doesn't name the schema of QTI 2.1")
def test_qti_holds_to_its_schema(order: Order, asked: list[Item], tmp_path: Path) -> None:
    (file,) = file_of(qti.qti_zip, order, asked)
    paths = []
    for name, content in unzipped(file.content).items():
        if name == "test.xml" or name.startswith("items/"):
            paths.append(tmp_path / name.replace("/", "-"))
            paths[-1].write_bytes(content)
    command = [reader("python", "lxml"), "-c", VALIDATE, os.environ["QDOT_QTI"]]
    done = subprocess.run([*command, *map(str, paths)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    broken = next(path for path in paths if path.name.startswith("items-"))
    broken.write_bytes(broken.read_bytes().replace(b"<itemBody", b"<itemsBody").replace(b"</itemB", b"</itemsB"))
    assert subprocess.run([*command, str(broken)], capture_output=True).returncode != 0


def test_qti_marks_as_it_should(order: Order, asked: list[Item]) -> None:
    (file,) = file_of(qti.qti_zip, order, asked)
    package = unzipped(file.content)
    manifest = ElementTree.fromstring(package["imsmanifest.xml"])
    assert {str(each.get("href")) for each in local(manifest, "file")} | {"imsmanifest.xml"} == set(package)
    for one in asked:
        item = ElementTree.fromstring(package[f"items/{one.key}.xml"])
        assert {f"images/{source.rpartition('/')[2]}" for source in sources(item)} <= set(package)
        assert all(image.get("alt") for image in local(item, "img"))
        assert not [element for element in item.iter() if element.get("style")]
        declared = {str(each.get("identifier")) for each in local(item, "responseDeclaration")}
        asks = [each for each in item.iter() if each.tag.endswith("Interaction")]
        assert {str(each.get("responseIdentifier")) for each in asks} == declared
        told = {str(each.text) for each in local(item, "baseValue") if each.get("baseType") == "identifier"}
        assert {str(each.get("identifier")) for each in local(item, "modalFeedback")} <= told
        if isinstance(one.form, Numeric):
            assert right_numbers(item) == [(field.value, True) for field in one.form.fields] or all(
                abs(value - field.value) < 1e-8 and held
                for (value, held), field in zip(right_numbers(item), one.form.fields, strict=True)
            )
    test = ElementTree.fromstring(package["test.xml"])
    assert len(local(test, "assessmentItemRef")) == len(asked)
    places = [each for each in local(test, "assessmentSection") if local(each, "selection")]
    assert {str(each.get("identifier")) for each in places} == {one.key[:2] for one in asked}
    for listed in places:
        assert [each.get("select") for each in local(listed, "selection")] == ["1"]
        variants = [each for each in local(listed, "assessmentSection") if each is not listed]
        assert len(variants) == len({one.key[:6] for one in asked if one.key[:2] == listed.get("identifier")})
        refs = [[str(each.get("identifier")) for each in local(variant, "assessmentItemRef")] for variant in variants]
        assert [one.key for one in asked if one.key[:2] == listed.get("identifier")] == [
            ref for each in refs for ref in each
        ]
    (control,) = local(test, "itemSessionControl")
    assert control.get("maxAttempts") == str(qti.TRIES)
    (outcome,) = local(test, "outcomeDeclaration")
    points = {one.key[:2] + one.category[2]: one.points for one in asked}
    assert float(str(outcome.get("normalMaximum"))) == sum(points.values())


def test_options_in_qti_have_the_letters_of_their_solutions(order: Order, asked: list[Item]) -> None:
    """Solutions say that the answer is B, so that B has to be on the screen, and to stay where it is."""
    (file,) = file_of(qti.qti_zip, order, asked)
    package = unzipped(file.content)
    for one in asked:
        if isinstance(one.form, Choose) and not one.form.fixed:
            item = ElementTree.fromstring(package[f"items/{one.key}.xml"])
            texts = ["".join(each.itertext()) for each in local(item, "simpleChoice")]
            assert [text.strip()[:2] for text in texts] == [f"{letter}." for letter in LETTERS[: len(texts)]]
            assert not [each for each in item.iter() if each.get("shuffle") == "true"]


def sources(item: ElementTree.Element) -> list[str]:
    return [str(image.get("src")) for image in local(item, "img")]


def right_numbers(item: ElementTree.Element) -> list[tuple[float, bool]]:
    """Return the right numbers of an item, and whether three digits of each are within what is allowed."""
    found = []
    conditions = local(item, "responseIf")
    for declared, condition in zip(local(item, "responseDeclaration"), conditions, strict=False):
        value = float(local(declared, "value")[0].text or "nan")
        (equal,) = local(condition, "equal")
        low, _ = map(float, str(equal.get("tolerance")).split())
        found.append((value, abs(float(f"{value:.2e}") - value) <= low))
    return found


# --- jupyterquiz ---

FOUND = """
import json, sys
from jupyterquiz.dynamic.loader import load_questions_script
script, static, _ = load_questions_script(sys.argv[1], "abc")
assert static
print(len(json.loads(script.partition("var questionsabc=")[2].partition(";\\n\\nif (typeof")[0])))
"""
FIELDS = {
    "multiple_choice": {"answer", "correct", "feedback"}, "many_choice": {"answer", "correct", "feedback"},
    "value": {"type", "value", "correct", "feedback"}, "range": {"type", "range", "correct", "feedback"},
    "default": {"type", "feedback"},
}  # fmt: skip
"""What jupyterquiz's schemas let an answer hold."""


def answered(question: dict[str, Any], number: float) -> tuple[bool, str]:
    """Return what jupyterquiz says to a number: the first answer that fits, as in its numeric.js."""
    default = ""
    for answer in question["answers"]:
        if answer["type"] == "default":
            default = answer["feedback"]
        elif answer["type"] == "range" and answer["range"][0] <= number < answer["range"][1]:
            return answer["correct"], answer["feedback"]
    return False, default


def quizzes(order: Order, asked: list[Item]) -> dict[str, Any]:
    return {file.path: json.loads(file.content) for file in file_of(jupyterquiz.jupyterquiz_files, order, asked)}


def test_jupyterquiz_is_given_what_its_schemas_say(order: Order, asked: list[Item]) -> None:
    notes: list[str] = []
    made = quizzes(replace(order, note=notes.append), asked)
    notebook = made.pop("quizzes.ipynb")
    assert len(made) == 7
    assert len(notes) == 1
    for name, questions in made.items():
        assert any(name in cell["source"] for cell in notebook["cells"])
        for question in questions:
            assert set(question) == {"question", "type", "answers"}
            assert "](" not in question["question"]  # it would be taken for a link
            assert "<table>" not in question["question"]  # JupyterLab would show it smaller than the text
            right = [answer for answer in question["answers"] if answer.get("correct")]
            assert len(right) == 1 or question["type"] == "many_choice"
            for answer in question["answers"]:
                assert set(answer) == FIELDS[answer.get("type", question["type"])]


def test_jupyterquiz_takes_three_digits_and_names_mistakes(order: Order, asked: list[Item]) -> None:
    made = quizzes(order, asked)
    for one, question in zip(
        [one for one in asked if "-determinant" in one.key], made["p1-determinant.json"], strict=True
    ):
        assert isinstance(one.form, Numeric)
        (field,) = one.form.fields
        assert answered(question, float(f"{field.value:.2e}")) == (True, "Right.")
        assert all(answered(question, wrong.value)[0] is False for wrong in field.wrong)
        assert answered(question, field.wrong[0].value)[1] == field.wrong[0].advice
        assert answered(question, 1e6) == (False, "Not this number.")


def test_jupyterquiz_reads_the_files(order: Order, asked: list[Item], tmp_path: Path) -> None:
    python = reader("python", "jupyterquiz")
    for file in file_of(jupyterquiz.jupyterquiz_files, order, asked):
        (tmp_path / file.path).write_text(file.content)
    command = [python, "-W", "ignore", "-c", FOUND]
    done = subprocess.run([*command, "p1-jacobian.json"], cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.strip() == "2", done.stderr
    (tmp_path / "broken.json").write_text("[{]")
    assert subprocess.run([*command, "broken.json"], cwd=tmp_path, capture_output=True).returncode != 0


def test_every_outlet_is_the_same_twice(order: Order, asked: Sequence[Item]) -> None:
    for outlet in (moodle.moodle_files, canvas.canvas_zip, qti.qti_zip, jupyterquiz.jupyterquiz_files):
        assert file_of(outlet, order, list(asked)) == file_of(outlet, order, list(asked))
