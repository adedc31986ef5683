"""Find out why an option is wrong: the mistakes that lead to the options of all questions with lettered options.

Some mistakes are stored with the options that they produced. Others are found by comparison: the option may be the
answer that a known mistake gives, or the velocity of a joint after a mistake. Otherwise the choice of the option itself
shows the mistake.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import StageResults, compute_numeric_stages
from qdot.exercises.mistakes import catalogue
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import JointEffectDetails, parse_vector
from qdot.exercises.questions.results import compute_answer
from qdot.exercises.reference_answers import TRUE_FALSE, Letters
from qdot.exercises.short_questions.options import Blame, list_blames
from qdot.exercises.short_questions.selections import QuantityDetails
from qdot.exercises.short_questions.single_configuration import ConfigurationStatement

Blames = tuple[Blame, ...]
ROUNDING_TOLERANCE = 6e-4
"""Absolute tolerance for the numbers of an option, which are rounded to three decimals."""
EFFECT_MISTAKES = ("sign", "no-cross-product", "rows-exchanged", "row-sign")
"""The mistakes in the velocity that a joint causes which its numbers show at a single configuration.

Many other mistakes give the same few numbers by chance, so that none of them is likely.
"""


def explain_options(problem: Problem, part: Part, stream: Stream) -> list[Blames]:
    """Return the mistakes that lead to each option (none for a correct option).

    In a matching question, these are the mistakes that lead to a wrong assignment of the option. If a question gives no
    configuration, `stream` samples the configuration at which numeric options are evaluated.
    """
    answer = part.answer
    blames = {**_blame_by_effect(problem, part, stream), **_blame_by_mistaken_answers(problem, part)}
    is_matched = bool(answer.matched_items)
    return [
        () if index in answer.correct_indices and not is_matched
        else list_blames(part, index) or blames.get(index) or _blame_by_question_kind(problem, part, index)
        for index in range(len(answer.offered_options))
    ]  # fmt: skip


def _blame_by_mistaken_answers(problem: Problem, part: Part) -> Mapping[int, Blames]:
    """Return, by the index of a wrong option, the first known mistake whose answer chooses the option."""
    blames: dict[int, Blames] = {}
    for mistake, variant in catalogue.generate_mistaken_answers(problem.chain, part):
        if isinstance(variant.answer, Letters):
            for index in set(variant.answer.correct_indices) - set(part.answer.correct_indices):
                blames.setdefault(index, (Blame.from_mistake(mistake, variant.words.items()),))
    return blames


def _blame_by_effect(problem: Problem, part: Part, stream: Stream) -> Mapping[int, Blames]:
    """Return, by the index of a velocity that a joint is said to cause, the mistake that surely leads to it."""
    if not isinstance(part.details, JointEffectDetails):
        return {}
    stages = compute_numeric_stages(
        problem.chain, sample_configurations(problem.chain, part, problem.domain, 1, stream)
    )
    mistakes = (CATALOGUE[name] for name in EFFECT_MISTAKES)
    predictions = [prediction for mistake in mistakes for prediction in apply_mistake(mistake, stages, part)]
    blames: dict[int, Blames] = {}
    for index, option in enumerate(part.answer.offered_options):
        velocity = np.array(parse_vector(option))[:, None, None]
        if _is_effect_of_other_joint(stages, part, velocity):
            blames[index] = (Blame.from_mistake(CATALOGUE["column-of-other-joint"], ()),)
        elif found := next((prediction for prediction in predictions if _is_near(prediction.answer, velocity)), None):
            blames[index] = (Blame.from_mistake(found.mistake, found.variant.words.items()),)
    return blames


def _is_effect_of_other_joint(stages: StageResults, part: Part, expected: np.ndarray) -> bool:
    """Return whether another joint causes the expected velocity."""
    details = part.details_as(JointEffectDetails)
    other_details = (replace(details, joint=joint) for joint in range(1, stages.n + 1) if joint != details.joint)
    other_parts = (replace(part, details=details_of_other) for details_of_other in other_details)
    return any(_is_near(compute_answer(stages, other_part), expected) for other_part in other_parts)


def _is_near(values: np.ndarray, expected: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return values.shape == expected.shape and bool((np.abs(values - expected) <= ROUNDING_TOLERANCE).all())


def _blame_by_question_kind(problem: Problem, part: Part, index: int) -> Blames:
    """Return the mistake that the choice of an option shows by itself, depending on the kind of question."""
    answer, details = part.answer, part.details
    if answer.matched_items:
        return (Blame("column-of-other-joint", ()),)
    if isinstance(details, QuantityDetails):
        return (Blame("joint-without-effect", (("joint", str(problem.chain.q[index])),)),)
    if isinstance(details, ConfigurationStatement):
        is_true = answer.offered_options[answer.correct_indices[0]] == TRUE_FALSE[0]
        confusion = "singular-taken-for-regular" if is_true else "regular-taken-for-singular"
        return (Blame(confusion if details.statement_kind == "singular" else "motion-reversed", ()),)
    return ()
