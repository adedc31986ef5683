"""Questions on the rank of J, the direction of motion that is lost, and the geometric meaning of a singularity (6.8).

The singular set of an arm consists of branches. At the configurations of a branch, some joints have given values, or a
condition on several joints holds. Results for a branch are derived once for the arm's structure (the arm with symbols
for all lengths and oblique angles).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.problem.problem import Details, recorded_as
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.exact_configurations import (
    DIGITS,
    ZERO,
    Branch,
    ConfigurationDetails,
    ExactConfiguration,
    Sampler,
    compute_full_rank,
    compute_lost_direction,
    compute_rank,
    convert_to_sample,
    evaluate_jacobian,
    match_branches,
    sample_displayable_configuration,
    sample_from_any_component,
    sample_regular_configuration,
    sample_singular_configuration,
    sample_with_varied_lengths,
)
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE
from qdot.exercises.questions.singular import KIND_OPTIONS, find_lost_direction_objection, find_singularity_objection
from qdot.exercises.reference_answers import Direction, Number
from qdot.exercises.reference_answers.formulas import COUNT_TOLERANCE
from qdot.exercises.singularities.classification import sample_representatives
from qdot.exercises.singularities.directions import (
    LostDirectionFormula,
    find_clear_rank,
    find_shortest_lost_direction,
)
from qdot.exercises.singularities.meanings import BranchMeanings, Meaning, find_branch_meanings
from qdot.exercises.singularities.singular_set import Component, ValueCombination, find_singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples

MAX_ROWS = 4
"""Maximum number of rows of a Jacobian whose null space is found by hand."""

MEANING_SAMPLE_COUNT, KIND_SAMPLE_COUNT = 8, 60
"""Numbers of configurations at which the meaning and the kind (boundary or internal) of a branch are determined."""


# --- rank ---


@lru_cache(maxsize=1024)
def _find_sets_with_larger_rank_loss(symbolic_chain: Chain) -> tuple[tuple[int, ...], ...]:
    """Return sets of components (by index) on whose intersection the rank of a structure's J drops by more than one."""
    components = find_singular_set(symbolic_chain) or ()
    lost_ranks = range(2, compute_full_rank(symbolic_chain) + 1)

    def loses_more_than_one(indices: tuple[int, ...]) -> bool:
        sample = partial(sample_singular_configuration, symbolic_chain, [components[i] for i in indices])
        return any(sample(Stream(f"deep/{indices}"), lost_rank) for lost_rank in lost_ranks)

    index_sets = (indices for size in (1, 2, 3) for indices in combinations(range(len(components)), size))
    return tuple(filter(loses_more_than_one, index_sets))


_sample_with_formulas = partial(sample_singular_configuration, needs_no_rounding=True, keeps_formulas=True)


def _sample_with_larger_rank_loss(chain: Chain, rng: Stream) -> ExactConfiguration | None:
    """Return a random configuration at which the rank of J drops by more than one, or None if none is found."""
    symbolic_chain, substitute = make_symbolic_arm(chain).chain, derive(chain).substitute_values
    symbolic_components = find_singular_set(symbolic_chain) or ()
    arm_components = {component.conditions: component for component in find_singular_set(chain) or ()}
    for indices in rng.permutation(_find_sets_with_larger_rank_loss(symbolic_chain)):
        matches = [arm_components.get(tuple(map(substitute, symbolic_components[i].conditions))) for i in indices]
        components = [component for component in matches if component is not None]
        if len(components) == len(indices):
            configuration = _sample_with_formulas(chain, components, rng)
            rank = None if configuration is None else compute_rank(chain, configuration)
            if rank is not None and rank <= compute_full_rank(chain) - 2:
                return configuration
    return None


_sample_with_single_rank_loss = partial(sample_from_any_component, lost_rank=1, sample=_sample_with_formulas)


@dataclass(frozen=True, kw_only=True)
class RankDetails(ConfigurationDetails):
    """Details of a question about the rank at a configuration.

    `independent_columns` are the numbers (from 1) of the first columns of J that span all columns.
    `satisfied_conditions` are the conditions of the components of the singular set that contain the configuration.
    """

    independent_columns: tuple[int, ...] = field(metadata=recorded_as("facts.columns"))
    satisfied_conditions: tuple[tuple[sp.Expr, ...], ...] = field(metadata=recorded_as("facts.vanishing"))


def _ask_rank(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose by how much the rank drops, then sample an exact configuration: rounding would restore full rank."""
    samplers: tuple[Sampler, ...] = (
        sample_regular_configuration,
        _sample_with_single_rank_loss,
        _sample_with_larger_rank_loss,
    )
    for sample in rng.permutation(samplers):
        configuration = sample(chain, rng)
        if configuration is not None:
            jacobian = evaluate_jacobian(chain, configuration)
            answer = Number(sp.Matrix([[find_clear_rank(jacobian)]]), ("",), COUNT_TOLERANCE, COUNT_TOLERANCE)
            return answer, RankDetails(
                configuration=configuration,
                independent_columns=_find_independent_columns(jacobian),
                satisfied_conditions=_find_satisfied_conditions(chain, configuration),
            )
    return None


def _find_independent_columns(jacobian: np.ndarray) -> tuple[int, ...]:
    """Return the numbers (from 1) of the first columns that span all columns."""
    independent_columns: list[int] = []
    for column in range(jacobian.shape[1]):
        sigma = np.linalg.svd(jacobian[:, [*independent_columns, column]], compute_uv=False)
        if len(sigma) == len(independent_columns) + 1 and sigma[-1] > 1e-7 * np.linalg.norm(jacobian):
            independent_columns.append(column)
    return tuple(column + 1 for column in independent_columns)


def _find_satisfied_conditions(chain: Chain, configuration: ExactConfiguration) -> tuple[tuple[sp.Expr, ...], ...]:
    """Return the conditions of each component of the singular set that contains a configuration."""

    def holds(condition: sp.Expr) -> bool:
        return bool(abs(sp.N(condition.xreplace(configuration.values), DIGITS)) < ZERO)

    all_conditions = (component.conditions for component in find_singular_set(chain) or ())
    return tuple(conditions for conditions in all_conditions if all(map(holds, conditions)))


# --- lost direction, as a vector ---


def _find_lost_vector_objection(chain: Chain) -> str | None:
    """Return why the question on the lost direction can't be asked about an arm, or None."""
    if objection := find_lost_direction_objection(chain):
        return objection
    if len(chain.task) > MAX_ROWS:
        return f"its Jacobian has {len(chain.task)} rows, too many for a null space by hand"
    has_branch = bool(_find_branches_losing_one_direction(chain))
    return None if has_branch else "it has no singular configuration that loses exactly one direction"


def _find_branches_losing_one_direction(chain: Chain) -> list[Branch]:
    """Return the branches that lose one direction, if possible only those with a formula for the direction."""
    symbolic_chain = make_symbolic_arm(chain).chain

    def has_formula(branch: Branch) -> bool:
        return find_shortest_lost_direction(symbolic_chain, branch.structure_component) is not None

    all_branches = match_branches(chain)
    branches = [branch for branch in all_branches if _loses_one_direction(symbolic_chain, branch.structure_component)]
    return list(filter(has_formula, branches)) or branches


@lru_cache(maxsize=1024)
def _loses_one_direction(symbolic_chain: Chain, component: Component) -> bool:
    """Return whether a structure has a configuration on a component at which exactly one direction is lost."""
    return sample_singular_configuration(symbolic_chain, (component,), Stream("one"), lost_rank=1) is not None


@dataclass(frozen=True)
class JacobianOnBranch:
    """The Jacobian at the joint values of a branch, from which the lost direction is found as a formula.

    - `values` are the joint values, and `free_joints` are the joints that may have any value.
    - `jacobian` is J at these values, or None if J is too long to show.
    - `columns` are the numbers (from 1) of the columns of J whose cofactors are the entries of the lost direction.
    """

    values: ValueCombination
    free_joints: tuple[sp.Symbol, ...] = field(metadata=recorded_as("free"))
    jacobian: sp.Matrix | None
    columns: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class LostDirectionDetails(Details):
    """Details about the direction that is lost if some joints have given values, whatever the values of the others."""

    jacobian_on_branch: JacobianOnBranch = field(metadata=recorded_as("lost"))

    @property
    def given_joints(self) -> dict[sp.Symbol, sp.Expr]:
        """The joint values at which the direction is lost."""
        return dict(self.jacobian_on_branch.values)


def _ask_direction(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Ask for the lost direction of a branch: as a formula if it is short, else as numbers at a configuration."""
    for branch in rng.permutation(_find_branches_losing_one_direction(chain)):
        formula = find_shortest_lost_direction(make_symbolic_arm(chain).chain, branch.structure_component)
        if formula is not None:
            jacobian_on_branch, direction = _substitute_numbers(chain, branch, formula)
            if all(entry == 0 or entry.could_extract_minus_sign() for entry in direction):
                direction = -direction
            return Direction(direction), LostDirectionDetails(jacobian_on_branch=jacobian_on_branch)
        configuration = sample_displayable_configuration(chain, (branch.component,), rng, lost_rank=1)
        if configuration is not None:
            direction = compute_lost_direction(chain, configuration)
            numbers = direction.applyfunc(lambda value: sp.Float(value, 10) if value else sp.S.Zero)
            return Direction(numbers, THREE_DIGIT_TOLERANCE), ConfigurationDetails(configuration=configuration)
    return None


def _substitute_numbers(
    chain: Chain, branch: Branch, formula: LostDirectionFormula
) -> tuple[JacobianOnBranch, sp.Matrix]:
    """Return J on a branch and the lost direction of an arm, given the formulas for its structure."""
    substitute = derive(chain).substitute_values
    free_joints = tuple(q for q in chain.q if q not in dict(branch.values))
    jacobian = None if formula.jacobian is None else formula.jacobian.applyfunc(substitute)
    jacobian_on_branch = JacobianOnBranch(branch.values, free_joints, jacobian, formula.columns)
    return jacobian_on_branch, formula.direction.applyfunc(substitute)


def find_lost_direction_formula(chain: Chain, values: ValueCombination) -> tuple[JacobianOnBranch, sp.Matrix] | None:
    """Return J and the lost direction at given joint values as formulas, or None if they are too long."""
    for branch in match_branches(chain) if values else ():
        if branch.values == values:
            formula = find_shortest_lost_direction(make_symbolic_arm(chain).chain, branch.structure_component)
            if formula is not None and formula.jacobian is not None:
                return _substitute_numbers(chain, branch, formula)
    return None


# --- geometric meaning of a singularity ---


@lru_cache(maxsize=1024)
def _find_meanings(symbolic_chain: Chain, component: Component) -> BranchMeanings | None:
    """Return the geometric statement that holds on a whole branch of a structure, and wrong statements.

    Return None if there is no such statement, or if there are too few wrong statements for a question.
    """
    samples = sample_with_varied_lengths(symbolic_chain, component, MEANING_SAMPLE_COUNT)
    meanings = find_branch_meanings(
        symbolic_chain, samples, sample_representatives(symbolic_chain, component.list_pieces())
    )
    if meanings is None or (len(meanings.wrong) < 2 and _find_common_kind(symbolic_chain, component) is None):
        return None
    return meanings


@lru_cache(maxsize=1024)
def _find_common_kind(symbolic_chain: Chain, component: Component) -> str | None:
    """Return the kind of a structure's branch, "boundary" or "internal"; None if it has both or can't be determined."""
    if not can_establish_kind(symbolic_chain):
        return None
    samples = sample_with_varied_lengths(symbolic_chain, component, KIND_SAMPLE_COUNT)
    kinds = set(classify_samples(symbolic_chain, samples))
    return kinds.pop() if len(kinds) == 1 else None


def _iterate_branches_with_meaning(chain: Chain, branches: Sequence[Branch]) -> Iterator[tuple[Branch, BranchMeanings]]:
    """Yield the branches that have a geometric meaning, in the order of `branches`, each with its meanings."""
    for branch in branches:
        meanings = _find_meanings(make_symbolic_arm(chain).chain, branch.structure_component)
        if meanings is not None:
            yield branch, meanings


def _find_meaning_objection(chain: Chain) -> str | None:
    if objection := find_singularity_objection(chain):
        return objection
    has_meaning = next(_iterate_branches_with_meaning(chain, match_branches(chain)), None) is not None
    return None if has_meaning else "its singular configurations have no common feature that you can see in a drawing"


class MeaningOption(NamedTuple):
    """An option of a question about a singularity; the kind is None if the branch has both kinds."""

    meaning: Meaning
    kind: str | None

    @property
    def text(self) -> str:
        """The text that students see."""
        return self.meaning.words if self.kind is None else f"{self.meaning.words}; {KIND_OPTIONS[self.kind]}"


@dataclass(frozen=True, kw_only=True)
class MeaningDetails(Details):
    """Details of a question about the geometric meaning of a branch, that is, what its configurations look like.

    The question states the joint `values` of the branch or, if there are none, one `configuration` that satisfies the
    `condition` of the branch.
    """

    values: ValueCombination = field(metadata=recorded_as("asked.values"))
    configuration: ExactConfiguration | None = field(metadata=recorded_as("asked.place"))
    condition: sp.Expr | None = field(metadata=recorded_as("asked.condition"))
    options: tuple[MeaningOption, ...] = field(metadata=recorded_as("asked.offered"))


def _ask_meaning(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer the correct and a wrong meaning, each with both kinds, or several meanings if there is no common kind."""
    for branch, meanings in _iterate_branches_with_meaning(chain, rng.permutation(match_branches(chain))):
        configuration = sample_displayable_configuration(chain, (branch.component,), rng, lost_rank=1)
        if configuration is None:
            continue
        kind = _confirm_common_kind(chain, branch, configuration)
        kinds = (None,) if kind is None else ("boundary", "internal")
        offered_meanings = [meanings.correct, *rng.permutation(meanings.wrong)][: 4 // len(kinds)]
        if not all(meaning.remark for meaning in offered_meanings):  # a remark would make an option stand out
            offered_meanings = [meaning.without_remark() for meaning in offered_meanings]
        options = [MeaningOption(meaning, offered_kind) for meaning in offered_meanings for offered_kind in kinds]
        answer, shuffled_options = shuffle_options(
            options, MeaningOption(offered_meanings[0], kind), rng, lambda option: option.text
        )
        has_values = branch.component.solutions is not None
        return answer, MeaningDetails(
            values=branch.values,
            configuration=None if has_values else configuration,
            condition=None if has_values else branch.component.conditions[0],
            options=tuple(shuffled_options),
        )
    return None


def _confirm_common_kind(chain: Chain, branch: Branch, configuration: ExactConfiguration) -> str | None:
    """Return the kind of a branch of the structure; None unless a configuration of the arm has the same kind."""
    kind = _find_common_kind(make_symbolic_arm(chain).chain, branch.structure_component)
    kinds_of_arm = classify_samples(chain, [convert_to_sample(chain, configuration)]) if kind else []
    return kind if kinds_of_arm == [kind] else None


# Rank and lost direction have no `alternative_prerequisites`: a student's wrong Jacobian usually has full rank.
QUESTIONS = (
    Question(
        "singularity-meaning", "Meaning of a singularity", "below 6.7",
        sample=_ask_meaning, find_arm_objection=_find_meaning_objection,
    ),
    Question(
        "rank", "Rank of the Jacobian", "6.8", prerequisites=("jacobian",), sample=_ask_rank,
        name_entries=lambda chain, _: [r"\text{rank}"], find_arm_objection=find_singularity_objection,
        alternative_prerequisites=(),
    ),
    Question(
        "lost-direction", "Lost direction of motion", "6.8", prerequisites=("jacobian",), stage="lost direction",
        sample=_ask_direction, find_arm_objection=_find_lost_vector_objection, is_made_of_jacobian=True,
        name_entries=lambda chain, _: [f"u_{{{row}}}" for row in range(1, len(chain.task) + 1)],
        alternative_prerequisites=(),
    ),
)  # fmt: skip
