"""All singular configurations of a chain for its task: where the task Jacobian loses rank (6.8).

For a square Jacobian these are the zeros of the factors of det J. For any other shape they are the common zeros of all
maximal minors: factors that all minors share, and combinations of conditions for the remaining factors.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import Derivation, TooLong, derive
from qdot.exercises.arm.joint_solvability import drop_implied, follows, may_hold_together
from qdot.exercises.arm.trigonometry import Factored, factor_trig, substitute

MOST_WAYS, MOST_PARTS = 300, 40
"""Ways in which minors vanish together that are examined at most, and ways that anyone would read."""
MOST_ZEROS = 10_000
"""Work allowed for proving that long conditions follow from others, as `joint_solvability` counts it."""
_NOTHING = sp.Float("1e-20")
RIGHT_ANGLES = (sp.S.Zero, sp.pi / 2, sp.pi, -sp.pi / 2)


Joints = tuple[sp.Symbol, ...]
Conjunction = tuple[sp.Expr, ...]
Solved = tuple[sp.Symbol, tuple[sp.Expr, ...]]
"""A joint, and its values at which a condition holds."""
Values = tuple[tuple[sp.Symbol, sp.Expr], ...]
"""Joints with their values."""
Zeros = list[Conjunction] | None
"""Conditions under which all minors vanish together; None if they always do."""


@dataclass(frozen=True)
class Component:
    """A part of the singular set: expressions that vanish together, and the joint values at which they do.

    `solutions` holds (joint, values) for each condition, or is None if one of them ties several joints.
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
        return [" and ".join(f"{joint} = {value}" for joint, value in each) for each in self.value_combinations()]

    def value_combinations(self) -> list[Values]:
        """Return every combination of joint values at which the conditions hold; none if they tie joints."""
        if self.solutions is None:
            return []
        pairs = ([(joint, value) for value in values] for joint, values in self.solutions)
        return list(product(*pairs))

    def at(self, values: Values) -> "Component":
        """Return the part at which joints have these values."""
        return Component(self.conditions, tuple((joint, (value,)) for joint, value in values))


@lru_cache(maxsize=256)
def singular_set(chain: Chain) -> tuple[Component, ...] | None:
    """Return the components of the singular set, or None if the Jacobian has lost rank everywhere.

    An empty tuple means that no configuration is singular.
    """
    return _components(derive(chain))


def special_length_components(chain: Chain) -> tuple[Component, ...]:
    """Return further components that exist only if the open lengths are related in special ways."""
    derivation = derive(chain)
    inverse = sp.Symbol("d_inverse")
    components = []
    for conditions, holds in _substitute_values(derivation, _zeros(derivation)):
        lengths = sorted(sp.Tuple(*conditions).free_symbols - set(chain.q), key=str)
        if holds or not lengths:
            continue
        nonzero_lengths = 1 - inverse * sp.Mul(*lengths)
        if may_hold_together([*conditions, nonzero_lengths], (*chain.q, *lengths, inverse)):
            components.append(solve_conjunction(conditions, chain))
    return tuple(dict.fromkeys(component for component in components if component is not None))


def never_vanishes(condition: sp.Expr, chain: Chain) -> bool:
    """Tell whether an expression is zero in no configuration, as 1.5 + 0.5 cos(theta2)."""
    return solve_conjunction((condition,), chain) is None


def _components(derivation: Derivation) -> tuple[Component, ...] | None:
    zeros = _zeros(derivation)
    if zeros is None:
        return None
    components = []
    for conditions, holds in _substitute_values(derivation, zeros):
        component = solve_conjunction(conditions, derivation.chain) if holds else None
        if component is not None and component not in components:
            components.append(component)
    for part in reversed(components[:]):
        if any(whole != part and _lies_in(part, whole) for whole in components):
            components.remove(part)  # one by one: of two that are the same, each lies in the other
    return tuple(components)


def _zeros(derivation: Derivation) -> Zeros:
    """Return the common zeros of the minors, in the symbols of the structure.

    The search runs once for each structure, and again for an arm whose numbers make zero a constant that is generically
    nonzero.
    """
    minors, joints = derivation.generic_minors, derivation.generic_joints
    zeros, taken = _zeros_in_general(minors, joints)

    def is_zero(constant: sp.Expr) -> bool:
        filled = derivation.fill(constant)
        drawn = {symbol: sp.Rational(7 + 4 * i, 11 + 6 * i) for i, symbol in enumerate(derivation.chain.parameters)}
        return bool(abs(sp.N(filled.xreplace(drawn), 30)) < _NOTHING)

    return common_zeros(minors, Search(joints, is_zero)) if any(map(is_zero, taken)) else zeros


def _substitute_values(derivation: Derivation, zeros: Zeros) -> Iterator[tuple[tuple[sp.Expr, ...], bool]]:
    """Yield the conditions that vanish together, with the numbers of the arm, and whether they can.

    If they can for generic lengths, they are not tested again with those of the arm. If there are more conditions than
    it takes to lower the rank of a matrix of this shape, those that follow from the others are left out, provided that
    they also follow with the arm's own numbers.
    """
    chain = derivation.chain
    enough = abs(chain.n - len(chain.task)) + 1
    for conjunction in zeros or ():
        conditions = tuple(derivation.fill(condition) for condition in conjunction)
        may = _hold_in_general(conjunction, derivation.generic_joints)
        may = may or may_hold_together(conditions, chain.q)
        if may and len(conjunction) > enough:
            needed = tuple(map(derivation.fill, _drop_implied_in_general(conjunction, derivation.generic_joints)))
            needless = (condition for condition in conditions if condition not in needed)
            if conditions == conjunction or all(follows(c, needed, chain.q, MOST_ZEROS) for c in needless):
                conditions = needed
        yield conditions, may


@lru_cache(maxsize=4096)
def _drop_implied_in_general(conjunction: Conjunction, joints: Joints) -> Conjunction:
    return drop_implied(conjunction, joints, MOST_ZEROS)


@lru_cache(maxsize=4096)
def _hold_in_general(conjunction: tuple[sp.Expr, ...], joints: tuple[sp.Symbol, ...]) -> bool:
    return len(conjunction) == 1 or may_hold_together(conjunction, joints)


def _lies_in(component: Component, whole: Component) -> bool:
    """Tell whether all joint values of a component are among those of another that constrains no further joints."""
    if component.solutions is None or whole.solutions is None:
        return False
    ours = dict(component.solutions)
    return all(joint in ours and set(ours[joint]) <= set(values) for joint, values in whole.solutions)


def solve_conjunction(conditions: tuple[sp.Expr, ...], chain: Chain) -> Component | None:
    """Return the component, or None if the conditions have no real solution for the arm's numbers."""
    solutions = []
    tied = False
    for condition in conditions:
        solved = solve_condition(condition, chain)
        if solved is None:
            tied = True
            excess = _excess(condition, chain)
            if excess is not None and excess > 0:
                return None
            if excess == 0 and len(conditions) == 1 and (touched := _single_solution(condition, chain)) is not None:
                return touched
        elif not solved[1]:
            return None
        else:
            solutions.append(solved)
    return Component(conditions, None) if tied else _merge_solutions(conditions, tuple(solutions))


def _merge_solutions(conditions: tuple[sp.Expr, ...], solutions: tuple[Solved, ...]) -> Component | None:
    """Return the component with the stronger of two conditions that fix the same joint; None if they contradict.

    Values are compared if they are numbers.
    """
    for i, j in combinations(range(len(conditions)), 2):
        (joint, first), (second_joint, second) = solutions[i], solutions[j]
        if joint == second_joint and all(value.is_number for value in (*first, *second)):
            both = [value for value in first if value in second]
            if not both:
                return None
            needless = j if len(both) == len(first) else i if len(both) == len(second) else None
            if needless is not None:
                rest = [k for k in range(len(conditions)) if k != needless]
                return _merge_solutions(tuple(conditions[k] for k in rest), tuple(solutions[k] for k in rest))
    return Component(conditions, solutions)


def solve_condition(condition: sp.Expr, chain: Chain) -> tuple[sp.Symbol, tuple[sp.Expr, ...]] | None:
    """Solve one condition for its joint: (joint, values), no values if there is no real solution.

    Returns None if the condition ties several joints, or has a form that no formula here solves.
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
    values = (principal_angle(value - offset) for value in _roots_of_trig(a, b, c))
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


def principal_angle(angle: sp.Expr) -> sp.Expr:
    """Return the angle in (-pi, pi], by adding full turns, if it is a number."""
    angle = sp.expand(angle)
    if not angle.is_number:
        return angle
    turns = -sp.floor((sp.N(angle, 30) + sp.N(sp.pi, 30)) / (2 * sp.N(sp.pi, 30)))
    moved = sp.expand(angle + 2 * sp.pi * turns)
    return sp.pi if moved == -sp.pi else moved


def _excess(condition: sp.Expr, chain: Chain) -> sp.Expr | None:
    """Return by how much the constant part of a sum of sines and cosines exceeds all amplitudes; None for other sums.

    Above zero the sum cannot vanish; at zero it can only if each sine and cosine is at an end of its range.
    """
    polynomial = _trig_polynomial(condition, chain)
    if polynomial is None:
        return None
    constant = polynomial.coeff_monomial(1)
    excess = 2 * abs(constant) - sum(abs(coefficient) for coefficient in polynomial.coeffs())
    number = sp.N(excess, 30)
    return sp.S.Zero if abs(number) < sp.Float("1e-20") and sp.simplify(excess) == 0 else number


def _single_solution(condition: sp.Expr, chain: Chain) -> Component | None:
    """Return the only configuration in which the sines and cosines of a sum with zero excess cancel its constant part.

    As in 0.8 + 0.4 c2 + 0.4 c23, whose cosines both have to be -1. Returns None if that does not fix one value for each
    joint in it.
    """
    polynomial = _trig_polynomial(condition, chain)
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
    touched = [(q, principal_angle(value)) for q, value in zip(joints, turns.inv() * rest, strict=True)]
    return Component(tuple(1 - sp.cos(q - value) for q, value in touched), tuple((q, (value,)) for q, value in touched))


def _trig_polynomial(condition: sp.Expr, chain: Chain) -> sp.Poly | None:
    """Return a condition in numbers and joint angles as a polynomial in its sines and cosines; None for others."""
    trigs = sorted(condition.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    plain = condition.xreplace({trig: sp.Dummy() for trig in trigs})
    if not trigs or condition.free_symbols - set(chain.q) or plain.free_symbols & set(chain.q):
        return None
    return sp.Poly(condition, *trigs)


# --- common zeros of several minors, on the structure (no offsets, lengths as symbols) ---

_AT = sp.Function("at")
"""Marks that a factor is zero at one of its roots, at(sin(theta2), pi), until the other root is found, too."""


def _is_mark(condition: sp.Expr) -> bool:
    return getattr(condition, "func", None) == _AT


@dataclass(frozen=True)
class Search:
    """What the search for common zeros knows about an arm: its joints, and which constants are zero, as a1 - a2 may be.

    `taken` collects the constants that were assumed nonzero.
    """

    joints: Joints
    is_zero: Callable[[sp.Expr], bool] = lambda _: False
    taken: set[sp.Expr] = field(default_factory=set)

    def moves(self, expression: sp.Expr) -> bool:
        """Tell whether joints change an expression."""
        return bool(expression.free_symbols & set(self.joints))

    def moving_factors(self, product: Factored) -> list[sp.Expr] | None:
        """Return the factors that contain joints, one of which vanishes where the product does; None if it is zero."""
        constants = [f for f, _ in product.factors if not self.moves(f) and not f.is_Symbol]
        if product.is_zero or any(map(self.is_zero, constants)):
            return None
        self.taken.update(constants)
        return [f for f, _ in product.factors if self.moves(f)]


@lru_cache(maxsize=4096)
def _zeros_in_general(minors: tuple[Factored, ...], joints: Joints) -> tuple[Zeros, frozenset[sp.Expr]]:
    """Return the zeros for generic lengths and twists, and the constants that were assumed nonzero."""
    search = Search(joints)
    return common_zeros(minors, search), frozenset(search.taken)


def common_zeros(minors: Sequence[Factored], search: Search) -> Zeros:
    """Return the ways in which minors vanish together. Raises TooLong."""
    factor_sets = [factors for minor in minors if (factors := search.moving_factors(minor)) is not None]
    if not factor_sets:
        return None
    shared = [f for f in factor_sets[0] if all(f in factors for factors in factor_sets[1:])]
    left = [[f for f in factors if f not in shared] for factors in factor_sets]
    conjunctions: list[Conjunction] = [(f,) for f in shared]
    for leaf in _branches(left, search):
        conjunction = tuple(dict.fromkeys(leaf))
        if len(conjunctions) > MOST_WAYS:
            raise TooLong(f"the {len(factor_sets)} minors of J may vanish together in more than {MOST_WAYS} ways")
        if not any(f in conjunction for f in shared):
            conjunctions.append(conjunction)
    return tidy_ways(conjunctions, search, f"the {len(factor_sets)} minors of J")


def tidy_ways(conjunctions: Iterable[Conjunction], search: Search, what: str) -> list[Conjunction]:
    """Return ways in which something vanishes without duplicates and implied conditions.

    Cases that differ in the root of a factor are merged. Raises TooLong with `what` vanishes.
    """
    merged = _merge_roots(list(conjunctions))
    if len(merged) > MOST_PARTS:
        raise TooLong(f"{what} vanish together in more than {MOST_PARTS} ways, too many to read")
    stated = [state_conditions(conjunction) for conjunction in merged]
    return _drop_subsumed([_drop_implied(conjunction, search) for conjunction in stated], search)


def _free_factors(condition: sp.Expr, search: Search) -> list[sp.Expr] | None:
    """Return the factors with joints, one of which vanishes where the condition holds; None if it always does."""
    return search.moving_factors(factor_trig(sp.expand(condition)))


def _holds(condition: sp.Expr, values: dict[sp.Symbol, sp.Expr], known: list[sp.Expr]) -> bool:
    """Tell whether a condition follows from joint values and known conditions, factor by factor."""
    if condition in known:
        return True
    substituted = factor_trig(sp.expand(substitute(condition, values)))
    return substituted.is_zero or any(factor in known or -factor in known for factor, _ in substituted.factors)


def _value_at(factor: sp.Expr, root: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """Return the value of the last joint in a factor at one of its roots."""
    angle = factor.args[0]
    joint = max(angle.free_symbols, key=lambda q: (q.name.startswith("theta"), len(q.name), q.name))
    return {joint: sp.expand((root - angle) / sp.diff(angle, joint) + joint)}


def state_conditions(conjunction: Conjunction) -> Conjunction:
    """Return conditions without marks: 1 - cos(theta2) = 0 says that the angle is at the root 0 only."""
    return tuple(
        1 - sp.cos(condition.args[0].args[0] - condition.args[1]) if _is_mark(condition) else condition
        for condition in conjunction
    )


def _branches(factor_sets: list[list[sp.Expr]], search: Search) -> Iterator[list[sp.Expr]]:
    """Yield combinations of conditions under which a factor of every set vanishes.

    A condition that fixes an angle is substituted into the other sets before the search continues, so that it is known
    what it makes vanish, or keeps from vanishing. The simplest set comes first.
    """
    if any(not factors for factors in factor_sets):
        return
    if not factor_sets:
        yield []
        return
    factor_sets = sorted(factor_sets, key=lambda factors: (len(factors), sum(map(sp.count_ops, factors))))
    first, rest = factor_sets[0], factor_sets[1:]
    for factor in first:
        for condition, values in cases_of_zero(factor):
            tried = (_remaining_factors(factors, factor, values, search) for factors in rest)
            remaining = [factors for factors in tried if factors is not None]
            yield from ([condition, *leaf] for leaf in _branches(remaining, search))


def cases_of_zero(factor: sp.Expr) -> list[tuple[sp.Expr, dict[sp.Symbol, sp.Expr]]]:
    """Return the ways in which a factor vanishes: a condition to state and the substitution that it allows."""
    if isinstance(factor, (sp.sin, sp.cos)):
        return [(_AT(factor, root), _value_at(factor, root)) for root in _WHERE[factor.func, 0]]
    return [(factor, {})]


def _remaining_factors(
    factors: list[sp.Expr], zero: sp.Expr, values: dict[sp.Symbol, sp.Expr], search: Search
) -> list[sp.Expr] | None:
    """Return the factors that can still vanish, or None if the product vanishes already."""
    left: list[sp.Expr] = []
    for factor in factors:
        if factor == zero:
            return None
        substituted = factor_trig(sp.expand(substitute(factor, values))) if values else None
        if substituted is None:
            left.append(factor)
            continue
        moving = search.moving_factors(substituted)
        if moving is None:
            return None
        left += moving
    return left


def _merge_roots(conjunctions: list[Conjunction]) -> list[Conjunction]:
    """Merge cases that differ only in the root of one factor, as theta3 = 0 and theta3 = pi, into the factor."""
    sets = {frozenset(conjunction) for conjunction in conjunctions}
    text = lru_cache(maxsize=None)(str)

    def mergeable_cases() -> tuple[set[frozenset[sp.Expr]], frozenset[sp.Expr]] | None:
        for conjunction in sorted(sets, key=lambda c: sorted(map(text, c))):
            for case in filter(_is_mark, conjunction):
                rest = conjunction - {case}
                siblings = {rest | {_AT(case.args[0], root)} for root in RIGHT_ANGLES} & sets
                if len(siblings) == 2:
                    return siblings, rest | {case.args[0]}
        return None

    while (cases := mergeable_cases()) is not None:
        sets = (sets - cases[0]) | {cases[1]}
    return [tuple(sorted(conjunction, key=lambda c: (sp.count_ops(c), sp.default_sort_key(c)))) for conjunction in sets]


def _drop_implied(conjunction: Conjunction, search: Search) -> Conjunction:
    """Drop conditions that follow from the others, the longest first."""
    kept = conjunction
    for condition in sorted(conjunction, key=sp.count_ops, reverse=True):
        rest = tuple(remaining for remaining in kept if remaining != condition)
        if rest and _follows(condition, rest, search):
            kept = rest
    return kept


def _follows(condition: sp.Expr, premises: Conjunction, search: Search) -> bool:
    """Tell whether a condition holds wherever the premises do, as far as angles that they fix and factors show."""
    if condition in premises:
        return True
    ways = [_roots(premise, search) for premise in premises]
    fixing = [way for way in ways if way]
    plain = [premise for premise, way in zip(premises, ways, strict=True) if not way]
    return bool(fixing) and all(_follows_at(condition, dict(values), plain, search) for values in product(*fixing))


def _follows_at(condition: sp.Expr, values: dict[sp.Symbol, sp.Expr], plain: list[sp.Expr], search: Search) -> bool:
    """Tell whether a condition follows at joint values, whichever factor of each premise vanishes."""
    ways = [_free_factors(substitute(premise, values), search) for premise in plain]
    return all(_holds(condition, values, list(known)) for known in product(*(way for way in ways if way is not None)))


_WHERE: dict[tuple[type[sp.Expr], int], tuple[sp.Expr, ...]] = {
    (sp.sin, 0): (sp.S.Zero, sp.pi), (sp.sin, 1): (sp.pi / 2,), (sp.sin, -1): (-sp.pi / 2,),
    (sp.cos, 0): (sp.pi / 2, -sp.pi / 2), (sp.cos, 1): (sp.S.Zero,), (sp.cos, -1): (sp.pi,),
}  # fmt: skip
"""The angles at which a sine or cosine is zero, or at an end of its range."""


def _roots(condition: sp.Expr, search: Search) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the joint that a condition alone fixes with each of its values; nothing if it ties several joints."""
    trig, at_end = condition, 0
    for end, rest in ((1, 1 - condition), (-1, condition - 1)):
        if condition.is_Add and isinstance(rest, (sp.sin, sp.cos)):
            trig, at_end = rest, end
    if not isinstance(trig, (sp.sin, sp.cos)) or len(trig.free_symbols & set(search.joints)) != 1:
        return []
    roots = _WHERE[trig.func, at_end]
    return [item for root in roots for item in _value_at(trig, root).items()]


def _drop_subsumed(conjunctions: list[Conjunction], search: Search) -> list[Conjunction]:
    """Drop conjunctions that lie in another one, and duplicates."""
    kept = list(dict.fromkeys(c for c in conjunctions if not any(set(o) < set(c) for o in conjunctions)))
    for narrow in sorted(kept, key=lambda c: (len(c), sp.count_ops(sp.Add(*c))), reverse=True):
        others = (wide for wide in kept if wide != narrow)
        if any(all(_follows(condition, narrow, search) for condition in wide) for wide in others):
            kept.remove(narrow)  # one by one: of two that are the same, each lies in the other
    return sorted(kept, key=lambda c: (len(c), sp.count_ops(sp.Add(*c)), [sp.default_sort_key(x) for x in c]))
