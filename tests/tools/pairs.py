"""`make pairs`: from the formulas of all families, make right and wrong answers, and check every verdict.

For a right answer, identities are applied at random places of a reference's tree. For a wrong one, a random place is
changed; it counts only if its values differ by much more than rounding at some configuration. `python -m
tests.tools.pairs --count 100000` prints the wrong verdicts, and exits with code 1 if there are any.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node, find_names, format_tree
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import judge_expression

QUESTION_NAMES = ("position", "velocity", "jacobian", "determinant", "inverse-jacobian", "inverse-velocity",
         "geometric-jacobian", "gram-determinant", "joint-torques", "link-velocity")  # fmt: skip
MAX_LENGTH = 1500
"""Longer references and rewritings are left unchanged."""


def number(value: int | Fraction) -> Node:
    """Return the tree of a number."""
    return Node("neg", (number(-value),)) if value < 0 else Node("number", value=Fraction(value))


PI, TWO, IMAGINARY = Node("name", value="pi"), number(2), Node("name", value="I")


def call(name: str, arg: Node) -> Node:
    """Return a function of a tree."""
    return Node("call", (arg,), name)


def times(*factors: Node) -> Node:
    """Return a product of trees."""
    product = factors[0]
    for factor in factors[1:]:
        product = Node("*", (product, factor))
    return product


def plus(left: Node, right: Node, sign: str = "+") -> Node:
    """Return a sum or difference of trees."""
    return Node(sign, (left, right))


def over(numerator: Node, denominator: Node) -> Node:
    """Return a quotient of trees."""
    return Node("/", (numerator, denominator))


Rule = Callable[[Node, Stream], Node | None]


def shift_angle(node: Node, rng: Stream) -> Node | None:
    """Rewrite sin(x) as cos(x - pi/2), as -sin(x + pi), or with full turns added."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    x, kind = node.args[0], rng.integer_below(3)
    if kind == 0:
        cofunction = "cos" if node.value == "sin" else "sin"
        return call(cofunction, plus(x, over(PI, TWO), "-" if node.value == "sin" else "+"))
    if kind == 1:
        return Node("neg", (call(node.value, plus(x, PI, rng.choice("+-"))),))
    return call(node.value, plus(x, times(number(2 * rng.integer(-3, 3)), PI)))


def use_half_angles(node: Node, rng: Stream) -> Node | None:
    """Rewrite sin and cos in terms of the half angle: its tangent, or its sine and cosine."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    half = over(node.args[0], TWO)
    t2, s2 = (Node("^", (call(name, half), TWO)) for name in ("tan", "sin"))
    if rng.integer_below(2):
        above = times(TWO, call("tan", half)) if node.value == "sin" else plus(number(1), t2, "-")
        return over(above, plus(number(1), t2))
    return (
        times(TWO, call("sin", half), call("cos", half))
        if node.value == "sin"
        else plus(number(1), times(TWO, s2), "-")
    )


def use_exponentials(node: Node, rng: Stream) -> Node | None:
    """Rewrite sin and cos as complex exponentials."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    ahead, back = (call("exp", times(IMAGINARY, sign)) for sign in (node.args[0], Node("neg", (node.args[0],))))
    if node.value == "cos":
        return over(plus(ahead, back), TWO)
    return over(plus(ahead, back, "-"), times(TWO, IMAGINARY))


def expand_angle_sum(node: Node, rng: Stream) -> Node | None:
    """Expand the sine or cosine of a sum."""
    if node.kind != "call" or node.value not in ("sin", "cos") or node.args[0].kind not in ("+", "-"):
        return None
    sum_ = node.args[0]
    (sx, cx), (sy, cy) = ((call("sin", x), call("cos", x)) for x in sum_.args)
    if node.value == "sin":
        return plus(times(sx, cy), times(cx, sy), sum_.kind)
    return plus(times(cx, cy), times(sx, sy), "-" if sum_.kind == "+" else "+")


def product_to_sum(node: Node, rng: Stream) -> Node | None:
    """Rewrite a product of two sines or cosines as a sum."""
    if node.kind != "*" or any(arg.kind != "call" or arg.value not in ("sin", "cos") for arg in node.args):
        return None
    (f, x), (g, y) = ((arg.value, arg.args[0]) for arg in node.args)
    low, high = plus(x, y, "-"), plus(x, y)
    if f == g:
        return over(plus(call("cos", low), call("cos", high), "+" if f == "cos" else "-"), TWO)
    return over(plus(call("sin", high), call("sin", low), "+" if f == "sin" else "-"), TWO)


def multiply_by_one(node: Node, rng: Stream) -> Node | None:
    """Multiply by 1 in another form."""
    x = call("sin", Node("name", value="theta1")), call("cos", Node("name", value="theta1"))
    ones = (
        plus(Node("^", (x[0], TWO)), Node("^", (x[1], TWO))),
        over(x[1], x[1]),
        Node("decimal", value=Fraction("1.0")),
    )
    return times(node, rng.choice(ones))


def swap_operands(node: Node, rng: Stream) -> Node | None:
    """Swap the operands of a sum or product."""
    return Node(node.kind, node.args[::-1]) if node.kind in ("+", "*") else None


def multiply_out(node: Node, rng: Stream) -> Node | None:
    """Multiply out a product with a sum."""
    if node.kind != "*" or node.args[1].kind not in ("+", "-"):
        return None
    x, sum_ = node.args
    return plus(times(x, sum_.args[0]), times(x, sum_.args[1]), sum_.kind)


def write_as_decimal(node: Node, rng: Stream) -> Node | None:
    """Write a number as a decimal if it has few digits."""
    if node.kind != "number" or any(node.value.denominator % p == 0 for p in (3, 7, 11, 13)) or node.value > 10**6:
        return None
    denominator = node.value.denominator
    while denominator % 2 == 0:
        denominator //= 2
    while denominator % 5 == 0:
        denominator //= 5
    return Node("decimal", value=node.value) if denominator == 1 else None


def insert_identity(node: Node, rng: Stream) -> Node | None:
    """Replace a tree by an equal one, such as half of its double, or its double negative."""
    kind = rng.integer_below(3)
    if kind == 0:
        return over(times(TWO, node), TWO)
    return Node("neg", (Node("neg", (node,)),)) if kind == 1 else plus(plus(node, IMAGINARY), IMAGINARY, "-")


REWRITINGS: tuple[Rule, ...] = (
    shift_angle, use_half_angles, use_exponentials, expand_angle_sum, product_to_sum, multiply_by_one, swap_operands,
    swap_operands, multiply_out, multiply_out, write_as_decimal, insert_identity,
)  # fmt: skip


def swap_sine_and_cosine(node: Node, rng: Stream) -> Node | None:
    """Replace a sine by a cosine, or the reverse."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    return call("cos" if node.value == "sin" else "sin", node.args[0])


def change_sign(node: Node, rng: Stream) -> Node | None:
    """Change a sign in a sum."""
    return Node("-" if node.kind == "+" else "+", node.args) if node.kind in ("+", "-") else None


def drop_operand(node: Node, rng: Stream) -> Node | None:
    """Drop a term or a factor."""
    return rng.choice(node.args) if node.kind in ("+", "-", "*") else None


def change_index(node: Node, rng: Stream) -> Node | None:
    """Change the index of a name."""
    if node.kind != "name" or not node.value[-1].isdigit():
        return None
    return Node("name", value=f"{node.value[:-1]}{rng.integer(1, 4)}")


def change_number(node: Node, rng: Stream) -> Node | None:
    """Change a number slightly."""
    if node.kind != "number":
        return None
    return Node(
        "number", value=node.value + rng.choice((Fraction(1), Fraction(1, 100), Fraction(1, 10**9), Fraction(-1, 7)))
    )


def lose_sign(node: Node, rng: Stream) -> Node | None:
    """Remove the sign of a sine or cosine with an absolute value or a root."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    return call("abs", node) if rng.integer_below(2) else call("sqrt", Node("^", (node, TWO)))


def add_small_term(node: Node, rng: Stream) -> Node | None:
    """Add a very small term."""
    return plus(node, times(Node("number", value=Fraction(1, 10 ** rng.integer(3, 8))), Node("name", value="a1")))


MUTATIONS: tuple[Rule, ...] = (
    swap_sine_and_cosine,
    change_sign,
    drop_operand,
    change_index,
    change_number,
    lose_sign,
    add_small_term,
)


def places(node: Node) -> list[tuple[int, ...]]:
    """Return every place in a tree, as the indices of the operands on the path to it."""
    return [(), *((i, *place) for i, arg in enumerate(node.args) for place in places(arg))]


def subtree_at(node: Node, place: tuple[int, ...]) -> Node:
    """Return the subtree at a place."""
    for i in place:
        node = node.args[i]
    return node


def replace_at(node: Node, place: tuple[int, ...], new: Node) -> Node:
    """Return the tree with another subtree at a place."""
    if not place:
        return new
    args = list(node.args)
    args[place[0]] = replace_at(args[place[0]], place[1:], new)
    return Node(node.kind, tuple(args), node.value)


def apply_rules(node: Node, rules: tuple[Rule, ...], rng: Stream, steps: int) -> Node:
    """Return a tree with some rules applied at random places."""
    for _ in range(steps):
        for _ in range(20):
            place = rng.choice(places(node))
            inside_a_power = any(subtree_at(node, place[:k]).kind == "^" and place[k] == 1 for k in range(len(place)))
            new = None if inside_a_power else rng.choice(rules)(subtree_at(node, place), rng)
            if new is not None:
                longer = replace_at(node, place, new)
                node = longer if len(format_tree(longer)) <= 2 * MAX_LENGTH else node
                break
    return node


def is_different(first: Node, second: Node, domain: Domain, rng: Stream) -> bool | None:
    """Return whether two trees clearly differ at some point, or None if that is unclear."""
    symbols = find_names(first) | find_names(second)
    values = domain.sample(symbols, 200, rng)
    (a, ma), (b, mb) = (evaluate(compile_program([tree]), values, 200) for tree in (first, second))
    good = np.isfinite(a) & np.isfinite(b) & np.isfinite(ma) & np.isfinite(mb)
    difference = np.abs(a[good] - b[good]) / np.maximum(ma[good] + mb[good], 1e-300)
    if not len(difference):
        return None
    return True if difference.max() > 1e-10 else None if difference.max() > 1e-13 else False


def references(seeds: Iterator[int]) -> Iterator[tuple[str, Node, Domain]]:
    """Yield the formulas of all families' problems, with their origins."""
    for seed in seeds:
        for family in FAMILIES:
            if FAMILIES[family].has_varied_structure:
                questions: tuple[str, ...] = ("jacobian",)
            else:
                questions = tuple(
                    question for question in list_questions_of_family(family) if question in QUESTION_NAMES
                )
            problem = generate(ProblemId(family, seed, questions))
            domain = problem.domain
            for part in problem.parts:
                answer = part.answer
                entries = list(answer.reference) if isinstance(answer, Matrix) else []
                entries = [answer.reference] if isinstance(answer, Expression) else entries
                for index, entry in enumerate(entries):
                    if len(text := format_expression(entry)) <= MAX_LENGTH:
                        yield f"{family}/{seed} {part.name}[{index}]", parse_formula(text, domain.roles), domain


@dataclass(frozen=True)
class Pair:
    """An answer made from a reference: its origin, how it was made, whether it is right, both texts, and the seed."""

    source: str
    kind: str
    is_right: bool
    answer: str
    reference: str
    domain: Domain
    seed: str


def pairs(count: int) -> Iterator[Pair]:
    """Yield references and answers, each with whether they are the same function."""
    count_so_far = 0
    for source, reference, domain in references(iter(range(10**9))):
        text = format_tree(reference)
        for k in range(6):
            if count_so_far >= count:
                return
            rng = Stream(f"pairs/{source}/{k}")
            is_rewriting = k % 2 == 0
            tree = apply_rules(reference, REWRITINGS, rng, rng.integer(1, 5))
            if not is_rewriting:
                tree = apply_rules(tree, MUTATIONS, rng, 1)
            differs = is_different(tree, reference, domain, rng)
            if is_rewriting and differs:
                raise AssertionError(f"a rewriting is no identity: {source}: {format_tree(tree)}")
            if differs is None or (not is_rewriting and not differs):
                continue  # floating-point values can't tell
            count_so_far += 1
            kind, seed = "rewritten" if is_rewriting else "changed", f"pairs/{source}/{k}"
            yield Pair(source, kind, not differs, format_tree(tree), text, domain, seed)


def verdicts(count: int) -> Iterator[tuple[str, str, bool, bool, str]]:
    """Yield for each pair its source, kind, whether it is right, the grader's verdict, and the answer."""
    for pair in pairs(count):
        judgement = judge_expression(pair.answer, pair.reference, pair.domain, pair.seed)
        yield pair.source, pair.kind, pair.is_right, judgement.outcome is Outcome.CORRECT, pair.answer


def main() -> int:
    """Run the sweep, and print the wrong verdicts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000)
    count = parser.parse_args().count
    counts: Counter[tuple[str, bool]] = Counter()
    wrong, start = 0, time.perf_counter()
    for done, (source, kind, is_right, verdict, answer) in enumerate(verdicts(count), 1):
        counts[kind, is_right] += 1
        if verdict != is_right:
            wrong += 1
            sys.stdout.write(
                f"{source}: {kind}, {'right' if is_right else 'wrong'} answer judged otherwise: {answer}\n"
            )
        if done % 5000 == 0:
            sys.stderr.write(f"{done} of {count} pairs, {wrong} wrong verdicts, {time.perf_counter() - start:.0f} s\n")
    summary = ", ".join(
        f"{n} {kind} ({'right' if is_right else 'wrong'})" for (kind, is_right), n in sorted(counts.items())
    )
    sys.stdout.write(
        f"{sum(counts.values())} pairs in {time.perf_counter() - start:.0f} s: {summary}; {wrong} wrong verdicts\n"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
