"""Arms written in every convention are the same arm, by the matrices of each convention, worked out here anew."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from jinja2.runtime import Macro

from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import CONVENTIONS, Base, Chain, Joint, Point
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.library import find_robot_path, robots
from qdot.exercises.arm.robot_file import Robot, read_robot_file
from qdot.exercises.arm.robot_text import robot_text
from qdot.exercises.arm.standard_table import home_geometry_of
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.own import read_robot_family
from qdot.exercises.generation import sample_chain
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.verify.certificate import CONVENTION_CHECKS
from qdot.exercises.writing.languages import ENGLISH
from qdot.exercises.writing.render import find_template_folder, make_environment
from tests.exercises.arm.poses import Matrix, about, exponential, placed, shift
from tests.support import ROOT
from tests.support.suites import select_for_suite

R = sp.Rational


def read(folder: Path, text: str, name: str = "robot.toml") -> Robot:
    path = folder / name
    path.write_text(text)
    return read_robot_file(path)


HEAD = 'name = "m"\n'


def row(theta: str = "theta1", d: object = 0, a: str = '"a1"', alpha: object = 0) -> str:
    return f'[[joint]]\nkind = "R"\ntheta = "{theta}"\nd = {d}\na = {a}\nalpha = {alpha}\n'


def screw(axis: str = "[0, 0, 1]", point: str = "[0, 0, 0]", kind: str = "R") -> str:
    return f'[[joint]]\nkind = "{kind}"\naxis = {axis}\npoint = {point}\n'


ROW, SCREW = row(), screw()
SCREWS = HEAD + 'convention = "screws"\n'


def place(chain: Chain, q: Sequence[float], lengths: dict[str, float]) -> Matrix:
    arm = NumericChain(chain, lengths)
    return arm.point_of(arm.frames(np.array(q)))


def jacobian(chain: Chain, q: Sequence[float], lengths: dict[str, float]) -> Matrix:
    return NumericChain(chain, lengths).jacobian(np.array(q)[None])[0]


def same_arm(one: Chain, other: Chain, seed: str) -> None:
    """Hold places and Jacobians of two arms against each other at random configurations, and their tasks."""
    assert (one.n, one.task) == (other.n, other.task)
    stream = Stream(seed)
    names = {symbol.name for chain in (one, other) for symbol in chain.parameters}
    for _ in range(3):
        q = [stream.uniform(-2, 2) for _ in one.q]
        lengths = {name: stream.uniform(0.2, 1.5) for name in sorted(names)}
        np.testing.assert_allclose(place(one, q, lengths), place(other, q, lengths), atol=1e-9)
        np.testing.assert_allclose(jacobian(one, q, lengths), jacobian(other, q, lengths), atol=1e-9)


@pytest.mark.parametrize("step", select_for_suite(["full"], ["chapter", "full"]))
def test_an_arm_is_written_in_every_convention_and_read_again(family: str, step: str, tmp_path: Path) -> None:
    chain = sample_chain(ProblemId(family, 3, variation=step))
    for convention in CONVENTIONS:
        text = robot_text(Robot(chain), convention)
        robot = read(tmp_path, text)
        assert not robot.is_table_rounded, convention  # all that families draw has short forms
        same_arm(chain, robot.chain, f"{family} {convention}")
        if convention != "screws":  # which place the frames anew
            assert robot_text(Robot(robot.chain), convention) == text, convention


@pytest.mark.parametrize("frame", [0, 1, 2, 3])
@pytest.mark.parametrize("convention", ["dh", "modified-dh"])
def test_a_table_is_multiplied_out_as_its_book_does(convention: str, frame: int, tmp_path: Path) -> None:
    """Rx(alpha) Tx(a) and Rz(theta) Tz(d), whichever is first, with joints that count the other way, and base.

    P moves with a frame, or with the tool's, which is behind the last one.
    """
    point = (
        f"point = {{frame = {frame}, offset = [0.05, 0, 0.2]}}" if frame < 3 else "tool = {position = [0.05, 0, 0.2]}"
    )
    slide = '[[joint]]\nkind = "P"\ntheta = 45\nd = "0.2 - d2"\na = "l"\nalpha = -60\n'
    text = f"""{HEAD}convention = "{convention}"
angles = "degrees"
task = ["vx"]
base = {{position = [0.1, -0.2, 0.3], rpy = [30, 45, 90]}}
{point}
{row("-q1 + 30", 0.4, "0.3", 90)}{slide}{row("theta3", 0, "0.25", 180)}"""
    chain, rad, stream = read(tmp_path, text).chain, np.deg2rad, Stream("modified")
    for _ in range(4):
        q, long = [stream.uniform(-2, 2) for _ in range(3)], stream.uniform(0.2, 1)
        rows = [(rad(90), 0.3, -q[0] + rad(30), 0.4), (rad(-60), long, rad(45), 0.2 - q[1]), (np.pi, 0.25, q[2], 0)]
        pose = placed([0.1, -0.2, 0.3], rad([30, 45, 90]))
        for alpha, a, theta, d in rows[:frame]:
            link, own = about("x", alpha) @ shift(a, 0, 0), about("z", theta) @ shift(0, 0, d)
            pose = pose @ (link @ own if convention == "modified-dh" else own @ link)
        np.testing.assert_allclose(place(chain, q, {"l": long}), (pose @ [0.05, 0, 0.2, 1])[:3], atol=1e-12)


@pytest.mark.parametrize("seed", range(select_for_suite(5, 12)))
def test_axes_in_any_place_lead_where_their_exponentials_do(seed: int, tmp_path: Path) -> None:
    """Parallel, crossing, skew and coincident axes, slides among them, on a base that is turned."""
    stream = Stream(f"axes/{seed}")
    rows, axes = "", []
    base, rpy = [0.2, -0.1, 0.5], stream.choice([[0, 0, 0], [0, 0, 90], [180, 0, 30], [90, -45, 15]])
    for _ in range(1 + int(stream.uniform(1, 4))):
        axis = stream.choice([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0], [1, 1, 0], [0, 1, 1], [1, 2, 3]])
        through = [stream.choice([0, 0, 0.3, -0.4, 0.75]) for _ in range(3)]
        kind = stream.choice(["R", "R", "R", "P"])
        axes.append((axis, through, kind == "P"))
        rows += screw(str(axis), str(through), kind)
    point = [stream.choice([0, 0.2, 0.5]) for _ in range(3)]
    link = len(axes) - int(stream.uniform(0, 1.3))
    text = f'{SCREWS}angles = "degrees"\ntask = ["vx"]\npoint = {{frame = {link}, offset = {point}}}\n'
    text += f"base = {{position = {base}, rpy = {rpy}}}\n{rows}"
    chain = read(tmp_path, text).chain
    outer = placed(base, np.deg2rad(rpy))
    for _ in range(3):
        q = [stream.uniform(-2, 2) for _ in axes]
        pose = outer
        for (axis, through, slides), value in list(zip(axes, q, strict=True))[:link]:
            pose = pose @ exponential(axis, value, slides, through)
        np.testing.assert_allclose(place(chain, q, {}), (pose @ [*point, 1])[:3], atol=1e-9)


BY_AXES = f"""{SCREWS}point = [0, "0.4 + a2", 0.1]
base = {{position = [0.3, 0, 0.2], rpy = [0, 0, "pi/2"]}}
{screw("[0, 0, 1]", "[0.1, 0.2, 0.5]")}{screw("[1, 1, 0]", '[0.1, "0.4", "0.1 + a2"]')}
{screw("[1, -1, 0]", "[1, 2, 3]", "P")}{screw("[0.3, 0.5, 1]", '["a2", 0.4, 0.7]')}"""


def test_points_on_axes_stay_those_of_the_file(tmp_path: Path) -> None:
    """Turned and moved with the base; the table has other points of the same axes for origins."""
    a2 = sp.Symbol("a2")
    plain, moved = read(tmp_path, re.sub("base = .*\n", "", BY_AXES)).chain, read(tmp_path, BY_AXES).chain
    named = [(R("0.1"), R("0.2"), R("0.5")), (R("0.1"), R("0.4"), R("0.1") + a2), None, (a2, R("0.4"), R("0.7"))]
    assert list(plain.axis_points) == named
    for chain, turn in ((plain, sp.eye(3)), (moved, sp.Matrix([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))):
        origin = sp.zeros(3, 1) if chain is plain else sp.Matrix([R("0.3"), 0, R("0.2")])
        axes, without = home_geometry_of(chain).axes, home_geometry_of(replace(chain, axis_points=())).axes
        for axis, other, point in zip(axes, without, named, strict=True):
            if point is None:
                assert axis == other
                continue
            assert axis.point == origin + turn * sp.Matrix(point)
            aside = axis.direction.cross(axis.point - other.point).xreplace({a2: R("0.7")})
            assert max(abs(float(entry)) for entry in aside) < 1e-9  # the same axis
        assert any(axis != other for axis, other in zip(axes, without, strict=True))
    again = read(tmp_path, robot_text(Robot(plain), "screws")).chain
    assert again.axis_points == plain.axis_points
    same_arm(plain, again, "points on axes")
    # Where lengths are put in, they are in the points, too; what lies on no axis any more is not told.
    path = tmp_path / "drawn.toml"
    path.write_text(BY_AXES + "[draw]\na2 = [0.3, 0.9]\n")
    drawn = read_robot_family(path).sample(Stream("drawn"), ("lengths",))
    (length,) = (home_geometry_of(drawn).axes[1].point - sp.Matrix([0, 0, R("0.3")]))[2:]
    assert R("0.3") <= length <= R("0.9") and home_geometry_of(drawn).axes[3].point[1] == length
    elsewhere = replace(plain, base=Base((R(1), R(0), R(0)), sp.S.Zero, sp.S.Zero))
    assert home_geometry_of(elsewhere).axes[0] == home_geometry_of(replace(elsewhere, axis_points=())).axes[0]


BASE = 'base = {position = [0, "a1", 0.3], rpy = %s}\n'
SCREWS_ON_A_BASE = f"{SCREWS}{BASE}point = [0.4, 0.1, 0.2]\n{SCREW}{screw('%s', '[0.2, 0, 0.2]', '%s')}"
TABLE_ON_A_BASE = (
    f'{HEAD}convention = "%s"\n{BASE}' + row("theta1 + 0.2", 0.1, "0.2", '"pi/2"') + row("-theta2", 0, "0.2")
)


@pytest.mark.parametrize(
    ("text", "rounded"),
    [
        (SCREWS_ON_A_BASE % ("[0.3, 0, 0]", "R", "[0, 1, 0]"), True),  # products with sin(0.3)
        (SCREWS_ON_A_BASE % ('["pi/3", 0, 0]', "R", "[0, 1, 0]"), False),  # roots
        (SCREWS_ON_A_BASE % ("[0, 0, 0]", "R", "[0.3, 0.5, 1]"), False),
        (SCREWS_ON_A_BASE % ('["pi/3", "pi/4", 0.1]', "P", "[0.3, 0.5, 1]"), True),
        (TABLE_ON_A_BASE % ("dh", "[0.3, 0, 0]"), False),  # that is the tilt
        (TABLE_ON_A_BASE % ("dh", "[0.3, 0.2, 0]"), True),  # whose tilt is atan2(…)
        (TABLE_ON_A_BASE % ("modified-dh", '["pi/2", 0, "pi/5"]'), True),  # no multiple of 15 degrees
        (TABLE_ON_A_BASE % ("modified-dh", '["pi/2", 0, "pi/4"]'), False),
    ],
    ids=range(8),
)
def test_an_arm_whose_table_is_rounded_is_known(text: str, rounded: bool, tmp_path: Path) -> None:
    robot = read(tmp_path, text)
    assert robot.is_table_rounded == rounded
    numbers = [number for joint in robot.chain.joints for number in (joint.theta, joint.d, joint.a, joint.alpha)]
    numbers += [*robot.chain.base.position, robot.chain.base.yaw, robot.chain.base.tilt, *robot.chain.point.offset]
    # A rounded number has ten decimals; those that are typed have few.
    assert rounded == any(atom.q > 10**6 for number in numbers for atom in sp.sympify(number).atoms(sp.Rational))


def test_no_real_robot_is_rounded() -> None:
    assert [name for name in robots() if read_robot_file(find_robot_path(name)).is_table_rounded] == []


URDF = """<?xml version="1.0"?>
<robot name="three">
  <link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="tool"/><link name="camera"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="a"/>
    <origin xyz="0 0 0.4" rpy="0 0 1.5708"/><axis xyz="0 0 1"/></joint>
  <joint name="elbow" type="revolute"><parent link="a"/><child link="b"/>
    <origin xyz="0.3 0 0" rpy="1.57079632679 0 0.2"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="2.5" effort="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>
    <origin xyz="0 0.1 0"/><axis xyz="1 0 1"/><limit lower="0" upper="0.5"/></joint>
  <joint name="mount" type="fixed"><parent link="c"/><child link="tool"/><origin xyz="0 0 0.12" rpy="0 0.3 0"/></joint>
  <joint name="look" type="fixed"><parent link="a"/><child link="camera"/></joint>
</robot>
"""


def test_a_urdf_leads_where_its_origins_and_axes_do(urdf: Callable[..., Path]) -> None:
    path = urdf()
    robot = read_robot_file(path, tip="tool")
    assert robot.chain.title == "three" and [joint.kind for joint in robot.chain.joints] == ["R", "R", "P"]
    assert robot.limits[0] is None and robot.limits[1] == (-1, sp.Rational(5, 2))
    assert robot.notes == (f"{path}: joint 'shoulder': 1.5708 rad is taken as exactly pi/2",)
    stream = Stream("urdf")
    for _ in range(4):
        q = [stream.uniform(-2, 2) for _ in range(3)]
        pose = shift(0, 0, 0.4) @ about("z", np.pi / 2) @ about("z", q[0])
        pose = pose @ placed([0.3, 0, 0], [np.pi / 2, 0, 0.2]) @ about("y", -q[1])
        pose = pose @ shift(0, 0.1, 0) @ shift(q[2] / np.sqrt(2), 0, q[2] / np.sqrt(2)) @ shift(0, 0, 0.12)
        np.testing.assert_allclose(place(robot.chain, q, {}), pose[:3, 3], atol=1e-8)


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[..., Path]:
    """Return what writes the URDF, with something else in one place."""

    def write(old: str = "", new: str = "") -> Path:
        path = tmp_path / "three.urdf"
        path.write_text(URDF.replace(old, new) if old else URDF)
        return path

    return write


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<robot name", "<robt name", "not valid XML"), ("<robot ", '<!DOCTYPE robot []><robot ', "DOCTYPE"),
        ('<robot name="three">', '<robot name="three" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:a/>', "macros"),
        ('type="revolute"', 'type="planar"', "joint 'elbow': unknown type 'planar'"),
        ('<child link="b"/>', '<child link="z"/>', "joint 'elbow': .* 'z', which does not exist"),
        ('<child link="b"/>', "", "joint 'elbow': the child is missing"),
        ('xyz="1 0 1"', 'xyz="0 0 0"', "joint 'slide': its axis is the zero vector"),
        ('xyz="1 0 1"', 'xyz="1 0 nan"', "joint 'slide': axis xyz = '1 0 nan'"),
        ('upper="0.5"/>', 'upper="0.5"/><mimic joint="elbow"/>', "joint 'slide': the joint copies"),
        ('lower="-1" upper="2.5"', 'lower="1" upper="-2.5"', r"joint 'elbow': its lower limit 1 .* -2\.5"),
        ('<child link="camera"/>', '<child link="tool"/>', "link 'tool' is also the child of joint 'mount'"),
    ],
)  # fmt: skip
def test_a_urdf_that_can_not_be_read_is_told_by_its_joint(
    old: str, new: str, said: str, urdf: Callable[..., Path]
) -> None:
    with pytest.raises(QdotError, match=rf"three\.urdf: .*{said}"):
        read_robot_file(urdf(old, new), tip="tool")


def test_limits_of_a_urdf_are_rounded_as_its_angles_are(urdf: Callable[..., Path]) -> None:
    robot = read_robot_file(urdf('lower="-1" upper="2.5"', 'lower="-1.57" upper="3.1416"'), tip="tool")
    assert robot.limits[1] == (-sp.pi / 2, sp.pi)
    assert any("3.1416 rad is taken as exactly pi" in note for note in robot.notes)


@pytest.mark.parametrize(
    ("tip", "said"),
    [("", r"several last links: tool, camera; .*--tip LINK"), ("tol", "unknown link 'tol'"), ("base", "is the root")],
)
def test_the_end_of_a_urdf_is_its_only_one_or_named(tip: str, said: str, urdf: Callable[..., Path]) -> None:
    with pytest.raises(QdotError, match=said):
        read_robot_file(urdf(), tip=tip)
    assert read_robot_file(urdf(), tip="camera").chain.n == 1


def test_a_urdf_has_no_more_joints_than_can_be_worked_out(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{k}"/>' for k in range(13))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/></joint>' for k in range(12)
    )
    with pytest.raises(QdotError, match=r"snake\.urdf: 12 joints are too many"):
        read(tmp_path, f'<robot name="snake">{links}{joints}</robot>', "snake.urdf")


# --- what is wrong in a file ---

OTHER_NAMES = {"mdh": "modified-dh", "Craig": "modified-dh", "PoE": "screws"}
DECIMALS = {"-0,4": "write -0.4", "0,4*a1": "a ="}
MODIFIED, AT = HEAD + 'convention = "modified-dh"\n', "point = [1, 0, 0]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + 'convention = "crag"\n' + ROW, 'line 2: convention = "crag": expected "dh" or "modified-dh"'),
        *((f'{HEAD}convention = "{other}"\n{ROW}', f'did you mean "{ours}"?') for other, ours in OTHER_NAMES.items()),
        (HEAD + 'angles = "deg"\n' + ROW, 'line 2: angles = "deg": expected "radians" or "degrees"'),
        (HEAD + 'angles = "degrees"\n' + row(alpha='"pi/2"'), "pi is not allowed"),
        (HEAD + 'base = {rpy = [0, 0, "beta1"]}\n' + ROW, "the angles must be numbers"),
        (MODIFIED + row(alpha='"alpha1"'), "the first alpha rotates the base"),
        (HEAD + "base = {at = [0, 0, 0]}\n" + ROW, "{position = [x, y, z]}"),
        (HEAD + 'point = "O1"\ntool = {position = [0, 0, 1]}\n' + ROW, "the point of interest is the tool's origin"),
        (HEAD + "point = {frame = 2, offset = [0, 0, 0]}\n" + ROW, 'a frame, "O0"'),
        (HEAD + row("2 - 2*theta1"), '"-theta1"'), (HEAD + row("q2"), "q2"),
        (HEAD + ROW + "limits = [1]\n", "expected two numbers, the lower one first"),
        (HEAD + ROW + 'limits = ["pi", 0]\n', "expected two numbers, the lower one first"),
        (HEAD + ROW + "limits = [true, 1]\n", "limits = [true, 1]: expected a number"),
        (HEAD + ROW + "limits = [-inf, 2]\n", "limits = [-inf, 2]: expected a finite number"),
        (HEAD + ROW + "limits = [-170, 170]\n", "-170 degrees would be"),
        (HEAD + 'angles = "degrees"\n' + row(a='"cos(60)"'), "sqrt(3)/2"),
        (SCREWS + SCREW, "the key 'point' is missing"), (SCREWS + "tool = {}\n" + SCREW, "with screws, use `point`"),
        (SCREWS + AT + ROW, 'belongs to a DH table, but the file has convention = "screws"'),
        (HEAD + AT + SCREW, "line 5: joint 1: the key 'axis' belongs to an arm described by screw axes"),
        (MODIFIED + SCREW, 'the file has convention = "modified-dh"'),
        (SCREWS + AT + screw(kind="p"), 'line 5: joint 1: kind = "p": expected "R" (revolute) or "P" (prismatic)'),
        (SCREWS + AT + SCREW.replace("kind", "knd"), "unknown key 'knd'"),
        (SCREWS + AT + screw("[0, 0, 0]"), "the direction of the axis"),
        *((HEAD + row(a=f'"{typed}"'), meant) for typed, meant in DECIMALS.items()),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_file_is_told_by_its_place(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(QdotError, match=rf"robot\.toml: .*{re.escape(said)}"):
        read(tmp_path, text)


def test_a_point_on_an_inner_link_is_told_by_its_frame() -> None:
    chain = Chain(
        "m", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2, 3)), ("vx", "vy"), Base(), Point(2, (0, 0, 0))
    )
    assert 'point = "O2"\n' in robot_text(Robot(chain), "dh")
    assert 'point = {frame = 2, offset = ["a2", 0, 0]}\n' in robot_text(Robot(chain), "modified-dh")
    assert 'point = {frame = 2, offset = ["a1 + a2", 0, 0]}\n' in robot_text(Robot(chain), "screws")


def test_the_arms_of_the_docs_are_read_and_the_same_in_every_convention(tmp_path: Path) -> None:
    blocks = re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / "robots.md").read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        chain = read(tmp_path, block).chain
        for convention in CONVENTIONS:
            same_arm(chain, read(tmp_path, robot_text(Robot(chain), convention)).chain, block[:20])


def test_a_letter_that_comes_out_of_the_table_is_no_failure(tmp_path: Path) -> None:
    """A SCARA by its axes: the height of its joints is nowhere in the table of an arm that is told at that height."""
    text = f'{SCREWS}point = ["a1", 0, "h"]\n{SCREW}[[joint]]\nkind = "P"\naxis = [0, 0, -1]\n'
    assert read(tmp_path, text).chain.n == 2


def test_what_is_told_beside_the_table_is_converted_too(tmp_path: Path) -> None:
    text = f'{HEAD}task = ["vx"]\n{row("-theta1 + pi/2")}limits = ["-pi/2", 2.8973]\n[draw]\na1 = [0.3, 0.85]\n'
    robot = read(tmp_path, text)
    for convention in CONVENTIONS:
        again = read(tmp_path, robot_text(robot, convention))
        assert (again.limits, again.length_ranges) == (robot.limits, robot.length_ranges)


def test_skew_axes_stay_exact(tmp_path: Path) -> None:
    text = f'{SCREWS}task = ["vx"]\n{AT}{SCREW}' + screw('["1/3", "2/3", "2/3"]', "[1, 0, 0]")
    robot = read(tmp_path, text)
    assert abs(robot.chain.joints[0].alpha) == sp.atan(sp.sqrt(5) / 2)
    assert 'axis = ["1/3", "2/3", "2/3"]' in robot_text(robot, "screws")
    axis = robot.written_arm and robot.written_arm.rows[1]
    assert isinstance(axis, Axis) and tuple(axis.direction) == (R(1, 3), R(2, 3), R(2, 3))


def test_an_axis_that_is_turned_by_an_open_angle_can_not_be_written() -> None:
    chain = Chain("m", (Joint("R", "theta1", 0, "a1", "alpha1"), Joint("R", "theta2", 0, "a2", 0)), ("vx",))
    assert "alpha1" in robot_text(Robot(chain), "modified-dh")
    with pytest.raises(QdotError, match="axis 2 of m is rotated by a symbolic angle"):
        robot_text(Robot(chain), "screws")


def macros(name: str) -> dict[str, list[str]]:
    """Return the macros of a template with the names of their arguments."""
    module = vars(make_environment(ENGLISH).get_template(f"conventions/{name}.md.j2").module)
    return {key: value.arguments for key, value in module.items() if isinstance(value, Macro)}


def called_macros(convention: str) -> Iterator[str]:
    """Yield the macros of a convention that templates call, but for questions that don't apply to it."""
    for path in find_template_folder().rglob("*.md.j2"):
        question = QUESTIONS.get(path.name.removesuffix(".md.j2"))
        if question is None or question.required_feature in {"", *REGISTRY[convention].features}:
            yield from re.findall(r"(?<![\w.])convention\.(\w+)\(", path.read_text())


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_convention_has_all_that_others_ask_of_it(convention: str) -> None:
    own, usual = macros(convention), macros(CONVENTIONS[0])
    assert set(called_macros(convention)) <= set(own)
    assert all(own[name] == usual[name] for name in own.keys() & usual.keys())
    assert convention in CONVENTION_CHECKS
    assert REGISTRY[convention].specific_mistakes <= set(CATALOGUE)
    assert not {convention, *REGISTRY[convention].aliases} & {
        name for other in REGISTRY.values() if other.name != convention for name in (other.name, *other.aliases)
    }


def test_nobody_else_tests_which_convention_an_arm_has() -> None:
    quoted = "|".join(CONVENTIONS)
    tested = re.compile(rf"""(?:[=!]=|\bin) *\(?["'](?:{quoted})["']|["'](?:{quoted})["'] *[=!]=""")
    files = [path for folder, end in (("exercises", "py"), ("grader", "py"), ("templates", "j2"))
             for path in (ROOT / folder).rglob(f"*.{end}")]  # fmt: skip
    assert [str(path) for path in files if tested.search(path.read_text(encoding="utf-8"))] == []
