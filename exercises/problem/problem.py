"""A problem, its parts, and the identity that regenerates it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

import sympy as sp

from qdot.exercises.answer_types import Answer
from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS, Chain
from qdot.exercises.arm.conventions import ALIASES, REGISTRY, convention_of
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.common.errors import QdotError, find_most_similar
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_AXES, VARIATION_STEPS, find_canonical_name
from qdot.exercises.formula.equality import Domain, Rounding
from qdot.exercises.problem.credit import Credit

AnswerType = TypeVar("AnswerType", bound=Answer)
DetailsType = TypeVar("DetailsType", bound="Details")

ENGINE = 1
"""Version of the problem generator. It increases whenever the same id would regenerate a different problem."""

MAX_SEED = (1 << 63) - 1


@dataclass(frozen=True)
class ProblemId:
    """The identity of a problem, from which the same version of the generator always makes the same problem.

    `engine` is this version. `band` is the minimum and the maximum difficulty of the arm, or None for any.
    `convention` is the convention in which the arm is described, and `twist_order` is the order of its twists; both
    are "" for the default of the family.
    The text form is planar-2r/7, followed by everything that is not the default: planar-2r/7@chapter@screws@v-omega.
    """

    family: str
    seed: int
    questions: tuple[str, ...] = ()
    engine: int = ENGINE
    band: tuple[int, int] | None = None
    variation: str = DEFAULT_VARIATION
    convention: str = ""
    twist_order: str = ""

    def __str__(self) -> str:
        marks = ("" if self.variation == DEFAULT_VARIATION else self.variation, self.convention, self.twist_order)
        return "@".join((self.family_and_seed, *filter(None, marks)))

    @property
    def family_and_seed(self) -> str:
        """Family and seed, which determine all random choices: the lengths are the same in all variations."""
        return f"{self.family}/{self.seed}"

    def with_variation(self, variation: str) -> "ProblemId":
        """Return the identity with another variation, if one is given. Raises QdotError if it is unknown."""
        return replace(self, variation=find_canonical_name(variation)) if variation else self

    def with_convention(self, convention: str, twist_order: str = "") -> "ProblemId":
        """Return the identity with another convention and another order of twists, if they are given.

        Only an arm described by its axes has an order of twists. Raises QdotError for unknown names, and for an order
        of twists if the arm is described by a table.
        """
        chosen = find_convention(convention) if convention else self.convention
        order = find_twist_order(twist_order) if twist_order else self.twist_order
        is_ordered = bool(REGISTRY[chosen].twist_orders) if chosen else not convention
        if (twist_order or order) and not is_ordered:
            table_words = f"is described by a table (convention = {convention or chosen!r})"
            raise QdotError(f"{self.family_and_seed} {table_words}; {TWIST_ORDER_HINT}")
        return replace(self, convention=SCREW_CONVENTION if twist_order else chosen, twist_order=order)

    @staticmethod
    def parse(text: str, hint: str = "") -> "ProblemId":
        """Parse FAMILY/SEED, followed by any of @VARIATION, @CONVENTION and @ORDER.

        Raises QdotError; the message ends with `hint` if the text has another form.
        """
        match = re.fullmatch(r"([a-z0-9-]+)/0*(\d+)((?:@[a-z0-9_+-]+)*)", text, re.IGNORECASE | re.ASCII)
        if match is None:
            raise QdotError(f"{text!r} is not a problem; write FAMILY/SEED, as in planar-2r/7{hint}")
        family, seed, marks = match.groups()
        if text != text.lower():
            lower_case = str(ProblemId.parse(text.lower(), hint))
            raise QdotError(f"{text!r} has capital letters, but names are lower-case: write {lower_case!r}{hint}")
        if len(seed) > len(str(MAX_SEED)) or int(seed) > MAX_SEED:
            raise QdotError(f"{family}/{seed[:25]}{'…' * (len(seed) > 25)}: the largest seed is {MAX_SEED}")
        sorted_marks = _sort_suffixes(text, marks.split("@")[1:])
        problem = ProblemId(family, int(seed)).with_variation(sorted_marks["variation"])
        return problem.with_convention(sorted_marks["convention"], sorted_marks["order of twists"])


def _sort_suffixes(text: str, suffixes: Sequence[str]) -> dict[str, str]:
    """Return the variation, the convention and the order of twists from the @ suffixes of an id; "" if not given.

    Raises QdotError for two suffixes of the same kind, and for an unknown suffix.
    """
    sorted_marks = dict.fromkeys(_SUFFIXES, "")
    for mark in suffixes:
        kind = next((kind for kind, names in _SUFFIXES.items() if mark in names), "variation" if "+" in mark else "")
        if not kind:
            mark_name = mark.replace("_", "-")
            known_suffixes = {name: kind for kind, names in _SUFFIXES.items() for name in names}
            suggestion = ALIASES.get(mark_name) or find_most_similar(mark, list(known_suffixes))
            hint = f" (did you mean the {known_suffixes[suggestion]} {suggestion!r}?)" if suggestion else ""
            raise QdotError(
                f"{text!r}: {mark!r} is neither a variation nor a convention nor an order of twists{hint}; "
                f"variations: {', '.join(VARIATION_STEPS)}, or axes, as in lengths+base, out of "
                f"{', '.join(VARIATION_AXES)}; "
                f"conventions: {', '.join(CONVENTIONS)}; orders of twists: {', '.join(TWIST_ORDERS)}"
            )
        if sorted_marks[kind]:
            kinds = "orders of twists" if kind == "order of twists" else f"{kind}s"
            raise QdotError(f"{text!r} names two {kinds}, {sorted_marks[kind]} and {mark}; it may have one of each")
        sorted_marks[kind] = mark
    return sorted_marks


SCREW_CONVENTION = Screws.name
TWIST_ORDER_HINT = (
    f'the order of twists applies only to arms described by screw axes (convention = "{SCREW_CONVENTION}")'
)

_VARIATIONS = (*VARIATION_STEPS, *VARIATION_AXES)
_SUFFIXES = {"convention": CONVENTIONS, "order of twists": TWIST_ORDERS, "variation": _VARIATIONS}


def find_twist_order(name: str) -> str:
    """Return the order of twists for an identity, "" for the default one. Raises QdotError if it is unknown."""
    return _find_name("order of twists", name, TWIST_ORDERS, {})


def find_convention(name: str) -> str:
    """Return the convention for an identity, "" for the default one. Raises QdotError if it is unknown."""
    return _find_name("convention", name, CONVENTIONS, ALIASES)


def _find_name(kind: str, name: str, known: tuple[str, ...], aliases: Mapping[str, str]) -> str:
    if name not in known:
        normalized_name = name.lower().replace("_", "-").replace(" ", "")
        suggestion = aliases.get(normalized_name) or find_most_similar(normalized_name, known)
        hint = f" (did you mean {suggestion!r}?)" if suggestion else ""
        raise QdotError(f"unknown {kind} {name!r}{hint}; known: {', '.join(known)}")
    return "" if name == known[0] else name


@dataclass(frozen=True)
class SymbolInfo:
    """The meaning of a symbol: its role (joint, rate, velocity, force, length, angle), unit, and given value."""

    role: str
    unit: str
    value: sp.Expr | None = None


def values_by_name(values: Mapping[sp.Symbol, sp.Expr]) -> dict[str, float]:
    """Return the numeric values by name."""
    return {symbol.name: float(value) for symbol, value in values.items() if not value.free_symbols}


@dataclass(frozen=True, kw_only=True)
class Details:
    """The data of a part besides its answer, used by its texts and tests; each kind of question has a subclass.

    `symbols` may be used in answers in addition to those of the arm. `units` are the units of formulas. `pose` is the
    configuration shown in the figure under the prompt: the value of each joint by its name. `drawn` means that the
    options are drawings. A field with its default value does not change the problem's digests.
    """

    symbols: Mapping[str, SymbolInfo] | None = None
    units: tuple[str, ...] | None = None
    pose: Mapping[str, float] | None = None
    drawn: bool = False

    def given_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the given lengths, joint values and velocities; {} for a symbolic question."""
        return {}

    def shown_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the lengths and joint values of the arm that the question's figure and text show."""
        return {**values_by_name(self.given_joints), **self.given_values(chain), **(self.pose or {})}

    @property
    def given_joints(self) -> Mapping[sp.Symbol, sp.Expr]:
        """The given joint values of a symbolic answer; they may contain lengths."""
        return {}


@dataclass(frozen=True, kw_only=True)
class ResultChoiceDetails(Details):
    """Details of a question that asks for one of several results; equal details mean the same result of an arm."""


@dataclass(frozen=True)
class Part:
    """One question of a problem: its kind, its answer, its points, and the names of the parts whose results it needs.

    `details` holds the question's other data, in a class specific to the question. `rounding` is the error that the
    assignment allows for decimals; if it is None, formulas are exact and numbers have three digits. `credit` is the
    assignment's rule for partly correct answers, None for the question's default.
    """

    name: str
    kind: str
    answer: Answer
    points: float = 1.0
    needs: tuple[str, ...] = ()
    details: Details = field(default_factory=Details)
    rounding: Rounding | None = None
    credit: Credit | None = None

    def __repr__(self) -> str:
        shape = "" if self.shape is None else f" {self.shape[0]} x {self.shape[1]}"
        return f"Part({self.name}: {self.type}{shape}, {self.points:g} points)"

    def answer_as(self, answer_type: type[AnswerType]) -> AnswerType:
        """Return the answer, typed as `answer_type`. Raises TypeError if it is of another type."""
        if not isinstance(self.answer, answer_type):
            raise TypeError(f"the answer to {self.kind!r} is of type {self.type}, not {answer_type.type}")
        return self.answer

    def details_as(self, details_type: type[DetailsType]) -> DetailsType:
        """Return the details, typed as `details_type`. Raises TypeError if they are of another class."""
        if not isinstance(self.details, details_type):
            found = type(self.details).__name__
            raise TypeError(f"the details of {self.kind!r} are {found}, not {details_type.__name__}")
        return self.details

    @property
    def effective_credit(self) -> Credit:
        """The rule for partly correct answers: the assignment's, or else the question's default."""
        return self.credit or Credit()

    @property
    def precision(self) -> str:
        """The expected precision of numbers, in words: the assignment's, or else three digits."""
        return self.rounding.words if self.rounding is not None else "to three significant digits"

    @property
    def type(self) -> str:
        """The type of the answer: expression, matrix, singular, number, direction, choice, selection or matching."""
        return self.answer.type

    @property
    def shape(self) -> tuple[int, int] | None:
        """Rows and columns of a matrix, of numbers or of a direction, else None."""
        return self.answer.shape

    @property
    def symbols(self) -> Mapping[str, SymbolInfo]:
        """The symbols that only this part has, such as the forces of a statics question."""
        return self.details.symbols or {}

    @property
    def pose(self) -> Mapping[str, float] | None:
        """The joint values of the figure under the prompt, or None."""
        return self.details.pose

    @property
    def has_drawn_options(self) -> bool:
        """Whether options are drawings of configurations, with the letters under them."""
        return self.details.drawn


@dataclass(frozen=True)
class Problem:
    """An arm and the questions asked about it."""

    id: ProblemId
    chain: Chain
    parts: tuple[Part, ...]

    def __repr__(self) -> str:
        return f"Problem({self.id}: {', '.join(part.name for part in self.parts)})"

    def __getitem__(self, name: str) -> Part:
        """Return the part of that name. Raises KeyError."""
        parts = {part.name: part for part in self.parts}
        if name not in parts:
            raise KeyError(f"{self.id} asks {', '.join(parts)}, not {name!r}")
        return parts[name]

    @property
    def title(self) -> str:
        """The arm's name as a heading."""
        name = self.chain.title or "arm"
        return f"{name[:1].upper()}{name[1:]}"

    def symbols(self) -> dict[str, SymbolInfo]:
        """Return every symbol that an answer may use, including names such as a1 and d1 of numbers in the table."""
        symbols: dict[str, SymbolInfo] = {}
        for joint, q, rate in zip(self.chain.joints, self.chain.q, self.chain.rates, strict=True):
            is_revolute = joint.kind == "R"
            symbols[q.name] = SymbolInfo("joint", "rad" if is_revolute else "m")
            symbols[rate.name] = SymbolInfo("rate", "rad/s" if is_revolute else "m/s")
        for row in self.chain.task:
            symbols[row] = SymbolInfo("velocity", "m/s" if row[0] == "v" else "rad/s")
        for symbol in self.chain.parameters:
            is_angle = symbol.name.startswith(("alpha", "beta"))
            symbols[symbol.name] = SymbolInfo("angle" if is_angle else "length", "rad" if is_angle else "m")
        for number, joint in enumerate(self.chain.joints if convention_of(self.chain).shows_table else (), 1):
            for letter, value in (("a", joint.a), ("d", joint.d if joint.kind == "R" else sp.S.Zero)):
                if value.is_number and value != 0:
                    symbols.setdefault(f"{letter}{number}", SymbolInfo("length", "m", value))
        for part in self.parts:
            symbols.update(part.symbols)
        return symbols

    @property
    def constants(self) -> frozenset[str]:
        """The names of the arm's constant lengths and angles."""
        return frozenset(name for name, info in self.symbols().items() if info.role in ("length", "angle"))

    def domain(self) -> Domain:
        """Return the domain from which the symbols are sampled in comparisons, with the values of given lengths."""
        return self._domain

    @cached_property
    def _domain(self) -> Domain:
        roles: dict[str, str | float | Fraction] = {}
        for name, info in self.symbols().items():
            if info.value is not None:
                value = info.value
                roles[name] = Fraction(int(value.p), int(value.q)) if value.is_Rational else float(value)
            elif info.role == "joint":
                roles[name] = "angle" if info.unit == "rad" else "signed"
            else:
                roles[name] = {"length": "length", "angle": "angle"}.get(info.role, "signed")
        return Domain(roles)

    @property
    def max_points(self) -> float:
        """The sum of the points of all parts."""
        return sum(part.points for part in self.parts)


def answer_variable(slot: str, part: str) -> str:
    """Return the name of the variable that holds the answer to a part.

    >>> answer_variable("p1", "inverse-jacobian")
    'p1_inverse_jacobian'
    """
    return f"{slot}_{part.replace('-', '_')}"
