r"""Typeset a student's answer from its expression tree, with terms and factors in the student's order.

Nothing is simplified. Names and sines are written in the textbook's notation: \theta_{1}, \dot{d}_{2}, and s_{12} for
sin(theta1 + theta2).
"""

import re
from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from qdot.exercises.formula import layout
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import (
    Layout,
    Pieces,
    make_digits,
    make_numeric_fraction,
    make_row,
    make_script,
)
from qdot.exercises.formula.trees import ONE, Node, ParseError, as_matrix, format_tree, make_number
from qdot.exercises.writing.latex import write_symbol
from qdot.exercises.writing.units import tex_unit

MAX_DEPTH = 30
"""Maximum depth of trees that are typeset; deeper formulas would be unreadable."""

_RELATION, _SUM, _PRODUCT, _FACTOR, _ATOM = range(5)
"""How strongly an operand binds, from weak to strong. Only an atom needs no brackets as the base of a power."""

_FUNCTION_NAMES = {
    "asin": Layout("function", "arcsin"), "acos": Layout("function", "arccos"), "atan": Layout("function", "arctan"),
    "acot": Layout("text", "arccot"), "log": Layout("function", "ln"), "atan2": Layout("text", "atan2"),
    "sign": Layout("text", "sign"),
}  # fmt: skip
"""The names of functions that are not shown as typed; LaTeX has no commands for those that are texts."""
_CONSTANTS = {"pi": "π", "E": "e", "I": "i"}
_TALL = frozenset(("fraction", "root", "matrix"))
"""Kinds of layouts that need tall brackets."""
_ELEMENT_SIGN = Layout("sign", "∈")
_AND, _OR = (Layout("text", " and "),), (Layout("text", " or "), layout.QQUAD)
_SYMBOL_PATTERN = re.compile(r"(?:theta|alpha|beta|qd|[a-zA-Z])\d*|[vwfm][xyz]")
_PI, _HALF_TURN = Node("name", value="pi"), make_number(180)
_ANGLE_PATTERN = re.compile(r"theta(\d)")


class TooDeep(ValueError):
    """The tree is nested too deeply to be typeset."""


class _Operand(NamedTuple):
    """A typeset operand: its pieces, and how strongly it binds (_RELATION to _ATOM)."""

    pieces: Pieces
    level: int


def typeset(
    node: Node, prismatic_numbers: tuple[str, ...] = (), are_alternatives: bool = False, units: Sequence[str] = ()
) -> Layout:
    r"""Return the layout of an answer. Raises TooDeep.

    `prismatic_numbers` are the numbers of the prismatic joints, whose rates are written \dot d. If `are_alternatives`,
    the conditions in a list are alternatives; otherwise, all hold. `units` has the unit of each entry of a numeric
    vector.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.printers.latex import print_latex
    >>> print_latex(typeset(parse_formula("-a1*sin(theta1 + theta2)/2 + x_long^2")))
    '-\\tfrac{1}{2}\\, a_{1} s_{12} + \\text{x_long}^{2}'
    """
    return make_row(*_Typesetter(prismatic_numbers, are_alternatives, units).typeset_answer(node))


class _Typesetter:
    """Typesets trees by recursion. A loop handles the left operands of sums and products, which may be many."""

    def __init__(self, prismatic_numbers: tuple[str, ...], are_alternatives: bool, units: Sequence[str]) -> None:
        self.prismatic_numbers, self.units, self.depth = prismatic_numbers, units, 0
        self.separator = _OR if are_alternatives else (layout.COMMA, layout.QQUAD)

    def typeset_answer(self, node: Node) -> Pieces:
        rows = _find_rows(node) if node.kind in ("list", "set", "dict", "eq", "in", "and", "or") else [[node]]
        if not self.units or rows is None or len(rows) * len(rows[0]) != len(self.units):
            return self.typeset_node(node).pieces
        units = iter(parse_latex(tex_unit(unit)).inner for unit in self.units)
        entry_rows = [[(*self.typeset_node(entry).pieces, *next(units)) for entry in entries] for entries in rows]
        return entry_rows[0][0] if len(self.units) == 1 else (layout.make_matrix(entry_rows),)

    def typeset_node(self, node: Node) -> _Operand:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise TooDeep(f"the answer nests more than {MAX_DEPTH} deep")
        operand = _TYPESETTERS[node.kind](self, node)
        self.depth -= 1
        return operand

    def typeset_operand(self, node: Node, level: int) -> Pieces:
        """Return a typeset operand, in brackets if it binds less strongly than `level`."""
        operand = self.typeset_node(node)
        return operand.pieces if operand.level >= level else layout.bracket(operand.pieces, _TALL)

    def typeset_name(self, node: Node) -> _Operand:
        name = str(node.value)
        if name in _CONSTANTS:
            return _Operand((Layout("letter", _CONSTANTS[name]),), _ATOM)
        if _SYMBOL_PATTERN.fullmatch(name):
            return _Operand(parse_latex(write_symbol(name, self.prismatic_numbers)).inner, _ATOM)
        # A name may contain characters such as ⑴, which normalization turns into (1), so that brackets would appear.
        text = "".join(ch if ch.isalnum() or ch in "._" else "?" for ch in name)
        return _Operand((Layout("text", text),), _ATOM)

    def typeset_sum(self, node: Node) -> _Operand:
        if node.kind == "neg":
            return _Operand((layout.MINUS, *self.typeset_operand(node.args[0], _PRODUCT)), _SUM)
        left_operand, terms = node, list[Pieces]()
        while left_operand.kind in ("+", "-"):
            sign = layout.PLUS if left_operand.kind == "+" else layout.MINUS
            terms.append((sign, *self.typeset_operand(left_operand.args[1], _PRODUCT)))
            left_operand = left_operand.args[0]
        return _Operand(layout.join_pieces((), [self.typeset_operand(left_operand, _SUM), *reversed(terms)]), _SUM)

    def typeset_product(self, node: Node) -> _Operand:
        if (degrees := _find_degrees(node)) is not None:
            return _Operand(layout.raise_pieces_to(self.typeset_node(degrees).pieces, layout.DEGREE), _FACTOR)
        numerator, denominator = _split_factors(node)
        if not denominator:
            return _Operand(self.typeset_factors(numerator), _PRODUCT)
        other_factors = [factor for factor in numerator if factor.kind != "number"]
        has_numeric_denominator = all(factor.kind == "number" for factor in denominator)
        is_small = has_numeric_denominator and all(factor.value == "pi" for factor in other_factors)
        if has_numeric_denominator and not is_small:  # 4*sin(theta1)/25 has its fraction before the sine
            numbers = [factor for factor in numerator if factor.kind == "number"] or [ONE]
            coefficient = layout.make_fraction(self.typeset_factors(numbers), self.typeset_factors(denominator), True)
            return _Operand((coefficient, layout.THIN, *self.typeset_factors(other_factors, False)), _PRODUCT)
        if len(numerator) > 1:  # (1/a1)*a2 is a2/a1
            numerator = [factor for factor in numerator if factor != ONE] or numerator[:1]
        fraction = layout.make_fraction(self.typeset_factors(numerator), self.typeset_factors(denominator), is_small)
        return _Operand((fraction,), _FACTOR)

    def typeset_factors(self, factors: Sequence[Node], is_alone: bool = True) -> Pieces:
        """Return factors side by side; a single factor needs no brackets if `is_alone`."""
        if len(factors) == 1 and is_alone:
            return self.typeset_node(factors[0]).pieces
        factor_pieces = [self.typeset_operand(factor, _FACTOR) for factor in factors]
        pieces = list(factor_pieces[0])
        for left_factor, factor in pairwise(factor_pieces):
            pieces += (*_choose_separator(left_factor, factor[0]), *factor)
        return tuple(pieces)

    def typeset_power(self, node: Node) -> _Operand:
        base, exponent = node.args
        is_fraction = exponent.kind == "/" and all(arg.kind == "number" for arg in exponent.args)  # as in a^(1/2)
        separator = (Layout("sign", "/"),)
        superscript = make_row(*self.typeset_list(exponent.args if is_fraction else (exponent,), separator))
        is_whole_number = len(superscript.inner) == 1 and superscript.inner[0].text.isdigit()
        if base.kind == "call" and base.value in ("sin", "cos", "tan") and is_whole_number:
            return self.typeset_call(base, superscript)
        return _Operand(layout.raise_pieces_to(self.typeset_operand(base, _ATOM), superscript), _FACTOR)

    def typeset_call(self, node: Node, superscript: Layout = layout.EMPTY) -> _Operand:
        word = str(node.value)
        if word in ("sin", "cos") and (joint_digits := _find_joint_digits(node.args[0])):
            symbol = make_script(Layout("letter", word[0]), make_row(*make_digits(joint_digits)), superscript)
            return _Operand((symbol,), _FACTOR if superscript.inner else _ATOM)
        arguments = self.typeset_list(node.args)
        if word == "sqrt":
            return _Operand((Layout("root", "sqrt", (make_row(*arguments),)),), _FACTOR)
        if word == "abs":
            return _Operand((layout.make_fence("||", arguments),), _ATOM)
        function_name = _FUNCTION_NAMES.get(word) or Layout("function", word)
        function_name = make_script(function_name, layout.EMPTY, superscript) if superscript.inner else function_name
        return _Operand((function_name, *layout.bracket(arguments, _TALL)), _FACTOR)

    def typeset_list(self, nodes: Sequence[Node], separator: Sequence[Layout] = (layout.COMMA,)) -> Pieces:
        return layout.join_pieces(separator, (self.typeset_node(node).pieces for node in nodes))

    # --- lists and conditions ---

    def typeset_collection(self, node: Node) -> _Operand:
        if any(item.kind in ("eq", "in", "pair", "and", "or", "dict") for item in node.args):
            return _Operand(self.typeset_list(node.args, _AND if node.kind == "dict" else self.separator), _RELATION)
        if (rows := _find_rows(node)) is not None:
            entry_rows = [[self.typeset_node(entry).pieces for entry in entries] for entries in rows]
            return _Operand((layout.make_matrix(entry_rows),), _ATOM)
        brackets = "[]" if node.kind == "list" else "{}"
        return _Operand((layout.make_fence(brackets, self.typeset_list(node.args)),), _ATOM)

    def typeset_relation(self, node: Node) -> _Operand:
        if node.kind in ("and", "or"):
            return _Operand(self.typeset_list(node.args, _AND if node.kind == "and" else _OR), _RELATION)
        left, right = node.args
        sign = layout.EQUALS
        if node.kind == "in" or right.kind in ("list", "set"):  # {theta2: [0, pi]} means that theta2 is 0 or pi
            sign = _ELEMENT_SIGN
            if right.kind not in ("name", "set"):
                right = Node("set", right.args if right.kind == "list" else (right,))
        return _Operand(self.typeset_list((left, right), (sign,)), _RELATION)


_TYPESETTERS: dict[str, Callable[[_Typesetter, Node], _Operand]] = {
    **dict.fromkeys(("number", "decimal"), lambda _, node: _typeset_number(node)),
    "blank": lambda _self, _node: _Operand((Layout("letter", "□"),), _ATOM),
    "name": _Typesetter.typeset_name,
    "^": _Typesetter.typeset_power,
    "call": _Typesetter.typeset_call,
    **dict.fromkeys(("neg", "+", "-"), _Typesetter.typeset_sum),
    **dict.fromkeys(("*", "/"), _Typesetter.typeset_product),
    **dict.fromkeys(("list", "set", "dict"), _Typesetter.typeset_collection),
    **dict.fromkeys(("eq", "in", "pair", "and", "or"), _Typesetter.typeset_relation),
}
"""For each kind of node, the function that typesets it."""


def _choose_separator(left_factor: Pieces, right_start: Layout) -> Pieces:
    """Return the separator of two factors: a dot before a number; a space beside a name and after tall brackets.

    `right_start` is the first piece of the right factor.
    """
    left_base, left_end = layout.get_script_base(left_factor[0]), left_factor[-1]
    right_base = layout.get_script_base(right_start)
    if right_base.kind == "number" or (right_start.kind == "fraction" and left_end.kind == "number"):
        return (layout.DOT,)
    return (layout.THIN,) if "text" in (left_base.kind, right_base.kind) or left_end.text == "()" else ()


def _split_factors(node: Node) -> tuple[list[Node], list[Node]]:
    """Return the factors in the numerator and those in the denominator of a product, in the student's order."""
    numerator, denominator = list[Node](), list[Node]()
    pending_factors = [(node, numerator)]
    while pending_factors:  # from right to left, reversed at the end
        factor, side = pending_factors.pop()
        if factor.kind == "*":
            pending_factors += [(factor.args[0], side), (factor.args[1], side)]
        elif factor.kind == "/" and side is numerator:
            pending_factors += [(factor.args[0], numerator), (factor.args[1], denominator)]
        else:
            side.append(factor)
    return numerator[::-1], denominator[::-1]


def _find_joint_digits(angle: Node) -> str:
    """Return "12" for theta1 + theta2; "" for an angle whose cosine can't be written like c_{12}."""
    left_operand, terms = angle, list[Node]()
    while left_operand.kind == "+":
        terms.append(left_operand.args[1])
        left_operand = left_operand.args[0]
    names = [str(term.value) if term.kind == "name" else "" for term in (left_operand, *terms)]
    digits = {match[1] for match in map(_ANGLE_PATTERN.fullmatch, names) if match is not None}
    return "".join(sorted(digits)) if len(digits) == len(names) else ""


def _find_rows(node: Node) -> list[list[Node]] | None:
    """Return the rows of entries if a node is parsed as a matrix or vector, otherwise None."""
    if node.kind != "list" and not (node.kind == "set" and node.args and node.args[0].kind == "set"):
        return None
    try:
        rows = as_matrix(node)
    except ParseError:
        return None
    return rows if rows != [[node]] else None


def _find_degrees(node: Node) -> Node | None:
    """Return 30 if a node is an angle of 30 degrees, which is parsed as 30*pi/180; None for any other node."""
    if node.kind != "/" or node.args[1] != _HALF_TURN or node.args[0].kind != "*":
        return None
    degrees, pi = node.args[0].args
    return degrees if degrees.kind in ("number", "decimal") and pi == _PI else None


def _typeset_number(node: Node) -> _Operand:
    """Return a typeset number; a very large or very small decimal has a power of ten."""
    value: Fraction = node.value
    if node.kind == "number" and value.denominator != 1:
        return _Operand((make_numeric_fraction(value.numerator, value.denominator),), _FACTOR)
    digits = format_tree(node)
    if node.kind == "decimal" and value and not Fraction(1, 10**5) <= abs(value) < 10**9:
        mantissa, _, power = f"{Decimal(digits):e}".partition("e")
        return _Operand(layout.make_scientific_number(mantissa.rstrip("0").rstrip("."), int(power)), _PRODUCT)
    return _Operand(make_digits(digits), _ATOM)
