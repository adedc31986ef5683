"""Parse text into a tree of plain nodes by a grammar and a whitelist; the text is never executed.

The grammar is the notation of Python and SymPy, extended by what people type: `^` for powers, `2a1`, theta as a Greek
letter, `theta_1`, and the robotics shorthand c12 = cos(theta1 + theta2). Lists, sets, dictionaries and equations are
parsed, too, because some answers consist of them. The caller decides what a node means as a scalar, a matrix or a set
of conditions.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

from qdot.exercises.formula import names, trees
from qdot.exercises.formula.algebra import ONE, ZERO, number
from qdot.exercises.formula.metres import METRE, remove_metres
from qdot.exercises.formula.names import ARITY, FUNCTIONS, SHORTHAND, NamePart, normalize_name, split_name
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.products import evaluate_matrices
from qdot.exercises.formula.trees import EQUATION_CHAIN, Node, ParseError, combine_from_left, find_names, make_rows
from qdot.exercises.formula.vocabulary import LIMITS, VOCABULARY, compile_pattern

MAX_DEPTH = LIMITS["depth"]
MAX_LENGTH, MAX_PLUS_MINUS_SIGNS = LIMITS["characters"], LIMITS["either"]
MAX_DIAGONAL = LIMITS["diagonal"]

_CONTAINERS: dict[str, str] = VOCABULARY["containers"]
"""The meaning of each SymPy, NumPy or Python call that is not a function of numbers."""
_TWO_ARGUMENT_KINDS = ("eq", "in", "/", "^")
"""Meanings of calls that need exactly two arguments."""
_BINDING_CALLS: dict[str, str] = VOCABULARY["bound"]
"""Calls with a variable of their own, such as Derivative and Lambda."""
_CONNECTIVES: list[str] = VOCABULARY["words"]
"""Names that connect two conditions, and so are not factors of a product."""

_TOKEN = re.compile("|".join(
    f"(?P<{kind}>{VOCABULARY['patterns'][name]})"
    for kind, name in (("space", "passed"), ("number", "number"), ("name", "name"), ("op", "operator"))
))  # fmt: skip

_NEVER_INSIDE_BARS = ("=", "==", ",", ";", ":", "&")
_AFTER_BARS = ("*", "/", "^", "**", "=", "==", ")", "]", "}", ",", ";")
"""Tokens that can't occur inside a factor in bars, and tokens after its second bar that can't begin an alternative."""
_BEFORE_STATEMENT = (",", ";", "and", "&", "or", "[", "(", "{")
_OR_WORDS = ("or", "|")
"""Words that add nothing to the comma before them. This holds between conditions only, not between vector entries."""

_BRACKETS = {"(": (")", "group"), "[": ("]", "list"), "{": ("}", "set")}
"""For each opening bracket its closing bracket and the meaning of its content."""
_DEPTH_CHANGES = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}


def _tokenize(text: str) -> list[tuple[str, str, int]]:
    tokens: list[tuple[str, str, int]] = []
    position, depth = 0, 0
    for match in _TOKEN.finditer(text):
        if match.start() != position:
            break
        if match.lastgroup != "space":
            tokens.append((str(match.lastgroup), match.group(), position))
            depth += _DEPTH_CHANGES.get(match.group(), 0)
            if depth > MAX_DEPTH:  # checked here, so that later tokens cost no time
                raise ParseError(f"brackets are nested more than {MAX_DEPTH} deep {_describe_position(text, position)}")
        position = match.end()
    if position < len(text):
        example = "write a formula as a1*cos(theta1), a matrix as [[a, b], [c, d]], a condition as theta2 = 0"
        raise ParseError(f"unexpected {text[position]!r} {_describe_position(text, position)}; {example}")
    tokens.append(("end", "", position))
    return tokens


def _describe_position(text: str, position: int) -> str:
    start = max(0, position - 15)
    nearby = (" " if ch.isspace() else ch for ch in text[start : position + 15])
    printable = "".join(ch if ch.isprintable() else "\N{REPLACEMENT CHARACTER}" for ch in nearby)
    return f"(at character {position + 1}, near '{printable}')"


class _Parser:
    """An operator-precedence parser that limits the nesting depth, so that no text can exhaust the stack."""

    def __init__(self, text: str, known_symbols: frozenset[str]) -> None:
        self.text, self.known_symbols = text, known_symbols
        self.tokens, self.position, self.depth = self.translate_words(_tokenize(text)), 0, 0
        if (signs := sum(text == "±" for _, text, _ in self.tokens)) > MAX_PLUS_MINUS_SIGNS:
            raise ParseError(f"the answer has {signs} signs ±, and each doubles the cases; write out the cases")
        self.bare_argument_end = -1
        """The index of the token after the last function argument without brackets; -1 if there is none."""
        self.joined_product: Node | None = None
        """The last parsed product of names written without spaces or brackets, as in a1c2."""
        self.in_bars = False
        """Whether the next bar ends an absolute value."""
        self.braces_are_lists = False
        """Whether a function had square brackets, as in Mathematica, where {a, b} is a list."""

    def translate_words(self, tokens: list[tuple[str, str, int]]) -> list[tuple[str, str, int]]:
        """Return the tokens with words of other languages replaced, such as the German word for "or"."""
        translated = []
        for kind, text, at in tokens:
            word = _SYNONYMS.get(text) if kind == "name" and text not in self.known_symbols else None
            is_dotted = word is None and kind == "name" and "." in text
            if word:
                translated.append(("number" if word.isdigit() else "name" if word.isalpha() else "op", word, at))
            elif is_dotted and (factors := names.split_dotted_product(text, self.known_symbols)):
                start = at
                for factor in factors:  # a1.a2.sin
                    translated += [("op", "*", start), ("name", factor, start)]
                    start += len(factor) + 1
                del translated[-2 * len(factors)]
            elif word is None:
                translated.append((kind, text, at))
        return translated

    def peek(self, ahead: int = 0) -> str:
        return self.tokens[min(self.position + ahead, len(self.tokens) - 1)][1]

    def parse_error(self, message: str) -> ParseError:
        return ParseError(f"{message} {_describe_position(self.text, self.tokens[self.position][2])}")

    def take(self, *texts: str) -> bool:
        kind, text, _ = self.tokens[self.position]
        is_next = kind in ("op", "name") and text in texts
        self.position += is_next
        return is_next

    def expect(self, text: str) -> None:
        if not self.take(text):
            raise self.parse_error(f"expected '{text}', found {repr(self.peek()) if self.peek() else 'the end'}")

    def parse(self) -> Node:
        if self.tokens[0][0] == "end":
            raise ParseError("the text is empty")
        self.skip_lambda_head()
        tree = self.parse_to_end()
        if self.braces_are_lists:
            tree = trees.fold(tree, _make_list_of_set)
        is_metre = METRE not in self.known_symbols and any(text == METRE for _, text, _ in self.tokens)
        return evaluate_matrices(remove_metres(tree) if is_metre else tree)

    def parse_to_end(self) -> Node:
        """Return the tree of all remaining tokens."""
        rows, has_comma = self.parse_rows("")
        if self.tokens[self.position][0] != "end":
            raise self.parse_error(f"unexpected {self.peek()!r}")
        if not rows[0]:  # semicolons alone
            raise ParseError("the text is empty")
        if len(rows) > 1 and any(len(row) > 1 for row in rows):
            return make_rows(rows)
        items = [entry for row in rows for entry in row]  # of a; b, too
        if any(item.kind == "pair" for item in items):  # x: a, y: b
            return self.make_dictionary(items)
        return Node("list", tuple(items)) if has_comma or len(items) > 1 else items[0]

    def parse_rows(self, closing: str) -> tuple[list[list[Node]], bool]:
        """Parse entries up to the closing bracket; return them in rows, and whether there was a comma.

        Commas separate entries, semicolons separate rows. An entry may have a name, as in x: a, in braces or if
        `closing` is empty.
        """
        rows: list[list[Node]] = [[]]
        has_comma = False
        while not self.take_closing(closing):
            if self.take(";"):
                rows.append([])
                continue
            entry = self.parse_disjunction()
            if not closing and self.is_comma_before_and() and self.is_condition(entry):
                entry = self.join_conditions(entry, rows == [[]])
            if closing in ("", "}") and self.take(":"):
                entry = Node("pair", (entry, self.parse_disjunction()))
            rows[-1].append(entry)
            if self.take(","):
                has_comma = True
                first = next(row[0] for row in rows if row)
                if not closing and self.take("and", "&", *(_OR_WORDS if self.is_condition(first) else ())):
                    self.require_more()
            elif self.peek() != ";":
                if closing:
                    self.expect(closing)
                break
        return [row for row in rows if row] or [[]], has_comma

    def require_more(self) -> None:
        if self.tokens[self.position][0] == "end":
            raise self.parse_error("expected a number, a symbol or a bracket, found the end")

    def is_comma_before_and(self) -> bool:
        return self.peek() == "," and self.peek(1) in ("and", "&")

    def is_condition(self, node: Node) -> bool:
        """Return whether a node is a condition on a symbol of the problem; x = 1 only names an entry."""
        if node.kind in ("and", "or"):
            return all(map(self.is_condition, node.args))
        return node.kind in ("eq", "in") and not find_names(node.args[0]).isdisjoint(self.known_symbols)

    def join_conditions(self, first: Node, is_alone: bool) -> Node:
        """Parse "A, and B" as "A and B" if B is a condition.

        Raises ParseError if further commas or alternatives make this ambiguous. Before a value, as in theta2 = 0, and
        pi, the comma separates the entries of a list.
        """
        start = self.position
        terms = list(first.args) if first.kind == "and" else [first]
        while self.is_comma_before_and():
            position = self.position
            self.position += 2
            term = self.parse_relation()
            if not self.is_condition(term):
                self.position = position
                break
            terms.append(term)
        if self.position == start:
            return first
        if not is_alone or self.peek() in (",", "or", "|") or first.kind == "or":
            self.position = start
            example = "(theta1 = 0 or theta2 = 0) and theta3 = 0"
            raise self.parse_error(f"a comma before 'and' is ambiguous; use brackets and no comma, as in {example}")
        return Node("and", tuple(terms))

    def take_closing(self, closing: str) -> bool:
        return self.take(closing) if closing else self.tokens[self.position][0] == "end"

    def make_dictionary(self, items: Sequence[Node]) -> Node:
        pairs: list[list[Node]] = []
        for item in items:
            if item.kind == "pair":
                pairs.append([*item.args])
            elif pairs and _is_value(item):  # theta2: 0, pi
                pairs[-1].append(item)
            else:
                advice = "write conditions without words before them"
                raise self.parse_error(f"every entry of a dictionary needs the form 'joint: values'; {advice}")
        assignments = ((name, values[0] if len(values) == 1 else Node("set", tuple(values))) for name, *values in pairs)
        return Node("dict", tuple(Node("pair", pair) for pair in assignments))

    def skip_lambda_head(self) -> None:
        """Skip the head of a Python function, lambda theta1, theta2: …; the expression it returns is the answer."""
        if self.take("lambda"):
            while self.tokens[self.position][0] == "name":
                self.position += 1
                if not self.take(","):
                    break
            self.expect(":")

    @contextmanager
    def count_nesting(self, construct: str = "brackets") -> Iterator[None]:
        """Count the nesting depth of brackets, bars and functions. Raises ParseError beyond MAX_DEPTH."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.parse_error(f"{construct} are nested more than {MAX_DEPTH} deep")
        yield
        self.depth -= 1

    def parse_disjunction(self) -> Node:
        with self.count_nesting():
            terms = [self.parse_conjunction()]
            while self.take("or", "|"):
                terms.append(self.parse_conjunction())
        return terms[0] if len(terms) == 1 else Node("or", tuple(terms))

    def parse_conjunction(self) -> Node:
        terms = [self.parse_relation()]
        while self.take("and", "&"):
            terms.append(self.parse_relation())
        return terms[0] if len(terms) == 1 else Node("and", tuple(terms))

    def parse_relation(self) -> Node:
        sides = [self.parse_modulo(self.parse_sum())]
        while self.take("=", "=="):
            sides.append(self.parse_right_side())
        if len(sides) > 2 and sides[0].kind == "name" and sides[1].kind == "list":
            del sides[0]  # P = [x; y] = […]
        equations = tuple(Node("eq", pair) for pair in pairwise(sides))
        if len(equations) > 1:  # theta1 = theta2 = 0
            return Node("and", equations, EQUATION_CHAIN)
        if not equations and self.take("in"):
            return Node("in", (sides[0], self.parse_modulo(self.parse_sum())))
        return equations[0] if equations else sides[0]

    def parse_right_side(self) -> Node:
        """Parse the right side of an equation: one value, or several, as in theta2 = 0 or pi."""
        alternatives = [self.parse_modulo(self.parse_sum())]
        while self.peek() in ("or", "and", "|", "&"):
            position = self.position
            self.position += 1
            alternative = self.parse_modulo(self.parse_sum()) if self.tokens[self.position][0] != "end" else None
            if alternative is None or self.peek() in ("=", "==", "in", ":") or not _is_value(alternative):
                self.position = position  # another condition begins there
                break
            alternatives.append(alternative)
        return alternatives[0] if len(alternatives) == 1 else Node("set", tuple(alternatives))

    def parse_modulo(self, value: Node) -> Node:
        """Parse "0 mod pi" or "0 (mod pi)": the value plus any whole multiple of pi."""
        bracket = self.peek() == "(" and self.peek(1) in _MODULO_WORDS
        if not bracket and self.peek() not in _MODULO_WORDS:
            return value
        self.position += 2 if bracket else 1
        if self.peek(-1) == "%" and self.tokens[self.position][0] in ("end", "op") and self.peek() != "(":
            raise self.parse_error("percentages are not allowed; write a decimal such as 0.5")
        step = Node("*", (_ANY_WHOLE_NUMBER, self.parse_sum()))
        if bracket:
            self.expect(")")
        if value.kind in ("list", "set"):
            return Node(value.kind, tuple(Node("+", (term, step)) for term in value.args))
        return Node("+", (value, step))

    def parse_sum(self) -> Node:
        if self.take("±"):
            value = self.parse_product()
            node = Node("set", (value, Node("neg", (value,))))
        else:
            node = _apply_sign(self.parse_sign(), self.parse_product())
        while self.peek() in ("+", "-", "±"):
            op = self.peek()
            follows_bare_argument = self.position == self.bare_argument_end
            self.position += 1
            is_negative, term = self.parse_sign(), self.parse_product()
            if follows_bare_argument and term.kind == "name" and _is_angle(str(term.value)):
                message = f"a function without brackets comes before {op} {term.value}"
                raise self.parse_error(f"{message}; put its argument in brackets, as in sin(theta1 + theta2)")
            term = _apply_sign(is_negative, term)
            alternatives = (Node("+", (node, term)), Node("-", (node, term)))
            node = Node("set", alternatives) if op == "±" else Node(op, (node, term))
        return node

    def parse_sign(self) -> bool:
        is_negative = False
        while self.peek() in ("+", "-") and self.tokens[self.position][0] == "op":
            is_negative ^= self.peek() == "-"
            self.position += 1
        return is_negative

    def parse_product(self) -> Node:
        node = self.parse_power()
        divisor_end = -1
        while True:
            kind, text, _ = self.tokens[self.position]
            if text in ("*", "/", "."):
                self.position += 1
                start = self.position
                node = Node(text if text == "/" else "*", (node, _apply_sign(self.parse_sign(), self.parse_power())))
                is_name = text == "/" and self.is_single_name(start) and node.args[1].kind == "name"
                divisor_end = self.position if is_name else -1
            elif kind == "number" == self.tokens[self.position - 1][0]:
                raise self.parse_error("there is no operator between two numbers")  # 1 000, 1.2.3: no product is meant
            elif kind == "number" and text.startswith("."):  # a1.2
                raise self.parse_error(f"the point in {text} is ambiguous; write *{text[1:]} or *0{text}")
            elif text == "(" and self.peek(1) in _MODULO_WORDS:
                return node
            elif kind == "name" and self.is_unit(text):
                self.position += 1
                node = _convert_unit(node, text)
            elif kind == "name" and text not in _CONNECTIVES and self.position == divisor_end:
                advice = "put the denominator in brackets, as in a/(b*c), or write a/b*c"
                raise self.parse_error(f"/{self.peek(-1)} {text} is ambiguous; {advice}")
            elif text == "|" and self.begins_absolute_value():
                node = Node("*", (node, self.parse_power()))
            elif text == "[" and self.is_row_below(node):
                node = self.parse_row_below(node)
            elif kind == "number" or text in ("(", "[") or (kind == "name" and text not in _CONNECTIVES):
                node = Node("*", (node, self.parse_factor()))
            else:
                return node

    def is_single_name(self, start: int) -> bool:
        """Return whether the divisor, which begins at token `start` and has just been parsed, is a single name."""
        kind, text, _ = self.tokens[start]
        return kind == "name" and self.position == start + 1 and not text.startswith(_PI_NAMES)

    def parse_factor(self) -> Node:
        """Parse a factor that has no sign. [0] is refused, because in Python it selects an entry."""
        is_bracket = self.peek() == "["
        start, node = self.position, self.parse_power()
        if is_bracket and node.kind == "list" and len(node.args) == 1 and node.args[0].kind in ("number", "neg"):
            self.position = start
            raise self.parse_error("unexpected '['; entries of a vector have names such as a1 or theta2")
        return node

    def begins_absolute_value(self) -> bool:
        """Return whether this bar begins an absolute value, as in a1|s2|, rather than an alternative, as in 0 | pi."""
        if self.in_bars:
            return False
        depth, at, has_symbol = 0, self.position + 1, False
        while self.tokens[at][0] != "end" and not (self.tokens[at][1] == "|" and depth == 0):
            kind, text, _ = self.tokens[at]
            depth += _DEPTH_CHANGES.get(text, 0)
            if depth < 0 or (depth == 0 and (text in _NEVER_INSIDE_BARS or text in _CONNECTIVES)):
                return False
            has_symbol |= kind == "name" and not text.startswith(_PI_NAMES)
            at += 1
        if self.tokens[at][0] == "end" or not has_symbol:
            return False
        first, last = self.tokens[self.position + 1], self.tokens[at - 1]
        is_tight = first[2] == self.tokens[self.position][2] + 1 and last[2] + len(last[1]) == self.tokens[at][2]
        return is_tight or self.tokens[at + 1][0] == "end" or self.tokens[at + 1][1] in _AFTER_BARS

    def is_row_below(self, node: Node) -> bool:
        """Return whether the next list is another row below `node`, as calculators write [a, b][c, d]."""
        return node.kind == "list" and len(node.args) > 1 and self.peek(-1) == "]" and not self.is_column_ahead()

    def is_column_ahead(self) -> bool:
        """Return whether the list that begins here has rows, as in [a; b] or [[a, b], [c, d]]."""
        return self.peek(1) == "[" or (1, ";") in self.next_bracket_tokens()

    def next_bracket_tokens(self) -> list[tuple[int, str]]:
        """Return (depth, text) of each token from the bracket that begins here to its closing bracket."""
        depth, tokens_with_depth = 0, list[tuple[int, str]]()
        for at in range(self.position, len(self.tokens)):
            depth += _DEPTH_CHANGES.get(self.tokens[at][1], 0)
            tokens_with_depth.append((depth, self.tokens[at][1]))
            if depth == 0:
                break
        return tokens_with_depth

    def parse_row_below(self, node: Node) -> Node:
        """Parse the next list and return `node` with it as another row."""
        self.take("[")
        row = self.parse_bracket("]", "list")
        rows = node.args if all(arg.kind == "list" for arg in node.args) else (node,)
        if len(rows) >= MAX_DIAGONAL or any(len(other_row.args) != len(row.args) for other_row in rows):
            raise self.parse_error("two lists of different lengths follow each other")
        return Node("list", (*rows, row))

    def is_unit(self, text: str) -> bool:
        """Return whether a name after a number is a unit.

        Angles have one only at the end of a product, as in 0.25 rad; lengths also before a factor, as in 25 cm. The
        name m is decided later, when the whole formula is known (`metres`).
        """
        if text not in _UNITS or text in self.known_symbols or text in VOCABULARY["whole_numbers"]:
            return False
        kind, previous, _ = self.tokens[self.position - 1]
        if kind != "number" and previous not in VOCABULARY["before_whole_numbers"]:
            return False
        next_kind, following, _ = self.tokens[min(self.position + 1, len(self.tokens) - 1)]
        if text in VOCABULARY["lengths"]:
            return following not in _UNIT_OPERATORS
        return following not in _FACTOR_CONTINUATIONS and (next_kind in ("op", "end") or following in _CONNECTIVES)

    def parse_power(self) -> Node:
        base = self.parse_primary()
        if self.tokens[self.position][1] not in ("**", "^"):
            return base
        exponents, applies_to_last_factor = [], base is self.joined_product
        while self.take("**", "^"):
            exponents.append(_apply_sign(self.parse_sign(), self.parse_primary()))
            if len(exponents) > MAX_DEPTH:
                raise self.parse_error(f"powers are nested more than {MAX_DEPTH} deep")
        if base.kind == "list" and len(exponents) == 1 and exponents[0].value in VOCABULARY["transposed"]:
            return _transpose(base)
        tower = exponents.pop()
        while exponents:  # -a^-b^c: the sign of an exponent applies to the whole power above it
            exponent = exponents.pop()
            is_negative = exponent.kind == "neg"
            tower = _apply_sign(is_negative, Node("^", (exponent.args[0] if is_negative else exponent, tower)))
        if applies_to_last_factor:  # a1c2^2
            return Node("*", (base.args[0], Node("^", (base.args[1], tower))))
        return Node("^", (base, tower))

    def parse_primary(self) -> Node:
        kind, text, _ = self.tokens[self.position]
        if kind == "number":
            self.position += 1
            return _parse_number(text)
        if kind == "name" and text not in _CONNECTIVES:
            self.position += 1
            return self.parse_name(text)
        if self.take("..."):
            return Node("blank")
        if self.take("(", "[", "{"):
            return self.parse_bracket(*_BRACKETS[text])
        if self.take("|"):
            return self.parse_absolute_value()
        raise self.parse_error("expected a number, a symbol or a bracket, found " + (repr(text) if text else "the end"))

    def parse_absolute_value(self) -> Node:
        """Parse |a1*sin(theta2)| up to its second bar; a bar between two conditions means "or" instead."""
        with self.count_nesting():
            self.in_bars, was_in_bars = True, self.in_bars
            inner = self.parse_sum()
            self.in_bars = was_in_bars
            self.expect("|")
        return _make_call(FUNCTIONS["abs"], (inner,))

    def parse_bracket(self, closing: str, kind: str) -> Node:
        self.in_bars, was_in_bars = False, self.in_bars
        rows, has_comma = self.parse_rows(closing)
        self.in_bars, self.joined_product = was_in_bars, None
        items = rows[0]
        if len(rows) > 1:  # [a, b; c, d], or (a; b), {0; pi}
            is_column = kind in ("group", "set") and all(len(row) == 1 for row in rows)
            return Node("list", tuple(row[0] for row in rows)) if is_column else make_rows(rows)
        if kind == "group":
            return items[0] if len(items) == 1 and not has_comma else Node("list", tuple(items))
        return self.make_dictionary(items) if any(item.kind == "pair" for item in items) else Node(kind, tuple(items))

    def parse_name(self, typed_name: str) -> Node:
        if len(typed_name) > names.MAX_NAME_LENGTH:
            raise self.parse_error(f"a name of {len(typed_name)} characters is not a symbol")
        if typed_name.endswith(".diff") and self.peek() == "(":  # theta1.diff(t)
            variable = split_name(typed_name.removesuffix(".diff"), self.known_symbols)[0]
            return self.parse_binding_call("Derivative", _make_part_node(variable))
        name = normalize_name(typed_name)
        is_bracket_next = self.peek() == "("
        if is_bracket_next and name in _BINDING_CALLS:
            return self.parse_binding_call(name)
        may_depend_on_time = name in self.known_symbols or _JOINT_PATTERN.fullmatch(name) is not None
        if is_bracket_next and may_depend_on_time and self.peek(1) == "t" and self.peek(2) == ")":
            self.position += 3  # theta1(t), as dynamicsymbols prints it
            return _make_part_node(split_name(typed_name, self.known_symbols)[0])
        if is_bracket_next and name in _CONTAINERS:
            self.position += 1
            return _make_container(name, self.parse_bracket(")", "args").args, self)
        if name in VOCABULARY["undefined"]:
            raise self.parse_error(f"{name} is not an answer{VOCABULARY['undefined_because'].get(name, '')}")
        if name in VOCABULARY["blank"]:
            return Node("blank")
        if name in SHORTHAND and name not in self.known_symbols and self.is_angle_ahead():
            return self.parse_shorthand(name)
        pieces = split_name(typed_name, self.known_symbols)
        symbol = pieces[0].names[0] if len(pieces) == 1 and pieces[0].kind == "name" else ""
        if is_bracket_next and symbol and not {name, symbol} & self.known_symbols and symbol not in _BEFORE_BRACKETS:
            after_bracket = self.position + len(self.next_bracket_tokens())
            if self.begins_statement() and after_bracket < len(self.tokens) and self.tokens[after_bracket][1] == "=":
                self.position = after_bracket  # J(q) = …
                return Node("name", value=symbol)
            advice = _NEGATION_ADVICE if name in VOCABULARY["negations"] else _UNKNOWN_FUNCTION_ADVICE
            raise self.parse_error(f"the function {name!r} {advice}")
        product = self.multiply_parts(pieces)
        if pieces[-1].kind in FUNCTIONS and _ANGLE_SHORTHAND_PATTERN.search(name):
            self.bare_argument_end = self.position
        return product

    def begins_statement(self) -> bool:
        """Return whether the last parsed name begins a statement."""
        return self.position == 1 or self.tokens[self.position - 2][1] in _BEFORE_STATEMENT

    def is_angle_ahead(self) -> bool:
        """Return whether an angle or a bracket follows, perhaps after a power: c theta1, s^2(theta1)."""
        ahead = 0 if self.peek() not in ("^", "**") else 4 if self.peek(1) == "(" else 2
        kind, text, _ = self.tokens[min(self.position + ahead, len(self.tokens) - 1)]
        piece = split_name(text, self.known_symbols)[0] if kind == "name" else None
        return text == "(" or (piece is not None and (piece.kind == "sum" or _is_angle(piece.names[0])))

    def parse_shorthand(self, name: str) -> Node:
        """Parse c or s as the cosine or sine of the angle that follows.

        Raises ParseError for an argument that is not an angle, such as S(1), which is SymPy's number 1.
        """
        start, function = self.position, SHORTHAND[name]
        call = self.parse_function(function)
        if not any(map(_is_angle, find_names(call))):
            self.position = start
            advice = f"as in {name}(theta1); write {function}(…)"
            raise self.parse_error(f"{name} means {function} only before an angle, {advice}")
        return call

    def multiply_parts(self, pieces: Sequence[NamePart]) -> Node:
        """Return the product of names written without spaces; a function applies to the name after it."""
        factors: list[Node] = []
        remaining = list(pieces)
        while remaining:
            piece = remaining.pop(0)
            if piece.kind != "function":
                factors.append(_make_part_node(piece))
            elif remaining and remaining[0].kind != "function" and piece.names[0] not in ARITY:
                factors.append(_make_call(piece.names[0], (_make_part_node(remaining.pop(0)),)))
                self.bare_argument_end = self.position if not remaining else -1
            elif not remaining:
                factors.append(self.parse_function(piece.names[0]))
            else:
                raise self.parse_error(f"{piece.names[0]} has no argument")
        product = combine_from_left("*", factors)
        if len(factors) > 1:
            self.joined_product = product
        return product

    def parse_binding_call(self, name: str, *first_arguments: Node) -> Node:
        """Parse Derivative(theta1(t), t) as the rate qd1, and Lambda(_n, …) with any whole number as _n.

        `first_arguments` has the argument that was typed before the name, as in theta1.diff(t).
        """
        self.position += 1
        args = first_arguments + self.parse_bracket(")", "args").args
        is_rate = _BINDING_CALLS[name] == "rate"
        joint = _JOINT_PATTERN.fullmatch(str(args[0].value)) if args and args[0].kind == "name" else None
        if is_rate and len(args) in (1, 2) and joint is not None:
            return Node("name", value=f"qd{joint.group(1)}")
        if not is_rate and len(args) == 2 and args[0].kind == "name":
            return trees.replace_names(args[1], {args[0].value: _ANY_WHOLE_NUMBER})
        raise self.parse_error(f"this form of {name} is not supported")

    def parse_function(self, name: str) -> Node:
        power = None
        with self.count_nesting("functions"):
            if self.take("^", "**"):  # sin^2(x)
                power = _apply_sign(self.parse_sign(), self.parse_primary())
            if self.take("("):
                args = self.parse_bracket(")", "args").args
            elif self.take("["):
                args = self.parse_bracket("]", "args").args
                self.braces_are_lists = True
            else:
                args = (self.parse_bare_argument(name),)
        if len(args) != ARITY.get(name, 1):
            raise self.parse_error(f"wrong number of arguments of {name}: {len(args)} instead of {ARITY.get(name, 1)}")
        if power is not None and power == _MINUS_ONE and name in VOCABULARY["inverses"]:
            return _make_call(VOCABULARY["inverses"][name], args)  # sin^-1(x) is the arc sine
        call = _make_call(name, args)
        return Node("^", (call, power)) if power is not None else call

    def parse_bare_argument(self, name: str) -> Node:
        """Parse the argument of a function without brackets: a number and one name, as in sin 2 theta1."""
        factors = []
        if self.tokens[self.position][0] == "number":
            factors.append(_parse_number(self.peek()))
            self.position += 1
        if self.tokens[self.position][0] == "name" and self.peek() not in _CONNECTIVES:
            if any(piece.kind != "name" for piece in split_name(self.peek(), self.known_symbols)[1:]):
                raise self.parse_error(f"expected '(' after {name}")  # sin theta1cos(theta2)
            self.position += 1
            factors.append(self.parse_name(self.peek(-1)))
        if not factors or self.peek() in ("/", "^", "**"):
            raise self.parse_error(f"expected '(' after {name}")
        self.bare_argument_end = self.position
        return combine_from_left("*", factors)


_JOINT_PATTERN = compile_pattern("joint")
_ANGLE_PATTERN, _ANGLE_SHORTHAND_PATTERN = compile_pattern("angle"), compile_pattern("short_of_angle")
_ANY_WHOLE_NUMBER = Node("name", value=VOCABULARY["whole_numbers"][0])
_NEGATION_ADVICE = "is not supported; write the equations that hold, not those that don't"
_UNKNOWN_FUNCTION_ADVICE = "is unknown; use sin, cos, tan, sqrt, exp or atan2"
_MODULO_WORDS: list[str] = VOCABULARY["modulo"]
_SYNONYMS: dict[str, str] = VOCABULARY["synonyms"]
_PI_NAMES = tuple(VOCABULARY["before_whole_numbers"])
_BEFORE_BRACKETS = ("pi", "I", *VOCABULARY["whole_numbers"])
"""Names that are multiplied by the bracket after them, because nobody gives functions these names."""
_UNITS: dict[str, str] = VOCABULARY["units"]
_UNIT_OPERATORS = ("/", "^", "**")
_FACTOR_CONTINUATIONS = ("*", "(", *_UNIT_OPERATORS)
"""Tokens after a name that show that it is a factor rather than a unit at the end of a product."""


def _make_list_of_set(node: Node, args: Sequence[Node]) -> Node:
    return Node("list" if node.kind == "set" else node.kind, tuple(args), node.value)


def _is_angle(name: str) -> bool:
    return _ANGLE_PATTERN.fullmatch(name) is not None


def _is_value(node: Node) -> bool:
    return node.kind not in ("eq", "in", "and", "or") and find_names(node) <= set(VOCABULARY["whole_numbers"])


def _convert_unit(value: Node, unit: str) -> Node:
    """Return a value converted to metres or radians."""
    factor = _UNITS[unit]
    if factor.startswith("/"):
        return Node("/", (value, number(int(factor[1:]))))
    return _make_call("radians", (value,)) if factor else value


def _transpose(matrix: Node) -> Node:
    """Return a list of rows transposed; a list of entries is returned unchanged, because it may be a column."""
    rows = [row.args for row in matrix.args if row.kind == "list"]
    if len(rows) != len(matrix.args) or len({len(row) for row in rows}) != 1:
        return matrix
    return make_rows(zip(*rows, strict=True))


def _apply_sign(is_negative: bool, node: Node) -> Node:
    return Node("neg", (node,)) if is_negative else node


_MINUS_ONE = Node("neg", (ONE,))


def _make_part_node(piece: NamePart) -> Node:
    if piece.kind == "name":
        return Node("name", value=piece.names[0])
    angle = combine_from_left("+", [Node("name", value=part) for part in piece.names])
    return angle if piece.kind == "sum" else Node("call", (angle,), piece.kind)


def _make_call(name: str, args: tuple[Node, ...]) -> Node:
    if name == "radians":
        return Node("/", (Node("*", (args[0], Node("name", value="pi"))), number(180)))
    return Node("call", args, name)


@lru_cache(maxsize=1024)
def _parse_number(text: str) -> Node:
    mantissa, _, exponent = text.lower().partition("e")
    is_long = len(mantissa) > LIMITS["mantissa"] or len(exponent) > LIMITS["exponent_characters"]
    if is_long or abs(int(exponent or 0)) > LIMITS["exponent"]:
        raise ParseError(f"the number {text[:20]}… is out of range")
    kind = "decimal" if "." in mantissa or exponent else "number"
    return Node(kind, value=Fraction(text))


def _fill_matrix(rows: Node, columns: Node, entries: Node) -> Node | None:
    """Return the matrix of Matrix(rows, columns, entries), or None if the numbers don't fit.

    The entries are a single list, or a list of rows as in Maple.
    """
    if entries.kind != "list" or rows.kind != "number" or columns.kind != "number":
        return None
    lengths = [len(entry.args) if entry.kind == "list" else None for entry in entries.args]
    if rows.value == len(lengths) > 0 and set(lengths) == {columns.value}:
        return entries
    if not 0 < rows.value * columns.value == len(entries.args):
        return None
    width = int(columns.value)
    return make_rows(entries.args[i : i + width] for i in range(0, len(entries.args), width))


def _make_container(name: str, args: tuple[Node, ...], parser: _Parser) -> Node:
    meaning = _CONTAINERS[name]
    if meaning == "set" or (meaning in ("or", "and") and args) or (meaning in _TWO_ARGUMENT_KINDS and len(args) == 2):
        return Node(meaning, args)
    if meaning == "image" and len(args) == 2 and args[1].value in VOCABULARY["whole_number_sets"]:
        return args[0]
    if meaning == "condition" and len(args) in (2, 3):
        return args[1]
    if meaning == "transposed" and len(args) == 1:
        return _transpose(args[0])
    if meaning == "inverse" and len(args) == 1:
        return Node("^", (args[0], _MINUS_ONE))
    if meaning == "modulo" and len(args) == 2:  # the remainder is the value minus a whole multiple of the modulus
        return Node("-", (args[0], Node("*", (_ANY_WHOLE_NUMBER, args[1]))))
    if len(args) == 1:
        return args[0]
    if meaning == "matrix" and len(args) == 3 and (matrix := _fill_matrix(*args)) is not None:
        return matrix
    if meaning == "diagonal" and len(args) <= MAX_DIAGONAL:
        return make_rows([arg if i == j else ZERO for j in range(len(args))] for i, arg in enumerate(args))
    if meaning == "list":
        return Node("list", args)
    raise parser.parse_error(f"{name} with {len(args)} arguments is not supported")


def parse_formula(text: str, known_symbols: Iterable[str] = ()) -> Node:
    """Return the tree of `text`; the names `known_symbols` of the problem's symbols take precedence over shorthand.

    Raises ParseError with the position and the expected token. Time and memory are linear in the length.

    >>> parse_formula("2*a1 + c12").kind
    '+'
    >>> parse_formula("sin(theta1")
    Traceback (most recent call last):
    qdot.exercises.formula.trees.ParseError: expected ')', found the end (at character 11, near 'sin(theta1')
    """
    if len(text) > MAX_LENGTH:
        raise ParseError(f"the answer has {len(text)} characters; at most {MAX_LENGTH} are allowed")
    return (_parse_short_text if len(text) < SHORT_TEXT_LENGTH else _parse_long_text)(text, frozenset(known_symbols))


SHORT_TEXT_LENGTH = 4000
"""Length in characters below which many answers are cached; only a few longer answers are."""


def _parse(text: str, known_symbols: frozenset[str]) -> Node:
    """Return the tree. It is cached because grading, diagnosis and the student's page all parse the same answer."""
    return _Parser(to_plain_text(text, known_symbols), known_symbols).parse()


_parse_long_text, _parse_short_text = lru_cache(4)(_parse), lru_cache(128)(_parse)


@lru_cache(maxsize=512)
def parse_reference(text: str, known_symbols: frozenset[str]) -> Node:
    """Return the cached tree of a reference formula, which is compared with many answers."""
    return parse_formula(text, known_symbols)
