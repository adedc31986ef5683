"""`qdot solve`: every form of its output, and mistakes in a file told by place.

test_textbook_results.py compares what is derived and displayed with textbooks.
"""

import json
import re
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation import derivation
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.entry import to_sympy
from qdot.exercises.robots.robot_file import read_robot, read_robot_file
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.singular_set import Component
from qdot.exercises.solve.solver import ReadyResult, generate_text_events, solve
from qdot.exercises.solve.time_limited import write_solution
from qdot.exercises.writing.markup import to_text
from qdot.exercises.writing.problem_texts import get_solution_steps
from qdot.exercises.writing.solution_steps import SingularComponent, SolutionSteps
from tests.repository.test_schemas import find_schema_errors
from tests.support import read_cases
from tests.support.command import run, run_and_fail
from tests.support.solving import solve_to_json, solve_to_text
from tests.support.suites import sample_for_suite


def test_the_pose_at_home_of_oblique_axes_is_what_the_file_says(tmp_path: Path) -> None:
    """The table that is worked with has products of roots in brackets, which make the point that was given."""
    axes = TURN % ("[0, 0, 1]", "[0, 0, 0]") + TURN % ("[1, 1, 0]", '["a1", 0, 0.2]') + SLIDE % "[0, 3, 4]"
    chain = _read(tmp_path, 'name = "Oblique"\nconvention = "screws"\npoint = ["a1 + a2", 0, "1/4"]\n' + axes)
    (a1, a2, d3), share = sp.symbols("a1 a2 d3"), sp.Rational(1, 5)
    steps = SolutionSteps(chain)
    assert list(steps.point_at_home) == [a1 + a2, 0, sp.Rational(1, 4)]
    assert list(steps.derive_axis_at_home(3)) == [0, 3 * share, 4 * share]
    (_, place), *_ = steps.point_positions
    assert list(place) == [a1 + a2, 3 * share * d3, 4 * share * d3 + sp.Rational(1, 4)]


@pytest.mark.parametrize("name", ["planar_2R", "SCARA_RRRP", "ZYZ_wrist", "pan_tilt_2R", "cartesian_PPP"])
def test_every_form_is_written(name: str, textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms[name].chain
    text, latex, data = solve_to_text(chain, "text"), solve_to_text(chain, "latex"), solve_to_json(chain)
    assert "$" not in text and "\\" not in text
    assert latex.count(r"\begin{") == latex.count(r"\end{")
    assert latex.replace(r"\\[6pt]", "").count(r"\[") == latex.count(r"\]")
    assert len(data["position"]) == 3 and np.array(data["jacobian"]).shape == (3, chain.n)
    assert np.array(data["geometric_jacobian"]).shape == (6, chain.n)
    entries = [entry for row in data["geometric_jacobian"] for entry in row]
    for entry in [*data["position"], *entries, data["determinant"] or "0"]:
        to_sympy(parse_formula(entry))


ROW = '[[joint]]\nkind = "R"\ntheta = "%s"\nd = %s\na = %s\nalpha = %s\n'
TWO_R = 'name = "two"\n' + ROW % ("theta1", 0, '"a1"', 0) + ROW % ("theta2 + pi/2", 0, 0.35, 0)


def _read(tmp_path: Path, text: str) -> Chain:
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return read_robot(path)


def test_decimals_are_exact_and_the_default_task_is_that_of_the_plane(tmp_path: Path) -> None:
    chain = _read(tmp_path, TWO_R)
    second = chain.joints[1]
    assert (second.a, second.theta) == (sp.Rational(7, 20), sp.Symbol("theta2") + sp.pi / 2)
    assert chain.task == ("vx", "vy")


def _refused(tmp_path: Path, old: str, new: str) -> str:
    assert old in TWO_R
    with pytest.raises(QdotError) as caught:
        _read(tmp_path, TWO_R.replace(old, new, 1))
    said = str(caught.value)
    assert "\n" not in said and "Decimal" not in said and said.startswith(str(tmp_path / "arm.toml"))
    return said.removeprefix(f"{tmp_path}/")


HEAD, LAST = 'name = "two"', "a = 0.35\nalpha = 0\n"
REFUSED = read_cases("refused_robots")


@pytest.mark.parametrize(("old", "new", "said"), REFUSED["changes"])
def test_a_mistake_is_told_by_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    told = _refused(tmp_path, old, new)
    assert all(piece in told for piece in said.split(" … ")), told


@pytest.mark.parametrize(("key", "typed", "end"), REFUSED["entries"])
def test_units_and_products_without_a_sign_are_refused(tmp_path: Path, key: str, typed: str, end: str) -> None:
    line = {"a": f'a = "{typed}"\nalpha = 0\n', "alpha": f'a = 0.35\nalpha = "{typed}"\n'}[key]
    said = _refused(tmp_path, LAST, line)
    assert said.startswith(f'arm.toml: line {12 + (key == "alpha")}: joint 2: {key} = "{typed}": ')
    assert said.endswith(end)


@pytest.mark.parametrize(
    ("entry", "value"),
    [("2a1", "2*a1"), ("2(a1 + h)", "2*a1 + 2*h"), ("L_2", "L2"), ("sqrt(a1^2 + d1^2)", "sqrt(a1**2 + d1**2)")],
)
def test_what_can_be_meant_in_one_way_only_is_read(tmp_path: Path, entry: str, value: str) -> None:
    assert _read(tmp_path, TWO_R.replace("a = 0.35", f'a = "{entry}"')).joints[1].a == sp.expand(sp.sympify(value))
    turned = _read(tmp_path, TWO_R.replace(LAST, 'a = 0.35\nalpha = "2pi/3 + atan2(a1, h)"\n')).joints[1].alpha
    assert turned == 2 * sp.pi / 3 + sp.atan2(sp.Symbol("a1"), sp.Symbol("h"))


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("a = 0.35", "a = 400", "line 12: joint 2: a = 400"),
        (HEAD, f"{HEAD}\npoint = [0, 0, 400]", "line 2: point = [0, 0, 400]"),
        (LAST, LAST + "[draw]\na1 = [100, 400]\n", "line 15: draw: a1 = [100, 400]"),
    ],
)
def test_lengths_in_millimetres_are_noticed(tmp_path: Path, old: str, new: str, place: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(TWO_R.replace(old, new, 1), encoding="utf-8")
    (said,) = read_robot_file(path).notes
    assert said.startswith(f"{path}: {place}: ") and said.endswith(" 0.4")
    path.write_text(TWO_R.replace(old, new.replace("400", "20"), 1).replace("100", "10"), encoding="utf-8")
    assert read_robot_file(path).notes == ()


def test_a_file_that_is_not_there_or_no_text(tmp_path: Path) -> None:
    path = tmp_path / "no-arm.toml"
    with pytest.raises(QdotError, match=r"no-arm\.toml: .*file not found"):
        read_robot(path)
    path.write_bytes(b'name = "x"\n\xff\n')
    with pytest.raises(QdotError, match=r"no-arm\.toml: line 2: .*UTF-8"):
        read_robot(path)
    with pytest.raises(QdotError, match="can't be read"):
        read_robot(tmp_path)
    path.write_text("\ufeff" + TWO_R, encoding="utf-8")  # a byte order mark
    assert read_robot(path).n == 2


@pytest.fixture
def hardly_any_terms(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let a determinant of more than one term be too long."""
    monkeypatch.setattr(derivation, "MAX_MINOR_TERMS", 1)
    kept: tuple[Any, ...] = (derivation._expand_minors, derivation._derive_minors)
    for minors in kept:
        minors.cache_clear()
    yield
    for minors in kept:
        minors.cache_clear()


@pytest.mark.usefixtures("hardly_any_terms")
def test_what_would_be_too_long_to_read_is_not_worked_out(tmp_path: Path) -> None:
    """Position and Jacobian are; an arm of nine joints has tens of thousands of terms in its minors."""
    solution = solve(_read(tmp_path, TWO_R.replace('name = "two"', 'name = "too long"')))
    assert solution.determinant is None and solution.singular is None
    assert "more than 1 terms" in (solution.note or "")
    assert all("not derived" in solve_to_text(solution.chain, form) for form in ("text", "json"))
    obstacles = [QUESTIONS[name].find_obstacle(solution.chain) for name in ("singular-angles", "determinant")]
    assert obstacles[0] == obstacles[1]


def _many(count: int) -> str:
    return 'name = "long"\n' + "".join(ROW % (f"theta{i}", f'"d{i}"', f'"a{i}"', 0) for i in range(1, count + 1))


def test_an_arm_of_too_many_joints_is_refused_and_parallel_ones_count_for_their_plane(tmp_path: Path) -> None:
    with pytest.raises(QdotError, match=r"11 joints .*10"):
        _read(tmp_path, _many(11))
    assert _read(tmp_path, _many(6)).task == ("vx", "vy")


def test_rank_lost_everywhere_is_said_in_every_form(tmp_path: Path) -> None:
    text = TWO_R.replace('name = "two"', 'name = "two"\ntask = ["vx", "vz"]')
    solution = solve(_read(tmp_path, text))
    data = solve_to_json(solution.chain)
    assert data["singular"] is None and "every configuration" in data["note"]
    assert all("every configuration" in solve_to_text(solution.chain, form) for form in ("text", "latex"))


MODIFIED = (
    'name = "two"\nconvention = "modified-dh"\npoint = ["a2", 0, 0]\n'
    'base = {position = [0, 0, 0.5], rpy = ["pi", 0, 0]}\n'
    + ROW % ("theta1", 0, 0, 0) + ROW % ("theta2", 0, '"a1"', 0) + 'limits = ["-pi/2", "3*pi/4"]\n'
)  # fmt: skip


def test_an_arm_is_shown_as_it_was_told_and_its_limits_rule_values_out(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(MODIFIED.replace("base =", "# base ="))
    assert "Given by" not in run("solve", path)  # it is told so
    path.write_text(MODIFIED)
    said = run("solve", path)
    assert "Given by" in said and "Craig" in said and "(0, 0, 0.5) m in the world" in said
    assert "rule out θ₂ = 180° (from −90° to 135°)" in said
    axes = tmp_path / "axes.toml"
    axes.write_text(run("solve", path, "--convert", "screws"))
    by_axes = run("solve", axes)
    assert "Screw axes at home" in by_axes and "Denavit" not in by_axes
    assert 'base = {position = [0, 0, 0.5], rpy = ["pi", 0, 0]}' in run("solve", path, "--convert", "dh")
    assert "--convert 'craig'" in run_and_fail("solve", path, "--convert", "craig")
    assert "--format" in run_and_fail("solve", path, "--convert", "dh", "--format", "json")


AWKWARD = (
    'name = "two"\ntask = ["vx", "vy"]\npoint = [0.9123, 0.05671, 0]\n'
    + ROW % ("theta1", 0, 0.4, 0) + ROW % ("theta2 + 0.3", 0, 0, 0) + "limits = [-2.181661625, 1.134464045]\n"
)  # fmt: skip


def test_an_angle_without_a_short_form_is_rounded_and_in_one_unit(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(AWKWARD)
    text = " ".join(run("solve", path).split())
    assert "that is θ₂ = −0.3621 rad ≈ −20.75° or 2.78 rad ≈ 159.3°." in text
    assert "rule out θ₂ = 2.78 rad ≈ 159.3° (from −125° to 65°)" in text
    path.write_text(AWKWARD.replace("+ 0.3", "- 0.3 + pi/2").replace("0.9123, 0.05671", "0.9, 0"))
    text = " ".join(run("solve", path).split())
    assert "θ₂ − 0.3 + π/2 rad" in text
    assert "that is θ₂ = 0.3 + π/2 rad ≈ 107.2° or 0.3 − π/2 rad ≈ −72.81°." in text


@pytest.mark.whole
def test_configurations_without_a_simple_meaning_are_reported_as_such() -> None:
    """That all joints can move together with link 3 at rest is true of every singular configuration."""
    fifth = sp.Rational(1, 5)
    lengths = ((1, fifth, sp.pi / 3), (fifth, 2 * fifth, sp.pi / 4), (fifth, 3 * fifth, 0))
    rows = (Joint("R", sp.Symbol(f"theta{i}"), d, a, alpha) for i, (d, a, alpha) in enumerate(lengths, 1))
    (component,) = solve(Chain("skew", tuple(rows), ("vx", "vy", "vz"))).singular or ()
    assert component.classification.meaning == "these configurations have no simple geometric meaning"


SKEW = 'name = "skew"\ntask = ["vx", "vy", "vz"]\n' + ROW % ("theta1", '"d1"', "%s", '"pi/3"')
SKEW += ROW % ("theta2", "%s", "%s", 0)


@pytest.mark.parametrize(
    ("lengths", "said", "is_singular"),
    sample_for_suite(
        [
            (('"a1"', '"d2"', '"a2"'), "can hold together only for special lengths", False),
            (("0.2", "0.1", "0.4"), "full rank in every configuration", False),
            # a2^2 = a1^2 + 3 d2^2, so the conditions can hold together
            (("0.1", "0.1", "0.2"), "In every other configuration, at least one minor is not zero", True),
        ],
        1,
    ),
)
def test_conditions_that_hold_for_special_lengths_only_are_said_of_those(
    lengths: tuple[str, str, str], said: str, is_singular: bool, tmp_path: Path
) -> None:
    solution = solve(_read(tmp_path, SKEW % lengths))
    assert said in " ".join(solve_to_text(solution.chain, "text").split())
    assert bool(solution.singular) == is_singular


@pytest.mark.whole
def test_a_twist_whose_sine_is_below_a_fraction_bar_is_no_failure() -> None:
    first = Joint("R", "theta1", 0, sp.Rational(1, 5), sp.pi / 3)
    second = Joint("R", "theta2", sp.Rational(1, 10), sp.Rational(3, 10), -sp.pi / 4)
    assert solve(Chain("rrp", (first, second, Joint("P", 0, "d3", 0, 0)), VELOCITY_NAMES)).singular == ()


def test_a_table_is_shown_as_it_is_written_and_its_rewriting_is_said(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    first, second = (ROW % (f"-theta{i} + pi/2", 0.1, 0.3, '"pi/2"') for i in (1, 2))
    path.write_text(f'name = "m"\ntask = ["vx", "vy"]\n{first}{second}')
    given, _, standard = run("solve", path).partition("The same arm follows as a standard table")
    assert "joint variables count in the opposite direction" in given
    assert "90° − θ₁" in given and "90° − θ₂" in given and "−90°" not in given
    assert "θ₁ − 90°" in standard
    head = 'name = "m"\nconvention = "modified-dh"\nbase = {position = [0, 0, 1], rpy = ["pi/2", 0, 0]}\n'
    path.write_text(head + first)
    assert re.search(r"at \(0, 0, 1\) m, .* 90°, 0, 0", " ".join(run("solve", path).split()))


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ("cos(theta2)", "a configuration in which `cos(theta2) = 0`"),
        ("2 + cos(theta2)", "No configuration was found in which `cos(theta2) + 2 = 0`, in 60 searches"),
        ("theta1 - theta1", ""),
    ],
)
def test_what_a_test_in_numbers_finds_amiss_is_told(
    told: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = 'name = "arm"\n' + ROW % ("theta1", 0, 0.4, 0) + ROW % ("theta2", 0, 0.7, 0)
    chain = _read(tmp_path, text.replace("arm", f"arm {told}"))  # one of which nothing is kept
    conditions = [to_sympy(parse_formula(one)) for one in ("sin(theta2)", told) if one != "theta1 - theta1"]
    components = tuple(Component((condition,), None) for condition in conditions)
    shown = [SingularComponent(one.conditions, None, Classification("", False, "x")) for one in components]
    monkeypatch.setattr("qdot.exercises.solve.solver.find_singular_set", lambda _: components)
    monkeypatch.setattr(SolutionSteps, "singular_components", shown)
    solution = solve(chain)
    assert said in (solution.note or "") and (said == "") == (solution.note is None)
    monkeypatch.setattr(SolutionSteps, "singular_components", [])
    get_solution_steps.cache_clear()
    note = solve(chain).note
    assert "60 of the searches ended in a configuration that satisfies none of these conditions" in (note or "")


SLIDE = '[[joint]]\nkind = "P"\naxis = %s\n'
TURN = SLIDE.replace("P", "R") + "point = %s\n"
BY_AXES = 'name = "by its axes"\nconvention = "screws"\npoint = %s\n' + TURN % ("[0, 0, 1]", "[0.1, 0.2, 0.5]")
BY_AXES += SLIDE % "[0, 1, 1]" + TURN % ("[1, 0, 0]", '[0, "a1", 0.3]')


@pytest.mark.whole
def test_json_of_an_arm_told_by_axes_has_its_space_and_body_jacobian(tmp_path: Path) -> None:
    """The certificates of the questions on both hold them against exponentials of the axes."""
    chain = _read(tmp_path, BY_AXES % "[0.3, 0.4, 0.6]")
    data = solve_to_json(chain)
    assert find_schema_errors("solve", data) == [] and data["twist_rows"] == ["wx", "wy", "wz", "vx", "vy", "vz"]
    for name in ("space-jacobian", "body-jacobian"):
        reference, _ = QUESTIONS[name].ask(chain, Stream(name))
        entries = [[to_sympy(parse_formula(entry)) for entry in row] for row in data[name.replace("-", "_")]]
        assert (sp.Matrix(entries) - reference.as_matrix()).applyfunc(sp.simplify).is_zero_matrix
    inner = _read(tmp_path, BY_AXES % "{frame = 2, offset = [0.3, 0.4, 0.6]}")
    data = solve_to_json(inner)
    assert find_schema_errors("solve", data) == []
    assert data["body_jacobian"] is None and len(data["space_jacobian"]) == 6  # P is on link 2
    assert "space_jacobian" not in solve_to_json(_read(tmp_path, TWO_R))


TWO_BY_AXES = 'name = "two"\nconvention = "screws"\ntask = ["vx", "vz"]\npoint = [0.4, 0, 0.2]\n'
TWO_BY_AXES += TURN % ("[0, 1, 0]", "[0, 0, 0]") + TURN % ("[0, 1, 0]", "[0.3, 0, 0]")
ROUNDED, EXACT = "[0.3, 0.2, 0]", '["pi/3", 0, 0]'
WITH_A = TWO_R.replace('"a1"', "0.4")


@pytest.mark.parametrize(
    ("arm", "rpy"), sample_for_suite([(WITH_A, ROUNDED), (WITH_A, EXACT), (TWO_BY_AXES, ROUNDED)], 1)
)
def test_numbers_that_are_rounded_are_told_to_be(arm: str, rpy: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(arm.replace("[[joint]]", f"base = {{rpy = {rpy}}}\n[[joint]]", 1))
    robot = read_robot_file(path)
    stages = (stage for stage in generate_text_events(robot) if isinstance(stage, ReadyResult))
    texts = {stage.name: " ".join(to_text(stage.content).split()) for stage in stages}
    rounded = rpy == ROUNDED
    assert ("rounded" in texts["arm"]) == ("rounded" in texts["singular-angles"]) == rounded
    said: list[str] = []
    write_solution(robot, "json", 0.3, said.append, lambda _: nullcontext())
    content = json.loads("".join(said))
    assert find_schema_errors("solve", content) == [] and content.get("rounded", False) == rounded
