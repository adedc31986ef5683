"""The steps that a worked solution shows between the formula and its result: vectors, products, cofactors, numbers.

Everything is worked out on the structure of the arm (no numbers, no offsets), where the algebra is exact and short,
and then filled with the arm's own numbers. World frame; notation of the chapter.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain, Point
from qdot.exercises.arm.classification import Kind, classify, is_one_sided, split_by_value
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import Derivation, TooLong, derive, structure, task_velocity
from qdot.exercises.arm.existence_conditions import Need, need_of
from qdot.exercises.arm.kinematics import frame_behind, link_frames
from qdot.exercises.arm.mpmath_kinematics import determinant, four_digits, inverse, round_matrix
from qdot.exercises.arm.singularity import Component, Values, never_vanishes, singular_set
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.arm.trigonometry import substitute, textbook, without_brackets
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.inversion import Configuration, Situation, jacobian_at
from qdot.exercises.questions.rank import LostAt, MeaningAsked, Where, lost_direction_where
from qdot.exercises.questions.screws import (
    Screw,
    body_jacobian,
    body_rotation,
    carried_screws,
    exponential,
    hat,
    home_screws,
    space_jacobian,
)
from qdot.exercises.questions.singular import Place, find_components_at
from qdot.exercises.questions.wrist import block_determinants, objection_unless_partitioned, wrist_block
from qdot.exercises.writing.angles import AngleNames, angle_names, arm_angles, link_angles
from qdot.exercises.writing.expansion import (
    Expansion,
    expand_determinant,
    expand_jacobian,
    jacobian_at_joint_1,
    sparsest_line,
    straight_joint_1,
)
from qdot.exercises.writing.hint_context import HintContext
from qdot.exercises.writing.latex import tex


@dataclass(frozen=True)
class Column:
    """The effect of joint `number` (6.12): its axis z, its vector p*, and z x p*."""

    number: int
    kind: str
    z: sp.Matrix
    p_star: sp.Matrix
    cross: sp.Matrix
    carries: bool


@dataclass(frozen=True)
class Recursion:
    """One step of (6.13), from p*_i to p*_{i-1}."""

    number: int
    turned: sp.Matrix
    p_star: sp.Matrix


@dataclass(frozen=True)
class SingularComponent:
    """A component of the singular set with what it is; `solutions` are (joint, values), None where joints are tied.

    `cases` has the kind for each choice of values, if joints have several and their kinds differ. If the conditions
    hold for some lengths only, `need` has the inequality for these lengths.
    """

    conditions: tuple[sp.Expr, ...]
    solutions: tuple[tuple[sp.Symbol, tuple[sp.Expr, ...]], ...] | None
    kind: Kind
    cases: tuple[tuple[Values, Kind], ...] = ()
    need: Need | None = None

    @property
    def says_it(self) -> bool:
        """Whether the condition is the joint value itself, as d3 = 0."""
        return self.solutions is not None and self.conditions == tuple(
            joint for joint, values in self.solutions if values == (0,)
        )


class SolutionSteps:
    """The steps for one arm; templates read its properties."""

    def __init__(self, chain: Chain) -> None:
        self.chain, self.convention = chain, convention_of(chain)
        self.d: Derivation = derive(chain)
        generic = structure(chain)
        self._structure, self._values = generic.chain, dict(generic.values)

    @cached_property
    def angles(self) -> AngleNames:
        """Short names for the angles that c_{12} can't say: the same in all that is shown of the arm."""
        # Beside a slide whose twists undo each other, angles add up in the rotations only when these are tidied.
        last = [self._fill(derive(self._structure).rotations[-1])] if "P" in self.kinds else []
        shown = (self.d.position, self.d.geometric, self.d.p_star, *self.d.rotations, *last)
        return angle_names(arm_angles(self.chain), *shown)

    @cached_property
    def hint_context(self) -> HintContext:
        """Facts about the arm and parts of its results for hints."""
        return HintContext(self.chain)

    def lost_where(self, values: Values) -> tuple[LostAt, sp.Matrix] | None:
        """Return J and the direction that is lost where joints have values; None where these are not short."""
        return lost_direction_where(self.chain, Where(values))

    @property
    def links(self) -> list[sp.Expr]:
        """The angle of every link with the x axis of the world, for an arm in its plane; nothing for others."""
        return link_angles(self.chain) if self.chain.is_planar and "P" not in self.kinds else []

    @property
    def angle_sums(self) -> list[sp.Expr]:
        """The sums of joint variables that the angles of links behind parallel axes have, without their offsets."""
        sums = [angle.as_independent(*self.chain.q, as_Add=True)[1] for angle in link_angles(self.chain)]
        return [angle for angle in dict.fromkeys(sums) if len(angle.free_symbols) > 1]

    @staticmethod
    def adds_angles(result: sp.Matrix) -> bool:
        """Return whether a result has sines or cosines of sums of joint angles."""
        return any(len(trig.args[0].free_symbols) > 1 for trig in result.atoms(sp.sin, sp.cos))

    @property
    def kinds(self) -> list[str]:
        """R or P for every joint."""
        return [joint.kind for joint in self.chain.joints]

    def _fill(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix of the structure, tidied, in this arm's numbers."""
        return matrix.applyfunc(lambda entry: substitute(textbook(sp.expand(entry)), self._values))

    @cached_property
    def transforms(self) -> list[sp.Matrix]:
        """T_{0,1} ... T_{n-1,n}, 4 x 4, row by row of the table."""
        matrices = []
        for row in self.convention.rows:
            pose = self.convention.rotation(row).row_join(self.convention.link_vector(row))
            matrices.append(pose.col_join(sp.Matrix([[0, 0, 0, 1]])))
        return matrices

    @cached_property
    def origins(self) -> list[sp.Matrix]:
        """O_0 ... O_k, k being the frame in which the point is fixed (3 x 1, m)."""
        frames = link_frames(self._structure)
        return [self._fill(frame.origin) for frame in frames[: self.chain.point.frame + 1]]

    @property
    def last_fixed_origin(self) -> int:
        """The last of the origins O_0 ... O_k that no joint moves."""
        moved = [self._moves(origin) for origin in self.origins]
        return moved.index(True) - 1 if any(moved) else len(moved) - 1

    @property
    def last_part_of_position(self) -> tuple[int, sp.Matrix] | None:
        """The last origin from which the way to P changes, and this way; None where it is most of the position."""
        for joint in range(self.chain.point.frame, 0, -1):
            i = self.convention.frame_on_axis(joint)
            way, origin = self.d.p_star[:, joint - 1], self.origins[i]
            if self._moves(way):
                whole = [row for row in range(3) if self._moves(way[row]) and not self._moves(origin[row])]
                return (i, way) if self._moves(origin) and len(whole) < 2 else None
        return None

    def _moves(self, place: sp.Matrix | sp.Expr) -> bool:
        return bool(place.free_symbols & set(self.chain.q))

    @property
    def is_standard(self) -> bool:
        """Whether the arm is described by a standard table, in whose frames everything is derived."""
        return self.convention.has_frames and not self.convention.has_frames_of_joints

    @property
    def _home(self) -> dict[sp.Symbol, sp.Expr]:
        return dict.fromkeys(self.chain.q, sp.S.Zero)

    @property
    def home_pose(self) -> sp.Matrix:
        """M, the pose of the body frame at home (4 x 4)."""
        return sp.eye(3).row_join(self.point_at_home).col_join(sp.Matrix([[0, 0, 0, 1]]))

    @property
    def point_at_home(self) -> sp.Matrix:
        """Where P is at home (3 x 1, m)."""
        return axes_of(self.chain)[1]

    @property
    def exponentials(self) -> list[tuple[str, sp.Matrix]]:
        """Of each joint what its exponential is called, and the 4 x 4 matrix."""
        axes = axes_of(self.chain)[0]
        pairs = enumerate(zip(self.chain.q, axes, strict=True), 1)
        return [(f"e^{{[S_{{{i}}}]{tex(q)}}}", exponential(axis, q)) for i, (q, axis) in pairs]

    @property
    def body_rotation(self) -> sp.Matrix:
        """R_sb, 3 x 3."""
        return body_rotation(self.chain)

    @staticmethod
    def hat(vector: sp.Matrix) -> sp.Matrix:
        """Return [v], 3 x 3."""
        return hat(vector)

    def screw_at_home(self, joint: int) -> Screw:
        """Return a joint with its axis and its screw at home."""
        return home_screws(self.chain)[joint - 1]

    def screw_carried(self, joint: int) -> Screw:
        """Return a joint with its axis and its screw as the joints before it have moved them."""
        return carried_screws(self.chain)[joint - 1]

    def jacobian_of(self, frame: str) -> sp.Matrix:
        """Return the Jacobian of screws in the "space" or "body" frame, its rows in the order of the arm's twists."""
        return self.convention.twist((space_jacobian if frame == "space" else body_jacobian)(self.chain))

    def axis_at_home(self, joint: int) -> sp.Matrix:
        """Return the axis of a joint where all joint variables are zero (3 x 1)."""
        return self.d.z[:, joint - 1].xreplace(self._home).applyfunc(sp.expand)

    def turned_axis(self, joint: int) -> sp.Matrix | None:
        """Return the axis of a joint as the joints before it have turned it (3 x 1), None where they do not."""
        turned = self.d.z[:, joint - 1]
        return turned if self._moves(turned) else None

    @cached_property
    def moved_points(self) -> list[tuple[int, sp.Matrix]]:
        """Where P is when joint i and those behind it have moved, and those before it are at home; the last i first.

        Joints that do not move P are left out, and so is joint 1, after which P is at its position.
        """
        places: list[tuple[int, sp.Matrix]] = []
        before = self.d.position.xreplace(self._home)
        for joint in range(self.chain.point.frame, 0, -1):
            home = dict.fromkeys(self.chain.q[: joint - 1], sp.S.Zero)
            place = self.d.position.xreplace(home)
            if place != before:
                places.append((joint, place.applyfunc(without_brackets)))
            before = place
        return places if len(places) < 2 or places[-1][0] != 1 else places[:-1]

    def rotation(self, joint: int) -> sp.Matrix:
        """Return the rotation of the frame on the axis of a joint, its last column as this axis is written."""
        shown = self.angles.shorten(self.d.rotations[self.convention.frame_on_axis(joint)])
        return sp.Matrix.hstack(shown[:, :2], self.d.z[:, joint - 1])

    @cached_property
    def recursion(self) -> list[Recursion]:
        """The steps of (6.13), the last joint first; for a point in the last frame."""
        generic, first = derive(self._structure), self.convention.frame_on_axis(1)
        rotations, links = generic.rotations, generic.link_vectors
        steps = []
        for i in range(self.chain.point.frame, first, -1):
            turned, p_star = self._fill(rotations[i - 1] * links[i - 1]), self.d.p_star[:, i - 1 - first]
            steps.append(Recursion(i, turned, p_star))
        return steps

    @property
    def last_vector(self) -> sp.Matrix:
        """p*_k of the point's own frame: R_k times its coordinates there (zero for an origin)."""
        k = self.chain.point.frame
        return self._fill(derive(self._structure).rotations[k] * sp.Matrix(convention_of(self._structure).point.offset))

    @property
    def geometric(self) -> sp.Matrix:
        """The geometric Jacobian, 6 x n, its rows in the order in which the arm is asked about."""
        return self.convention.velocity_rows(self.d.geometric)

    @cached_property
    def columns(self) -> list[Column]:
        """The columns of the geometric Jacobian (6.12)."""
        return [self._column(self.d.z, self.d.p_star, self.d.geometric, i) for i in range(self.chain.n)]

    def _column(self, z: sp.Matrix, p_star: sp.Matrix, jacobian: sp.Matrix, i: int) -> Column:
        carries = i < self.chain.point.frame
        return Column(i + 1, self.chain.joints[i].kind, z[:, i], p_star[:, i], jacobian[:3, i], carries)

    def link_columns(self, k: int) -> list[Column]:
        """Return the columns for frame k: p* goes from O_{i-1} to O_k, and only joints 1 ... k count."""
        inner = derive(self.convention.first_joints(k))
        return [self._column(inner.z, inner.p_star, inner.geometric, i) for i in range(k)]

    @property
    def rates(self) -> sp.Matrix:
        """The vector of joint rates."""
        return sp.Matrix(self.chain.rates)

    def rate_along_z(self, joint: int) -> sp.Matrix:
        """Return what a joint adds in its own frame (3 x 1)."""
        return sp.Matrix([0, 0, self.chain.rates[joint - 1]])

    @property
    def velocity(self) -> sp.Matrix:
        """The vector of the task's velocity."""
        return sp.Matrix(task_velocity(self.chain))

    @cached_property
    def cofactors(self) -> sp.Matrix:
        """The cofactors of the task Jacobian, (-1)^(i+j) times the minor (appendix)."""
        return self._fill(_cofactors(self._structure))

    @property
    def never_zero(self) -> list[sp.Expr]:
        """The factors of det J that joints change, and that are zero in no configuration."""
        factors = (factor.as_base_exp()[0] for factor in sp.Mul.make_args(self.d.determinant))
        joints = set(self.chain.q)
        return [factor for factor in factors if factor.free_symbols & joints and never_vanishes(factor, self.chain)]

    @property
    def inverse_determinant(self) -> sp.Expr:
        """The factor 1/det J."""
        return 1 / self.d.determinant

    @cached_property
    def expansion(self) -> Expansion:
        """How det J is worked out."""
        return expand_jacobian(self._structure).fill(self.d.fill, self.d.determinant)

    @property
    def sparsest(self) -> str:
        """The row or column of J with the most zeros, in words."""
        return sparsest_line(self.d.jacobian)[0]

    @cached_property
    def arm_expansion(self) -> Expansion:
        """How det J11 is worked out, of an arm with a wrist whose axes meet in P."""
        generic = self._structure
        behind = frame_behind(generic.joints[3 : generic.point.frame])
        centre = behind.origin + behind.rotation * sp.Matrix(generic.point.offset)
        arm = Chain("arm", generic.joints[:3], TASK_ROWS[:3], generic.base, Point(3, tuple(centre.applyfunc(textbook))))
        return expand_jacobian(arm).fill(self.d.fill, block_determinants(self.chain)[0])

    @cached_property
    def wrist_expansion(self) -> Expansion:
        """How det J22 is worked out, in frame 3."""
        matrix = wrist_block(self._structure)
        return expand_determinant(matrix).fill(self.d.fill, block_determinants(self.chain)[1])

    @property
    def wrist(self) -> sp.Matrix:
        """J22, the axes of joints 4 to 6 in frame 3, of such an arm."""
        return wrist_block(self.chain)

    @property
    def joint_1_value(self) -> sp.Expr:
        """The value of joint 1 at which J is short."""
        value = sp.expand(straight_joint_1(self._structure).xreplace(self._values) - self.chain.offsets[0])
        return sp.pi - sp.Mod(sp.pi - value, 2 * sp.pi) if value.is_number else value

    @property
    def jacobian_at_joint_1(self) -> sp.Matrix | None:
        """J at that value of joint 1, if it has the same determinant in every configuration."""
        short = jacobian_at_joint_1(self._structure) if 1 < self.chain.n <= 4 else None
        return None if short is None else short.applyfunc(self.d.fill)

    @cached_property
    def blocks(self) -> sp.Matrix | None:
        """det J11 and det J22 of an arm with a wrist whose axes meet in P; None for all others."""
        return block_determinants(self.chain) if objection_unless_partitioned(self.chain) is None else None

    @cached_property
    def minors(self) -> list[tuple[str, sp.Expr]]:
        """The maximal minors of a Jacobian that is not square: which columns (or rows), and the factored minor."""
        rows, cols = self.d.jacobian.shape
        size, count = min(rows, cols), max(rows, cols)
        what = "columns" if cols > rows else "rows"
        labels = [f"{what} {', '.join(str(i + 1) for i in chosen)}" for chosen in combinations(range(count), size)]
        values = (minor.substitute(self._values) for minor in self.d.generic_minors)
        return list(zip(labels, values, strict=True))

    def largest_minor(self, situation: Situation) -> tuple[str, sp.Expr]:
        """Return the minor that is farthest from zero in a situation: its columns or rows, and its number."""
        numbers = [(label, self.numeric(situation, minor)) for label, minor in self.minors]
        return max(numbers, key=lambda labelled: abs(labelled[1]))

    # --- singular configurations ---

    @property
    def components(self) -> list[Component]:
        """The components of the singular set, their conditions as they are shown."""
        return [
            replace(component, conditions=tuple(map(self.as_shown, component.conditions)))
            for component in singular_set(self.chain) or ()
        ]

    @property
    def may_be_singular(self) -> bool:
        """Whether the arm is singular anywhere, as far as that is known."""
        try:
            return singular_set(self.chain) != ()
        except TooLong:
            return True

    @property
    def all_at_boundary(self) -> bool:
        """Whether all of the singular set is at the boundary, so that nothing else is where conditions meet."""
        return all(
            component.kind.kind == "boundary" and component.kind.uniform for component in self.singular_components
        )

    @cached_property
    def singular_components(self) -> list[SingularComponent]:
        """The same, classified."""
        return [self.classify_component(component) for component in singular_set(self.chain) or ()]

    def classify_component(self, component: Component) -> SingularComponent:
        """Return a component of the singular set with what its configurations look like, and are."""
        conditions = tuple(map(self.as_shown, component.conditions))
        kind = classify(self.chain, component)
        need = next(filter(None, (need_of(condition, self.chain) for condition in conditions)), None)
        return SingularComponent(conditions, component.solutions, kind, self._cases(component, kind), need)

    def as_shown(self, condition: sp.Expr) -> sp.Expr:
        """Return a condition without numbers before it, and a sum with the signs that it has in det J, as shown."""
        plain = without_factor(condition)
        if not plain.is_Add or not self.d.is_square:
            return plain
        opposite = f"({tex(-plain, self.chain, self.angles)})"
        return -plain if opposite in tex(self.d.determinant, self.chain, self.angles) else plain

    def _cases(self, component: Component, kind: Kind) -> tuple[tuple[Values, Kind], ...]:
        every = [(values, classify(self.chain, here)) for values, here in split_by_value(component, kind)]
        return tuple(every) if len({case for _, case in every}) > 1 else ()

    def components_at(self, place: Place) -> list[SingularComponent]:
        """Return the components that a place lies on, none where the arm is not singular."""
        return [
            SingularComponent(tuple(map(self.as_shown, here.conditions)), here.solutions, classify(self.chain, here))
            for _, here in find_components_at(self.chain, place)
        ]

    def is_one_sided(self, asked: Place | MeaningAsked) -> bool:
        """Tell whether P gets past singular places to one side only, along the direction that is lost."""
        return is_one_sided(self.chain, asked.condition, asked.values)

    # --- numbers ---

    def numeric(self, situation: Configuration, expression: sp.Matrix | sp.Expr) -> sp.Matrix | sp.Expr:
        """Return the numbers that a formula takes in a situation, to four significant digits."""
        filled = expression.xreplace(situation.values)
        return filled.applyfunc(_four_digits) if isinstance(filled, sp.MatrixBase) else _four_digits(filled)

    def numeric_inverse(self, situation: Situation) -> sp.Matrix:
        """Return the inverse of the task Jacobian in a situation, to four significant digits."""
        return round_matrix(inverse(jacobian_at(self.chain, situation)))

    def numeric_determinant(self, situation: Situation) -> sp.Expr:
        """Return the determinant of the task Jacobian in a situation, to four significant digits."""
        return four_digits(determinant(jacobian_at(self.chain, situation)))

    def at(self, place: Place, expression: sp.Expr) -> sp.Expr:
        """Return an expression at a configuration, the open lengths kept, numbers to four digits."""
        filled = sp.expand(sp.N(expression.xreplace(place.joints), 15))
        return filled.xreplace({number: _four_digits(number) for number in filled.atoms(sp.Float)})

    def three_digits(self, part: Part) -> list[str]:
        """Return the numbers of an answer to three significant digits."""
        return [three_digits(value) for value in part.answer.as_matrix()]


@lru_cache(maxsize=512)
def _cofactors(generic: Chain) -> sp.Matrix:
    """Return the cofactors of the task Jacobian of a structure."""
    jacobian = derive(generic).jacobian
    n = jacobian.rows
    return sp.Matrix(n, n, lambda i, j: jacobian.cofactor(i, j) if n > 1 else sp.S.One)


def without_factor(condition: sp.Expr) -> sp.Expr:
    """Return what has to vanish without numbers and signs before it, as in sin(theta3) for -2 sin(theta3)."""
    coefficient, rest = condition.as_coeff_Mul()
    if rest.is_Add or coefficient == 1:
        return condition
    return rest


def three_digits(value: sp.Expr) -> str:
    """Return a number to three significant digits, without an exponent where it can be read without.

    >>> three_digits(sp.Float("0.0752277")), three_digits(sp.Float("-12.345"))
    ('0.0752', '-12.3')
    """
    return "0" if abs(value) < sp.Float("1e-12") else _plain(f"{float(value):#.3g}")


def _plain(text: str) -> str:
    return f"{float(text):.0f}" if "e+" in text else text.rstrip(".")


def _four_digits(value: sp.Expr) -> sp.Expr:
    number = sp.N(value, 15)
    if abs(number) < sp.Float("1e-12"):
        return sp.S.Zero
    return sp.Float(f"{float(number):.4g}", 10)
