"""Parsing formulas and LaTeX: notation is understood, hostile text is handled quickly, nothing is executed."""

import ast
import contextlib
import json
import math
import re
import time
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from qdot.exercises.formula import names, notation, parser
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.latex import COMMAND_NAMES, UnknownLatex, parse_latex
from qdot.exercises.formula.layout import (
    ACCENTS,
    EMPTY,
    MINUS,
    PLUS,
    SPACES,
    Layout,
    make_digits,
    make_row,
    make_script,
    split_at,
    split_terms,
)
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.parser import MAX_LENGTH, parse_formula
from qdot.exercises.formula.printers.latex import print_latex
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.styles import STYLES
from qdot.exercises.formula.tables import convert_numbers, convert_table
from qdot.exercises.formula.trees import (
    Node,
    ParseError,
    as_matrix,
    count_decimal_digits,
    find_names,
    format_tree,
    has_blank,
)
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.grader.judging.verdict import Outcome
from tests.support import DATA, read_cases
from tests.support.judging import judge_singular
from tests.support.suites import sample_for_suite, select_for_suite

NOTATIONS = read_cases("notations")
VALUES = {
    "theta1": 0.7, "theta2": -1.9, "theta3": 2.3, "a1": 0.31, "a2": 1.7, "a3": 0.83, "d1": 0.4, "x": 1.3, "y": -0.6,
    "c1": 5.0, "phi": 0.2, "qd1": -0.4, "alpha1": 0.9,
}  # fmt: skip


def evaluate_text(text: str, known: tuple[str, ...] = ()) -> complex:
    program = compile_program([parse_formula(text, known)])
    values, _ = evaluate(program, {name: np.array([number]) for name, number in VALUES.items()}, 1)
    return complex(values[0, 0])


@pytest.mark.parametrize(("typed", "meant"), NOTATIONS["equal"])
def test_typed_formula_has_the_intended_value(typed: str, meant: str) -> None:
    assert evaluate_text(typed) == pytest.approx(evaluate_text(meant), abs=1e-12)


def test_symbol_of_the_problem_takes_precedence_over_shorthand() -> None:
    assert evaluate_text("c1") == pytest.approx(math.cos(0.7))
    assert evaluate_text("c1", ("c1", "theta1")) == 5.0
    assert parse_formula("c12", ("theta1",)).kind == "name"


@pytest.mark.parametrize(("text", "kind", "count"), NOTATIONS["containers"])
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


@pytest.mark.parametrize(("text", "message"), NOTATIONS["errors"])
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
    with pytest.raises(ParseError, match=r"the answer has 13 ± signs"):
        parse_formula(f"{sign}a2" * 13)


@pytest.mark.parametrize(("text", "expected"), read_cases("equal")["worked_out"])
def test_matrix_operations_are_computed(text: str, expected: list[list[float]]) -> None:
    rows = as_matrix(parse_formula(text))
    values = [evaluate(compile_program(row), {}, 1).values[:, 0].real.tolist() for row in rows]
    assert [pytest.approx(row) for row in expected] == values


@pytest.mark.parametrize(("text", "message"), NOTATIONS["refused_products"])
def test_invalid_or_ambiguous_product_is_refused(text: str, message: str) -> None:
    with pytest.raises(ParseError) as refused:
        parse_formula(text)
    assert message in str(refused.value)


def test_tables_with_the_expected_shape_are_parsed() -> None:
    for text in ("a\tb\nc\td", "| a   b |\n| c   d |", "a b\nc d", "a, b\nc, d", "a, b,\nc, d", "[a, b\n c, d]",
                 "[a b\n c d]", "J = [a b; c d];", "J =\na b\nc d", "a b; c d"):  # fmt: skip
        assert convert_table(text, (2, 2)) == "[[a, b], [c, d]]", text
    assert convert_table("[a -b; c d]", (2, 2)) == "[[a, -b], [c, d]]"
    assert convert_table("a\n-b", (2, 1)) == "[a, -b]"
    for goes_on in ("a\n+ b", "a\n- b", "a\n* b", "a\nb\nc", "a, b\nc"):
        assert convert_table(goes_on, (2, 1)) is None
    for not_two in ("[a - b; c d]", "[a b c; d e]", "[a b; c d; e f]", "a b\nc d e", "a, , b\nc, d"):
        assert convert_table(not_two, (2, 2)) is None


def test_spaced_comma_separates_entries_with_decimal_commas() -> None:
    assert convert_table("0,5*a , b; 2 , 1,5", (2, 2)) == "[[0.5*a, b], [2, 1.5]]"
    assert convert_table("0,5\t1,5\n2\t3", (2, 2)) == "[[0.5, 1.5], [2, 3]]"
    assert convert_table("[0,5*a, b]", (2, 1)) == "[0.5*a, b]"
    for unclear in ("[1,2 x; 3,4 y]", "[0,5*a,b; 1, 2]"):
        assert convert_table(unclear, (2, 2)) is None


def test_numbers_with_decimal_commas_are_separated() -> None:
    assert convert_numbers("0,5; -1,25", 2) == convert_numbers("(0,5 | -1,25)", 2) == "[0.5, -1.25]"
    assert convert_numbers("[0,5 , -1,25]", 2) == convert_numbers("[0,5 ,-1,25]", 2) == "[0.5, -1.25]"
    assert convert_numbers("0.5 rad/s and -1.25 rad/s", 2) == "[0.5, -1.25]"
    assert {convert_numbers(size, 2) for size in ("3 × 6", "3x6", "3 × 6", "3 by 6")} == {"[3, 6]"}
    for unclear in ("0,5,-1,25", "3 x", "3 x a", "3by6", "0,5, -1,25, 3", "{0.5, -1.25}", "0.5 -1.25"):
        assert convert_numbers(unclear, 2) is None


TABLES = (
    "functions", "constants", "whole_numbers", "before_whole_numbers", "modules", "letters", "spelled_letters",
    "undefined", "blank", "call_meanings", "binding_calls", "whole_number_sets", "units", "superscripts", "signs",
    "look_alikes", "latex",
)  # fmt: skip
GRAMMAR = {
    "pi", "sqrt", "sin", "cos", "rate", "in", "and", "or", "list", "set", "eq", "name", "qd", "begin", "...",
    "Derivative", "theta", "radians", "matrix", "image", "diagonal", "condition", "transposed", "inverse", "±", "…",
}  # fmt: skip
"""Words with a meaning in the grammar itself, kinds of nodes with the same names, and the mark of a shortened text."""


def list_words(table: Any) -> Iterator[str]:
    if isinstance(table, str):
        yield table
    else:
        for word in table:
            yield from list_words(word)
        if isinstance(table, dict):
            yield from list_words(list(table.values()))


def test_parser_modules_contain_no_vocabulary() -> None:
    """The site would not know a synonym that is added in a Python module."""
    listed = {word.strip() for table in TABLES for word in list_words(VOCABULARY[table])}
    listed = {word for word in listed if len(word) > 1 or not word.isascii()}
    for module in (names, notation, parser):
        tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
        constants = [node for node in ast.walk(tree) if isinstance(node, ast.Constant)]
        texts = {node.value for node in constants if isinstance(node.value, str)}
        subscripts = [node for node in ast.walk(tree) if isinstance(node, ast.Subscript)]
        keys = {node.slice.value for node in subscripts if isinstance(node.slice, ast.Constant)}
        assert {text.strip() for text in texts - keys} & listed <= GRAMMAR, module.__name__


def list_patterns() -> list[tuple[str, str]]:
    habits = [(habit["about"], habit["pattern"]) for habit in VOCABULARY["habits"]]
    return [*VOCABULARY["patterns"].items(), *habits]


@pytest.mark.parametrize(("name", "pattern"), list_patterns())
def test_pattern_is_portable_to_browsers(name: str, pattern: str) -> None:
    """The only character class is \\w inside brackets, which the browser expands."""
    assert not re.search(r"(?<!\\)(?:\\\\)*\\[bBdDsSWAZ]|\(\?P|\(\?#|\(\?[a-z]", pattern)
    outside = re.sub(r"(?<!\\)\[(?:[^\]\\]|\\.)*\]", "", pattern)
    assert "\\w" not in outside
    re.compile(pattern)


def test_every_function_is_evaluable() -> None:
    for name in VOCABULARY["functions"]:
        arguments = ", ".join(["0.5"] * VOCABULARY["arity"].get(name, names.ARITY.get(names.FUNCTIONS[name], 1)))
        value = evaluate(compile_program([parse_formula(f"{name}({arguments})")]), {}, 1).values[0, 0]
        assert abs(value) < 10, name


def test_digits_of_all_scripts_are_parsed() -> None:
    for zero in VOCABULARY["zeros"]:
        digits = "".join(chr(ord(zero) + k) for k in range(10))
        assert [unicodedata.decimal(digit) for digit in digits] == list(range(10))
        assert to_plain_text(f"{digits}*a1", {"a1"}) == "0123456789*a1"


@pytest.mark.parametrize("text", ["det(J) = 0", "|J| = 0", "$det J = 0$", r"\det(J) = 0.0", "det(J)=0;"])
def test_vanishing_determinant_is_not_a_joint_value(text: str) -> None:
    """It holds for every arm, and was once read as theta2 = 0."""
    domain = Domain({"theta1": "angle", "theta2": "angle"})
    judged = judge_singular(text, ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"], domain, "s")
    assert judged.outcome is Outcome.WRONG


WRITTEN = [json.loads(line)["latex"] for line in (DATA / "mathml.jsonl").read_text(encoding="utf-8").splitlines()]


def test_latex_is_parsed_to_a_layout() -> None:
    a, index = Layout("letter", "a"), make_row(*make_digits("1"))
    assert parse_latex("a_{1}") == make_row(make_script(a, index))
    assert parse_latex("a_1^{2}") == make_row(make_script(a, index.inner[0], make_row(*make_digits("2"))))
    assert parse_latex("-a") == make_row(MINUS, a) and parse_latex("{}") == make_row(EMPTY)
    assert parse_latex(r"\frac12").inner == (Layout("fraction", "frac", (*make_digits("1"), *make_digits("2"))),)
    assert parse_latex("0{,}5") == make_row(*make_digits("0,5"))


@pytest.mark.parametrize("text", WRITTEN)
def test_printed_latex_parses_to_the_same(text: str) -> None:
    shown = print_latex(parse_latex(text))
    assert print_latex(parse_latex(shown)) == shown


@pytest.mark.parametrize("text", NOTATIONS["latex"])
def test_latex_is_printed_unchanged(text: str) -> None:
    assert print_latex(parse_latex(text)) == text


@pytest.mark.parametrize("text", NOTATIONS["unknown_latex"])
def test_unknown_latex_is_refused_by_name(text: str) -> None:
    with pytest.raises(UnknownLatex, match=r" in ['\"]"):
        parse_latex(text)


@pytest.mark.parametrize(("text", "printed"), [
    (r"a \ne b \ldots", r"a \neq b \dots"), (r"\bigl( \lVert v\rVert \bigr)", r"(\| v \|)"),
    (r"\mathrm{d}t", r"\text{d} t"),
    (r"\mathrm{a_1}", "a_1"), (r"\begin{bmatrix} 1 \\ 2 \\ \end{bmatrix}", r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"),
])  # fmt: skip
def test_other_names_of_a_sign_are_parsed(text: str, printed: str) -> None:
    assert print_latex(parse_latex(text)) == printed


def test_every_symbol_has_a_printed_form() -> None:
    """Each name becomes the same sign when it is printed and parsed again, and screen readers have a word for it."""
    for name in COMMAND_NAMES:
        argument = r"{a}{b}" if name in ("frac", "tfrac", "dfrac", "sqrt", *ACCENTS, *STYLES) else ""
        if name in ("text", "textrm", "operatorname", "left", "right", "begin", "end"):
            continue
        formula = parse_latex(f"\\{name}{argument}")
        assert print_latex(parse_latex(print_latex(formula))) == print_latex(formula)
        assert print_speech(formula).isascii() or name in SPACES, name


def test_terms_are_split_at_signs_outside_brackets() -> None:
    terms = split_terms(parse_latex("-a + b (c - d) - (e + f)^{2} = -g").inner)
    shown = [print_latex(make_row(EMPTY, *term)) for term in terms]
    assert shown == ["{} - a", "{} + b (c - d)", "{} - (e + f)^{2} = -g"]
    parts = split_at(parse_latex("a + (b + c)").inner, PLUS)
    assert [print_latex(make_row(*part)) for part in parts] == ["a", "(b + c)"]
