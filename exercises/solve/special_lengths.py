"""Find singular configurations that exist, or change their kind, only for special relations between lengths.

Results for symbolic lengths hold for *generic* lengths: all lengths except those that satisfy a special relation. For
example, a planar arm of two links is at the boundary of its workspace if it is folded back. That is not so if the links
are equally long. Three kinds of relations are examined: a length at which a condition begins to have solutions, a
length equal to another length, and a length that is the sum of two others.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.lengths import substitute_arm_lengths
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.existence_conditions import ExistenceCondition, find_existence_condition
from qdot.exercises.singularities.numeric_rank_check import find_covering_branches
from qdot.exercises.singularities.reciprocal import elimination_applies
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certify_components
from qdot.exercises.solve.redundant import RedundantSingularities, generate_redundant_events
from qdot.exercises.writing.solution_steps import SingularComponent

MAX_RELATIONS = 8
"""Maximum number of relations that are examined."""


@dataclass(frozen=True)
class SpecialLength:
    """A special length.

    - `length`, `value`: the symbolic length, and its special value.
    - `chain`: the arm with this value.
    - `components`: the components of its singular set that do not exist for generic lengths, or have another kind.
    """

    length: sp.Symbol
    value: sp.Expr
    chain: Chain
    components: tuple[SingularComponent, ...]

    @property
    def relation(self) -> str:
        """The relation as text, such as a1 = a2."""
        return f"{self.length} = {self.value}"


def find_length_requirements(
    chain: Chain, generic_components: tuple[SingularComponent, ...]
) -> list[ExistenceCondition]:
    """Return what the symbolic lengths must satisfy so that the conditions of a singular set have solutions."""
    conditions = (condition for component in generic_components for condition in component.conditions)
    return list(filter(None, (find_existence_condition(condition, chain) for condition in conditions)))


def _find_threshold_relations(requirements: Iterable[ExistenceCondition]) -> Iterator[tuple[sp.Symbol, sp.Expr]]:
    """Yield for each requirement a length, and its value at which a condition begins to have solutions."""
    for requirement in requirements:
        for term in sp.Add.make_args(requirement.smaller):
            if term.is_Symbol and term not in (requirement.larger + requirement.smaller - term).free_symbols:
                yield term, requirement.larger - (requirement.smaller - term)
                break


def list_length_relations(
    chain: Chain, generic_components: tuple[SingularComponent, ...] = ()
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the relations to examine, as pairs of a symbolic length in the task Jacobian and its special value.

    >>> from qdot.exercises.arm.chain import Joint
    >>> rows = [Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)]
    >>> list_length_relations(Chain("two", tuple(rows), ("vx", "vy")))
    [(a1, a2)]
    """
    entries = [value for joint in chain.joints for value in (joint.a, joint.d if joint.is_revolute else sp.S.Zero)]
    sizes = [-value if value.as_coeff_Mul()[0].is_negative else value for value in (*entries, *chain.point.offset)]
    lengths = list(dict.fromkeys(size for size in sizes if size != 0 and (size.is_Symbol or size.is_number)))
    jacobian_symbols = derive(chain).jacobian.free_symbols
    numbers = [size for size in lengths if size.is_number]
    symbols = [size for size in lengths if size.is_Symbol and size in jacobian_symbols]
    equalities = [*combinations(symbols, 2), *product(symbols, numbers)]
    pairs = (pair for pair in combinations((*symbols, *numbers), 2) if not all(size.is_number for size in pair))
    sums = [(length, sp.Add(*pair)) for length, pair in product(symbols, pairs) if length not in pair]
    thresholds = _find_threshold_relations(find_length_requirements(chain, generic_components))
    return list(dict.fromkeys([*thresholds, *equalities, *sums]))[:MAX_RELATIONS]


def find_special_lengths(
    chain: Chain, generic_components: tuple[SingularComponent, ...]
) -> Iterator[str | SpecialLength]:
    """Yield descriptions of the next step, and each length for whose special value the singular set differs."""
    for length, value in list_length_relations(chain, generic_components):
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
        return certify_components(chain)
    *_, singularities = generate_redundant_events(chain)
    assert isinstance(singularities, RedundantSingularities)
    return singularities.components


def _is_known(component: SingularComponent, known_components: list[SingularComponent], special_chain: Chain) -> bool:
    """Return whether a component for special lengths is one of the known components for generic lengths.

    Elimination may state the same component by different conditions; then sampled configurations are compared.
    """

    def normalize(singular_component: SingularComponent) -> frozenset[sp.Expr]:
        return frozenset(_normalize_condition(condition, special_chain) for condition in singular_component.conditions)

    same_components = [c for c in known_components if normalize(c) == normalize(component)]
    if any(_has_generic_kind(component, known_component, special_chain) for known_component in same_components):
        return True
    if not elimination_applies(special_chain):
        return False
    branches = [known_component.conditions for known_component in known_components]
    indices = find_covering_branches(special_chain, component.conditions, branches) or ()
    return bool(indices) and all(_has_generic_kind(component, known_components[k], special_chain) for k in indices)


def _has_generic_kind(component: SingularComponent, generic_component: SingularComponent, chain: Chain) -> bool:
    """Return whether a component has the same kind as the component for generic lengths.

    A component for generic lengths that is boundary in part and internal in part agrees with both kinds.
    """
    if not can_establish_kind(chain):
        return True
    generic_cases = _classify_by_values(generic_component, chain).items()
    for values, classification in _classify_by_values(component, chain).items():
        generic_kinds = [generic for v, generic in generic_cases if values in (v, ()) or v == ()]
        if not generic_kinds or any(
            generic.is_uniform and replace(generic, meaning=classification.meaning) != classification
            for generic in generic_kinds
        ):
            return False
    return True


def _classify_by_values(component: SingularComponent, chain: Chain) -> dict[tuple[str, ...], Classification]:
    """Return the classification for each combination of a component's joint values; the key () stands for all."""
    revolute_variables = {chain.q[i].name for i in chain.revolute_joints}

    def normalize(joint: sp.Symbol, value: sp.Expr) -> str:
        """Return a joint value as text; an angle is reduced to [0, 2 pi)."""
        return str(value % (2 * sp.pi) if joint.name in revolute_variables and value.is_number else value)

    cases = component.cases or (((), component.classification),)
    return {tuple(normalize(*pair) for pair in joint_values): classification for joint_values, classification in cases}


def _substitute_lengths(component: SingularComponent, values: dict[sp.Symbol, sp.Expr]) -> SingularComponent:
    """Return a component with values substituted for symbolic lengths."""
    cases = (
        (tuple((joint, value.xreplace(values)) for joint, value in joint_values), classification)
        for joint_values, classification in component.cases
    )
    conditions = (condition.xreplace(values) for condition in component.conditions)
    return replace(component, conditions=tuple(conditions), cases=tuple(cases))


def _normalize_condition(condition: sp.Expr, chain: Chain) -> sp.Expr:
    """Return a condition without the numbers, lengths and signs that all its terms have in common."""
    factors = sp.Mul.make_args(sp.factor_terms(sp.expand(condition)))
    product_with_joints = sp.expand(sp.Mul(*(factor for factor in factors if factor.free_symbols & set(chain.q))))
    _, primitive = product_with_joints.as_content_primitive()
    return min(primitive, -primitive, key=sp.default_sort_key)
