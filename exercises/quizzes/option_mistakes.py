"""Why an option is wrong: the mistakes behind the options of every question with letters.

Some are kept with the options that they made; others are found where the question takes one meaning for another, or
where a derivation with a mistake in it gives the option; of the rest, it is the option itself that tells.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from qdot.exercises.answers import TRUE_FALSE, Letters
from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.catalogue import CATALOGUE, mistaken_answers, variant_frequency, wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import OfJoint, option_numbers
from qdot.exercises.questions.results import is_derived, result
from qdot.exercises.quizzes.drawn import Said
from qdot.exercises.quizzes.options import Blame, Places, blames_of
from qdot.exercises.quizzes.several import OfQuantity

Blames = tuple[Blame, ...]
THREE_DECIMALS = 6e-4
"""What the numbers of an option may be off."""


def blames_for(problem: Problem, part: Part, stream: Stream) -> list[Blames]:
    """Return the mistakes behind each option where it is wrong; of matches, where it is given to another item.

    `stream` draws the configuration at which an option in numbers is worked out, where none is given.
    """
    answer = part.answer
    found = {**_worked_out(problem, part, stream), **_taken(problem, part)}
    is_matched = bool(answer.matched)
    return [
        () if index in answer.right and not is_matched
        else blames_of(part, index) or found.get(index) or _by_itself(problem, part, index)
        for index in range(len(answer.offered))
    ]  # fmt: skip


def _taken(problem: Problem, part: Part) -> Mapping[int, Blames]:
    """Return what is behind options that one meaning is taken for, the likelier mistake of each."""
    found: dict[int, Blames] = {}
    for mistake, slip in mistaken_answers(problem.chain, part):
        if isinstance(slip.answer, Letters):
            for index in set(slip.answer.right) - set(part.answer.right):
                found.setdefault(index, (Blame.of(mistake, slip.words.items()),))
    return found


def _worked_out(problem: Problem, part: Part, stream: Stream) -> Mapping[int, Blames]:
    """Return what is behind options in numbers that a derivation with a mistake in it gives, the likeliest of each."""
    if not is_derived(part):
        return {}
    w = numbers(problem.chain, sample_configurations(problem.chain, part, problem.domain(), 1, stream))
    every = list(wrong_answers(w, part))
    found: dict[int, Blames] = {}
    for index, option in enumerate(part.answer.offered):
        due = np.array(option_numbers(option))[:, None, None]
        same = [one for one in every if one.answer.shape == due.shape and _is_near(one.answer, due)]
        if same:
            first = max(same, key=variant_frequency)
            found[index] = (Blame.of(first.mistake, first.slip.words.items()),)
        elif isinstance(part.details, OfJoint) and _is_of_other_joint(w, part, due):
            found[index] = (Blame.of(CATALOGUE["column-of-other-joint"], ()),)
    return found


def _is_of_other_joint(w: Working, part: Part, due: np.ndarray) -> bool:
    """Tell whether what one joint does is what another does."""
    effect = part.about(OfJoint).effect
    others = (replace(effect, joint=joint) for joint in range(1, w.n + 1) if joint != effect.joint)
    return any(_is_near(result(w, replace(part, details=OfJoint(effect=other))), due) for other in others)


def _is_near(one: np.ndarray, other: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(one - other) <= THREE_DECIMALS).all())


def _by_itself(problem: Problem, part: Part, index: int) -> Blames:
    return tuple(Blame.of(CATALOGUE[name], words.items()) for name, words in _told_by(problem, part, index))


def _told_by(problem: Problem, part: Part, index: int) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yield the mistake, and its words, that is made by choosing an option, whatever led to it."""
    answer, details = part.answer, part.details
    if answer.matched:
        yield "column-of-other-joint", {}
    elif isinstance(details, Places):
        yield "regular-taken-for-singular", {}
    elif isinstance(details, OfQuantity):
        yield "joint-without-effect", {"joint": str(problem.chain.q[index])}
    elif isinstance(details, Said):
        is_true = answer.offered[answer.right[0]] == TRUE_FALSE[0]
        of_singular = "singular-taken-for-regular" if is_true else "regular-taken-for-singular"
        yield of_singular if details.said == "singular" else "motion-turned-round", {}
