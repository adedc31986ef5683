"""Configurations that questions on singularities are asked at: poses in numbers, and parts of the singular set.

A pose is exact: joint values of the component, or the value of one joint for which a condition that ties several is
solved. What is no simple number is shown rounded; references are worked out at the exact pose, with 30 digits.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.directions import CLEAR, clear_rank
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.singularity import Component, Values, singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.inversion import Configuration, list_table_lengths, sample_pose

DIGITS, KEPT = 30, 40
TRIES = 12
EXACT_TRIES = 24
MOST_TIED = 4
"""Joints of conditions that tie them whose angles are all looked through for exact zeros."""
BITS, MOST_COUNTED = 86, 1e6
"""Numbers of so many bits (25 digits), up to so much, are rounded in binary where they are clear of a half by 1e-15."""


@dataclass(frozen=True)
class Pose(Configuration):
    """A configuration with exact joint values, and those that are shown rounded.

    `about` holds degrees of an angle to two decimals, and metres of a slide to four.
    """

    about: dict[sp.Symbol, sp.Rational] = field(default_factory=dict)

    @property
    def figure(self) -> dict[str, float]:
        """The joint values for a figure."""
        return {q.name: float(sp.Float(sp.N(value, DIGITS), 10)) for q, value in self.joints.items()}


@dataclass(frozen=True, kw_only=True)
class AtPose(Details):
    """Asked at a pose."""

    place: Pose

    def given_values(self, chain: Chain) -> dict[str, float]:
        """Return the numbers of the pose."""
        return self.place.numbers


def make_pose(
    chain: Chain,
    lengths: Mapping[sp.Symbol, sp.Rational],
    joints: Mapping[sp.Symbol, sp.Expr],
    symbolic: bool = False,
) -> Pose:
    """Return a pose; a value that is not a simple number is stored with 40 digits and shown rounded.

    With `symbolic`, a value that is a formula, such as arctan(3/4), stays one.
    """
    exact, about = dict(joints), {}
    for q, joint in zip(chain.q, chain.joints, strict=True):
        unit, places = (180 / sp.pi, 2) if joint.kind == "R" else (sp.S.One, 4)
        simple = sp.Integer(10 if joint.kind == "R" else 10000) * unit
        if (simple * joints[q]).is_Integer or (symbolic and not joints[q].has(sp.Float)):
            continue
        number = sp.N(joints[q], KEPT)
        counted = sp.N(simple, KEPT) * number
        nearest = sp.Integer(nearest_integer(counted))
        if abs(counted - nearest) < sp.Float("1e-25"):
            exact[q] = nearest / simple
        else:
            exact[q] = number
            about[q] = sp.Rational(nearest_integer(sp.N(unit, KEPT) * number * 10**places), 10**places)
    return Pose(dict(lengths), exact, about)


def nearest_integer(value: sp.Expr) -> int:
    """Return round(value) a hundred times as fast as SymPy, which counts in decimal digits.

    If a number may be half-way between two integers in decimal digits, SymPy decides.

    >>> nearest_integer(sp.Float("-7.51", 30)), nearest_integer(sp.Float("2.5", 30)), nearest_integer(sp.S.Zero)
    (-8, 2, 0)
    """
    if isinstance(value, sp.Float) and value._prec >= BITS and abs(float(value)) < MOST_COUNTED:
        sign, mantissa, exponent, _ = value._mpf_
        unit = 1 << max(0, -int(exponent))
        whole, rest = divmod(2 * (int(mantissa) << max(0, int(exponent))) + unit, 2 * unit)
        if min(rest, 2 * unit - rest) * 10**15 > unit:
            return -whole if sign else whole
    return int(value.round())


def to_sample(chain: Chain, pose: Pose) -> Sample:
    """Return a pose in floating point."""
    arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in pose.lengths.items()})
    return Sample(arm, np.array([float(sp.N(pose.joints[q])) for q in chain.q]))


def full_rank(chain: Chain) -> int:
    """Return the rank of the task Jacobian where the arm is not singular."""
    return min(len(chain.task), chain.n)


def jacobian_at(chain: Chain, pose: Pose) -> np.ndarray:
    """Return the task Jacobian at a pose, (m, n), in floating point."""
    sample = to_sample(chain, pose)
    return np.asarray(sample.arm.jacobian(sample.q)[chain.task_rows])


def evaluate_precisely(chain: Chain, pose: Pose, matrix: sp.Matrix) -> sp.Matrix:
    """Return a matrix of formulas in numbers of 30 digits at a pose, tiny ones as zero."""
    exact = matrix.xreplace(pose.values)

    def number(entry: sp.Expr) -> sp.Expr:
        value = sp.N(entry, DIGITS, maxn=60)
        return sp.S.Zero if abs(value) < sp.Float("1e-20") else value

    return exact.applyfunc(number)


def precise_lost_direction(chain: Chain, pose: Pose) -> sp.Matrix:
    """Return the unit vector u with u J = 0 at a singular pose, to 30 digits; its first clear entry is positive."""
    jacobian = evaluate_precisely(chain, pose, derive(chain).jacobian)
    with mpmath.workdps(DIGITS):
        numbers = mpmath.matrix([[mpmath.mpf(str(value)) for value in row] for row in jacobian.tolist()])
        gram = numbers * numbers.T
        _, vectors = mpmath.eigsy(gram)
        lost = [vectors[i, 0] for i in range(jacobian.rows)]
        first = next(value for value in lost if abs(value) > mpmath.mpf("1e-3"))
        sign = 1 if first > 0 else -1
        entries = [sp.Float(str(sign * value), DIGITS) for value in lost]
    return sp.Matrix([sp.S.Zero if abs(value) < sp.Float("1e-12") else value for value in entries])


# --- sampling ---


def sample_regular_pose(
    chain: Chain, rng: Stream, clear: float = 0.1, misleading: bool = True, exact: bool = False
) -> Pose | None:
    """Sample a pose of full rank; with `misleading`, one that an error makes seem singular.

    With `exact`, no joint value is shown rounded.
    """
    components = singular_set(chain) or () if misleading else ()
    roots = [solution for component in components for solution in component.solutions or ()]
    for attempt in range(60):
        lengths, joints = sample_unequal_lengths(chain, rng), sample_pose(chain, rng)
        if roots and attempt < 30:
            joints |= sample_false_root(roots, lengths, rng)
        if not all(_is_real(value) for value in joints.values()):
            continue
        pose = make_pose(chain, lengths, {q: wrap_angle(chain, q, value) for q, value in joints.items()})
        if not (exact and pose.about) and clear_rank(jacobian_at(chain, pose), clear) == full_rank(chain):
            return pose
    return None


def sample_false_root(
    roots: Sequence[tuple[sp.Symbol, tuple[sp.Expr, ...]]], lengths: Mapping[sp.Symbol, sp.Expr], rng: Stream
) -> dict[sp.Symbol, sp.Expr]:
    """Return a joint with what an error of a sign or of a right angle makes of a value at which the arm is singular."""
    joint, values = rng.choice(roots)
    shift = rng.choice((sp.pi / 2, -sp.pi / 2)) if joint.name.startswith("theta") else sp.Rational(1, 10)
    value = rng.choice(values).xreplace(dict(lengths))
    return {joint: rng.choice((-value, value + shift, shift - value))}


def sample_singular_pose(
    chain: Chain,
    components: Sequence[Component],
    rng: Stream,
    lost: int | None = None,
    wide: bool = False,
    exact: bool = False,
    symbolic: bool = False,
) -> Pose | None:
    """Sample a pose on all of `components` at once whose rank is clearly less than full, by `lost` if given; or None.

    With `wide`, open lengths differ by up to a factor of 12. With `exact`, no joint value is shown rounded;
    with `symbolic`, too, they may be formulas.
    """
    for _ in range(EXACT_TRIES if exact else TRIES):
        lengths = _sample_wide_lengths(chain, rng) if wide else sample_unequal_lengths(chain, rng)
        joints = (_sample_exact_joints_on if exact else _sample_joints_on)(chain, components, lengths, rng)
        if joints is None or not all(_is_real(value) for value in joints.values()):
            continue
        pose = make_pose(chain, lengths, joints, symbolic)
        if exact and pose.about:
            continue
        rank = clear_rank(jacobian_at(chain, pose), CLEAR / 5 if wide else CLEAR)
        if rank is not None and rank < full_rank(chain) and lost in (None, full_rank(chain) - rank):
            return pose
    return None


def sample_shown_pose(chain: Chain, branch: Sequence[Component], rng: Stream, lost: int | None = None) -> Pose | None:
    """Sample a singular pose to be shown: an exact one if there is one, else with a joint value rounded; or None."""
    sample = partial(sample_singular_pose, chain, branch, rng, lost)
    return sample(exact=True) or sample()


def find_singular_pose(
    chain: Chain, rng: Stream, lost: int | None = None, sample: Callable[..., Pose | None] = sample_shown_pose
) -> Pose | None:
    """Return a singular pose on the first component, in random order, on which one is found."""
    poses = (sample(chain, (component,), rng, lost) for component in rng.permutation(singular_set(chain) or ()))
    return next((pose for pose in poses if pose is not None), None)


def sample_unequal_lengths(chain: Chain, rng: Stream) -> dict[sp.Symbol, sp.Rational]:
    """Sample a number for each length that the table leaves open; no two are equal, which would be a special case."""
    taken = list_table_lengths(chain)
    shuffled = rng.permutation(range(6, max(17, 6 + len(chain.parameters) + len(taken))))
    steps = [step for step in shuffled if sp.Rational(step, 20) not in taken]
    return {symbol: sp.Rational(step, 20) for symbol, step in zip(chain.parameters, steps, strict=False)}


def _sample_wide_lengths(chain: Chain, rng: Stream) -> dict[sp.Symbol, sp.Rational]:
    """Sample lengths of very different size, no two of which are nearly equal."""
    sizes = [12 * 13**i // 10**i for i in range(max(10, len(chain.parameters)))]
    pairs = zip(chain.parameters, rng.permutation(sizes), strict=False)
    return {symbol: sp.Rational(size + rng.below(2), 100) for symbol, size in pairs}


@lru_cache(maxsize=1024)
def sample_singular_poses(chain: Chain, component: Component, count: int) -> tuple[Sample, ...]:
    """Return configurations of a component where one direction is lost, of very different lengths; often `count`."""
    stream = Stream(f"samples/{component.pieces()}")
    poses = (sample_singular_pose(chain, (component,), stream, 1, wide=True) for _ in range(count))
    return tuple(to_sample(chain, pose) for pose in poses if pose is not None)


@dataclass(frozen=True)
class Branch:
    """A part of the singular set that looks alike: a combination of joint values, or a condition that ties joints.

    `component` is that of the arm, `generic` that of its structure.
    """

    component: Component
    generic: Component


@lru_cache(maxsize=1024)
def branches(chain: Chain) -> tuple[Branch, ...]:
    """Return the singular set of an arm in branches, each with that of its structure."""
    derivation = derive(chain)
    generic = {tuple(map(derivation.fill, c.conditions)): c for c in singular_set(structure(chain).chain) or ()}
    reached: list[Branch] = []
    for component in singular_set(chain) or ():
        generic_component = generic.get(component.conditions)
        if generic_component is None or (component.solutions is None) != (generic_component.solutions is None):
            continue
        if component.solutions is None or generic_component.solutions is None:
            reached.append(Branch(component, generic_component))
            continue
        for values in component.value_combinations():
            theirs = next(
                (v for v in generic_component.value_combinations() if _have_same_values(chain, values, v)), None
            )
            if theirs is not None:
                reached.append(Branch(component.at(values), generic_component.at(theirs)))
    return tuple(reached)


def _have_same_values(chain: Chain, arm_values: Values, generic_values: Values) -> bool:
    """Tell whether joint values of a structure are those of the arm, which has offsets, whole turns apart."""
    lengths = {symbol: sp.Rational(37 + 11 * i, 100) for i, symbol in enumerate(chain.parameters)}
    for (q, value), (_, theirs) in zip(arm_values, generic_values, strict=True):
        index = chain.q.index(q)
        apart = sp.N((derive(chain).fill(theirs) - chain.offsets[index] - value).xreplace(lengths), 15)
        if chain.joints[index].kind == "R":
            apart = sp.N(sp.exp(sp.I * apart) - 1, 15)
        if abs(apart) > sp.Float("1e-9"):
            return False
    return True


def _sample_joints_on(
    chain: Chain, components: Sequence[Component], lengths: Mapping[sp.Symbol, sp.Expr], rng: Stream
) -> dict[sp.Symbol, sp.Expr] | None:
    """Sample joint values on components: first those that are solved, then one joint for each that ties several."""
    fixed: dict[sp.Symbol, sp.Expr] = {}
    for component in sorted(components, key=lambda component: component.solutions is None):
        if component.solutions is not None:
            values = dict(rng.choice(component.value_combinations()))
            if any(fixed.get(q, value) != value for q, value in values.items()):
                return None
            fixed.update({q: wrap_angle(chain, q, value.xreplace(dict(lengths))) for q, value in values.items()})
    if not all(_is_real(value) for value in fixed.values()):
        return None
    sampled = sample_pose(chain, rng)
    for component in components:
        if component.solutions is not None:
            continue
        if len(component.conditions) > 1:
            return None
        (condition,) = component.conditions
        free = [q for q in chain.q if condition.has(q) and q not in fixed]
        if not free:
            return None
        last = rng.choice(free)
        known = {**lengths, **sampled, **fixed}
        known.pop(last)
        zeros = _zeros(condition.xreplace(known), last, chain.joints[chain.q.index(last)].kind == "R")
        if not zeros:
            return None
        fixed.update({q: sampled[q] for q in free})
        fixed[last] = rng.choice(zeros)
    return {**sampled, **fixed}


def _sample_exact_joints_on(
    chain: Chain, components: Sequence[Component], lengths: Mapping[sp.Symbol, sp.Expr], rng: Stream
) -> dict[sp.Symbol, sp.Expr] | None:
    """Sample joint values on components; angles that conditions tie are multiples of 30 degrees in the table.

    Prismatic joints are then in steps of 5 cm, so that nothing has to be rounded.
    """
    solved = [component for component in components if component.solutions is not None]
    fixed = _sample_joints_on(chain, solved, lengths, rng)
    if fixed is None:
        return None
    solved_joints = {q for component in solved for q, _ in component.solutions or ()}
    conditions = [c for component in components if component.solutions is None for c in component.conditions]
    tied = [q for q in chain.q if q not in solved_joints and any(condition.has(q) for condition in conditions)]
    if not conditions:
        return fixed
    if not 0 < len(tied) <= MOST_TIED:
        return None
    kinds, offsets = (dict(zip(chain.q, items, strict=True)) for items in (chain.joints, chain.offsets))
    steps = {
        q: [wrap_angle(chain, q, k * sp.pi / 6 - offsets[q]) for k in range(12)]
        if kinds[q].kind == "R"
        else [sp.Rational(k, 20) for k in range(2, 17)]
        for q in tied
    }
    grid = np.meshgrid(*([float(value) for value in steps[q]] for q in tied), indexing="ij")
    values = {symbol.name: np.full(grid[0].size, float(sp.N(value))) for symbol, value in {**lengths, **fixed}.items()}
    values |= {q.name: axis.ravel() for q, axis in zip(tied, grid, strict=True)}
    programs = compile_program([read(str(condition)) for condition in conditions])
    apart = np.abs(evaluate(programs, values, grid[0].size)[0]).max(axis=0)
    places = np.argwhere(apart.reshape(grid[0].shape) < 1e-9)
    if not len(places):
        return None
    place = rng.choice(places.tolist())
    joints = {**fixed, **{q: steps[q][index] for q, index in zip(tied, place, strict=True)}}
    exact = {**lengths, **joints}
    return joints if all(abs(sp.N(c.xreplace(exact), DIGITS)) < sp.Float("1e-20") for c in conditions) else None


def _zeros(condition: sp.Expr, joint: sp.Symbol, turns: bool) -> list[sp.Expr]:
    """Return the zeros of a + b cos q + c sin q (or of a + b q), to 40 digits, none where it is of another form."""
    places = (sp.S.Zero, sp.pi / 2, sp.pi, sp.S.One) if turns else (sp.S.Zero, sp.S.One, sp.S(2), sp.S(3))
    start, quarter, half, test = (sp.N(condition.xreplace({joint: place}), KEPT) for place in places)
    tiny = sp.Float("1e-30")
    with mpmath.workdps(KEPT):
        if not turns:
            slope = quarter - start
            linear = abs(test - start - 3 * slope) < tiny and abs(slope) > sp.Float("1e-3")
            return [-start / slope] if linear else []
        a, b = (start + half) / 2, (start - half) / 2
        c = quarter - a
        size = sp.sqrt(b**2 + c**2)
        if abs(test - a - b * sp.N(sp.cos(1), KEPT) - c * sp.N(sp.sin(1), KEPT)) > tiny or size <= abs(a) + sp.Float(
            "1e-3"
        ):
            return []
        middle, away = sp.atan2(c, b), sp.acos(-a / size)
        zeros = [sp.N(middle + sign * away, KEPT) for sign in (1, -1)]
        return [value - 2 * sp.N(sp.pi, KEPT) * round(value / sp.N(2 * sp.pi, KEPT)) for value in zeros]


def _is_real(value: sp.Expr) -> bool:
    return value.is_real is True or bool(abs(sp.im(sp.N(value, DIGITS))) < sp.Float("1e-20"))


def wrap_angle(chain: Chain, joint: sp.Symbol, value: sp.Expr) -> sp.Expr:
    """Return a revolute joint's value in (-pi, pi] where it is a number."""
    if chain.joints[chain.q.index(joint)].kind == "P" or not value.is_number or not _is_real(value):
        return value
    turns = sp.floor((sp.pi - sp.N(value, DIGITS)) / (2 * sp.pi))
    return sp.expand(value + 2 * sp.pi * int(turns))
