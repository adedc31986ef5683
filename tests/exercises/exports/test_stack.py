"""STACK questions: Maxima evaluates the response trees for every question test of exported questions.

STACK itself runs them in tests/platforms/stack.py.
"""

import io
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.known_wrong_answers import compare_entry_by_entry
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.stack_parts import _are_usable, convert_part
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.printers.maxima import print_maxima
from qdot.exercises.formula.program import compile_program
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.generation import generate
from qdot.exercises.problem.credit import Credit
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.marking.marking import compute_earned_share
from tests.support import read_cases, read_data
from tests.support.programs import MAXIMA, require_program
from tests.support.submitting import make_class

TOML = read_data("assignments/stack.toml")
PLUGIN = "plugin_qtype_stack_question"
OWN_EQUALITY = "test_AlgEquiv(a, b, opt) := is(a = b)$"
"""Response trees compare integers and lists of integers."""
COMMON = r"""
test_NumAbsolute(a, b, opt) := is(abs(float(a) - float(b)) <= float(opt) * (1 + 1.0e-9))$
display2d: false$
linel: 100000$
ratprint: false$
"""


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    assignment = make_assignment(tmp_path_factory.mktemp("stack") / "hw", TOML)
    return ExportRequest(assignment, lambda _: [], variant_count=2, compute_earned_share=compute_earned_share)


def make_assignment(folder: Path, toml: str) -> Assignment:
    make_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(toml)
    return load_assignment(folder)


@pytest.fixture(scope="module")
def notes() -> list[str]:
    return []


@pytest.fixture(scope="module")
def exported_files(export_request: ExportRequest, notes: list[str]) -> list[ExportedFile]:
    return list(EXPORT_FORMATS["stack"].export(replace(export_request, report=notes.append)))


@pytest.fixture(scope="module")
def quiz(exported_files: list[ExportedFile]) -> ET.Element:
    file = exported_files[0]
    assert file.is_private and file.path == "hw-stack.xml"
    return ET.fromstring(file.content)


def list_questions(quiz: ET.Element) -> list[ET.Element]:
    return [question for question in quiz if question.get("type") == "stack"]


def get_text(element: ET.Element, path: str) -> str:
    match = element.find(path)
    assert match is not None, path
    return match.text or ""


def find_question(quiz: ET.Element, name: str) -> ET.Element:
    return next(
        element for element in list_questions(quiz) if get_text(element, "name/text").startswith(f"p1-001, {name}:")
    )


def test_each_part_is_a_question_in_its_category_with_its_points(
    quiz: ET.Element, export_request: ExportRequest
) -> None:
    categories = [get_text(question, "category/text") for question in quiz if question.get("type") == "category"]
    assert categories[:2] == [
        "$course$/top/Velocity kinematics//1/p1 planar-2r/1. Position of the point",
        "$course$/top/Velocity kinematics//1/p1 planar-2r/2. Jacobian by differentiation",
    ]
    assert categories[6:] == ["$course$/top/Velocity kinematics//1/p2 polar-rp/1. Manipulability at a configuration"]
    assert len(list_questions(quiz)) == 2 * len(categories) == 14
    for path in ("idnumber", "name/text"):
        assert len({get_text(question, path) for question in list_questions(quiz)}) == 14
    assert len({get_text(question, "questionnote/text") for question in list_questions(quiz)}) == 4
    assert [get_text(question, "defaultgrade") for question in list_questions(quiz)][:12:2] == [*"121121"]
    assert {get_text(tree, "value") for tree in quiz.findall("question/prt")} == {"1.0000000"}
    problem = next(iter(iterate_bank(replace(export_request, variant_count=1)))).problem
    determinant = problem.parts[2].answer
    assert isinstance(determinant, Expression)
    text = get_text(find_question(quiz, "determinant"), "questiontext/text")
    assert format_expression(determinant.reference) not in text


def test_quiz_contains_the_questions_of_the_bank(quiz: ET.Element, exported_files: list[ExportedFile]) -> None:
    backup = exported_files[1]
    assert backup.is_private and backup.path == "hw-stack.mbz" and isinstance(backup.content, bytes)
    with zipfile.ZipFile(io.BytesIO(backup.content)) as archive:
        bank, activity = (ET.fromstring(archive.read(name)) for name in ("questions.xml", "activities/quiz_1/quiz.xml"))
    assert [slot.text for slot in activity.iter("maxmark")] == [f"{n}.0000000" for n in (1, 2, 1, 1, 2, 1, 1)]
    restored = [question for question in bank.iter("question") if question.findtext("qtype") == "stack"]
    assert len(restored) == len(list_questions(quiz)) == 14
    for question, imported in zip(restored, list_questions(quiz), strict=True):
        plugin = question.find("plugin_qtype_stack_question")
        assert plugin is not None
        pairs = [
            ("name", "name/text"), ("questiontext", "questiontext/text"), ("generalfeedback", "generalfeedback/text"),
            (f"{PLUGIN}/stackoptions/questionvariables", "questionvariables/text"),
            (f"{PLUGIN}/stackprts/stackprt/feedbackvariables", "prt/feedbackvariables/text"),
            (f"{PLUGIN}/stackinputs/stackinput/options", "input/options"),
        ]  # fmt: skip
        for path, imported_path in pairs:
            assert question.findtext(path) == imported.findtext(imported_path), path
        for tag, imported_tag in (("truefeedback", "truefeedback/text"), ("falseanswernote", "falseanswernote")):
            nodes = [node.findtext(tag) for node in plugin.iter("stackprtnode")]
            assert nodes == [node.findtext(imported_tag) for node in imported.findall("prt/node")]
        expected, restored_tests = ([test.text for test in e.iter("expectedanswernote")] for e in (imported, plugin))
        assert restored_tests == expected


def test_categories_have_the_names_of_moodles_questions(export_request: ExportRequest, quiz: ET.Element) -> None:
    bank = ET.fromstring(next(iter(EXPORT_FORMATS["moodle"].export(replace(export_request, variant_count=1)))).content)
    paths = [[get_text(path, "text") for path in root.iter("category")] for root in (bank, quiz)]
    assert set(paths[1]) < set(paths[0])  # the questions that STACK can't ask have categories only in Moodle


def test_copies_of_a_question_are_left_out_and_reported(tmp_path: Path) -> None:
    """All variants have the same arm; the numbers of the second question differ, the formulas of the first don't."""
    toml = 'title = "T"\nkey = "hw"\n[[problem]]\nrobot = "al5d"\nquestions = ["position", "speed"]\n'
    messages: list[str] = []
    assignment = make_assignment(tmp_path / "hw", toml)
    request = ExportRequest(
        assignment, lambda _: [], variant_count=3, report=messages.append, compute_earned_share=compute_earned_share
    )
    file, _ = EXPORT_FORMATS["stack"].export(request)
    names = [get_text(question, "name/text") for question in list_questions(ET.fromstring(file.content))]
    assert names == ["p1-001, position: T", *(f"p1-00{n}, speed: T" for n in (1, 2, 3))]
    assert messages == [
        "p1 al5d: the 3 variants of 'Position of the point' contain only 1 different question; copies are left out"
    ]


def test_unsupported_parts_are_noted(notes: list[str], quiz: ET.Element) -> None:
    assert [(note.partition(":")[0], *re.findall("'([a-z-]+)'", note)) for note in sorted(notes)] == [
        ("p1", "determinant"), ("p1", "determinant"), ("p2", "match-columns"),
    ]  # fmt: skip
    assert [word for word in ("rounded decimals", "factors", "letters") if word not in " ".join(notes)] == []


def test_texts_and_feedback_are_valid_castext(quiz: ET.Element) -> None:
    for question in list_questions(quiz):
        text = get_text(question, "questiontext/text")
        assert get_text(question, "input/name") == "ans1" and get_text(question, "prt/name") == "prt1"
        assert re.findall(r"\[\[(\w+:\w+)\]\]", text) == ["input:ans1", "validation:ans1", "feedback:prt1"]
        assert r"\(" in text and "$" not in text and "<math" not in text
        assert text.count("<details>") == 3
        shown = re.findall(r'src="@@PLUGINFILE@@/([\w.-]+)" alt="[^"]{20,}"', text)
        assert shown == [file.get("name") for file in question.findall("questiontext/file")] and shown
        assert text.count('style="max-width: 100%; height: auto"') == len(shown)  # no wider than Moodle's column
        assert "<table>" not in get_text(question, "generalfeedback/text")
        assert "<table>" not in text and '<table class="generaltable ' in text  # Moodle draws lines for this class
    texts = [get_text(element, "text") for element in quiz.iter() if element.tag in ("truefeedback", "falsefeedback")]
    filled = [text for text in texts if text]
    assert filled and all(
        text.startswith(("<p>", "[[if ")) and "&lt;p" not in text and "&#" not in text for text in filled
    )
    assert any('</p><p>{@right@} of 2 entries are right.</p>[[if test="error_count>0"]]<p>' in text for text in filled)


def test_formulas_are_compared_at_regular_points_only() -> None:
    """At a1 = 0.5 and 0.6, no value may be imaginary, undefined or huge, and no pivot nearly zero."""
    for entry in ("3*a1", "sqrt(a1 - 1)", "1/(a1 - 1/2)", "100000*a1", "(a1 - 1/2)/8"):
        program = compile_program([parse_formula(entry, {"a1": "length"})])
        assert _are_usable(program, [{"a1": 0.6}, {"a1": 0.5}], 0) == (entry == "3*a1"), entry


def test_example_of_typed_set_uses_the_joints_of_the_arm() -> None:
    for family, typed in (("cylindrical", "{theta1 = pi/3, d3 = 1/2}"), ("planar-2r", "{theta2 = 1/2, theta2 = pi/3}")):
        problem = generate(ProblemId(family, 3, ("singular-angles",)))
        converted = convert_part(problem, problem.parts[0], compute_earned_share)
        assert not isinstance(converted, str) and typed in converted.expected_answer


def test_node_notes_are_unique_and_reached_by_tests(quiz: ET.Element) -> None:
    for question in list_questions(quiz):
        reached = {get_text(element, "expectedanswernote") for element in question.findall("qtest/expected")}
        nodes = question.findall("prt/node")
        notes = [get_text(node, f"{way}answernote") for node in nodes for way in ("true", "false")]
        assert len(set(notes)) == len(notes) and not [note for note in notes if ";" in note or "|" in note]
        assert {get_text(node, "trueanswernote") for node in nodes} <= reached
        assert [get_text(node, "falsenextnode") for node in nodes] == [*map(str, range(1, len(nodes))), "-1"]
    assert {"prt1-right", "prt1-other"} <= reached


def run_maxima(script: str, folder: Path) -> list[str]:
    program = require_program("maxima", MAXIMA)
    path = folder / "tests.mac"
    path.write_text(script)
    command = [program, "--very-quiet", "--batch-string", f'batchload("{path}")$']
    done = subprocess.run(command, capture_output=True, text=True, timeout=400)
    return [line.strip() for line in done.stdout.splitlines()]


def convert_tree(tree: ET.Element) -> str:
    """Return a response tree as one Maxima expression: [note, score]."""
    expression = ""
    for node in reversed(tree.findall("node")):
        test = f"test_{get_text(node, 'answertest')}({get_text(node, 'sans')}, {get_text(node, 'tans')}, "
        test += f"{get_text(node, 'testoptions') or 0}) = true"
        yes = f'["{get_text(node, "trueanswernote")}", {get_text(node, "truescore")}]'
        no = expression or f'["{get_text(node, "falseanswernote")}", {get_text(node, "falsescore")}]'
        expression = f"(if {test} then {yes} else {no})"
    return expression


def make_script(quiz: ET.Element) -> tuple[str, list[str]]:
    """Return a script that runs all question tests, and the lines that it should print."""
    lines, expected = [OWN_EQUALITY, COMMON], []
    for q, question in enumerate(list_questions(quiz)):
        lines.append(get_text(question, "questionvariables/text"))
        tree = question.find("prt")
        assert tree is not None
        for test in question.findall("qtest"):
            value, note = get_text(test, "testinput/value"), get_text(test, "expected/expectedanswernote")
            if note == "NULL":
                assert not get_text(test, "expected/expectedscore")
                if value != "qdot_unknown(1)":  # no function of qdot, but STACK reports it
                    validator = get_text(question, "input/options").removeprefix("validator:")
                    lines.append(f'print("RAN", "{q} is invalid:", is({validator}({value}) # ""));')
                    expected.append(f"RAN {q} is invalid: true")
                continue
            label = f"{q} {get_text(test, 'testcase')}"
            lines.append(f"ans1: {value}; {get_text(tree, 'feedbackvariables/text')}")
            lines.append(f"found: {convert_tree(tree)};")
            lines.append(f'print("RAN", "{label}", first(found), round(10000*float(second(found))));')
            expected.append(f"RAN {label} {note} {round(10000 * float(get_text(test, 'expected/expectedscore')))}")
    return "\n".join(lines).replace(";", "$"), expected


@pytest.mark.integration
def test_question_tests_pass_in_maxima(quiz: ET.Element, tmp_path: Path) -> None:
    script, expected = make_script(quiz)
    assert len(expected) > 80
    assert [line for line in run_maxima(script, tmp_path) if line.startswith("RAN")] == expected


def test_question_tests_of_a_determinant_pass_in_maxima(quiz: ET.Element, tmp_path: Path) -> None:
    first = ET.Element("quiz")
    first.append(find_question(quiz, "determinant"))
    script, expected = make_script(first)
    assert expected
    assert [line for line in run_maxima(script, tmp_path) if line.startswith("RAN")] == expected


CASES = read_cases("stack")
SIGN_AND_FACTOR_ERRORS = (
    "block([u: qdot_values(qdot_read({})), w: qdot_values({})],"
    " qdot_sign_and_factor_errors(u, w, qdot_agree(u, w), {}))"
)
FOUND_AND_FALSE = (
    "block([c: qdot_conditions({}), t: [theta2 = %pi/2, theta2 = -%pi/2]],"
    " [qdot_count_found(c, t), qdot_false_conditions(c, t)])"
)
SAME, INVALID_FORMULA = "qdot_same(qdot_values(qdot_read({})), {})", 'is(qdot_check_formulas({}) # "")'
INVALID_SET = 'is(qdot_check_set({}) # "")'
FORMULAS = [
    *((SAME.format(*pair), value) for key, value in (("same", "1"), ("different", "0")) for pair in CASES[key]),
    *((SIGN_AND_FACTOR_ERRORS.format(*case), str(count)) for *case, count in CASES["sign_and_factor_errors"]),
    *((INVALID_FORMULA.format(typed), "false") for typed in CASES["valid_formulas"]),
    *((INVALID_FORMULA.format(typed), "true") for typed in CASES["invalid_formulas"]),
]
SETS = [
    *((FOUND_AND_FALSE.format(typed), counts) for typed, counts in CASES["sets"]),
    *((INVALID_SET.format(typed), "false") for typed, _ in CASES["sets"]),
    *((INVALID_SET.format(typed), "true") for typed in CASES["invalid_sets"]), *map(tuple, CASES["calls"]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "cases"), [("determinant", FORMULAS), ("singular-angles", SETS)])
def test_typed_answers_are_judged_as_by_qdot(
    quiz: ET.Element, tmp_path: Path, name: str, cases: list[tuple[str, str]]
) -> None:
    """Shorthand, lengths by name, decimals, sets: STACK's question gives the same verdict in Maxima as qdot."""
    operators = 'prefix("#pm#"); infix("nounor", 60, 60);'  # STACK has these operators for +- and or
    lines = [COMMON, operators, get_text(find_question(quiz, name), "questionvariables/text")]
    lines += [f'print("RAN", {typed});' for typed, _ in cases]
    printed = [line for line in run_maxima("\n".join(lines).replace(";", "$"), tmp_path) if line.startswith("RAN")]
    expected = [f"RAN {value}" for _, value in cases]
    assert printed == expected, [case for case, line in zip(cases, printed, strict=False) if line != f"RAN {case[1]}"]


def test_part_marked_as_a_whole_earns_no_partial_credit(export_request: ExportRequest) -> None:
    problem = next(iter(iterate_bank(replace(export_request, variant_count=1)))).problem
    for name in ("position", "jacobian", "joint-rates"):
        converted = convert_part(problem, replace(problem[name], credit=Credit("whole")), compute_earned_share)
        assert not isinstance(converted, str), name
        assert {case.score for case in converted.question_tests} <= {0, 1, None}, name
        if name == "joint-rates":
            assert "share: 0;" in converted.marking_lines


def test_directions_are_converted_and_sets_that_couple_joints_are_refused() -> None:
    problem = generate(ProblemId("planar-3r", 3, ("self-motion",)))
    converted = convert_part(problem, problem.parts[0], compute_earned_share)
    assert not isinstance(converted, str) and "form1: -3*ta1;" in converted.variables
    assert converted.question_tests[1].value == "form1"
    tied = generate(ProblemId("puma-560", 3, ("singular-angles",)))
    refused = convert_part(tied, tied.parts[0], compute_earned_share)
    assert isinstance(refused, str) and "does not consist of values of a single joint" in refused


def test_maxima_text_keeps_the_formula() -> None:
    problem: Problem = generate(ProblemId("planar-2r", 5, ("inverse-jacobian", "determinant")))
    for part in problem.parts:
        answer = part.answer
        assert isinstance(answer, (Expression, Matrix))
        for entry in answer.reference if isinstance(answer, Matrix) else [answer.reference]:
            again = sp.sympify(print_maxima(entry).replace("%pi", "pi").replace("^", "**"))
            assert compare_entry_by_entry(problem, sp.Matrix([again]), sp.Matrix([entry])) == (True,)
