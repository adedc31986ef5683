"""The data by which an instructor defines a question: its texts, and the formula or the options of its answer."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields

from qdot.exercises.formula.equality import Rounding

TEXT_ANSWER = "text"
"""The `answer` of a question that a person marks."""

SAMPLED_KINDS = {"angle": "rad", "length": "m", "rate": "rad/s", "velocity": "m/s", "force": "N"}
"""The kinds of random values of a symbol, and the unit of each."""

GIVEN_GROUPS = {"pose": "", "rates": "rate", "velocity": "velocity", "force": "force"}
"""The groups of values that a question may give, with their kinds: joint variables, joint rates, the velocity of the
task, and the force and moment that the arm exerts."""


def split_units(text: str) -> tuple[str, ...]:
    """Return the units in a text that separates them by commas.

    >>> split_units("rad/s, m/s"), split_units("")
    (('rad/s', 'm/s'), ('',))
    """
    return tuple(unit.strip() for unit in text.split(","))


@dataclass(frozen=True)
class Option:
    """An option of a choice: a formula or a text, and whether it is correct."""

    content: str
    is_formula: bool
    is_correct: bool


@dataclass(frozen=True)
class GivenValue:
    """A value that the question states: the name of the symbol or group, and how the value is sampled.

    `kind` is one of SAMPLED_KINDS, or "" for a random number from `low` to `high`. If `low` and `high` are equal, the
    value is the same for all students.
    """

    name: str
    kind: str = ""
    low: float = 0.0
    high: float = 0.0

    @property
    def is_random(self) -> bool:
        """Whether the value differs from student to student."""
        return bool(self.kind) or self.name in GIVEN_GROUPS or self.low < self.high


@dataclass(frozen=True)
class Texts:
    """The texts of a question in one language: Markdown with formulas in braces (`placeholders`)."""

    title: str
    prompt: str
    hints: tuple[str, ...] = ()
    solution: str = ""
    language: str = "en"

    def list_texts(self) -> list[tuple[str, str]]:
        """Return the texts, each after its key."""
        return [("prompt", self.prompt), *(("hints", hint) for hint in self.hints), ("solution", self.solution)]


@dataclass(frozen=True)
class Definition:
    """The definition of an instructor's own question.

    - `answer`: a formula, TEXT_ANSWER, or "" if the question has options.
    - `texts`: the texts in each language; languages other than the first may lack some.
    - `given`: the values that the question states.
    - `rows`: the LaTeX names of the entries of a vector. For a vector of three, they may be the names of only those
      components that are asked for, such as v_x and v_y.
    - `units`: symbols that the arm does not have, such as the mass of a load, with their units.
    - `unit`: the unit of a numeric answer: one for all entries, or one for each, separated by commas.
    - `rounding`: the error that a numeric answer may have. By default, numbers need three significant digits.
    - `is_up_to_factor`: whether every nonzero multiple of a vector is correct, too.
    - `locations`: for messages, the file, the line and the key of each value, by key. A key in a table has a dot, as in
      given.m.
    """

    name: str
    answer: str
    texts: tuple[Texts, ...]
    options: tuple[Option, ...] = ()
    given: tuple[GivenValue, ...] = ()
    rows: tuple[str, ...] = ()
    units: tuple[tuple[str, str], ...] = ()
    unit: str = ""
    rounding: Rounding | None = None
    is_up_to_factor: bool = False
    points: float = 1.0
    locations: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    @property
    def answer_key(self) -> str:
        """The key of the answer."""
        return "options" if self.options else "answer"

    def find_location(self, key: str = "") -> str:
        """Return the file, the line and the key of a value; those of the answer if there is no such key."""
        return self.locations.get(key) or self.locations.get(self.answer_key) or self.name

    @property
    def entry_units(self) -> tuple[str, ...]:
        """The units of the entries of a number: one for all entries, or one for each."""
        return split_units(self.unit)

    @property
    def digest(self) -> str:
        """A hash of the question, without its texts and points."""
        ignored_names = ("texts", "points", "locations")
        content = {item.name: getattr(self, item.name) for item in fields(self) if item.name not in ignored_names}
        return hashlib.sha256(repr(content).encode()).hexdigest()[:16]

    def find_texts(self, language: str, has_text: Callable[[Texts], object]) -> Texts:
        """Return the texts in a language if `has_text` is true of them, else those in the first language."""
        matching_texts = (texts for texts in self.texts if texts.language == language and has_text(texts))
        return next(matching_texts, self.texts[0])
