r"""Typeset a student's answer from its expression tree, with terms and factors in the student's order.

Nothing is simplified. Names and sines are written in the textbook's notation: \theta_{1}, \dot{d}_{2}, and s_{12} for
sin(theta1 + theta2).
"""

import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from qdot.exercises.formula import algebra, layout
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import Layout, Pieces, number, row, script
from qdot.exercises.formula.trees import Node, ParseError, as_matrix, node_text
from qdot.exercises.writing.latex import symbol_latex

MAX_DEPTH = 30
"""Maximum depth of trees that are typeset; deeper formulas would be unreadable."""

_RELATION_LEVEL, _SUM_LEVEL, _PRODUCT_LEVEL, _FACTOR_LEVEL, _ATOM_LEVEL = range(5)
"""How strongly a piece binds, from weak to strong. Only an atom needs no brackets as the base of a power."""

_FUNCTIONS = {
    "asin": Layout("word", "arcsin"), "acos": Layout("word", "arccos"), "atan": Layout("word", "arctan"),
    "acot": Layout("text", "arccot"), "log": Layout("word", "ln"), "atan2": Layout("text", "atan2"),
    "sign": Layout("text", "sign"),
}  # fmt: skip
_CONSTANTS = {"pi": "π", "E": "e", "I": "i"}
_TALL = frozenset(("fraction", "root", "matrix"))
_ELEMENT_SIGN, _AND_WORD = (Layout("sign", "∈"),), (Layout("text", " and "),)
_OR_WORD = (Layout("text", " or "), layout.QQUAD)
_SYMBOL_PATTERN = re.compile(r"(?:theta|alpha|beta|qd|[a-zA-Z])\d*|[vwfm][xyz]")
_PI, _HALF_TURN = Node("name", value="pi"), algebra.number(180)
_ANGLE_PATTERN = re.compile(r"theta(\d)")


class TooDeep(ValueError):
    """The tree is nested too deeply to be typeset."""


class _TypesetPiece(NamedTuple):
    """A typeset piece and its binding strength."""

    pieces: Pieces
    level: int


def typeset(
    node: Node, prismatic: tuple[str, ...] = (), are_alternatives: bool = False, units: Sequence[str] = ()
) -> Layout:
    r"""Return the layout of an answer. Raises TooDeep.

    `prismatic` has the numbers of the prismatic joints, whose rates are written \dot d. If `are_alternatives`, the
    conditions in a list are alternatives; otherwise, all hold. `units` has the unit of each entry of a numeric vector.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.printers.latex import latex_text
    >>> latex_text(typeset(parse_formula("-a1*sin(theta1 + theta2)/2 + x_long^2")))
    '-\\tfrac{1}{2}\\, a_{1} s_{12} + \\text{x_long}^{2}'
    """
    return row(*_Typesetter(prismatic, are_alternatives, units).typeset_answer(node))


class _Typesetter:
    """Typesets trees by recursion. A loop handles the left operands of sums and products, which may be many."""

    def __init__(self, prismatic: tuple[str, ...], are_alternatives: bool, units: Sequence[str]) -> None:
        self.prismatic, self.units, self.depth = prismatic, units, 0
        self.separator = _OR_WORD if are_alternatives else (layout.COMMA, layout.QQUAD)

    def typeset_answer(self, node: Node) -> Pieces:
        rows = _find_rows(node) if node.kind in ("list", "set", "dict", "eq", "in", "and", "or") else [[node]]
        if not self.units or rows is None or len(rows) * len(rows[0]) != len(self.units):
            return self.typeset_node(node).pieces
        units = iter((layout.THIN, Layout("text", unit)) if unit else () for unit in self.units)
        entry_rows = [[(*self.typeset_node(entry).pieces, *next(units)) for entry in entries] for entries in rows]
        return entry_rows[0][0] if len(self.units) == 1 else (layout.matrix(entry_rows),)

    def typeset_node(self, node: Node) -> _TypesetPiece:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise TooDeep(f"the answer nests more than {MAX_DEPTH} deep")
        typeset_piece = _TYPESETTERS[node.kind](self, node)
        self.depth -= 1
        return typeset_piece

    def typeset_operand(self, node: Node, level: int) -> Pieces:
        """Return a typeset operand, in brackets if it binds less strongly than `level`."""
        typeset_piece = self.typeset_node(node)
        if typeset_piece.level >= level:
            return typeset_piece.pieces
        return layout.bracket(typeset_piece.pieces, _TALL)

    def typeset_name(self, node: Node) -> _TypesetPiece:
        name = str(node.value)
        if name in _CONSTANTS:
            return _TypesetPiece((Layout("letter", _CONSTANTS[name]),), _ATOM_LEVEL)
        if _SYMBOL_PATTERN.fullmatch(name):
            return _TypesetPiece(parse_latex(symbol_latex(name, self.prismatic)).inner, _ATOM_LEVEL)
        # A name may contain characters that normalize to others, such as Unicode's digits in brackets.
        text = "".join(ch if ch.isalnum() or ch in "._" else "?" for ch in name)
        return _TypesetPiece((Layout("text", text),), _ATOM_LEVEL)

    def typeset_sum(self, node: Node) -> _TypesetPiece:
        if node.kind == "neg":
            return _TypesetPiece((layout.MINUS, *self.typeset_operand(node.args[0], _PRODUCT_LEVEL)), _SUM_LEVEL)
        terms: list[Pieces] = []
        while node.kind in ("+", "-"):
            sign = layout.PLUS if node.kind == "+" else layout.MINUS
            terms.append((sign, *self.typeset_operand(node.args[1], _PRODUCT_LEVEL)))
            node = node.args[0]
        return _TypesetPiece(
            layout.join_pieces((), [self.typeset_operand(node, _SUM_LEVEL), *reversed(terms)]), _SUM_LEVEL
        )

    def typeset_product(self, node: Node) -> _TypesetPiece:
        if (degrees := _find_degrees(node)) is not None:
            pieces = layout.raise_pieces_to(self.typeset_node(degrees).pieces, layout.DEGREE)
            return _TypesetPiece(pieces, _FACTOR_LEVEL)
        numerator, denominator = _split_factors(node)
        if not denominator:
            return _TypesetPiece(self.typeset_factors(numerator), _PRODUCT_LEVEL)
        other_factors = [factor for factor in numerator if factor.kind != "number"]
        is_small = all(factor.value == "pi" for factor in other_factors) and _are_numbers(denominator)
        if not is_small and _are_numbers(denominator):  # 4*sin(theta1)/25 has its fraction before the sine
            numbers = [factor for factor in numerator if factor.kind == "number"] or [algebra.ONE]
            coefficient = layout.fraction(
                self.typeset_factors(numbers), self.typeset_factors(denominator), is_small=True
            )
            return _TypesetPiece(
                (coefficient, layout.THIN, *self.typeset_factors(other_factors, is_alone=False)), _PRODUCT_LEVEL
            )
        if len(numerator) > 1:  # (1/a1)*a2 is a2/a1
            numerator = [factor for factor in numerator if factor != algebra.ONE] or numerator[:1]
        return _TypesetPiece(
            (layout.fraction(self.typeset_factors(numerator), self.typeset_factors(denominator), is_small),),
            _FACTOR_LEVEL,
        )

    def typeset_factors(self, factors: Sequence[Node], is_alone: bool = True) -> Pieces:
        """Return factors side by side; a single factor needs no brackets if `is_alone`."""
        if len(factors) == 1 and is_alone:
            return self.typeset_node(factors[0]).pieces
        factor_pieces = [self.typeset_operand(factor, _FACTOR_LEVEL) for factor in factors]
        pieces = list(factor_pieces[0])
        for before, factor in pairwise(factor_pieces):
            pieces += (*_factor_separator(before, factor[0]), *factor)
        return tuple(pieces)

    def typeset_power(self, node: Node) -> _TypesetPiece:
        base, exponent = node.args
        exponent_layout = row(*self.typeset_exponent(exponent))
        is_whole = len(exponent_layout.inner) == 1 and exponent_layout.inner[0].text.isdigit()
        if base.kind == "call" and base.value in ("sin", "cos", "tan") and is_whole:
            return self.typeset_call(base, exponent_layout)
        return _TypesetPiece(
            layout.raise_pieces_to(self.typeset_operand(base, _ATOM_LEVEL), exponent_layout), _FACTOR_LEVEL
        )

    def typeset_exponent(self, node: Node) -> Pieces:
        if node.kind == "/" and all(arg.kind == "number" for arg in node.args):
            return layout.join_pieces((Layout("sign", "/"),), [self.typeset_node(arg).pieces for arg in node.args])
        return self.typeset_node(node).pieces

    def typeset_call(self, node: Node, superscript: Layout = layout.EMPTY) -> _TypesetPiece:
        word = str(node.value)
        if word in ("sin", "cos") and (joints := _list_joint_digits(node.args[0])):
            symbol = script(Layout("letter", word[0]), row(*number(joints)), superscript)
            return _TypesetPiece((symbol,), _FACTOR_LEVEL if superscript.inner else _ATOM_LEVEL)
        arguments = self.typeset_list(node.args)
        if word == "sqrt":
            return _TypesetPiece((Layout("root", "sqrt", (row(*arguments),)),), _FACTOR_LEVEL)
        if word == "abs":
            return _TypesetPiece((layout.fence("||", arguments),), _ATOM_LEVEL)
        function_name = _FUNCTIONS.get(word) or Layout("word", word)
        function_name = script(function_name, layout.EMPTY, superscript) if superscript.inner else function_name
        return _TypesetPiece((function_name, *layout.bracket(arguments, _TALL)), _FACTOR_LEVEL)

    def typeset_list(self, nodes: Sequence[Node], separator: Sequence[Layout] = (layout.COMMA,)) -> Pieces:
        return layout.join_pieces(separator, (self.typeset_node(node).pieces for node in nodes))

    # --- lists and conditions ---

    def typeset_collection(self, node: Node) -> _TypesetPiece:
        if any(item.kind in ("eq", "in", "pair", "and", "or", "dict") for item in node.args):
            separator = _AND_WORD if node.kind == "dict" else self.separator
            return _TypesetPiece(self.typeset_list(node.args, separator), _RELATION_LEVEL)
        if (rows := _find_rows(node)) is not None:
            entry_rows = [[self.typeset_node(entry).pieces for entry in entries] for entries in rows]
            return _TypesetPiece((layout.matrix(entry_rows),), _ATOM_LEVEL)
        brackets = "[]" if node.kind == "list" else "{}"
        return _TypesetPiece((layout.fence(brackets, self.typeset_list(node.args)),), _ATOM_LEVEL)

    def typeset_relation(self, node: Node) -> _TypesetPiece:
        if node.kind in ("and", "or"):
            word = _AND_WORD if node.kind == "and" else _OR_WORD
            return _TypesetPiece(self.typeset_list(node.args, word), _RELATION_LEVEL)
        left, right = node.args
        if node.kind == "in" or right.kind in ("list", "set"):  # {theta2: [0, pi]} means that theta2 is 0 or pi
            values = right if right.kind == "name" else Node("set", right.args if right.kind == "list" else (right,))
            values = right if right.kind == "set" else values
            return _TypesetPiece(self.typeset_list((left, values), _ELEMENT_SIGN), _RELATION_LEVEL)
        return _TypesetPiece(self.typeset_list((left, right), (layout.EQUALS,)), _RELATION_LEVEL)


_TYPESETTERS: dict[str, Callable[[_Typesetter, Node], _TypesetPiece]] = {
    **dict.fromkeys(("number", "decimal"), lambda _, node: _typeset_number(node)),
    "blank": lambda _self, _node: _TypesetPiece((Layout("letter", "□"),), _ATOM_LEVEL),
    "name": _Typesetter.typeset_name,
    "^": _Typesetter.typeset_power,
    "call": _Typesetter.typeset_call,
    **dict.fromkeys(("neg", "+", "-"), _Typesetter.typeset_sum),
    **dict.fromkeys(("*", "/"), _Typesetter.typeset_product),
    **dict.fromkeys(("list", "set", "dict"), _Typesetter.typeset_collection),
    **dict.fromkeys(("eq", "in", "pair", "and", "or"), _Typesetter.typeset_relation),
}


def _factor_separator(previous_factor: Pieces, next_start: Layout) -> Pieces:
    """Return the separator of two factors: a dot before a number; a space beside a name and after tall brackets."""
    previous_piece, next_piece = previous_factor[-1], layout.base_of_script(next_start)
    previous_start = layout.base_of_script(previous_factor[0])
    if next_piece.kind == "number" or (next_start.kind == "fraction" and previous_piece.kind == "number"):
        return (layout.DOT,)
    return (layout.THIN,) if "text" in (previous_start.kind, next_piece.kind) or previous_piece.text == "()" else ()


def _are_numbers(factors: Sequence[Node]) -> bool:
    return all(factor.kind == "number" for factor in factors)


def _split_factors(node: Node) -> tuple[list[Node], list[Node]]:
    """Return the factors in the numerator and those in the denominator of a product, in the student's order."""
    numerator, denominator = list[Node](), list[Node]()
    pending = [(node, numerator)]
    while pending:  # from right to left, reversed at the end
        part, side = pending.pop()
        if part.kind == "*":
            pending += [(part.args[0], side), (part.args[1], side)]
        elif part.kind == "/" and side is numerator:
            pending += [(part.args[0], numerator), (part.args[1], denominator)]
        else:
            side.append(part)
    return numerator[::-1], denominator[::-1]


def _list_joint_digits(angle: Node) -> str:
    """Return "12" for theta1 + theta2; "" for an angle whose cosine can't be written like c_{12}."""
    digits: list[str] = []
    while True:
        term = angle.args[1] if angle.kind == "+" else angle
        match = _ANGLE_PATTERN.fullmatch(str(term.value)) if term.kind == "name" else None
        if match is None or match[1] in digits:
            return ""
        digits.append(match[1])
        if angle.kind != "+":
            return "".join(sorted(digits))
        angle = angle.args[0]


def _find_rows(node: Node) -> list[list[Node]] | None:
    """Return the rows of entries if a node is parsed as a matrix or vector; otherwise None."""
    if node.kind != "list" and not (node.kind == "set" and node.args and node.args[0].kind == "set"):
        return None
    try:
        rows = as_matrix(node)
    except ParseError:
        return None
    return rows if rows != [[node]] else None


def _find_degrees(node: Node) -> Node | None:
    """Return 30 if a node is an angle of 30 degrees, which is parsed as 30*pi/180; None if it is no such angle."""
    if node.kind != "/" or node.args[1] != _HALF_TURN or node.args[0].kind != "*":
        return None
    number, pi = node.args[0].args
    return number if number.kind in ("number", "decimal") and pi == _PI else None


def _typeset_number(node: Node) -> _TypesetPiece:
    value: Fraction = node.value
    if node.kind == "number" and value.denominator != 1:
        fraction = layout.fraction(number(str(value.numerator)), number(str(value.denominator)), is_small=True)
        return _TypesetPiece((fraction,), _FACTOR_LEVEL)
    digits = node_text(node)
    size = abs(value)
    if node.kind == "decimal" and size and not Fraction(1, 10**5) <= size < 10**9:
        significant = digits.replace(".", "").strip("0")
        integer_digits, _, decimal_digits = digits.partition(".")
        power = len(integer_digits) - 1
        if size < 1:
            power = len(decimal_digits.lstrip("0")) - len(decimal_digits) - 1
        mantissa = f"{significant[0]}.{significant[1:]}".rstrip(".")
        return _TypesetPiece(layout.scientific(mantissa, power), _PRODUCT_LEVEL)
    return _TypesetPiece(number(digits), _ATOM_LEVEL)
