"""Make the keys for grading in a browser: values of the correct answer and of known mistakes at some configurations.

A key contains numbers but no formulas. The first configurations have two decimals, so that a counterexample can be
checked by hand. Correct values are computed with many digits and written with 15 digits, those of mistakes with 6
digits. So a key has the same bytes on every machine. A key has one of these forms:

    {"type": "values", "symbols": [name], "points": [[value]], "rows": r, "columns": c,
     "right": [[entry at each point]], "constants": [name of a length or constant angle in "symbols"],
     "moving": [index of an entry that contains other symbols than these],
     "linear": {rate, velocity or force: [[its factor in each entry at the first points]]},
     "mistakes": [{"name", "title", "says", "missing": symbols, "print": [number at the first points]}],
     "throughout": [… like "mistakes": the same mistake everywhere in the finished formulas]}
    {"type": "numbers", "units", "tolerance", "floor", "right": [number], "mistakes": [{…, "values": [number]}],
     "precise": [… like "mistakes": considered only for a single number with many digits]}
    {"type": "direction", … like "values", "tolerance": number or null}
    {"type": "configurations", "joints": [name], "symbols": [name], "pieces": [[configuration on the piece]],
     "conditions": [number of pieces of each condition], "mistakes": []}
    {"type": "choice" | "selection" | "matching", "options": count, "items": count, "right": [index],
     "option_mistakes": [[{"name", "title", "says"} of a mistake that leads to a wrong option]]}

"print" is a fingerprint, one number for a whole answer at a configuration: the sum of its entries, row by row, each
times `compute_weight(index)`. For a direction, it is the absolute value of this sum for its unit vector. In the key of
a numeric direction, mistakes have that unit vector as "values". A set of configurations is the union of its pieces;
theta2 = 0 and theta2 = pi are the pieces of sin(theta2) = 0. Single mistakes in a formula and mistakes in conditions
are not in the key, because the page finds them itself (site/src/grade/slips.ts, set-slips.ts).
"""

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import mpmath
import numpy as np

from qdot.exercises.arm.trigonometry import write_in_textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import (
    StageResults,
    compute_numeric_stages,
    compute_symbolic_stages,
    to_sympy_matrix,
)
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.formula.equality import Domain, round_to_six_digits
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate, evaluate_constant, evaluate_precisely
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import as_matrix, find_names
from qdot.exercises.mistakes import catalogue
from qdot.exercises.mistakes.catalogue import PredictedAnswer
from qdot.exercises.mistakes.configurations import SymbolValues, fix_given_joints, sample_configurations
from qdot.exercises.mistakes.formula_edits import edit_all_entries
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json
from qdot.exercises.questions.custom.question import CustomDetails, DefinitionEvaluator
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step
from qdot.exercises.reference_answers import Answer, AnswerVisitor, ConditionSet, Direction, Letters, Number
from qdot.exercises.short_questions.option_mistakes import explain_options
from qdot.exercises.short_questions.single_configuration import RateDetails
from qdot.exercises.writing.problem_texts import write_answer_code

POINT_COUNT, SAMPLED_POINT_COUNT = 16, 24
"""Number of configurations in a key, and number of sampled configurations.

More are sampled, because the answer may be undefined at some of them."""
MAX_ENTRY = 1e8
"""Maximum of an entry. A larger entry means that the arm is nearly singular, so that rounding hides differences."""
MIN_POINT_COUNT, FINGERPRINT_POINT_COUNT = 3, 2
"""Minimum number of configurations in a key, and number of configurations at which mistakes are evaluated."""
MAX_MISTAKES, MAX_NUMERIC_MISTAKES, MAX_MISTAKE_NUMBERS = 60, 160, 500
"""Maximum number of mistakes in formulas, of mistakes in a numeric answer, and of all numbers of these mistakes."""
ALWAYS_INCLUDED = (
    *catalogue.NUMERIC_MISTAKES, "transposed", "cross-order", "sign", "transpose-for-inverse",
    "determinant-forgotten", "jacobian-for-inverse", "degrees",
)  # fmt: skip
"""Mistakes that are always included, because they are frequent but come late in the catalogue."""
THROUGHOUT_MISTAKES = (
    "lengths-missing", "relative-throughout", "trig-throughout", "constants-left-out", "constants-sign",
    "constants-in-degrees", "constants-wrong-radians", "sum-of-angles-split",
)  # fmt: skip
"""Mistakes that a student makes everywhere in the finished formulas, the likeliest first."""
MAX_THROUGHOUT_MISTAKES = 16
"""Maximum number of variants of THROUGHOUT_MISTAKES in a key."""
CONFIGURATIONS_PER_PIECE = 6
"""Number of configurations on each piece of a singular set."""
GOLDEN_RATIO = 0.6180339887498949
"""The golden ratio minus one, for the weights of entries."""
DIGITS = 30
"""Number of digits in the computation of correct values."""


def compute_weight(index: int) -> float:
    """Return the weight of entry number `index` (from 0) in the fingerprint ("print") of an answer.

    >>> compute_weight(0), round(compute_weight(1), 6)
    (1.0, 1.618034)
    """
    return 1.0 + (index * GOLDEN_RATIO) % 1.0


def make_key(problem: Problem, part: Part, with_mistakes: bool = True) -> Json:
    """Return the key of a part, with known mistakes if `with_mistakes`; finding these takes most of the time."""
    return _KeyMaker(problem, part, with_mistakes).visit(part.answer)


@dataclass(frozen=True)
class _KeyMaker(AnswerVisitor[Json]):
    """Makes the key of a part; each method handles one form of answer."""

    problem: Problem
    part: Part
    with_mistakes: bool

    def visit_formulas(self, answer: Answer) -> Json:
        key, points = _make_formula_key(self.problem, self.part)
        if not self.with_mistakes:
            return key
        key["mistakes"] = list(_find_mistakes_in_formulas(self.problem, self.part, points))
        if not answer.is_direction:
            if coefficients := _find_linear_coefficients(self.problem, self.part, points):
                key["linear"] = coefficients
            if mistakes_throughout := list(_find_mistakes_throughout(self.problem, self.part, points, key)):
                key["throughout"] = mistakes_throughout
        return key

    def visit_direction(self, answer: Direction) -> Json:
        key = self.visit_formulas(answer) if answer.tolerance is None else self._make_numeric_direction()
        return key | {"type": "direction", "tolerance": answer.tolerance}

    def _make_numeric_direction(self) -> Json:
        key, _ = _make_formula_key(self.problem, self.part)
        reference = np.array([entry[0] for entry in key["right"]], dtype=float)
        unit_vectors = _find_wrong_unit_vectors(self.problem, self.part, reference)
        mistakes = _select_likeliest_mistakes(unit_vectors, reference / np.linalg.norm(reference))
        return key | {"mistakes": self._collect(mistakes)}

    def visit_number(self, answer: Number) -> Json:
        mistakes = self._collect(_find_mistakes_in_numbers(self.problem, self.part, answer))
        tolerance, floors = answer.find_allowed_errors(self.part.rounding)
        key: Json = {
            "type": "numbers", "units": list(answer.units), "tolerance": tolerance, "floor": min(floors),
            "right": [_to_double(float(value)) for value in answer.reference], "mistakes": mistakes,
        }  # fmt: skip
        if max(floors) > min(floors):
            key["floors"] = floors
        if answer.shape == (1, 1):  # unlikely mistakes, which would match a number with few digits by chance
            known_values = {tuple(mistake["values"]) for mistake in mistakes}
            precise_mistakes = self._collect(_find_mistakes_in_numbers(self.problem, self.part, answer, True))
            key["precise"] = [mistake for mistake in precise_mistakes if tuple(mistake["values"]) not in known_values]
        return key

    def visit_singular(self, answer: ConditionSet) -> Json:
        joints, symbols = _list_variables(self.problem)
        pieces = _sample_pieces(self.problem, self.part, answer)
        return {
            "type": "configurations", "joints": joints, "symbols": symbols, "pieces": pieces,
            "conditions": _count_pieces(self.problem, answer), "mistakes": [],
            **({} if answer.is_singular_set else {"zeros": _write_zeros(self.problem, self.part)}),
        }  # fmt: skip

    def visit_letters(self, answer: Letters) -> Json:
        explanations = self._explain_options() if self.with_mistakes else [[] for _ in answer.options]
        return {
            "type": answer.type, "options": len(answer.options), "items": len(answer.matched_items),
            "right": list(answer.correct_indices), "option_mistakes": explanations,
        }  # fmt: skip

    def _explain_options(self) -> list[list[Json]]:
        option_blames = explain_options(self.problem, self.part, _make_stream(self.problem, self.part))
        return [[_make_mistake_record(blame.mistake, blame.sentence) for blame in blames] for blames in option_blames]

    def _collect(self, mistakes: Iterator[Json]) -> list[Json]:
        """Return the records of mistakes; if the key has none, return an empty list without computing them."""
        return list(mistakes) if self.with_mistakes else []


# --- formulas ---


def _make_formula_key(problem: Problem, part: Part) -> tuple[Json, SymbolValues]:
    """Return the key of a part without the mistakes, and the configurations in the key."""
    texts, shape = part.answer.list_formulas(), part.shape or (1, 1)
    key = make_values_key(texts, shape, problem.domain, _make_stream(problem, part))
    reference = part.answer.as_matrix()
    symbols_by_entry = [{symbol.name for symbol in entry.free_symbols} for entry in reference]
    symbolic_names = {name for name, role in problem.domain.roles.items() if isinstance(role, str)}
    key["constants"] = sorted(problem.constants & {*key["symbols"]} & symbolic_names)
    key["moving"] = [index for index, symbols in enumerate(symbols_by_entry) if symbols - problem.constants]
    columns = zip(*key["points"], strict=True)
    return key, {name: np.array(column) for name, column in zip(key["symbols"], columns, strict=True)}


def _find_linear_coefficients(problem: Problem, part: Part, points: SymbolValues) -> Json:
    """For each rate, velocity or force in which all entries are linear, return its coefficient in each entry."""
    nodes = [parse_formula(text, problem.domain.roles) for text in part.answer.list_formulas()]
    program, used_names = compile_program(nodes), set().union(*map(find_names, nodes))
    first_points = {name: column[:FINGERPRINT_POINT_COUNT] for name, column in points.items() if name in used_names}
    coefficients = {}
    for name, symbol in problem.symbols.items():
        if name in used_names and symbol.role in ("rate", "velocity", "force"):
            samples = (first_points | {name: first_points[name] * 0 + value} for value in range(3))
            entries = [evaluate(program, sample, FINGERPRINT_POINT_COUNT).values.real for sample in samples]
            slopes = entries[1] - entries[0]
            if np.allclose(entries[2] - entries[1], slopes, rtol=1e-9, atol=1e-12):
                coefficients[name] = [[round_to_six_digits(slope) + 0.0 for slope in row] for row in slopes]
    return coefficients


def make_values_key(texts: Sequence[str], shape: tuple[int, int], domain: Domain, stream: Stream) -> Json:
    """Return the key of formulas (texts of the entries of a matrix with this shape), without mistakes.

    Raises ValueError if the formulas are defined at too few configurations.
    """
    nodes = [parse_formula(text, domain.roles) for text in texts]
    points = domain.sample(set(domain.roles), SAMPLED_POINT_COUNT, stream)
    symbols = sorted(points)
    fixed_names = {name for name, role in domain.roles.items() if not isinstance(role, str)}
    program = compile_program(nodes)
    used_names = sorted(set().union(*map(find_names, nodes)) & set(points))
    rows_of_points: list[list[float]] = []
    correct: list[list[float | None]] = []
    for k in range(SAMPLED_POINT_COUNT):
        point = {name: float(points[name][k]) for name in symbols}
        point |= {name: round_to_six_digits(value) for name, value in point.items() if name not in fixed_names}
        shown_decimals = {name: mpmath.mpf(repr(point[name])) for name in used_names}  # exactly as on the page
        values = list(map(_to_double, evaluate_precisely(program, shown_decimals, DIGITS)))
        if all(value is not None and abs(value) < MAX_ENTRY for value in values):
            rows_of_points.append(list(point.values()))
            correct.append(values)
        if len(correct) == POINT_COUNT:
            break
    if len(correct) < MIN_POINT_COUNT:
        raise ValueError(f"the reference is defined at {len(correct)} of {SAMPLED_POINT_COUNT} configurations: {texts}")
    return {
        "type": "values", "symbols": symbols, "points": rows_of_points, "rows": shape[0], "columns": shape[1],
        "right": [list(entry) for entry in zip(*correct, strict=True)], "mistakes": [],
    }  # fmt: skip


def _find_mistakes_in_formulas(problem: Problem, part: Part, points: SymbolValues) -> Iterator[Json]:
    """Yield the records of the known mistakes that lead to different wrong answers in formulas."""
    if not is_derived_step_by_step(part):
        return
    first_points = {name: column[:FINGERPRINT_POINT_COUNT] for name, column in points.items()}
    is_direction = part.answer.is_direction
    values = fix_given_joints(part, first_points) if is_direction else first_points
    stages = compute_numeric_stages(problem.chain, values)
    known_fingerprints = {_compute_fingerprint(compute_answer(stages, part), is_direction)}
    opposite_fingerprint = _compute_fingerprint(-compute_answer(stages, part))
    for prediction in _predict_enough_wrong_answers(stages, part, known_fingerprints):
        if prediction.answer.shape[:2] != (part.shape or (1, 1)) or not _is_finite_and_nonzero(prediction.answer):
            continue
        fingerprint = _compute_fingerprint(prediction.answer, is_direction)
        if fingerprint == opposite_fingerprint and prediction.mistake.name in catalogue.SIGN_MISTAKES_AT_ONE_PLACE:
            continue
        is_constant = is_direction and len(set(fingerprint)) == 1  # many mistakes lead to a constant
        if fingerprint not in known_fingerprints and not is_constant:
            known_fingerprints.add(fingerprint)
            yield {**_make_prediction_record(prediction), "print": [float(text) for text in fingerprint]}


def _find_mistakes_throughout(problem: Problem, part: Part, points: SymbolValues, key: Json) -> Iterator[Json]:
    """Yield the records of mistakes that are made everywhere in the finished formulas, the likeliest first."""
    first_points = {name: column[:FINGERPRINT_POINT_COUNT] for name, column in points.items()}
    rows = as_matrix(parse_formula(write_answer_code(problem, part), problem.domain.roles))
    reference_names = set().union(*(find_names(entry) for row in rows for entry in row))
    edits = list(edit_all_entries(rows))
    likely_edits = [edit for likely_name in THROUGHOUT_MISTAKES for edit in edits if edit[0] == likely_name]
    correct = np.array(key["right"])[:, :FINGERPRINT_POINT_COUNT].reshape(key["rows"], key["columns"], -1)
    known_fingerprints = {_compute_fingerprint(correct)}
    for name, edited_rows in likely_edits[:MAX_THROUGHOUT_MISTAKES]:
        entries = [entry for row in edited_rows for entry in row]
        values, _ = evaluate(compile_program(entries), first_points, FINGERPRINT_POINT_COUNT)
        if not np.isfinite(values).all() or (fingerprint := _compute_fingerprint(values)) in known_fingerprints:
            continue
        known_fingerprints.add(fingerprint)
        missing_names = reference_names - set().union(*map(find_names, entries)) if name == "lengths-missing" else set()
        sentence = catalogue.CATALOGUE[name].format_message({"Where": "In your answer,"})
        mistake = _make_mistake_record(name, sentence, ", ".join(sorted(missing_names)))
        yield {**mistake, "print": [float(text) for text in fingerprint]}


def _predict_enough_wrong_answers(
    stages: StageResults, part: Part, known_answers: Collection[object]
) -> Iterator[PredictedAnswer]:
    """Yield wrong answers of mistakes from the catalogue until there are enough, then those of ALWAYS_INCLUDED.

    The caller adds each new wrong answer to `known_answers` before it asks for the next one.
    """
    for prediction in catalogue.predict_wrong_answers(stages, part):
        if len(known_answers) > MAX_MISTAKES:
            break
        yield prediction
    else:
        return
    for mistake in catalogue.list_likely_mistakes(part):
        if mistake.name in ALWAYS_INCLUDED:
            yield from catalogue.apply_mistake(mistake, stages, part)


class _NumericMistake(NamedTuple):
    """A mistake in a numeric answer: its frequency, its record, and the wrong numbers that it leads to."""

    frequency: float
    record: Json
    values: list[float]


def _find_wrong_unit_vectors(problem: Problem, part: Part, correct: np.ndarray) -> Iterator[_NumericMistake]:
    """Yield the unit vectors that mistakes lead to, each with the sign for which it is nearer to the correct vector."""
    for mistake in _find_derived_mistakes(problem, part):
        unit = np.array(mistake.values) / np.linalg.norm(mistake.values)
        yield mistake._replace(values=(unit * (np.sign(unit @ correct) or 1.0)).tolist())


def _select_likeliest_mistakes(mistakes: Iterable[_NumericMistake], correct: Iterable[float]) -> Iterator[Json]:
    """Yield the record of the most frequent mistake for every different wrong answer."""
    correct_texts = _round_to_texts(correct)
    mistake_by_texts: dict[tuple[str, ...], _NumericMistake] = {}
    for mistake in mistakes:
        texts = _round_to_texts(mistake.values)
        is_wrong = len(texts) == len(correct_texts) and texts != correct_texts
        if is_wrong and (texts not in mistake_by_texts or mistake_by_texts[texts].frequency < mistake.frequency):
            mistake_by_texts[texts] = mistake
    max_count = min(MAX_NUMERIC_MISTAKES, MAX_MISTAKE_NUMBERS // len(correct_texts))
    for mistake in itertools.islice(mistake_by_texts.values(), max_count):
        yield {**mistake.record, "values": [round_to_six_digits(value) + 0.0 for value in mistake.values]}


def _compute_fingerprint(answer: np.ndarray, is_direction: bool = False) -> tuple[str, ...]:
    """Return the fingerprint of an answer (rows, columns, points): a number for each point, as text.

    If `is_direction`, return the fingerprint of the unit vector along the answer, without its sign.
    """
    entries = answer.reshape(-1, answer.shape[-1])
    if is_direction:
        entries = entries / np.sqrt((np.abs(entries) ** 2).sum(axis=0))
    values = np.asarray(sum(compute_weight(i) * entry for i, entry in enumerate(entries))).real
    return tuple(f"{value:.5e}" for value in (np.abs(values) if is_direction else values))


def _is_finite_and_nonzero(answer: np.ndarray) -> bool:
    """Return whether all entries are finite, and some entry is not zero."""
    return bool(np.isfinite(answer).all() and (np.abs(answer) > 1e-9).any())


def _make_prediction_record(prediction: PredictedAnswer) -> Json:
    return _make_mistake_record(prediction.mistake.name, prediction.sentence, prediction.variant.missing_symbols)


def _make_mistake_record(mistake: str, sentence: str, missing_names: str = "") -> Json:
    record = {"name": mistake, "title": catalogue.CATALOGUE[mistake].title, "says": sentence}
    return record | {"missing": missing_names} if missing_names else record


# --- numbers ---


def _find_mistakes_in_numbers(problem: Problem, part: Part, answer: Number, is_precise: bool = False) -> Iterator[Json]:
    """Return the records of the mistakes that lead to different wrong numbers.

    For a single number, only the likely mistakes are considered, unless the number has many digits (`is_precise`).
    """
    mistakes = itertools.chain(
        _list_mistaken_answers(problem, part), _list_speed_mistakes(problem, part),
        _find_derived_mistakes(problem, part, is_precise),
    )  # fmt: skip
    return _select_likeliest_mistakes(mistakes, map(float, answer.reference))


def _list_mistaken_answers(problem: Problem, part: Part) -> Iterator[_NumericMistake]:
    """Yield the wrong numbers of mistakes that are defined for this question alone."""
    for mistake, mistaken_answer in catalogue.generate_mistaken_answers(problem.chain, part):
        if isinstance(mistaken_answer.answer, Number):
            values = [float(value) for value in mistaken_answer.answer.reference]
            record = _make_mistake_record(mistake.name, mistake.format_message(mistaken_answer.words))
            yield _NumericMistake(1.0, record, values)


def _find_derived_mistakes(problem: Problem, part: Part, is_precise: bool = False) -> Iterator[_NumericMistake]:
    """Yield the wrong numbers that follow from a mistake in the derivation."""
    derived_part, extract_numbers = _find_derived_question(part)
    if derived_part is None:
        return
    for prediction in catalogue.predict_wrong_answers(_evaluate_derivation(problem, part), derived_part, is_precise):
        numbers = extract_numbers(prediction.answer)
        if _is_finite_and_nonzero(numbers) and (derived_part is part or prediction.mistake.name not in _RATE_MISTAKES):
            yield _NumericMistake(prediction.frequency, _make_prediction_record(prediction), numbers.tolist())


def _list_speed_mistakes(problem: Problem, part: Part) -> Iterator[_NumericMistake]:
    """Yield wrong speeds that students compute from the components of a velocity; nothing for other questions."""
    if part.kind != "speed":
        return
    derived_part, _ = _find_derived_question(part)
    assert derived_part is not None
    velocity = _take_first_values(compute_answer(_evaluate_derivation(problem, part), derived_part))
    nonzero_components = np.abs(velocity[np.abs(velocity) > 1e-9])
    wrong_speeds = [("components-added", nonzero_components.sum()), ("components-added", abs(velocity.sum()))]
    wrong_speeds += [("component-alone", component) for component in nonzero_components]
    for name, value in [*wrong_speeds, ("speed-squared", (nonzero_components**2).sum())]:
        record = _make_mistake_record(name, catalogue.CATALOGUE[name].format_message({}))
        yield _NumericMistake(1.0, record, [float(value)])


def _evaluate_derivation(problem: Problem, part: Part) -> StageResults:
    """Return the derivation in numbers, at the configuration and the joint rates of a question."""
    rates = part.details.rates if isinstance(part.details, RateDetails) else {}
    rate_values = {rate.name: np.array([float(value)]) for rate, value in rates.items()}
    values = sample_configurations(problem.chain, part, problem.domain, 1, _make_stream(problem, part)) | rate_values
    return compute_numeric_stages(problem.chain, values)


def _take_first_values(answer: np.ndarray) -> np.ndarray:
    """Return the entries of an answer at its first configuration."""
    return answer.reshape(-1, answer.shape[-1])[:, 0].real


def _compute_norm(answer: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(_take_first_values(answer))])


_CHAPTER_QUESTIONS = {"determinant-value": ("determinant", _take_first_values), "speed": ("velocity", _compute_norm)}
"""Maps each numeric short question to the chapter's question from which it follows, and a function that extracts the
number."""


_RATE_MISTAKES = frozenset({"rates-in-degrees", "rates-in-turns"})
"""Mistakes in joint rates; no short question asks for joint rates."""


def _find_derived_question(part: Part) -> tuple[Part | None, Callable[[np.ndarray], np.ndarray]]:
    """Return a question that the stages answer, and a function that extracts the part's numbers from it.

    The question is the part itself, or the chapter's question from which it follows; None if there is no such question.
    """
    if is_derived_step_by_step(part):
        return part, _take_first_values
    if part.kind not in _CHAPTER_QUESTIONS:
        return None, _take_first_values
    kind, extract_numbers = _CHAPTER_QUESTIONS[part.kind]
    return replace(part, kind=kind), extract_numbers


def _round_to_texts(values: Iterable[float]) -> tuple[str, ...]:
    """Return numbers with four digits; numbers with equal texts count as the same answer."""
    return tuple(f"{value + 0.0:.3e}" for value in values)


# --- sets of configurations ---


def _list_variables(problem: Problem) -> tuple[list[str], list[str]]:
    """Return the names of the joint variables, and of all symbols with values in the key: joints and lengths."""
    joints = [q.name for q in problem.chain.q]
    lengths = {name for name, role in problem.domain.roles.items() if role == "length" or not isinstance(role, str)}
    return joints, sorted({*joints, *lengths})


def _write_zeros(problem: Problem, part: Part) -> list[str]:
    """Return the formulas that are zero in an instructor's set of configurations."""
    details = part.details_as(CustomDetails)
    zeros = DefinitionEvaluator(details.definition).compute_zeros(compute_symbolic_stages(problem.chain), details)
    return [format_expression(write_in_textbook_form(zero)) for zero in to_sympy_matrix(zeros)]


def _count_pieces(problem: Problem, answer: ConditionSet) -> list[int]:
    """Return the number of pieces of each component of the singular set."""
    joints, _ = _list_variables(problem)
    space = ConfigurationSpace(joints, problem.domain)
    groups = answer.group_by_component([parse_formula(text, problem.domain.roles) for text in answer.list_pieces()])
    return [len(space.parse_reference(group)) for group in groups]


def _sample_pieces(problem: Problem, part: Part, answer: ConditionSet) -> list[Any]:
    """Return configurations on each piece of the singular set; each is a row with the values of all symbols."""
    joints, symbols = _list_variables(problem)
    domain, stream = problem.domain, _make_stream(problem, part)
    space = ConfigurationSpace(joints, domain)
    rows_by_piece = []
    for text in answer.list_pieces():
        for piece in space.parse_reference([parse_formula(text, domain.roles)]):
            # Some of the sampled configurations can't be moved onto the piece, so more than needed are sampled.
            values = space.sample_piece(piece, {*joints, *symbols}, stream, 4 * CONFIGURATIONS_PER_PIECE)
            exact_values = {atom.joint: evaluate_constant(atom.expression) for atom in piece if atom.joint is not None}
            columns = []
            for name in symbols:
                exact_value = exact_values.get(name)
                columns.append(
                    [float(f"{value:.9f}" if exact_value is None else exact_value) + 0.0 for value in values[name]]
                )
            rows_by_piece.append([list(row) for row in zip(*columns, strict=True)][:CONFIGURATIONS_PER_PIECE])
    return rows_by_piece


def _make_stream(problem: Problem, part: Part) -> Stream:
    return Stream(f"site/{problem.id}/{problem.id.engine}/{part.name}")


def _to_double(value: Any) -> float | None:
    """Return a number rounded to 15 digits, or None if it is not real and finite."""
    real_value = value
    if isinstance(value, mpmath.mpc):  # of DIGITS digits, so a tiny imaginary part is a rounding error
        real_value = value.real if abs(value.imag) < 1e-20 * (1 + abs(value.real)) else mpmath.nan
    number = float(mpmath.nstr(mpmath.mpf(real_value), 15))
    return number + 0.0 if np.isfinite(number) else None
