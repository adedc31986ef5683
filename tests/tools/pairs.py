"""`make pairs`: right answers rewritten and wrong answers made, of all families' formulas, and every verdict on them.

A rewriting applies identities at random places of a reference's tree, so that it is the same function. A mutation
changes a random place, and is kept only if it is another function: at some configuration the two values differ by much
more than rounding. `python -m tests.tools.pairs --count 100000` prints the wrong verdicts and leaves with code 1 if
there are any.
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
from qdot.exercises.formula.sympy_text import expression_text
from qdot.exercises.formula.trees import Node, find_names, node_text
from qdot.exercises.generation import generate, questions_of_family
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import judge_expression

ASKED = ("position", "velocity", "jacobian", "determinant", "inverse-jacobian", "inverse-velocity",
         "geometric-jacobian", "gram-determinant", "joint-torques", "link-velocity")  # fmt: skip
LONGEST = 1500
"""Characters of a reference, or of a rewriting, beyond which it is left as it is."""


def number(value: int | Fraction) -> Node:
    """A tree of a number."""
    return Node("neg", (number(-value),)) if value < 0 else Node("number", value=Fraction(value))


PI, TWO, IMAGINARY = Node("name", value="pi"), number(2), Node("name", value="I")


def call(name: str, arg: Node) -> Node:
    """A function of a tree."""
    return Node("call", (arg,), name)


def times(*factors: Node) -> Node:
    """A product of trees."""
    product = factors[0]
    for factor in factors[1:]:
        product = Node("*", (product, factor))
    return product


def plus(one: Node, other: Node, sign: str = "+") -> Node:
    """A sum or difference of trees."""
    return Node(sign, (one, other))


def over(one: Node, other: Node) -> Node:
    """A quotient of trees."""
    return Node("/", (one, other))


Rule = Callable[[Node, Stream], Node | None]


def shifted(node: Node, rng: Stream) -> Node | None:
    """sin(x) as cos(x - pi/2), as -sin(x + pi), or with another whole turn."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    x, way = node.args[0], rng.integer_below(3)
    if way == 0:
        other = "cos" if node.value == "sin" else "sin"
        return call(other, plus(x, over(PI, TWO), "-" if node.value == "sin" else "+"))
    if way == 1:
        return Node("neg", (call(node.value, plus(x, PI, rng.choice("+-"))),))
    return call(node.value, plus(x, times(number(2 * rng.integer(-3, 3)), PI)))


def half_angles(node: Node, rng: Stream) -> Node | None:
    """sin and cos by the tangent of the half angle, or by sines and cosines of it."""
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


def exponentials(node: Node, rng: Stream) -> Node | None:
    """sin and cos by complex exponentials."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    ahead, back = (call("exp", times(IMAGINARY, sign)) for sign in (node.args[0], Node("neg", (node.args[0],))))
    if node.value == "cos":
        return over(plus(ahead, back), TWO)
    return over(plus(ahead, back, "-"), times(TWO, IMAGINARY))


def added_angles(node: Node, rng: Stream) -> Node | None:
    """Sine and cosine of a sum by the addition theorem."""
    if node.kind != "call" or node.value not in ("sin", "cos") or node.args[0].kind not in ("+", "-"):
        return None
    sum_ = node.args[0]
    (sx, cx), (sy, cy) = ((call("sin", x), call("cos", x)) for x in sum_.args)
    if node.value == "sin":
        return plus(times(sx, cy), times(cx, sy), sum_.kind)
    return plus(times(cx, cy), times(sx, sy), "-" if sum_.kind == "+" else "+")


def to_sum(node: Node, rng: Stream) -> Node | None:
    """A product of two sines or cosines as a sum."""
    if node.kind != "*" or any(arg.kind != "call" or arg.value not in ("sin", "cos") for arg in node.args):
        return None
    (f, x), (g, y) = ((arg.value, arg.args[0]) for arg in node.args)
    low, high = plus(x, y, "-"), plus(x, y)
    if f == g:
        return over(plus(call("cos", low), call("cos", high), "+" if f == "cos" else "-"), TWO)
    return over(plus(call("sin", high), call("sin", low), "+" if f == "sin" else "-"), TWO)


def one(node: Node, rng: Stream) -> Node | None:
    """A product with a one in another form."""
    x = call("sin", Node("name", value="theta1")), call("cos", Node("name", value="theta1"))
    ones = (
        plus(Node("^", (x[0], TWO)), Node("^", (x[1], TWO))),
        over(x[1], x[1]),
        Node("decimal", value=Fraction("1.0")),
    )
    return times(node, rng.choice(ones))


def turned(node: Node, rng: Stream) -> Node | None:
    """Operands in the other order."""
    return Node(node.kind, node.args[::-1]) if node.kind in ("+", "*") else None


def spread(node: Node, rng: Stream) -> Node | None:
    """A product of a sum multiplied out."""
    if node.kind != "*" or node.args[1].kind not in ("+", "-"):
        return None
    x, sum_ = node.args
    return plus(times(x, sum_.args[0]), times(x, sum_.args[1]), sum_.kind)


def decimals(node: Node, rng: Stream) -> Node | None:
    """A number as a decimal, where it has few digits."""
    if node.kind != "number" or any(node.value.denominator % p == 0 for p in (3, 7, 11, 13)) or node.value > 10**6:
        return None
    denominator = node.value.denominator
    while denominator % 2 == 0:
        denominator //= 2
    while denominator % 5 == 0:
        denominator //= 5
    return Node("decimal", value=node.value) if denominator == 1 else None


def doubled(node: Node, rng: Stream) -> Node | None:
    """Half of twice, minus minus, and the like."""
    way = rng.integer_below(3)
    if way == 0:
        return over(times(TWO, node), TWO)
    return Node("neg", (Node("neg", (node,)),)) if way == 1 else plus(plus(node, IMAGINARY), IMAGINARY, "-")


REWRITINGS: tuple[Rule, ...] = (
    shifted, half_angles, exponentials, added_angles, to_sum, one, turned, turned, spread, spread, decimals, doubled,
)  # fmt: skip


def exchanged(node: Node, rng: Stream) -> Node | None:
    """Sine for cosine and the reverse."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    return call("cos" if node.value == "sin" else "sin", node.args[0])


def other_sign(node: Node, rng: Stream) -> Node | None:
    """Another sign in a sum."""
    return Node("-" if node.kind == "+" else "+", node.args) if node.kind in ("+", "-") else None


def dropped(node: Node, rng: Stream) -> Node | None:
    """A term or a factor dropped."""
    return rng.choice(node.args) if node.kind in ("+", "-", "*") else None


def other_name(node: Node, rng: Stream) -> Node | None:
    """Another index."""
    if node.kind != "name" or not node.value[-1].isdigit():
        return None
    return Node("name", value=f"{node.value[:-1]}{rng.integer(1, 4)}")


def other_number(node: Node, rng: Stream) -> Node | None:
    """A number that is off by a little, or rounded."""
    if node.kind != "number":
        return None
    return Node(
        "number", value=node.value + rng.choice((Fraction(1), Fraction(1, 100), Fraction(1, 10**9), Fraction(-1, 7)))
    )


def size(node: Node, rng: Stream) -> Node | None:
    """A sine without its sign, by an absolute value or a root."""
    if node.kind != "call" or node.value not in ("sin", "cos"):
        return None
    return call("abs", node) if rng.integer_below(2) else call("sqrt", Node("^", (node, TWO)))


def disturbed(node: Node, rng: Stream) -> Node | None:
    """A term that is all but nothing."""
    return plus(node, times(Node("number", value=Fraction(1, 10 ** rng.integer(3, 8))), Node("name", value="a1")))


MUTATIONS: tuple[Rule, ...] = (exchanged, other_sign, dropped, other_name, other_number, size, disturbed)


def places(node: Node) -> list[tuple[int, ...]]:
    """Every place in a tree, as the numbers of the operands on the way to it."""
    return [(), *((i, *place) for i, arg in enumerate(node.args) for place in places(arg))]


def at(node: Node, place: tuple[int, ...]) -> Node:
    """What stands at a place."""
    for i in place:
        node = node.args[i]
    return node


def put(node: Node, place: tuple[int, ...], new: Node) -> Node:
    """The tree with something else at a place."""
    if not place:
        return new
    args = list(node.args)
    args[place[0]] = put(args[place[0]], place[1:], new)
    return Node(node.kind, tuple(args), node.value)


def changed(node: Node, rules: tuple[Rule, ...], rng: Stream, steps: int) -> Node:
    """A tree with some rules applied at random places."""
    for _ in range(steps):
        for _ in range(20):
            place = rng.choice(places(node))
            inside_a_power = any(at(node, place[:k]).kind == "^" and place[k] == 1 for k in range(len(place)))
            new = None if inside_a_power else rng.choice(rules)(at(node, place), rng)
            if new is not None:
                longer = put(node, place, new)
                node = longer if len(node_text(longer)) <= 2 * LONGEST else node
                break
    return node


def differs(one_: Node, other: Node, domain: Domain, rng: Stream) -> bool | None:
    """Whether two trees clearly differ somewhere; None where that is not clear."""
    used = find_names(one_) | find_names(other)
    values = domain.sample(used, 200, rng)
    (a, ma), (b, mb) = (evaluate(compile_program([tree]), values, 200) for tree in (one_, other))
    good = np.isfinite(a) & np.isfinite(b) & np.isfinite(ma) & np.isfinite(mb)
    off = np.abs(a[good] - b[good]) / np.maximum(ma[good] + mb[good], 1e-300)
    if not len(off):
        return None
    return True if off.max() > 1e-10 else None if off.max() > 1e-13 else False


def references(seeds: Iterator[int]) -> Iterator[tuple[str, Node, Domain]]:
    """The formulas of all families' problems, one after another, with where they are from."""
    for seed in seeds:
        for family in FAMILIES:
            if FAMILIES[family].has_varied_structure:
                asked: tuple[str, ...] = ("jacobian",)
            else:
                asked = tuple(question for question in questions_of_family(family) if question in ASKED)
            problem = generate(ProblemId(family, seed, asked))
            domain = problem.domain
            for part in problem.parts:
                answer = part.answer
                entries = list(answer.reference) if isinstance(answer, Matrix) else []
                entries = [answer.reference] if isinstance(answer, Expression) else entries
                for index, entry in enumerate(entries):
                    if len(text := expression_text(entry)) <= LONGEST:
                        yield f"{family}/{seed} {part.name}[{index}]", parse_formula(text, domain.roles), domain


@dataclass(frozen=True)
class Pair:
    """An answer that was made of a reference: where that is from, how, whether it is right, both texts, the seed."""

    source: str
    kind: str
    due: bool
    answer: str
    reference: str
    domain: Domain
    seed: str


def pairs(count: int) -> Iterator[Pair]:
    """Pairs of a reference and an answer, of which it is known whether they are the same function."""
    made = 0
    for source, reference, domain in references(iter(range(10**9))):
        text = node_text(reference)
        for k in range(6):
            if made >= count:
                return
            rng = Stream(f"pairs/{source}/{k}")
            right = k % 2 == 0
            tree = changed(reference, REWRITINGS, rng, rng.integer(1, 5))
            if not right:
                tree = changed(tree, MUTATIONS, rng, 1)
            other = differs(tree, reference, domain, rng)
            if right and other:
                raise AssertionError(f"a rewriting is no identity: {source}: {node_text(tree)}")
            if other is None or (not right and not other):
                continue  # doubles do not show that it is another function: by 1e-14, or undefined everywhere
            made += 1
            kind, seed = "rewritten" if right else "changed", f"pairs/{source}/{k}"
            yield Pair(source, kind, not other, node_text(tree), text, domain, seed)


def verdicts(count: int) -> Iterator[tuple[str, str, bool, bool, str]]:
    """Pairs with what is due and what the grader says: source, kind, due, verdict, text of the answer."""
    for pair in pairs(count):
        judged = judge_expression(pair.answer, pair.reference, pair.domain, pair.seed)
        yield pair.source, pair.kind, pair.due, judged.outcome is Outcome.CORRECT, pair.answer


def main() -> int:
    """Run the sweep, and print what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100_000)
    count = parser.parse_args().count
    seen: Counter[tuple[str, bool]] = Counter()
    wrong, start = 0, time.perf_counter()
    for done, (source, kind, due, verdict, answer) in enumerate(verdicts(count), 1):
        seen[kind, due] += 1
        if verdict != due:
            wrong += 1
            sys.stdout.write(f"{source}: {kind}, {'right' if due else 'wrong'} answer judged otherwise: {answer}\n")
        if done % 5000 == 0:
            sys.stderr.write(f"{done} of {count} pairs, {wrong} wrong verdicts, {time.perf_counter() - start:.0f} s\n")
    told = ", ".join(f"{n} {kind} ({'right' if due else 'wrong'})" for (kind, due), n in sorted(seen.items()))
    sys.stdout.write(
        f"{sum(seen.values())} pairs in {time.perf_counter() - start:.0f} s: {told}; {wrong} wrong verdicts\n"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
