"""Equal wrong answers: a key for each, the same for all students of a class whose answer is wrong in the same way.

Answers are the same where the same mistake was made in the same place. Where none is known, they are the same where
they are the same formula, and the same is due, once each student's own numbers are undone: given lengths stand for
themselves again (0.6 for a2), and joints count from where the table has its zero (theta1 + pi/4 is one angle). What
can't be undone stays a number, so that only students with the same numbers share it.

A key depends on the problem, the answer and the assignment's secret, and on nobody else's answer: it stays when others
hand in, and nobody can work out which answers share one.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations_with_replacement, permutations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.formula.angles import turns_of
from qdot.exercises.formula.exact import fingerprint_results
from qdot.exercises.formula.parser import tree_of_reference
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import parse_claims
from qdot.exercises.formula.trees import Node, ReadError
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.diagnosis.similar import written
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis

LETTERS = "bcdfghjkmnpqrstvwxz"
"""What keys are made of: neither words nor anything that a spreadsheet takes for a number."""
LENGTH = 6


def group_key(part: str, letters: str) -> str:
    """Return the key of a group as results.jsonl has it.

    >>> group_key("p1.jacobian", "kqvxwz")
    'p1.jacobian/kqvxwz'
    """
    return f"{part}/{letters}"


def group_of(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> str | None:
    """Return the letters of the group that a wrong answer belongs to; None where that is not known.

    `diagnosis` is what was found behind it, whatever was found in earlier parts. Not known is it of Python functions
    behind which no mistake was found: each is called at other configurations.
    """
    identity = _identify(problem, part, parsed_answer, diagnosis, secret)
    if identity is None:
        return None
    number = int.from_bytes(
        hashlib.sha256(repr((secret, part.name, identity)).encode("utf-8", "replace")).digest()[:16]
    )
    letters = []
    for _ in range(LENGTH):
        number, index = divmod(number, len(LETTERS))
        letters.append(LETTERS[index])
    return "".join(letters)


def _identify(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> tuple[object, ...] | None:
    """Return what is equal for answers that are the same."""
    if diagnosis is not None and (made := diagnosis.known_by or diagnosis.mistakes):
        return "mistake", *made
    if parsed_answer.table is not None:
        return None
    if part.answer.offered and parsed_answer.chosen:
        return "options", _options(part, parsed_answer.chosen), _options(part, part.answer.right)
    try:
        if part.answer.is_in_numbers and parsed_answer.rows is not None:
            return "numbers", part.answer.code(), _numbers(parsed_answer.entries)
        general, is_direction = _GeneralForm(problem.chain), part.answer.counts_up_to_a_factor
        if parsed_answer.tree is not None and part.answer.is_a_set:
            joints = [q.name for q in problem.chain.q]
            reference = Node("list", tuple(tree for row in part.answer.trees(problem.domain().roles) for tree in row))
            return "set", *(general.conditions(tree, joints, secret) for tree in (parsed_answer.tree, reference))
        if parsed_answer.rows is not None:
            both = (parsed_answer.rows, part.answer.trees(problem.domain().roles))
            shapes = [(len(rows), len(rows[0])) for rows in both]
            entries = [[entry for row in rows for entry in row] for rows in both]
            return "formulas", shapes, *(general.formulas(some, secret, is_direction) for some in entries)
    except (ReadError, ValueError, ArithmeticError, RecursionError):
        pass  # no formulas: it is known again by its text
    return "text", "".join(parsed_answer.text.split())


def _options(part: Part, chosen: Sequence[int]) -> tuple[object, ...]:
    """Return options by what they say, with the item that each is matched to: letters differ from arm to arm."""
    texts = [part.answer.offered[index] for index in chosen]
    items = part.answer.matched
    return tuple(sorted(zip(items, texts, strict=True) if len(items) == len(texts) else texts))


def _numbers(entries: Sequence[Node]) -> tuple[str, ...]:
    """Return numbers to three digits, as they are due."""
    values = evaluate(compile_program(list(entries)), {}, 1)[0]
    return tuple(f"{complex(value):.2e}" for value in values[:, 0])


class _GeneralForm:
    """The form of formulas that is the same for all students: their given lengths have names again."""

    def __init__(self, chain: Chain) -> None:
        names = _name_lengths(_given_lengths(chain))
        self.factors = dict(_unambiguous(names, [_products(names, 2), _products(names, 3), _sums_of(names)]))
        self.terms = dict(_unambiguous(names, [_sums_of(names), _products(names, 2), _products(names, 3)]))
        self.zeros: dict[str, Node] = {}
        self.names: dict[str, Node] = {}
        self.angles = {q.name for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"}
        for q, joint, offset in zip(chain.q, chain.joints, _zeros(chain), strict=True):
            if offset != 0:
                self.zeros[q.name] = self.generalize(tree_of_reference(str(offset), frozenset()), joint.kind == "P")
                self.names[q.name] = Node("-", (Node("name", value=q.name), self.zeros[q.name]))

    def generalize(self, tree: Node, in_length: bool = True) -> Node:
        """Return a tree in which names stand for given lengths, and joints count from the table's zero.

        Numbers in a sine or an exponent are no lengths, and an angle has its zero only in a sine.
        """
        if tree.kind == "name":
            return tree if in_length and tree.value in self.angles else self.names.get(tree.value, tree)
        if tree.kind == "blank":
            return Node("name", value="blank")
        if tree.kind in ("number", "decimal"):
            return _length(self.terms, tree.value) if in_length else tree
        if tree.kind == "call":
            return Node("call", tuple(self.generalize(arg, False) for arg in tree.args), tree.value)
        if tree.kind == "^":
            return Node("^", (self.generalize(tree.args[0], in_length), self.generalize(tree.args[1], False)))
        if in_length and tree.kind in ("*", "/", "neg"):
            return self._product(tree)
        return Node(tree.kind, tuple(self.generalize(arg, in_length) for arg in tree.args), tree.value)

    def _product(self, tree: Node) -> Node:
        """Return a product with its numbers as one where that is a length, as 7*cos(theta2)/20 has; else each alone."""
        factors, number = list(_factors(tree)), Fraction(1)
        others = [factor for factor in factors if not _is_number(factor[0])]
        for factor, is_below in factors:
            if _is_number(factor):
                number *= 1 / factor.value if is_below else factor.value
        known = self.factors if others else self.terms
        product = Node("number", value=Fraction(1))
        if abs(number) in known:
            product, factors = _length(known, number), others
        for factor, is_below in factors:
            general = _length(known, factor.value) if _is_number(factor) else self.generalize(factor)
            product = Node("/" if is_below else "*", (product, general))
        return product

    def formulas(self, entries: Sequence[Node], seed: str, up_to_a_factor: bool = False) -> tuple[object, ...]:
        """Return what is the same for the same formulas; with `up_to_a_factor`, for their multiples, too."""
        trees = [self.generalize(entry) for entry in entries]
        numbers = fingerprint_results(compile_program(trees), seed)
        pivot = next((tree for tree, number in zip(trees, numbers, strict=True) if number and any(number)), None)
        if up_to_a_factor and pivot is not None:
            trees = [Node("/", (tree, pivot)) for tree in trees]
            numbers = fingerprint_results(compile_program(trees), seed)
        return tuple(_text(tree) if number is None else number for tree, number in zip(trees, numbers, strict=True))

    def conditions(self, tree: Node, joints: Sequence[str], seed: str) -> tuple[object, ...]:
        """Return what is the same for the same conditions, in whatever order they stand."""
        every = {
            tuple(sorted({repr(self._condition(atom.zero, atom.joint, seed)) for atom in piece}))
            for piece in parse_claims(tree, joints)
        }
        return tuple(sorted(every))

    def _condition(self, zero: Node, joint: str | None, seed: str) -> tuple[object, ...]:
        if joint is None:
            return "zero", *self.formulas([zero], seed)
        value = Node("+", (zero, self.zeros[joint])) if joint in self.zeros else zero
        turns = turns_of(value)
        return (joint, str(turns)) if turns is not None else (joint, *self.formulas([value], seed))


def _length(known: Mapping[Fraction, Node], value: Fraction) -> Node:
    """Return what a number stands for, or the number."""
    number = known.get(abs(value), Node("number", value=abs(value)))
    return Node("neg", (number,)) if value < 0 else number


def _text(tree: Node) -> str:
    form = written(ParsedAnswer("", tree=tree))
    return repr(tree) if form is None else form.text


def _zeros(chain: Chain) -> Sequence[sp.Expr]:
    """Return what is added to each joint's variable, at the first with the turn of an upright base."""
    if chain.joints[0].kind == "R" and chain.base.tilt == 0:
        return (chain.offsets[0] + chain.base.yaw, *chain.offsets[1:])
    return chain.offsets


def _given_lengths(chain: Chain) -> Iterator[tuple[str, sp.Expr]]:
    """Yield the lengths of an arm that are numbers, by names that are the same for all arms."""
    for number, (joint, offset) in enumerate(zip(chain.joints, chain.offsets, strict=True), 1):
        yield f"a{number}", joint.a
        yield (f"d{number}", joint.d) if joint.kind == "R" else (f"zero of d{number}", offset)
    for place, values in (("base", chain.base.position), ("point", chain.point.offset)):
        for axis, value in zip("xyz", values, strict=True):
            yield f"{place} {axis}", value


NumbersAndNodes = Iterator[tuple[Fraction, Node]]
"""Numbers, and what they are made of."""


def _name_lengths(lengths: Iterator[tuple[str, sp.Expr]]) -> dict[Fraction, Node]:
    """Return what stands for each length, without its sign; those of the same value are one, under all their names."""
    of_value: dict[Fraction, list[tuple[str, int]]] = {}
    for name, value in lengths:
        if value.is_Rational and value != 0:
            number = Fraction(int(value.p), int(value.q))
            of_value.setdefault(abs(number), []).append((name, 1 if number > 0 else -1))
    return {value: _signed_name(named) for value, named in of_value.items()}


def _unambiguous(names: Mapping[Fraction, Node], ways: Sequence[NumbersAndNodes]) -> NumbersAndNodes:
    """Yield the numbers that stand for lengths, or for what is made of several, the likelier ways first.

    Those that could be made in several ways, one as likely as the other, stay numbers, and so do whole ones: 2 may be
    any factor.
    """
    known = {value for value in names if value.denominator == 1}
    for pairs in (iter(names.items()), *ways):
        nodes: dict[Fraction, list[Node]] = {}
        for value, node in pairs:
            nodes.setdefault(value, []).append(node)
        yield from (
            (value, every[0])
            for value, every in nodes.items()
            if value not in known and value.denominator != 1 and len(every) == 1
        )
        known |= set(nodes)


def _signed_name(named: Sequence[tuple[str, int]]) -> Node:
    name = Node("name", value=" = ".join(name for name, _ in named))
    return name if named[0][1] > 0 else Node("neg", (name,))


def _products(names: Mapping[Fraction, Node], count: int) -> NumbersAndNodes:
    for values in combinations_with_replacement(names, count):
        product, node = values[0], names[values[0]]
        for value in values[1:]:
            product, node = product * value, Node("*", (node, names[value]))
        yield product, node


def _sums_of(names: Mapping[Fraction, Node]) -> NumbersAndNodes:
    """Yield sums of two, differences that are positive, and twice a product."""
    yield from _twice((value, node) for value, node in names.items())
    yield from _twice(_products(names, 2))
    for larger, smaller in permutations(names, 2):
        if larger > smaller:
            yield larger + smaller, Node("+", (names[larger], names[smaller]))
            yield larger - smaller, Node("-", (names[larger], names[smaller]))


def _twice(pairs: NumbersAndNodes) -> NumbersAndNodes:
    for value, node in pairs:
        yield 2 * value, Node("+", (node, node))


def _is_number(node: Node) -> bool:
    return node.kind in ("number", "decimal") and bool(node.value)


def _factors(tree: Node) -> Iterator[tuple[Node, bool]]:
    """Yield the factors of a product of products and quotients, and whether each stands below; a minus is -1."""
    stack = [(tree, False)]
    while stack:
        top, is_below = stack.pop()
        if top.kind == "neg":
            yield Node("number", value=Fraction(-1)), False
        if top.kind in ("*", "neg"):
            stack += [(arg, is_below) for arg in reversed(top.args)]
        elif top.kind == "/":
            stack += [(top.args[1], not is_below), (top.args[0], is_below)]
        else:
            yield top, is_below
