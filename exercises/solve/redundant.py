"""What `qdot solve` tells of where a redundant arm is singular: by elimination, and put to the test."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.appearance import reason_of
from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import Kind
from qdot.exercises.arm.kinds import kind_is_sure
from qdot.exercises.arm.numeric_rank_check import RankCheck, check_rank_loss
from qdot.exercises.arm.reciprocal import ReciprocalSet, ReducedCase, plain_chain, reciprocal_set
from qdot.exercises.arm.singularity import Component, solve_conjunction
from qdot.exercises.arm.trigonometry import substitute
from qdot.exercises.solve.certified_singularities import sound_component, sound_words
from qdot.exercises.verify.appearance import is_of_kind
from qdot.exercises.writing.worked import SingularComponent

MOST_SHOWN = 700
"""Operations in all entries of a matrix that is shown."""
MOST_READ = 40
"""Terms of an equation that anyone would read."""
_LOOKED_AT = 20


@dataclass(frozen=True)
class Rest:
    """A matrix that the rank comes down to in some cases: conditions of each, and the joints of its columns.

    `minors` are its maximal minors where the only way in which they vanish together is that each does by itself.
    """

    cases: tuple[tuple[sp.Expr, ...], ...]
    matrix: sp.ImmutableMatrix
    joints: tuple[int, ...]
    minors: frozenset[sp.Expr]

    @property
    def mixed(self) -> bool:
        """Whether some column stands for two joints."""
        return 0 in self.joints


@dataclass(frozen=True)
class Redundant:
    """Where such an arm is singular, in its own numbers: how J is seen, what it comes down to, and what it was put to.

    Conditions that failed the test in numbers are `doubtful`, those for which it found no configuration `undecided`:
    neither are told as singular. `ranks` has for each component the number of the matrix (of `rests`) whose minors its
    conditions are, None for others.
    """

    found: ReciprocalSet
    matrix: sp.ImmutableMatrix
    rests: tuple[Rest, ...]
    components: tuple[SingularComponent, ...]
    always: bool
    tried: RankCheck | None
    doubtful: tuple[tuple[sp.Expr, ...], ...]
    undecided: tuple[tuple[sp.Expr, ...], ...] = ()
    ranks: tuple[int | None, ...] = ()
    described: bool = True
    """Whether it is known what the configurations of its components look like."""

    most_terms: int = MOST_READ
    """Terms of an equation beyond which it is not written out in a text."""

    def is_long(self, condition: sp.Expr) -> bool:
        """Tell whether nobody would read a condition."""
        return bool(condition.is_Add) and len(condition.args) > self.most_terms

    @property
    def is_cut(self) -> bool:
        """Whether some condition is not written out."""
        told = (one for one, rank in zip(self.components, self.ranks, strict=True) if rank is None)
        return any(self.is_long(condition) for one in told for condition in one.conditions)

    @property
    def never(self) -> bool:
        """Whether J was found to keep its rank everywhere, by what was derived."""
        return not (self.always or self.components or self.doubtful or self.undecided)

    @property
    def searched(self) -> dict[str, int]:
        """How many searches for lost rank there were, how many found it, and how many of these nothing explains."""
        if self.tried is None:
            return {}
        out = self.tried
        return {"searches": out.searches, "ended": out.ended, "unexplained": len(out.unexplained)}


def redundant_stages(chain: Chain) -> Iterator[str | Redundant]:
    """Yield in words what is worked out next, the result without what configurations look like, and all of it.

    Raises TooLong.
    """
    yield f"where the rank of J is below {len(chain.task)}, by elimination"
    plain, values = plain_chain(chain)
    twists = tuple((symbol, value) for symbol, value in values.items() if symbol not in plain.q)
    found = reciprocal_set(plain, twists)
    rests = _rests([left for left in found.left if _is_shown(left)], values)
    matrix = _filled(found.reduction.matrix, values)
    if () in found.ways:
        yield Redundant(found, matrix, rests, (), True, None, ())
        return
    ways = [tuple(_scaled(substitute(condition, values)) for condition in way) for way in found.ways]
    solved = [(way, component) for way in ways if (component := solve_conjunction(way, chain)) is not None]
    yield "the test of these conditions in numbers"
    out = check_rank_loss(chain, [component.conditions for _, component in solved])
    held, doubtful, undecided = [], [], []
    for k, (way, component) in enumerate(solved):
        if k in out.wrong:
            doubtful.append(way)
        elif out.samples[k] or not out.arms:
            held.append((component, [Sample(out.arms[a], q) for a, q in out.samples[k]]))
        else:
            undecided.append(component.conditions)
    ranks = tuple(_minors_of(rests, component.conditions) for component, _ in held)
    plain_ones = tuple(_described(component, "") for component, _ in held)
    of_test = tuple(doubtful), tuple(undecided), ranks
    known = Redundant(found, matrix, rests, plain_ones, False, out, *of_test, described=False)
    yield known
    yield "what the configurations look like in which J loses rank"
    components = tuple(_told(chain, component, samples) for component, samples in held)
    yield replace(known, components=components, described=True)


def _described(component: Component, meaning: str) -> SingularComponent:
    return SingularComponent(component.conditions, component.solutions, Kind("", False, meaning))


def _told(chain: Chain, component: Component, samples: list[Sample]) -> SingularComponent:
    """Return a component with what configurations look like, and their kind where that can be established."""
    if kind_is_sure(chain):
        one = sound_component(chain, component)
        is_so = is_of_kind(chain, one.kind, samples)  # found by another search, with other lengths
        return one if is_so else replace(one, kind=replace(one.kind, uniform=False))
    return _described(component, _looks(chain, samples))


def _looks(chain: Chain, samples: list[Sample]) -> str:
    """Return what configurations look like, in words, empty where that is nothing."""
    said = reason_of(chain, samples[:: max(1, len(samples) // _LOOKED_AT)])
    return sound_words(chain, said.words, samples) if said else ""


def _is_shown(left: ReducedCase) -> bool:
    return (
        bool(left.ways) and min(left.matrix.shape) > 1 and sp.count_ops(left.matrix) < MOST_SHOWN and left.ways != ((),)
    )


def _rests(shown: list[ReducedCase], values: dict[sp.Symbol, sp.Expr]) -> tuple[Rest, ...]:
    """Return what is left, in the arm's numbers; cases with the same matrix together."""
    cases: dict[tuple[sp.ImmutableMatrix, tuple[int, ...], frozenset[sp.Expr]], list[tuple[sp.Expr, ...]]] = {}
    for left in shown:
        case = tuple(substitute(condition, values) for condition in left.case)
        (only,) = left.ways if len(left.ways) == 1 else ((),)
        minors = frozenset(_scaled(substitute(minor, values)) for minor in only)
        cases.setdefault((_filled(left.matrix, values), left.joints, minors), []).append(case)
    return tuple(Rest(tuple(where), *rest) for rest, where in cases.items())


def _minors_of(rests: tuple[Rest, ...], conditions: tuple[sp.Expr, ...]) -> int | None:
    """Return the number of the matrix that is left without a case and whose minors some long conditions are."""
    for number, rest in enumerate(rests):
        if len(conditions) > 2 and rest.cases == ((),) and set(conditions) <= rest.minors:
            return number
    return None


def _filled(matrix: sp.ImmutableMatrix, values: dict[sp.Symbol, sp.Expr]) -> sp.ImmutableMatrix:
    return sp.ImmutableMatrix(matrix.applyfunc(lambda entry: substitute(entry, values)))


def _scaled(condition: sp.Expr) -> sp.Expr:
    """Return a sum with numbers before its terms in decimals of the size of one, which are exact."""
    plain = sp.expand(condition)
    numbers = [term.as_coeff_Mul()[0] for term in sp.Add.make_args(plain)]
    largest = max(map(abs, numbers))
    if not condition.is_Add or not all(number.is_Integer for number in numbers) or largest < 10:
        return condition
    return sp.expand(plain / sp.Integer(10) ** len(str(largest)))
