"""Singular configurations of a chain for its task: where the task Jacobian loses rank (6.8), all of them.

For a square Jacobian these are the zeros of the factors of det J. For any other shape they are the common zeros of
all maximal minors: factors that all minors share, and, for what is left, combinations of conditions.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import Derivation, TooLong, derive
from qdot.exercises.arm.joint_solvability import follows, may_hold_together, without_needless
from qdot.exercises.arm.relations import Relation, by_half_angle, relation_of
from qdot.exercises.arm.trigonometry import Factored, factored, substitute
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.text import ByText

MOST_WAYS, MOST_PARTS = 300, 40
"""Ways in which minors vanish together that are looked at, and those of them that anyone would read."""
MOST_ZEROS = 10_000
"""How much work it may be to see of long conditions that they follow from others, as `joint_solvability` counts it."""
_NOTHING = sp.Float("1e-20")
_SIGNS, _CLEAR = 12, 1e-6
"""Places at which the sign of an expression is looked at, and from what size on it has one."""
RIGHT_ANGLES = (sp.S.Zero, sp.pi / 2, sp.pi, -sp.pi / 2)


Joints = tuple[sp.Symbol, ...]
Conjunction = tuple[sp.Expr, ...]
Solved = tuple[sp.Symbol, tuple[sp.Expr, ...]]
"""A joint, and its values at which a condition holds."""
Zeros = list[Conjunction] | None
"""Conditions under which all minors vanish together; None where they always do."""


@dataclass(frozen=True)
class Component:
    """A part of the singular set: expressions that vanish together, and the joint values at which they do.

    `solutions` holds (joint, values) for each condition, or is None where one of them ties several joints.
    """

    conditions: tuple[sp.Expr, ...]
    solutions: tuple[tuple[sp.Symbol, tuple[sp.Expr, ...]], ...] | None

    def pieces(self) -> list[str]:
        """Return the conditions as text, one string for each value or combination of values.

        >>> Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi)),)).pieces()
        ['theta2 = 0', 'theta2 = pi']
        """
        if self.solutions is None:
            return [" and ".join(f"{condition} = 0" for condition in self.conditions)]
        texts = [""]
        for joint, values in self.solutions:
            texts = [f"{text} and {joint} = {value}".removeprefix(" and ") for text in texts for value in values]
        return texts


@lru_cache(maxsize=256)
def singular_set(chain: Chain) -> tuple[Component, ...] | None:
    """Return the components of the singular set, or None where the Jacobian has lost rank everywhere.

    An empty tuple means that no configuration is singular.
    """
    return _components(derive(chain))


def for_special_lengths(chain: Chain) -> tuple[Component, ...]:
    """Return what more is singular where the lengths that are open are related to each other in a way of its own."""
    derivation = derive(chain)
    never = (conditions for conditions, holds in _filled(derivation, _zeros(derivation)) if not holds)
    found = (
        solved_together(conditions, chain) for conditions in never if sp.Tuple(*conditions).free_symbols - set(chain.q)
    )
    return tuple(dict.fromkeys(component for component in found if component is not None))


def never_vanishes(condition: sp.Expr, chain: Chain) -> bool:
    """Tell whether an expression is zero in no configuration, as 1.5 + 0.5 cos(theta2)."""
    return solved_together((condition,), chain) is None


def _components(derivation: Derivation) -> tuple[Component, ...] | None:
    zeros = _zeros(derivation)
    if zeros is None:
        return None
    components = []
    for conditions, holds in _filled(derivation, zeros):
        component = solved_together(conditions, derivation.chain) if holds else None
        if component is not None and component not in components:
            components.append(component)
    for one in reversed(components[:]):
        if any(other != one and _lies_in(one, other) for other in components):
            components.remove(one)  # one by one: of two that are the same, each lies in the other
    return tuple(components)


def _zeros(derivation: Derivation) -> Zeros:
    """Return the common zeros of the minors, in the symbols of the structure.

    They are looked for once for each structure; again, for an arm whose numbers make a constant zero that in general
    is none.
    """
    minors, joints = derivation.generic_minors, derivation.generic_joints
    zeros, taken = _zeros_in_general(minors, joints)

    def is_zero(constant: sp.Expr) -> bool:
        filled = derivation.fill(constant)
        drawn = {symbol: sp.Rational(7 + 4 * i, 11 + 6 * i) for i, symbol in enumerate(derivation.chain.parameters)}
        return bool(abs(sp.N(filled.xreplace(drawn), 30)) < _NOTHING)

    return common_zeros(minors, Search(joints, is_zero)) if any(map(is_zero, taken)) else zeros


def _filled(derivation: Derivation, zeros: Zeros) -> Iterator[tuple[tuple[sp.Expr, ...], bool]]:
    """Yield what vanishes together, with the numbers of the arm, and whether it may.

    What does so for lengths in general is not tried again with those of each arm. Of more conditions than it takes to
    lower the rank of a matrix of this shape, those that follow from the others are left out, where they do so with the
    arm's own numbers, too.
    """
    chain = derivation.chain
    enough = abs(chain.n - len(chain.task)) + 1
    for conjunction in zeros or ():
        conditions = tuple(derivation.fill(condition) for condition in conjunction)
        may = _hold_in_general(conjunction, derivation.generic_joints)
        may = may or may_hold_together(conditions, chain.q)
        if may and len(conjunction) > enough:
            needed = tuple(map(derivation.fill, _needed_in_general(conjunction, derivation.generic_joints)))
            needless = (condition for condition in conditions if condition not in needed)
            if conditions == conjunction or all(follows(c, needed, chain.q, MOST_ZEROS) for c in needless):
                conditions = needed
        yield conditions, may


@lru_cache(maxsize=4096)
def _needed_in_general(conjunction: Conjunction, joints: Joints) -> Conjunction:
    return without_needless(conjunction, joints, MOST_ZEROS)


@lru_cache(maxsize=4096)
def _hold_in_general(conjunction: tuple[sp.Expr, ...], joints: tuple[sp.Symbol, ...]) -> bool:
    return len(conjunction) == 1 or may_hold_together(conjunction, joints)


def _lies_in(component: Component, other: Component) -> bool:
    """Tell whether all joint values of a component are among those of another, which says nothing of more joints."""
    if component.solutions is None or other.solutions is None:
        return False
    ours = dict(component.solutions)
    return all(joint in ours and set(ours[joint]) <= set(values) for joint, values in other.solutions)


def solved_together(conditions: tuple[sp.Expr, ...], chain: Chain) -> Component | None:
    """Return the component, or None where the conditions have no real solution for the given numbers."""
    solutions = []
    tied = False
    for condition in conditions:
        solved = solve_condition(condition, chain)
        if solved is None:
            tied = True
            excess = _excess(condition, chain)
            if excess is not None and excess > 0:
                return None
            if excess == 0 and len(conditions) == 1 and (touched := _touched(condition, chain)) is not None:
                return touched
        elif not solved[1]:
            return None
        else:
            solutions.append(solved)
    return Component(conditions, None) if tied else _agreeing(conditions, tuple(solutions))


def _agreeing(conditions: tuple[sp.Expr, ...], solutions: tuple[Solved, ...]) -> Component | None:
    """Return the component, of two conditions that fix the same joint only the one that says more; None if they differ.

    They are told apart where their values are numbers.
    """
    for i, j in combinations(range(len(conditions)), 2):
        (joint, first), (other, second) = solutions[i], solutions[j]
        if joint == other and all(value.is_number for value in (*first, *second)):
            both = [value for value in first if value in second]
            if not both:
                return None
            needless = j if len(both) == len(first) else i if len(both) == len(second) else None
            if needless is not None:
                rest = [k for k in range(len(conditions)) if k != needless]
                return _agreeing(tuple(conditions[k] for k in rest), tuple(solutions[k] for k in rest))
    return Component(conditions, solutions)


def solve_condition(condition: sp.Expr, chain: Chain) -> tuple[sp.Symbol, tuple[sp.Expr, ...]] | None:
    """Solve one condition for its joint: (joint, values), no values if there is no real solution.

    Returns None where the condition ties several joints, or is of a form that no formula here solves.
    """
    joints = [q for q in chain.q if condition.has(q)]
    if len(joints) != 1:
        return None
    (joint,) = joints
    if chain.joints[chain.q.index(joint)].kind == "P":
        return _solve_polynomial(condition, joint)
    return _solve_angle(condition, joint)


def _solve_polynomial(condition: sp.Expr, joint: sp.Symbol) -> tuple[sp.Symbol, tuple[sp.Expr, ...]] | None:
    polynomial = sp.Poly(condition, joint)
    if polynomial.degree() == 1:
        a, b = polynomial.all_coeffs()
        return joint, (sp.together(-b / a),)
    if polynomial.degree() == 2 and not polynomial.free_symbols_in_domain:
        return joint, tuple(root for root in sp.roots(polynomial) if root.is_real)
    return None


@lru_cache(maxsize=4096)
def _solve_angle(condition: sp.Expr, joint: sp.Symbol) -> tuple[sp.Symbol, tuple[sp.Expr, ...]] | None:
    """Solve A + B cos(phi) + C sin(phi) = 0, phi being the joint's angle with its offset."""
    arguments = {atom.args[0] for atom in condition.atoms(sp.sin, sp.cos)}
    phi = arguments.pop() if len(arguments) == 1 else joint
    offset = sp.expand(phi - joint)
    if offset.has(joint):
        return None
    cosine, sine = sp.Dummy("c"), sp.Dummy("s")
    plain = sp.expand_trig(condition) if arguments else condition
    polynomial = sp.Poly(sp.expand(plain).xreplace({sp.cos(phi): cosine, sp.sin(phi): sine}), cosine, sine)
    if polynomial.total_degree() != 1 or polynomial.free_symbols & {joint}:
        return None
    a, b, c = (polynomial.coeff_monomial(monomial) for monomial in (1, cosine, sine))
    values = (principal(value - offset) for value in _roots_of_trig(a, b, c))
    return joint, tuple(dict.fromkeys(values))


def _roots_of_trig(a: sp.Expr, b: sp.Expr, c: sp.Expr) -> list[sp.Expr]:
    if a == 0:
        if b == 0:
            return [sp.S.Zero, sp.pi]
        if c == 0:
            return [sp.pi / 2, -sp.pi / 2]
        return [-sp.atan(b / c), sp.pi - sp.atan(b / c)]
    if b == 0 and c != 0:
        return [] if _exceeds(a, c) else [sp.asin(-a / c), sp.pi - sp.asin(-a / c)]
    if c == 0:
        return [] if _exceeds(a, b) else list(dict.fromkeys((sp.acos(-a / b), -sp.acos(-a / b))))
    radius, shift = sp.sqrt(b**2 + c**2), sp.atan2(c, b)
    return [] if _exceeds(a, radius) else [shift + sp.acos(-a / radius), shift - sp.acos(-a / radius)]


def _exceeds(a: sp.Expr, b: sp.Expr) -> bool:
    """Tell whether |a| > |b|, whatever the lengths are."""
    if a.is_number and b.is_number:
        return bool(abs(sp.N(a)) > abs(sp.N(b)))
    return bool(sp.expand(a**2 - b**2).is_positive)


def principal(angle: sp.Expr) -> sp.Expr:
    """Return the angle in (-pi, pi] where it is a number, by adding whole turns."""
    angle = sp.expand(angle)
    if not angle.is_number:
        return angle
    turns = -sp.floor((sp.N(angle, 30) + sp.N(sp.pi, 30)) / (2 * sp.N(sp.pi, 30)))
    moved = sp.expand(angle + 2 * sp.pi * turns)
    return sp.pi if moved == -sp.pi else moved


def _excess(condition: sp.Expr, chain: Chain) -> sp.Expr | None:
    """Return by how much the constant part of a sum of sines and cosines exceeds all amplitudes, None for others.

    Above zero the sum cannot vanish; at zero it can only where each of them is at an end of its range.
    """
    polynomial = _in_trigs(condition, chain)
    if polynomial is None:
        return None
    constant = polynomial.coeff_monomial(1)
    excess = 2 * abs(constant) - sum(abs(coefficient) for coefficient in polynomial.coeffs())
    number = sp.N(excess, 30)
    return sp.S.Zero if abs(number) < sp.Float("1e-20") and sp.simplify(excess) == 0 else number


def _touched(condition: sp.Expr, chain: Chain) -> Component | None:
    """Return the only configuration in which the sines and cosines of a sum with no excess cancel its constant part.

    As in 0.8 + 0.4 c2 + 0.4 c23, whose cosines both have to be -1. Returns None where that does not fix one value for
    each joint in it.
    """
    polynomial = _in_trigs(condition, chain)
    assert polynomial is not None
    if polynomial.total_degree() != 1:
        return None
    sign = sp.sign(polynomial.coeff_monomial(1))
    equations = []
    for trig in polynomial.gens:
        highest = sp.sign(polynomial.coeff_monomial(trig)) != sign
        crest = sp.S.Zero if isinstance(trig, sp.cos) else sp.pi / 2
        equations.append(trig.args[0] - crest - (0 if highest else sp.pi))
    joints = [q for q in chain.q if condition.has(q)]
    turns, rest = sp.linear_eq_to_matrix(equations, joints)
    if not turns.is_square or abs(turns.det()) != 1:  # several joint values, or none, lead to the same angles
        return None
    touched = [(q, principal(value)) for q, value in zip(joints, turns.inv() * rest, strict=True)]
    return Component(tuple(1 - sp.cos(q - value) for q, value in touched), tuple((q, (value,)) for q, value in touched))


def _in_trigs(condition: sp.Expr, chain: Chain) -> sp.Poly | None:
    """Return a condition in numbers and joint angles as a polynomial in its sines and cosines; None for others."""
    trigs = sorted(condition.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    plain = condition.xreplace({trig: sp.Dummy() for trig in trigs})
    if not trigs or condition.free_symbols - set(chain.q) or plain.free_symbols & set(chain.q):
        return None
    return sp.Poly(condition, *trigs)


# --- common zeros of several minors, on the structure (no offsets, lengths as symbols) ---

_AT = sp.Function("at")
"""Marks that a factor is zero at one of its roots, at(sin(theta2), pi), until its sibling is found to be, too."""

_TRIG = sp.Dummy("trig")


@dataclass(frozen=True)
class Search:
    """What the search for common zeros knows of an arm: its joints, and which constants are zero, as a1 - a2 may be.

    `taken` are the constants that were taken not to be.
    """

    joints: Joints
    is_zero: Callable[[sp.Expr], bool] = lambda _: False
    taken: set[sp.Expr] = field(default_factory=set)

    def moves(self, expression: sp.Expr) -> bool:
        """Tell whether joints change an expression."""
        return bool(expression.free_symbols & set(self.joints))

    def moving(self, product: Factored) -> list[sp.Expr] | None:
        """Return the factors that joints change, one of which vanishes where a product does; None where it is zero."""
        constants = [f for f, _ in product.factors if not self.moves(f) and not f.is_Symbol]
        if product.is_zero or any(map(self.is_zero, constants)):
            return None
        self.taken.update(constants)
        return [f for f, _ in product.factors if self.moves(f)]


@lru_cache(maxsize=4096)
def _zeros_in_general(minors: tuple[Factored, ...], joints: Joints) -> tuple[Zeros, frozenset[sp.Expr]]:
    """Return the zeros for lengths and twists that nothing is special about, and what was taken to be none."""
    search = Search(joints)
    return common_zeros(minors, search), frozenset(search.taken)


def common_zeros(minors: Sequence[Factored], search: Search) -> Zeros:
    """Return the ways in which minors vanish together. Raises TooLong."""
    factor_sets = [factors for minor in minors if (factors := search.moving(minor)) is not None]
    if not factor_sets:
        return None
    shared = [f for f in factor_sets[0] if all(f in other for other in factor_sets[1:])]
    left = [[f for f in factors if f not in shared] for factors in factor_sets]
    conjunctions: list[Conjunction] = [(f,) for f in shared]
    for leaf in _branches(left, search):
        conjunction = tuple(dict.fromkeys(leaf))
        if len(conjunctions) > MOST_WAYS:
            raise TooLong(f"the {len(factor_sets)} minors of J may vanish together in more than {MOST_WAYS} ways")
        if not any(f in conjunction for f in shared):
            conjunctions.append(conjunction)
    return tidied(conjunctions, search, f"the {len(factor_sets)} minors of J")


def tidied(conjunctions: Iterable[Conjunction], search: Search, what: str) -> list[Conjunction]:
    """Return ways in which something vanishes without what is told twice, follows, or is never there.

    Cases that differ in the root of a factor are one. Raises TooLong, which says what it is that vanishes.
    """
    merged = _merged(list(conjunctions))
    settled = [leaf for conjunction in merged for leaf in _settled(conjunction, search)]
    if settled != merged:
        merged = _merged(settled)
    if len(merged) > MOST_PARTS:
        raise TooLong(f"{what} vanish together in more than {MOST_PARTS} ways, too many to read")
    stated = [as_stated(conjunction) for conjunction in _without_special_cases(merged)]
    there = [conjunction for conjunction in stated if _is_there(list(conjunction), search)]
    return _without_subsumed([_without_needless(conjunction, search) for conjunction in there], search)


def _is_there(conditions: list[sp.Expr], search: Search) -> bool:
    """Tell whether conditions may hold together, for lengths that nothing is special about.

    Angles that some of them fix are put into the others; two that ask for both cosine and sine of one angle have to
    agree. What can't be decided so is taken to be there.
    """
    for condition in conditions:
        roots = _roots(condition, search)
        if roots:
            rest = [other for other in conditions if other != condition]
            return any(_is_there_at(rest, {joint: value}, search) for joint, value in roots)
    known: dict[sp.Expr, sp.Expr] = {}
    for condition in conditions:
        for trig, value in _known_trig(condition, search):
            known[trig] = value
            others = (_above(other.xreplace({trig: value})) for other in conditions if other != condition)
            if any(_free_factors(other, search) == [] for other in others):
                return False
    return not any(_are_apart(a, b, known, search) for a, b in combinations(conditions, 2))


def _above(condition: sp.Expr) -> sp.Expr:
    """Return what stands above the fraction bar: it is zero where the condition holds."""
    return sp.together(condition).as_numer_denom()[0]


def _is_there_at(conditions: list[sp.Expr], values: dict[sp.Symbol, sp.Expr], search: Search) -> bool:
    """Tell the same where a joint has a value: of each condition some factor that a joint changes has to vanish."""
    ways = [_free_factors(substitute(condition, values), search) for condition in conditions]
    return all(way != [] for way in ways) and any(
        _is_there(list(dict.fromkeys(chosen)), search) for chosen in product(*(way for way in ways if way is not None))
    )


def _free_factors(condition: sp.Expr, search: Search) -> list[sp.Expr] | None:
    """Return the factors that a joint changes, of which one vanishes where the condition holds; None where it holds."""
    return search.moving(factored(sp.expand(condition)))


def _known_trig(condition: sp.Expr, search: Search) -> Iterator[tuple[sp.Expr, sp.Expr]]:
    """Yield the only sine or cosine of joints in a condition with its value, as a1 + a2 cos(theta2) = 0 tells it."""
    moving = [trig for trig in condition.atoms(sp.sin, sp.cos) if search.moves(trig)]
    if len(moving) == 1:
        line = sp.Poly(sp.expand(condition).xreplace({moving[0]: _TRIG}), _TRIG)
        if line.degree() == 1 and not line.free_symbols_in_domain & set(search.joints):
            slope, rest = line.all_coeffs()
            if search.moving(factored(sp.expand(slope))) is not None:
                yield moving[0], -rest / slope


def _are_apart(one: sp.Expr, other: sp.Expr, known: dict[sp.Expr, sp.Expr], search: Search) -> bool:
    """Tell whether two conditions, both linear in cosine and sine of one angle, have no common solution."""
    angles = {atom.args[0] for atom in (*one.atoms(sp.sin, sp.cos), *other.atoms(sp.sin, sp.cos))}
    turning = sorted(filter(search.moves, angles), key=sp.default_sort_key)
    return any(_are_apart_at(one, other, angle, known, search) for angle in turning)


def _are_apart_at(one: sp.Expr, other: sp.Expr, angle: sp.Expr, known: dict[sp.Expr, sp.Expr], search: Search) -> bool:
    """Solve both for cosine and sine, whose squares have to add up to one; without constants, both would be zero."""
    cosine, sine = sp.Dummy("c"), sp.Dummy("s")
    circle = {sp.cos(angle): cosine, sp.sin(angle): sine}
    lines = [sp.Poly(sp.expand(condition).xreplace(circle), cosine, sine) for condition in (one, other)]
    if any(line.total_degree() != 1 for line in lines):
        return False
    a, b = ([line.coeff_monomial(monomial) for monomial in (cosine, sine, 1)] for line in lines)
    size = a[0] * b[1] - a[1] * b[0]
    if not any(map(search.moves, (*a, *b))):
        x, y = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2]
        return search.moving(factored(sp.expand(x**2 + y**2 - size**2))) is not None
    return a[2] == b[2] == 0 and _is_never_zero(size.xreplace(known), search)


def _is_never_zero(expression: sp.Expr, search: Search) -> bool:
    """Tell of a sum of squares, up to its sign, one of them of what no joint changes, that it is above zero.

    The same of one that has no real root as a quadratic in a sine, cosine or slide, as (3 cos(theta5) - 2)^2 + 9.
    """
    if _changes_sign(expression, search):
        return False
    plain = sp.expand(expression)
    trigs = plain.atoms(sp.sin, sp.cos)
    real = {
        atom: sp.Dummy(real=True) if search.moves(atom) else sp.Dummy(real=True, zero=False)
        for atom in (*trigs, *plain.free_symbols)
    }
    plain = plain.xreplace({trig: real[trig] for trig in trigs}).xreplace(real)
    if plain.is_positive or plain.is_negative:
        return True
    quadratics = [sp.Poly(plain, x) for x in plain.free_symbols if not x.is_nonzero]
    parts = (polynomial.all_coeffs() for polynomial in quadratics if polynomial.degree() == 2)
    return any(sp.expand(b**2 - 4 * a * c).is_negative for a, b, c in parts)


def _changes_sign(expression: sp.Expr, search: Search) -> bool:
    """Tell whether an expression has both signs for some real numbers in place of what joints change."""
    draws = Stream("signs")
    atoms = sorted(expression.atoms(sp.sin, sp.cos) | expression.free_symbols, key=ByText)
    signs = set()
    for _ in range(_SIGNS):
        values = {
            atom: sp.Float(draws.uniform(-3, 3) if search.moves(atom) else draws.uniform(0.2, 2)) for atom in atoms
        }
        number = expression.xreplace(values)
        signs.add(sp.sign(number) if number.is_Float and abs(number) > _CLEAR else 0)
    return {1, -1} <= signs


def _settled(conjunction: Conjunction, search: Search) -> Iterator[Conjunction]:
    """Yield what a conjunction comes to when what its conditions say of joints is put into the others.

    A long condition may have been taken before the one that fixes a joint in it: there it is shorter, has factors of
    its own, or follows from the others.
    """
    open_ones = [condition for condition in conjunction if getattr(condition, "func", None) != _AT]
    marks = [condition for condition in conjunction if condition not in open_ones]
    for one in (*marks, *open_ones):  # what has a value is never given another one
        put = _putting(one, search)
        moved = [c for c in open_ones if c != one and put is not None and put.is_in(c)]
        if put is None or not moved:
            continue
        ways = (_factors_with(put, condition, search) for condition in moved)
        kept = tuple(condition for condition in conjunction if condition not in moved)
        for leaf in _branches([way for way in ways if way is not None], search):
            yield from _settled(tuple(dict.fromkeys((*kept, *leaf))), search)
        return
    yield conjunction


def _putting(condition: sp.Expr, search: Search) -> Relation | None:
    """Return what a condition, or a mark, puts in the place of a joint, None where that is nothing for sure."""
    if getattr(condition, "func", None) != _AT:
        return relation_of(condition, search.joints, lambda constant: search.moving(factored(constant)) is not None)
    ((joint, value),) = _value_at(*condition.args).items()
    return Relation(joint, value)


def _factors_with(put: Relation, condition: sp.Expr, search: Search) -> list[sp.Expr] | None:
    """Return the factors of which one vanishes where a condition holds with what is put into it; None where it does."""
    factors = search.moving(factored(put.put_into(condition)))
    if factors is None:
        return None
    left = [factor for factor in factors if factor not in put.beside]
    return [piece for factor in left for piece in by_half_angle(factor, search.joints)]


def _without_special_cases(conjunctions: list[Conjunction]) -> list[Conjunction]:
    """Drop what says no more than another conjunction does at one root, as s2 = 0 at 0 in a1 + a2 c2 = 0."""
    kept = []
    for conjunction in conjunctions:
        marks = [case for case in conjunction if getattr(case, "func", None) == _AT]
        values = {}
        for mark in marks:
            values.update(_value_at(*mark.args))
        plain = [condition for condition in conjunction if condition not in marks]
        others = [other for other in conjunctions if other != conjunction and not any(o.has(_AT) for o in other)]
        if not marks or not any(all(_holds(condition, values, plain) for condition in other) for other in others):
            kept.append(conjunction)
    return kept


def _holds(condition: sp.Expr, values: dict[sp.Symbol, sp.Expr], known: list[sp.Expr]) -> bool:
    """Tell whether a condition follows from values of joints and conditions that are known, factor by factor."""
    if condition in known:
        return True
    moved = factored(sp.expand(substitute(condition, values)))
    return moved.is_zero or any(factor in known or -factor in known for factor, _ in moved.factors)


def _value_at(factor: sp.Expr, root: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """Return what a factor at one of its roots says of the joint that comes last in it."""
    angle = factor.args[0]
    joint = max(angle.free_symbols, key=lambda symbol: symbol.name)
    return {joint: sp.expand((root - angle) / sp.diff(angle, joint) + joint)}


def as_stated(conjunction: Conjunction) -> Conjunction:
    """Return conditions without marks: that an angle is at one root only, as 1 - cos(theta2) = 0 says of 0."""
    return tuple(
        1 - sp.cos(condition.args[0].args[0] - condition.args[1])
        if getattr(condition, "func", None) == _AT
        else condition
        for condition in conjunction
    )


def _branches(factor_sets: list[list[sp.Expr]], search: Search) -> Iterator[list[sp.Expr]]:
    """Yield combinations of conditions under which a factor of every set vanishes.

    A condition that fixes an angle is put into the other sets before the search goes on, so that what it makes
    vanish, or keeps from vanishing, is known. The simplest set goes first.
    """
    if any(not factors for factors in factor_sets):
        return
    if not factor_sets:
        yield []
        return
    factor_sets = sorted(factor_sets, key=lambda factors: (len(factors), sum(map(sp.count_ops, factors))))
    first, rest = factor_sets[0], factor_sets[1:]
    for factor in first:
        for condition, values in cases_of_zero(factor, search):
            tried = (_after(factors, factor, values, search) for factors in rest)
            remaining = [factors for factors in tried if factors is not None]
            yield from ([condition, *leaf] for leaf in _branches(remaining, search))


def cases_of_zero(factor: sp.Expr, search: Search) -> list[tuple[sp.Expr, dict[sp.Symbol, sp.Expr]]]:
    """Return the ways in which a factor vanishes: a condition to state and the substitution that it allows."""
    if isinstance(factor, (sp.sin, sp.cos)):
        angle = factor.args[0]
        joint = max((q for q in search.joints if angle.has(q)), key=search.joints.index)
        roots = (sp.S.Zero, sp.pi) if isinstance(factor, sp.sin) else (sp.pi / 2, -sp.pi / 2)
        sign = sp.diff(angle, joint)
        return [(_case(factor, root), {joint: sp.expand((root - angle) / sign + joint)}) for root in roots]
    return [(factor, {})]


def _case(factor: sp.Expr, root: sp.Expr) -> sp.Expr:
    """Return a mark for "this factor is zero at this root", to be merged with its sibling root later."""
    return _AT(factor, root)


def _after(
    factors: list[sp.Expr], zero: sp.Expr, values: dict[sp.Symbol, sp.Expr], search: Search
) -> list[sp.Expr] | None:
    """Return the factors that can still vanish, or None where the product vanishes already."""
    left: list[sp.Expr] = []
    for factor in factors:
        if factor == zero:
            return None
        moved = factored(sp.expand(substitute(factor, values))) if values else None
        if moved is None:
            left.append(factor)
            continue
        moving = search.moving(moved)
        if moving is None:
            return None
        left += moving
    return left


def _merged(conjunctions: list[Conjunction]) -> list[Conjunction]:
    """Join cases that differ in the root of one factor only, as in theta3 = 0 and theta3 = pi, into the factor."""
    sets = {frozenset(conjunction) for conjunction in conjunctions}
    text = lru_cache(maxsize=None)(str)
    changed = True
    while changed:
        changed = False
        for conjunction in sorted(sets, key=lambda c: sorted(map(text, c))):
            for case in conjunction:
                if getattr(case, "func", None) != _AT:
                    continue
                rest = conjunction - {case}
                siblings = {rest | {_AT(case.args[0], root)} for root in RIGHT_ANGLES} & sets
                if len(siblings) == 2:
                    sets = (sets - siblings) | {rest | {case.args[0]}}
                    changed = True
                    break
            if changed:
                break
    return [tuple(sorted(conjunction, key=lambda c: (sp.count_ops(c), sp.default_sort_key(c)))) for conjunction in sets]


def _without_needless(conjunction: Conjunction, search: Search) -> Conjunction:
    """Drop conditions that follow from the others, the longest first."""
    kept = conjunction
    for condition in sorted(conjunction, key=sp.count_ops, reverse=True):
        rest = tuple(other for other in kept if other != condition)
        if rest and _follows(condition, rest, search):
            kept = rest
    return kept


def _follows(condition: sp.Expr, given: Conjunction, search: Search) -> bool:
    """Tell whether a condition holds wherever the given ones do, as far as angles that they fix and factors show."""
    if condition in given:
        return True
    ways = [_roots(other, search) for other in given]
    fixing = [way for way in ways if way]
    plain = [other for other, way in zip(given, ways, strict=True) if not way]
    return bool(fixing) and all(_follows_at(condition, dict(values), plain, search) for values in product(*fixing))


def _follows_at(condition: sp.Expr, values: dict[sp.Symbol, sp.Expr], plain: list[sp.Expr], search: Search) -> bool:
    """Tell whether a condition follows where joints have values, whichever factor of each other condition vanishes."""
    ways = [_free_factors(substitute(other, values), search) for other in plain]
    return all(_holds(condition, values, list(known)) for known in product(*(way for way in ways if way is not None)))


_WHERE: dict[tuple[type[sp.Expr], int], tuple[sp.Expr, ...]] = {
    (sp.sin, 0): (sp.S.Zero, sp.pi), (sp.sin, 1): (sp.pi / 2,), (sp.sin, -1): (-sp.pi / 2,),
    (sp.cos, 0): (sp.pi / 2, -sp.pi / 2), (sp.cos, 1): (sp.S.Zero,), (sp.cos, -1): (sp.pi,),
}  # fmt: skip
"""Where a sine or cosine is zero, or at an end of its range."""


def _roots(condition: sp.Expr, search: Search) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the joint that a condition fixes by itself with each of its values; nothing where it ties several."""
    trig, at_end = condition, 0
    for end, rest in ((1, 1 - condition), (-1, condition - 1)):
        if condition.is_Add and isinstance(rest, (sp.sin, sp.cos)):
            trig, at_end = rest, end
    if not isinstance(trig, (sp.sin, sp.cos)) or len(trig.free_symbols & set(search.joints)) != 1:
        return []
    roots = _WHERE[trig.func, at_end]
    return [item for root in roots for item in _value_at(trig, root).items()]


def _without_subsumed(conjunctions: list[Conjunction], search: Search) -> list[Conjunction]:
    """Drop what lies in another conjunction, and what is there twice."""
    kept = list(dict.fromkeys(c for c in conjunctions if not any(set(o) < set(c) for o in conjunctions)))
    for one in sorted(kept, key=lambda c: (len(c), sp.count_ops(sp.Add(*c))), reverse=True):
        others = (other for other in kept if other != one)
        if any(all(_follows(condition, one, search) for condition in other) for other in others):
            kept.remove(one)  # one by one: of two that are the same, each lies in the other
    return sorted(kept, key=lambda c: (len(c), sp.count_ops(sp.Add(*c)), [sp.default_sort_key(x) for x in c]))
