"""Screw arms with twists (v, omega), as in Murray, Li and Sastry: the same answers in another order."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import TWIST_ORDERS, Chain, Joint
from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests, make_arm_json
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.robot_file import Robot, read_robot, read_robot_file
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.markup import to_text
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.repository.test_schemas import find_schema_errors
from tests.support.solving import solve_to_json
from tests.support.suites import select_for_suite
from tests.tools.diagnoses import classify_diagnosis, make_wrong_answers

FEW_ARMS = ["planar-2r", "spherical-offset", "wrist-zyz"]
ARMS = select_for_suite(FEW_ARMS, [*FEW_ARMS, "elbow-3r", "scara-rrrp", "cartesian"])
IN_ORDER = (
    "home-screws", "space-jacobian", "body-jacobian", "space-twist", "body-twist", "geometric-jacobian", "twist",
    "body-adjoint",
)  # fmt: skip
"""Questions whose answers have six rows like a twist."""
SWAPPED = [3, 4, 5, 0, 1, 2]
Q1, Q2 = sp.symbols("theta1 theta2")
A1, A2 = sp.symbols("a1 a2")


def generate_both_orders(family: str, seed: int = 1, variation: str = "full") -> tuple[Problem, Problem]:
    """Return a problem with twists (omega, v) and the same with (v, omega), with the questions that show the order."""
    first, second = (_generate_with_order(family, seed, variation, order) for order in TWIST_ORDERS)
    return first, second


@cache
def _generate_with_order(family: str, seed: int, variation: str, order: str) -> Problem:
    identity = ProblemId(family, seed, variation=variation, convention="screws").with_convention("", order)
    arm = sample_chain(identity)
    return generate(identity, [name for name in (*IN_ORDER, "position") if QUESTIONS[name].find_obstacle(arm) is None])


def test_planar_arm_agrees_with_murray_li_and_sastry() -> None:
    """Twists are (-omega x q, omega), and the adjoint has [P] R at the upper right."""
    _, problem = generate_both_orders("planar-2r", 1, "chapter")
    c, s = sp.cos(Q1 + Q2), sp.sin(Q1 + Q2)
    x, y = A1 * sp.cos(Q1) + A2 * c, A1 * sp.sin(Q1) + A2 * s
    below = [[0, 0], [0, 0], [1, 1]]
    expected = {
        "home-screws": [[0, 0], [0, -A1], [0, 0], *below],
        "space-jacobian": [[0, A1 * sp.sin(Q1)], [0, -A1 * sp.cos(Q1)], [0, 0], *below],
        "body-jacobian": [[A1 * sp.sin(Q2), 0], [A1 * sp.cos(Q2) + A2, A2], [0, 0], *below],
        "geometric-jacobian": [[-y, -A2 * s], [x, A2 * c], [0, 0], *below],
        "body-adjoint": [
            [c, -s, 0, 0, 0, y], [s, c, 0, 0, 0, -x], [0, 0, 1, A1 * sp.sin(Q2), A1 * sp.cos(Q2) + A2, 0],
            [0, 0, 0, c, -s, 0], [0, 0, 0, s, c, 0], [0, 0, 0, 0, 0, 1],
        ],
    }  # fmt: skip
    for name, rows in expected.items():
        apart = (problem[name].answer.as_matrix() - sp.Matrix(rows)).applyfunc(sp.simplify)
        assert apart.is_zero_matrix, name


@pytest.mark.parametrize("family", ARMS)
def test_other_order_swaps_the_answers_and_is_certified(family: str) -> None:
    first, second = generate_both_orders(family)
    assert [part.name for part in first.parts] == [part.name for part in second.parts]
    assert {"home-screws", "space-jacobian"} <= {part.name for part in second.parts}
    for first_part, second_part in zip(first.parts, second.parts, strict=True):
        if first_part.name not in IN_ORDER:
            assert first_part.answer == second_part.answer
            continue
        ours, theirs = (part.answer.as_matrix() for part in (second_part, first_part))
        columns = SWAPPED if first_part.name == "body-adjoint" else list(range(ours.cols))
        assert ours == theirs.extract(SWAPPED, columns), first_part.name
        assert first_part.answer != second_part.answer or first_part.name == "twist"
    assert certify(second).passed, certify(second).failures
    swapped = replace(second, parts=tuple(part for part in first.parts if part.name in IN_ORDER))
    wrong = {check.name.partition(":")[0] for check in certify(swapped).failures}
    assert wrong == {part.name for part in swapped.parts}


@pytest.mark.parametrize("order", TWIST_ORDERS)
def test_substituted_stage_reappears_in_the_answer(order: str) -> None:
    problem = _generate_with_order("scara-rrrp", 2, "full", order)
    for name in ("home-screws", "space-jacobian", "body-jacobian", "body-adjoint", "geometric-jacobian"):
        part, question = problem[name], QUESTIONS[name]
        w = compute_numeric_stages(
            problem.chain, sample_configurations(problem.chain, part, problem.domain, 3, Stream("put"))
        )
        assert question.compute is not None and question.substitution is not None
        answer = question.compute(w, part.details)
        wrong = answer + 0.1 * np.arange(answer.shape[0] * answer.shape[1]).reshape(*answer.shape[:2], 1)
        assert np.allclose(question.compute(w.with_mistakes(question.substitution(wrong)), part.details), wrong), name


NAMED = {
    "home-screws": {"screw-sign", "screw-point", "twist-rows-exchanged"},
    "space-jacobian": {"screw-sign", "twist-rows-exchanged", "screws-at-home", "other-twist-frame", "velocity-of-p"},
    "body-jacobian": {"screw-sign", "twist-rows-exchanged", "body-not-rotated", "body-about-origin"},
    "body-adjoint": {
        "adjoint-of-inverse", "adjoint-block-upper-right", "adjoint-order", "adjoint-sign", "adjoint-without-p",
        "adjoint-not-rotated",
    },
    "geometric-jacobian": {"twist-rows-exchanged"},
}  # fmt: skip


@pytest.mark.parametrize("order", TWIST_ORDERS)
@pytest.mark.parametrize("name", NAMED)
def test_mistakes_are_named_in_either_order(name: str, order: str) -> None:
    problem = _generate_with_order("planar-2r" if name == "body-adjoint" else "elbow-3r", 1, "chapter", order)
    verdicts = {
        answer.mistake: classify_diagnosis(answer)
        for answer in make_wrong_answers(problem, problem[name], only=NAMED[name])
    }
    assert verdicts == dict.fromkeys(NAMED[name], "named")


def _write_answer(part: Part) -> str:
    return str(part.answer.as_matrix().tolist())


def test_grader_distinguishes_the_orders() -> None:
    """An answer in the other order is wrong."""
    first, second = generate_both_orders("elbow-3r", 1, "chapter")
    name = "space-jacobian"
    assert judge(second, second[name], _write_answer(second[name]), "x").outcome == Outcome.CORRECT
    assert judge(second, second[name], _write_answer(first[name]), "x").outcome != Outcome.CORRECT


V, OMEGA = "v_x, v_y, v_z", r"\omega_x, \omega_y, \omega_z"


@pytest.mark.parametrize("family", ARMS)
def test_texts_use_the_order_of_the_arm(family: str) -> None:
    for problem, ours, excluded in zip(
        generate_both_orders(family), (f"{OMEGA}, {V}", f"{V}, {OMEGA}"), (V, OMEGA), strict=True
    ):
        for part in (part for part in problem.parts if part.name in IN_ORDER):
            texts = [write_prompt(problem, part), *write_hints(problem, part), write_solution(problem, part)]
            assert ours in texts[0]
            assert not any(f"{excluded}, {OMEGA if excluded == V else V}" in text for text in texts)
            if excluded == OMEGA:
                for text in texts:
                    assert not re.search(r"\(\\omega, v\)|\\\\ v |\(0, v|\(\\omega_i", text), part.name
                assert part.name != "twist" or r"\begin{bmatrix} v \\ \omega \end{bmatrix}" in texts[-1]


def test_solution_shows_blocks_in_the_order_of_the_arm() -> None:
    first, second = generate_both_orders("planar-2r", 1, "chapter")
    (first_text, second_text) = (
        to_text(write_solution(problem, problem["body-adjoint"])) for problem in (first, second)
    )
    assert "⎡R      0⎤" in first_text and "⎣[P] R  R⎦" in first_text
    assert "⎡R  [P] R⎤" in second_text and "⎣0  R    ⎦" in second_text


def test_id_contains_the_order() -> None:
    identity = ProblemId.parse("planar-2r/7@chapter@screws@v-omega")
    assert (identity.convention, identity.twist_order) == ("screws", "v-omega")
    assert str(identity) == "planar-2r/7@chapter@screws@v-omega"
    assert ProblemId.parse("planar-2r/7@v-omega") == ProblemId.parse("planar-2r/7@screws@v-omega")
    assert ProblemId.parse("planar-2r/7@screws@omega-v") == ProblemId.parse("planar-2r/7@screws")
    assert generate(identity, ["home-screws"]).chain.twist_order == "v-omega"


def test_only_the_unusual_order_changes_the_digest() -> None:
    first, second = generate_both_orders("planar-2r", 1, "chapter")
    assert "twist_order" not in make_arm_json(first.chain) and make_arm_json(second.chain)["twist_order"] == "v-omega"
    assert compute_digests(first).arm != compute_digests(second).arm
    table_arm = replace(second.chain, convention="dh")
    assert "twist_order" not in make_arm_json(table_arm)


ARM = """name = "arm"
convention = "screws"
twist_order = "v-omega"
point = ["a1 + a2", 0, 0]
[[joint]]
kind = "R"
axis = [0, 0, 1]
point = [0, 0, 0]
[[joint]]
kind = "R"
axis = [0, 0, 1]
point = ["a1", 0, 0]
"""


def test_robot_file_contains_the_order(tmp_path: Path) -> None:
    path, copy = tmp_path / "arm.toml", tmp_path / "again.toml"
    path.write_text(ARM)
    robot = read_robot_file(path)
    assert robot.chain.twist_order == "v-omega"
    copy.write_text(write_robot_text(robot, "screws"))
    assert 'twist_order = "v-omega"' in copy.read_text() and read_robot(copy) == robot.chain
    assert "twist_order" not in write_robot_text(robot, "dh")
    data = solve_to_json(robot.chain)
    assert find_schema_errors("solve", json.loads(json.dumps(data))) == []
    assert data["twist_rows"] == ["vx", "vy", "vz", "wx", "wy", "wz"]
    assert data["space_jacobian"][1] == ["0", "-a1*cos(theta1)"] and data["space_jacobian"][5] == ["1", "1"]
    assert data["body_jacobian"][0] == ["a1*sin(theta2)", "0"] and data["body_jacobian"][5] == ["1", "1"]


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    init_assignment(tmp_path / "hw", "Homework", "hw")
    (tmp_path / "hw" / "roster.csv").write_text("student\nada\n")
    (tmp_path / "hw" / "arm.toml").write_text(ARM)
    yield tmp_path / "hw"


def _write_assignment(folder: Path, top: str, *problems: str) -> None:
    entries = "".join(f'[[problem]]\nquestions = ["position"]\n{problem}\n' for problem in problems)
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{top}\n{entries}')


PLANAR, OWN = 'family = "planar-2r"\n', 'robot = "arm.toml"\n'


def test_nearest_twist_order_key_decides(folder: Path) -> None:
    def read_orders(top: str, *problems: str) -> list[str]:
        _write_assignment(folder, top, *problems)
        return [problem.chain.twist_order for _, problem in load_assignment(folder).generate_problems("ada")]

    by_axes, v, w = 'convention = "screws"\n', 'twist_order = "v-omega"\n', 'twist_order = "omega-v"\n'
    assert read_orders("", PLANAR, OWN) == ["omega-v", "v-omega"]
    assert read_orders(by_axes + v, PLANAR, PLANAR + w, OWN, OWN + w) == ["v-omega", "omega-v", "v-omega", "omega-v"]
    assert read_orders(by_axes + w, PLANAR, PLANAR + v, OWN) == ["omega-v", "v-omega", "omega-v"]
    assert read_orders(v, PLANAR, PLANAR + by_axes) == ["omega-v", "v-omega"]


def test_other_order_changes_the_problems_digest(folder: Path) -> None:
    digests_of = []
    for top in ("", 'twist_order = "omega-v"\n', 'twist_order = "v-omega"\n'):
        _write_assignment(folder, 'convention = "screws"\n' + top, PLANAR)
        digests_of.append(load_assignment(folder).problems_digest)
    assert digests_of[0] == digests_of[1] != digests_of[2]


WRONG = [
    ("id", "planar-2r/7@dh@v-omega", ["convention = 'dh'"]),
    ("id", "planar-2r/7@screws@v-w", ["orders of twists: omega-v, v-omega"]),
    ("id", "planar-2r/7@v-omega@omega-v", ["v-omega", "omega-v"]),
    ("file", ARM.replace("v-omega", "v-w"), ["line 3", '"v-w"', '"omega-v" or "v-omega"']),
    ("file", ARM.replace('"screws"', '"dh"'), ["line 3", 'twist_order = "v-omega"']),
    ("assignment", 'twist_order = "v-omega"', ['twist_order = "v-omega"']),
    ("assignment", 'convention = "screws"\ntwist_order = "v-w"', ["known: omega-v, v-omega"]),
    ("assignment", 'convention = "screws"\ntwist_order = 1', ["line", "omega-v or v-omega"]),
    ("problem", 'twist_order = "v-omega"', ["tables"]),
]  # fmt: skip


@pytest.mark.parametrize(("where", "text", "named"), WRONG)
def test_invalid_order_is_refused_with_its_place(where: str, text: str, named: list[str], folder: Path) -> None:
    with pytest.raises(QdotError) as caught:
        if where == "id":
            ProblemId.parse(text)
        elif where == "file":
            (folder / "arm.toml").write_text(text)
            read_robot(folder / "arm.toml")
        else:
            _write_assignment(folder, *(("", PLANAR + text) if where == "problem" else (text, PLANAR)))
            load_assignment(folder)
    assert all(name in str(caught.value) for name in named)


def test_arm_has_a_valid_order() -> None:
    with pytest.raises(QdotError, match="'v, omega'"):
        Chain("m", (Joint("R", "theta1", 0, "a1", 0),), ("vx",), convention="screws", twist_order="v, omega")
    assert Robot(Chain("m", (Joint("R", "theta1", 0, "a1", 0),), ("vx",))).chain.twist_order == "omega-v"
