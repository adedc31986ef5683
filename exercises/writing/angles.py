r"""Name the angles in a solution: for example, \varphi_{12} is \theta_1 + \theta_2 + 30 degrees.

c_{12} is always the cosine of \theta_1 + \theta_2 alone. If c_{12} included the table's offsets, students who forget
the offsets would think that their wrong answer is correct.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import wrap_multiple_of_pi
from qdot.exercises.formula.order import find_number_in_name
from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.writing import shortening


@dataclass(frozen=True)
class AngleNames:
    r"""Names for angles whose cosines can't be written like c_{12}.

    They contain a difference, or a constant that is not a multiple of 90 degrees. `angle_by_name` has
    the angle for each name.
    """

    angle_by_name: Mapping[sp.Symbol, sp.Expr]
    _named_trigs: dict[sp.Expr, sp.Expr] = field(default_factory=dict, compare=False, repr=False)

    def use_names(self, expression: sp.Expr | sp.Matrix) -> sp.Expr | sp.Matrix:
        """Return an expression or matrix with named angles in its sines and cosines, and with its sums factored.

        An angle is written with a name only if it is ±1 or ±2 times the named angle plus a multiple of 90 degrees.
        """
        if isinstance(expression, sp.MatrixBase):
            return expression.applyfunc(self.use_names)
        expanded_expression = shortening.remove_constant_shifts(expression)
        renamed_trigs = {trig: self._use_name(trig) for trig in expanded_expression.atoms(sp.sin, sp.cos)}
        return shortening.factor_sums(expanded_expression.xreplace(renamed_trigs))

    def shorten(self, expression: sp.Expr | sp.Matrix) -> sp.Expr | sp.Matrix:
        """Return a result shortened by sin^2 + cos^2 = 1, and by angle-sum identities if this shortens it."""
        if isinstance(expression, sp.MatrixBase):
            return expression.applyfunc(self.shorten)
        return shortening.replace_squares(shortening.use_angle_sums(expression, self._can_be_abbreviated))

    def _can_be_abbreviated(self, angle: sp.Expr) -> bool:
        """Return whether the cosine of an angle can be written like c_{12} or with a named angle."""
        return not needs_name(angle) or _express_by_name(angle, self.angle_by_name) is not None

    def _use_name(self, trig: sp.Expr) -> sp.Expr:
        if trig not in self._named_trigs:
            (angle,) = trig.args
            renamed_angle = _express_by_name(angle, self.angle_by_name) if needs_name(angle) else None
            self._named_trigs[trig] = trig if renamed_angle is None else trig.func(renamed_angle)
        return self._named_trigs[trig]

    def write_python_code(self, expression: sp.Expr) -> str:
        """Return an expression as Python code, with angles such as theta1 + 5*pi/6 instead of their names."""
        new_expression = shortening.multiply_numbers(self.use_names(self.shorten(expression)))
        return print_python(new_expression, {name: print_python(angle) for name, angle in self.angle_by_name.items()})


def name_angles(angles: Iterable[sp.Expr], *matrices: sp.Matrix) -> AngleNames:
    r"""Return names for angles, in order, and then for other angles in the sines and cosines of `matrices`.

    SymPy rewrites cos(theta1 - 2 pi/3) as -cos(theta1 + pi/3). Because `angles` come first, a link's own angle gets the
    name, not SymPy's.

    >>> t1, (a1, phi) = sp.Symbol("theta1"), sp.symbols(r"a1 \varphi_{1}")
    >>> names = name_angles([t1 - 2 * sp.pi / 3])
    >>> names.angle_by_name, names.use_names(a1 * sp.cos(t1 - 2 * sp.pi / 3)) == a1 * sp.cos(phi)
    ({\varphi_{1}: theta1 - 2*pi/3}, True)
    """
    other_angles = {trig.args[0] for matrix in matrices for trig in matrix.atoms(sp.sin, sp.cos)}
    angle_by_name: dict[sp.Symbol, sp.Expr] = {}
    for angle in (*angles, *sorted(other_angles, key=lambda a: (len(a.free_symbols), format_expression(a)))):
        has_unit_coefficients = all(abs(angle.coeff(symbol)) == 1 for symbol in angle.free_symbols)
        if needs_name(angle) and has_unit_coefficients and _express_by_name(angle, angle_by_name) is None:
            angle_by_name[_make_name(angle, angle_by_name)] = angle
    return AngleNames(angle_by_name)


def needs_name(angle: sp.Expr) -> bool:
    """Return whether an angle contains a symbol but is not a sum of joint variables and multiples of 90 degrees."""
    remainder, constant = shortening.split_constant(angle)
    return remainder != 0 and not ((2 * constant / sp.pi).is_Integer and shortening.is_joint_sum(remainder))


def _express_by_name(angle: sp.Expr, angle_by_name: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr | None:
    """Return an angle as ±1 or ±2 times a named angle plus a multiple of 90 degrees, or None if that is impossible."""
    for name, meaning in angle_by_name.items():
        for factor in (1, -1, 2, -2):
            difference = sp.expand(angle - factor * meaning)
            if (2 * difference / sp.pi).is_Integer:
                return factor * name + difference
    return None


def _make_name(angle: sp.Expr, angle_by_name: Mapping[sp.Symbol, sp.Expr]) -> sp.Symbol:
    name = rf"\varphi_{{{''.join(map(str, sorted(find_number_in_name(symbol) for symbol in angle.free_symbols)))}}}"
    while sp.Symbol(name) in angle_by_name:
        name = name.replace(r"\varphi", r"\varphi'", 1)
    return sp.Symbol(name)


def iterate_arm_angles(chain: Chain) -> Iterator[sp.Expr]:
    """Yield the angles that may occur in an arm's formulas: of links, of rows of the table, and between two links."""
    runs = _group_angles_by_run(chain)
    yield from (angle for run in runs for angle in run)
    yield from (_reduce_constant(joint.theta) for joint in chain.joints if joint.is_revolute)
    for run in runs:
        differences = (_reduce_constant(other_angle - angle) for angle, other_angle in combinations(run, 2))
        yield from map(_make_first_joint_positive, differences)


def list_link_angles(chain: Chain) -> list[sp.Expr]:
    """Return each link's angle, summed over the joints since the direction of the axes last changed.

    If all axes are parallel, this is the angle of x_i in the world frame. The constant of an angle is in (-pi, pi].
    """
    return [angle for run in _group_angles_by_run(chain) for angle in run][1:]


def _group_angles_by_run(chain: Chain) -> list[list[sp.Expr]]:
    """Return the angles of the base and of all links, grouped into runs of parallel axes."""
    total, sense = chain.base.yaw, 1  # the sense is -1 if an axis is antiparallel to the first axis of its run
    runs: list[list[sp.Expr]] = [[]]
    for theta, alpha in [(sp.S.Zero, chain.base.tilt), *((joint.theta, joint.alpha) for joint in chain.joints)]:
        total = _reduce_constant(total + sense * theta)
        runs[-1].append(total)
        if alpha in (sp.pi, -sp.pi):
            sense = -sense
        elif alpha != 0:
            total, sense = sp.S.Zero, 1
            runs.append([])
    return runs


def _reduce_constant(angle: sp.Expr) -> sp.Expr:
    """Return an angle with its constant moved into (-pi, pi]; unchanged if this is not a rational multiple of pi."""
    variable, constant = shortening.split_constant(sp.expand(angle))
    return variable + wrap_multiple_of_pi(constant)


def _make_first_joint_positive(angle: sp.Expr) -> sp.Expr:
    """Return an angle or its negative, so that its first joint variable in alphabetical order has a positive sign."""
    first_joint = min(angle.free_symbols, key=lambda symbol: symbol.name, default=sp.S.One)
    return _reduce_constant(-angle) if angle.coeff(first_joint) == -1 else angle
