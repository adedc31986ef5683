"""Compute the intermediate steps of a worked solution: vectors, products, cofactors, numbers.

Everything is derived for the arm's structure (no numbers, no offsets), because there the algebra is exact and short.
Then the arm's own numbers are substituted. All vectors are in the world frame, in the notation of the chapter.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import Derivation, TooLong, derive, structure, task_velocity
from qdot.exercises.arm.kinematics import frame_after, link_frames
from qdot.exercises.arm.mpmath_kinematics import determinant, inverse, round_matrix, round_to_four_digits
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.arm.trigonometry import remove_brackets, substitute, textbook_form
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import rank, screws
from qdot.exercises.questions.inversion import Configuration, ConfigurationAndVelocity, evaluate_jacobian_precisely
from qdot.exercises.questions.rank import JacobianOnBranch, MeaningDetails
from qdot.exercises.questions.singular import ConfigurationsOfOneKind, find_components_with
from qdot.exercises.questions.wrist import derive_block_determinants, derive_wrist_block, find_block_objection
from qdot.exercises.singularities.classification import Classification, classify, is_one_sided, split_by_value
from qdot.exercises.singularities.existence_conditions import ExistenceCondition, existence_condition
from qdot.exercises.singularities.singularity import Component, Values, never_vanishes, singular_set
from qdot.exercises.writing import expansion
from qdot.exercises.writing.angles import AngleNames, arm_angles, link_angles, name_angles
from qdot.exercises.writing.expansion import Expansion, expand_determinant, expand_jacobian
from qdot.exercises.writing.hint_context import HintContext
from qdot.exercises.writing.latex import tex


@dataclass(frozen=True)
class Column:
    """The effect of joint `number` (6.12): its axis z, its vector p*, and z x p*.

    `moves_point`: whether the joint can move P.
    """

    number: int
    kind: str
    z: sp.Matrix
    p_star: sp.Matrix
    cross: sp.Matrix
    moves_point: bool


@dataclass(frozen=True)
class Recursion:
    """One step of (6.13), from p*_i to p*_{i-1}."""

    number: int
    rotated_link: sp.Matrix
    p_star: sp.Matrix


@dataclass(frozen=True)
class SingularComponent:
    """A component of the singular set and its kind.

    `solutions` are pairs (joint, values), or None if a condition ties several joints together. `cases` has the kind
    for each choice of values, if a joint has several values and their kinds differ. If the conditions hold for some
    lengths only, `need` has the inequality for these lengths.
    """

    conditions: tuple[sp.Expr, ...]
    solutions: tuple[tuple[sp.Symbol, tuple[sp.Expr, ...]], ...] | None
    kind: Classification
    cases: tuple[tuple[Values, Classification], ...] = ()
    need: ExistenceCondition | None = None

    @property
    def states_joint_value(self) -> bool:
        """Whether the condition states the joint's value directly, like d3 = 0."""
        joints = tuple(joint for joint, values in self.solutions or () if values == (0,))
        return self.solutions is not None and self.conditions == joints


class SolutionSteps:
    """The steps for one arm; templates read its properties."""

    def __init__(self, chain: Chain) -> None:
        self.chain, self.convention = chain, convention_of(chain)
        self.derivation: Derivation = derive(chain)
        generic = structure(chain)
        self._structure, self._values = generic.chain, dict(generic.values)
        self.kinds = [joint.kind for joint in chain.joints]
        """R or P for every joint."""
        self.rates, self.velocity = sp.Matrix(chain.rates), sp.Matrix(task_velocity(chain))
        """The vectors of the joint rates and of the task's velocity."""
        self.home_configuration = dict.fromkeys(chain.q, sp.S.Zero)
        """All joint variables at zero, for substitution."""

    @cached_property
    def angles(self) -> AngleNames:
        """Short names for the angles that can't be written like c_{12}; the same in all results of the arm."""
        # If the twists before and after a prismatic joint cancel, the angles add up only in simplified rotations.
        last_rotation = [self._substitute_numbers(derive(self._structure).rotations[-1])] if "P" in self.kinds else []
        d = self.derivation
        matrices = (d.position, d.geometric, d.p_star, *d.rotations, *last_rotation)
        return name_angles(arm_angles(self.chain), *matrices)

    @cached_property
    def hint_context(self) -> HintContext:
        """Facts about the arm and parts of its results for hints."""
        return HintContext(self.chain)

    def lost_direction_at(self, values: Values) -> tuple[JacobianOnBranch, sp.Matrix] | None:
        """Return J and the lost direction at given joint values, or None if they have no short formula."""
        return rank.find_lost_direction_formula(self.chain, values)

    @property
    def planar_link_angles(self) -> list[sp.Expr]:
        """The angle of each link with the world's x axis, for a planar arm without prismatic joints; else nothing."""
        return link_angles(self.chain) if self.chain.is_planar and "P" not in self.kinds else []

    @property
    def angle_sums(self) -> list[sp.Expr]:
        """The sums of joint variables in the angles of links that follow parallel axes, without their offsets."""
        sums = [angle.as_independent(*self.chain.q, as_Add=True)[1] for angle in link_angles(self.chain)]
        return [angle for angle in dict.fromkeys(sums) if len(angle.free_symbols) > 1]

    @staticmethod
    def has_angle_sums(result: sp.Matrix) -> bool:
        """Return whether a result has sines or cosines of sums of joint angles."""
        return any(len(trig.args[0].free_symbols) > 1 for trig in result.atoms(sp.sin, sp.cos))

    def _substitute_numbers(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix of the structure, simplified, with this arm's numbers."""
        return matrix.applyfunc(lambda entry: substitute(textbook_form(sp.expand(entry)), self._values))

    @cached_property
    def transforms(self) -> list[sp.Matrix]:
        """The transforms T_{0,1} ... T_{n-1,n} (4 x 4), one for each row of the table."""
        rows = self.convention.rows
        return [_transform(self.convention.rotation(row), self.convention.link_vector(row)) for row in rows]

    @cached_property
    def origins(self) -> list[sp.Matrix]:
        """The origins O_0 ... O_k (3 x 1, m); P is fixed in frame k."""
        frames = link_frames(self._structure)
        return [self._substitute_numbers(frame.origin) for frame in frames[: self.chain.point.frame + 1]]

    @property
    def last_fixed_origin(self) -> int:
        """The index of the last of the origins O_0 ... O_k that no joint moves."""
        is_moved = [self._depends_on_joints(origin) for origin in self.origins]
        return is_moved.index(True) - 1 if any(is_moved) else len(is_moved) - 1

    @property
    def last_moving_vector(self) -> tuple[int, sp.Matrix] | None:
        """The last origin whose vector to P depends on the joints, and this vector.

        None if the vector makes up most of the position.
        """
        for joint in range(self.chain.point.frame, 0, -1):
            i = self.convention.frame_on_axis(joint)
            vector, origin = self.derivation.p_star[:, joint - 1], self.origins[i]
            if self._depends_on_joints(vector):
                depends = [(self._depends_on_joints(vector[k]), self._depends_on_joints(origin[k])) for k in range(3)]
                return (i, vector) if self._depends_on_joints(origin) and depends.count((True, False)) < 2 else None
        return None

    def _depends_on_joints(self, expression: sp.Matrix | sp.Expr) -> bool:
        return bool(expression.free_symbols & set(self.chain.q))

    @property
    def home_pose(self) -> sp.Matrix:
        """M, the pose of the body frame at home (4 x 4)."""
        return _transform(sp.eye(3), self.point_at_home)

    @property
    def point_at_home(self) -> sp.Matrix:
        """The position of P at home (3 x 1, m)."""
        return axes_of(self.chain)[1]

    @property
    def exponentials(self) -> list[tuple[str, sp.Matrix]]:
        """For each joint the LaTeX name of its exponential, and the exponential itself (4 x 4)."""
        axes = axes_of(self.chain)[0]
        pairs = enumerate(zip(self.chain.q, axes, strict=True), 1)
        return [(f"e^{{[S_{{{i}}}]{tex(q)}}}", screws.compute_exponential(axis, q)) for i, (q, axis) in pairs]

    @property
    def body_rotation(self) -> sp.Matrix:
        """The rotation R_sb from body to space frame (3 x 3)."""
        return screws.derive_body_rotation(self.chain)

    @staticmethod
    def hat(vector: sp.Matrix) -> sp.Matrix:
        """Return the skew-symmetric matrix [v] of a vector (3 x 3)."""
        return screws.make_cross_product_matrix(vector)

    def screw_at_home(self, joint: int) -> screws.Screw:
        """Return a joint with its axis and its screw at home."""
        return screws.list_home_screws(self.chain)[joint - 1]

    def moved_screw(self, joint: int) -> screws.Screw:
        """Return a joint with its axis and its screw as moved by the joints before it."""
        return screws.list_moved_screws(self.chain)[joint - 1]

    def jacobian_of(self, frame: str) -> sp.Matrix:
        """Return the Jacobian in the "space" or "body" frame, its rows in the order of the arm's twists."""
        derive_jacobian = screws.derive_space_jacobian if frame == "space" else screws.derive_body_jacobian
        return self.convention.reorder_twists(derive_jacobian(self.chain))

    def axis_at_home(self, joint: int) -> sp.Matrix:
        """Return the axis of a joint with all joint variables at zero (3 x 1)."""
        return self.derivation.z[:, joint - 1].xreplace(self.home_configuration).applyfunc(sp.expand)

    def rotated_axis(self, joint: int) -> sp.Matrix | None:
        """Return the axis of a joint as rotated by the joints before it (3 x 1), or None if they don't rotate it."""
        rotated = self.derivation.z[:, joint - 1]
        return rotated if self._depends_on_joints(rotated) else None

    @cached_property
    def point_positions(self) -> list[tuple[int, sp.Matrix]]:
        """The joints i with the position of P if joints i to n have moved and those before i are at home; last i first.

        Joints that do not move P are omitted. Joint 1 is omitted, too, because then P is at its final position.
        """
        positions: list[tuple[int, sp.Matrix]] = []
        previous = self.derivation.position.xreplace(self.home_configuration)
        for joint in range(self.chain.point.frame, 0, -1):
            earlier_joints_at_zero = dict.fromkeys(self.chain.q[: joint - 1], sp.S.Zero)
            position = self.derivation.position.xreplace(earlier_joints_at_zero)
            if position != previous:
                positions.append((joint, position.applyfunc(remove_brackets)))
            previous = position
        return positions if len(positions) < 2 or positions[-1][0] != 1 else positions[:-1]

    def rotation(self, joint: int) -> sp.Matrix:
        """Return the rotation of the frame on a joint's axis; its last column is written like the axis itself."""
        shortened = self.angles.shorten(self.derivation.rotations[self.convention.frame_on_axis(joint)])
        return sp.Matrix.hstack(shortened[:, :2], self.derivation.z[:, joint - 1])

    @cached_property
    def recursion(self) -> list[Recursion]:
        """The steps of (6.13) for a point in the last frame, the last joint first."""
        generic, first_frame = derive(self._structure), self.convention.frame_on_axis(1)
        rotations, links = generic.rotations, generic.link_vectors
        steps = []
        for i in range(self.chain.point.frame, first_frame, -1):
            rotated_link = self._substitute_numbers(rotations[i - 1] * links[i - 1])
            steps.append(Recursion(i, rotated_link, self.derivation.p_star[:, i - 1 - first_frame]))
        return steps

    @property
    def last_vector(self) -> sp.Matrix:
        """The vector p*_k in the point's own frame k: R_k times the point's coordinates there (zero for an origin)."""
        rotation = derive(self._structure).rotations[self.chain.point.frame]
        return self._substitute_numbers(rotation * sp.Matrix(convention_of(self._structure).point.offset))

    @property
    def geometric(self) -> sp.Matrix:
        """The geometric Jacobian (6 x n), its rows in the order that the arm's convention asks for."""
        return self.convention.reorder_velocity_rows(self.derivation.geometric)

    @cached_property
    def columns(self) -> list[Column]:
        """The columns of the geometric Jacobian (6.12)."""
        return [self._column(self.derivation, i) for i in range(self.chain.n)]

    def _column(self, d: Derivation, i: int) -> Column:
        carries = i < self.chain.point.frame
        return Column(i + 1, self.chain.joints[i].kind, d.z[:, i], d.p_star[:, i], d.geometric[:3, i], carries)

    def link_columns(self, k: int) -> list[Column]:
        """Return the Jacobian's columns for O_k: p* goes from O_{i-1} to O_k, and only joints 1 ... k count."""
        derivation = derive(self.convention.first_joints(k))
        return [self._column(derivation, i) for i in range(k)]

    def rate_along_z(self, joint: int) -> sp.Matrix:
        """Return the joint's rate along z of its own frame (3 x 1)."""
        return sp.Matrix([0, 0, self.chain.rates[joint - 1]])

    @cached_property
    def cofactors(self) -> sp.Matrix:
        """The cofactors of the task Jacobian, (-1)^(i+j) times the minor (appendix)."""
        return self._substitute_numbers(_cofactors(self._structure))

    @property
    def never_vanishing_factors(self) -> list[sp.Expr]:
        """The factors of det J that depend on the joints but vanish in no configuration."""
        factors = (factor.as_base_exp()[0] for factor in sp.Mul.make_args(self.derivation.determinant))
        joints = set(self.chain.q)
        return [factor for factor in factors if factor.free_symbols & joints and never_vanishes(factor, self.chain)]

    @property
    def inverse_determinant(self) -> sp.Expr:
        """The factor 1/det J."""
        return 1 / self.derivation.determinant

    @cached_property
    def expansion(self) -> Expansion:
        """The steps that expand det J."""
        return self._with_numbers(expand_jacobian(self._structure), self.derivation.determinant)

    def _with_numbers(self, steps: Expansion, result: sp.Expr) -> Expansion:
        return steps.with_numbers(self.derivation.substitute_values, result)

    @property
    def sparsest_line(self) -> str:
        """The name of the row or column of J with the most zeros."""
        return expansion.find_sparsest_line(self.derivation.jacobian)[0]

    @cached_property
    def arm_expansion(self) -> Expansion:
        """The steps that expand det J11 of an arm with a spherical wrist whose axes meet in P."""
        generic = self._structure
        wrist_frame = frame_after(generic.joints[3 : generic.point.frame])
        centre = wrist_frame.origin + wrist_frame.rotation * sp.Matrix(generic.point.offset)
        point = Point(3, tuple(centre.applyfunc(textbook_form)))
        arm = Chain("arm", generic.joints[:3], TASK_ROWS[:3], generic.base, point)
        return self._with_numbers(expand_jacobian(arm), derive_block_determinants(self.chain)[0])

    @cached_property
    def wrist_expansion(self) -> Expansion:
        """The steps that expand det J22 in frame 3."""
        block = expand_determinant(derive_wrist_block(self._structure))
        return self._with_numbers(block, derive_block_determinants(self.chain)[1])

    @property
    def wrist(self) -> sp.Matrix:
        """The block J22: the axes of joints 4 to 6 in frame 3, for an arm with a spherical wrist."""
        return derive_wrist_block(self.chain)

    @property
    def joint_1_value(self) -> sp.Expr:
        """The value of joint 1 at which the entries of J are shortest."""
        variable = expansion.joint_1_without_base_rotation(self._structure).xreplace(self._values)
        value = sp.expand(variable - self.chain.offsets[0])
        return sp.pi - sp.Mod(sp.pi - value, 2 * sp.pi) if value.is_number else value

    @property
    def jacobian_at_joint_1(self) -> sp.Matrix | None:
        """J at `joint_1_value`; None if det J depends on joint 1, if J doesn't, or for more than four joints."""
        shortest = expansion.shorten_by_joint_1(self._structure) if 1 < self.chain.n <= 4 else None
        return None if shortest is None else shortest.applyfunc(self.derivation.substitute_values)

    @cached_property
    def blocks(self) -> sp.Matrix | None:
        """The determinants of J11 and J22 if the wrist's axes meet in P; None for other arms."""
        return derive_block_determinants(self.chain) if find_block_objection(self.chain) is None else None

    @cached_property
    def minors(self) -> list[tuple[str, sp.Expr]]:
        """The maximal minors of a Jacobian that is not square: the columns (or rows) chosen, and the factored minor."""
        rows, cols = self.derivation.jacobian.shape
        size, count = min(rows, cols), max(rows, cols)
        line_kind = "columns" if cols > rows else "rows"
        choices = combinations(map(str, range(1, count + 1)), size)
        labels = [f"{line_kind} {', '.join(numbers)}" for numbers in choices]
        values = (minor.substitute(self._values) for minor in self.derivation.generic_minors)
        return list(zip(labels, values, strict=True))

    def largest_minor(self, configuration: ConfigurationAndVelocity) -> tuple[str, sp.Expr]:
        """Return the minor that is farthest from zero at a configuration: its columns or rows, and its value."""
        numbers = [(label, self.numeric(configuration, minor)) for label, minor in self.minors]
        return max(numbers, key=lambda labelled: abs(labelled[1]))

    # --- singular configurations ---

    @property
    def components(self) -> list[Component]:
        """The components of the singular set, with their conditions in the form that is shown."""
        return [replace(part, conditions=self._shown_conditions(part)) for part in singular_set(self.chain) or ()]

    def _shown_conditions(self, component: Component) -> tuple[sp.Expr, ...]:
        return tuple(map(self.shown_condition, component.conditions))

    @property
    def may_be_singular(self) -> bool:
        """Whether the arm has singular configurations; True if the derivation is too long to find out."""
        try:
            return singular_set(self.chain) != ()
        except TooLong:
            return True

    @property
    def all_at_boundary(self) -> bool:
        """Whether the whole singular set is on the workspace boundary.

        Then configurations that satisfy several conditions are on the boundary, too.
        """
        kinds = (component.kind for component in self.singular_components)
        return all(kind.kind == "boundary" and kind.uniform for kind in kinds)

    @cached_property
    def singular_components(self) -> list[SingularComponent]:
        """The components of the singular set, classified."""
        return [self.classify_component(component) for component in singular_set(self.chain) or ()]

    def classify_component(self, component: Component) -> SingularComponent:
        """Return a component of the singular set with its geometric meaning and its kind."""
        conditions = self._shown_conditions(component)
        kind = classify(self.chain, component)
        need = next(filter(None, (existence_condition(condition, self.chain) for condition in conditions)), None)
        return SingularComponent(conditions, component.solutions, kind, self._cases(component, kind), need)

    def shown_condition(self, condition: sp.Expr) -> sp.Expr:
        """Return a condition without its numeric factor, and a sum with the signs that it has in the shown det J."""
        without_number = remove_numeric_factor(condition)
        if not without_number.is_Add or not self.derivation.is_square:
            return without_number
        opposite_latex = f"({tex(-without_number, self.chain, self.angles)})"
        is_opposite_shown = opposite_latex in tex(self.derivation.determinant, self.chain, self.angles)
        return -without_number if is_opposite_shown else without_number

    def _cases(self, component: Component, kind: Classification) -> tuple[tuple[Values, Classification], ...]:
        cases = [(values, classify(self.chain, part)) for values, part in split_by_value(component, kind)]
        return tuple(cases) if len({case for _, case in cases}) > 1 else ()

    def components_at(self, configuration: ConfigurationsOfOneKind) -> list[SingularComponent]:
        """Return the components of the singular set that contain a configuration; none if it is regular."""
        components = (component for _, component in find_components_with(self.chain, configuration))
        return [SingularComponent(self._shown_conditions(c), c.solutions, classify(self.chain, c)) for c in components]

    def is_one_sided(self, singular_place: ConfigurationsOfOneKind | MeaningDetails) -> bool:
        """Return whether P can leave the singular configurations to one side only along the lost direction."""
        return is_one_sided(self.chain, singular_place.condition, singular_place.values)

    # --- numbers ---

    def numeric(self, configuration: Configuration, expression: sp.Matrix | sp.Expr) -> sp.Matrix | sp.Expr:
        """Return the values of a formula at a configuration, to four significant digits."""
        substituted = expression.xreplace(configuration.values)
        is_matrix = isinstance(substituted, sp.MatrixBase)
        return substituted.applyfunc(_four_digits) if is_matrix else _four_digits(substituted)

    def numeric_inverse(self, configuration: ConfigurationAndVelocity) -> sp.Matrix:
        """Return the inverse of the task Jacobian at a configuration, to four significant digits."""
        return round_matrix(inverse(evaluate_jacobian_precisely(self.chain, configuration)))

    def numeric_determinant(self, configuration: ConfigurationAndVelocity) -> sp.Expr:
        """Return the determinant of the task Jacobian at a configuration, to four significant digits."""
        return round_to_four_digits(determinant(evaluate_jacobian_precisely(self.chain, configuration)))

    def at(self, configuration: ConfigurationsOfOneKind, expression: sp.Expr) -> sp.Expr:
        """Return an expression at a configuration with symbolic lengths unchanged and numbers to four digits."""
        substituted = sp.expand(sp.N(expression.xreplace(configuration.joints), 15))
        return substituted.xreplace({number: _four_digits(number) for number in substituted.atoms(sp.Float)})

    def three_digits(self, part: Part) -> list[str]:
        """Return the numbers of an answer to three significant digits."""
        return [three_digits(value) for value in part.answer.as_matrix()]


def _transform(rotation: sp.Matrix, origin: sp.Matrix) -> sp.Matrix:
    """Return a pose as a matrix (4 x 4)."""
    return rotation.row_join(origin).col_join(sp.Matrix([[0, 0, 0, 1]]))


@lru_cache(maxsize=512)
def _cofactors(generic: Chain) -> sp.Matrix:
    """Return the cofactors of the task Jacobian of a structure."""
    jacobian = derive(generic).jacobian
    n = jacobian.rows
    return sp.Matrix(n, n, lambda i, j: jacobian.cofactor(i, j) if n > 1 else sp.S.One)


def remove_numeric_factor(condition: sp.Expr) -> sp.Expr:
    """Return a condition without its numeric factor: sin(theta3) for -2 sin(theta3)."""
    coefficient, rest = condition.as_coeff_Mul()
    return condition if rest.is_Add or coefficient == 1 else rest


def three_digits(value: sp.Expr) -> str:
    """Return a number to three significant digits, without an exponent if it is readable without one.

    >>> three_digits(sp.Float("0.0752277")), three_digits(sp.Float("-12.345"))
    ('0.0752', '-12.3')
    """
    text = "0" if abs(value) < sp.Float("1e-12") else f"{float(value):#.3g}"
    return f"{float(text):.0f}" if "e+" in text else text.rstrip(".")


def _four_digits(value: sp.Expr) -> sp.Expr:
    number = sp.N(value, 15)
    if abs(number) < sp.Float("1e-12"):
        return sp.S.Zero
    return sp.Float(f"{float(number):.4g}", 10)
