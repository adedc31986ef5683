"""Mistakes in finished formulas: an entry was simplified, copied or typed with one error.

Each entry is taken both as it is written and as a sum of products, and one thing is changed: a sign, a term, a factor,
a sine or cosine, or an angle. A mistake that changes every angle in the same way is made in all entries.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial, reduce
from itertools import combinations

from qdot.exercises.formula.algebra import ONE, TWO, ZERO, addends, minus, negative, number, over, plus, terms_of, times
from qdot.exercises.formula.trees import Node, names, node_text, size_of
from qdot.exercises.mistakes.base import Mistake

LONGEST = 400
"""Maximum number of nodes of an entry that is edited."""
MOST_TERMS = 40
"""Maximum number of terms of an entry that is expanded into a sum of products."""

WAVES = ("sin", "cos")
OF_DERIVATIVES = frozenset({"wave-derived", "wave-not-derived"})
"""The mistakes that occur only in entries that are found by differentiation."""


@dataclass(frozen=True)
class Edit:
    """An entry with one mistake, the name of the mistake, and the term or factor that is missing, if any."""

    mistake: str
    entry: Node
    missing: Node | None = None

    @property
    def which(self) -> str:
        """A phrase that identifies the missing part by its lengths, rates and numbers, or otherwise by its joints."""
        identifying_names = [] if self.missing is None else [*dict.fromkeys(_factors_in(self.missing))]
        if self.missing is not None and not identifying_names:
            identifying_names = sorted(name for name in names(self.missing) if name != "pi")
        return f" (with {', '.join(identifying_names)} in it)" if identifying_names else ""


def _factors_in(node: Node) -> Iterator[str]:
    """Yield the names and decimals of a term, except those inside sines and cosines."""
    if node.kind == "decimal" or (node.kind == "name" and node.value != "pi"):
        yield node_text(node)
    elif not _is_wave(node):
        for arg in node.args:
            yield from _factors_in(arg)


def _is_wave(node: Node) -> bool:
    return node.kind == "call" and node.value in WAVES


# --- one mistake in an entry ---


def edits(entry: Node, symbols: Iterable[str] = ()) -> Iterator[Edit]:
    """Yield an entry with each possible mistake, such as one of the `symbols` confused with a similar one."""
    if size_of(entry) > LONGEST:
        return
    yield from _edit_each_node(entry, partial(_mistype_symbol, sorted(symbols)))
    yield from _edit_each_node(entry, _edit_node)
    yield from _edit_every_wave(entry)
    coefficient = _coefficient(entry)
    if coefficient not in (-1, 0, 1):
        yield Edit("factor-missing", over(entry, number(abs(coefficient))))
        if coefficient:
            yield Edit("factor-turned-over", over(entry, number(coefficient**2)))
    yield from exchange_symbols(entry, symbols)
    yield from _edit_each_node(entry, partial(_add_joint_to_angle, sorted(symbols)))
    for angle in dict.fromkeys(_angles_in(entry)):
        for new_angle in _edit_angle(angle):
            yield Edit("angle-typed", _map_waves(entry, partial(_replace_angle, {angle: new_angle})))
    terms = terms_of(entry, MOST_TERMS)
    yield Edit("term-sign-typed" if terms is not None and len(terms) == 1 else "entry-sign", negative(entry))
    if terms is not None and len(terms) > 1:
        for k, term in enumerate(terms):
            other_terms = [*terms[:k], *terms[k + 1 :]]
            yield Edit("term-sign-typed", _sum([*other_terms, negative(term)]))
            yield Edit("term-missing", _sum(other_terms), term)


def _edit_every_wave(entry: Node) -> Iterator[Edit]:
    """Yield an entry with the same mistake in all of its sines and cosines, if it has several."""
    angles = list(_angles_in(entry))
    if len(angles) > 1:
        yield Edit("waves-typed", _map_waves(entry, _swap_wave))
    sums = [angle for angle in dict.fromkeys(angles) if len(addends(angle)) > 1]
    for keep in (True, False):
        new_angles = {angle: _keep_last_angle(keep)(angle) for angle in sums}
        if sum(new_angle != angle for angle, new_angle in new_angles.items()) > 1:
            yield Edit("angles-typed", _map_waves(entry, partial(_replace_angle, new_angles)))


def _edit_each_node(node: Node, edit_node: Callable[[Node], Iterator[Edit]]) -> Iterator[Edit]:
    """Yield a tree with each of its nodes edited in turn."""
    yield from edit_node(node)
    for k, arg in enumerate(node.args):
        for edit in _edit_each_node(arg, edit_node):
            new_tree = Node(node.kind, (*node.args[:k], edit.entry, *node.args[k + 1 :]), node.value)
            yield Edit(edit.mistake, new_tree, edit.missing)


def _edit_node(node: Node) -> Iterator[Edit]:
    if _is_wave(node):
        swapped = _swap_wave(node)
        yield Edit("wave-typed", swapped)
        yield Edit("wave-derived" if node.value == "sin" else "wave-not-derived", swapped)
        yield Edit("wave-not-derived" if node.value == "sin" else "wave-derived", negative(swapped))
        yield Edit("wave-and-sign", negative(swapped))
        for angle in _edit_angle(node.args[0]):
            yield Edit("angle-typed", Node("call", (angle,), node.value))
        yield from _split_wave(node)
    elif node.kind in _OPERATIONS and not _is_angle(node):
        yield from _OPERATIONS[node.kind](node)


def _edit_sum(node: Node) -> Iterator[Edit]:
    first_term, second_term = node.args
    yield Edit("term-sign-typed", Node("-" if node.kind == "+" else "+", node.args))
    yield Edit("term-sign-typed", Node(node.kind, (negative(first_term), second_term)))
    yield Edit("term-missing", first_term, second_term)
    yield Edit("term-missing", second_term if node.kind == "+" else negative(second_term), first_term)
    yield Edit("sum-multiplied", _product(addends(node)))
    yield from _add_unlike_terms(node)
    if second_term.kind == "*" and node.kind == "-":  # without a bracket, the minus applies to the first term only
        for edit in _edit_product(second_term):
            if edit.mistake == "bracket-missing":
                first_factor, second_factor = edit.entry.args
                yield Edit("bracket-missing", Node(edit.entry.kind, (minus(first_term, first_factor), second_factor)))


def _add_unlike_terms(node: Node) -> Iterator[Edit]:
    """Yield a sum with a number added to the coefficient of an unlike term: 0.6 x instead of 0.2 + 0.4 x."""
    for constant, term in (node.args, node.args[::-1]):
        if constant.kind in ("number", "decimal") and names(term):
            factor = _coefficient(constant) / _coefficient(term) if _coefficient(term) else Fraction(0)
            kept_term, scaled_term = (term, times(number(factor), term))
            yield Edit(
                "unlike-terms-added",
                plus(kept_term, scaled_term) if node.kind == "+" else minus(kept_term, scaled_term),
            )


def _edit_product(node: Node) -> Iterator[Edit]:
    first_factor, second_factor = node.args
    yield from _drop_denominator_bracket(first_factor, second_factor)
    if second_factor.kind == "call" and second_factor.value in WAVES and len(addends(second_factor.args[0])) > 1:
        first, *rest = _waves(second_factor)  # s1 + s2 instead of s12, without a bracket
        yield Edit("sum-of-angles-split", plus(times(first_factor, first), _sum(rest)))
    for missing, kept in ((first_factor, second_factor), (second_factor, first_factor)):
        yield Edit("factor-missing", kept, missing)
        if missing.kind in ("+", "-"):  # the other factor multiplies only one of the terms
            add = plus if missing.kind == "+" else minus
            yield Edit("waves-in-factor", times(_map_waves(missing, _swap_wave), kept))
            yield Edit("bracket-missing", add(missing.args[0], times(missing.args[1], kept)))
            yield Edit("bracket-missing", add(times(kept, missing.args[0]), missing.args[1]))


def _edit_quotient(node: Node) -> Iterator[Edit]:
    numerator, denominator = node.args
    terms = addends(numerator)
    for k in range(len(terms)) if 1 < len(terms) <= MOST_TERMS else ():  # divide only one term, or all but one
        yield Edit(
            "bracket-missing", _sum([over(term, denominator) if i == k else term for i, term in enumerate(terms)])
        )
        yield Edit(
            "bracket-missing", _sum([term if i == k else over(term, denominator) for i, term in enumerate(terms)])
        )
    if denominator.kind in ("+", "-", "*"):  # divide by only one of the two operands
        for divisor, remainder in (denominator.args, denominator.args[::-1]):
            yield Edit("bracket-missing", Node(denominator.kind, (over(numerator, divisor), remainder)))
    yield Edit("factor-missing", numerator, denominator)
    yield Edit("factor-missing", times(numerator, denominator))


def _edit_power(node: Node) -> Iterator[Edit]:
    if node.args[1] == TWO:
        yield Edit("square-missing", node.args[0])
        yield Edit("square-missing", times(TWO, node.args[0]))


def _edit_negative(node: Node) -> Iterator[Edit]:
    (inside,) = node.args
    yield Edit("term-sign-typed", inside)
    yield from _drop_denominator_bracket(number(-1), inside)
    terms = addends(inside.args[0]) if inside.kind == "/" else []
    if 1 < len(terms) <= MOST_TERMS:  # negate only the first term, and divide only the last one
        yield Edit("bracket-missing", _sum([negative(terms[0]), *terms[1:-1], over(terms[-1], inside.args[1])]))


def _drop_denominator_bracket(factor: Node, quotient: Node) -> Iterator[Edit]:
    """Yield a factor times a quotient, without the brackets around the denominator."""
    if quotient.kind == "/" and quotient.args[1].kind in ("+", "-"):
        numerator, denominator = quotient.args
        yield Edit(
            "bracket-missing",
            Node(denominator.kind, (over(times(factor, numerator), denominator.args[0]), denominator.args[1])),
        )


_OPERATIONS: dict[str, Callable[[Node], Iterator[Edit]]] = {
    "+": _edit_sum, "-": _edit_sum, "*": _edit_product, "/": _edit_quotient, "^": _edit_power, "neg": _edit_negative,
}  # fmt: skip


def _coefficient(node: Node) -> Fraction:
    """Return the numeric factor of a product."""
    if node.kind in ("number", "decimal"):
        return Fraction(node.value)
    if node.kind == "neg":
        return -_coefficient(node.args[0])
    if node.kind in ("*", "/"):
        first, second = map(_coefficient, node.args)
        return first * second if node.kind == "*" else first / second if second else Fraction(0)
    return Fraction(1)


def _mistype_symbol(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield a name replaced by each similar name."""
    for symbol in symbols if node.kind == "name" else ():
        if symbol != node.value and _stem(symbol) == _stem(str(node.value)):
            yield Edit("symbol-typed", Node("name", value=symbol))


def exchange_symbols(entry: Node, symbols: Iterable[str]) -> Iterator[Edit]:
    """Yield an entry with two similar names exchanged."""
    present_symbols = sorted(names(entry) & set(symbols))
    for first, second in combinations(present_symbols, 2):
        if _stem(first) == _stem(second):
            first_leaf, second_leaf = Node("name", value=first), Node("name", value=second)
            yield Edit("symbol-typed", map_nodes(entry, {first_leaf: second_leaf, second_leaf: first_leaf}.get))


def _add_joint_to_angle(symbols: Sequence[str], node: Node) -> Iterator[Edit]:
    """Yield a sine or cosine with a joint variable added to its angle, subtracted from it, or negated in it."""
    for joint in (Node("name", value=name) for name in symbols if _is_wave(node) and name.startswith("theta")):
        is_single_angle = names(node.args[0]) == {joint.value}  # negating it is not a mistake in a sum of angles
        for term in (
            joint,
            negative(joint),
            times(TWO, joint),
            *(() if is_single_angle else (negative(times(TWO, joint)),)),
        ):
            yield Edit("angle-typed", Node("call", (plus(node.args[0], term),), node.value))


def replace_each_wave(entry: Node, new: Callable[[Node], Node]) -> list[Node]:
    """Return copies of an entry, each with one of its sines and cosines replaced by the tree that `new` returns."""
    edits_of_nodes = _edit_each_node(entry, lambda node: iter([Edit("", new(node))] if _is_wave(node) else []))
    return [edit.entry for edit in edits_of_nodes]


def turn_wave(node: Node) -> Node:
    """Return a sine or cosine with pi/2 added to its angle."""
    return _swap_wave(node) if node.value == "sin" else negative(_swap_wave(node))


def _stem(name: str) -> str:
    """Return the common stem of similar names such as theta1 and theta2, or fy and fz."""
    return name[:-1] if len(name) == 2 and name[-1] in "xyz" else name.rstrip("0123456789")


def _is_angle(node: Node) -> bool:
    """Return whether a tree is an angle, that is, contains pi or a joint angle outside of function calls."""
    if node.kind == "name":
        return node.value == "pi" or node.value.startswith("theta")
    return any(map(_is_angle, node.args)) and node.kind != "call"


def _split_wave(node: Node) -> Iterator[Edit]:
    """Yield the sine or cosine of a sum, replaced by the sum or product of the sines or cosines of its terms."""
    terms = addends(node.args[0])
    if len(terms) > 1:
        yield Edit("sum-of-angles-split", _sum(_waves(node)))
        yield Edit("sum-of-angles-split", _product(_waves(node)))
        yield Edit("sum-of-angles-split", _sum(_signed_waves(node)))
        all_but_last, last_term = _sum(terms[:-1]), terms[-1]
        yield Edit("bracket-missing", plus(Node("call", (all_but_last,), node.value), last_term))


def _waves(node: Node) -> list[Node]:
    """Return the sine or cosine of each term of an angle."""
    return [Node("call", (part,), node.value) for part in addends(node.args[0])]


def _signed_waves(node: Node) -> list[Node]:
    """Return the sine or cosine of each term of an angle; the minus of a negative term stands before the function."""
    return [
        negative(Node("call", part.args, node.value)) if part.kind == "neg" else Node("call", (part,), node.value)
        for part in addends(node.args[0])
    ]


def _product(factors: Sequence[Node]) -> Node:
    return reduce(times, factors, ONE)


def _edit_angle(angle: Node) -> Iterator[Node]:
    """Yield an angle with a term omitted or negated, a constant scaled, or its joint variables multiplied."""
    terms = addends(angle)
    joint_terms = [term for term in terms if names(term)]
    for k, term in enumerate(terms):
        other_terms = [*terms[:k], *terms[k + 1 :]]
        if other_terms:
            yield _sum(other_terms)
            if len(joint_terms) > 1 or not names(term):  # negating a single angle is not a mistake in a sum of angles
                yield _sum([*other_terms, negative(term)])
        if not names(term):
            for factor in (number(2), number(Fraction(1, 2)), over(number(180), Node("name", value="pi"))):
                yield _sum([*other_terms, times(factor, term)])
    if len(joint_terms) > 1:
        yield _sum([_product(joint_terms), *(term for term in terms if not names(term))])
    if len(terms) > 2:
        constants = [term for term in terms if not names(term)]
        for term in terms:  # keep only one joint variable, without and with the constants
            if names(term):
                yield term
                yield _sum([term, *constants])


# --- the same mistake in all entries ---


def edits_throughout(rows: Sequence[Sequence[Node]]) -> Iterator[tuple[str, list[list[Node]]]]:
    """Yield the name of a mistake, and all entries with this mistake in every angle or wherever one angle occurs."""
    angles = list(dict.fromkeys(angle for row in rows for entry in row for angle in _angles_in(entry)))
    sums = [angle for angle in angles if len(addends(angle)) > 1]
    for name, change in _SAME_EVERYWHERE:
        new_angles = {angle: change(angle) for angle in sums}
        if any(new_angle != angle for angle, new_angle in new_angles.items()):
            yield name, _edit_all_waves(rows, partial(_replace_angle, new_angles))
    yield "sum-of-angles-split", _edit_all_waves(rows, lambda node: _product(_waves(node)))
    yield "sum-of-angles-split", _edit_all_waves(rows, lambda node: _sum(_waves(node)))
    for angle in angles:
        yield "wave-throughout", _edit_all_waves(rows, partial(_swap_wave_of, angle))
    for angle in sums:
        for new_angle in _edit_angle(angle):
            yield "angle-throughout", _edit_all_waves(rows, partial(_replace_angle, {angle: new_angle}))
    lengths = sorted({name for row in rows for entry in row for name in names(entry) if is_length(name)})
    if len(lengths) > 1:
        yield "lengths-missing", [[_set_lengths_to_one(entry, lengths) for entry in row] for row in rows]
    for length in lengths:
        yield "lengths-missing", [[_set_lengths_to_one(entry, [length]) for entry in row] for row in rows]


def is_length(name: str) -> bool:
    """Return whether a name is that of a length, such as a1, d3 or b2."""
    return name[0] in "adb" and name[1:].isdigit()


def _set_lengths_to_one(node: Node, lengths: Sequence[str]) -> Node:
    return map_nodes(node, dict.fromkeys((Node("name", value=name) for name in lengths), ONE).get)


def _replace_angle(changed: Mapping[Node, Node], node: Node) -> Node:
    (angle,) = node.args
    return Node("call", (changed.get(angle, angle),), node.value)


def _swap_wave_of(angle: Node, node: Node) -> Node:
    return _swap_wave(node) if node.args == (angle,) else node


def _swap_wave(node: Node) -> Node:
    return Node("call", node.args, WAVES[node.value == "sin"])


def _edit_all_waves(rows: Sequence[Sequence[Node]], change: Callable[[Node], Node]) -> list[list[Node]]:
    """Return all entries with every sine and cosine changed."""
    return [[_map_waves(entry, change) for entry in row] for row in rows]


def _map_waves(node: Node, change: Callable[[Node], Node]) -> Node:
    return map_nodes(node, lambda inner: change(inner) if _is_wave(inner) else None)


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


def _angles_in(node: Node) -> Iterator[Node]:
    if _is_wave(node):
        yield node.args[0]
        return
    for arg in node.args:
        yield from _angles_in(arg)


def _drop_constants(angle: Node) -> Node:
    return _sum([part for part in addends(angle) if names(part)])


def _scale_constants(factor: Node) -> Callable[[Node], Node]:
    return lambda angle: _sum([part if names(part) else times(factor, part) for part in addends(angle)])


def _keep_last_angle(keep: bool) -> Callable[[Node], Node]:
    """Return a function that reduces a sum of angles to the last joint angle; if `keep`, the constants remain."""

    def changed(angle: Node) -> Node:
        terms = addends(angle)
        joint_terms = [part for part in terms if names(part)]
        if len(joint_terms) < 2:
            return angle
        last_angle = max(joint_terms, key=lambda part: sorted(names(part)))
        return _sum([last_angle, *(part for part in terms if keep and not names(part))])

    return changed


_SAME_EVERYWHERE: tuple[tuple[str, Callable[[Node], Node]], ...] = (
    ("constants-left-out", _drop_constants),
    ("constants-sign", _scale_constants(number(-1))),
    ("constants-in-degrees", _scale_constants(over(number(180), Node("name", value="pi")))),
    ("constants-wrong-radians", _scale_constants(number(2))),
    ("constants-wrong-radians", _scale_constants(number(Fraction(1, 2)))),
    ("relative-throughout", _keep_last_angle(keep=True)),
    ("relative-throughout", _keep_last_angle(keep=False)),
)


# --- sums of products ---


def _sum(terms: Sequence[Node]) -> Node:
    return reduce(plus, terms, ZERO)


_algebra = partial(Mistake, source="6.3")
_angles = partial(Mistake, source="Example 6.1")
_constants = partial(Mistake, source="6.1")

MISTAKES = (
    _algebra("term-sign-typed", "Sign of one term", "{Where} one sign seems to be wrong: the rest is as it should be."),
    _algebra("term-missing", "Term missing",
             "{Where} one term{which} seems to be missing: the rest is as it should be."),
    _algebra("factor-missing", "Factor missing",
             "{Where} one factor{which} of a product seems to be missing: check that every term has the same unit."),
    _algebra("bracket-missing", "Bracket missing",
             "{Where} a bracket seems to be missing: the factor multiplies every term of the sum."),
    _algebra("factor-turned-over", "Number turned over",
             "{Where} a number seems to be turned over: to divide by a fraction is to multiply by what it is upside "
             "down."),
    _algebra("unlike-terms-added", "Terms added that are not alike",
             "{Where} numbers seem to be added that stand before different things: only like terms add up."),
    _algebra("entry-sign", "Sign of an entry", "{Where} all signs seem to be wrong, and the rest is right."),
    _algebra("entry-missing", "Entry left at zero", "{Where} you have zero, but several terms are expected there."),
    _algebra("sign-lost", "Sign lost in a root",
             "{Where} the size is right, but the sign is wrong in some configurations: a square root is never "
             "negative, so the root of 1 - cos² is the absolute value of the sine."),
    _algebra("term-surplus", "Extra term", "{Where} one term{which} seems to be extra, and the rest is right."),
    _algebra("factor-surplus", "Extra factor",
             "{Where} one factor{which} of a product seems to be extra: check that every term has the same unit."),
    _algebra("number-typed", "Number in one place",
             "{Where} one term{which} seems to be multiplied by a wrong number, and the rest is right."),
    _algebra("entry-factor", "Factor of an entry", "{Where} everything seems to be multiplied by one wrong number."),
    _algebra("constant-typed", "Constant in one place",
             "{Where} a constant term seems to be wrong, missing or extra, and the rest is right."),
    _algebra("sum-multiplied", "Product for a sum",
             "{Where} you seem to have a product where a sum is expected: rates and angles of joints are added."),
    _algebra("square-missing", "Square missing", "{Where} a square seems to be missing."),
    _angles("wave-typed", "Sine for cosine in one place",
            "{Where} a sine stands where a cosine is due, or the other way round."),
    _angles("angle-typed", "Angle in one place",
            "{Where} the angle of one sine or cosine seems to be wrong, and the rest is right: compare what stands "
            "in its sum with the other terms."),
    _algebra("wave-derived", "Sine or cosine differentiated once too often",
             "{Where} there is a sine where a cosine is expected, or the other way round, with a sign as if it had "
             "been differentiated once more."),
    _algebra("wave-not-derived", "Sine or cosine not differentiated",
             "{Where} there is a sine where a cosine is expected, or the other way round, with a sign as if it had "
             "not been differentiated."),
    _angles("wave-and-sign", "Sine for cosine in one place, and its sign",
            "{Where} there is a sine where a cosine is expected, or the other way round, and its sign is wrong."),
    _angles("waves-in-factor", "Sines for cosines in a factor",
            "{Where} sines and cosines seem to be exchanged in one factor, and the rest is right."),
    _angles("waves-typed", "Sines for cosines in an entry",
            "{Where} sines and cosines seem to be exchanged throughout, and the rest is right."),
    _angles("angles-typed", "Relative angles in an entry",
            "{Where} the angle of a link's own joint seems to stand wherever a sum of angles is due: the angles of "
            "parallel joints add up from link to link."),
    _algebra("symbol-typed", "One symbol for another",
             "{Where} one symbol seems to be typed for another: look at the numbers behind the letters."),
    _angles("sum-of-angles-split", "Sine or cosine of a sum split",
            "{Where} the sine or cosine of a sum seems to be split: s12 is one sine, that of the sum, and neither "
            "s1 + s2 nor s1 s2."),
    Mistake("entries-exchanged", "Entries exchanged", "{Where} two entries seem to be exchanged.", "6.4"),
    _constants("constants-left-out", "Constants of the angles left out",
               "The constants that are added to angles seem to be left out of the sines and cosines."),
    _constants("constants-sign", "Constants of the angles with the wrong sign",
               "The constants that are added to angles seem to have the wrong sign in the sines and cosines."),
    _constants("constants-in-degrees", "Constants of the angles typed in degrees",
               "The constants in the angles seem to be typed in degrees: sine and cosine take radians, so that 90° "
               "is pi/2."),
    _constants("constants-wrong-radians", "Constants of the angles turned into the wrong radians",
               "The constants in the angles seem to be turned into radians wrongly: 180° is pi, so that 30° is "
               "pi/6, 45° is pi/4, 60° is pi/3 and 90° is pi/2."),
    _angles("relative-throughout", "Relative angles in the finished formula",
            "The angle of a link's own joint seems to stand where a sum of angles is due: the angles of parallel "
            "joints add up from link to link."),
    _angles("angle-throughout", "One angle wrong throughout",
            "One sum of angles seems to be wrong wherever it stands: look again at which joints turn that link, and "
            "by what constant."),
    _angles("wave-throughout", "Sine and cosine of one angle exchanged",
            "Sine and cosine of one angle seem to be exchanged wherever it stands."),
    _algebra("lengths-missing", "Lengths missing",
             "A length seems to be left out wherever it stands: every entry must have the right unit."),
)  # fmt: skip
