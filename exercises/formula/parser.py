"""Parse a typed answer into a tree of nodes. Only known notation is accepted, and the text is never executed.

The grammar is the notation of Python and SymPy, extended by what people type: `^` for powers, `2a1`, theta as a Greek
letter, `theta_1`, and the robotics shorthand c12 = cos(theta1 + theta2). Lists, sets, dictionaries and equations are
parsed, too. The caller decides whether a tree stands for a scalar, a matrix or a set of conditions.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from qdot.exercises.formula import names, trees
from qdot.exercises.formula.metres import METRE, remove_metres
from qdot.exercises.formula.names import ARITY, FUNCTIONS, SHORTHAND, NamePart, normalize_name, split_name
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.products import evaluate_matrices
from qdot.exercises.formula.trees import Node, ParseError, combine_from_left, find_names, make_number, make_rows
from qdot.exercises.formula.vocabulary import LIMITS, PATTERNS, VOCABULARY

MAX_DEPTH = LIMITS["depth"]
"""Maximum depth of nested brackets, bars, functions or powers."""
MAX_LENGTH, MAX_PLUS_MINUS_SIGNS = LIMITS["characters"], LIMITS["plus_minus_signs"]
"""Maximum number of characters of an answer, and of ± signs in it."""
MAX_ROWS = LIMITS["matrix_rows"]
"""Maximum number of rows of diag(…), and of a matrix typed as several lists in a row, such as [a, b][c, d]."""

_CALL_MEANINGS: dict[str, str] = VOCABULARY["call_meanings"]
"""Maps each SymPy, NumPy or Python call that is not a function of numbers, such as Matrix and Eq, to its meaning."""
_TWO_ARGUMENT_MEANINGS = ("eq", "in", "/", "^")
"""Meanings of calls that need exactly two arguments."""
_BINDING_CALLS: dict[str, str] = VOCABULARY["binding_calls"]
"""Maps each call with a variable of its own, such as Derivative and Lambda, to the meaning of the call."""
_OPERATOR_WORDS: list[str] = VOCABULARY["operator_words"]
"""Names that are operators, as in "a and b" or "0 mod pi", and so are not factors of a product."""

_TOKEN = re.compile("|".join(
    f"(?P<{kind}>{VOCABULARY['patterns'][name]})"
    for kind, name in (("space", "between_tokens"), ("number", "number"), ("name", "name"), ("op", "operator"))
))  # fmt: skip
"""Matches a token; the name of the group that matches is the token's kind."""

_TOKENS_OUTSIDE_BARS = ("=", "==", ",", ";", ":", "&")
"""Tokens that occur inside an absolute value such as |a1| only if they are in brackets."""
_TOKENS_AFTER_BARS = ("*", "/", "^", "**", "=", "==", ")", "]", "}", ",", ";")
"""Tokens that show that the bar before them ends an absolute value, because they can't follow a bar that means "or"."""
_TOKENS_BEFORE_EQUATION = (",", ";", "and", "&", "or", "[", "(", "{")
"""Tokens after which an equation such as J(q) = … may begin."""
_OR_WORDS = ("or", "|")
"""Words for "or" that may follow a comma between two conditions, but not a comma between two entries of a vector."""

_BRACKETS = {"(": (")", "group"), "[": ("]", "list"), "{": ("}", "set")}
"""Maps each opening bracket to its closing bracket and to the kind of its content (`parse_bracket`)."""
_DEPTH_CHANGES = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}
"""Maps each bracket to the change of the depth at the bracket."""


class _Token(NamedTuple):
    """A number, a name, an operator or the end of the text; the `kind` is "number", "name", "op" or "end".

    `position` is the index of its first character in the text.
    """

    kind: str
    text: str
    position: int


def _tokenize(text: str) -> list[_Token]:
    """Return the tokens of a text and an "end" token. Raises ParseError for a character that begins no token."""
    tokens: list[_Token] = []
    position, depth = 0, 0
    for match in _TOKEN.finditer(text):
        if match.start() != position:
            break
        if match.lastgroup != "space":
            tokens.append(_Token(str(match.lastgroup), match.group(), position))
            depth += _DEPTH_CHANGES.get(match.group(), 0)
            if depth > MAX_DEPTH:  # checked early, to spend no time on the other tokens
                raise ParseError(f"brackets are nested more than {MAX_DEPTH} deep {_describe_position(text, position)}")
        position = match.end()
    if position < len(text):
        example = "write a formula as a1*cos(theta1), a matrix as [[a, b], [c, d]], a condition as theta2 = 0"
        raise ParseError(f"unexpected {text[position]!r} {_describe_position(text, position)}; {example}")
    tokens.append(_Token("end", "", position))
    return tokens


def _describe_position(text: str, position: int) -> str:
    """Return a position and the characters around it, for a message."""
    start, end = max(0, position - 15), position + 15
    nearby_characters = (" " if ch.isspace() else ch for ch in text[start:end])
    printable_text = "".join(ch if ch.isprintable() else "\N{REPLACEMENT CHARACTER}" for ch in nearby_characters)
    excerpt = f"{'…' if start else ''}{printable_text}{'…' if end < len(text) else ''}"
    return f"(at character {position + 1}, near '{excerpt}')"


class _Parser:
    """A recursive-descent parser that limits the nesting depth, so that no text can exhaust the stack.

    There is one method for each level of precedence, from `parse_disjunction` to `parse_primary`.
    """

    def __init__(self, text: str, known_symbols: frozenset[str]) -> None:
        self.text, self.known_symbols = text, known_symbols
        self.tokens = self.translate_words(_tokenize(text))
        self.index = 0
        """The index of the next token."""
        self.depth = 0
        if (sign_count := sum(symbol == "±" for _, symbol, _ in self.tokens)) > MAX_PLUS_MINUS_SIGNS:
            raise ParseError(
                f"the answer has {sign_count} ± signs, and each doubles the number of alternatives; "
                "write out the alternatives"
            )
        self.bare_argument_end = -1
        """The index of the token after the last function argument without brackets; -1 if there is none."""
        self.joined_product: Node | None = None
        """The last parsed product of names written without spaces or brackets, as in a1c2."""
        self.is_inside_bars = False
        """Whether the next bar ends an absolute value."""
        self.braces_are_lists = False
        """Whether a function was typed with square brackets, as in Mathematica, where {a, b} is a list."""

    def translate_words(self, tokens: list[_Token]) -> list[_Token]:
        """Return the tokens with words of other languages replaced, such as the German word for "or".

        Words without a meaning, such as "when", are left out.
        """
        translated_tokens: list[_Token] = []
        for token in tokens:
            kind, text, position = token
            word = VOCABULARY["synonyms"].get(text) if kind == "name" and text not in self.known_symbols else None
            is_dotted = word is None and kind == "name" and "." in text
            if word:
                word_kind = "number" if word.isdigit() else "name" if word.isalpha() else "op"
                translated_tokens.append(_Token(word_kind, word, position))
            elif is_dotted and (factors := names.split_dotted_product(text, self.known_symbols)):
                start = position
                for factor in factors:  # a1.a2.sin
                    translated_tokens += [_Token("op", "*", start), _Token("name", factor, start)]
                    start += len(factor) + 1
                del translated_tokens[-2 * len(factors)]  # no * before the first factor
            elif word is None:
                translated_tokens.append(token)
        return translated_tokens

    def peek(self, offset: int = 0) -> str:
        """Return the text of the next token or, if `offset` is not 0, of the token that comes `offset` tokens later."""
        return self.tokens[min(self.index + offset, len(self.tokens) - 1)].text

    def make_error(self, message: str) -> ParseError:
        """Return an error at the next token."""
        return ParseError(f"{message} {_describe_position(self.text, self.tokens[self.index].position)}")

    def take(self, *texts: str) -> bool:
        """Skip the next token if it is one of `texts`; return whether a token was skipped."""
        kind, text, _ = self.tokens[self.index]
        is_next = kind in ("op", "name") and text in texts
        self.index += is_next
        return is_next

    def expect(self, text: str) -> None:
        if not self.take(text):
            is_end = self.tokens[self.index].kind == "end"
            raise self.make_error(
                f"'{text}' is missing at the end" if is_end else f"expected '{text}', found {self.peek()!r}"
            )

    def parse(self) -> Node:
        """Return the tree of the whole text."""
        if self.tokens[0].kind == "end":
            raise ParseError("the text is empty")
        self.skip_lambda_head()
        tree = self.parse_to_end()
        if self.braces_are_lists:
            tree = trees.fold(
                tree, lambda node, args: Node("list" if node.kind == "set" else node.kind, tuple(args), node.value)
            )
        may_have_metres = METRE not in self.known_symbols and any(text == METRE for _, text, _ in self.tokens)
        return evaluate_matrices(remove_metres(tree) if may_have_metres else tree)

    def parse_to_end(self) -> Node:
        """Return the tree of all remaining tokens."""
        rows, has_comma = self.parse_rows("")
        if self.tokens[self.index].kind != "end":
            raise self.make_error(f"unexpected {self.peek()!r}")
        if not rows[0]:  # semicolons alone
            raise ParseError("the text is empty")
        if len(rows) > 1 and any(len(row) > 1 for row in rows):
            return make_rows(rows)
        items = [entry for row in rows for entry in row]  # also a column, as in a; b
        if any(item.kind == "pair" for item in items):  # x: a, y: b
            return self.make_dictionary(items)
        return Node("list", tuple(items)) if has_comma or len(items) > 1 else items[0]

    def parse_rows(self, closing: str) -> tuple[list[list[Node]], bool]:
        """Parse entries up to the closing bracket; return the rows of entries, and whether there was a comma.

        Commas separate entries, semicolons separate rows. If `closing` is "", entries are parsed up to the end of the
        text. In braces and outside all brackets, an entry may have a name, as in x: a.
        """
        rows: list[list[Node]] = [[]]
        has_comma = False
        while not (self.take(closing) if closing else self.tokens[self.index].kind == "end"):
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
                first_entry = next(row[0] for row in rows if row)
                words = ("and", "&", *(_OR_WORDS if self.is_condition(first_entry) else ()))
                if not closing and self.take(*words) and self.tokens[self.index].kind == "end":  # theta2 = 0, or
                    raise self.make_error("a number, a symbol or a bracket is missing at the end")
            elif self.peek() != ";":
                if closing:
                    self.expect(closing)
                break
        return [row for row in rows if row] or [[]], has_comma

    def is_comma_before_and(self) -> bool:
        return self.peek() == "," and self.peek(1) in ("and", "&")

    def is_condition(self, node: Node) -> bool:
        """Return whether a node is a condition on a symbol of the problem.

        In x = 1, for example, x only names an entry.
        """
        if node.kind in ("and", "or"):
            return all(map(self.is_condition, node.args))
        return node.kind in ("eq", "in") and not find_names(node.args[0]).isdisjoint(self.known_symbols)

    def join_conditions(self, condition: Node, is_first_entry: bool) -> Node:
        """Parse ", and B" after the condition A; return "A and B" if B is a condition, else A.

        If B is a value, as in theta2 = 0, and pi, the comma separates the entries of a list. Raises ParseError if more
        commas or alternatives make this ambiguous.
        """
        start = self.index
        terms = list(condition.args) if condition.kind == "and" else [condition]
        while self.is_comma_before_and():
            index_before_comma = self.index
            self.index += 2
            term = self.parse_relation()
            if not self.is_condition(term):
                self.index = index_before_comma
                break
            terms.append(term)
        if self.index == start:
            return condition
        if not is_first_entry or self.peek() in (",", "or", "|") or condition.kind == "or":
            self.index = start
            example = "(theta1 = 0 or theta2 = 0) and theta3 = 0"
            raise self.make_error(f"a comma before 'and' is ambiguous; use brackets and no comma, as in {example}")
        return Node("and", tuple(terms))

    def make_dictionary(self, items: Sequence[Node]) -> Node:
        """Return a dictionary node; values without a name belong to the name before them, as in theta2: 0, pi."""
        pairs: list[list[Node]] = []
        for item in items:
            if item.kind == "pair":
                pairs.append([*item.args])
            elif pairs and _is_value(item):
                pairs[-1].append(item)
            else:
                advice = "write conditions without words before them"
                raise self.make_error(f"every entry of a dictionary needs the form 'joint: values'; {advice}")
        assignments = ((name, values[0] if len(values) == 1 else Node("set", tuple(values))) for name, *values in pairs)
        return Node("dict", tuple(Node("pair", pair) for pair in assignments))

    def skip_lambda_head(self) -> None:
        """Skip the head of a Python function, as in lambda theta1, theta2: …, if there is one."""
        if self.take("lambda"):
            while self.tokens[self.index].kind == "name":
                self.index += 1
                if not self.take(","):
                    break
            self.expect(":")

    @contextmanager
    def count_nesting(self, construct: str = "brackets") -> Iterator[None]:
        """Count the nesting depth of brackets, bars and functions. Raises ParseError beyond MAX_DEPTH."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.make_error(f"{construct} are nested more than {MAX_DEPTH} deep")
        yield
        self.depth -= 1

    def parse_disjunction(self) -> Node:
        with self.count_nesting():
            return self.parse_chain("or", "|", self.parse_conjunction)

    def parse_conjunction(self) -> Node:
        return self.parse_chain("and", "&", self.parse_relation)

    def parse_chain(self, word: str, sign: str, parse_term: Callable[[], Node]) -> Node:
        """Parse terms that are connected by a word or by its sign."""
        terms = [parse_term()]
        while self.take(word, sign):
            terms.append(parse_term())
        return terms[0] if len(terms) == 1 else Node(word, tuple(terms))

    def parse_relation(self) -> Node:
        sides = [self.parse_modulo(self.parse_sum())]
        while self.take("=", "=="):
            sides.append(self.parse_right_side())
        if len(sides) > 2 and sides[0].kind == "name" and sides[1].kind == "list":
            del sides[0]  # P = [x; y] = […]
        equations = tuple(Node("eq", pair) for pair in pairwise(sides))
        if len(equations) > 1:  # theta1 = theta2 = 0
            return Node("and", equations, trees.EQUATION_CHAIN)
        if not equations and self.take("in"):
            return Node("in", (sides[0], self.parse_modulo(self.parse_sum())))
        return equations[0] if equations else sides[0]

    def parse_right_side(self) -> Node:
        """Parse the right side of an equation, which may have several values, as in theta2 = 0 or pi."""
        alternatives = [self.parse_modulo(self.parse_sum())]
        while self.peek() in ("or", "and", "|", "&"):
            index_before_word = self.index
            self.index += 1
            alternative = self.parse_modulo(self.parse_sum()) if self.tokens[self.index].kind != "end" else None
            if alternative is None or self.peek() in ("=", "==", "in", ":") or not _is_value(alternative):
                self.index = index_before_word  # another condition begins at this word
                break
            alternatives.append(alternative)
        return alternatives[0] if len(alternatives) == 1 else Node("set", tuple(alternatives))

    def parse_modulo(self, value: Node) -> Node:
        """Parse "mod pi" or "(mod pi)" after a value; return the value plus any whole multiple of pi."""
        is_in_brackets = self.peek() == "(" and self.peek(1) in _MODULO_WORDS
        if not is_in_brackets and self.peek() not in _MODULO_WORDS:
            return value
        self.index += 2 if is_in_brackets else 1
        if self.peek(-1) == "%" and self.tokens[self.index].kind in ("end", "op") and self.peek() != "(":
            raise self.make_error("percentages are not allowed; write a decimal such as 0.5")
        multiple = Node("*", (_ANY_WHOLE_NUMBER, self.parse_sum()))
        if is_in_brackets:
            self.expect(")")
        if value.kind in ("list", "set"):
            return Node(value.kind, tuple(Node("+", (term, multiple)) for term in value.args))
        return Node("+", (value, multiple))

    def parse_sum(self) -> Node:
        if self.take("±"):
            value = self.parse_product()
            node = Node("set", (value, Node("neg", (value,))))
        else:
            node = _apply_sign(self.parse_sign(), self.parse_product())
        while self.peek() in ("+", "-", "±"):
            op = self.peek()
            follows_bare_argument = self.index == self.bare_argument_end
            self.index += 1
            is_negative, term = self.parse_sign(), self.parse_product()
            if follows_bare_argument and term.kind == "name" and _is_angle(str(term.value)):
                message = f"{op} {term.value} may or may not belong to the argument of the function before it"
                raise self.make_error(f"{message}; put the argument in brackets, as in sin(theta1 + theta2)")
            term = _apply_sign(is_negative, term)
            alternatives = (Node("+", (node, term)), Node("-", (node, term)))
            node = Node("set", alternatives) if op == "±" else Node(op, (node, term))
        return node

    def parse_sign(self) -> bool:
        """Parse the signs before a term; return whether the term is negative."""
        is_negative = False
        while self.peek() in ("+", "-") and self.tokens[self.index].kind == "op":
            is_negative ^= self.peek() == "-"
            self.index += 1
        return is_negative

    def parse_product(self) -> Node:
        """Parse factors and divisors, also factors without a sign between them, as in 2 a1 cos(theta1)."""
        node = self.parse_power()
        divisor_end = -1  # the index of the token after a divisor that is a single name; -1 if there is none
        while True:
            kind, text, _ = self.tokens[self.index]
            if text in ("*", "/", "."):
                self.index += 1
                start = self.index
                node = Node(text if text == "/" else "*", (node, _apply_sign(self.parse_sign(), self.parse_power())))
                is_name_divisor = text == "/" and self.is_single_name(start) and node.args[1].kind == "name"
                divisor_end = self.index if is_name_divisor else -1
            elif kind == "number" and self.tokens[self.index - 1].kind == "number":
                raise self.make_error("there is no operator between two numbers")  # 1 000, 1.2.3: no product is meant
            elif kind == "number" and text.startswith("."):  # a1.2
                raise self.make_error(
                    f"the point in {text} can be a product or a decimal point; write *{text[1:]} or *0{text}"
                )
            elif text == "(" and self.peek(1) in _MODULO_WORDS:
                return node
            elif kind == "name" and self.is_unit(text):
                self.index += 1
                node = _convert_unit(node, text)
            elif kind == "name" and text not in _OPERATOR_WORDS and self.index == divisor_end:
                advice = "put the denominator in brackets, as in a/(b*c), or write a/b*c"
                raise self.make_error(f"/{self.peek(-1)} {text} is ambiguous; {advice}")
            elif text == "|" and self.begins_absolute_value():
                node = Node("*", (node, self.parse_power()))
            elif text == "[" and self.is_row_below(node):
                node = self.parse_row_below(node)
            elif kind == "number" or text in ("(", "[") or (kind == "name" and text not in _OPERATOR_WORDS):
                node = Node("*", (node, self.parse_factor()))
            else:
                return node

    def is_single_name(self, start: int) -> bool:
        """Return whether a divisor, from the token `start` to the one before the next, is a single name except pi."""
        kind, text, _ = self.tokens[start]
        return kind == "name" and self.index == start + 1 and not text.startswith(_PI_NAMES)

    def parse_factor(self) -> Node:
        """Parse a factor without a sign.

        A list of one number, such as [0], is refused, because it selects an entry in Python.
        """
        is_bracket = self.peek() == "["
        start, node = self.index, self.parse_power()
        if is_bracket and node.kind == "list" and len(node.args) == 1 and node.args[0].kind in ("number", "neg"):
            self.index = start
            raise self.make_error("unexpected '['; entries of a vector have names such as a1 or theta2")
        return node

    def begins_absolute_value(self) -> bool:
        """Return whether the next token, a bar, begins an absolute value, as in a1|s2|, or means "or", as in 0 | pi."""
        if self.is_inside_bars:
            return False
        depth, index, has_symbol = 0, self.index + 1, False
        while self.tokens[index].kind != "end" and not (self.tokens[index].text == "|" and depth == 0):
            kind, text, _ = self.tokens[index]
            depth += _DEPTH_CHANGES.get(text, 0)
            if depth < 0 or (depth == 0 and (text in _TOKENS_OUTSIDE_BARS or text in _OPERATOR_WORDS)):
                return False
            has_symbol |= kind == "name" and not text.startswith(_PI_NAMES)
            index += 1
        if self.tokens[index].kind == "end" or not has_symbol:
            return False
        opening_bar, first_inside = self.tokens[self.index : self.index + 2]
        last_inside, closing_bar, token_after = self.tokens[index - 1 : index + 2]
        begins_tightly = first_inside.position == opening_bar.position + 1
        ends_tightly = last_inside.position + len(last_inside.text) == closing_bar.position
        is_at_end = token_after.kind == "end" or token_after.text in _TOKENS_AFTER_BARS
        return (begins_tightly and ends_tightly) or is_at_end

    def is_row_below(self, node: Node) -> bool:
        """Return whether the next list is another row of the matrix `node`, as in [a, b][c, d] on some calculators."""
        has_rows = self.peek(1) == "[" or (1, ";") in self.list_bracket_tokens()  # [[a, b], [c, d]] or [a; b]
        return node.kind == "list" and len(node.args) > 1 and self.peek(-1) == "]" and not has_rows

    def list_bracket_tokens(self) -> list[tuple[int, str]]:
        """Return (depth, text) of each token from the bracket that begins here to its closing bracket."""
        depth, tokens_with_depth = 0, list[tuple[int, str]]()
        for _, text, _ in self.tokens[self.index :]:
            depth += _DEPTH_CHANGES.get(text, 0)
            tokens_with_depth.append((depth, text))
            if depth == 0:
                break
        return tokens_with_depth

    def parse_row_below(self, node: Node) -> Node:
        """Parse the next list; return `node` with this list as its last row."""
        self.take("[")
        row = self.parse_bracket("]", "list")
        rows = node.args if all(arg.kind == "list" for arg in node.args) else (node,)
        if len(rows) >= MAX_ROWS or any(len(other_row.args) != len(row.args) for other_row in rows):
            raise self.make_error("two lists of different lengths follow each other")
        return Node("list", (*rows, row))

    def is_unit(self, text: str) -> bool:
        """Return whether a name after a number is a unit.

        A unit of angles ends a product, as in 0.25 rad. A unit of lengths may also come before a factor. Whether m is a
        unit is decided later, when the whole formula is known (`metres`).
        """
        if text not in _UNITS or text in self.known_symbols or text in VOCABULARY["whole_numbers"]:
            return False
        kind, previous_text, _ = self.tokens[self.index - 1]
        if kind != "number" and previous_text not in VOCABULARY["before_whole_numbers"]:
            return False
        next_kind, next_text, _ = self.tokens[min(self.index + 1, len(self.tokens) - 1)]
        if text in VOCABULARY["lengths"]:
            return next_text not in _UNIT_OPERATORS
        return next_text not in _TOKENS_AFTER_FACTOR and (next_kind in ("op", "end") or next_text in _OPERATOR_WORDS)

    def parse_power(self) -> Node:
        base = self.parse_primary()
        if self.tokens[self.index].text not in ("**", "^"):
            return base
        exponents, applies_to_last_factor = [], base is self.joined_product
        while self.take("**", "^"):
            exponents.append(_apply_sign(self.parse_sign(), self.parse_primary()))
            if len(exponents) > MAX_DEPTH:
                raise self.make_error(f"powers are nested more than {MAX_DEPTH} deep")
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
        kind, text, _ = self.tokens[self.index]
        if kind == "number":
            self.index += 1
            return _parse_number(text)
        if kind == "name" and text not in _OPERATOR_WORDS:
            self.index += 1
            return self.parse_name(text)
        if self.take("..."):
            return Node("blank")
        if self.take("(", "[", "{"):
            return self.parse_bracket(*_BRACKETS[text])
        if self.take("|"):
            return self.parse_absolute_value()
        operand = "a number, a symbol or a bracket"
        raise self.make_error(f"expected {operand}, found {text!r}" if text else f"{operand} is missing at the end")

    def parse_absolute_value(self) -> Node:
        """Parse an absolute value such as |a1*sin(theta2)|; its first bar has been skipped."""
        with self.count_nesting():
            self.is_inside_bars, was_inside_bars = True, self.is_inside_bars
            content = self.parse_sum()
            self.is_inside_bars = was_inside_bars
            self.expect("|")
        return _make_call(FUNCTIONS["abs"], (content,))

    def parse_bracket(self, closing: str, kind: str) -> Node:
        """Parse the content of brackets.

        The `kind` is "group" (parentheses), "list", "set" or "args" (of a function).
        """
        self.is_inside_bars, was_inside_bars = False, self.is_inside_bars
        rows, has_comma = self.parse_rows(closing)
        self.is_inside_bars = was_inside_bars
        self.joined_product = None  # in (a1c2)^2, the power applies to the whole product
        items = rows[0]
        if len(rows) > 1:  # [a, b; c, d], or (a; b), {0; pi}
            is_column = kind in ("group", "set") and all(len(row) == 1 for row in rows)
            return Node("list", tuple(row[0] for row in rows)) if is_column else make_rows(rows)
        if kind == "group":
            return items[0] if len(items) == 1 and not has_comma else Node("list", tuple(items))
        return self.make_dictionary(items) if any(item.kind == "pair" for item in items) else Node(kind, tuple(items))

    def parse_name(self, typed_name: str) -> Node:
        """Return the tree of a name that has been skipped: a call, a value, or a product of symbols and functions."""
        if len(typed_name) > names.MAX_NAME_LENGTH:
            raise self.make_error(f"a name of {len(typed_name)} characters is not a symbol")
        if typed_name.endswith(".diff") and self.peek() == "(":  # theta1.diff(t)
            variable = split_name(typed_name.removesuffix(".diff"), self.known_symbols)[0]
            return self.parse_binding_call("Derivative", _make_part_node(variable))
        name = normalize_name(typed_name)
        is_bracket_next = self.peek() == "("
        if is_bracket_next and name in _BINDING_CALLS:
            return self.parse_binding_call(name)
        may_depend_on_time = name in self.known_symbols or PATTERNS["joint"].fullmatch(name) is not None
        if is_bracket_next and may_depend_on_time and self.peek(1) == "t" and self.peek(2) == ")":
            self.index += 3  # theta1(t), as dynamicsymbols prints it
            return _make_part_node(split_name(typed_name, self.known_symbols)[0])
        if is_bracket_next and name in _CALL_MEANINGS:
            self.index += 1
            return _interpret_call(name, self.parse_bracket(")", "args").args, self)
        if name in VOCABULARY["undefined"]:
            meaning, advice = VOCABULARY["undefined"][name]
            location = f"at character {self.tokens[self.index - 1].position + 1}"
            is_whole_answer = self.index == 1 and self.peek() == ""
            fact = f"is {name} ({meaning})" if is_whole_answer else f"contains {name} ({meaning}) {location}"
            raise trees.UndefinedValue(f"your answer {fact}; {advice}")
        if name in VOCABULARY["blank"]:
            return Node("blank")
        if name in SHORTHAND and name not in self.known_symbols and self.is_angle_ahead():
            return self.parse_shorthand(name)
        parts = split_name(typed_name, self.known_symbols)
        symbol = parts[0].names[0] if len(parts) == 1 and parts[0].kind == "name" else ""
        is_unknown = symbol and not {name, symbol} & self.known_symbols and symbol not in _FACTORS_BEFORE_BRACKETS
        if is_bracket_next and is_unknown:
            after_bracket = self.index + len(self.list_bracket_tokens())
            is_first_name = self.index == 1 or self.tokens[self.index - 2].text in _TOKENS_BEFORE_EQUATION
            if is_first_name and after_bracket < len(self.tokens) and self.tokens[after_bracket].text == "=":
                self.index = after_bracket  # J(q) = …
                return Node("name", value=symbol)
            advice = _NEGATION_ADVICE if name in VOCABULARY["negations"] else _UNKNOWN_FUNCTION_ADVICE
            raise self.make_error(f"the function {name!r} {advice}")
        product = self.multiply_parts(parts)
        if parts[-1].kind in FUNCTIONS and PATTERNS["shorthand_of_angle"].search(name):  # ctheta1
            self.bare_argument_end = self.index
        return product

    def is_angle_ahead(self) -> bool:
        """Return whether an angle or a bracket follows, perhaps after a power, as in c theta1 and s^2(theta1)."""
        power_length = 0 if self.peek() not in ("^", "**") else 4 if self.peek(1) == "(" else 2  # as in ^2 or ^(2)
        kind, text, _ = self.tokens[min(self.index + power_length, len(self.tokens) - 1)]
        part = split_name(text, self.known_symbols)[0] if kind == "name" else None
        return text == "(" or (part is not None and (part.kind == "sum" or _is_angle(part.names[0])))

    def parse_shorthand(self, name: str) -> Node:
        """Parse c or s as the cosine or sine of the angle that follows.

        Raises ParseError for an argument that is not an angle, such as S(1), which is SymPy's number 1.
        """
        start, function = self.index, SHORTHAND[name]
        call = self.parse_function(function)
        if not any(map(_is_angle, find_names(call))):
            self.index = start
            advice = f"as in {name}(theta1); write {function}(…)"
            raise self.make_error(f"{name} means {function} only before an angle, {advice}")
        return call

    def multiply_parts(self, parts: Sequence[NamePart]) -> Node:
        """Return the product of names that are written without spaces. A function applies to the name after it."""
        factors: list[Node] = []
        remaining_parts = list(parts)
        while remaining_parts:
            part = remaining_parts.pop(0)
            if part.kind != "function":
                factors.append(_make_part_node(part))
            elif remaining_parts and remaining_parts[0].kind != "function" and part.names[0] not in ARITY:
                factors.append(_make_call(part.names[0], (_make_part_node(remaining_parts.pop(0)),)))
                self.bare_argument_end = self.index if not remaining_parts else -1
            elif not remaining_parts:
                factors.append(self.parse_function(part.names[0]))
            else:
                raise self.make_error(f"{part.names[0]} has no argument")
        product = combine_from_left("*", factors)
        if len(factors) > 1:
            self.joined_product = product
        return product

    def parse_binding_call(self, name: str, *arguments_before: Node) -> Node:
        """Parse Derivative(theta1(t), t) as the rate qd1, and Lambda(_n, …) as an expression with any whole number.

        `arguments_before` has the argument that was typed before the name, as in theta1.diff(t).
        """
        self.index += 1
        args = arguments_before + self.parse_bracket(")", "args").args
        is_rate = _BINDING_CALLS[name] == "rate"
        joint = PATTERNS["joint"].fullmatch(str(args[0].value)) if args and args[0].kind == "name" else None
        if is_rate and len(args) in (1, 2) and joint is not None:
            return Node("name", value=f"qd{joint.group(1)}")
        if not is_rate and len(args) == 2 and args[0].kind == "name":
            return trees.replace_names(args[1], {args[0].value: _ANY_WHOLE_NUMBER})
        raise self.make_error(f"this form of {name} is not supported")

    def parse_function(self, name: str) -> Node:
        """Parse the power (if any) and the arguments after the name of a function."""
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
            raise self.make_error(f"wrong number of arguments of {name}: {len(args)} instead of {ARITY.get(name, 1)}")
        if power is not None and power == _MINUS_ONE and name in VOCABULARY["inverses"]:
            return _make_call(VOCABULARY["inverses"][name], args)  # sin^-1(x) is the arc sine
        call = _make_call(name, args)
        return Node("^", (call, power)) if power is not None else call

    def parse_bare_argument(self, name: str) -> Node:
        """Parse an argument without brackets: a number, a name, or a number and a name, as in sin 2 theta1."""
        factors = []
        if self.tokens[self.index].kind == "number":
            factors.append(_parse_number(self.peek()))
            self.index += 1
        if self.tokens[self.index].kind == "name" and self.peek() not in _OPERATOR_WORDS:
            if any(part.kind != "name" for part in split_name(self.peek(), self.known_symbols)[1:]):
                raise self.make_error(f"expected '(' after {name}")  # sin theta1cos(theta2)
            self.index += 1
            factors.append(self.parse_name(self.peek(-1)))
        if not factors or self.peek() in ("/", "^", "**"):
            raise self.make_error(f"expected '(' after {name}")
        self.bare_argument_end = self.index
        return combine_from_left("*", factors)


_ANY_WHOLE_NUMBER = Node("name", value=VOCABULARY["whole_numbers"][0])
_NEGATION_ADVICE = "is not supported; write the equations that hold, not those that don't"
_UNKNOWN_FUNCTION_ADVICE = "is unknown; use sin, cos, tan, sqrt, exp or atan2"
_MODULO_WORDS: list[str] = VOCABULARY["modulo"]
_PI_NAMES = tuple(VOCABULARY["before_whole_numbers"])
_FACTORS_BEFORE_BRACKETS = ("pi", "I", *VOCABULARY["whole_numbers"])
"""Names that are a factor of the bracket after them, because no function has these names."""
_UNITS: dict[str, str] = VOCABULARY["units"]
"""Maps each unit to the text that converts the number before it to SI units: /100 for cm, *pi/180 for deg."""
_UNIT_OPERATORS = ("/", "^", "**")
_TOKENS_AFTER_FACTOR = ("*", "(", *_UNIT_OPERATORS)
"""Tokens after a name that show that the name is a factor, not a unit at the end of a product."""


def _is_angle(name: str) -> bool:
    return PATTERNS["angle"].fullmatch(name) is not None


def _is_value(node: Node) -> bool:
    """Return whether a node is a value without symbols, apart from names of whole numbers such as k."""
    return node.kind not in ("eq", "in", "and", "or") and find_names(node) <= set(VOCABULARY["whole_numbers"])


def _convert_unit(value: Node, unit: str) -> Node:
    """Return a value converted to SI units."""
    conversion = _UNITS[unit]
    if conversion.startswith("/"):
        return Node("/", (value, make_number(int(conversion[1:]))))
    return _make_call("radians", (value,)) if conversion else value


def _transpose(matrix: Node) -> Node:
    """Transpose a list of rows. A list of entries is returned unchanged, because it may be a column."""
    rows = [row.args for row in matrix.args if row.kind == "list"]
    if len(rows) != len(matrix.args) or len({len(row) for row in rows}) != 1:
        return matrix
    return make_rows(zip(*rows, strict=True))


def _apply_sign(is_negative: bool, node: Node) -> Node:
    return Node("neg", (node,)) if is_negative else node


_MINUS_ONE = Node("neg", (trees.ONE,))


def _make_part_node(part: NamePart) -> Node:
    """Return the tree of a part of a name that is not a function."""
    if part.kind == "name":
        return Node("name", value=part.names[0])
    angle = combine_from_left("+", [Node("name", value=name) for name in part.names])
    return angle if part.kind == "sum" else Node("call", (angle,), part.kind)


def _make_call(name: str, args: tuple[Node, ...]) -> Node:
    if name == "radians":
        return Node("/", (Node("*", (args[0], Node("name", value="pi"))), make_number(180)))
    return Node("call", args, name)


@lru_cache(maxsize=1024)
def _parse_number(text: str) -> Node:
    """Return the node of a number. Raises ParseError if the number is out of range."""
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


def _interpret_call(name: str, args: tuple[Node, ...], parser: _Parser) -> Node:
    """Return the tree of a SymPy, NumPy or Python call that is not a function of numbers. Raises ParseError."""
    meaning = _CALL_MEANINGS[name]
    if meaning == "set" or (meaning in ("or", "and") and args):
        return Node(meaning, args)
    if meaning in _TWO_ARGUMENT_MEANINGS and len(args) == 2:
        return Node(meaning, args)
    if meaning == "image" and len(args) == 2 and args[1].value in VOCABULARY["whole_number_sets"]:
        return args[0]  # ImageSet(Lambda(n, 2*pi*n), Integers)
    if meaning == "condition" and len(args) in (2, 3):
        return args[1]  # ConditionSet(theta2, Eq(…), Reals)
    if meaning == "transposed" and len(args) == 1:
        return _transpose(args[0])
    if meaning == "inverse" and len(args) == 1:
        return Node("^", (args[0], _MINUS_ONE))
    if meaning == "modulo" and len(args) == 2:  # the remainder is the value minus a whole multiple of the modulus
        return Node("-", (args[0], Node("*", (_ANY_WHOLE_NUMBER, args[1]))))
    if len(args) == 1:  # Matrix([…]) or simplify(…) stands for its argument
        return args[0]
    if meaning == "matrix" and len(args) == 3 and (matrix := _fill_matrix(*args)) is not None:
        return matrix
    if meaning == "diagonal" and len(args) <= MAX_ROWS:
        return make_rows([arg if i == j else trees.ZERO for j in range(len(args))] for i, arg in enumerate(args))
    if meaning == "list":
        return Node("list", args)
    raise parser.make_error(f"{name} with {len(args)} arguments is not supported")


def parse_formula(text: str, known_symbols: Iterable[str] = ()) -> Node:
    """Return the tree of a text. The problem's symbols, `known_symbols`, take precedence over shorthand such as c12.

    Raises ParseError with the position and the expected token. Time and memory are linear in the length of the text.

    >>> parse_formula("2*a1 + c12").kind
    '+'
    >>> parse_formula("sin(theta1")
    Traceback (most recent call last):
    qdot.exercises.formula.trees.ParseError: ')' is missing at the end (at character 11, near 'sin(theta1')
    """
    if len(text) > MAX_LENGTH:
        raise ParseError(f"the answer has {len(text)} characters; at most {MAX_LENGTH} are allowed")
    return (_parse_short_text if len(text) < MIN_LONG_TEXT_LENGTH else _parse_long_text)(text, frozenset(known_symbols))


MIN_LONG_TEXT_LENGTH = 4000
"""Minimum length of a long answer, in characters. Fewer trees of long answers are cached, because they take more
memory."""


def _parse(text: str, known_symbols: frozenset[str]) -> Node:
    """Return the tree of a text. Trees are cached, because grading, diagnosis and feedback parse the same answer."""
    return _Parser(to_plain_text(text, known_symbols), known_symbols).parse()


_parse_long_text, _parse_short_text = lru_cache(4)(_parse), lru_cache(128)(_parse)


@lru_cache(maxsize=512)
def parse_reference(text: str, known_symbols: frozenset[str]) -> Node:
    """Return the tree of a reference formula; it is cached, because it is compared with many answers."""
    return parse_formula(text, known_symbols)
