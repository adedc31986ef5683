"""Check singular sets, and the type of a singularity.

A singular set is checked in both directions: J loses rank everywhere on it, and it contains every singular
configuration that a numerical search finds. The type of a singularity is determined again for other lengths.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.answers import Choice, ConditionSet
from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.classification import domain_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.normalized_arm import normalize_arm
from qdot.exercises.arm.singularity_kinds import REGULAR, kinds_at
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.set_parser import parse_pieces
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.singular import OPTIONS, OfKind, Place, find_components_at
from qdot.exercises.verify.appearance import (
    check_component_statement,
    check_singularity_statements,
    side_of_lost_direction,
)
from qdot.exercises.verify.formulas import PartCheck
from qdot.exercises.verify.numeric_reference import (
    ARMS,
    Check,
    Checks,
    NumericReference,
    random_lengths,
    random_poses,
    samples_where,
)

STARTS, STARTS_REDUNDANT, STEPS, SINGULAR = 30, 150, 40, 1e-9
"""Searches on each arm, on each redundant arm, steps of a search, and maximum sigma_min/sigma_max at its end.

A redundant arm has singular components of lower dimension, which fewer of the searches reach."""

STILL_SINGULAR = 1e-8
"""The same maximum for the arm with other joint offsets, which change the rounding."""

STILL = 1e-12
"""Size of a step below which the iteration stops."""

FURTHER_ARMS = 300
"""Number of choices of lengths to try if a piece of the set does not exist for the reference's lengths."""

NEAR, AROUND = 1e-5, 0.003
"""Maximum distance of a singular configuration from the claimed set, and the radius for further searches.

Near an intersection of components, sigma_min is a product of distances, so that it vanishes in rounding farther away
from the set. The further searches decide then."""


def _check_singular_set(numeric: NumericReference, part: Part) -> Checks:
    """Check a singular set in both directions, and what the worked solution says about it."""
    answer = part.of(ConditionSet)
    joints = [q.name for q in numeric.chain.q]
    texts = answer.pieces()
    claimed = [piece for text in texts for piece in parse_pieces(read(text, numeric.known), joints)]
    yield from _check_soundness(numeric, texts, claimed, joints)
    yield _check_completeness(numeric, claimed, joints)
    yield from check_singularity_statements(numeric)


def _check_soundness(numeric: NumericReference, texts: Sequence[str], claimed: list[Any], joints: list[str]) -> Checks:
    """Check that every piece contains configurations, and that the Jacobian loses rank there."""
    for text, piece in zip(texts, claimed, strict=True):
        ratios_by_arm = [_ratios_on(numeric, piece, lengths, joints) for lengths in numeric.lengths]
        ratios = [ratio for arm_ratios in ratios_by_arm for ratio in arm_ratios] or _ratios_elsewhere(
            numeric, piece, joints
        )
        detail = f"{len(ratios)} configurations, sigma_min/sigma_max at most {max(ratios, default=0.0):.1e}"
        yield Check(f"rank at {text}", bool(ratios) and max(ratios) < REGULAR, detail)


def _ratios_on(numeric: NumericReference, piece: Any, lengths: dict[str, float], joints: list[str]) -> list[float]:
    """Return sigma_min/sigma_max of J at configurations on a piece, for an arm with the given lengths."""
    space = Space(joints, domain_of(numeric.chain, lengths))
    values = space.on_piece(piece, space.names_of([[piece]]), numeric.stream, count=8)
    q = np.stack([values[joint] for joint in joints], axis=1)
    return [float(ratio) for ratio in _ratios(NumericChain(numeric.chain, lengths).jacobian(q)[:, numeric.task])]


def _ratios_elsewhere(numeric: NumericReference, piece: Any, joints: list[str]) -> list[float]:
    """Return sigma_min/sigma_max of J at configurations on a piece, for other lengths.

    A piece such as theta3 = acos(-a2/a3) exists only for some lengths. The first arm on which it exists is used.
    """
    for _ in range(FURTHER_ARMS):
        ratios = _ratios_on(numeric, piece, random_lengths(numeric.chain, numeric.stream), joints)
        if ratios:
            return ratios
    return []


def _ratios(jacobians: np.ndarray) -> np.ndarray:
    """Return sigma_min/sigma_max of Jacobians; for a Jacobian that is nearly zero, the result is nearly zero, too."""
    sigma = np.linalg.svd(jacobians, compute_uv=False)
    return np.asarray(sigma[..., -1] / np.maximum(sigma[..., 0], 1e-6))


def _check_completeness(numeric: NumericReference, claimed: list[Any], joints: list[str]) -> Check:
    """Check that the claimed set contains the singular configurations that a search from random starts finds.

    The search runs on the normalized arm, once for all arms that share it. Therefore its results are first
    checked to be singular for this arm, too.
    """
    count, chain = 0, numeric.chain
    for sampled_lengths, at_zero in _search_on_each_arm(normalize_arm(chain)):
        lengths = random_lengths(chain, numeric.stream) | dict(sampled_lengths)
        arm, space = NumericChain(chain, lengths), Space(joints, domain_of(chain, lengths))

        def outside(q: np.ndarray, lengths: dict[str, float] = lengths, space: Space = space) -> np.ndarray:
            """Return the configurations that satisfy no condition."""
            values = dict(zip(joints, q.T, strict=True)) | {name: np.full(len(q), v) for name, v in lengths.items()}
            return np.asarray(q[~space.contains(claimed, values, len(q), NEAR)])

        q = at_zero - np.array(arm.offsets)
        if len(q) and _ratios(arm.jacobian(q)[:, numeric.task]).max() > STILL_SINGULAR:
            return Check("complete", False, "J keeps its rank where that of the same arm with other zeros loses it")
        count += len(q)
        for uncovered in outside(q):
            starts = uncovered + AROUND * random_poses(chain, numeric.stream, STARTS)
            nearby_results = singular_configurations(arm, starts, numeric.task)
            if 2 * len(outside(nearby_results)) >= len(nearby_results):
                location = ", ".join(
                    f"{name} = {value:.4g}" for name, value in [*zip(joints, uncovered, strict=True), *lengths.items()]
                )
                return Check("complete", False, f"J loses rank at {location}, which no condition covers")
    return Check("complete", True, f"all of {count} singular configurations found by search are covered")


@lru_cache(maxsize=1024)
def _search_on_each_arm(chain: Chain) -> tuple[tuple[tuple[tuple[str, float], ...], np.ndarray], ...]:
    """Return choices of the symbolic lengths of a normalized arm, with the singular configurations found for each."""
    task, stream = [TASK_ROWS.index(row) for row in chain.task], Stream("verify/singular")
    results = []
    for _ in range(ARMS):
        lengths = random_lengths(chain, stream)
        starts = random_poses(chain, stream, STARTS_REDUNDANT if chain.n > len(task) else STARTS)
        q = singular_configurations(NumericChain(chain, lengths), starts, task)
        q.setflags(write=False)
        results.append((tuple(lengths.items()), q))
    return tuple(results)


def singular_configurations(arm: NumericChain, starts: np.ndarray, task: Sequence[int]) -> np.ndarray:
    """Return singular configurations of J[task], (..., n), that Gauss-Newton reaches from `starts`.

    The unknowns are q and a unit vector u with J^T u = 0 (J u = 0 if J has more rows than columns). These equations
    converge quickly on components of any dimension. Equations in the minors of J, which may be products, do not.
    """
    q, nudge = starts.copy(), 1e-6 * np.eye(starts.shape[1])
    count, n = q.shape

    def narrow(q: np.ndarray) -> np.ndarray:
        jacobian = arm.jacobian(q)[..., task, :]
        return np.asarray(jacobian if len(task) <= n else jacobian.swapaxes(-1, -2))

    u = np.linalg.svd(narrow(q))[0][..., -1]
    for _ in range(STEPS):
        matrices = narrow(np.concatenate([q[:, None], q[:, None] + nudge, q[:, None] - nudge], axis=1))
        products = np.einsum("pkmn,pm->pkn", matrices, u)
        derivatives = (products[:, 1 : n + 1] - products[:, n + 1 :]) / 2e-6
        unit = np.concatenate([np.zeros((count, 1, n)), u[:, None]], axis=2)
        system = np.concatenate([np.concatenate([derivatives, matrices[:, 0]], axis=1).swapaxes(1, 2), unit], axis=1)
        residuals = np.concatenate([products[:, 0], np.zeros((count, 1))], axis=1)
        step = np.einsum("pij,pj->pi", np.linalg.pinv(system, rcond=1e-8), residuals)
        step *= np.minimum(1.0, 0.7 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        q, u = q - step[:, :n], u - step[:, n:]
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        if np.abs(step).max() < STILL:  # quadratic convergence: usually after 7 of the 40 steps
            break
    return np.asarray(q[_ratios(arm.jacobian(q)[:, task]) < SINGULAR])


def _check_type(numeric: NumericReference, part: Part) -> Checks:
    """Check the kind of a singularity by determining it again, for lengths that the question did not use."""
    answer, details = part.of(Choice), part.about(OfKind)
    kind, configuration = details.type, details.place
    options = answer.options
    is_correct_option = len(set(options)) == len(options) and options[answer.correct] == OPTIONS[kind]
    yield Check("option", is_correct_option, f"{answer.letter} is {options[answer.correct]}")
    samples = _samples(numeric, configuration)
    kinds = set(map(str, kinds_at(numeric.chain, samples)))
    detail = f"{', '.join(sorted(kinds))} at {len(samples)} configurations"
    yield Check("kind", bool(samples) and kinds == {kind}, detail)
    for _, component in find_components_at(numeric.chain, configuration):
        yield check_component_statement(numeric.chain, component)
    if kind == "boundary":
        yield side_of_lost_direction(numeric.chain, configuration.condition, configuration.values, samples)
    if kind == "regular" and configuration.condition is None and len(numeric.task) == numeric.chain.n:
        yield _check_regular(numeric, configuration)


def _check_regular(numeric: NumericReference, place: Place) -> Check:
    """Check that det J has the same sign for short and long lengths.

    The configuration is then regular for all of them.
    """
    signs = set()
    for _ in range(40):
        lengths = {name: value * 4 ** numeric.stream.uniform(-1, 1) for name, value in numeric.lengths[0].items()}
        arm, q = NumericChain(numeric.chain, lengths), _pose(numeric.chain, place, lengths)
        signs.add(float(np.sign(np.linalg.det(arm.jacobian(q)[numeric.task]))))
    return Check("regular for all lengths", len(signs) == 1, f"signs of det J: {sorted(signs)}")


def _samples(numeric: NumericReference, place: Place) -> list[Sample]:
    if place.condition is not None:
        return samples_where(numeric, place.condition, arms=ARMS, each=1)
    pairs = zip(numeric.arms, numeric.lengths, strict=True)
    return [Sample(arm, _pose(numeric.chain, place, lengths)) for arm, lengths in pairs]


def _pose(chain: Chain, place: Place, lengths: dict[str, float]) -> np.ndarray:
    numbers = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
    return np.array([float(sp.N(place.joints[q].xreplace(numbers))) for q in chain.q])


CHECKS: dict[str, PartCheck] = {
    "singular-angles": _check_singular_set,
    "singularity-type": _check_type,
}
