"""Keys by which a browser grades: what the right answer, and each mistake's, is worth at a few configurations.

A key holds numbers, no formula. Configurations have two decimals, so that a counterexample can be followed by hand. The
right values are worked out with many digits and written with 15, those of mistakes with 6: the same bytes everywhere.

    {"type": "values", "symbols": [name], "points": [[value]], "rows": r, "columns": c,
     "right": [[entry at each point]], "constants": [name], "moving": [index of an entry that depends on others],
     "linear": {rate, velocity or force: [[what it is multiplied by in each entry at the first points]]},
     "mistakes": [{"name", "title", "says", "missing": symbols, "print": [number at the first points]}],
     "throughout": [… as mistakes: the same slip everywhere in the finished formulas]}
    {"type": "numbers", "units", "tolerance", "floor", "right": [number], "mistakes": [{…, "values": [number]}],
     "precise": [… as mistakes: what is looked for behind a single number that has many digits]}
    {"type": "direction", …as "values", "tolerance": number or null}
    {"type": "configurations", "joints": [name], "symbols": [name], "pieces": [[pose]],
     "conditions": [number of pieces of each], "mistakes": []}
    {"type": "choice" | "selection" | "matching", "options": count, "items": count, "right": [index],
     "told": [[{"name", "title", "says"} of what is behind an option that is wrong]]}

`print` is one number for a whole answer at a point: the sum of its entries, row by row, each times `weight(index)`; of
a direction, the size of that for the unit vector along it. A direction in numbers has that vector itself as "values".
Slips in one place of a formula, and in conditions, the page finds by itself (site/src/grade/slips.ts, set-slips.ts).
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.answers import Answer, ConditionSet, Direction, Forms, Letters, Number
from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space
from qdot.exercises.formula.constants import value_of
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.identity import Domain
from qdot.exercises.formula.pieces import pieces
from qdot.exercises.formula.program import Program, compile_program, evaluate, evaluate_precisely
from qdot.exercises.formula.trees import as_matrix, names
from qdot.exercises.mistakes import numeric
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    Wrong,
    likely_mistakes,
    make_mistake,
    mistaken_answers,
    variant_frequency,
    wrong_answers,
)
from qdot.exercises.mistakes.configurations import Values, fix_given_joints, sample_configurations
from qdot.exercises.mistakes.finished import edits_throughout
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json
from qdot.exercises.questions.results import is_derived, result
from qdot.exercises.quizzes.option_mistakes import blames_for
from qdot.exercises.quizzes.values import AtRates
from qdot.exercises.writing.statement import answer_code

POINTS, DRAWN = 16, 24
"""Configurations of a key, and how many are drawn: the first are readable, the others have lengths of all sizes."""
HUGE = 1e8
"""Where an entry is larger the arm is singular but for rounding, and no formula can be told from another."""
FEWEST_POINTS, PRINTED = 3, 2
"""So many configurations a key needs, and at so many a mistake's answer is known, to six digits."""
MOST_MISTAKES, MOST_IN_NUMBERS, MOST_NUMBERS = 60, 160, 500
"""So many mistakes in formulas are told, and so many in numbers, with so many numbers in all."""
ALWAYS = (
    *(mistake.name for mistake in numeric.MISTAKES), "transposed", "cross-order", "sign", "transpose-for-inverse",
    "determinant-forgotten", "jacobian-for-inverse", "degrees",
)  # fmt: skip
"""Mistakes that are told beside these: what people do most, though it comes late in the catalogue."""
THROUGHOUT = (
    "lengths-missing", "relative-throughout", "wave-throughout", "constants-left-out", "constants-sign",
    "constants-in-degrees", "constants-wrong-radians", "sum-of-angles-split",
)  # fmt: skip
"""Slips that are made everywhere in finished formulas, the likelier ones first; `MOST_THROUGHOUT` of them are told."""
MOST_THROUGHOUT = 16
POSES = 6
"""So many poses of each piece of a singular set."""
GOLDEN = 0.6180339887498949
DIGITS = 30


def weight(index: int) -> float:
    """Return what an entry counts in the print of an answer.

    >>> weight(0), round(weight(1), 6)
    (1.0, 1.618034)
    """
    return 1.0 + (index * GOLDEN) % 1.0


def key_of(problem: Problem, part: Part, with_mistakes: bool = True) -> Json:
    """Return the key of a part; `with_mistakes`, what a browser names, takes nearly all of the time."""
    return part.answer.told_to(_Keys(problem, part, with_mistakes))


@dataclass(frozen=True)
class _Keys(Forms[Json]):
    """The key of each form of answer."""

    problem: Problem
    part: Part
    with_mistakes: bool

    def formulas(self, answer: Answer) -> Json:
        key, points = _values(self.problem, self.part)
        if not self.with_mistakes:
            return key
        key["mistakes"] = list(_mistakes_in_formulas(self.problem, self.part, points))
        if not answer.counts_up_to_a_factor:
            told = {
                "linear": _linear(self.problem, self.part, points),
                "throughout": list(_throughout(self.problem, self.part, points, key)),
            }
            key |= {name: some for name, some in told.items() if some}
        return key

    def direction(self, answer: Direction) -> Json:
        key = self.formulas(answer) if answer.tolerance is None else self._direction_in_numbers()
        return key | {"type": "direction", "tolerance": answer.tolerance}

    def _direction_in_numbers(self) -> Json:
        key, _ = _values(self.problem, self.part)
        right = np.array([entry[0] for entry in key["right"]], dtype=float)
        return key | {"mistakes": self._mistakes(_mistakes_in_direction(self.problem, self.part, right))}

    def numbers(self, answer: Number) -> Json:
        told = self._mistakes(_mistakes_in_numbers(self.problem, self.part, answer))
        key = _numbers(answer) | {"mistakes": told}
        if answer.shape == (1, 1):  # to few digits, many others give the same number
            known = {tuple(mistake["values"]) for mistake in told}
            precise = self._mistakes(_mistakes_in_numbers(self.problem, self.part, answer, precise=True))
            key["precise"] = [mistake for mistake in precise if tuple(mistake["values"]) not in known]
        return key

    def conditions(self, answer: ConditionSet) -> Json:
        return _configurations(self.problem, self.part, answer)

    def letters(self, answer: Letters) -> Json:
        told = self._behind_options() if self.with_mistakes else [[] for _ in answer.options]
        return {
            "type": answer.type, "options": len(answer.options), "items": len(answer.matched),
            "right": list(answer.right), "told": told,
        }  # fmt: skip

    def _behind_options(self) -> list[list[Json]]:
        behind = blames_for(self.problem, self.part, _stream(self.problem, self.part))
        return [[_named(blame.mistake, blame.sentence) for blame in blames] for blames in behind]

    def _mistakes(self, made: Iterator[Json]) -> list[Json]:
        return list(made) if self.with_mistakes else []


# --- formulas ---


def _values(problem: Problem, part: Part) -> tuple[Json, Values]:
    """Return the key of a part without its mistakes, and its configurations."""
    key = values_key(part.answer.formulas(), part.shape or (1, 1), problem.domain(), _stream(problem, part))
    reference = part.answer.as_matrix()
    used = [{symbol.name for symbol in entry.free_symbols} for entry in reference]
    key["constants"] = sorted(problem.constants & {*key["symbols"]} & _open(problem))
    key["moving"] = [index for index, symbols in enumerate(used) if symbols - problem.constants]
    columns = zip(*key["points"], strict=True)
    return key, {name: np.array(column) for name, column in zip(key["symbols"], columns, strict=True)}


def _linear(problem: Problem, part: Part, points: Values) -> Json:
    """Return what each rate, velocity or force is multiplied by in each entry, if it is multiplied only."""
    nodes = [read(text, problem.domain().roles) for text in part.answer.formulas()]
    program, used = compile_program(nodes), set().union(*map(names, nodes))
    few = {name: column[:PRINTED] for name, column in points.items() if name in used}
    found = {}
    for name, symbol in problem.symbols().items():
        if name in used and symbol.role in ("rate", "velocity", "force"):
            at = [np.real(evaluate(program, few | {name: few[name] * 0 + k}, PRINTED)[0]) for k in range(3)]
            if np.allclose(at[2] - at[1], at[1] - at[0], rtol=1e-9, atol=1e-12):
                found[name] = [[float(f"{value:.6g}") + 0.0 for value in entry] for entry in at[1] - at[0]]
    return found


def _open(problem: Problem) -> set[str]:
    """Return the symbols that are given no number."""
    return {name for name, role in problem.domain().roles.items() if isinstance(role, str)}


def values_key(texts: Sequence[str], shape: tuple[int, int], domain: Domain, stream: Stream) -> Json:
    """Return the key of formulas, without mistakes; their symbols are those of the domain. Raises ValueError."""
    nodes = [read(text, domain.roles) for text in texts]
    points = domain.sample(set(domain.roles), DRAWN, stream)
    symbols = sorted(points)
    given = {name for name, role in domain.roles.items() if not isinstance(role, str)}
    program = compile_program(nodes)
    used = sorted(set().union(*map(names, nodes)) & set(points))
    rows_of_points: list[list[float]] = []
    right: list[list[float | None]] = []
    for k in range(DRAWN):
        row = [float(points[name][k]) if name in given else _short(points[name][k]) for name in symbols]
        values = [_double(value) for value in _at(program, dict(zip(symbols, row, strict=True)), used)]
        if len(right) < POINTS and all(value is not None and abs(value) < HUGE for value in values):
            rows_of_points.append(row)
            right.append(values)
    if len(right) < FEWEST_POINTS:
        raise ValueError(f"the reference is defined at {len(right)} of {DRAWN} configurations: {texts}")
    return {
        "type": "values", "symbols": symbols, "points": rows_of_points, "rows": shape[0], "columns": shape[1],
        "right": [list(entry) for entry in zip(*right, strict=True)], "mistakes": [],
    }  # fmt: skip


def _at(program: Program, point: Mapping[str, float], used: Sequence[str]) -> list[Any]:
    """Return the entries at a configuration with many digits; its values are the decimals that are shown."""
    return evaluate_precisely(program, {name: mpmath.mpf(repr(point[name])) for name in used}, DIGITS)


def _mistakes_in_formulas(problem: Problem, part: Part, points: Values) -> Iterator[Json]:
    if not is_derived(part):
        return
    few = {name: column[:PRINTED] for name, column in points.items()}
    is_direction = part.answer.counts_up_to_a_factor
    w = numbers(problem.chain, fix_given_joints(part, few) if is_direction else few)
    seen = {_print(result(w, part), is_direction)}
    for wrong in _likely(w, part, seen):
        if wrong.answer.shape[:2] != (part.shape or (1, 1)):
            continue
        if not _says_something(wrong.answer) or (by := _print(wrong.answer, is_direction)) in seen:
            continue
        if is_direction and len(set(by)) == 1:  # one that never changes may come from anything
            continue
        seen.add(by)
        yield {**_said(wrong), "print": [float(text) for text in by]}


def _throughout(problem: Problem, part: Part, points: Values, key: Json) -> Iterator[Json]:
    """Yield what the same slip everywhere in the finished formulas makes of them, the likelier ones first."""
    few = {name: column[:PRINTED] for name, column in points.items()}
    rows = as_matrix(read(answer_code(problem, part), problem.domain().roles))
    right = set().union(*(names(entry) for row in rows for entry in row))
    every = [(THROUGHOUT.index(name), name, new) for name, new in edits_throughout(rows) if name in THROUGHOUT]
    seen = {_print(np.array(key["right"])[:, :PRINTED].reshape(key["rows"], key["columns"], -1))}
    for _, name, new in sorted(every, key=lambda one: one[0])[:MOST_THROUGHOUT]:
        entries = [entry for row in new for entry in row]
        values = evaluate(compile_program(entries), few, PRINTED)[0]
        if not np.isfinite(values).all() or (by := _print(values)) in seen:
            continue
        seen.add(by)
        gone = right - set().union(*map(names, entries)) if name == "lengths-missing" else set()
        said = _named(name, CATALOGUE[name].sentence({"Where": "In your answer"}), ", ".join(sorted(gone)))
        yield {**said, "print": [float(text) for text in by]}


def _likely(w: Working, part: Part, seen: Collection[object]) -> Iterator[Wrong]:
    """Yield what mistakes make of an answer until enough are seen, then what those make of it that are always told."""
    for wrong in wrong_answers(w, part):
        if len(seen) > MOST_MISTAKES:
            break
        yield wrong
    else:
        return
    for mistake in likely_mistakes(part):
        if mistake.name in ALWAYS:
            yield from make_mistake(mistake, w, part)


def _mistakes_in_direction(problem: Problem, part: Part, right: np.ndarray) -> Iterator[Json]:
    """Yield the unit vectors that mistakes make of a direction in numbers, each once with the likeliest."""
    found: dict[tuple[str, ...], tuple[float, Json, list[float]]] = {}
    for chance, said, values in _worked_out_in_numbers(problem, part):
        unit = np.array(values) / np.linalg.norm(values)
        way = np.sign(unit @ right)
        by = _to_few(unit * (way or 1.0))
        if unit.shape == right.shape and (by not in found or found[by][0] < chance):
            found[by] = chance, said, [float(value) for value in unit * (way or 1.0)]
    found.pop(_to_few(right / np.linalg.norm(right)), None)
    for _, said, values in islice(found.values(), min(MOST_IN_NUMBERS, MOST_NUMBERS // len(right))):
        yield {**said, "values": [float(f"{value:.6g}") + 0.0 for value in values]}


def _print(answer: np.ndarray, up_to_a_factor: bool = False) -> tuple[str, ...]:
    flat = answer.reshape(-1, answer.shape[-1])
    if up_to_a_factor:
        flat = flat / np.sqrt((np.abs(flat) ** 2).sum(axis=0))
    total = sum(weight(i) * entry for i, entry in enumerate(flat))
    values = np.asarray(total).real
    return tuple(f"{value:.5e}" for value in (np.abs(values) if up_to_a_factor else values))


def _says_something(answer: np.ndarray) -> bool:
    return bool(np.isfinite(answer).all() and (np.abs(answer) > 1e-9).any())


def _said(wrong: Wrong) -> Json:
    return _named(wrong.mistake.name, wrong.sentence, wrong.slip.missing)


def _named(mistake: str, sentence: str, missing: str = "") -> Json:
    named = {"name": mistake, "title": CATALOGUE[mistake].title, "says": sentence}
    return named | {"missing": missing} if missing else named


# --- numbers ---


def _numbers(answer: Number) -> Json:
    return {
        "type": "numbers", "units": list(answer.units), "tolerance": answer.tolerance, "floor": answer.floor,
        "right": [_double(float(value)) for value in answer.reference],
    }  # fmt: skip


def _mistakes_in_numbers(problem: Problem, part: Part, answer: Number, precise: bool = False) -> Iterator[Json]:
    """Yield what mistakes make of numbers, each answer once with the likeliest; all of them, as they are short.

    Those of single numbers are told that come to mind by few digits, all if it is `precise`.
    """
    found: dict[tuple[str, ...], tuple[float, Json, list[float]]] = {}
    right = _to_few(float(value) for value in answer.reference)
    every = (
        _taken_for_numbers(problem, part), _instead_of_speed(problem, part),
        _worked_out_in_numbers(problem, part, precise),
    )  # fmt: skip
    for chance, said, values in chain.from_iterable(every):
        by = _to_few(values)
        if len(by) == len(right) and by != right and (by not in found or found[by][0] < chance):
            found[by] = chance, said, values
    for _, said, values in islice(found.values(), min(MOST_IN_NUMBERS, MOST_NUMBERS // len(right))):
        yield {**said, "values": [float(f"{value:.6g}") + 0.0 for value in values]}


def _taken_for_numbers(problem: Problem, part: Part) -> Iterator[tuple[float, Json, list[float]]]:
    for mistake, slip in mistaken_answers(problem.chain, part):
        if isinstance(slip.answer, Number):
            values = [float(value) for value in slip.answer.reference]
            yield 1.0, _named(mistake.name, mistake.sentence(slip.words)), values


def _worked_out_in_numbers(
    problem: Problem, part: Part, precise: bool = False
) -> Iterator[tuple[float, Json, list[float]]]:
    derived, of_answer = _as_derived(part)
    if derived is None:
        return
    for wrong in wrong_answers(_in_numbers(problem, part), derived, precise):
        flat = of_answer(wrong.answer)
        if _says_something(flat) and (derived is part or wrong.mistake.name not in _OF_RATES):
            yield variant_frequency(wrong), _said(wrong), flat.tolist()


def right_in_numbers(problem: Problem, part: Part) -> list[float] | None:
    """Return the answer to a part as the derivation gives it in which mistakes are made; None where there is none."""
    derived, of_answer = _as_derived(part)
    return None if derived is None else of_answer(result(_in_numbers(problem, part), derived)).tolist()


def _instead_of_speed(problem: Problem, part: Part) -> Iterator[tuple[float, Json, list[float]]]:
    """Yield what else is made of the components of a velocity whose length is asked for."""
    if part.kind != "speed":
        return
    derived, _ = _as_derived(part)
    assert derived is not None
    velocity = _flat(result(_in_numbers(problem, part), derived))
    moving = np.abs(velocity[np.abs(velocity) > 1e-9])
    made = [("components-added", moving.sum()), ("components-added", abs(velocity.sum()))]
    made += [("component-alone", component) for component in moving]
    for name, value in [*made, ("speed-squared", (moving**2).sum())]:
        yield 1.0, _named(name, CATALOGUE[name].sentence({})), [float(value)]


def _in_numbers(problem: Problem, part: Part) -> Working:
    rates = part.details.rates if isinstance(part.details, AtRates) else {}
    given = {rate.name: np.array([float(value)]) for rate, value in rates.items()}
    values = sample_configurations(problem.chain, part, problem.domain(), 1, _stream(problem, part)) | given
    return numbers(problem.chain, values)


def _flat(answer: np.ndarray) -> np.ndarray:
    return answer.reshape(-1, answer.shape[-1])[:, 0].real


def _length(answer: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(_flat(answer))])


_OF_CHAPTER = {"determinant-value": ("determinant", _flat), "speed": ("velocity", _length)}
"""Short questions in numbers: which of the chapter's they are about, and how the number comes of its answer."""


_OF_RATES = frozenset({"rates-in-degrees", "rates-in-turns"})
"""Mistakes in joint rates that are asked for, which no short question does."""


def _as_derived(part: Part) -> tuple[Part | None, Callable[[np.ndarray], np.ndarray]]:
    """Return the part that comes out of a derivation, a short question's as the chapter's, and how its numbers do."""
    if is_derived(part) or part.kind not in _OF_CHAPTER:
        return (part if is_derived(part) else None), _flat
    kind, of_answer = _OF_CHAPTER[part.kind]
    return replace(part, kind=kind), of_answer


def _to_few(values: Iterable[float]) -> tuple[str, ...]:
    return tuple(f"{value + 0.0:.3e}" for value in values)


# --- sets of configurations ---


def _configurations(problem: Problem, part: Part, answer: ConditionSet) -> Json:
    joints, symbols = _variables(problem)
    return {
        "type": "configurations", "joints": joints, "symbols": symbols, "pieces": _pieces(problem, part, answer),
        "conditions": _conditions(problem, answer), "mistakes": [],
    }  # fmt: skip


def _variables(problem: Problem) -> tuple[list[str], list[str]]:
    """Return the names of the joint variables, and of all symbols that a pose has values for: lengths among them."""
    joints = [q.name for q in problem.chain.q]
    lengths = {name for name, role in problem.domain().roles.items() if role == "length" or not isinstance(role, str)}
    return joints, sorted({*joints, *lengths})


def _conditions(problem: Problem, answer: ConditionSet) -> list[int]:
    """Return how many of the pieces belong to each condition, or to several that hold together."""
    known, joints = problem.domain().roles, [q.name for q in problem.chain.q]
    groups = answer.by_condition(answer.pieces())
    return [sum(len(pieces(read(text, known), joints)) for text in group) for group in groups]


def _pieces(problem: Problem, part: Part, answer: ConditionSet) -> list[Any]:
    """Return poses on each piece, all symbols' values in a row."""
    (joints, symbols), domain, stream = _variables(problem), problem.domain(), _stream(problem, part)
    space, keys = Space(joints, domain), []
    for text in answer.pieces():
        for piece in pieces(read(text, domain.roles), joints):
            values = space.on_piece(piece, {*joints, *symbols}, stream, 4 * POSES)
            exact = {atom.joint: value_of(atom.zero) for atom in piece if atom.joint is not None}
            poses = np.array([values[name] for name in symbols]).T[:POSES]
            keys.append([[_in_pose(*one) for one in zip(pose, map(exact.get, symbols), strict=True)] for pose in poses])
    return keys


def _in_pose(found: float, exact: Any) -> float:
    """Return a value as it was found, with nine decimals, or the exact one if there is one, as a double."""
    return (float(f"{found:.9f}") if exact is None else float(exact)) + 0.0


# ---


def _stream(problem: Problem, part: Part) -> Stream:
    return Stream(f"site/{problem.id}/{problem.id.engine}/{part.name}")


def _short(value: float) -> float:
    """Return a drawn value with six digits, which are the same whatever the machine's last bit is."""
    return float(f"{float(value):.6g}")


def _double(value: Any) -> float | None:
    """Return a number with 15 digits, None where it is not defined."""
    if isinstance(value, mpmath.mpc):
        value = value.real if abs(value.imag) < 1e-20 * (1 + abs(value.real)) else mpmath.nan
    text = mpmath.nstr(mpmath.mpf(value), 15)
    double = float(text)
    return double + 0.0 if np.isfinite(double) else None
