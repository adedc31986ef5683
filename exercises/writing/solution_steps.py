"""Compute the intermediate steps of a worked solution: vectors, products, cofactors, numbers.

All formulas are derived for the arm's structure: the same arm with symbols for its lengths and without joint offsets.
For the structure, the algebra is exact and short. Then the arm's numbers are substituted. All vectors are in the world
frame, in the notation of the chapter.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import compute_frame_after, compute_link_frames
from qdot.exercises.arm.mpmath_kinematics import (
    compute_determinant,
    compute_inverse,
    round_matrix,
    round_to_four_digits,
)
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.arm.trigonometry import remove_brackets, to_textbook_form, wrap_angle
from qdot.exercises.derivation.derivation import Derivation, TooLong, derive, make_symbolic_arm, make_task_velocity
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import rank, screws
from qdot.exercises.questions.inversion import Configuration, ConfigurationAndVelocity, evaluate_jacobian_precisely
from qdot.exercises.questions.rank import JacobianOnBranch, MeaningDetails
from qdot.exercises.questions.singular import ConfigurationsOfOneKind, find_components_containing
from qdot.exercises.questions.wrist import (
    derive_block_determinants,
    derive_wrist_block,
    find_block_objection,
)
from qdot.exercises.singularities.classification import Classification, classify, is_one_sided, split_by_value
from qdot.exercises.singularities.existence_conditions import ExistenceCondition, find_existence_condition
from qdot.exercises.singularities.singular_set import Component, ValueCombination, find_singular_set, never_vanishes
from qdot.exercises.writing import expansion
from qdot.exercises.writing.angles import AngleNames, iterate_arm_angles, list_link_angles, name_angles
from qdot.exercises.writing.expansion import Expansion, expand_determinant, expand_jacobian
from qdot.exercises.writing.hint_context import HintContext
from qdot.exercises.writing.latex import remove_numeric_factor, tex


@dataclass(frozen=True)
class Column:
    """A column of the geometric Jacobian (6.12): the axis z of joint `number`, its vector p* to P, and z x p*.

    `moves_point` says whether the joint can move P.
    """

    number: int
    kind: str
    z: sp.Matrix
    p_star: sp.Matrix
    cross: sp.Matrix
    moves_point: bool


@dataclass(frozen=True)
class RecursionStep:
    """A step of (6.13), p*_{i-1} = R_{i-1} r_i + p*_i: i is `number`, R_{i-1} r_i is `rotated_link`."""

    number: int
    rotated_link: sp.Matrix
    p_star: sp.Matrix


@dataclass(frozen=True)
class SingularComponent:
    """A component of the singular set: configurations that satisfy all `conditions` (each expression is zero).

    `solutions` are pairs (joint variable, values), or None if a condition depends on several joints. `classification`
    applies to all configurations of the component. If it differs between the values of a joint, `cases` has the
    classification for each choice of values. If the conditions can hold only for some lengths, `existence_condition` is
    the inequality that the lengths must satisfy.
    """

    conditions: tuple[sp.Expr, ...]
    solutions: tuple[tuple[sp.Symbol, tuple[sp.Expr, ...]], ...] | None
    classification: Classification
    cases: tuple[tuple[ValueCombination, Classification], ...] = ()
    existence_condition: ExistenceCondition | None = None

    @property
    def states_joint_value(self) -> bool:
        """Whether each condition already states the value of a joint, like d3 = 0."""
        joints = tuple(joint for joint, values in self.solutions or () if values == (0,))
        return self.solutions is not None and self.conditions == joints


class SolutionSteps:
    """The steps of the worked solutions for one arm. Templates read the properties."""

    screws = screws
    """The module with the formulas of screws, for templates."""

    def __init__(self, chain: Chain) -> None:
        self.chain, self.convention = chain, convention_of(chain)
        self.derivation: Derivation = derive(chain)
        symbolic_arm = make_symbolic_arm(chain)
        self._structure, self._values = symbolic_arm.chain, dict(symbolic_arm.values)
        self.kinds = [joint.kind for joint in chain.joints]
        """For each joint, R (revolute) or P (prismatic)."""
        self.rates, self.velocity = sp.Matrix(chain.rates), sp.Matrix(make_task_velocity(chain))
        """The vectors of the joint rates and of the task's velocity."""
        self.home_configuration = dict.fromkeys(chain.q, sp.S.Zero)
        """All joint variables at zero, for substitution."""

    @cached_property
    def angles(self) -> AngleNames:
        """Short names for the angles that can't be written like c_{12}; the same names in all results of the arm."""
        # If the twists before and after a prismatic joint cancel, angles add up only in a simplified rotation matrix.
        last_rotation = [self._substitute_numbers(derive(self._structure).rotations[-1])] if "P" in self.kinds else []
        d = self.derivation
        matrices = (d.position, d.geometric_jacobian, d.p_star, *d.rotations, *last_rotation)
        return name_angles(iterate_arm_angles(self.chain), *matrices)

    @cached_property
    def hint_context(self) -> HintContext:
        """What hints reveal about the arm and its results."""
        return HintContext(self.chain)

    def find_lost_direction(self, values: ValueCombination) -> tuple[JacobianOnBranch, sp.Matrix] | None:
        """Return J and the lost direction at given joint values, or None if there is no short formula for both."""
        return rank.find_lost_direction_formula(self.chain, values)

    @property
    def planar_link_angles(self) -> list[sp.Expr]:
        """The angle of each link with the world's x axis; empty unless the arm is planar without prismatic joints."""
        return list_link_angles(self.chain) if self.chain.is_planar and "P" not in self.kinds else []

    @property
    def angle_sums(self) -> list[sp.Expr]:
        """The sums of joint variables, without offsets, in the angles of links whose joint axes are parallel."""
        sums = [angle.as_independent(*self.chain.q, as_Add=True)[1] for angle in list_link_angles(self.chain)]
        return [angle for angle in dict.fromkeys(sums) if len(angle.free_symbols) > 1]

    @staticmethod
    def has_angle_sums(result: sp.Matrix) -> bool:
        """Return whether a result has sines or cosines of sums of joint angles."""
        return any(len(trig.args[0].free_symbols) > 1 for trig in result.atoms(sp.sin, sp.cos))

    def _substitute_numbers(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix of the structure in the textbook's form, with this arm's numbers."""
        return matrix.applyfunc(lambda entry: to_textbook_form(sp.expand(entry)).xreplace(self._values))

    @cached_property
    def transforms(self) -> list[sp.Matrix]:
        """The transforms T_{0,1} ... T_{n-1,n} (4 x 4), one for each row of the table."""
        rows = self.convention.rows
        return [
            screws.make_transform(self.convention.make_rotation(row), self.convention.make_link_vector(row))
            for row in rows
        ]

    @cached_property
    def origins(self) -> list[sp.Matrix]:
        """The origins O_0 ... O_k (3 x 1, m), where P is fixed in frame k."""
        frames = compute_link_frames(self._structure)
        return [self._substitute_numbers(frame.origin) for frame in frames[: self.chain.point.frame + 1]]

    @property
    def last_fixed_origin(self) -> int:
        """The index of the last of the origins O_0 ... O_k that no joint moves."""
        is_moved = [self._depends_on_joints(origin) for origin in self.origins]
        return is_moved.index(True) - 1 if any(is_moved) else len(is_moved) - 1

    @property
    def last_moving_vector(self) -> tuple[int, sp.Matrix] | None:
        """The index of the last origin whose vector to P depends on the joint variables, and this vector.

        The value is None if a hint with this vector would reveal most of P's position.
        """
        for joint in range(self.chain.point.frame, 0, -1):
            i = self.convention.find_frame_on_axis(joint)
            vector, origin = self.derivation.p_star[:, joint - 1], self.origins[i]
            if self._depends_on_joints(vector):
                depends = self._depends_on_joints
                # If, in a coordinate, only the vector depends on the joints, it reveals how P's coordinate does.
                revealed_count = sum(depends(vector[k]) and not depends(origin[k]) for k in range(3))
                return (i, vector) if depends(origin) and revealed_count < 2 else None
        return None

    def _depends_on_joints(self, expression: sp.Matrix | sp.Expr) -> bool:
        return bool(expression.free_symbols & set(self.chain.q))

    @property
    def home_pose(self) -> sp.Matrix:
        """The pose M of the body frame at home (4 x 4)."""
        return screws.make_transform(sp.eye(3), self.point_at_home)

    @property
    def point_at_home(self) -> sp.Matrix:
        """The position of P at home (3 x 1, m)."""
        return compute_home_geometry(self.chain).point

    @property
    def exponentials(self) -> list[tuple[str, sp.Matrix]]:
        """For each joint the LaTeX name of its exponential, and the exponential itself (4 x 4)."""
        axes = compute_home_geometry(self.chain).axes
        pairs = enumerate(zip(self.chain.q, axes, strict=True), 1)
        return [(f"e^{{[S_{{{i}}}]{tex(q)}}}", screws.compute_exponential(axis, q)) for i, (q, axis) in pairs]

    def derive_jacobian(self, frame: str) -> sp.Matrix:
        """Return the Jacobian (6 x n) in the "space" or "body" frame; its rows have the order of the arm's twists."""
        derive_jacobian = screws.derive_space_jacobian if frame == "space" else screws.derive_body_jacobian
        return self.convention.reorder_twists(derive_jacobian(self.chain))

    def derive_axis_at_home(self, joint: int) -> sp.Matrix:
        """Return the axis of a joint with all joint variables at zero (3 x 1)."""
        return self.derivation.z[:, joint - 1].xreplace(self.home_configuration).applyfunc(sp.expand)

    def find_rotated_axis(self, joint: int) -> sp.Matrix | None:
        """Return the axis of a joint after the preceding joints have rotated it (3 x 1); None if none rotates it."""
        axis = self.derivation.z[:, joint - 1]
        return axis if self._depends_on_joints(axis) else None

    @cached_property
    def point_positions(self) -> list[tuple[int, sp.Matrix]]:
        """Joints i, the last first, each with the position of P if only the joints i to n have moved from home.

        Joints that do not move P are omitted. Joint 1 is omitted, too, unless it is the only one, because P is then at
        its final position.
        """
        positions: list[tuple[int, sp.Matrix]] = []
        previous_position = self.derivation.position.xreplace(self.home_configuration)
        for joint in range(self.chain.point.frame, 0, -1):
            earlier_joints_at_zero = dict.fromkeys(self.chain.q[: joint - 1], sp.S.Zero)
            position = self.derivation.position.xreplace(earlier_joints_at_zero)
            if position != previous_position:
                positions.append((joint, position.applyfunc(remove_brackets)))
            previous_position = position
        return positions if len(positions) < 2 or positions[-1][0] != 1 else positions[:-1]

    def derive_rotation(self, joint: int) -> sp.Matrix:
        """Return the rotation matrix (3 x 3) of the frame on a joint's axis; the last column is the axis."""
        rotation = self.angles.shorten(self.derivation.rotations[self.convention.find_frame_on_axis(joint)])
        return sp.Matrix.hstack(rotation[:, :2], self.derivation.z[:, joint - 1])

    @cached_property
    def recursion(self) -> list[RecursionStep]:
        """The steps of (6.13) for a point in the last frame, beginning with the last joint."""
        derivation, first_frame = derive(self._structure), self.convention.find_frame_on_axis(1)
        rotations, links = derivation.rotations, derivation.link_vectors
        steps = []
        for i in range(self.chain.point.frame, first_frame, -1):
            rotated_link = self._substitute_numbers(rotations[i - 1] * links[i - 1])
            steps.append(RecursionStep(i, rotated_link, self.derivation.p_star[:, i - 1 - first_frame]))
        return steps

    @property
    def last_vector(self) -> sp.Matrix:
        """The vector p*_k from O_k to P, where P is fixed in frame k: R_k times the coordinates of P in frame k."""
        rotation = derive(self._structure).rotations[self.chain.point.frame]
        return self._substitute_numbers(rotation * sp.Matrix(convention_of(self._structure).point.offset))

    @cached_property
    def columns(self) -> list[Column]:
        """The columns of the geometric Jacobian (6.12)."""
        return [self._make_column(self.derivation, i) for i in range(self.chain.n)]

    def _make_column(self, derivation: Derivation, i: int) -> Column:
        kind, moves_point = self.chain.joints[i].kind, i < self.chain.point.frame
        z, p_star, cross = derivation.z[:, i], derivation.p_star[:, i], derivation.geometric_jacobian[:3, i]
        return Column(i + 1, kind, z, p_star, cross, moves_point)

    def list_link_columns(self, k: int) -> list[Column]:
        """Return the columns of the geometric Jacobian for the point O_k, one for each of the joints 1 ... k."""
        derivation = derive(self.convention.keep_first_joints(k))
        return [self._make_column(derivation, i) for i in range(k)]

    def make_rate_along_z(self, joint: int) -> sp.Matrix:
        """Return the vector (3 x 1) along the z axis of a frame on the joint's axis; its length is the joint rate."""
        return sp.Matrix([0, 0, self.chain.rates[joint - 1]])

    @cached_property
    def cofactors(self) -> sp.Matrix:
        """The cofactors of the task Jacobian, (-1)^(i+j) times the minor (appendix)."""
        return self._substitute_numbers(_compute_cofactors(self._structure))

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
        d = self.derivation
        return expand_jacobian(self._structure).with_numbers(d.substitute_values, d.determinant)

    @property
    def sparsest_line_name(self) -> str:
        """The name of the row or column of J with the most zeros, such as "row 2"."""
        return expansion.find_sparsest_line(self.derivation.jacobian).name

    @cached_property
    def arm_expansion(self) -> Expansion:
        """The steps that expand det J11 of an arm with a spherical wrist whose axes meet in P."""
        chain = self._structure
        wrist_frame = compute_frame_after(chain.joints[3 : chain.point.frame])
        wrist_centre = wrist_frame.origin + wrist_frame.rotation * sp.Matrix(chain.point.offset)
        point = Point(3, tuple(wrist_centre.applyfunc(to_textbook_form)))
        first_joints = Chain("arm", chain.joints[:3], VELOCITY_NAMES[:3], chain.base, point)
        determinant = derive_block_determinants(self.chain)[0]
        return expand_jacobian(first_joints).with_numbers(self.derivation.substitute_values, determinant)

    @cached_property
    def wrist_expansion(self) -> Expansion:
        """The steps that expand det J22 in frame 3."""
        steps = expand_determinant(derive_wrist_block(self._structure))
        return steps.with_numbers(self.derivation.substitute_values, derive_block_determinants(self.chain)[1])

    @property
    def wrist_block(self) -> sp.Matrix:
        """The block J22: the axes of joints 4 to 6 in frame 3, for an arm with a spherical wrist."""
        return derive_wrist_block(self.chain)

    @property
    def joint_1_value(self) -> sp.Expr:
        """The value of joint 1 at which the entries of J are shortest."""
        value_with_offset = expansion.find_joint_1_value(self._structure).xreplace(self._values)
        return wrap_angle(value_with_offset - self.chain.offsets[0])

    @property
    def jacobian_at_joint_1(self) -> sp.Matrix | None:
        """J at `joint_1_value`; None if det J depends on joint 1, if J doesn't, or unless there are 2 to 4 joints."""
        jacobian = expansion.shorten_by_joint_1(self._structure) if 1 < self.chain.n <= 4 else None
        return None if jacobian is None else jacobian.applyfunc(self.derivation.substitute_values)

    @cached_property
    def block_determinants(self) -> sp.Matrix | None:
        """The determinants of J11 and J22 (2 x 1) if the wrist's axes meet in P; None for other arms."""
        return derive_block_determinants(self.chain) if find_block_objection(self.chain) is None else None

    @cached_property
    def minors(self) -> list[tuple[str, sp.Expr]]:
        """The maximal minors of a Jacobian that is not square, each after the names of its columns or rows."""
        rows, cols = self.derivation.jacobian.shape
        size, count = min(rows, cols), max(rows, cols)
        line_kind = "columns" if cols > rows else "rows"
        choices = combinations(map(str, range(1, count + 1)), size)
        labels = [f"{line_kind} {', '.join(numbers)}" for numbers in choices]
        values = (minor.substitute(self._values) for minor in self.derivation.symbolic_minors)
        return list(zip(labels, values, strict=True))

    def find_largest_minor(self, configuration: ConfigurationAndVelocity) -> tuple[str, sp.Expr]:
        """Return the minor with the largest absolute value at a configuration: its columns or rows, and its value."""
        values = {label: self.evaluate(configuration, minor) for label, minor in self.minors}
        largest_label = max(values, key=lambda label: abs(values[label]))
        return largest_label, values[largest_label]

    # --- singular configurations ---

    @property
    def components(self) -> list[Component]:
        """The components of the singular set, with their conditions in the form that solutions show."""
        return [
            replace(component, conditions=self._simplify_conditions(component))
            for component in find_singular_set(self.chain) or ()
        ]

    def _simplify_conditions(self, component: Component) -> tuple[sp.Expr, ...]:
        return tuple(map(self.simplify_condition, component.conditions))

    @property
    def may_be_singular(self) -> bool:
        """Whether the arm may have singular configurations; True if the formulas are too long to find out."""
        try:
            return find_singular_set(self.chain) != ()
        except TooLong:
            return True

    @property
    def has_only_boundary_singularities(self) -> bool:
        """Whether all singular configurations are on the workspace boundary."""
        classifications = (component.classification for component in self.singular_components)
        return all(c.kind == "boundary" and c.is_uniform for c in classifications)

    @cached_property
    def singular_components(self) -> list[SingularComponent]:
        """The components of the singular set, classified."""
        return [self.classify_component(component) for component in find_singular_set(self.chain) or ()]

    def classify_component(self, component: Component) -> SingularComponent:
        """Return a component of the singular set with its geometric meaning and its kind."""
        conditions = self._simplify_conditions(component)
        classification = classify(self.chain, component)
        cases = self._find_cases(component, classification)
        inequalities = (find_existence_condition(condition, self.chain) for condition in conditions)
        inequality = next(filter(None, inequalities), None)
        return SingularComponent(conditions, component.solutions, classification, cases, inequality)

    def simplify_condition(self, condition: sp.Expr) -> sp.Expr:
        """Return a condition without its numeric factor; a sum has the same signs as in the det J that is shown."""
        without_number = remove_numeric_factor(condition)
        if not without_number.is_Add or not self.derivation.is_square:
            return without_number
        opposite_latex = f"({tex(-without_number, self.chain, self.angles)})"
        is_opposite_shown = opposite_latex in tex(self.derivation.determinant, self.chain, self.angles)
        return -without_number if is_opposite_shown else without_number

    def _find_cases(
        self, component: Component, classification: Classification
    ) -> tuple[tuple[ValueCombination, Classification], ...]:
        """Return the classification for each choice of joint values; () if it is the same for all."""
        subsets = split_by_value(component, classification)
        cases = tuple((values, classify(self.chain, subset)) for values, subset in subsets)
        return cases if len({case for _, case in cases}) > 1 else ()

    def find_components(self, configuration: ConfigurationsOfOneKind) -> list[SingularComponent]:
        """Return the components of the singular set that contain a configuration; none if it is regular."""
        return [
            SingularComponent(self._simplify_conditions(c), c.solutions, classify(self.chain, c))
            for c in find_components_containing(self.chain, configuration)
        ]

    def is_one_sided(self, configurations: ConfigurationsOfOneKind | MeaningDetails) -> bool:
        """Return whether P can leave the singular configurations only to one side along the lost direction."""
        return is_one_sided(self.chain, configurations.condition, configurations.values)

    # --- numbers ---

    def evaluate(self, configuration: Configuration, expression: sp.Matrix | sp.Expr) -> sp.Matrix | sp.Expr:
        """Return the value of a formula or matrix at a configuration, to four significant digits."""
        substituted_expression = expression.xreplace(configuration.values)
        if isinstance(substituted_expression, sp.MatrixBase):
            return substituted_expression.applyfunc(_evaluate_to_four_digits)
        return _evaluate_to_four_digits(substituted_expression)

    def evaluate_inverse(self, configuration: ConfigurationAndVelocity) -> sp.Matrix:
        """Return the inverse of the task Jacobian at a configuration, to four significant digits."""
        return round_matrix(compute_inverse(evaluate_jacobian_precisely(self.chain, configuration)))

    def evaluate_determinant(self, configuration: ConfigurationAndVelocity) -> sp.Expr:
        """Return the determinant of the task Jacobian at a configuration, to four significant digits."""
        return round_to_four_digits(compute_determinant(evaluate_jacobian_precisely(self.chain, configuration)))

    def substitute_joints(self, configuration: ConfigurationsOfOneKind, expression: sp.Expr) -> sp.Expr:
        """Return an expression with joint values substituted: lengths stay symbols, numbers get four digits."""
        substituted_expression = sp.expand(sp.N(expression.xreplace(configuration.joints), 15))
        return substituted_expression.xreplace(
            {number: _evaluate_to_four_digits(number) for number in substituted_expression.atoms(sp.Float)}
        )

    def format_answer(self, part: Part) -> list[str]:
        """Return the numbers of an answer as text, to the digits that students need."""
        return [format_number(value, part.count_digits(float(value))) for value in part.answer.as_matrix()]


@lru_cache(maxsize=512)
def _compute_cofactors(chain: Chain) -> sp.Matrix:
    """Return the cofactors of the task Jacobian of a structure."""
    jacobian = derive(chain).jacobian
    n = jacobian.rows
    return sp.Matrix(n, n, lambda i, j: jacobian.cofactor(i, j) if n > 1 else sp.S.One)


def format_number(value: sp.Expr, digits: int = 3) -> str:
    """Return a number as text with significant digits; only very small numbers have an exponent.

    >>> format_number(sp.Float("0.0752277")), format_number(sp.Float("-12.345"))
    ('0.0752', '-12.3')
    """
    text = "0" if abs(value) < sp.Float("1e-12") else f"{float(value):#.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text else text.rstrip(".")


def _evaluate_to_four_digits(value: sp.Expr) -> sp.Expr:
    """Return the value of an exact number, such as sqrt(2)/3, to four significant digits."""
    number = sp.N(value, 15)
    if abs(number) < sp.Float("1e-12"):
        return sp.S.Zero
    return sp.Float(f"{float(number):.4g}", 10)
