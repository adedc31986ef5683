"""Quiz items: what is asked in numbers, what is right and what a mistake gives, on any arm."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from exercises.arm.chain import TASK_ROWS
from exercises.arm.kinematics import NumericChain
from exercises.assignment import Student, load_assignment
from exercises.errors import QdotError
from exercises.exports.items import Choose, Field, Item, Numeric, Picture, Wrong, items
from exercises.exports.markup import allowance, decimal
from exercises.exports.numbers import InNumbers, in_numbers
from exercises.exports.outlet import Order
from exercises.families import FAMILIES
from exercises.generation import generate
from exercises.problem import Problem, ProblemId
from exercises.verify.exponentials import exponential_jacobian
from grader.certify import failures_of
from tests.support.handing_in import a_class

TOML = """title = "Arms & <signs>"
key = "hw"
hints = true
[[problem]]
family = "planar-2r"
questions = ["jacobian", "determinant", "jacobian-size", "joint-effect", "lost-direction", "joint-torques"]
[[problem]]
family = "planar-2r"
questions = ["singular-angles", "dependence", "true-or-false"]
[[problem]]
family = "planar-2r"
questions = ["speed"]
"""


def an_order(folder: Path, toml: str = TOML, variants: int = 2) -> Order:
    assignment = a_class(folder / "hw", [Student("ada")])
    (assignment.folder / "assignment.toml").write_text(toml)
    return Order(load_assignment(assignment.folder), failures_of, variants=variants)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> list[Item]:
    return list(items(an_order(tmp_path_factory.mktemp("items"))))


def by_kind(made: Sequence[Item], kind: str) -> Item:
    return next(one for one in made if one.key.endswith(f"-{kind}"))


def test_every_part_of_every_variant_is_an_item_of_its_own_that_stands_alone(made: list[Item]) -> None:
    assert len(made) == 2 * (6 + 3 + 1) == len({one.key for one in made})
    for one in made:
        assert isinstance(one.body[0], Picture)
        for text in (*one.body, *(one.number.body if one.number else ())):
            if isinstance(text, Picture):
                assert text.alt
                assert text.svg.startswith("<svg")
            else:  # nothing of how formulas are typed, nor of letters
                assert "`" not in text
                assert "typed" not in text
                assert "**A.**" not in text
                assert r"\text{A.}" not in text
        assert one.solution[0]
        assert len(one.hints) == 3


def test_a_formula_is_asked_for_in_numbers_at_a_configuration(made: list[Item]) -> None:
    one = by_kind(made, "jacobian")
    assert isinstance(one.form, Numeric)
    assert [len(row) for row in one.form.rows] == [2, 2]
    asked = str(one.body[-1])
    assert "rows in the order $v_{x}, v_{y}$" in asked
    assert "Each number to three significant digits" in asked
    assert r"\theta_{1} = " in asked
    assert one.number is not None
    assert len(one.number.form.fields) == 1  # type: ignore[union-attr]
    assert "one number, that in row" in str(one.number.body[-1])


def test_a_direction_is_scaled_and_a_set_becomes_a_choice(made: list[Item]) -> None:
    one = by_kind(made, "lost-direction")
    assert isinstance(one.form, Numeric)
    assert [entry for row in one.form.rows for entry in row if isinstance(entry, str)] == ["1"]
    assert abs(one.form.fields[0].value) <= 1
    assert "Scale the vector so that its entry $u_{" in str(one.body[-1])
    assert isinstance(by_kind(made, "singular-angles-choice").form, Choose)


def test_three_digits_are_right_and_no_mistake_is(made: list[Item]) -> None:
    fields = [field for one in made if isinstance(one.form, Numeric) for field in one.form.fields]
    assert sum(len(field.wrong) for field in fields) > 2 * len(fields)
    for field in fields:
        rounded = float(f"{field.value:.2e}")
        assert abs(rounded - field.value) <= float(allowance(field.tolerance))
        near: list[Field | Wrong] = [field, *field.wrong]
        for number, one in enumerate(near):
            for other in near[number + 1 :]:
                assert abs(one.value - other.value) > one.tolerance + other.tolerance
        assert all(wrong.title and wrong.advice and "{" not in wrong.advice for wrong in field.wrong)


def test_counts_are_exact(made: list[Item]) -> None:
    form = by_kind(made, "jacobian-size").form
    assert isinstance(form, Numeric)
    assert [field.tolerance for field in form.fields] == [0, 0]


def test_items_are_the_same_every_time(made: list[Item], tmp_path: Path) -> None:
    order = an_order(tmp_path, TOML.split("[[problem]]\n", 2)[0] + "[[problem]]\n" + TOML.split("[[problem]]\n")[1], 1)
    again = list(items(order))
    assert [one.form for one in again] == [one.form for one in made[:6]]


def test_decimals_of_the_assignment_are_the_tolerance(tmp_path: Path) -> None:
    toml = 'title = "T"\nkey = "hw"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\ndecimals = 2\n'
    (one,) = items(an_order(tmp_path, toml, 1))
    assert isinstance(one.form, Numeric)
    (field,) = one.form.fields
    assert field.tolerance == pytest.approx(0.05 * abs(field.value))
    assert "to two significant digits" in str(one.body[-1])


def test_what_cannot_be_asked_is_told_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exercises.exports.items.in_numbers", lambda problem, part: None)
    notes: list[str] = []
    toml = 'title = "T"\nkey = "hw"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\n'
    assert not list(items(replace(an_order(tmp_path, toml), note=notes.append)))
    assert notes == ["p1: determinant can't be asked on a platform that compares no formulas"]


def test_numbers_that_do_not_agree_are_not_exported(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = generate(ProblemId("planar-2r", 7, ("jacobian",)))
    right = generate(ProblemId("planar-2r", 8, ("jacobian",)))
    with pytest.raises(QdotError, match="its numbers do not agree"):
        in_numbers(problem, right.parts[0])


# --- every family, by a route of its own: the product of exponentials ---


def _expected(problem: Problem, found: InNumbers) -> np.ndarray:
    assert found.given is not None
    values, chain = found.given.values, problem.chain
    arm = NumericChain(chain, {symbol.name: values[symbol.name] for symbol in chain.parameters})
    q = np.array([values[symbol.name] for symbol in chain.q])
    whole = exponential_jacobian(arm, q)
    jacobian = whole[[TASK_ROWS.index(row) for row in chain.task]]
    rates = np.array([values[rate.name] for rate in chain.rates])
    velocity = np.array([values[row] for row in chain.task])
    kinds: dict[str, Callable[[], Any]] = {
        "jacobian": lambda: jacobian,
        "geometric-jacobian": lambda: whole,
        "determinant": lambda: np.linalg.det(jacobian),
        "gram-determinant": lambda: np.linalg.det(jacobian @ jacobian.T),
        "inverse-velocity": lambda: np.linalg.solve(jacobian, velocity),
        "twist": lambda: whole @ rates,
        "joint-torques": lambda: jacobian.T @ np.array([values[name] for name in found.part.symbols]),
        "position": lambda: arm.point(q)[["xyz".index(axis) for axis in chain.linear_rows]],
    }
    expected: np.ndarray = np.asarray(kinds[found.part.kind]())
    return expected.reshape(found.values.shape)


KINDS = (
    "jacobian", "determinant", "inverse-velocity", "joint-torques", "gram-determinant", "geometric-jacobian", "twist",
    "position",
)  # fmt: skip


def test_numbers_of_every_family_are_those_of_the_product_of_exponentials(family: str) -> None:
    from exercises.generation import questions_of

    can = [kind for kind in KINDS if kind in questions_of(family)]
    first = list(FAMILIES).index(family)
    for kind in can[first % max(len(can), 1) :][:1]:
        problem = generate(ProblemId(family, 3, (kind,)))
        found = in_numbers(problem, problem.parts[0])
        assert found is not None
        assert np.allclose(found.values, _expected(problem, found), rtol=1e-8, atol=1e-9)
        assert np.abs(found.values).max() > 1e-3


def test_numbers_are_written_as_platforms_read_them() -> None:
    assert decimal(1e-7) == "0.0000001"
    assert decimal(123456.0) == "123456"
    assert "e" not in decimal(-2.5e-9)
    assert float(allowance(0.0123451)) >= 0.0123451
    assert isinstance(Field("x", "x", 1.0, 0.1, "", ()), Field)
