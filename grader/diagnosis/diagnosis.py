"""Name the mistake behind a wrong answer: the one of the catalogue that gives the very same answer.

Answers are compared at random configurations, or at the one that is given. If no mistake of the catalogue gives the
whole answer, what is wrong is told entry by entry. What gives neither is not guessed at.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ReadError, as_matrix, digits_of_decimals
from qdot.exercises.mistakes.catalogue import (
    ALIKE,
    CATALOGUE,
    Wrong,
    make_mistake,
    variant_frequency,
    wrong_answers,
)
from qdot.exercises.mistakes.configurations import Values, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import read_vector
from qdot.exercises.questions.results import is_derived, is_made_of_jacobian, is_product, result
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.problem_texts import answer_code
from qdot.grader.diagnosis.formula_mistakes import TOO_MANY, Compared, explain_formulas
from qdot.grader.diagnosis.numbers import SAME, InNumbers, says_something, unit
from qdot.grader.diagnosis.residuals import missing_links
from qdot.grader.diagnosis.rounding import explain_rounded_function, explain_rounding, is_right
from qdot.grader.diagnosis.set_mistakes import explain_set, find_mistaken_answer, name_either
from qdot.grader.judging.answer import ParsedAnswer, Table
from qdot.grader.judging.verdict import Diagnosis, locate_mistake

POINTS = 16
THREE_DECIMALS = 6e-4
LEAST_LIKELY = 0.2
"""Prior of a mistake below which a slip in one place of the finished formulas is likelier."""
VERY_LIKELY = 2.0
"""Prior of a mistake throughout an answer that is likelier than the wrong sign of a single entry."""
MOST_IN_ONE_PLACE = 2
"""Wrong entries that one slip may make in finished formulas."""
EXTRA = set(TOO_MANY.values())
SIGNS = {"term-sign-typed", "entry-sign"}
EXCHANGED = {"wave-throughout"}
"""What is likelier than the same slip at several joints."""
OF_ONE_PLACE = {"joint", "link", "one"}
"""Words of mistakes that were made in one place: others change everything, and hardly the sign of one entry only."""
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
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str = "", causes: Sequence[Cause] = ()
) -> Diagnosis | None:
    """Return the mistake that gives a wrong answer, or nothing where none in the catalogue does.

    One of the `causes` that were found in earlier parts is told as that. `seed` draws the configurations at which the
    answer is compared with what mistakes give.

    >>> from qdot import generate
    >>> from qdot import read_answer
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> (part,) = problem.parts
    >>> diagnose(problem, part, read_answer(problem, part, "d2 + 0.7")).mistakes
    ('determinant-sign',)
    """
    if parsed_answer.table is None:
        option_mistakes = _explain_option(part, parsed_answer)
        if option_mistakes is not None:
            return option_mistakes
        is_short = len(parsed_answer.text) <= LONGEST_SET
        if part.answer.is_a_set:
            return explain_set(problem, part, parsed_answer, seed) if is_short else None
        mistaken = find_mistaken_answer(problem, part, parsed_answer, seed) if is_short else None
        if mistaken is not None:
            return mistaken
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return None
    values, right = wrong_answer.in_numbers, wrong_answer.right
    if parsed_answer.table is None:
        rounding = explain_rounding(part, values, right, parsed_answer.entries)
    else:
        rounding = explain_rounded_function(values, right)
    if rounding or is_right(values, right):  # as are mistakes that make no difference on this arm
        return rounding
    return _explain(wrong_answer.upright, causes)


def is_one_mistake(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Tell whether a single known mistake gives all that is wrong in an answer in formulas or in several numbers.

    What such a mistake would spoil besides may be right: no cause is named then, but a better answer never earns less.
    Only what is quickly found counts, so that no mark hangs on how long mistakes are looked for.
    """
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return False
    values, right = wrong_answer.in_numbers, wrong_answer.right
    if values.values.shape != right.shape or is_right(values, right):
        return False
    is_wrong = ~values.like(right)
    is_filled = np.abs(values.values[is_wrong]).max(axis=-1) > SAME  # zeros are given by many
    for wrong in wrong_answers(wrong_answer.w, part, values.is_precise) if is_filled.any() else ():
        fits = wrong.answer.shape == right.shape and (values.like(wrong.answer) | ~is_wrong).all()
        if fits and says_something(wrong.answer):
            return True
    if is_product(part) or not is_filled.all():  # of a product the factors count
        return False
    one_kind = (missing_links(wrong_answer.w, part, right, values.values), _explain_formulas(wrong_answer))
    return any(diagnosis is not None and diagnosis.is_one for diagnosis in one_kind)


# --- the answer in numbers ---


@dataclass(frozen=True)
class WrongAnswer:
    """A wrong answer with its values at configurations, and its formulas as they were typed, if there are any."""

    problem: Problem
    part: Part
    values: Values
    in_numbers: InNumbers
    rows: Rows | None = None

    @cached_property
    def w(self) -> Working:
        """The right derivation at the configurations."""
        return numbers(self.problem.chain, self.values)

    @cached_property
    def right(self) -> np.ndarray:
        """The right answer, (rows, columns, N)."""
        return result(self.w, self.part)

    @cached_property
    def derivatives(self) -> np.ndarray:
        """Which entries are differentiated, (rows, columns): no angular ones, and not what is made of a Jacobian."""
        if is_made_of_jacobian(self.part):
            return np.zeros(self.right.shape[:2], bool)
        doubled = result(self.w.with_mistakes({"linear": lambda _, rows: 2 * rows}), self.part)
        return np.asarray((np.abs(doubled - self.right) > SAME * np.abs(self.right)).any(axis=-1))

    @property
    def upright(self) -> "WrongAnswer":
        """The same, a vector that was typed as a row or column in the shape that is right."""
        shape, transposed = self.right.shape, self.in_numbers.values.swapaxes(0, 1)
        if 1 not in shape[:2] or self.in_numbers.values.shape == shape or transposed.shape != shape:
            return self
        in_numbers = replace(self.in_numbers, values=transposed, size=self.in_numbers.size.swapaxes(0, 1))
        return replace(self, in_numbers=in_numbers, rows=None if self.rows is None else _transpose(self.rows))


def _evaluate_answer(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> WrongAnswer | None:
    """Return an answer with its values at configurations, None where no mistakes in the derivation are known."""
    if not is_derived(part):
        return None
    if parsed_answer.table is not None:
        return _evaluate_function(problem, part, parsed_answer.table)
    values = sample_configurations(problem.chain, part, problem.domain(), POINTS, Stream(f"{seed}/diagnosis"))
    try:
        in_numbers = (
            _parse_option(part, parsed_answer)
            if part.answer.offered
            else _evaluate_entries(part, parsed_answer, values)
        )
    except ReadError:  # statements among the entries of an answer that was refused
        return None
    return None if in_numbers is None else WrongAnswer(problem, part, values, in_numbers, parsed_answer.rows)


def _evaluate_function(problem: Problem, part: Part, table: Table) -> WrongAnswer | None:
    """Return a function with what it returned where it was called."""
    if table.shape is None or len(table.shape) > 2:
        return None
    values = {name: column[:POINTS] for name, column in table.at.items()}
    rows = (*table.shape, *(1,) * (2 - len(table.shape)))
    returned = table.values[:POINTS].T.reshape(*rows, -1)
    room = (max(SAME, part.rounding.relative), part.rounding.absolute) if part.rounding else (SAME, 0.0)
    is_direction = part.answer.counts_up_to_a_factor
    return WrongAnswer(problem, part, values, InNumbers(returned, np.abs(returned), room, is_direction))


def _evaluate_entries(part: Part, parsed_answer: ParsedAnswer, values: Values) -> InNumbers | None:
    entries, blanks = parsed_answer.entries, parsed_answer.blanks
    if parsed_answer.rows is None or all(blanks) or parsed_answer.symbols - set(values):
        return None
    filled = [Node("name", value="pi") if blank else entry for entry, blank in zip(entries, blanks, strict=True)]
    count = len(next(iter(values.values())))
    evaluated, size = evaluate(compile_program(filled), values, count)
    evaluated[blanks] = np.nan
    shape, is_direction = (
        (len(parsed_answer.rows), len(parsed_answer.rows[0]), count),
        part.answer.counts_up_to_a_factor,
    )
    return InNumbers(evaluated.reshape(shape), size.reshape(shape), _room(part, filled), is_direction)


def _room(part: Part, entries: Sequence[Node]) -> tuple[float, float]:
    """Return what an answer may be off: what is asked for in digits, or what was typed where that is more."""
    relative, absolute = (0.0, 0.0) if part.rounding is None else (part.rounding.relative, part.rounding.absolute)
    if not part.answer.is_in_numbers:
        return max(SAME, relative), absolute
    digits = max(map(digits_of_decimals, entries))
    return max(min(relative or 5e-3, 0.6 * 10.0 ** (1 - max(digits, 3))), 1e-5), 0.0


def _parse_option(part: Part, parsed_answer: ParsedAnswer) -> InNumbers | None:
    if not parsed_answer.chosen:
        return None
    values = np.array(read_vector(part.answer.offered[parsed_answer.chosen[0]]))[:, None, None]
    return InNumbers(values, np.abs(values), (0.0, THREE_DECIMALS))


# --- the mistake behind it ---


def _explain_option(part: Part, parsed_answer: ParsedAnswer) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, as they were kept when it was made."""
    for index in parsed_answer.chosen:
        blames = [] if index in part.answer.right else list_blames(part, index)
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


def _explain(answer: WrongAnswer, causes: Sequence[Cause]) -> Diagnosis | None:
    """Return the mistake that gives an answer at configurations, or nothing.

    Of several that do, one that was found in an earlier part is the cause here, too; else the likeliest is told. Where
    none does, what is wrong is told entry by entry, if it is one thing in each.
    """
    in_numbers, right, part = answer.in_numbers, answer.right, answer.part
    if in_numbers.is_direction and _moves(right, in_numbers.values):
        return Diagnosis(("direction-that-moves",), CATALOGUE["direction-that-moves"].sentence({}))
    fitting = []
    for wrong in wrong_answers(answer.w, part, in_numbers.is_precise):
        if _gives(wrong, in_numbers):
            if cause := _find_cause(wrong, causes):
                return _name_inherited(wrong, cause)
            fitting.append(wrong)
            if not causes and variant_frequency(wrong) >= 1:
                break
    if fitting:
        return _name_likeliest(answer, fitting)
    if in_numbers.values.shape != right.shape or in_numbers.is_direction:
        return None
    return (
        missing_links(answer.w, part, right, in_numbers.values)
        or _explain_formulas(answer)
        or _explain_formulas(answer, any_number=True)
    )


def _gives(wrong: Wrong, in_numbers: InNumbers) -> bool:
    return in_numbers.is_all(wrong.answer) and says_something(wrong.answer)


def _moves(lost: np.ndarray, direction: np.ndarray) -> bool:
    """Tell whether a direction is one in which the arm can move: it has no part along the one that is lost."""
    if lost.shape != direction.shape or lost.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        along = np.abs((unit(lost) * unit(direction)).sum(axis=0))
    return bool(np.isfinite(along).all() and (along < 1e-3).all())


def _find_cause(wrong: Wrong, causes: Sequence[Cause]) -> Cause | None:
    return next((c for c in causes if (c.mistake, c.words) == (wrong.mistake.name, dict(wrong.variant.words))), None)


def _name_inherited(wrong: Wrong, cause: Cause) -> Diagnosis:
    """Return what is said of a mistake that was found before."""
    says = f"This follows from what went wrong in {cause.title!r}: the same mistake gives this answer."
    made = locate_mistake(wrong.mistake.name, wrong.variant.words)
    return Diagnosis((), says, inherited=cause.part, known_by=(made,))


def _name_likeliest(answer: WrongAnswer, fitting: Sequence[Wrong]) -> Diagnosis:
    """Return the mistake with the highest prior, or the first two of them; a slip in one place may be likelier."""
    in_numbers, first = answer.in_numbers, max(fitting, key=variant_frequency)
    alike = list(ALIKE.get(first.mistake.name, ()))
    if in_numbers.is_direction and first.mistake.name == "row-sign":  # one row against the others, either of them
        alike.append("row-sign")
    ways = (wrong for name in alike for wrong in make_mistake(CATALOGUE[name], answer.w, answer.part))
    rivals = [first, *(wrong for wrong in ways if _gives(wrong, in_numbers) and wrong.sentence != first.sentence)]
    highest = max(map(variant_frequency, rivals))
    count = int((~in_numbers.like(answer.right)).sum()) if in_numbers.values.shape == answer.right.shape else 0
    is_rare = highest < LEAST_LIKELY and count <= MOST_IN_ONE_PLACE
    is_throughout = count == 1 < in_numbers.values[..., 0].size and not OF_ONE_PLACE & set(first.variant.words)
    is_at_several = first.mistake.rare and len(first.variant.places) > 1
    is_less_likely = is_rare or is_at_several or (is_throughout and highest < VERY_LIKELY)
    slip = _explain_formulas(answer) if count and not in_numbers.is_direction and is_less_likely else None
    if slip is not None:
        is_likelier = is_rare and not EXTRA & set(slip.mistakes)
        if is_likelier or set(slip.mistakes) <= (EXCHANGED if is_at_several else SIGNS):
            return slip
    likeliest = [wrong for wrong in rivals if variant_frequency(wrong) == highest][:2]
    diagnosis = name_either([(wrong.mistake, wrong.variant.words, _sentence(wrong)) for wrong in likeliest])
    cause = (likeliest[0].mistake.name, dict(likeliest[0].variant.words)) if len(likeliest) == 1 else None
    return replace(diagnosis, cause=cause)


def _sentence(wrong: Wrong) -> str:
    missing = wrong.variant.missing
    return f"{wrong.sentence} What is missing has {missing} in it." if missing else wrong.sentence


def _explain_formulas(answer: WrongAnswer, any_number: bool = False) -> Diagnosis | None:
    """Return what went wrong in the finished formulas, as worked solutions show them or as they are compared.

    What is the same everywhere in either of these forms comes before what is wrong in some places.
    """
    diagnoses = []
    for form in _reference_forms(answer.problem, answer.part):
        shape = answer.right.shape[:2]
        rows = form if (len(form), len(form[0])) == shape else _transpose(form)
        if (len(rows), len(rows[0])) == shape:
            both = Compared(rows, answer.derivatives, answer.rows)
            diagnoses.append(explain_formulas(both, answer.values, answer.in_numbers, answer.right, any_number))
    return min(filter(None, diagnoses), key=lambda each: (len(each.known_by) > 0, not each.is_one), default=None)


def _transpose(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _reference_forms(problem: Problem, part: Part) -> Iterator[Rows]:
    """Yield the entries of the reference with the angles of the worked solution, and as they are compared."""
    if not part.answer.is_in_numbers and part.answer.entries() and part.type != "number":
        roles = problem.domain().roles
        shown, compared = as_matrix(read(answer_code(problem, part), roles)), part.answer.trees(roles)
        if shown is not None:
            yield shown
        if compared != shown:
            yield compared
