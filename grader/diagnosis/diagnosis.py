"""Name the mistake behind a wrong answer: the one of the catalogue that gives the very same answer.

Answers are compared at random configurations, or at the one that is given. If no mistake of the catalogue gives the
whole answer, what is wrong is told entry by entry. What gives neither is not guessed at.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ReadError, as_matrix, digits_of_decimals
from qdot.exercises.mistakes.catalogue import (
    ALIKE,
    CATALOGUE,
    NO_WEIGHTS,
    MistakeWeights,
    Wrong,
    make_mistake,
    mistaken_answers,
    variant_frequency,
    wrong_answers,
)
from qdot.exercises.mistakes.configurations import Values, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import read_vector
from qdot.exercises.questions.results import is_derived, is_made_of_jacobian, is_product, result
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.statement import answer_code
from qdot.grader.diagnosis.formula_mistakes import TOO_MANY, Compared, finished
from qdot.grader.diagnosis.numbers import SAME, InNumbers, says_something, unit
from qdot.grader.diagnosis.residuals import missing_links
from qdot.grader.diagnosis.rounding import is_right, rounded, rounded_values
from qdot.grader.diagnosis.set_mistakes import behind_set
from qdot.grader.judging.answer import ParsedAnswer, Table
from qdot.grader.judging.judge import judge_given
from qdot.grader.judging.verdict import Diagnosis, Outcome, locate_mistake

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
OF_ANOTHER = ("other-lengths",)
"""What is right for another arm is no mistake that was made on this one."""
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
    problem: Problem,
    part: Part,
    given: ParsedAnswer,
    seed: str = "",
    causes: Sequence[Cause] = (),
    mistake_weights: MistakeWeights = NO_WEIGHTS,
) -> Diagnosis | None:
    """Return the mistake that gives a wrong answer, or nothing where none in the catalogue does.

    One of the `causes` that were found in earlier parts is told as that. `seed` draws the configurations at which the
    answer is compared with what mistakes give. `mistake_weights` is what is known of mistakes that a class makes more.

    >>> from qdot import generate
    >>> from qdot import read_answer
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> (part,) = problem.parts
    >>> diagnose(problem, part, read_answer(problem, part, "d2 + 0.7")).mistakes
    ('determinant-sign',)
    """
    if given.table is None:
        offered = _behind_options(part, given)
        if offered is not None:
            return offered
        if part.answer.is_a_set:
            return behind_set(problem, part, given, seed, mistake_weights) if len(given.text) <= LONGEST_SET else None
        for mistake, slip in mistaken_answers(problem.chain, part) if len(given.text) <= LONGEST_SET else ():
            if judge_given(problem, replace(part, answer=slip.answer), given, seed).outcome is Outcome.CORRECT:
                made = locate_mistake(mistake.name, slip.words)
                return Diagnosis((mistake.name,), mistake.sentence(slip.words), known_by=(made,))
    answer = _wronged(problem, part, given, seed)
    if answer is None:
        return None
    found, right = answer.found, answer.right
    said = rounded(part, found, right, given.entries) if given.table is None else rounded_values(found, right)
    if said or is_right(found, right):  # as are mistakes that make no difference on this arm
        return said
    return named(answer, causes, mistake_weights)


def is_one_mistake(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> bool:
    """Tell whether a single known mistake gives all that is wrong in an answer in formulas or in several numbers.

    What such a mistake would spoil besides may be right: no cause is named then, but a better answer never earns less.
    Only what is quickly found counts, so that no mark hangs on how long mistakes are looked for.
    """
    answer = _wronged(problem, part, given, seed)
    if answer is None:
        return False
    found, right = answer.found, answer.right
    if found.values.shape != right.shape or is_right(found, right):
        return False
    is_wrong = ~found.like(right)
    is_filled = np.abs(found.values[is_wrong]).max(axis=-1) > SAME  # zeros are given by many
    for wrong in wrong_answers(answer.w, part, found.is_precise) if is_filled.any() else ():
        fits = wrong.answer.shape == right.shape and (found.like(wrong.answer) | ~is_wrong).all()
        if fits and says_something(wrong.answer):
            return True
    if is_product(part) or not is_filled.all():  # of a product the factors count
        return False
    one_kind = (missing_links(answer.w, part, right, found.values), _finished(answer))
    return any(each is not None and each.is_one and each.mistakes != OF_ANOTHER for each in one_kind)


def _wronged(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> "Wronged | None":
    """Return an answer with its values at configurations, None where no mistakes in the derivation are known."""
    if not is_derived(part):
        return None
    if given.table is not None:
        return _wronged_function(problem, part, given.table)
    values = sample_configurations(problem.chain, part, problem.domain(), POINTS, Stream(f"{seed}/diagnosis"))
    try:
        in_numbers = _in_numbers(part, given, values)
    except ReadError:  # statements among the entries of an answer that was refused
        return None
    return None if in_numbers is None else Wronged(problem, part, values, in_numbers, given.rows)


def _wronged_function(problem: Problem, part: Part, table: Table) -> "Wronged | None":
    """Return a function with what it returned where it was called."""
    if table.shape is None or len(table.shape) > 2:
        return None
    values = {name: column[:POINTS] for name, column in table.at.items()}
    rows = (*table.shape, *(1,) * (2 - len(table.shape)))
    returned = table.values[:POINTS].T.reshape(*rows, -1)
    room = (max(SAME, part.rounding.relative), part.rounding.absolute) if part.rounding else (SAME, 0.0)
    return Wronged(
        problem, part, values, InNumbers(returned, np.abs(returned), room, part.answer.counts_up_to_a_factor)
    )


def _in_numbers(part: Part, given: ParsedAnswer, values: Values) -> InNumbers | None:
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


def _option(part: Part, given: ParsedAnswer) -> InNumbers | None:
    if not given.chosen:
        return None
    values = np.array(read_vector(part.answer.offered[given.chosen[0]]))[:, None, None]
    return InNumbers(values, np.abs(values), (0.0, THREE_DECIMALS))


def _behind_options(part: Part, given: ParsedAnswer) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, as they were kept when it was made."""
    for index in given.chosen:
        blames = [] if index in part.answer.right else list_blames(part, index)
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


@dataclass(frozen=True)
class Wronged:
    """A wrong answer with its values at configurations, and its formulas as they were typed, if there are any."""

    problem: Problem
    part: Part
    values: Values
    found: InNumbers
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
    def upright(self) -> "Wronged":
        """The same, a vector that was typed as a row or column in the shape that is right."""
        shape = self.right.shape
        if 1 not in shape[:2] or self.found.values.shape == shape or self.found.values.swapaxes(0, 1).shape != shape:
            return self
        found = replace(self.found, values=self.found.values.swapaxes(0, 1), size=self.found.size.swapaxes(0, 1))
        return replace(self, found=found, rows=None if self.rows is None else _turned(self.rows))


def named(
    answer: Wronged, causes: Sequence[Cause] = (), mistake_weights: MistakeWeights = NO_WEIGHTS
) -> Diagnosis | None:
    """Return the mistake that gives an answer at configurations, or nothing.

    Of several that do, one that was found in an earlier part is the cause here, too; else the likeliest is told. Where
    none does, what is wrong is told entry by entry, if it is one thing in each.
    """
    answer = answer.upright
    found, right, part = answer.found, answer.right, answer.part
    if found.is_direction and _moves(right, found.values):
        mistake = CATALOGUE["direction-that-moves"]
        return Diagnosis((mistake.name,), mistake.sentence({}))
    fitting = []
    highest = max([1.0, *mistake_weights.values()])
    for wrong in wrong_answers(answer.w, part, found.is_precise):
        if _gives(wrong, found):
            fitting.append(wrong)
            if not causes and variant_frequency(wrong, mistake_weights) >= highest:
                break
    if fitting:
        inherited = next((one for one in fitting if _cause(one, causes)), None)
        return _inherited(inherited, causes) if inherited else _likeliest(answer, fitting, mistake_weights)
    if found.values.shape != right.shape or found.is_direction:
        return None
    return missing_links(answer.w, part, right, found.values) or _finished(answer) or _finished(answer, any_number=True)


def _gives(wrong: Wrong, found: InNumbers) -> bool:
    return found.is_all(wrong.answer) and says_something(wrong.answer)


def _likeliest(answer: Wronged, fitting: Sequence[Wrong], mistake_weights: MistakeWeights) -> Diagnosis:
    """Return the mistake with the highest prior, or the first two of them; a slip in one place may be likelier."""
    found, first = answer.found, max(fitting, key=partial(variant_frequency, mistake_weights=mistake_weights))
    alike = [*ALIKE.get(first.mistake.name, ()), *(["row-sign"] if _of_either_row(first, found) else [])]
    ways = (wrong for name in alike for wrong in make_mistake(CATALOGUE[name], answer.w, answer.part))
    rivals = [first, *(wrong for wrong in ways if _gives(wrong, found) and wrong.sentence != first.sentence)]
    priors = [variant_frequency(wrong, mistake_weights) for wrong in rivals]
    highest = max(priors)
    count = int((~found.like(answer.right)).sum()) if found.values.shape == answer.right.shape else 0
    is_rare = highest < LEAST_LIKELY and count <= MOST_IN_ONE_PLACE
    is_throughout = count == 1 < found.values[..., 0].size and not OF_ONE_PLACE & set(first.slip.words)
    is_at_several = first.mistake.rare and len(first.slip.places) > 1
    is_less_likely = is_rare or is_at_several or (is_throughout and highest < VERY_LIKELY)
    slip = _finished(answer) if count and not found.is_direction and is_less_likely else None
    if slip is not None:
        is_likelier = is_rare and not EXTRA & set(slip.mistakes)
        if is_likelier or set(slip.mistakes) <= (EXCHANGED if is_at_several else SIGNS):
            return slip
    return _said([wrong for wrong, own in zip(rivals, priors, strict=True) if own == highest][:2])


def _said(wrongs: Sequence[Wrong]) -> Diagnosis:
    """Return what is said of a mistake, or of two of which either gives the answer."""
    first, names = wrongs[0], tuple(dict.fromkeys(wrong.mistake.name for wrong in wrongs))
    says = " Or, which gives the same answer: ".join(dict.fromkeys(map(_sentence, wrongs)))
    cause = (first.mistake.name, dict(first.slip.words)) if len(wrongs) == 1 else None
    ways = tuple(locate_mistake(wrong.mistake.name, wrong.slip.words) for wrong in wrongs)
    return Diagnosis(names, says, cause, known_by=ways, either=len(names) > 1)


def _sentence(wrong: Wrong) -> str:
    missing = wrong.slip.missing
    return f"{wrong.sentence} What is missing has {missing} in it." if missing else wrong.sentence


def _of_either_row(wrong: Wrong, found: InNumbers) -> bool:
    """Tell whether it is one row of a direction against the others that has the wrong sign."""
    return found.is_direction and wrong.mistake.name == "row-sign"


def _moves(lost: np.ndarray, found: np.ndarray) -> bool:
    """Tell whether a direction is one in which the arm can move: it has no part along the one that is lost."""
    if lost.shape != found.shape or lost.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        along = np.abs((unit(lost) * unit(found)).sum(axis=0))
    return bool(np.isfinite(along).all() and (along < 1e-3).all())


def _finished(answer: Wronged, any_number: bool = False) -> Diagnosis | None:
    """Return what went wrong in the finished formulas, as worked solutions show them or as they are compared.

    What is the same everywhere in either of these forms comes before what is wrong in some places.
    """
    said = []
    for form in _forms(answer.problem, answer.part):
        rows = form if (len(form), len(form[0])) == answer.right.shape[:2] else _turned(form)
        if (len(rows), len(rows[0])) == answer.right.shape[:2]:
            both = Compared(rows, answer.derivatives, answer.rows)
            diagnosis = finished(both, answer.values, answer.found, answer.right, any_number)
            said += [] if diagnosis is None else [diagnosis]
    return min(said, key=lambda one: (len(one.known_by) > 0, not one.is_one), default=None)


def _turned(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _forms(problem: Problem, part: Part) -> Iterator[Rows]:
    """Yield the entries of the reference, as worked solutions show them and as they are compared."""
    if not part.answer.is_in_numbers and part.answer.entries() and part.type != "number":
        shown, compared = _as_shown(problem, part), part.answer.trees(problem.domain().roles)
        yield from (form for form in (shown, compared if compared != shown else None) if form is not None)


def _as_shown(problem: Problem, part: Part) -> Rows | None:
    """Return the reference with the angles of the worked solution, as trees."""
    tree = read(answer_code(problem, part), problem.domain().roles)
    return as_matrix(tree)


def _cause(wrong: Wrong, causes: Sequence[Cause]) -> Cause | None:
    return next((c for c in causes if (c.mistake, c.words) == (wrong.mistake.name, dict(wrong.slip.words))), None)


def _inherited(wrong: Wrong, causes: Sequence[Cause]) -> Diagnosis:
    """Return what is said of a mistake that was found before."""
    cause = _cause(wrong, causes)
    assert cause is not None
    says = f"This follows from what went wrong in {cause.title!r}: the same mistake gives this answer."
    return Diagnosis((), says, inherited=cause.part, known_by=_said([wrong]).known_by)
