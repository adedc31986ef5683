"""Compute the keys of groups of wrong answers; students whose answers are wrong in the same way share a key.

Two answers are in one group if the same mistake was made at the same joint or entry. If no mistake is known, two
answers are in one group if their formulas are equal and their expected answers are equal. For this comparison, the
lengths in a student's table are replaced by their names: 0.6 becomes a2. A joint variable plus its offset, such as
theta1 + pi/4, becomes one angle. A number that can't be replaced remains, so only students with that number share a
key.

A key depends on the problem, the answer and the assignment's secret, but not on other students' answers. It doesn't
change when other students submit, and without the secret nobody can compute the key.
"""

import cmath
import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import chain, combinations_with_replacement, permutations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.formula.angles import find_multiple_of_pi
from qdot.exercises.formula.exact import fingerprint_results
from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, parse_typed_set
from qdot.exercises.formula.trees import Node, ParseError
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis

KEY_LETTERS = "bcdfghjkmnpqrstvwxz"
"""The letters of keys. They form no words, and no key looks like a number to a spreadsheet."""
KEY_LENGTH = 6
"""Number of letters of a key."""


def format_group_key(part: str, letters: str) -> str:
    """Return the key of a group in the form of results.jsonl.

    >>> format_group_key("p1.jacobian", "kqvxwz")
    'p1.jacobian/kqvxwz'
    """
    return f"{part}/{letters}"


def find_group(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> str | None:
    """Return the letters of the key of a wrong answer's group, or None if the answer has no group.

    `diagnosis` concerns this answer alone, regardless of mistakes found in earlier parts. Python functions without a
    diagnosed mistake have no group, because each function is called at different configurations.
    """
    identity = _make_identity(problem, part, parsed_answer, diagnosis, secret)
    if identity is None:
        return None
    text = repr((secret, part.name, identity)).encode("utf-8", "replace")
    number, base = int.from_bytes(hashlib.sha256(text).digest()[:16]), len(KEY_LETTERS)
    return "".join(KEY_LETTERS[number // base**k % base] for k in range(KEY_LENGTH))


def _make_identity(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, diagnosis: Diagnosis | None, secret: str
) -> tuple[object, ...] | None:
    """Return a tuple that is equal for all answers of a group."""
    if diagnosis is not None and (identifying_mistakes := diagnosis.signature or diagnosis.mistakes):
        return "mistake", *identifying_mistakes
    if parsed_answer.table is not None:
        return None
    if part.answer.offered_options and parsed_answer.chosen_indices:
        typed_and_correct_indices = parsed_answer.chosen_indices, part.answer.correct_indices
        return "options", *(_list_option_texts(part, indices) for indices in typed_and_correct_indices)
    try:
        if part.answer.is_numeric and parsed_answer.rows is not None:
            return "numbers", part.answer.write_code(), _round_numbers(parsed_answer.entries, part)
        general_form, roles = _GeneralForm(problem.chain, secret), problem.domain.roles
        if parsed_answer.tree is not None and part.answer.is_set:
            reference = Node("list", tuple(chain.from_iterable(part.answer.parse_trees(roles))))
            joints, trees = [q.name for q in problem.chain.q], (parsed_answer.tree, reference)
            return "set", *(general_form.fingerprint_set(tree, joints) for tree in trees)
        if parsed_answer.rows is not None:
            forms = (parsed_answer.rows, part.answer.parse_trees(roles))
            shapes, is_direction = [(len(rows), len(rows[0])) for rows in forms], part.answer.is_direction
            entries = (list(chain.from_iterable(rows)) for rows in forms)
            return "formulas", shapes, *(general_form.fingerprint_formulas(nodes, is_direction) for nodes in entries)
    except (ParseError, ValueError, ArithmeticError, RecursionError):
        pass  # not a formula: compare the text
    return "text", "".join(parsed_answer.text.split())


def _list_option_texts(part: Part, option_indices: Sequence[int]) -> tuple[object, ...]:
    """Return the texts of options, each with the item to which it is matched, if any.

    The letters of the options are not used, because they differ between students.
    """
    texts = [part.answer.offered_options[index] for index in option_indices]
    items = part.answer.matched_items
    return tuple(sorted(zip(items, texts, strict=True) if len(items) == len(texts) else texts))


def _round_numbers(entries: Sequence[Node], part: Part) -> tuple[str, ...]:
    """Return the numbers as texts with the precision required of answers."""
    values = list(map(complex, evaluate(compile_program(list(entries)), {}, 1).values[:, 0]))
    digits = (part.count_digits(abs(value)) if cmath.isfinite(value) else 3 for value in values)
    return tuple(f"{value:.{count - 1}e}" for value, count in zip(values, digits, strict=True))


class _GeneralForm:
    """Rewrites formulas into a form common to all students, with names instead of the numeric lengths of an arm.

    `names_in_products` maps numeric factors of a product to expressions of named lengths, and `names_in_sums` maps all
    other numbers. The two differ if a number equals both a product and a sum of lengths. `offset_by_joint` maps joint
    variables to their offsets, and `shifted_joints` maps joint variables to the variable minus its offset. `seed`
    determines the numbers at which formulas are compared.
    """

    def __init__(self, arm: Chain, seed: str) -> None:
        names, self.seed = _name_lengths(arm), seed
        products = [*_list_products(names, count=2)], [*_list_products(names, count=3)]
        sums = [*_list_sums(names)]
        self.names_in_products = dict(_drop_ambiguous(names, [*products, sums]))
        self.names_in_sums = dict(_drop_ambiguous(names, [sums, *products]))
        self.offset_by_joint: dict[str, Node] = {}
        self.shifted_joints: dict[str, Node] = {}
        self.revolute_variables = {q.name for q, joint in zip(arm.q, arm.joints, strict=True) if joint.is_revolute}
        for q, joint, offset in zip(arm.q, arm.joints, _list_offsets(arm), strict=True):
            if offset != 0:
                tree = parse_reference(str(offset), frozenset())
                self.offset_by_joint[q.name] = self.generalize(tree, joint.is_prismatic)
                self.shifted_joints[q.name] = Node("-", (Node("name", value=q.name), self.offset_by_joint[q.name]))

    def generalize(self, tree: Node, numbers_are_lengths: bool = True) -> Node:
        """Return the tree with the arm's lengths replaced by their names, and with the offsets of joints undone.

        `numbers_are_lengths` is False for trees inside a function or an exponent. The offset of a revolute joint is
        undone only there.
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
            return Node("call", tuple(self.generalize(arg, numbers_are_lengths=False) for arg in tree.args), tree.value)
        if tree.kind == "^":
            base = self.generalize(tree.args[0], numbers_are_lengths)
            return Node("^", (base, self.generalize(tree.args[1], numbers_are_lengths=False)))
        if numbers_are_lengths and tree.kind in ("*", "/", "neg"):
            return self._generalize_product(tree)
        return Node(tree.kind, tuple(self.generalize(arg, numbers_are_lengths) for arg in tree.args), tree.value)

    def _generalize_product(self, tree: Node) -> Node:
        """Return a product with its numeric factors replaced by the names of lengths.

        If the product of all numeric factors is a known length, it is replaced as a whole: 7*cos(theta2)/20 is
        0.35*cos(theta2). Otherwise each factor is replaced separately.
        """
        factors, number = list(_split_product(tree)), Fraction(1)
        other_factors = [factor for factor in factors if not _is_number(factor[0])]
        for factor, is_in_denominator in factors:
            if _is_number(factor):
                number *= 1 / factor.value if is_in_denominator else factor.value
        lengths = self.names_in_products if other_factors else self.names_in_sums
        product = Node("number", value=Fraction(1))
        if abs(number) in lengths:
            product, factors = _replace_number(lengths, number), other_factors
        for factor, is_in_denominator in factors:
            general_factor = _replace_number(lengths, factor.value) if _is_number(factor) else self.generalize(factor)
            product = Node("/" if is_in_denominator else "*", (product, general_factor))
        return product

    def fingerprint_formulas(self, entries: Sequence[Node], is_direction: bool = False) -> tuple[object, ...]:
        """Return a fingerprint that is equal for equal formulas, and for a direction and its multiples."""
        trees = [self.generalize(entry) for entry in entries]
        digests = fingerprint_results(compile_program(trees), self.seed)
        pivot = next((tree for tree, digest in zip(trees, digests, strict=True) if digest and any(digest)), None)
        if is_direction and pivot is not None:
            trees = [Node("/", (tree, pivot)) for tree in trees]
            digests = fingerprint_results(compile_program(trees), self.seed)
        pairs = zip(trees, digests, strict=True)
        return tuple(_write_sorted(tree) if digest is None else digest for tree, digest in pairs)

    def fingerprint_set(self, tree: Node, joints: Sequence[str]) -> tuple[object, ...]:
        """Return a fingerprint of a set of configurations that doesn't depend on the order of its conditions."""
        digests = {
            tuple(sorted({repr(self._fingerprint_condition(atom)) for atom in piece}))
            for piece in parse_typed_set(tree, joints)
        }
        return tuple(sorted(digests))

    def _fingerprint_condition(self, atom: Atom) -> tuple[object, ...]:
        if atom.joint is None:
            return "zero", *self.fingerprint_formulas([atom.expression])
        offset = self.offset_by_joint.get(atom.joint)
        value = atom.expression if offset is None else Node("+", (atom.expression, offset))
        multiple_of_pi = find_multiple_of_pi(value)
        if multiple_of_pi is not None:
            return atom.joint, str(multiple_of_pi)
        return atom.joint, *self.fingerprint_formulas([value])


def _replace_number(name_by_value: Mapping[Fraction, Node], value: Fraction) -> Node:
    """Return the name of the length that is equal to a number up to the sign; the number itself if there is none."""
    absolute_value = name_by_value.get(abs(value), Node("number", value=abs(value)))
    return Node("neg", (absolute_value,)) if value < 0 else absolute_value


def _write_sorted(tree: Node) -> str:
    """Return the text of a tree, with the factors of products and the operands of sums in alphabetical order."""
    if tree.kind in ("*", "/", "neg"):
        factors = ((_write_sorted(factor), is_in_denominator) for factor, is_in_denominator in _split_product(tree))
        return repr(sorted(factors))
    texts = list(map(_write_sorted, tree.args))
    return f"{tree.kind} {tree.value} {sorted(texts) if tree.kind == '+' else texts}"


def _list_offsets(arm: Chain) -> Sequence[sp.Expr]:
    """Return each joint's offset.

    If the base is upright and the first joint revolute, the first offset includes the base's yaw.
    """
    if arm.joints[0].is_revolute and arm.base.tilt == 0:
        return (arm.offsets[0] + arm.base.yaw, *arm.offsets[1:])
    return arm.offsets


def _list_lengths(arm: Chain) -> Iterator[tuple[str, sp.Expr]]:
    """Yield the lengths and offsets of an arm, under names that are the same for all arms."""
    for number, (joint, offset) in enumerate(zip(arm.joints, arm.offsets, strict=True), 1):
        yield f"a{number}", joint.a
        yield (f"d{number}", joint.d) if joint.is_revolute else (f"zero of d{number}", offset)
    for frame, values in (("base", arm.base.position), ("point", arm.point.offset)):
        for axis, value in zip("xyz", values, strict=True):
            yield f"{frame} {axis}", value


NumbersAndNodes = Iterable[tuple[Fraction, Node]]
"""Pairs of a number and an expression of named lengths that has this value."""


def _name_lengths(arm: Chain) -> dict[Fraction, Node]:
    """Map the absolute value of each numeric length to its name, or to minus its name if the length is negative.

    Lengths of equal value share one name, which is composed of all their names.
    """
    names_by_value: dict[Fraction, list[str]] = {}
    negative_values = set[Fraction]()
    for name, value in _list_lengths(arm):
        if value.is_Rational and value != 0:
            number = Fraction(int(value.p), int(value.q))
            if abs(number) not in names_by_value and number < 0:
                negative_values.add(abs(number))
            names_by_value.setdefault(abs(number), []).append(name)
    nodes = {value: Node("name", value=" = ".join(names)) for value, names in names_by_value.items()}
    return {value: Node("neg", (node,)) if value in negative_values else node for value, node in nodes.items()}


def _drop_ambiguous(name_by_value: Mapping[Fraction, Node], sources: Sequence[NumbersAndNodes]) -> NumbersAndNodes:
    """Yield the numbers that equal a length or an expression of several lengths, each with this length or expression.

    `sources` are the sources of expressions, the most likely source first. A number that is ambiguous within one source
    is left out, and so is every integer, because a 2 may be just a factor.
    """
    known_numbers = set[Fraction]()
    for pairs in (name_by_value.items(), *sources):
        nodes: dict[Fraction, list[Node]] = {}
        for value, node in pairs:
            nodes.setdefault(value, []).append(node)
        for value, candidates in nodes.items():
            if value not in known_numbers and value.denominator != 1 and len(candidates) == 1:
                yield value, candidates[0]
        known_numbers |= set(nodes)


def _list_products(name_by_value: Mapping[Fraction, Node], count: int) -> NumbersAndNodes:
    for values in combinations_with_replacement(name_by_value, count):
        names = (name_by_value[value] for value in values)
        yield math.prod(values, start=Fraction(1)), reduce(lambda product, name: Node("*", (product, name)), names)


def _list_sums(name_by_value: Mapping[Fraction, Node]) -> NumbersAndNodes:
    """Yield a + b, a - b > 0, 2 a and 2 a b for lengths a and b."""
    for value, node in [*name_by_value.items(), *_list_products(name_by_value, count=2)]:
        yield 2 * value, Node("+", (node, node))
    for (longer, longer_name), (shorter, shorter_name) in permutations(name_by_value.items(), 2):
        if longer > shorter:
            yield longer + shorter, Node("+", (longer_name, shorter_name))
            yield longer - shorter, Node("-", (longer_name, shorter_name))


def _is_number(node: Node) -> bool:
    return node.kind in ("number", "decimal") and bool(node.value)


def _split_product(tree: Node) -> Iterator[tuple[Node, bool]]:
    """Yield each factor of a nested product or quotient, and whether it is in the denominator.

    A minus sign is the factor -1.
    """
    stack = [(tree, False)]
    while stack:
        node, is_in_denominator = stack.pop()
        if node.kind == "neg":
            yield Node("number", value=Fraction(-1)), False
        if node.kind in ("*", "neg"):
            stack += [(arg, is_in_denominator) for arg in reversed(node.args)]
        elif node.kind == "/":
            stack += [(node.args[1], not is_in_denominator), (node.args[0], is_in_denominator)]
        else:
            yield node, is_in_denominator
