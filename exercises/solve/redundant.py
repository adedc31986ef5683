"""Find the singular configurations of a redundant arm for `qdot solve`, by elimination with a numerical check."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.appearance import reason_of
from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import Kind
from qdot.exercises.arm.numeric_rank_check import RankCheck, check_rank_loss
from qdot.exercises.arm.reciprocal import ReciprocalSet, ReducedCase, plain_chain, reciprocal_set
from qdot.exercises.arm.singularity import Component, solve_conjunction
from qdot.exercises.arm.singularity_kinds import kind_is_sure
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.solve.certified_singularities import certified_component, certified_words
from qdot.exercises.verify.appearance import is_of_kind
from qdot.exercises.writing.solution_steps import SingularComponent

MOST_SHOWN = 700
"""A matrix is shown if its entries have fewer operations than this."""
MOST_READ = 40
"""Maximum number of terms of an equation that a person would read."""
_LOOKED_AT = 20
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


@dataclass(frozen=True)
class Redundant:
    """The singular set of a redundant arm: the elimination, its results, and the numerical check.

    `rests` are the matrices that remain after the elimination. `always` says that every configuration is singular.
    Conditions that failed the check are `doubtful`; those for which it found no configuration are `undecided`. Neither
    are reported as singular. `ranks` has for each component the index of the matrix in `rests` whose minors are its
    conditions, or None.
    """

    reciprocal: ReciprocalSet
    matrix: sp.ImmutableMatrix
    rests: tuple[RemainingMatrix, ...]
    components: tuple[SingularComponent, ...]
    always: bool
    check: RankCheck | None
    doubtful: tuple[tuple[sp.Expr, ...], ...]
    undecided: tuple[tuple[sp.Expr, ...], ...] = ()
    ranks: tuple[int | None, ...] = ()
    described: bool = True
    """Whether the configurations of its components have been described."""

    most_terms: int = MOST_READ
    """Maximum number of terms of an equation that is written out in a text."""

    def is_long(self, condition: sp.Expr) -> bool:
        """Return whether a condition is too long to be read."""
        return bool(condition.is_Add) and len(condition.args) > self.most_terms

    @property
    def is_cut(self) -> bool:
        """Whether any condition is not written out."""
        written_out = (component for component, rank in zip(self.components, self.ranks, strict=True) if rank is None)
        return any(self.is_long(condition) for component in written_out for condition in component.conditions)

    @property
    def is_never_singular(self) -> bool:
        """Whether the derivation found that J has full rank everywhere."""
        return not (self.always or self.components or self.doubtful or self.undecided)

    @property
    def search_counts(self) -> dict[str, int]:
        """The number of searches for rank loss, of those that converged, and of results that no condition explains."""
        if self.check is None:
            return {}
        check = self.check
        return {"searches": check.searches, "ended": check.ended, "unexplained": len(check.unexplained)}


def redundant_stages(chain: Chain) -> Iterator[str | Redundant]:
    """Yield descriptions of the next step, and the singular set twice: before and after its description.

    The description says what the singular configurations look like. Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    plain, values = plain_chain(chain)
    twists = tuple((symbol, value) for symbol, value in values.items() if symbol not in plain.q)
    reciprocal = reciprocal_set(plain, twists)
    rests = _remaining_matrices([reduced_case for reduced_case in reciprocal.left if _is_shown(reduced_case)], values)
    matrix = _substitute_values(reciprocal.reduction.matrix, values)
    if () in reciprocal.ways:
        yield Redundant(reciprocal, matrix, rests, (), True, None, ())
        return
    branches = [tuple(_scale(substitute(condition, values)) for condition in branch) for branch in reciprocal.ways]
    solved = [(branch, component) for branch in branches if (component := solve_conjunction(branch, chain)) is not None]
    yield "the test of these conditions in numbers"
    check = check_rank_loss(chain, [component.conditions for _, component in solved])
    confirmed, doubtful, undecided = [], [], []
    for k, (branch, component) in enumerate(solved):
        if k in check.wrong:
            doubtful.append(branch)
        elif check.samples[k] or not check.arms:
            confirmed.append((component, [Sample(check.arms[a], q) for a, q in check.samples[k]]))
        else:
            undecided.append(component.conditions)
    ranks = tuple(_minors_of(rests, component.conditions) for component, _ in confirmed)
    undescribed = tuple(_component_with_meaning(component, "") for component, _ in confirmed)
    check_results = tuple(doubtful), tuple(undecided), ranks
    partial_result = Redundant(reciprocal, matrix, rests, undescribed, False, check, *check_results, described=False)
    yield partial_result
    yield "what the configurations look like in which J loses rank"
    components = tuple(_describe_component(chain, component, samples) for component, samples in confirmed)
    yield replace(partial_result, components=components, described=True)


def _component_with_meaning(component: Component, meaning: str) -> SingularComponent:
    return SingularComponent(component.conditions, component.solutions, Kind("", False, meaning))


def _describe_component(chain: Chain, component: Component, samples: list[Sample]) -> SingularComponent:
    """Return a component with a description of its configurations, and their kind if it can be established."""
    if kind_is_sure(chain):
        singular = certified_component(chain, component)
        is_confirmed = is_of_kind(chain, singular.kind, samples)  # the samples come from another search and lengths
        return singular if is_confirmed else replace(singular, kind=replace(singular.kind, uniform=False))
    return _component_with_meaning(component, _describe_appearance(chain, samples))


def _describe_appearance(chain: Chain, samples: list[Sample]) -> str:
    """Return a description of configurations; empty if none passes the test."""
    statement = reason_of(chain, samples[:: max(1, len(samples) // _LOOKED_AT)])
    return certified_words(chain, statement.words, samples) if statement else ""


def _is_shown(left: ReducedCase) -> bool:
    return (
        bool(left.ways) and min(left.matrix.shape) > 1 and sp.count_ops(left.matrix) < MOST_SHOWN and left.ways != ((),)
    )


def _remaining_matrices(shown: list[ReducedCase], values: dict[sp.Symbol, sp.Expr]) -> tuple[RemainingMatrix, ...]:
    """Return the remaining matrices with the arm's numbers; cases with the same matrix are grouped."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for reduced in shown:
        case = tuple(substitute(condition, values) for condition in reduced.case)
        (only_branch,) = reduced.ways if len(reduced.ways) == 1 else ((),)
        minors = frozenset(_scale(substitute(minor, values)) for minor in only_branch)
        cases.setdefault((_substitute_values(reduced.matrix, values), reduced.joints, minors), []).append(case)
    return tuple(RemainingMatrix(tuple(matrix_cases), *key) for key, matrix_cases in cases.items())


def _minors_of(rests: tuple[RemainingMatrix, ...], conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the index of the matrix without case conditions whose minors include all `conditions`, or None."""
    for index, remaining in enumerate(rests):
        if len(conditions) > 2 and remaining.cases == ((),) and set(conditions) <= remaining.minors:
            return index
    return None


def _substitute_values(matrix: sp.ImmutableMatrix, values: dict[sp.Symbol, sp.Expr]) -> sp.ImmutableMatrix:
    return sp.ImmutableMatrix(matrix.applyfunc(lambda entry: substitute(entry, values)))


def _scale(condition: sp.Expr) -> sp.Expr:
    """Scale a sum by a power of ten, so that its integer coefficients become exact decimals of magnitude about one."""
    plain = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(plain)]
    largest = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest < 10:
        return condition
    return sp.expand(plain / sp.Integer(10) ** len(str(largest)))
