"""Operations on typed matrices are computed, or refused with a reason; tables and lists are parsed."""

import pytest

from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.tables import convert_numbers, convert_table
from qdot.exercises.formula.trees import ParseError, as_matrix

WORKED_OUT = [
    ("2*[1, 3]", [[2], [6]]), ("[[1, 2], [3, 4]]/2", [[0.5, 1], [1.5, 2]]), ("-[1; 2]", [[-1], [-2]]),
    ("[1, 2] + 2*[3, 4]", [[7], [10]]), ("[1; 2] - [3; 4]", [[-2], [-2]]), ("[[1, 2], [3, 4]] [5; 6]", [[17], [39]]),
    ("1/2 [[1, 2], [3, 4]] * [5, 6]", [[8.5], [19.5]]), ("[[5, 6]]*[[1, 2], [3, 4]]", [[23, 34]]),
    ("[[1, 2], [3, 4]]^-1", [[-2, 1], [1.5, -0.5]]),
    ("inv([2, 0, 0; 0, 4, 0; 0, 0, 1])", [[0.5, 0, 0], [0, 0.25, 0], [0, 0, 1]]),
    ("([[1, 2], [3, 4]] [[1, 0], [0, 2]])^T", [[1, 3], [4, 8]]), ("[1 + 2] 3", [[9]]),
    ("[1, 2][3, 4]", [[1, 2], [3, 4]]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), WORKED_OUT)
def test_matrix_operations_are_computed(text: str, expected: list[list[float]]) -> None:
    rows = as_matrix(parse_formula(text))
    values = [evaluate(compile_program(row), {}, 1).values[:, 0].real.tolist() for row in rows]
    assert [pytest.approx(row) for row in expected] == values


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]*[3, 4]", "there is no product of a 2 × 1 and a 2 × 1"),
        ("[1, 2] + 3", "there is no sum of a 2 × 1 matrix and a number"),
        ("3/[1, 2]", "there is no quotient of a 2 × 1 matrix and a number"),
        ("[[1, 2], [3, 4]]^2", "computes no other power"), ("[[1, 2, 3], [4, 5, 6]]^-1", "computes no other power"),
        ("[a; b; c] = [1, 2]", "there is no equation of a 3 × 1 and a 2 × 1"),
        ("1 + J(q) = 3", "the function 'J' is unknown"),
        ("[1, 2, 3][1, 2]", "two lists of different lengths"), ("[[[1]], 2]*3", "a list that is not a matrix"),
        ("a1[0]", "unexpected '['"), ("a1/a2 a3", "/a2 a3 is ambiguous"),
        ("sin theta1 + theta2", "a function without brackets comes before"),
    ],
)  # fmt: skip
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
