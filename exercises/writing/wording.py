"""Describe an arm in words that are the same in all questions: its frame, its point of interest, its task, units."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES, Convention
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.questions.base import name_velocity_components
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.singular_set import ValueCombination
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.writing.languages import ENGLISH, Catalogue, load_catalogue
from qdot.exercises.writing.latex import list_lengths, tex, tex_angle, tex_length, tex_result, write_symbol
from qdot.exercises.writing.translatable_phrases import NUMBER_WORDS


@dataclass(frozen=True)
class Wording:
    """What templates say about an arm (`chain`) in a language (`messages`); formulas are LaTeX without dollar signs.

    `solved_kinds` has the kinds of the questions whose solutions come earlier in the same text. Templates do not repeat
    their results.
    """

    chain: Chain
    messages: Catalogue = field(default_factory=lambda: load_catalogue(ENGLISH))
    solved_kinds: frozenset[str] = frozenset()

    @property
    def convention(self) -> Convention:
        """The convention of the arm."""
        return convention_of(self.chain)

    @property
    def velocity_components(self) -> str:
        """The six components of a velocity, in the order in which questions ask for them."""
        names = name_velocity_components(self.convention.velocity_names)
        return ", ".join(names).replace("{", "").replace("}", "")

    def write_twist(self, omega: str, v: str) -> str:
        """Return a twist with the halves `omega` and `v` in the order of the arm's convention."""
        return f"({omega}, {v})" if self.convention.is_omega_first else f"({v}, {omega})"

    @property
    def indexed_axis_names(self) -> list[str]:
        """The names of the axis of joint i: one name for each kind of joint (R, P) that the arm has."""
        kinds = {joint.kind for joint in self.chain.joints}
        names = {"R": self.convention.name_axis(), "P": self.convention.prismatic_axis_name}
        return list(dict.fromkeys(name for kind, name in names.items() if kind in kinds))

    @property
    def frame(self) -> str:
        """The name of the frame in which vectors are expressed."""
        return self.convention.name_reference_frame(self.messages)

    @property
    def joints(self) -> list[str]:
        """The joint variables."""
        return [tex(q) for q in self.chain.q]

    @property
    def rates(self) -> list[str]:
        """The joint rates."""
        return [tex(rate, self.chain) for rate in self.chain.rates]

    @property
    def rate_units(self) -> list[str]:
        """The units of the joint rates."""
        return ["rad/s" if joint.is_revolute else "m/s" for joint in self.chain.joints]

    @property
    def task(self) -> list[str]:
        """The components of velocity that belong to the task."""
        return [write_symbol(row) for row in self.chain.task]

    @property
    def task_units(self) -> str:
        """The unit of the task's velocity, or both units if it has linear and angular rows."""
        return self.join([{"v": "m/s", "w": "rad/s"}[motion] for motion in self.task_motions])

    @property
    def linear_components(self) -> list[str]:
        """The linear components of velocity that belong to the task."""
        return [write_symbol(row) for row in self.chain.task if row[0] == "v"]

    @property
    def mover(self) -> str:
        """The point or body whose velocity belongs to the task."""
        gettext = self.messages.gettext
        return {"v": "$P$", "w": gettext("the last link"), "vw": gettext("$P$ and the last link")}[self.task_motions]

    @property
    def mover_genitive(self) -> str:
        """The mover after "of"; in some languages, this is the genitive without a preposition."""
        gettext = self.messages.gettext
        point, link = gettext("of $P$"), gettext("of the last link")
        return {"v": point, "w": link, "vw": gettext("of $P$ and the last link")}[self.task_motions]

    @property
    def mover_dative(self) -> str:
        """The mover as the recipient in "give the mover a velocity"; in some languages, this is the dative."""
        link = self.messages.pgettext("to whom something is given", "the last link")
        point_and_link = self.messages.pgettext("to whom something is given", "$P$ and the last link")
        return {"v": "$P$", "w": link, "vw": point_and_link}[self.task_motions]

    @property
    def task_motions(self) -> str:
        """The kinds of velocity in the task: "v" (linear), "w" (angular) or "vw" (both)."""
        return "".join(kind for kind in "vw" if any(row[0] == kind for row in self.chain.task))

    @property
    def is_always_invertible(self) -> bool:
        """Whether J has an inverse in every configuration, because det J is a nonzero constant."""
        derivation = derive(self.chain)
        if not derivation.is_square or derivation.determinant == 0:
            return False
        return not derivation.determinant.free_symbols & set(self.chain.q)

    def moves_outside_task(self, component_count: int = len(VELOCITY_NAMES)) -> bool:
        """Return whether the arm can move in a direction outside its task.

        Only the first `component_count` of the velocity components (vx, ..., wz) are considered.
        """
        geometric = derive(self.chain).geometric_jacobian
        outside_task = (i for i, row in enumerate(VELOCITY_NAMES[:component_count]) if row not in self.chain.task)
        return any(not geometric[i, :].is_zero_matrix for i in outside_task)

    @property
    def can_classify_singularities(self) -> bool:
        """Whether boundary and internal singularities can be distinguished for the task."""
        return can_establish_kind(self.chain)

    def list_joints(self, kind: str) -> list[int]:
        """Return the numbers (from 1) of the joints of kind "R" or "P"."""
        return [i for i, joint in enumerate(self.chain.joints, 1) if joint.kind == kind]

    @property
    def rates_with_units(self) -> str:
        """The joint rates, each with its unit, or all with their common unit."""
        units, messages = self.rate_units, self.messages
        if len(units) > 2 and len(set(units)) == 1:
            rates = self.join([f"${rate}$" for rate in self.rates])
            return messages.gettext("%(rates)s, all in %(unit)s", rates=rates, unit=units[0])
        if len(units) > 3 and units.count("m/s") == 1:
            prismatic_index = units.index("m/s")
            return messages.gettext("$%(rate)s$ in m/s, all others in rad/s", rate=self.rates[prismatic_index])
        pairs = zip(self.rates, units, strict=True)
        return ", ".join(messages.gettext("$%(rate)s$ in %(unit)s", rate=rate, unit=unit) for rate, unit in pairs)

    @property
    def joint_count(self) -> str:
        """The number of joints as a word."""
        return self.write_number(self.chain.n)

    def write_number(self, count: int) -> str:
        """Return a small number as a word."""
        return self.messages.translate_phrase(NUMBER_WORDS[count]) if count < len(NUMBER_WORDS) else str(count)

    @property
    def rows(self) -> list[list[str]]:
        """The convention's table, with columns theta_i, d_i, a_i, alpha_i, or alpha_{i-1}, a_{i-1}, d_i, theta_i.

        Angles are in degrees, lengths in metres.
        """
        order, rows = self.convention.order_entries, self.convention.rows
        return [order(tex_angle(row.theta), tex_length(row.d), tex_length(row.a), tex_angle(row.alpha)) for row in rows]

    @property
    def axes_at_home(self) -> list[tuple[str, str, str, str]]:
        """For each joint: its kind, the name of its direction, and the direction and a point of its axis at home."""
        pgettext = self.messages.pgettext
        kinds = {"R": pgettext("of a joint", "revolute"), "P": pgettext("of a joint", "prismatic")}
        rows = []
        for number, axis in enumerate(compute_home_geometry(self.chain).axes, 1):
            name, point = (r"\omega", format_coordinates(axis.point)) if axis.is_revolute else ("v", "")
            direction = ", ".join(map(tex, axis.direction))
            rows.append((kinds[axis.kind], f"{name}_{{{number}}}", f"({direction})", point))
        return rows

    @property
    def point_at_home(self) -> str:
        """The position of P at home."""
        return format_coordinates(compute_home_geometry(self.chain).point)

    # --- the convention ---

    @property
    def exponentials(self) -> str:
        """The product of the joints' exponentials; if there are more than three, only the first and the last."""
        factors = [f"e^{{[S_{{{i}}}]{tex(q)}}}" for i, q in enumerate(self.chain.q, 1)]
        return r"\, ".join(factors) if len(factors) < 4 else rf"{factors[0]} \cdots {factors[-1]}"

    @property
    def first_link_twist(self) -> str:
        """The link twist alpha_0 before joint 1 in a modified table, "" if it is zero."""
        link_twist, _ = self.convention.find_step_to_standard_frame(0)
        return tex_angle(link_twist) if link_twist != 0 else ""

    @property
    def links_in_recursion(self) -> list[int]:
        """The links, from the last to the first, whose vectors are added one by one to get the vectors p*."""
        return list(range(self.chain.n, self.convention.find_frame_on_axis(1), -1))

    def name_origin(self, frame: int) -> str:
        """Return the arm's name for the origin of a standard frame, "" if the convention has no such point."""
        return self.convention.name_origin(frame) or ""

    @property
    def base_position(self) -> str:
        """The coordinates of O_0 in the world frame."""
        return format_coordinates(self.convention.base.position)

    @property
    def base_orientation(self) -> str:
        """The orientation of frame O_0 in the world frame, in words; "" if the frame is not rotated."""
        base, messages = self.convention.base, self.messages
        yaw, tilt = tex_angle(base.yaw), tex_angle(base.tilt)
        yaw_text = messages.gettext("rotated by $%(yaw)s$ about $z_w$", yaw=yaw) if base.yaw != 0 else ""
        if base.tilt == 0:
            return yaw_text
        if not yaw_text:
            return messages.gettext("rotated by $%(tilt)s$ about its own $x$ axis", tilt=tilt)
        return messages.gettext("%(turned)s and then by $%(tilt)s$ about its own $x$ axis", turned=yaw_text, tilt=tilt)

    @property
    def base_transform(self) -> str:
        """The pose of frame O_0 in the world frame, as a product of elementary transformations."""
        base = self.convention.base
        translations = [rf"T_{axis}({tex_length(v)})" for axis, v in zip("xyz", base.position, strict=True) if v != 0]
        rotations = [rf"R_{axis}({tex_angle(v)})" for axis, v in (("z", base.yaw), ("x", base.tilt)) if v != 0]
        return r"\, ".join([*translations, *rotations])

    @property
    def point_offset(self) -> str:
        """The coordinates of P in the frame in which P is fixed."""
        return format_coordinates(self.convention.point.offset)

    @property
    def constants(self) -> list[tuple[str, str]]:
        """The constants of the table that stay symbols, each as LaTeX and as students type it."""
        return [(tex(symbol), symbol.name) for symbol in self.chain.parameters]

    @property
    def has_numbers(self) -> bool:
        """Whether a nonzero length of the table, base or point is given as a number."""
        return any(length.is_number and length != 0 for length in list_lengths(self.chain))

    # --- for single questions ---

    @property
    def axis_names(self) -> str:
        """The joint axes, z_0 ... z_{n-1}, or z_1 ... z_n of a modified table."""
        return self.join([f"${self.convention.name_axis(i)}$" for i in range(1, self.chain.n + 1)])

    @property
    def moved_axis_names(self) -> str:
        """The names of the axes' directions and points after the preceding joints have moved the axes."""
        kinds = {joint.kind for joint in self.chain.joints}
        names = ([r"\omega_i", "q_i"] if "R" in kinds else []) + ["v_i"] * ("P" in kinds)
        return self.join([f"${name}'$" for name in names])

    @property
    def indexed_axes_phrase(self) -> str:
        """The names of the joint axes, with an index i."""
        return self.join([f"${name}$" for name in self.indexed_axis_names])

    @property
    def vector_names(self) -> str:
        """The vectors to the point, p*_0 ... p*_{n-1}, or p*_1 ... p*_n of a modified table."""
        return self.join([f"${self.convention.name_vector(i)}$" for i in range(1, self.chain.n + 1)])

    @property
    def has_parallel_axes(self) -> bool:
        """Whether all joint axes are parallel."""
        return all(joint.alpha in (0, sp.pi, -sp.pi) for joint in self.chain.joints[:-1])

    @property
    def max_rank(self) -> int:
        """The number of rows or of columns of the task Jacobian, whichever is smaller."""
        return min(len(self.chain.task), self.chain.n)

    def find_unit(self, symbol: sp.Symbol) -> str:
        """Return the unit of a joint rate or of a component of the task's velocity; "" for other symbols."""
        if symbol in self.chain.rates:
            return self.rate_units[self.chain.rates.index(symbol)]
        return ("m/s" if symbol.name.startswith("v") else "rad/s") if symbol.name in self.chain.task else ""

    def write_velocity(self, component: sp.Symbol, value: sp.Expr) -> str:
        """Return a component of velocity with its unit."""
        return rf"{tex(value)}\,\text{{{self.find_unit(component)}}}"

    def explain_meaning(self, classification: Classification) -> str:
        """Return sentences on the geometric meaning and the kind of a set of singular configurations."""
        messages, sentence = self.messages, self.write_sentence(classification.meaning)
        if not self.can_classify_singularities or not classification.kind:
            return sentence
        boundary_sentence = messages.gettext("This is a boundary singularity.")
        internal_sentence = messages.gettext("This is an internal singularity.")
        kind_sentence = boundary_sentence if classification.kind == "boundary" else internal_sentence
        return f"{sentence} {kind_sentence if classification.is_uniform else self._mixed_kinds_sentence}"

    def explain_cases(self, cases: Iterable[tuple[ValueCombination, Classification]]) -> str:
        """Return sentences on the meaning and kind for each choice of joint values; equal sentences are joined."""
        values_by_case: dict[Classification, list[ValueCombination]] = {}
        for values, classification in cases:
            values_by_case.setdefault(classification, []).append(values)
        conjunction = ", " + self.messages.gettext("or") + " "
        sentences = []
        for classification, values_of_case in values_by_case.items():
            equations = (
                [f"${tex(q, self.chain)} = {tex_result(value, q)}$" for q, value in values] for values in values_of_case
            )
            values_text, meaning = conjunction.join(map(self.join, equations)), self.explain_meaning(classification)
            sentences.append(self.messages.gettext("At %(values)s: %(case)s", values=values_text, case=meaning))
        return " ".join(sentences)

    @property
    def _mixed_kinds_sentence(self) -> str:
        gettext = self.messages.gettext
        if self.constants:
            return gettext(
                "This is a boundary singularity for some lengths and configurations, "
                "and an internal singularity for others."
            )
        return gettext(
            "Some of these configurations are boundary singularities; the others are internal singularities."
        )

    def write_sentence(self, english: str) -> str:
        """Return a description (see `describe`) as a sentence."""
        description = self.describe(english)
        return f"{description[0].upper()}{description[1:]}."

    def describe(self, english: str) -> str:
        """Return a problem's English description of configurations, translated, for the middle of a sentence.

        Points get the names that the arm's convention uses, and "the point" becomes P.
        """
        renamed_text = re.sub(r"\b([Oq])(\d+)('?)", r"$\1_{\2}\3$", self.convention.rename_origins(english))
        clause = re.sub(r"^arm (?=stretched|folded|retracted)", "the arm is ", renamed_text)
        return self.messages.translate_phrase(clause.replace("the point", "$P$"))

    def join(self, words: list[str]) -> str:
        """Join words as in a sentence: "x, y and z"."""
        *first_words, last_word = words
        if not first_words:
            return last_word
        return self.messages.gettext("%(rest)s and %(last)s", rest=", ".join(first_words), last=last_word)


def format_coordinates(values: Iterable[sp.Expr]) -> str:
    """Return the LaTeX of coordinates in metres, as in (-0.6, 0.9, 0) m; without a unit if any is symbolic."""
    coordinates = ", ".join(tex(sp.sympify(value)) for value in values)
    is_numeric = all(sp.sympify(value).is_number for value in values)
    return f"({coordinates})" + (r"\,\text{m}" if is_numeric else "")
