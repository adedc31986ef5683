"""Why an option is wrong: the mistakes behind the options of all questions with lettered options.

Some mistakes are stored with the options that they produced. Others are found by comparison: an option may name
another meaning, or equal the result of a derivation with a mistake. Otherwise the option itself shows the mistake.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from qdot.exercises.answers import TRUE_FALSE, Letters
from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.catalogue import CATALOGUE, mistaken_answers, variant_frequency, wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import OfJoint, read_vector
from qdot.exercises.questions.results import is_derived, result
from qdot.exercises.quizzes.drawings import PoseStatement
from qdot.exercises.quizzes.options import Blame, Places, list_blames
from qdot.exercises.quizzes.selections import OfQuantity

Blames = tuple[Blame, ...]
THREE_DECIMALS = 6e-4
"""Absolute tolerance for the numbers of an option, which are rounded to three decimals."""


def explain_options(problem: Problem, part: Part, stream: Stream) -> list[Blames]:
    """Return the mistakes behind each wrong option; in a matching question, those behind a wrong assignment.

    `stream` samples the configuration at which numeric options are evaluated if the question has none.
    """
    answer = part.answer
    blames = {**_blame_by_derivation(problem, part, stream), **_blame_by_meaning(problem, part)}
    is_matched = bool(answer.matched)
    return [
        () if index in answer.right and not is_matched
        else list_blames(part, index) or blames.get(index) or _blame_by_choice(problem, part, index)
        for index in range(len(answer.offered))
    ]  # fmt: skip


def _blame_by_meaning(problem: Problem, part: Part) -> Mapping[int, Blames]:
    """Return the most likely mistake for each wrong option that an answer with a known mistake would choose."""
    blames: dict[int, Blames] = {}
    for mistake, variant in mistaken_answers(problem.chain, part):
        if isinstance(variant.answer, Letters):
            for index in set(variant.answer.right) - set(part.answer.right):
                blames.setdefault(index, (Blame.of(mistake, variant.words.items()),))
    return blames


def _blame_by_derivation(problem: Problem, part: Part, stream: Stream) -> Mapping[int, Blames]:
    """Return the most likely mistake behind each numeric option that equals the result of a wrong derivation."""
    if not is_derived(part):
        return {}
    w = numbers(problem.chain, sample_configurations(problem.chain, part, problem.domain(), 1, stream))
    all_wrong_answers = list(wrong_answers(w, part))
    blames: dict[int, Blames] = {}
    for index, option in enumerate(part.answer.offered):
        expected = np.array(read_vector(option))[:, None, None]
        equal_answers = [
            wrong
            for wrong in all_wrong_answers
            if wrong.answer.shape == expected.shape and _is_near(wrong.answer, expected)
        ]
        if equal_answers:
            likeliest = max(equal_answers, key=variant_frequency)
            blames[index] = (Blame.of(likeliest.mistake, likeliest.variant.words.items()),)
        elif isinstance(part.details, OfJoint) and _is_of_other_joint(w, part, expected):
            blames[index] = (Blame.of(CATALOGUE["column-of-other-joint"], ()),)
    return blames


def _is_of_other_joint(w: Working, part: Part, expected: np.ndarray) -> bool:
    """Return whether the values are the effect of another joint."""
    effect = part.about(OfJoint).effect
    other_effects = (replace(effect, joint=joint) for joint in range(1, w.n + 1) if joint != effect.joint)
    return any(
        _is_near(result(w, replace(part, details=OfJoint(effect=other_effect))), expected)
        for other_effect in other_effects
    )


def _is_near(values: np.ndarray, expected: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(values - expected) <= THREE_DECIMALS).all())


def _blame_by_choice(problem: Problem, part: Part, index: int) -> Blames:
    """Return the mistake that is obvious from the choice of an option."""
    answer, details = part.answer, part.details
    if answer.matched:
        return (Blame("column-of-other-joint", ()),)
    if isinstance(details, Places):
        return (Blame("regular-taken-for-singular", ()),)
    if isinstance(details, OfQuantity):
        return (Blame("joint-without-effect", (("joint", str(problem.chain.q[index])),)),)
    if isinstance(details, PoseStatement):
        is_true = answer.offered[answer.right[0]] == TRUE_FALSE[0]
        confusion = "singular-taken-for-regular" if is_true else "regular-taken-for-singular"
        return (Blame(confusion if details.said == "singular" else "motion-turned-round", ()),)
    return ()
