"""Mistakes behind wrong options, and behind counts: the size of J, its rank."""

from collections.abc import Callable, Iterator, Mapping
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


def _choose_option(part: Part, index: int, **words: object) -> MistakenAnswer:
    answer = part.of(Choice)
    return MistakenAnswer(replace(answer, correct=index), words)


def _confuse_meanings(kind: str, texts: Mapping[str, str], pairs: set[tuple[str, str]]) -> Answers:
    """Return the mistaken answers that take one meaning for another; `pairs` are (right, chosen)."""

    def takes(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind != kind or not isinstance(part.answer, Choice):
            return
        names = {text: name for name, text in texts.items()}
        right = names[part.answer.options[part.answer.correct]]
        for index, option in enumerate(part.answer.options):
            if (right, names[option]) in pairs:
                yield _choose_option(part, index)

    return takes


def _combine(*all_answers: Answers) -> Answers:
    def takes(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        for some in all_answers:
            yield from some(chain, part)

    return takes


_TYPES = {"boundary", "internal"}


def _choose_other_kind(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Choose the right meaning with the wrong kind."""
    if part.kind != "singularity-meaning":
        return
    offered = part.about(OfMeaning).asked.offered
    meaning, kind = offered[_right_index(part)]
    for index, (offered_meaning, its_kind) in enumerate(offered):
        if offered_meaning is meaning and its_kind != kind:
            yield _choose_option(part, index)


def _choose_other_meaning(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    if part.kind != "singularity-meaning":
        return
    offered = part.about(OfMeaning).asked.offered
    for index, (offered_meaning, _) in enumerate(offered):
        if offered_meaning is not offered[_right_index(part)][0]:
            yield _choose_option(part, index)


def _right_index(part: Part) -> int:
    answer = part.of(Choice)
    return answer.correct


def _choose_any_wrong(kind: str) -> Answers:
    def takes(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == kind and isinstance(part.answer, Choice):
            for index in range(len(part.answer.options)):
                if index != part.answer.correct:
                    yield _choose_option(part, index)

    return takes


def _give_numbers(kind: str, value: Callable[[Chain, Part], Iterator[list[int]]]) -> Answers:
    def takes(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if part.kind == kind and isinstance(part.answer, Number):
            right = list(part.answer.reference)
            for taken_for in value(chain, part):
                if taken_for != right:
                    yield MistakenAnswer(replace(part.answer, reference=sp.Matrix(taken_for)))

    return takes


def _transpose_size(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [chain.n, _task_size(part)]


def _task_size(part: Part) -> int:
    return len(part.about(ForTask).task)


def _give_six_rows(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [6, chain.n]


def _give_square_size(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [chain.n, chain.n]
    yield [_task_size(part), _task_size(part)]


def _use_arm_task(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [len(chain.task), chain.n]


def _give_full_rank(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [min(len(chain.task), chain.n)]


def _give_shape_as_rank(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [chain.n]
    yield [len(chain.task)]


def _give_lower_rank(chain: Chain, part: Part) -> Iterator[list[int]]:
    answer = part.of(Number)
    right = int(answer.reference[0])
    if right == min(len(chain.task), chain.n):
        yield [right - 1]


def _count_one_condition(chain: Chain, part: Part) -> Iterator[list[int]]:
    full = min(len(chain.task), chain.n)
    if int(part.of(Number).reference[0]) < full - 1:
        yield [full - 1]


def _give_zero(chain: Chain, part: Part) -> Iterator[list[int]]:
    yield [0]


def _count_kinds(chain: Chain, part: Part) -> Iterator[list[int]]:
    """Count the orientation as one component, or the position."""
    task = part.about(ForTask).task
    linear = sum(row[0] == "v" for row in task)
    angular = len(task) - linear
    yield [linear + min(angular, 1), chain.n]
    yield [min(linear, 1) + angular, chain.n]
    yield [min(linear, 1) + min(angular, 1), chain.n]


MISTAKES = (
    Mistake(
        "boundary-and-internal", "Boundary and internal confused",
        "Boundary and internal singularities seem to be confused: is the point at the edge of what it can reach, or "
        "inside?", "below 6.7",
        takes=_combine(
            _confuse_meanings("singularity-type", OPTIONS, {("boundary", "internal"), ("internal", "boundary")}),
            _choose_other_kind,
        ),
    ),
    Mistake(
        "singular-taken-for-regular", "A singular configuration taken for a regular one",
        "The configuration seems to be taken for a regular one. Put its values into det J, or look at the rank.", "6.8",
        takes=_combine(
            _confuse_meanings("singularity-type", OPTIONS, {(kind, "regular") for kind in _TYPES}),
            _confuse_meanings("invertibility", USES, {("singular", "regular")}),
        ),
    ),
    Mistake(
        "regular-taken-for-singular", "A regular configuration taken for a singular one",
        "The configuration seems to be taken for a singular one. Put its values into det J, or look at the rank.",
        "6.8", takes=_combine(
            _confuse_meanings("singularity-type", OPTIONS, {("regular", kind) for kind in _TYPES}),
            _confuse_meanings("invertibility", USES, {("regular", "singular")}),
        ),
    ),
    Mistake(
        "shape-of-jacobian", "Shape of J not looked at",
        "Count the rows and the columns of J first: only a square matrix can have an inverse.", "6.7",
        takes=_confuse_meanings(
            "invertibility", USES,
            {(a, b) for a in USES for b in USES if a != b} - {("singular", "regular"), ("regular", "singular")},
        ),
    ),
    Mistake(
        "other-meaning", "Another meaning of a singularity",
        "That is not what the arm looks like there. Draw it with these joint values.", "below 6.7",
        takes=_choose_other_meaning,
    ),
    Mistake(
        "direction-not-lost", "A direction that is not lost",
        "Along that line the arm can still move. Look for the direction that no column of J has a part along.", "6.8",
        takes=_choose_any_wrong("lost-motion"),
    ),
    Mistake(
        "reachable-and-not", "What can be produced and what can't confused",
        "A velocity can be produced where it has no part along the lost direction. Look at the scalar products.", "6.8",
        takes=_choose_any_wrong("unreachable-velocity"),
    ),
    Mistake(
        "motion-turned-round", "Motion of a joint in the other sense",
        "The component seems to have the other sign: a positive rate turns counterclockwise as seen from the tip of "
        "the axis, or slides along it.", "6.12",
    ),
    Mistake(
        "joint-without-effect", "A joint that changes nothing there",
        "A change of {joint} alone, with all other joints at rest, changes nothing there.", "6.4",
    ),
    Mistake(
        "column-of-other-joint", "Column of another joint",
        "A column seems to be given to another joint: it is what a unit rate of its own joint gives, while all others "
        "rest.", "6.12",
    ),
    Mistake(
        "size-transposed", "Rows and columns exchanged",
        "Rows and columns of J seem to be exchanged: it has a row for each component of velocity and a column for each "
        "joint.", "6.4", takes=_give_numbers("jacobian-size", _transpose_size),
    ),
    Mistake(
        "size-of-own-task", "Size for another task",
        "The rows seem to be counted for another task than the one that is asked about.", "6.6",
        takes=_give_numbers("jacobian-size", _use_arm_task),
    ),
    Mistake(
        "size-six-rows", "Six rows whatever the task",
        "J seems to be given all six rows: it has one for each component of velocity that counts.", "6.6",
        takes=_give_numbers("jacobian-size", _give_six_rows),
    ),
    Mistake(
        "size-square", "J taken for square",
        "J seems to be taken for square: it has a row for each component of velocity and a column for each joint.",
        "6.4", takes=_give_numbers("jacobian-size", _give_square_size), rare=True,
    ),
    Mistake(
        "rank-full", "Full rank given",
        "The rank seems to be that of a regular configuration. Are the columns independent here?", "6.8",
        takes=_give_numbers("rank", _give_full_rank),
    ),
    Mistake(
        "rank-of-shape", "Number of rows or columns for the rank",
        "The rank seems to be counted from the size of J: it is at most the smaller of the two, and less where J is "
        "singular.", "6.8", takes=_give_numbers("rank", _give_shape_as_rank),
    ),
    Mistake(
        "rank-less", "Rank of a singular configuration given",
        "The configuration seems to be taken for a singular one. Are the columns dependent here?", "6.8",
        takes=_give_numbers("rank", _give_lower_rank),
    ),
    Mistake(
        "rank-of-one-condition", "Only one of several conditions counted",
        "One seems to be taken off the full rank. Does more than one condition hold in this configuration?", "6.8",
        takes=_give_numbers("rank", _count_one_condition), rare=True,
    ),
    Mistake(
        "rank-zero", "Rank zero where the determinant is",
        "A determinant that is zero says only that the rank is less than full: count the independent columns.", "6.8",
        takes=_give_numbers("rank", _give_zero), rare=True,
    ),
    Mistake(
        "size-of-kinds", "Orientation counted as one component",
        "Position or orientation seems to be counted as one component: J has a row for each component that counts.",
        "6.6", takes=_give_numbers("jacobian-size", _count_kinds), rare=True,
    ),
)  # fmt: skip
