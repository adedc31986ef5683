"""Define a problem (an arm and questions about it), its parts, and the identity from which it can be regenerated."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS, Chain, is_angle_symbol
from qdot.exercises.arm.conventions import ALIASES, REGISTRY, convention_of
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.common.errors import QdotError, find_most_similar, make_name_error
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_AXES, VARIATION_STEPS, find_canonical_name
from qdot.exercises.formula.equality import Domain, Rounding
from qdot.exercises.formula.units import parse_unit
from qdot.exercises.problem.credit import Credit
from qdot.exercises.reference_answers import Answer

AnswerType = TypeVar("AnswerType", bound=Answer)
DetailsType = TypeVar("DetailsType", bound="Details")

ENGINE = 1
"""The version of the problem generator. It increases whenever the same id would give a different problem."""

MAX_SEED = (1 << 63) - 1
"""The largest seed in the id of a problem: the largest signed integer of 64 bits."""


@dataclass(frozen=True)
class ProblemId:
    """The identity of a problem, from which the same version of the generator always makes the same problem.

    - `family` is a family of arms, such as planar-2r, and `seed` determines all random choices.
    - `questions` are the names of the questions; if there are none, the family's usual questions are asked.
    - `engine` is the version of the problem generator.
    - `band` has the minimum and the maximum level of difficulty of the arm; None allows any level.
    - `variation` says how much the arm may differ from the chapter's arm ("chapter" means not at all).
    - `convention` is the convention in which the arm is described: a kind of DH table, or screw axes. `twist_order` is
      the order of the rows of its twists: omega-v or v-omega. Both are "" for the family's default.

    In text, an identity is FAMILY/SEED, followed by all that is not the default: planar-2r/7@chapter@screws@v-omega.
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
        suffixes = ("" if self.variation == DEFAULT_VARIATION else self.variation, self.convention, self.twist_order)
        return "@".join((self.family_and_seed, *filter(None, suffixes)))

    @property
    def family_and_seed(self) -> str:
        """FAMILY/SEED, the name of streams of random numbers that all variations share."""
        return f"{self.family}/{self.seed}"

    @property
    def stream_name(self) -> str:
        """The version of the generator and the text form: the name of this identity's own streams of random numbers."""
        return f"{self.engine}/{self}"

    def with_variation(self, variation: str) -> "ProblemId":
        """Return the identity with another variation; "" changes nothing. Raises QdotError for an unknown variation."""
        return replace(self, variation=find_canonical_name(variation)) if variation else self

    def with_convention(self, convention: str, twist_order: str = "") -> "ProblemId":
        """Return the identity with another convention and another order of twists; "" changes nothing.

        Only an arm that is described by its screw axes has an order of twists. Raises QdotError for unknown names, and
        for an order of twists if the arm is described by a table.
        """
        new_convention = normalize_convention(convention) if convention else self.convention
        new_order = normalize_twist_order(twist_order) if twist_order else self.twist_order
        # An order of twists alone implies screw axes, unless `convention` names the default convention, a table.
        has_twist_order = bool(REGISTRY[new_convention].twist_orders) if new_convention else not convention
        if (twist_order or new_order) and not has_twist_order:
            table_words = f"is described by a table (convention = {convention or new_convention!r})"
            raise QdotError(f"{self.family_and_seed} {table_words}; {TWIST_ORDER_HINT}")
        return replace(self, convention=SCREW_CONVENTION if twist_order else new_convention, twist_order=new_order)

    @staticmethod
    def parse(text: str, hint: str = "") -> "ProblemId":
        """Parse FAMILY/SEED, followed by any of @VARIATION, @CONVENTION and @ORDER.

        Raises QdotError, with `hint` at the end of the message, if the text has another form.
        """
        match = re.fullmatch(r"([a-z0-9-]+)/0*(\d+)((?:@[a-z0-9_+-]+)*)", text, re.IGNORECASE | re.ASCII)
        if match is None:
            raise QdotError(f"{text!r} is not a problem; write FAMILY/SEED, as in planar-2r/7{hint}")
        family, seed, suffixes = match.groups()
        if text != text.lower():
            lower_case = str(ProblemId.parse(text.lower(), hint))
            raise QdotError(f"{text!r} has capital letters, but names are lower-case: write {lower_case!r}{hint}")
        if len(seed) > len(str(MAX_SEED)) or int(seed) > MAX_SEED:
            shown_seed = seed if len(seed) <= 25 else f"{seed[:25]}…"
            raise QdotError(f"{family}/{shown_seed}: the largest seed is {MAX_SEED}")
        suffix_of_kind = _classify_suffixes(text, suffixes.split("@")[1:])
        problem = ProblemId(family, int(seed)).with_variation(suffix_of_kind["variation"])
        return problem.with_convention(suffix_of_kind["convention"], suffix_of_kind["order of twists"])


def _classify_suffixes(text: str, suffixes: Sequence[str]) -> dict[str, str]:
    """Return the variation, the convention and the order of twists among the @ suffixes of an id; "" for none.

    Raises QdotError for two suffixes of the same kind, and for an unknown suffix. `text` is the id, for the message.
    """
    suffix_of_kind = dict.fromkeys(_SUFFIXES, "")
    for suffix in suffixes:
        default_kind = "variation" if "+" in suffix else ""
        kind = next((kind for kind, names in _SUFFIXES.items() if suffix in names), default_kind)
        if not kind:
            kinds = {name: kind for kind, names in _SUFFIXES.items() for name in names}
            suggestion = ALIASES.get(suffix.replace("_", "-")) or find_most_similar(suffix, list(kinds))
            hint = f" (did you mean the {kinds[suggestion]} {suggestion!r}?)" if suggestion else ""
            raise QdotError(
                f"{text!r}: {suffix!r} is neither a variation nor a convention nor an order of twists{hint}; "
                f"variations: {', '.join(VARIATION_STEPS)}, or axes, as in lengths+base, out of "
                f"{', '.join(VARIATION_AXES)}; "
                f"conventions: {', '.join(CONVENTIONS)}; orders of twists: {', '.join(TWIST_ORDERS)}"
            )
        if suffix_of_kind[kind]:
            plural = "orders of twists" if kind == "order of twists" else f"{kind}s"
            names = f"{suffix_of_kind[kind]} and {suffix}"
            raise QdotError(f"{text!r} names two {plural}, {names}; it may have one of each")
        suffix_of_kind[kind] = suffix
    return suffix_of_kind


SCREW_CONVENTION = Screws.name
TWIST_ORDER_HINT = (
    f'the order of twists applies only to arms described by screw axes (convention = "{SCREW_CONVENTION}")'
)

_SUFFIXES = {
    "convention": CONVENTIONS, "order of twists": TWIST_ORDERS, "variation": (*VARIATION_STEPS, *VARIATION_AXES),
}  # fmt: skip
"""The names that may follow the seed of an id, each after an @, by their kind."""


def normalize_twist_order(name: str) -> str:
    """Return the name of an order of twists for an identity; "" for the default order. Raises QdotError if unknown."""
    return _normalize_name("order of twists", name, TWIST_ORDERS, {})


def normalize_convention(name: str) -> str:
    """Return the name of a convention for an identity; "" for the default convention. Raises QdotError if unknown."""
    return _normalize_name("convention", name, CONVENTIONS, ALIASES)


def _normalize_name(kind: str, name: str, known_names: tuple[str, ...], aliases: Mapping[str, str]) -> str:
    """Return a name, or "" for the first of the known names, which is the default."""
    if name not in known_names:
        normalized_name = name.lower().replace("_", "-").replace(" ", "")
        suggestion = aliases.get(normalized_name) or find_most_similar(normalized_name, known_names)
        raise make_name_error(kind, name, known_names, suggestion)
    return "" if name == known_names[0] else name


@dataclass(frozen=True)
class SymbolInfo:
    """The meaning of a symbol: its role (joint, rate, velocity, force, moment, length or angle), unit and value.

    `value` is the number of a length or angle in the arm's table; it is None for a symbol without a given value.
    """

    role: str
    unit: str
    value: sp.Expr | None = None

    @property
    def is_positive(self) -> bool:
        """Whether the symbol's unit is that of a quantity that is never negative, such as a mass."""
        unit = parse_unit(self.unit)
        return unit is not None and unit.dimension in _POSITIVE_DIMENSIONS


_POSITIVE_DIMENSIONS = {(1, 0, 0), (1, -1, 0), (1, -3, 0), (1, 0, -1), (1, 0, -2)}
"""The powers of kg, m and s of masses, densities, damping constants and stiffnesses.

Forces, moments, accelerations and products of inertia may be negative.
"""


def list_values_by_name(values: Mapping[sp.Symbol, sp.Expr]) -> dict[str, float]:
    """Return the values of symbols as floats, by the symbols' names, without values that contain other symbols."""
    return {symbol.name: float(value) for symbol, value in values.items() if not value.free_symbols}


RECORDED_NAME = "recorded name"
"""The key of a field's metadata under which `record` finds the field's name in problem digests."""


def recorded_as(name: str) -> dict[str, str]:
    """Return the metadata that gives a field the name `name` in problem digests, or GROUP.NAME for a name in a group.

    Certificates contain the digests, so these names can't change, even if the field is renamed.
    """
    return {RECORDED_NAME: name}


@dataclass(frozen=True, kw_only=True)
class Details:
    """What a part states or uses besides its answer, such as a configuration, options, or steps to the answer.

    Prompts, solutions and the grader use the details. Questions that need other fields have subclasses.

    - `symbols` are symbols that answers may use in addition to those of the arm, such as forces.
    - `units` are the units of the answer's entries, if they are formulas.
    - `pose` is the configuration that the figure under the prompt shows: the value of each joint variable by name.
    - `has_drawn_options` means that the options are drawings.

    A field that has its default value does not change the problem's digests.
    """

    symbols: Mapping[str, SymbolInfo] | None = None
    units: tuple[str, ...] | None = None
    pose: Mapping[str, float] | None = None
    has_drawn_options: bool = field(default=False, metadata=recorded_as("drawn"))

    @property
    def question(self) -> Any:
        """The question if an instructor has defined it, else None."""
        return None

    def list_given_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the lengths, joint values and velocities that the question gives, by name; {} for none."""
        return {}

    def list_shown_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the lengths and joint values that the question's figure and text show, by name."""
        return {**list_values_by_name(self.given_joints), **self.list_given_values(chain), **(self.pose or {})}

    @property
    def given_joints(self) -> Mapping[sp.Symbol, sp.Expr]:
        """The joint values, which may contain lengths, at which a formula is asked for; {} for any configuration."""
        return {}


@dataclass(frozen=True, kw_only=True)
class ResultChoiceDetails(Details):
    """Details that say which of an arm's results is asked for, so that equal details mean equal answers."""


@dataclass(frozen=True)
class Part:
    """One question of a problem.

    - `name` is unique in the problem. `kind` is the name of the question in the registry of all questions.
    - `prerequisites` are the names of the problem's parts whose results help to find this answer.
    - `details` contains the other values that the part states or uses, in a class for this kind of question.
    - `rounding` is the error that the assignment allows for decimals. If it is None, formulas are exact and numbers
      have three digits.
    - `credit` is the assignment's rule for partly correct answers.
    """

    name: str
    kind: str
    answer: Answer
    points: float = 1.0
    prerequisites: tuple[str, ...] = ()
    details: Details = field(default_factory=Details)
    rounding: Rounding | None = None
    credit: Credit = field(default_factory=Credit)

    def __repr__(self) -> str:
        shape = "" if self.shape is None else f" {self.shape[0]} x {self.shape[1]}"
        return f"Part({self.name}: {self.type}{shape}, {self.points:g} points)"

    def answer_as(self, answer_type: type[AnswerType]) -> AnswerType:
        """Return the answer, with the static type `answer_type`. Raises TypeError if the answer is of another type."""
        if not isinstance(self.answer, answer_type):
            raise TypeError(f"the answer to {self.kind!r} is of type {self.type}, not {answer_type.type}")
        return self.answer

    def details_as(self, details_type: type[DetailsType]) -> DetailsType:
        """Return the details, with the static type `details_type`. Raises TypeError if they are of another class."""
        if not isinstance(self.details, details_type):
            class_name = type(self.details).__name__
            raise TypeError(f"the details of {self.kind!r} are {class_name}, not {details_type.__name__}")
        return self.details

    @property
    def precision(self) -> str:
        """The expected precision of numbers, in words: that of the assignment, or else three digits."""
        return self.rounding.words if self.rounding is not None else "to three significant digits"

    def count_digits(self, value: float, at_least: int = 3) -> int:
        """Return the number of significant digits with which a number, if shown, would be accepted as an answer."""
        return at_least if self.rounding is None else max(at_least, self.rounding.count_digits(value))

    @property
    def type(self) -> str:
        """The type of the answer: expression, matrix, singular, number, direction, choice, selection or matching."""
        return self.answer.type

    @property
    def shape(self) -> tuple[int, int] | None:
        """The numbers of rows and columns of a matrix, of numbers or of a direction; None for other answers."""
        return self.answer.shape

    @property
    def symbols(self) -> Mapping[str, SymbolInfo]:
        """The symbols that only this part has, such as the forces of a statics question."""
        return self.details.symbols or {}


def list_table_numbers(chain: Chain) -> dict[str, sp.Expr]:
    """Return the nonzero numeric lengths in the arm's table by the names a1, d1, …; {} if the arm has no table."""
    numbers: dict[str, sp.Expr] = {}
    for row, joint in enumerate(chain.joints if convention_of(chain).shows_table else (), 1):
        lengths = {f"a{row}": joint.a, f"d{row}": joint.d if joint.is_revolute else sp.S.Zero}
        numbers |= {name: value for name, value in lengths.items() if value.is_number and value != 0}
    return numbers


@dataclass(frozen=True)
class Problem:
    """An arm and the questions asked about it."""

    id: ProblemId
    chain: Chain
    parts: tuple[Part, ...]

    def __repr__(self) -> str:
        return f"Problem({self.id}: {', '.join(part.name for part in self.parts)})"

    def __getitem__(self, name: str) -> Part:
        """Return the part with a name. Raises KeyError if the problem has no such part."""
        parts = {part.name: part for part in self.parts}
        if name not in parts:
            raise KeyError(f"{self.id} asks {', '.join(parts)}, not {name!r}")
        return parts[name]

    @property
    def title(self) -> str:
        """The arm's name with a capital letter, as a heading."""
        name = self.chain.title or "arm"
        return f"{name[:1].upper()}{name[1:]}"

    @property
    def symbols(self) -> dict[str, SymbolInfo]:
        """The meaning of every symbol that an answer may use, by name.

        A number in the arm's table has a name, too, such as a1 or d1, because students may type the name instead.
        """
        symbols: dict[str, SymbolInfo] = {}
        for joint, q, rate in zip(self.chain.joints, self.chain.q, self.chain.rates, strict=True):
            unit = "rad" if joint.is_revolute else "m"
            symbols[q.name], symbols[rate.name] = SymbolInfo("joint", unit), SymbolInfo("rate", f"{unit}/s")
        for row in self.chain.task:
            symbols[row] = SymbolInfo("velocity", "m/s" if row[0] == "v" else "rad/s")
        for symbol in self.chain.parameters:
            is_angle = is_angle_symbol(symbol)
            symbols[symbol.name] = SymbolInfo("angle" if is_angle else "length", "rad" if is_angle else "m")
        for name, value in list_table_numbers(self.chain).items():
            symbols.setdefault(name, SymbolInfo("length", "m", value))
        for part in self.parts:
            symbols.update(part.symbols)
        return symbols

    @property
    def constants(self) -> frozenset[str]:
        """The names of the arm's constant lengths and angles."""
        return frozenset(name for name, info in self.symbols.items() if info.role in ("length", "angle"))

    @cached_property
    def domain(self) -> Domain:
        """The domain from which symbols are sampled to compare formulas: the role or the value of each symbol."""
        roles: dict[str, str | float | Fraction] = {}
        for name, info in self.symbols.items():
            if (value := info.value) is not None:
                roles[name] = Fraction(int(value.p), int(value.q)) if value.is_Rational else float(value)
            elif info.role == "joint":
                roles[name] = "angle" if info.unit == "rad" else "signed"
            else:
                default_role = "positive" if info.is_positive else "signed"
                roles[name] = info.role if info.role in ("length", "angle") else default_role
        return Domain(roles)

    def select_domain(self, part: Part) -> Domain:
        """Return the domain for the answer to a part: messages about unknown names don't list other parts' symbols."""
        other_symbols = {name for other_part in self.parts for name in other_part.symbols} - set(part.symbols)
        return replace(self.domain, unlisted_names=frozenset(other_symbols))

    @property
    def max_points(self) -> float:
        """The sum of the points of all parts."""
        return sum(part.points for part in self.parts)


def name_answer_variable(slot: str, part: str) -> str:
    """Return the name of the variable in a notebook for the answer to a part; `slot` is the problem's prefix.

    >>> name_answer_variable("p1", "inverse-jacobian")
    'p1_inverse_jacobian'
    """
    return f"{slot}_{part.replace('-', '_')}"
