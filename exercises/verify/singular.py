"""Check singular sets, and the kind of a singularity.

A singular set is checked in both directions: J loses rank everywhere on the set, and the set contains every singular
configuration that a numerical search finds. The kind of a singularity is determined again for other lengths. The set
consists of pieces, such as theta2 = 0; the reference is the set in the problem's answer.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.singular import (
    KIND_OPTIONS,
    ConfigurationsOfOneKind,
    KindDetails,
    find_components_containing,
)
from qdot.exercises.reference_answers import Choice, ConditionSet
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import make_domain
from qdot.exercises.singularities.normalized_arm import normalize_arm
from qdot.exercises.singularities.singularity_kinds import RANK_TOLERANCE, classify_samples
from qdot.exercises.verify.formulas import PartCheck
from qdot.exercises.verify.numeric_model import (
    ARM_COUNT,
    Check,
    Checks,
    NumericModel,
    choose_random_configurations,
    choose_random_lengths,
    compute_conditioning_ratios,
)
from qdot.exercises.verify.singularity_statements import (
    check_component_statement,
    check_side_of_lost_direction,
    check_singularity_statements,
)

START_COUNT, REDUNDANT_START_COUNT = 30, 150
"""Number of searches on each arm, and on each redundant arm.

A redundant arm has singular components of lower dimension, which fewer of the searches reach."""

MAX_STEPS, MAX_SINGULAR_RATIO = 40, 1e-9
"""Maximum number of steps of a search, and maximum sigma_min/sigma_max at the end of a successful search."""

MAX_SHIFTED_RATIO = 1e-8
"""Maximum sigma_min/sigma_max of an arm at the configurations that a search found on its normalized arm. The limit is
larger, because the arm's joint offsets change the rounding."""

MIN_STEP = 1e-12
"""Size of a step below which a search stops."""

MAX_FURTHER_ARMS = 300
"""Number of choices of lengths to try if a piece of the set does not exist for the reference's lengths."""

SET_TOLERANCE, SEARCH_RADIUS = 1e-5, 0.003
"""Maximum distance (rad or m) of a singular configuration from the reference set, and the radius for further searches.

Near an intersection of components, sigma_min is a product of distances. It is then zero up to rounding even at some
distance from the set. If a configuration there is not in the set, further searches near it decide."""


def _check_singular_set(model: NumericModel, part: Part) -> Checks:
    """Check a singular set in both directions, and what the worked solution says about it."""
    joints, texts = [q.name for q in model.chain.q], part.answer_as(ConditionSet).list_pieces()
    pieces = [piece for text in texts for piece in parse_pieces(parse_formula(text, model.symbol_names), joints)]
    yield from _check_soundness(model, texts, pieces)
    yield _check_completeness(model, pieces)
    yield from check_singularity_statements(model)


def _make_space(model: NumericModel, lengths: dict[str, float]) -> ConfigurationSpace:
    """Return the configurations of the arm with the given lengths."""
    return ConfigurationSpace([q.name for q in model.chain.q], make_domain(model.chain, lengths))


def _check_soundness(model: NumericModel, texts: Sequence[str], pieces: Sequence[Piece]) -> Checks:
    """Check that every piece of the set contains configurations, and that the Jacobian loses rank there.

    A piece such as theta3 = acos(-a2/a3) exists only for some lengths. If it does not exist for the reference's
    lengths, the first of several arms on which it exists is used.
    """
    for text, piece in zip(texts, pieces, strict=True):
        ratios = [ratio for lengths in model.lengths for ratio in _compute_ratios_on_piece(model, piece, lengths)]
        for _ in range(0 if ratios else MAX_FURTHER_ARMS):
            ratios = _compute_ratios_on_piece(model, piece, choose_random_lengths(model.chain, model.rng))
            if ratios:
                break
        detail = f"{len(ratios)} configurations, sigma_min/sigma_max at most {max(ratios, default=0.0):.1e}"
        yield Check(f"rank at {text}", bool(ratios) and max(ratios) < RANK_TOLERANCE, detail)


def _compute_ratios_on_piece(model: NumericModel, piece: Piece, lengths: dict[str, float]) -> list[float]:
    """Return sigma_min/sigma_max of J at configurations on a piece, for an arm with the given lengths."""
    space = _make_space(model, lengths)
    values = space.sample_piece(piece, space.collect_names([[piece]]), model.rng, count=8)
    q = np.stack([values[q.name] for q in model.chain.q], axis=1)
    jacobians = NumericChain(model.chain, lengths).compute_jacobian(q)[:, model.task_rows]
    return [float(ratio) for ratio in compute_conditioning_ratios(jacobians)]


def _check_completeness(model: NumericModel, pieces: Sequence[Piece]) -> Check:
    """Check that the set contains the singular configurations that a search from random starts finds.

    The search runs on the normalized arm, once for all arms that share the normalized arm. Therefore its results are
    first checked to be singular for this arm, too.
    """
    chain, count = model.chain, 0
    for result in _search_on_arms(normalize_arm(chain)):
        lengths = choose_random_lengths(chain, model.rng) | dict(result.lengths)
        arm = NumericChain(chain, lengths)
        q = result.configurations - np.array(arm.joint_offsets)
        ratios = compute_conditioning_ratios(arm.compute_jacobian(q)[:, model.task_rows])
        if ratios.max(initial=0.0) > MAX_SHIFTED_RATIO:
            return Check("complete", False, "J has full rank at a singular configuration of the normalized arm")
        count += len(q)
        for configuration in _find_uncovered_configurations(model, pieces, lengths, q):
            starts = configuration + SEARCH_RADIUS * choose_random_configurations(chain, model.rng, START_COUNT)
            nearby_results = find_singular_configurations(arm, starts, model.task_rows)
            # The set is incomplete if at least half of the searches near the configuration end outside the set, too.
            if 2 * len(_find_uncovered_configurations(model, pieces, lengths, nearby_results)) >= len(nearby_results):
                pairs = [*zip(chain.q, configuration, strict=True), *lengths.items()]
                location = ", ".join(f"{name} = {value:.4g}" for name, value in pairs)
                return Check("complete", False, f"J loses rank at {location}, which no condition covers")
    return Check("complete", True, f"all of {count} singular configurations found by search are covered")


def _find_uncovered_configurations(
    model: NumericModel, pieces: Sequence[Piece], lengths: dict[str, float], q: np.ndarray
) -> np.ndarray:
    """Return the configurations (k x n) among `q` that no piece contains."""
    values = {symbol.name: column for symbol, column in zip(model.chain.q, q.T, strict=True)}
    values |= {name: np.full(len(q), length) for name, length in lengths.items()}
    return np.asarray(q[~_make_space(model, lengths).contains(pieces, values, len(q), SET_TOLERANCE)])


class _SearchResult(NamedTuple):
    """The symbolic lengths of a normalized arm, and the singular configurations (k x n) that a search found."""

    lengths: Mapping[str, float]
    configurations: np.ndarray


@lru_cache(maxsize=1024)
def _search_on_arms(chain: Chain) -> tuple[_SearchResult, ...]:
    """Return singular configurations of a normalized arm for several choices of its symbolic lengths."""
    stream = Stream("verify/singular")
    start_count = REDUNDANT_START_COUNT if chain.n > len(chain.task) else START_COUNT
    results = []
    for _ in range(ARM_COUNT):
        lengths = choose_random_lengths(chain, stream)
        starts = choose_random_configurations(chain, stream, start_count)
        q = find_singular_configurations(NumericChain(chain, lengths), starts, chain.task_rows)
        q.setflags(write=False)
        results.append(_SearchResult(lengths, q))
    return tuple(results)


def find_singular_configurations(arm: NumericChain, starts: np.ndarray, task_rows: Sequence[int]) -> np.ndarray:
    """Return singular configurations (k x n) of the task Jacobian J that Gauss-Newton steps reach from `starts`.

    The unknowns are q and a unit vector u with J^T u = 0 (J u = 0 if J has more rows than columns). With these
    equations, the steps converge quickly on components of any dimension. With equations in the minors of J, they would
    not, because minors may be products.
    """
    q, nudge = starts.copy(), 1e-6 * np.eye(starts.shape[1])
    count, n = q.shape

    def compute_matrix(q: np.ndarray) -> np.ndarray:
        jacobian = arm.compute_jacobian(q)[..., task_rows, :]
        return np.asarray(jacobian if len(task_rows) <= n else jacobian.swapaxes(-1, -2))

    u = np.linalg.svd(compute_matrix(q))[0][..., -1]
    for _ in range(MAX_STEPS):
        matrices = compute_matrix(np.concatenate([q[:, None], q[:, None] + nudge, q[:, None] - nudge], axis=1))
        products = np.einsum("pkmn,pm->pkn", matrices, u)
        derivatives = (products[:, 1 : n + 1] - products[:, n + 1 :]) / 2e-6
        unit_equation = np.concatenate([np.zeros((count, 1, n)), u[:, None]], axis=2)
        equations = np.concatenate([derivatives, matrices[:, 0]], axis=1).swapaxes(1, 2)
        system = np.concatenate([equations, unit_equation], axis=1)
        residuals = np.concatenate([products[:, 0], np.zeros((count, 1))], axis=1)
        step = np.einsum("pij,pj->pi", np.linalg.pinv(system, rcond=1e-8), residuals)
        # A step changes no unknown by more than 0.7, so that a search does not leave the region in which it starts.
        step *= np.minimum(1.0, 0.7 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        q, u = q - step[:, :n], u - step[:, n:]
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        if np.abs(step).max() < MIN_STEP:  # usually after 7 of the 40 steps: convergence is quadratic
            break
    return np.asarray(q[compute_conditioning_ratios(arm.compute_jacobian(q)[:, task_rows]) < MAX_SINGULAR_RATIO])


def _check_kind(model: NumericModel, part: Part) -> Checks:
    """Check the kind of a singularity by determining it again, for lengths that the question did not use."""
    answer, details = part.answer_as(Choice), part.details_as(KindDetails)
    kind, configurations, options = details.singularity_kind, details.configurations, answer.options
    is_correct_option = len(set(options)) == len(options) and options[answer.correct] == KIND_OPTIONS[kind]
    yield Check("option", is_correct_option, f"{answer.letters} is {options[answer.correct]}")
    samples = _sample_configurations(model, configurations)
    kinds = set(map(str, classify_samples(model.chain, samples)))
    detail = f"{', '.join(sorted(kinds))} at {len(samples)} configurations"
    yield Check("kind", bool(samples) and kinds == {kind}, detail)
    for component in find_components_containing(model.chain, configurations):
        yield check_component_statement(model.chain, component)
    if kind == "boundary":
        yield check_side_of_lost_direction(model.chain, configurations.condition, configurations.values, samples)
    if kind == "regular" and configurations.condition is None and len(model.task_rows) == model.chain.n:
        yield _check_regular(model, configurations)


def _check_regular(model: NumericModel, configurations: ConfigurationsOfOneKind) -> Check:
    """Check that det J has the same sign for short and long lengths, and so is zero for none of them."""
    signs = set()
    for _ in range(40):  # sets of lengths, each from a quarter to four times the reference's lengths
        lengths = {name: value * 4 ** model.rng.uniform(-1, 1) for name, value in model.lengths[0].items()}
        q = _compute_joint_values(model.chain, configurations, lengths)
        jacobian = NumericChain(model.chain, lengths).compute_jacobian(q)[model.task_rows]
        signs.add(float(np.sign(np.linalg.det(jacobian))))
    return Check("regular for all lengths", len(signs) == 1, f"signs of det J: {sorted(signs)}")


def _sample_configurations(model: NumericModel, configurations: ConfigurationsOfOneKind) -> Sequence[Sample]:
    if configurations.condition is not None:
        return model.sample_on_condition(configurations.condition, arm_count=ARM_COUNT, samples_per_arm=1)
    pairs = zip(model.arms, model.lengths, strict=True)
    return [Sample(arm, _compute_joint_values(model.chain, configurations, lengths)) for arm, lengths in pairs]


def _compute_joint_values(
    chain: Chain, configurations: ConfigurationsOfOneKind, lengths: dict[str, float]
) -> np.ndarray:
    numbers = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
    return np.array([float(sp.N(configurations.joints[q].xreplace(numbers))) for q in chain.q])


CHECKS: dict[str, PartCheck] = {"singular-angles": _check_singular_set, "singularity-type": _check_kind}
