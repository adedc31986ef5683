"""List all mistakes, and compute the wrong answers to which they lead."""

import ast
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain as chain_together
from pathlib import Path

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.graph import Change, StageResults, propagate_linear_rows
from qdot.exercises.mistakes import (
    algebra,
    arrangement,
    choices,
    columns,
    numeric,
    position,
    question_formulas,
    screws,
    sets,
    table,
)
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer, MistakeVariant
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.language import FormulaError, find_names
from qdot.exercises.questions.quantities import is_quantity
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step, is_made_of_jacobian

VARIANTS = (
    position.VARIANTS | columns.VARIANTS | screws.VARIANTS | algebra.VARIANTS | table.VARIANTS | arrangement.VARIANTS
    | numeric.VARIANTS
)  # fmt: skip
"""Maps the name of each mistake in a derivation to a function that yields its variants."""
ANSWERS = numeric.ANSWERS | sets.ANSWERS | choices.ANSWERS
"""Maps the name of each mistake in a part without a derivation to a function that yields the wrong answers."""


FORMULA_VARIANTS = question_formulas.FORMULA_VARIANTS
"""Maps the name of each mistake in the formula of an instructor's question to a function that yields its variants."""


def _read_sections() -> dict[str, tuple[Mistake, ...]]:
    """Return the mistakes of catalogue.toml, each with its functions, by the titles of the sections."""
    sections = tomllib.loads(Path(__file__).with_name("catalogue.toml").read_text(encoding="utf-8"))["section"]
    return {
        section["title"]: tuple(
            Mistake(
                name=name, variant_generator=VARIANTS.get(name), answer_generator=ANSWERS.get(name),
                formula_variant_generator=FORMULA_VARIANTS.get(name), **entries,
            )
            for name, entries in section["mistakes"].items()
        )
        for section in sections
    }  # fmt: skip


SECTIONS: dict[str, tuple[Mistake, ...]] = _read_sections()
"""The mistakes, by the titles of the sections of catalogue.toml."""

CATALOGUE: dict[str, Mistake] = {
    mistake.name: mistake for mistake in sorted(chain_together(*SECTIONS.values()), key=lambda mistake: mistake.is_rare)
}
"""All mistakes by name, with the rare ones last, because the first mistake that gives a wrong answer is named."""

_LAST_STEP_MISTAKES = algebra.VARIANTS.keys() | arrangement.VARIANTS.keys()
"""The names of the mistakes that are made after J is derived."""

NUMERIC_MISTAKES = tuple(mistake.name for mistake in SECTIONS["Numbers"])
"""The names of the mistakes that occur only in numeric answers."""

MISTAKES_FOR_ONE_NUMBER = frozenset(
    {
        *NUMERIC_MISTAKES, *FORMULA_VARIANTS, "all-relative-angles", "degrees", "determinant-sign", "sign",
        "square-lost",
    } - {"value-sign"}
)  # fmt: skip
"""The mistakes that are considered if the answer is a single number. Others would often give the number by chance."""

IN_DEGREES, ANGULAR_UNITS = "result-in-degrees", ("rad", "rad/s", "rad/s^2")
"""The mistake of giving a result in degrees, and the units of results in which it can be made."""

SIGN_MISTAKES_AT_ONE_PLACE = frozenset({
    "link-subtracted", "term-sign", "column-sign", "row-sign", "axis-sign", "twist-sign", "velocity-sign",
})  # fmt: skip
"""The mistakes that change signs at one place. If all signs are wrong, the mistake `sign` describes the answer
better."""

SIGN_MISTAKES_THROUGHOUT = frozenset({
    "sign", "determinant-sign", "arm-reversed", "path-reversed", "derivative-of-cosine", "derivative-of-sine",
})  # fmt: skip
"""The mistakes that explain why all signs of an answer are wrong."""

LIKELIEST_IN_OWN_QUESTIONS = {
    *FORMULA_VARIANTS, "length-forgotten", "distance-forgotten", "rows-exchanged",
} - {"cross-terms-missing"}  # fmt: skip
"""The likeliest mistakes in an instructor's question: a mistake in the formula, a length that is missing everywhere,
and two exchanged entries. Missing cross terms are not among them, because a single missing term is likelier."""

PROPAGATION_FACTOR = 0.5
"""Factor for the frequency of a mistake in the position of P if the columns of J are then computed by propagation."""

_POSITION_STAGES = frozenset({"table", "rotations", "local link vectors", "link vectors"})
"""The stages from which the position of P is computed."""


@dataclass(frozen=True)
class PredictedAnswer:
    """The wrong answer that a variant of a mistake gives to a part that is derived step by step, (rows, columns, …).

    `stages` is the derivation with this mistake. For other parts, there is `MistakenAnswer` instead. The entries are
    numbers, formula trees or SymPy expressions, as in `stages`.
    """

    mistake: Mistake
    variant: MistakeVariant
    stages: StageResults
    answer: np.ndarray

    @property
    def sentence(self) -> str:
        """The message to the student, with "entry" instead of "row" for a vector."""
        message = self.mistake.format_message(self.variant.words)
        if self.answer.ndim < 2 or self.answer.shape[1] > 1:
            return message
        return re.sub(r"^Row\b", "Entry", message.replace("exchanged rows", "exchanged entries"))

    @property
    def frequency(self) -> float:
        """How often this variant is made, relative to other variants that give the same answer."""
        frequency = self.mistake.frequency
        # an answer such as p*, which is itself propagated, does not depend on the linear rows of J
        if "linear rows" in self.variant.changes:
            return frequency if self.stages.depends_on("linear rows") else max(frequency, 1.0)
        is_propagated = any(stage == "linear rows" for stage, _ in self.stages.changes)
        return frequency * PROPAGATION_FACTOR if is_propagated else frequency


def list_likely_mistakes(part: Part, is_precise: bool = False) -> list[Mistake]:
    """Return the mistakes to consider for a wrong answer to a part, the likelier mistakes first.

    If the answer is derived from J, mistakes in this last step come before mistakes in J. For an answer that is a
    single number, all mistakes are considered only if it has enough digits (`is_precise`).
    """
    mistakes = list(CATALOGUE.values())
    if is_made_of_jacobian(part):
        mistakes = sorted(mistakes, key=lambda mistake: (mistake.is_rare, mistake.name not in _LAST_STEP_MISTAKES))
    if (formula := question_formulas.find_formula(part)) is not None:
        mistakes = _list_mistakes_in_question(mistakes, formula)
    if part.type != "number":
        # a mistake in the formula of an instructor's question may also be made if the answer is no number
        only_formula_mistakes = FORMULA_VARIANTS.keys() - VARIANTS.keys()
        impossible_mistakes = set(NUMERIC_MISTAKES) - only_formula_mistakes
        return [mistake for mistake in mistakes if mistake.name not in impossible_mistakes]
    impossible_mistakes = set() if all(unit in ANGULAR_UNITS for unit in part.answer.expected_units) else {IN_DEGREES}
    if not is_precise and part.shape == (1, 1):
        impossible_mistakes |= CATALOGUE.keys() - MISTAKES_FOR_ONE_NUMBER
    return [mistake for mistake in mistakes if mistake.name not in impossible_mistakes]


JACOBIAN_SECTION = "Columns of the Jacobian"
"""The section of mistakes in deriving J, or the velocity as J times the joint rates."""


_ABOUT_JACOBIAN = re.compile(r"\bJ\b|\bcolumn|p\*", re.IGNORECASE)
"""Matches a message about the Jacobian, or about the vectors p* of its columns."""


def _list_mistakes_in_question(mistakes: Sequence[Mistake], formula: ast.expr) -> list[Mistake]:
    """Return the mistakes that are possible with the quantities in the formula of an instructor's question.

    Mistakes in the formula come first, then the likeliest others, unless the question asks for a quantity of the arm.
    Mistakes with messages about J or its columns are possible only if the formula contains J.
    """
    quantities = find_names(formula)
    has_jacobian, has_velocity = (not quantities.isdisjoint(names) for names in (("J", "Jv", "Jw"), ("v", "w")))
    excluded_mistakes = set[str]()
    if not has_jacobian:
        excluded_mistakes |= {mistake.name for mistake in mistakes if _ABOUT_JACOBIAN.search(mistake.message)}
    if not (has_jacobian or has_velocity):
        excluded_mistakes |= {mistake.name for mistake in SECTIONS[JACOBIAN_SECTION]}
    possible_mistakes = [mistake for mistake in mistakes if mistake.name not in excluded_mistakes]
    likeliest_names = () if is_quantity(formula) else LIKELIEST_IN_OWN_QUESTIONS
    return sorted(
        possible_mistakes,
        key=lambda mistake: (mistake.name not in FORMULA_VARIANTS, mistake.name not in likeliest_names),
    )


def predict_wrong_answers(stages: StageResults, part: Part, is_precise: bool = False) -> Iterator[PredictedAnswer]:
    """Yield the answers that mistakes in the derivation of a part give; some of these answers are still correct.

    A part that is not derived step by step has no such answers.
    """
    if is_derived_step_by_step(part):
        correct_answer = _compute_result(stages, part)
        for mistake in list_likely_mistakes(part, is_precise):
            yield from apply_mistake(mistake, stages, part, correct_answer)


def apply_mistake(
    mistake: Mistake, stages: StageResults, part: Part, correct_answer: np.ndarray | None = None
) -> Iterator[PredictedAnswer]:
    """Yield the answers to a part that the variants of one mistake give.

    After a mistake in the position of P, J is derived in two ways: first by differentiation, then by propagation. A
    mistake at several joints is made only at those joints at which it changes the answer, and the message names only
    these. `correct_answer` is the answer that follows from `stages`; if it is None, it is computed.
    """
    expected = _compute_result(stages, part) if correct_answer is None else correct_answer
    if expected is None:
        return
    idle_joints = set[int]()
    variants = mistake.generate_variants(stages.chain, (expected.shape[0], expected.shape[1]))
    for variant in (*mistake.generate_formula_variants(stages.chain, part), *variants):
        effective_variant: MistakeVariant | None = variant
        if variant.make_for_joints is not None:  # all joints; the variants for single joints have come before
            effective_variant = variant.without_idle_joints(idle_joints)
            idle_joints = set()
        if effective_variant is None:
            continue
        changes: dict[str, Change] = dict(effective_variant.changes)
        stages_of_each_derivation = [stages.with_mistakes(changes)]
        if _POSITION_STAGES & changes.keys() and "linear rows" not in changes:
            stages_of_each_derivation.append(stages.with_mistakes({**changes, "linear rows": propagate_linear_rows}))
        answers = []
        for mistaken_stages in stages_of_each_derivation:
            answer = _compute_result(mistaken_stages, part)
            if answer is not None:
                answers.append(answer)
                yield PredictedAnswer(mistake, effective_variant, mistaken_stages, answer)
        if effective_variant.joints and all(_is_same_answer(answer, expected) for answer in answers):
            idle_joints.update(effective_variant.joints)


def _is_same_answer(answer: np.ndarray, correct_answer: np.ndarray) -> bool:
    if answer.shape != correct_answer.shape:
        return False
    if answer.dtype == object:
        return bool((answer == correct_answer).all())
    return np.allclose(answer, correct_answer, rtol=1e-9, atol=1e-9, equal_nan=True)


def _compute_result(stages: StageResults, part: Part) -> np.ndarray | None:
    """Return the answer that a derivation gives; None if there is none.

    A mistake may concern a joint that the question does not use, or rewrite a formula so that it has no meaning.
    """
    try:
        with np.errstate(all="ignore"):  # J may be rank-deficient
            return compute_answer(stages, part)
    except (IndexError, FormulaError):  # for example, the joint comes after the frame in the question
        return None


def generate_mistaken_answers(chain: Chain, part: Part) -> Iterator[tuple[Mistake, MistakenAnswer]]:
    """Yield wrong answers to a part that is not derived step by step, each after the mistake that leads to it."""
    for mistake in CATALOGUE.values():
        for mistaken_answer in mistake.generate_answers(chain, part):
            yield mistake, mistaken_answer
