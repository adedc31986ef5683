"""What is singular, or of another kind, only where open lengths of an arm are related in a way of its own.

What is told of open lengths holds for lengths that nothing is special about: a planar arm of two links that is folded
back is at the boundary of its reach, but not where the links are as long as each other. Looked at are the lengths at
which a condition begins to hold, lengths that are equal, to each other or to a given one, and one that is as long as
two others together.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import Kind
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.existence_conditions import Need, need_of
from qdot.exercises.arm.kinds import kind_is_sure
from qdot.exercises.arm.lengths import with_lengths
from qdot.exercises.arm.numeric_rank_check import ways_covering
from qdot.exercises.arm.reciprocal import applies
from qdot.exercises.solve.certified_singularities import sound_components
from qdot.exercises.solve.redundant import Redundant, redundant_stages
from qdot.exercises.writing.worked import SingularComponent

MOST = 8
"""Relations that are looked at, the first of them."""


@dataclass(frozen=True)
class Special:
    """What differs where a length is as long as something: the components that are others then, or of another kind."""

    length: sp.Symbol
    value: sp.Expr
    chain: Chain
    components: tuple[SingularComponent, ...]

    @property
    def relation(self) -> str:
        """The relation as text, as in a1 = a2."""
        return f"{self.length} = {self.value}"


def needs(chain: Chain, general: tuple[SingularComponent, ...]) -> list[Need]:
    """Return what has to be true of open lengths for the conditions of a singular set to hold anywhere."""
    found = (need_of(condition, chain) for one in general for condition in one.conditions)
    return [need for need in found if need is not None]


def _slides(chain: Chain) -> set[sp.Symbol]:
    return {q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "P"}


def _where_it_begins(need: Need) -> tuple[sp.Symbol, sp.Expr] | None:
    """Return the relation at which a condition begins to hold, of a length; None where no length stands alone."""
    for term in sp.Add.make_args(need.least):
        if term.is_Symbol and term not in (need.most + need.least - term).free_symbols:
            return term, need.most - (need.least - term)
    return None


def relations(chain: Chain, general: tuple[SingularComponent, ...] = ()) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return what is looked at: an open length that J of the task depends on, and what it is as long as.

    >>> from qdot.exercises.arm.chain import Joint
    >>> rows = [Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)]
    >>> relations(Chain("two", tuple(rows), ("vx", "vy")))
    [(a1, a2)]
    """
    rows = [value for joint in chain.joints for value in (joint.a, joint.d if joint.kind == "R" else sp.S.Zero)]
    sizes = [-value if value.as_coeff_Mul()[0].is_negative else value for value in (*rows, *chain.point.offset)]
    lengths = list(dict.fromkeys(size for size in sizes if size != 0 and (size.is_Symbol or size.is_number)))
    counted = derive(chain).jacobian.free_symbols
    given = [size for size in lengths if size.is_number]
    is_open = [size for size in lengths if size.is_Symbol and size in counted]
    equal = [*combinations(is_open, 2), *((one, other) for one in is_open for other in given)]
    sums = [
        (one, first + second)
        for one in is_open
        for first, second in combinations([size for size in (*is_open, *given) if size != one], 2)
        if first.is_Symbol or second.is_Symbol
    ]
    begins = [relation for need in needs(chain, general) if (relation := _where_it_begins(need)) is not None]
    return list(dict.fromkeys([*begins, *equal, *sums]))[:MOST]


def special_lengths(chain: Chain, general: tuple[SingularComponent, ...]) -> Iterator[str | Special]:
    """Yield in words what is looked at, and where something differs from what is told in general."""
    for length, value in relations(chain, general):
        yield f"whether anything differs where {length} = {value}"
        there = with_lengths(chain, {length: value})
        known = [_put_in(one, {length: value}) for one in general]
        try:
            found = _components(there)
        except TooLong:
            continue
        others = tuple(one for one in found if not _is_known(one, known, there))
        if others:
            yield Special(length, value, there, others)


def _components(chain: Chain) -> tuple[SingularComponent, ...]:
    """Return the singular set of an arm by the way that is shorter for it. Raises TooLong."""
    if not applies(chain):
        return sound_components(chain)
    *_, last = redundant_stages(chain)
    assert isinstance(last, Redundant)
    return last.components


def _is_known(one: SingularComponent, known: list[SingularComponent], there: Chain) -> bool:
    """Tell whether what is so for special lengths is what is told in general, with these put in.

    By elimination, the same may be told by other conditions: then its configurations tell.
    """
    conditions = _conditions(one, there)
    if any(conditions == _conditions(other, there) and _says_no_more(one, other, there) for other in known):
        return True
    if not applies(there):
        return False
    numbers = ways_covering(there, one.conditions, [other.conditions for other in known])
    return numbers is not None and all(_says_no_more(one, known[number], there) for number in numbers)


def _says_no_more(one: SingularComponent, general: SingularComponent, chain: Chain) -> bool:
    """Tell whether a component is of no other kind than is told in general; of both kinds, it is told of neither."""
    if not kind_is_sure(chain):
        return True
    for at, kind in _kinds(one, chain).items():
        told = [other for there, other in _kinds(general, chain).items() if at in (there, ()) or there == ()]
        same = [other for other in told if not other.uniform or replace(other, meaning=kind.meaning) == kind]
        if not told or same != told:
            return False
    return True


def _kinds(one: SingularComponent, chain: Chain) -> dict[tuple[str, ...], Kind]:
    """Return the kind of a component by values of joints where these are told apart, else of all of it."""
    turning = {q.name for q in chain.q} - {slide.name for slide in _slides(chain)}
    if not one.cases:
        return {(): one.kind}
    return {
        tuple(str(_turned(value) if joint.name in turning else value) for joint, value in at): kind
        for at, kind in one.cases
    }


def _put_in(one: SingularComponent, values: dict[sp.Symbol, sp.Expr]) -> SingularComponent:
    cases = tuple((tuple((joint, value.xreplace(values)) for joint, value in at), kind) for at, kind in one.cases)
    return replace(one, conditions=tuple(condition.xreplace(values) for condition in one.conditions), cases=cases)


def _conditions(one: SingularComponent, chain: Chain) -> frozenset[sp.Expr]:
    """Return the conditions of a component up to factors."""
    return frozenset(_plain(condition, chain) for condition in one.conditions)


def _turned(angle: sp.Expr) -> sp.Expr:
    """Return a number of radians from 0 to below a whole turn: -135 degrees are 225."""
    return angle % (2 * sp.pi) if angle.is_number else angle


def _plain(condition: sp.Expr, chain: Chain) -> sp.Expr:
    """Return a condition without numbers, lengths and signs that all its terms share."""
    factors = sp.Mul.make_args(sp.factor_terms(sp.expand(condition)))
    plain = sp.expand(sp.Mul(*(factor for factor in factors if factor.free_symbols & set(chain.q))))
    _, plain = plain.as_content_primitive()
    return min(plain, -plain, key=sp.default_sort_key)
