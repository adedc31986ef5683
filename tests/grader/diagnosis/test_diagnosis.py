"""Diagnosis of wrong answers: the mistake is named if it is known, for every arm and question; otherwise none is."""

import json
import re
import warnings

import numpy as np
import pytest

from qdot.exercises.arm.chain import Chain
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages, compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom import Definition
from qdot.exercises.questions.custom.definition import Texts
from qdot.exercises.questions.results import compute_answer
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.functions import sample_function_arguments
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from tests.support.judging import diagnose
from tests.support.problems import LONG_ARMS, ask_question
from tests.support.suites import few_or_all_families, select_for_suite
from tests.tools.diagnoses import list_parts, sweep

FAMILY_NAMES = list(FAMILIES)
QUESTION_COUNT, LONG_ARM_COUNT = 4, select_for_suite(2, 4)
"""The number of questions tested per family, and per family of six or seven joints; `make diagnoses` tests all."""


def evaluate_reference(part: Part, values: SymbolValues) -> np.ndarray:
    """Return the entries of a reference at N configurations, shape (entries, N)."""
    nodes = [parse_formula(format_expression(entry), frozenset(values)) for entry in part.answer.as_matrix()]
    return evaluate(compile_program(nodes), values, len(next(iter(values.values())))).values


def choose_questions(family: str) -> tuple[str, ...]:
    """Return some questions of a family; together, the families cover all questions."""
    names, first = [*list_questions_of_family(family)], 3 * FAMILY_NAMES.index(family)
    return tuple(
        names[(first + k * 7) % len(names)] for k in range(LONG_ARM_COUNT if family in LONG_ARMS else QUESTION_COUNT)
    )


@few_or_all_families
def test_mistakes_are_named_and_random_answers_are_not(family: str) -> None:
    counts, missed = sweep([family], (0,), choose_questions(family), few=2, random_count=2)
    wrong = counts["named"] + counts["same answer"] + counts["nothing"]
    assert counts["judged right"] == 0, missed
    assert counts["nothing"] <= 0.05 * wrong, missed
    assert counts["random, blamed"] == 0, missed


# --- the chapter's arms ---

PLANAR, SCORBOT = make_planar_2r(), make_scorbot_arm()
C1, S1, C12, S12 = "cos(theta1)", "sin(theta1)", "cos(theta1 + theta2)", "sin(theta1 + theta2)"


def diagnose_chapter(name: str, answer: str, chain: Chain = PLANAR) -> tuple[str, str]:
    """Return the mistakes named for an answer to a chapter problem, and the message."""
    problem = ask_question(name, chain)
    diagnosis = diagnose(problem, problem.parts[0], answer, "chapter")
    return ("", "") if diagnosis is None else (" and ".join(diagnosis.mistakes), diagnosis.feedback)


@pytest.mark.parametrize(
    ("question", "answer", "mistake"),
    [
        ("position", f"[a1*{C1} + a2*cos(theta2), a1*{S1} + a2*sin(theta2)]", "relative-angle"),
        ("position", f"[a1*{C1}, a1*{S1}]", "link-left-out"),
        ("position", f"[a1*{S1} + a2*{S12}, a1*{C1} + a2*{C12}]", "all-sines-for-cosines and rows-exchanged"),
        ("position", f"[a1*{C1} - a2*{C12}, a1*{S1} - a2*{S12}]", "link-subtracted"),
        ("jacobian", f"[[-a1*{S1}, -a2*{S12}], [a1*{C1}, a2*{C12}]]", "chain-rule: Column 1|link 2|(6.3)"),
        ("jacobian", f"[[-a1*{S1} - a2*{S12}, a1*{C1} + a2*{C12}], [-a2*{S12}, a2*{C12}]]", "transposed"),
        ("jacobian", f"[[a1*{S1} + a2*{S12}, a2*{S12}], [a1*{C1} + a2*{C12}, a2*{C12}]]", "derivative-of-cosine"),
        ("jacobian", f"[[-a2*{S12}, -a1*{S1} - a2*{S12}], [a2*{C12}, a1*{C1} + a2*{C12}]]", "columns-exchanged"),
        ("determinant", "a1*a2*cos(theta2)", "wave-exchanged"),
        ("determinant", "-a1*a2*sin(theta2)", "determinant-sign"),
        ("determinant", "a2*sin(theta2)", "factor-lost: a1"),
        ("determinant", "a1*a2", "factor-lost: theta2"),
        ("inverse-jacobian", f"[[a2*{C12}, a2*{S12}], [-a1*{C1} - a2*{C12}, -a1*{S1} - a2*{S12}]]",
         "determinant-forgotten"),
        ("inverse-velocity", f"[vx*(-a1*{S1} - a2*{S12}) + vy*(a1*{C1} + a2*{C12}), -vx*a2*{S12} + vy*a2*{C12}]",
         "transpose-for-inverse"),
        ("joint-torques", f"[-(a1*{S1} + a2*{S12})*fx - a2*{S12}*fy, (a1*{C1} + a2*{C12})*fx + a2*{C12}*fy]",
         "jacobian-for-transpose"),
        ("singular-angles", "theta2 in {0}", "one-root-only"),
        ("singular-angles", "{theta2: [pi/2, -pi/2]}", "quarter-turn-singular"),
        ("singular-angles", "{theta1: [0, pi]}", "condition-for-other-joint"),
        ("singular-angles", "{theta2: [0, 180]}", "angles-in-degrees"),
        ("singular-angles", "[theta1 = 0, theta1 = pi, theta2 = 0, theta2 = pi]", "joint-called-singular"),
        ("singular-angles", "[theta2 = 0, theta2 = pi, theta2 = pi/2]", "value-called-singular: theta2 = pi/2"),
        ("singular-angles", "[theta2 = 0, theta1 = 1]", "joint-called-singular and one-root-only: theta1|1"),
        ("determinant", "a1*a2*sqrt(1 - cos(theta2)^2)", "sign-lost"),
        ("velocity", f"[-a1*qd1*{S1} - a2*qd1*qd2*{S12}, a1*qd1*{C1} + a2*qd1*qd2*{C12}]", "sum-multiplied: added"),
    ],
)  # fmt: skip
def test_mistakes_on_the_planar_arm_are_named(question: str, answer: str, mistake: str) -> None:
    name, _, words = mistake.partition(": ")
    diagnosis = diagnose_chapter(question, answer)
    assert diagnosis[0] == name and all(word in diagnosis[1] for word in words.split("|")), diagnosis


@pytest.mark.parametrize("answer", ["(sin(theta1) + cos(theta2) + theta1)**9**9**9", "1/0*theta1", "tan(pi/2)"])
def test_answers_that_are_never_finite_have_no_mistake_and_no_warning(answer: str) -> None:
    """Infinite values have an infinite tolerance, so they once matched the first mistake."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert diagnose_chapter("determinant", answer) == ("", "")


REACH = "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)"
Z_REACH, Z_REACH_SLOPE = "a2*sin(theta2) + a3*sin(theta2 + theta3)", "a2*cos(theta2) + a3*cos(theta2 + theta3)"


def write_elbow_jacobian(second: list[str], third: list[str]) -> str:
    """Return the Jacobian of elbow-3r/1@chapter with other second and third columns."""
    first = [f"-sin(theta1)*({REACH})", f"cos(theta1)*({REACH})", "0"]
    return f"Matrix([{', '.join(f'[{x}, {y}, {z}]' for x, y, z in zip(first, second, third, strict=True))}])"


SECOND = [f"-cos(theta1)*({Z_REACH})", f"-sin(theta1)*({Z_REACH})", f"-({Z_REACH_SLOPE})"]
THIRD = [f"-a3*{wave}" for wave in ("cos(theta1)*sin(theta2 + theta3)", "sin(theta1)*sin(theta2 + theta3)",
                                    "cos(theta2 + theta3)")]  # fmt: skip
RPR_SINE, RPR_COSINE = "sin(theta1 + theta3 + pi/4)", "cos(theta1 + theta3 + pi/4)"
P_X, P_Y = f"a3*{RPR_SINE} - (d2 - 1/4)*c1", f"-a3*{RPR_COSINE} - (d2 - 1/4)*s1"
ELBOW_TURNED = write_elbow_jacobian(SECOND, THIRD).removesuffix("])") + ", [0, c1, -s1], [0, c1, c1], [1, 0, 0]])"
C1_60, S1_60, T12 = "cos(theta1 + pi/3)", "sin(theta1 + pi/3)", "theta1 + theta2 + pi/12"
OFFSET, WRONG = "(0.25 - 0.7*c2 + a3*c23)", "(0.3 - 0.6*c2 + a3*c23)"
D3, D3_20, C2_45 = "(d3 - 0.7)", "(d3 + 0.2)", "cos(theta2 + pi/4)"
D3_ROWS = f"[{D3}*c1*c2, -{D3}*s1*s2, s1*c2], [{D3}*s1*c2, {D3}*s2*c1, -c1*c2], [0, {D3}*c2, s2]"
WRIST = (
    "[[s23*c1, s1*c4 - s4*c1*c23, (s1*s4 + c1*c4*c23)*s5 + s23*c1*c5],"
    " [s1*s23, -s1*s4*c23 - c1*c4, (s1*c4*c23 - s4*c1)*s5 + s1*s23*c5], [-c23, -s4*s23, s5*s23*c4 - c5*c23]]"
)
OF_P = "a2*qd2*s3, a2*qd2*c3 + 3*(qd2 + qd3)/4, qd1*(3/20 - a2*c2 - 3*c23/4)"
P3 = "[-a1*s1 - a2*s12 - a3*s123, -a2*s12 - a3*s123, -a3*s123], [a1*c1 + a2*c12 + a3*c123, a2*c12 + a3*c123, a3*c123]"


@pytest.mark.parametrize(
    ("problem_id", "question", "answer", "mistake"),
    [
        ("scara/4@modified-dh", "own-frame-velocity",  # left in the base frame
         "[-a1*qd1*c1 + (qd1 + qd2)*s12/2, -a1*qd1*s1 - (qd1 + qd2)*c12/2, -qd3, 0, 0, qd1 + qd2]",
         "vectors-left-in-base: the vectors"),
        ("planar-2r/12@modified-dh", "own-frame-velocity",
         "[-a1*qd1*sin(theta1 + pi/4), a1*qd1*cos(theta1 + pi/4), 0, 0, 0, qd1 + qd2]",
         "vectors-left-in-base: the vectors"),
        ("spherical/3", "tool-jacobian", f"[{D3_ROWS}, [0, -c1, 0], [0, -s1, 0], [1, 0, 0]]",
         "vectors-left-in-base: the vectors"),
        ("spherical/3", "tool-jacobian", f"[{D3_ROWS}, [c2, 0, 0], [0, 1, 0], [s2, 0, 0]]",
         "vectors-left-in-base: the linear vectors"),
        ("wrist-zyz/47", "jacobian", "[[0, -s1, c1*s2], [0, c1, s1*s2], [1, 0, c2]]",
         "offset-forgotten: adds to theta1 and theta2"),  # the offset of joint 3 changes nothing
        ("spherical/29", "position", f"[{D3_20}*s1*{C2_45}, -{D3_20}*c1*{C2_45}, {D3_20}*sin(theta2 + pi/4) + 0.65]",
         "trig-throughout"),  # not two signs of constants
        ("scara/83@full", "determinant", "7/20*a1*sin(theta2 + pi/3)", "offset-sign: for -60°|theta2"),
        ("planar-3r-pose/90", "singular-angles", "theta2 = pi/2, theta2 = -pi/2", "offset-forgotten-in-set"),
        ("planar-3r-pose/90", "singular-angles", "theta2 = 2*pi/3, theta2 = -pi/3", "offset-sign-in-set"),
        ("planar-3r-pose/90", "singular-angles", "theta2 = pi/3, theta2 = -2*pi/3, theta2 = -pi/5",
         "value-called-singular: singular at theta2 = -pi/5."),
        ("cartesian/5@frames", "position", "[d1 + 0.8, d2 - 0.7, d3 - 0.25 + 0.35]",
         "prismatic-joints-along-xyz: along x, y and z"),
        ("anthropomorphic-6r/1@chapter", "wrist-block", WRIST, "vectors-left-in-base: the vectors"),
        ("elbow-3r/21@modified-dh", "own-frame-velocity", f"[{OF_P}, qd1*s23, qd1*c23, qd2 + qd3]",
         "velocity-of-other-frame: the velocity of the point"),
        ("wrist-zyz/1@chapter", "jacobian", "[[-s2*c3, s3, 0], [s2*s3, c3, 0], [c2, 0, 1]]",
         "tool-frame: the last frame"),
        ("wrist-zyz/1@chapter", "determinant", "cos(theta2)", "trig-and-sign"),
        ("planar-3r-pose/90", "determinant", "-9*sin(theta2 + pi/6)/20", "wave-exchanged"),
        ("scara/83@full", "determinant", "-7/20*a1*sin(theta2 + pi/6)", "wave-exchanged"),
        ("scara/83@full", "determinant", "7/20*a1*cos(theta2 - pi/3)", "wave-exchanged"),
        ("planar-pr/33@frames", "position", f"[a2*{C2_45} + 1/20, -a2*sin(theta2 + pi/4) + d1 + 9/20]",
         "trig-throughout"),
        ("elbow-3r/1@chapter", "geometric-jacobian", ELBOW_TURNED,
         "trig-and-sign: entry (4, 2)"),  # angular rows are no derivatives
        ("wrist-zyz/1@chapter", "jacobian", "[[0, -s1, -c1*s2], [0, c1, s1*s2], [1, 0, c2]]",
         "term-sign-typed: entry (1, 3)"),
        ("elbow-3r/1@chapter", "jacobian",  # both factors of the product were differentiated
         write_elbow_jacobian([f"sin(theta1)*({Z_REACH_SLOPE})", *SECOND[1:]], THIRD), ""),
        ("elbow-3r/1@chapter", "jacobian",
         write_elbow_jacobian([f"sin(theta1)*({Z_REACH})", f"-cos(theta1)*({Z_REACH})", SECOND[2]], THIRD),
         "trig-derived: entries (1, 2) and (2, 2)"),
        ("elbow-3r/1@chapter", "jacobian", write_elbow_jacobian(SECOND, SECOND), "term-surplus: (3, 3)|a2"),
        ("elbow-3r/2@frames", "position",
         f"[{OFFSET}*cos(theta1 - pi/3), {OFFSET}*sin(theta1 - pi/3), 0.7 + d1 + 0.7*s2 - a3*s23]", "base-not-rotated"),
        ("planar-2r/2@lengths", "path-rates", "[-0.2397, 0.09242]", "path-reversed: or all of your rates"),
        ("planar-2r/2@lengths", "position", "[0.4*c1 + a2*c12, 0.4*s1 + a2*s12]", ": other lengths (0.4)"),
        ("planar-2r/2@lengths", "position", "[a1*c1 + 0.5*c12, a1*s1 + 0.5*s12]", ": other lengths (a1)"),
        ("elbow-3r/2@frames", "position",
         f"[{WRONG}*cos(theta1 - pi/3), -0.6*s2 + a3*s23 - d1, 0.7 + {WRONG}*sin(theta1 - pi/3)]",
         ": other lengths (0.3 and 0.6)"),
        ("planar-rpr/14@frames", "position",  # the base taken at (0.3, 0); not an exchange with z = 0
         f"[{P_X} + s1/5 + 3/10, {P_Y} - c1/5]", "term-missing: entry 2|0.4"),
        ("planar-rpr/14@frames", "position-vectors",
         f"[[{P_X} + s1/5, {P_X} + s1/5, a3*{RPR_SINE}], [{P_Y} - c1/5, {P_Y} - c1/5, -a3*{RPR_COSINE}], [0, 0, 0]]",
         "arm-from-other-origin: joint 2|frame 0|frame 1"),
        ("wrist-zyz/9@zeros", "twist",
         f"[0, 0, 0, -qd2*{S1_60} - qd3*s2*{C1_60}, qd2*{C1_60} - qd3*s2*{S1_60}, qd1 - qd3*c2]",
         "distance-forgotten and other-point: row 3|O2"),
        ("scara/3@zeros", "position",  # twice the last link equals the offset of d3
         f"[a1*{C1_60} + 0.3*cos({T12}), a1*{S1_60} + 0.3*sin({T12}), d1 - d3 - 0.1]",
         "link-subtracted and offset-forgotten: link 4|d3"),
        ("spherical/4@frames", "position",  # the base is as high as link 1 is long
         "[-(d3 - 0.2)*s1*cos(theta2 + pi/4), (d3 - 0.2)*c1*cos(theta2 + pi/4), (d3 - 0.2)*sin(theta2 + pi/4) + 0.45]",
         "link-left-out and base-forgotten: link 1"),
        ("polar-rp/13@lengths", "jacobian", "[[d2*c1 - 0.15*s1, c1], [d2*s1 + 0.15*c1, s1]]",
         "wrong-axis-of-joint: joint 2|the x"),
        ("elbow-lateral/17@lengths", "determinant", "-0.6*a3*(a3*s23 + 0.6*s2)*s3", "trigs-in-factor"),
        ("planar-2r/15@lengths@screws", "home-screws",
         "[[0, 0], [0, 0], [1, 1], [0, 0], [0, a1], [0, 0]]", "screw-sign"),
        ("scara/1@chapter", "singular-angles", "[theta2 = 0, theta2 = pi, d3 = 0]",
         "joint-called-singular: singular at d3 = 0. Is det J zero there? See (6.8)."),
        ("spherical-offset/5@lengths", "singular-angles", "{theta2: [0, 180], d3: [0]}",
         "angles-in-degrees and and-for-or: a dictionary"),
        ("spherical-offset/5@lengths", "singular-angles", "{theta2: [0, 180]}",
         "angles-in-degrees and component-missed: in radians. You seem to have left out a condition on a joint"),
        ("spherical-offset/5@lengths", "singular-angles", "[]", "component-missed: contains no condition"),
        ("planar-2r/5403668597637521520@lengths", "joint-rates",  # typed as a calculation
         ("[0.11*(sin(15)/2 + cos(15))/(0.385*sin(15 - 110)), -(0.11*cos(15) + 0.14*cos(110) + 0.055*sin(15)"
         " + 0.07*sin(110))/(0.385*sin(15 - 110))]"), "degrees-as-radians"),
        ("planar-rpr/8876105815824641441", "inverse-velocity",  # not divided by -det J
         ("[vy*c1 - vx*s1 - a3*wz*c3, a3*wz*((d2 - 0.75)*s3 - 0.05*c3) + vx*((d2 - 0.75)*c1 - 0.05*s1)"
         " + vy*((d2 - 0.75)*s1 + 0.05*c1), vx*s1 - vy*c1 + wz*(a3*c3 + d2 - 0.75)]"), "determinant-forgotten"),
        ("orthogonal-3r/1@chapter", "singular-angles",
         "[theta3 = 0, theta3 = pi, theta2 = acos(-a1/a2), a2 + a3*c3 = 0]", "one-root-only"),
        ("planar-3r-pose/1@chapter", "jacobian", f"[{P3}, [0, 0, 1]]", "angular-of-one-joint: joint 3"),
        ("scara/1@chapter", "velocity",
         "[-a1*s1*qd1 - a2*s12*(qd1 + qd2), a1*c1*qd1 + a2*c12*(qd1 + qd2), d1 - qd3]", "term-surplus: entry 3|d1"),
        ("spherical/1@chapter", "link-velocity", "[0, 0, 0, -s1*qd2, c1*qd2, qd1 + qd3]", "term-surplus: entry 6|qd3"),
    ],
)  # fmt: skip
def test_a_mistake_in_one_place_gets_its_true_name(problem_id: str, question: str, answer: str, mistake: str) -> None:
    """Regressions: each of these was once given a wrong name, two names, or none."""
    generated = generate(problem_id, [question])
    diagnosis = diagnose(generated, generated.parts[0], answer, "one place")
    name, _, words = mistake.partition(": ")
    assert " and ".join(diagnosis.mistakes if diagnosis else ()) == name, diagnosis
    assert all(diagnosis and word in diagnosis.feedback for word in words.split("|") if word), diagnosis


@pytest.mark.parametrize(
    ("answer", "mistake"),
    [
        ("theta3 in {0, pi}", "shoulder-missed"),
        (f"[{REACH} = 0]", "component-missed"),
        (f"[theta3 = 0, theta3 = pi, {REACH} = 0, theta2 = 0]", "joint-called-singular"),
        ("[theta3 = 0, theta3 = pi, theta2 = 0, theta2 = pi]", "shoulder-missed"),
        (f"[theta3 = 0, {REACH} = 0]", "one-root-only"),
        ("[theta3 in {0, pi}, a1 + a2*cos(theta2) + a3*cos(theta3) = 0]", "relative-angle-in-condition"),
        ("[theta3 in {0, pi}, a1 + a2*cos(theta2) - a3*cos(theta2 + theta3) = 0]", "sign-in-condition"),
        ("[theta3 in {0, pi}, a2*cos(theta2) + a3*cos(theta2 + theta3) = 0]", "term-lost-in-condition"),
    ],
)
def test_mistakes_in_example_6_3_are_named(answer: str, mistake: str) -> None:
    assert diagnose_chapter("singular-angles", answer, SCORBOT)[0] == mistake


@pytest.mark.parametrize(
    ("family", "formula", "first_mistake"),
    [
        ("planar-2r", "ddt(dot(p, p))", "sign"), ("planar-2r", "o2 - o1", "sign"),
        ("polar-rp", "det(J)", "determinant-sign"),
        ("planar-2r", "det(J)", "sign"), ("spherical", "v", "sign"), ("spherical", "p.x", "sign"),
        ("planar-2r", "J[1, 1]", "derivative-of-cosine"),
    ],
)  # fmt: skip
def test_a_wrong_sign_of_the_whole_answer_is_no_mistake_of_one_link(
    family: str, formula: str, first_mistake: str
) -> None:
    definition = Definition("mine", formula, (Texts("Mine", "x"),))
    problem = generate(f"{family}/1", ["mine"], definitions=[definition])
    answer = (-problem.parts[0].answer.as_matrix()).tolist()
    diagnosis = diagnose(problem, problem.parts[0], str(answer if len(answer) > 1 else answer[0][0]), "seed")
    assert diagnosis is not None and diagnosis.mistakes[0] == first_mistake
    assert "contribution of link" not in diagnosis.feedback


def test_a_wrong_sign_of_a_column_or_part_of_it_is_named() -> None:
    right = to_sympy_matrix(
        compute_answer(compute_symbolic_stages(SCORBOT), ask_question("jacobian", SCORBOT).parts[0])
    )
    wrong = right.copy()
    wrong[:, 1] = -wrong[:, 1]
    assert diagnose_chapter("jacobian", str(wrong.tolist()), SCORBOT)[0] == "column-sign"
    wrong[2, 1] = right[2, 1]  # now only part of the column has the wrong sign
    name, message = diagnose_chapter("jacobian", str(wrong.tolist()), SCORBOT)
    assert name == "term-sign-typed" and "entries (1, 2) and (2, 2)" in message


@pytest.mark.parametrize(
    "answer", ["0", "1", "a1", "theta2", "sin(theta1)", "[1, 2, 3]", "{{{", "", "a1*a2*tan(theta2)"]
)
def test_unexplained_answers_have_no_diagnosis(answer: str) -> None:
    assert diagnose_chapter("determinant", answer) == ("", "")


def test_a_long_set_is_not_compared_with_mistakes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each comparison would take long and delay the class."""
    monkeypatch.setattr("qdot.grader.diagnosis.set_mistakes.judge_parsed", None)
    conditions = ", ".join(f"cos(theta1 + {k}*theta2) = 0" for k in range(60))
    assert diagnose_chapter("singular-angles", f"[{conditions}]") == ("", "")


def test_an_answer_with_blanks_is_diagnosed() -> None:
    answer = f"[[-a1*{S1} - a2*{S12}, blank], [blank, -a2*{C12}]]"
    assert diagnose_chapter("jacobian", answer)[0] != ""


# --- the catalogue ---


def test_every_mistake_has_a_message_without_formulas_and_a_source() -> None:
    assert len(CATALOGUE) >= 30
    for mistake in CATALOGUE.values():
        words = re.sub(r"{\w+}", "2", mistake.message)
        assert re.fullmatch(r"[A-Z*2{].*[.?)]", words), mistake.name
        assert not re.search(r"sin\(|cos\(|\w\*\w|theta\d", words), mistake.name
        assert re.search(r"6\.\d|appendix|^the product of exponentials$|^$", mistake.source), mistake.name


@few_or_all_families
def test_numeric_derivations_give_the_reference(family: str) -> None:
    """The numeric stages used for mistakes are a third derivation and must agree with the references."""
    for problem, part in list_parts(family, 0, tuple(name for name, question in QUESTIONS.items() if question.compute)):
        if isinstance(part.answer, (Expression, Matrix)):
            values = sample_configurations(problem.chain, part, problem.domain, 3, Stream("right"))
            derived = compute_answer(compute_numeric_stages(problem.chain, values), part)
            expected = evaluate_reference(part, values)
            error = abs(derived - expected.reshape(derived.shape)).max()
            assert error < 1e-9 * max(1.0, abs(expected).max()), part.name


def test_a_sampled_function_is_diagnosed_by_its_values() -> None:
    problem = ask_question("position", PLANAR)
    calls = sample_function_arguments(problem, problem.domain, "points")
    values_at = dict(zip(calls.symbols, np.array(calls.points).T, strict=True))
    a1, a2, theta1, theta2 = (values_at[name] for name in ("a1", "a2", "theta1", "theta2"))
    rows = [a1 * trig(theta1) + a2 * trig(theta2) for trig in (np.cos, np.sin)]
    values = [[[value, 0.0] for value in row] for row in np.array(rows).T.tolist()]
    table = TABLE_PREFIX + json.dumps({"shape": [2], "values": values})
    diagnosis = diagnose(problem, problem.parts[0], table, "s", "points")
    assert diagnosis is not None and diagnosis.mistakes == ("relative-angle",)
