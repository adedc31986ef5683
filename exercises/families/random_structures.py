"""Define the families random-2, random-3 and random-4, whose structures are sampled from all clean structures.

Structures are clean if the arm can be solved by hand, and those of one class lead to the same problem (`structures`).
First a class is sampled, with equal probabilities, and then one of its structures. Then the axes of variation change
these properties of the arm:

- the lengths, the joint offsets, and the senses of the axes (mirror images);
- the position and the orientation of the base, and with them the rows of the task;
- whether the last length is in the table or in the coordinates of the point of interest.

If there are lengths on which no condition of the singular set depends, one of these lengths stays symbolic. The other
lengths become numbers for which every condition can hold.
"""

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache, partial
from itertools import zip_longest

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import compile_expressions
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.families import variations
from qdot.exercises.families.family import Family
from qdot.exercises.families.structures import Structure, build_arm, group_clean_structures, is_clean
from qdot.exercises.families.variations import ANGLES, RIGHT_ANGLES, SIGNED_LENGTHS
from qdot.exercises.formula.program import evaluate
from qdot.exercises.singularities.difficulty import HARDEST_LEVEL, describe_band, rate_difficulty_level
from qdot.exercises.singularities.singular_set import find_singular_set

Band = tuple[int, int]
"""The minimum and the maximum level of difficulty of an arm."""
ChainTest = Callable[[Chain], bool]
"""A function that returns whether an arm is acceptable."""
Values = dict[sp.Symbol, sp.Rational]
"""Maps symbolic lengths to numbers (m)."""

MAX_ARMS, MAX_ARMS_PER_STRUCTURE, MAX_LENGTH_SETS = 400, 4, 60
"""Maximum numbers of samples: arms in total, arms of one structure, and sets of lengths for one arm."""
INVERSE_FUNCTIONS = (sp.atan, sp.acos, sp.asin)
"""Inverse functions, which do not occur in the joint values of easy singular configurations."""
CONFIGURATION_COUNT, MIN_SIGN_FRACTION = 400, 0.02
"""Number of configurations at which a condition is evaluated, and a fraction of its largest absolute value. If the
values exceed this fraction with both signs, the condition has a zero and can hold.
"""

SOURCE = "equations 6.1 to 6.12"
LENGTHS = tuple(range(10, 100, 5))
"""Numeric lengths, in centimetres."""


def _sample_structure(
    n: int, rng: Stream, axes: Collection[str], band: Band | None = None, is_acceptable: ChainTest | None = None
) -> Chain:
    """Return a random arm of n joints whose level of difficulty is in the band and which satisfies `is_acceptable`.

    Raises QdotError if no arm is found.
    """
    low, high = band or (0, HARDEST_LEVEL)
    classes = [*filter(None, (_select_near_band(structures, low, high) for structures in group_clean_structures(n)))]
    rejected_structures: set[Structure] = set()
    has_arm_in_band = False
    for index, structure in enumerate((_order_structures(classes, rng) * MAX_ARMS_PER_STRUCTURE)[:MAX_ARMS]):
        chain = None if structure in rejected_structures else _sample_arm(structure, rng.substream(str(index)), axes)
        if chain is None or not low <= rate_difficulty_level(chain) <= high:
            continue
        has_arm_in_band = True
        if is_acceptable is None or is_acceptable(chain):
            return chain
        rejected_structures.add(structure)
    band_phrase = f"of difficulty {describe_band(low, high)}" if band else "of any difficulty"
    if has_arm_in_band:
        raise QdotError(f"random-{n} has no arm {band_phrase} to which all of these questions apply")
    levels = [structure.level for structures in group_clean_structures(n) for structure in structures]
    raise QdotError(
        f"random-{n} has no arm {band_phrase}; its arms are of difficulty {describe_band(min(levels), max(levels))}"
    )


def _order_structures(classes: list[tuple[Structure, ...]], rng: Stream) -> list[Structure]:
    """Return all structures in random order, with one structure of each class before a second one of any class."""
    rounds = zip_longest(*(rng.permutation(structures) for structures in rng.permutation(classes)))
    return [structure for structures in rounds for structure in structures if structure is not None]


def _select_near_band(structures: tuple[Structure, ...], low: int, high: int) -> tuple[Structure, ...]:
    """Return the structures whose arms may have a level of difficulty from `low` to `high`.

    Joint offsets and a displaced base make an arm harder than its structure, and equal lengths make it easier.
    """
    return tuple(structure for structure in structures if low - 2 <= structure.level <= high + 1)


def _sample_arm(structure: Structure, rng: Stream, axes: Collection[str]) -> Chain | None:
    """Return a random arm of a structure; None if there are no suitable lengths (`_sample_lengths`)."""
    sense_stream = rng.substream("senses")
    senses = tuple(variations.choose_sign(sense_stream) for _ in structure.rows) if "senses" in axes else ()
    chain = build_arm(structure.rows, structure.task, f"random-{len(structure.rows)}", senses)
    if "lengths" in axes:
        values = _sample_lengths(chain, rng.substream("lengths"), needs_clean_roots="tool" not in axes)
        if values is None:
            return None
        chain = substitute_in_arm(chain, values)
    if "zeros" in axes:
        chain = _shift_zeros(chain, rng.substream("zeros"))
    if "base" in axes:
        chain = _mount_arm(chain, rng.substream("base"))
    return variations.place_point(chain, rng.substream("tool")) if "tool" in axes else chain


def _sample_lengths(chain: Chain, rng: Stream, needs_clean_roots: bool) -> Values | None:
    """Return random lengths for which every condition of the singular set can hold; None if none are found.

    One length that no condition contains stays symbolic. If `needs_clean_roots`, the joint values of singular
    configurations contain no inverse functions such as arctan(35/6).
    """
    components = find_singular_set(chain) or ()
    conditions = tuple(condition for component in components for condition in component.conditions)
    roots = [root for component in components for _, values in component.solutions or () for root in values]
    irrelevant_lengths = [
        length for length in chain.parameters if not any(condition.has(length) for condition in conditions)
    ]
    symbolic_length = rng.choice(irrelevant_lengths) if irrelevant_lengths else None
    for _ in range(MAX_LENGTH_SETS):
        lengths_in_cm = {symbol: rng.choice(LENGTHS) for symbol in chain.parameters if symbol != symbolic_length}
        values = {symbol: variations.to_metres(length) for symbol, length in lengths_in_cm.items()}
        has_clean_roots = not any(root.xreplace(values).has(*INVERSE_FUNCTIONS) for root in roots)
        is_accepted = variations.are_distinct([*lengths_in_cm.values()]) and (has_clean_roots or not needs_clean_roots)
        if is_accepted and _can_all_hold(conditions, chain, values):
            return values
    return None


def _shift_zeros(chain: Chain, rng: Stream) -> Chain:
    """Return the arm with random joint offsets; prismatic joints have none if J would otherwise have too many terms."""
    choices = [SIGNED_LENGTHS if joint.is_prismatic else RIGHT_ANGLES for joint in chain.joints]
    if chain.joints[0].is_revolute:
        choices[0] = ANGLES
    shifted_joints = tuple(map(variations.shift_zero, chain.joints, map(rng.choice, choices)))
    shifted_chain = replace(chain, joints=shifted_joints)
    if is_clean(shifted_chain):
        return shifted_chain
    pairs = zip(chain.joints, shifted_joints, strict=True)
    return replace(chain, joints=tuple(joint if joint.is_prismatic else new_joint for joint, new_joint in pairs))


def _mount_arm(chain: Chain, rng: Stream) -> Chain:
    """Return the arm mounted on the floor, the ceiling or a wall, with the rows of its task rotated accordingly."""
    mounted_chain = variations.mount_base(chain, rng)
    rotation = rot_z(mounted_chain.base.yaw) * rot_x(mounted_chain.base.tilt)
    # Axis k of the base is the world axis whose entry in column k of the rotation is not zero.
    rotated_axis_names = {"xyz"[k]: "xyz"[next(i for i in range(3) if rotation[i, k] != 0)] for k in range(3)}
    rows = {row[0] + rotated_axis_names[row[1]] for row in chain.task}
    mounted_chain = replace(mounted_chain, task=tuple(row for row in VELOCITY_NAMES if row in rows))
    if not mounted_chain.is_planar:
        return mounted_chain
    position = variations.displace_base(chain, rng).base.position
    return replace(mounted_chain, base=replace(mounted_chain.base, position=position))


# --- lengths for which conditions can hold ---


@lru_cache(maxsize=64)
def _sample_configurations(kinds: str) -> np.ndarray:
    """Return the random configurations, CONFIGURATION_COUNT x n, of arms with these kinds of joints, such as RRP."""
    stream, limits = Stream(f"random/{kinds}"), [np.pi if kind == REVOLUTE else 2.0 for kind in kinds]
    return np.array([[stream.uniform(-limit, limit) for limit in limits] for _ in range(CONFIGURATION_COUNT)])


def _can_all_hold(conditions: tuple[sp.Expr, ...], chain: Chain, values: Values) -> bool:
    """Return whether each condition clearly has both signs at the sampled configurations, and so has a zero."""
    if not conditions:
        return True
    configurations = _sample_configurations("".join(joint.kind for joint in chain.joints))
    symbol_values = {q.name: column for q, column in zip(chain.q, configurations.T, strict=True)}
    symbol_values |= {symbol.name: np.full(CONFIGURATION_COUNT, float(value)) for symbol, value in values.items()}
    condition_values = evaluate(compile_expressions(*conditions), symbol_values, CONFIGURATION_COUNT).values.real
    threshold = MIN_SIGN_FRACTION * np.abs(condition_values).max(axis=1)
    return bool(np.all((condition_values.min(axis=1) < -threshold) & (condition_values.max(axis=1) > threshold)))


RANDOM_FAMILIES = tuple(
    Family(f"random-{n}", f"Random arm of {word} joints", SOURCE, None, sample_structure=partial(_sample_structure, n))
    for n, word in ((2, "two"), (3, "three"), (4, "four"))
)
