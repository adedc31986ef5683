"""The words in which a problem speaks of its arm: frame, point, task, units; the same in every question."""

from dataclasses import dataclass

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain
from exercises.arm.classification import Kind, kind_is_sure
from exercises.arm.derivation import derive
from exercises.writing.latex import symbol_latex, tex, tex_angle, tex_length

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_OF_ALL = {1: "", 2: "both "}
MOUNTS = {sp.pi: "hangs from the ceiling", sp.pi / 2: "is fixed to a wall", -sp.pi / 2: "is fixed to a wall"}


@dataclass(frozen=True)
class Wording:
    """What templates say about a chain; every formula is LaTeX without dollar signs."""

    chain: Chain

    @property
    def frame(self) -> str:
        """The frame in which everything is expressed."""
        return "the base frame $O_0$" if self.chain.base.is_world else "the world frame"

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
        return ["rad/s" if joint.kind == "R" else "m/s" for joint in self.chain.joints]

    @property
    def task(self) -> list[str]:
        """The components of velocity that the task counts."""
        return [symbol_latex(row) for row in self.chain.task]

    @property
    def task_units(self) -> str:
        """The unit of the task's velocity, or both where it has linear and angular rows."""
        units = ["m/s"] if any(row[0] == "v" for row in self.chain.task) else []
        units += ["rad/s"] if any(row[0] == "w" for row in self.chain.task) else []
        return " and ".join(units)

    @property
    def linear(self) -> list[str]:
        """The linear components of the task."""
        return [symbol_latex(row) for row in self.chain.task if row[0] == "v"]

    @property
    def mover(self) -> str:
        """What has the velocity that the task counts."""
        return {"v": "$P$", "w": "the last link", "vw": "$P$ and the last link"}[self._motions]

    @property
    def its_mover(self) -> str:
        """The same, at the beginning of a sentence on the arm."""
        return {"v": "Its point $P$", "w": "Its last link", "vw": "Its point $P$ and its last link"}[self._motions]

    @property
    def _motions(self) -> str:
        """Whether the task counts linear velocities, angular ones or both: "v", "w" or "vw"."""
        return "".join(kind for kind in "vw" if any(row[0] == kind for row in self.chain.task))

    @property
    def kinds_defined(self) -> str:
        """What a boundary and an internal singularity are, for what the task places."""
        turn = "angle" if len(self.task) - len(self.linear) == 1 else "orientation"
        there = {
            "v": "$P$ is on the boundary of what it can reach",
            "w": f"the {turn} of the last link is on the boundary of what it can be",
            "vw": f"the pose, which is the place of $P$ together with the {turn} of the last link, is on the "
            "boundary of what the arm can reach",
        }[self._motions]
        if self._motions == "v" and self.moves_besides:
            axes = ", ".join(row[1] for row in self.chain.task)
            there = f"the coordinates $({axes})$ of $P$ are on the boundary of what they can be"
        return (
            f"A *boundary* singularity: {there} (over all configurations, with unlimited joint travel). An *internal* "
            "singularity: any other configuration in which $J$ loses rank."
        )

    @property
    def moves_besides(self) -> bool:
        """Whether P has components of velocity that the task does not count."""
        linear = derive(self.chain).geometric[:3, :]
        return any(
            row not in self.chain.task and not linear[i, :].is_zero_matrix for i, row in enumerate(TASK_ROWS[:3])
        )

    @property
    def kinds_are_sure(self) -> bool:
        """Whether boundary and internal can be told apart for the task."""
        return kind_is_sure(self.chain)

    def kind_shown(self, kind: str) -> str:
        """Return why a singularity is of its kind."""
        place = {"v": "place", "w": "orientation", "vw": "pose"}[self._motions]
        if kind == "boundary":
            return (
                f"Small motions reach one side only of this {place}, and no other configuration reaches the far side."
            )
        mover = {"v": "$P$", "w": "The last link", "vw": "The arm"}[self._motions]
        return f"{mover} can get past this {place} in every direction, here or in another configuration."

    def numbers(self, kind: str) -> list[int]:
        """Return which joints, from 1, are "R" or "P"."""
        return [i for i, joint in enumerate(self.chain.joints, 1) if joint.kind == kind]

    @property
    def rates_with_units(self) -> str:
        """The joint rates, each with its unit, or all with the one that they have in common."""
        units = self.rate_units
        if len(units) > 2 and len(set(units)) == 1:
            return f"{join([f'${rate}$' for rate in self.rates])}, all in {units[0]}"
        return ", ".join(f"${rate}$ in {unit}" for rate, unit in zip(self.rates, units, strict=True))

    @property
    def last(self) -> int:
        """The number of the last joint and frame."""
        return self.chain.n

    @property
    def count(self) -> str:
        """The number of joints as a word."""
        return self.number(self.chain.n)

    @staticmethod
    def number(count: int) -> str:
        """Return a small number as a word."""
        return NUMBER_WORDS[count] if count < len(NUMBER_WORDS) else str(count)

    @property
    def kinds(self) -> str:
        """What kinds of joints there are, as in "both revolute" or "joint 1 revolute and joint 2 prismatic"."""
        kinds = {"R": "revolute", "P": "prismatic"}
        found = {kind: self.numbers(kind) for kind in kinds}
        if not all(found.values()):
            return f"{_OF_ALL.get(self.chain.n, 'all ')}{kinds[self.chain.joints[0].kind]}"
        return " and ".join(
            f"{'joint' if len(numbers) == 1 else 'joints'} {join([str(i) for i in numbers])} {kinds[kind]}"
            for kind, numbers in found.items()
        )

    @property
    def rows(self) -> list[list[str]]:
        """The DH table: theta_i, d_i, a_i, alpha_i of every joint, angles in degrees."""
        return [
            [tex_angle(joint.theta), tex_length(joint.d), tex_length(joint.a), tex_angle(joint.alpha)]
            for joint in self.chain.joints
        ]

    @property
    def base_place(self) -> str:
        """The coordinates of O_0 in the world frame."""
        return triple(self.chain.base.position)

    @property
    def base_turn(self) -> str:
        """How O_0 is turned in the world, or nothing."""
        base, parts = self.chain.base, []
        if base.yaw != 0:
            parts.append(f"turned by ${tex_angle(base.yaw)}$ about $z_w$")
        if base.tilt != 0:
            own = "then by " if base.yaw != 0 else "turned by "
            parts.append(f"{own}${tex_angle(base.tilt)}$ about its own $x$ axis")
        return " and ".join(parts)

    @property
    def base_transform(self) -> str:
        """The pose of O_0 in the world frame as a product of elementary transformations."""
        base = self.chain.base
        shift = [rf"T_{axis}({tex_length(v)})" for axis, v in zip("xyz", base.position, strict=True) if v != 0]
        turns = [rf"R_{axis}({tex_angle(v)})" for axis, v in (("z", base.yaw), ("x", base.tilt)) if v != 0]
        return r"\, ".join([*shift, *turns])

    @property
    def mounting(self) -> str:
        """What the tilt of the base means for an arm in space, or nothing."""
        return "" if self.chain.is_planar else MOUNTS.get(self.chain.base.tilt, "")

    @property
    def point_offset(self) -> str:
        """The coordinates of P in its frame."""
        return triple(self.chain.point.offset)

    @property
    def constants(self) -> list[tuple[str, str]]:
        """The open symbols of the table, as LaTeX and as they are typed."""
        return [(tex(symbol), symbol.name) for symbol in self.chain.parameters]

    # --- for single questions ---

    @property
    def jacobian_route(self) -> str:
        """How the Jacobian of the task is to be found."""
        if not self.linear:
            return "from the joint axes (6.12)"
        if len(self.linear) == len(self.task):
            return "by direct differentiation (6.3)"
        return "by differentiation (6.3), and for the angular rows from the joint axes (6.12)"

    @property
    def axis_names(self) -> str:
        """The joint axes, z_0 ... z_{n-1}."""
        return join([f"$z_{i}$" for i in range(self.chain.n)])

    @property
    def vector_names(self) -> str:
        """The vectors to the point, p*_0 ... p*_{n-1}."""
        return join([f"$p^*_{i}$" for i in range(self.chain.n)])

    @property
    def parallel(self) -> bool:
        """Whether all joint axes are parallel."""
        return all(joint.alpha in (0, sp.pi, -sp.pi) for joint in self.chain.joints[:-1])

    @property
    def point_column(self) -> str:
        """The coordinates of P in its frame as a column."""
        return tex(sp.Matrix(self.chain.point.offset))

    @property
    def rows_remark(self) -> str:
        """What the rows of the geometric Jacobian show."""
        rows = ", ".join(self.task)
        return f"The rows ${rows}$ are the Jacobian for the task; the other rows say how the arm moves besides."

    @property
    def smaller(self) -> int:
        """The size of the largest square part of the task Jacobian."""
        return min(len(self.chain.task), self.chain.n)

    def joint_value(self, joint: sp.Symbol, value: sp.Expr) -> str:
        """Return a joint's value: degrees where it is a simple number of them, else radians; metres for a slide."""
        if self.chain.joints[self.chain.q.index(joint)].kind == "P":
            return tex_length(value)
        return tex_angle(value) if sp.deg(value).is_Rational else tex(value)

    def velocity_value(self, component: sp.Symbol, value: sp.Expr) -> str:
        """Return a component of velocity with its unit."""
        unit = r"\text{m/s}" if component.name.startswith("v") else r"\text{rad/s}"
        return rf"{tex(value)}\,{unit}"

    def meaning(self, kind: Kind) -> str:
        """Return a sentence on what a set of singular configurations looks like, and of what kind it is."""
        if not self.kinds_are_sure:
            return self.sentence(kind.meaning)
        if kind.uniform:
            what = "a boundary" if kind.kind == "boundary" else "an internal"
            return f"{self.sentence(kind.meaning)} This is {what} singularity."
        mixed = "Some of these configurations are boundary singularities, the others internal."
        return f"{self.sentence(kind.meaning)} {mixed}"

    def case(self, kind: Kind) -> str:
        """Return the same for one value of a joint, shorter."""
        said = kind.meaning.replace("the point", "$P$")
        if not self.kinds_are_sure:
            return f"{said}."
        if kind.uniform:
            return f"{said}, {'a boundary' if kind.kind == 'boundary' else 'an internal'} singularity."
        return f"{said}; a boundary singularity in some of these configurations, an internal one in the others."

    @staticmethod
    def sentence(words: str) -> str:
        """Return words as a sentence that speaks of P by name."""
        said = words.replace("the point", "$P$")
        return f"{said[0].upper()}{said[1:]}."


def triple(values: tuple[sp.Expr, sp.Expr, sp.Expr]) -> str:
    """Return coordinates in metres, as in (-0.6, 0.9, 0) m."""
    inside = ", ".join(tex(sp.sympify(value)) for value in values)
    numeric = all(sp.sympify(value).is_number for value in values)
    return f"({inside})" + (r"\,\text{m}" if numeric else "")


def join(words: list[str], last: str = "and") -> str:
    """Return words as in a sentence.

    >>> join(["x", "y", "z"])
    'x, y and z'
    """
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"
