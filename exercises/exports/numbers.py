"""Formulas asked for in numbers, for platforms that compare no formulas: at a configuration that tells mistakes apart.

Lengths and a configuration are drawn from a stream of the problem's own: away from singularities, no entry tiny or
zero by chance. The numbers are worked out twice, from the reference and by a derivation in numbers.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.answers import Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import domain_of
from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.arm.mpmath_kinematics import numeric, ten_digits
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import Domain
from qdot.exercises.mistakes.catalogue import (
    ONE_NUMBER,
    Wrong,
    likely_mistakes,
    make_mistake,
    mistaken_answers,
    wrong_answers,
)
from qdot.exercises.mistakes.configurations import Values, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.geometry import distinct_lengths
from qdot.exercises.questions.inversion import THREE_DIGITS, conditioning, sample_pose, well_conditioned
from qdot.exercises.questions.results import is_derived, is_made_of_jacobian, result
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_value
from qdot.exercises.writing.wording import Wording

DRAWS = 12
"""Configurations that are drawn; the one that tells most mistakes apart is taken."""
TINY = 0.02
"""Share of the largest entry below which an entry is hard to give to three digits."""
LEAST = 0.001
"""Share of the largest entry that any entry may be off, those that are zero above all."""
APART = 0.03
"""Share of the largest entry by which a mistake must change some entry to count as told apart."""
MOST_JOINTS = 4
"""Joints of the largest arm of which all mistakes behind J are worked out; it takes many seconds beyond."""
SAME = 1e-8
"""Share of the largest entry by which both ways to the numbers may differ."""


@dataclass(frozen=True)
class Given:
    """What is told of a configuration, as LaTeX: names and values in the order in which they are told.

    `values` are all symbols in numbers.
    """

    joints: tuple[tuple[str, str], ...]
    others: tuple[tuple[str, str], ...]
    values: Mapping[str, float]


@dataclass(frozen=True)
class InNumbers:
    """A part whose answer is numbers, (rows, columns), what is given for it, and what mistakes make of the answer.

    The entry of a direction that is to be 1 is `unit`, counted from 0; None for other answers.
    """

    part: Part
    values: np.ndarray
    given: Given | None
    wrong: tuple[tuple[str, str, np.ndarray], ...]
    unit: int | None = None


def in_numbers(problem: Problem, part: Part) -> InNumbers | None:
    """Return a part with numbers as its answer; None where there is no way to ask for it in numbers.

    Raises QdotError where the two ways to the numbers do not agree.
    """
    answer = part.answer
    if answer.is_in_numbers and not answer.counts_up_to_a_factor:
        return _of_numbers(problem, part)
    if answer.is_in_numbers:
        return _scaled(_of_numbers(problem, replace(part, answer=_as_number(part, answer.as_matrix())), direction=True))
    if not answer.entries() or not is_derived(part):
        return None
    asked = _of_formulas(problem, part)
    return _scaled(asked) if answer.counts_up_to_a_factor and asked is not None else asked


def _as_number(part: Part, values: sp.Matrix) -> Number:
    floor = LEAST * float(max(map(abs, values)))
    return Number(values, part.details.units or ("",) * len(values), THREE_DIGITS, floor)


def _of_numbers(problem: Problem, part: Part, direction: bool = False) -> InNumbers:
    answer = part.of(Number)
    right = np.array(answer.reference.tolist(), dtype=float)
    wrong = [
        (mistake.title, mistake.sentence(slip.words), np.array(slip.answer.reference.tolist(), dtype=float))
        for mistake, slip in mistaken_answers(problem.chain, part)
        if isinstance(slip.answer, Number)
    ]
    if is_derived(part):
        domain = _domain(problem, part)
        where = sample_configurations(problem.chain, part, domain, 1, Stream(f"{problem.id}/{part.name}/wrong"))
        w = numbers(problem.chain, where)
        _hold(problem, part, right, result(w, part)[..., 0], direction)
        wrong += [_told(one, one.answer[..., 0]) for one in _mistakes(w, part)]
    return InNumbers(part, right, None, tuple(wrong))


def _told(wrong: Wrong, values: np.ndarray) -> tuple[str, str, np.ndarray]:
    return wrong.mistake.title, wrong.sentence, values


def _hold(problem: Problem, part: Part, one: np.ndarray, other: np.ndarray, direction: bool) -> None:
    """Hold the numbers of one way against those of another; directions up to a factor. Raises QdotError."""
    if one.shape == other.shape and direction:
        one, other = (vector / vector.ravel()[np.abs(one).argmax()] for vector in (one, other))
    if one.shape != other.shape or not np.abs(one - other).max() <= SAME * max(np.abs(one).max(), 1e-9):
        raise QdotError(f"{problem.id}: {part.name}: its numbers do not agree; please report it")


def _mistakes(w: Working, part: Part) -> list[Wrong]:
    """Return what mistakes make of an answer; of long derivations only those that a single number shows."""
    if not is_derived(part):
        return []
    if w.n > MOST_JOINTS and is_made_of_jacobian(part):
        return [
            wrong
            for mistake in likely_mistakes(part)
            if mistake.name in ONE_NUMBER
            for wrong in make_mistake(mistake, w, part)
        ]
    return list(wrong_answers(w, part))


# --- formulas ---


def _of_formulas(problem: Problem, part: Part) -> InNumbers | None:
    """Return a part with its formulas evaluated at the best of some configurations."""
    chain, stream = problem.chain, Stream(f"qdot/{problem.id.engine}/{problem.id}/{part.name}/in numbers")
    reference = part.answer.as_matrix()
    drawn = list(_configurations(chain, part, stream))
    values = _columns(chain, part, drawn)
    as_number = replace(part, answer=_as_number(part, sp.ones(*reference.shape)))
    w = numbers(chain, values)
    right = result(w, as_number)
    mistakes = [one for one in _mistakes(w, as_number) if one.answer.shape == right.shape]
    best = _best(right, mistakes)
    if best is None:
        return None
    exact = _precise(reference, _exact(part, drawn[best]))
    as_number = replace(part, answer=_as_number(part, exact))
    doubles = np.array(exact.tolist(), dtype=float)
    _hold(problem, part, doubles, right[..., best], part.answer.counts_up_to_a_factor)
    wrong = tuple(_told(one, one.answer[..., best]) for one in mistakes)
    return InNumbers(as_number, doubles, _given(chain, part, drawn[best], reference), wrong)


Drawn = dict[sp.Symbol, sp.Expr]


def _configurations(chain: Chain, part: Part, stream: Stream) -> Iterator[Drawn]:
    """Yield numbers for every symbol; joints are where J is well conditioned, if that can be had."""
    full = min(len(chain.task), chain.n) and not part.details.given_joints
    for _ in range(DRAWS):
        for _ in range(30):
            lengths = {
                symbol: _angle(stream) if symbol.name.startswith(("alpha", "beta")) else value
                for symbol, value in distinct_lengths(chain, stream).items()
            }
            joints = sample_pose(chain, stream)
            if not full or conditioning(chain, lengths, joints) > well_conditioned(chain) / 2:
                break
        rates = {rate: sp.Rational(_some(stream, 9), 10) for rate in chain.rates}
        velocity = {sp.Symbol(row): sp.Rational(_some(stream, 8), 20) for row in chain.task}
        loads = {sp.Symbol(name): sp.Integer(_some(stream, 20)) for name in part.symbols}
        yield {**lengths, **joints, **rates, **velocity, **loads}


def _angle(stream: Stream) -> sp.Expr:
    return sp.pi * sp.Rational(_some(stream, 16), 18)


def _some(stream: Stream, most: int) -> int:
    """Draw a whole number other than zero."""
    return stream.choice([k for k in range(-most, most + 1) if k])


def _exact(part: Part, drawn: Drawn) -> Drawn:
    """Return a draw with the joint values that the question gives in it."""
    return {**drawn, **{q: value.xreplace(drawn) for q, value in part.details.given_joints.items()}}


def _columns(chain: Chain, part: Part, drawn: Sequence[Drawn]) -> Values:
    """Return the values of each symbol at all configurations, (N,)."""
    exact = [_exact(part, one) for one in drawn]
    columns = {symbol.name: np.array([float(one[symbol]) for one in exact]) for symbol in exact[0]}
    others = {*domain_of(chain).roles} - set(columns)
    return columns | {name: np.ones(len(drawn)) for name in sorted(others)}


def _precise(reference: sp.Matrix, values: Drawn) -> sp.Matrix:
    return reference.applyfunc(lambda entry: ten_digits(numeric(entry.xreplace(values))))


def _best(right: np.ndarray, mistakes: Sequence[Wrong]) -> int | None:
    """Return the configuration with the fewest entries that are tiny, and of these the one that tells most apart."""
    size = np.abs(right).max(axis=(0, 1))
    somewhere = np.nan_to_num(np.abs(right)).max(axis=-1)
    always = somewhere > SAME * somewhere.max()
    small = ((np.abs(right) < TINY * size) & always[..., None]).sum(axis=(0, 1))
    told = np.zeros(right.shape[-1], dtype=int)
    for one in mistakes:
        apart = np.abs(one.answer - right)
        told += np.where(np.isfinite(apart), apart, 0.0).max(axis=(0, 1)) > APART * size
    usable = np.isfinite(right).all(axis=(0, 1)) & (size > SAME)
    order = [(small[k], -told[k], k) for k in range(right.shape[-1]) if usable[k]]
    return min(order)[2] if order else None


def _scaled(found: InNumbers) -> InNumbers:
    """Return a direction with its largest entry made 1: it counts up to a factor."""
    unit = int(np.abs(np.round(found.values, 6)).argmax())
    values = found.values / found.values.ravel()[unit]
    with np.errstate(all="ignore"):
        wrong = tuple((title, says, answer / answer.ravel()[unit]) for title, says, answer in found.wrong)
    reference = sp.Matrix(values.tolist())
    part = replace(found.part, answer=Number(reference, ("",) * len(reference), THREE_DIGITS, LEAST))
    return InNumbers(part, values, found.given, wrong, unit)


# --- words ---


def _given(chain: Chain, part: Part, drawn: Drawn, reference: sp.Matrix) -> Given:
    """Return what is told: all joints but those that the question gives, and what the formulas or mistakes need."""
    w, used = Wording(chain), reference.free_symbols
    joints = tuple((tex(q), tex_value(drawn[q], q)) for q in chain.q if q not in part.details.given_joints)
    others: list[tuple[str, str]] = []
    if used & set(chain.rates):
        units = zip(chain.rates, w.rate_units, strict=True)
        others += [(tex(rate, chain), rf"{tex(drawn[rate])}\,\text{{{unit}}}") for rate, unit in units]
    rows = [sp.Symbol(row) for row in chain.task]
    if used & set(rows):
        others += [(tex(row), w.velocity_value(row, drawn[row])) for row in rows]
    others += [
        (tex(sp.Symbol(name)), rf"{tex(drawn[sp.Symbol(name)])}\,\text{{{info.unit}}}")
        for name, info in part.symbols.items()
    ]
    others += [(tex(symbol), _value(symbol, drawn[symbol])) for symbol in chain.parameters]
    return Given(joints, tuple(others), {symbol.name: float(value) for symbol, value in _exact(part, drawn).items()})


def _value(symbol: sp.Symbol, value: sp.Expr) -> str:
    return tex_angle(value) if symbol.name.startswith(("alpha", "beta")) else tex_length(value)


def _domain(problem: Problem, part: Part) -> Domain:
    """Return the domain of a problem's symbols, those that the part brings with it included."""
    roles: Mapping[str, Any] = domain_of(problem.chain).roles
    return Domain({**roles, **dict.fromkeys(part.symbols, "signed")})
