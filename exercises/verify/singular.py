"""Check singular sets, and the type of a singularity.

A singular set is checked in both directions: J loses rank everywhere on it, and it contains every singular
configuration that a numerical search finds. The type of a singularity is determined again for other lengths.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Choice, ConditionSet
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import parse_pieces
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.singular import KIND_OPTIONS, ConfigurationsOfOneKind, KindDetails, find_components_with
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import domain_of
from qdot.exercises.singularities.normalized_arm import normalize_arm
from qdot.exercises.singularities.singularity_kinds import RANK_TOLERANCE, classify_samples
from qdot.exercises.verify.appearance import (
    check_component_statement,
    check_singularity_statements,
    side_of_lost_direction,
)
from qdot.exercises.verify.formulas import PartCheck
from qdot.exercises.verify.numeric_reference import (
    ARM_COUNT,
    Check,
    Checks,
    NumericReference,
    conditioning_ratios,
    random_configurations,
    random_lengths,
    samples_on_condition,
)

START_COUNT, REDUNDANT_START_COUNT, MAX_STEPS, MAX_SINGULAR_RATIO = 30, 150, 40, 1e-9
"""Number of searches on each arm and on each redundant arm, and steps and final sigma_min/sigma_max of a search.

The last two are maxima.

A redundant arm has singular components of lower dimension, which fewer of the searches reach."""

MAX_SHIFTED_RATIO = 1e-8
"""Maximum sigma_min/sigma_max at a search's end for an arm with other joint offsets, which change the rounding."""

MIN_STEP = 1e-12
"""Size of a step below which the iteration stops."""

MAX_FURTHER_ARMS = 300
"""Number of choices of lengths to try if a piece of the set does not exist for the reference's lengths."""

SET_TOLERANCE, SEARCH_RADIUS = 1e-5, 0.003
"""Maximum distance of a singular configuration from the claimed set, and the radius for further searches.

Near an intersection of components, sigma_min is a product of distances, so that it vanishes in rounding farther away
from the set. Then the further searches decide."""


def _check_singular_set(numeric: NumericReference, part: Part) -> Checks:
    """Check a singular set in both directions, and what the worked solution says about it."""
    answer = part.answer_as(ConditionSet)
    joints = [q.name for q in numeric.chain.q]
    texts = answer.pieces()
    claimed = [piece for text in texts for piece in parse_pieces(parse_formula(text, numeric.symbol_names), joints)]
    yield from _check_soundness(numeric, texts, claimed, joints)
    yield _check_completeness(numeric, claimed, joints)
    yield from check_singularity_statements(numeric)


def _check_soundness(numeric: NumericReference, texts: Sequence[str], claimed: list[Any], joints: list[str]) -> Checks:
    """Check that every piece contains configurations, and that the Jacobian loses rank there."""
    for text, piece in zip(texts, claimed, strict=True):
        ratios = [each for lengths in numeric.lengths for each in _ratios_on_piece(numeric, piece, lengths, joints)]
        ratios = ratios or _ratios_for_other_lengths(numeric, piece, joints)
        detail = f"{len(ratios)} configurations, sigma_min/sigma_max at most {max(ratios, default=0.0):.1e}"
        yield Check(f"rank at {text}", bool(ratios) and max(ratios) < RANK_TOLERANCE, detail)


def _ratios_on_piece(
    numeric: NumericReference, piece: Any, lengths: dict[str, float], joints: list[str]
) -> list[float]:
    """Return sigma_min/sigma_max of J at configurations on a piece, for an arm with the given lengths."""
    space = ConfigurationSpace(joints, domain_of(numeric.chain, lengths))
    values = space.sample_piece(piece, space.collect_names([[piece]]), numeric.rng, count=8)
    q = np.stack([values[joint] for joint in joints], axis=1)
    jacobians = NumericChain(numeric.chain, lengths).jacobian(q)[:, numeric.task]
    return [float(ratio) for ratio in conditioning_ratios(jacobians)]


def _ratios_for_other_lengths(numeric: NumericReference, piece: Any, joints: list[str]) -> list[float]:
    """Return sigma_min/sigma_max of J at configurations on a piece, for other lengths.

    A piece such as theta3 = acos(-a2/a3) exists only for some lengths. The first arm on which it exists is used.
    """
    for _ in range(MAX_FURTHER_ARMS):
        ratios = _ratios_on_piece(numeric, piece, random_lengths(numeric.chain, numeric.rng), joints)
        if ratios:
            return ratios
    return []


def _check_completeness(numeric: NumericReference, claimed: list[Any], joints: list[str]) -> Check:
    """Check that the claimed set contains the singular configurations that a search from random starts finds.

    The search runs on the normalized arm, once for all arms that share it. Therefore its results are first
    checked to be singular for this arm, too.
    """
    count, chain = 0, numeric.chain
    for sampled_lengths, at_zero in _search_on_arms(normalize_arm(chain)):
        lengths = random_lengths(chain, numeric.rng) | dict(sampled_lengths)
        arm, space = NumericChain(chain, lengths), ConfigurationSpace(joints, domain_of(chain, lengths))

        def find_uncovered(
            q: np.ndarray, lengths: dict[str, float] = lengths, space: ConfigurationSpace = space
        ) -> np.ndarray:
            """Return the configurations that satisfy no condition."""
            values = dict(zip(joints, q.T, strict=True)) | {name: np.full(len(q), v) for name, v in lengths.items()}
            return np.asarray(q[~space.contains(claimed, values, len(q), SET_TOLERANCE)])

        q = at_zero - np.array(arm.offsets)
        if len(q) and conditioning_ratios(arm.jacobian(q)[:, numeric.task]).max() > MAX_SHIFTED_RATIO:
            return Check("complete", False, "J keeps its rank where that of the same arm with other zeros loses it")
        count += len(q)
        for uncovered in find_uncovered(q):
            starts = uncovered + SEARCH_RADIUS * random_configurations(chain, numeric.rng, START_COUNT)
            nearby_results = find_singular_configurations(arm, starts, numeric.task)
            if 2 * len(find_uncovered(nearby_results)) >= len(nearby_results):
                pairs = [*zip(joints, uncovered, strict=True), *lengths.items()]
                location = ", ".join(f"{name} = {value:.4g}" for name, value in pairs)
                return Check("complete", False, f"J loses rank at {location}, which no condition covers")
    return Check("complete", True, f"all of {count} singular configurations found by search are covered")


@lru_cache(maxsize=1024)
def _search_on_arms(chain: Chain) -> tuple[tuple[tuple[tuple[str, float], ...], np.ndarray], ...]:
    """Return choices of the symbolic lengths of a normalized arm, with the singular configurations found for each."""
    task, stream = [TASK_ROWS.index(row) for row in chain.task], Stream("verify/singular")
    results = []
    for _ in range(ARM_COUNT):
        lengths = random_lengths(chain, stream)
        starts = random_configurations(chain, stream, REDUNDANT_START_COUNT if chain.n > len(task) else START_COUNT)
        q = find_singular_configurations(NumericChain(chain, lengths), starts, task)
        q.setflags(write=False)
        results.append((tuple(lengths.items()), q))
    return tuple(results)


def find_singular_configurations(arm: NumericChain, starts: np.ndarray, task: Sequence[int]) -> np.ndarray:
    """Return singular configurations of J[task], (..., n), that Gauss-Newton reaches from `starts`.

    The unknowns are q and a unit vector u with J^T u = 0 (J u = 0 if J has more rows than columns). These equations
    converge quickly on components of any dimension. Equations in the minors of J, which may be products, do not.
    """
    q, nudge = starts.copy(), 1e-6 * np.eye(starts.shape[1])
    count, n = q.shape

    def task_jacobian(q: np.ndarray) -> np.ndarray:
        jacobian = arm.jacobian(q)[..., task, :]
        return np.asarray(jacobian if len(task) <= n else jacobian.swapaxes(-1, -2))

    u = np.linalg.svd(task_jacobian(q))[0][..., -1]
    for _ in range(MAX_STEPS):
        matrices = task_jacobian(np.concatenate([q[:, None], q[:, None] + nudge, q[:, None] - nudge], axis=1))
        products = np.einsum("pkmn,pm->pkn", matrices, u)
        derivatives = (products[:, 1 : n + 1] - products[:, n + 1 :]) / 2e-6
        unit = np.concatenate([np.zeros((count, 1, n)), u[:, None]], axis=2)
        system = np.concatenate([np.concatenate([derivatives, matrices[:, 0]], axis=1).swapaxes(1, 2), unit], axis=1)
        residuals = np.concatenate([products[:, 0], np.zeros((count, 1))], axis=1)
        step = np.einsum("pij,pj->pi", np.linalg.pinv(system, rcond=1e-8), residuals)
        step *= np.minimum(1.0, 0.7 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        q, u = q - step[:, :n], u - step[:, n:]
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        if np.abs(step).max() < MIN_STEP:  # quadratic convergence: usually after 7 of the 40 steps
            break
    return np.asarray(q[conditioning_ratios(arm.jacobian(q)[:, task]) < MAX_SINGULAR_RATIO])


def _check_kind(numeric: NumericReference, part: Part) -> Checks:
    """Check the kind of a singularity by determining it again, for lengths that the question did not use."""
    answer, details = part.answer_as(Choice), part.details_as(KindDetails)
    kind, configuration = details.singularity_kind, details.configurations
    options = answer.options
    is_correct_option = len(set(options)) == len(options) and options[answer.correct] == KIND_OPTIONS[kind]
    yield Check("option", is_correct_option, f"{answer.letters} is {options[answer.correct]}")
    samples = _configuration_samples(numeric, configuration)
    kinds = set(map(str, classify_samples(numeric.chain, samples)))
    detail = f"{', '.join(sorted(kinds))} at {len(samples)} configurations"
    yield Check("kind", bool(samples) and kinds == {kind}, detail)
    for _, component in find_components_with(numeric.chain, configuration):
        yield check_component_statement(numeric.chain, component)
    if kind == "boundary":
        yield side_of_lost_direction(numeric.chain, configuration.condition, configuration.values, samples)
    if kind == "regular" and configuration.condition is None and len(numeric.task) == numeric.chain.n:
        yield _check_regular(numeric, configuration)


def _check_regular(numeric: NumericReference, configuration: ConfigurationsOfOneKind) -> Check:
    """Check that det J has the same sign for short and long lengths.

    The configuration is then regular for all of them.
    """
    signs = set()
    for _ in range(40):
        lengths = {name: value * 4 ** numeric.rng.uniform(-1, 1) for name, value in numeric.lengths[0].items()}
        arm, q = NumericChain(numeric.chain, lengths), _joint_values(numeric.chain, configuration, lengths)
        signs.add(float(np.sign(np.linalg.det(arm.jacobian(q)[numeric.task]))))
    return Check("regular for all lengths", len(signs) == 1, f"signs of det J: {sorted(signs)}")


def _configuration_samples(numeric: NumericReference, configuration: ConfigurationsOfOneKind) -> Sequence[Sample]:
    if configuration.condition is not None:
        return samples_on_condition(numeric, configuration.condition, arm_count=ARM_COUNT, per_arm=1)
    pairs = zip(numeric.arms, numeric.lengths, strict=True)
    return [Sample(arm, _joint_values(numeric.chain, configuration, lengths)) for arm, lengths in pairs]


def _joint_values(chain: Chain, configuration: ConfigurationsOfOneKind, lengths: dict[str, float]) -> np.ndarray:
    numbers = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
    return np.array([float(sp.N(configuration.joints[q].xreplace(numbers))) for q in chain.q])


CHECKS: dict[str, PartCheck] = {
    "singular-angles": _check_singular_set,
    "singularity-type": _check_kind,
}
