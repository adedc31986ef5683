"""Certify problems: every reference is tested against the arm in numbers, by ways it was not derived by.

The references come from symbolic algebra on a structure (`derivation`). Here they are read back from their text, as
an answer is, evaluated at random places and held against products of 4 x 4 matrices, finite differences of the poses
and NumPy's linear algebra. A singular set is tested both ways: at every piece of it the rank is less, and every
configuration of less rank that Newton's method finds lies in it.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from exercises.chain import TASK_ROWS, Chain
from exercises.classification import REGULAR, Sample, domain_of, kind_at, samples_on
from exercises.conditions import Space, pieces
from exercises.derivation import derive
from exercises.expression import Node, ReadError, names, read
from exercises.kinematics import NumericChain
from exercises.problem import Choice, ConditionSet, Expression, Matrix, Number, Part, Problem, ProblemId
from exercises.questions.differentiation import moving_rows
from exercises.questions.singular import OPTIONS, Place
from exercises.singularity import singular_set
from exercises.stream import Stream
from exercises.tape import compile_tape, evaluate

ARMS, POSES = 3, 4
EXACT, DIFFERENCED = 1e-9, 1e-7
"""Relative error allowed against products of matrices, and against finite differences of them."""

STARTS, STEPS, SINGULAR = 30, 40, 1e-9
"""Searches for singular configurations on each arm, Newton steps of each, and sigma_min/sigma_max of a find."""

WELL_CONDITIONED = 0.1
_H = 1e-5


class Check(NamedTuple):
    """One thing that was tested: its name, whether it held, and what was found."""

    name: str
    passed: bool
    detail: str


@dataclass(frozen=True)
class ProblemCertificate:
    """What was tested of a problem, and how it came out."""

    problem: ProblemId
    engine: int
    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether every check held."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not hold."""
        return tuple(check for check in self.checks if not check.passed)

    def as_json(self) -> dict[str, Any]:
        """Return the form in which `show` and `verify` print it."""
        checks = [check._asdict() for check in self.checks]
        return {"problem": str(self.problem), "engine": self.engine, "passed": self.passed, "checks": checks}


def certify(problem: Problem) -> ProblemCertificate:
    """Test every reference of a problem; a question for which there is no test here fails, too.

    >>> from exercises.generate import generate
    >>> certify(generate(ProblemId("planar-2r", 7, ("determinant",)))).passed
    True
    """
    ground = Ground(problem)
    checks = [_one_meaning(problem.chain)]
    for part in problem.parts:
        checks.append(_readable(ground, part))
        if checks[-1].passed:
            checks += [Check(f"{part.name}: {name}", held, detail) for name, held, detail in _checks_of(ground, part)]
    return ProblemCertificate(problem.id, problem.id.engine, tuple(checks))


def _checks_of(ground: "Ground", part: Part) -> Iterator[Check]:
    known = CHECKS.get(part.kind)
    if known is None:
        yield Check("known", False, "nothing in exercises.verify.CHECKS tests this kind of question")
    else:
        yield from known(ground, part)


class Ground:
    """The arm in numbers at random places: ARMS choices of the open lengths, POSES poses of each.

    Arrays begin with the place: `frames` (…, n + 1, 4, 4), `point` (…, 3), `jacobian` (…, 6, n) by z x p;
    `carried` (…, n, n + 1, 6) is the velocity of each frame's origin and link for each joint's unit rate, and
    `moved` (…, n, 3) that of the point, both by central differences of the poses.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.chain = problem, problem.chain
        self.stream = Stream(f"verify/{problem.id.engine}/{problem.id}")
        self.task = [TASK_ROWS.index(row) for row in self.chain.task]
        self.known, self._trees = frozenset(problem.symbols()), dict[sp.Expr, Node]()
        self.lengths = [_lengths(self.chain, self.stream) for _ in range(ARMS)]
        self.arms = [NumericChain(self.chain, lengths) for lengths in self.lengths]
        poses = [_poses(self.chain, self.stream, POSES) for _ in self.arms]
        self.points = ARMS * POSES
        self.values = self._named(poses)
        self.frames = np.concatenate([arm.frames(q) for arm, q in zip(self.arms, poses, strict=True)])
        self.point = np.concatenate([arm.point(q) for arm, q in zip(self.arms, poses, strict=True)])
        self.jacobian = np.concatenate([arm.jacobian(q) for arm, q in zip(self.arms, poses, strict=True)])
        differences = [_differences(arm, q) for arm, q in zip(self.arms, poses, strict=True)]
        self.carried, self.moved = (np.concatenate(arrays) for arrays in zip(*differences, strict=True))

    def _named(self, poses: list[np.ndarray]) -> dict[str, np.ndarray]:
        values = {q.name: np.concatenate([pose[:, i] for pose in poses]) for i, q in enumerate(self.chain.q)}
        for name in (*(rate.name for rate in self.chain.rates), *TASK_ROWS):
            values[name] = np.array([self.stream.uniform(-2, 2) for _ in range(self.points)])
        for symbol in self.chain.parameters:
            values[symbol.name] = np.repeat([lengths[symbol.name] for lengths in self.lengths], POSES)
        return values

    @property
    def task_jacobian(self) -> np.ndarray:
        """The rows of the task, (…, m, n)."""
        return self.jacobian[:, self.task]

    @property
    def differenced_jacobian(self) -> np.ndarray:
        """The 6 x n Jacobian by finite differences: the point's velocity and the last link's angular velocity."""
        angular = self.carried[:, :, self.chain.n, 3:]
        return np.concatenate([self.moved, angular], axis=2).transpose(0, 2, 1)

    @property
    def rates(self) -> np.ndarray:
        """Joint rates, (…, n, 1)."""
        return np.stack([self.values[rate.name] for rate in self.chain.rates], axis=1)[:, :, None]

    @property
    def velocity(self) -> np.ndarray:
        """Task velocities, (…, m, 1)."""
        return np.stack([self.values[row] for row in self.chain.task], axis=1)[:, :, None]

    def tree(self, entry: sp.Expr) -> Node:
        """Return the tree of an entry's text, read as an answer is. Raises ReadError."""
        if entry not in self._trees:
            self._trees[entry] = read(str(entry), self.known)
        return self._trees[entry]

    def read(self, entries: sp.Matrix) -> np.ndarray:
        """Return the values of symbolic entries by way of their text, (…, rows, columns); complex if one is."""
        tape = compile_tape([self.tree(entry) for entry in entries])
        found = evaluate(tape, self.values, self.points)[0]
        real = found.real if np.all(np.abs(found.imag) <= 1e-12 * (1 + np.abs(found))) else found
        return real.T.reshape(self.points, *entries.shape)


def _lengths(chain: Chain, stream: Stream) -> dict[str, float]:
    roles = domain_of(chain).roles
    ends = {"angle": (-np.pi, np.pi), "length": (0.25, 1.25)}
    return {symbol.name: stream.uniform(*ends[str(roles[symbol.name])]) for symbol in chain.parameters}


def _poses(chain: Chain, stream: Stream, count: int) -> np.ndarray:
    ends = [(-np.pi, np.pi) if joint.kind == "R" else (-1.5, 1.5) for joint in chain.joints]
    return np.array([[stream.uniform(*pair) for pair in ends] for _ in range(count)])


def _differences(arm: NumericChain, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities of frames (…, n, n + 1, 6) and of the point (…, n, 3) for unit rates, by differences."""
    nudge = _H * np.eye(q.shape[1])
    ahead, behind = (arm.frames(q[:, None, :] + side * nudge) for side in (1, -1))
    slope = (ahead - behind) / (2 * _H)
    spin = slope[..., :3, :3] @ arm.frames(q)[:, None, :, :3, :3].swapaxes(-1, -2)
    angular = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
    moved = (arm.point_of(ahead) - arm.point_of(behind)) / (2 * _H)
    return np.concatenate([slope[..., :3, 3], angular], axis=-1), moved


# --- what holds for any part ---


def _one_meaning(chain: Chain) -> Check:
    """Look for a symbol that stands for two things, as a length named after another entry of the table does."""
    taken = {symbol.name for symbol in (*chain.q, *chain.rates)} | set(TASK_ROWS)
    twice = sorted(symbol.name for symbol in chain.parameters if symbol.name in taken)
    for symbol in chain.parameters:
        match = re.fullmatch(r"([ad])([1-9]\d*)", symbol.name)
        if match and int(match.group(2)) <= chain.n:
            joint = chain.joints[int(match.group(2)) - 1]
            own = joint.a if match.group(1) == "a" else joint.d
            if own != 0 and not own.has(symbol):
                twice.append(symbol.name)
    return Check("symbols", not twice, f"{', '.join(twice)} stands for two things" if twice else "each has one meaning")


def _trees(ground: Ground, part: Part) -> list[Node]:
    answer = part.answer
    if isinstance(answer, ConditionSet):
        return [read(text, ground.known) for text in answer.pieces()]
    return [] if isinstance(answer, Choice) else [ground.tree(entry) for entry in _reference(part)]


def _usable(ground: Ground, part: Part) -> set[str]:
    """Return the symbols that a part may use: all of the problem's; joints and lengths in conditions on them."""
    if isinstance(part.answer, ConditionSet):
        return {symbol.name for symbol in (*ground.chain.q, *ground.chain.parameters)}
    return set(ground.known)


def _readable(ground: Ground, part: Part) -> Check:
    """Read every text of the reference as an answer is read, and look for symbols that the problem does not have."""
    name = f"{part.name}: readable"
    try:
        strange = set[str]().union(*map(names, _trees(ground, part))) - _usable(ground, part)
    except ReadError as error:
        return Check(name, False, str(error))
    if strange:
        return Check(name, False, f"{', '.join(sorted(strange))} is no symbol of the problem")
    return Check(name, True, "its text is understood, and holds the problem's symbols only")


# --- formulas ---


def _agree(name: str, found: np.ndarray, expected: np.ndarray, allowed: float) -> Check:
    """Hold values against those expected, both (…, rows, columns)."""
    if found.shape != expected.shape:
        shapes = [" x ".join(map(str, array.shape[1:])) for array in (found, expected)]
        return Check(name, False, f"the reference is {shapes[0]}, expected {shapes[1]}")
    scale = 1 + np.abs(expected).max(axis=(1, 2), keepdims=True)
    error = np.where(np.isfinite(found), np.abs(found - expected) / scale, np.inf)
    worst = np.unravel_index(int(error.argmax()), error.shape)
    if error[worst] <= allowed:
        return Check(name, True, f"{len(found)} places, error at most {error[worst]:.1e}")
    row, column = worst[1] + 1, worst[2] + 1
    return Check(name, False, f"entry ({row}, {column}): {found[worst]:.6g}, expected {expected[worst]:.6g}")


def _reference(part: Part) -> sp.Matrix:
    if isinstance(part.answer, Expression):
        return sp.Matrix([part.answer.reference])
    assert isinstance(part.answer, (Matrix, Number))
    return sp.Matrix(part.answer.reference)


Expected = Callable[[Ground, Part], dict[str, tuple[np.ndarray, float]]]


def _formula(expected: Expected) -> Callable[[Ground, Part], Iterator[Check]]:
    """Return the check that a symbolic reference has the values expected, by each way of finding them."""

    def check(ground: Ground, part: Part) -> Iterator[Check]:
        found = ground.read(_reference(part))
        for name, (values, allowed) in expected(ground, part).items():
            yield _agree(name, found, values, allowed)

    return check


def _both(by_product: np.ndarray, by_difference: np.ndarray) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (by_product, EXACT), "finite differences": (by_difference, DIFFERENCED)}


def _position(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (ground.point[:, moving_rows(ground.chain), None], EXACT)}


def _velocity(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    rows = moving_rows(ground.chain)
    return _both(ground.jacobian[:, rows] @ ground.rates, ground.differenced_jacobian[:, rows] @ ground.rates)


def _component(ground: Ground, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    row = "xyz".index(str(part.details["axis"]))
    pair = (ground.jacobian[:, [row]] @ ground.rates, ground.differenced_jacobian[:, [row]] @ ground.rates)
    return _both(*pair)


def _jacobian(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return _both(ground.task_jacobian, ground.differenced_jacobian[:, ground.task])


def _axes(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (ground.frames[:, :-1, :3, 2].transpose(0, 2, 1), EXACT)}


def _vectors(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": ((ground.point[:, None] - ground.frames[:, :-1, :3, 3]).transpose(0, 2, 1), EXACT)}


def _geometric(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return _both(ground.jacobian, ground.differenced_jacobian)


def _twist(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return _both(ground.jacobian @ ground.rates, ground.differenced_jacobian @ ground.rates)


def _link_velocity(ground: Ground, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = int(str(part.details["frame"]))
    carried = ground.carried[:, :, frame].transpose(0, 2, 1)
    return {"finite differences": (carried @ ground.rates, DIFFERENCED)}


def _determinant(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"LU decomposition": (np.linalg.det(ground.task_jacobian)[:, None, None], EXACT)}


def _inverse(ground: Ground, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by its inverse; the result is 1."""
    yield _undone(ground, part, np.broadcast_to(np.eye(ground.chain.n), ground.task_jacobian.shape))


def _rate_law(ground: Ground, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by the rates; the result is the velocity asked for."""
    yield _undone(ground, part, ground.velocity)


def _undone(ground: Ground, part: Part, expected: np.ndarray) -> Check:
    found = ground.read(_reference(part))
    if found.shape != expected.shape:
        return _agree("J times it", found, expected, EXACT)
    size = (np.abs(ground.task_jacobian) @ np.abs(found)).max(axis=(1, 2), keepdims=True)
    return _agree("J times it", ground.task_jacobian @ found / size, expected / size, EXACT)


# --- numbers ---


def _joint_rates(ground: Ground, part: Part) -> Iterator[Check]:
    """Solve J qd = v in floating point, at a pose where small errors stay small."""
    situation: Any = part.details["situation"]
    arm = NumericChain(ground.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
    jacobian = arm.jacobian(np.array([float(situation.joints[q]) for q in ground.chain.q]))[ground.task]
    velocity = np.array([float(situation.velocity[sp.Symbol(row)]) for row in ground.chain.task])
    expected = np.linalg.solve(jacobian, velocity)
    found = np.array(_reference(part).tolist(), dtype=float)
    yield _agree("linear solve", found[None], expected[None, :, None], 1e-8)
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    detail = f"sigma_min/sigma_max = {sigma[-1] / sigma[0]:.3f}"
    yield Check("well conditioned", bool(sigma[-1] / sigma[0] > WELL_CONDITIONED), detail)
    assert isinstance(part.answer, Number)
    allowed = np.maximum(part.answer.tolerance * np.abs(expected), part.answer.floor)
    rounded = np.array([float(f"{value:.2e}") for value in expected])
    yield Check("three digits", bool(np.all(np.abs(rounded - expected) <= allowed)), "rounding keeps it right")


# --- singular configurations ---


def _singular(ground: Ground, part: Part) -> Iterator[Check]:
    assert isinstance(part.answer, ConditionSet)
    joints = [q.name for q in ground.chain.q]
    texts = part.answer.pieces()
    claimed = [piece for text in texts for piece in pieces(read(text, ground.known), joints)]
    yield from _sound(ground, texts, claimed, joints)
    yield _complete(ground, claimed, joints)


def _sound(ground: Ground, texts: Sequence[str], claimed: list[Any], joints: list[str]) -> Iterator[Check]:
    """Draw configurations on every piece: there are some, and the Jacobian has lost rank there."""
    for text, piece in zip(texts, claimed, strict=True):
        ratios: list[float] = []
        for lengths, arm in zip(ground.lengths, ground.arms, strict=True):
            space = Space(joints, domain_of(ground.chain, lengths))
            values = space.on_piece(piece, space.names_of([[piece]]), ground.stream, count=8)
            q = np.stack([values[joint] for joint in joints], axis=1)
            ratios += _ratios(arm.jacobian(q)[:, ground.task]).tolist()
        detail = f"{len(ratios)} configurations, sigma_min/sigma_max at most {max(ratios, default=0.0):.1e}"
        yield Check(f"rank at {text}", bool(ratios) and max(ratios) < REGULAR, detail)


def _ratios(jacobians: np.ndarray) -> np.ndarray:
    sigma = np.linalg.svd(jacobians, compute_uv=False)
    return np.asarray(sigma[..., -1] / np.maximum(sigma[..., 0], 1e-300))


def _complete(ground: Ground, claimed: list[Any], joints: list[str]) -> Check:
    """Search for singular configurations from random poses, and look for each in the claimed set."""
    found = 0
    for lengths, arm in zip(ground.lengths, ground.arms, strict=True):
        q = singular_configurations(arm, _poses(ground.chain, ground.stream, STARTS), ground.task)
        found += len(q)
        space = Space(joints, domain_of(ground.chain, lengths))
        values = dict(zip(joints, q.T, strict=True))
        values.update({name: np.full(len(q), length) for name, length in lengths.items()})
        outside = np.nonzero(~space.contains(claimed, values, len(q)))[0]
        if len(outside):
            at = ", ".join(f"{name} = {column[outside[0]]:.4g}" for name, column in values.items())
            return Check("complete", False, f"J loses rank at {at}, which no condition covers")
    return Check("complete", True, f"all of {found} singular configurations found by search are covered")


def singular_configurations(arm: NumericChain, starts: np.ndarray, task: Sequence[int]) -> np.ndarray:
    """Return singular configurations of J[task], (…, n), that Gauss-Newton on its maximal minors reaches."""
    q, nudge = starts.copy(), 1e-6 * np.eye(starts.shape[1])
    for _ in range(STEPS):
        around = np.concatenate([q[:, None], q[:, None] + nudge, q[:, None] - nudge], axis=1)
        minors = _minors(arm.jacobian(around)[..., task, :])
        n = q.shape[1]
        slopes = (minors[:, 1 : n + 1] - minors[:, n + 1 :]) / 2e-6
        move = np.einsum("pim,pm->pi", np.linalg.pinv(slopes.swapaxes(1, 2), rcond=1e-8), minors[:, 0])
        q -= move * np.minimum(1.0, 0.7 / np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-300))
    return np.asarray(q[_ratios(arm.jacobian(q)[:, task]) < SINGULAR])


def _minors(jacobians: np.ndarray) -> np.ndarray:
    """Return all maximal minors of (…, m, n), stacked along the last axis."""
    rows, columns = jacobians.shape[-2:]
    size = min(rows, columns)
    chosen = [
        jacobians[..., np.array(r)[:, None], np.array(c)]
        for r in combinations(range(rows), size)
        for c in combinations(range(columns), size)
    ]
    return np.stack([np.linalg.det(minor) for minor in chosen], axis=-1)


def _type(ground: Ground, part: Part) -> Iterator[Check]:
    """Find the kind again for lengths that the question has not tried."""
    kind, place = str(part.details["type"]), part.details["place"]
    assert isinstance(part.answer, Choice)
    assert isinstance(place, Place)
    options = part.answer.options
    right = len(set(options)) == len(options) and options[part.answer.correct] == OPTIONS[kind]
    yield Check("option", right, f"{part.answer.letter} is {options[part.answer.correct]}")
    samples = _samples(ground, place)
    kinds = {str(kind_at(ground.chain, sample)) for sample in samples}
    detail = f"{', '.join(sorted(kinds))} at {len(samples)} configurations"
    yield Check("kind", bool(samples) and kinds == {kind}, detail)
    if kind == "regular" and place.condition is None and len(ground.task) == ground.chain.n:
        yield _regular_throughout(ground, place)


def _regular_throughout(ground: Ground, place: Place) -> Check:
    """Look at the sign of det J for short and long lengths: where it stays, the pose is regular for all of them."""
    signs = set()
    for _ in range(40):
        lengths = {name: value * 4 ** ground.stream.uniform(-1, 1) for name, value in ground.lengths[0].items()}
        arm, q = NumericChain(ground.chain, lengths), _pose(ground.chain, place, lengths)
        signs.add(float(np.sign(np.linalg.det(arm.jacobian(q)[ground.task]))))
    return Check("regular for all lengths", len(signs) == 1, f"signs of det J: {sorted(signs)}")


def _samples(ground: Ground, place: Place) -> list[Sample]:
    if place.condition is not None:
        return samples_on(ground.chain, f"{place.condition} = 0", f"verify/{ground.problem.id}", arms=ARMS, each=1)
    pairs = zip(ground.arms, ground.lengths, strict=True)
    return [Sample(arm, _pose(ground.chain, place, lengths)) for arm, lengths in pairs]


def _pose(chain: Chain, place: Place, lengths: dict[str, float]) -> np.ndarray:
    numbers = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
    return np.array([float(sp.N(place.joints[q].xreplace(numbers))) for q in chain.q])


CHECKS: dict[str, Callable[[Ground, Part], Iterator[Check]]] = {
    "position": _formula(_position),
    "velocity": _formula(_velocity),
    "velocity-component": _formula(_component),
    "jacobian": _formula(_jacobian),
    "joint-axes": _formula(_axes),
    "position-vectors": _formula(_vectors),
    "geometric-jacobian": _formula(_geometric),
    "twist": _formula(_twist),
    "link-velocity": _formula(_link_velocity),
    "determinant": _formula(_determinant),
    "inverse-jacobian": _inverse,
    "inverse-velocity": _rate_law,
    "joint-rates": _joint_rates,
    "singular-angles": _singular,
    "singularity-type": _type,
}
"""The test of each kind of question; one that is not here can't be certified."""


# --- how hard an arm is ---


def difficulty(chain: Chain) -> int:
    """Return terms of J + 4 x conditions of the singular set + 8 x those that tie several joints.

    The conditions are the factors of det J that can vanish, where J is square. Example 6.3 has 15 + 8 + 8 = 31.
    """
    entries = [sp.expand(entry) for entry in derive(chain).jacobian]
    terms = sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0)
    factors = {condition for component in singular_set(chain) or () for condition in component.conditions}
    tying = sum(len(factor.free_symbols & set(chain.q)) > 1 for factor in factors)
    return terms + 4 * len(factors) + 8 * tying


def step(chain: Chain) -> int:
    """Return the band of the difficulty: 0 below 10, 1 below 16, 2 below 24, 3 below 34, 4 above."""
    return sum(difficulty(chain) >= least for least in (10, 16, 24, 34))
