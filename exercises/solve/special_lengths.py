"""Find singular configurations that exist, or change their kind, only for special relations between lengths.

Results for symbolic lengths hold for generic lengths. For example, a planar arm of two links that is folded back is at
the boundary of its workspace, but not if the links are equally long. Three kinds of relations are examined: a length at
which a condition begins to have solutions, a length equal to another one, and a length that is the sum of two others.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import Kind
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.existence_conditions import Need, need_of
from qdot.exercises.arm.lengths import with_lengths
from qdot.exercises.arm.numeric_rank_check import ways_covering
from qdot.exercises.arm.reciprocal import applies
from qdot.exercises.arm.singularity_kinds import kind_is_sure
from qdot.exercises.solve.certified_singularities import certified_components
from qdot.exercises.solve.redundant import Redundant, redundant_stages
from qdot.exercises.writing.solution_steps import SingularComponent

MOST = 8
"""Maximum number of relations that are examined."""


@dataclass(frozen=True)
class Special:
    """What differs if a length has a certain value: the components that are new, or have a different kind."""

    length: sp.Symbol
    value: sp.Expr
    chain: Chain
    components: tuple[SingularComponent, ...]

    @property
    def relation(self) -> str:
        """The relation as text, as in a1 = a2."""
        return f"{self.length} = {self.value}"


def length_needs(chain: Chain, general: tuple[SingularComponent, ...]) -> list[Need]:
    """Return what the symbolic lengths must satisfy so that the conditions of a singular set have solutions."""
    candidates = (need_of(condition, chain) for component in general for condition in component.conditions)
    return [need for need in candidates if need is not None]


def _slides(chain: Chain) -> set[sp.Symbol]:
    return {q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "P"}


def _threshold_relation(need: Need) -> tuple[sp.Symbol, sp.Expr] | None:
    """Return a length and its value at which a condition begins to have solutions; None if none can be isolated."""
    for term in sp.Add.make_args(need.least):
        if term.is_Symbol and term not in (need.most + need.least - term).free_symbols:
            return term, need.most - (need.least - term)
    return None


def relations(chain: Chain, general: tuple[SingularComponent, ...] = ()) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the relations to examine: pairs of a symbolic length in the task Jacobian and its value.

    >>> from qdot.exercises.arm.chain import Joint
    >>> rows = [Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)]
    >>> relations(Chain("two", tuple(rows), ("vx", "vy")))
    [(a1, a2)]
    """
    rows = [value for joint in chain.joints for value in (joint.a, joint.d if joint.kind == "R" else sp.S.Zero)]
    sizes = [-value if value.as_coeff_Mul()[0].is_negative else value for value in (*rows, *chain.point.offset)]
    lengths = list(dict.fromkeys(size for size in sizes if size != 0 and (size.is_Symbol or size.is_number)))
    jacobian_symbols = derive(chain).jacobian.free_symbols
    fixed = [size for size in lengths if size.is_number]
    symbolic = [size for size in lengths if size.is_Symbol and size in jacobian_symbols]
    equal = [*combinations(symbolic, 2), *((length, value) for length in symbolic for value in fixed)]
    sums = [
        (length, first + second)
        for length in symbolic
        for first, second in combinations([size for size in (*symbolic, *fixed) if size != length], 2)
        if first.is_Symbol or second.is_Symbol
    ]
    thresholds = [
        relation for need in length_needs(chain, general) if (relation := _threshold_relation(need)) is not None
    ]
    return list(dict.fromkeys([*thresholds, *equal, *sums]))[:MOST]


def special_lengths(chain: Chain, general: tuple[SingularComponent, ...]) -> Iterator[str | Special]:
    """Yield descriptions of the next step, and each special length whose singular set differs from the generic one."""
    for length, value in relations(chain, general):
        yield f"whether anything differs where {length} = {value}"
        special_chain = with_lengths(chain, {length: value})
        known_components = [_substitute_lengths(component, {length: value}) for component in general]
        try:
            components = _components(special_chain)
        except TooLong:
            continue
        new_components = tuple(
            component for component in components if not _is_known(component, known_components, special_chain)
        )
        if new_components:
            yield Special(length, value, special_chain, new_components)


def _components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the singular set of an arm, by elimination if that applies, else by minors. Raises TooLong."""
    if not applies(chain):
        return certified_components(chain)
    *_, last = redundant_stages(chain)
    assert isinstance(last, Redundant)
    return last.components


def _is_known(component: SingularComponent, known: list[SingularComponent], there: Chain) -> bool:
    """Return whether a component for special lengths is already known from the generic singular set.

    Elimination may state the same component by different conditions; then sampled configurations are compared.
    """
    conditions = _conditions(component, there)
    if any(conditions == _conditions(earlier, there) and _adds_nothing(component, earlier, there) for earlier in known):
        return True
    if not applies(there):
        return False
    numbers = ways_covering(there, component.conditions, [earlier.conditions for earlier in known])
    return numbers is not None and all(_adds_nothing(component, known[number], there) for number in numbers)


def _adds_nothing(component: SingularComponent, general: SingularComponent, chain: Chain) -> bool:
    """Return whether a component has the same kind as the generic one; a generic one of mixed kind agrees with any."""
    if not kind_is_sure(chain):
        return True
    for values, kind in _kinds(component, chain).items():
        general_kinds = [
            general_kind
            for general_values, general_kind in _kinds(general, chain).items()
            if values in (general_values, ()) or general_values == ()
        ]
        agreeing_kinds = [
            general_kind
            for general_kind in general_kinds
            if not general_kind.uniform or replace(general_kind, meaning=kind.meaning) == kind
        ]
        if not general_kinds or agreeing_kinds != general_kinds:
            return False
    return True


def _kinds(component: SingularComponent, chain: Chain) -> dict[tuple[str, ...], Kind]:
    """Return the kind of a component for each of its joint values if these are distinguished, else for all of it."""
    revolute = {q.name for q in chain.q} - {prismatic.name for prismatic in _slides(chain)}
    if not component.cases:
        return {(): component.kind}
    return {
        tuple(str(_normalize_angle(value) if joint.name in revolute else value) for joint, value in joint_values): kind
        for joint_values, kind in component.cases
    }


def _substitute_lengths(component: SingularComponent, values: dict[sp.Symbol, sp.Expr]) -> SingularComponent:
    cases = tuple(
        (tuple((joint, value.xreplace(values)) for joint, value in joint_values), kind)
        for joint_values, kind in component.cases
    )
    return replace(
        component, conditions=tuple(condition.xreplace(values) for condition in component.conditions), cases=cases
    )


def _conditions(component: SingularComponent, chain: Chain) -> frozenset[sp.Expr]:
    """Return the conditions of a component without constant factors."""
    return frozenset(_normalize_condition(condition, chain) for condition in component.conditions)


def _normalize_angle(angle: sp.Expr) -> sp.Expr:
    """Return the equivalent angle in [0, 2 pi): -135 degrees becomes 225."""
    return angle % (2 * sp.pi) if angle.is_number else angle


def _normalize_condition(condition: sp.Expr, chain: Chain) -> sp.Expr:
    """Return a condition without the numbers, lengths and signs that all its terms have in common."""
    factors = sp.Mul.make_args(sp.factor_terms(sp.expand(condition)))
    plain = sp.expand(sp.Mul(*(factor for factor in factors if factor.free_symbols & set(chain.q))))
    _, plain = plain.as_content_primitive()
    return min(plain, -plain, key=sp.default_sort_key)
