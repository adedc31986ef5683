"""Text to a tree of plain nodes, by a grammar and a whitelist; nothing of the text is ever executed.

The grammar is Python's and SymPy's way of writing formulas, with what people type beside it: `^` for powers, `2a1`,
theta as a Greek letter, `theta_1`, and the robotics shorthand c12 = cos(theta1 + theta2). Lists, sets, dictionaries
and equations are read, too, as the answers to some questions are made of them. What a node means as a scalar, a
matrix or a set of conditions is for the caller to say.
"""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

MAX_DEPTH = 60
MAX_LENGTH = 300_000

FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tan", "cot", "sec", "csc", "asin", "acos", "atan", "acot")},
    **{name: name for name in ("sinh", "cosh", "tanh", "exp", "log", "sqrt", "atan2", "sign")},
    **{"abs": "abs", "Abs": "abs", "ln": "log", "fabs": "abs"},
    **{"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
}
"""Every function that an expression may call, under each name that is understood for it."""

ARITY = {"atan2": 2}

CONTAINERS = {
    "Matrix", "Union", "ImageSet",
    "MutableDenseMatrix", "ImmutableDenseMatrix", "ImmutableMatrix", "array", "FiniteSet",
    "Eq", "Equality", "Or", "And", "Rational", "Integer", "Float", "Pow", "list", "set", "tuple", "Tuple",
}  # fmt: skip

CONSTANTS = ("pi", "E", "I")
UNDEFINED = ("nan", "NaN", "inf", "oo", "zoo", "None", "True", "False", "undefined")
BLANK = ("blank", "Ellipsis")


class ReadError(ValueError):
    """Text that is no answer: what was found, where, and what would be understood."""


@dataclass(frozen=True, slots=True)
class Node:
    """A piece of an expression: `kind` and `args`; `value` holds a number (Fraction) or a name.

    Kinds: number, decimal, name, blank, call, neg, + - * / ^, list, set, dict, pair, eq, in, and, or.
    """

    kind: str
    args: tuple["Node", ...] = ()
    value: Any = None


_TOKEN = re.compile(
    r"(?P<space>[ \t\r\n\f]+|\#[^\n]*)"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[^\W\d]\w*(?:\.[^\W\d]\w*)*)"
    r"|(?P<op>\*\*|==|\.\.\.|[-+*/^()\[\]{},:=&|])"
)
_GREEK = {"θ": "theta", "ϑ": "theta", "α": "alpha", "β": "beta", "ω": "w", "π": "pi", "φ": "phi"}
_DASHES = str.maketrans({"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "…": "..."})
_MODULES = ("np.", "numpy.", "math.", "sp.", "sympy.", "sym.")


def _tokens(text: str) -> list[tuple[str, str, int]]:
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ReadError(f"cannot read {text[at]!r} {_where(text, at)}")
        kind = str(match.lastgroup)
        if kind != "space":
            found.append((kind, match.group(), at))
        at = match.end()
    found.append(("end", "", len(text)))
    return found


def _where(text: str, at: int) -> str:
    start = max(0, at - 15)
    shown = text[start : at + 15].replace("\n", " ")
    return f"at character {at + 1}, near '{shown}'"


_LONGEST_NAME = 60


@lru_cache(maxsize=4096)
def _plain_name(name: str) -> str:
    """Return a name in the form that the symbol tables use: no module, no Greek, no underscore before digits."""
    for module in _MODULES:
        name = name.removeprefix(module)
    name = "".join(_GREEK.get(ch, ch) for ch in unicodedata.normalize("NFKC", name))
    return re.sub(r"_(?=\d)", "", name)


class _Parser:
    """Operator-precedence parser; depth is counted, so that no text can exhaust the stack."""

    def __init__(self, text: str, known: frozenset[str]) -> None:
        self.text, self.known = text, known
        self.tokens, self.at, self.depth = _tokens(text), 0, 0

    def peek(self) -> str:
        return self.tokens[self.at][1]

    def fail(self, message: str) -> ReadError:
        return ReadError(f"{message} {_where(self.text, self.tokens[self.at][2])}")

    def take(self, *texts: str) -> bool:
        kind, text, _ = self.tokens[self.at]
        if kind in ("op", "name") and text in texts:
            self.at += 1
            return True
        return False

    def expect(self, text: str) -> None:
        if not self.take(text):
            found = self.peek() or "the end"
            raise self.fail(f"expected '{text}', found {found!r},")

    def whole(self) -> Node:
        if self.tokens[0][0] == "end":
            raise ReadError("nothing is there")
        node = self.disjunction()
        if self.peek() == ",":  # a bare "a, b" is a list
            items = [node]
            while self.take(",") and self.tokens[self.at][0] != "end":
                items.append(self.disjunction())
            node = Node("list", tuple(items))
        if self.tokens[self.at][0] != "end":
            raise self.fail(f"did not expect {self.peek()!r}")
        return node

    def disjunction(self) -> Node:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.fail(f"brackets nest more than {MAX_DEPTH} deep")
        terms = [self.conjunction()]
        while self.take("or", "|"):
            terms.append(self.conjunction())
        self.depth -= 1
        return terms[0] if len(terms) == 1 else Node("or", tuple(terms))

    def conjunction(self) -> Node:
        terms = [self.relation()]
        while self.take("and", "&"):
            terms.append(self.relation())
        return terms[0] if len(terms) == 1 else Node("and", tuple(terms))

    def relation(self) -> Node:
        left = self.sum()
        if self.take("=", "=="):
            return Node("eq", (left, self.sum()))
        if self.take("in", "∈"):
            return Node("in", (left, self.sum()))
        return left

    def sum(self) -> Node:
        negative = self.sign()
        node = self.product()
        node = Node("neg", (node,)) if negative else node
        while self.peek() in ("+", "-"):
            op = self.peek()
            self.at += 1
            negative = self.sign()
            right = self.product()
            node = Node(op, (node, Node("neg", (right,)) if negative else right))
        return node

    def sign(self) -> bool:
        negative = False
        while self.peek() in ("+", "-") and self.tokens[self.at][0] == "op":
            negative ^= self.peek() == "-"
            self.at += 1
        return negative

    def product(self) -> Node:
        node = self.power()
        while True:
            if self.take("*"):
                node = Node("*", (node, self.signed_power()))
            elif self.take("/"):
                node = Node("/", (node, self.signed_power()))
            elif self.starts_factor():
                node = Node("*", (node, self.power()))
            else:
                return node

    def starts_factor(self) -> bool:
        kind, text, _ = self.tokens[self.at]
        return kind == "number" or (kind == "name" and text not in ("in", "and", "or")) or text == "("

    def signed_power(self) -> Node:
        return Node("neg", (self.power(),)) if self.sign() else self.power()

    def power(self) -> Node:
        base, exponents = self.primary(), []
        while self.take("**", "^"):
            negative = self.sign()
            exponent = self.primary()
            exponents.append(Node("neg", (exponent,)) if negative else exponent)
            if len(exponents) > MAX_DEPTH:
                raise self.fail(f"powers nest more than {MAX_DEPTH} deep")
        if exponents:
            tower = exponents.pop()
            while exponents:  # -a^-b^c: the sign of an exponent covers what stands above it
                below = exponents.pop()
                if below.kind == "neg":
                    tower = Node("neg", (Node("^", (below.args[0], tower)),))
                else:
                    tower = Node("^", (below, tower))
            return Node("^", (base, tower))
        return base

    def primary(self) -> Node:
        kind, text, _ = self.tokens[self.at]
        if kind == "number":
            self.at += 1
            return _number(text)
        if kind == "name" and text not in ("in", "and", "or"):
            self.at += 1
            return self.named(text)
        if self.take("..."):
            return Node("blank")
        if self.take("("):
            return self.bracketed(")", "group")
        if self.take("["):
            return self.bracketed("]", "list")
        if self.take("{"):
            return self.bracketed("}", "set")
        raise self.fail("expected a number, a symbol or a bracket, found " + (repr(text) if text else "the end"))

    def bracketed(self, close: str, kind: str) -> Node:
        items: list[Node] = []
        comma = False
        while not self.take(close):
            item = self.disjunction()
            if kind == "set" and self.take(":"):
                item = Node("pair", (item, self.disjunction()))
            items.append(item)
            if not self.take(","):
                self.expect(close)
                break
            comma = True
        if kind == "group":
            return items[0] if len(items) == 1 and not comma else Node("list", tuple(items))
        if kind == "set" and items and all(item.kind == "pair" for item in items):
            return Node("dict", tuple(items))
        if any(item.kind == "pair" for item in items):
            raise self.fail("a dictionary needs 'joint: values' throughout")
        return Node(kind, tuple(items))

    def named(self, raw: str) -> Node:
        if len(raw) > _LONGEST_NAME:
            raise self.fail(f"a name of {len(raw)} characters is no symbol of this field,")
        name = _plain_name(raw)
        if name in FUNCTIONS or (name.lower() in FUNCTIONS and name not in self.known):
            return self.function(FUNCTIONS.get(name) or FUNCTIONS[name.lower()])
        if name in ("Derivative", "Lambda") and self.peek() == "(":
            return self.bound(name)
        if name in self.known and self.peek() == "(" and self.text_at(1) == "t" and self.text_at(2) == ")":
            self.at += 3  # theta1(t), as dynamicsymbols prints it
            return Node("name", value=name)
        if name in CONTAINERS and self.peek() == "(":
            self.at += 1
            return _container(name, self.bracketed(")", "args").args, self)
        if name in UNDEFINED:
            raise self.fail(f"{name} is not an answer;")
        if name in BLANK:
            return Node("blank")
        if self.peek() == "(" and name not in self.known and not _shorthand(name, self.known):
            raise self.fail(f"the function {name!r} is not understood")
        angles = _shorthand(name, self.known)
        if angles:
            return Node("call", (_sum([Node("name", value=a) for a in angles]),), "cos" if name[0] in "cC" else "sin")
        return Node("name", value=name)

    def text_at(self, ahead: int) -> str:
        return self.tokens[min(self.at + ahead, len(self.tokens) - 1)][1]

    def bound(self, name: str) -> Node:
        """Read Derivative(theta1(t), t), which is the rate qd1, or Lambda(_n, …), whose _n is any whole number."""
        self.at += 1
        args = self.bracketed(")", "args").args
        if name == "Derivative" and len(args) == 2 and args[0].kind == "name":
            match = re.fullmatch(r"(?:theta|d)(\d+)", str(args[0].value))
            if match is not None:
                return Node("name", value=f"qd{match.group(1)}")
        if name == "Lambda" and len(args) == 2 and args[0].kind == "name":
            return renamed(args[1], str(args[0].value), "k")
        raise self.fail(f"this {name} is not understood")

    def function(self, name: str) -> Node:
        power = None
        if self.peek() in ("^", "**"):  # sin^2(x)
            self.at += 1
            power = self.primary()
        if not self.take("("):
            raise self.fail(f"expected '(' after {name},")
        args = self.bracketed(")", "args").args
        if len(args) != ARITY.get(name, 1):
            raise self.fail(f"{name} takes {ARITY.get(name, 1)} argument, not {len(args)},")
        call = Node("call", args, name)
        return Node("^", (call, power)) if power is not None else call


def _sum(nodes: list[Node]) -> Node:
    total = nodes[0]
    for node in nodes[1:]:
        total = Node("+", (total, node))
    return total


@lru_cache(maxsize=4096)
def _shorthand(name: str, known: frozenset[str]) -> tuple[str, ...]:
    """Return the angles of c12 or S_23, or nothing where the name is a symbol of the problem or no shorthand."""
    match = re.fullmatch(r"[csCS]_?\{?(\d{1,4})\}?", name)
    if match is None or name in known:
        return ()
    angles = tuple(f"theta{digit}" for digit in match.group(1))
    return angles if not known or all(angle in known for angle in angles) else ()


def _number(text: str) -> Node:
    mantissa, _, exponent = text.lower().partition("e")
    if len(mantissa) > 1000 or len(exponent) > 4 or abs(int(exponent or 0)) > 400:
        raise ReadError(f"the number {text[:20]}… is out of range")
    kind = "decimal" if "." in mantissa or exponent else "number"
    return Node(kind, value=Fraction(text))


def _container(name: str, args: tuple[Node, ...], parser: _Parser) -> Node:
    if name in ("Eq", "Equality") and len(args) == 2:
        return Node("eq", args)
    if name == "Or" and args:
        return Node("or", args)
    if name == "And" and args:
        return Node("and", args)
    if name in ("FiniteSet", "Union"):
        return Node("set", args)
    if name == "ImageSet" and len(args) == 2 and args[1].value == "Integers":
        return args[0]
    if name in ("Rational", "Pow") and len(args) == 2:
        return Node("/" if name == "Rational" else "^", args)
    if len(args) == 1:
        return args[0]
    if name == "Tuple":
        return Node("list", args)
    raise parser.fail(f"{name} with {len(args)} arguments is not understood")


def read(text: str, known: Iterable[str] = ()) -> Node:
    """Return the tree of `text`; `known` are the names of the problem's symbols, which win over any shorthand.

    Raises ReadError with the place and what was expected. Time and memory grow with the length only.

    >>> read("2*a1 + c12").kind
    '+'
    >>> read("sin(theta1")
    Traceback (most recent call last):
    exercises.formula.expression.ReadError: expected ')', found 'the end', at character 11, near 'sin(theta1'
    """
    if len(text) > MAX_LENGTH:
        raise ReadError(f"the answer is {len(text)} characters long; more than {MAX_LENGTH} are not read")
    return _read(text, frozenset(known))


@lru_cache(maxsize=4)
def _read(text: str, known: frozenset[str]) -> Node:
    """Return the tree; an answer is often read twice in a row, for its symbols and for what it says."""
    return _Parser(text.translate(_DASHES), known).whole()


def renamed(node: Node, old: str, new: str) -> Node:
    """Return the tree with one name put for another."""
    if node.kind == "name":
        return Node("name", value=new) if node.value == old else node
    return Node(node.kind, tuple(renamed(arg, old, new) for arg in node.args), node.value)


def names(node: Node) -> set[str]:
    """Return the names in a tree that are not constants."""
    found, stack = set(), [node]
    while stack:
        top = stack.pop()
        if top.kind == "name" and top.value not in CONSTANTS:
            found.add(top.value)
        stack.extend(top.args)
    return found


def digits_of_decimals(node: Node) -> int:
    """Return how many significant digits the longest decimal in a tree has; 0 without one.

    >>> digits_of_decimals(read("0.50*a1 + 3.14159"))
    6
    """
    most, stack = 0, [node]
    while stack:
        top = stack.pop()
        if top.kind == "decimal":
            whole = top.value
            while whole.denominator != 1:
                whole *= 10
            most = max(most, len(str(abs(whole.numerator)).rstrip("0")))
        stack.extend(top.args)
    return most


def has_blank(node: Node) -> bool:
    """Tell whether a placeholder is still there somewhere in the tree."""
    stack = [node]
    while stack:
        top = stack.pop()
        if top.kind == "blank":
            return True
        stack.extend(top.args)
    return False


def _is_column(node: Node) -> bool:
    """Tell whether a node is [[a], [b], …], a column vector as SymPy writes it."""
    one_each = all(item.kind == "list" and len(item.args) == 1 and item.args[0].kind != "list" for item in node.args)
    return node.kind == "list" and len(node.args) > 1 and one_each


def as_matrix(node: Node) -> list[list[Node]]:
    """Return rows of scalars: a list of rows, a list of scalars (a column), or a scalar (1 x 1).

    Raises ReadError where rows differ in length or lists nest deeper.
    """
    if node.kind != "list":
        return [[node]]
    if node.args and all(_is_column(item) for item in node.args):  # a list of column vectors, side by side
        columns = [[entry.args[0] for entry in item.args] for item in node.args]
        if len({len(column) for column in columns}) == 1:
            return [list(row) for row in zip(*columns, strict=True)]
    rows = [list(item.args) if item.kind == "list" else [item] for item in node.args]
    if not rows:
        raise ReadError("the list is empty")
    if len({len(row) for row in rows}) != 1:
        raise ReadError(f"the rows of the matrix have different lengths: {', '.join(str(len(row)) for row in rows)}")
    if any(entry.kind in ("list", "set", "dict") for row in rows for entry in row):
        raise ReadError("an entry of the matrix is itself a list")
    return rows
