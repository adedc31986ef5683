"""Make the family of an instructor's own robot (ROBOT.toml): only the lengths under [draw] vary among students."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.families.family import Family
from qdot.exercises.families.variations import are_distinct, to_metres
from qdot.exercises.robots.library import ROBOT_FOLDER
from qdot.exercises.robots.robot_file import LengthRange, Robot, read_robot_file

MAX_TRIES = 50
"""Maximum number of samples of lengths that are clearly different; the instructor's ranges may allow none."""


def read_robot_family(path: Path, robot: Robot | None = None) -> Family:
    """Return the family of a robot file; its name is derived from the file's name. Raises QdotError.

    `robot` is the content of the file; if it is None, the file is read.
    """
    known_robot = robot or read_robot_file(path)
    name = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-") or "robot"
    ranges = known_robot.length_ranges
    axes = {"lengths": partial(_sample_lengths, ranges=ranges)} if ranges else {}
    robot_argument = path.stem if path.parent == ROBOT_FOLDER else shlex.quote(str(path))
    chain, source = replace(known_robot.chain, name=name), known_robot.source or path.name
    return Family(name, chain.title, source, chain, axes, robot_argument=robot_argument)


def _sample_lengths(chain: Chain, rng: Stream, ranges: Sequence[LengthRange]) -> Chain:
    """Return the arm with random lengths from the ranges of [draw].

    If the ranges allow it, the lengths are clearly different.
    """
    for _ in range(MAX_TRIES):
        lengths = [rng.integer(length_range.min_cm, length_range.max_cm) for length_range in ranges]
        if are_distinct(lengths):
            break
    pairs = zip(ranges, lengths, strict=True)
    return substitute_in_arm(chain, {length_range.symbol: to_metres(length) for length_range, length in pairs})
