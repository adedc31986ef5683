"""Wrong options that look as plausible as the right one, made by the mistakes of the catalogue.

Two mistakes give three wrong options: with the first, with the second, with both. In such a set of four every feature
occurs twice, so the right option is not the one that has most in common with the others. Its rank in length is random.
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
from qdot.exercises.formula.identity import READABLE, Domain
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.mistakes import screws
from qdot.exercises.mistakes.catalogue import wrong_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import result
from qdot.exercises.quizzes.options import MOST_SPREAD, SHOWS_ITSELF, SPREAD, Blame, OfferedOption, rank_right_option

POINTS = 5
APART = 1e-6
"""Relative difference that two different answers reach somewhere."""
PAIRS, WRITTEN = 300, 12
"""Pairs of mistakes that are tried in numbers, and those of them that are written out as formulas."""
OF_SCREWS = frozenset(mistake.name for mistake in screws.MISTAKES)
"""Mistakes about screws; another order or sign of the entries has nothing to do with screws."""
NO_NUMBER = (sp.nan, sp.zoo, sp.oo)
LONGEST, LEAST = 110, 260
"""Characters of an option for each entry and in all (the smaller limit holds): longer ones are no short question."""
MOST_JOINTS = 4
"""Joints up to which determinants are derived as formulas, right and wrong: beyond, it takes minutes."""


@dataclass(frozen=True)
class Subject:
    """What options are about: the answer to a question, one column of it, or one entry of that column."""

    base: str
    column: int | None = None
    row: int | None = None

    @property
    def is_of_screws(self) -> bool:
        """Whether it depends on where the arm is at home, which its structure does not determine."""
        return QUESTIONS[self.base].speaks_of == SCREWS

    @property
    def is_quotient(self) -> bool:
        """Whether the right answer has a denominator."""
        return "inverse" in self.base

    def of(self, answer: np.ndarray) -> np.ndarray:
        """Return the subject as part of a whole answer, (rows, columns, …)."""
        rows = slice(None) if self.row is None else slice(self.row, self.row + 1)
        return answer[rows, slice(None) if self.column is None else slice(self.column, self.column + 1)]


@dataclass(frozen=True)
class _Variant:
    """A mistake made in one way on a structure, what it gives in numbers, and the changes that make it."""

    blame: Blame
    values: np.ndarray
    changes: tuple[tuple[str, Change], ...]


@lru_cache(maxsize=512)
def _ask_base(generic: Chain, base: str) -> Part:
    answer, details = QUESTIONS[base].ask(generic, Stream("quiz"))
    return Part(base, base, answer, details=details)


@lru_cache(maxsize=512)
def _sample_values(generic: Chain, base: str) -> Mapping[str, np.ndarray]:
    symbols = _ask_base(generic, base).symbols
    names = {*domain_of(generic).roles, *(rate.name for rate in generic.rates), *generic.task, *symbols}
    sampled = Domain(domain_of(generic).roles).sample(names, READABLE + POINTS, Stream(f"quiz/{base}"))
    return {name: values[READABLE:] for name, values in sampled.items()}


@lru_cache(maxsize=512)
def _evaluate_right_answer(generic: Chain, subject: Subject) -> tuple[Working, np.ndarray]:
    w = numbers(generic, _sample_values(generic, subject.base))
    return w, subject.of(result(w, _ask_base(generic, subject.base)))


@lru_cache(maxsize=512)
def _find_variants(generic: Chain, subject: Subject) -> tuple[_Variant, ...]:
    """Return the mistakes that change the subject, each result once."""
    w, right = _evaluate_right_answer(generic, subject)
    variants: list[_Variant] = []
    for wrong in wrong_answers(w, _ask_base(generic, subject.base)):
        values = subject.of(wrong.answer)
        if (
            wrong.mistake.rare
            or (subject.is_of_screws and wrong.mistake.name not in OF_SCREWS)
            or wrong.mistake.name in SHOWS_ITSELF
            or values.shape != right.shape
            or not np.isfinite(values).all()
        ):
            continue
        if all(differ(values, known_values) for known_values in (right, *(variant.values for variant in variants))):
            blame = Blame.of(wrong.mistake, wrong.variant.words.items())
            variants.append(_Variant(blame, values, wrong.working.changes))
    return tuple(variants)


def differ(a: np.ndarray, b: np.ndarray) -> bool:
    """Tell whether two answers have different values somewhere."""
    return bool(np.abs(a - b).max() > APART * max(np.abs(a).max(), np.abs(b).max(), 1e-12))


def _are_three(generic: Chain, subject: Subject, first: _Variant, second: _Variant) -> bool:
    """Tell whether both mistakes together give another answer than one of them or none."""
    w, right = _evaluate_right_answer(generic, subject)
    together = w.with_mistakes(dict(first.changes)).with_mistakes(dict(second.changes))
    with np.errstate(all="ignore"):
        values = subject.of(result(together, _ask_base(generic, subject.base)))
    if values.shape != right.shape or not np.isfinite(values).all():
        return False
    return all(differ(values, known_values) for known_values in (right, first.values, second.values))


# --- as formulas ---


@lru_cache(maxsize=512)
def in_formulas(generic: Chain) -> Working:
    """Return the right working in formulas, which are shortened on the way."""
    return formulas(generic).with_mistakes({"rotations": _shorten, "links": _shorten})


def _shorten(_: Working, matrices: list[np.ndarray]) -> list[np.ndarray]:
    tidy = np.frompyfunc(lambda entry: textbook(sp.expand(entry)), 1, 1)
    return [np.asarray(tidy(matrix)) for matrix in matrices]


@lru_cache(maxsize=20_000)
def _write_answer(generic: Chain, subject: Subject, numbers: tuple[int, ...]) -> sp.Matrix | None:
    """Return an answer with some mistakes (by their number) made in it, None where it can't be written briefly."""
    if not _is_short(generic, subject):
        return None
    w = formulas(generic) if subject.is_of_screws else in_formulas(generic)
    for index in numbers:
        w = w.with_mistakes(dict(_find_variants(generic, subject)[index].changes))
    entries = as_formulas(subject.of(result(w, _ask_base(generic, subject.base))))
    if entries.has(*NO_NUMBER):
        return None
    try:
        tidy = entries.applyfunc(_expand_numbers if subject.is_of_screws else tidy_entry)
    except (ValueError, BasePolynomialError):  # no trigonometric polynomial
        return None
    if not subject.is_quotient and any(sp.fraction(entry)[1].free_symbols for entry in tidy):
        return None  # a student would not divide where the right answer does not
    return tidy if _fits(tidy) else None


def _fits(option: sp.Matrix) -> bool:
    return len(str(option.tolist())) <= max(LONGEST * min(len(option), 4), LEAST)


@lru_cache(maxsize=2048)
def _is_short(generic: Chain, subject: Subject) -> bool:
    """Tell whether the right answer is short, from the reference, which is cheaper than the working."""
    if generic.n > MOST_JOINTS and QUESTIONS[subject.base].is_made_of_minors:
        return False
    whole = _ask_base(generic, subject.base).answer.as_matrix()
    return _fits(sp.Matrix(subject.of(np.array(whole.tolist(), dtype=object))))


def _expand_numbers(entry: sp.Expr) -> sp.Expr:
    """Return an entry with the numbers of the arm multiplied out, unchanged if it depends on no joint.

    Raises ValueError for a formula with roots, or with constant angles of the arm, such as theta1 + 30 degrees.
    """
    if not entry.has(sp.sin, sp.cos):
        return sp.expand(entry)
    if any(power.is_number and not power.is_Rational for power in entry.atoms(sp.Pow)):
        raise ValueError(f"{entry} has roots")
    return tidy_entry(entry)


def tidy_entry(entry: sp.Expr) -> sp.Expr:
    """Return a right or wrong entry as a textbook has it; common factors of a quotient are cancelled."""
    if any(power.exp.is_negative for power in entry.atoms(sp.Pow)):
        above, below = (sp.expand(side) for side in sp.fraction(sp.together(entry)))
        under = factor_trig(below) if not below.has(*NO_NUMBER) else None
        if under is None or under.is_zero or above.has(*NO_NUMBER):
            raise ValueError(f"{entry} divides by zero")
        return factor_trig(above).over(under).expression()
    return textbook(sp.expand(entry))


# --- four options ---


def make_four_options(chain: Chain, subject: Subject, rng: Stream) -> list[OfferedOption] | None:
    """Return the right option and three wrong ones, or None if the catalogue gives no three that match it."""
    generic = chain if subject.is_of_screws else structure(chain).chain
    if _write_answer(generic, subject, ()) is None:
        return None
    wanted, ranked = rng.below(4), list[tuple[tuple[bool, int, float], tuple[tuple[int, ...], ...]]]()
    for sets in islice(_make_wrong_triples(generic, subject, rng), WRITTEN):
        lengths = [_measure_length(generic, subject, numbers) for numbers in ((), *sets)]
        if not all(lengths) or max(lengths) > MOST_SPREAD * min(lengths):
            continue
        spread = max(lengths) / min(lengths)
        ranked.append(((spread > SPREAD, abs(rank_right_option(lengths) - wanted), spread), sets))
        if ranked[-1][0][:2] == (False, 0):
            break
    fill = sp.Matrix if generic is chain else derive(chain).fill_matrix
    variants = _find_variants(generic, subject)
    for _, sets in sorted(ranked):
        options = [fill(_write_answer(generic, subject, numbers)) for numbers in ((), *sets)]
        if all_differ(chain, options):
            behind = [tuple(variants[index].blame for index in numbers) for numbers in ((), *sets)]
            return [OfferedOption(shown, why) for shown, why in zip(options, behind, strict=True)]
    return None


@lru_cache(maxsize=20_000)
def _measure_length(generic: Chain, subject: Subject, numbers: tuple[int, ...]) -> int:
    """Return the number of characters of an option, 0 if it can't be written briefly."""
    written = _write_answer(generic, subject, numbers)
    return 0 if written is None else len(str(written.tolist()))


def _make_wrong_triples(generic: Chain, subject: Subject, rng: Stream) -> Iterator[tuple[tuple[int, ...], ...]]:
    """Yield triples of wrong options: one mistake, another, both; then any three with one mistake each."""
    variants = _find_variants(generic, subject)
    pairs = rng.permutation(list(combinations(range(len(variants)), 2)))
    for first, second in pairs[:PAIRS]:
        if variants[first].blame.mistake == variants[second].blame.mistake and len(variants) > 8:
            continue
        if _are_three(generic, subject, variants[first], variants[second]):
            yield (first,), (second,), (first, second)
    for a, b, c in rng.permutation(list(islice(combinations(range(len(variants)), 3), PAIRS))):
        yield (a,), (b,), (c,)


def all_differ(chain: Chain, options: list[sp.Matrix]) -> bool:
    """Tell whether options are different functions on this arm, whose lengths may be given, and equal."""
    programs = compile_program([read(str(entry)) for option in options for entry in option])
    names = {symbol.name for option in options for symbol in option.free_symbols}
    sampled = Domain(domain_of(chain).roles).sample(names, READABLE + POINTS, Stream("quiz"))
    count = POINTS + READABLE
    outcomes = evaluate(programs, sampled or {"any": np.ones(count)}, count)[0]
    values = outcomes.reshape(len(options), -1, count)[:, :, READABLE:]
    return bool(np.isfinite(values).all()) and all(differ(a, b) for a, b in combinations(values, 2))


def list_wrong_forms(generic: Chain, subject: Subject) -> list[tuple[sp.Expr, Blame]]:
    """Return the entry with each single mistake, and the mistake."""
    forms = []
    for index, variant in enumerate(_find_variants(generic, subject)):
        written = _write_answer(generic, subject, (index,))
        if written is not None:
            forms.append((written[0], variant.blame))
    return forms
