"""Define what a mistake is: a change to a derivation or to an answer, and a message to the student.

A derivation consists of stages, such as the table, the link vectors and the Jacobian (`derivation.graph`). A mistake
changes the results of some stages, and all later stages are computed from the changed results. A change is a function
of all stages and of the correct result of one stage; it returns the wrong result. Values may include derivatives with
respect to the joint variables; `drop_derivatives` removes these. In array shapes, "…" stands for the last axes: one for
the configurations in numeric arrays, and one of length 1 in symbolic arrays (see `derivation.arithmetic`).
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import KW_ONLY, dataclass, field, replace
from itertools import starmap
from typing import Any

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.derivation.graph import Change, StageResults, propagate_linear_rows
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import Answer

AnswerShape = tuple[int, int]
"""The numbers of rows and columns of an answer."""


@dataclass(frozen=True)
class MistakeVariant:
    """One variant of a mistake in a problem on an arm: changes of stages, and words for the message.

    `changes` maps the names of stages to changes. `words` maps the placeholders in the message to texts.
    `missing_symbols` lists the symbols in an omitted factor. The message does not name them, because it is part of
    quizzes, and the same quiz id must always give the same text.

    If the mistake can be made at several joints, `joints` are the joints (from 0) at which this variant makes it.
    `make_for_joints` returns the variant for other joints.
    """

    changes: Mapping[str, Change]
    _: KW_ONLY
    words: Mapping[str, object] = field(default_factory=dict)
    missing_symbols: str = ""
    joints: tuple[int, ...] = ()
    make_for_joints: "Callable[[Sequence[int]], MistakeVariant] | None" = None

    def without_idle_joints(self, idle_joints: AbstractSet[int]) -> "MistakeVariant | None":
        """Return the variant without the joints at which it changes nothing; None if fewer than two joints remain."""
        remaining_joints = [joint for joint in self.joints if joint not in idle_joints]
        if self.make_for_joints and len(remaining_joints) > 1:
            return replace(self.make_for_joints(remaining_joints), joints=tuple(remaining_joints))
        return None


@dataclass(frozen=True)
class MistakenAnswer:
    """The wrong answer that one variant of a mistake gives, for a part that is not derived step by step.

    `answer` is an `Answer` with the wrong value in place of the correct one. For a part that is derived step by step,
    there is `PredictedAnswer` instead.
    """

    answer: Answer
    _: KW_ONLY
    words: Mapping[str, object] = field(default_factory=dict)


VariantGenerator = Callable[[Chain, AnswerShape], Iterator[MistakeVariant]]
"""A function that yields the variants of a mistake on an arm, for an answer of a shape."""

FormulaVariantGenerator = Callable[[Chain, Part], Iterator[MistakeVariant]]
"""A function that yields the variants of a mistake in the formula of an instructor's question."""

AnswerGenerator = Callable[[Chain, Part], Iterator[MistakenAnswer]]
"""A function that yields the wrong answers that a mistake gives to a part."""


MISREADINGS = frozenset().union(*(convention.specific_mistakes for convention in REGISTRY.values()))
"""The names of the mistakes that come from reading the arm's description in the wrong convention."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Mistake:
    """A mistake: its entries in catalogue.toml, and the functions that generate its variants or wrong answers.

    - `title`, `message`: the title in lists, and the message to the student, with placeholders in braces.
    - `source`: the equation, example or section of the chapter to read; "" for none.
    - `is_rare`: whether qdot reports this mistake only if no other mistake gives the same answer.
    - `frequency`: how often the mistake is made, relative to other mistakes that give the same answer.
    - `equivalent_mistakes`: the names of mistakes that give the same answer on some arms.
    - `requires`: the feature that the arm's convention must have; "" for none.
    """

    name: str
    title: str
    message: str
    source: str = ""
    is_rare: bool = False
    frequency: float = 1.0
    equivalent_mistakes: Sequence[str] = ()
    requires: str = ""
    variant_generator: VariantGenerator | None = None
    formula_variant_generator: FormulaVariantGenerator | None = None
    answer_generator: AnswerGenerator | None = None

    def generate_variants(self, chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
        """Yield the variants of the mistake on an arm, for an answer of the given shape."""
        return self.variant_generator(chain, shape) if self.variant_generator and self._applies_to(chain) else iter(())

    def generate_formula_variants(self, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
        """Yield the variants of the mistake in the formula of an instructor's question."""
        return self.formula_variant_generator(chain, part) if self.formula_variant_generator else iter(())

    def generate_answers(self, chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        """Yield the wrong answers that the mistake gives to a part that is not derived step by step."""
        return self.answer_generator(chain, part) if self.answer_generator and self._applies_to(chain) else iter(())

    def _applies_to(self, chain: Chain) -> bool:
        """Return whether the mistake can be made in the arm's convention."""
        convention = convention_of(chain)
        is_possible = self.name in convention.specific_mistakes or self.name not in MISREADINGS
        return is_possible and (not self.requires or self.requires in convention.features)

    def format_message(self, words: Mapping[str, object]) -> str:
        """Return the message to the student, with words for its placeholders and a reference to the chapter, if any."""
        return self.message.format(**words) + (f" See {self.chapter_reference}." if self.source else "")

    @property
    def chapter_reference(self) -> str:
        """The section, example or equation of the chapter to read, with brackets around the number of an equation."""
        return f"({self.source})" if self.source[:1].isdigit() else self.source


def add_chapter_to_citation(sentence: str) -> str:
    """Add "in Chapter 6" to a reference such as "See (6.4)" in a message.

    This is not necessary in notebooks and on the site, which name the chapter at the top.

    >>> add_chapter_to_citation("Check the sign. See (6.4).")
    'Check the sign. See (6.4) in Chapter 6.'
    """
    return re.sub(r"\bSee (\(6\.[^)]*\)|Example 6\.\d+|the text below \(6\.\d+\))", r"See \1 in Chapter 6", sentence)


# --- helpers for variants ---


def vary_always(changes: Mapping[str, Change]) -> VariantGenerator:
    """Return a function that yields the same variant for every arm."""
    return vary_if(lambda chain: True, changes)


def vary_if(
    applies: Callable[[Chain], object], changes: Mapping[str, Change], words: Mapping[str, object] | None = None
) -> VariantGenerator:
    """Return a function that yields one variant if `applies` is true of the arm."""
    return lambda chain, shape: iter([MistakeVariant(changes, words=words or {})] if applies(chain) else [])


def vary_each(
    list_cases: Callable[[Chain], Iterable[tuple[Any, ...]]], make_variant: Callable[..., MistakeVariant]
) -> VariantGenerator:
    """Return a function that yields one variant for each case, such as each pair of joints.

    `list_cases` returns a tuple of the arguments of `make_variant` for each case.
    """
    return lambda chain, shape: starmap(make_variant, list_cases(chain))


def combine(*generators: Callable[[Chain, Any], Iterator[Any]]) -> Callable[[Chain, Any], Iterator[Any]]:
    """Return a generator function that yields the items of several generator functions."""
    return lambda chain, subject: (item for generate in generators for item in generate(chain, subject))


def make_propagated_variant(changes: Mapping[str, Change], words: Mapping[str, object] | None = None) -> MistakeVariant:
    """Return a variant with these changes, and with the linear rows of the Jacobian computed by propagation (6.9).

    Otherwise, mistakes in the axes or in p* would have no effect on the linear rows, which are derivatives of the link
    vectors.
    """
    return MistakeVariant({**changes, "linear rows": propagate_linear_rows}, words=words or {})


def vary_each_joint_and_all(
    joints: Sequence[int], make_variant: Callable[[Sequence[int]], MistakeVariant]
) -> Iterator[MistakeVariant]:
    """Yield one variant for each of the joints and, if there are several, a variant for all of them together."""
    for joint in joints:
        yield replace(make_variant([joint]), joints=(joint,))
    if len(joints) > 1:
        yield replace(make_variant(joints), joints=tuple(joints), make_for_joints=make_variant)


def make_joint_words(joints: Sequence[int]) -> dict[str, object]:
    """Return the words for the placeholder "joint" of a message: [0, 1] gives "joints 1 and 2"."""
    return {"joint": name_items("joint", [i + 1 for i in joints])}


def name_items(noun: str, numbers: Sequence[int]) -> str:
    """Return a noun with the numbers of one or more items.

    >>> name_items("row", [2]), name_items("entry", [1, 2, 4])
    ('row 2', 'entries 1, 2 and 4')
    """
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{noun if len(numbers) == 1 else plural} {join_words(list(map(str, numbers)))}"


def join_words(words: Sequence[str]) -> str:
    """Return words as an enumeration in a sentence.

    >>> join_words(["theta1"]), join_words(["x", "y", "z"])
    ('theta1', 'x, y and z')
    """
    *other_words, last_word = words
    return f"{', '.join(other_words)} and {last_word}" if other_words else last_word


def list_joints_of_kind(stages: StageResults, kind: str) -> list[int]:
    """Return the joints (from 0) of a kind, according to the stage "joint kinds", which a mistake may have changed."""
    return [i for i, kind_of_joint in enumerate(stages["joint kinds"]) if kind_of_joint == kind]


def scale_entries(entry_index: Any, factor: int) -> Change:
    """Return the change that multiplies the entries of an array at an index by a factor."""

    def scale(stages: StageResults, values: np.ndarray) -> np.ndarray:
        new_values = np.array(values)
        new_values[entry_index] = factor * new_values[entry_index]
        return new_values

    return scale


def exchange(i: int, j: int, axis: int = 0) -> Change:
    """Return the change that exchanges two rows (axis 0) or columns (axis 1) of an array."""

    def apply_exchange(stages: StageResults, values: np.ndarray) -> np.ndarray:
        order = list(range(values.shape[axis]))
        order[i], order[j] = j, i
        return values.take(order, axis)

    return apply_exchange
