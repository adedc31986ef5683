"""Arms described by screw axes: independent exponentials, texts without link frames, and either order of twists."""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis, move_point_along_axes
from qdot.exercises.arm.chain import TWIST_ORDERS, Chain, Joint, Point
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.family import Family
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.generation import generate, list_applicable_questions, sample_chain
from qdot.exercises.mistakes.catalogue import CATALOGUE, SECTIONS, generate_mistaken_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.problem.record import compute_digests, make_arm_json
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.screws import QUESTIONS as SCREW_QUESTIONS
from qdot.exercises.questions.screws import SpaceJacobianDetails, derive_body_jacobian, derive_body_rotation
from qdot.exercises.reference_answers import Choice
from qdot.exercises.robots.robot_file import Robot, read_robot, read_robot_file
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.exercises.short_questions.choice import FormulaOptions
from qdot.exercises.verify import certificate
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.problem_texts import (
    get_solution_steps,
    write_hints,
    write_prompt,
    write_solution,
    write_statement,
)
from tests.repository.test_schemas import find_schema_errors
from tests.support import read_data
from tests.support.solving import solve_to_json
from tests.support.suites import SHAPES, few_families, on_families, sample_for_suite, select_for_suite
from tests.tools.diagnoses import classify_diagnosis, make_wrong_answers

FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
NAMES = tuple(question.name for question in SCREW_QUESTIONS)
Q1, Q2, Q3 = sp.symbols("theta1:4")
A1, A2, A3, D1 = sp.symbols("a1 a2 a3 d1")


def sample_screw_arm(family: str, variation: str = "full", seed: int = 1) -> Chain:
    return sample_chain(ProblemId(family, seed, variation=variation, convention="screws"))


@on_families(select_for_suite(["polar-rp", "scara"], FIXED))
def test_screw_questions_are_certified(family: str) -> None:
    """Certificates use exponentials of the stated axes, frames at home, and finite differences."""
    arm = sample_screw_arm(family)
    questions = tuple(name for name in list_applicable_questions(arm) if name in NAMES)
    certificate = certify(generate(ProblemId(family, 1, questions, variation="full", convention="screws")))
    assert certificate.passed, certificate.failures
    checks = {check.name for check in certificate.checks if check.name.startswith("axes at home: ")}
    named = ("directions", "P", *(["points on them"] if arm.revolute_joints else []))
    assert checks == {f"axes at home: {what}" for what in named}


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
                details = part.details_as(FormulaOptions)
                options, subject = details.offered_options, details.subject
                reference, _ = QUESTIONS[subject.base_question].ask(arm, Stream("order"))
                column = reference.as_matrix()[:, subject.column]
                assert (options[part.answer_as(Choice).correct].content - column).expand().is_zero_matrix
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


@on_families(select_for_suite(("polar-rp",), tuple(SHAPES.values())))
def test_no_text_names_link_frames_and_moved_axes_have_primes(family: str) -> None:
    if family not in FIXED:
        pytest.skip("its arms are of many structures")
    arm, each = sample_screw_arm(family), select_for_suite(72, 10)
    turn = [*SHAPES.values()].index(family) % each
    questions = list_applicable_questions(arm)
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
    every = [(mistake, shape) for mistake in CATALOGUE.values() for shape in shapes]
    messages = {m.format_message(slip.words) for m, shape in every for slip in m.generate_variants(arm, shape)}
    identity = ProblemId(family, 1, tuple(list_applicable_questions(arm)), variation="full", convention="screws")
    for part in generate(identity).parts:
        messages |= {mistake.format_message(take.words) for mistake, take in generate_mistaken_answers(arm, part)}
    table = re.compile(
        r"\b(table|frames?|(?<!exchanged )(?<!entries of )rows?) (\d|i\b|of the table|below)"
        r"|\btable\b|(base|last|own) frame|p\*|\bO\d"
    )
    assert not [sentence for sentence in messages if table.search(sentence)]


def test_screw_questions_apply_to_screw_arms_only() -> None:
    arm = sample_chain(ProblemId("planar-2r", 1))
    assert not set(list_applicable_questions(arm)) & set(NAMES)
    by = sample_screw_arm("planar-2r")
    assert set(NAMES) <= set(list_applicable_questions(by))
    assert not {"transform", "position-vectors", "link-velocity", "tool-jacobian"} & set(list_applicable_questions(by))


def write_screw_robot(path: Path, point: str, *joints: str) -> Path:
    rows = [joint.split(" at ") for joint in joints]
    lines = [f'kind = "{"PR"[len(row) - 1]}"\naxis = {row[0]}' for row in rows]
    points = [f"\npoint = {row[1]}" if len(row) == 2 else "" for row in rows]
    text = "".join(f"[[joint]]\n{line}{at}\n" for line, at in zip(lines, points, strict=True))
    path.write_text(f'name = "{path.stem}"\nconvention = "screws"\npoint = {point}\n{text}')
    return path


def test_points_of_an_own_arm_are_moved_along_its_axes(tmp_path: Path) -> None:
    """P and the point of each axis, by exponentials of the axes of the joints that move it."""
    joints = ("[0, 0, 1] at [0.1, 0.2, 0.5]", "[0, 1, 1]", "[1, 1, 0] at [0.1, 0.4, 0.1]")
    chain = read_robot(write_screw_robot(tmp_path / "oblique.toml", '[0, "0.4 + a2", 0.1]', *joints))
    axes, home = compute_home_geometry(chain)
    q, lengths = np.array([0.3, -0.4, 1.1]), {sp.Symbol("a2"): 0.7}
    values = lengths | dict(zip(chain.q, q, strict=True))
    for joint, place in get_solution_steps(chain).point_positions:
        moved = np.where(np.arange(1, 4) < joint, 0, q)
        assert np.allclose(_evaluate_vector(place, values), move_point_along_axes(axes, home, moved, lengths))
    _, details = QUESTIONS["space-jacobian"].ask(chain, Stream("x"))
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
    ours = np.array(jacobian.xreplace(values).evalf().tolist(), dtype=float)
    assert np.allclose(ours, np.array(expected).T, atol=1e-8)


FEW_ARMS = ["planar-2r", "spherical-offset", "wrist-zyz"]
ARMS = select_for_suite(FEW_ARMS, [*FEW_ARMS, "elbow-3r", "scara-rrrp", "cartesian"])
IN_ORDER = (
    "home-screws", "space-jacobian", "body-jacobian", "space-twist", "body-twist", "geometric-jacobian", "twist",
    "body-adjoint",
)  # fmt: skip
"""Questions whose answers have six rows like a twist."""
SWAPPED = [3, 4, 5, 0, 1, 2]


def generate_both_orders(family: str, seed: int = 1, variation: str = "full") -> tuple[Problem, Problem]:
    """Return a problem with twists (omega, v) and the same with (v, omega), with the questions that show the order."""
    first, second = (_generate_with_order(family, seed, variation, order) for order in TWIST_ORDERS)
    return first, second


@cache
def _generate_with_order(family: str, seed: int, variation: str, order: str) -> Problem:
    identity = ProblemId(family, seed, variation=variation, convention="screws").with_convention("", order)
    arm = sample_chain(identity)
    return generate(identity, [name for name in (*IN_ORDER, "position") if QUESTIONS[name].find_obstacle(arm) is None])


@pytest.mark.parametrize("family", sample_for_suite(ARMS, 1))
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
        configurations = sample_configurations(problem.chain, part, problem.domain, 3, Stream("put"))
        w = compute_numeric_stages(problem.chain, configurations)
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
@pytest.mark.parametrize("name", sample_for_suite(NAMED, 3))
def test_mistakes_are_named_in_either_order(name: str, order: str) -> None:
    problem = _generate_with_order("planar-2r" if name == "body-adjoint" else "elbow-3r", 1, "chapter", order)
    answers = make_wrong_answers(problem, problem[name], mistakes=NAMED[name])
    verdicts = {answer.mistake: classify_diagnosis(answer) for answer in answers}
    assert verdicts == dict.fromkeys(NAMED[name], "named")


V, OMEGA = "v_x, v_y, v_z", r"\omega_x, \omega_y, \omega_z"


@pytest.mark.parametrize("family", sample_for_suite(ARMS, 1))
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


ARM = read_data("screws_with_order.toml")


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
