"""STACK questions: every question test of exported questions is run through Maxima, as the response trees say.

With QDOT_STACK=FOLDER, a checkout of maths/moodle-qtype_stack, STACK's own Maxima library compares the answers (it is
under the GPL, and no part of qdot); without it an equality of our own does, with 40 digits at fixed points.
"""

import os
import re
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from exercises.answers import Expression, Matrix
from exercises.assignment import Assignment, Student, load_assignment
from exercises.exports.bank import bank
from exercises.exports.known_wrong import known_wrong, same_entries
from exercises.exports.outlet import Order
from exercises.exports.registry import OUTLETS
from exercises.exports.stack_parts import asked, share_of
from exercises.formula.printers.maxima import maxima_text
from exercises.formula.text import text_of
from exercises.generation import generate
from exercises.problem import Problem, ProblemId
from grader.certify import failures_of
from grader.parts import judge
from grader.verdict import Outcome
from tests.support.handing_in import a_class
from tests.support.judging import diagnose, earned
from tests.support.programs import MAXIMA, needs

TOML = """title = "Velocity kinematics/1"
key = "hw"
hints = true
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "joint-rates", "singular-angles", "singularity-type"]
points = [1, 2, 1, 1, 2, 1]
credit = {jacobian = "columns"}
decimals = {determinant = 3}
[[problem]]
family = "polar-rp"
questions = ["manipulability", "match-columns"]
"""

LETTERS_OF_SEVERAL = "letters of several options are not asked; the outlets with quizzes ask them"

OWN_EQUALITY = r"""
fpprec: 40$
points: [3/7, 11/13, 5/9]$
number(x) := errcatch(bfloat(rectform(x)))$
at_point(x, k) := block([v: listofvars(x)],
  number(subst(makelist(v[i] = points[k]*(i + k)/(k + 2), i, 1, length(v)), x)))$
zero_at(a, b, k) := block([d: at_point(a - b, k), s: at_point(abs(a) + abs(b) + 1, k)],
  is(d # [] and s # [] and cabs(d[1]) < 1.0b-30*cabs(s[1])))$
algebraic_equivalence(a, b) := is(zero_at(a, b, 1) = true and zero_at(a, b, 2) = true and zero_at(a, b, 3) = true)$
num_ensure_rational(x) := if floatnump(x) then ratdisrep(rat(x)) elseif atom(x) then x
  else apply(op(x), map('num_ensure_rational, args(x)))$
test_AlgEquiv(a, b, opt) := if matrixp(a) and matrixp(b) then
    is(matrix_size(a) = matrix_size(b)) and every(lambda([x], x), map(algebraic_equivalence,
      apply(append, args(a)), apply(append, args(b))))
  elseif listp(a) and listp(b)
    then is(length(a) = length(b)) and every(lambda([x], x), map(algebraic_equivalence, a, b))
  elseif listp(a) or listp(b) or matrixp(a) or matrixp(b) then false else algebraic_equivalence(a, b)$
load("linearalgebra")$
"""

LIBRARY = r"""
file_search_maxima: append(["{0}/stack/maxima/###.{{mac,mc}}"], file_search_maxima)$
file_search_lisp: append(["{0}/stack/maxima/###.{{lisp}}"], file_search_lisp)$
STACK_SETUP(ex) := block(MAXIMA_PLATFORM: "server", maxima_tempdir: "/tmp/", IMAGE_DIR: "/tmp/", URL_BASE: "", true)$
load("stackmaxima.mac")$
simp: true$
test_AlgEquiv(a, b, opt) := is(second(ATAlgEquiv(a, b)) = true)$
"""

COMMON = r"""
test_NumAbsolute(a, b, opt) := is(abs(float(a) - float(b)) <= float(opt) * (1 + 1.0e-9))$
display2d: false$
linel: 100000$
ratprint: false$
"""


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> Order:
    return Order(of(tmp_path_factory.mktemp("stack") / "hw", TOML), failures_of, variants=2)


def of(folder: Path, toml: str) -> Assignment:
    a_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(toml)
    return load_assignment(folder)


@pytest.fixture(scope="module")
def notes() -> list[str]:
    return []


@pytest.fixture(scope="module")
def quiz(order: Order, notes: list[str]) -> ET.Element:
    (file,) = OUTLETS["stack"].files(replace(order, note=notes.append))
    assert file.private
    return ET.fromstring(file.content)


def questions(quiz: ET.Element) -> list[ET.Element]:
    return [question for question in quiz if question.get("type") == "stack"]


def content(element: ET.Element, path: str) -> str:
    found = element.find(path)
    assert found is not None, path
    return found.text or ""


def test_variants_are_questions_in_a_category_for_each_place(quiz: ET.Element, order: Order) -> None:
    categories = [content(question, "category/text") for question in quiz if question.get("type") == "category"]
    assert categories == ["$course$/top/Velocity kinematics//1/p1", "$course$/top/Velocity kinematics//1/p2"]
    assert len(questions(quiz)) == 4
    for path in ("questionnote/text", "idnumber", "name/text"):
        assert len({content(question, path) for question in questions(quiz)}) == 4
    assert content(questions(quiz)[0], "defaultgrade") == "8"
    ((_, problem),) = [(variant.key, variant.problem) for variant in bank(replace(order, variants=1))][:1]
    determinant = problem.parts[2].answer
    assert isinstance(determinant, Expression)
    assert text_of(determinant.reference) not in content(questions(quiz)[0], "questiontext/text")


def test_what_stack_can_not_do_is_told(notes: list[str], quiz: ET.Element) -> None:
    assert sorted(notes) == [
        "p1: STACK takes no rounded decimals in 'determinant'; qdot would, to three significant digits",
        "p1: in STACK 'determinant' is right or wrong; factors that are right earn nothing",
        f"p2: STACK does not ask 'match-columns': {LETTERS_OF_SEVERAL}",
    ]


def test_texts_are_castext_with_inputs_pictures_and_mathematics_for_mathjax(quiz: ET.Element) -> None:
    for question in questions(quiz):
        text = content(question, "questiontext/text")
        inputs = [content(one, "name") for one in question.findall("input")]
        assert re.findall(r"\[\[input:(\w+)\]\]", text) == inputs == re.findall(r"\[\[validation:(\w+)\]\]", text)
        trees = [content(one, "name") for one in question.findall("prt")]
        assert re.findall(r"\[\[feedback:(\w+)\]\]", text) == trees
        assert set(re.findall(r"\[\[(\w+):", text)) == {"input", "validation", "feedback"}
        assert r"\(" in text and "$" not in text and "<math" not in text
        assert text.count("<details>") == 3 * len(inputs)
        shown = re.findall(r'src="@@PLUGINFILE@@/([\w.-]+)" alt="[^"]{20,}"', text)
        assert shown == [file.get("name") for file in question.findall("questiontext/file")] and shown
        solution = content(question, "generalfeedback/text")
        assert solution.count("<h4>") == len(inputs)


def test_notes_of_nodes_are_unique_and_every_note_is_reached_by_a_test(quiz: ET.Element) -> None:
    for question in questions(quiz):
        reached = {content(one, "expectedanswernote") for one in question.findall("qtest/expected")}
        for tree in question.findall("prt"):
            nodes = tree.findall("node")
            notes = [content(node, f"{way}answernote") for node in nodes for way in ("true", "false")]
            assert len(set(notes)) == len(notes) and not [note for note in notes if ";" in note or "|" in note]
            assert {content(node, "trueanswernote") for node in nodes} <= reached
            assert [content(node, "falsenextnode") for node in nodes] == [*map(str, range(1, len(nodes))), "-1"]
        assert {f"prt1-{name}" for name in ("right", "other")} <= reached


# --- Maxima ---


def maxima(script: str, folder: Path) -> list[str]:
    """Return the lines that a script prints."""
    program = needs("maxima", MAXIMA)
    path = folder / "tests.mac"
    path.write_text(script)
    done = subprocess.run(
        [program, "--very-quiet", "--batch-string", f'batchload("{path}")$'],
        capture_output=True,
        text=True,
        timeout=400,
    )
    return [line.strip() for line in done.stdout.splitlines()]


def tree_of(tree: ET.Element) -> str:
    """Return a response tree as one Maxima expression: [note, score]."""
    found = ""
    for node in reversed(tree.findall("node")):
        test = f"test_{content(node, 'answertest')}({content(node, 'sans')}, {content(node, 'tans')}, "
        test += f"{content(node, 'testoptions') or 0}) = true"
        yes = f'["{content(node, "trueanswernote")}", {content(node, "truescore")}]'
        no = found or f'["{content(node, "falseanswernote")}", {content(node, "falsescore")}]'
        found = f"(if {test} then {yes} else {no})"
    return found


def script_of(quiz: ET.Element, prelude: str) -> tuple[str, list[str]]:
    """Return a script that runs all question tests, and the lines it is to print."""
    lines, expected = [prelude, COMMON], []
    for q, question in enumerate(questions(quiz)):
        lines.append(content(question, "questionvariables/text"))
        trees = {content(tree, "name"): tree for tree in question.findall("prt")}
        for test in question.findall("qtest"):
            given = {content(one, "name"): content(one, "value") for one in test.findall("testinput")}
            for due in test.findall("expected"):
                tree, note = content(due, "name"), content(due, "expectedanswernote")
                value = given[f"ans{tree[3:]}"]
                if note == "NULL":
                    assert value in ("", "qdot_unknown(1)") and not content(due, "expectedscore")
                    continue
                feedback = content(trees[tree], "feedbackvariables/text")
                label = f"{q} {content(test, 'testcase')} {tree}"
                lines.append(f"ans{tree[3:]}: {value}; {feedback}")
                lines.append(f"found: {tree_of(trees[tree])};")
                lines.append(f'print("RAN", "{label}", first(found), round(10000*float(second(found))));')
                expected.append(f"RAN {label} {note} {round(10000 * float(content(due, 'expectedscore')))}")
    return "\n".join(lines).replace(";", "$"), expected


def library() -> Iterator[tuple[str, str]]:
    yield "our own equality", OWN_EQUALITY
    if "QDOT_STACK" in os.environ:
        yield "STACK's library", LIBRARY.format(os.environ["QDOT_STACK"])


@pytest.mark.parametrize("prelude", [text for _, text in library()], ids=[name for name, _ in library()])
def test_question_tests_pass_in_maxima(quiz: ET.Element, tmp_path: Path, prelude: str) -> None:
    script, expected = script_of(quiz, prelude)
    found = [line for line in maxima(script, tmp_path) if line.startswith("RAN")]
    assert len(expected) > 80
    assert found == expected


def test_a_wrong_response_tree_fails_in_maxima(quiz: ET.Element, tmp_path: Path) -> None:
    """The way in which question tests are run can tell: with two model answers exchanged, they don't pass."""
    first = ET.Element("quiz")
    first.append(questions(quiz)[0])
    script, expected = script_of(first, OWN_EQUALITY)
    spoiled = script.replace("ta3: ", "ta3: 2*", 1)
    assert [line for line in maxima(spoiled, tmp_path) if line.startswith("RAN")] != expected


def test_answers_as_students_type_them_are_judged_alike(quiz: ET.Element, tmp_path: Path) -> None:
    """Shorthand, given lengths by name, decimals: STACK's question, with Maxima, says what qdot says."""
    variables = content(questions(quiz)[0], "questionvariables/text")
    cases = {
        "qdot_entry(qdot_exact(c12), cos(theta1 + theta2))": "true",
        "qdot_entry(qdot_exact(0.5*s1), sin(theta1)/2)": "true",
        "qdot_entry(qdot_exact(0.333*s1), sin(theta1)/3)": "false",
        "qdot_entry(qdot_exact(c12), cos(theta1))": "false",
        "qdot_covered([theta2 = 0.5], [theta2 = 1/2], [theta2])": "1",
        "qdot_covered([theta2 = 2*%pi + 1/2], [theta2 = 1/2], [theta2])": "1",
        "qdot_covered([theta2 = 180], [theta2 = %pi], [theta2])": "0",
        "qdot_beyond([theta2 = 1/2, 5, x + y, theta1 = 1/2], [theta2 = 1/2], [theta2])": "3",
        "qdot_covered([d2 = 2*%pi], [d2 = 0], [theta1])": "0",
        "qdot_amiss(-a1*sin(theta2), a1*sin(theta2), 1, [theta2])": "1",
        "qdot_amiss(sin(theta2)/2, a1*sin(theta2), 1, [theta2])": "1",
        "qdot_amiss(-sin(theta2), a1*sin(theta2), 1, [theta2])": "2",
        "qdot_amiss(a1*cos(theta2), a1*sin(theta2), 1, [theta2])": "0",
        "qdot_amiss(0, a1*sin(theta2), 1, [theta2])": "0",
        "qdot_amiss(matrix([0, 2*s2]), matrix([0, sin(theta2)]), 2, [theta2])": "0",
        "qdot_amiss(matrix([0, 2*sin(theta2)]), matrix([0, sin(theta2)]), 2, [theta2])": "1",
        "qdot_set_share([[1, 2]], 0)": "2/3",
        "qdot_set_share([[0, 2], [1, 1]], 1)": "1/4",
        "qdot_set_share([[2, 2]], 2)": "0",
    }
    script = OWN_EQUALITY + COMMON + variables + "\n" + "\n".join(f'print("RAN", {case});' for case in cases)
    found = [line for line in maxima(script.replace(";", "$"), tmp_path) if line.startswith("RAN")]
    assert found == [f"RAN {due}" for due in cases.values()]


# --- qdot's side ---


@pytest.mark.parametrize("family", ["planar-2r", "scara"])
def test_known_wrong_answers_are_wrong_for_the_grader_and_blamed_on_their_mistake(family: str) -> None:
    problem = generate(ProblemId(family, 3, ("position", "jacobian", "determinant")))
    for part in problem.parts:
        found = known_wrong(problem, part, 4)
        assert len(found) == 4 == len({wrong.mistake for wrong in found})
        for wrong in found:
            assert isinstance(wrong.answer, sp.MatrixBase)
            text = str(wrong.answer.tolist()) if isinstance(part.answer, Matrix) else str(wrong.answer[0])
            judged = judge(problem, part, text, "known")
            assert judged.outcome in (Outcome.WRONG, Outcome.PARTIAL)
            if isinstance(part.answer, Matrix):
                share = earned(problem, part, text, "known").share
                assert share_of(problem, part, wrong.answer, wrong.equal) == pytest.approx(share)
            blamed = diagnose(problem, part, text, "known")
            assert blamed is not None and blamed.mistakes


def test_shares_are_those_of_the_grader_whatever_the_policy(order: Order) -> None:
    variant = next(iter(bank(replace(order, variants=1))))
    part = variant.problem.parts[1]
    assert part.credit is not None and part.credit.by == "columns"
    for wrong in known_wrong(variant.problem, part, 6):
        assert isinstance(wrong.answer, sp.MatrixBase)
        text = str(wrong.answer.tolist())
        judged = earned(variant.problem, part, text, "s")
        assert share_of(variant.problem, part, wrong.answer, wrong.equal) == pytest.approx(judged.share)


def test_directions_and_sets_that_tie_joints() -> None:
    problem = generate(ProblemId("planar-3r", 3, ("self-motion",)))
    one = asked(problem, problem.parts[0], 1)
    assert not isinstance(one, str) and one.cases[1].value == "-3*ta1"
    tied = generate(ProblemId("puma-560", 3, ("singular-angles",)))
    refused = asked(tied, tied.parts[0], 1)
    assert isinstance(refused, str) and "no values of single joints" in refused


def test_maxima_text_means_the_same() -> None:
    problem: Problem = generate(ProblemId("planar-2r", 5, ("inverse-jacobian", "determinant")))
    for part in problem.parts:
        answer = part.answer
        assert isinstance(answer, (Expression, Matrix))
        for entry in answer.reference if isinstance(answer, Matrix) else [answer.reference]:
            again = sp.sympify(maxima_text(entry).replace("%pi", "pi").replace("^", "**"))
            assert same_entries(problem, sp.Matrix([again]), sp.Matrix([entry])) == (True,)
