"""Sample regular and singular configurations with exact joint values, and find the branches of a singular set.

The singular set consists of components. A component is given by values of some joints (its solutions), or by conditions
on several joints. Sampled singular configurations are exact: joints have the values in a component, or a condition is
solved for one joint. A problem rounds the joint values that are not simple numbers, but its reference answer is
computed from the exact values, with 30 digits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import compile_expressions
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.formula.program import evaluate
from qdot.exercises.problem.problem import Details, list_values_by_name, recorded_as
from qdot.exercises.questions import inversion
from qdot.exercises.questions.inversion import Configuration, JointValues, Lengths, sample_joint_values
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.directions import NONZERO_THRESHOLD, find_clear_rank
from qdot.exercises.singularities.singular_set import Component, ValueCombination, find_singular_set

DIGITS, WORKING_DIGITS = 30, 40
"""Numbers of digits of results, and of intermediate results."""
ZERO = sp.Float("1e-20")
"""Limit below which a number with 30 digits counts as zero."""
MAX_TRIES, MAX_UNROUNDED_TRIES = 12, 24
"""Maximum numbers of samples for a singular configuration: with rounded joint values, and without."""
MAX_MISLEADING_TRIES, MAX_REGULAR_TRIES = 30, 60
"""Maximum numbers of samples for a regular configuration: of samples that seem singular after a mistake, and in
total."""
MAX_GRID_JOINTS = 4
"""Maximum number of joints in conditions whose exact zeros are found by a search on a grid; more take too long."""
MIN_PRECISION_BITS, MAX_MPMATH_VALUE = 86, 1e6
"""Minimum precision in bits (about 25 digits), and maximum absolute value, of numbers that mpmath rounds. SymPy, which
is slower, rounds the others."""

Roots = Sequence[tuple[sp.Symbol, tuple[sp.Expr, ...]]]
"""Joints, each with the values at which a condition holds."""


@dataclass(frozen=True)
class ExactConfiguration(Configuration):
    """A configuration with exact joint values, some of which the problem may show rounded.

    `rounded_values` maps each joint whose value is shown rounded to this value, in degrees (two decimals) or metres
    (four).
    """

    rounded_values: dict[sp.Symbol, sp.Rational] = field(default_factory=dict, metadata=recorded_as("about"))

    @property
    def figure_values(self) -> dict[str, float]:
        """The joint values for a figure, to 10 digits, by the names of the joint variables."""
        return {q.name: float(sp.Float(sp.N(value, DIGITS), 10)) for q, value in self.joints.items()}

    @property
    def formula_roots(self) -> Roots:
        """The joints with a formula such as arctan(3/4) as their value, each with this value."""
        return tuple((q, (value,)) for q, value in self.joints.items() if value.has(sp.acos, sp.asin, sp.atan))


Sampler = Callable[..., ExactConfiguration | None]
"""A function that returns a random configuration, or None if it finds no suitable one."""


@dataclass(frozen=True, kw_only=True)
class ConfigurationDetails(Details):
    """Details of a question about a given configuration, which the figure shows."""

    configuration: ExactConfiguration = field(metadata=recorded_as("place"))

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", self.configuration.figure_values)

    def list_given_values(self, chain: Chain) -> dict[str, float]:
        """Return the numbers of the configuration, by name."""
        return self.configuration.numbers


def make_exact_configuration(
    chain: Chain, lengths: Lengths, joints: JointValues, keeps_formulas: bool = False
) -> ExactConfiguration:
    """Return the configuration with these joint values, and with a rounded value for each that is not simple.

    Simple values are multiples of 0.1 degrees or 0.1 mm. Any other value becomes a number with 40 digits. If
    `keeps_formulas`, a formula such as arctan(3/4) stays unchanged, without a rounded value.
    """
    exact_values, rounded_values = dict(joints), {}
    for q, joint in zip(chain.q, chain.joints, strict=True):
        factor, decimals = (180 / sp.pi, 2) if joint.is_revolute else (sp.S.One, 4)  # to degrees, or metres unchanged
        steps_per_unit = sp.Integer(10 if joint.is_revolute else 10000) * factor
        if (steps_per_unit * joints[q]).is_Integer or (keeps_formulas and not joints[q].has(sp.Float)):
            continue
        number = sp.N(joints[q], WORKING_DIGITS)
        step_count = sp.N(steps_per_unit, WORKING_DIGITS) * number
        nearest_integer = sp.Integer(round_to_integer(step_count))
        if abs(step_count - nearest_integer) < sp.Float("1e-25"):  # a simple value, apart from rounding
            exact_values[q] = nearest_integer / steps_per_unit
        else:
            exact_values[q] = number
            numerator = round_to_integer(sp.N(factor, WORKING_DIGITS) * number * 10**decimals)
            rounded_values[q] = sp.Rational(numerator, 10**decimals)
    return ExactConfiguration(dict(lengths), exact_values, rounded_values)


def round_to_integer(value: sp.Expr) -> int:
    """Return the nearest integer.

    This takes a hundredth of SymPy's time. Numbers that may be half-way between two integers are left to SymPy.

    >>> round_to_integer(sp.Float("-7.51", 30)), round_to_integer(sp.Float("2.5", 30)), round_to_integer(sp.S.Zero)
    (-8, 2, 0)
    """
    if isinstance(value, sp.Float) and value._prec >= MIN_PRECISION_BITS and abs(float(value)) < MAX_MPMATH_VALUE:
        nearest_integer = mpmath.libmp.to_int(value._mpf_, mpmath.libmp.round_nearest)
        if abs(abs(value - nearest_integer) - sp.Rational(1, 2)) > sp.Float("1e-15"):
            return int(nearest_integer)
    return int(value.round())


def convert_to_sample(chain: Chain, configuration: ExactConfiguration) -> Sample:
    """Return a configuration in floating point: an arm with numeric lengths, and joint values."""
    arm = NumericChain(chain, list_values_by_name(configuration.lengths))
    return Sample(arm, np.array([float(sp.N(configuration.joints[q])) for q in chain.q]))


def compute_full_rank(chain: Chain) -> int:
    """Return the rank of the task Jacobian at a regular configuration."""
    return min(len(chain.task), chain.n)


def evaluate_jacobian(chain: Chain, configuration: ExactConfiguration) -> np.ndarray:
    """Return the task Jacobian at a configuration, (m, n), in floating point."""
    sample = convert_to_sample(chain, configuration)
    return np.asarray(sample.arm.compute_jacobian(sample.q)[chain.task_rows])


def compute_rank(chain: Chain, configuration: ExactConfiguration, min_ratio: float = NONZERO_THRESHOLD) -> int | None:
    """Return the rank of the task Jacobian at a configuration; None if a singular value is small, but not zero.

    A singular value is small if it is less than `min_ratio` times the largest.
    """
    return find_clear_rank(evaluate_jacobian(chain, configuration), min_ratio)


def evaluate_precisely(chain: Chain, configuration: ExactConfiguration, matrix: sp.Matrix) -> sp.Matrix:
    """Return the value of a matrix of formulas at a configuration, to 30 digits; values below ZERO become zero."""

    def evaluate_entry(entry: sp.Expr) -> sp.Expr:
        value = sp.N(entry, DIGITS, maxn=60)  # with up to 60 digits in intermediate results
        return sp.S.Zero if abs(value) < ZERO else value

    return matrix.xreplace(configuration.values).applyfunc(evaluate_entry)


def compute_lost_direction(chain: Chain, configuration: ExactConfiguration) -> sp.Matrix:
    """Return the unit vector u (m x 1) with u^T J = 0 at a singular configuration, to 30 digits.

    The first entry of u with an absolute value above 1e-3 is positive. Entries below 1e-12 become zero.
    """
    jacobian = evaluate_precisely(chain, configuration, derive(chain).jacobian)
    with mpmath.workdps(DIGITS):
        numbers = mpmath.matrix([[mpmath.mpf(str(value)) for value in row] for row in jacobian.tolist()])
        _, vectors = mpmath.eigsy(numbers * numbers.T)
        lost_entries = [vectors[i, 0] for i in range(jacobian.rows)]
        first_entry = next(value for value in lost_entries if abs(value) > mpmath.mpf("1e-3"))
        sign = 1 if first_entry > 0 else -1
        entries = [sp.Float(str(sign * value), DIGITS) for value in lost_entries]
    return sp.Matrix([sp.S.Zero if abs(value) < sp.Float("1e-12") else value for value in entries])


# --- sampling ---


def sample_regular_configuration(
    chain: Chain, rng: Stream, min_ratio: float = 0.1, prefers_seemingly_singular: bool = True
) -> ExactConfiguration | None:
    """Return a random configuration of full rank without rounded joint values, or None if none is found.

    The ratio of the smallest to the largest singular value is at least `min_ratio`. If
    `prefers_seemingly_singular`, the first samples are configurations that seem singular to students who make a sign
    error or an error of 90 degrees.
    """
    roots: list[tuple[sp.Symbol, tuple[sp.Expr, ...]]] = []
    if prefers_seemingly_singular:
        for component in find_singular_set(chain) or ():
            roots += component.solutions or ()
        roots += find_formula_roots(chain)
    for attempt in range(MAX_REGULAR_TRIES):
        lengths, joints = sample_unequal_lengths(chain, rng), sample_joint_values(chain, rng)
        if roots and attempt < MAX_MISLEADING_TRIES:
            joints |= sample_false_root(roots, lengths, rng)
        if not all(_is_real(value) for value in joints.values()):
            continue
        configuration = make_exact_configuration(chain, lengths, wrap_angles(joints), keeps_formulas=True)
        if compute_rank(chain, configuration, min_ratio) == compute_full_rank(chain):
            return configuration
    return None


@lru_cache(maxsize=1024)
def find_formula_roots(chain: Chain) -> Roots:
    """Return formulas such as arctan(3/4) that solve conditions on several joints, each with its joint.

    Regular configurations get similar formulas; otherwise students could recognise singular configurations by them.
    """
    stream = Stream("formula roots")
    components = [component for component in find_singular_set(chain) or () if component.solutions is None]
    configurations = (sample_displayable_configuration(chain, (component,), stream) for component in components)
    return tuple(root for configuration in configurations if configuration for root in configuration.formula_roots)


def sample_false_root(roots: Roots, lengths: Lengths, rng: Stream) -> JointValues:
    """Return a wrong value of a random joint: a root with a sign error, an error of 90 degrees or 0.1 m, or both."""
    joint, values = rng.choice(roots)
    shift = rng.choice((sp.pi / 2, -sp.pi / 2)) if is_joint_angle(joint) else sp.Rational(1, 10)
    value = rng.choice(values).xreplace(dict(lengths))
    return {joint: rng.choice((-value, value + shift, shift - value))}


def sample_singular_configuration(
    chain: Chain,
    components: Sequence[Component],
    rng: Stream,
    lost_rank: int | None = None,
    has_varied_lengths: bool = False,
    needs_no_rounding: bool = False,
    keeps_formulas: bool = False,
) -> ExactConfiguration | None:
    """Return a random configuration on all `components`, at which J clearly loses rank; None if none is found.

    If `lost_rank` is given, J loses exactly that much rank. If `has_varied_lengths`, the numbers for symbolic lengths
    differ by up to a factor of 12. If `needs_no_rounding`, no joint value is shown rounded. If `keeps_formulas` as
    well, joint values may be formulas.
    """
    for _ in range(MAX_UNROUNDED_TRIES if needs_no_rounding else MAX_TRIES):
        lengths = _sample_varied_lengths(chain, rng) if has_varied_lengths else sample_unequal_lengths(chain, rng)
        sample_joints = _sample_unrounded_values_on_components if needs_no_rounding else _sample_values_on_components
        joints = sample_joints(chain, components, lengths, rng)
        if joints is None and needs_no_rounding and keeps_formulas:
            joints = _sample_formulas_on_component(chain, components, lengths, rng)
        if joints is None or not all(_is_real(value) for value in joints.values()):
            continue
        configuration = make_exact_configuration(chain, lengths, joints, keeps_formulas)
        if needs_no_rounding and configuration.rounded_values:
            continue
        # With very different lengths, singular values that are not zero may be smaller.
        threshold = NONZERO_THRESHOLD / 5 if has_varied_lengths else NONZERO_THRESHOLD
        full_rank, rank = compute_full_rank(chain), compute_rank(chain, configuration, threshold)
        if rank is not None and rank < full_rank and lost_rank in (None, full_rank - rank):
            return configuration
    return None


def sample_displayable_configuration(
    chain: Chain, components: Sequence[Component], rng: Stream, lost_rank: int | None = None
) -> ExactConfiguration | None:
    """Return a random singular configuration without rounded joint values, or None if none is found.

    Joint values are simple numbers if possible, otherwise formulas such as arctan(3/4).
    """
    sample = partial(sample_singular_configuration, chain, components, rng, lost_rank, needs_no_rounding=True)
    return sample() or sample(keeps_formulas=True)


def sample_from_any_component(
    chain: Chain, rng: Stream, lost_rank: int | None = None, sample: Sampler = sample_displayable_configuration
) -> ExactConfiguration | None:
    """Return a random singular configuration; None if none is found.

    The components are tried in random order until `sample` finds a configuration on one of them.
    """
    components = rng.permutation(find_singular_set(chain) or ())
    return next(filter(None, (sample(chain, (component,), rng, lost_rank) for component in components)), None)


def sample_unequal_lengths(chain: Chain, rng: Stream) -> Lengths:
    """Return random numbers for the symbolic lengths. No two lengths are equal, because that is a special case."""
    table_lengths = inversion.list_table_lengths(chain)
    last_step = max(16, 5 + len(chain.parameters) + len(table_lengths))  # in steps of 5 cm, usually 0.3 m to 0.8 m
    shuffled_steps = rng.permutation(range(6, last_step + 1))
    steps = [step for step in shuffled_steps if sp.Rational(step, 20) not in table_lengths]
    return {symbol: sp.Rational(step, 20) for symbol, step in zip(chain.parameters, steps, strict=False)}


def _sample_varied_lengths(chain: Chain, rng: Stream) -> Lengths:
    """Return random lengths from 0.12 m upwards, each about 1.3 times as long as the next shorter one."""
    sizes = [12 * 13**i // 10**i for i in range(max(10, len(chain.parameters)))]  # in cm
    pairs = zip(chain.parameters, rng.permutation(sizes), strict=False)
    return {symbol: sp.Rational(size + rng.integer_below(2), 100) for symbol, size in pairs}


@lru_cache(maxsize=1024)
def sample_with_varied_lengths(chain: Chain, component: Component, count: int) -> tuple[Sample, ...]:
    """Return up to `count` configurations on a component that lose one direction, with very different lengths."""
    stream = Stream(f"samples/{component.list_pieces()}")
    sample = partial(sample_singular_configuration, chain, (component,), stream, lost_rank=1, has_varied_lengths=True)
    configurations = [sample() for _ in range(count)]
    return tuple(convert_to_sample(chain, configuration) for configuration in configurations if configuration)


@dataclass(frozen=True)
class Branch:
    """A branch of an arm's singular set: one combination of joint values, or a condition on several joints.

    `component` is the branch of the arm, and `structure_component` is the same branch of the arm's structure. The
    structure is the arm with symbols for all lengths and oblique angles and without joint offsets.
    """

    component: Component
    structure_component: Component

    @property
    def values(self) -> ValueCombination:
        """The joint values of the branch; empty if the branch is given by a condition."""
        return () if self.component.solutions is None else self.component.list_value_combinations()[0]


@lru_cache(maxsize=1024)
def match_branches(chain: Chain) -> tuple[Branch, ...]:
    """Return the branches of an arm's singular set that its structure also has."""
    substitute = derive(chain).substitute_values
    structure_set = find_singular_set(make_symbolic_arm(chain).chain) or ()
    structure_components = {tuple(map(substitute, component.conditions)): component for component in structure_set}
    branches: list[Branch] = []
    for component in find_singular_set(chain) or ():
        structure_component = structure_components.get(component.conditions)
        if structure_component is None or (component.solutions is None) != (structure_component.solutions is None):
            continue
        if component.solutions is None:
            branches.append(Branch(component, structure_component))
        for values in component.list_value_combinations():
            for structure_values in structure_component.list_value_combinations():
                if _are_same_values(chain, values, structure_values):
                    restricted_component = structure_component.restrict_to(structure_values)
                    branches.append(Branch(component.restrict_to(values), restricted_component))
                    break
    return tuple(branches)


def _are_same_values(chain: Chain, arm_values: ValueCombination, structure_values: ValueCombination) -> bool:
    """Return whether joint values of a structure are those of the arm, up to joint offsets and full rotations."""
    lengths = {symbol: sp.Rational(37 + 11 * i, 100) for i, symbol in enumerate(chain.parameters)}  # any lengths
    for (q, value), (_, structure_value) in zip(arm_values, structure_values, strict=True):
        index = chain.q.index(q)
        exact_difference = derive(chain).substitute_values(structure_value) - chain.offsets[index] - value
        difference = sp.N(exact_difference.xreplace(lengths), 15)
        if chain.joints[index].is_revolute:
            difference = sp.N(sp.exp(sp.I * difference) - 1, 15)  # zero for a multiple of 2 pi
        if abs(difference) > sp.Float("1e-9"):
            return False
    return True


def _sample_values_on_components(
    chain: Chain, components: Sequence[Component], lengths: Lengths, rng: Stream
) -> JointValues | None:
    """Return random joint values of a configuration that is on all `components`, or None if none are found.

    First, joints get the values in the solutions of components. Then each condition of the other components is solved
    for one joint.
    """
    fixed_values: JointValues = {}
    for component in components:
        if component.solutions is None:
            continue
        values = dict(rng.choice(component.list_value_combinations()))
        if any(fixed_values.get(q, value) != value for q, value in values.items()):
            return None
        fixed_values.update(wrap_angles({q: value.xreplace(dict(lengths)) for q, value in values.items()}))
    if not all(_is_real(value) for value in fixed_values.values()):
        return None
    sampled_values = sample_joint_values(chain, rng)
    unsolved_components = [component for component in components if component.solutions is None]
    for condition, *other_conditions in (component.conditions for component in unsolved_components):
        if other_conditions:  # one joint can't fulfil several conditions
            return None
        free_joints = [q for q in chain.q if condition.has(q) and q not in fixed_values]
        if not free_joints:
            return None
        solved_joint = rng.choice(free_joints)
        known_values = {**lengths, **sampled_values, **fixed_values}
        known_values.pop(solved_joint)
        is_revolute = chain.joints[chain.q.index(solved_joint)].is_revolute
        zeros = _find_zeros(condition.xreplace(known_values), solved_joint, is_revolute)
        if not zeros:
            return None
        fixed_values.update({q: sampled_values[q] for q in free_joints})
        fixed_values[solved_joint] = rng.choice(zeros)
    return {**sampled_values, **fixed_values}


def _sample_unrounded_values_on_components(
    chain: Chain, components: Sequence[Component], lengths: Lengths, rng: Stream
) -> JointValues | None:
    """Return joint values as `_sample_values_on_components` does, but only values that need no rounding.

    The joints in a condition on several joints have angles (with the joint offset) in multiples of 30 degrees, or
    displacements in multiples of 5 cm.
    """
    solved_components = [component for component in components if component.solutions is not None]
    fixed_values = _sample_values_on_components(chain, solved_components, lengths, rng)
    if fixed_values is None:
        return None
    solved_joints = {q for component in solved_components for q, _ in component.solutions or ()}
    unsolved_components = [component for component in components if component.solutions is None]
    conditions = [condition for component in unsolved_components for condition in component.conditions]
    grid_joints = [q for q in chain.q if q not in solved_joints and any(condition.has(q) for condition in conditions)]
    if not conditions:
        return fixed_values
    if not 0 < len(grid_joints) <= MAX_GRID_JOINTS:
        return None
    grid_values = {}
    for q in grid_joints:
        index = chain.q.index(q)
        if chain.joints[index].is_revolute:
            grid_values[q] = [_wrap_angle(k * sp.pi / 6 - chain.offsets[index]) for k in range(12)]
        else:
            grid_values[q] = [sp.Rational(k, 20) for k in range(2, 17)]  # 0.1 m to 0.8 m
    grid = np.meshgrid(*([float(value) for value in grid_values[q]] for q in grid_joints), indexing="ij")
    constants = {**lengths, **fixed_values}
    values = {symbol.name: np.full(grid[0].size, float(sp.N(value))) for symbol, value in constants.items()}
    values |= {q.name: axis.ravel() for q, axis in zip(grid_joints, grid, strict=True)}
    residuals = np.abs(evaluate(compile_expressions(*conditions), values, grid[0].size).values).max(axis=0)
    zero_indices = np.argwhere(residuals.reshape(grid[0].shape) < 1e-9)
    if not len(zero_indices):
        return None
    chosen_indices = rng.choice(zero_indices.tolist())
    joints = {**fixed_values, **{q: grid_values[q][k] for q, k in zip(grid_joints, chosen_indices, strict=True)}}
    exact_values = {**lengths, **joints}
    residuals_at_joints = (sp.N(condition.xreplace(exact_values), DIGITS) for condition in conditions)
    return joints if all(abs(residual) < ZERO for residual in residuals_at_joints) else None


def _sample_formulas_on_component(
    chain: Chain, components: Sequence[Component], lengths: Lengths, rng: Stream
) -> JointValues | None:
    """Return joint values on a component with one condition, which is solved for one angle; None if none are found.

    The other angles in the condition are multiples of 90 degrees, so that the solution is a short formula such as
    arctan(3/4).
    """
    if len(components) != 1 or components[0].solutions is not None or len(components[0].conditions) != 1:
        return None
    condition = components[0].conditions[0].xreplace(dict(lengths))
    joints, offsets = sample_joint_values(chain, rng), dict(zip(chain.q, chain.offsets, strict=True))
    angles = rng.permutation([q for q in chain.q if is_joint_angle(q) and condition.has(q)])
    for solved_joint in angles:
        other_angles = {q: rng.integer_below(4) * sp.pi / 2 - offsets[q] for q in angles if q != solved_joint}
        values = {**joints, **other_angles}
        del values[solved_joint]
        zeros = _find_short_zeros(condition.xreplace(values), solved_joint, offsets[solved_joint])
        if zeros:
            return wrap_angles({**joints, **other_angles, solved_joint: rng.choice(zeros)})
    return None


def _find_short_zeros(condition: sp.Expr, angle: sp.Symbol, offset: sp.Expr) -> list[sp.Expr]:
    """Return the values of an angle at which a + b cos(angle + offset) + c sin(angle + offset) is zero.

    The zeros have short formulas if a, b and c are rational and one of them is zero. Otherwise the list is empty.
    """
    f_0, f_1, f_2 = (condition.xreplace({angle: k * sp.pi / 2 - offset}) for k in range(3))
    a, b = (f_0 + f_2) / 2, (f_0 - f_2) / 2
    c = f_1 - a
    if not all(value.is_Rational for value in (a, b, c)):
        return []
    if a == 0 and b != 0 and c != 0:
        zeros = [sp.atan(-b / c), sp.atan(-b / c) + sp.pi]
    elif c == 0 and abs(a) < abs(b):
        zeros = [sp.acos(-a / b), -sp.acos(-a / b)]
    elif b == 0 and abs(a) < abs(c):
        zeros = [sp.asin(-a / c), sp.pi - sp.asin(-a / c)]
    else:
        return []
    return [zero - offset for zero in zeros if abs(sp.N(condition.xreplace({angle: zero - offset}), DIGITS)) < ZERO]


def _find_zeros(condition: sp.Expr, joint: sp.Symbol, is_revolute: bool) -> list[sp.Expr]:
    """Return the values of a joint at which a condition is zero, to 40 digits.

    The condition must be a + b cos q + c sin q for a revolute joint, or a + b q for a prismatic joint. For any other
    condition, or one that does not clearly reach zero, the list is empty.
    """
    test_values = (sp.S.Zero, sp.pi / 2, sp.pi, sp.S.One) if is_revolute else (sp.S.Zero, sp.S.One, sp.S(2), sp.S(3))
    f_0, f_1, f_2, f_3 = (sp.N(condition.xreplace({joint: test_value}), WORKING_DIGITS) for test_value in test_values)
    tolerance = sp.Float("1e-30")
    with mpmath.workdps(WORKING_DIGITS):
        if not is_revolute:
            derivative = f_1 - f_0
            is_linear = abs(f_3 - f_0 - 3 * derivative) < tolerance and abs(derivative) > sp.Float("1e-3")
            return [-f_0 / derivative] if is_linear else []
        a, b = (f_0 + f_2) / 2, (f_0 - f_2) / 2
        c = f_1 - a
        norm = sp.sqrt(b**2 + c**2)
        residual = f_3 - a - b * sp.N(sp.cos(1), WORKING_DIGITS) - c * sp.N(sp.sin(1), WORKING_DIGITS)
        if abs(residual) > tolerance or norm <= abs(a) + sp.Float("1e-3"):
            return []
        maximum_angle, half_distance = sp.atan2(c, b), sp.acos(-a / norm)
        zeros = (sp.N(maximum_angle + sign * half_distance, WORKING_DIGITS) for sign in (1, -1))
        full_rotation = sp.N(2 * sp.pi, WORKING_DIGITS)
        return [value - full_rotation * round(value / full_rotation) for value in zeros]


def _is_real(value: sp.Expr) -> bool:
    return value.is_real is True or bool(abs(sp.im(sp.N(value, DIGITS))) < ZERO)


def wrap_angles(joints: JointValues) -> JointValues:
    """Return joint values with numeric angles wrapped to [-pi, pi].

    Unlike `trigonometry.wrap_angle`, it counts rotations in rounded numbers and leaves -pi unchanged. Ids of existing
    problems depend on that.
    """
    numbers = {q for q, value in joints.items() if value.is_number and _is_real(value)}
    return {q: _wrap_angle(value) if q in numbers and is_joint_angle(q) else value for q, value in joints.items()}


def _wrap_angle(angle: sp.Expr) -> sp.Expr:
    """Return a numeric, real angle wrapped to [-pi, pi]."""
    rotation_count = sp.floor((sp.pi - sp.N(angle, DIGITS)) / (2 * sp.pi))
    return sp.expand(angle + 2 * sp.pi * int(rotation_count))
