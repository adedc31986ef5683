"""Questions on the rank, lost direction and meaning of a singular configuration (null space of J transposed; 6.8)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.answers import Direction, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import representative_samples
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.directions import Line, LostFormula, clear_rank, lost_formula
from qdot.exercises.arm.meanings import Meaning, Reading, common_kind, read_meanings
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.arm.singularity_kinds import kind_at, kind_is_sure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import Asked, Question, shuffle_options
from qdot.exercises.questions.geometry import (
    AtPose,
    Branch,
    Pose,
    branches,
    find_singular_pose,
    full_rank,
    jacobian_at,
    precise_lost_direction,
    sample_regular_pose,
    sample_shown_pose,
    sample_singular_pose,
    sample_singular_poses,
    to_sample,
)
from qdot.exercises.questions.inversion import THREE_DIGITS
from qdot.exercises.questions.lost_lines import SAMPLES, Motion, find_lost_motion, find_parallel_lines
from qdot.exercises.questions.singular import objection_unless_direction_lost, objection_unless_singular

MOST_ROWS = 4
"""Maximum number of rows of a Jacobian whose null space is found by hand."""

Sampler = Callable[[Chain, Stream], Pose | None]

KINDS = 60
"""Number of configurations at which the kind of a branch (boundary or internal) is determined."""


# --- rank ---


@lru_cache(maxsize=1024)
def _find_deep_sets(generic: Chain) -> tuple[tuple[int, ...], ...]:
    """Return the sets of components (by index) that together reduce the rank of a structure by more than one."""
    components = singular_set(generic) or ()

    def loses_more_than_one(chosen: tuple[int, ...]) -> bool:
        chosen_components = [components[i] for i in chosen]
        lost_counts = range(2, full_rank(generic) + 1)
        return any(
            sample_singular_pose(generic, chosen_components, Stream(f"deep/{chosen}"), lost) for lost in lost_counts
        )

    index_sets = (chosen for size in (1, 2, 3) for chosen in combinations(range(len(components)), size))
    return tuple(filter(loses_more_than_one, index_sets))


_sample_formula_pose = partial(sample_singular_pose, exact=True, symbolic=True)


def _sample_deep_pose(chain: Chain, rng: Stream) -> Pose | None:
    """Return a random configuration at which J loses more than one rank, or None if none is found."""
    generic, fill = structure(chain).chain, derive(chain).fill
    generic_components = singular_set(generic) or ()
    arm_components = {component.conditions: component for component in singular_set(chain) or ()}
    for indices in rng.permutation(_find_deep_sets(generic)):
        matches = [arm_components.get(tuple(map(fill, generic_components[i].conditions))) for i in indices]
        components = [component for component in matches if component is not None]
        if len(components) == len(indices):
            configuration = _sample_formula_pose(chain, components, rng)
            if (
                configuration is not None
                and (clear_rank(jacobian_at(chain, configuration)) or 0) < full_rank(chain) - 1
            ):
                return configuration
    return None


_sample_regular_pose = partial(sample_regular_pose, exact=True)
_sample_single_pose = partial(find_singular_pose, lost=1, sample=_sample_formula_pose)


@dataclass(frozen=True)
class RankFacts:
    """What a solution says about a rank: independent columns (from 1), and the conditions that are satisfied."""

    columns: tuple[int, ...]
    vanishing: tuple[tuple[sp.Expr, ...], ...]


@dataclass(frozen=True, kw_only=True)
class OfRank(AtPose):
    """Details of a question about the rank at a configuration, and what a solution says about it."""

    facts: RankFacts


def _ask_rank(chain: Chain, rng: Stream) -> Asked | None:
    """Choose how much rank is lost, if any, then sample an exact configuration. A rounded one would have full rank."""
    samplers: tuple[Sampler, ...] = (_sample_regular_pose, _sample_single_pose, _sample_deep_pose)
    for sample in rng.permutation(samplers):
        configuration = sample(chain, rng)
        if configuration is not None:
            jacobian = jacobian_at(chain, configuration)
            rank = clear_rank(jacobian)
            facts = RankFacts(_find_independent_columns(jacobian), _find_vanishing_conditions(chain, configuration))
            answer = Number(sp.Matrix([[rank]]), ("",), 1e-9, 1e-9)
            return answer, OfRank(place=configuration, facts=facts, pose=configuration.figure)
    return None


def _find_independent_columns(jacobian: np.ndarray) -> tuple[int, ...]:
    """Return the numbers (from 1) of the first independent columns that span all columns."""
    independent_columns: list[int] = []
    for column in range(jacobian.shape[1]):
        sigma = np.linalg.svd(jacobian[:, [*independent_columns, column]], compute_uv=False)
        if len(sigma) == len(independent_columns) + 1 and sigma[-1] > 1e-7 * np.linalg.norm(jacobian):
            independent_columns.append(column)
    return tuple(column + 1 for column in independent_columns)


def _find_vanishing_conditions(chain: Chain, pose: Pose) -> tuple[tuple[sp.Expr, ...], ...]:
    """Return the conditions of the components that contain a configuration."""
    components = singular_set(chain) or ()
    return tuple(
        component.conditions
        for component in components
        if all(abs(sp.N(condition.xreplace(pose.values), 30)) < sp.Float("1e-20") for condition in component.conditions)
    )


# --- lost direction, as a vector ---


def _object_to_vector(chain: Chain) -> str | None:
    objection = objection_unless_direction_lost(chain)
    if objection is None and len(chain.task) > MOST_ROWS:
        return f"its Jacobian has {len(chain.task)} rows, too many to find a null space by hand"
    if objection is None and not _find_branches_with_vector(chain):
        return "no singular configuration loses exactly one direction"
    return objection


def _find_branches_with_vector(chain: Chain) -> list[Branch]:
    """Return the branches that lose exactly one direction. If some have a formula for it, return only those."""
    generic = structure(chain).chain
    single_loss_branches = [branch for branch in branches(chain) if loses_one_direction(generic, branch.generic)]
    return [branch for branch in single_loss_branches if lost_formula(generic, branch.generic)] or single_loss_branches


@lru_cache(maxsize=1024)
def loses_one_direction(generic: Chain, component: Component) -> bool:
    """Return whether a sampled configuration of a structure on a component loses exactly one direction."""
    return sample_singular_pose(generic, (component,), Stream("one"), 1) is not None


@dataclass(frozen=True)
class LostAt:
    """A branch with a formula for the lost direction: its joint values, free joints, J, and the columns used."""

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    free: tuple[sp.Symbol, ...]
    jacobian: sp.Matrix | None
    columns: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class LostInFormulas(Details):
    """Details about a direction that is lost at given joint values, for any values of the other joints."""

    lost: LostAt

    @property
    def given_joints(self) -> dict[sp.Symbol, sp.Expr]:
        """The joint values at which the direction is lost."""
        return dict(self.lost.values)


def _ask_direction(chain: Chain, rng: Stream) -> Asked | None:
    """Ask for the direction: as a formula if the branch has a short one, else as numbers at a configuration."""
    for branch in rng.permutation(_find_branches_with_vector(chain)):
        formula = lost_formula(structure(chain).chain, branch.generic)
        if formula is not None:
            direction = formula.direction.applyfunc(derive(chain).fill)
            if all(entry == 0 or entry.could_extract_minus_sign() for entry in direction):
                direction = -direction
            return Direction(direction), LostInFormulas(lost=_describe_loss(chain, branch.component, formula))
        configuration = sample_shown_pose(chain, (branch.component,), rng, 1)
        if configuration is not None:
            numbers = precise_lost_direction(chain, configuration).applyfunc(
                lambda value: sp.Float(value, 10) if value else sp.S.Zero
            )
            return Direction(numbers, THREE_DIGITS), AtPose(place=configuration, pose=configuration.figure)
    return None


def _describe_loss(chain: Chain, component: Component, formula: LostFormula) -> LostAt:
    (values,) = component.value_combinations()
    jacobian = None if formula.jacobian is None else formula.jacobian.applyfunc(derive(chain).fill)
    return LostAt(values, tuple(q for q in chain.q if q not in dict(values)), jacobian, formula.columns)


# --- lost direction, in words ---


@dataclass(frozen=True)
class Where:
    """The configurations of a branch: given joint values, or a description in words with the condition behind it."""

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    words: str = ""
    condition: sp.Expr | None = None


def _describe_where(chain: Chain, branch: Branch) -> Where | None:
    if branch.component.solutions is not None:
        return Where(branch.component.value_combinations()[0])
    reading = read_branch(structure(chain).chain, branch.generic)
    if reading is None or len(branch.component.conditions) > 1 or reading.right.kind != "on axis":
        return None
    return Where((), reading.right.words, branch.component.conditions[0])


def _find_lost_motions(chain: Chain) -> list[tuple[Where, Branch, Motion]]:
    generic = structure(chain).chain
    return [
        (where, branch, motion)
        for branch in branches(chain)
        if (where := _describe_where(chain, branch)) is not None
        and (motion := find_lost_motion(generic, branch.generic)) is not None
    ]


def _object_to_motion(chain: Chain) -> str | None:
    objection = objection_unless_direction_lost(chain)
    if objection is None and not _find_lost_motions(chain):
        return "no line of the arm tells a direction that is lost"
    return objection


@dataclass(frozen=True)
class MotionAsked:
    """The question: where, what moves, whether the other motion is held at zero, and the lines in option order."""

    where: Where
    moving: str
    held: bool
    lines: tuple[Line, ...]


@dataclass(frozen=True, kw_only=True)
class OfMotion(Details):
    """Details of a question about a lost motion."""

    asked: MotionAsked


def _ask_motion(chain: Chain, rng: Stream) -> Asked:
    where, branch, motion = rng.choice(_find_lost_motions(chain))
    parallel = find_parallel_lines(structure(chain).chain, branch.generic)
    chosen_lines = [rng.choice(motion.right)]
    for line in rng.permutation(motion.wrong):
        if len(chosen_lines) < 4 and not any(parallel[line, chosen_line] for chosen_line in chosen_lines):
            chosen_lines.append(line)
    answer, shuffled = shuffle_options(chosen_lines, chosen_lines[0], rng, lambda line: line.words)
    return answer, OfMotion(asked=MotionAsked(where, motion.moving, motion.held, tuple(shuffled)))


def lost_direction_where(chain: Chain, where: Where) -> tuple[LostAt, sp.Matrix] | None:
    """Return J and the lost direction at given joint values as formulas, or None if they are too long."""
    for branch in branches(chain) if where.values else ():
        if branch.component.solutions is not None and branch.component.value_combinations()[0] == where.values:
            formula = lost_formula(structure(chain).chain, branch.generic)
            if formula is not None and formula.jacobian is not None:
                return _describe_loss(chain, branch.component, formula), formula.direction.applyfunc(derive(chain).fill)
    return None


# --- geometric meaning of a singularity ---


@lru_cache(maxsize=1024)
def read_branch(generic: Chain, component: Component) -> Reading | None:
    """Return a description that fits all configurations of a structure's branch, or None if there is none."""
    additional_samples = representative_samples(generic, component.pieces())
    meanings = read_meanings(generic, sample_singular_poses(generic, component, SAMPLES), additional_samples)
    if meanings is None or (len(meanings.wrong) < 2 and find_common_kind(generic, component) is None):
        return None
    return meanings


@lru_cache(maxsize=1024)
def find_common_kind(generic: Chain, component: Component) -> str | None:
    """Return the kind of a structure's branch, "boundary" or "internal", or None if it differs within the branch."""
    return common_kind(generic, sample_singular_poses(generic, component, KINDS)) if kind_is_sure(generic) else None


def _read_branches(chain: Chain, order: Sequence[Branch]) -> Iterator[tuple[Branch, Reading]]:
    """Yield the branches that have a description in words, in the given order, with that description."""
    generic = structure(chain).chain
    for branch in order:
        reading = read_branch(generic, branch.generic)
        if reading is not None:
            yield branch, reading


def _object_to_meaning(chain: Chain) -> str | None:
    objection = objection_unless_singular(chain)
    if objection is None and next(_read_branches(chain, branches(chain)), None) is None:
        return "nothing that can be told at sight is common to a whole component of its singular set"
    return objection


@dataclass(frozen=True)
class MeaningAsked:
    """The question: joint values, or one configuration that satisfies a condition, and the options.

    `offered` has the meaning and the kind of each option. The kind is None if it differs within the branch.
    """

    values: tuple[tuple[sp.Symbol, sp.Expr], ...]
    place: Pose | None
    condition: sp.Expr | None
    offered: tuple[tuple[Meaning, str | None], ...]


@dataclass(frozen=True, kw_only=True)
class OfMeaning(Details):
    """Details of a question about the geometric meaning of a singularity: what all of its configurations look like."""

    asked: MeaningAsked


def _ask_meaning(chain: Chain, rng: Stream) -> Asked | None:
    """Offer the correct meaning and kind, the same meaning with the other kind, and meanings that do not hold."""
    for branch, reading in _read_branches(chain, rng.permutation(branches(chain))):
        configuration = sample_shown_pose(chain, (branch.component,), rng, 1)
        if configuration is None:
            continue
        kind = _find_kind_with_numbers(chain, branch, configuration)
        kinds = ("boundary", "internal")
        offered = [(reading.right, kind)]
        if kind is not None:
            offered.append((reading.right, kinds[kind == "boundary"]))
        wrong_meanings = rng.permutation(reading.wrong)[: 4 - len(offered)]
        offered += [(wrong_meaning, None if kind is None else rng.choice(kinds)) for wrong_meaning in wrong_meanings]
        answer, shuffled = shuffle_options(offered, offered[0], rng, _describe_meaning)
        has_condition = branch.component.solutions is None
        values = () if has_condition else branch.component.value_combinations()[0]
        condition = branch.component.conditions[0] if has_condition else None
        meaning_asked = MeaningAsked(values, configuration if has_condition else None, condition, tuple(shuffled))
        return answer, OfMeaning(asked=meaning_asked)
    return None


def _find_kind_with_numbers(chain: Chain, branch: Branch, pose: Pose) -> str | None:
    """Return the kind of a branch of the structure, or None if the arm with its own numbers has another kind."""
    kind = find_common_kind(structure(chain).chain, branch.generic)
    return kind if kind is not None and kind == kind_at(chain, to_sample(chain, pose)) else None


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
        entry_names=lambda chain, _: [r"\text{rank}"], objection=objection_unless_singular, follows_from=(),
    ),
    Question(
        "lost-direction", "Lost direction of motion", "6.8", needs=("jacobian",),
        stage="lost direction", sample=_ask_direction, objection=_object_to_vector, is_made_of_jacobian=True,
        entry_names=lambda chain, _: [f"u_{{{row}}}" for row in range(1, len(chain.task) + 1)],
        follows_from=(),
    ),
    Question("lost-motion", "Motion that is lost", "6.8", sample=_ask_motion, objection=_object_to_motion),
)  # fmt: skip
