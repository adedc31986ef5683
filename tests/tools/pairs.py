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
from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import ONE, Node, find_names, format_tree, make_number
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import judge_expression

QUESTION_NAMES = ("position", "velocity", "jacobian", "determinant", "inverse-jacobian", "inverse-velocity",
         "geometric-jacobian", "gram-determinant", "joint-torques", "link-velocity")  # fmt: skip
MAX_LENGTH = 1500
"""Longer references and rewritings are left unchanged."""

PI, IMAGINARY, THETA1, A1 = (Node("name", value=name) for name in ("pi", "I", "theta1", "a1"))
COFUNCTIONS = {"sin": "cos", "cos": "sin"}
Rule = Callable[[Node, Stream], Node | None]


def apply_function(name: str, arg: Node) -> Node:
    return Node("call", (arg,), name)


def is_sine_or_cosine(node: Node) -> bool:
    return node.kind == "call" and node.value in COFUNCTIONS


def shift_angle(node: Node, rng: Stream) -> Node | None:
    """Rewrite sin(x) as cos(x - pi/2), as -sin(x + pi), or with full turns added."""
    if not is_sine_or_cosine(node):
        return None
    x, rule_number, quarter_turn = node.args[0], rng.integer_below(3), PI / 2
    if rule_number == 0:
        return apply_function(COFUNCTIONS[node.value], x - quarter_turn if node.value == "sin" else x + quarter_turn)
    if rule_number == 1:
        return -apply_function(node.value, rng.choice((x + PI, x - PI)))
    return apply_function(node.value, x + make_number(2 * rng.integer(1, 3)) * PI)


def use_half_angles(node: Node, rng: Stream) -> Node | None:
    if not is_sine_or_cosine(node):
        return None
    sine, cosine, tangent = (apply_function(name, node.args[0] / 2) for name in ("sin", "cos", "tan"))
    if rng.integer_below(2):
        return (2 * tangent if node.value == "sin" else ONE - tangent**2) / (ONE + tangent**2)
    return 2 * sine * cosine if node.value == "sin" else ONE - 2 * sine**2


def use_exponentials(node: Node, rng: Stream) -> Node | None:
    if not is_sine_or_cosine(node):
        return None
    ahead, back = (apply_function("exp", IMAGINARY * angle) for angle in (node.args[0], -node.args[0]))
    return (ahead + back) / 2 if node.value == "cos" else (ahead - back) / (2 * IMAGINARY)


def expand_angle_sum(node: Node, rng: Stream) -> Node | None:
    if not is_sine_or_cosine(node) or node.args[0].kind not in ("+", "-"):
        return None
    sign = 1 if node.args[0].kind == "+" else -1
    (sx, cx), (sy, cy) = ((apply_function("sin", x), apply_function("cos", x)) for x in node.args[0].args)
    return sx * cy + sign * (cx * sy) if node.value == "sin" else cx * cy - sign * (sx * sy)


def rewrite_product_as_sum(node: Node, rng: Stream) -> Node | None:
    if node.kind != "*" or not all(map(is_sine_or_cosine, node.args)):
        return None
    (f, x), (g, y) = ((arg.value, arg.args[0]) for arg in node.args)
    if f == g:
        return (apply_function("cos", x - y) + (1 if f == "cos" else -1) * apply_function("cos", x + y)) / 2
    return (apply_function("sin", x + y) + (1 if f == "sin" else -1) * apply_function("sin", x - y)) / 2


def multiply_by_one(node: Node, rng: Stream) -> Node | None:
    s, c = apply_function("sin", THETA1), apply_function("cos", THETA1)
    return node * rng.choice((s**2 + c**2, c / c, Node("decimal", value=Fraction(1))))


def swap_operands(node: Node, rng: Stream) -> Node | None:
    return node.with_args(node.args[::-1]) if node.kind in ("+", "*") else None


def multiply_out(node: Node, rng: Stream) -> Node | None:
    if node.kind != "*" or node.args[1].kind not in ("+", "-"):
        return None
    x, sum_ = node.args
    return sum_.with_args([x * term for term in sum_.args])


def write_as_decimal(node: Node, rng: Stream) -> Node | None:
    """Write a number as a decimal if it has few digits."""
    if node.kind != "number" or node.value > 10**6 or 10**40 % node.value.denominator:
        return None
    return Node("decimal", value=node.value)


def insert_identity(node: Node, rng: Stream) -> Node | None:
    """Replace a tree by an equal one, such as half of its double, or its double negative."""
    doubled, twice_negated = 2 * node / 2, Node("neg", (Node("neg", (node,)),))
    return rng.choice((doubled, twice_negated, node + IMAGINARY - IMAGINARY))


REWRITINGS: tuple[Rule, ...] = (
    shift_angle, use_half_angles, use_exponentials, expand_angle_sum, rewrite_product_as_sum, multiply_by_one,
    swap_operands, swap_operands, multiply_out, multiply_out, write_as_decimal, insert_identity,
)  # fmt: skip


def swap_sine_and_cosine(node: Node, rng: Stream) -> Node | None:
    return apply_function(COFUNCTIONS[node.value], node.args[0]) if is_sine_or_cosine(node) else None


def change_sign(node: Node, rng: Stream) -> Node | None:
    return Node("-" if node.kind == "+" else "+", node.args) if node.kind in ("+", "-") else None


def drop_operand(node: Node, rng: Stream) -> Node | None:
    return rng.choice(node.args) if node.kind in ("+", "-", "*") else None


def change_index(node: Node, rng: Stream) -> Node | None:
    if node.kind != "name" or not node.value[-1].isdigit():
        return None
    return Node("name", value=f"{node.value[:-1]}{rng.integer(1, 4)}")


def change_number(node: Node, rng: Stream) -> Node | None:
    changes = (Fraction(1), Fraction(1, 100), Fraction(1, 10**9), Fraction(-1, 7))
    return make_number(node.value + rng.choice(changes)) if node.kind == "number" else None


def lose_sign(node: Node, rng: Stream) -> Node | None:
    """Remove the sign of a sine or cosine with an absolute value or a root."""
    if not is_sine_or_cosine(node):
        return None
    return rng.choice((apply_function("abs", node), apply_function("sqrt", node**2)))


def add_small_term(node: Node, rng: Stream) -> Node | None:
    return node + make_number(Fraction(1, 10 ** rng.integer(3, 8))) * A1


MUTATIONS: tuple[Rule, ...] = (
    swap_sine_and_cosine, change_sign, drop_operand, change_index, change_number, lose_sign, add_small_term,
)  # fmt: skip


def list_places(node: Node) -> list[tuple[int, ...]]:
    return [(), *((i, *place) for i, arg in enumerate(node.args) for place in list_places(arg))]


def find_subtree(node: Node, place: tuple[int, ...]) -> Node:
    for i in place:
        node = node.args[i]
    return node


def replace_subtree(node: Node, place: tuple[int, ...], subtree: Node) -> Node:
    if not place:
        return subtree
    args = list(node.args)
    args[place[0]] = replace_subtree(args[place[0]], place[1:], subtree)
    return Node(node.kind, tuple(args), node.value)


def apply_rules(node: Node, rules: tuple[Rule, ...], rng: Stream, steps: int) -> Node:
    for _ in range(steps):
        for _ in range(20):
            place = rng.choice(list_places(node))
            is_in_exponent = any(find_subtree(node, place[:k]).kind == "^" and place[k] == 1 for k in range(len(place)))
            new_subtree = None if is_in_exponent else rng.choice(rules)(find_subtree(node, place), rng)
            if new_subtree is not None:
                new_tree = replace_subtree(node, place, new_subtree)
                node = new_tree if len(format_tree(new_tree)) <= 2 * MAX_LENGTH else node
                break
    return node


def is_different(first: Node, second: Node, domain: Domain, rng: Stream) -> bool | None:
    symbols = find_names(first) | find_names(second)
    values = domain.sample(symbols, 200, rng)
    (a, scale_a), (b, scale_b) = (evaluate(compile_program([tree]), values, 200) for tree in (first, second))
    is_finite = np.isfinite(a) & np.isfinite(b) & np.isfinite(scale_a) & np.isfinite(scale_b)
    difference = np.abs(a[is_finite] - b[is_finite]) / np.maximum(scale_a[is_finite] + scale_b[is_finite], 1e-300)
    if not len(difference):
        return None
    if difference.max() > 1e-10:
        return True
    return None if difference.max() > 1e-13 else False


def generate_references(seeds: Iterator[int]) -> Iterator[tuple[str, Node, Domain]]:
    for seed in seeds:
        for family in FAMILIES:
            names = ("jacobian",) if FAMILIES[family].has_varied_structure else QUESTION_NAMES
            questions = tuple(name for name in list_questions_of_family(family) if name in names)
            problem = generate(ProblemId(family, seed, questions))
            domain = problem.domain
            for part in problem.parts:
                entries = part.answer.as_matrix() if isinstance(part.answer, (Expression, Matrix)) else ()
                for index, entry in enumerate(entries):
                    if len(text := format_expression(entry)) <= MAX_LENGTH:
                        yield f"{family}/{seed} {part.name}[{index}]", parse_formula(text, domain.roles), domain


def generate_verdicts(count: int) -> Iterator[tuple[str, str, bool, bool, str]]:
    """Yield an answer's source, how it was made, whether it is right, whether the grader accepts it, and the answer.

    An answer is right if it is the same function as the reference.
    """
    count_so_far = 0
    for source, reference, domain in generate_references(iter(range(10**9))):
        for k in range(6):
            if count_so_far >= count:
                return
            rng = Stream(f"pairs/{source}/{k}")
            is_rewriting = k % 2 == 0
            tree = apply_rules(reference, REWRITINGS, rng, rng.integer(1, 5))
            if not is_rewriting:
                tree = apply_rules(tree, MUTATIONS, rng, 1)
            differs, answer = is_different(tree, reference, domain, rng), format_tree(tree)
            if is_rewriting and differs:
                raise AssertionError(f"a rewriting is no identity: {source}: {answer}")
            if differs is None or (not is_rewriting and not differs):
                continue  # floating-point values can't tell
            count_so_far += 1
            judgement = judge_expression(answer, format_tree(reference), domain, f"pairs/{source}/{k}")
            change = "rewritten" if is_rewriting else "changed"
            yield source, change, not differs, judgement.outcome is Outcome.CORRECT, answer


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000)
    count = parser.parse_args().count
    counts, wrong_count, start = Counter[str](), 0, time.perf_counter()
    for source, change, is_right, is_accepted, answer in generate_verdicts(count):
        description = "right" if is_right else "wrong"
        counts[f"{change} ({description})"] += 1
        if is_accepted != is_right:
            wrong_count += 1
            print(f"{source}: {change}, {description} answer judged otherwise: {answer}", flush=True)
    summary = ", ".join(f"{number} {name}" for name, number in sorted(counts.items()))
    print(f"{summary}: {wrong_count} wrong verdicts in {time.perf_counter() - start:.0f} s")
    return 1 if wrong_count else 0


if __name__ == "__main__":
    sys.exit(main())
