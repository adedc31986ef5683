"""Parsing: common notation is understood, hostile text is handled quickly, and nothing is ever executed."""

import contextlib
import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from qdot.exercises.formula.parser import MAX_LENGTH, parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import (
    Node,
    ParseError,
    as_matrix,
    count_decimal_digits,
    find_names,
    format_tree,
    has_blank,
)
from tests.support.suites import sample_for_suite, select_for_suite

VALUES = {
    "theta1": 0.7, "theta2": -1.9, "theta3": 2.3, "a1": 0.31, "a2": 1.7, "a3": 0.83, "d1": 0.4, "x": 1.3, "y": -0.6,
    "c1": 5.0, "phi": 0.2, "qd1": -0.4, "alpha1": 0.9,
}  # fmt: skip


def evaluate_text(text: str, known: tuple[str, ...] = ()) -> complex:
    program = compile_program([parse_formula(text, known)])
    values, _ = evaluate(program, {name: np.array([number]) for name, number in VALUES.items()}, 1)
    return complex(values[0, 0])


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("c12", "cos(theta1 + theta2)"), ("s23", "sin(theta2 + theta3)"), ("C1*S_2", "cos(theta1)*sin(theta2)"),
        ("c123", "cos(theta1 + theta2 + theta3)"), ("θ₁ + θ_2", "theta1 + theta2"),
        ("cos(θ1)·a₁ − a2", "cos(theta1)*a1 - a2"), ("a_1*cos(theta_1)", "a1*cos(theta1)"), ("2a1", "2*a1"),
        ("2 a1 cos(theta1)", "2*a1*cos(theta1)"), ("(a1 + a2)(a1 - a2)", "a1*a1 - a2*a2"), ("a1^2", "a1*a1"),
        ("a1**2", "a1*a1"), ("sin^2(theta1)", "sin(theta1)*sin(theta1)"), ("cos(theta1)^2", "cos(theta1)*cos(theta1)"),
        ("np.cos(theta1)", "cos(theta1)"), ("sympy.sin(theta1)", "sin(theta1)"), ("numpy.arctan2(x, y)", "atan2(x, y)"),
        ("Cos(theta1)", "cos(theta1)"), ("Rational(1, 2)*a1", "a1/2"), ("sqrt(a1)*sqrt(a1)", "a1"), ("π", "pi"),
        ("Abs(-a1)", "a1"), ("a1 # the length", "a1"), ("1e-1*a1", "a1/10"), (".5*a1", "a1/2"), ("a1\n+ a2", "a1 + a2"),
        ("--a1", "a1"), ("a2+-a1", "a2 - a1"), ("a1*-a2", "-(a1*a2)"), ("2**-1", "1/2"), ("-2**2", "0 - 4"),
        ("2^3^2", "512"), ("8/4/2", "1"), ("1 - 2 - 3", "0 - 4"), ("Pow(a1, 3)", "a1*a1*a1"),
        ("exp(I*theta1)", "cos(theta1) + I*sin(theta1)"),
    ],
)  # fmt: skip
def test_typed_formula_has_the_intended_value(typed: str, meant: str) -> None:
    assert evaluate_text(typed) == pytest.approx(evaluate_text(meant), abs=1e-12)


def test_symbol_of_the_problem_takes_precedence_over_shorthand() -> None:
    assert evaluate_text("c1") == pytest.approx(math.cos(0.7))
    assert evaluate_text("c1", ("c1", "theta1")) == 5.0
    assert parse_formula("c12", ("theta1",)).kind == "name"


@pytest.mark.parametrize(
    ("text", "kind", "count"),
    [
        ("[a1, a2]", "list", 2), ("; a1, a2", "list", 2), ("(a1, a2)", "list", 2), ("a1, a2", "list", 2),
        ("{0, pi}", "set", 2), ("FiniteSet(0, pi)", "set", 2), ("Matrix([[1, 2], [3, 4]])", "list", 2),
        ("np.array([[1, 2], [3, 4]])", "list", 2), ("{theta2: [0, pi]}", "dict", 1), ("theta2 = 0", "eq", 2),
        ("Eq(theta2, 0)", "eq", 2), ("theta2 == 0", "eq", 2), ("theta2 in {0, pi}", "in", 2),
        ("theta2 = 0 or theta2 = pi", "or", 2), ("theta2 = 0 and theta3 = 0", "and", 2),
        ("And(Eq(theta2, 0), Eq(theta3, 0))", "and", 2), ("...", "blank", 0),
    ],
)  # fmt: skip
def test_containers_and_conditions_are_parsed(text: str, kind: str, count: int) -> None:
    node = parse_formula(text)
    assert (node.kind, len(node.args)) == (kind, count)


def test_matrix_rows_are_parsed_and_uneven_rows_refused() -> None:
    assert [len(row) for row in as_matrix(parse_formula("[[1, 2, 3], [4, 5, 6]]"))] == [3, 3]
    assert [len(row) for row in as_matrix(parse_formula("[1, 2, 3]"))] == [1, 1, 1]
    assert as_matrix(parse_formula("a1")) == [[Node("name", value="a1")]]
    for wrong in ("[[1, 2], [3]]", "[]", "[[[1], 2], 3]"):
        with pytest.raises(ParseError):
            as_matrix(parse_formula(wrong))


def test_names_and_blanks_are_found() -> None:
    assert find_names(parse_formula("a1*c2 + pi*sin(theta1) + E + I")) == {"a1", "theta1", "theta2"}
    assert has_blank(parse_formula("[a1, ...]"))
    assert not has_blank(parse_formula("[a1, 0]"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the text is empty"), ("   # only a comment", "the text is empty"), ("; ;", "the text is empty"),
        ("sin theta1/2", "expected '\\(' after sin"), ("sin(theta1", "'\\)' is missing at the end"),
        ("a1 +", "is missing at the end"), ("a1 $ a2", "unexpected '\\$' \\(at character 4"),
        ("a1\t\x00 \x1b[2J", r"unexpected '\\x00' \(at character 4, near 'a1 \uFFFD \uFFFD\[2J'"),
        ("atan2(theta1)", "wrong number of arguments of atan2"), ("foo(theta1)", "the function 'foo' is unknown"),
        ("a1)", "unexpected '\\)'"),
        ("nan", r"^your answer is nan \(not a number\); look for 0/0, or for a value that was never computed"),
        ("[1, zoo*vx]", r"contains zoo \(.* division by zero\) at character 5"), ("oo", "infinity"),
        ("None", r"print\(\)"), ("{theta1: 0, theta2}", "every entry of a dict"),
    ],
)  # fmt: skip
def test_parse_error_says_what_is_wrong_and_where(text: str, message: str) -> None:
    with pytest.raises(ParseError, match=message):
        parse_formula(text)


MANY = select_for_suite(5_000, 20_000)
HOSTILE = [
    "(" * 5000 + "a1" + ")" * 5000, "[" * 100_000, "sin(" * 2000 + "a1" + ")" * 2000, "-" * 200_000 + "a1",
    "**".join(["a1"] * 3000), "9**9**9**9", "1/(9**9**9**9)", "a1**9**9**9**9", "exp(exp(exp(exp(exp(9)))))",
    "sinh(sinh(sinh(9999999)))*a1", "sin(10^300)^1000 + sin(exp(exp(10)))", "cos(I*10^300) + tan(I*1e308)",
    "9" * 100_000, "1e99999", "1e-99999", "1e" + "9" * 10_000, "0x" + "f" * 1000, "a1\x00+a2", "a1 + \ud800",
    "a1 \u202e+ a2", "__import__('os').system('touch MARK')", "a.b.c", "a1.__class__.__mro__",
    "f'{a1}' + '%s' % a1 + '{0.__class__}'.format(a1)", "(lambda: a1)()", "(a1 := 2)", "[a1 for a1 in a2]",
    "{{{a1: {a2}}: 0}: 1}", "theta1" * 10_000, ("a1+" * MAX_LENGTH)[: MAX_LENGTH - 2] + "a1",
    " " * (MAX_LENGTH - 1) + "1", "a" * (MAX_LENGTH + 1), "," * 10_000, "=".join(["a1"] * 10_000),
    " or ".join(["theta1 = 0"] * 5_000), "a1!" * 1000, "a1[0][1]", "'a1'", "\\theta_1 \\cdot a_1", "#" * 200_000,
    "\n" * 200_000 + "a1", "a\u0301" * 10_000, "/".join(["1"] * 5 * MANY), "[[a,b],[c,d]]*" * 1000 + "[x;y]",
    "inv(" * 50 + "[a,b;c,d]" + ")" * 50, "[a,b]" * 20_000, "x: " + "0, " * 50_000 + "1",
    "[" + "a;" * 20_000 + "a]*[[" + "a," * 20_000 + "a]]", "[x,y]" + "*a" * 10_000, "1 m " * MANY, "a1." * 30_000,
]  # fmt: skip


@pytest.mark.parametrize("text", sample_for_suite(HOSTILE, 6), ids=lambda text: ascii(text[:16]))
def test_hostile_text_is_handled_quickly(text: str) -> None:
    begun = time.process_time()
    try:
        tree = parse_formula(text)
        program = compile_program([tree])
        evaluate(program, {used: np.full(4, 0.7) for used in find_names(tree)}, 4)
    except ParseError as error:
        assert len(str(error)) < 300, "the message is too long to read"
    assert time.process_time() - begun < 10


@settings(max_examples=select_for_suite(150, 400))
@given(st.text(max_size=60))
def test_any_text_is_parsed_or_refused(text: str) -> None:
    with contextlib.suppress(ParseError):
        parse_formula(text)


PIECES = [
    "theta1", "a1", "c12", "sin", "cos(", "(", ")", "[", "]", "{", "}", ",", ":", "=", "==", "+", "-", "*", "**", "^",
    "/", "2", "0.5", "1e3", " ", "in", "or", "and", "...", "Eq(", "atan2(", "Matrix(", "π", "θ", "₁", "\n", "#", ".",
    ";", "|", "'", "&", "<", "not",
]  # fmt: skip


@settings(max_examples=select_for_suite(150, 400))
@given(st.lists(st.sampled_from(PIECES), max_size=25).map("".join))
def test_any_sequence_of_tokens_is_parsed_or_refused(text: str) -> None:
    try:
        tree = parse_formula(text)
        program = compile_program([tree])
        evaluate(program, {used: np.full(2, 0.7) for used in find_names(tree)}, 2)
    except ParseError:
        pass


numbers = st.integers(1, 9).map(str) | st.sampled_from(["x", "y", "0.5", "a1"])
arithmetic = st.recursive(
    numbers,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", " - ", " + "]), inner).map("".join),
        inner.map(lambda text: f"({text})"),
        inner.map(lambda text: f"-{text}"),
        st.tuples(numbers, st.sampled_from(["**2", "**-1", "**3", "**-x", "**2**2"])).map("".join),
    ),
    max_leaves=8,
)


@settings(max_examples=select_for_suite(150, 300))
@given(arithmetic)
def test_operator_precedence_is_that_of_python(text: str) -> None:
    allowed = {"x": complex(VALUES["x"]), "y": complex(VALUES["y"]), "a1": complex(VALUES["a1"])}
    try:
        expected = complex(eval(text, {"__builtins__": {}}, allowed))
    except (ZeroDivisionError, OverflowError):
        return
    assert evaluate_text(text) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "a1-(a2-a3)+x", "a1/(a2*a3)*x/y", "-(a1+a2)*-x", "(a1^a2)^(x^y)", "(1/2*x)^-2",
        "+".join(f"a1*{k}" for k in range(3000)),
    ],
)  # fmt: skip
def test_printed_tree_parses_to_the_same(text: str) -> None:
    printed = format_tree(parse_formula(format_tree(parse_formula(text))))
    assert printed == format_tree(parse_formula(text))
    assert evaluate_text(printed) == evaluate_text(text)


@pytest.mark.parametrize(("text", "digits"), [("0.0", 0), ("1.50", 2), ("1.25e-400", 3), ("12.5e399", 3), ("1e3", 1)])
def test_decimal_digits_exclude_leading_and_exponent_digits(text: str, digits: int) -> None:
    assert count_decimal_digits(parse_formula(text)) == digits


@pytest.mark.parametrize("sign", ["±", "+/-", r"\pm "])
def test_at_most_twelve_plus_minus_signs_are_parsed(sign: str) -> None:
    parse_formula(f"{sign}a2" * 12)
    with pytest.raises(ParseError, match=r"the answer has 13 signs ±"):
        parse_formula(f"{sign}a2" * 13)
