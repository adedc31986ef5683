"""Name the mistake behind a wrong answer: the one of the catalogue that gives the very same answer.

Answers are compared at random configurations, or at the one that is given. First each mistake by itself, then two
together (one on the way to J, one behind it), then mistakes that were made in some entries only. What gives none of
these is not guessed at.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from exercises.arm.stages import Working, numbers
from exercises.formula.algebra import Matrix as Rows
from exercises.formula.expression import read
from exercises.formula.program import compile_program, evaluate
from exercises.formula.trees import Node, ReadError, as_matrix, digits_of_decimals
from exercises.mistakes.catalogue import (
    CATALOGUE,
    ON_THE_WAY,
    Wrong,
    fingerprint,
    late_mistakes,
    late_slips,
    taken,
    wrong_answers,
)
from exercises.mistakes.given import Values, configurations
from exercises.problem import Part, Problem
from exercises.questions.concepts import option_numbers
from exercises.questions.results import is_derived, result
from exercises.quizzes.options import blames_of
from exercises.stream import Stream
from exercises.writing.statement import answer_code
from grader.answer import Given
from grader.finished import finished, in_words
from grader.function_values import Table
from grader.numbers import SAME, InNumbers, says_something, unit
from grader.parts import judge_given
from grader.residuals import missing_links
from grader.verdict import Diagnosis, Outcome

POINTS = 5
THREE_DECIMALS = 6e-4
IF_NOTHING_PLAINER = frozenset({"cross-order", "arm-reversed"})
"""Mistakes that are told where no other gives the same: mostly a wrong sign throughout does."""
LONGEST_SET = 600
"""Characters of a set that is compared with what mistakes make of the right one; each comparison takes its time."""


@dataclass(frozen=True)
class Cause:
    """A mistake that was found in an earlier part: its name, its words, and the part with its title."""

    mistake: str
    words: Mapping[str, object]
    part: str
    title: str


def diagnose(
    problem: Problem, part: Part, given: Given, seed: str = "", causes: Sequence[Cause] = ()
) -> Diagnosis | None:
    """Return the mistake that gives a wrong answer, or nothing where none in the catalogue does.

    One of the `causes` that were found in earlier parts is told as that. `seed` draws the configurations at which the
    answer is compared with what mistakes give.

    >>> from exercises import generate
    >>> from grader import read_answer
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> (part,) = problem.parts
    >>> diagnose(problem, part, read_answer(problem, part, "d2 + 0.7")).mistakes
    ('determinant-sign',)
    """
    if given.table is not None:
        return _of_function(problem, part, given.table, causes)
    offered = _behind_options(part, given)
    if offered is not None:
        return offered
    for mistake, slip in taken(problem.chain, part) if len(given.text) <= LONGEST_SET else ():
        if judge_given(problem, replace(part, answer=slip.answer), given, seed).outcome is Outcome.CORRECT:
            made = known_by(mistake.name, slip.words)
            return Diagnosis((mistake.name,), mistake.sentence(slip.words), known_by=(made,))
    if not is_derived(part):
        return None
    values = configurations(problem.chain, part, problem.domain(), POINTS, Stream(f"{seed}/diagnosis"))
    try:
        in_numbers = _in_numbers(part, given, values)
    except ReadError:  # statements among the entries of an answer that was refused
        return None
    return None if in_numbers is None else named(problem, part, values, in_numbers, causes)


def _of_function(problem: Problem, part: Part, table: Table, causes: Sequence[Cause]) -> Diagnosis | None:
    if table.shape is None or not is_derived(part) or len(table.shape) > 2:
        return None
    values = {name: column[:POINTS] for name, column in table.at.items()}
    rows = (*table.shape, *(1,) * (2 - len(table.shape)))
    returned = table.values[:POINTS].T.reshape(*rows, -1)
    room = (max(SAME, part.rounding.relative), part.rounding.absolute) if part.rounding else (SAME, 0.0)
    answer = InNumbers(returned, np.abs(returned), room, part.answer.counts_up_to_a_factor)
    return named(problem, part, values, answer, causes)


def _in_numbers(part: Part, given: Given, values: Values) -> InNumbers | None:
    if part.answer.offered:
        return _option(part, given)
    if given.rows is None:
        return None
    rows, entries, blanks = given.rows, given.entries, given.blanks
    if all(blanks) or given.symbols - set(values):
        return None
    filled = [Node("name", value="pi") if blank else entry for entry, blank in zip(entries, blanks, strict=True)]
    count = len(next(iter(values.values())))
    evaluated, size = evaluate(compile_program(filled), values, count)
    evaluated[blanks] = np.nan
    shape = (len(rows), len(rows[0]), count)
    return InNumbers(
        evaluated.reshape(shape), size.reshape(shape), _room(part, filled), part.answer.counts_up_to_a_factor
    )


def _room(part: Part, entries: Sequence[Node]) -> tuple[float, float]:
    """Return what an answer may be off: what is asked for in digits, or what was typed where that is more."""
    relative, absolute = (0.0, 0.0) if part.rounding is None else (part.rounding.relative, part.rounding.absolute)
    if not part.answer.is_in_numbers:
        return max(SAME, relative), absolute
    digits = max(map(digits_of_decimals, entries))
    return max(min(relative or 5e-3, 0.6 * 10.0 ** (1 - max(digits, 3))), 1e-5), 0.0


def _option(part: Part, given: Given) -> InNumbers | None:
    if not given.chosen:
        return None
    values = np.array(option_numbers(part.answer.offered[given.chosen[0]]))[:, None, None]
    return InNumbers(values, np.abs(values), (0.0, THREE_DECIMALS))


def _behind_options(part: Part, given: Given) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, as they were kept when it was made."""
    for index in given.chosen:
        blames = [] if index in part.answer.right else blames_of(part, index)
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


def named(
    problem: Problem, part: Part, values: Values, found: InNumbers, causes: Sequence[Cause] = ()
) -> Diagnosis | None:
    """Return the mistake that gives values at configurations, or nothing.

    Of several that do, one that was found in an earlier part is the cause here, too; else the likeliest is told.
    """
    w = numbers(problem.chain, values)
    right = result(w, part)
    if 1 in right.shape[:2] and found.values.shape == right.swapaxes(0, 1).shape != right.shape:
        found = replace(found, values=found.values.swapaxes(0, 1), size=found.size.swapaxes(0, 1))
    if found.is_direction and _moves(right, found.values):
        mistake = CATALOGUE["direction-that-moves"]
        return Diagnosis((mistake.name,), mistake.sentence({}))
    alone, fitting = [], []
    for wrong in wrong_answers(w, part, found.is_precise):
        if wrong.answer.shape == found.values.shape:
            alone.append(wrong)
            if found.is_all(wrong.answer) and says_something(wrong.answer):
                fitting.append(wrong)
                if not causes and wrong.mistake.name not in IF_NOTHING_PLAINER:
                    break
    if fitting:
        plainest = min(fitting, key=lambda one: one.mistake.name in IF_NOTHING_PLAINER)
        here = _said([plainest])
        return next((_inherited(one, causes, here) for one in fitting if _cause(one, causes)), here)
    if found.values.shape != right.shape:
        return None
    if right[..., 0].size == 1 and part.type == "number":
        return _two(w, right, alone, part, found) if found.is_precise else None
    telling, off = _in_some_entries(alone, right, found)
    return (
        (None if found.is_direction else missing_links(w, part, right, found.values))
        or (None if found.is_direction else _finished(problem, part, values, found, right, pairs=False))
        or _two(w, right, alone, part, found)
        or (None if found.is_direction else _finished(problem, part, values, found, right, pairs=True))
        or _one_in_some(telling, off)
        or _two_in_some(telling, off)
    )


def _moves(lost: np.ndarray, found: np.ndarray) -> bool:
    """Tell whether a direction is one in which the arm can move: it has no part along the one that is lost."""
    if lost.shape != found.shape or lost.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        along = np.abs((unit(lost) * unit(found)).sum(axis=0))
    return bool(np.isfinite(along).all() and (along < 1e-3).all())


def _finished(
    problem: Problem, part: Part, values: Values, found: InNumbers, right: np.ndarray, pairs: bool
) -> Diagnosis | None:
    """Return what went wrong in the finished formulas, as worked solutions show them or as they are compared."""
    if part.answer.is_in_numbers or not part.answer.entries() or part.type == "number":
        return None
    for form in (_as_shown(problem, part), part.answer.trees(problem.domain().roles)):
        for rows in () if form is None else (form, [list(column) for column in zip(*form, strict=True)]):
            if (len(rows), len(rows[0])) == right.shape[:2]:
                diagnosis = finished(rows, values, found, right, pairs)
                if diagnosis is not None:
                    return diagnosis
                break
    return None


def _as_shown(problem: Problem, part: Part) -> Rows | None:
    """Return the reference with the angles of the worked solution, as trees."""
    tree = read(answer_code(problem, part), problem.domain().roles)
    return as_matrix(tree)


def _cause(wrong: Wrong, causes: Sequence[Cause]) -> Cause | None:
    return next((c for c in causes if (c.mistake, c.words) == (wrong.mistake.name, dict(wrong.slip.words))), None)


def _inherited(wrong: Wrong, causes: Sequence[Cause], here: Diagnosis) -> Diagnosis:
    """Return what is said of a mistake that was found before; `here` is what would be said without that."""
    cause = _cause(wrong, causes)
    assert cause is not None
    says = f"This follows from what went wrong in {cause.title!r}: the same mistake gives this answer."
    return Diagnosis((), says, inherited=cause.part, known_by=here.known_by)


def _said(wrongs: Sequence[Wrong], where: str = "") -> Diagnosis:
    sentences = dict.fromkeys(wrong.sentence for wrong in wrongs)
    says = " ".join(
        f"{where}, and only there, the answer is what this gives: {sentence}" if where else sentence
        for sentence in sentences
    )
    first = wrongs[0]
    cause = (first.mistake.name, dict(first.slip.words)) if len(wrongs) == 1 and not where else None
    made = tuple(f"{known_by(wrong.mistake.name, wrong.slip.words)}{where}" for wrong in wrongs)
    return Diagnosis(tuple(dict.fromkeys(wrong.mistake.name for wrong in wrongs)), says, cause, known_by=made)


OWN_NUMBERS = ("degrees",)
"""Words of a sentence that are numbers of the student's own arm, and don't say which mistake it is."""


def known_by(mistake: str, words: Mapping[str, object]) -> str:
    """Return a mistake with where it was made, the same for all arms on which it is made there.

    >>> known_by("offset-sign", {"joint": 2, "degrees": "45°"})
    'offset-sign joint=2'
    """
    said = [f"{name}={value}" for name, value in sorted(words.items()) if name not in OWN_NUMBERS]
    return " ".join([mistake, *said])


# --- two at once ---


def _two(w: Working, right: np.ndarray, alone: Sequence[Wrong], part: Part, found: InNumbers) -> Diagnosis | None:
    """Return one mistake on the way to J and one behind it, which give the answer together.

    Of first mistakes that come to the same, or to what is right, one is tried: the others have the same second ones.
    """
    if part.type == "number" and not found.is_precise:  # three digits are too few to tell so many apart
        return None
    if np.isnan(found.values).any():  # left blank, and like nothing
        return None
    late, seen = (
        late_mistakes(w.chain, part, (right.shape[0], right.shape[1]), found.is_precise),
        {fingerprint(w, right)},
    )
    for first in alone:
        if first.mistake.name in ON_THE_WAY and (made := fingerprint(first.working, first.answer)) not in seen:
            seen.add(made)
            for second in late_slips(first, part, late):
                if found.is_all(second.answer) and says_something(second.answer):
                    return _said([first, second])
    return None


# --- in some entries ---


_Telling = list[tuple[Wrong, np.ndarray]]


def _in_some_entries(alone: Sequence[Wrong], right: np.ndarray, found: InNumbers) -> tuple[_Telling, np.ndarray]:
    """Return the mistakes that give some of the wrong entries, with these, and all that are wrong."""
    wrong = ~found.like(right) & ~np.isnan(found.values).any(axis=-1)
    telling: list[tuple[int, Wrong, np.ndarray]] = []
    if found.is_direction or not wrong.any() or wrong.size == 1 or right.shape[-1] == 1:
        return [], wrong
    original = replace(found, values=right)
    for one in alone:
        covered = found.like(one.answer) & wrong
        if covered.any() and says_something(one.answer[covered]):
            elsewhere = ~original.like(one.answer) & ~covered
            telling.append((int(elsewhere.sum()), one, covered))
    # What such a mistake would change elsewhere is right here: the fewer, the truer is its name.
    return [(one, covered) for _, one, covered in sorted(telling, key=lambda each: each[0])], wrong


def _one_in_some(telling: _Telling, wrong: np.ndarray) -> Diagnosis | None:
    places = [(int(i), int(j)) for i, j in np.argwhere(wrong)]
    where = in_words(places, wrong.shape).rstrip(",")
    return next((_said([one], where) for one, covered in telling if (covered == wrong).all()), None)


def _two_in_some(telling: _Telling, wrong: np.ndarray) -> Diagnosis | None:
    for (one, covered), (other, rest) in combinations(telling, 2):
        if ((covered | rest) == wrong).all() and (covered & ~rest).any() and (rest & ~covered).any():
            return _said([one, other])
    return None
