"""Print expressions, matrices and lists as Python code for SymPy, as in the cells of a notebook."""

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence

import sympy as sp
from sympy.printing.str import StrPrinter

from qdot.exercises.formula import order
from qdot.exercises.formula.order import write_decimal

MAX_CODE_WIDTH = 88
"""Maximum length of a line of code in a notebook, if it can be broken."""
_MAX_SHORT_BRACKET = 24
"""Maximum number of characters inside brackets that stay on one line."""
_INDENT = "    "

FormulaToCode = Callable[[sp.Expr], str]
"""A function that converts a formula to code."""


class _CodePrinter(StrPrinter):
    """Prints terms and factors in the order in which a person writes them, and fractions as decimals or Rational.

    `sum_texts` maps each symbol that stands for a sum to the text of the sum.
    """

    def __init__(self, sum_texts: Mapping[sp.Symbol, str]) -> None:
        super().__init__()
        self.sum_texts = sum_texts

    def _print_Symbol(self, expr: sp.Symbol) -> str:
        return f"({self.sum_texts[expr]})" if expr in self.sum_texts else str(expr.name)

    def _print_Function(self, expr: sp.Function) -> str:
        if expr.args[0] in self.sum_texts:
            return f"{expr.func.__name__}({self.sum_texts[expr.args[0]]})"
        return str(super()._print_Function(expr))

    def _print_Add(self, expr: sp.Add, order: object = None) -> str:
        return self._print_sum(expr)

    def _print_sum(self, expr: sp.Expr, flips_signs: bool = False) -> str:
        code = ""
        for is_negative, term in order.order_terms(expr, flips_signs):
            if code:
                code += " - " if is_negative else " + "
            elif is_negative:
                code = "-"
            code += self._print_unsigned(term)
        return code

    def _print_Mul(self, expr: sp.Mul) -> str:
        return f"{'-' if order.order_product(expr).is_negative else ''}{self._print_unsigned(expr)}"

    def _print_unsigned(self, term: sp.Expr) -> str:
        """Return a term without its sign."""
        if not term.is_Mul:
            return str(self._print(abs(term) if term.is_Rational or term.is_Float else term))
        product = order.order_product(term)
        is_irrational = any(factor.is_number and not factor.is_Rational for factor in term.args)  # as in 5*pi/6
        digits = None if is_irrational else write_decimal(product.number)
        numbers = (digits, "1") if digits else (str(product.number.p), str(product.number.q))
        numerator, denominator = (
            [text for text in (number, *self._print_factors(factors, product)) if text != "1"]
            for number, factors in zip(numbers, (product.numerator, product.denominator), strict=True)
        )
        if not denominator:
            return "*".join(numerator)
        divisor = "*".join(denominator)
        return f"{'*'.join(numerator) or '1'}/{divisor if len(denominator) == 1 else f'({divisor})'}"

    def _print_factors(self, factors: Sequence[sp.Expr], product: order.Product) -> list[str]:
        sums = {factor: self._print_sum(factor, factor in product.flipped_sums) for factor in factors if factor.is_Add}
        return [f"({sums[factor]})" if factor in sums else str(self._print(factor)) for factor in factors]

    def _print_Rational(self, expr: sp.Rational) -> str:
        return write_decimal(expr) or f"Rational({expr.p}, {expr.q})"

    def _print_Float(self, expr: sp.Float) -> str:
        return f"{float(expr):.10g}"


def print_python(expression: sp.Expr, sum_texts: Mapping[sp.Symbol, str] | None = None) -> str:
    """Return an expression as Python code with exactly the same value.

    `sum_texts` maps symbols to the texts of sums that replace them.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> print_python(sp.Rational(2, 5) * sp.sin(t1) - a1 * sp.cos(t1 + t2 + 5 * sp.pi / 12) / 3)
    '0.4*sin(theta1) - a1*cos(theta1 + theta2 + 5*pi/12)/3'
    """
    return str(_CodePrinter(sum_texts or {}).doprint(expression))


def write_matrix_code(rows: Sequence[Sequence[str]], prefix_width: int) -> str:
    """Return the code of a matrix, given the code of its entries; it begins after `prefix_width` columns of a line."""
    inner_width = prefix_width + len("Matrix()")
    if all(len(row) == 1 for row in rows):
        return f"Matrix({write_list_code([row[0] for row in rows], inner_width)})"
    return f"Matrix({write_list_code([write_list_code(row, len(_INDENT + ','), 1) for row in rows], inner_width)})"


def write_list_code(items: Sequence[str], prefix_width: int, depth: int = 0) -> str:
    """Return the code of a list, on one line if the list fits after `prefix_width` columns.

    Otherwise, each item has a line of its own, indented once more than `depth` times.
    """
    line = f"[{', '.join(items)}]"
    if prefix_width + len(line) <= MAX_CODE_WIDTH and "\n" not in line:
        return line
    indent = _INDENT * depth
    lines = "".join(f"{_wrap(item + ',', depth + 1)}\n" for item in items)
    return f"[\n{lines}{indent}]"


def bracket_long_text(text: str, prefix_width: int) -> str:
    """Return code; if it doesn't fit after `prefix_width` columns, put it in brackets, on separate lines."""
    return text if prefix_width + len(text) <= MAX_CODE_WIDTH else f"(\n{_wrap(text, 1)}\n)"


def _wrap(text: str, depth: int) -> str:
    """Return bracketed code on indented lines, broken before operators.

    Lines are never broken inside cos(...) or inside short brackets, as in (d3 + 0.39).
    """
    indent = _INDENT * depth
    if "\n" in text:  # broken already
        return indent + text
    # \0 stands for a space at which the line must not be broken
    bracket_pattern = rf"(?<=[a-z]\()[^()]*(?=\))|\([^()]{{,{_MAX_SHORT_BRACKET}}}\)"
    protected_text = re.sub(bracket_pattern, lambda match: match.group().replace(" ", "\0"), text)
    protected_text = re.sub(r" ([-+]) ", " \\1\0", protected_text)
    longest_piece = max(map(len, protected_text.split(" ")))
    if longest_piece > MAX_CODE_WIDTH - len(indent + _INDENT):  # a long product is broken before its factors too
        protected_text = re.sub(r"(?<=\))(\*|/)(?=[(a-z])", " \\1\0", protected_text)
    wrapper = textwrap.TextWrapper(MAX_CODE_WIDTH, indent, indent + _INDENT, break_long_words=False)
    wrapper.break_on_hyphens = False
    return wrapper.fill(protected_text).replace("\0", " ")
