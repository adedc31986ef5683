"""Compute the keys of groups of wrong answers; students whose answers are wrong in the same way share a key.

Two answers are the same if the same mistake was made at the same joint or entry. If no mistake is known, two answers
are the same if their formulas are equal and so are the expected answers. For this, each student's own numbers are
replaced by names: a given length becomes its name (0.6 becomes a2). Joint variables include their offset: theta1 + pi/4
becomes one angle. A number that can't be replaced stays, so only students with the same numbers share that key.

A key depends on the problem, the answer and the assignment's secret, but not on other students' answers. It doesn't
change when others submit, and without the secret nobody can compute it.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import combinations_with_replacement, permutations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.formula.angles import find_multiple_of_pi
from qdot.exercises.formula.exact import fingerprint_results
from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import parse_typed_set
from qdot.exercises.formula.trees import Node, ParseError
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.diagnosis.similar import canonical_form
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis

KEY_LETTERS = "bcdfghjkmnpqrstvwxz"
"""The letters of keys, which form neither words nor anything that a spreadsheet takes for a number."""
KEY_LENGTH = 6


def group_key(part: str, letters: str) -> str:
    """Return the key of a group as written in results.jsonl.

    >>> group_key("p1.jacobian", "kqvxwz")
    'p1.jacobian/kqvxwz'
    """
    return f"{part}/{letters}"


def find_group(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> str | None:
    """Return the letters of the group that a wrong answer belongs to, or None if the group is not known.

    `diagnosis` concerns this answer alone, regardless of mistakes found in earlier parts. Python functions without a
    diagnosed mistake have no group, because each is called at different configurations.
    """
    identity = _identify(problem, part, parsed_answer, diagnosis, secret)
    if identity is None:
        return None
    text = repr((secret, part.name, identity)).encode("utf-8", "replace")
    number, letters = int.from_bytes(hashlib.sha256(text).digest()[:16]), []
    for _ in range(KEY_LENGTH):
        number, index = divmod(number, len(KEY_LETTERS))
        letters.append(KEY_LETTERS[index])
    return "".join(letters)


def _identify(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> tuple[object, ...] | None:
    """Return a tuple that is equal for equivalent answers."""
    if diagnosis is not None and (identifying_mistakes := diagnosis.signature or diagnosis.mistakes):
        return "mistake", *identifying_mistakes
    if parsed_answer.table is not None:
        return None
    if part.answer.offered_options and parsed_answer.chosen:
        return "options", _option_texts(part, parsed_answer.chosen), _option_texts(part, part.answer.correct_indices)
    try:
        if part.answer.is_numeric and parsed_answer.rows is not None:
            return "numbers", part.answer.write_code(), _round_numbers(parsed_answer.entries)
        general_form, is_direction = _GeneralForm(problem.chain), part.answer.counts_up_to_a_factor
        if parsed_answer.tree is not None and part.answer.is_set:
            joints = [q.name for q in problem.chain.q]
            reference = Node(
                "list", tuple(tree for row in part.answer.parse_trees(problem.domain.roles) for tree in row)
            )
            trees = (parsed_answer.tree, reference)
            return "set", *(general_form.fingerprint_conditions(tree, joints, secret) for tree in trees)
        if parsed_answer.rows is not None:
            answer_and_reference = (parsed_answer.rows, part.answer.parse_trees(problem.domain.roles))
            shapes = [(len(rows), len(rows[0])) for rows in answer_and_reference]
            entries = [[entry for row in rows for entry in row] for rows in answer_and_reference]
            return (
                "formulas",
                shapes,
                *(general_form.fingerprint_formulas(each, secret, is_direction) for each in entries),
            )
    except (ParseError, ValueError, ArithmeticError, RecursionError):
        pass  # not a formula: compare the text
    return "text", "".join(parsed_answer.text.split())


def _option_texts(part: Part, option_indices: Sequence[int]) -> tuple[object, ...]:
    """Return the texts of the chosen options, and the item to which each option is matched.

    The letters of the options differ between students.
    """
    texts = [part.answer.offered_options[index] for index in option_indices]
    items = part.answer.matched_items
    return tuple(sorted(zip(items, texts, strict=True) if len(items) == len(texts) else texts))


def _round_numbers(entries: Sequence[Node]) -> tuple[str, ...]:
    """Return the numbers rounded to three significant digits, as required of answers."""
    values = evaluate(compile_program(list(entries)), {}, 1)[0]
    return tuple(f"{complex(value):.2e}" for value in values[:, 0])


class _GeneralForm:
    """Rewrites formulas into a form common to all students: numbers that are given lengths become names.

    `names_in_products` and `names_in_sums` map numbers to expressions of lengths. An ambiguous number is a product of
    lengths in `names_in_products`, and a sum in `names_in_sums`. `offset_by_joint` maps joint variables to their
    offsets, and `shifted_joints` maps them to the variable minus its offset.
    """

    def __init__(self, chain: Chain) -> None:
        names = _name_lengths(_given_lengths(chain))
        self.names_in_products = dict(_drop_ambiguous(names, [_products(names, 2), _products(names, 3), _sums(names)]))
        self.names_in_sums = dict(_drop_ambiguous(names, [_sums(names), _products(names, 2), _products(names, 3)]))
        self.offset_by_joint: dict[str, Node] = {}
        self.shifted_joints: dict[str, Node] = {}
        self.revolute_variables = {q.name for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"}
        for q, joint, offset in zip(chain.q, chain.joints, _list_offsets(chain), strict=True):
            if offset != 0:
                tree = parse_reference(str(offset), frozenset())
                self.offset_by_joint[q.name] = self.generalize(tree, joint.kind == "P")
                self.shifted_joints[q.name] = Node("-", (Node("name", value=q.name), self.offset_by_joint[q.name]))

    def generalize(self, tree: Node, numbers_are_lengths: bool = True) -> Node:
        """Return the tree with given lengths replaced by their names, and with the offsets of joints undone.

        Numbers inside a function or an exponent are not lengths, and a revolute joint's offset is undone only inside
        a function.
        """
        if tree.kind == "name":
            if numbers_are_lengths and tree.value in self.revolute_variables:
                return tree
            return self.shifted_joints.get(tree.value, tree)
        if tree.kind == "blank":
            return Node("name", value="blank")
        if tree.kind in ("number", "decimal"):
            return _replace_number(self.names_in_sums, tree.value) if numbers_are_lengths else tree
        if tree.kind == "call":
            return Node("call", tuple(self.generalize(arg, False) for arg in tree.args), tree.value)
        if tree.kind == "^":
            return Node("^", (self.generalize(tree.args[0], numbers_are_lengths), self.generalize(tree.args[1], False)))
        if numbers_are_lengths and tree.kind in ("*", "/", "neg"):
            return self._generalize_product(tree)
        return Node(tree.kind, tuple(self.generalize(arg, numbers_are_lengths) for arg in tree.args), tree.value)

    def _generalize_product(self, tree: Node) -> Node:
        """Return a product with its numeric factors replaced by the names of lengths.

        If their product is a known length (7*cos(theta2)/20 = 0.35*cos(theta2)), the factors are multiplied together.
        Otherwise each factor is replaced separately.
        """
        factors, number = list(_split_product(tree)), Fraction(1)
        other_factors = [factor for factor in factors if not _is_number(factor[0])]
        for factor, in_denominator in factors:
            if _is_number(factor):
                number *= 1 / factor.value if in_denominator else factor.value
        lengths = self.names_in_products if other_factors else self.names_in_sums
        product = Node("number", value=Fraction(1))
        if abs(number) in lengths:
            product, factors = _replace_number(lengths, number), other_factors
        for factor, in_denominator in factors:
            general_factor = _replace_number(lengths, factor.value) if _is_number(factor) else self.generalize(factor)
            product = Node("/" if in_denominator else "*", (product, general_factor))
        return product

    def fingerprint_formulas(
        self, entries: Sequence[Node], seed: str, up_to_a_factor: bool = False
    ) -> tuple[object, ...]:
        """Return a fingerprint that is equal for equal formulas (and for their multiples, if `up_to_a_factor`)."""
        trees = [self.generalize(entry) for entry in entries]
        digests = fingerprint_results(compile_program(trees), seed)
        pivot = next((tree for tree, digest in zip(trees, digests, strict=True) if digest and any(digest)), None)
        if up_to_a_factor and pivot is not None:
            trees = [Node("/", (tree, pivot)) for tree in trees]
            digests = fingerprint_results(compile_program(trees), seed)
        pairs = zip(trees, digests, strict=True)
        return tuple(_canonical_text(tree) if digest is None else digest for tree, digest in pairs)

    def fingerprint_conditions(self, tree: Node, joints: Sequence[str], seed: str) -> tuple[object, ...]:
        """Return a fingerprint of a set of conditions that doesn't depend on their order."""
        digests = {
            tuple(sorted({repr(self.fingerprint_condition(atom.expression, atom.joint, seed)) for atom in piece}))
            for piece in parse_typed_set(tree, joints)
        }
        return tuple(sorted(digests))

    def fingerprint_condition(self, zero: Node, joint: str | None, seed: str) -> tuple[object, ...]:
        if joint is None:
            return "zero", *self.fingerprint_formulas([zero], seed)
        value = Node("+", (zero, self.offset_by_joint[joint])) if joint in self.offset_by_joint else zero
        multiple_of_pi = find_multiple_of_pi(value)
        if multiple_of_pi is not None:
            return (joint, str(multiple_of_pi))
        return (joint, *self.fingerprint_formulas([value], seed))


def _replace_number(name_by_value: Mapping[Fraction, Node], value: Fraction) -> Node:
    """Return the name of the length that a number is equal to up to its sign, or else the number."""
    absolute_value = name_by_value.get(abs(value), Node("number", value=abs(value)))
    return Node("neg", (absolute_value,)) if value < 0 else absolute_value


def _canonical_text(tree: Node) -> str:
    canonical = canonical_form(ParsedAnswer("", tree=tree))
    return repr(tree) if canonical is None else canonical.text


def _list_offsets(chain: Chain) -> Sequence[sp.Expr]:
    """Return each joint's offset.

    If the base is upright and the first joint revolute, the first offset includes the base's yaw.
    """
    if chain.joints[0].kind == "R" and chain.base.tilt == 0:
        return (chain.offsets[0] + chain.base.yaw, *chain.offsets[1:])
    return chain.offsets


def _given_lengths(chain: Chain) -> Iterator[tuple[str, sp.Expr]]:
    """Yield the lengths and offsets of an arm, under names that are the same for all arms."""
    for number, (joint, offset) in enumerate(zip(chain.joints, chain.offsets, strict=True), 1):
        yield f"a{number}", joint.a
        yield (f"d{number}", joint.d) if joint.kind == "R" else (f"zero of d{number}", offset)
    for frame, values in (("base", chain.base.position), ("point", chain.point.offset)):
        for axis, value in zip("xyz", values, strict=True):
            yield f"{frame} {axis}", value


NumbersAndNodes = Iterator[tuple[Fraction, Node]]
"""Pairs of a number and the expression of named lengths that it is equal to."""


def _name_lengths(lengths: Iterator[tuple[str, sp.Expr]]) -> dict[Fraction, Node]:
    """Return a mapping from the absolute value of each length to its name.

    Lengths of equal value share one name, which is composed of all their names.
    """
    names_by_value: dict[Fraction, list[tuple[str, int]]] = {}
    for name, value in lengths:
        if value.is_Rational and value != 0:
            number = Fraction(int(value.p), int(value.q))
            names_by_value.setdefault(abs(number), []).append((name, 1 if number > 0 else -1))
    return {value: _signed_name(names_and_signs) for value, names_and_signs in names_by_value.items()}


def _drop_ambiguous(name_by_value: Mapping[Fraction, Node], sources: Sequence[NumbersAndNodes]) -> NumbersAndNodes:
    """Yield the numbers that equal a length or an expression of several lengths, and this expression.

    `sources` are the sources of expressions, the most likely first. A number that is ambiguous within one source, and
    every integer (2 may be just a factor), is left out.
    """
    known_numbers = {value for value in name_by_value if value.denominator == 1}
    for pairs in (iter(name_by_value.items()), *sources):
        nodes: dict[Fraction, list[Node]] = {}
        for value, node in pairs:
            nodes.setdefault(value, []).append(node)
        for value, candidates in nodes.items():
            if value not in known_numbers and value.denominator != 1 and len(candidates) == 1:
                yield value, candidates[0]
        known_numbers |= set(nodes)


def _signed_name(names_and_signs: Sequence[tuple[str, int]]) -> Node:
    name = Node("name", value=" = ".join(name for name, _ in names_and_signs))
    return name if names_and_signs[0][1] > 0 else Node("neg", (name,))


def _products(name_by_value: Mapping[Fraction, Node], count: int) -> NumbersAndNodes:
    for values in combinations_with_replacement(name_by_value, count):
        names = (name_by_value[value] for value in values)
        yield math.prod(values, start=Fraction(1)), reduce(lambda product, name: Node("*", (product, name)), names)


def _sums(name_by_value: Mapping[Fraction, Node]) -> NumbersAndNodes:
    """Yield a + b, a - b > 0, 2 a and 2 a b for lengths a and b."""
    yield from _double((value, node) for value, node in name_by_value.items())
    yield from _double(_products(name_by_value, 2))
    for larger_length, smaller_length in permutations(name_by_value, 2):
        if larger_length > smaller_length:
            yield (
                larger_length + smaller_length,
                Node("+", (name_by_value[larger_length], name_by_value[smaller_length])),
            )
            yield (
                larger_length - smaller_length,
                Node("-", (name_by_value[larger_length], name_by_value[smaller_length])),
            )


def _double(pairs: NumbersAndNodes) -> NumbersAndNodes:
    for value, node in pairs:
        yield 2 * value, Node("+", (node, node))


def _is_number(node: Node) -> bool:
    return node.kind in ("number", "decimal") and bool(node.value)


def _split_product(tree: Node) -> Iterator[tuple[Node, bool]]:
    """Yield each factor of a nested product or quotient, and whether it is in the denominator.

    A minus sign is the factor -1.
    """
    stack = [(tree, False)]
    while stack:
        node, in_denominator = stack.pop()
        if node.kind == "neg":
            yield Node("number", value=Fraction(-1)), False
        if node.kind in ("*", "neg"):
            stack += [(arg, in_denominator) for arg in reversed(node.args)]
        elif node.kind == "/":
            stack += [(node.args[1], not in_denominator), (node.args[0], in_denominator)]
        else:
            yield node, in_denominator
