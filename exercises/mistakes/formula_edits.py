"""Mistakes in finished formulas: an entry was simplified, copied or typed with one error.

An edit changes one sign, term, factor, sine, cosine or angle of an entry, which may first be expanded into a sum of
products. Some mistakes are made throughout, such as in every angle of all entries (`edit_all_entries`). Formulas are
trees of nodes (`formula.trees`), and a "trig" is a sine or cosine. In the names of mistakes, "-typed" means "typed
wrongly".
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations, pairwise
from math import prod
from operator import add, sub

from qdot.exercises.formula.algebra import expand_terms, split_terms
from qdot.exercises.formula.trees import (
    ONE,
    ZERO,
    Node,
    count_nodes,
    find_names,
    format_tree,
    iterate_nodes,
    make_number,
)
from qdot.exercises.mistakes.base import join_words

MAX_ENTRY_NODES = 400
"""Maximum number of nodes of an entry that is edited."""
MAX_TERMS = 40
"""Maximum number of terms of an entry that is expanded into a sum of products."""

TRIG_FUNCTIONS = ("sin", "cos")
TWO, HALF, DEGREES_PER_RADIAN = make_number(2), make_number(Fraction(1, 2)), make_number(180) / Node("name", value="pi")
DERIVATIVE_MISTAKES = frozenset({"trig-derived", "trig-not-derived"})
"""The mistakes that can occur only in derivatives."""


@dataclass(frozen=True)
class Edit:
    """An entry with one mistake, the name of the mistake, and the omitted term or factor, if any."""

    mistake: str
    entry: Node
    missing_node: Node | None = None

    @property
    def term_words(self) -> str:
        """A phrase that identifies the omitted term or factor; "" if nothing is omitted."""
        return "" if self.missing_node is None else describe_term(self.missing_node)


def describe_term(term: Node) -> str:
    """Return a phrase such as " that contains a1" with the lengths, rates and decimals of a term or factor.

    If there are none, the phrase names the joints; if there are none either, it is empty.
    """
    if term.kind in ("number", "decimal"):
        return f" ({format_tree(term)})"
    names = [*dict.fromkeys(_find_names_outside_trigs(term))] or sorted(find_names(term) - {"pi"})
    return f" that contains {join_words(names)}" if names else ""


def _find_names_outside_trigs(node: Node) -> Iterator[str]:
    """Yield the names and decimals of a term, except those inside sines and cosines."""
    if node.kind == "decimal" or (node.kind == "name" and node.value != "pi"):
        yield format_tree(node)
    elif not _is_trig(node):
        for arg in node.args:
            yield from _find_names_outside_trigs(arg)


def _is_trig(node: Node) -> bool:
    return node.kind == "call" and node.value in TRIG_FUNCTIONS


# --- one mistake in an entry ---


def edit_entry(entry: Node, symbols: Iterable[str] = ()) -> Iterator[Edit]:
    """Yield the edits of an entry, each with one mistake.

    A mistake may confuse a name with one of the `symbols`. Entries with more than MAX_ENTRY_NODES nodes have no edits.
    """
    if count_nodes(entry) > MAX_ENTRY_NODES:
        return
    yield Edit("entry-halved", entry / TWO)
    yield Edit("entry-doubled", TWO * entry)
    yield from _edit_each_node(entry, partial(_mistype_symbol, sorted(symbols)))
    yield from _edit_each_node(entry, _edit_node)
    yield from _edit_all_trigs(entry)
    coefficient = _find_numeric_factor(entry)
    if coefficient not in (-1, 0, 1):
        yield Edit("factor-missing", entry / make_number(abs(coefficient)))
        yield Edit("number-inverted", entry / make_number(coefficient**2))  # 1/coefficient instead of the coefficient
    yield from _exchange_similar_symbols(entry, symbols)
    yield from _edit_each_node(entry, partial(_add_joint_to_angle, sorted(symbols)))
    for angle in dict.fromkeys(_find_angles(entry)):
        for new_angle in _edit_angle(angle):
            yield Edit("angle-typed", _change_trigs(entry, partial(_replace_angle, {angle: new_angle})))
    terms = expand_terms(entry, MAX_TERMS)
    yield Edit("term-sign-typed" if terms is not None and len(terms) == 1 else "entry-sign", -entry)
    if terms is not None and len(terms) > 1:
        for k, term in enumerate(terms):
            other_terms = [*terms[:k], *terms[k + 1 :]]
            yield Edit("term-sign-typed", _add_terms([*other_terms, -term]))
            yield Edit("term-missing", _add_terms(other_terms), term)


def _edit_all_trigs(entry: Node) -> Iterator[Edit]:
    """Yield the edits that make the same mistake in all sines and cosines of an entry, if there are several."""
    angles = list(_find_angles(entry))
    if len(angles) > 1:
        yield Edit("trigs-typed", _change_trigs(entry, _swap_trig))
    sums = [angle for angle in dict.fromkeys(angles) if len(split_terms(angle)) > 1]
    for keeps_constants in (True, False):
        new_angles = {angle: _keep_last_angle(keeps_constants)(angle) for angle in sums}
        if sum(new_angle != angle for angle, new_angle in new_angles.items()) > 1:
            yield Edit("angles-typed", _change_trigs(entry, partial(_replace_angle, new_angles)))


def _edit_each_node(node: Node, edit_node: Callable[[Node], Iterator[Edit]]) -> Iterator[Edit]:
    """Yield the edits of a tree that change one of its nodes."""
    yield from edit_node(node)
    for k, arg in enumerate(node.args):
        for edit in _edit_each_node(arg, edit_node):
            yield replace(edit, entry=node.with_args([*node.args[:k], edit.entry, *node.args[k + 1 :]]))


def _edit_node(node: Node) -> Iterator[Edit]:
    """Yield the edits of a sine or cosine, or of an operation that is not part of an angle."""
    if _is_trig(node):
        other_trig = _swap_trig(node)  # for a cosine, the derivative is -other_trig
        yield Edit("trig-typed", other_trig)
        yield Edit("trig-derived" if node.value == "sin" else "trig-not-derived", other_trig)
        yield Edit("trig-not-derived" if node.value == "sin" else "trig-derived", -other_trig)
        yield Edit("trig-and-sign", -other_trig)
        for angle in _edit_angle(node.args[0]):
            yield Edit("angle-typed", node.with_args([angle]))
        yield from _split_trig_of_sum(node)
    elif node.kind in _OPERATIONS and not _is_angle(node):
        yield from _OPERATIONS[node.kind](node)


def _edit_sum(node: Node) -> Iterator[Edit]:
    """Yield the edits of a sum or difference of two terms, each of which may be a sum itself."""
    first_term, second_term = node.args
    yield Edit("term-sign-typed", Node("-" if node.kind == "+" else "+", node.args))
    yield Edit("term-sign-typed", Node(node.kind, (-first_term, second_term)))
    yield Edit("term-missing", first_term, second_term)
    yield Edit("term-missing", second_term if node.kind == "+" else -second_term, first_term)
    yield Edit("sum-multiplied", _multiply(split_terms(node)))
    yield from _add_unlike_terms(node)
    if second_term.kind == "*" and node.kind == "-":  # without a bracket, the minus applies to the first term only
        for edit in _edit_product(second_term):
            if edit.mistake == "bracket-missing":
                first_factor, second_factor = edit.entry.args
                args = [first_term - first_factor, second_factor]
                yield replace(edit, entry=edit.entry.with_args(args))


def _add_unlike_terms(node: Node) -> Iterator[Edit]:
    """Yield the edit that adds a number to the coefficient of an unlike term: 0.6 x instead of 0.2 + 0.4 x."""
    combine = add if node.kind == "+" else sub
    for constant, term in (node.args, node.args[::-1]):
        if constant.kind in ("number", "decimal") and find_names(term):
            coefficient = _find_numeric_factor(term)
            factor = _find_numeric_factor(constant) / coefficient if coefficient else Fraction(0)
            yield Edit("unlike-terms-added", combine(term, make_number(factor) * term))


def _edit_product(node: Node) -> Iterator[Edit]:
    """Yield the edits of a product of two factors."""
    first_factor, second_factor = node.args
    yield from _drop_denominator_bracket(first_factor, second_factor)
    if _is_trig(second_factor) and len(split_terms(second_factor.args[0])) > 1:
        first_trig, *later_trigs = _make_trig_of_each_term(second_factor)  # s1 + s2 instead of s12, without a bracket
        yield Edit("sum-of-angles-split", first_factor * first_trig + _add_terms(later_trigs))
    for factor, other_factor in (node.args, node.args[::-1]):
        yield Edit("factor-missing", other_factor, factor)
        if factor.kind in ("+", "-"):  # the other factor multiplies only one of the terms
            combine, (first_term, second_term) = add if factor.kind == "+" else sub, factor.args
            yield Edit("trigs-in-factor", _change_trigs(factor, _swap_trig) * other_factor)
            yield Edit("bracket-missing", combine(first_term, second_term * other_factor))
            yield Edit("bracket-missing", combine(other_factor * first_term, second_term))


def _edit_quotient(node: Node) -> Iterator[Edit]:
    """Yield the edits that divide only some terms, divide by only one operand, or omit or invert the divisor."""
    numerator, denominator = node.args
    terms = split_terms(numerator)
    quotients = [term / denominator for term in terms]
    for k in range(len(terms)) if 1 < len(terms) <= MAX_TERMS else ():  # divide only one term, or all but one
        yield Edit("bracket-missing", _add_terms([*terms[:k], quotients[k], *terms[k + 1 :]]))
        yield Edit("bracket-missing", _add_terms([*quotients[:k], terms[k], *quotients[k + 1 :]]))
    if denominator.kind in ("+", "-", "*"):  # divide by only one of the two operands
        for divisor, remainder in (denominator.args, denominator.args[::-1]):
            yield Edit("bracket-missing", Node(denominator.kind, (numerator / divisor, remainder)))
    is_nonzero_number = denominator.kind in ("number", "decimal") and bool(denominator.value)
    missing_factor = make_number(1 / Fraction(denominator.value)) if is_nonzero_number else denominator
    yield Edit("factor-missing", numerator, missing_factor)
    yield Edit("factor-missing", numerator * denominator)


def _edit_power(node: Node) -> Iterator[Edit]:
    if node.args[1] == TWO:
        yield Edit("square-missing", node.args[0])
        yield Edit("square-missing", TWO * node.args[0])


def _edit_negative(node: Node) -> Iterator[Edit]:
    (operand,) = node.args
    yield Edit("term-sign-typed", operand)
    yield from _drop_denominator_bracket(make_number(-1), operand)
    terms = split_terms(operand.args[0]) if operand.kind == "/" else []
    if 1 < len(terms) <= MAX_TERMS:  # negate only the first term, and divide only the last term
        yield Edit("bracket-missing", _add_terms([-terms[0], *terms[1:-1], terms[-1] / operand.args[1]]))


def _drop_denominator_bracket(factor: Node, quotient: Node) -> Iterator[Edit]:
    """Yield the edit that omits the brackets around the denominator of a quotient, which is multiplied by a factor."""
    if quotient.kind == "/" and quotient.args[1].kind in ("+", "-"):
        numerator, denominator = quotient.args
        first_term = factor * numerator / denominator.args[0]
        yield Edit("bracket-missing", denominator.with_args([first_term, denominator.args[1]]))


_OPERATIONS: dict[str, Callable[[Node], Iterator[Edit]]] = {
    "+": _edit_sum, "-": _edit_sum, "*": _edit_product, "/": _edit_quotient, "^": _edit_power, "neg": _edit_negative,
}  # fmt: skip


def _find_numeric_factor(node: Node) -> Fraction:
    """Return the numeric factor of a product: 1 if there is none, and 0 if the product is divided by 0."""
    if node.kind in ("number", "decimal"):
        return Fraction(node.value)
    if node.kind == "neg":
        return -_find_numeric_factor(node.args[0])
    if node.kind in ("*", "/"):
        first_factor, second_factor = map(_find_numeric_factor, node.args)
        if node.kind == "*":
            return first_factor * second_factor
        return first_factor / second_factor if second_factor else Fraction(0)
    return Fraction(1)


def _mistype_symbol(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield the edits that replace a name by a similar symbol, such as theta1 by theta2."""
    for symbol in symbols if node.kind == "name" else ():
        if symbol != node.value and find_stem(symbol) == find_stem(str(node.value)):
            yield Edit("symbol-typed", Node("name", value=symbol))


def _exchange_similar_symbols(entry: Node, symbols: Iterable[str]) -> Iterator[Edit]:
    """Yield the edits that exchange two similar names in an entry."""
    present_symbols = sorted(find_names(entry) & set(symbols))
    for first_name, second_name in combinations(present_symbols, 2):
        if find_stem(first_name) == find_stem(second_name):
            first_leaf, second_leaf = Node("name", value=first_name), Node("name", value=second_name)
            yield Edit("symbol-typed", replace_nodes(entry, {first_leaf: second_leaf, second_leaf: first_leaf}.get))


def _add_joint_to_angle(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield the edits that add a joint variable to the angle of a sine or cosine, subtract it, or change its sign."""
    for joint in (Node("name", value=name) for name in symbols if _is_trig(node) and name.startswith("theta")):
        terms = [joint, -joint, TWO * joint]
        if find_names(node.args[0]) != {joint.value}:  # a single angle is no sum in which a sign may be wrong
            terms.append(-(TWO * joint))
        for term in terms:
            yield Edit("angle-typed", node.with_args([node.args[0] + term]))


def replace_each_trig(entry: Node, replacement: Callable[[Node], Node]) -> list[Node]:
    """Return copies of an entry; in each copy, `replacement` replaces one sine or cosine."""
    copies = [replacement(entry)] if _is_trig(entry) else []
    for k, arg in enumerate(entry.args):
        new_args = replace_each_trig(arg, replacement)
        copies += [entry.with_args([*entry.args[:k], new_arg, *entry.args[k + 1 :]]) for new_arg in new_args]
    return copies


def add_quarter_turn(node: Node) -> Node:
    """Return a sine or cosine with pi/2 added to its angle."""
    return _swap_trig(node) if node.value == "sin" else -_swap_trig(node)


def find_stem(name: str) -> str:
    """Return the first letters of a name, which similar names, such as theta1 and theta2 or fy and fz, share."""
    return name[:-1] if len(name) == 2 and name[-1] in "xyz" else name.rstrip("0123456789")


def _is_angle(node: Node) -> bool:
    """Return whether a tree is an angle: it contains pi or a joint angle outside of function calls."""
    if node.kind == "name":
        return node.value == "pi" or node.value.startswith("theta")
    return any(map(_is_angle, node.args)) and node.kind != "call"


def _split_trig_of_sum(node: Node) -> Iterator[Edit]:
    """Yield the edits that replace the sine or cosine of a sum by a sum or product of sines or cosines of its terms."""
    terms = split_terms(node.args[0])
    if len(terms) > 1:
        yield Edit("sum-of-angles-split", _add_terms(_make_trig_of_each_term(node)))
        yield Edit("sum-of-angles-split", _multiply(_make_trig_of_each_term(node)))
        signed_trigs = [-node.with_args(term.args) if term.kind == "neg" else node.with_args([term]) for term in terms]
        yield Edit("sum-of-angles-split", _add_terms(signed_trigs))  # the minus of a term is moved before the function
        yield Edit("bracket-missing", node.with_args([_add_terms(terms[:-1])]) + terms[-1])


def _make_trig_of_each_term(node: Node) -> list[Node]:
    """Return the sine or cosine of each term of an angle."""
    return [node.with_args([term]) for term in split_terms(node.args[0])]


def _multiply(factors: Sequence[Node]) -> Node:
    return prod(factors, start=ONE)


def _edit_angle(angle: Node) -> Iterator[Node]:
    """Yield an angle with one mistake in its terms.

    A term is omitted or has the wrong sign, a constant is scaled, the joint variables are multiplied instead of added,
    or only one of them remains.
    """
    terms = split_terms(angle)
    joint_terms, constants = _split_constants(terms)
    for k, term in enumerate(terms):
        other_terms = [*terms[:k], *terms[k + 1 :]]
        if other_terms:
            yield _add_terms(other_terms)
            if len(joint_terms) > 1 or term in constants:  # a single angle is no sum in which a sign may be wrong
                yield _add_terms([*other_terms, -term])
        for factor in (TWO, HALF, DEGREES_PER_RADIAN) if term in constants else ():
            yield _add_terms([*other_terms, factor * term])
    if len(joint_terms) > 1:
        yield _add_terms([_multiply(joint_terms), *constants])
    for term in joint_terms if len(terms) > 2 else ():
        yield term
        yield _add_terms([term, *constants])


def _split_constants(terms: Sequence[Node]) -> tuple[list[Node], list[Node]]:
    """Return the terms of an angle that contain joint variables, and the constant terms."""
    return [term for term in terms if find_names(term)], [term for term in terms if not find_names(term)]


# --- the same mistake in all entries ---


def edit_all_entries(rows: Sequence[Sequence[Node]]) -> Iterator[tuple[str, list[list[Node]]]]:
    """Yield the names of mistakes, each with all entries after this mistake.

    The mistake is made in every angle, or wherever a certain angle, rate or length occurs.
    """
    angles = list(dict.fromkeys(angle for row in rows for entry in row for angle in _find_angles(entry)))
    sums = [angle for angle in angles if len(split_terms(angle)) > 1]
    for name, change in _CHANGES_OF_ALL_ANGLES:
        new_angles = {angle: change(angle) for angle in sums}
        if any(new_angle != angle for angle, new_angle in new_angles.items()):
            yield name, _change_trigs_in_rows(rows, partial(_replace_angle, new_angles))
    yield "sum-of-angles-split", _change_trigs_in_rows(rows, lambda node: _multiply(_make_trig_of_each_term(node)))
    yield "sum-of-angles-split", _change_trigs_in_rows(rows, lambda node: _add_terms(_make_trig_of_each_term(node)))
    if len(angles) > 1:
        yield "all-sines-for-cosines", _change_trigs_in_rows(rows, _swap_trig)
    yield from _use_relative_rates(rows)
    for angle in angles:
        yield "trig-throughout", _change_trigs_in_rows(rows, partial(_swap_trig_of_angle, angle))
    for angle in sums:
        for new_angle in _edit_angle(angle):
            yield "angle-throughout", _change_trigs_in_rows(rows, partial(_replace_angle, {angle: new_angle}))
    lengths = sorted({name for row in rows for entry in row for name in find_names(entry) if is_length(name)})
    if len(lengths) > 1:
        yield "lengths-missing", [[_set_lengths_to_one(entry, lengths) for entry in row] for row in rows]
    for length in lengths:
        yield "lengths-missing", [[_set_lengths_to_one(entry, [length]) for entry in row] for row in rows]


def _use_relative_rates(rows: Sequence[Sequence[Node]]) -> Iterator[tuple[str, list[list[Node]]]]:
    """Yield the entries with single rates instead of sums of rates of parallel joints.

    A rate qd2 is replaced by qd2 - qd1, so that the sum qd1 + qd2 becomes qd2.
    """
    names = sorted({name for row in rows for entry in row for name in find_names(entry) if _is_rate(name)})
    rates = [Node("name", value=name) for name in names]
    new_rates = {rate: rate - earlier_rate for earlier_rate, rate in pairwise(rates)}
    changes = [{rate: new_rate} for rate, new_rate in new_rates.items()]
    if len(new_rates) > 1:
        changes.append(new_rates)
    for change in changes:
        yield "relative-rates", [[replace_nodes(entry, change.get) for entry in row] for row in rows]


def _is_rate(name: str) -> bool:
    return name.startswith("qd") and name[2:].isdigit()


def is_length(name: str) -> bool:
    """Return whether a name is the name of a length, such as a1, d3 or b2."""
    return name[0] in "adb" and name[1:].isdigit()


def _set_lengths_to_one(node: Node, lengths: Sequence[str]) -> Node:
    return replace_nodes(node, dict.fromkeys((Node("name", value=name) for name in lengths), ONE).get)


def _replace_angle(new_angles: Mapping[Node, Node], node: Node) -> Node:
    (angle,) = node.args
    return node.with_args([new_angles.get(angle, angle)])


def exchange_trigs(term: Node, max_count: int) -> list[Node]:
    """Return copies of a term in which sines and cosines are exchanged: one, several or all of them.

    If the term has more than `max_count` different ones, only all of them are exchanged together.
    """
    trigs = list(dict.fromkeys(node for node in iterate_nodes(term) if _is_trig(node)))
    counts = range(1, len(trigs) + 1) if len(trigs) <= max_count else [len(trigs)]
    subsets = (subset for count in counts for subset in combinations(trigs, count))
    return [replace_nodes(term, {trig: _swap_trig(trig) for trig in subset}.get) for subset in subsets]


def _swap_trig_of_angle(swapped_angle: Node, node: Node) -> Node:
    return _swap_trig(node) if node.args == (swapped_angle,) else node


def _swap_trig(node: Node) -> Node:
    return Node("call", node.args, "cos" if node.value == "sin" else "sin")


def _change_trigs_in_rows(rows: Sequence[Sequence[Node]], change: Callable[[Node], Node]) -> list[list[Node]]:
    """Return all entries with every sine and cosine changed."""
    return [[_change_trigs(entry, change) for entry in row] for row in rows]


def _change_trigs(node: Node, change: Callable[[Node], Node]) -> Node:
    return replace_nodes(node, lambda inner: change(inner) if _is_trig(inner) else None)


def replace_nodes(node: Node, change: Callable[[Node], Node | None]) -> Node:
    """Return a tree with new nodes: `change` returns the replacement of a node, or None if the node stays.

    Unchanged subtrees remain the same objects, so that cached results can be used.
    """
    replacement = change(node)
    return node.with_args([replace_nodes(arg, change) for arg in node.args]) if replacement is None else replacement


def _find_angles(node: Node) -> Iterator[Node]:
    """Yield the angles of the sines and cosines in a tree, from left to right."""
    if _is_trig(node):
        yield node.args[0]
        return
    for arg in node.args:
        yield from _find_angles(arg)


def _scale_constants(factor: Node) -> Callable[[Node], Node]:
    """Return a function that multiplies the constants of a sum of angles by a factor."""
    return lambda angle: _add_terms([term if find_names(term) else factor * term for term in split_terms(angle)])


def _keep_last_angle(keeps_constants: bool) -> Callable[[Node], Node]:
    """Return a function that keeps only the last joint angle of a sum of joint angles.

    If `keeps_constants`, the constants of the sum remain, too.
    """

    def reduce_angle(angle: Node) -> Node:
        joint_terms, constants = _split_constants(split_terms(angle))
        if len(joint_terms) < 2:
            return angle
        last_term = max(joint_terms, key=lambda term: sorted(find_names(term)))
        return _add_terms([last_term, *(constants if keeps_constants else ())])

    return reduce_angle


_CHANGES_OF_ALL_ANGLES: tuple[tuple[str, Callable[[Node], Node]], ...] = (
    ("constants-left-out", _scale_constants(ZERO)),
    ("constants-sign", _scale_constants(make_number(-1))),
    ("constants-in-degrees", _scale_constants(DEGREES_PER_RADIAN)),
    ("constants-wrong-radians", _scale_constants(TWO)),
    ("constants-wrong-radians", _scale_constants(HALF)),
    ("relative-throughout", _keep_last_angle(keeps_constants=True)),
    ("relative-throughout", _keep_last_angle(keeps_constants=False)),
)
"""The mistakes that change every angle, and how they change an angle."""


def _add_terms(terms: Sequence[Node]) -> Node:
    return sum(terms, ZERO)
