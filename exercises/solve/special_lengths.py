"""Find singular configurations that exist, or change their kind, only for special relations between lengths.

Results for symbolic lengths hold for generic lengths. For example, a planar arm of two links that is folded back is at
the boundary of its workspace, but not if the links are equally long. Three kinds of relations are examined: a length at
which a condition begins to have solutions, a length equal to another one, and a length that is the sum of two others.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.lengths import substitute_arm_lengths
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.existence_conditions import ExistenceCondition, existence_condition
from qdot.exercises.singularities.numeric_rank_check import find_covering_branches
from qdot.exercises.singularities.reciprocal import elimination_applies
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certified_components
from qdot.exercises.solve.redundant import RedundantSingularities, redundant_stages
from qdot.exercises.writing.solution_steps import SingularComponent

MAX_RELATIONS = 8
"""Maximum number of relations that are examined."""


@dataclass(frozen=True)
class SpecialLength:
    """What differs if a length has a certain value: the components that are new, or have a different kind."""

    length: sp.Symbol
    value: sp.Expr
    chain: Chain
    components: tuple[SingularComponent, ...]

    @property
    def relation(self) -> str:
        """The relation as text, as in a1 = a2."""
        return f"{self.length} = {self.value}"


def length_requirements(chain: Chain, generic_components: tuple[SingularComponent, ...]) -> list[ExistenceCondition]:
    """Return what the symbolic lengths must satisfy so that the conditions of a singular set have solutions."""
    conditions = (condition for component in generic_components for condition in component.conditions)
    return [need for condition in conditions if (need := existence_condition(condition, chain)) is not None]


def _threshold_relation(need: ExistenceCondition) -> tuple[sp.Symbol, sp.Expr] | None:
    """Return a length and its value at which a condition begins to have solutions; None if none can be isolated."""
    for term in sp.Add.make_args(need.smaller):
        if term.is_Symbol and term not in (need.larger + need.smaller - term).free_symbols:
            return term, need.larger - (need.smaller - term)
    return None


def length_relations(
    chain: Chain, generic_components: tuple[SingularComponent, ...] = ()
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the relations to examine: pairs of a symbolic length in the task Jacobian and its value.

    >>> from qdot.exercises.arm.chain import Joint
    >>> rows = [Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)]
    >>> length_relations(Chain("two", tuple(rows), ("vx", "vy")))
    [(a1, a2)]
    """
    rows = [value for joint in chain.joints for value in (joint.a, joint.d if joint.kind == "R" else sp.S.Zero)]
    sizes = [-value if value.as_coeff_Mul()[0].is_negative else value for value in (*rows, *chain.point.offset)]
    lengths = list(dict.fromkeys(size for size in sizes if size != 0 and (size.is_Symbol or size.is_number)))
    jacobian_symbols = derive(chain).jacobian.free_symbols
    fixed = [size for size in lengths if size.is_number]
    symbolic = [size for size in lengths if size.is_Symbol and size in jacobian_symbols]
    equal = [*combinations(symbolic, 2), *product(symbolic, fixed)]
    pairs = (pair for pair in combinations((*symbolic, *fixed), 2) if not all(size.is_number for size in pair))
    sums = [(length, sp.Add(*pair)) for length, pair in product(symbolic, pairs) if length not in pair]
    needs = length_requirements(chain, generic_components)
    thresholds = [relation for need in needs if (relation := _threshold_relation(need)) is not None]
    return list(dict.fromkeys([*thresholds, *equal, *sums]))[:MAX_RELATIONS]


def find_special_lengths(
    chain: Chain, generic_components: tuple[SingularComponent, ...]
) -> Iterator[str | SpecialLength]:
    """Yield descriptions of the next step, and each special length whose singular set differs from the generic one."""
    for length, value in length_relations(chain, generic_components):
        yield f"whether {length} = {value} is special"
        special_chain = substitute_arm_lengths(chain, {length: value})
        known_components = [_substitute_lengths(component, {length: value}) for component in generic_components]
        try:
            components = _find_components(special_chain)
        except TooLong:
            continue
        new_components = [c for c in components if not _is_known(c, known_components, special_chain)]
        if new_components:
            yield SpecialLength(length, value, special_chain, tuple(new_components))


def _find_components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the singular set of an arm, by elimination if that applies, else by minors. Raises TooLong."""
    if not elimination_applies(chain):
        return certified_components(chain)
    *_, last = redundant_stages(chain)
    assert isinstance(last, RedundantSingularities)
    return last.components


def _is_known(component: SingularComponent, known_components: list[SingularComponent], special_chain: Chain) -> bool:
    """Return whether a component for special lengths is already known from the generic singular set.

    Elimination may state the same component by different conditions; then sampled configurations are compared.
    """
    conditions = _normalize_conditions(component, special_chain)
    same = [known for known in known_components if _normalize_conditions(known, special_chain) == conditions]
    if any(_has_generic_kind(component, known, special_chain) for known in same):
        return True
    if not elimination_applies(special_chain):
        return False
    branches = [known.conditions for known in known_components]
    covering = find_covering_branches(special_chain, component.conditions, branches) or ()
    return bool(covering) and all(_has_generic_kind(component, known_components[k], special_chain) for k in covering)


def _has_generic_kind(component: SingularComponent, generic_component: SingularComponent, chain: Chain) -> bool:
    """Return whether a component has the same kind as the generic one; a generic one of mixed kind agrees with any."""
    if not can_establish_kind(chain):
        return True
    for values, kind in _kinds(component, chain).items():
        pairs = _kinds(generic_component, chain).items()
        generic_kinds = [generic for at, generic in pairs if values in (at, ()) or at == ()]
        agrees = [not generic.uniform or replace(generic, meaning=kind.meaning) == kind for generic in generic_kinds]
        if not agrees or not all(agrees):
            return False
    return True


def _kinds(component: SingularComponent, chain: Chain) -> dict[tuple[str, ...], Classification]:
    """Return the kind of a component for each of its joint values if these are distinguished, else for all of it."""
    revolute = {q.name for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"}
    if not component.cases:
        return {(): component.kind}
    return {
        tuple(str(_normalize_angle(value) if joint.name in revolute else value) for joint, value in joint_values): kind
        for joint_values, kind in component.cases
    }


def _substitute_lengths(component: SingularComponent, values: dict[sp.Symbol, sp.Expr]) -> SingularComponent:
    cases = (
        (tuple((joint, value.xreplace(values)) for joint, value in joint_values), kind)
        for joint_values, kind in component.cases
    )
    conditions = (condition.xreplace(values) for condition in component.conditions)
    return replace(component, conditions=tuple(conditions), cases=tuple(cases))


def _normalize_conditions(component: SingularComponent, chain: Chain) -> frozenset[sp.Expr]:
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
