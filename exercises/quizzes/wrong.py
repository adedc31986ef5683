"""Wrong options that nobody could tell from the right one by their looks, made by the mistakes of the catalogue.

Two mistakes give three wrong options: with the first made, with the second, with both. In such a set of four every
feature is there twice, so that the right option is not the one that has most in common with the others. How long it is
beside the others is drawn.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, islice

import numpy as np
import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import domain_of
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working, as_formulas, formulas, numbers
from qdot.exercises.arm.trigonometry import factor_trig, textbook
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.identity import READABLE, Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.mistakes import screws
from qdot.exercises.mistakes.catalogue import Wrong, wrong_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import result
from qdot.exercises.quizzes.options import MOST_SPREAD, SHOWS_ITSELF, SPREAD, Blame, Offered, rank_of_key

POINTS = 5
APART = 1e-6
"""Share of the size of two answers by which they differ somewhere, if they are not the same."""
PAIRS, WRITTEN = 300, 12
"""Pairs of mistakes that are tried in numbers, and those of them that are written out as formulas."""
OF_SCREWS = frozenset(mistake.name for mistake in screws.MISTAKES)
"""What goes wrong in a screw; what is written down in another order, or with another sign, says nothing of screws."""
NO_NUMBER = (sp.nan, sp.zoo, sp.oo)
LONGEST, LEAST = 110, 260
"""Characters of an option for each entry, and for all together if that is less: others are no short question."""
MOST_JOINTS = 4
"""Joints up to which determinants are worked out in formulas, right and wrong: it takes minutes beyond."""


@dataclass(frozen=True)
class Subject:
    """What options are about: the answer to a question, one column of it, or one entry of that column."""

    base: str
    column: int | None = None
    row: int | None = None

    @property
    def is_of_screws(self) -> bool:
        """Whether it hangs on where the arm is at home, which its structure does not know."""
        return QUESTIONS[self.base].speaks_of == SCREWS

    @property
    def is_quotient(self) -> bool:
        """Whether the right answer has a denominator."""
        return "inverse" in self.base

    def of(self, answer: np.ndarray) -> np.ndarray:
        """Return what is asked about out of a whole answer, (rows, columns, …)."""
        rows = slice(None) if self.row is None else slice(self.row, self.row + 1)
        return answer[rows, slice(None) if self.column is None else slice(self.column, self.column + 1)]


@dataclass(frozen=True)
class _Slip:
    """A mistake made in one way on a structure, what it gives in numbers, and the changes that make it."""

    blame: Blame
    values: np.ndarray
    changes: tuple[tuple[str, Change], ...]


@lru_cache(maxsize=512)
def _base_part(generic: Chain, base: str) -> Part:
    answer, details = QUESTIONS[base].ask(generic, Stream("quiz"))
    return Part(base, base, answer, details=details)


@lru_cache(maxsize=512)
def _values(generic: Chain, base: str) -> Mapping[str, np.ndarray]:
    symbols = _base_part(generic, base).symbols
    names = {*domain_of(generic).roles, *(rate.name for rate in generic.rates), *generic.task, *symbols}
    drawn = Domain(domain_of(generic).roles).sample(names, READABLE + POINTS, Stream(f"quiz/{base}"))
    return {name: values[READABLE:] for name, values in drawn.items()}


@lru_cache(maxsize=512)
def _right(generic: Chain, subject: Subject) -> tuple[Working, np.ndarray]:
    w = numbers(generic, _values(generic, subject.base))
    return w, subject.of(result(w, _base_part(generic, subject.base)))


@lru_cache(maxsize=512)
def _slips(generic: Chain, subject: Subject) -> tuple[_Slip, ...]:
    """Return the mistakes that change what is asked about, each result once."""
    w, right = _right(generic, subject)
    slips: list[_Slip] = []
    for wrong in wrong_answers(w, _base_part(generic, subject.base)):
        values = subject.of(wrong.answer)
        if (
            wrong.mistake.rare
            or (subject.is_of_screws and wrong.mistake.name not in OF_SCREWS)
            or wrong.mistake.name in SHOWS_ITSELF
            or values.shape != right.shape
            or not np.isfinite(values).all()
        ):
            continue
        if all(differ(values, other) for other in (right, *(slip.values for slip in slips))):
            slips.append(_Slip(Blame.of(wrong.mistake, wrong.slip.words.items()), values, _changes(wrong)))
    return tuple(slips)


def _changes(wrong: Wrong) -> tuple[tuple[str, Change], ...]:
    return wrong.working.changes


def differ(a: np.ndarray, b: np.ndarray) -> bool:
    """Tell whether two answers have other values somewhere."""
    return bool(np.abs(a - b).max() > APART * max(np.abs(a).max(), np.abs(b).max(), 1e-12))


def _both(generic: Chain, subject: Subject, first: _Slip, second: _Slip) -> np.ndarray | None:
    """Return what two mistakes make of an answer together, None where that is none of its own."""
    w, right = _right(generic, subject)
    together = w.with_mistakes(dict(first.changes)).with_mistakes(dict(second.changes))
    with np.errstate(all="ignore"):
        values = subject.of(result(together, _base_part(generic, subject.base)))
    others = (right, first.values, second.values)
    if values.shape != right.shape or not np.isfinite(values).all():
        return None
    return values if all(differ(values, other) for other in others) else None


# --- as formulas ---


@lru_cache(maxsize=512)
def in_formulas(generic: Chain) -> Working:
    """Return the right working in formulas that are kept short on the way."""
    return formulas(generic).with_mistakes({"rotations": _short, "links": _short})


def _short(_: Working, found: list[np.ndarray]) -> list[np.ndarray]:
    tidy = np.frompyfunc(lambda entry: textbook(sp.expand(entry)), 1, 1)
    return [np.asarray(tidy(one)) for one in found]


@lru_cache(maxsize=20_000)
def _written(generic: Chain, subject: Subject, slips: tuple[int, ...]) -> sp.Matrix | None:
    """Return an answer with some mistakes (by their number) made in it, None where it can't be written briefly."""
    if not _is_short(generic, subject):
        return None
    w = formulas(generic) if subject.is_of_screws else in_formulas(generic)
    for index in slips:
        w = w.with_mistakes(dict(_slips(generic, subject)[index].changes))
    entries = as_formulas(subject.of(result(w, _base_part(generic, subject.base))))
    if entries.has(*NO_NUMBER):
        return None
    try:
        tidy = entries.applyfunc(_of_own_numbers if subject.is_of_screws else tidied)
    except (ValueError, BasePolynomialError):  # no trigonometric polynomial
        return None
    if not subject.is_quotient and any(sp.fraction(entry)[1].free_symbols for entry in tidy):
        return None  # nobody divides where the right answer does not
    return tidy if _fits(tidy) else None


def _fits(option: sp.Matrix) -> bool:
    return len(str(option.tolist())) <= max(LONGEST * min(len(option), 4), LEAST)


@lru_cache(maxsize=2048)
def _is_short(generic: Chain, subject: Subject) -> bool:
    """Tell whether the right answer is short; found out from the reference, which takes less than the working."""
    if generic.n > MOST_JOINTS and QUESTIONS[subject.base].is_made_of_minors:
        return False
    whole = _base_part(generic, subject.base).answer.as_matrix()
    return _fits(sp.Matrix(subject.of(np.array(whole.tolist(), dtype=object))))


def _of_own_numbers(entry: sp.Expr) -> sp.Expr:
    """Return an entry of an arm with its own numbers, as it is where no joint is in it.

    Raises ValueError for a formula with roots, or with angles of the arm's own, as theta1 + 30 degrees.
    """
    if not entry.has(sp.sin, sp.cos):
        return sp.expand(entry)
    if any(power.is_number and not power.is_Rational for power in entry.atoms(sp.Pow)):
        raise ValueError(f"{entry} has roots")
    return tidied(entry)


def tidied(entry: sp.Expr) -> sp.Expr:
    """Return an entry as a textbook has it, right or wrong; factors that a quotient shares are cancelled."""
    if any(power.exp.is_negative for power in entry.atoms(sp.Pow)):
        above, below = (sp.expand(side) for side in sp.fraction(sp.together(entry)))
        under = factor_trig(below) if not below.has(*NO_NUMBER) else None
        if under is None or under.is_zero or above.has(*NO_NUMBER):
            raise ValueError(f"{entry} divides by zero")
        return factor_trig(above).over(under).expression()
    return textbook(sp.expand(entry))


# --- four options ---


def four_options(chain: Chain, subject: Subject, rng: Stream) -> list[Offered] | None:
    """Return the right option and three wrong ones, or None where the catalogue does not give three that go with it."""
    generic = chain if subject.is_of_screws else structure(chain).chain
    if _written(generic, subject, ()) is None:
        return None
    wanted, ranked = rng.below(4), list[tuple[tuple[bool, int, float], tuple[tuple[int, ...], ...]]]()
    for sets in islice(_sets(generic, subject, rng), WRITTEN):
        lengths = [_length(generic, subject, slips) for slips in ((), *sets)]
        if not all(lengths) or max(lengths) > MOST_SPREAD * min(lengths):
            continue
        spread = max(lengths) / min(lengths)
        ranked.append(((spread > SPREAD, abs(rank_of_key(lengths) - wanted), spread), sets))
        if ranked[-1][0][:2] == (False, 0):
            break
    fill = sp.Matrix if generic is chain else derive(chain).fill_matrix
    slips_of = _slips(generic, subject)
    for _, sets in sorted(ranked):
        options = [fill(_written(generic, subject, slips)) for slips in ((), *sets)]
        if all_differ(chain, options):
            behind = [tuple(slips_of[index].blame for index in slips) for slips in ((), *sets)]
            return [Offered(shown, why) for shown, why in zip(options, behind, strict=True)]
    return None


@lru_cache(maxsize=20_000)
def _length(generic: Chain, subject: Subject, slips: tuple[int, ...]) -> int:
    """Return the number of characters of an option, 0 of one that can't be written briefly."""
    written = _written(generic, subject, slips)
    return 0 if written is None else len(str(written.tolist()))


def _sets(generic: Chain, subject: Subject, rng: Stream) -> Iterator[tuple[tuple[int, ...], ...]]:
    """Yield three wrong options by the mistakes in them: one, another, both; else any three, a mistake each."""
    slips = _slips(generic, subject)
    pairs = rng.shuffled(list(combinations(range(len(slips)), 2)))
    for first, second in pairs[:PAIRS]:
        if slips[first].blame.mistake == slips[second].blame.mistake and len(slips) > 8:
            continue
        if _both(generic, subject, slips[first], slips[second]) is not None:
            yield (first,), (second,), (first, second)
    for one, two, three in rng.shuffled(list(islice(combinations(range(len(slips)), 3), PAIRS))):
        yield (one,), (two,), (three,)


def all_differ(chain: Chain, options: list[sp.Matrix]) -> bool:
    """Tell whether options are different functions on this arm, whose lengths may be given, and equal."""
    programs = compile_program([read(str(entry)) for option in options for entry in option])
    names = {symbol.name for option in options for symbol in option.free_symbols}
    drawn = Domain(domain_of(chain).roles).sample(names, READABLE + POINTS, Stream("quiz"))
    count = POINTS + READABLE
    values = evaluate(programs, drawn or {"one": np.ones(count)}, count)[0].reshape(len(options), -1, count)[
        :, :, READABLE:
    ]
    return bool(np.isfinite(values).all()) and all(differ(a, b) for a, b in combinations(values, 2))


def wrong_forms(generic: Chain, subject: Subject) -> list[tuple[sp.Expr, Blame]]:
    """Return what single mistakes make of one entry, with the mistake."""
    forms = []
    for index, slip in enumerate(_slips(generic, subject)):
        written = _written(generic, subject, (index,))
        if written is not None:
            forms.append((written[0], slip.blame))
    return forms
