"""Find the singular configurations of a redundant arm for `qdot solve`, by elimination and with a numerical check.

A redundant arm has more joints than its task has rows, such as seven joints for a pose.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import NO_SIMPLE_MEANING
from qdot.exercises.singularities.appearance import find_reason
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.reciprocal import ReciprocalSet, ReducedCase, find_reciprocal_set, make_polynomial_arm
from qdot.exercises.singularities.singular_set import Component, solve_conjunction
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certify_component, certify_statement
from qdot.exercises.solve.numeric_rank_check import RankCheck, check_rank_loss
from qdot.exercises.verify.singularity_statements import all_have_kind
from qdot.exercises.writing.solution_steps import SingularComponent

MAX_SHOWN_OPERATIONS = 700
"""A matrix is shown if its entries have fewer operations than this."""
MAX_READABLE_TERMS = 40
"""Maximum number of terms of an equation that a person would read."""
_MAX_DESCRIBED_SAMPLES = 20
"""Approximate number of samples that serve to describe what the configurations of a component look like."""


@dataclass(frozen=True)
class RemainingMatrix:
    """A matrix that remains after the elimination; its rank decides in some cases whether the arm is singular.

    - `cases`: the conditions of each case in which this matrix remains.
    - `joints`: the joint (counted from 1) of each column; 0 for a column that combines two joints.
    - `minors`: the maximal minors of the matrix, if the only known condition for rank loss is that all are zero; else
      empty.
    """

    cases: tuple[tuple[sp.Expr, ...], ...]
    matrix: sp.ImmutableMatrix
    joints: tuple[int, ...]
    minors: frozenset[sp.Expr]

    @property
    def has_mixed_columns(self) -> bool:
        """Whether any column combines two joints."""
        return 0 in self.joints


RemainingMatrices = tuple[RemainingMatrix, ...]


@dataclass(frozen=True)
class RedundantSingularities:
    """The singular set of a redundant arm.

    - `reciprocal_set`: the result of the elimination.
    - `matrix`: the Jacobian before the elimination, with the arm's numbers.
    - `remaining_matrices`: the matrices that remain after the elimination, with the arm's numbers.
    - `components`: the components of the singular set that the numerical check confirmed.
    - `is_always_singular`: whether every configuration is singular.
    - `check`: the result of the numerical check; None if every configuration is singular.
    - `doubtful_conditions`: conditions that failed the check. These are not reported as singular.
    - `undecided_conditions`: conditions for which the check found no configuration; not reported as singular, either.
    - `matrix_indices`: for each component, the index of the remaining matrix whose minors are the component's
      conditions, or None.
    - `is_described`: whether the configurations of the components have been described.
    - `max_terms`: the maximum number of terms of an equation that is written out in a text.
    """

    reciprocal_set: ReciprocalSet
    matrix: sp.ImmutableMatrix
    remaining_matrices: RemainingMatrices
    components: tuple[SingularComponent, ...] = ()
    is_always_singular: bool = False
    check: RankCheck | None = None
    doubtful_conditions: tuple[tuple[sp.Expr, ...], ...] = ()
    undecided_conditions: tuple[tuple[sp.Expr, ...], ...] = ()
    matrix_indices: tuple[int | None, ...] = ()
    is_described: bool = True
    max_terms: int = MAX_READABLE_TERMS

    def is_long(self, condition: sp.Expr) -> bool:
        """Return whether a condition is too long to be read."""
        return bool(condition.is_Add) and len(condition.args) > self.max_terms

    @property
    def omits_conditions(self) -> bool:
        """Whether any condition is not written out."""
        pairs = zip(self.components, self.matrix_indices, strict=True)
        conditions = (c for component, matrix_index in pairs if matrix_index is None for c in component.conditions)
        return any(map(self.is_long, conditions))

    @property
    def is_never_singular(self) -> bool:
        """Whether the derivation found that J has full rank everywhere."""
        unconfirmed_conditions = self.doubtful_conditions or self.undecided_conditions
        return not (self.is_always_singular or self.components or unconfirmed_conditions)

    @property
    def search_counts(self) -> dict[str, int]:
        """The numbers of searches for rank loss, of those that converged, and of results that no condition explains."""
        if (check := self.check) is None:
            return {}
        unexplained_count = len(check.unexplained_configurations)
        return {"searches": check.search_count, "ended": check.converged_count, "unexplained": unexplained_count}


def generate_redundant_events(chain: Chain) -> Iterator[str | RedundantSingularities]:
    """Yield descriptions of the next step, and the singular set twice.

    Only the second time, the set has descriptions of what its configurations look like. Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    arm, values = make_polynomial_arm(chain)
    symbol_values = tuple((symbol, value) for symbol, value in values.items() if symbol not in arm.q)
    reciprocal_set = find_reciprocal_set(arm, symbol_values)
    remaining_matrices = _collect_remaining_matrices(filter(_is_shown, reciprocal_set.cases), values)
    result = RedundantSingularities(reciprocal_set, reciprocal_set.start.matrix.xreplace(values), remaining_matrices)
    if () in reciprocal_set.branches:
        yield replace(result, is_always_singular=True)
        return
    branches = [tuple(_scale_coefficients(c.xreplace(values)) for c in branch) for branch in reciprocal_set.branches]
    solutions = [(b, component) for b in branches if (component := solve_conjunction(b, chain)) is not None]
    yield "the numeric test of these conditions"
    check = check_rank_loss(chain, [component.conditions for _, component in solutions])
    confirmed_components, doubtful_conditions, undecided_conditions = [], [], []
    for k, (branch, component) in enumerate(solutions):
        if k in check.full_rank_branches:
            doubtful_conditions.append(branch)
        elif check.samples[k] or not check.arms:
            confirmed_components.append((component, check.samples[k]))
        else:
            undecided_conditions.append(component.conditions)
    components = tuple(_add_meaning(component, "") for component, _ in confirmed_components)
    indices = tuple(_find_minors_index(remaining_matrices, component.conditions) for component in components)
    result = replace(
        result, components=components, matrix_indices=indices, check=check, is_described=False,
        doubtful_conditions=tuple(doubtful_conditions), undecided_conditions=tuple(undecided_conditions),
    )  # fmt: skip
    yield result
    yield "the geometry of the configurations in which J loses rank"
    components = tuple(_describe_component(chain, component, samples) for component, samples in confirmed_components)
    yield replace(result, components=components, is_described=True)


def _add_meaning(component: Component, meaning: str) -> SingularComponent:
    classification = Classification("", is_uniform=False, meaning=meaning)
    return SingularComponent(component.conditions, component.solutions, classification)


def _describe_component(chain: Chain, component: Component, samples: Sequence[Sample]) -> SingularComponent:
    """Return a component with a description of its configurations, and with their kind if it can be established.

    If no description passes the test, the configurations have no simple meaning.
    """
    if can_establish_kind(chain):
        certified_component = certify_component(chain, component)
        classification = certified_component.classification
        if all_have_kind(chain, classification, samples):  # the samples are from another search with other lengths
            return certified_component
        return replace(certified_component, classification=replace(classification, is_uniform=False))
    statement = find_reason(chain, samples[:: max(1, len(samples) // _MAX_DESCRIBED_SAMPLES)])
    meaning = certify_statement(chain, statement.words, samples) if statement else ""
    return _add_meaning(component, meaning or NO_SIMPLE_MEANING)


def _is_shown(reduced_case: ReducedCase) -> bool:
    """Return whether the matrix of a case is short enough to be shown, and has rank loss under some conditions."""
    is_short = min(reduced_case.matrix.shape) > 1 and sp.count_ops(reduced_case.matrix) < MAX_SHOWN_OPERATIONS
    return reduced_case.branches not in ((), ((),)) and is_short


def _collect_remaining_matrices(
    reduced_cases: Iterable[ReducedCase], values: Mapping[sp.Symbol, sp.Expr]
) -> RemainingMatrices:
    """Return the matrices of cases, without duplicates and with the arm's numbers, each with all of its cases."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for reduced_case in reduced_cases:
        case = tuple(condition.xreplace(values) for condition in reduced_case.conditions)
        (only_branch,) = reduced_case.branches if len(reduced_case.branches) == 1 else ((),)
        minors = frozenset(_scale_coefficients(minor.xreplace(values)) for minor in only_branch)
        cases.setdefault((reduced_case.matrix.xreplace(values), reduced_case.joints, minors), []).append(case)
    return tuple(RemainingMatrix(tuple(matrix_cases), *key) for key, matrix_cases in cases.items())


def _find_minors_index(remaining_matrices: RemainingMatrices, conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the index of a matrix that remains in all cases and has all conditions among its minors.

    Return None if there is no such matrix, or if there are at most two conditions.
    """
    if len(conditions) <= 2:  # so few are written out instead
        return None
    for index, remaining_matrix in enumerate(remaining_matrices):
        if remaining_matrix.cases == ((),) and set(conditions) <= remaining_matrix.minors:
            return index
    return None


def _scale_coefficients(condition: sp.Expr) -> sp.Expr:
    """Divide a sum with large integer coefficients by a power of ten, so that they become decimals of at most one.

    Other conditions are returned unchanged.
    """
    expanded_condition = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(expanded_condition)]
    largest_number = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest_number < 10:
        return condition
    return sp.expand(expanded_condition / sp.Integer(10) ** len(str(largest_number)))
