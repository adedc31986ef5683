"""An instructor's own robot (ROBOT.toml) as a family: the lengths under [draw] differ from student to student."""

import re
from dataclasses import replace
from functools import partial
from itertools import combinations
from pathlib import Path

import sympy as sp

from exercises.arm.chain import Chain, Point
from exercises.arm.robot_file import Robot, read_robot_file
from exercises.families.base import Family, centimetres
from exercises.stream import Stream

APART, TRIES = sp.Rational(5, 100), 50
"""Lengths drawn are that much apart, as nearly equal ones add singular configurations that nobody asked for."""


def own_family(path: Path, robot: Robot | None = None) -> Family:
    """Return the family of a robot file, read unless `robot` is given; its name is the file's. Raises QdotError."""
    robot = robot or read_robot_file(path)
    name = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-") or "robot"
    return Family(name, robot.chain.title, path.name, partial(_sample, robot, name))


def _sample(robot: Robot, name: str, rng: Stream) -> Chain:
    for _ in range(TRIES):
        values = {symbol: centimetres(rng, low, high) for symbol, low, high in robot.draws}
        if all(abs(a - b) >= APART for a, b in combinations(values.values(), 2)):
            break
    return replace(_filled(robot.chain, values), name=name)


def _filled(chain: Chain, values: dict[sp.Symbol, sp.Rational]) -> Chain:
    """Return a chain with numbers for some of its symbols."""
    joints = tuple(
        replace(joint, **{key: getattr(joint, key).xreplace(values) for key in ("theta", "d", "a", "alpha")})
        for joint in chain.joints
    )
    x, y, z = (sp.sympify(value).xreplace(values) for value in chain.point.offset)
    tool = None if chain.tool is None else Point(chain.point.frame, (x, y, z))
    return replace(chain, joints=joints, tool=tool)
