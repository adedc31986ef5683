"""Two mistakes behind a wrong answer, or one that was made in a part of it only.

Both are told where together they give the very same answer. Of numbers to a few digits, which many pairs could meet by
chance, so many are tried that one in a hundred answers at most is met by any.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from exercises.arm.stages import RESULT, Working
from exercises.formula.algebra import Matrix as Rows
from exercises.mistakes.catalogue import (
    CATALOGUE,
    ON_THE_WAY,
    READING,
    Wrong,
    fingerprint,
    late_mistakes,
    late_slips,
    made,
    prior,
)
from exercises.mistakes.given import Values
from exercises.problem import Part
from exercises.questions.results import result
from grader.finished import in_places, in_words
from grader.numbers import InNumbers, says_something
from grader.verdict import Diagnosis, known_by

BY_CHANCE = 0.01
"""Share of wrong answers that may be met by chance by one of the pairs that are tried."""
MOST_READ_TWICE = 700
"""Pairs of what was misread that are tried."""
MOST_BESIDE = 3
"""Wrong entries that slips in the finished formulas may explain beside another mistake."""


def said(wrongs: Sequence[Wrong], where: Sequence[str] = (), either: bool = False) -> Diagnosis:
    """Return what is said of one mistake or two, each with the entries `where` it was made, if only there."""
    places = where or [""] * len(wrongs)
    sentences = dict.fromkeys(
        f"{place}, and only there, the answer is what this gives: {_sentence(wrong)}" if place else _sentence(wrong)
        for wrong, place in zip(wrongs, places, strict=True)
    )
    first = wrongs[0]
    cause = (first.mistake.name, dict(first.slip.words)) if len(wrongs) == 1 and not where else None
    names = tuple(dict.fromkeys(wrong.mistake.name for wrong in wrongs))
    says = " Or, which gives the same answer: ".join(sentences) if either else " ".join(sentences)
    made = tuple(
        f"{known_by(wrong.mistake.name, wrong.slip.words)}{place}" for wrong, place in zip(wrongs, places, strict=True)
    )
    return Diagnosis(names, says, cause, known_by=made, either=either and len(names) > 1)


def _sentence(wrong: Wrong) -> str:
    missing = wrong.slip.missing
    return f"{wrong.sentence} What is missing has {missing} in it." if missing else wrong.sentence


# --- two in the whole answer ---


def two(w: Working, right: np.ndarray, alone: Sequence[Wrong], part: Part, found: InNumbers) -> Diagnosis | None:
    """Return one mistake on the way to J and one behind it, which give the answer together.

    Of first mistakes that come to the same, or to what is right, one is tried: the others have the same second ones.
    """
    firsts = sorted((one for one in alone if one.mistake.name in ON_THE_WAY), key=_rarity)
    return _one_after_another(w, right, firsts, part, found)


def _rarity(wrong: Wrong) -> float:
    return -prior(wrong)


def misread_and_more(
    w: Working, right: np.ndarray, alone: Sequence[Wrong], part: Part, found: InNumbers
) -> Diagnosis | None:
    """Return what was misread in the table, and a mistake behind J."""
    if right[..., 0].size == 1 and not found.is_precise:  # what was made alone is no whole list here
        read: Iterable[Wrong] = (wrong for name in READING for wrong in made(CATALOGUE[name], w, part))
    else:
        of_name = {name: k for k, name in enumerate(READING)}
        others = [one for one in alone if one.mistake.name not in ON_THE_WAY and "table" in one.slip.changes]
        read = sorted(others, key=lambda one: of_name.get(one.mistake.name, len(of_name)))
    return _one_after_another(w, right, read, part, found)


def _one_after_another(
    w: Working, right: np.ndarray, firsts: Iterable[Wrong], part: Part, found: InNumbers
) -> Diagnosis | None:
    if np.isnan(found.values).any():  # left blank, and like nothing
        return None
    late = late_mistakes(w.chain, part, (right.shape[0], right.shape[1]), found.is_precise)
    single = right[..., 0].size == 1 and not found.is_precise
    if single:  # a factor of a single number may be that of anything
        late = [(mistake, slip) for mistake, slip in late if RESULT not in slip.changes]
    seen = {np.round(right, 9).tobytes() if single else fingerprint(w, right)}
    tries = most_tries(found)
    for first in firsts:
        key = np.round(first.answer, 9).tobytes() if single else fingerprint(first.working, first.answer)
        if key in seen:
            continue
        seen.add(key)
        for second in late_slips(first, part, late):
            tries -= 1
            if tries < 0:
                return None
            if found.is_all(second.answer) and says_something(second.answer):
                return said([first, second])
    return None


def most_tries(found: InNumbers) -> float:
    """Return how many answers may be compared with that found, until chance gives one that is the same."""
    if found.is_precise:
        return float("inf")
    with np.errstate(all="ignore"):
        share = np.minimum(1.0, 2 * (found.room[0] + found.room[1] / np.maximum(np.abs(found.values[..., 0]), 1e-12)))
    return float(BY_CHANCE / max(float(np.prod(share)), 1e-12))


def misread_twice(
    w: Working, right: np.ndarray, alone: Sequence[Wrong], part: Part, found: InNumbers
) -> Diagnosis | None:
    """Return two things that were misread in the table, or one beside a mistake on the way to J."""
    if np.isnan(found.values).any() or not found.is_precise:
        return None
    read, seen = [], {fingerprint(w, right)}
    for name in READING:
        for one in (one for one in alone if one.mistake.name == name):
            if (worked_out := fingerprint(one.working, one.answer)) not in seen:
                seen.add(worked_out)
                read.append(one)
    others = sorted((one for one in alone if one.mistake.name in ON_THE_WAY), key=_rarity)
    pairs = [*combinations(read, 2), *((first, second) for first in read for second in others)]
    for first, second in islice(pairs, MOST_READ_TWICE):
        answer = _together(first, second, part)
        if answer is not None and found.is_all(answer) and says_something(answer):
            return said([first, second])
    return None


def _together(first: Wrong, second: Wrong, part: Part) -> np.ndarray | None:
    try:
        with np.errstate(all="ignore"):
            return result(first.working.but(second.slip.changes), part)
    except IndexError:  # of a joint behind the frame that is asked for
        return None


# --- in some entries ---

Telling = list[tuple[Wrong, np.ndarray]]
"""Mistakes, each with the wrong entries that it gives, (rows, columns)."""


def in_some_entries(alone: Sequence[Wrong], right: np.ndarray, found: InNumbers) -> tuple[Telling, np.ndarray]:
    """Return the mistakes that give some of the wrong entries, with these, and all that are wrong."""
    wrong = ~found.like(right) & ~np.isnan(found.values).any(axis=-1)
    telling: list[tuple[int, Wrong, np.ndarray]] = []
    if found.is_direction or not wrong.any() or wrong.size == 1 or right.shape[-1] == 1:
        return [], wrong
    original = replace(found, values=right)
    for one in alone:
        covered = found.like(one.answer) & wrong
        if covered.any() and (says_something(one.answer[covered]) or _is_column_left_out(one.answer, covered)):
            elsewhere = ~original.like(one.answer) & ~covered
            telling.append((int(elsewhere.sum()), one, covered))
    # What such a mistake would change elsewhere is right here: the fewer, the truer is its name.
    return [(one, covered) for _, one, covered in sorted(telling, key=lambda each: each[0])], wrong


def _is_column_left_out(answer: np.ndarray, covered: np.ndarray) -> bool:
    """Tell whether what is covered is in a column with nothing but zeros, where two entries or more are due."""
    columns = np.flatnonzero(covered.any(axis=0))
    if len(columns) != 1 or covered.shape[1] < 2 or covered.sum() < 2:
        return False
    return bool(np.abs(answer[:, columns[0]]).max() == 0)


def _where(which: np.ndarray) -> str:
    return in_words([(int(i), int(j)) for i, j in np.argwhere(which)], which.shape).rstrip(",")


def one_in_some(telling: Telling, wrong: np.ndarray) -> Diagnosis | None:
    """Return the mistake that gives all wrong entries, and would give more that are right."""
    return next((said([one], [_where(wrong)]) for one, covered in telling if (covered == wrong).all()), None)


def two_in_some(telling: Telling, wrong: np.ndarray, part: Part, found: InNumbers) -> Diagnosis | None:
    """Return two mistakes that give the wrong entries between them, each with its own unless both give the answer."""
    for (one, covered), (other, rest) in combinations(telling, 2):
        if ((covered | rest) == wrong).all() and (covered & ~rest).any() and (rest & ~covered).any():
            answer = _together(one, other, part)
            together = answer is not None and found.is_all(answer)
            return said([one, other], [] if together else [_where(covered), _where(rest & ~covered)])
    return None


def one_beside_slips(
    forms: Iterable[Rows], values: Values, telling: Telling, wrong: np.ndarray, found: InNumbers
) -> Diagnosis | None:
    """Return a mistake that gives most of the wrong entries, and slips in the finished formulas of the others."""
    rows = next((form for form in forms if (len(form), len(form[0])) == wrong.shape), None)
    if rows is None:
        return None
    tried = set[bytes]()
    for one, covered in telling:
        rest = wrong & ~covered
        if not 1 <= rest.sum() <= MOST_BESIDE or rest.tobytes() in tried:
            continue
        tried.add(rest.tobytes())
        slips = in_places(rows, values, found, [(int(i), int(j)) for i, j in np.argwhere(rest)])
        if slips is not None:
            first = said([one], [_where(covered)])
            return Diagnosis((*first.mistakes, *slips.mistakes), f"{first.says} {slips.says}")
    return None


def all_but_one(alone: Sequence[Wrong], right: np.ndarray, found: InNumbers) -> Diagnosis | None:
    """Return the mistake that gives the whole answer but for one entry, several other entries of which are wrong.

    That entry may have the wrong sign besides, or be left out.
    """
    if found.is_direction or np.isnan(found.values).any() or right[..., 0].size < 3 or not found.is_precise:
        return None
    wrong = ~found.like(right)
    fitting: list[tuple[bool, Wrong, np.ndarray, str]] = []
    for one in alone:
        if one.answer.shape != found.values.shape:
            continue
        same = found.like(one.answer)
        covered = same & wrong
        if (~same).sum() != 1 or covered.sum() < 2 or not says_something(one.answer[covered]):
            continue
        mine, its = found.values[~same], one.answer[~same]
        sign = replace(found, values=-its[None], size=np.abs(its)[None]).is_all(mine[None])
        name = "term-sign-typed" if sign else "term-missing" if np.abs(mine).max() == 0 else ""
        fitting.append((not name, one, ~same, name))
    if not fitting:
        return None
    _, one, off, name = min(fitting, key=lambda each: each[0])
    where = _where(off)
    more = CATALOGUE[name].sentence({"Where": where, "which": ""}) if name else "Something else is wrong there."
    says = f"{where.replace('In ', 'But for ', 1)}, the answer is what this gives: {one.sentence} {more}"
    return Diagnosis((one.mistake.name, *([name] if name else [])), says)
