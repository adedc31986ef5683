"""`make fuzz`: try odd texts on the formula parser and the judge.

Every text must quickly give a tree or a ParseError, and a verdict. A tree must print as text that parses to the same
tree, and a verdict may be `correct` only if many digits agree at random points.
`python -m tests.tools.fuzz --seconds 120 --seed x` runs each of the `TARGETS` for 120 seconds, prints the faults that
it finds, and exits with code 1 if there are any.
"""

import argparse
import json
import operator
import re
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import names, trees
from qdot.exercises.formula import parser as expression
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, parse_pieces
from qdot.exercises.formula.trees import Node, ParseError, as_matrix, format_tree
from qdot.grader.judging.answer_parser import assign_values_to_joint, read_conditions, replace_decimal_commas
from qdot.grader.judging.compare_command import compare_line
from qdot.grader.judging.verdict import Judgement, Outcome
from tests.support import DATA
from tests.support.judging import judge_angles, judge_expression, judge_matrix, judge_singular

MAX_LENGTH = 10_000
PARSE_SECONDS, JUDGE_SECONDS, MAX_MEGABYTES = 1.0, 5.0, 250
"""Limits for a text: seconds to parse it, seconds to judge it as four kinds of answer, and memory in MB."""

ANGLES = dict.fromkeys(("theta1", "theta2", "theta3"), "angle")
DOMAIN = Domain({**ANGLES, "a1": "length", "a2": "length", "d3": "signed", "qd1": "signed", "qd2": "signed"})
SYMBOL_SETS: tuple[frozenset[str], ...] = (
    frozenset(),
    frozenset(DOMAIN.roles),
    frozenset(("theta1", "theta12", "c1", "q1", "e", "m", "k", "vx", "wz", "alpha1")),
    frozenset(f"{letter}{index}" for letter in ("theta", "a", "d", "qd") for index in range(1, 8)),
)
"""Sets of symbols that a problem may have: none, those of an arm, names like a shorthand or a unit, and many."""

_WORDS = """
    theta1 theta2 theta3 theta12 θ1 θ₁ θ_2 θ̇1 q̇2 q1 th1 t1 a1 a_1 a_{1} a2 d3 qd1 dq2 qdot1 c1 s1 c12 s123 C_{12}
    c1234 s23 a1c12 costheta1 pi π E e I i j k n m _n x blank ... nan oo None Integers
    sin cos tan cot sec csc asin arccos atan acot atan2 sinh cosh tanh exp log ln sqrt √ abs sign deg2rad np.sin math.pi
    Matrix diag Union ImageSet Lambda FiniteSet Eq Or And Rational Float Pow Tuple Derivative theta1.diff (t)
    \\frac \\dfrac12 \\sqrt \\sqrt[3] \\sin \\cos^2 \\theta_1 \\dot \\dot{\\theta}_1 \\left( \\right) \\cdot \\pi
    \\in \\lor \\begin{bmatrix} \\end{bmatrix} \\begin{array}{cc} \\\\ & \\mathrm{m} \\text \\{ \\} $ $$ \\( \\)
    + - * / ** ^ ( ) [ ] { } , : = == ; . & | % => ⇒ # ' ° ½ ² ⁻¹ · × − ÷ … ₁ ′
    0 1 2 3 12 180 0.5 .5 1. 1,5 1e3 1e-400 9e399 0.1000000000000000055511151231257827 3.14159265358979 9^9^9 1000 007
    rad deg cm mm m/s N*m in and or ∈
    ٣ １ 𝟙 ५ Ａ１ ⅕ ㎧ ﷺ ª İ
"""
_MARKS = (
    " ", "\n", "\t", "\u0307", "\u0301", "\u200b", "\u00a0", "\x00", "\udc80", "\udcff", "\ufeff", " and ", " or ",
)  # fmt: skip
TOKENS = (*_WORDS.split(), *_MARKS)
"""Tokens for changing a text: everything that the parser knows, and lookalikes."""

EXPRESSION = "a1*cos(theta1) + a2*cos(theta1 + theta2)"
MATRIX = (("-a2*sin(theta1 + theta2)", "0"), ("qd1/a1", "sqrt(a1^2 + a2^2)"))
SINGULAR = ("theta2 = 0", "theta2 = pi")
JOINTS = ("theta1", "theta2", "theta3")

SEEDS = (
    "-2**2", "2**-1*a1--x", "a1**2**3/(x-y)**2", "-(x+1)**-3*2/a1", "+-+2e1*.5",
    "Matrix([[-a2*s12, 0], [qd1/a1, sqrt(a1**2 + a2**2)]])", "[-a2*sin(theta1+theta2), 0; qd1/a1, sqrt(a1²+a2²)]",
    r"\begin{bmatrix} -a_2 s_{12} & 0 \\ \frac{\dot{q}_1}{a_1} & \sqrt{a_1^2+a_2^2} \end{bmatrix}",
    "theta2 = k*pi", "{theta2: [0, pi]}", "sin(theta2) = 0", "theta2 in {0, pi}", "theta2 = 0 or theta2 = pi", "s2",
    "ImageSet(Lambda(_n, pi*_n), Integers)", "Union(FiniteSet(0), FiniteSet(pi))", "{0, pi}", "theta1.diff(t)*30 cm",
    r"a_1\cos\theta_1 + a_2\cos^{2}\left(\theta_1+\theta_2\right) $", "a1*exp(i*θ₁)", "1,5 a1", "a1 c1 + a2 c12",
)  # fmt: skip


class Find(AssertionError):
    """A text that is handled wrongly, with the reason."""


def load_seed_texts() -> list[str]:
    lines = (DATA / "corpus.jsonl").read_text("utf-8").splitlines()
    students = [json.loads(line)["student"] for line in lines if line.strip()]
    return [*SEEDS, *(text for text in students if isinstance(text, str) and len(text) <= MAX_LENGTH)]


# --- targets ---


def check_parsing(text: str) -> None:
    for symbols in SYMBOL_SETS:
        tree = _parse(text, symbols)
        if tree is not None:
            _is_scalar(tree)
    for answer_type, reference in (("expression", "a1"), ("matrix", "[[a1, 0]]"), ("angles", "{0, pi}")):
        answer = compare_line(json.dumps({"type": answer_type, "reference": reference, "student": text}), 1)
        json.dumps(answer, allow_nan=False)
        if answer["outcome"] == Outcome.UNGRADED.value:
            raise Find(answer["reason"])


def check_printing(text: str) -> None:
    for symbols in SYMBOL_SETS[:3]:
        tree = _parse(text, symbols)
        if tree is None or not _is_scalar(tree) or not all(map(_is_normal, trees.find_names(tree))):
            continue
        reparsed_tree = _parse(format_tree(tree), symbols)
        if reparsed_tree is None:
            if _measure_depth(tree) < expression.MAX_DEPTH // 2:
                raise Find(f"its printed text can't be parsed: {format_tree(tree)}")
        elif _have_different_values(tree, reparsed_tree):
            raise Find(f"prints as something else: {format_tree(tree)}, with the symbols {sorted(symbols)}")


def _unwrap_single(tree: Node) -> Node:
    """Return the entry of a list with one entry, because such a list means the entry itself."""
    return _unwrap_single(tree.args[0]) if tree.kind == "list" and len(tree.args) == 1 else tree


def check_judging(text: str) -> None:
    """Check that every judgement has an outcome, and gives full marks only if many digits agree."""
    rows = [[parse_formula(entry, DOMAIN.roles) for entry in row] for row in MATRIX]
    expected = [[parse_formula(EXPRESSION, DOMAIN.roles)]]
    judgement = _judge(lambda: judge_expression(text, EXPRESSION, DOMAIN, make_seed(text)))
    if judgement.outcome is Outcome.CORRECT:
        answers = (text, replace_decimal_commas(text))
        if all(_differ([[_unwrap_single(_parse_right_side(answer))]], expected) for answer in answers):
            raise Find("this expression is not the reference")
    judgement = _judge(lambda: judge_matrix(text, MATRIX, DOMAIN, make_seed(text)))
    if judgement.outcome is Outcome.CORRECT and _differ(as_matrix(_parse_right_side(text)), rows):
        raise Find("this matrix is not the reference")
    judgement = _judge(lambda: judge_singular(text, SINGULAR, JOINTS, DOMAIN, make_seed(text)))
    if judgement.outcome is Outcome.CORRECT and not _describes_singular_set(text):
        raise Find("these are not the singular configurations")
    _judge(lambda: judge_angles(text, "{0, pi}", DOMAIN, make_seed(text)))


TARGETS: dict[str, Callable[[str], None]] = {
    "reading": check_parsing,  # bytes changed, as by libFuzzer
    "writing": check_parsing,  # tokens inserted, removed, repeated
    "printing": check_printing,
    "judging": check_judging,
}


def make_seed(text: str) -> str:
    """Return a seed that depends on the answer, as the grader's does."""
    return f"fuzz/{text!a}"


def check_text(target: str, text: str, slack: float = 1.0) -> None:
    start = time.process_time()
    memory_before = _measure_memory()
    TARGETS[target](text)
    elapsed, growth = time.process_time() - start, _measure_memory() - memory_before
    if elapsed > slack * (JUDGE_SECONDS if target == "judging" else PARSE_SECONDS):
        raise Find(f"takes {elapsed:.1f} s")
    if growth > MAX_MEGABYTES:
        raise Find(f"takes {growth} MB")


def _measure_memory() -> int:
    try:
        import resource
    except ImportError:
        return 0
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) // (2**20 if sys.platform == "darwin" else 2**10)


def _judge(judgement: Callable[[], Judgement]) -> Judgement:
    result = judgement()
    if result.outcome is Outcome.UNGRADED or not 0 <= result.share <= 1:
        raise Find(f"{result.outcome}, {result.share}")
    if result.certificate is not None:
        json.dumps(to_jsonable(result.certificate), allow_nan=False)
    return result


def _parse(text: str, symbols: frozenset[str]) -> Node | None:
    try:
        return parse_formula(text, symbols)
    except ParseError:
        return None


def _is_normal(name: str) -> bool:
    """Return whether parsing keeps a name unchanged; theta__2 becomes theta_2."""
    return name.isidentifier() and names.normalize_name(name) == name


def _is_scalar(tree: Node) -> bool:
    try:
        compile_program([tree])
    except ParseError:
        return False
    return True


def _measure_depth(tree: Node) -> int:
    return trees.fold(tree, lambda _, depths: 1 + max(depths, default=0))


def _parse_right_side(text: str) -> Node:
    """Return the tree of a formula; that of the right side for an equation."""
    tree = parse_formula(text, DOMAIN.roles)
    return tree.args[1] if tree.kind == "eq" else tree


def _have_different_values(first: Node, second: Node) -> bool:
    """Return whether two trees have different symbols, or different values at random points."""
    used_names = trees.find_names(first)
    if used_names != trees.find_names(second):
        return True
    values = DOMAIN.sample(used_names, 12, Stream("fuzz/printing"))
    (a, scale_a), (b, scale_b) = (evaluate(compile_program([tree]), values, 12) for tree in (first, second))
    with np.errstate(all="ignore"):
        return bool(np.any((np.isfinite(a) != np.isfinite(b)) | (np.abs(a - b) > 1e-9 * (scale_a + scale_b))))


# --- evaluation with many digits ---


def _evaluate_precisely(tree: Node, values: Mapping[str, Any]) -> Any:
    """Evaluate a tree independently of qdot, to many digits; return nan if it has no value."""

    def combine(node: Node, args: list[Any]) -> Any:
        try:
            return _evaluate_node(node, args, values)
        except (ZeroDivisionError, ValueError, OverflowError):
            return mpmath.nan

    return trees.fold(tree, combine)


_UNKNOWN_VALUE = mpmath.mpf(0.7390851332151607)
"""The value of a symbol that is not in the problem."""


def _evaluate_node(node: Node, args: list[Any], values: Mapping[str, Any]) -> Any:
    if node.kind in ("number", "decimal"):
        return mpmath.mpf(node.value.numerator) / node.value.denominator
    if node.kind == "name":
        constants = {"pi": +mpmath.pi, "E": +mpmath.e, "I": mpmath.mpc(0, 1)}
        return constants.get(node.value, values.get(node.value, _UNKNOWN_VALUE))
    if not all(mpmath.isfinite(arg) and abs(arg) < mpmath.mpf(10) ** 300 for arg in args):
        return mpmath.nan
    if node.kind == "call":
        if node.value == "atan2":
            return mpmath.atan2(mpmath.re(args[0]), mpmath.re(args[1]))
        if node.value in ("exp", "sinh", "cosh", "tanh") and abs(args[0]) > 1000:
            return mpmath.nan
        return mpmath.fabs(args[0]) if node.value == "abs" else getattr(mpmath, str(node.value))(args[0])
    if node.kind == "^":
        return args[0] ** args[1] if abs(args[1]) < 1000 else mpmath.nan
    if node.kind == "neg":
        return -args[0]
    operators: dict[str, Callable[..., Any]] = {
        "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv
    }  # fmt: skip
    return operators[node.kind](*args)


def _sample_configurations(count: int) -> Iterator[dict[str, Any]]:
    values = DOMAIN.sample(set(DOMAIN.roles), count, Stream("fuzz/precise"))
    for k in range(count):
        yield {name: mpmath.mpf(float(column[k])) for name, column in values.items()}


def _differ(answer: list[list[Node]], reference: list[list[Node]]) -> bool:
    """Return whether two matrices differ at any of 30 configurations; undefined values are ignored."""
    if len(answer) == 1 and len(answer[0]) == len(reference) and len(reference[0]) == 1:
        answer = [[entry] for entry in answer[0]]
    if [len(row) for row in answer] != [len(row) for row in reference]:
        return True
    if not all(_is_scalar(entry) for row in answer for entry in row):
        return True
    pairs = [pair for rows in zip(answer, reference, strict=True) for pair in zip(*rows, strict=True)]
    with mpmath.workdps(60):
        for configuration in _sample_configurations(30):
            values = [[_evaluate_precisely(entry, configuration) for entry in pair] for pair in pairs]
            if any(mpmath.isfinite(a) and abs(a - b) > 1e-11 * (1 + abs(b)) for a, b in values):
                return True
    return False


def _describes_singular_set(text: str) -> bool:
    """Return whether the conditions hold if theta2 is 0 or pi, but at no random configuration."""
    tree = read_conditions(text, DOMAIN).tree
    assert tree is not None
    claimed_pieces = parse_pieces(assign_values_to_joint(tree, JOINTS), JOINTS)

    def holds(configuration: Mapping[str, Any]) -> bool:
        return any(all(abs(gap(atom, configuration)) < 1e-6 for atom in piece) for piece in claimed_pieces)

    def gap(atom: Atom, configuration: Mapping[str, Any]) -> Any:
        value = _evaluate_precisely(atom.expression, configuration)
        if not mpmath.isfinite(value):
            return mpmath.inf
        if atom.joint is None:
            return value
        difference = mpmath.re(value) - configuration[atom.joint]
        return difference - 2 * mpmath.pi * mpmath.nint(difference / (2 * mpmath.pi))

    with mpmath.workdps(40):
        for configuration in _sample_configurations(6):
            singular_ones = [{**configuration, "theta2": value} for value in (mpmath.mpf(0), +mpmath.pi)]
            if holds(configuration) or not all(map(holds, singular_ones)):
                return False
    return True


# --- changing texts ---

_TEXT_PARTS = re.compile(r"\\?[a-zA-Z]+|\d+|\s+|.", re.DOTALL)


def mutate(text: str, rng: Stream, tokens: tuple[str, ...], max_length: int = MAX_LENGTH) -> str:
    """Return a text with a few parts inserted, removed, exchanged, repeated or bracketed."""
    parts = _TEXT_PARTS.findall(text)
    for _ in range(1 + rng.integer_below(4)):
        start = rng.integer_below(len(parts) + 1)
        end = min(len(parts), start + 1 + rng.integer_below(5))
        change_number = rng.integer_below(8)
        if change_number <= 1:
            parts.insert(start, rng.choice(tokens))
        elif change_number == 2:
            del parts[start:end]
        elif change_number == 3:
            parts[start:end] = [rng.choice(tokens)]
        elif change_number == 4:
            parts[start:start] = parts[start:end] * (1 + rng.integer_below(3))
        elif change_number == 5:
            position = rng.integer_below(len(parts) + 1)
            parts[position:position] = parts[start:end]
        elif change_number == 6:
            parts.insert(end, ")")
            parts.insert(start, "(")
        elif rng.integer_below(20) == 0:  # repetition reveals slow handling
            parts[start:start] = parts[start:end] * 2 ** rng.integer_below(12)
    return "".join(parts)[:max_length]


# --- the program ---


def fuzz(target: str, seconds: float, seed: str) -> int:
    rng, texts, keys = Stream(f"fuzz/{seed}/{target}"), load_seed_texts(), set[str]()
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        text = rng.choice(texts)
        for _ in range(1 + rng.integer_below(4)):
            text = mutate(text, rng, TOKENS)
        try:
            check_text(target, text, slack=4.0)
        except Exception as error:
            if (key := _classify(error)) not in keys:
                keys.add(key)
                print(f"find: {target}: {type(error).__name__}: {str(error)[:300]}: {text!a}", flush=True)
    return len(keys)


def _classify(error: Exception) -> str:
    """Return a key that is the same for finds with one cause: the exception and where it was raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    where = "" if trace is None else f"{trace.tb_frame.f_code.co_name}:{trace.tb_lineno}"
    return f"{type(error).__name__} {'' if isinstance(error, RecursionError) else where}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=120, help="how long each target runs")
    parser.add_argument("--seed", default="a", help="another seed gives other texts")
    options = parser.parse_args()
    warnings.simplefilter("error")  # graders must see no warnings
    finds = sum(fuzz(target, options.seconds, options.seed) for target in TARGETS)
    print(f"{len(TARGETS)} targets of {options.seconds:g} s each: {finds} finds")
    return 1 if finds else 0


if __name__ == "__main__":
    sys.exit(main())
