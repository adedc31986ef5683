"""The library of robots: each agrees with published models in pose and Jacobian; how robots are found by name.

`tests/data/robots` has for each robot the models that it is compared with, as published: joints of a URDF (metres,
radians), rows of a DH table (metres, degrees), or poses and Jacobians that another program computed. The model's joint
values are `sign` times those of the library, plus `zero` (degrees; metres for a prismatic joint); `base` is the
library's world frame in the model's, and `tool` is the model's last frame in the library's. `tolerance` is the
precision of its numbers. The computations with a model here don't use qdot.
"""

import json
import re
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.assignment_files import read_problem_files
from qdot.exercises.robots.library import ROBOT_FOLDER, find_robot_path, list_robots
from qdot.exercises.robots.robot_file import Robot, read_robot_file
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.solve.solver import solve
from tests.exercises.arm.poses import Matrix, compute_exponential, compute_origin_pose, rotate_about, translate
from tests.exercises.arm.sets import compute_rank_ratios, read_pieces, search_singularities
from tests.support import ROOT
from tests.support.command import run, run_and_fail
from tests.support.suites import select_for_suite

DATA = ROOT / "tests" / "data" / "robots"
MODELS = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(DATA.glob("*.json"))}
CASES = [
    pytest.param(name, k, id=f"{name}-{m['kind']}") for name, models in MODELS.items() for k, m in enumerate(models)
]
COUNT = 20
STEP = 1e-5


def compute_urdf_pose(model: dict[str, Any], q: Matrix) -> Matrix:
    pose, values = np.eye(4), iter(np.moveaxis(q, -1, 0))
    for joint in model["joints"]:
        pose = pose @ compute_origin_pose(joint["xyz"], joint["rpy"])
        if joint["kind"]:
            pose = pose @ compute_exponential(joint["axis"], next(values), joint["kind"] == "P")
    return pose


def compute_table_pose(model: dict[str, Any], q: Matrix) -> Matrix:
    pose = np.eye(4)
    for (kind, theta, d, a, alpha), value in zip(model["rows"], np.moveaxis(q, -1, 0), strict=True):
        turn, slide = (value, 0 * value) if kind == "R" else (0 * value, value)
        about_z = rotate_about("z", np.radians(theta) + turn) @ translate(0, 0, d + slide)
        about_x = rotate_about("x", np.radians(alpha)) @ translate(a, 0, 0)
        pose = pose @ (about_x @ about_z if model["kind"] == "modified-dh" else about_z @ about_x)
    return pose


def compute_craig_pose(model: dict[str, Any], q: Matrix) -> Matrix:
    """Equation (3.14) of Craig's book: the entries of the pose of frame 6, as printed."""
    a2, a3, d3, d4 = (model["lengths"][name] for name in ("a2", "a3", "d3", "d4"))
    (c1, c2, _, c4, c5, c6), (s1, s2, _, s4, s5, s6) = np.moveaxis(np.array([np.cos(q), np.sin(q)]), -1, 1)
    c23, s23 = np.cos(q[..., 1] + q[..., 2]), np.sin(q[..., 1] + q[..., 2])
    r11 = c1 * (c23 * (c4 * c5 * c6 - s4 * s6) - s23 * s5 * c6) + s1 * (s4 * c5 * c6 + c4 * s6)
    r21 = s1 * (c23 * (c4 * c5 * c6 - s4 * s6) - s23 * s5 * c6) - c1 * (s4 * c5 * c6 + c4 * s6)
    r31 = -s23 * (c4 * c5 * c6 - s4 * s6) - c23 * s5 * c6
    r12 = c1 * (c23 * (-c4 * c5 * s6 - s4 * c6) + s23 * s5 * s6) + s1 * (c4 * c6 - s4 * c5 * s6)
    r22 = s1 * (c23 * (-c4 * c5 * s6 - s4 * c6) + s23 * s5 * s6) - c1 * (c4 * c6 - s4 * c5 * s6)
    r32 = -s23 * (-c4 * c5 * s6 - s4 * c6) + c23 * s5 * s6
    r13 = -c1 * (c23 * c4 * s5 + s23 * c5) - s1 * s4 * s5
    r23 = -s1 * (c23 * c4 * s5 + s23 * c5) + c1 * s4 * s5
    r33 = s23 * c4 * s5 - c23 * c5
    px = c1 * (a2 * c2 + a3 * c23 - d4 * s23) - d3 * s1
    py = s1 * (a2 * c2 + a3 * c23 - d4 * s23) + d3 * c1
    pz = -a3 * s23 - a2 * s2 - d4 * c23
    last = [0 * px, 0 * px, 0 * px, 0 * px + 1]
    entries = np.array([[r11, r12, r13, px], [r21, r22, r23, py], [r31, r32, r33, pz], last])
    return np.moveaxis(entries, (0, 1), (-2, -1))


POSES: dict[str, Callable[[dict[str, Any], Matrix], Matrix]] = {
    "urdf": compute_urdf_pose, "dh": compute_table_pose, "modified-dh": compute_table_pose, "craig": compute_craig_pose,
}  # fmt: skip


def convert_joint_values(model: dict[str, Any], kinds: str, q: Matrix) -> Matrix:
    zero = [np.radians(z) if kind == "R" else z for z, kind in zip(model["zero"], kinds, strict=True)]
    return np.array(model["sign"]) * q + np.array(zero)


def get_base_and_tool(model: dict[str, Any]) -> tuple[Matrix, Matrix]:
    base, tool = (compute_origin_pose(model[key]["xyz"], np.radians(model[key]["rpy"])) for key in ("base", "tool"))
    return base, tool


@cache
def read_robot(name: str) -> Robot:
    return read_robot_file(ROBOT_FOLDER / f"{name}.toml")


def compute_model_motion(model: dict[str, Any], robot: Robot) -> tuple[Matrix, Matrix, Matrix]:
    """Return joint values, poses of the library's last frame and its 6 x n Jacobians, computed from the model."""
    kinds = "".join(joint.kind for joint in robot.chain.joints)
    base, tool = get_base_and_tool(model)
    from_world, from_tip = np.linalg.inv(base), np.linalg.inv(tool)
    if model["kind"] == "poses":
        return convert_stored_poses(model, kinds, from_world, from_tip)

    def compute_pose(q: Matrix) -> Matrix:
        return np.asarray(from_world @ POSES[model["kind"]](model, convert_joint_values(model, kinds, q)) @ from_tip)

    q = np.random.default_rng(2024).uniform(-3, 3, (COUNT, len(kinds)))
    poses, columns = compute_pose(q), []
    for e in np.eye(len(kinds)) * STEP:
        slopes = (compute_pose(q + e) - compute_pose(q - e)) / (2 * STEP)
        spin = slopes[:, :3, :3] @ poses[:, :3, :3].swapaxes(-1, -2)
        angular = np.array([spin[:, j, i] - spin[:, i, j] for i, j in ((1, 2), (2, 0), (0, 1))])
        columns.append(np.concatenate([slopes[:, :3, 3], angular.T / 2], axis=-1))
    return q, poses, np.stack(columns, axis=-1)


def convert_stored_poses(
    model: dict[str, Any], kinds: str, from_world: Matrix, from_tip: Matrix
) -> tuple[Matrix, Matrix, Matrix]:
    """Return the same from stored results of another program, whose Jacobian is that of its tip."""
    zero = convert_joint_values(model, kinds, np.zeros(len(kinds)))
    q = np.array(model["sign"]) * (np.array(model["q"]) - zero)
    tip, base_rotation = np.zeros((len(q), 4, 4)) + np.eye(4), from_world[:3, :3]
    tip[:, :3] = model["pose"]
    jacobian = np.array(model["jacobian"]) * np.array(model["sign"])
    at_frame = shift_jacobian(jacobian, tip[:, :3, :3] @ from_tip[:3, 3])
    rotated = np.concatenate([base_rotation @ at_frame[:, :3], base_rotation @ at_frame[:, 3:]], axis=1)
    return q, from_world @ tip @ from_tip, rotated


def shift_jacobian(jacobian: Matrix, offset: Matrix) -> Matrix:
    """Move the reference point of Jacobians (…, 6, n) by an offset (…, 3)."""
    linear = jacobian[..., :3, :] + np.cross(jacobian[..., 3:, :], offset[..., None], axis=-2)
    return np.concatenate([linear, jacobian[..., 3:, :]], axis=-2)


@pytest.mark.parametrize(("name", "k"), CASES)
def test_robot_moves_like_its_published_model(name: str, k: int) -> None:
    model, robot = MODELS[name][k], read_robot(name)
    arm = NumericChain(robot.chain, {}).with_point(robot.chain.n)
    tolerance, (q, poses, jacobians) = model["tolerance"], compute_model_motion(model, robot)
    assert poses.shape == (COUNT, 4, 4)
    assert jacobians.shape == (COUNT, 6, robot.chain.n)
    assert np.allclose(arm.compute_frames(q)[:, -1], poses, rtol=0, atol=tolerance)
    assert np.allclose(arm.compute_jacobian(q), jacobians, rtol=0, atol=5 * tolerance + 1e-8)


QUICK = ("cobra600", "kr5")
FEW = [name if name in QUICK else pytest.param(name, marks=pytest.mark.whole) for name in list_robots()]


@pytest.mark.parametrize("name", FEW)
def test_robot_loses_rank_exactly_where_solve_says(name: str) -> None:
    """Rank is lost where each condition holds; a search from random starts finds no other singular configurations."""
    chain = read_robot(name).chain
    conditions = [" and ".join(f"{c} = 0" for c in component.conditions) for component in solve(chain).singular or ()]
    for text in conditions:
        samples = sample_condition(chain, text, name, arm_count=1, samples_per_arm=5)
        assert samples and all(compute_rank_ratios(sample.arm, chain, sample.q) < 1e-6 for sample in samples), text
    search = search_singularities(chain, name, select_for_suite(40, 120))
    assert len(search.reached) > len(search.starts) / 2
    assert search.are_in(read_pieces(chain, conditions), 1e-5).all()


def test_every_robot_has_a_model_and_a_source() -> None:
    assert sorted(MODELS) == sorted(list_robots())
    assert all(model["source"] for models in MODELS.values() for model in models)
    assert all(model["tolerance"] <= 1e-8 or model["why"] for models in MODELS.values() for model in models)
    assert all(any(model["tolerance"] <= 3e-5 for model in models) for models in MODELS.values())
    for robot in list_robots().values():
        text = robot.path.read_text(encoding="utf-8")
        assert text.startswith("# "), f"{robot.name} does not name its source"
        assert read_robot(robot.name).source == robot.source
        assert max(map(len, text.splitlines())) <= 120


def test_source_of_robot_is_read_and_must_be_text(tmp_path: Path) -> None:
    text, source = write_robot_text(read_robot("scorbot"), "modified-dh"), read_robot("scorbot").source
    path = tmp_path / "arm.toml"
    for line, expected in ((f'source = "{source}"\n', source), ("", ""), ("source = 12\n", None)):
        path.write_text(text.replace(f'source = "{source}"\n', line), encoding="utf-8")
        if expected is None:
            with pytest.raises(QdotError, match=r"line 2: source = 12"):
                read_robot_file(path)
        else:
            assert read_robot_file(path).source == expected


def test_robots_are_sorted_by_name_and_number() -> None:
    names = list(list_robots())
    assert [name for name in names if name.startswith("ur")] == ["ur3", "ur3e", "ur5", "ur5e", "ur10", "ur10e"]
    assert [(a, b) for a, b in pairwise(names) if a[0] > b[0]] == []


def test_file_takes_precedence_over_robot_name(tmp_path: Path) -> None:
    for name in ("panda", "PANDA", "LR-Mate 200iD", "iiwa_14", "Puma-560"):
        assert find_robot_path(name) == ROBOT_FOLDER / f"{re.sub('[-_ ]', '', name.lower())}.toml"
    path = tmp_path / "panda"
    path.write_text("mine", encoding="utf-8")
    assert find_robot_path("panda", tmp_path) == find_robot_path(str(path)) == path


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pandas", r"no file pandas and no robot 'pandas' \(did you mean 'panda'\?\)"),
        ("ur-5f", "did you mean 'ur5'"), ("wxyz", "no robot 'wxyz'; 'qdot robots'"),
        ("arm.toml", r"there is no file arm\.toml$"), ("panda.toml", "no file panda.toml; .* panda"),
        ("arms/UR5e", "no file arms/UR5e; .* ur5e"), (".", r"\. is a folder"), ("", "is a folder"),
        ("panda" * 1000, "pandapanda: File name too long"),
    ],
)  # fmt: skip
def test_unknown_file_or_robot_is_refused(name: str, message: str) -> None:
    with pytest.raises(QdotError, match=message):
        find_robot_path(name)


def test_robots_command_lists_all_robots() -> None:
    listed = json.loads(run("robots", "--json"))
    assert [robot["name"] for robot in listed] == list(list_robots())
    assert {"name", "title", "joints", "convention", "source"} == {*listed[0]}
    output = run("robots")
    for robot in list_robots().values():
        assert re.search(rf"(?m)^  {robot.name} +{robot.joints} +{robot.convention} +\S", output)
    assert max(map(len, output.splitlines())) <= 100


def test_solve_accepts_robot_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    solved = json.loads(run("solve", "Cobra-600", "--format", "json"))
    assert (solved["name"], solved["determinant"]) == ("Adept Cobra 600", "143*sin(theta2)/1600")
    assert [component["solutions"] for component in solved["singular"]] == [{"theta2": ["0", "pi"]}]
    assert "(did you mean 'cobra600'?)" in run_and_fail("solve", "cobra66")
    Path("cobra600").write_text("no arm", encoding="utf-8")
    assert "cobra600: line 1: not valid TOML" in run_and_fail("solve", "cobra600")


def test_assignment_takes_robot_from_library_or_folder(tmp_path: Path) -> None:
    init_assignment(tmp_path / "hw", "Robots", "hw")
    path = tmp_path / "hw" / "assignment.toml"
    path.write_text('title = "T"\nkey = "hw"\n[[problem]]\nrobot = "Cobra600"\nquestions = ["determinant"]\n')
    slot = load_assignment(path.parent).slots[0]
    assert (slot.name, slot.family.name, slot.family.title) == ("p1", "cobra600", "Adept Cobra 600")
    assert _list_exported_files(path.parent) == ["assignment.toml"]
    path.write_text(path.read_text().replace("Cobra600", "cobra"))
    with pytest.raises(QdotError, match=r'line 4: problem 1: robot = "cobra": .*\'cobra600'):
        load_assignment(path.parent)
    text = (ROBOT_FOLDER / "cobra600.toml").read_text(encoding="utf-8").replace("Adept Cobra 600", "Mine")
    (path.parent / "cobra.toml").write_text(text, encoding="utf-8")
    path.write_text(path.read_text().replace('"cobra"', '"cobra.toml"'))
    assert load_assignment(path.parent).slots[0].family.title == "Mine"
    assert _list_exported_files(path.parent) == ["assignment.toml", "cobra.toml"]


def _list_exported_files(folder: Path) -> list[str]:
    return list(read_problem_files(load_assignment(folder)))
