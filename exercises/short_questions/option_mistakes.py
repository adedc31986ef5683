"""Why an option is wrong: the mistakes behind the options of all questions with lettered options.

Some mistakes are stored with the options that they produced. Others are found by comparison: an option may name
another meaning, or equal the result of a derivation with a mistake. Otherwise the option itself shows the mistake.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from qdot.exercises.answer_types import TRUE_FALSE, Letters
from qdot.exercises.arm.derivation_graph import Working, numeric_working
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes import catalogue
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import JointEffectDetails, parse_vector
from qdot.exercises.questions.results import compute_answer, is_derived
from qdot.exercises.short_questions.drawings import PoseStatement
from qdot.exercises.short_questions.options import Blame, ConfigurationOptions, list_blames
from qdot.exercises.short_questions.selections import QuantityDetails

Blames = tuple[Blame, ...]
ROUNDING_TOLERANCE = 6e-4
"""Absolute tolerance for the numbers of an option, which are rounded to three decimals."""


def explain_options(problem: Problem, part: Part, stream: Stream) -> list[Blames]:
    """Return the mistakes behind each wrong option; in a matching question, those behind a wrong assignment.

    `stream` samples the configuration at which numeric options are evaluated if the question has none.
    """
    answer = part.answer
    blames = {**_blame_by_derivation(problem, part, stream), **_blame_by_mistaken_answers(problem, part)}
    is_matched = bool(answer.matched_items)
    return [
        () if index in answer.correct_indices and not is_matched
        else list_blames(part, index) or blames.get(index) or _blame_by_question_kind(problem, part, index)
        for index in range(len(answer.offered_options))
    ]  # fmt: skip


def _blame_by_mistaken_answers(problem: Problem, part: Part) -> Mapping[int, Blames]:
    """Return the most likely mistake for each wrong option that an answer with a known mistake would choose."""
    blames: dict[int, Blames] = {}
    for mistake, variant in catalogue.generate_mistaken_answers(problem.chain, part):
        if isinstance(variant.answer, Letters):
            for index in set(variant.answer.correct_indices) - set(part.answer.correct_indices):
                blames.setdefault(index, (Blame.from_mistake(mistake, variant.words.items()),))
    return blames


def _blame_by_derivation(problem: Problem, part: Part, stream: Stream) -> Mapping[int, Blames]:
    """Return the most likely mistake behind each numeric option that equals the result of a wrong derivation."""
    if not is_derived(part):
        return {}
    w = numeric_working(problem.chain, sample_configurations(problem.chain, part, problem.domain(), 1, stream))
    all_wrong_answers = list(catalogue.predict_wrong_answers(w, part))
    blames: dict[int, Blames] = {}
    for index, option in enumerate(part.answer.offered_options):
        expected = np.array(parse_vector(option))[:, None, None]
        equal_answers = [wrong for wrong in all_wrong_answers if _is_near(wrong.answer, expected)]
        if equal_answers:
            likeliest = max(equal_answers, key=lambda predicted: predicted.frequency)
            blames[index] = (Blame.from_mistake(likeliest.mistake, likeliest.variant.words.items()),)
        elif isinstance(part.details, JointEffectDetails) and _is_effect_of_other_joint(w, part, expected):
            blames[index] = (Blame.from_mistake(CATALOGUE["column-of-other-joint"], ()),)
    return blames


def _is_effect_of_other_joint(w: Working, part: Part, expected: np.ndarray) -> bool:
    """Return whether the values are the effect of another joint."""
    effect = part.details_as(JointEffectDetails).effect
    other_effects = (replace(effect, joint=joint) for joint in range(1, w.n + 1) if joint != effect.joint)
    other_parts = (replace(part, details=JointEffectDetails(effect=other)) for other in other_effects)
    return any(_is_near(compute_answer(w, other_part), expected) for other_part in other_parts)


def _is_near(values: np.ndarray, expected: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return values.shape == expected.shape and bool((np.abs(values - expected) <= ROUNDING_TOLERANCE).all())


def _blame_by_question_kind(problem: Problem, part: Part, index: int) -> Blames:
    """Return the mistake that is obvious from the choice of an option."""
    answer, details = part.answer, part.details
    if answer.matched_items:
        return (Blame("column-of-other-joint", ()),)
    if isinstance(details, ConfigurationOptions):
        return (Blame("regular-taken-for-singular", ()),)
    if isinstance(details, QuantityDetails):
        return (Blame("joint-without-effect", (("joint", str(problem.chain.q[index])),)),)
    if isinstance(details, PoseStatement):
        is_true = answer.offered_options[answer.correct_indices[0]] == TRUE_FALSE[0]
        confusion = "singular-taken-for-regular" if is_true else "regular-taken-for-singular"
        return (Blame(confusion if details.said == "singular" else "motion-turned-round", ()),)
    return ()
