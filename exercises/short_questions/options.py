"""The options of a question: formulas, sets or configurations, and the mistakes behind the wrong ones."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import sympy as sp

from qdot.exercises.answer_types import Choice
from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.base import Mistake
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Details, Part, values_by_name
from qdot.exercises.questions.base import shuffle_options
from qdot.exercises.questions.geometry import ExactConfiguration

Formula: TypeAlias = Any
"""A matrix, an expression, or the components of a singular set."""

PREFERRED_LENGTH_RATIO, MAX_LENGTH_RATIO = 1.35, 2.0
"""Maximum length ratio of the longest option to the shortest: the preferred limit, and the limit if none meets it."""

SELF_EVIDENT_MISTAKES = frozenset({"rates-left-in", "angles-in-degrees"})
"""Mistakes that are visible without a calculation: they produce symbols or values that can't occur."""


def is_plausible(mistake: Mistake) -> bool:
    """Return whether options may be based on a mistake: it is not rare, and not visible without a calculation."""
    return not mistake.is_rare and mistake.name not in SELF_EVIDENT_MISTAKES


@dataclass(frozen=True)
class Blame:
    """The name of a mistake, and the words that describe this instance of it in the mistake's sentence."""

    mistake: str
    words: tuple[tuple[str, str], ...]

    @staticmethod
    def from_mistake(mistake: Mistake, words: Iterable[tuple[str, object]]) -> "Blame":
        """Return the blame on a mistake, with its words as plain text."""
        return Blame(mistake.name, tuple((name, str(word)) for name, word in sorted(words, key=lambda pair: pair[0])))

    @property
    def title(self) -> str:
        """The title of the mistake."""
        return CATALOGUE[self.mistake].title

    @property
    def sentence(self) -> str:
        """The message to a student who made the mistake."""
        return CATALOGUE[self.mistake].format_message(dict(self.words))


@dataclass(frozen=True)
class OfferedOption:
    """One option: what it shows, and the mistakes that lead to it (none if it is correct)."""

    shown: Formula
    behind: tuple[Blame, ...] = ()

    @property
    def is_set(self) -> bool:
        """Whether the option shows a set of configurations."""
        return isinstance(self.shown, tuple)

    @property
    def is_tall(self) -> bool:
        """Whether the option is displayed in several lines."""
        return isinstance(self.shown, sp.MatrixBase) and self.shown.rows > 1

    @property
    def formula(self) -> Formula:
        """What the option shows; a single number has no matrix brackets."""
        return self.shown[0] if isinstance(self.shown, sp.MatrixBase) and self.shown.shape == (1, 1) else self.shown

    @property
    def text(self) -> str:
        """What the option shows, as plain text in the syntax of an answer: [[1, a1]] for a matrix."""
        if isinstance(self.shown, tuple):
            return " or ".join(piece for component in self.shown for piece in component.pieces())
        if isinstance(self.shown, sp.Expr):
            return str(self.shown)
        is_matrix = self.shown.cols > 1
        rows = [f"[{', '.join(map(str, row))}]" if is_matrix else str(row[0]) for row in self.shown.tolist()]
        return f"[{', '.join(rows)}]"


@dataclass(frozen=True, kw_only=True)
class Options(Details):
    """The formulas or sets offered as options."""

    offered: tuple[OfferedOption, ...]


@dataclass(frozen=True, kw_only=True)
class ConfigurationOptions(Details):
    """The configurations offered, the lengths of the arm, and the mistake that makes each one seem singular, if any."""

    places: tuple[ExactConfiguration, ...]
    lengths: dict[sp.Symbol, sp.Rational]
    blames: tuple[Blame | None, ...]

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths only: the arm is not shown in any of the configurations."""
        return values_by_name(self.lengths)

    @property
    def rounded_joints(self) -> tuple[sp.Symbol, ...]:
        """The joints whose value is shown rounded in at least one configuration."""
        return tuple(q for q in self.places[0].joints if any(q in configuration.about for configuration in self.places))

    def format_rounded_joint(self, configuration: ExactConfiguration, q: sp.Symbol) -> str:
        """Return the text of a rounded joint's value, in degrees or metres, with the same decimals in all options."""
        decimals = 2 if q.name.startswith("theta") else 4
        return f"{float(exact_or_rounded_value(configuration, q)) + 0.0:.{decimals}f}"


def exact_or_rounded_value(configuration: ExactConfiguration, q: sp.Symbol) -> sp.Expr:
    """Return the value of a joint in degrees or metres, rounded if it is not a simple number."""
    unit = 180 / sp.pi if q.name.startswith("theta") else sp.S.One
    return configuration.about.get(q, configuration.joints[q] * unit)


LengthMismatch = tuple[bool, int, float]
"""How badly options match, by three values.

They are: whether the lengths of the options differ much, how far the correct option is from its intended rank by
length, and the length ratio of the longest option to the shortest."""

BEST_MISMATCH = (False, 0)
"""The first two components of the best possible mismatch."""


def rate_lengths(lengths: Sequence[int], intended_rank: int, tolerance: float = 1.0) -> LengthMismatch | None:
    """Return how badly options of these lengths match, or None if they differ too much; the first option is correct.

    The maximum ratios are multiplied by `tolerance`.
    """
    ratio, rank = max(lengths) / min(lengths), sum(length < lengths[0] for length in lengths[1:])
    if ratio > tolerance * MAX_LENGTH_RATIO:
        return None
    return ratio > tolerance * PREFERRED_LENGTH_RATIO, abs(rank - intended_rank), ratio


def offer_choice(offered: Sequence[OfferedOption], rng: Stream) -> tuple[Choice, tuple[OfferedOption, ...]]:
    """Return a choice between options in random order, the first of which is correct, and the shuffled options."""
    answer, order = shuffle_options(offered, offered[0], rng, lambda option: option.text)
    return answer, tuple(order)


def list_blames(part: Part, index: int) -> tuple[Blame, ...]:
    """Return the known mistakes behind an option of a part (none if it is correct)."""
    if isinstance(part.details, Options):
        return part.details.offered[index].behind
    blame = part.details.blames[index] if isinstance(part.details, ConfigurationOptions) else None
    return () if blame is None else (blame,)
