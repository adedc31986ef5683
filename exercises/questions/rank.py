"""Questions on the rank, lost direction and meaning of a singular configuration (null space of J transposed; 6.8)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Direction, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions import geometry
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.geometry import Branch, ConfigurationDetails, ExactConfiguration, Sampler
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE
from qdot.exercises.questions.lost_lines import SAMPLE_COUNT, LostMotion, find_lost_motion, find_parallel_lines
from qdot.exercises.questions.singular import object_unless_direction_lost, object_unless_singular
from qdot.exercises.singularities.classification import sample_representatives
from qdot.exercises.singularities.directions import ArmLine, LostDirectionFormula, clear_rank, lost_direction_formula
from qdot.exercises.singularities.meanings import BranchMeanings, Meaning, find_branch_meanings
from qdot.exercises.singularities.singularity import Component, singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples

MAX_ROWS = 4
"""Maximum number of rows of a Jacobian whose null space is found by hand."""

KIND_SAMPLE_COUNT = 60
"""Number of configurations at which the kind of a branch (boundary or internal) is determined."""


# --- rank ---


@lru_cache(maxsize=1024)
def _find_sets_with_larger_rank_loss(generic: Chain) -> tuple[tuple[int, ...], ...]:
    """Return the sets of components (by index) that together reduce the rank of a structure by more than one."""
    components = singular_set(generic) or ()

    def loses_more_than_one(indices: tuple[int, ...]) -> bool:
        chosen, lost_ranks = [components[i] for i in indices], range(2, geometry.compute_full_rank(generic) + 1)
        seed = f"deep/{indices}"
        return any(geometry.sample_singular_configuration(generic, chosen, Stream(seed), lost) for lost in lost_ranks)

    index_sets = (chosen for size in (1, 2, 3) for chosen in combinations(range(len(components)), size))
    return tuple(filter(loses_more_than_one, index_sets))


_sample_with_formulas = partial(geometry.sample_singular_configuration, needs_no_rounding=True, keeps_formulas=True)


def _sample_with_larger_rank_loss(chain: Chain, rng: Stream) -> ExactConfiguration | None:
    """Return a random configuration at which J loses more than one rank, or None if none is found."""
    generic, fill = symbolic_arm_of(chain).chain, derive(chain).substitute_values
    generic_components, max_rank = singular_set(generic) or (), geometry.compute_full_rank(chain) - 2
    arm_components = {component.conditions: component for component in singular_set(chain) or ()}
    for indices in rng.permutation(_find_sets_with_larger_rank_loss(generic)):
        matches = [arm_components.get(tuple(map(fill, generic_components[i].conditions))) for i in indices]
        components = [component for component in matches if component is not None]
        if len(components) == len(indices):
            configuration = _sample_with_formulas(chain, components, rng)
            if configuration is not None and (geometry.compute_rank(chain, configuration) or 0) <= max_rank:
                return configuration
    return None


_sample_regular = partial(geometry.sample_regular_configuration, needs_no_rounding=True)
_sample_with_single_rank_loss = partial(geometry.find_singular_configuration, lost_rank=1, sample=_sample_with_formulas)


@dataclass(frozen=True)
class RankFacts:
    """What a solution says about a rank: which columns (from 1) are independent, and which conditions are satisfied."""

    columns: tuple[int, ...]
    vanishing: tuple[tuple[sp.Expr, ...], ...]


@dataclass(frozen=True, kw_only=True)
class RankDetails(ConfigurationDetails):
    """Details of a question about the rank at a configuration, and what a solution says about it."""

    facts: RankFacts


def _ask_rank(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose how much rank is lost, if any, then sample an exact configuration. A rounded one would have full rank."""
    samplers: tuple[Sampler, ...] = (_sample_regular, _sample_with_single_rank_loss, _sample_with_larger_rank_loss)
    for sample in rng.permutation(samplers):
        configuration = sample(chain, rng)
        if configuration is not None:
            jacobian = geometry.evaluate_jacobian(chain, configuration)
            facts = RankFacts(_find_independent_columns(jacobian), _find_vanishing_conditions(chain, configuration))
            answer = Number(sp.Matrix([[clear_rank(jacobian)]]), ("",), 1e-9, 1e-9)
            return answer, RankDetails(place=configuration, facts=facts)
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

    def holds(condition: sp.Expr) -> bool:
        return bool(abs(sp.N(condition.xreplace(configuration.values), 30)) < sp.Float("1e-20"))

    all_conditions = (component.conditions for component in singular_set(chain) or ())
    return tuple(conditions for conditions in all_conditions if all(map(holds, conditions)))


# --- lost direction, as a vector ---


def _object_to_vector(chain: Chain) -> str | None:
    if objection := object_unless_direction_lost(chain):
        return objection
    if len(chain.task) > MAX_ROWS:
        return f"its Jacobian has {len(chain.task)} rows, too many for a null space by hand"
    has_branch = bool(_find_branches_with_vector(chain))
    return None if has_branch else "it has no singular configuration that loses exactly one direction"


def _find_branches_with_vector(chain: Chain) -> list[Branch]:
    """Return the branches that lose exactly one direction, and of these only those with a formula for it, if any."""
    generic = symbolic_arm_of(chain).chain
    branches = [branch for branch in geometry.match_branches(chain) if loses_one_direction(generic, branch.generic)]
    return [branch for branch in branches if lost_direction_formula(generic, branch.generic)] or branches


@lru_cache(maxsize=1024)
def loses_one_direction(generic: Chain, component: Component) -> bool:
    """Return whether a sampled configuration of a structure on a component loses exactly one direction."""
    return geometry.sample_singular_configuration(generic, (component,), Stream("one"), 1) is not None


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
        formula = lost_direction_formula(symbolic_arm_of(chain).chain, branch.generic)
        if formula is not None:
            direction = formula.direction.applyfunc(derive(chain).substitute_values)
            if all(entry == 0 or entry.could_extract_minus_sign() for entry in direction):
                direction = -direction
            return Direction(direction), LostDirectionDetails(lost=_describe_loss(chain, branch.component, formula))
        configuration = geometry.sample_displayable_configuration(chain, (branch.component,), rng, 1)
        if configuration is not None:
            direction = geometry.compute_lost_direction(chain, configuration)
            numbers = direction.applyfunc(lambda value: sp.Float(value, 10) if value else sp.S.Zero)
            return Direction(numbers, THREE_DIGIT_TOLERANCE), ConfigurationDetails(place=configuration)
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
    meanings = describe_branch_in_words(symbolic_arm_of(chain).chain, branch.generic)
    if meanings is None or len(branch.component.conditions) > 1 or meanings.correct.kind != "on axis":
        return None
    return BranchConfigurations((), meanings.correct.words, branch.component.conditions[0])


def _find_lost_motions(chain: Chain) -> list[tuple[BranchConfigurations, Branch, LostMotion]]:
    generic = symbolic_arm_of(chain).chain
    return [
        (where, branch, motion)
        for branch in geometry.match_branches(chain)
        if (where := _describe_branch(chain, branch)) is not None
        and (motion := find_lost_motion(generic, branch.generic)) is not None
    ]


def _object_to_motion(chain: Chain) -> str | None:
    if objection := object_unless_direction_lost(chain):
        return objection
    return None if _find_lost_motions(chain) else "no line of the arm has a lost direction"


@dataclass(frozen=True)
class LostMotionQuestion:
    """What a question states: where and what moves, whether the other motion is held at zero, and the lines offered."""

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
    parallel = find_parallel_lines(symbolic_arm_of(chain).chain, branch.generic)
    chosen_lines = [rng.choice(motion.correct_lines)]
    for line in rng.permutation(motion.wrong_lines):
        if len(chosen_lines) < 4 and not any(parallel[line, chosen_line] for chosen_line in chosen_lines):
            chosen_lines.append(line)
    answer, shuffled = shuffle_options(chosen_lines, chosen_lines[0], rng, lambda line: line.description)
    question = LostMotionQuestion(where, motion.moving_part, motion.holds_other_motion, tuple(shuffled))
    return answer, LostMotionDetails(asked=question)


def find_lost_direction_formula(
    chain: Chain, configurations: BranchConfigurations
) -> tuple[LostDirectionAt, sp.Matrix] | None:
    """Return J and the lost direction at given joint values as formulas, or None if they are too long."""
    for branch in geometry.match_branches(chain) if configurations.values else ():
        if branch.component.solutions is not None and branch.component.value_combinations()[0] == configurations.values:
            formula = lost_direction_formula(symbolic_arm_of(chain).chain, branch.generic)
            if formula is not None and formula.jacobian is not None:
                direction = formula.direction.applyfunc(derive(chain).substitute_values)
                return _describe_loss(chain, branch.component, formula), direction
    return None


# --- geometric meaning of a singularity ---


@lru_cache(maxsize=1024)
def describe_branch_in_words(generic: Chain, component: Component) -> BranchMeanings | None:
    """Return a description that fits all configurations of a structure's branch, or None if there is none."""
    samples = geometry.sample_singular_configurations(generic, component, SAMPLE_COUNT)
    meanings = find_branch_meanings(generic, samples, sample_representatives(generic, component.pieces()))
    if meanings is None or (len(meanings.wrong) < 2 and find_common_kind(generic, component) is None):
        return None
    return meanings


@lru_cache(maxsize=1024)
def find_common_kind(generic: Chain, component: Component) -> str | None:
    """Return the kind of a structure's branch, "boundary" or "internal", or None if it differs within the branch."""
    if not can_establish_kind(generic):
        return None
    samples = geometry.sample_singular_configurations(generic, component, KIND_SAMPLE_COUNT)
    kinds = set(classify_samples(generic, samples))
    return kinds.pop() if len(kinds) == 1 else None


def _describe_branches_in_words(chain: Chain, order: Sequence[Branch]) -> Iterator[tuple[Branch, BranchMeanings]]:
    """Yield the branches that have a description in words, in the given order, with that description."""
    for branch in order:
        meanings = describe_branch_in_words(symbolic_arm_of(chain).chain, branch.generic)
        if meanings is not None:
            yield branch, meanings


def _object_to_meaning(chain: Chain) -> str | None:
    if objection := object_unless_singular(chain):
        return objection
    is_described = any(True for _ in _describe_branches_in_words(chain, geometry.match_branches(chain)))
    return None if is_described else "its singular configurations have no common feature that you can see in a drawing"


@dataclass(frozen=True)
class MeaningQuestion:
    """What a question states: joint values, or one configuration that satisfies a condition, and the options.

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
    for branch, meanings in _describe_branches_in_words(chain, rng.permutation(geometry.match_branches(chain))):
        configuration = geometry.sample_displayable_configuration(chain, (branch.component,), rng, 1)
        if configuration is None:
            continue
        kind = _find_kind_of_arm(chain, branch, configuration)
        kinds = ("boundary", "internal")
        offered = [(meanings.correct, kind)]
        if kind is not None:
            offered.append((meanings.correct, kinds[kind == "boundary"]))
        wrong_meanings = rng.permutation(meanings.wrong)[: 4 - len(offered)]
        offered += [(wrong_meaning, None if kind is None else rng.choice(kinds)) for wrong_meaning in wrong_meanings]
        answer, shuffled = shuffle_options(offered, offered[0], rng, _describe_meaning)
        if branch.component.solutions is None:
            question = MeaningQuestion((), configuration, branch.component.conditions[0], tuple(shuffled))
        else:
            question = MeaningQuestion(branch.component.value_combinations()[0], None, None, tuple(shuffled))
        return answer, MeaningDetails(asked=question)
    return None


def _find_kind_of_arm(chain: Chain, branch: Branch, configuration: ExactConfiguration) -> str | None:
    """Return the kind of a branch of the structure, or None if the arm with its own numbers has another kind."""
    kind = find_common_kind(symbolic_arm_of(chain).chain, branch.generic)
    kinds_of_arm = classify_samples(chain, [geometry.convert_to_sample(chain, configuration)]) if kind else []
    return kind if kinds_of_arm == [kind] else None


def _describe_meaning(option: tuple[Meaning, str | None]) -> str:
    meaning, kind = option
    return meaning.words if kind is None else f"{meaning.words}; {KIND_WORDS[kind]}"


KIND_WORDS = {"boundary": "a boundary singularity", "internal": "an internal singularity"}


# A rank or lost direction can't be derived from a wrong Jacobian: that mostly has full rank at singular configurations.
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
        "lost-direction", "Lost direction of motion", "6.8", needs=("jacobian",), stage="lost direction",
        sample=_ask_direction, objection=_object_to_vector, is_made_of_jacobian=True,
        entry_names=lambda chain, _: [f"u_{{{row}}}" for row in range(1, len(chain.task) + 1)], source_questions=(),
    ),
    Question("lost-motion", "Lost motion", "6.8", sample=_ask_motion, objection=_object_to_motion),
)  # fmt: skip
