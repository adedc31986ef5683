"""Find the singular configurations of a redundant arm for `qdot solve`, by elimination with a numerical check."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.singularities.appearance import find_reason
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.numeric_rank_check import RankCheck, check_rank_loss
from qdot.exercises.singularities.reciprocal import ReciprocalSet, ReducedCase, polynomial_chain, reciprocal_set
from qdot.exercises.singularities.singularity import Component, solve_conjunction
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certified_component, certified_statement
from qdot.exercises.verify.appearance import all_have_kind
from qdot.exercises.writing.solution_steps import SingularComponent

MAX_SHOWN_OPERATIONS = 700
"""A matrix is shown if its entries have fewer operations than this."""
MAX_READABLE_TERMS = 40
"""Maximum number of terms of an equation that a person would read."""
_MAX_DESCRIBED_SAMPLES = 20
"""Approximate number of samples from which the appearance of a component's configurations is described."""


@dataclass(frozen=True)
class RemainingMatrix:
    """A matrix whose rank decides whether the arm is singular in some cases.

    `cases` has the conditions of each case, and `joints` the joints of the columns. `minors` are its maximal minors, if
    they vanish simultaneously only under conditions that state that each of them is zero.
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
    """The singular set of a redundant arm: the elimination, its results, and the numerical check.

    `remaining_matrices` are the matrices that remain after the elimination. `is_always_singular` says that every
    configuration is singular. Conditions that failed the check are `doubtful`; those for which it found no
    configuration are `undecided`. Neither are reported as singular. `matrix_indices` has for each component the index
    of the matrix in `remaining_matrices` whose minors are its conditions, or None.
    """

    reciprocal: ReciprocalSet
    matrix: sp.ImmutableMatrix
    remaining_matrices: RemainingMatrices
    components: tuple[SingularComponent, ...]
    is_always_singular: bool
    check: RankCheck | None
    doubtful: tuple[tuple[sp.Expr, ...], ...]
    undecided: tuple[tuple[sp.Expr, ...], ...] = ()
    matrix_indices: tuple[int | None, ...] = ()
    is_described: bool = True
    """Whether the configurations of its components have been described."""

    max_terms: int = MAX_READABLE_TERMS
    """Maximum number of terms of an equation that is written out in a text."""

    def is_long(self, condition: sp.Expr) -> bool:
        """Return whether a condition is too long to be read."""
        return bool(condition.is_Add) and len(condition.args) > self.max_terms

    @property
    def omits_conditions(self) -> bool:
        """Whether any condition is not written out."""
        pairs = zip(self.components, self.matrix_indices, strict=True)
        written_out = (condition for component, rank in pairs if rank is None for condition in component.conditions)
        return any(map(self.is_long, written_out))

    @property
    def is_never_singular(self) -> bool:
        """Whether the derivation found that J has full rank everywhere."""
        return not (self.is_always_singular or self.components or self.doubtful or self.undecided)

    @property
    def search_counts(self) -> dict[str, int]:
        """The number of searches for rank loss, of those that converged, and of results that no condition explains."""
        if (check := self.check) is None:
            return {}
        unexplained = len(check.unexplained_configurations)
        return {"searches": check.search_count, "ended": check.converged_count, "unexplained": unexplained}


def redundant_stages(chain: Chain) -> Iterator[str | RedundantSingularities]:
    """Yield descriptions of the next step, and the singular set twice: before and after its description.

    The description says what the singular configurations look like. Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    plain, values = polynomial_chain(chain)
    twists = tuple((symbol, value) for symbol, value in values.items() if symbol not in plain.q)
    reciprocal = reciprocal_set(plain, twists)
    rests = _remaining_matrices([reduced_case for reduced_case in reciprocal.cases if _is_shown(reduced_case)], values)
    matrix = _substitute_values(reciprocal.reduction.matrix, values)
    if () in reciprocal.branches:
        yield RedundantSingularities(reciprocal, matrix, rests, (), True, None, ())
        return
    branches = [tuple(_scale_coefficients(substitute(c, values)) for c in branch) for branch in reciprocal.branches]
    solved = [(branch, component) for branch in branches if (component := solve_conjunction(branch, chain)) is not None]
    yield "the numeric test of these conditions"
    check = check_rank_loss(chain, [component.conditions for _, component in solved])
    confirmed, doubtful, undecided = [], [], []
    for k, (branch, component) in enumerate(solved):
        if k in check.full_rank_branches:
            doubtful.append(branch)
        elif check.samples[k] or not check.arms:
            confirmed.append((component, [Sample(check.arms[a], q) for a, q in check.samples[k]]))
        else:
            undecided.append(component.conditions)
    ranks = tuple(_index_of_minors(rests, component.conditions) for component, _ in confirmed)
    undescribed = tuple(_component_with_meaning(component, "") for component, _ in confirmed)
    results = reciprocal, matrix, rests, undescribed, False, check, tuple(doubtful), tuple(undecided), ranks, False
    partial_result = RedundantSingularities(*results)
    yield partial_result
    yield "the geometry of the configurations in which J loses rank"
    components = tuple(_describe_component(chain, component, samples) for component, samples in confirmed)
    yield replace(partial_result, components=components, is_described=True)


def _component_with_meaning(component: Component, meaning: str) -> SingularComponent:
    return SingularComponent(component.conditions, component.solutions, Classification("", False, meaning))


def _describe_component(chain: Chain, component: Component, samples: list[Sample]) -> SingularComponent:
    """Return a component with a description of its configurations, and their kind if it can be established."""
    if can_establish_kind(chain):
        singular = certified_component(chain, component)
        is_confirmed = all_have_kind(chain, singular.kind, samples)  # the samples come from another search and lengths
        return singular if is_confirmed else replace(singular, kind=replace(singular.kind, uniform=False))
    return _component_with_meaning(component, _describe_appearance(chain, samples))


def _describe_appearance(chain: Chain, samples: list[Sample]) -> str:
    """Return a description of configurations; empty if none passes the test."""
    statement = find_reason(chain, samples[:: max(1, len(samples) // _MAX_DESCRIBED_SAMPLES)])
    return certified_statement(chain, statement.words, samples) if statement else ""


def _is_shown(reduced_case: ReducedCase) -> bool:
    is_short = min(reduced_case.matrix.shape) > 1 and sp.count_ops(reduced_case.matrix) < MAX_SHOWN_OPERATIONS
    return reduced_case.branches not in ((), ((),)) and is_short


def _remaining_matrices(reduced_cases: list[ReducedCase], values: Mapping[sp.Symbol, sp.Expr]) -> RemainingMatrices:
    """Return the remaining matrices with the arm's numbers; cases with the same matrix are grouped."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for reduced in reduced_cases:
        case = tuple(substitute(condition, values) for condition in reduced.case)
        (only_branch,) = reduced.branches if len(reduced.branches) == 1 else ((),)
        minors = frozenset(_scale_coefficients(substitute(minor, values)) for minor in only_branch)
        cases.setdefault((_substitute_values(reduced.matrix, values), reduced.joints, minors), []).append(case)
    return tuple(RemainingMatrix(tuple(matrix_cases), *key) for key, matrix_cases in cases.items())


def _index_of_minors(remaining_matrices: RemainingMatrices, conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the index of the matrix without case conditions whose minors include all `conditions`, or None."""
    for index, remaining in enumerate(remaining_matrices):
        if len(conditions) > 2 and remaining.cases == ((),) and set(conditions) <= remaining.minors:
            return index
    return None


def _substitute_values(matrix: sp.ImmutableMatrix, values: Mapping[sp.Symbol, sp.Expr]) -> sp.ImmutableMatrix:
    return sp.ImmutableMatrix(matrix.applyfunc(lambda entry: substitute(entry, values)))


def _scale_coefficients(condition: sp.Expr) -> sp.Expr:
    """Scale a sum by a power of ten, so that its integer coefficients become exact decimals of magnitude about one."""
    plain = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(plain)]
    largest = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest < 10:
        return condition
    return sp.expand(plain / sp.Integer(10) ** len(str(largest)))
