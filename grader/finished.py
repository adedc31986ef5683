"""Slips in the finished formulas of an answer: one place in an entry, or the same everywhere (mistakes.finished).

Where single entries are meant, they are named: the rest of the answer is right.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import islice
from typing import Literal

import numpy as np

from exercises.formula.algebra import Matrix as Rows
from exercises.formula.program import evaluate_each
from exercises.formula.trees import Node, size_of
from exercises.mistakes.catalogue import CATALOGUE
from exercises.mistakes.finished import LONGEST, Edit, edits, throughout, waves_in
from exercises.mistakes.given import Values
from grader.numbers import SAME, InNumbers, says_something
from grader.verdict import Diagnosis

MOST_ENTRIES = 6
"""Wrong entries in which single slips are looked for."""
MOST_NODES = 40_000
"""Nodes of all changed formulas that are evaluated for an answer."""

MOST_EDITS = 600
"""Slips that are tried in an entry."""
MOST_WAVES = 24
"""Sines and cosines of an entry whose angle may be wrong by any constant."""
POINTS_FOR_CONSTANT = 4

LEAST_PAIRED = 20
"""Nodes of an entry in which two slips are looked for: of a shorter one, two leave too little to tell them by."""
MOST_PAIRED = 400
"""Slips in an entry of which two are tried together."""

Place = tuple[int, int]

How = Literal["one", "pairs", "any constant"]


def finished(rows: Rows, values: Values, found: InNumbers, right: np.ndarray, how: How = "one") -> Diagnosis | None:
    """Return what went wrong in the finished formulas; `rows` are the reference's, in the shape of `right`.

    By `how`, one slip in an entry is looked for, or two as well, or an angle that is wrong by any constant.
    """
    wrong = ~found.like(right)
    places = [(int(i), int(j)) for i, j in np.argwhere(wrong)]
    if not places or np.isnan(found.values).any() or found.values.shape != right.shape:
        return None
    alone = wrong.size == 1
    if len(places) == 1 and not alone:
        return in_places(rows, values, found, places, how)
    return (
        _exchanged(found, right, places)
        or _everywhere(rows, values, found)
        or (in_places(rows, values, found, places, how) if len(places) <= MOST_ENTRIES else None)
    )


def in_words(places: Sequence[Place], shape: tuple[int, ...]) -> str:
    """Return where entries stand, to begin a sentence.

    >>> in_words([(0, 1), (1, 1)], (2, 2))
    'In row 1, column 2, and row 2, column 2,'
    >>> in_words([(1, 0)], (3, 1)), in_words([(0, 0)], (1, 1))
    ('In entry 2', 'In your answer')
    """
    if shape[:2] == (1, 1):
        return "In your answer"
    if 1 in shape[:2]:
        numbers = [str(max(place) + 1) for place in places]
        return (
            f"In entry {numbers[0]}" if len(numbers) == 1 else f"In entries {', '.join(numbers[:-1])} and {numbers[-1]}"
        )
    said = [f"row {i + 1}, column {j + 1}" for i, j in places]
    return f"In {said[0]}," if len(said) == 1 else f"In {', '.join(said[:-1])}, and {said[-1]},"


def _exchanged(found: InNumbers, right: np.ndarray, places: Sequence[Place]) -> Diagnosis | None:
    if len(places) != 2:
        return None
    swapped = right.copy()
    one, other = places
    swapped[one], swapped[other] = right[other], right[one]
    return _said("entries-exchanged", places, right.shape) if found.is_all(swapped) else None


def _everywhere(rows: Rows, values: Values, found: InNumbers) -> Diagnosis | None:
    room = MOST_NODES
    size = sum(size_of(entry) for row in rows for entry in row)
    for name, changed in throughout(rows):
        room -= size
        if room < 0:
            return None
        answer = _evaluated([entry for row in changed for entry in row], values).reshape(found.values.shape)
        if found.is_all(answer) and says_something(answer):
            return Diagnosis((name,), CATALOGUE[name].sentence({"Where": "In your answer"}))
    return None


def in_places(
    rows: Rows, values: Values, found: InNumbers, places: Sequence[Place], how: How = "one"
) -> Diagnosis | None:
    """Return the one kind of slip that was made in each of some entries, or up to two kinds."""
    made: dict[Slip, list[Place]] = {}
    for place in places:
        slips = _slips(rows[place[0]][place[1]], values, found.entry(*place), found.values[..., 0].size > 3, how)
        if slips is None:
            return None
        for slip in slips:
            made.setdefault(slip, []).append(place)
    names = tuple(dict.fromkeys(name for name, _ in made))
    if len(names) > 2:
        return None
    said = [_said(name, where, found.values.shape, which) for (name, which), where in made.items()]
    known_by = tuple(name for one in said for name in one.known_by)
    return Diagnosis(names, " ".join(one.says for one in said), known_by=known_by)


Slip = tuple[str, str]
"""The name of a mistake, and which term or factor is missing, in words."""


def _slips(entry: Node, values: Values, found: InNumbers, beside_others: bool, how: How) -> tuple[Slip, ...] | None:
    """Return the slip that gives an entry, or two; a constant says something `beside_others` only that are right."""
    changed = list(_affordable(entry, values))
    if not changed or not (says_something(found.values) or (beside_others and found.values.any())):
        return None
    answers = _evaluated([edit.entry for edit in changed] + [entry], values)
    for k in np.flatnonzero(found.like(answers[:-1, None, None])):
        return ((changed[k].mistake, changed[k].which),)
    if how == "any constant":
        return (("angle-typed", ""),) if _by_a_constant(entry, values, found) else None
    if how == "one" or size_of(entry) < LEAST_PAIRED:
        return None
    return _two(changed, answers[:-1], answers[-1], found)


def _by_a_constant(entry: Node, values: Values, found: InNumbers) -> bool:
    """Tell whether one angle is wrong by a constant, whatever that is.

    With w and w' a sine or cosine and what is a quarter turn on, the entry is A + B (w cos c + w' sin c): c follows.
    """
    gone = list(islice(waves_in(entry), MOST_WAVES)) if size_of(entry) <= LONGEST else []
    if not gone or found.values.shape[-1] < POINTS_FOR_CONSTANT:
        return False
    probes = _evaluated([entry, *(tree for one in gone for tree in (one.without, one.on))], values)
    mine = found.values[0, 0]
    for k, one in enumerate(gone):
        without, on = probes[2 * k + 1], probes[2 * k + 2]
        slopes = np.stack([probes[0] - without, on - without], axis=1)
        if not (np.isfinite(slopes).all() and np.isfinite(without).all()):
            continue
        (c, s), *_ = np.linalg.lstsq(slopes.real, (mine - without).real, rcond=None)
        if abs(c * c + s * s - 1) > 1e-6:
            continue
        more = Node("decimal", value=Fraction(float(np.arctan2(s, c))))
        if found.is_all(_evaluated([one.turned(more)], values)[None]):
            return True
    return False


def _two(made: Sequence[Edit], answers: np.ndarray, right: np.ndarray, found: InNumbers) -> tuple[Slip, ...] | None:
    """Return two slips in different terms, whose differences add up, or in different factors, whose ratios multiply."""
    mine = found.values[0, 0]
    with np.errstate(all="ignore"):
        changed = np.isfinite(answers).all(axis=1) & (np.abs(answers - right) > SAME * np.abs(right)).any(axis=1)
        indices = np.flatnonzero(changed)[:MOST_PAIRED]
        some = answers[indices]
        sums = some[:, None] + some[None] - right
        products = some[:, None] * some[None] / right
        for together in (sums, products):
            near = np.abs(together - mine) <= SAME * (np.abs(some).max(axis=0) + np.abs(mine))
            for one, other in np.argwhere(near.all(axis=-1)):
                if one < other:
                    both = (made[indices[one]], made[indices[other]])
                    return tuple(dict.fromkeys((edit.mistake, edit.which) for edit in both))
    return None


def _affordable(entry: Node, values: Values) -> Iterator[Edit]:
    return islice(edits(entry, values), MOST_EDITS)


def _evaluated(entries: Sequence[Node], values: Values) -> np.ndarray:
    """Return values, (entries, N); nan where one can't be had."""
    return evaluate_each(entries, values, len(next(iter(values.values()))))


def _said(name: str, places: Sequence[Place], shape: tuple[int, ...], which: str = "") -> Diagnosis:
    where = in_words(places, shape)
    return Diagnosis((name,), CATALOGUE[name].sentence({"Where": where, "which": which}), known_by=(f"{name} {where}",))
