"""The map of where an arm is singular: what is drawn is where J loses rank, and what is not is said."""

import itertools
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.arm.derivation import derive
from exercises.arm.library import robot_path
from exercises.arm.robot_file import Limits, read_robot_file
from exercises.arm.singularity import Component, singular_set
from exercises.errors import QdotError
from exercises.figure.pose import example_values
from exercises.locus import GRID, Map, check_map, singular_map, write_map

T2, T3, T4, D3 = sp.symbols("theta2 theta3 theta4 d3")
SVG = "{http://www.w3.org/2000/svg}"


def arm(kinds: str, task: Sequence[str] = ("vx", "vy")) -> Chain:
    joints = (
        Joint(kind, f"theta{i}" if kind == "R" else 0, 0 if kind == "R" else f"d{i}", 0 if kind == "P" else f"a{i}", 0)
        for i, kind in enumerate(kinds, 1)
    )
    return Chain("an arm", tuple(joints), tuple(task))


def drawn(chain: Chain, components: Sequence[Component], limits: Sequence[Limits | None] = ()) -> Map:
    found = singular_map(chain, components, limits)
    assert found is not None
    return found


def labels(svg: str) -> list[str]:
    return ["".join(text.itertext()).strip() for text in ET.fromstring(svg).iter(f"{SVG}text")]


def curves(svg: str) -> list[np.ndarray]:
    """Return what `contour` has drawn: each line in units of the axes, from -180 to 180 degrees."""
    found = []
    frame = re.search(r'id="patch_2".*?d="([^"]*)"', svg, re.DOTALL)
    assert frame is not None
    corners = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", frame.group(1)), dtype=float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    for path in re.findall(r'<g id="(?:Quad|)ContourSet_\d+">\s*<path d="([^"]*)"', svg):
        for piece in path.split("M")[1:]:
            points = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", piece), dtype=float)
            share = (points - low) / (high - low)
            found.append(np.stack([360 * share[:, 0] - 180, 180 - 360 * share[:, 1]], axis=1))
    return found


def test_on_every_curve_of_a_known_robot_the_jacobian_loses_rank() -> None:
    """PUMA 560: the elbow, and the wrist centre over joint 1; drawn points are some of a degree off at most."""
    robot = read_robot_file(robot_path("puma560"), "", "")
    found = drawn(robot.chain, [Component(one.conditions, None) for one in singular_set(robot.chain) or ()])
    jacobian = derive(robot.chain).jacobian
    numeric = sp.lambdify(robot.chain.q, jacobian, "numpy")
    lines = [line for line in curves(found.svg) if np.abs(line).max() < 182]  # others are of the second picture
    assert len(lines) >= 4

    def least(t2: float, t3: float) -> float:
        matrix = np.array(numeric(0.3, t2, t3, 0.4, 0.9, 0.2), dtype=float)
        return float(np.linalg.svd(matrix, compute_uv=False)[-1])

    for line in lines:
        for start, end in itertools.pairwise(line):
            for share in (0.1, 0.5, 0.9):
                assert least(*np.radians(start + share * (end - start))) < 2e-3
    assert least(0.4, 0.2) > 0.02


def test_values_at_the_edge_are_drawn_at_both_edges() -> None:
    found = drawn(arm("RR"), [Component((sp.sin(T2),), ((T2, (sp.S.Zero, sp.pi)),))])
    assert sorted({round(float(np.median(line[:, 1]))) for line in curves(found.svg)}) == [-180, 0, 180]


def test_conditions_that_hold_together_are_points_and_those_beside_a_curve_are_named() -> None:
    chain = arm("RRRR", ("vx", "vy", "wz"))
    points = Component((sp.sin(T2), sp.cos(T3)), ((T2, (sp.S.Zero, sp.pi)), (T3, (sp.pi / 2, -sp.pi / 2))))
    beside = Component((sp.cos(T4), sp.sin(T2 + T3)), None)
    found = drawn(chain, [points, beside])
    assert found.svg.count("<use") >= 6  # 0 and both edges, times two
    told = " ".join(labels(found.svg))
    assert "s₂ = 0 and" in told and "c₃ = 0" in told and "c₄ = 0 and" in told and "s₂₃ = 0" in told


def test_a_condition_in_three_joints_is_drawn_for_values_of_the_third() -> None:
    found = drawn(arm("RRRR", ("vx", "vy", "wz")), [Component((sp.sin(T2 + T3 + 2 * T4),), None)])
    shown = [label for label in labels(found.svg) if label.startswith("θ₄ =")]
    assert shown == [f"θ₄ = {value}°" for value in ("−120", "−60", "0", "60", "120")]


def test_what_is_in_more_joints_is_said_and_open_lengths_are_told() -> None:
    chain = arm("RRRR", ("vx", "vy", "wz"))
    many = Component((sp.sin(T2 + T3) * sp.sin(T4) + sp.cos(sp.Symbol("theta1")),), None)
    found = drawn(chain, [many, Component((sp.sin(T2),), None)])
    assert found.notes[1].startswith("Not in the map: 1 of the cases")
    for symbol, value in example_values(chain).items():
        assert f"{symbol} = {float(value):.3g}" in found.notes[0]
    assert singular_map(chain, [many]) is None


def test_slides_are_in_metres_and_limits_are_shaded() -> None:
    chain = arm("RRP")
    component = Component((D3 + sp.cos(T2),), None)
    free, limited = drawn(chain, [component]), drawn(chain, [component], [None, (-sp.pi / 2, sp.pi / 2), None])
    assert "d₃ (m)" in labels(free.svg) and "θ₂ (°)" in labels(free.svg)
    shaded = "shaded: beyond the limits of a joint"
    assert shaded in labels(limited.svg) and shaded not in labels(free.svg)
    assert limited.svg.count("opacity: 0.08") == 2 and free.svg.count("opacity: 0.08") == 0


def test_the_same_arm_gives_the_same_bytes() -> None:
    chain, component = arm("RR"), Component((sp.sin(T2),), None)
    assert drawn(chain, [component]).svg == drawn(chain, [component]).svg
    assert GRID % 2 == 1, "0 is a point of the grid"


def test_a_map_that_cannot_be_drawn_is_refused_before_anything_is_derived_or_not_written(tmp_path: Path) -> None:
    for file, why in ((tmp_path / "map.png", "ends in .svg"), (tmp_path / "none" / "map.svg", "no folder")):
        with pytest.raises(QdotError, match=why):
            check_map(file)
    robot, file = read_robot_file(robot_path("puma560"), "", ""), tmp_path / "map.svg"
    check_map(file)
    assert "no singular set" in write_map(file, robot, None) and "no configuration" in write_map(file, robot, ())
    assert not file.exists()
