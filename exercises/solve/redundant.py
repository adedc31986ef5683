"""Find the singular configurations of a redundant arm for `qdot solve`, by elimination and with a numerical check.

A redundant arm has more joints than its task has rows, such as seven joints for a pose.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.singularities.appearance import find_reason
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.numeric_rank_check import RankCheck, check_rank_loss
from qdot.exercises.singularities.reciprocal import ReciprocalSet, ReducedCase, find_reciprocal_set, make_polynomial_arm
from qdot.exercises.singularities.singular_set import Component, solve_conjunction
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certify_component, certify_statement
from qdot.exercises.verify.singularity_statements import all_have_kind
from qdot.exercises.writing.solution_steps import SingularComponent

MAX_SHOWN_OPERATIONS = 700
"""A matrix is shown if its entries have fewer operations than this."""
MAX_READABLE_TERMS = 40
"""Maximum number of terms of an equation that a person would read."""
_MAX_DESCRIBED_SAMPLES = 20
"""Approximate number of samples from which the appearance of a component's configurations is described."""


@dataclass(frozen=True)
class RemainingMatrix:
    """A matrix that remains after the elimination; its rank decides in some cases whether the arm is singular.

    - `cases`: the conditions of each case.
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

    - `reciprocal`: the result of the elimination.
    - `matrix`: the Jacobian with which the elimination started, with the arm's numbers.
    - `remaining_matrices`: the matrices that remained after the elimination, with the arm's numbers.
    - `components`: the components of the singular set that the numerical check confirmed.
    - `is_always_singular`: whether every configuration is singular.
    - `check`: the result of the numerical check; None if every configuration is singular.
    - `doubtful`: conditions that failed the check. They are not reported as singular.
    - `undecided`: conditions for which the check found no configuration. They are not reported as singular, either.
    - `matrix_indices`: for each component, the index of the remaining matrix whose minors are the component's
      conditions, or None.
    - `is_described`: whether the configurations of the components have been described.
    - `max_terms`: the maximum number of terms of an equation that is written out in a text.
    """

    reciprocal: ReciprocalSet
    matrix: sp.ImmutableMatrix
    remaining_matrices: RemainingMatrices
    components: tuple[SingularComponent, ...] = ()
    is_always_singular: bool = False
    check: RankCheck | None = None
    doubtful: tuple[tuple[sp.Expr, ...], ...] = ()
    undecided: tuple[tuple[sp.Expr, ...], ...] = ()
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
        written_out = (component for component, matrix_index in pairs if matrix_index is None)
        return any(self.is_long(condition) for component in written_out for condition in component.conditions)

    @property
    def is_never_singular(self) -> bool:
        """Whether the derivation found that J has full rank everywhere."""
        return not (self.is_always_singular or self.components or self.doubtful or self.undecided)

    @property
    def search_counts(self) -> dict[str, int]:
        """The numbers of searches for rank loss, of those that converged, and of results that no condition explains."""
        if (check := self.check) is None:
            return {}
        unexplained = len(check.unexplained_configurations)
        return {"searches": check.search_count, "ended": check.converged_count, "unexplained": unexplained}


def generate_redundant_events(chain: Chain) -> Iterator[str | RedundantSingularities]:
    """Yield descriptions of the next step, and the singular set twice: without and with descriptions.

    Descriptions say what the singular configurations look like. Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    arm, values = make_polynomial_arm(chain)
    symbol_values = tuple((symbol, value) for symbol, value in values.items() if symbol not in arm.q)
    reciprocal = find_reciprocal_set(arm, symbol_values)
    remaining_matrices = _collect_remaining_matrices(filter(_is_shown, reciprocal.cases), values)
    result = RedundantSingularities(reciprocal, reciprocal.start.matrix.xreplace(values), remaining_matrices)
    if () in reciprocal.branches:
        yield replace(result, is_always_singular=True)
        return
    branches = [tuple(_scale_coefficients(c.xreplace(values)) for c in branch) for branch in reciprocal.branches]
    solutions = [(b, component) for b in branches if (component := solve_conjunction(b, chain)) is not None]
    yield "the numeric test of these conditions"
    check = check_rank_loss(chain, [component.conditions for _, component in solutions])
    confirmed, doubtful, undecided = [], [], []
    for k, (branch, component) in enumerate(solutions):
        if k in check.full_rank_branches:
            doubtful.append(branch)
        elif check.samples[k] or not check.arms:
            confirmed.append((component, check.samples[k]))
        else:
            undecided.append(component.conditions)
    components = tuple(_add_meaning(component, "") for component, _ in confirmed)
    indices = tuple(_find_minors_index(remaining_matrices, component.conditions) for component in components)
    result = replace(result, components=components, matrix_indices=indices, check=check, is_described=False)
    result = replace(result, doubtful=tuple(doubtful), undecided=tuple(undecided))
    yield result
    yield "the geometry of the configurations in which J loses rank"
    components = tuple(_describe_component(chain, component, samples) for component, samples in confirmed)
    yield replace(result, components=components, is_described=True)


def _add_meaning(component: Component, meaning: str) -> SingularComponent:
    return SingularComponent(component.conditions, component.solutions, Classification("", False, meaning))


def _describe_component(chain: Chain, component: Component, samples: Sequence[Sample]) -> SingularComponent:
    """Return a component with a description of its configurations, and with their kind if it can be established.

    The description is empty if no description passes the test.
    """
    if can_establish_kind(chain):
        singular = certify_component(chain, component)
        classification = singular.classification
        if all_have_kind(chain, classification, samples):  # the samples come from another search and lengths
            return singular
        return replace(singular, classification=replace(classification, is_uniform=False))
    statement = find_reason(chain, samples[:: max(1, len(samples) // _MAX_DESCRIBED_SAMPLES)])
    meaning = certify_statement(chain, statement.words, samples) if statement else ""
    return _add_meaning(component, meaning)


def _is_shown(reduced_case: ReducedCase) -> bool:
    """Return whether the matrix of a case is short enough to be shown, and has rank loss under some conditions."""
    is_short = min(reduced_case.matrix.shape) > 1 and sp.count_ops(reduced_case.matrix) < MAX_SHOWN_OPERATIONS
    return reduced_case.branches not in ((), ((),)) and is_short


def _collect_remaining_matrices(
    reduced_cases: Iterable[ReducedCase], values: Mapping[sp.Symbol, sp.Expr]
) -> RemainingMatrices:
    """Return the matrices of cases, without duplicates and with the arm's numbers, each with all of its cases."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for reduced in reduced_cases:
        case = tuple(condition.xreplace(values) for condition in reduced.case)
        (only_branch,) = reduced.branches if len(reduced.branches) == 1 else ((),)
        minors = frozenset(_scale_coefficients(minor.xreplace(values)) for minor in only_branch)
        cases.setdefault((reduced.matrix.xreplace(values), reduced.joints, minors), []).append(case)
    return tuple(RemainingMatrix(tuple(matrix_cases), *key) for key, matrix_cases in cases.items())


def _find_minors_index(remaining_matrices: RemainingMatrices, conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the index of the matrix that applies in all cases and whose minors include all conditions, or None."""
    for index, remaining_matrix in enumerate(remaining_matrices):
        if len(conditions) > 2 and remaining_matrix.cases == ((),) and set(conditions) <= remaining_matrix.minors:
            return index
    return None


def _scale_coefficients(condition: sp.Expr) -> sp.Expr:
    """Divide a sum with large integer coefficients by a power of ten, so that they become decimals of at most one.

    Other conditions are returned unchanged.
    """
    expanded = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(expanded)]
    largest_number = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest_number < 10:
        return condition
    return sp.expand(expanded / sp.Integer(10) ** len(str(largest_number)))
