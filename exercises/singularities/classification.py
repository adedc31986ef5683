"""Classify singular sets: boundary or internal, uniformly or not, and what their configurations look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain as chain_together
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import are_unrelated, with_symbolic_lengths
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.singularities.appearance import describe_appearance
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalized_pieces
from qdot.exercises.singularities.singularity import Component, Values, singular_set
from qdot.exercises.singularities.singularity_kinds import are_one_sided, can_establish_kind, classify_samples

_SAMPLE_COUNT = 60
"""Approximate number of samples that are examined together; with fewer, all might miss an exception."""
_KIND_STRIDE = 2
"""Only every second sample is tested for its kind, because this test takes longer."""
_EXTRA_LENGTH_SAMPLES = 60
"""Number of further choices of symbolic lengths that are tested before a kind is reported for all lengths."""
_ARMS_PER_LENGTH = 5
"""Number of arms that are sampled per symbolic length."""
_MIN_LENGTH_COUNT = 3
"""An arm with fewer symbolic lengths than this is sampled as if it had this many."""

_MAX_VALUE_COMBINATIONS = 4
"""Maximum number of combinations of joint values that are listed separately."""

_ARM_KEY = "number of the arm"
"""The name of the variable that holds the number of the arm to which a configuration belongs."""


@dataclass(frozen=True)
class Classification:
    """The classification of a set of singular configurations.

    - `kind`: "boundary" or "internal". It is empty, and is not reported, if it can't be established
      (`can_establish_kind`) or if no configuration was found.
    - `uniform`: whether all configurations are of that kind.
    - `meaning`: what the configurations look like, in words.
    """

    kind: str
    uniform: bool
    meaning: str


def domain_of(
    chain: Chain, values: Mapping[str, float | np.ndarray] | None = None, prismatic_role: str = "signed"
) -> Domain:
    """Return the domain of a chain's symbols: joints, rates, task velocity and symbolic lengths, or their given values.

    `prismatic_role` is the role of prismatic joints: "signed" for comparing answers, or "travel", limited as in a real
    arm.
    """
    roles: dict[str, str | float | np.ndarray] = {}
    for joint, q, rate in zip(chain.joints, chain.q, chain.rates, strict=True):
        roles[q.name] = "angle" if joint.kind == "R" else prismatic_role
        roles[rate.name] = "signed"
    roles.update(dict.fromkeys(TASK_ROWS, "signed"))
    for symbol in chain.parameters:
        roles[symbol.name] = "angle" if symbol.name.startswith(("alpha", "beta")) else "length"
    return Domain({**roles, **(values or {})})


@lru_cache(maxsize=64)  # a component is examined as a whole first, and then again for each value of a joint
def sample_condition(
    chain: Chain, condition: str, seed: str, arm_count: int = 5, samples_per_arm: int = 3
) -> tuple[Sample, ...]:
    """Return configurations at which `condition` (text) holds, for several choices of the symbolic lengths."""
    samples_by_arm: list[list[Sample]] = [[] for _ in range(arm_count)]
    has_prismatic_joints = any(joint.kind == "P" for joint in chain.joints)
    # an arm may be at the boundary with extended prismatic joints, but not with retracted ones
    for first_arm, role in ((0, "signed"), (1, "travel")) if has_prismatic_joints else ((0, "signed"),):
        stream = Stream(f"{seed}/{condition}/{first_arm}")
        arm_numbers = range(first_arm, arm_count, 2 if has_prismatic_joints else 1)
        values = [_sample_distinct_lengths(chain, stream) for _ in arm_numbers]
        for piece in parse_pieces(parse_formula(condition), [q.name for q in chain.q]) if values else ():
            pieces = _sample_piece(chain, piece, values, role, stream, samples_per_arm)
            for number, samples in zip(arm_numbers, pieces, strict=True):
                samples_by_arm[number] += samples
    return tuple(chain_together.from_iterable(samples_by_arm))


def _sample_distinct_lengths(chain: Chain, stream: Stream) -> dict[str, float]:
    """Sample the symbolic lengths, none of them close to another length, because equal lengths are a special case."""
    fixed_lengths = [joint.a for joint in chain.joints] + [j.d for j in chain.joints if j.kind == "R"]
    used_lengths = [abs(float(length)) for length in fixed_lengths if length.is_number]
    values = {}
    for symbol in chain.parameters:
        candidates = [round(0.4 * 3.5 ** stream.uniform(0, 1), 3) for _ in range(5)]
        value = next((v for v in candidates if all(abs(v - length) > 0.01 for length in used_lengths)), candidates[-1])
        values[symbol.name] = value
        used_lengths.append(value)
    return values


def _sample_piece(
    chain: Chain, piece: Piece, lengths: Sequence[Mapping[str, float]], role: str, stream: Stream, samples_per_arm: int
) -> list[list[Sample]]:
    """Return up to `samples_per_arm` configurations for each arm, computed for all arms at once.

    `lengths` are the lengths of each arm, and `role` is the role of prismatic joints.
    """
    joints, count = [q.name for q in chain.q], 3 * samples_per_arm
    names = [symbol.name for symbol in chain.parameters]
    values_by_name = {name: np.repeat([values[name] for values in lengths], count) for name in names}
    values_by_name[_ARM_KEY] = np.repeat(np.arange(len(lengths)), count)
    space = ConfigurationSpace(joints, domain_of(chain, values_by_name, role))
    sampled_names = {*space.collect_names([[piece]]), _ARM_KEY}
    values = space.sample_piece(piece, sampled_names, stream, count=count * len(lengths))
    configurations = np.array([values[joint] for joint in joints]).T
    samples = []
    for number, arm_lengths in enumerate(lengths):
        arm = NumericChain(chain, arm_lengths)
        samples.append([Sample(arm, q) for q in configurations[values[_ARM_KEY] == number][:samples_per_arm]])
    return samples


def classify(chain: Chain, component: Component) -> Classification:
    """Classify a component of the singular set by samples of its configurations and of the symbolic lengths.

    If some configurations are boundary and some internal, `kind` is "boundary" and `uniform` is False. The kind is
    first established for the structure, for all lengths at once. If that gives several answers, the kind is established
    for the normalized arm, once for all arms that share it.
    """
    arm, conditions = normalize_arm(chain), tuple(normalized_pieces(chain, component))
    general, general_conditions = generalize(chain)
    if all(condition in general_conditions for condition in conditions):
        kind = _kind_for_all_lengths(general, tuple(general_conditions[condition] for condition in conditions))
        if kind is not None:
            return kind if kind.uniform or not kind.kind else replace(kind, **_kind_and_uniformity(arm, conditions))
    return classify_conditions(arm, conditions)


@lru_cache(maxsize=1024)
def generalize(chain: Chain) -> tuple[Chain, Mapping[str, str]]:
    """Return the normalized arm with symbols for all lengths, and its conditions for singular configurations.

    The conditions are text; their keys are the same conditions of the arm itself. There are none if lengths of the arm
    are related, for example equal.
    """
    general, lengths = with_symbolic_lengths(chain)
    relevant_lengths = [value for symbol, value in lengths.items() if symbol in normalize_arm(general).parameters]
    general_pieces = {}
    for component in singular_set(general) or () if relevant_lengths and are_unrelated(relevant_lengths) else ():
        for part_component in [component.at(values) for values in component.value_combinations()] or [component]:
            (general_piece,) = normalized_pieces(general, part_component)
            (arm_piece,) = normalized_pieces(normalize_arm(chain), _substitute_lengths(part_component, lengths))
            general_pieces[arm_piece] = general_piece
    return normalize_arm(general), general_pieces


def _substitute_lengths(component: Component, lengths: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with numbers substituted for lengths."""
    conditions = tuple(substitute(condition, lengths) for condition in component.conditions)
    return replace(component, conditions=conditions).map_values(lambda _, value: substitute(value, lengths))


@lru_cache(maxsize=4096)
def _kind_for_all_lengths(chain: Chain, conditions: tuple[str, ...]) -> Classification | None:
    """Return the classification of conditions for all lengths; None if one condition has several possible looks."""
    kind = classify_conditions(chain, conditions)
    if len(conditions) > 1:
        return kind if all(_kind_for_all_lengths(chain, (condition,)) for condition in conditions) else None
    return None if " or " in kind.meaning else kind


def split_by_value(component: Component, kind: Classification) -> list[tuple[Values, Component]]:
    """Split a component by its combinations of joint values; return an empty list unless the parts may differ.

    They may differ in kind or in what they look like.
    """
    combinations = component.value_combinations()
    may_differ = " or " in kind.meaning or (kind.kind and not kind.uniform)
    if not may_differ or not 1 < len(combinations) <= _MAX_VALUE_COMBINATIONS:
        return []
    return [(values, component.at(values)) for values in combinations]


@lru_cache(maxsize=4096)
def classify_conditions(chain: Chain, conditions: tuple[str, ...]) -> Classification:
    """Classify the union of conditions (text), as `classify` does for a component."""
    meaning = describe_appearance(chain, representative_samples(chain, conditions))
    return Classification(**_kind_and_uniformity(chain, conditions), meaning=meaning)


@lru_cache(maxsize=4096)
def _kind_and_uniformity(chain: Chain, conditions: tuple[str, ...]) -> Mapping[str, Any]:
    """Return `kind` and `uniform` of conditions."""
    kinds = set[str]()
    if can_establish_kind(chain):
        kinds.update(classify_samples(chain, representative_samples(chain, conditions)[::_KIND_STRIDE]))
    if len(kinds) == 1 and chain.parameters:  # for other lengths the kind may differ
        others = (sample_condition(chain, condition, "lengths", _EXTRA_LENGTH_SAMPLES, 1) for condition in conditions)
        kinds.update(classify_samples(chain, [*chain_together.from_iterable(others)]))
    return {"kind": "boundary" if "boundary" in kinds else "internal" if kinds else "", "uniform": len(kinds) == 1}


@lru_cache(maxsize=256)
def is_one_sided(chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> bool:
    """Return whether all configurations at a condition or at joint values lose one direction, and one side of it.

    The arm can't move to that side at all, not even to second order.
    """
    text = f"{condition} = 0" if condition is not None else " and ".join(f"{q} = {value}" for q, value in values)
    return are_one_sided(chain, sample_condition(chain, text, "sides"))


def representative_samples(chain: Chain, conditions: Sequence[str]) -> list[Sample]:
    """Return enough configurations on conditions (text) to generalize from these to all."""
    # the look and the kind may depend on which symbolic length is larger
    arms = _ARMS_PER_LENGTH * max(_MIN_LENGTH_COUNT, len(chain.parameters)) if chain.parameters else _ARMS_PER_LENGTH
    samples_per_arm = -(-_SAMPLE_COUNT // (arms * len(conditions)))
    samples_of_all = (sample_condition(chain, condition, "seen", arms, samples_per_arm) for condition in conditions)
    samples = list(chain_together.from_iterable(samples_of_all))
    return samples[:: max(1, len(samples) // _SAMPLE_COUNT)]
