"""A problem, its parts, and the identity that regenerates it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

import sympy as sp

from qdot.exercises.answers import Answer
from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS, Chain
from qdot.exercises.arm.conventions import ALIASES, REGISTRY, convention_of
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.common.errors import QdotError, likeliest
from qdot.exercises.common.variation import AXES, DEFAULT, STEPS, canonical_name
from qdot.exercises.formula.identity import Domain, Rounding
from qdot.exercises.problem.credit import Credit

Kind = TypeVar("Kind", bound=Answer)
About = TypeVar("About", bound="Details")

ENGINE = 1
"""Version of the problem generator: any change of what an id regenerates raises it."""

LARGEST_SEED = (1 << 63) - 1


@dataclass(frozen=True)
class ProblemId:
    """Family, seed, questions and variation; with the engine's version they regenerate the same problem permanently.

    `band` is the lowest and the highest step of difficulty that the arm may have, None for any; `convention` is how the
    arm is described, and `twist_order` the order of its twists, "" for the family's own. As a text it is planar-2r/7,
    followed by everything that is not the default: planar-2r/7@chapter@screws@v-omega.
    """

    family: str
    seed: int
    questions: tuple[str, ...] = ()
    engine: int = ENGINE
    band: tuple[int, int] | None = None
    variation: str = DEFAULT
    convention: str = ""
    twist_order: str = ""

    def __str__(self) -> str:
        marks = ("" if self.variation == DEFAULT else self.variation, self.convention, self.twist_order)
        return "@".join((self.family_and_seed, *filter(None, marks)))

    @property
    def family_and_seed(self) -> str:
        """Family and seed, which determine all random choices: a seed has the same lengths in all variations."""
        return f"{self.family}/{self.seed}"

    def with_variation(self, variation: str) -> "ProblemId":
        """Return the identity with another variation, if one is given. Raises QdotError if it is unknown."""
        return replace(self, variation=canonical_name(variation)) if variation else self

    def with_convention(self, convention: str, twist_order: str = "") -> "ProblemId":
        """Return the identity with another convention and another order of twists, if they are given.

        Only an arm described by its axes has an order. Raises QdotError for unknown ones, and for an order of a table.
        """
        chosen = find_convention(convention) if convention else self.convention
        order = find_twist_order(twist_order) if twist_order else self.twist_order
        is_ordered = bool(REGISTRY[chosen].twist_orders) if chosen else not convention
        if (twist_order or order) and not is_ordered:
            table = f"is told by a table (convention = {convention or chosen!r})"
            raise QdotError(f"{self.family_and_seed} {table}; {OF_ORDER}")
        return replace(self, convention=BY_AXES if twist_order else chosen, twist_order=order)

    @staticmethod
    def parse(text: str, hint: str = "") -> "ProblemId":
        """Parse FAMILY/SEED, followed by @VARIATION, @CONVENTION and @ORDER or some of these.

        Raises QdotError, with `hint` for a text of another form.
        """
        match = re.fullmatch(r"([a-z0-9-]+)/0*(\d+)((?:@[a-z0-9_+-]+)*)", text, re.IGNORECASE | re.ASCII)
        if match is None:
            raise QdotError(f"{text!r} is not a problem; write FAMILY/SEED, as in planar-2r/7{hint}")
        family, seed, marks = match.groups()
        if text != text.lower():
            meant = ProblemId.parse(text.lower(), hint)
            raise QdotError(
                f"{text!r} has capital letters, and names have none; {str(meant)!r} is meant, probably{hint}"
            )
        if len(seed) > len(str(LARGEST_SEED)) or int(seed) > LARGEST_SEED:
            raise QdotError(f"{family}/{seed[:25]}{'…' * (len(seed) > 25)}: the largest seed is {LARGEST_SEED}")
        sorted_marks = _sort_marks(text, marks.split("@")[1:])
        problem = ProblemId(family, int(seed)).with_variation(sorted_marks["variation"])
        return problem.with_convention(sorted_marks["convention"], sorted_marks["order of twists"])


def _sort_marks(text: str, marks: Sequence[str]) -> dict[str, str]:
    """Return the mark of each kind (`_MARKS`) in an identity, "" if there is none.

    Raises QdotError for two of a kind; for an unknown mark, it lists the known ones.
    """
    sorted_marks = dict.fromkeys(_MARKS, "")
    for mark in marks:
        kind = next((kind for kind, names in _MARKS.items() if mark in names), "variation" if "+" in mark else "")
        if not kind:
            called = mark.replace("_", "-")
            known = {name: kind for kind, names in _MARKS.items() for name in names}
            meant = ALIASES.get(called) or likeliest(mark, list(known))
            is_what = f" (did you mean the {known[meant]} {meant!r}?)" if meant else ""
            raise QdotError(
                f"{text!r}: {mark!r} is neither a variation nor a convention nor an order of twists{is_what}; "
                f"variations: {', '.join(STEPS)}, or axes, as in lengths+base, out of {', '.join(AXES)}; "
                f"conventions: {', '.join(CONVENTIONS)}; orders of twists: {', '.join(TWIST_ORDERS)}"
            )
        if sorted_marks[kind]:
            kinds = "orders of twists" if kind == "order of twists" else f"{kind}s"
            raise QdotError(f"{text!r} names two {kinds}, {sorted_marks[kind]} and {mark}; it may have one of each")
        sorted_marks[kind] = mark
    return sorted_marks


BY_AXES = Screws.name
OF_ORDER = f'the order of twists is for arms that are told by their axes (convention = "{BY_AXES}")'

_MARKS = {"convention": CONVENTIONS, "order of twists": TWIST_ORDERS, "variation": (*STEPS, *AXES)}


def find_twist_order(name: str) -> str:
    """Return the order of twists for an identity, "" for the default one. Raises QdotError if it is unknown."""
    return _find("order of twists", name, TWIST_ORDERS, {})


def find_convention(name: str) -> str:
    """Return the convention for an identity, "" for the default one. Raises QdotError if it is unknown."""
    return _find("convention", name, CONVENTIONS, ALIASES)


def _find(kind: str, name: str, known: tuple[str, ...], aliases: Mapping[str, str]) -> str:
    if name not in known:
        called = name.lower().replace("_", "-").replace(" ", "")
        likely = aliases.get(called) or likeliest(called, known)
        hint = f" (did you mean {likely!r}?)" if likely else ""
        raise QdotError(f"unknown {kind} {name!r}{hint}; known: {', '.join(known)}")
    return "" if name == known[0] else name


@dataclass(frozen=True)
class SymbolInfo:
    """What a symbol of a problem stands for: role (joint, rate, velocity, force, length, angle), unit, given value."""

    role: str
    unit: str
    value: sp.Expr | None = None


def by_name(values: Mapping[sp.Symbol, sp.Expr]) -> dict[str, float]:
    """Return the numeric values by name."""
    return {symbol.name: float(value) for symbol, value in values.items() if not value.free_symbols}


@dataclass(frozen=True, kw_only=True)
class Details:
    """What the wording and the tests of a part need in addition to its answer; each kind of question has a subclass.

    `symbols` may be used in answers in addition to those of the arm, `units` are the units of formulas, `pose` (joint's
    name -> value) is the pose of the figure under the prompt, and `drawn` means that the options are drawings. Defaults
    are not recorded, so they do not change digests.
    """

    symbols: Mapping[str, SymbolInfo] | None = None
    units: tuple[str, ...] | None = None
    pose: Mapping[str, float] | None = None
    drawn: bool = False

    def given_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the given lengths, joint values and velocities; {} for a question in formulas."""
        return {}

    def shown_values(self, chain: Chain) -> Mapping[str, float]:
        """Return the lengths and joint values of the arm beside the question, as its figure and its text have them."""
        return {**by_name(self.given_joints), **self.given_values(chain), **(self.pose or {})}

    @property
    def given_joints(self) -> Mapping[sp.Symbol, sp.Expr]:
        """The given joint values of an answer in formulas; they may contain lengths."""
        return {}


@dataclass(frozen=True, kw_only=True)
class OneOfSeveral(Details):
    """About one of several results that a question asks for: equal details are the same result of a structure."""


@dataclass(frozen=True)
class Part:
    """One question of a problem: what is asked, its answer, points, and the parts whose result it builds on.

    `details` are of a class of the question's own (`about`). `rounding` is what the assignment allows decimals to be
    off, None for formulas without rounding and numbers to three digits; `credit` is how it marks an answer that is
    right in part, None for the question's own way.
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

    def of(self, kind: type[Kind]) -> Kind:
        """Return the answer, which has to be of this type; else raise TypeError."""
        if not isinstance(self.answer, kind):
            raise TypeError(f"the answer to {self.kind!r} is of type {self.type}, not {kind.type}")
        return self.answer

    def about(self, kind: type[About]) -> About:
        """Return the details, which have to be of this class; else raise TypeError."""
        if not isinstance(self.details, kind):
            raise TypeError(f"the details of {self.kind!r} are {type(self.details).__name__}, not {kind.__name__}")
        return self.details

    @property
    def precision(self) -> str:
        """How exactly numbers are wanted: as the assignment says, else to three digits."""
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
        """The symbols that this part brings with it, as the forces of a static question."""
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
        for part in self.parts:
            if part.name == name:
                return part
        raise KeyError(f"{self.id} asks {', '.join(part.name for part in self.parts)}, not {name!r}")

    @property
    def title(self) -> str:
        """What its arm is called, as a heading."""
        named = self.chain.title or "arm"
        return f"{named[:1].upper()}{named[1:]}"

    def symbols(self) -> dict[str, SymbolInfo]:
        """Return every symbol that an answer may use, the table's numbers under their usual names included."""
        known: dict[str, SymbolInfo] = {}
        for joint, q, rate in zip(self.chain.joints, self.chain.q, self.chain.rates, strict=True):
            revolute = joint.kind == "R"
            known[q.name] = SymbolInfo("joint", "rad" if revolute else "m")
            known[rate.name] = SymbolInfo("rate", "rad/s" if revolute else "m/s")
        for row in self.chain.task:
            known[row] = SymbolInfo("velocity", "m/s" if row[0] == "v" else "rad/s")
        for symbol in self.chain.parameters:
            angle = symbol.name.startswith(("alpha", "beta"))
            known[symbol.name] = SymbolInfo("angle" if angle else "length", "rad" if angle else "m")
        for number, joint in enumerate(self.chain.joints if convention_of(self.chain).has_frames else (), 1):
            for letter, value in (("a", joint.a), ("d", joint.d if joint.kind == "R" else sp.S.Zero)):
                if value.is_number and value != 0:
                    known.setdefault(f"{letter}{number}", SymbolInfo("length", "m", value))
        for part in self.parts:
            known.update(part.symbols)
        return known

    @property
    def constants(self) -> frozenset[str]:
        """The lengths and angles of the arm that no motion changes."""
        return frozenset(name for name, info in self.symbols().items() if info.role in ("length", "angle"))

    def domain(self) -> Domain:
        """Return what each symbol of the problem may be; a length that is given has its value."""
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
        """The points of all parts together."""
        return sum(part.points for part in self.parts)


def variable(slot: str, part: str) -> str:
    """Return the name of the variable that holds the answer to a part.

    >>> variable("p1", "inverse-jacobian")
    'p1_inverse_jacobian'
    """
    return f"{slot}_{part.replace('-', '_')}"
