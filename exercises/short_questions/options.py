"""The options of a short question (formulas, sets or configurations), and the mistakes that give the wrong ones."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.base import Mistake
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Details, Part, list_values_by_name, recorded_as
from qdot.exercises.questions.base import shuffle_options
from qdot.exercises.questions.exact_configurations import ExactConfiguration
from qdot.exercises.reference_answers import Choice

OptionContent: TypeAlias = Any
"""A SymPy matrix, a SymPy expression, or the components of a singular set."""

PREFERRED_LENGTH_RATIO, MAX_LENGTH_RATIO = 1.35, 2.0
"""Maximum ratio of the lengths (in characters) of the longest and the shortest option: preferred, and in any case."""

SELF_EVIDENT_MISTAKES = frozenset({"rates-left-in", "angles-in-degrees"})
"""Mistakes that are visible without a calculation, because they lead to symbols or values that can't occur."""


def is_plausible(mistake: Mistake) -> bool:
    """Return whether options may be based on a mistake, which must not be rare or visible without a calculation."""
    return not mistake.is_rare and mistake.name not in SELF_EVIDENT_MISTAKES


@dataclass(frozen=True)
class Blame:
    """An instance of a known mistake, which explains a wrong option.

    `mistake` is the name of the mistake. `words` are the words for the placeholders in its message.
    """

    mistake: str
    words: tuple[tuple[str, str], ...]

    @staticmethod
    def from_mistake(mistake: Mistake, words: Iterable[tuple[str, object]]) -> "Blame":
        """Return an instance of a mistake, with its words as plain text."""
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
    """One option: its content, and the mistakes that lead to it (none for a correct option)."""

    content: OptionContent = field(metadata=recorded_as("shown"))
    blames: tuple[Blame, ...] = field(default=(), metadata=recorded_as("behind"))

    @property
    def is_set(self) -> bool:
        """Whether the option shows a set of configurations."""
        return isinstance(self.content, tuple)

    @property
    def is_tall(self) -> bool:
        """Whether the option is displayed in several lines."""
        return isinstance(self.content, sp.MatrixBase) and self.content.rows > 1

    @property
    def formula(self) -> OptionContent:
        """The content without the matrix brackets of a single entry."""
        is_single_entry = isinstance(self.content, sp.MatrixBase) and self.content.shape == (1, 1)
        return self.content[0] if is_single_entry else self.content

    @property
    def text(self) -> str:
        """The content as plain text in the syntax of an answer, such as [[1, a1]] for a matrix."""
        if isinstance(self.content, tuple):
            return " or ".join(piece for component in self.content for piece in component.list_pieces())
        if isinstance(self.content, sp.Expr):
            return str(self.content)
        is_matrix = self.content.cols > 1
        rows = [f"[{', '.join(map(str, row))}]" if is_matrix else str(row[0]) for row in self.content.tolist()]
        return f"[{', '.join(rows)}]"


@dataclass(frozen=True, kw_only=True)
class Options(Details):
    """Details of a question with formulas or sets as options."""

    offered_options: tuple[OfferedOption, ...] = field(metadata=recorded_as("offered"))


@dataclass(frozen=True, kw_only=True)
class ConfigurationOptions(Details):
    """Details of a question with configurations as options: the configurations, and the lengths of the arm.

    `blames` has for each configuration the mistake that makes the configuration seem singular, or None. The worked
    solution mentions this mistake, but a student may choose the configuration for another reason.
    """

    offered_configurations: tuple[ExactConfiguration, ...] = field(metadata=recorded_as("places"))
    lengths: dict[sp.Symbol, sp.Rational]
    blames: tuple[Blame | None, ...]

    def list_shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths only, because the arm's figure shows none of the configurations."""
        return list_values_by_name(self.lengths)

    @property
    def rounded_joints(self) -> tuple[sp.Symbol, ...]:
        """The joints whose value is shown rounded in at least one configuration."""
        configurations = self.offered_configurations
        return tuple(q for q in configurations[0].joints if any(q in c.rounded_values for c in configurations))

    def format_rounded_joint(self, configuration: ExactConfiguration, q: sp.Symbol) -> str:
        """Return a joint's value in degrees or metres as text, with the same number of decimals in all options."""
        decimals = 2 if is_joint_angle(q) else 4
        number = float(find_shown_value(configuration, q)) + 0.0  # turns -0.0 into 0.0
        return f"{number:.{decimals}f}"


def find_shown_value(configuration: ExactConfiguration, q: sp.Symbol) -> sp.Expr:
    """Return the value of a joint variable in degrees or metres, rounded if it is not a simple number."""
    unit = 180 / sp.pi if is_joint_angle(q) else sp.S.One
    return configuration.rounded_values.get(q, configuration.joints[q] * unit)


class LengthMismatch(NamedTuple):
    """How badly the lengths of options match.

    Smaller values are better, and the first fields matter most. `rank_error` is the distance of the correct option's
    rank by length from the intended rank. `ratio` is the ratio of the lengths of the longest and the shortest option.
    """

    differs_much: bool
    rank_error: int
    ratio: float

    @property
    def is_best(self) -> bool:
        """Whether no other options need to be tried."""
        return not self.differs_much and self.rank_error == 0


def find_length_mismatch(lengths: Sequence[int], intended_rank: int, tolerance: float = 1.0) -> LengthMismatch | None:
    """Return how badly options of these lengths match, or None if the lengths differ too much.

    The first length is that of the correct option. The maximum ratios are multiplied by `tolerance`.
    """
    ratio = max(lengths) / min(lengths)
    if ratio > tolerance * MAX_LENGTH_RATIO:
        return None
    rank = sum(length < lengths[0] for length in lengths)
    return LengthMismatch(ratio > tolerance * PREFERRED_LENGTH_RATIO, abs(rank - intended_rank), ratio)


def offer_choice(options: Sequence[OfferedOption], rng: Stream) -> tuple[Choice, tuple[OfferedOption, ...]]:
    """Return a choice between options, of which the first is correct, and the options in random order."""
    answer, shuffled_options = shuffle_options(options, options[0], rng, lambda option: option.text)
    return answer, tuple(shuffled_options)


def list_blames(part: Part, index: int) -> tuple[Blame, ...]:
    """Return the mistakes that surely lead to an option (an index) of a part; () if the option is correct.

    These are the mistakes by which a formula or a set was generated. For a configuration, only a mistake about its rank
    is certain.
    """
    if isinstance(part.details, Options):
        return part.details.offered_options[index].blames
    is_regular = isinstance(part.details, ConfigurationOptions) and index not in part.answer.correct_indices
    return (Blame("regular-taken-for-singular", ()),) if is_regular else ()
