"""Arms written in every convention are the same arm, by independent matrices, and every text names its frames."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from jinja2.runtime import Macro

from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import CONVENTIONS, DEFAULT_CONVENTION, Base, Chain, Joint, Point
from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.arm.conventions.modified_dh import ModifiedDh
from qdot.exercises.arm.kinematics import NumericChain, compute_link_frames
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.figure.arm_parts import compute_convention_frames
from qdot.exercises.figure.pose import compute_skeleton, make_drawable_chain
from qdot.exercises.generation import generate, list_questions_of_family, sample_chain
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.library import find_robot_path, list_robots
from qdot.exercises.robots.robot_file import Robot, read_robot_file
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.verify.certificate import CONVENTION_CHECKS, certify
from qdot.exercises.verify.numeric_model import compute_modified_frames
from qdot.exercises.writing.languages import ENGLISH
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solutions, write_statement
from qdot.exercises.writing.render import find_template_folder, make_environment
from tests.exercises.arm.poses import Matrix, compute_exponential, compute_origin_pose, rotate_about, translate
from tests.support import ROOT, read_cases, read_data
from tests.support.suites import few_families, on_families, select_for_suite

R = sp.Rational


def read_robot(folder: Path, text: str, name: str = "robot.toml") -> Robot:
    path = folder / name
    path.write_text(text)
    return read_robot_file(path)


HEAD = 'name = "m"\n'


def make_row(theta: str = "theta1", d: object = 0, a: str = '"a1"', alpha: object = 0) -> str:
    return f'[[joint]]\nkind = "R"\ntheta = "{theta}"\nd = {d}\na = {a}\nalpha = {alpha}\n'


def make_screw(axis: str = "[0, 0, 1]", point: str = "[0, 0, 0]", kind: str = "R") -> str:
    return f'[[joint]]\nkind = "{kind}"\naxis = {axis}\npoint = {point}\n'


ROW, SCREW = make_row(), make_screw()
SCREWS = HEAD + 'convention = "screws"\n'


def compute_point(chain: Chain, q: Sequence[float], lengths: dict[str, float]) -> Matrix:
    arm = NumericChain(chain, lengths)
    return arm.compute_point_of(arm.compute_frames(np.array(q)))


def compute_jacobian(chain: Chain, q: Sequence[float], lengths: dict[str, float]) -> Matrix:
    return NumericChain(chain, lengths).compute_jacobian(np.array(q)[None])[0]


def assert_same_arm(first: Chain, second: Chain, seed: str) -> None:
    """Compare the tasks of two arms, and their points and Jacobians at random configurations."""
    assert (first.n, first.task) == (second.n, second.task)
    stream = Stream(seed)
    names = {symbol.name for chain in (first, second) for symbol in chain.parameters}
    for _ in range(3):
        q = [stream.uniform(-2, 2) for _ in first.q]
        lengths = {name: stream.uniform(0.2, 1.5) for name in sorted(names)}
        np.testing.assert_allclose(compute_point(first, q, lengths), compute_point(second, q, lengths), atol=1e-9)
        np.testing.assert_allclose(compute_jacobian(first, q, lengths), compute_jacobian(second, q, lengths), atol=1e-9)


@pytest.mark.parametrize("step", select_for_suite(["full"], ["chapter", "full"]))
def test_arm_survives_writing_in_every_convention(family: str, step: str, tmp_path: Path) -> None:
    chain = sample_chain(ProblemId(family, 3, variation=step))
    for convention in CONVENTIONS:
        text = write_robot_text(Robot(chain), convention)
        robot = read_robot(tmp_path, text)
        assert not robot.is_table_rounded, convention  # all numbers of the families have short forms
        assert_same_arm(chain, robot.chain, f"{family} {convention}")
        if convention != "screws":  # screws choose new frames
            assert write_robot_text(Robot(robot.chain), convention) == text, convention


@pytest.mark.parametrize("frame", [0, 1, 2, 3])
@pytest.mark.parametrize("convention", ["dh", "modified-dh"])
def test_table_gives_the_frames_of_its_book(convention: str, frame: int, tmp_path: Path) -> None:
    """Multiply Rx(alpha) Tx(a) and Rz(theta) Tz(d) in the book's order, with a base and negative joint directions.

    P is fixed to a frame, or to the tool after the last frame.
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
{make_row("-q1 + 30", 0.4, "0.3", 90)}{slide}{make_row("theta3", 0, "0.25", 180)}"""
    chain, rad, stream = read_robot(tmp_path, text).chain, np.deg2rad, Stream("modified")
    for _ in range(4):
        q, long = [stream.uniform(-2, 2) for _ in range(3)], stream.uniform(0.2, 1)
        rows = [(rad(90), 0.3, -q[0] + rad(30), 0.4), (rad(-60), long, rad(45), 0.2 - q[1]), (np.pi, 0.25, q[2], 0)]
        pose = compute_origin_pose([0.1, -0.2, 0.3], rad([30, 45, 90]))
        for alpha, a, theta, d in rows[:frame]:
            about_x = rotate_about("x", alpha) @ translate(a, 0, 0)
            about_z = rotate_about("z", theta) @ translate(0, 0, d)
            pose = pose @ (about_x @ about_z if convention == "modified-dh" else about_z @ about_x)
        np.testing.assert_allclose(compute_point(chain, q, {"l": long}), (pose @ [0.05, 0, 0.2, 1])[:3], atol=1e-12)


@pytest.mark.parametrize("seed", range(select_for_suite(5, 12)))
def test_axes_give_the_product_of_their_exponentials(seed: int, tmp_path: Path) -> None:
    """Parallel, intersecting, skew and coincident axes, some prismatic, on a rotated base."""
    stream = Stream(f"axes/{seed}")
    rows, axes = "", []
    base, rpy = [0.2, -0.1, 0.5], stream.choice([[0, 0, 0], [0, 0, 90], [180, 0, 30], [90, -45, 15]])
    for _ in range(1 + int(stream.uniform(1, 4))):
        axis = stream.choice([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0], [1, 1, 0], [0, 1, 1], [1, 2, 3]])
        through = [stream.choice([0, 0, 0.3, -0.4, 0.75]) for _ in range(3)]
        kind = stream.choice(["R", "R", "R", "P"])
        axes.append((axis, through, kind == "P"))
        rows += make_screw(str(axis), str(through), kind)
    point = [stream.choice([0, 0.2, 0.5]) for _ in range(3)]
    link = len(axes) - int(stream.uniform(0, 1.3))
    text = f'{SCREWS}angles = "degrees"\ntask = ["vx"]\npoint = {{frame = {link}, offset = {point}}}\n'
    text += f"base = {{position = {base}, rpy = {rpy}}}\n{rows}"
    chain = read_robot(tmp_path, text).chain
    outer = compute_origin_pose(base, np.deg2rad(rpy))
    for _ in range(3):
        q = [stream.uniform(-2, 2) for _ in axes]
        pose = outer
        for (axis, through, is_prismatic), value in list(zip(axes, q, strict=True))[:link]:
            pose = pose @ compute_exponential(axis, value, is_prismatic, through)
        np.testing.assert_allclose(compute_point(chain, q, {}), (pose @ [*point, 1])[:3], atol=1e-9)


BY_AXES = f"""{SCREWS}point = [0, "0.4 + a2", 0.1]
base = {{position = [0.3, 0, 0.2], rpy = [0, 0, "pi/2"]}}
{make_screw("[0, 0, 1]", "[0.1, 0.2, 0.5]")}{make_screw("[1, 1, 0]", '[0.1, "0.4", "0.1 + a2"]')}
{make_screw("[1, -1, 0]", "[1, 2, 3]", "P")}{make_screw("[0.3, 0.5, 1]", '["a2", 0.4, 0.7]')}"""


def test_points_on_axes_are_those_of_the_file(tmp_path: Path) -> None:
    """They are rotated and moved with the base; the origins in the table are other points of the same axes."""
    a2 = sp.Symbol("a2")
    plain, moved = read_robot(tmp_path, re.sub("base = .*\n", "", BY_AXES)).chain, read_robot(tmp_path, BY_AXES).chain
    named = [(R("0.1"), R("0.2"), R("0.5")), (R("0.1"), R("0.4"), R("0.1") + a2), None, (a2, R("0.4"), R("0.7"))]
    assert list(plain.axis_points) == named
    for chain, turn in ((plain, sp.eye(3)), (moved, sp.Matrix([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))):
        origin = sp.zeros(3, 1) if chain is plain else sp.Matrix([R("0.3"), 0, R("0.2")])
        axes, without = compute_home_geometry(chain).axes, compute_home_geometry(replace(chain, axis_points=())).axes
        for axis, plain_axis, point in zip(axes, without, named, strict=True):
            if point is None:
                assert axis == plain_axis
                continue
            assert axis.point == origin + turn * sp.Matrix(point)
            aside = axis.direction.cross(axis.point - plain_axis.point).xreplace({a2: R("0.7")})
            assert max(abs(float(entry)) for entry in aside) < 1e-9  # the same axis
        assert any(axis != plain_axis for axis, plain_axis in zip(axes, without, strict=True))
    reread = read_robot(tmp_path, write_robot_text(Robot(plain), "screws")).chain
    assert reread.axis_points == plain.axis_points
    assert_same_arm(plain, reread, "points on axes")
    # Sampled lengths replace symbols in the points, too; a point that is no longer on its axis is dropped.
    path = tmp_path / "drawn.toml"
    path.write_text(BY_AXES + "[draw]\na2 = [0.3, 0.9]\n")
    sampled = read_robot_family(path).sample(Stream("drawn"), ("lengths",))
    (length,) = (compute_home_geometry(sampled).axes[1].point - sp.Matrix([0, 0, R("0.3")]))[2:]
    assert R("0.3") <= length <= R("0.9") and compute_home_geometry(sampled).axes[3].point[1] == length
    elsewhere = replace(plain, base=Base((R(1), R(0), R(0)), sp.S.Zero, sp.S.Zero))
    assert compute_home_geometry(elsewhere).axes[0] == compute_home_geometry(replace(elsewhere, axis_points=())).axes[0]


BASE = 'base = {position = [0, "a1", 0.3], rpy = %s}\n'
SCREWS_ON_A_BASE = f"{SCREWS}{BASE}point = [0.4, 0.1, 0.2]\n{SCREW}{make_screw('%s', '[0.2, 0, 0.2]', '%s')}"
TABLE_ON_A_BASE = (
    f'{HEAD}convention = "%s"\n{BASE}' + make_row("theta1 + 0.2", 0.1, "0.2", '"pi/2"') + make_row("-theta2", 0, "0.2")
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
def test_rounded_table_is_detected(text: str, rounded: bool, tmp_path: Path) -> None:
    robot = read_robot(tmp_path, text)
    assert robot.is_table_rounded == rounded
    numbers = [number for joint in robot.chain.joints for number in (joint.theta, joint.d, joint.a, joint.alpha)]
    numbers += [*robot.chain.base.position, robot.chain.base.yaw, robot.chain.base.tilt, *robot.chain.point.offset]
    # A rounded number has ten decimals; those that are typed have few.
    assert rounded == any(atom.q > 10**6 for number in numbers for atom in sp.sympify(number).atoms(sp.Rational))


def test_no_library_robot_has_a_rounded_table() -> None:
    assert [name for name in list_robots() if read_robot_file(find_robot_path(name)).is_table_rounded] == []


URDF = read_data("three.urdf")


def test_urdf_gives_the_poses_of_its_origins_and_axes(write_urdf: Callable[..., Path]) -> None:
    path = write_urdf()
    robot = read_robot_file(path, tip="tool")
    assert robot.chain.title == "three" and [joint.kind for joint in robot.chain.joints] == ["R", "R", "P"]
    assert robot.limits[0] is None and robot.limits[1] == (-1, sp.Rational(5, 2))
    subject = "taken as multiples of 15°, from which they differ by at most 0.001 rad"
    assert robot.notes == (f"{path}: {subject}: yaw of 'shoulder' (1.5708 rad as 90°)",)
    stream = Stream("urdf")
    for _ in range(4):
        q = [stream.uniform(-2, 2) for _ in range(3)]
        pose = translate(0, 0, 0.4) @ rotate_about("z", np.pi / 2) @ rotate_about("z", q[0])
        pose = pose @ compute_origin_pose([0.3, 0, 0], [np.pi / 2, 0, 0.2]) @ rotate_about("y", -q[1])
        pose = pose @ translate(0, 0.1, 0) @ translate(q[2] / np.sqrt(2), 0, q[2] / np.sqrt(2)) @ translate(0, 0, 0.12)
        np.testing.assert_allclose(compute_point(robot.chain, q, {}), pose[:3, 3], atol=1e-8)


@pytest.fixture
def write_urdf(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the URDF, with one text replaced."""

    def write(old: str = "", new: str = "") -> Path:
        path = tmp_path / "three.urdf"
        path.write_text(URDF.replace(old, new) if old else URDF)
        return path

    return write


@pytest.mark.parametrize(("old", "new", "message"), read_cases("refused")["urdf"])
def test_urdf_error_names_the_joint(old: str, new: str, message: str, write_urdf: Callable[..., Path]) -> None:
    with pytest.raises(QdotError, match=rf"three\.urdf: .*{message}"):
        read_robot_file(write_urdf(old, new), tip="tool")


def test_urdf_limits_are_rounded_like_its_angles(write_urdf: Callable[..., Path]) -> None:
    robot = read_robot_file(write_urdf('lower="-1" upper="2.5"', 'lower="-1.57" upper="3.1416"'), tip="tool")
    assert robot.limits[1] == (-sp.pi / 2, sp.pi)
    assert any("upper limit of 'elbow' (3.1416 rad as 180°)" in note for note in robot.notes)


@pytest.mark.parametrize(("tip", "base", "message"), read_cases("refused")["links"])
def test_urdf_links_that_begin_and_end_no_chain_are_refused(
    tip: str, base: str, message: str, write_urdf: Callable[..., Path]
) -> None:
    with pytest.raises(QdotError, match=message):
        read_robot_file(write_urdf(), tip, base)


def test_urdf_chain_is_in_the_frame_of_its_base_link(write_urdf: Callable[..., Path]) -> None:
    robot = read_robot_file(write_urdf(), base="a", tip="tool")  # the link a has another end, the camera
    pose = compute_origin_pose([0.3, 0, 0], [np.pi / 2, 0, 0.2]) @ rotate_about("y", -0.5) @ translate(0, 0.1, 0.12)
    np.testing.assert_allclose(compute_point(robot.chain, [0.5, 0], {}), pose[:3, 3], atol=1e-8)
    assert robot.notes == (f"{write_urdf()}: the world frame is the frame of link 'a'",)
    assert read_robot_file(write_urdf(), base="b").chain.n == 1  # only one end comes after the link b
    assert read_robot_file(write_urdf(), tip="camera").chain.n == 1


def test_urdf_proposes_the_tool_frame_or_the_link_that_carries_the_fingers(write_urdf: Callable[..., Path]) -> None:
    finger = '<link name="{0}"/><joint name="{0}" type="prismatic"><parent link="c"/><child link="{0}"/>{1}</joint>'
    fingers = finger.format("left", "") + finger.format("right", '<mimic joint="left" multiplier="-1"/>')
    with pytest.raises(QdotError, match="--tip tool "):
        read_robot_file(write_urdf("</robot>", f"{fingers}</robot>"))
    fingers += finger.format("thumb", "")
    with pytest.raises(QdotError, match="--tip c "):
        path = write_urdf("</robot>", f"{fingers}</robot>")
        path.write_text(path.read_text().replace('"tool"', '"hand"'))
        read_robot_file(path, base="a")
    robot = read_robot_file(write_urdf("</robot>", f"{fingers}</robot>"), tip="right")
    assert [joint.kind for joint in robot.chain.joints] == ["R", "R", "P", "P"]
    assert any("joint 'right': it copies joint 'left' (mimic), which is not in the chain" in n for n in robot.notes)


def test_urdf_joints_that_copy_the_same_joint_are_refused(write_urdf: Callable[..., Path]) -> None:
    """Neither the elbow nor the slide copies the other, but both copy the camera's joint."""
    mimic = '<mimic joint="look" multiplier="2"/>'
    path = write_urdf('effort="1"/>', f'effort="1"/>{mimic}')
    path.write_text(path.read_text().replace('upper="0.5"/>', f'upper="0.5"/>{mimic}'))
    rule = "delete this joint's <mimic> and, .* add the column of 'slide', times .* to that of 'elbow' .*; or end"
    caution = "the singular configurations, which are those of independent joints"
    with pytest.raises(QdotError, match=f"joint 'slide': it moves together with joint 'elbow' .*{rule}") as error:
        read_robot_file(path, tip="tool")
    assert caution in str(error.value)
    assert len(read_robot_file(path, tip="tool", base="b").notes) == 2


def test_urdf_offsets_and_angles_near_zero_are_snapped(write_urdf: Callable[..., Path]) -> None:
    path = write_urdf('xyz="0.3 0 0" rpy="1.57079632679 0 0.2"', 'xyz="0.3 0.0006 2e-7" rpy="1.57 3e-7 0.0004"')
    robot = read_robot_file(path, tip="tool")
    angles, offsets = robot.notes
    assert angles.endswith("roll of 'elbow' (1.57 rad as 90°), yaw of 'elbow' (0.0004 rad as 0°)")
    assert offsets == f"{path}: taken as 0, because at most 0.92 mm: y of 'elbow' (0.6 mm)"
    t1, t2 = sp.symbols("theta1 theta2")
    assert [joint.theta for joint in robot.chain.joints[:2]] == [t1 + sp.pi / 2, t2 - sp.pi / 4]


def test_urdf_offset_that_remains_in_the_table_is_snapped(write_urdf: Callable[..., Path]) -> None:
    """The axes of the shoulder and of the wrist miss each other by 0.5 mm, the difference of two large offsets."""
    path = write_urdf("0 0.1 0", "0.1 0 0.2505")
    path.write_text(
        path.read_text().replace('xyz="0.3 0 0" rpy="1.57079632679 0 0.2"', 'xyz="0.3 0.25 0"')
        .replace('type="prismatic"', 'type="revolute"').replace("1 0 1", "0 0 1").replace("0 0.3 0", "0 0 0")
        .replace("0.1 0 0.2505", "0.1 -0.2505 0")
    )  # fmt: skip
    robot = read_robot_file(path, tip="tool")
    (note,) = [note for note in robot.notes if "of the table" in note]
    assert note == f"{path}: taken as 0, because at most 1 mm: d2 (0.5 mm) of the table"
    assert robot.chain.joints[1].d == 0 and robot.written_arm is not None
    for axis, written_axis in zip(compute_home_geometry(robot.chain).axes, robot.written_arm.rows, strict=True):
        assert isinstance(written_axis, Axis) and axis.direction == written_axis.direction
        assert axis.direction.cross(axis.point - written_axis.point).n().norm() < 1e-12


def test_urdf_with_too_many_joints_is_refused(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{k}"/>' for k in range(13))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/></joint>' for k in range(12)
    )
    with pytest.raises(QdotError, match=r"snake\.urdf: 12 joints are too many"):
        read_robot(tmp_path, f'<robot name="snake">{links}{joints}</robot>', "snake.urdf")


@pytest.mark.parametrize(("lines", "change", "message"), read_cases("refused_robots")["files"])
def test_robot_file_error_names_its_place(lines: str, change: str, message: str, tmp_path: Path) -> None:
    text = HEAD + lines.replace("ROW\n", ROW).replace("SCREW\n", SCREW)
    if change:
        text = re.sub(rf"(?m)^{change.partition(' = ')[0]} = .*$", lambda _: change, text)
    with pytest.raises(QdotError, match=rf"robot\.toml: .*{re.escape(message)}"):
        read_robot(tmp_path, text)


def test_point_on_inner_link_is_written_with_its_frame() -> None:
    joints = tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2, 3))
    chain = Chain("m", joints, ("vx", "vy"), tool=Point(2, (0, 0, 0)))
    assert 'point = "O2"\n' in write_robot_text(Robot(chain), "dh")
    assert 'point = {frame = 2, offset = ["a2", 0, 0]}\n' in write_robot_text(Robot(chain), "modified-dh")
    assert 'point = {frame = 2, offset = ["a1 + a2", 0, 0]}\n' in write_robot_text(Robot(chain), "screws")


def test_arms_in_the_docs_are_the_same_in_every_convention(tmp_path: Path) -> None:
    blocks = re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / "robots.md").read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        chain = read_robot(tmp_path, block).chain
        for convention in CONVENTIONS:
            assert_same_arm(chain, read_robot(tmp_path, write_robot_text(Robot(chain), convention)).chain, block[:20])


def test_length_that_cancels_out_of_the_table_is_accepted(tmp_path: Path) -> None:
    """A SCARA described by axes at height h: the table doesn't contain h."""
    text = f'{SCREWS}point = ["a1", 0, "h"]\n{SCREW}[[joint]]\nkind = "P"\naxis = [0, 0, -1]\n'
    assert read_robot(tmp_path, text).chain.n == 2


def test_limits_and_length_ranges_survive_conversion(tmp_path: Path) -> None:
    text = f'{HEAD}task = ["vx"]\n{make_row("-theta1 + pi/2")}limits = ["-pi/2", 2.8973]\n[draw]\na1 = [0.3, 0.85]\n'
    robot = read_robot(tmp_path, text)
    for convention in CONVENTIONS:
        reread = read_robot(tmp_path, write_robot_text(robot, convention))
        assert (reread.limits, reread.length_ranges) == (robot.limits, robot.length_ranges)


def test_skew_axes_stay_exact(tmp_path: Path) -> None:
    text = f'{SCREWS}task = ["vx"]\npoint = [1, 0, 0]\n{SCREW}' + make_screw('["1/3", "2/3", "2/3"]', "[1, 0, 0]")
    robot = read_robot(tmp_path, text)
    assert abs(robot.chain.joints[0].alpha) == sp.atan(sp.sqrt(5) / 2)
    assert 'axis = ["1/3", "2/3", "2/3"]' in write_robot_text(robot, "screws")
    axis = robot.written_arm and robot.written_arm.rows[1]
    assert isinstance(axis, Axis) and tuple(axis.direction) == (R(1, 3), R(2, 3), R(2, 3))


def test_axis_with_symbolic_twist_is_not_written_as_screw() -> None:
    chain = Chain("m", (Joint("R", "theta1", 0, "a1", "alpha1"), Joint("R", "theta2", 0, "a2", 0)), ("vx",))
    assert "alpha1" in write_robot_text(Robot(chain), "modified-dh")
    with pytest.raises(QdotError, match="axis 2 of m is rotated by a symbolic angle"):
        write_robot_text(Robot(chain), "screws")


def list_macros(name: str) -> dict[str, list[str]]:
    module = vars(make_environment(ENGLISH).get_template(f"conventions/{name}.md.j2").module)
    return {key: value.arguments for key, value in module.items() if isinstance(value, Macro)}


def list_called_macros(convention: str) -> Iterator[str]:
    """Yield the macros of a convention that templates call, except in questions that don't apply to it."""
    for path in find_template_folder().rglob("*.md.j2"):
        question = QUESTIONS.get(path.name.removesuffix(".md.j2"))
        if question is None or question.required_feature in {"", *REGISTRY[convention].features}:
            yield from re.findall(r"(?<![\w.])convention\.(\w+)\(", path.read_text())


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_convention_defines_everything_that_callers_use(convention: str) -> None:
    macros, standard_macros = list_macros(convention), list_macros(DEFAULT_CONVENTION)
    assert set(list_called_macros(convention)) <= set(macros)
    assert all(macros[name] == standard_macros[name] for name in macros.keys() & standard_macros.keys())
    assert convention in CONVENTION_CHECKS
    assert REGISTRY[convention].specific_mistakes <= set(CATALOGUE)
    others = [registered for registered in REGISTRY.values() if registered.name != convention]
    names = {name for registered in others for name in (registered.name, *registered.aliases)}
    assert not {convention, *REGISTRY[convention].aliases} & names


def test_only_conventions_compare_convention_names() -> None:
    quoted = "|".join(CONVENTIONS)
    tested = re.compile(rf"""(?:[=!]=|\bin) *\(?["'](?:{quoted})["']|["'](?:{quoted})["'] *[=!]=""")
    files = [path for folder, end in (("exercises", "py"), ("grader", "py"), ("templates", "j2"))
             for path in (ROOT / folder).rglob(f"*.{end}")]  # fmt: skip
    assert [str(path) for path in files if tested.search(path.read_text(encoding="utf-8"))] == []


MODIFIED = "modified-dh"
FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
SOME = select_for_suite(("polar-rp", "wrist-zyz"), FIXED)
FRAME_QUESTIONS = ("transform", "position-vectors", "joint-axes", "link-velocity", "tool-jacobian", "wrist-block",
             "own-frame-velocity")  # fmt: skip
"""Questions whose answers depend on the frames."""


def sample_modified_arm(family: str, seed: int = 1, variation: str = "full") -> Chain:
    return sample_chain(ProblemId(family, seed, variation=variation, convention=MODIFIED))


def sample_values(chain: Chain, poses: int = 3) -> tuple[dict[str, float], np.ndarray]:
    """Return lengths and joint values (poses x n)."""
    stream = Stream(f"told/{chain.name}")
    lengths = {symbol.name: stream.uniform(0.2, 1.2) for symbol in chain.parameters}
    return lengths, np.array([[stream.uniform(-2, 2) for _ in chain.q] for _ in range(poses)])


def evaluate_matrix(chain: Chain, matrix: sp.Matrix, lengths: dict[str, float], q: np.ndarray) -> np.ndarray:
    known = {sp.Symbol(name): value for name, value in lengths.items()} | dict(zip(chain.q, q.tolist(), strict=True))
    return np.array(matrix.subs(known).evalf().tolist(), dtype=float)


@few_families
def test_frames_are_those_of_the_modified_table(family: str) -> None:
    arm = sample_modified_arm(family)
    lengths, poses = sample_values(arm)
    expected, frames = compute_modified_frames(arm, lengths, poses), compute_link_frames(arm)
    standard = NumericChain(arm, lengths)
    for k, q in enumerate(poses):
        for i, frame in enumerate(frames):
            assert np.allclose(evaluate_matrix(arm, frame.rotation, lengths, q), expected[k, i, :3, :3], atol=1e-9)
            assert np.allclose(evaluate_matrix(arm, frame.origin, lengths, q)[:, 0], expected[k, i, :3, 3], atol=1e-9)
        point = convention_of(arm).point
        offset = [float(entry.subs(lengths)) for entry in point.offset]
        point_world = expected[k, point.frame, :3, :3] @ offset + expected[k, point.frame, :3, 3]
        assert np.allclose(point_world, standard.compute_point(q), atol=1e-9)
        p_star = standard.compute_point(q)[:, None] - expected[k, 1:, :3, 3].T
        assert np.allclose(evaluate_matrix(arm, derive(arm).p_star, lengths, q), p_star, atol=1e-9)


@on_families(SOME)
def test_questions_about_frames_are_certified(family: str) -> None:
    questions = [name for name in list_questions_of_family(family, MODIFIED) if name in FRAME_QUESTIONS]
    certificate = certify(generate(ProblemId(family, 2, tuple(questions), variation="full", convention=MODIFIED)))
    assert certificate.passed, certificate.failures
    assert {check.name for check in certificate.checks} >= {"modified table: axes", "modified table: point"}


def test_certificate_detects_wrong_table(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = generate("elbow-3r/1@modified-dh", ["transform"])

    table = ModifiedDh._make_base_and_rows

    def wrong(convention: ModifiedDh) -> tuple[Base, list[Joint]]:
        base, (first, second, third) = table(convention)
        return base, [first, replace(second, alpha=-second.alpha), third]

    monkeypatch.setattr(ModifiedDh, "_make_base_and_rows", wrong)
    failed = {check.name for check in certify(problem).failures}
    assert {"modified table: axes", "modified table: point"} <= failed


@on_families(SOME)
def test_no_text_names_frames_of_the_standard_table(family: str) -> None:
    """There is no z_0 and no p*_0: the frame on the axis of joint 1 is frame 1."""
    problem = generate(ProblemId(family, 1, variation="full", convention=MODIFIED))
    texts = {"statement": write_statement(problem, "").replace("replace the chapter's $z_{i-1}$ and $p^*_{i-1}$", "")}
    for part in problem.parts:
        texts[f"{part.name}, prompt"] = write_prompt(problem, part)
        texts[f"{part.name}, hints"] = "\n".join(write_hints(problem, part))
    texts |= {f"{name}, solution": text for name, text in write_solutions(problem).items()}
    wrong = re.compile(r"(?:z|p\^\*)_\{?0\b|p\^\*_\{i-1\} *\$|z_\{i-1\} \\times|R_z\(\\theta_i\)\\, T_z\(d_i\)\\, T_x")
    assert not {name: match[0] for name, text in texts.items() if (match := wrong.search(text))}


@on_families(FIXED)
def test_figure_shows_frames_of_the_modified_table(family: str) -> None:
    arm = make_drawable_chain(sample_modified_arm(family))
    _, poses = sample_values(arm)
    for q in poses:
        frames = compute_convention_frames(arm, compute_skeleton(arm, q))
        assert np.allclose(frames, compute_modified_frames(arm, {}, q[None])[0], atol=1e-9)


@pytest.mark.parametrize(("alpha", "a"), [(0, "3/10"), ("pi/2", 0), ("pi/3", "a0"), ("pi", "-3/10")])
def test_first_row_may_have_length_and_twist(alpha: object, a: object) -> None:
    """Then frame 0 is the world frame, unlike in the standard table."""
    base = Base((sp.S(a), sp.S.Zero, sp.S.Zero), sp.S.Zero, sp.S(alpha))
    arm = replace(sample_modified_arm("elbow-3r", variation="chapter"), base=base)
    first = convention_of(arm).rows[0]
    assert (first.a, first.alpha, convention_of(arm).base) == (base.position[0], base.tilt, Base())
    lengths, poses = sample_values(arm)
    expected = compute_modified_frames(arm, lengths, poses)
    assert np.allclose(expected[:, 0], np.eye(4))
    assert certify(Problem(ProblemId("mine", 1), arm, ())).passed
    drawable = make_drawable_chain(arm)
    for q in poses:
        frames = compute_convention_frames(arm, compute_skeleton(drawable, q))
        assert np.allclose(frames, compute_modified_frames(drawable, {}, q[None])[0], atol=1e-9)
    on_axis = "O_0" if first.a == 0 else None  # d_1 leads from the axis to O_1
    assert convention_of(arm).name_origin(0) == on_axis
    flat = replace(sample_modified_arm("planar-3r", variation="chapter"), base=base)
    assert [convention_of(flat).name_origin(k) for k in range(4)] == ["O_1", "O_2", "O_3", "P"]


def test_origins_have_the_names_of_the_convention() -> None:
    planar, puma = (
        convention_of(sample_modified_arm(family, variation="chapter")) for family in ("planar-3r", "puma-560")
    )
    assert [planar.name_origin(k) for k in range(4)] == ["O_1", "O_2", "O_3", "P"]
    assert puma.name_origin(1) == "O_2"
    assert puma.name_origin(2) is None  # d3 leads away from O_2 of the standard
