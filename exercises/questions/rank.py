"""Questions on the rank, lost direction and meaning of a singular configuration (null space of J transposed; 6.8)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Direction, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.geometry import (
    Branch,
    ConfigurationDetails,
    ExactConfiguration,
    compute_full_rank,
    compute_lost_direction,
    convert_to_sample,
    evaluate_jacobian,
    find_singular_configuration,
    match_branches,
    sample_displayable_configuration,
    sample_regular_configuration,
    sample_singular_configuration,
    sample_singular_configurations,
)
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE
from qdot.exercises.questions.lost_lines import SAMPLE_COUNT, LostMotion, find_lost_motion, find_parallel_lines
from qdot.exercises.questions.singular import object_unless_direction_lost, object_unless_singular
from qdot.exercises.singularities.classification import representative_samples
from qdot.exercises.singularities.directions import ArmLine, LostDirectionFormula, clear_rank, lost_direction_formula
from qdot.exercises.singularities.meanings import BranchMeanings, Meaning, find_branch_meanings
from qdot.exercises.singularities.singularity import Component, singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples

MAX_ROWS = 4
"""Maximum number of rows of a Jacobian whose null space is found by hand."""

Sampler = Callable[[Chain, Stream], ExactConfiguration | None]

KIND_SAMPLE_COUNT = 60
"""Number of configurations at which the kind of a branch (boundary or internal) is determined."""


# --- rank ---


@lru_cache(maxsize=1024)
def _find_sets_with_larger_rank_loss(generic: Chain) -> tuple[tuple[int, ...], ...]:
    """Return the sets of components (by index) that together reduce the rank of a structure by more than one."""
    components = singular_set(generic) or ()

    def loses_more_than_one(indices: tuple[int, ...]) -> bool:
        chosen_components = [components[i] for i in indices]
        lost_counts = range(2, compute_full_rank(generic) + 1)
        return any(
            sample_singular_configuration(generic, chosen_components, Stream(f"deep/{indices}"), lost)
            for lost in lost_counts
        )

    index_sets = (chosen for size in (1, 2, 3) for chosen in combinations(range(len(components)), size))
    return tuple(filter(loses_more_than_one, index_sets))


_sample_formula_configuration = partial(sample_singular_configuration, needs_no_rounding=True, keeps_formulas=True)


def _sample_configuration_with_larger_rank_loss(chain: Chain, rng: Stream) -> ExactConfiguration | None:
    """Return a random configuration at which J loses more than one rank, or None if none is found."""
    generic, fill = structure(chain).chain, derive(chain).substitute_values
    generic_components = singular_set(generic) or ()
    arm_components = {component.conditions: component for component in singular_set(chain) or ()}
    for indices in rng.permutation(_find_sets_with_larger_rank_loss(generic)):
        matches = [arm_components.get(tuple(map(fill, generic_components[i].conditions))) for i in indices]
        components = [component for component in matches if component is not None]
        if len(components) == len(indices):
            configuration = _sample_formula_configuration(chain, components, rng)
            if (
                configuration is not None
                and (clear_rank(evaluate_jacobian(chain, configuration)) or 0) < compute_full_rank(chain) - 1
            ):
                return configuration
    return None


_sample_exact_regular_configuration = partial(sample_regular_configuration, needs_no_rounding=True)
_sample_configuration_with_rank_loss_one = partial(
    find_singular_configuration, lost_rank=1, sample=_sample_formula_configuration
)


@dataclass(frozen=True)
class RankFacts:
    """What a solution says about a rank: independent columns (from 1), and the conditions that are satisfied."""

    columns: tuple[int, ...]
    vanishing: tuple[tuple[sp.Expr, ...], ...]


@dataclass(frozen=True, kw_only=True)
class RankDetails(ConfigurationDetails):
    """Details of a question about the rank at a configuration, and what a solution says about it."""

    facts: RankFacts


def _ask_rank(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose how much rank is lost, if any, then sample an exact configuration. A rounded one would have full rank."""
    samplers: tuple[Sampler, ...] = (
        _sample_exact_regular_configuration,
        _sample_configuration_with_rank_loss_one,
        _sample_configuration_with_larger_rank_loss,
    )
    for sample in rng.permutation(samplers):
        configuration = sample(chain, rng)
        if configuration is not None:
            jacobian = evaluate_jacobian(chain, configuration)
            rank = clear_rank(jacobian)
            facts = RankFacts(_find_independent_columns(jacobian), _find_vanishing_conditions(chain, configuration))
            answer = Number(sp.Matrix([[rank]]), ("",), 1e-9, 1e-9)
            return answer, RankDetails(place=configuration, facts=facts, pose=configuration.figure_values)
    return None


def _find_independent_columns(jacobian: np.ndarray) -> tuple[int, ...]:
    """Return the numbers (from 1) of the first independent columns that span all columns."""
    independent_columns: list[int] = []
    for column in range(jacobian.shape[1]):
        sigma = np.linalg.svd(jacobian[:, [*independent_columns, column]], compute_uv=False)
        if len(sigma) == len(independent_columns) + 1 and sigma[-1] > 1e-7 * np.linalg.norm(jacobian):
            independent_columns.append(column)
    return tuple(column + 1 for column in independent_columns)


def _find_vanishing_conditions(chain: Chain, configuration: ExactConfiguration) -> tuple[tuple[sp.Expr, ...], ...]:
    """Return the conditions of the components that contain a configuration."""
    components = singular_set(chain) or ()
    return tuple(
        component.conditions
        for component in components
        if all(
            abs(sp.N(condition.xreplace(configuration.values), 30)) < sp.Float("1e-20")
            for condition in component.conditions
        )
    )


# --- lost direction, as a vector ---


def _object_to_vector(chain: Chain) -> str | None:
    objection = object_unless_direction_lost(chain)
    if objection is None and len(chain.task) > MAX_ROWS:
        return f"its Jacobian has {len(chain.task)} rows, too many for a null space by hand"
    if objection is None and not _find_branches_with_vector(chain):
        return "it has no singular configuration that loses exactly one direction"
    return objection


def _find_branches_with_vector(chain: Chain) -> list[Branch]:
    """Return the branches that lose exactly one direction. If some have a formula for it, return only those."""
    generic = structure(chain).chain
    single_loss_branches = [branch for branch in match_branches(chain) if loses_one_direction(generic, branch.generic)]
    return [
        branch for branch in single_loss_branches if lost_direction_formula(generic, branch.generic)
    ] or single_loss_branches


@lru_cache(maxsize=1024)
def loses_one_direction(generic: Chain, component: Component) -> bool:
    """Return whether a sampled configuration of a structure on a component loses exactly one direction."""
    return sample_singular_configuration(generic, (component,), Stream("one"), 1) is not None


@dataclass(frozen=True)
class LostDirectionAt:
    """A branch with a formula for the lost direction: its joint values, free joints, J, and the columns used."""

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    free: tuple[sp.Symbol, ...]
    jacobian: sp.Matrix | None
    columns: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class LostDirectionDetails(Details):
    """Details about a direction that is lost at given joint values, for any values of the other joints."""

    lost: LostDirectionAt

    @property
    def given_joints(self) -> dict[sp.Symbol, sp.Expr]:
        """The joint values at which the direction is lost."""
        return dict(self.lost.values)


def _ask_direction(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Ask for the direction: as a formula if the branch has a short one, else as numbers at a configuration."""
    for branch in rng.permutation(_find_branches_with_vector(chain)):
        formula = lost_direction_formula(structure(chain).chain, branch.generic)
        if formula is not None:
            direction = formula.direction.applyfunc(derive(chain).substitute_values)
            if all(entry == 0 or entry.could_extract_minus_sign() for entry in direction):
                direction = -direction
            return Direction(direction), LostDirectionDetails(lost=_describe_loss(chain, branch.component, formula))
        configuration = sample_displayable_configuration(chain, (branch.component,), rng, 1)
        if configuration is not None:
            numbers = compute_lost_direction(chain, configuration).applyfunc(
                lambda value: sp.Float(value, 10) if value else sp.S.Zero
            )
            return Direction(numbers, THREE_DIGIT_TOLERANCE), ConfigurationDetails(
                place=configuration, pose=configuration.figure_values
            )
    return None


def _describe_loss(chain: Chain, component: Component, formula: LostDirectionFormula) -> LostDirectionAt:
    (values,) = component.value_combinations()
    jacobian = None if formula.jacobian is None else formula.jacobian.applyfunc(derive(chain).substitute_values)
    return LostDirectionAt(values, tuple(q for q in chain.q if q not in dict(values)), jacobian, formula.columns)


# --- lost direction, in words ---


@dataclass(frozen=True)
class BranchConfigurations:
    """The configurations of a branch: given joint values, or a description in words with the condition behind it."""

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    words: str = ""
    condition: sp.Expr | None = None


def _describe_branch(chain: Chain, branch: Branch) -> BranchConfigurations | None:
    if branch.component.solutions is not None:
        return BranchConfigurations(branch.component.value_combinations()[0])
    reading = describe_branch_in_words(structure(chain).chain, branch.generic)
    if reading is None or len(branch.component.conditions) > 1 or reading.correct.kind != "on axis":
        return None
    return BranchConfigurations((), reading.correct.words, branch.component.conditions[0])


def _find_lost_motions(chain: Chain) -> list[tuple[BranchConfigurations, Branch, LostMotion]]:
    generic = structure(chain).chain
    return [
        (where, branch, motion)
        for branch in match_branches(chain)
        if (where := _describe_branch(chain, branch)) is not None
        and (motion := find_lost_motion(generic, branch.generic)) is not None
    ]


def _object_to_motion(chain: Chain) -> str | None:
    objection = object_unless_direction_lost(chain)
    if objection is None and not _find_lost_motions(chain):
        return "no line of the arm has a lost direction"
    return objection


@dataclass(frozen=True)
class LostMotionQuestion:
    """The question: where, what moves, whether the other motion is held at zero, and the lines in option order."""

    where: BranchConfigurations
    moving: str
    held: bool
    lines: tuple[ArmLine, ...]


@dataclass(frozen=True, kw_only=True)
class LostMotionDetails(Details):
    """Details of a question about a lost motion."""

    asked: LostMotionQuestion


def _ask_motion(chain: Chain, rng: Stream) -> AnswerAndDetails:
    where, branch, motion = rng.choice(_find_lost_motions(chain))
    parallel = find_parallel_lines(structure(chain).chain, branch.generic)
    chosen_lines = [rng.choice(motion.correct_lines)]
    for line in rng.permutation(motion.wrong_lines):
        if len(chosen_lines) < 4 and not any(parallel[line, chosen_line] for chosen_line in chosen_lines):
            chosen_lines.append(line)
    answer, shuffled = shuffle_options(chosen_lines, chosen_lines[0], rng, lambda line: line.description)
    return answer, LostMotionDetails(
        asked=LostMotionQuestion(where, motion.moving_part, motion.holds_other_motion, tuple(shuffled))
    )


def find_lost_direction_formula(
    chain: Chain, configurations: BranchConfigurations
) -> tuple[LostDirectionAt, sp.Matrix] | None:
    """Return J and the lost direction at given joint values as formulas, or None if they are too long."""
    for branch in match_branches(chain) if configurations.values else ():
        if branch.component.solutions is not None and branch.component.value_combinations()[0] == configurations.values:
            formula = lost_direction_formula(structure(chain).chain, branch.generic)
            if formula is not None and formula.jacobian is not None:
                return _describe_loss(chain, branch.component, formula), formula.direction.applyfunc(
                    derive(chain).substitute_values
                )
    return None


# --- geometric meaning of a singularity ---


@lru_cache(maxsize=1024)
def describe_branch_in_words(generic: Chain, component: Component) -> BranchMeanings | None:
    """Return a description that fits all configurations of a structure's branch, or None if there is none."""
    additional_samples = representative_samples(generic, component.pieces())
    meanings = find_branch_meanings(
        generic, sample_singular_configurations(generic, component, SAMPLE_COUNT), additional_samples
    )
    if meanings is None or (len(meanings.wrong) < 2 and find_common_kind(generic, component) is None):
        return None
    return meanings


@lru_cache(maxsize=1024)
def find_common_kind(generic: Chain, component: Component) -> str | None:
    """Return the kind of a structure's branch, "boundary" or "internal", or None if it differs within the branch."""
    if not can_establish_kind(generic):
        return None
    kinds = set(classify_samples(generic, sample_singular_configurations(generic, component, KIND_SAMPLE_COUNT)))
    return kinds.pop() if len(kinds) == 1 else None


def _describe_branches_in_words(chain: Chain, order: Sequence[Branch]) -> Iterator[tuple[Branch, BranchMeanings]]:
    """Yield the branches that have a description in words, in the given order, with that description."""
    generic = structure(chain).chain
    for branch in order:
        reading = describe_branch_in_words(generic, branch.generic)
        if reading is not None:
            yield branch, reading


def _object_to_meaning(chain: Chain) -> str | None:
    objection = object_unless_singular(chain)
    if objection is None and next(_describe_branches_in_words(chain, match_branches(chain)), None) is None:
        return "its singular configurations have no common feature that you can see in a drawing"
    return objection


@dataclass(frozen=True)
class MeaningQuestion:
    """The question: joint values, or one configuration that satisfies a condition, and the options.

    `offered` has the meaning and the kind of each option. The kind is None if it differs within the branch.
    """

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    place: ExactConfiguration | None
    condition: sp.Expr | None
    offered: tuple[tuple[Meaning, str | None], ...]


@dataclass(frozen=True, kw_only=True)
class MeaningDetails(Details):
    """Details of a question about the geometric meaning of a singularity: what all of its configurations look like."""

    asked: MeaningQuestion


def _ask_meaning(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer the correct meaning and kind, the same meaning with the other kind, and meanings that do not hold."""
    for branch, reading in _describe_branches_in_words(chain, rng.permutation(match_branches(chain))):
        configuration = sample_displayable_configuration(chain, (branch.component,), rng, 1)
        if configuration is None:
            continue
        kind = _find_kind_of_arm(chain, branch, configuration)
        kinds = ("boundary", "internal")
        offered = [(reading.correct, kind)]
        if kind is not None:
            offered.append((reading.correct, kinds[kind == "boundary"]))
        wrong_meanings = rng.permutation(reading.wrong)[: 4 - len(offered)]
        offered += [(wrong_meaning, None if kind is None else rng.choice(kinds)) for wrong_meaning in wrong_meanings]
        answer, shuffled = shuffle_options(offered, offered[0], rng, _describe_meaning)
        has_condition = branch.component.solutions is None
        values = () if has_condition else branch.component.value_combinations()[0]
        condition = branch.component.conditions[0] if has_condition else None
        meaning_asked = MeaningQuestion(values, configuration if has_condition else None, condition, tuple(shuffled))
        return answer, MeaningDetails(asked=meaning_asked)
    return None


def _find_kind_of_arm(chain: Chain, branch: Branch, configuration: ExactConfiguration) -> str | None:
    """Return the kind of a branch of the structure, or None if the arm with its own numbers has another kind."""
    kind = find_common_kind(structure(chain).chain, branch.generic)
    return kind if kind and classify_samples(chain, [convert_to_sample(chain, configuration)]) == [kind] else None


def _describe_meaning(option: tuple[Meaning, str | None]) -> str:
    meaning, kind = option
    return meaning.words if kind is None else f"{meaning.words}; {KIND_WORDS[kind]}"


KIND_WORDS = {"boundary": "a boundary singularity", "internal": "an internal singularity"}


# A rank or lost direction can't be derived from a wrong Jacobian: it mostly has full rank at singular configurations.
QUESTIONS = (
    Question(
        "singularity-meaning", "Meaning of a singularity", "below 6.7",
        sample=_ask_meaning, objection=_object_to_meaning,
    ),
    Question(
        "rank", "Rank of the Jacobian", "6.8", needs=("jacobian",), sample=_ask_rank,
        entry_names=lambda chain, _: [r"\text{rank}"], objection=object_unless_singular, source_questions=(),
    ),
    Question(
        "lost-direction", "Lost direction of motion", "6.8", needs=("jacobian",),
        stage="lost direction", sample=_ask_direction, objection=_object_to_vector, is_made_of_jacobian=True,
        entry_names=lambda chain, _: [f"u_{{{row}}}" for row in range(1, len(chain.task) + 1)],
        source_questions=(),
    ),
    Question("lost-motion", "Motion that is lost", "6.8", sample=_ask_motion, objection=_object_to_motion),
)  # fmt: skip
