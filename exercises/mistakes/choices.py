"""Mistakes behind wrong options of choice questions, and behind wrong integers such as the size or rank of J."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace

import sympy as sp

from qdot.exercises.answers import Choice, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.mistakes.base import Answers, Mistake, MistakenAnswer
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.concepts import USES
from qdot.exercises.questions.differentiation import ForTask
from qdot.exercises.questions.rank import OfMeaning
from qdot.exercises.questions.singular import OPTIONS


def _choose(kind: str, is_chosen: Callable[[Part, int, int], bool]) -> Answers:
    """Return a function that yields answers with the wrong options that a mistake leads to.

    `is_chosen` returns whether it does, given the part and the indices of a wrong option and of the correct one.
    """

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == kind and isinstance(part.answer, Choice):
            correct_index = part.answer.correct
            for index in range(len(part.answer.options)):
                if index != correct_index and is_chosen(part, index, correct_index):
                    yield MistakenAnswer(replace(part.answer, correct=index))

    return answers


def _confuse_meanings(kind: str, texts: Mapping[str, str], pairs: Collection[tuple[str, str]]) -> Answers:
    """Return a function that yields answers with one meaning confused with another; `pairs` are (correct, chosen)."""
    meanings_by_text = {text: name for name, text in texts.items()}

    def is_chosen(part: Part, index: int, right: int) -> bool:
        options = part.of(Choice).options
        return (meanings_by_text[options[right]], meanings_by_text[options[index]]) in pairs

    return _choose(kind, is_chosen)


def _choose_statement(is_same_meaning: bool) -> Answers:
    """Return a function that yields answers with a wrong kind of singularity or a wrong geometric cause.

    If `is_same_meaning`, the geometric cause is correct and the kind is wrong.
    """

    def is_chosen(part: Part, index: int, right: int) -> bool:
        offered = part.about(OfMeaning).asked.offered
        return (offered[index][0] is offered[right][0]) is is_same_meaning

    return _choose("singularity-meaning", is_chosen)


def _combine(*all_answers: Answers) -> Answers:
    return lambda chain, part: (mistaken for answers in all_answers for mistaken in answers(chain, part))


def _give_numbers(kind: str, numbers: Callable[[Chain, Part], Iterable[list[int]]]) -> Answers:
    """Return a function that yields answers with wrong integers."""

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == kind and isinstance(part.answer, Number):
            for values in numbers(chain, part):
                if values != list(part.answer.reference):
                    yield MistakenAnswer(replace(part.answer, reference=sp.Matrix(values)))

    return answers


def _task_size(part: Part) -> int:
    return len(part.about(ForTask).task)


def _full_rank(chain: Chain) -> int:
    return min(len(chain.task), chain.n)


def _rank(part: Part) -> int:
    return int(part.of(Number).reference[0])


def _count_kinds(chain: Chain, part: Part) -> Iterator[list[int]]:
    """Yield the rows and columns of J, with the orientation or the position counted as a single component."""
    linear = sum(row[0] == "v" for row in part.about(ForTask).task)
    angular = _task_size(part) - linear
    yield [linear + min(angular, 1), chain.n]
    yield [min(linear, 1) + angular, chain.n]
    yield [min(linear, 1) + min(angular, 1), chain.n]


_TYPES = {"boundary", "internal"}

MISTAKES = (
    Mistake("boundary-and-internal", "Boundary and internal confused",
            "Boundary and internal singularities seem to be confused: is the point at the edge of what it can reach, "
            "or inside?", "below 6.7",
            answers=_combine(
                _confuse_meanings("singularity-type", OPTIONS, {("boundary", "internal"), ("internal", "boundary")}),
                _choose_statement(is_same_meaning=True),
            )),
    Mistake("singular-taken-for-regular", "A singular configuration taken for a regular one",
            "The configuration seems to be taken for a regular one. Put its values into det J, or look at the rank.",
            "6.8",
            answers=_combine(
                    _confuse_meanings("singularity-type", OPTIONS, {(kind, "regular") for kind in _TYPES}),
                    _confuse_meanings("invertibility", USES, {("singular", "regular")}),
                )),
    Mistake("regular-taken-for-singular", "A regular configuration taken for a singular one",
            "The configuration seems to be taken for a singular one. Put its values into det J, or look at the rank.",
            "6.8",
            answers=_combine(
                    _confuse_meanings("singularity-type", OPTIONS, {("regular", kind) for kind in _TYPES}),
                    _confuse_meanings("invertibility", USES, {("regular", "singular")}),
                )),
    Mistake("shape-of-jacobian", "Shape of J not looked at",
            "Count the rows and the columns of J first: only a square matrix can have an inverse.", "6.7",
            answers=_confuse_meanings(
                    "invertibility", USES,
                    {(a, b) for a in USES for b in USES if a != b} - {("singular", "regular"), ("regular", "singular")},
                )),
    Mistake("other-meaning", "Another meaning of a singularity",
            "That is not what the arm looks like there. Draw it with these joint values.", "below 6.7",
            answers=_choose_statement(is_same_meaning=False)),
    Mistake("direction-not-lost", "A direction that is not lost",
            "Along that line the arm can still move. Look for the direction that no column of J has a part along.",
            "6.8", answers=_choose("lost-motion", lambda *_: True)),
    Mistake("reachable-and-not", "What can be produced and what can't confused",
            "A velocity can be produced where it has no part along the lost direction. Look at the scalar products.",
            "6.8", answers=_choose("unreachable-velocity", lambda *_: True)),
    Mistake("motion-turned-round", "Motion of a joint in the other sense",
            "The component seems to have the other sign: a positive rate turns counterclockwise as seen from the tip "
            "of the axis, or slides along it.", "6.12"),
    Mistake("joint-without-effect", "A joint that changes nothing there",
            "A change of {joint} alone, with all other joints at rest, changes nothing there.", "6.4"),
    Mistake("column-of-other-joint", "Column of another joint",
            "A column seems to be given to another joint: it is what a unit rate of its own joint gives, while all "
            "others rest.", "6.12"),
    Mistake("size-transposed", "Rows and columns exchanged",
            "Rows and columns of J seem to be exchanged: it has a row for each component of velocity and a column for "
            "each joint.", "6.4",
            answers=_give_numbers("jacobian-size", lambda chain, part: [[chain.n, _task_size(part)]])),
    Mistake("size-of-own-task", "Size for another task",
            "The rows seem to be counted for another task than the one that is asked about.", "6.6",
            answers=_give_numbers("jacobian-size", lambda chain, _: [[len(chain.task), chain.n]])),
    Mistake("size-six-rows", "Six rows whatever the task",
            "J seems to be given all six rows: it has one for each component of velocity that counts.", "6.6",
            answers=_give_numbers("jacobian-size", lambda chain, _: [[6, chain.n]])),
    Mistake("size-square", "J taken for square",
            "J seems to be taken for square: it has a row for each component of velocity and a column for each joint.",
            "6.4",
            answers=_give_numbers(
                    "jacobian-size", lambda chain, part: [[size, size] for size in (chain.n, _task_size(part))]
                ), rare=True),
    Mistake("rank-full", "Full rank given",
            "The rank seems to be that of a regular configuration. Are the columns independent here?", "6.8",
            answers=_give_numbers("rank", lambda chain, _: [[_full_rank(chain)]])),
    Mistake("rank-of-shape", "Number of rows or columns for the rank",
            "The rank seems to be counted from the size of J: it is at most the smaller of the two, and less where J "
            "is singular.", "6.8", answers=_give_numbers("rank", lambda chain, _: [[chain.n], [len(chain.task)]])),
    Mistake("rank-less", "Rank of a singular configuration given",
            "The configuration seems to be taken for a singular one. Are the columns dependent here?", "6.8",
            answers=_give_numbers(
                    "rank", lambda chain, part: [[_rank(part) - 1]] if _rank(part) == _full_rank(chain) else []
                )),
    Mistake("rank-of-one-condition", "Only one of several conditions counted",
            "One seems to be taken off the full rank. Does more than one condition hold in this configuration?", "6.8",
            answers=_give_numbers(
                    "rank", lambda chain, part: [[_full_rank(chain) - 1]] if _rank(part) < _full_rank(chain) - 1 else []
                ), rare=True),
    Mistake("rank-zero", "Rank zero where the determinant is",
            "A determinant that is zero says only that the rank is less than full: count the independent columns.",
            "6.8", answers=_give_numbers("rank", lambda chain, part: [[0]]), rare=True),
    Mistake("size-of-kinds", "Orientation counted as one component",
            "Position or orientation seems to be counted as one component: J has a row for each component that "
            "counts.", "6.6", answers=_give_numbers("jacobian-size", _count_kinds), rare=True),
)  # fmt: skip
