"""`make fuzz`: texts that nobody would write, to the reader and to the judgement.

Every text must end soon, in a tree or a ParseError, in a verdict; what was read must print and read again as what it
was; what is plain Python must mean what it does in Python; and no verdict is `correct` unless many digits at random
points agree. `python -m tests.tools.fuzz --seconds 120 --seed x` gives every target (`TARGETS`) that long, prints the
finds, and leaves with code 1 if there are any.
"""

import argparse
import ast
import cmath
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

from qdot.exercises.common.json_form import as_json
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import names, trees
from qdot.exercises.formula import parser as expression
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, parse_pieces
from qdot.exercises.formula.trees import Node, ParseError, as_matrix, node_text
from qdot.grader.judging.answer_parser import assign_values_to_joint, read_conditions, replace_decimal_commas
from qdot.grader.judging.compare_command import compare_line
from qdot.grader.judging.verdict import Judgement, Outcome
from tests.support import DATA
from tests.support.judging import judge_angles, judge_expression, judge_matrix, judge_singular

LONGEST = 10_000
SECONDS, SEARCH, MEGABYTES = 1.0, 5.0, 250
"""Seconds that a text may take to be read, and to be judged as four kinds of answer; MB that it may take."""

ANGLES = dict.fromkeys(("theta1", "theta2", "theta3"), "angle")
DOMAIN = Domain({**ANGLES, "a1": "length", "a2": "length", "d3": "signed", "qd1": "signed", "qd2": "signed"})
KNOWN: tuple[frozenset[str], ...] = (
    frozenset(),
    frozenset(DOMAIN.roles),
    frozenset(("theta1", "theta12", "c1", "q1", "e", "m", "k", "vx", "wz", "alpha1")),
    frozenset(f"{letter}{index}" for letter in ("theta", "a", "d", "qd") for index in range(1, 8)),
)
"""Sets of symbols that a problem may have: none, an arm's, such as are like a shorthand or a unit, and many."""

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
"""What a text is changed by: everything that the reader knows, and what looks like it but is not."""

PLAIN = ("a1", "a2", "d3", "x", "y", "0", "1", "2", "3", "10", "0.5", ".5", "1.", "2e1", "1e-2",
         "+", "-", "*", "/", "**", "(", ")", "-", "**", " ", "-(", ")**", "**-", "(a1+x)")  # fmt: skip
"""The part of Python that needs no explanation."""

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
    """Something that must not be: what, and of which text."""


def seeds() -> list[str]:
    """Return the texts to begin with: the students' of the corpus, and SEEDS."""
    lines = (DATA / "corpus.jsonl").read_text("utf-8").splitlines()
    students = [json.loads(line)["student"] for line in lines if line.strip()]
    return [*SEEDS, *(text for text in students if isinstance(text, str) and len(text) <= LONGEST)]


# --- what is looked at ---


def reading(text: str) -> None:
    """A text is read or refused, whatever the problem's symbols are."""
    for known in KNOWN:
        tree = _tree(text, known)
        if tree is not None:
            _scalar(tree)
    for kind, reference in (("expression", "a1"), ("matrix", "[[a1, 0]]"), ("angles", "{0, pi}")):
        answer = compare_line(json.dumps({"type": kind, "reference": reference, "student": text}), 1)
        json.dumps(answer, allow_nan=False)
        if answer["outcome"] == Outcome.UNGRADED.value:
            raise Find(answer["reason"])


def printing(text: str) -> None:
    """What was read prints as a text that reads as the same; what is plain Python means what Python says."""
    for known in KNOWN[:3]:
        tree = _tree(text, known)
        if tree is None or not _scalar(tree) or not all(map(_is_plain, trees.find_names(tree))):
            continue
        again = _tree(node_text(tree), known)
        if again is None:
            if _depth(tree) < expression.MAX_DEPTH // 2:
                raise Find(f"what it prints as can't be read: {node_text(tree)}")
        elif _apart(tree, again):
            raise Find(f"prints as something else: {node_text(tree)}, known {sorted(known)}")
    _like_python(text)


def _alone(tree: Node) -> Node:
    """Return the entry of a list of one, which stands for that."""
    return _alone(tree.args[0]) if tree.kind == "list" and len(tree.args) == 1 else tree


def judging(text: str) -> None:
    """Every judgement ends in an outcome, and in full marks only where many digits agree."""
    rows = [[parse_formula(entry, DOMAIN.roles) for entry in row] for row in MATRIX]
    due = [[parse_formula(EXPRESSION, DOMAIN.roles)]]
    judged = _judged(lambda: judge_expression(text, EXPRESSION, DOMAIN, text_seed(text)))
    if judged.outcome is Outcome.CORRECT:
        answers = (text, replace_decimal_commas(text))
        if all(_differ([[_alone(_right(parse_formula(answer, DOMAIN.roles)))]], due) for answer in answers):
            raise Find("this expression is not the reference")
    judged = _judged(lambda: judge_matrix(text, MATRIX, DOMAIN, text_seed(text)))
    if judged.outcome is Outcome.CORRECT and _differ(as_matrix(_right(parse_formula(text, DOMAIN.roles))), rows):
        raise Find("this matrix is not the reference")
    judged = _judged(lambda: judge_singular(text, SINGULAR, JOINTS, DOMAIN, text_seed(text)))
    if judged.outcome is Outcome.CORRECT and not _holds_where_due(text):
        raise Find("these are not the singular configurations")
    _judged(lambda: judge_angles(text, "{0, pi}", DOMAIN, text_seed(text)))


TARGETS: dict[str, Callable[[str], None]] = {
    "reading": reading,  # bytes, as libFuzzer changes them
    "writing": reading,  # tokens put in, taken out, repeated
    "printing": printing,
    "judging": judging,
}


def text_seed(text: str) -> str:
    """Return a seed that holds the answer, as the grader's does."""
    return f"fuzz/{text!a}"


def checked(target: str, text: str, slower: float = 1.0) -> None:
    """Look at one text. Raises Find where it takes too long, and whatever else must not be."""
    start = time.process_time()
    before = _memory()
    TARGETS[target](text)
    took, grown = time.process_time() - start, _memory() - before
    if took > slower * (SEARCH if target == "judging" else SECONDS):
        raise Find(f"takes {took:.1f} s")
    if grown > MEGABYTES:
        raise Find(f"takes {grown} MB")


def _memory() -> int:
    """Return the most memory that this process had so far, in MB; 0 where that is not told."""
    try:
        import resource
    except ImportError:
        return 0
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) // (2**20 if sys.platform == "darwin" else 2**10)


def _judged(judgement: Callable[[], Judgement]) -> Judgement:
    found = judgement()
    if found.outcome is Outcome.UNGRADED or not 0 <= found.share <= 1:
        raise Find(f"{found.outcome}, {found.share}")
    if found.certificate is not None:
        json.dumps(as_json(found.certificate), allow_nan=False)
    return found


def _tree(text: str, known: frozenset[str]) -> Node | None:
    try:
        return parse_formula(text, known)
    except ParseError:
        return None


def _is_plain(name: str) -> bool:
    """Tell whether a name is one of which nothing is taken away when it is read: theta__2 is theta_2."""
    return name.isidentifier() and names.normalize_name(name) == name


def _scalar(tree: Node) -> bool:
    try:
        compile_program([tree])
    except ParseError:
        return False
    return True


def _depth(tree: Node) -> int:
    deepest, stack = 0, [(tree, 1)]
    while stack:
        top, depth = stack.pop()
        deepest = max(deepest, depth)
        stack += [(arg, depth + 1) for arg in top.args]
    return deepest


def _right(tree: Node) -> Node:
    return tree.args[1] if tree.kind == "eq" else tree


def _apart(one: Node, other: Node) -> bool:
    """Tell whether two trees have different values at random points, or different symbols."""
    used = trees.find_names(one)
    if used != trees.find_names(other):
        return True
    values = DOMAIN.sample(used, 12, Stream("fuzz/printing"))
    (a, ma), (b, mb) = (evaluate(compile_program([tree]), values, 12) for tree in (one, other))
    with np.errstate(all="ignore"):
        return bool(np.any((np.isfinite(a) != np.isfinite(b)) | (np.abs(a - b) > 1e-9 * (ma + mb))))


# --- what Python says ---

_PYTHON: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
_NAMES = ("a1", "a2", "d3", "x", "y")


def _python(node: ast.AST, at: Mapping[str, complex]) -> complex:
    """Return the value of a part of Python's own tree. Raises KeyError where it is not the part that is meant."""
    if isinstance(node, ast.BinOp):
        return complex(_PYTHON[type(node.op)](_python(node.left, at), _python(node.right, at)))
    if isinstance(node, ast.UnaryOp):
        return complex(_PYTHON[type(node.op)](_python(node.operand, at)))
    if isinstance(node, ast.Name):
        return at[node.id]
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return complex(node.value)
    raise KeyError(type(node).__name__)


def _like_python(text: str) -> None:
    """Raise Find where a text in plain Python means something else here."""
    if len(text) > 400 or not re.fullmatch(r"[-+*/() \w.]+", text, re.ASCII) or re.search(r"\d_|_\d|[jJ]", text):
        return
    tree, known = None, frozenset(_NAMES)
    for seed in range(3):
        drawn = Domain(dict.fromkeys(_NAMES, "length")).sample(set(_NAMES), 1, Stream(f"fuzz/python/{seed}"))
        try:
            due = _python(ast.parse(text.strip(), mode="eval").body, {name: complex(v[0]) for name, v in drawn.items()})
        except (SyntaxError, ValueError, KeyError, OverflowError, ZeroDivisionError, RecursionError, MemoryError):
            return
        tree = _tree(text, known)
        if tree is None:
            if text.count("(") < expression.MAX_DEPTH and text.count("**") < expression.MAX_DEPTH:
                raise Find("Python understands this")
            return
        value, size = (column[0, 0] for column in evaluate(compile_program([tree]), drawn, 1))
        # On the cut of a power, -1 + 0j and -1 - 0j have different roots; Python has its own signs of zero.
        near = (abs(value - other) <= 1e-9 * max(size, abs(due), 1e-200) for other in (due, due.conjugate()))
        if cmath.isfinite(due) and abs(due) < 1e200 and not any(near):
            raise Find(f"in Python this is {due}, and here {value}, {node_text(tree)}")


# --- what many digits say ---


def _precise(tree: Node, at: Mapping[str, Any]) -> Any:
    """Return the value of a tree with many digits, by a walk of its own; nan where it has none."""
    done: list[Any] = []
    stack = [(tree, False)]
    while stack:
        top, ready = stack.pop()
        if not ready:
            stack.append((top, True))
            stack += [(arg, False) for arg in reversed(top.args)]
            continue
        args = [done.pop() for _ in top.args][::-1]
        try:
            done.append(_value(top, args, at))
        except (ZeroDivisionError, ValueError, OverflowError):
            done.append(mpmath.nan)
    return done[0]


_ELSE = mpmath.mpf(0.7390851332151607)
"""The value of a symbol that the problem does not have."""


def _value(node: Node, args: list[Any], at: Mapping[str, Any]) -> Any:
    if node.kind in ("number", "decimal"):
        return mpmath.mpf(node.value.numerator) / node.value.denominator
    if node.kind == "name":
        return {"pi": +mpmath.pi, "E": +mpmath.e, "I": mpmath.mpc(0, 1)}.get(node.value, at.get(node.value, _ELSE))
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


def _configurations(count: int) -> Iterator[dict[str, Any]]:
    values = DOMAIN.sample(set(DOMAIN.roles), count, Stream("fuzz/precise"))
    for k in range(count):
        yield {name: mpmath.mpf(float(column[k])) for name, column in values.items()}


def _differ(found: list[list[Node]], due: list[list[Node]]) -> bool:
    """Tell whether two matrices differ at some of 30 configurations; what is undefined at one tells nothing."""
    if len(found) == 1 and len(found[0]) == len(due) and len(due[0]) == 1:
        found = [[entry] for entry in found[0]]
    if [len(row) for row in found] != [len(row) for row in due]:
        return True
    if not all(_scalar(entry) for row in found for entry in row):
        return True
    pairs = [pair for rows in zip(found, due, strict=True) for pair in zip(*rows, strict=True)]
    with mpmath.workdps(60):
        for at in _configurations(30):
            values = [(_precise(own, at), _precise(right, at)) for own, right in pairs]
            if any(mpmath.isfinite(a) and abs(a - b) > 1e-11 * (1 + abs(b)) for a, b in values):
                return True
    return False


def _holds_where_due(text: str) -> bool:
    """Tell whether the conditions hold where theta2 is 0 or pi, and nowhere at random."""
    tree = read_conditions(text, DOMAIN).tree
    assert tree is not None
    claimed = parse_pieces(assign_values_to_joint(tree, JOINTS), JOINTS)

    def holds(at: Mapping[str, Any]) -> bool:
        return any(all(abs(gap(atom, at)) < 1e-6 for atom in piece) for piece in claimed)

    def gap(atom: Atom, at: Mapping[str, Any]) -> Any:
        value = _precise(atom.expression, at)
        if not mpmath.isfinite(value):
            return mpmath.inf
        if atom.joint is None:
            return value
        off = mpmath.re(value) - at[atom.joint]
        return off - 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))

    with mpmath.workdps(40):
        for at in _configurations(6):
            if holds(at) or not all(holds({**at, "theta2": value}) for value in (mpmath.mpf(0), +mpmath.pi)):
                return False
    return True


# --- texts made and changed ---

_PARTS = re.compile(r"\\?[a-zA-Z]+|\d+|\s+|.", re.DOTALL)


def changed(text: str, rng: Stream, tokens: tuple[str, ...], most: int = LONGEST) -> str:
    """Return a text with a few of its parts put in, taken out, exchanged, repeated or bracketed."""
    parts = _PARTS.findall(text)
    for _ in range(1 + rng.integer_below(4)):
        at = rng.integer_below(len(parts) + 1)
        end = min(len(parts), at + 1 + rng.integer_below(5))
        way = rng.integer_below(8)
        if way <= 1:
            parts.insert(at, rng.choice(tokens))
        elif way == 2:
            del parts[at:end]
        elif way == 3:
            parts[at:end] = [rng.choice(tokens)]
        elif way == 4:
            parts[at:at] = parts[at:end] * (1 + rng.integer_below(3))
        elif way == 5:
            there = rng.integer_below(len(parts) + 1)
            parts[there:there] = parts[at:end]
        elif way == 6:
            parts.insert(end, ")")
            parts.insert(at, "(")
        elif rng.integer_below(20) == 0:  # what takes long shows where there is much of it
            parts[at:at] = parts[at:end] * 2 ** rng.integer_below(12)
    return "".join(parts)[:most]


# --- the program ---


def fuzz(target: str, seconds: float, seed: str) -> int:
    """Run one target on texts made by a stream, print each kind of find once, and return how many kinds there are."""
    rng, texts, kinds = Stream(f"fuzz/{seed}/{target}"), seeds(), set[str]()
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        text = rng.choice(texts)
        for _ in range(1 + rng.integer_below(4)):
            text = changed(text, rng, PLAIN if target == "printing" and rng.integer_below(2) else TOKENS)
        try:
            checked(target, text, slower=4.0)
        except Exception as error:
            if (kind := _kind(error)) not in kinds:
                kinds.add(kind)
                print(f"find: {target}: {type(error).__name__}: {str(error)[:300]}: {text!a}", flush=True)
    return len(kinds)


def _kind(error: Exception) -> str:
    """Return what finds of one cause have in common: where it was raised, or the first words."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    where = "" if trace is None else f"{trace.tb_frame.f_code.co_name}:{trace.tb_lineno}"
    return f"{type(error).__name__} {'' if isinstance(error, RecursionError) else where}"


def main() -> int:
    """Run the targets one after another, and count what they find."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=120, help="how long each target runs")
    parser.add_argument("--seed", default="a", help="another one makes other texts")
    options = parser.parse_args()
    warnings.simplefilter("error")  # nothing of the sort belongs on a grader's screen
    finds = sum(fuzz(target, options.seconds, options.seed) for target in TARGETS)
    print(f"{len(TARGETS)} targets of {options.seconds:g} s each: {finds} finds")
    return 1 if finds else 0


if __name__ == "__main__":
    sys.exit(main())
