"""Find the relation between symbolic lengths that is necessary for a condition on joint variables to hold anywhere."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import compute_fourier_form


@dataclass(frozen=True)
class ExistenceCondition:
    """The relation `smaller` <= `larger` of symbolic lengths that a condition requires to hold at any configuration.

    `smaller` and `larger` are formulas in lengths (m).
    """

    condition: sp.Expr
    smaller: sp.Expr
    larger: sp.Expr

    def __str__(self) -> str:
        return f"`{self.condition} = 0` can hold only if `{self.smaller} <= {self.larger}`"


def find_existence_condition(condition: sp.Expr, chain: Chain) -> ExistenceCondition | None:
    """Return the relation between symbolic lengths that a condition requires; None if no relation is known.

    A condition is a constant K plus a sum of terms A cos(phi) + B sin(phi). If the angles phi are linearly independent,
    the sum takes every value from -S to S, in which S is the sum of all sqrt(A^2 + B^2). Then the condition can hold if
    and only if |K| <= S. If K has terms of both signs, no relation is known.

    >>> from qdot.exercises.arm.chain import Joint
    >>> rows = [Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)]
    >>> a1, a2, t2 = sp.symbols("a1 a2 theta2")
    >>> str(find_existence_condition(a1 + a2 * sp.cos(t2), Chain("two", tuple(rows), ("vx", "vy"))))
    '`a1 + a2*cos(theta2) = 0` can hold only if `a1 <= a2`'
    """
    try:
        form = compute_fourier_form(sp.expand(condition))
    except ValueError:
        return None
    prismatic_variables = {chain.q[i] for i in chain.prismatic_joints}
    constant_key = (0,) * len(form.angles)
    constant, _ = form.terms.get(constant_key, (sp.S.Zero, sp.S.Zero))
    pairs = [pair for key, pair in form.terms.items() if key != constant_key]
    keys = sp.Matrix([key for key in form.terms if key != constant_key])
    if constant == 0 or not pairs or keys.rank() < len(pairs) or condition.free_symbols & prismatic_variables:
        return None
    amplitudes = [_compute_amplitude(c, s) for c, s in pairs]
    magnitude = _compute_absolute_value(constant)
    if magnitude is None or None in amplitudes:
        return None
    margin = sp.expand(sp.Add(*amplitudes) - magnitude)
    terms = sp.Add.make_args(margin)
    negative_terms = [-term for term in terms if term.as_coeff_Mul()[0].is_negative]
    if not negative_terms or not margin.free_symbols:
        return None
    return ExistenceCondition(
        condition, sp.Add(*negative_terms), sp.Add(*(term for term in terms if -term not in negative_terms))
    )


def _compute_amplitude(c: sp.Expr, s: sp.Expr) -> sp.Expr | None:
    """Return sqrt(c^2 + s^2) for formulas c and s in lengths; None if it is |c| or |s|, and the sign is unknown."""
    if c == 0 or s == 0:
        return _compute_absolute_value(c + s)
    lengths = {symbol: sp.Symbol(symbol.name, positive=True) for symbol in (c + s).free_symbols}
    root = sp.sqrt(sp.expand((c**2 + s**2).xreplace(lengths)))
    return root.xreplace({length: symbol for symbol, length in lengths.items()})


def _compute_absolute_value(formula: sp.Expr) -> sp.Expr | None:
    """Return the absolute value of a formula in lengths if all its terms have the same sign, else None."""
    signs = {bool(term.as_coeff_Mul()[0].is_negative) for term in sp.Add.make_args(sp.expand(formula))}
    return None if len(signs) > 1 else sp.expand(-formula if signs == {True} else formula)
