"""Classify singular configurations: whether they are boundary or internal singularities, and what they look like.

A component of the singular set (`singular_set`) is classified by samples of its configurations. Arms that differ only
in properties without influence on singularities share a normalized arm (`normalized_arm`) and its classification.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain as chain_together

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_angle_symbol
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import are_unrelated, replace_lengths_by_symbols
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.singularities.appearance import describe_appearance
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, ValueCombination, find_singular_set
from qdot.exercises.singularities.singularity_kinds import are_one_sided, can_establish_kind, classify_samples

_SAMPLE_COUNT = 60
"""Approximate number of samples of a component; fewer samples might all miss an exceptional configuration."""
_KIND_STRIDE = 2
"""The kind is computed at every second sample only, because this takes long."""
_EXTRA_LENGTH_SAMPLES = 60
"""Number of further sets of lengths for which the kind is computed before it is reported for all lengths."""
_ARMS_PER_LENGTH = 5
"""Number of arms that are sampled per symbolic length."""
_MIN_LENGTH_COUNT = 3
"""An arm with fewer symbolic lengths than this is sampled as if it had this many."""

_MAX_VALUE_COMBINATIONS = 4
"""Maximum number of combinations of joint values that are classified separately."""

_ARM_KEY = "number of the arm"
"""The name of an additional variable for the number of the arm to which a sampled configuration belongs."""


@dataclass(frozen=True)
class Classification:
    """The classification of a set of singular configurations.

    - `kind`: "boundary" or "internal"; "" if the kind can't be established (`can_establish_kind`) or if no
      configuration was found. Then no kind is reported.
    - `is_uniform`: whether all configurations are of that kind; if not, some are boundary and some are internal.
    - `meaning`: what the configurations look like, in words.
    """

    kind: str
    is_uniform: bool
    meaning: str


def make_domain(
    chain: Chain, values: Mapping[str, float | np.ndarray] | None = None, prismatic_role: str = "signed"
) -> Domain:
    """Return the ranges from which the symbols of an arm are sampled: joints, rates, task velocity and lengths.

    `values` has fixed values for some symbols. `prismatic_role` is the range of prismatic joints: "signed" to compare
    answers, or "travel" with limits as in a real arm.
    """
    roles: dict[str, str | float | np.ndarray] = {}
    for joint, q, rate in zip(chain.joints, chain.q, chain.rates, strict=True):
        roles[q.name] = "angle" if joint.is_revolute else prismatic_role
        roles[rate.name] = "signed"
    roles.update(dict.fromkeys(VELOCITY_NAMES, "signed"))
    for symbol in chain.parameters:
        roles[symbol.name] = "angle" if is_angle_symbol(symbol) else "length"
    return Domain({**roles, **(values or {})})


@lru_cache(maxsize=64)  # a component is first classified as a whole, and then for each value of a joint
def sample_condition(
    chain: Chain, condition: str, seed: str, arm_count: int = 5, samples_per_arm: int = 3
) -> tuple[Sample, ...]:
    """Return configurations at which a condition (text) holds, for several sets of values of the symbolic lengths.

    The lengths and configurations are determined by `seed`.
    """
    samples_by_arm: list[list[Sample]] = [[] for _ in range(arm_count)]
    # An arm may be at the boundary with extended prismatic joints, but not with retracted ones. So every second arm is
    # sampled with the wider range "travel".
    roles = ((0, "signed"), (1, "travel")) if chain.prismatic_joints else ((0, "signed"),)
    for first_arm, role in roles:
        stream = Stream(f"{seed}/{condition}/{first_arm}")
        arm_numbers = range(first_arm, arm_count, len(roles))
        lengths = [_sample_distinct_lengths(chain, stream) for _ in arm_numbers]
        for piece in parse_pieces(parse_formula(condition), [q.name for q in chain.q]) if lengths else ():
            samples_on_piece = _sample_piece(chain, piece, lengths, role, stream, samples_per_arm)
            for arm_number, samples in zip(arm_numbers, samples_on_piece, strict=True):
                samples_by_arm[arm_number] += samples
    return tuple(chain_together(*samples_by_arm))


def _sample_distinct_lengths(chain: Chain, stream: Stream) -> dict[str, float]:
    """Return random values of the symbolic lengths (m).

    No length is close to another, because equal lengths are special.
    """
    fixed_lengths = [joint.a for joint in chain.joints] + [j.d for j in chain.joints if j.is_revolute]
    used_lengths = [abs(float(length)) for length in fixed_lengths if length.is_number]
    values = {}
    for symbol in chain.parameters:
        # from 0.4 m to 1.4 m, with a uniform logarithm
        candidates = [round(0.4 * 3.5 ** stream.uniform(0, 1), 3) for _ in range(5)]
        distinct_lengths = (value for value in candidates if all(abs(value - length) > 0.01 for length in used_lengths))
        values[symbol.name] = next(distinct_lengths, candidates[-1])
        used_lengths.append(values[symbol.name])
    return values


def _sample_piece(
    chain: Chain, piece: Piece, lengths: Sequence[Mapping[str, float]], role: str, stream: Stream, samples_per_arm: int
) -> list[list[Sample]]:
    """Return up to `samples_per_arm` configurations on a piece of a condition for each arm.

    `lengths` are the lengths (m) of each arm, and `role` is the range of prismatic joints (`make_domain`). The
    configurations are computed for all arms at once.
    """
    joints, start_count = [q.name for q in chain.q], 3 * samples_per_arm  # some starts lead to no configuration
    names = [symbol.name for symbol in chain.parameters]
    values_by_name = {name: np.repeat([values[name] for values in lengths], start_count) for name in names}
    values_by_name[_ARM_KEY] = np.repeat(np.arange(len(lengths)), start_count)
    space = ConfigurationSpace(joints, make_domain(chain, values_by_name, role))
    sampled_names = {*space.collect_names([[piece]]), _ARM_KEY}
    values = space.sample_piece(piece, sampled_names, stream, count=start_count * len(lengths))
    configurations = np.array([values[joint] for joint in joints]).T
    samples = []
    for number, arm_lengths in enumerate(lengths):
        arm = NumericChain(chain, arm_lengths)
        samples.append([Sample(arm, q) for q in configurations[values[_ARM_KEY] == number][:samples_per_arm]])
    return samples


def classify(chain: Chain, component: Component) -> Classification:
    """Classify a component of an arm's singular set by samples of its configurations and of the symbolic lengths.

    If some configurations are boundary singularities and others internal ones, `kind` is "boundary" and `is_uniform` is
    False. First, the component is classified for an arm with symbols for all lengths. If the result depends on the
    lengths, the component is classified for the normalized arm. Both results are cached.
    """
    arm, conditions = normalize_arm(chain), tuple(normalize_conditions(chain, component))
    symbolic_arm, symbolic_conditions = generalize_conditions(chain)
    if all(condition in symbolic_conditions for condition in conditions):
        result = _classify_for_all_lengths(symbolic_arm, tuple(map(symbolic_conditions.__getitem__, conditions)))
        if result is not None:
            if result.kind and not result.is_uniform:  # the kind may be uniform for this arm's lengths
                kind, is_uniform = _establish_kind(arm, conditions)
                return replace(result, kind=kind, is_uniform=is_uniform)
            return result
    return classify_conditions(arm, conditions)


@lru_cache(maxsize=1024)
def generalize_conditions(chain: Chain) -> tuple[Chain, Mapping[str, str]]:
    """Return the normalized arm with symbols for all lengths, and its conditions for singular configurations.

    The conditions are a map from each condition (text) of the normalized arm of `chain` to the same condition of the
    returned arm. The map is empty if lengths of the arm are related, for example equal.
    """
    symbolic_arm, lengths = replace_lengths_by_symbols(chain)
    normalized_symbolic_arm = normalize_arm(symbolic_arm)
    relevant_lengths = [value for symbol, value in lengths.items() if symbol in normalized_symbolic_arm.parameters]
    conditions = {}
    components = find_singular_set(symbolic_arm) if relevant_lengths and are_unrelated(relevant_lengths) else ()
    for component in components or ():
        for subset in [component.restrict_to(values) for values in component.list_value_combinations()] or [component]:
            (symbolic_condition,) = normalize_conditions(symbolic_arm, subset)
            (condition,) = normalize_conditions(normalize_arm(chain), _substitute_lengths(subset, lengths))
            conditions[condition] = symbolic_condition
    return normalized_symbolic_arm, conditions


def _substitute_lengths(component: Component, lengths: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with values substituted for symbolic lengths."""
    conditions = tuple(condition.xreplace(lengths) for condition in component.conditions)
    return replace(component, conditions=conditions).map_values(lambda _, value: value.xreplace(lengths))


@lru_cache(maxsize=4096)
def _classify_for_all_lengths(chain: Chain, conditions: tuple[str, ...]) -> Classification | None:
    """Return the classification of conditions for all lengths; None if a condition has several meanings."""
    result = classify_conditions(chain, conditions)
    if len(conditions) > 1:
        return result if all(_classify_for_all_lengths(chain, (condition,)) for condition in conditions) else None
    return None if " or " in result.meaning else result  # "arm stretched out or folded back"


def split_by_value(component: Component, classification: Classification) -> list[tuple[ValueCombination, Component]]:
    """Split a component by its combinations of joint values; return [] if there are too many, or if no parts differ.

    Parts may differ in their kind or in what their configurations look like.
    """
    combinations = component.list_value_combinations()
    may_differ = " or " in classification.meaning or (classification.kind and not classification.is_uniform)
    if not may_differ or not 1 < len(combinations) <= _MAX_VALUE_COMBINATIONS:
        return []
    return [(values, component.restrict_to(values)) for values in combinations]


@lru_cache(maxsize=4096)
def classify_conditions(chain: Chain, conditions: tuple[str, ...]) -> Classification:
    """Classify the configurations at which any of several conditions (text) holds."""
    meaning = describe_appearance(chain, sample_representatives(chain, conditions))
    return Classification(*_establish_kind(chain, conditions), meaning)


@lru_cache(maxsize=4096)
def _establish_kind(chain: Chain, conditions: tuple[str, ...]) -> tuple[str, bool]:
    """Return `kind` and `is_uniform` of the classification of conditions."""
    kinds = set[str]()
    if can_establish_kind(chain):
        kinds.update(classify_samples(chain, sample_representatives(chain, conditions)[::_KIND_STRIDE]))
    if len(kinds) == 1 and chain.parameters:  # for other lengths the kind may differ
        samples = (sample_condition(chain, text, "lengths", _EXTRA_LENGTH_SAMPLES, 1) for text in conditions)
        kinds.update(classify_samples(chain, list(chain_together(*samples))))
    return "boundary" if "boundary" in kinds else "internal" if kinds else "", len(kinds) == 1


@lru_cache(maxsize=256)
def is_one_sided(chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> bool:
    """Return whether each configuration at a condition, or at joint values, loses one direction and is one-sided.

    A one-sided configuration allows motions to one side of the lost direction only, to second order.
    """
    text = f"{condition} = 0" if condition is not None else " and ".join(f"{q} = {value}" for q, value in values)
    return are_one_sided(chain, sample_condition(chain, text, "sides"))


def sample_representatives(chain: Chain, conditions: Sequence[str]) -> list[Sample]:
    """Return enough configurations at conditions (text) to generalize from them."""
    # the kind and the meaning may depend on which symbolic length is larger
    length_count = max(_MIN_LENGTH_COUNT, len(chain.parameters)) if chain.parameters else 1
    arm_count = _ARMS_PER_LENGTH * length_count
    samples_per_arm = math.ceil(_SAMPLE_COUNT / (arm_count * len(conditions)))
    samples_of_each = (sample_condition(chain, text, "seen", arm_count, samples_per_arm) for text in conditions)
    samples = list(chain_together(*samples_of_each))
    return samples[:: max(1, len(samples) // _SAMPLE_COUNT)]
