"""What singular sets are: of which kind, whether all of each is, and what its configurations look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.appearance import meaning
from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.kinds import are_one_sided, kind_is_sure, kinds_at
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import are_unrelated, with_open_lengths
from qdot.exercises.arm.normalized_arm import bare, bare_pieces
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.identity import Domain
from qdot.exercises.formula.pieces import Piece, pieces

_LOOKED_AT = 60
"""About how many samples are looked at to say what they have in common: few may all miss where it is not so."""
_KIND_AT = 2
"""Of how many of these one is asked for its kind, which takes longer."""
_PARTS = 3
"""In how many parts these are looked at."""
_FURTHER = 60
"""Further choices of open lengths of which the kind is looked at, before it is told of all."""
_ARMS = 5
"""Choices of lengths for each length that is open."""
_LEAST_ARMS = 3
"""As many as for so many open lengths are there of fewer."""

_MOST_VALUES = 4
"""Of more combinations of joint values nobody wants to read one after the other."""

_ARM = "number of the arm"
"""The name under which a configuration says whose it is."""


@dataclass(frozen=True)
class Kind:
    """What a set of singular configurations is: kind, whether all of it is of that kind, and what it looks like.

    The kind is empty where it can't be established (`kind_is_sure`), or no configuration was found of which it is
    known, so that it is told nowhere.
    """

    kind: str
    uniform: bool
    meaning: str


def domain_of(chain: Chain, values: Mapping[str, float | np.ndarray] | None = None, slides: str = "signed") -> Domain:
    """Return the domain of a chain's symbols: joints, rates, task velocity, open lengths, and given values.

    `slides` is the role of slides: "signed", where answers are compared, or "travel", as far as any arm reaches.
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
    """Return configurations at which `condition` (text) holds, for several choices of the open lengths."""
    return list(_samples(chain, condition, seed, arms, each))


@lru_cache(maxsize=64)
def _samples(chain: Chain, condition: str, seed: str, arms: int, each: int) -> tuple[Sample, ...]:
    """Return the same, kept: a component is looked at whole and then value by value, which are the same conditions."""
    found: list[list[Sample]] = [[] for _ in range(arms)]
    slides = any(joint.kind == "P" for joint in chain.joints)
    # far out, an arm may be at the boundary where it is not with its slides drawn in
    for first, role in ((0, "signed"), (1, "travel")) if slides else ((0, "signed"),):
        stream = Stream(f"{seed}/{condition}/{first}")
        numbers = range(first, arms, 2 if slides else 1)
        values = [_apart(chain, stream) for _ in numbers]
        for piece in pieces(read(condition), [q.name for q in chain.q]) if values else ():
            for number, samples in zip(numbers, _configurations(chain, piece, values, role, stream, each), strict=True):
                found[number] += samples
    return tuple(sample for samples in found for sample in samples)


def _apart(chain: Chain, stream: Stream) -> dict[str, float]:
    """Draw lengths for those left open, none near another or a given one: equal lengths are a special case."""
    given = [joint.a for joint in chain.joints] + [j.d for j in chain.joints if j.kind == "R"]
    taken = [abs(float(length)) for length in given if length.is_number]
    values = {}
    for symbol in chain.parameters:
        drawn = [round(0.4 * 3.5 ** stream.uniform(0, 1), 3) for _ in range(5)]
        value = next((v for v in drawn if all(abs(v - other) > 0.01 for other in taken)), drawn[-1])
        values[symbol.name] = value
        taken.append(value)
    return values


def _configurations(
    chain: Chain, piece: Piece, values: Sequence[Mapping[str, float]], role: str, stream: Stream, each: int
) -> list[list[Sample]]:
    """Return up to so many configurations of each of some arms, told by their open lengths; worked out all at once."""
    joints, lengths = [q.name for q in chain.q], [symbol.name for symbol in chain.parameters]
    count = 3 * each
    roles = {name: np.repeat([value[name] for value in values], count) for name in lengths}
    space = Space(joints, domain_of(chain, {**roles, _ARM: np.repeat(np.arange(len(values)), count)}, role))
    there = space.on_piece(piece, {*space.names_of([[piece]]), _ARM}, stream, count=count * len(values))
    columns = np.array([there[joint] for joint in joints]).T
    found = []
    for number, value in enumerate(values):
        arm = NumericChain(chain, value)
        found.append([Sample(arm, q) for q in columns[there[_ARM] == number][:each]])
    return found


def classify(chain: Chain, component: Component) -> Kind:
    """Classify a component of the singular set over samples of its configurations and of the open lengths.

    Where some configurations are boundary and some internal, `kind` is "boundary" and `uniform` is False. It is
    established for the structure, for all lengths at once; where that gives several answers, for the bare arm, once for
    all arms that have the same.
    """
    arm, conditions = bare(chain), tuple(bare_pieces(chain, component))
    general, known = in_general(chain)
    if all(condition in known for condition in conditions):
        kind = _whatever_the_lengths(general, tuple(known[condition] for condition in conditions))
        if kind is not None:
            return kind if kind.uniform or not kind.kind else replace(kind, **_kind_of(arm, conditions))
    return _classified(arm, conditions)


@lru_cache(maxsize=1024)
def in_general(chain: Chain) -> tuple[Chain, Mapping[str, str]]:
    """Return the bare arm with open lengths in place of given ones, and each condition on it that it has in common with
    the arm's own, as text, under the text of that one; none where the given lengths are special.
    """
    general, given = with_open_lengths(chain)
    counted = [value for symbol, value in given.items() if symbol in bare(general).parameters]
    found = {}
    for component in singular_set(general) or () if counted and are_unrelated(counted) else ():
        for part in _parts(component):
            (piece,) = bare_pieces(general, part)
            (own,) = bare_pieces(bare(chain), _filled(part, given))
            found[own] = piece
    return bare(general), found


def _parts(component: Component) -> list[Component]:
    """Return what a component is at each combination of values of joints; itself, if they are not told."""
    if component.solutions is None:
        return [component]
    joints, values = zip(*component.solutions, strict=True)
    return [part_at(component, tuple(zip(joints, each, strict=True))) for each in product(*values)]


def _filled(component: Component, lengths: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with numbers for lengths."""
    conditions = tuple(substitute(condition, lengths) for condition in component.conditions)
    if component.solutions is None:
        return Component(conditions, None)
    solutions = ((q, tuple(substitute(value, lengths) for value in values)) for q, values in component.solutions)
    return Component(conditions, tuple(solutions))


@lru_cache(maxsize=4096)
def _whatever_the_lengths(chain: Chain, conditions: tuple[str, ...]) -> Kind | None:
    """Return what conditions are for all lengths, where each of them looks like one thing; else None."""
    kind = _classified(chain, conditions)
    if len(conditions) > 1:
        return kind if all(_whatever_the_lengths(chain, (condition,)) for condition in conditions) else None
    return None if " or " in kind.meaning else kind


Values = tuple[tuple[sp.Symbol, sp.Expr], ...]
"""Joints with their values."""


def by_value(component: Component, kind: Kind) -> list[tuple[Values, Component]]:
    """Return a component's values of its joints, each with the part that it is, where more is to be said than of all.

    That is where it looks like this or like that, or is of both kinds.
    """
    if component.solutions is None or not (" or " in kind.meaning or (kind.kind and not kind.uniform)):
        return []
    joints, values = zip(*component.solutions, strict=True)
    chosen = [tuple(zip(joints, each, strict=True)) for each in product(*values)]
    if not 1 < len(chosen) <= _MOST_VALUES:
        return []
    return [(each, part_at(component, each)) for each in chosen]


def part_at(component: Component, values: Values) -> Component:
    """Return the part of a component at which joints have these values."""
    return replace(component, solutions=tuple((joint, (value,)) for joint, value in values))


def classify_pieces(chain: Chain, conditions: Sequence[str]) -> Kind:
    """Classify the union of conditions (text), as `classify` does for a component."""
    return _classified(chain, tuple(conditions))


@lru_cache(maxsize=4096)
def _classified(chain: Chain, conditions: tuple[str, ...]) -> Kind:
    return Kind(**_kind_of(chain, conditions), meaning=meaning(chain, seen_on(chain, conditions)))


@lru_cache(maxsize=4096)
def _kind_of(chain: Chain, conditions: tuple[str, ...]) -> Mapping[str, Any]:
    """Return `kind` and `uniform` of conditions; as soon as both kinds are seen, nothing more can be."""
    kinds: set[str] = set()
    if kind_is_sure(chain):
        seen = seen_on(chain, conditions)[::_KIND_AT]
        kinds = _kinds_among(chain, [seen[first::_PARTS] for first in range(_PARTS)])
    if len(kinds) == 1 and chain.parameters:  # of other lengths it may be another
        others = [one for condition in conditions for one in samples_on(chain, condition, "lengths", _FURTHER, 1)]
        kinds |= _kinds_among(chain, [others])
    return {"kind": "boundary" if "boundary" in kinds else "internal" if kinds else "", "uniform": len(kinds) == 1}


def _kinds_among(chain: Chain, parts: Sequence[Sequence[Sample]]) -> set[str]:
    """Return the kinds of configurations, part by part until there are two."""
    found: set[str] = set()
    for samples in parts:
        if len(found) < 2:
            found |= {kind for kind in kinds_at(chain, samples) if kind is not None}
    return found


@lru_cache(maxsize=256)
def is_one_sided(chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> bool:
    """Tell whether configurations lose one direction, to one side of it only: where a condition holds, or at values."""
    text = f"{condition} = 0" if condition is not None else " and ".join(f"{q} = {value}" for q, value in values)
    return are_one_sided(chain, samples_on(chain, text, "sides"))


def seen_on(chain: Chain, conditions: Sequence[str]) -> list[Sample]:
    """Return configurations on conditions (text), enough to say of all what is so of these."""
    # what is so may depend on how open lengths compare
    arms = _ARMS * max(_LEAST_ARMS, len(chain.parameters)) if chain.parameters else _ARMS
    each = -(-_LOOKED_AT // (arms * len(conditions)))
    samples = [sample for condition in conditions for sample in samples_on(chain, condition, "seen", arms, each)]
    return samples[:: max(1, len(samples) // _LOOKED_AT)]
