"""The vocabulary of answers stands in one file, written so that Python and a browser read it alike."""

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
    "functions", "constants", "whole_numbers", "before_whole_numbers", "modules", "letters", "spelled", "undefined",
    "blank", "containers", "bound", "whole_number_sets", "units", "superscripts", "signs", "look_alikes", "latex",
)  # fmt: skip
GRAMMAR = {
    "pi", "sqrt", "sin", "cos", "rate", "in", "and", "or", "list", "set", "eq", "name", "qd", "begin", "...",
    "Derivative", "theta", "radians", "matrix", "image", "diagonal", "condition", "transposed", "inverse", "±",
}  # fmt: skip
"""Words to which the grammar itself gives a meaning, and kinds of nodes that are called like one."""


def words(table: Any) -> Iterator[str]:
    if isinstance(table, str):
        yield table
    else:
        for word in table:
            yield from words(word)
        if isinstance(table, dict):
            yield from words(list(table.values()))


def test_the_reader_has_no_list_of_its_own() -> None:
    """A synonym that is added in a module would be unknown to the site."""
    listed = {word.strip() for table in TABLES for word in words(VOCABULARY[table])}
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


def patterns() -> list[tuple[str, str]]:
    habits = [(habit["about"], habit["pattern"]) for habit in VOCABULARY["habits"]]
    return [*VOCABULARY["patterns"].items(), *habits]


@pytest.mark.parametrize(("name", "pattern"), patterns())
def test_a_pattern_means_the_same_to_a_browser(name: str, pattern: str) -> None:
    """Of classes only \\w is allowed, inside brackets, where a browser can write out what it stands for."""
    assert not re.search(r"(?<!\\)(?:\\\\)*\\[bBdDsSWAZ]|\(\?P|\(\?#|\(\?[a-z]", pattern)
    outside = re.sub(r"(?<!\\)\[(?:[^\]\\]|\\.)*\]", "", pattern)
    assert "\\w" not in outside
    re.compile(pattern)


def test_every_function_has_a_value() -> None:
    for name in VOCABULARY["functions"]:
        arguments = ", ".join(["0.5"] * VOCABULARY["arity"].get(name, names.ARITY.get(names.FUNCTIONS[name], 1)))
        value = evaluate(compile_program([parse_formula(f"{name}({arguments})")]), {}, 1)[0][0, 0]
        assert abs(value) < 10, name


def test_digits_of_all_scripts_are_digits() -> None:
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
def test_what_a_keyboard_or_a_page_makes_of_it_is_read(typed: str, meant: str) -> None:
    assert parse_formula(typed, {"a1", "a2", "theta1", "theta2"}) == parse_formula(
        meant, {"a1", "a2", "theta1", "theta2"}
    )


@pytest.mark.parametrize("text", ["det(J) = 0", "|J| = 0", "$det J = 0$", r"\det(J) = 0.0", "det(J)=0;"])
def test_a_determinant_that_is_said_to_vanish_is_no_value_of_a_joint(text: str) -> None:
    """It is true of every arm: theta2 = 0 was taken out of it."""
    domain = Domain({"theta1": "angle", "theta2": "angle"})
    judged = judge_singular(text, ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"], domain, "s")
    assert judged.outcome is Outcome.WRONG
