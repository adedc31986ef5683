"""Parse the text of an answer into a formula, entries, numbers or conditions, or refuse the text with a reason.

Judging, partial credit, diagnosis, follow-through and reports all use the parsed answer and never parse the text again.
A part is one question of a problem. `expected_form` chooses the function of this module that parses its answer.

A parsed text is a tree of nodes (`formula.trees`). The domain of a problem contains the names of its symbols. Labels
are names that a student may write before entries, such as vx in vx = 0.
"""

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.formula.algebra import Matrix
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.notation import (
    convert_units_of_numbers,
    find_units,
    replace_latex_units,
    use_points_in_lengths,
)
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import WHOLE_NUMBER_NAMES, parse_typed_set
from qdot.exercises.formula.tables import convert_numbers, convert_table
from qdot.exercises.formula.trees import (
    EQUATION_CHAIN,
    Node,
    ParseError,
    UndefinedValue,
    as_matrix,
    count_nodes,
    find_names,
    find_nonscalar,
    format_tree,
    has_blank,
    iterate_nodes,
    list_equation_sides,
    make_rows,
    refuse_nonscalars,
    replace_names,
)
from qdot.exercises.formula.units import parse_unit
from qdot.exercises.formula.vocabulary import LIMITS, PATTERNS, VOCABULARY
from qdot.grader.judging.verdict import Judgement, make_missing_judgement, make_wrong_judgement

MatrixShape = tuple[int, int]
"""The numbers of rows and columns."""


@dataclass(frozen=True)
class FunctionValues:
    """The values of a student's Python function at several configurations.

    `values` has one row per configuration and one column per entry. `shape` is the shape of a single value; None if the
    table is malformed. `arguments` maps each argument to its values at the configurations.
    """

    shape: tuple[int, ...] | None
    values: np.ndarray
    arguments: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class ParsedAnswer:
    """A parsed answer: the typed `text` and its meaning. If the answer was refused, `refusal` is the judgement.

    `tree` is the formula, list or set of conditions, without a leading "det J =". `rows` contains the entries in rows
    and columns; named entries are in the expected order. If the answer was refused, `tree` and `rows` contain what
    could be parsed. `table` contains the values of a Python function. `chosen_indices` are those of the chosen options.
    """

    text: str
    refusal: Judgement | None = None
    tree: Node | None = None
    rows: Matrix | None = None
    table: FunctionValues | None = None
    chosen_indices: tuple[int, ...] = ()

    @property
    def entries(self) -> list[Node]:
        """The entries, row by row."""
        return [entry for row in self.rows or () for entry in row]

    @property
    def symbols(self) -> set[str]:
        """The names of variables in the entries: all names except constants such as pi."""
        return _find_symbols(self.rows or ())

    @property
    def is_blank(self) -> list[bool]:
        """Whether each entry, row by row, contains a blank."""
        return [has_blank(entry) for entry in self.entries]


class _Refusal(Exception):
    """Raised with the reason for refusing an answer."""


class _AmbiguousAnswer(_Refusal):
    """Raised with the reason for refusing an answer that has two meanings, so its tree must not be used."""


def refuse(text: str, reason: str) -> ParsedAnswer:
    """Return a refused answer with this text and reason."""
    return ParsedAnswer(text, make_wrong_judgement(reason))


def _make_refused_answer(
    error: _Refusal | ParseError, text: str, expected_type: str, tree: Node, rows: Matrix | None
) -> ParsedAnswer:
    """Return a refused answer with the reason from an error, and with the `tree` and `rows` that could be parsed.

    `expected_type` is the type as which the text was parsed, such as "a formula".
    """
    reason = describe_parse_error(error, expected_type) if isinstance(error, ParseError) else str(error)
    return ParsedAnswer(text, make_wrong_judgement(reason), None if isinstance(error, _AmbiguousAnswer) else tree, rows)


def read_formula(text: str, domain: Domain, labels: Sequence[str] = ()) -> ParsedAnswer:
    """Parse a single formula, which may be named by a single label. A decimal comma is accepted, as in 0,5."""
    if (value_text := _remove_capital_name(text, domain)) != text:
        return replace(read_formula(value_text, domain, labels), text=text)
    parsed = _parse(text, domain)
    if parsed.tree is None:
        return parsed
    tree, rows = parsed.tree, None
    try:
        if name := _find_wrong_component(tree, labels):
            reason = f"the question asks for {labels[0]}, but your answer is named {name}"
            raise _Refusal(f"{reason}; write {labels[0]} = … or only the formula")
        tree = _find_value(tree, domain, labels)
        if tree.kind == "list" and (text_with_points := replace_decimal_commas(text)) != text:
            return replace(read_formula(text_with_points, domain, labels), text=text)
        tree = _find_value(_unwrap(tree, domain), domain, labels)
        if tree.kind in ("list", "set", "dict"):
            rows = _find_rows(tree)
            raise _Refusal("your answer is a list or matrix, but the question asks for a single expression")
        rows = as_matrix(_remove_labels(tree))
        _require_scalars(rows)
        if has_blank(tree):
            raise _Refusal("your answer contains a blank, but the question asks for a single expression")
    except (_Refusal, ParseError) as error:
        return _make_refused_answer(error, text, "a formula", tree, rows)
    return ParsedAnswer(text, None, tree, rows)


def read_matrix(
    text: str, shape: MatrixShape, domain: Domain, labels: Sequence[str] = (), columns: Sequence[str] = ()
) -> ParsedAnswer:
    """Parse a matrix or vector of the given shape.

    A vector may be typed as a row instead of a column, and the entries may be named by `labels`. The columns of a
    matrix may be typed as vectors with the names in `columns`, and a twist as the two vectors v and ω.
    """
    parsed = _read_entries(text, shape, domain, labels, columns)
    find_table = partial(convert_table, shape=shape)
    return _retry_printed_table(parsed, find_table, lambda table: read_matrix(table, shape, domain))


def read_numbers(text: str, count: int, labels: Sequence[str] = (), units: Sequence[str] = ()) -> ParsedAnswer:
    """Parse `count` numbers, which may be formulas without symbols.

    The numbers may be named by `labels`. `units` are their units; an answer in a unit of another dimension is refused.
    A single number may have a decimal comma, as in 0,5.
    """
    text_with_plain_units = replace_latex_units(text)
    if unit_error := _describe_wrong_unit(text_with_plain_units.strip(), labels, units):
        return refuse(text, unit_error)
    numbers = convert_units_of_numbers(text_with_plain_units)
    if count == 1:
        numbers = replace_decimal_commas(numbers)
    parsed = _read_entries(numbers, (count, 1), Domain({}), labels, are_numbers=True)
    find_table = partial(convert_numbers, count=count)
    parsed = _retry_printed_table(parsed, find_table, lambda table: read_numbers(table, count, labels))
    return replace(parsed, text=text)


def _read_entries(
    text: str, shape: MatrixShape, domain: Domain, labels: Sequence[str], columns: Sequence[str] = (),
    are_numbers: bool = False,
) -> ParsedAnswer:  # fmt: skip
    """Parse the entries of a matrix or vector or, if `are_numbers`, a list of numbers. Entries may be named."""
    parsed = _parse(text, domain)
    if parsed.tree is None:
        return parsed
    tree = parsed.tree
    rows: Matrix | None = None
    try:
        tree = _find_value(_split_chains(tree, (*labels, *columns)), domain)
        if tree.kind == "set" and len(tree.args) > 1 and not _KINDS_ALLOWED_IN_SET & {arg.kind for arg in tree.args}:
            raise _AmbiguousAnswer("a set {a, b} has no order; write the entries as a list, [a, b]")
        if not are_numbers:
            tree = _stack_vectors(tree, shape, labels, columns) or tree
        rows = as_matrix(_remove_labels(tree, labels, (shape[0], 0) if are_numbers else shape))
        if tree.kind == "eq":  # an equation whose left side is not the name of the answer
            refuse_nonscalars(tree)
        symbols = _find_symbols(rows)
        if are_numbers and symbols:
            example = "0.5" if shape == (1, 1) else _make_example(shape, "0.5")
            raise _Refusal(f"{describe_symbols_in_numbers(symbols)}; write only numbers, such as {example}")
        is_single_formula = shape != (1, 1) and (len(rows), len(rows[0])) == (1, 1)
        if is_single_formula and not are_numbers and (unknown_names := symbols - set(domain.roles)):
            raise _Refusal(f"{name_unknown_symbols(unknown_names)}; write out every entry, like {_make_example(shape)}")
        rows = _require_shape(rows, shape, text)
        _require_scalars(rows)
    except (_Refusal, ParseError) as error:
        return _make_refused_answer(error, text, "numbers" if are_numbers else "a matrix", tree, rows)
    return ParsedAnswer(text, None, tree, rows)


def describe_symbols_in_numbers(symbols: AbstractSet[str]) -> str:
    """Return the reason for refusing numbers that contain symbols."""
    return f"the question asks for numbers, but your answer contains {', '.join(sorted(symbols)[:_MAX_NAMES_SHOWN])}"


def name_unknown_symbols(unknown: AbstractSet[str]) -> str:
    """Return a clause about symbols that the problem doesn't define."""
    names = ", ".join(repr(name) for name in sorted(unknown)[:_MAX_NAMES_SHOWN])
    return f"{names} {'is not a symbol' if len(unknown) == 1 else 'are not symbols'} of this problem"


_MAX_NAMES_SHOWN = 5
"""Maximum number of names that are shown in a message."""


_KINDS_ALLOWED_IN_SET = {"eq", "pair", "set", "list"}
"""The kinds of nodes that are accepted as entries in braces, although a set has no order: named entries and rows."""


def _retry_printed_table(
    parsed: ParsedAnswer, find_table: Callable[[str], str | None], parse_again: Callable[[str], ParsedAnswer]
) -> ParsedAnswer:
    """Return an answer unchanged, unless it was refused and its text is a printed table. Then parse it as a table.

    `find_table` returns the table in a text as the text of a list, or None. `parse_again` parses such a list.
    """
    if parsed.refusal is None or (table := find_table(parsed.text)) in (None, parsed.text):
        return parsed
    is_ambiguous = find_table(table) not in (None, table)  # a list that could be read as yet another table
    return parsed if is_ambiguous else replace(parse_again(table), text=parsed.text)


def _describe_wrong_unit(text: str, labels: Sequence[str], units: Sequence[str]) -> str:
    """Return a sentence about the first unit that doesn't fit its entry; "" if all units fit.

    A unit whose entry is unknown, such as one after the whole list, must fit some entry.
    """
    separator = next((sign for sign in ";\n" if sign in text), ",")
    has_expected_count = text.count(separator) + 1 == len(units)
    expected_names = [_normalize_label(label) for label in labels]
    for name, unit, end in find_units(text):
        index = text.count(separator, 0, end) if has_expected_count and text[end - 1] not in "]}" else None
        if (label := _normalize_label(name)) in expected_names:
            index = expected_names.index(label)
        expected = units if index is None else units[index : index + 1]
        typed_unit = parse_unit(unit)
        expected_units = [parse_unit(symbol) if symbol else None for symbol in expected]
        dimensions = {expected_unit and expected_unit.dimension for expected_unit in expected_units}
        if typed_unit and dimensions and not {None, typed_unit.dimension} & dimensions:  # None: no expected unit
            subject = f"entry {index + 1}" if index is not None and len(units) > 1 else "the result"
            advice = "use this unit or write only the number"
            return f"the unit {unit} does not fit: {subject} is in {expected[0]}; {advice}"
    return ""


def read_conditions(text: str, domain: Domain, joints: Sequence[str] = ()) -> ParsedAnswer:
    """Parse conditions on the given joints; entries that were left blank are omitted.

    If `joints` is empty, the conditions are not checked, so the text may also be a set of angles.
    """
    text_with_points = use_points_in_lengths(text)
    parsed = replace(_parse(text_with_points, domain), text=text)
    if parsed.tree is None:
        return parsed
    tree = parsed.tree
    try:
        tree = _drop_blanks(_substitute_whole_numbers(tree))
        if joints:
            _require_conditions(tree, text_with_points, domain, joints)
    except (_Refusal, ParseError) as error:
        return _make_refused_answer(error, text, "conditions", tree, None)
    return ParsedAnswer(text, None, tree)


def _require_conditions(tree: Node, text: str, domain: Domain, joints: Sequence[str]) -> None:
    """Raise _Refusal or ParseError if the tree is not a set of conditions on the joints."""
    if replace_decimal_commas(text) != text:
        reason = "a comma between two digits can be a decimal comma or separate two numbers"
        raise _AmbiguousAnswer(f"{reason}; write 0.5, or 0, 5 with a space")
    example = f"{joints[-1]} = 0 or {joints[-1]} = pi/3"
    alternatives = tree.args if tree.kind in ("list", "set", "or") else (tree,)
    bare_formula = next((node for node in alternatives if _is_bare_formula(node, joints)), None)
    if bare_formula is not None:
        formula = format_tree(bare_formula)[:_MAX_LENGTH_SHOWN]
        advice = f"write the joint values at which it is zero, such as {example}, or an equation, {formula} = 0"
        raise _Refusal(f"{formula} is not a condition; {advice}")
    if unknown := find_names(tree) - set(domain.roles) - set(joints) - set(WHOLE_NUMBER_NAMES):
        advice = f"write conditions on {', '.join(joints)}, such as {example}; k stands for any whole number"
        raise _Refusal(f"{name_unknown_symbols(unknown)}; {advice}")
    if joint := _find_ambiguous_joint(tree, joints):
        reason = f"a product with {joint} between two equals signs is ambiguous"
        raise _AmbiguousAnswer(f"{reason}; write a comma or 'and' between two conditions")
    parse_typed_set(assign_values_to_joint(tree, joints), joints)


def _find_ambiguous_joint(tree: Node, joints: Sequence[str]) -> str:
    """Return a joint that may belong to two conditions, as theta2 does in theta1 = 0 theta2 = 0; "" if there is none.

    The parser takes this text for theta1 = 0*theta2 = 0, so such a joint is the last factor between two equals signs.
    """
    products = (side for node in iterate_nodes(tree) for side in list_equation_sides(node)[1:-1] if side.kind == "*")
    factors = (product.args[1] for product in products)
    return next((str(factor.value) for factor in factors if factor.kind == "name" and factor.value in joints), "")


_MAX_LENGTH_SHOWN = 60
"""Maximum number of characters of a formula that are shown in a message."""


def _is_bare_formula(node: Node, joints: Sequence[str]) -> bool:
    """Return whether a node is a formula of the joints that is not equated to anything."""
    is_formula = node.kind in ("+", "-", "*", "/", "^", "neg", "call") and find_nonscalar(node) is None
    return is_formula and bool(find_names(node) & set(joints))


def _drop_blanks(node: Node) -> Node:
    """Return conditions without blanks, and without statements that are no conditions: det J = 0 and k in Z.

    The dots in 0, pi, … are a blank.
    """
    if node.kind in ("eq", "in", "pair") and node.args[1].kind in ("list", "set"):
        return node.with_args((node.args[0], _drop_blanks(node.args[1])))
    if node.kind not in ("and", "or", "list", "set"):
        return node
    kept_args = tuple(arg for arg in node.args if not _has_no_content(arg)) or node.args
    if node.kind in ("and", "or") and len(kept_args) == 1:
        return _drop_blanks(kept_args[0])
    return Node(node.kind, kept_args if node.kind == "and" else tuple(map(_drop_blanks, kept_args)), node.value)


def _substitute_whole_numbers(node: Node) -> Node:
    """Substitute the listed values of a whole number into conditions, as in theta2 = k*pi, k = 0, 1.

    If dots follow the values, as in k = 0, 1, 2, …, the symbol k remains and stands for any whole number. Raises
    ParseError if the result is too long.
    """
    index = next((i for i, arg in enumerate(node.args) if _lists_whole_numbers(arg)), 0) if node.kind == "list" else 0
    # Only values that follow a condition, and are followed by no other statement, are substituted.
    if index == 0 or any(arg.kind in ("eq", "in", "and", "or", "dict", "list") for arg in node.args[index + 1 :]):
        return node
    name, value_node = node.args[index].args
    values = [*(value_node.args if value_node.kind in ("list", "set") else (value_node,)), *node.args[index + 1 :]]
    conditions = Node("list", node.args[:index])
    if any(map(has_blank, values)):
        return conditions
    numbers = [number for value in values for number in (value.args if value.kind == "set" else (value,))]
    if count_nodes(conditions) * len(numbers) > LIMITS["nodes_of_results"]:
        raise ParseError("the conditions are too long, or they contain too many whole numbers")
    return Node("list", tuple(arg for value in numbers for arg in replace_names(conditions, {name.value: value}).args))


def _lists_whole_numbers(node: Node) -> bool:
    """Return whether a node lists the values of a whole number, as in k = 0, 1 or k in {0, 1}."""
    return node.kind in ("eq", "in") and node.args[0].value in WHOLE_NUMBER_NAMES and node.args[1].kind != "name"


def _has_no_content(node: Node) -> bool:
    """Return whether an entry is blank, or only says that det J is zero, k a whole number, or a joint variable real."""
    names_on_left = find_names(node.args[0]) if node.kind == "eq" else set[str]()
    if names_on_left and names_on_left <= set(VOCABULARY["determinant"]):
        return True
    if node.kind == "in" and node.args[1].value in VOCABULARY["number_sets"]:
        return True
    if node.kind == "in" and node.args[0].value in WHOLE_NUMBER_NAMES:
        return node.args[1].value in VOCABULARY["whole_number_sets"]
    has_several_values = node.kind in ("eq", "in", "pair") and node.args[1].kind in ("list", "set")
    return has_blank(node) and not has_several_values


def assign_values_to_joint(node: Node, joints: Sequence[str]) -> Node:
    """Assign values without a joint, as in {0, pi}, to the only joint. Raises ParseError if there are several joints.

    In that case, the student has to name the joint, because qdot must not guess the joint from the reference.
    """
    values = node.args if node.kind in ("list", "set") else (node,)
    if not values or any(_is_condition(value, joints) for value in values):
        return node
    if len(joints) != 1:
        raise ParseError(f"say which joint variable has these values, for example {{{joints[-1]}: [0, pi/3]}}")
    return Node("in", (Node("name", value=joints[0]), Node("set", tuple(values))))


OR_HINT = "commas between conditions mean 'or'; write 'and' between conditions that must hold together"
"""Advice if a set of conditions would be more correct with "and" instead of commas."""


def combine_with_and(node: Node, joints: Sequence[str]) -> Node | None:
    """Return conditions with "and" instead of commas between different joints; None if commas can only mean "or".

    Conditions on the same joints remain alternatives. A value without a joint belongs to the joint named before it.
    """
    if node.kind != "list":
        return None
    groups: dict[frozenset[str], list[Node]] = {}
    current_joints: frozenset[str] = frozenset()
    for condition in node.args:
        current_joints = frozenset(find_names(condition) & set(joints)) or current_joints
        groups.setdefault(current_joints, []).append(condition)
    return Node("and", tuple(Node("list", tuple(group)) for group in groups.values())) if len(groups) > 1 else None


def _is_condition(node: Node, joints: Sequence[str]) -> bool:
    """Return whether a node is a condition or contains a joint, rather than being a value."""
    return node.kind in ("eq", "in", "dict", "and", "or", "list", "set") or bool(find_names(node) & set(joints))


_BEFORE_GROUPING = re.compile(r"(?:[-+*/^=·−]|\b(?:sin|cos|tan|sqrt|exp|abs|asin|acos|atan|arcsin|arccos|arctan))\s*$")
"""Matches text before a bracket that only groups: an operator, or a function of one argument."""
_BRACKET_CONTEXT = 40
"""Number of characters inspected on each side of a bracket; a limit keeps the search fast in long texts."""
_BEFORE_CALL, _AFTER_GROUPING = re.compile(r"\w\s*$"), re.compile(r"\s*[-+*/^·−]")
"""Match a name before a bracket, which makes the bracket a call, and an operator after a bracket that only groups."""


def replace_decimal_commas(text: str) -> str:
    """Return the text with decimal commas, as in 0,5, replaced by points.

    Commas between entries of a list, or between arguments of a function, don't change.

    >>> replace_decimal_commas("a1*(0,06*s2 - 1,5)"), replace_decimal_commas("[0,5]")
    ('a1*(0.06*s2 - 1.5)', '[0,5]')
    >>> replace_decimal_commas("atan2(1,2)")
    'atan2(1,2)'
    """
    if "," not in text:
        return text
    closing_brackets = _find_closing_brackets(text)
    characters: list[str] = []
    is_grouping: list[bool] = []  # for each open bracket, whether it only groups
    for index, (previous_char, char, next_char) in enumerate(zip(f" {text}", text, f"{text[1:]} ", strict=False)):
        if char in "([{":
            is_grouping.append(char == "(" and _is_grouping_bracket(text, index, closing_brackets.get(index)))
        elif char in ")]}" and is_grouping:
            is_grouping.pop()
        is_between_digits = previous_char.isdecimal() and next_char.isdecimal()
        characters.append("." if char == "," and is_between_digits and (not is_grouping or is_grouping[-1]) else char)
    return "".join(characters)


def _find_closing_brackets(text: str) -> dict[int, int]:
    """Return the index of each bracket's closing bracket; brackets that are never closed are omitted."""
    closing_brackets, open_brackets = dict[int, int](), list[int]()
    for index, char in enumerate(text):
        if char in "([{":
            open_brackets.append(index)
        elif char in ")]}" and open_brackets:
            closing_brackets[open_brackets.pop()] = index
    return closing_brackets


def _is_grouping_bracket(text: str, start: int, end: int | None) -> bool:
    """Return whether a bracket only groups a formula, because an operator or a function of one argument is beside it.

    The bracket is opened at the index `start` and closed at `end`, which is None if the bracket is never closed.
    """
    text_before = text[max(0, start - _BRACKET_CONTEXT) : start]
    text_after = "" if end is None else text[end + 1 : end + _BRACKET_CONTEXT]
    is_operand = not _BEFORE_CALL.search(text_before) and _AFTER_GROUPING.match(text_after)
    return bool(_BEFORE_GROUPING.search(text_before) or is_operand)


def read_any(text: str) -> ParsedAnswer:
    """Parse an answer without knowing its expected type."""
    parsed = _parse(text, Domain({}))
    return parsed if parsed.tree is None else replace(parsed, rows=_find_rows(parsed.tree))


# --- helpers for the functions above that parse answers ---


def _parse(text: str, domain: Domain) -> ParsedAnswer:
    """Parse a text into an answer that has only a `tree`; refuse a text that is blank or can't be parsed."""
    if not text.strip():
        return ParsedAnswer(text, make_missing_judgement())
    try:
        tree = parse_formula(text, domain.roles)
    except ParseError as error:
        return refuse(text, describe_parse_error(error))
    return ParsedAnswer(text, BLANK_JUDGEMENT) if _contains_only_blanks(tree) else ParsedAnswer(text, None, tree)


BLANK_JUDGEMENT = make_missing_judgement("you left the answer blank")
"""The judgement on an answer that contains only placeholders."""


def describe_parse_error(error: ParseError, expected_type: str = "") -> str:
    """Return the reason for refusing an answer that can't be parsed, or can't be parsed as the expected type."""
    if isinstance(error, UndefinedValue):
        return str(error)
    return f"qdot couldn't parse your answer{expected_type and f' as {expected_type}'}: {error}"


def _unwrap(node: Node, domain: Domain) -> Node:
    """Return the entry of a 1 x 1 matrix such as [[a]] or {"det": a}; return any other node unchanged."""
    while node.kind in ("list", "dict") and len(node.args) == 1:
        (inner_node,) = node.args
        if inner_node.kind == "pair" and inner_node.args[0].value in domain.roles:
            return node  # a symbol of the problem is not the name of an entry
        node = inner_node.args[1] if inner_node.kind == "pair" else inner_node
    return node


def _contains_only_blanks(node: Node) -> bool:
    if node.kind in ("list", "set"):
        return all(map(_contains_only_blanks, node.args)) and bool(node.args)
    return node.kind == "blank"


def _find_value(tree: Node, domain: Domain, labels: Sequence[str] = ()) -> Node:
    """Return the value in "J = …", "… = J" or "det: …"; return any other tree unchanged.

    The name must be either the only name in `labels` or a name that the student made up. Before a matrix, it may also
    look like a symbol, as M looks like the mass m, because a symbol stands for a number and can't equal a matrix.
    """
    statement = tree.args[0] if tree.kind == "dict" and len(tree.args) == 1 else tree
    sides = list_equation_sides(statement) or (statement.args if statement.kind == "pair" else ())
    if not sides or (any(find_names(side) & set(domain.roles) for side in sides[1:-1]) and not find_names(sides[-1])):
        return tree  # det J = a1*a2*sin(theta2) = 0 is an equation for theta2
    for name, value in ((sides[0], sides[-1]), (sides[-1], sides[0])):  # ignores sides in between
        has_no_symbol = not find_names(name) & set(domain.roles)
        is_student_name = has_no_symbol and (_is_name(name) or _contains_only_jacobian_entries(name))
        is_label = name.kind == "name" and [_normalize_label(str(name.value))] == list(map(_normalize_label, labels))
        if is_student_name or is_label or (value.kind == "list" and _is_symbol_or_function(name)):
            return value
    return tree


def _remove_capital_name(text: str, domain: Domain) -> str:
    """Return the text after the name M in "M = m*a1" if the problem has a symbol m, as which M would be parsed.

    Any other text is returned unchanged.
    """
    match = re.fullmatch(r"\s*([A-Z]\w*)\s*:?=([^=]+)", text, re.DOTALL)
    has_other_meaning = match is not None and match[1] not in domain.roles and match[1].lower() in domain.roles
    return match[2] if match is not None and has_other_meaning else text


def _find_wrong_component(tree: Node, labels: Sequence[str]) -> str:
    """Return the name before a formula if it is a velocity component other than the only label; else ""."""
    if len(labels) != 1 or _normalize_label(labels[0]) not in VELOCITY_NAMES[:3]:
        return ""
    while tree.kind in ("list", "set", "dict") and len(tree.args) == 1:
        tree = tree.args[0]
    if tree.kind not in ("eq", "pair") or tree.args[0].kind != "name":
        return ""
    name = str(tree.args[0].value)
    return name if _normalize_label(name) in {*VELOCITY_NAMES} - {_normalize_label(labels[0])} else ""


def _is_name(node: Node) -> bool:
    """Return whether a node is a name rather than a formula: words, dx/dq, |J|, or a power of a name such as J^-1."""
    node = node.args[0] if node.kind == "call" and node.value == "abs" else node
    while node.kind in ("*", "/") and node.args[1].kind == "name":
        node = node.args[0]
    return node.kind == "name" or (node.kind == "^" and node.args[0].kind == "name")


def _is_symbol_or_function(node: Node) -> bool:
    """Return whether a node is a single name, or a function of all joint variables such as M(q)."""
    symbol, argument = node.args if node.kind == "*" else (node, None)
    return symbol.kind == "name" and (argument is None or argument.value in VOCABULARY["joints"])


def _contains_only_jacobian_entries(node: Node) -> bool:
    """Return whether all names in a formula are entries of the Jacobian, as in J11*J22 - J12*J21."""
    return bool(find_names(node)) and all(_JACOBIAN_ENTRY.fullmatch(name) for name in find_names(node))


_JACOBIAN_ENTRY = re.compile(r"[jJ]_?[1-6]{2}")
"""Matches the name of an entry of the Jacobian, such as J12."""


def _split_chains(tree: Node, expected_names: Sequence[str]) -> Node:
    """Split z0 = z1 = a into z0 = a and z1 = a if both names are expected, also inside a list."""
    if tree.kind not in ("and", "list", "set"):
        return tree
    labels, statements = set(map(_normalize_label, expected_names)), list[Node]()
    is_chain = tree.value == EQUATION_CHAIN
    for node in [tree] if is_chain else tree.args:
        *sides, value = list_equation_sides(node) or (node,)
        are_expected = (side.kind == "name" and _normalize_label(str(side.value)) in labels for side in sides)
        is_named = bool(sides) and all(are_expected)
        statements += [Node("eq", (name, value)) for name in sides] if is_named else [node]
    return tree if is_chain and len(statements) == 1 else Node(tree.kind, tuple(statements))


def _find_rows(tree: Node) -> Matrix | None:
    """Return the entries of an answer in rows and columns, without their names; None if there are no such rows."""
    with suppress(ParseError):
        return as_matrix(_remove_labels(tree))
    return None


_SYMBOL_LETTERS = {"a", "alpha", "d", "q", "theta"}
"""The letters of the symbols of an arm, such as d1. A name with such a letter is a symbol, not a numbered entry."""


def _sort_by_number(entries: Mapping[str, Node]) -> tuple[Node, ...]:
    """Return entries with names such as tau1, f2, f3 in the order of their numbers 1, 2, …; () for other names."""
    matches = [re.fullmatch(r"([^\W\d]+)(\d+)", name) for name in entries]
    numbers = [match[2] for match in matches if match and match[1] not in _SYMBOL_LETTERS]
    positions = [str(i + 1) for i in range(len(entries))]
    if set(numbers) != set(positions):
        return ()
    entry_by_number = dict(zip(numbers, entries.values(), strict=True))
    return tuple(entry_by_number[position] for position in positions)


def _remove_labels(node: Node, labels: Sequence[str] = (), shape: MatrixShape = (0, 0)) -> Node:
    """Return the entries of {qd1: …, qd2: …}, [qd1 = …, qd2 = …] or [(qd1, …), (qd2, …)] in the order of `labels`.

    The entries may be inside another list, or joined by "and". The rows of a matrix may be named row1, row2, …, and the
    entries of a matrix J11, J12, …. `shape` has no columns if the answer should not be a matrix or vector. A node
    without names is returned unchanged. Raises ParseError for other names.
    """
    while node.kind in ("list", "set") and len(node.args) == 1 and node.args[0].kind in ("dict", "list"):
        if node.kind == "list" and node.args[0].kind == "list" and not all(map(_is_named, node.args[0].args)):
            break  # a matrix with a single row
        node = node.args[0]
    is_sequence = node.kind in ("dict", "list", "set", "and")
    if not is_sequence or not all(_is_named(arg, allows_tuple=True) for arg in node.args):
        return node
    entries = {_normalize_label(str(arg.args[0].value)): arg.args[1] for arg in node.args}
    if len(entries) != len(node.args):
        if not all(map(_is_named, node.args)):
            return node  # (a, …) and (a, …) may be rows that begin with the same symbol
        names = [str(arg.args[0].value) for arg in node.args]
        normalized_names = list(map(_normalize_label, names))
        repeated_name = next(name for name in names if normalized_names.count(_normalize_label(name)) > 1)
        raise ParseError(f"{repeated_name} appears twice; write each entry once")
    expected_names = [_normalize_label(label) for label in labels]
    if expected_names and set(entries) == set(expected_names):
        return Node("list", tuple(entries[label] for label in expected_names))
    rows, columns = shape
    row_names = [f"row{i + 1}" for i in range(rows)]
    entry_names = [f"j{i + 1}{j + 1}" for i in range(rows) for j in range(columns)]
    if columns > 1 and set(entries) == set(row_names):
        return Node("list", tuple(entries[name] for name in row_names))
    for names_in_order in (row_names, entry_names):
        if columns and set(entries) == set(names_in_order):
            ordered_entries = [entries[name] for name in names_in_order]
            return make_rows(ordered_entries[i : i + columns] for i in range(0, len(ordered_entries), columns))
    if not entries or not all(map(_is_named, node.args)):
        return node
    has_all_entries = not labels and columns <= 1 and len(entries) == rows
    if has_all_entries and (numbered_entries := _sort_by_number(entries)):
        return Node("list", numbered_entries)
    expected_words = f", but the question asks for {', '.join(labels)}" if labels else ""
    advice = f"write your answer like {_make_example(shape)}" if columns else "write only the entries"
    raise ParseError(f"you named the entries {', '.join(list(entries)[:_MAX_NAMES_SHOWN])}{expected_words}; {advice}")


def _stack_vectors(node: Node, shape: MatrixShape, labels: Sequence[str], columns: Sequence[str]) -> Node | None:
    """Return the twist that v = […], ω = […] define, or the matrix with the columns z0 = […], z1 = […].

    The vectors may be in any order. The columns of a Jacobian may also be named J1, J2, …, and the columns with screws
    S1, S2, …. Returns None for anything else.
    """
    if node.kind not in ("dict", "list", "set", "and") or not all(map(_find_entry_name, node.args)):
        return None
    components = [_normalize_label(label) for label in labels]
    first_letter = _normalize_label(_find_entry_name(node.args[0]))[:1] if node.args else ""
    has_numbered_columns = not columns and shape[1] > 1 and first_letter in ("j", "s")
    column_names = [f"{first_letter}{i + 1}" for i in range(shape[1])] if has_numbered_columns else columns
    is_twist = components in ([*VELOCITY_NAMES], [*VELOCITY_NAMES[3:], *VELOCITY_NAMES[:3]])
    expected_names = [components[0][0], components[3][0]] if is_twist else list(map(_normalize_label, column_names))
    vectors = {_normalize_label(_find_entry_name(arg)): _find_vector_entries(arg.args[1]) for arg in node.args}
    if not expected_names or len(node.args) != len(expected_names) or set(vectors) != set(expected_names):
        return None
    if any(len(vector) * (2 if is_twist else 1) != shape[0] for vector in vectors.values()):
        return None
    ordered_vectors = [vectors[name] for name in expected_names]
    if is_twist:
        return Node("list", tuple(entry for vector in ordered_vectors for entry in vector))
    return make_rows(zip(*ordered_vectors, strict=True))


def _find_entry_name(node: Node) -> str:
    """Return the name before an entry, or "". S1 is the name of a screw here, although S1 was parsed as sin(theta1)."""
    name = node.args[0] if node.kind in ("pair", "eq") else node
    if node.kind in ("pair", "eq") and name.kind == "call" and name.value == "sin" and name.args[0].kind == "name":
        return str(name.args[0].value).replace("theta", "s")
    return str(name.value) if _is_named(node) else ""


def _find_vector_entries(node: Node) -> tuple[Node, ...]:
    """Return the entries of a row or column vector; () for anything else."""
    rows = node.args if node.kind == "list" else ()
    entries = [row.args[0] if row.kind == "list" and len(row.args) == 1 else row for row in rows]
    return tuple(entries) if not any(entry.kind == "list" for entry in entries) else ()


def _is_named(node: Node, allows_tuple: bool = False) -> bool:
    """Return whether a node is an entry with a name, as in qd1 = 0 or qd1: 0 or, if `allows_tuple`, in (qd1, 0)."""
    may_be_named = node.kind in ("pair", "eq") or (allows_tuple and node.kind == "list" and len(node.args) == 2)
    return may_be_named and node.args[0].kind == "name"


def _normalize_label(name: str) -> str:
    """Return the normalized name of an entry: P_x, p_x and px become x; v_x and x_dot become vx; ω_x becomes wx."""
    label = name.replace("_", "").lower()
    label = VOCABULARY["velocities"].get(label, label)
    for spelled_name, letter in VOCABULARY["spelled_letters"].items():
        label = label.replace(spelled_name, letter)
    if (point_match := PATTERNS["point_of_entry"].fullmatch(label)) is not None:
        return point_match.group(1)
    return label.removeprefix("p") if len(label) > 1 else label


def _has_split_decimals(rows: Matrix, expected: tuple[int, int]) -> bool:
    """Return whether decimal commas seem to have split every number: Python reads [0,5, -1,25] as [0, 5, -1, 25]."""
    entries = list(itertools.chain.from_iterable(rows))
    numbers = [entry.args[0] if entry.kind == "neg" else entry for entry in entries]
    has_whole_numbers = all(number.kind == "number" and number.value.denominator == 1 for number in numbers)
    are_fractions_unsigned = all(entry.kind == "number" for entry in entries[1::2])
    return len(entries) == 2 * math.prod(expected) and has_whole_numbers and are_fractions_unsigned


def _require_shape(rows: Matrix, expected: tuple[int, int], text: str) -> Matrix:
    """Return rows in the expected shape; a row vector becomes a column vector. Raises _Refusal for another shape."""
    shape = (len(rows), len(rows[0]))
    if expected[1] == 1 and shape == (1, expected[0]):
        return [[entry] for entry in rows[0]]
    if shape == expected:
        return rows
    hint = f"; write it like {_make_example(expected)}"
    if shape == expected[::-1] and 1 not in expected:  # a transposed matrix
        hint = ", so its entries can't be compared"
    if shape[0] * shape[1] > expected[0] * expected[1] and re.search(r"\d,\d", text):
        hint = _COMMA_HINT
    elif _has_split_decimals(rows, expected):
        hint = "; write decimals with a point, like 0.5"
    if expected[1] == 1:
        expected_words = f"but it must have {expected[0]}"
        if 1 not in shape:
            raise _Refusal(f"your answer is {shape[0]} × {shape[1]}, {expected_words} entries{hint}")
        noun = "entry" if max(shape) == 1 else "entries"
        raise _Refusal(f"your answer has {max(shape)} {noun}, {expected_words}{hint}")
    actual_size, expected_size = (f"{row_count} × {column_count}" for row_count, column_count in (shape, expected))
    raise _Refusal(f"your answer is {actual_size}, but it must be {expected_size}{hint}")


_COMMA_HINT = "; if 0,5 is a number, separate entries with semicolons, or with commas and spaces, like [0,5; 1,25]"
"""Advice on an answer with more entries than expected and with commas between digits."""


def _make_example(shape: MatrixShape, entry: str = "a") -> str:
    """Return an example of a typed answer of this shape: [a, b], or [[a, b], [c, d]]."""
    rows, columns = shape
    if max(shape) > _MAX_SIZE_SHOWN:
        row = entry if columns == 1 else f"[{entry}, {'…, ' if columns > 2 else ''}{entry}]"  # too many to show
        return f"[{row}, …, {row}] with {rows} {'entries' if columns == 1 else f'rows of {columns}'}"
    letters = iter("abcdefghi") if entry == "a" else iter((entry,) * 9)
    row_texts = [", ".join(next(letters) for _ in range(columns)) for _ in range(rows)]
    return f"[{', '.join(row_texts)}]" if columns == 1 else f"[{', '.join(f'[{row}]' for row in row_texts)}]"


_MAX_SIZE_SHOWN = 3
"""Maximum number of rows or columns of an example that is shown completely."""


def _require_scalars(rows: Matrix) -> None:
    """Raise ParseError if any entry is a list or a statement; blank entries are allowed."""
    for entry in (entry for row in rows for entry in row if not has_blank(entry)):
        refuse_nonscalars(entry)


def _find_symbols(rows: Matrix) -> set[str]:
    """Return the names of the variables in the entries."""
    return set().union(*(find_names(entry) for row in rows for entry in row))
