"""random-2, random-3, random-4: arms whose structure is sampled, too, from all clean structures.

A class of structures that are the same problem is sampled with equal chances, then one of its structures. Then the axes
of variation change what leaves the problem the same: numbers for lengths, zeros of the joints, mirror images, where the
base stands and how it is rotated (with the rows of the task), and whether the table or the point of interest has the
last length. One length that no condition depends on stays open, if there is one; the others are numbers for which every
condition of the singular set can hold.
"""

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache, partial
from itertools import zip_longest

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.difficulty import HARDEST, describe_band, step
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.axes import (
    ANY_ANGLE,
    BOTH_WAYS,
    RIGHT_ANGLE,
    are_apart,
    displace_base,
    metres,
    mount_base,
    place_point,
    shift_zero,
    sign,
    with_values,
)
from qdot.exercises.families.base import Family
from qdot.exercises.families.structures import Structure, build_arm, group_clean_structures, is_clean
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import Program, compile_program, evaluate

Band = tuple[int, int]
Accepts = Callable[[Chain], bool]
Values = dict[sp.Symbol, sp.Rational]

TRIES, ROUNDS, NUMBERS = 400, 4, 60
"""Samples before qdot gives up: arms in all, arms of one structure, and numbers for one arm."""
INVERSE = (sp.atan, sp.acos, sp.asin)
POSES, CLEARLY = 400, 0.02
"""A condition can hold if it takes both signs at so many poses, on either side by that part of its largest value."""


LENGTHS = tuple(range(10, 100, 5))
"""Centimetres of lengths that are given."""


def _sample(
    n: int, rng: Stream, axes: Collection[str], band: Band | None = None, accepts: Accepts | None = None
) -> Chain:
    low, high = band or (0, HARDEST)
    classes = [near for alike in group_clean_structures(n) if (near := _select_near_band(alike, low, high))]
    refused: set[Structure] = set()
    in_band = False
    for index, structure in enumerate((_order_structures(classes, rng) * ROUNDS)[:TRIES]):
        chain = None if structure in refused else _sample_arm(structure, rng.part(str(index)), axes)
        if chain is None or not low <= step(chain) <= high:
            continue
        in_band = True
        if accepts is None or accepts(chain):
            return chain
        refused.add(structure)
    which = f"of difficulty {describe_band(low, high)}" if band else "of any difficulty"
    if in_band:
        raise QdotError(f"random-{n} has no arm {which} that can be asked all of these questions")
    steps = [structure.step for alike in group_clean_structures(n) for structure in alike]
    range_of_steps = describe_band(min(steps), max(steps))
    raise QdotError(f"random-{n} has no arm {which}; its arms are of difficulty {range_of_steps}")


def _order_structures(classes: list[tuple[Structure, ...]], rng: Stream) -> list[Structure]:
    """Return all structures in random order, one of every class before the second of any."""
    rounds = zip_longest(*(rng.permutation(alike) for alike in rng.permutation(classes)))
    return [structure for in_round in rounds for structure in in_round if structure is not None]


def _select_near_band(alike: tuple[Structure, ...], low: int, high: int) -> tuple[Structure, ...]:
    """Return the structures whose arms may be in the band: zeros and a base make it harder, equal numbers easier."""
    return tuple(structure for structure in alike if low - 2 <= structure.step <= high + 1)


def _sample_arm(structure: Structure, rng: Stream, axes: Collection[str]) -> Chain | None:
    """Return an arm of a structure; None if no sampled numbers let every condition hold."""
    sense_stream = rng.part("senses")
    senses = tuple(sign(sense_stream) for _ in structure.rows) if "senses" in axes else ()
    chain = build_arm(structure.rows, structure.task, f"random-{len(structure.rows)}", senses)
    if "lengths" in axes:
        values = _sample_lengths(chain, rng.part("lengths"), clean_roots="tool" not in axes)
        if values is None:
            return None
        chain = with_values(chain, values)
    if "zeros" in axes:
        chain = _shift_zeros(chain, rng.part("zeros"))
    if "base" in axes:
        chain = _mount_arm(chain, rng.part("base"))
    return place_point(chain, rng.part("tool")) if "tool" in axes else chain


def _sample_lengths(chain: Chain, rng: Stream, clean_roots: bool) -> Values | None:
    """Return a number for every length but one that no condition depends on, for which every condition can hold.

    With `clean_roots`, angles in the singular set are multiples of 15 degrees, and no arctan(35/6).
    """
    components = singular_set(chain) or ()
    conditions = tuple(condition for component in components for condition in component.conditions)
    roots = [root for component in components for _, values in component.solutions or () for root in values]
    free = [s for s in chain.parameters if not any(condition.has(s) for condition in conditions)]
    kept = rng.choice(free) if free else None
    for _ in range(NUMBERS):
        sampled = {symbol: rng.choice(LENGTHS) for symbol in chain.parameters if symbol != kept}
        values = {symbol: metres(length) for symbol, length in sampled.items()}
        clean = not clean_roots or not any(root.xreplace(values).has(*INVERSE) for root in roots)
        if are_apart([*sampled.values()]) and clean and _can_hold(conditions, chain, values):
            return values
    return None


def _shift_zeros(chain: Chain, rng: Stream) -> Chain:
    """Return the arm with other zeros of its joints; those of slides stay where they would add too many terms."""
    choices = [BOTH_WAYS if joint.kind == "P" else RIGHT_ANGLE for joint in chain.joints]
    if chain.joints[0].kind == "R":
        choices[0] = ANY_ANGLE
    shifted = tuple(shift_zero(joint, rng.choice(by)) for joint, by in zip(chain.joints, choices, strict=True))
    moved = replace(chain, joints=shifted)
    if is_clean(moved):
        return moved
    pairs = zip(chain.joints, shifted, strict=True)
    return replace(chain, joints=tuple(joint if joint.kind == "P" else turned for joint, turned in pairs))


def _mount_arm(chain: Chain, rng: Stream) -> Chain:
    """Return the arm on the floor, under the ceiling or on a wall, with the rows that its task then has."""
    moved = mount_base(chain, rng)
    rotation = rot_z(moved.base.yaw) * rot_x(moved.base.tilt)
    names = {"xyz"[k]: "xyz"[next(i for i in range(3) if rotation[i, k] != 0)] for k in range(3)}
    rows = {row[0] + names[row[1]] for row in chain.task}
    placed = replace(moved, task=tuple(row for row in TASK_ROWS if row in rows))
    if not placed.is_planar:
        return placed
    return replace(placed, base=replace(placed.base, position=displace_base(chain, rng).base.position))


# --- numbers for which conditions can hold ---


@lru_cache(maxsize=64)
def _sample_poses(kinds: str) -> np.ndarray:
    stream, ends = Stream(f"random/{kinds}"), {"R": np.pi, "P": 2.0}
    return np.array([[stream.uniform(-ends[kind], ends[kind]) for kind in kinds] for _ in range(POSES)])


@lru_cache(maxsize=1024)
def _compile_conditions(conditions: tuple[sp.Expr, ...]) -> Program:
    return compile_program([read(str(condition)) for condition in conditions])


def _can_hold(conditions: tuple[sp.Expr, ...], chain: Chain, values: Values) -> bool:
    """Tell whether each condition clearly takes both signs over the joints, so that it vanishes in between."""
    if not conditions:
        return True
    poses = _sample_poses("".join(joint.kind for joint in chain.joints))
    known = {q.name: column for q, column in zip(chain.q, poses.T, strict=True)}
    known |= {symbol.name: np.full(POSES, float(value)) for symbol, value in values.items()}
    evaluated = evaluate(_compile_conditions(conditions), known, POSES)[0].real
    least = CLEARLY * np.abs(evaluated).max(axis=1)
    return bool(np.all((evaluated.min(axis=1) < -least) & (evaluated.max(axis=1) > least)))


RANDOM = tuple(
    Family(f"random-{n}", f"Random arm of {word} joints", "equations 6.1 to 6.12", None, structures=partial(_sample, n))
    for n, word in ((2, "two"), (3, "three"), (4, "four"))
)
