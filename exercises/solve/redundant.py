"""Find for `qdot solve` where a redundant arm is singular: by elimination, then checked numerically."""

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
"""Operations in all entries of a matrix, up to which it is shown."""
MOST_READ = 40
"""Terms of an equation, up to which anyone would read it."""
_LOOKED_AT = 20


@dataclass(frozen=True)
class RemainingMatrix:
    """A matrix whose rank decides in some cases: the conditions of each case, and the joints of its columns.

    `minors` are its maximal minors, if they vanish together only where each is stated to be zero.
    """

    cases: tuple[tuple[sp.Expr, ...], ...]
    matrix: sp.ImmutableMatrix
    joints: tuple[int, ...]
    minors: frozenset[sp.Expr]

    @property
    def has_mixed_columns(self) -> bool:
        """Whether some column combines two joints."""
        return 0 in self.joints


@dataclass(frozen=True)
class Redundant:
    """Where such an arm is singular, in its own numbers: the elimination, what it leads to, and the numerical check.

    Conditions that failed the check are `doubtful`, those for which it found no configuration `undecided`: neither are
    reported as singular. `ranks` has for each component the number of the matrix (in `rests`) whose minors are its
    conditions, None for others.
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
    """Whether it is known what the configurations of its components look like."""

    most_terms: int = MOST_READ
    """Terms up to which an equation is written out in a text."""

    def is_long(self, condition: sp.Expr) -> bool:
        """Tell whether a condition is too long to be read."""
        return bool(condition.is_Add) and len(condition.args) > self.most_terms

    @property
    def is_cut(self) -> bool:
        """Whether some condition is not written out."""
        written_out = (component for component, rank in zip(self.components, self.ranks, strict=True) if rank is None)
        return any(self.is_long(condition) for component in written_out for condition in component.conditions)

    @property
    def is_never_singular(self) -> bool:
        """Whether the derivation found that J keeps its rank everywhere."""
        return not (self.always or self.components or self.doubtful or self.undecided)

    @property
    def search_counts(self) -> dict[str, int]:
        """The number of searches for lost rank, of those that found it, and of finds that no condition explains."""
        if self.check is None:
            return {}
        out = self.check
        return {"searches": out.searches, "ended": out.ended, "unexplained": len(out.unexplained)}


def redundant_stages(chain: Chain) -> Iterator[str | Redundant]:
    """Yield in words what is derived next, then the result without the look of its configurations, then all of it.

    Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    plain, values = plain_chain(chain)
    twists = tuple((symbol, value) for symbol, value in values.items() if symbol not in plain.q)
    reciprocal = reciprocal_set(plain, twists)
    rests = _remaining_matrices([left for left in reciprocal.left if _is_shown(left)], values)
    matrix = _substitute_values(reciprocal.reduction.matrix, values)
    if () in reciprocal.ways:
        yield Redundant(reciprocal, matrix, rests, (), True, None, ())
        return
    ways = [tuple(_scale(substitute(condition, values)) for condition in way) for way in reciprocal.ways]
    solved = [(way, component) for way in ways if (component := solve_conjunction(way, chain)) is not None]
    yield "the test of these conditions in numbers"
    check = check_rank_loss(chain, [component.conditions for _, component in solved])
    held, doubtful, undecided = [], [], []
    for k, (way, component) in enumerate(solved):
        if k in check.wrong:
            doubtful.append(way)
        elif check.samples[k] or not check.arms:
            held.append((component, [Sample(check.arms[a], q) for a, q in check.samples[k]]))
        else:
            undecided.append(component.conditions)
    ranks = tuple(_minors_of(rests, component.conditions) for component, _ in held)
    plain_ones = tuple(_component_with_meaning(component, "") for component, _ in held)
    of_test = tuple(doubtful), tuple(undecided), ranks
    known = Redundant(reciprocal, matrix, rests, plain_ones, False, check, *of_test, described=False)
    yield known
    yield "what the configurations look like in which J loses rank"
    components = tuple(_describe_component(chain, component, samples) for component, samples in held)
    yield replace(known, components=components, described=True)


def _component_with_meaning(component: Component, meaning: str) -> SingularComponent:
    return SingularComponent(component.conditions, component.solutions, Kind("", False, meaning))


def _describe_component(chain: Chain, component: Component, samples: list[Sample]) -> SingularComponent:
    """Return a component with what its configurations look like, and their kind if it can be established."""
    if kind_is_sure(chain):
        singular = certified_component(chain, component)
        is_so = is_of_kind(chain, singular.kind, samples)  # found by another search, with other lengths
        return singular if is_so else replace(singular, kind=replace(singular.kind, uniform=False))
    return _component_with_meaning(component, _describe_appearance(chain, samples))


def _describe_appearance(chain: Chain, samples: list[Sample]) -> str:
    """Return in words what configurations look like, or nothing."""
    statement = reason_of(chain, samples[:: max(1, len(samples) // _LOOKED_AT)])
    return certified_words(chain, statement.words, samples) if statement else ""


def _is_shown(left: ReducedCase) -> bool:
    return (
        bool(left.ways) and min(left.matrix.shape) > 1 and sp.count_ops(left.matrix) < MOST_SHOWN and left.ways != ((),)
    )


def _remaining_matrices(shown: list[ReducedCase], values: dict[sp.Symbol, sp.Expr]) -> tuple[RemainingMatrix, ...]:
    """Return the remaining matrices in the arm's numbers; cases with the same matrix are grouped."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for left in shown:
        case = tuple(substitute(condition, values) for condition in left.case)
        (only,) = left.ways if len(left.ways) == 1 else ((),)
        minors = frozenset(_scale(substitute(minor, values)) for minor in only)
        cases.setdefault((_substitute_values(left.matrix, values), left.joints, minors), []).append(case)
    return tuple(RemainingMatrix(tuple(where), *rest) for rest, where in cases.items())


def _minors_of(rests: tuple[RemainingMatrix, ...], conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the number of the matrix without a case whose minors include some long conditions, or None."""
    for number, rest in enumerate(rests):
        if len(conditions) > 2 and rest.cases == ((),) and set(conditions) <= rest.minors:
            return number
    return None


def _substitute_values(matrix: sp.ImmutableMatrix, values: dict[sp.Symbol, sp.Expr]) -> sp.ImmutableMatrix:
    return sp.ImmutableMatrix(matrix.applyfunc(lambda entry: substitute(entry, values)))


def _scale(condition: sp.Expr) -> sp.Expr:
    """Return a sum scaled by a power of ten, so that its integer coefficients become exact decimals of size one."""
    plain = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(plain)]
    largest = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest < 10:
        return condition
    return sp.expand(plain / sp.Integer(10) ** len(str(largest)))
