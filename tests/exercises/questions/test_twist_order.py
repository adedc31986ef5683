"""Arms told by their axes with twists (v, omega), as Murray, Li and Sastry have them: the same in another order."""

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import TWIST_ORDERS, Chain, Joint
from exercises.arm.derivation import derive
from exercises.arm.robot_file import Robot, read_robot, read_robot_file
from exercises.arm.robot_text import robot_text
from exercises.arm.stages import numbers
from exercises.arm.told import adjoint_told, twist_told
from exercises.assignment import load_assignment
from exercises.errors import QdotError
from exercises.generation import generate, sample_chain
from exercises.mistakes.given import configurations
from exercises.problem import Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.screws import body_adjoint, body_jacobian, body_rotation, space_jacobian
from exercises.record import digests, robot_json
from exercises.release import init_assignment
from exercises.solving import solution_data, solve
from exercises.stream import Stream
from exercises.verify import certify
from exercises.writing.markup import to_text
from exercises.writing.statement import hints, prompt, worked_solution
from grader.parts import judge
from grader.verdict import Outcome
from tests.repository.test_schemas import errors
from tests.tools.diagnoses import answers_with, verdict_on

ARMS = ["planar-2r", "elbow-3r", "scara-rrrp", "spherical-offset", "cartesian", "wrist-zyz"]
IN_ORDER = (
    "home-screws", "space-jacobian", "body-jacobian", "space-twist", "body-twist", "geometric-jacobian", "twist",
    "body-adjoint", "changed-twist",
)  # fmt: skip
"""Questions whose answers have the six rows of a twist."""
OTHER = [3, 4, 5, 0, 1, 2]
Q1, Q2 = sp.symbols("theta1 theta2")
A1, A2 = sp.symbols("a1 a2")


def both(family: str, seed: int = 1, variation: str = "full") -> tuple[Problem, Problem]:
    """Return a problem with twists (omega, v), and the same with (v, omega), each asked what shows the order."""
    first, second = (_asked(family, seed, variation, order) for order in TWIST_ORDERS)
    return first, second


@cache
def _asked(family: str, seed: int, variation: str, order: str) -> Problem:
    identity = ProblemId(family, seed, variation=variation, convention="screws").told("", order)
    arm = sample_chain(identity)
    return generate(identity, [name for name in (*IN_ORDER, "position") if QUESTIONS[name].refusal(arm) is None])


def test_the_planar_arm_is_as_murray_li_and_sastry_have_it() -> None:
    """Twists (-omega x q, omega); the adjoint has [P] R at the upper right; the body Jacobian holds joints behind."""
    _, problem = both("planar-2r", 1, "chapter")
    c, s = sp.cos(Q1 + Q2), sp.sin(Q1 + Q2)
    x, y = A1 * sp.cos(Q1) + A2 * c, A1 * sp.sin(Q1) + A2 * s
    below = [[0, 0], [0, 0], [1, 1]]
    due = {
        "home-screws": [[0, 0], [0, -A1], [0, 0], *below],
        "space-jacobian": [[0, A1 * sp.sin(Q1)], [0, -A1 * sp.cos(Q1)], [0, 0], *below],
        "body-jacobian": [[A1 * sp.sin(Q2), 0], [A1 * sp.cos(Q2) + A2, A2], [0, 0], *below],
        "geometric-jacobian": [[-y, -A2 * s], [x, A2 * c], [0, 0], *below],
        "body-adjoint": [
            [c, -s, 0, 0, 0, y],
            [s, c, 0, 0, 0, -x],
            [0, 0, 1, A1 * sp.sin(Q2), A1 * sp.cos(Q2) + A2, 0],
            [0, 0, 0, c, -s, 0],
            [0, 0, 0, s, c, 0],
            [0, 0, 0, 0, 0, 1],
        ],
    }
    for name, rows in due.items():
        apart = (problem[name].answer.as_matrix() - sp.Matrix(rows)).applyfunc(sp.simplify)
        assert apart.is_zero_matrix, name


@pytest.mark.parametrize("family", ARMS)
def test_the_same_is_asked_in_the_other_order(family: str) -> None:
    first, second = both(family)
    assert [part.name for part in first.parts] == [part.name for part in second.parts]
    assert {"home-screws", "space-jacobian"} <= {part.name for part in second.parts}
    for one, other in zip(first.parts, second.parts, strict=True):
        if one.name not in IN_ORDER:
            assert one.answer == other.answer
            continue
        ours, theirs = (part.answer.as_matrix() for part in (other, one))
        columns = OTHER if one.name == "body-adjoint" else list(range(ours.cols))
        assert ours == theirs.extract(OTHER, columns), one.name
        assert one.answer != other.answer or one.name == "twist"


@pytest.mark.parametrize("family", ARMS)
def test_a_certificate_holds_in_either_order_and_sees_the_other(family: str) -> None:
    first, second = both(family)
    assert certify(second).passed, certify(second).failures
    swapped = replace(second, parts=tuple(part for part in first.parts if part.name in IN_ORDER))
    wrong = {check.name.partition(":")[0] for check in certify(swapped).failures}
    assert wrong == {part.name for part in swapped.parts}


def test_body_jacobian_and_adjoint_are_how_the_body_frame_moves() -> None:
    """By differences of its pose, without any module of ours for twists: v is R^T dP, omega is of R^T dR."""
    chain, draws = both("elbow-3r")[1].chain, Stream("differences")
    answers = {
        "body-jacobian": twist_told(chain, body_jacobian(chain)),
        "space-jacobian": twist_told(chain, space_jacobian(chain)),
        "body-adjoint": adjoint_told(chain, body_adjoint(chain)),  # too long to be asked of it
    }
    known = {symbol: draws.uniform(0.3, 1.0) for symbol in chain.parameters}
    q = np.array([draws.uniform(-2, 2) for _ in chain.q])
    rotation, place = body_rotation(chain), derive(chain).position

    def pose(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = known | dict(zip(chain.q, at, strict=True))
        return tuple(np.array(m.xreplace(values).evalf().tolist(), dtype=float) for m in (rotation, place))  # type: ignore[return-value]

    turn, at = pose(q)
    columns, seen = [], []
    for i in range(chain.n):
        step = 1e-6 * np.eye(chain.n)[i]
        (r1, p1), (r0, p0) = pose(q + step), pose(q - step)
        moved, hat = (p1 - p0)[:, 0] / 2e-6, (r1 - r0) / 2e-6
        body, space = turn.T @ hat, hat @ turn.T
        columns.append([*turn.T @ moved, body[2, 1], body[0, 2], body[1, 0]])
        omega = np.array([space[2, 1], space[0, 2], space[1, 0]])
        seen.append([*(moved - np.cross(omega, at[:, 0])), *omega])
    values = known | dict(zip(chain.q, q, strict=True))
    told = {name: np.array(matrix.xreplace(values).evalf().tolist(), dtype=float) for name, matrix in answers.items()}
    assert np.allclose(told["body-jacobian"], np.array(columns).T, atol=1e-8)
    assert np.allclose(told["space-jacobian"], np.array(seen).T, atol=1e-8)
    assert np.allclose(told["body-adjoint"] @ told["body-jacobian"], told["space-jacobian"], atol=1e-12)


@pytest.mark.parametrize("order", TWIST_ORDERS)
def test_what_is_put_in_the_place_of_a_stage_comes_out_as_it_was(order: str) -> None:
    problem = _asked("scara-rrrp", 2, "full", order)
    for name in ("home-screws", "space-jacobian", "body-jacobian", "body-adjoint", "geometric-jacobian"):
        part, question = problem[name], QUESTIONS[name]
        w = numbers(problem.chain, configurations(problem.chain, part, problem.domain(), 3, Stream("put")))
        assert question.result is not None and question.put is not None
        answer = question.result(w, part)
        wrong = answer + 0.1 * np.arange(answer.shape[0] * answer.shape[1]).reshape(*answer.shape[:2], 1)
        assert np.allclose(question.result(w.but(question.put(wrong)), part), wrong), name


NAMED = {
    "home-screws": {"screw-sign", "screw-point", "twist-rows-exchanged"},
    "space-jacobian": {"screw-sign", "twist-rows-exchanged", "screws-at-home", "other-twist-frame", "velocity-of-p"},
    "body-jacobian": {"screw-sign", "twist-rows-exchanged", "body-not-turned", "body-about-origin"},
    "body-adjoint": {
        "adjoint-of-inverse", "adjoint-block-above", "adjoint-order", "adjoint-sign", "adjoint-without-p",
        "adjoint-not-turned",
    },
    "geometric-jacobian": {"twist-rows-exchanged"},
}  # fmt: skip


@pytest.mark.parametrize("order", TWIST_ORDERS)
@pytest.mark.parametrize("name", NAMED)
def test_mistakes_are_named_in_either_order(name: str, order: str) -> None:
    problem = _asked("planar-2r" if name == "body-adjoint" else "elbow-3r", 1, "chapter", order)
    verdicts = {one.mistake: verdict_on(one) for one in answers_with(problem, problem[name], only=NAMED[name])}
    assert verdicts == dict.fromkeys(NAMED[name], "named")


def _typed(part: Part) -> str:
    return str(part.answer.as_matrix().tolist())


def test_the_grader_knows_the_order() -> None:
    """The answer of the other order is wrong, and said to have its halves exchanged."""
    first, second = both("elbow-3r", 1, "chapter")
    name = "space-jacobian"
    assert judge(second, second[name], _typed(second[name]), "x").outcome == Outcome.CORRECT
    assert judge(second, second[name], _typed(first[name]), "x").outcome != Outcome.CORRECT


@pytest.mark.parametrize("family", ARMS)
def test_texts_have_the_order_of_the_arm(family: str) -> None:
    _, second = both(family)
    linear = r"v_x, v_y, v_z, \omega_x, \omega_y, \omega_z"
    for part in second.parts:
        if part.name in IN_ORDER:
            texts = [prompt(second, part), *hints(second, part), worked_solution(second, part)]
            assert linear in texts[0]
            for text in texts:
                assert r"\omega_x, \omega_y, \omega_z, v_x" not in text and r"(\omega, v)" not in text
                assert r"\\ v " not in text and "(0, v" not in text and r"(\omega_i" not in text, part.name
    shown = [worked_solution(second, part) for part in second.parts if part.name == "twist"]
    assert all(r"\begin{bmatrix} v \\ \omega \end{bmatrix}" in text for text in shown)


def test_a_solution_shows_its_blocks_where_they_stand() -> None:
    first, second = both("planar-2r", 1, "chapter")
    (one, other) = (to_text(worked_solution(problem, problem["body-adjoint"])) for problem in (first, second))
    assert "⎡R      0⎤" in one and "⎣[P] R  R⎦" in one
    assert "⎡R  [P] R⎤" in other and "⎣0  R    ⎦" in other


# --- how it is said ---


def test_an_id_says_the_order() -> None:
    identity = ProblemId.parse("planar-2r/7@chapter@screws@v-omega")
    assert (identity.convention, identity.twist_order) == ("screws", "v-omega")
    assert str(identity) == "planar-2r/7@chapter@screws@v-omega"
    assert ProblemId.parse("planar-2r/7@v-omega") == ProblemId.parse("planar-2r/7@screws@v-omega")
    assert ProblemId.parse("planar-2r/7@screws@omega-v") == ProblemId.parse("planar-2r/7@screws")
    assert generate(identity, ["home-screws"]).chain.twist_order == "v-omega"


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("planar-2r/7@dh@v-omega", "is told by a table (convention = 'dh'); the order of twists is for arms that are"),
        ("planar-2r/7@screws@v-w", "(did you mean the order of twists 'v-omega'?)"),
        ("planar-2r/7@v-omega@omega-v", "names two orders of twists, v-omega and omega-v; it may have one of each"),
    ],
)
def test_a_wrong_order_is_told(said: str, told: str) -> None:
    with pytest.raises(QdotError) as caught:
        ProblemId.parse(said)
    assert told in str(caught.value)


def test_the_order_changes_the_digest_and_the_usual_one_changes_nothing() -> None:
    first, second = both("planar-2r", 1, "chapter")
    assert "twist_order" not in robot_json(first.chain) and robot_json(second.chain)["twist_order"] == "v-omega"
    assert digests(first)["arm"] != digests(second)["arm"]
    told = replace(second.chain, convention="dh")
    assert "twist_order" not in robot_json(told)


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


def test_a_file_says_the_order_and_is_written_with_it(tmp_path: Path) -> None:
    path, again = tmp_path / "arm.toml", tmp_path / "again.toml"
    path.write_text(ARM)
    robot = read_robot_file(path)
    assert robot.chain.twist_order == "v-omega"
    again.write_text(robot_text(robot, "screws"))
    assert 'twist_order = "v-omega"' in again.read_text() and read_robot(again) == robot.chain
    assert "twist_order" not in robot_text(robot, "dh")
    data = solution_data(solve(robot.chain))
    assert errors("solve", json.loads(json.dumps(data))) == []
    assert data["twist_rows"] == ["vx", "vy", "vz", "wx", "wy", "wz"]
    assert data["space_jacobian"][1] == ["0", "-a1*cos(theta1)"] and data["space_jacobian"][5] == ["1", "1"]
    assert data["body_jacobian"][0] == ["a1*sin(theta2)", "0"] and data["body_jacobian"][5] == ["1", "1"]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (("v-omega", "v-w"), 'line 3: twist_order = "v-w": it is "omega-v" or "v-omega"'),
        (('"screws"', '"dh"'), 'line 3: twist_order = "v-omega": it is of arms that are told by their axes'),
    ],
)
def test_a_wrong_order_in_a_file_is_told(tmp_path: Path, changed: tuple[str, str], told: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(ARM.replace(*changed))
    with pytest.raises(QdotError) as caught:
        read_robot(path)
    assert told in str(caught.value)


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    init_assignment(tmp_path / "hw", "Homework", "hw")
    (tmp_path / "hw" / "roster.csv").write_text("student\nada\n")
    (tmp_path / "hw" / "arm.toml").write_text(ARM)
    yield tmp_path / "hw"


def _assignment(folder: Path, top: str, *problems: str) -> None:
    entries = "".join(f'[[problem]]\nquestions = ["position"]\n{one}\n' for one in problems)
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{top}\n{entries}')


PLANAR, OWN = 'family = "planar-2r"\n', 'robot = "arm.toml"\n'


def test_the_nearest_key_says_the_order(folder: Path) -> None:
    def told(top: str, *problems: str) -> list[str]:
        _assignment(folder, top, *problems)
        return [problem.chain.twist_order for _, problem in load_assignment(folder).problems("ada")]

    by_axes, v, w = 'convention = "screws"\n', 'twist_order = "v-omega"\n', 'twist_order = "omega-v"\n'
    assert told("", PLANAR, OWN) == ["omega-v", "v-omega"]
    assert told(by_axes + v, PLANAR, PLANAR + w, OWN, OWN + w) == ["v-omega", "omega-v", "v-omega", "omega-v"]
    assert told(by_axes + w, PLANAR, PLANAR + v, OWN) == ["omega-v", "v-omega", "omega-v"]
    assert told(v, PLANAR, PLANAR + by_axes) == ["omega-v", "v-omega"]


def test_another_order_is_another_assignment(folder: Path) -> None:
    digests_of = []
    for top in ("", 'twist_order = "omega-v"\n', 'twist_order = "v-omega"\n'):
        _assignment(folder, 'convention = "screws"\n' + top, PLANAR)
        digests_of.append(load_assignment(folder).digest)
    assert digests_of[0] == digests_of[1] != digests_of[2]


@pytest.mark.parametrize(
    ("top", "problem", "told"),
    [
        ('twist_order = "v-omega"', "", 'twist_order = "v-omega": no arm of this assignment is told by its axes'),
        ("", 'twist_order = "v-omega"', "its arms are told by tables; the order of twists is for arms"),
        ('convention = "screws"\ntwist_order = "v-w"', "", "unknown order of twists 'v-w' (did you mean 'v-omega'?)"),
        ('convention = "screws"\ntwist_order = 1', "", "it is the order of twists of arms that are told by their axes"),
    ],
)
def test_a_wrong_order_in_an_assignment_is_told(folder: Path, top: str, problem: str, told: str) -> None:
    _assignment(folder, top, PLANAR + problem)
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    assert told in str(caught.value)


def test_an_arm_has_one_of_the_orders() -> None:
    with pytest.raises(QdotError, match="unknown order of a twist 'v, omega'"):
        Chain("m", (Joint("R", "theta1", 0, "a1", 0),), ("vx",), convention="screws", twist_order="v, omega")
    assert Robot(Chain("m", (Joint("R", "theta1", 0, "a1", 0),), ("vx",))).chain.twist_order == "omega-v"
