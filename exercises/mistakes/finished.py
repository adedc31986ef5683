"""Mistakes in finished formulas: an entry was simplified, copied or typed with one error.

Each entry is taken both as it is written and as a sum of products, and one thing is changed: a sign, a term, a factor,
a sine or cosine, or an angle. A mistake that changes every angle in the same way is made in all entries.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import combinations
from math import prod
from operator import add, sub

from qdot.exercises.formula.algebra import expand_terms, split_terms
from qdot.exercises.formula.trees import ONE, ZERO, Node, count_nodes, find_names, make_number, node_text

MAX_ENTRY_NODES = 400
"""Maximum number of nodes of an entry that is edited."""
MAX_TERMS = 40
"""Maximum number of terms of an entry that is expanded into a sum of products."""

TRIG_FUNCTIONS = ("sin", "cos")
DERIVATIVE_MISTAKES = frozenset({"wave-derived", "wave-not-derived"})
"""The mistakes that occur only in entries that are found by differentiation."""


@dataclass(frozen=True)
class Edit:
    """An entry with one mistake, the name of the mistake, and the term or factor that is missing, if any."""

    mistake: str
    entry: Node
    missing_node: Node | None = None

    @property
    def missing_words(self) -> str:
        """A phrase that identifies the missing part by its lengths, rates and numbers, or otherwise by its joints."""
        identifying_names = [] if self.missing_node is None else [*dict.fromkeys(_find_factors(self.missing_node))]
        if self.missing_node is not None and not identifying_names:
            identifying_names = sorted(name for name in find_names(self.missing_node) if name != "pi")
        return f" (with {', '.join(identifying_names)} in it)" if identifying_names else ""


def _find_factors(node: Node) -> Iterator[str]:
    """Yield the names and decimals of a term, except those inside sines and cosines."""
    if node.kind == "decimal" or (node.kind == "name" and node.value != "pi"):
        yield node_text(node)
    elif not _is_trig(node):
        for arg in node.args:
            yield from _find_factors(arg)


def _is_trig(node: Node) -> bool:
    return node.kind == "call" and node.value in TRIG_FUNCTIONS


# --- one mistake in an entry ---


def edit_entry(entry: Node, symbols: Iterable[str] = ()) -> Iterator[Edit]:
    """Yield an entry with each possible mistake, such as one of the `symbols` confused with a similar one."""
    if count_nodes(entry) > MAX_ENTRY_NODES:
        return
    yield from _edit_each_node(entry, partial(_mistype_symbol, sorted(symbols)))
    yield from _edit_each_node(entry, _edit_node)
    yield from _edit_all_trigs(entry)
    coefficient = _numeric_factor(entry)
    if coefficient not in (-1, 0, 1):
        yield Edit("factor-missing", entry / make_number(abs(coefficient)))
        if coefficient:
            yield Edit("factor-turned-over", entry / make_number(coefficient**2))
    yield from _exchange_similar_symbols(entry, symbols)
    yield from _edit_each_node(entry, partial(_add_joint_to_angle, sorted(symbols)))
    for angle in dict.fromkeys(_find_angles(entry)):
        for new_angle in _edit_angle(angle):
            yield Edit("angle-typed", _map_trigs(entry, partial(_replace_angle, {angle: new_angle})))
    terms = expand_terms(entry, MAX_TERMS)
    yield Edit("term-sign-typed" if terms is not None and len(terms) == 1 else "entry-sign", -entry)
    if terms is not None and len(terms) > 1:
        for k, term in enumerate(terms):
            other_terms = [*terms[:k], *terms[k + 1 :]]
            yield Edit("term-sign-typed", _sum([*other_terms, -term]))
            yield Edit("term-missing", _sum(other_terms), term)


def _edit_all_trigs(entry: Node) -> Iterator[Edit]:
    """Yield an entry with the same mistake in all of its sines and cosines, if it has several."""
    angles = list(_find_angles(entry))
    if len(angles) > 1:
        yield Edit("waves-typed", _map_trigs(entry, _swap_trig))
    sums = [angle for angle in dict.fromkeys(angles) if len(split_terms(angle)) > 1]
    for keep in (True, False):
        new_angles = {angle: _keep_last_angle(keep)(angle) for angle in sums}
        if sum(new_angle != angle for angle, new_angle in new_angles.items()) > 1:
            yield Edit("angles-typed", _map_trigs(entry, partial(_replace_angle, new_angles)))


def _edit_each_node(node: Node, edit_node: Callable[[Node], Iterator[Edit]]) -> Iterator[Edit]:
    """Yield a tree with each of its nodes edited in turn."""
    yield from edit_node(node)
    for k, arg in enumerate(node.args):
        for edit in _edit_each_node(arg, edit_node):
            new_tree = Node(node.kind, (*node.args[:k], edit.entry, *node.args[k + 1 :]), node.value)
            yield Edit(edit.mistake, new_tree, edit.missing_node)


def _edit_node(node: Node) -> Iterator[Edit]:
    if _is_trig(node):
        swapped = _swap_trig(node)
        yield Edit("wave-typed", swapped)
        yield Edit("wave-derived" if node.value == "sin" else "wave-not-derived", swapped)
        yield Edit("wave-not-derived" if node.value == "sin" else "wave-derived", -swapped)
        yield Edit("wave-and-sign", -swapped)
        for angle in _edit_angle(node.args[0]):
            yield Edit("angle-typed", Node("call", (angle,), node.value))
        yield from _split_trig_of_sum(node)
    elif node.kind in _OPERATIONS and not _is_angle(node):
        yield from _OPERATIONS[node.kind](node)


def _edit_sum(node: Node) -> Iterator[Edit]:
    first_term, second_term = node.args
    yield Edit("term-sign-typed", Node("-" if node.kind == "+" else "+", node.args))
    yield Edit("term-sign-typed", Node(node.kind, (-first_term, second_term)))
    yield Edit("term-missing", first_term, second_term)
    yield Edit("term-missing", second_term if node.kind == "+" else -second_term, first_term)
    yield Edit("sum-multiplied", _product(split_terms(node)))
    yield from _add_unlike_terms(node)
    if second_term.kind == "*" and node.kind == "-":  # without a bracket, the minus applies to the first term only
        for edit in _edit_product(second_term):
            if edit.mistake == "bracket-missing":
                first_factor, second_factor = edit.entry.args
                yield Edit("bracket-missing", Node(edit.entry.kind, (first_term - first_factor, second_factor)))


def _add_unlike_terms(node: Node) -> Iterator[Edit]:
    """Yield a sum with a number added to the coefficient of an unlike term: 0.6 x instead of 0.2 + 0.4 x."""
    for constant, term in (node.args, node.args[::-1]):
        if constant.kind in ("number", "decimal") and find_names(term):
            factor = _numeric_factor(constant) / _numeric_factor(term) if _numeric_factor(term) else Fraction(0)
            kept_term, scaled_term = (term, make_number(factor) * term)
            yield Edit(
                "unlike-terms-added",
                kept_term + scaled_term if node.kind == "+" else kept_term - scaled_term,
            )


def _edit_product(node: Node) -> Iterator[Edit]:
    first_factor, second_factor = node.args
    yield from _drop_denominator_bracket(first_factor, second_factor)
    if (
        second_factor.kind == "call"
        and second_factor.value in TRIG_FUNCTIONS
        and len(split_terms(second_factor.args[0])) > 1
    ):
        first, *rest = _trigs_of_terms(second_factor)  # s1 + s2 instead of s12, without a bracket
        yield Edit("sum-of-angles-split", first_factor * first + _sum(rest))
    for missing, kept in ((first_factor, second_factor), (second_factor, first_factor)):
        yield Edit("factor-missing", kept, missing)
        if missing.kind in ("+", "-"):  # the other factor multiplies only one of the terms
            combine = add if missing.kind == "+" else sub
            yield Edit("waves-in-factor", _map_trigs(missing, _swap_trig) * kept)
            yield Edit("bracket-missing", combine(missing.args[0], missing.args[1] * kept))
            yield Edit("bracket-missing", combine(kept * missing.args[0], missing.args[1]))


def _edit_quotient(node: Node) -> Iterator[Edit]:
    numerator, denominator = node.args
    terms = split_terms(numerator)
    for k in range(len(terms)) if 1 < len(terms) <= MAX_TERMS else ():  # divide only one term, or all but one
        yield Edit(
            "bracket-missing",
            _sum([term / denominator if i == k else term for i, term in enumerate(terms)]),
        )
        yield Edit(
            "bracket-missing",
            _sum([term if i == k else term / denominator for i, term in enumerate(terms)]),
        )
    if denominator.kind in ("+", "-", "*"):  # divide by only one of the two operands
        for divisor, remainder in (denominator.args, denominator.args[::-1]):
            yield Edit("bracket-missing", Node(denominator.kind, (numerator / divisor, remainder)))
    yield Edit("factor-missing", numerator, denominator)
    yield Edit("factor-missing", numerator * denominator)


def _edit_power(node: Node) -> Iterator[Edit]:
    if node.args[1] == make_number(2):
        yield Edit("square-missing", node.args[0])
        yield Edit("square-missing", make_number(2) * node.args[0])


def _edit_negative(node: Node) -> Iterator[Edit]:
    (inside,) = node.args
    yield Edit("term-sign-typed", inside)
    yield from _drop_denominator_bracket(make_number(-1), inside)
    terms = split_terms(inside.args[0]) if inside.kind == "/" else []
    if 1 < len(terms) <= MAX_TERMS:  # negate only the first term, and divide only the last one
        yield Edit("bracket-missing", _sum([-terms[0], *terms[1:-1], terms[-1] / inside.args[1]]))


def _drop_denominator_bracket(factor: Node, quotient: Node) -> Iterator[Edit]:
    """Yield a factor times a quotient, without the brackets around the denominator."""
    if quotient.kind == "/" and quotient.args[1].kind in ("+", "-"):
        numerator, denominator = quotient.args
        yield Edit(
            "bracket-missing",
            Node(
                denominator.kind,
                (factor * numerator / denominator.args[0], denominator.args[1]),
            ),
        )


_OPERATIONS: dict[str, Callable[[Node], Iterator[Edit]]] = {
    "+": _edit_sum, "-": _edit_sum, "*": _edit_product, "/": _edit_quotient, "^": _edit_power, "neg": _edit_negative,
}  # fmt: skip


def _numeric_factor(node: Node) -> Fraction:
    """Return the numeric factor of a product."""
    if node.kind in ("number", "decimal"):
        return Fraction(node.value)
    if node.kind == "neg":
        return -_numeric_factor(node.args[0])
    if node.kind in ("*", "/"):
        first, second = map(_numeric_factor, node.args)
        return first * second if node.kind == "*" else first / second if second else Fraction(0)
    return Fraction(1)


def _mistype_symbol(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield a name replaced by each similar name."""
    for symbol in symbols if node.kind == "name" else ():
        if symbol != node.value and _name_stem(symbol) == _name_stem(str(node.value)):
            yield Edit("symbol-typed", Node("name", value=symbol))


def _exchange_similar_symbols(entry: Node, symbols: Iterable[str]) -> Iterator[Edit]:
    """Yield an entry with two similar names exchanged."""
    present_symbols = sorted(find_names(entry) & set(symbols))
    for first, second in combinations(present_symbols, 2):
        if _name_stem(first) == _name_stem(second):
            first_leaf, second_leaf = Node("name", value=first), Node("name", value=second)
            yield Edit("symbol-typed", map_nodes(entry, {first_leaf: second_leaf, second_leaf: first_leaf}.get))


def _add_joint_to_angle(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield a sine or cosine with a joint variable added to its angle, subtracted from it, or negated in it."""
    for joint in (Node("name", value=name) for name in symbols if _is_trig(node) and name.startswith("theta")):
        is_single_angle = find_names(node.args[0]) == {joint.value}  # negating it is not a mistake in a sum of angles
        for term in (
            joint,
            -joint,
            make_number(2) * joint,
            *(() if is_single_angle else (-(make_number(2) * joint),)),
        ):
            yield Edit("angle-typed", Node("call", (node.args[0] + term,), node.value))


def replace_each_trig(entry: Node, replacement: Callable[[Node], Node]) -> list[Node]:
    """Return copies of an entry, in each of which another sine or cosine is replaced.

    `replacement` takes the tree of a sine or cosine and returns the one to put in its place.
    """
    edits_of_nodes = _edit_each_node(entry, lambda node: iter([Edit("", replacement(node))] if _is_trig(node) else []))
    return [edit.entry for edit in edits_of_nodes]


def add_quarter_turn(node: Node) -> Node:
    """Return a sine or cosine with pi/2 added to its angle."""
    return _swap_trig(node) if node.value == "sin" else -_swap_trig(node)


def _name_stem(name: str) -> str:
    """Return the common stem of similar names such as theta1 and theta2, or fy and fz."""
    return name[:-1] if len(name) == 2 and name[-1] in "xyz" else name.rstrip("0123456789")


def _is_angle(node: Node) -> bool:
    """Return whether a tree is an angle, that is, contains pi or a joint angle outside of function calls."""
    if node.kind == "name":
        return node.value == "pi" or node.value.startswith("theta")
    return any(map(_is_angle, node.args)) and node.kind != "call"


def _split_trig_of_sum(node: Node) -> Iterator[Edit]:
    """Yield the sine or cosine of a sum, replaced by the sum or product of the sines or cosines of its terms."""
    terms = split_terms(node.args[0])
    if len(terms) > 1:
        yield Edit("sum-of-angles-split", _sum(_trigs_of_terms(node)))
        yield Edit("sum-of-angles-split", _product(_trigs_of_terms(node)))
        yield Edit("sum-of-angles-split", _sum(_signed_trigs_of_terms(node)))
        all_but_last, last_term = _sum(terms[:-1]), terms[-1]
        yield Edit("bracket-missing", Node("call", (all_but_last,), node.value) + last_term)


def _trigs_of_terms(node: Node) -> list[Node]:
    """Return the sine or cosine of each term of an angle."""
    return [Node("call", (part,), node.value) for part in split_terms(node.args[0])]


def _signed_trigs_of_terms(node: Node) -> list[Node]:
    """Return the sine or cosine of each term of an angle; the minus of a negative term stands before the function."""
    return [
        -Node("call", part.args, node.value) if part.kind == "neg" else Node("call", (part,), node.value)
        for part in split_terms(node.args[0])
    ]


def _product(factors: Sequence[Node]) -> Node:
    return prod(factors, start=ONE)


def _edit_angle(angle: Node) -> Iterator[Node]:
    """Yield an angle with a term omitted or negated, a constant scaled, or its joint variables multiplied."""
    terms = split_terms(angle)
    joint_terms = [term for term in terms if find_names(term)]
    for k, term in enumerate(terms):
        other_terms = [*terms[:k], *terms[k + 1 :]]
        if other_terms:
            yield _sum(other_terms)
            if len(joint_terms) > 1 or not find_names(
                term
            ):  # negating a single angle is not a mistake in a sum of angles
                yield _sum([*other_terms, -term])
        if not find_names(term):
            for factor in (make_number(2), make_number(Fraction(1, 2)), make_number(180) / Node("name", value="pi")):
                yield _sum([*other_terms, factor * term])
    if len(joint_terms) > 1:
        yield _sum([_product(joint_terms), *(term for term in terms if not find_names(term))])
    if len(terms) > 2:
        constants = [term for term in terms if not find_names(term)]
        for term in terms:  # keep only one joint variable, without and with the constants
            if find_names(term):
                yield term
                yield _sum([term, *constants])


# --- the same mistake in all entries ---


def edit_throughout(rows: Sequence[Sequence[Node]]) -> Iterator[tuple[str, list[list[Node]]]]:
    """Yield the name of a mistake, and all entries with this mistake in every angle or wherever one angle occurs."""
    angles = list(dict.fromkeys(angle for row in rows for entry in row for angle in _find_angles(entry)))
    sums = [angle for angle in angles if len(split_terms(angle)) > 1]
    for name, change in _CHANGES_OF_ALL_ANGLES:
        new_angles = {angle: change(angle) for angle in sums}
        if any(new_angle != angle for angle, new_angle in new_angles.items()):
            yield name, _map_trigs_in_rows(rows, partial(_replace_angle, new_angles))
    yield "sum-of-angles-split", _map_trigs_in_rows(rows, lambda node: _product(_trigs_of_terms(node)))
    yield "sum-of-angles-split", _map_trigs_in_rows(rows, lambda node: _sum(_trigs_of_terms(node)))
    for angle in angles:
        yield "wave-throughout", _map_trigs_in_rows(rows, partial(_swap_trig_of_angle, angle))
    for angle in sums:
        for new_angle in _edit_angle(angle):
            yield "angle-throughout", _map_trigs_in_rows(rows, partial(_replace_angle, {angle: new_angle}))
    lengths = sorted({name for row in rows for entry in row for name in find_names(entry) if is_length(name)})
    if len(lengths) > 1:
        yield "lengths-missing", [[_set_lengths_to_one(entry, lengths) for entry in row] for row in rows]
    for length in lengths:
        yield "lengths-missing", [[_set_lengths_to_one(entry, [length]) for entry in row] for row in rows]


def is_length(name: str) -> bool:
    """Return whether a name is that of a length, such as a1, d3 or b2."""
    return name[0] in "adb" and name[1:].isdigit()


def _set_lengths_to_one(node: Node, lengths: Sequence[str]) -> Node:
    return map_nodes(node, dict.fromkeys((Node("name", value=name) for name in lengths), ONE).get)


def _replace_angle(new_angles: Mapping[Node, Node], node: Node) -> Node:
    (angle,) = node.args
    return Node("call", (new_angles.get(angle, angle),), node.value)


def _swap_trig_of_angle(swapped_angle: Node, node: Node) -> Node:
    return _swap_trig(node) if node.args == (swapped_angle,) else node


def _swap_trig(node: Node) -> Node:
    return Node("call", node.args, TRIG_FUNCTIONS[node.value == "sin"])


def _map_trigs_in_rows(rows: Sequence[Sequence[Node]], change: Callable[[Node], Node]) -> list[list[Node]]:
    """Return all entries with every sine and cosine changed."""
    return [[_map_trigs(entry, change) for entry in row] for row in rows]


def _map_trigs(node: Node, change: Callable[[Node], Node]) -> Node:
    return map_nodes(node, lambda inner: change(inner) if _is_trig(inner) else None)


def map_nodes(node: Node, change: Callable[[Node], Node | None]) -> Node:
    """Return a tree with a node replaced wherever `change` returns a new node instead of None.

    Unchanged subtrees remain the same objects, so their cached results can be used.
    """
    replacement = change(node)
    if replacement is not None:
        return replacement
    args = tuple(map_nodes(arg, change) for arg in node.args)
    is_unchanged = all(replacement is old for replacement, old in zip(args, node.args, strict=True))
    return node if is_unchanged else Node(node.kind, args, node.value)


def _find_angles(node: Node) -> Iterator[Node]:
    if _is_trig(node):
        yield node.args[0]
        return
    for arg in node.args:
        yield from _find_angles(arg)


def _drop_constants(angle: Node) -> Node:
    return _sum([part for part in split_terms(angle) if find_names(part)])


def _scale_constants(factor: Node) -> Callable[[Node], Node]:
    return lambda angle: _sum([part if find_names(part) else factor * part for part in split_terms(angle)])


def _keep_last_angle(keeps_constants: bool) -> Callable[[Node], Node]:
    """Return a function that reduces a sum of angles to the last joint angle.

    If `keeps_constants`, the constants of the sum remain, too.
    """

    def reduce_angle(angle: Node) -> Node:
        terms = split_terms(angle)
        joint_terms = [part for part in terms if find_names(part)]
        if len(joint_terms) < 2:
            return angle
        last_angle = max(joint_terms, key=lambda part: sorted(find_names(part)))
        return _sum([last_angle, *(part for part in terms if keeps_constants and not find_names(part))])

    return reduce_angle


_CHANGES_OF_ALL_ANGLES: tuple[tuple[str, Callable[[Node], Node]], ...] = (
    ("constants-left-out", _drop_constants),
    ("constants-sign", _scale_constants(make_number(-1))),
    ("constants-in-degrees", _scale_constants(make_number(180) / Node("name", value="pi"))),
    ("constants-wrong-radians", _scale_constants(make_number(2))),
    ("constants-wrong-radians", _scale_constants(make_number(Fraction(1, 2)))),
    ("relative-throughout", _keep_last_angle(keeps_constants=True)),
    ("relative-throughout", _keep_last_angle(keeps_constants=False)),
)


# --- sums of products ---


def _sum(terms: Sequence[Node]) -> Node:
    return sum(terms, ZERO)
