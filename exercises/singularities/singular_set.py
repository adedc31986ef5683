"""Find the singular configurations of an arm for its task, at which the task Jacobian loses rank, as in equation (6.8).

For a square Jacobian, the singular configurations are the zeros of the factors of det J. For another shape, they are
the common zeros of all maximal minors: the zeros of common factors of all minors, and configurations at which several
conditions together make all minors zero. The search uses the minors of the symbolic arm (`derivation`), which has
symbols for all lengths and oblique angles.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.arm.trigonometry import Factored, factor_trig, wrap_angle
from qdot.exercises.derivation.derivation import Derivation, TooLong, derive
from qdot.exercises.singularities.joint_solvability import (
    drop_implied,
    drop_redundant,
    is_implied,
    may_hold_simultaneously,
)

MAX_EXAMINED_BRANCHES, MAX_BRANCHES = 300, 40
"""Maximum number of branches that are examined, and maximum number that is listed for a person to read. A branch is a
conjunction of conditions that makes all minors zero.
"""
MAX_ZEROS_FOR_IMPLICATION = 10_000
"""The limit `max_zeros` (`joint_solvability`) for proving that long conditions follow from others."""
_ZERO_TOLERANCE = sp.Float("1e-20")
"""A constant counts as zero if it is below this limit for the arm's numbers."""
_TRIG_ROOTS: dict[tuple[type[sp.Expr], int], tuple[sp.Expr, ...]] = {
    (sp.sin, 0): (sp.S.Zero, sp.pi), (sp.sin, 1): (sp.pi / 2,), (sp.sin, -1): (-sp.pi / 2,),
    (sp.cos, 0): (sp.pi / 2, -sp.pi / 2), (sp.cos, 1): (sp.S.Zero,), (sp.cos, -1): (sp.pi,),
}  # fmt: skip
"""Maps sine or cosine and one of its values 0, 1 and -1 to the angles at which it has this value."""

Joints = tuple[sp.Symbol, ...]
"""The joint variables of an arm."""
Conjunction = tuple[sp.Expr, ...]
"""Expressions that are zero simultaneously. Each expression stands for the condition that it is zero, and is called a
condition for short."""
JointSolution = tuple[sp.Symbol, tuple[sp.Expr, ...]]
"""A joint variable, and its values (rad or m) at which a condition holds."""
ValueCombination = tuple[tuple[sp.Symbol, sp.Expr], ...]
"""One value (rad or m) for each of several joint variables."""
JointValues = dict[sp.Symbol, sp.Expr]
"""Maps the joint variables that a condition fixes to their values."""
Zeros = list[Conjunction] | None
"""The conjunctions that make all minors zero; None if the minors are always zero."""


@dataclass(frozen=True)
class Component:
    """A component of the singular set: conditions that hold simultaneously, and the joint values at which they hold.

    `solutions` has a joint variable and its values for each condition. It is None if a condition involves several
    joints.
    """

    conditions: tuple[sp.Expr, ...]
    solutions: tuple[JointSolution, ...] | None

    @property
    def has_constant_values(self) -> bool:
        """Whether the conditions hold at real joint values that depend neither on lengths nor on other joints."""
        values = [value for _, joint_values in self.solutions or () for value in joint_values]
        return bool(values) and all(value.is_number and value.is_real for value in values)

    def list_pieces(self) -> list[str]:
        """Return the pieces of the component as text: a condition for each value, or for each combination of values.

        >>> Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi)),)).list_pieces()
        ['theta2 = 0', 'theta2 = pi']
        """
        if self.solutions is None:
            return [" and ".join(f"{condition} = 0" for condition in self.conditions)]
        value_combinations = self.list_value_combinations()
        return [" and ".join(f"{joint} = {value}" for joint, value in values) for values in value_combinations]

    def list_value_combinations(self) -> list[ValueCombination]:
        """Return every combination of joint values at which the conditions hold; [] if `solutions` is None."""
        if self.solutions is None:
            return []
        pairs = ([(joint, value) for value in values] for joint, values in self.solutions)
        return list(product(*pairs))

    def map_values(self, change: Callable[[sp.Symbol, sp.Expr], sp.Expr]) -> "Component":
        """Return this component with each joint value replaced by `change(joint, value)`."""
        solutions = self.solutions and tuple(
            (joint, tuple(change(joint, value) for value in values)) for joint, values in self.solutions
        )
        return replace(self, solutions=solutions)

    def restrict_to(self, values: ValueCombination) -> "Component":
        """Return the part of this component at which the joints have these values."""
        return Component(self.conditions, tuple((joint, (value,)) for joint, value in values))


@lru_cache(maxsize=256)
def find_singular_set(chain: Chain) -> tuple[Component, ...] | None:
    """Return the components of an arm's singular set; None if every configuration is singular.

    An empty tuple means that no configuration is singular.
    """
    return _find_components(derive(chain))


def find_zero_set(expressions: Sequence[sp.Expr], chain: Chain, is_symbolic: bool) -> tuple[Component, ...] | None:
    """Return the components of the configurations at which expressions vanish together; None if they always do.

    The expressions contain the symbols of the arm or, if `is_symbolic`, of the symbolic arm. Raises TooLong, and
    ValueError for expressions that can't be factored.
    """
    derivation = derive(chain)
    factored_expressions = tuple(factor_trig(sp.expand(expression)) for expression in expressions)
    if is_symbolic:
        zeros = _find_zeros(derivation, factored_expressions)
        conjunctions = zeros and [tuple(map(derivation.substitute_values, conditions)) for conditions in zeros]
    else:
        conjunctions = find_common_zeros(factored_expressions, Search(chain.q))
    if conjunctions is None:
        return None
    components = (solve_conjunction(_insert_prismatic_values(conditions, chain), chain) for conditions in conjunctions)
    return tuple(dict.fromkeys(component for component in components if component is not None))


def _insert_prismatic_values(conditions: tuple[sp.Expr, ...], chain: Chain) -> tuple[sp.Expr, ...]:
    """Return conditions with the value of a prismatic joint substituted if one of the conditions determines it."""
    new_conditions = conditions
    for condition in conditions:
        joint, values = solve_condition(condition, chain) or (None, ())
        if joint is not None and len(values) == 1 and chain.joints[chain.q.index(joint)].is_prismatic:
            other_conditions = (other for other in new_conditions if other is not condition)
            substituted = (sp.expand(other.xreplace({joint: values[0]})) for other in other_conditions)
            new_conditions = (condition, *(other for other in substituted if other != 0))
    return new_conditions


def find_special_length_components(chain: Chain) -> tuple[Component, ...]:
    """Return components that contain configurations only if the lengths satisfy a special relation."""
    derivation = derive(chain)
    inverse = sp.Symbol("d_inverse")  # if 1 = inverse * product of lengths, no length is zero
    components = []
    for conditions, is_possible in _substitute_values(derivation, _find_zeros(derivation, derivation.symbolic_minors)):
        lengths = sorted(sp.Tuple(*conditions).free_symbols - set(chain.q), key=str)
        nonzero_lengths = 1 - inverse * sp.Mul(*lengths)
        unknowns = (*chain.q, *lengths, inverse)
        if not is_possible and lengths and may_hold_simultaneously([*conditions, nonzero_lengths], unknowns):
            components.append(solve_conjunction(conditions, chain))
    return tuple(dict.fromkeys(component for component in components if component is not None))


def never_vanishes(condition: sp.Expr, chain: Chain) -> bool:
    """Return whether a condition holds at no configuration, as 1.5 + 0.5 cos(theta2) is never zero."""
    return solve_conjunction((condition,), chain) is None


def _find_components(derivation: Derivation) -> tuple[Component, ...] | None:
    """Return the components of the singular set, none inside another; None if every configuration is singular."""
    zeros = _find_zeros(derivation, derivation.symbolic_minors)
    if zeros is None:
        return None
    components = []
    for conditions, is_possible in _substitute_values(derivation, zeros):
        component = solve_conjunction(conditions, derivation.chain) if is_possible else None
        if component is not None and component not in components:
            components.append(component)
    for component in reversed(components[:]):
        if any(other != component and _is_contained(component, other) for other in components):
            components.remove(component)  # removed immediately, because each of two equal components lies in the other
    return tuple(components)


def _find_zeros(derivation: Derivation, expressions: tuple[Factored, ...]) -> Zeros:
    """Return the common zeros of the symbolic arm's minors, or of other expressions in its symbols.

    The search runs once for each symbolic arm. It is repeated for an arm whose numbers make a constant zero that the
    search assumed to be nonzero.
    """
    joints = derivation.symbolic_joints
    zeros, assumed_nonzero = _search_zeros(expressions, joints)
    if not assumed_nonzero:
        return zeros
    is_zero = make_zero_test(derivation.chain, derivation.substitute_values)
    return find_common_zeros(expressions, Search(joints, is_zero)) if any(map(is_zero, assumed_nonzero)) else zeros


def make_zero_test(chain: Chain, substitute_values: Callable[[sp.Expr], sp.Expr]) -> Callable[[sp.Expr], bool]:
    """Return a function that tests whether a constant is zero for the arm's numbers, given by `substitute_values`."""
    # a different fraction for each symbolic length, so that no constant is zero by chance
    lengths = {symbol: sp.Rational(7 + 4 * i, 11 + 6 * i) for i, symbol in enumerate(chain.parameters)}
    return lambda constant: bool(abs(sp.N(substitute_values(constant).xreplace(lengths), 30)) < _ZERO_TOLERANCE)


def _substitute_values(derivation: Derivation, zeros: Zeros) -> Iterator[tuple[tuple[sp.Expr, ...], bool]]:
    """Yield each conjunction with the arm's numbers, and whether its conditions can hold simultaneously.

    If the conditions can hold simultaneously for the symbolic arm, they are not tested again with the arm's numbers. A
    conjunction may have more conditions than are needed to lower the rank of J. Then conditions that follow from the
    others are dropped if they also follow with the arm's numbers.
    """
    chain, joints = derivation.chain, derivation.symbolic_joints
    needed_count = abs(chain.n - len(chain.task)) + 1
    for conjunction in zeros or ():
        conditions = tuple(derivation.substitute_values(condition) for condition in conjunction)
        is_possible = len(conjunction) == 1 or _may_hold_for_symbolic_arm(conjunction, joints)
        is_possible = is_possible or may_hold_simultaneously(conditions, chain.q)
        if is_possible and len(conjunction) > needed_count:
            required_conjunction = _drop_implied_for_symbolic_arm(conjunction, joints, MAX_ZEROS_FOR_IMPLICATION)
            required = tuple(map(derivation.substitute_values, required_conjunction))
            other_conditions = [] if conditions == conjunction else [c for c in conditions if c not in required]
            if all(is_implied(c, required, chain.q, MAX_ZEROS_FOR_IMPLICATION) for c in other_conditions):
                conditions = required
        yield conditions, is_possible


_drop_implied_for_symbolic_arm = lru_cache(maxsize=4096)(drop_implied)
_may_hold_for_symbolic_arm = lru_cache(maxsize=4096)(may_hold_simultaneously)


def _is_contained(component: Component, container: Component) -> bool:
    """Return whether the joint values of a component show that it lies in another component."""
    if component.solutions is None or container.solutions is None:
        return False
    solutions = dict(component.solutions)
    return all(joint in solutions and set(solutions[joint]) <= set(values) for joint, values in container.solutions)


def solve_conjunction(conditions: tuple[sp.Expr, ...], chain: Chain) -> Component | None:
    """Return the component that conditions describe; None if they have no real solution for this arm."""
    solutions = []
    for condition in conditions:
        solution = solve_condition(condition, chain)
        if solution is not None:
            _, values = solution
            if not values:
                return None
            solutions.append(solution)
            continue
        excess = _compute_excess(condition, chain)
        if excess is not None and excess > 0:
            return None
        component = _find_single_solution(condition, chain) if excess == 0 and len(conditions) == 1 else None
        if component is not None:
            return component
    if len(solutions) < len(conditions):
        return Component(conditions, None)
    return _merge_solutions(conditions, tuple(solutions))


def _merge_solutions(conditions: tuple[sp.Expr, ...], solutions: tuple[JointSolution, ...]) -> Component | None:
    """Return the component without conditions that follow from another on the same joint; None if two contradict.

    Only numeric joint values are compared.
    """
    for i, j in combinations(range(len(conditions)), 2):
        (joint, values), (other_joint, other_values) = solutions[i], solutions[j]
        if joint == other_joint and all(value.is_number for value in (*values, *other_values)):
            common_values = [value for value in values if value in other_values]  # at which both hold
            if not common_values:
                return None
            if len(common_values) in (len(values), len(other_values)):
                k = j if len(common_values) == len(values) else i  # the index of a condition that the other one implies
                return _merge_solutions(conditions[:k] + conditions[k + 1 :], solutions[:k] + solutions[k + 1 :])
    return Component(conditions, solutions)


def solve_condition(condition: sp.Expr, chain: Chain) -> JointSolution | None:
    """Solve a condition for its joint variable; the values are empty if there is no real solution.

    Return None if the condition involves several joints, or has a form that this module doesn't solve.
    """
    joints = [q for q in chain.q if condition.has(q)]
    if len(joints) != 1:
        return None
    (joint,) = joints
    if chain.joints[chain.q.index(joint)].is_prismatic:
        return _solve_polynomial(condition, joint)
    return _solve_angle(condition, joint)


def _solve_polynomial(condition: sp.Expr, joint: sp.Symbol) -> JointSolution | None:
    """Solve a condition of degree one, or of degree two with numeric coefficients, for a prismatic joint variable."""
    polynomial = sp.Poly(condition, joint)
    if polynomial.degree() == 1:
        a, b = polynomial.all_coeffs()
        return joint, (sp.together(-b / a),)
    if polynomial.degree() == 2 and not polynomial.free_symbols_in_domain:
        return joint, tuple(root for root in sp.roots(polynomial) if root.is_real)
    return None


@lru_cache(maxsize=4096)
def _solve_angle(condition: sp.Expr, joint: sp.Symbol) -> JointSolution | None:
    """Solve A + B cos(phi) + C sin(phi) = 0 for a joint variable; phi is the variable plus the joint offset."""
    arguments = {atom.args[0] for atom in condition.atoms(sp.sin, sp.cos)}
    phi = arguments.pop() if len(arguments) == 1 else joint
    offset = sp.expand(phi - joint)
    if offset.has(joint):
        return None
    coefficients = find_trig_coefficients(sp.expand_trig(condition) if arguments else condition, phi, joint)
    if coefficients is None:
        return None
    values = (wrap_angle(value - offset) for value in _find_trig_roots(*coefficients))
    return joint, tuple(dict.fromkeys(values))


def find_trig_coefficients(
    condition: sp.Expr, angle: sp.Expr, joint: sp.Symbol
) -> tuple[sp.Expr, sp.Expr, sp.Expr] | None:
    """Return A, B and C of a condition A + B cos(angle) + C sin(angle), which do not contain the joint variable.

    Return None if the condition has another form.
    """
    cosine, sine = sp.Dummy("c"), sp.Dummy("s")
    polynomial = sp.Poly(sp.expand(condition).xreplace({sp.cos(angle): cosine, sp.sin(angle): sine}), cosine, sine)
    if polynomial.total_degree() != 1 or joint in polynomial.free_symbols:
        return None
    a, b, c = (polynomial.coeff_monomial(monomial) for monomial in (1, cosine, sine))
    return a, b, c


def _find_trig_roots(a: sp.Expr, b: sp.Expr, c: sp.Expr) -> list[sp.Expr]:
    """Return the angles (rad) at which a + b cos + c sin is zero."""
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
    """Return whether |a| > |b| for all values of the lengths."""
    if a.is_number and b.is_number:
        return bool(abs(sp.N(a)) > abs(sp.N(b)))
    return bool(sp.expand(a**2 - b**2).is_positive)


def _compute_excess(condition: sp.Expr, chain: Chain) -> sp.Expr | None:
    """Return the excess of a sum of sines, cosines and a constant: the constant's size minus the sum of the amplitudes.

    If the excess is positive, the sum cannot be zero. If the excess is zero, the sum is zero only if each sine and each
    cosine is 1 or -1. Return None if the condition is not such a sum, or if it contains lengths.
    """
    polynomial = _to_trig_polynomial(condition, chain)
    if polynomial is None:
        return None
    constant = polynomial.coeff_monomial(1)
    # the constant is subtracted as one of the coefficients, so it is added twice
    excess = 2 * abs(constant) - sum(abs(coefficient) for coefficient in polynomial.coeffs())
    number = sp.N(excess, 30)
    return sp.S.Zero if abs(number) < _ZERO_TOLERANCE and sp.simplify(excess) == 0 else number


def _find_single_solution(condition: sp.Expr, chain: Chain) -> Component | None:
    """Return the only zero of a sum with the excess 0 (`_compute_excess`) as a component.

    For example, 0.8 + 0.4 c2 + 0.4 c23 is zero only if both cosines are -1. Return None unless the zero has one value
    of each joint in the sum.
    """
    polynomial = _to_trig_polynomial(condition, chain)
    assert polynomial is not None
    if polynomial.total_degree() != 1:
        return None
    sign = sp.sign(polynomial.coeff_monomial(1))
    equations = []
    for trig in polynomial.gens:
        is_maximum = sp.sign(polynomial.coeff_monomial(trig)) != sign
        maximizer = sp.S.Zero if isinstance(trig, sp.cos) else sp.pi / 2
        equations.append(trig.args[0] - maximizer - (0 if is_maximum else sp.pi))
    joints = [q for q in chain.q if condition.has(q)]
    multiples, angles = sp.linear_eq_to_matrix(equations, joints)
    if not multiples.is_square or abs(multiples.det()) != 1:  # the angles do not determine one value of each joint
        return None
    values = [(q, wrap_angle(value)) for q, value in zip(joints, multiples.inv() * angles, strict=True)]
    return Component(tuple(1 - sp.cos(q - value) for q, value in values), tuple((q, (value,)) for q, value in values))


def _to_trig_polynomial(condition: sp.Expr, chain: Chain) -> sp.Poly | None:
    """Return a condition as a polynomial in its sines and cosines.

    Return None if it has no sines and cosines, contains lengths, or contains joint variables outside of them.
    """
    trigs = sorted(condition.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    without_trigs = condition.xreplace({trig: sp.Dummy() for trig in trigs})
    if not trigs or condition.free_symbols - set(chain.q) or without_trigs.free_symbols & set(chain.q):
        return None
    return sp.Poly(condition, *trigs)


# --- common zeros of several minors, for the symbolic arm ---

_ROOT_MARK = sp.Function("at")
"""A mark such as at(sin(theta2), pi) is the condition that theta2 is one root of sin(theta2), here pi. If both roots
lead to the same conjunction, the condition sin(theta2) = 0 replaces the two marks.
"""


def _is_mark(condition: sp.Expr) -> bool:
    return getattr(condition, "func", None) == _ROOT_MARK


@dataclass(frozen=True)
class Search:
    """The settings and assumptions of a search for common zeros.

    A constant, such as a1 - a2, contains no joint variables. `is_zero` returns whether a constant is zero, and
    `assumed_nonzero` collects the constants that the search has assumed to be nonzero.
    """

    joints: Joints
    is_zero: Callable[[sp.Expr], bool] = lambda _: False
    assumed_nonzero: set[sp.Expr] = field(default_factory=set)

    def contains_joints(self, expression: sp.Expr) -> bool:
        """Return whether an expression contains joint variables."""
        return bool(expression.free_symbols & set(self.joints))

    def find_joint_factors(self, factored: Factored) -> list[sp.Expr] | None:
        """Return the factors of a product that contain joint variables; None if the product is always zero."""
        # a factor that is a symbol is a length, which is never zero
        constants = [f for f, _ in factored.factors if not self.contains_joints(f) and not f.is_Symbol]
        if factored.is_zero or any(map(self.is_zero, constants)):
            return None
        self.assumed_nonzero.update(constants)
        return [f for f, _ in factored.factors if self.contains_joints(f)]


@lru_cache(maxsize=4096)
def _search_zeros(minors: tuple[Factored, ...], joints: Joints) -> tuple[Zeros, frozenset[sp.Expr]]:
    """Return the common zeros of minors, and the constants that were assumed to be nonzero."""
    search = Search(joints)
    return find_common_zeros(minors, search), frozenset(search.assumed_nonzero)


def find_common_zeros(minors: Sequence[Factored], search: Search) -> Zeros:
    """Return the conjunctions that make all minors zero. Raises TooLong."""
    factor_sets = [factors for minor in minors if (factors := search.find_joint_factors(minor)) is not None]
    if not factor_sets:
        return None
    subject = f"the {len(factor_sets)} minors of J"
    common_factors = [f for f in factor_sets[0] if all(f in factors for factors in factor_sets[1:])]
    remaining_sets = [[f for f in factors if f not in common_factors] for factors in factor_sets]
    conjunctions: list[Conjunction] = [(f,) for f in common_factors]
    for branch in _search_branches(remaining_sets, search):
        if len(conjunctions) > MAX_EXAMINED_BRANCHES:
            raise TooLong(f"{subject} may vanish together in more than {MAX_EXAMINED_BRANCHES} ways")
        if not any(f in branch for f in common_factors):
            conjunctions.append(tuple(dict.fromkeys(branch)))
    return tidy_branches(conjunctions, search, subject)


def tidy_branches(conjunctions: Iterable[Conjunction], search: Search, subject: str) -> list[Conjunction]:
    """Return conjunctions without duplicates, and without conditions that follow from others.

    Conjunctions that differ only in the root of one factor are merged. Raises TooLong, with `subject` as the subject of
    the message.
    """
    merged_conjunctions = _merge_roots(list(conjunctions))
    if len(merged_conjunctions) > MAX_BRANCHES:
        raise TooLong(f"{subject} vanish together in more than {MAX_BRANCHES} ways, too many to list")
    follows = partial(_follows, search=search)
    shorter_conjunctions = [drop_redundant(replace_marks(c), follows) for c in merged_conjunctions]
    return _drop_subsumed(shorter_conjunctions, search)


def _find_joint_factors(condition: sp.Expr, search: Search) -> list[sp.Expr] | None:
    """Return the factors of a condition that contain joint variables; None if the condition always holds."""
    return search.find_joint_factors(factor_trig(sp.expand(condition)))


def _holds(condition: sp.Expr, values: JointValues, known_conditions: Conjunction) -> bool:
    """Return whether a condition holds at joint values, given known conditions, by comparing factors."""
    if condition in known_conditions:
        return True
    factored = factor_trig(sp.expand(condition.xreplace(values)))
    return factored.is_zero or any({factor, -factor} & set(known_conditions) for factor, _ in factored.factors)


def _solve_for_last_joint(factor: sp.Expr, root: sp.Expr) -> JointValues:
    """Return the value of the last joint in the angle of a sine or cosine at which the angle is `root`."""
    angle = factor.args[0]
    joint = max(angle.free_symbols, key=lambda q: (is_joint_angle(q), len(q.name), q.name))
    return {joint: sp.expand((root - angle) / sp.diff(angle, joint) + joint)}


def replace_marks(conjunction: Conjunction) -> Conjunction:
    """Return conditions with each mark replaced: at(sin(theta2), 0) becomes 1 - cos(theta2)."""
    return tuple(
        1 - sp.cos(condition.args[0].args[0] - condition.args[1]) if _is_mark(condition) else condition
        for condition in conjunction
    )


def _search_branches(factor_sets: list[list[sp.Expr]], search: Search) -> Iterator[list[sp.Expr]]:
    """Yield combinations of conditions that make a factor of every set zero.

    The search begins with the simplest set. A condition that fixes an angle is substituted into the other sets before
    the search continues, so that more factors become zero or constant.
    """
    if any(not factors for factors in factor_sets):
        return
    if not factor_sets:
        yield []
        return
    simplest_set, *other_sets = sorted(factor_sets, key=lambda factors: (len(factors), sum(map(sp.count_ops, factors))))
    for factor in simplest_set:
        for condition, values in split_zero_cases(factor):
            substituted = (_substitute_zero(factors, factor, values, search) for factors in other_sets)
            remaining_sets = [factors for factors in substituted if factors is not None]
            yield from ([condition, *branch] for branch in _search_branches(remaining_sets, search))


def split_zero_cases(factor: sp.Expr) -> list[tuple[sp.Expr, JointValues]]:
    """Return the cases in which a factor is zero, each with its condition and the joint values that it fixes."""
    if isinstance(factor, (sp.sin, sp.cos)):
        return [(_ROOT_MARK(factor, root), _solve_for_last_joint(factor, root)) for root in _TRIG_ROOTS[factor.func, 0]]
    return [(factor, {})]


def _substitute_zero(
    factors: list[sp.Expr], zero_factor: sp.Expr, values: JointValues, search: Search
) -> list[sp.Expr] | None:
    """Return the factors of a set that are not constant if `zero_factor` is zero; None if one of them is then zero."""
    remaining_factors: list[sp.Expr] = []
    for factor in factors:
        joint_factors = [factor] if not values else _find_joint_factors(factor.xreplace(values), search)
        if factor == zero_factor or joint_factors is None:
            return None
        remaining_factors += joint_factors
    return remaining_factors


def _merge_roots(conjunctions: list[Conjunction]) -> list[Conjunction]:
    """Merge conjunctions that differ only in the root of one factor, such as theta3 = 0 and theta3 = pi."""
    sets = {frozenset(conjunction) for conjunction in conjunctions}
    to_text = lru_cache(maxsize=None)(str)

    def find_mergeable() -> tuple[set[frozenset[sp.Expr]], frozenset[sp.Expr]] | None:
        """Return two conjunctions that can be merged, and the merged one."""
        for conjunction in sorted(sets, key=lambda c: sorted(map(to_text, c))):
            for mark in filter(_is_mark, conjunction):
                other_conditions = conjunction - {mark}
                (trig, _) = mark.args
                roots = _TRIG_ROOTS[trig.func, 0]
                siblings = {other_conditions | {_ROOT_MARK(trig, root)} for root in roots} & sets
                if len(siblings) == 2:
                    return siblings, other_conditions | {trig}
        return None

    while (mergeable := find_mergeable()) is not None:
        siblings, merged = mergeable
        sets = (sets - siblings) | {merged}
    return [tuple(sorted(conjunction, key=lambda c: (sp.count_ops(c), sp.default_sort_key(c)))) for conjunction in sets]


def _follows(condition: sp.Expr, premises: Conjunction, search: Search) -> bool:
    """Return whether a condition follows from premises, by substituting angles and comparing factors.

    If the result is False, the condition may follow nevertheless.
    """
    if condition in premises:
        return True
    roots = {premise: _find_roots(premise, search) for premise in premises}
    fixed_values = list(filter(None, roots.values()))
    other_premises = [premise for premise in premises if not roots[premise]]
    combinations_of_values = map(dict, product(*fixed_values))
    return bool(fixed_values) and all(
        _follows_at(condition, values, other_premises, search) for values in combinations_of_values
    )


def _follows_at(condition: sp.Expr, values: JointValues, other_premises: list[sp.Expr], search: Search) -> bool:
    """Return whether a condition holds at joint values, whichever factor of each premise is zero."""
    factor_sets = (_find_joint_factors(premise.xreplace(values), search) for premise in other_premises)
    combinations_of_factors = product(*(factors for factors in factor_sets if factors is not None))
    return all(_holds(condition, values, factors) for factors in combinations_of_factors)


def _find_roots(condition: sp.Expr, search: Search) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return the joint variable that a condition fixes, paired with each of its values; [] if there are several joints.

    The condition is a sine or a cosine, or has the form 1 - trig or 1 + trig.
    """
    trig, trig_value = condition, 0
    for extreme_value, single_trig in ((1, 1 - condition), (-1, condition - 1)):
        if condition.is_Add and isinstance(single_trig, (sp.sin, sp.cos)):
            trig, trig_value = single_trig, extreme_value
    if not isinstance(trig, (sp.sin, sp.cos)) or len(trig.free_symbols & set(search.joints)) != 1:
        return []
    roots = _TRIG_ROOTS[trig.func, trig_value]
    return [item for root in roots for item in _solve_for_last_joint(trig, root).items()]


def _drop_subsumed(conjunctions: list[Conjunction], search: Search) -> list[Conjunction]:
    """Drop duplicates, and conjunctions that imply another one, which contains all their configurations."""
    result = list(dict.fromkeys(c for c in conjunctions if not any(set(other) < set(c) for other in conjunctions)))
    for conjunction in sorted(result, key=lambda c: (len(c), sp.count_ops(sp.Add(*c))), reverse=True):
        other_conjunctions = (c for c in result if c != conjunction)
        if any(all(_follows(condition, conjunction, search) for condition in c) for c in other_conjunctions):
            result.remove(conjunction)  # removed immediately, because each of two equal conjunctions implies the other
    return sorted(result, key=lambda c: (len(c), sp.count_ops(sp.Add(*c)), [sp.default_sort_key(x) for x in c]))
