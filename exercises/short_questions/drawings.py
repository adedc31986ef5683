"""Questions about drawings of an arm: is a statement about a configuration true? Which configuration is singular?"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from qdot.exercises.answer_types import TRUE_FALSE, Choice
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import geometry
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.geometry import ConfigurationDetails
from qdot.exercises.short_questions import places
from qdot.exercises.short_questions.asking import ShortQuestion
from qdot.exercises.singularities.singularity import singular_set

MIN_VISIBLE_VELOCITY = 0.08
"""Minimum velocity component (m/s for a unit joint rate) whose sign is asked for; readers can see it in a drawing."""


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
                configuration = geometry.sample_displayable_configuration(chain, (rng.choice(components),), rng)
            else:
                configuration = geometry.sample_regular_configuration(chain, rng, 0.12)
            if configuration is not None:
                yield PoseStatement(said="singular", place=configuration)
        if statement_kind == "moves":
            yield from _sample_joint_statements(chain, is_true, rng)


def _sample_joint_statements(chain: Chain, is_true: bool, rng: Stream) -> Iterator[PoseStatement]:
    """Yield a statement about the sign of a velocity component due to one joint. A false one has the wrong sign."""
    configuration = geometry.sample_regular_configuration(chain, rng, 0.05, prefers_misleading=False)
    if configuration is None:
        return
    linear = geometry.evaluate_precisely(chain, configuration, derive(chain).linear)
    visible_entries = np.argwhere(np.abs(np.array(linear.tolist(), dtype=float)) > MIN_VISIBLE_VELOCITY).tolist()
    if visible_entries:
        row, joint = rng.choice(visible_entries)
        positive, row_name = bool(linear[row, joint] > 0) == is_true, TASK_ROWS[row]
        yield JointStatement(said="moves", place=configuration, joint=joint + 1, row=row_name, positive=positive)


# --- which drawing shows a singular configuration? ---


def _ask_which_drawing(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for _ in range(4):
        arm, lengths = places.assign_random_lengths(chain, rng)
        singular = places.take_distinct(places.iterate_singular_configurations(arm, rng), 1)
        regular = places.take_distinct(places.iterate_regular_configurations(arm, rng), 3, singular)
        if singular and len(regular) == 3:
            details, texts, (correct,) = places.offer_configurations(singular, regular, lengths, rng)
            return Choice(texts, correct), replace(details, drawn=True)
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
