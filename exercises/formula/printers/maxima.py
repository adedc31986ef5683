"""Print formulas in Maxima's notation, for STACK; except for `%pi`, students may also type it."""

import sympy as sp
from sympy.printing.precedence import precedence
from sympy.printing.str import StrPrinter

_MAXIMA_NAMES = {"Abs": "abs", "sign": "signum", "ln": "log"}
"""Maps the name of each SymPy function that Maxima names differently to its name in Maxima."""


class _MaximaPrinter(StrPrinter):
    """Prints as SymPy does, with Maxima's powers, constants and functions, and with doubles as exact fractions."""

    def _print_Pi(self, _: sp.Expr) -> str:
        return "%pi"

    def _print_Exp1(self, _: sp.Expr) -> str:
        return "%e"

    def _print_ImaginaryUnit(self, _: sp.Expr) -> str:
        return "%i"

    def _print_Float(self, expr: sp.Float) -> str:
        return str(self._print(sp.Rational(repr(float(expr)))))

    def _print_Pow(self, expr: sp.Pow, **_: bool) -> str:
        if expr.exp == sp.Rational(1, 2):
            return f"sqrt({self._print(expr.base)})"
        if expr.base == sp.E:
            return f"exp({self._print(expr.exp)})"
        base = self.parenthesize(expr.base, precedence(expr) + 1)
        power = self._print(expr.exp)
        return f"{base}^{power}" if expr.exp.is_Integer and expr.exp > 0 else f"{base}^({power})"

    def _print_Function(self, expr: sp.Function) -> str:
        name = expr.func.__name__
        return f"{_MAXIMA_NAMES.get(name, name)}({self.stringify(expr.args, ', ')})"

    def _print_Abs(self, expr: sp.Expr) -> str:
        return f"abs({self._print(expr.args[0])})"


def print_maxima(expression: sp.Expr) -> str:
    """Return an expression as Maxima text with exactly the same value.

    >>> x = sp.Symbol("theta1")
    >>> print_maxima(sp.Rational(2, 5) * sp.sin(x) ** 2 / sp.sqrt(sp.pi + sp.atan(sp.Rational(2, 7))))
    '2*sin(theta1)^2/(5*sqrt(atan(2/7) + %pi))'
    >>> print_maxima(sp.Float(0.25) * sp.Abs(x) ** sp.Rational(-3, 2))
    '1/4/abs(theta1)^(3/2)'
    """
    return str(_MaximaPrinter().doprint(expression))


def print_maxima_matrix(matrix: sp.Matrix) -> str:
    """Return a matrix as Maxima text.

    >>> print_maxima_matrix(sp.Matrix([[0, sp.pi / 2]]))
    'matrix([0, %pi/2])'
    """
    rows = (f"[{', '.join(map(print_maxima, row))}]" for row in matrix.tolist())
    return f"matrix({', '.join(rows)})"
