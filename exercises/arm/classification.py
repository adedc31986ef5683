"""Classify singular sets: their kind, whether all of each is of that kind, and what its configurations look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.appearance import meaning
from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import are_unrelated, with_open_lengths
from qdot.exercises.arm.normalized_arm import normalize_arm, normalized_pieces
from qdot.exercises.arm.singularity import Component, Values, singular_set
from qdot.exercises.arm.singularity_kinds import are_one_sided, kind_is_sure, kinds_at
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space
from qdot.exercises.formula.identity import Domain
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.set_parser import Piece, parse_pieces

_LOOKED_AT = 60
"""Approximate number of samples that are examined together; fewer might all miss an exception."""
_KIND_AT = 2
"""Every which of these samples is tested for its kind, which takes longer."""
_FURTHER = 60
"""Number of further choices of symbolic lengths that are tested before a kind is reported for all lengths."""
_ARMS = 5
"""Number of choices of lengths for each symbolic length."""
_LEAST_ARMS = 3
"""The minimum number of symbolic lengths that is assumed."""

_MOST_VALUES = 4
"""Maximum number of combinations of joint values that are listed separately."""

_ARM = "number of the arm"
"""The key that says to which arm a configuration belongs."""


@dataclass(frozen=True)
class Kind:
    """What a set of singular configurations is: its kind, whether all of it is of that kind, and what it looks like.

    The kind is empty, and reported nowhere, if it can't be established (`kind_is_sure`) or is known of no configuration
    that was found.
    """

    kind: str
    uniform: bool
    meaning: str


def domain_of(chain: Chain, values: Mapping[str, float | np.ndarray] | None = None, slides: str = "signed") -> Domain:
    """Return the domain of a chain's symbols: joints, rates, task velocity, open lengths, and fixed values.

    `slides` is the role of prismatic joints: "signed" to compare answers, or "travel", as far as any arm reaches.
    """
    roles: dict[str, str | float | np.ndarray] = {}
    for joint, q, rate in zip(chain.joints, chain.q, chain.rates, strict=True):
        roles[q.name] = "angle" if joint.kind == "R" else slides
        roles[rate.name] = "signed"
    roles.update(dict.fromkeys(TASK_ROWS, "signed"))
    for symbol in chain.parameters:
        roles[symbol.name] = "angle" if symbol.name.startswith(("alpha", "beta")) else "length"
    return Domain({**roles, **(values or {})})


def samples_on(chain: Chain, condition: str, seed: str, arms: int = 5, each: int = 3) -> list[Sample]:
    """Return configurations at which `condition` (text) holds, for several choices of the symbolic lengths."""
    return list(_samples(chain, condition, seed, arms, each))


@lru_cache(maxsize=64)
def _samples(chain: Chain, condition: str, seed: str, arms: int, each: int) -> tuple[Sample, ...]:
    """Return the same, cached: a component is examined as a whole and then value by value, with the same conditions."""
    samples_by_arm: list[list[Sample]] = [[] for _ in range(arms)]
    slides = any(joint.kind == "P" for joint in chain.joints)
    # with its prismatic joints extended, an arm may be at the boundary where it is not with them retracted
    for first, role in ((0, "signed"), (1, "travel")) if slides else ((0, "signed"),):
        stream = Stream(f"{seed}/{condition}/{first}")
        numbers = range(first, arms, 2 if slides else 1)
        values = [_sample_distinct_lengths(chain, stream) for _ in numbers]
        for piece in parse_pieces(read(condition), [q.name for q in chain.q]) if values else ():
            for number, samples in zip(numbers, _configurations(chain, piece, values, role, stream, each), strict=True):
                samples_by_arm[number] += samples
    return tuple(sample for samples in samples_by_arm for sample in samples)


def _sample_distinct_lengths(chain: Chain, stream: Stream) -> dict[str, float]:
    """Sample open lengths, none close to another or to a fixed one: equal lengths are a special case."""
    fixed_lengths = [joint.a for joint in chain.joints] + [j.d for j in chain.joints if j.kind == "R"]
    taken = [abs(float(length)) for length in fixed_lengths if length.is_number]
    values = {}
    for symbol in chain.parameters:
        candidates = [round(0.4 * 3.5 ** stream.uniform(0, 1), 3) for _ in range(5)]
        value = next((v for v in candidates if all(abs(v - length) > 0.01 for length in taken)), candidates[-1])
        values[symbol.name] = value
        taken.append(value)
    return values


def _configurations(
    chain: Chain, piece: Piece, values: Sequence[Mapping[str, float]], role: str, stream: Stream, each: int
) -> list[list[Sample]]:
    """Return up to `each` configurations of each arm, given by its open lengths; computed all at once."""
    joints, lengths = [q.name for q in chain.q], [symbol.name for symbol in chain.parameters]
    count = 3 * each
    roles = {name: np.repeat([value[name] for value in values], count) for name in lengths}
    space = Space(joints, domain_of(chain, {**roles, _ARM: np.repeat(np.arange(len(values)), count)}, role))
    there = space.on_piece(piece, {*space.names_of([[piece]]), _ARM}, stream, count=count * len(values))
    columns = np.array([there[joint] for joint in joints]).T
    samples = []
    for number, value in enumerate(values):
        arm = NumericChain(chain, value)
        samples.append([Sample(arm, q) for q in columns[there[_ARM] == number][:each]])
    return samples


def classify(chain: Chain, component: Component) -> Kind:
    """Classify a component of the singular set over samples of its configurations and of the open lengths.

    If some configurations are boundary and some internal, `kind` is "boundary" and `uniform` is False. The kind is
    established for the structure, for all lengths at once; if that gives several answers, for the normalized arm, once
    for all arms that share it.
    """
    arm, conditions = normalize_arm(chain), tuple(normalized_pieces(chain, component))
    general, known = generalize(chain)
    if all(condition in known for condition in conditions):
        kind = _kind_for_all_lengths(general, tuple(known[condition] for condition in conditions))
        if kind is not None:
            return kind if kind.uniform or not kind.kind else replace(kind, **_kind_of(arm, conditions))
    return classify_conditions(arm, conditions)


@lru_cache(maxsize=1024)
def generalize(chain: Chain) -> tuple[Chain, Mapping[str, str]]:
    """Return the normalized arm with all lengths open, and its conditions by those of the arm itself, as text.

    There are no conditions if the arm's lengths are special.
    """
    general, lengths = with_open_lengths(chain)
    counted = [value for symbol, value in lengths.items() if symbol in normalize_arm(general).parameters]
    general_pieces = {}
    for component in singular_set(general) or () if counted and are_unrelated(counted) else ():
        for part in [component.at(values) for values in component.value_combinations()] or [component]:
            (piece,) = normalized_pieces(general, part)
            (arm_piece,) = normalized_pieces(normalize_arm(chain), _substitute_lengths(part, lengths))
            general_pieces[arm_piece] = piece
    return normalize_arm(general), general_pieces


def _substitute_lengths(component: Component, lengths: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with numbers substituted for lengths."""
    conditions = tuple(substitute(condition, lengths) for condition in component.conditions)
    if component.solutions is None:
        return Component(conditions, None)
    solutions = ((q, tuple(substitute(value, lengths) for value in values)) for q, values in component.solutions)
    return Component(conditions, tuple(solutions))


@lru_cache(maxsize=4096)
def _kind_for_all_lengths(chain: Chain, conditions: tuple[str, ...]) -> Kind | None:
    """Return the kind of conditions for all lengths if each of them looks like one thing; else None."""
    kind = classify_conditions(chain, conditions)
    if len(conditions) > 1:
        return kind if all(_kind_for_all_lengths(chain, (condition,)) for condition in conditions) else None
    return None if " or " in kind.meaning else kind


def split_by_value(component: Component, kind: Kind) -> list[tuple[Values, Component]]:
    """Return each combination of a component's joint values with its part, if the parts differ in look or kind."""
    combinations = component.value_combinations()
    if not 1 < len(combinations) <= _MOST_VALUES or not (" or " in kind.meaning or (kind.kind and not kind.uniform)):
        return []
    return [(values, component.at(values)) for values in combinations]


@lru_cache(maxsize=4096)
def classify_conditions(chain: Chain, conditions: tuple[str, ...]) -> Kind:
    """Classify the union of conditions (text), as `classify` does for a component."""
    return Kind(**_kind_of(chain, conditions), meaning=meaning(chain, representative_samples(chain, conditions)))


@lru_cache(maxsize=4096)
def _kind_of(chain: Chain, conditions: tuple[str, ...]) -> Mapping[str, Any]:
    """Return `kind` and `uniform` of conditions."""
    kinds = set[str]()
    if kind_is_sure(chain):
        kinds.update(kinds_at(chain, representative_samples(chain, conditions)[::_KIND_AT]))
    if len(kinds) == 1 and chain.parameters:  # of other lengths it may be another
        others = [sample for condition in conditions for sample in samples_on(chain, condition, "lengths", _FURTHER, 1)]
        kinds.update(kinds_at(chain, others))
    return {"kind": "boundary" if "boundary" in kinds else "internal" if kinds else "", "uniform": len(kinds) == 1}


@lru_cache(maxsize=256)
def is_one_sided(chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> bool:
    """Return whether configurations on a condition or at values can't move to one side of the one lost direction."""
    text = f"{condition} = 0" if condition is not None else " and ".join(f"{q} = {value}" for q, value in values)
    return are_one_sided(chain, samples_on(chain, text, "sides"))


def representative_samples(chain: Chain, conditions: Sequence[str]) -> list[Sample]:
    """Return configurations on conditions (text), enough to generalize from these to all."""
    # what holds may depend on how the open lengths compare
    arms = _ARMS * max(_LEAST_ARMS, len(chain.parameters)) if chain.parameters else _ARMS
    each = -(-_LOOKED_AT // (arms * len(conditions)))
    samples = [sample for condition in conditions for sample in samples_on(chain, condition, "seen", arms, each)]
    return samples[:: max(1, len(samples) // _LOOKED_AT)]
