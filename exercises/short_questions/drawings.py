"""Questions about drawings of an arm: is a statement about a configuration true? Which configuration is singular?"""

from collections.abc import Iterator
from dataclasses import dataclass

from qdot.exercises.answer_types import TRUE_FALSE, Choice
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.geometry import (
    ConfigurationDetails,
    evaluate_precisely,
    sample_displayable_configuration,
    sample_regular_configuration,
)
from qdot.exercises.short_questions.asking import ShortQuestion
from qdot.exercises.short_questions.options import ConfigurationOptions
from qdot.exercises.short_questions.places import (
    assign_random_lengths,
    iterate_regular_configurations,
    iterate_singular_configurations,
    take_distinct,
    write_configuration,
)
from qdot.exercises.singularities.singularity import singular_set

MIN_VISIBLE_VELOCITY = 0.08
"""Minimum velocity component (m/s for a unit joint rate) whose sign is asked for: large enough to see in a drawing."""


@dataclass(frozen=True, kw_only=True)
class PoseStatement(ConfigurationDetails):
    """A statement about a configuration.

    `said` is "singular" (it is singular) or "moves" (a joint moves the tool point in some direction). Problem digests
    contain this word.
    """

    said: str


@dataclass(frozen=True, kw_only=True)
class JointStatement(PoseStatement):
    """The statement that a joint gives a velocity component of the tool point a certain sign at a positive rate.

    `joint` counts from 1, and `row` is the name of the component, such as "vx".
    """

    joint: int
    row: str
    positive: bool


# --- true or false ---


def _ask_true_or_false(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose first whether the statement is true, then the statement."""
    truth = rng.choice((True, False))
    for _ in range(30):
        for statement in _sample_statements(chain, truth, rng):
            return Choice(TRUE_FALSE, TRUE_FALSE.index("true" if truth else "false")), statement
    return None


def _sample_statements(chain: Chain, is_true: bool, rng: Stream) -> Iterator[PoseStatement]:
    for statement_kind in rng.permutation(("singular", "moves")):
        if statement_kind == "singular" and (components := singular_set(chain)):
            if is_true:
                configuration = sample_displayable_configuration(chain, (rng.choice(components),), rng)
            else:
                configuration = sample_regular_configuration(chain, rng, 0.12)
            if configuration is not None:
                yield PoseStatement(said="singular", place=configuration, pose=configuration.figure_values)
        if statement_kind == "moves":
            yield from _sample_joint_statements(chain, is_true, rng)


def _sample_joint_statements(chain: Chain, is_true: bool, rng: Stream) -> Iterator[PoseStatement]:
    """Yield a statement about the sign of a velocity component due to one joint. A false one has the wrong sign."""
    configuration = sample_regular_configuration(chain, rng, 0.05, prefers_misleading=False)
    if configuration is None:
        return
    linear = evaluate_precisely(chain, configuration, derive(chain).linear)
    visible_entries = [
        (row, joint)
        for row in range(3)
        for joint in range(chain.n)
        if abs(float(linear[row, joint])) > MIN_VISIBLE_VELOCITY
    ]
    if visible_entries:
        row, joint = rng.choice(visible_entries)
        positive = bool(linear[row, joint] > 0) == is_true
        yield JointStatement(
            said="moves",
            place=configuration,
            pose=configuration.figure_values,
            joint=joint + 1,
            row=TASK_ROWS[row],
            positive=positive,
        )


# --- which drawing shows a singular configuration? ---


def _ask_which_drawing(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for _ in range(4):
        arm, lengths = assign_random_lengths(chain, rng)
        singular = take_distinct(iterate_singular_configurations(arm, rng), 1)
        regular = take_distinct(
            iterate_regular_configurations(arm, rng), 3, [configuration for configuration, _ in singular]
        )
        if singular and len(regular) == 3:
            shuffled = rng.permutation([*singular, *regular])
            shown_configurations, blames = (tuple(column) for column in zip(*shuffled, strict=True))
            answer = Choice(
                tuple(write_configuration(configuration) for configuration in shown_configurations),
                shuffled.index(singular[0]),
            )
            return answer, ConfigurationOptions(places=shown_configurations, lengths=lengths, blames=blames, drawn=True)
    return None


DRAWING_QUESTIONS = (
    ShortQuestion(
        "true-or-false", "True or false?", "6.12", sample=_ask_true_or_false, form="true or false",
        base_question="jacobian", objection_if_nothing_found="there is no statement about its configurations to judge",
    ),
    ShortQuestion(
        "singular-drawing", "Which drawing shows a singular configuration?", "6.8", sample=_ask_which_drawing,
        form="choice", base_question="singular-angles",
        objection_if_nothing_found="it does not have four suitable configurations", shown_answers=("singular-angles",),
    ),
)  # fmt: skip
