"""The vocabulary of answers is one file, which Python and browsers read alike."""

import ast
import re
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.formula import names, notation, parser
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import judge_singular

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
        texts = {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        keys = {
            node.slice.value
            for node in ast.walk(tree)
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant)
        }
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


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("１２ a1", "12 a1"), ("٣*a1", "3*a1"), ("a1 ＋ （a2）", "a1+(a2)"), ("1．5", "1.5"), ("a1; ", "a1"),
        ("0.3 m ", "0.3"),
        ("a1\u2062cos\u2061(θ1)", "a1*cos(theta1)"), ("a1\u200b*a2", "a1*a2"), ("theta2 ∈ {0, π}", "theta2 in {0, pi}"),
        ("theta1 = 0 ∨ theta2 = 0", "theta1 = 0 or theta2 = 0"), ("a1\u202f+ a2", "a1+a2"),
    ],
)  # fmt: skip
def test_unicode_variants_are_parsed(typed: str, meant: str) -> None:
    assert parse_formula(typed, {"a1", "a2", "theta1", "theta2"}) == parse_formula(
        meant, {"a1", "a2", "theta1", "theta2"}
    )


@pytest.mark.parametrize("text", ["det(J) = 0", "|J| = 0", "$det J = 0$", r"\det(J) = 0.0", "det(J)=0;"])
def test_vanishing_determinant_is_not_a_joint_value(text: str) -> None:
    """It holds for every arm, and was once read as theta2 = 0."""
    domain = Domain({"theta1": "angle", "theta2": "angle"})
    judged = judge_singular(text, ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"], domain, "s")
    assert judged.outcome is Outcome.WRONG
