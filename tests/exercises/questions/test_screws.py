"""Arms described by screw axes: published Jacobians, independent exponentials, and texts without link frames."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis, move_point_along_axes
from qdot.exercises.arm.chain import Chain, Joint, Point
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.family import Family
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.generation import generate, list_applicable_questions, sample_chain
from qdot.exercises.mistakes.catalogue import CATALOGUE, SECTIONS, generate_mistaken_answers
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS as EVERY
from qdot.exercises.questions.screws import (
    QUESTIONS,
    SpaceJacobianDetails,
    derive_body_adjoint,
    derive_body_jacobian,
    derive_body_rotation,
    derive_space_jacobian,
)
from qdot.exercises.reference_answers import Choice
from qdot.exercises.robots.robot_file import Robot, read_robot
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.exercises.short_questions.choice import FormulaOptions
from qdot.exercises.solve.solver import ReadyResult, generate_text_events
from qdot.exercises.verify import certificate
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.markup import to_text
from qdot.exercises.writing.problem_texts import (
    get_solution_steps,
    write_hints,
    write_prompt,
    write_solution,
    write_statement,
)
from tests.support.suites import SHAPES, few_families, on_families, select_for_suite

FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
NAMES = tuple(question.name for question in QUESTIONS)
Q1, Q2, Q3 = sp.symbols("theta1:4")
A1, A2, A3, D1 = sp.symbols("a1 a2 a3 d1")


def sample_screw_arm(family: str, variation: str = "full", seed: int = 1) -> Chain:
    return sample_chain(ProblemId(family, seed, variation=variation, convention="screws"))


def equals_published(derived: sp.Matrix, published: list[list[sp.Expr]]) -> bool:
    return (derived - sp.Matrix(published)).applyfunc(sp.simplify).is_zero_matrix


def test_space_jacobian_of_scara_is_the_published_one() -> None:
    """Three parallel axes and a prismatic joint along them (the first example of most courses)."""
    arm = sample_screw_arm("scara-rrrp", "chapter")
    jacobian, s1, c1 = derive_space_jacobian(arm), sp.sin(Q1), sp.cos(Q1)
    x, y = A1 * c1 + A2 * sp.cos(Q1 + Q2), A1 * s1 + A2 * sp.sin(Q1 + Q2)
    assert equals_published(jacobian[:, :3], [[0] * 3, [0] * 3, [1] * 3, [0, A1 * s1, y], [0, -A1 * c1, -x], [0] * 3])
    assert equals_published(jacobian[:, 3], [[0]] * 5 + [[-1]])


@on_families(select_for_suite(["polar-rp", "elbow-3r"], FIXED))
def test_adjoint_converts_body_jacobian_to_space_jacobian(family: str) -> None:
    arm = sample_screw_arm(family)
    if "body-pose" not in list_applicable_questions(arm):
        pytest.skip("its pose is too long")
    stream = Stream(f"adjoint/{family}")
    known = {symbol: sp.Float(stream.uniform(0.3, 1.2), 30) for symbol in (*arm.q, *arm.parameters)}
    apart = derive_body_adjoint(arm) * derive_body_jacobian(arm) - derive_space_jacobian(arm)
    assert max(abs(entry) for entry in apart.xreplace(known).evalf(20)) < 1e-15


@on_families(select_for_suite(["polar-rp", "scara"], FIXED))
def test_screw_questions_are_certified(family: str) -> None:
    """Certificates use exponentials of the stated axes, frames at home, and finite differences."""
    arm = sample_screw_arm(family)
    questions = tuple(name for name in list_applicable_questions(arm) if name in NAMES)
    certificate = certify(generate(ProblemId(family, 1, questions, variation="full", convention="screws")))
    assert certificate.passed, certificate.failures
    checks = {check.name for check in certificate.checks if check.name.startswith("axes at home: ")}
    assert checks == {
        f"axes at home: {what}"
        for what in ("directions", "P", *(["points on them"] if "R" in {joint.kind for joint in arm.joints} else []))
    }


NINTH = sp.Rational(1, 9)
WRONG_AXES: dict[str, Callable[[Axis, sp.Matrix], tuple[Axis, sp.Matrix]]] = {
    "directions": lambda axis, point: (replace(axis, direction=-axis.direction), point),
    "points on them": lambda axis, point: (replace(axis, point=axis.point + sp.Matrix([0, NINTH, 0])), point),
    "P": lambda axis, point: (axis, point + sp.Matrix([0, 0, NINTH])),
}


@pytest.mark.parametrize("what", WRONG_AXES)
def test_certificate_detects_wrong_axes(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It does even if only the screws are asked, which come from the same table."""
    problem = generate("elbow-3r/1@chapter@screws", ["home-screws"])

    def compute_wrong_axes(chain: Chain) -> tuple[list[Axis], sp.Matrix]:
        (first, *others), point = compute_home_geometry(chain)
        first, point = WRONG_AXES[what](first, point)
        return [first, *others], point

    monkeypatch.setattr(certificate, "compute_home_geometry", compute_wrong_axes)
    assert [check.name for check in certify(problem).failures] == [f"axes at home: {what}"]


@pytest.mark.parametrize("variation", select_for_suite(["full"], ["chapter", "zeros", "full"]))
def test_screw_options_belong_to_the_arm_at_its_home(variation: str) -> None:
    """The home may contain roots, although an arm of the same structure has another home without roots."""
    asked = set()
    for family in ("planar-2r", "planar-rrp", "elbow-3r"):
        arm = sample_screw_arm(family, variation)
        for name in ("screw-choice", "space-column-choice"):
            if SHORT_QUESTIONS[name].find_obstacle(arm) is None:
                problem = generate(ProblemId(family, 1, (name,), variation=variation, convention="screws"))
                (part,) = problem.parts
                assert certify(problem).passed
                options, subject = (
                    part.details_as(FormulaOptions).offered_options,
                    part.details_as(FormulaOptions).subject,
                )
                whole = _ask_reference(arm, subject.base_question)
                assert (
                    (options[part.answer_as(Choice).correct].content - whole[:, subject.column]).expand().is_zero_matrix
                )
                mistakes = {blame.mistake for option in options for blame in option.blames}
                assert mistakes <= {mistake.name for mistake in SECTIONS["Screws and exponentials"]}
                asked.add(name)
    assert "screw-choice" in asked


LINK_FRAME_TEXT = re.compile(
    r"O_\{?[0-9]|z_\{|(?<!\$)\bz_[0-9]|p\^\*|(?<!\d )R_\{?[0-9i]|[Ff]rame (?:\$?[0-9]|\$i)"
    r"|base frame|world frame|Denavit|twist \$\\alpha|by the twists|row of the table"
)
"""Text about link frames, which only tables have."""


HOME_ONLY = {"home-screws", "body-pose", "position"}
"""Questions whose texts name only axes at home; those in BOTH name home and moved axes."""
BOTH = {"joint-axes", "body-jacobian"}
NAMED_AXIS = r"(?:\\omega|\bv|\bq)_(?:\{[0-9i]\}|[0-9i])"
MOVED, AT_HOME = re.compile(f"{NAMED_AXIS}'"), re.compile(f"{NAMED_AXIS}(?!')")
SIDE_BY_SIDE = re.compile(rf"^({NAMED_AXIS}) &= .*, \\qquad \1' = .*$", re.MULTILINE)


@few_families
def test_no_text_names_link_frames_and_moved_axes_have_primes(family: str) -> None:
    if family not in FIXED:
        pytest.skip("its arms are of many structures")
    arm, each = sample_screw_arm(family), select_for_suite(72, 4)
    questions = list_applicable_questions(arm)
    turn = [*SHAPES.values()].index(family) % each
    names = [*questions[turn::each], *list_applicable_questions(arm, SHORT_QUESTIONS)[turn::each]]
    for problem in (generate(ProblemId(family, 1, (name,), variation="full", convention="screws")) for name in names):
        (part,) = problem.parts
        texts = [write_prompt(problem, part), *write_hints(problem, part), write_solution(problem, part)]
        for text in (write_statement(problem, ""), *texts):
            assert not LINK_FRAME_TEXT.search(text), (part.name, text)
        unfit = MOVED if part.name in HOME_ONLY else AT_HOME
        if part.name in questions and part.name not in BOTH:
            assert not any(unfit.search(SIDE_BY_SIDE.sub("", text)) for text in texts), (part.name, texts)


@few_families
def test_no_mistake_message_names_a_table_or_link_frames(family: str) -> None:
    if family not in FIXED:
        pytest.skip("its arms are of many structures")
    arm = sample_screw_arm(family)
    shapes = ((3, 1), (6, arm.n), (6, 1), (arm.n, arm.n), (1, 1))
    messages = {
        m.format_message(slip.words)
        for m in CATALOGUE.values()
        for shape in shapes
        for slip in m.generate_variants(arm, shape)
    }
    for part in generate(
        ProblemId(family, 1, tuple(list_applicable_questions(arm)), variation="full", convention="screws")
    ).parts:
        messages |= {mistake.format_message(take.words) for mistake, take in generate_mistaken_answers(arm, part)}
    table = re.compile(
        r"\b(table|frames?|(?<!exchanged )(?<!sign of )rows?) (\d|i\b|of the table|below)"
        r"|\btable\b|(base|last|own) frame|p\*|\bO\d"
    )
    assert not [sentence for sentence in messages if table.search(sentence)]


def _ask_reference(chain: Chain, name: str) -> sp.Matrix:
    answer, _ = EVERY[name].ask(chain, Stream("order"))
    return answer.as_matrix()


def test_screw_questions_apply_to_screw_arms_only() -> None:
    arm = sample_chain(ProblemId("planar-2r", 1))
    assert not set(list_applicable_questions(arm)) & set(NAMES)
    by = sample_screw_arm("planar-2r")
    assert set(NAMES) <= set(list_applicable_questions(by))
    assert not {"transform", "position-vectors", "link-velocity", "tool-jacobian"} & set(list_applicable_questions(by))


def write_screw_robot(path: Path, point: str, *joints: str) -> Path:
    """Write a robot file with screw axes: each joint is an axis, with a point on it if it is revolute."""
    rows = [joint.split(" at ") for joint in joints]
    lines = [f'kind = "{"PR"[len(row) - 1]}"\naxis = {row[0]}' for row in rows]
    points = [f"\npoint = {row[1]}" if len(row) == 2 else "" for row in rows]
    text = "".join(f"[[joint]]\n{line}{at}\n" for line, at in zip(lines, points, strict=True))
    path.write_text(f'name = "{path.stem}"\nconvention = "screws"\npoint = {point}\n{text}')
    return path


@pytest.mark.whole
def test_own_arm_is_described_with_the_points_of_its_file(tmp_path: Path) -> None:
    joints = ("[0, 0, 1] at [0.1, 0.2, 0.5]", "[0, 1, 1]", "[1, 1, 0] at [0.1, 0.4, 0.1]")
    chain = read_robot(write_screw_robot(tmp_path / "oblique.toml", '[0, "0.4 + a2", 0.1]', *joints))
    texts = {}
    for stage in generate_text_events(Robot(chain)):
        if isinstance(stage, ReadyResult):
            texts[stage.name] = to_text(stage.content)
            if stage.name == "body-jacobian":  # later stages contain no points
                break
    assert "(0.1, 0.2, 0.5) m" in texts["arm"] and "(0.1, 0.4, 0.1) m" in texts["arm"]
    assert "⎢0  1  0  a₂ + 0.4⎥" in texts["arm"]
    for name in ("arm", "home-screws", "position", "jacobian", "geometric-jacobian", "space-jacobian", "body-jacobian"):
        assert "(√2 (" not in texts[name], name
    # Compare P and each point with exponentials of the stated axes of the joints that move it.
    axes, home = compute_home_geometry(chain)
    q, lengths = np.array([0.3, -0.4, 1.1]), {sp.Symbol("a2"): 0.7}
    values = lengths | dict(zip(chain.q, q, strict=True))
    for joint, place in get_solution_steps(chain).point_positions:
        moved = np.where(np.arange(1, 4) < joint, 0, q)
        assert np.allclose(_evaluate_vector(place, values), move_point_along_axes(axes, home, moved, lengths))
    _, details = next(question for question in QUESTIONS if question.name == "space-jacobian").ask(chain, Stream("x"))
    assert isinstance(details, SpaceJacobianDetails)
    for number, screw in enumerate(details.moved_screws):
        if screw.kind == "R":
            there = move_point_along_axes(axes[:number], sp.Matrix(chain.axis_points[number]), q[:number], lengths)
            assert np.allclose(_evaluate_vector(screw.point, values), there)
            assert np.allclose(_evaluate_vector(screw.moment + screw.direction.cross(screw.point), values), 0)


def _evaluate_vector(vector: sp.Matrix, values: dict[sp.Symbol, float]) -> np.ndarray:
    return np.array([float(entry.xreplace(values)) for entry in vector])


def test_point_on_inner_link_is_certified() -> None:
    joints = tuple(Joint("R", f"theta{i}", 0, f"a{i}", "pi/2" if i == 1 else 0) for i in (1, 2, 3))
    arm = Chain("m", joints, ("vx", "vy"), tool=Point(2), convention="screws")
    certificate = certify(generate(ProblemId("m", 1, ("position",)), family=Family("m", "m", "m", arm)))
    assert certificate.passed, certificate.failures


def test_length_may_have_the_name_of_a_hidden_table_length(tmp_path: Path) -> None:
    """In the hidden table, joint 1 has the length 0.3 where a1 would be expected."""
    joints = ("[0, 0, 1] at [0, 0, 0]", "[0, 0, 1] at [0.3, 0, 0]")
    family = read_robot_family(write_screw_robot(tmp_path / "arm.toml", '["a1 + 0.3", 0, 0]', *joints))
    certificate = certify(generate(ProblemId(family.name, 1, ("position", "determinant")), family=family))
    assert certificate.passed, certificate.failures


def test_body_jacobian_of_skew_axes_is_short_and_agrees_with_differences(tmp_path: Path) -> None:
    """With symbols for odd angles it had tens of thousands of terms."""
    joints = ["[0, 0, 1] at [0, 0, 0]", "[1, 1, 0] at [0.1, 0, 0.2]", "[0, 1, 1]", "[1, 0, 1] at [0.3, 0.2, 0.1]"]
    joints = joints[: select_for_suite(3, 4)]
    last = '[0, 1, 1] at [0, "a2", 0.1]'
    chain = read_robot(write_screw_robot(tmp_path / "skew.toml", '[0.1, "a2", 0.3]', *joints, last))
    jacobian, rotation = derive_body_jacobian(chain), derive_body_rotation(chain)
    assert sum(len(sp.Add.make_args(entry)) for entry in jacobian) < 400
    axes, home = compute_home_geometry(chain)
    q, lengths = np.array([0.3, -0.4, 0.5, 1.1, 0.8])[: chain.n], {sp.Symbol("a2"): 0.7}
    values = lengths | dict(zip(chain.q, q, strict=True))

    def compute_pose(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place = move_point_along_axes(axes, home, at, lengths)
        turned = [move_point_along_axes(axes, home + sp.eye(3)[:, k], at, lengths) - place for k in range(3)]
        return np.array(turned).T, place

    turn, _ = compute_pose(q)
    assert np.allclose(np.array(rotation.xreplace(values).evalf().tolist(), dtype=float), turn)
    expected = []
    for step in 1e-6 * np.eye(chain.n):
        (r1, p1), (r0, p0) = compute_pose(q + step), compute_pose(q - step)
        spin, v = turn.T @ (r1 - r0) / 2e-6, turn.T @ (p1 - p0) / 2e-6
        expected.append([spin[2, 1], spin[0, 2], spin[1, 0], *v])
    assert np.allclose(
        np.array(jacobian.xreplace(values).evalf().tolist(), dtype=float), np.array(expected).T, atol=1e-8
    )
