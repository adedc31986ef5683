"""Quiz items: numeric questions, their correct values and those of mistakes, and the texts that are accepted."""

import random
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.items import (
    ChoiceForm,
    NumberField,
    NumberForm,
    QuizItem,
    WrongValue,
    _make_field,
    make_items,
)
from qdot.exercises.exports.numeric_part import NumericPart, ask_in_numbers
from qdot.exercises.exports.platform_markup import Picture, format_decimal, format_tolerance
from qdot.exercises.exports.typed_numbers import list_accepted_texts, make_number_pattern
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions.results import comes_from_stages
from qdot.exercises.reference_answers import Number
from qdot.exercises.verify.numeric_model import compute_exponential_jacobian
from tests.support.problems import get_problem
from tests.support.submitting import make_class
from tests.support.suites import select_for_suite

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


def make_request(folder: Path, toml: str = TOML, variants: int = 2) -> ExportRequest:
    assignment = make_class(folder / "hw", [Student("ada")])
    (assignment.folder / "assignment.toml").write_text(toml)
    return ExportRequest(load_assignment(assignment.folder), lambda _: [], variant_count=variants)


@pytest.fixture(scope="module")
def items(tmp_path_factory: pytest.TempPathFactory) -> list[QuizItem]:
    return list(make_items(make_request(tmp_path_factory.mktemp("items"))))


def find_item(items: Sequence[QuizItem], kind: str) -> QuizItem:
    return next(item for item in items if item.key.endswith(f"-{kind}"))


def test_every_part_of_every_variant_is_a_self_contained_item(items: list[QuizItem]) -> None:
    assert len(items) == 2 * (6 + 3 + 1) == len({item.key for item in items})
    for item in items:
        assert isinstance(item.body[0], Picture)
        for text in (*item.body, *(item.single_number_item.body if item.single_number_item else ())):
            if isinstance(text, Picture):
                assert text.alt and text.svg.startswith("<svg")
            else:  # no remarks on typing formulas or letters
                assert not [word for word in ("`", "typed", "**A.**", r"\text{A.}") if word in text]
        assert item.solution[0] and len(item.hints) == 3


def test_formulas_become_numbers_directions_are_scaled_and_sets_become_choices(items: list[QuizItem]) -> None:
    item = find_item(items, "jacobian")
    assert isinstance(item.form, NumberForm)
    assert [len(row) for row in item.form.rows] == [2, 2]
    asked = str(item.body[-1])
    assert "$v_{x}, v_{y}$" in asked and "three significant digits" in asked and r"\theta_{1} = " in asked
    assert item.single_number_item is not None
    assert len(item.single_number_item.form.fields) == 1  # type: ignore[union-attr]
    counts = find_item(items, "jacobian-size").form
    assert isinstance(counts, NumberForm) and [field.tolerance for field in counts.fields] == [0, 0]  # they are exact
    item = find_item(items, "lost-direction")
    assert isinstance(item.form, NumberForm)
    assert [entry for row in item.form.rows for entry in row if isinstance(entry, str)] == ["1"]
    assert abs(item.form.fields[0].value) <= 1
    assert "entry $u_{" in str(item.body[-1])
    assert isinstance(find_item(items, "singular-angles-choice").form, ChoiceForm)


def test_three_digits_are_accepted_and_mistakes_are_not(items: list[QuizItem]) -> None:
    fields = [field for item in items if isinstance(item.form, NumberForm) for field in item.form.fields]
    assert sum(len(field.wrong_values) for field in fields) > 2 * len(fields)
    for field in fields:
        rounded = float(f"{field.value:.2e}")
        assert abs(rounded - field.value) <= float(format_tolerance(field.tolerance))
        near: list[NumberField | WrongValue] = [field, *field.wrong_values]
        for number, item in enumerate(near):
            for later in near[number + 1 :]:
                assert abs(item.value - later.value) > item.tolerance + later.tolerance
        assert all(wrong.feedback and "{" not in wrong.feedback for wrong in field.wrong_values)


def test_ranges_of_wrong_numbers_never_contain_zero_or_the_right_number() -> None:
    """A length in millimetres makes a number a thousand times too small, but a zero is no such number."""
    problem = generate(ProblemId("planar-2r", 3, ("determinant",)))
    part = problem.parts[0]
    numeric_part = ask_in_numbers(problem, part)
    assert numeric_part is not None
    ratios = (1e-6, 1e-3, 0.01, 1.0005, 2.0, 1e15)  # the last is a division by a zero that was rounded
    wrong_answers = tuple((f"times {ratio}", ratio * numeric_part.values) for ratio in ratios)
    field = _make_field(part, replace(numeric_part, wrong_answers=wrong_answers), 0, "d", explains_mistakes=True)
    assert [wrong.feedback for wrong in field.wrong_values] == [f"times {ratio}" for ratio in (1e-6, 1e-3, 0.01, 2.0)]
    for wrong in field.wrong_values:
        assert wrong.tolerance < abs(wrong.value) and abs(wrong.value - field.value) > wrong.tolerance


DETERMINANT = 'title = "T"\nkey = "hw"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\n'


def test_decimals_set_the_tolerance_and_unsupported_parts_are_noted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (item,) = make_items(make_request(tmp_path, f"{DETERMINANT}decimals = 2\n", 1))
    assert isinstance(item.form, NumberForm)
    (field,) = item.form.fields
    assert field.tolerance == pytest.approx(0.05 * abs(field.value))
    assert "two significant digits" in str(item.body[-1])
    monkeypatch.setattr("qdot.exercises.exports.items.ask_in_numbers", lambda problem, part: None)
    notes: list[str] = []
    assert not list(make_items(replace(make_request(tmp_path / "other", DETERMINANT), report=notes.append)))
    assert len(notes) == 1 and notes[0].startswith("p1: determinant ")


def test_inconsistent_numbers_are_not_exported() -> None:
    problem, other_problem = (generate(ProblemId("planar-2r", seed, ("jacobian",))) for seed in (7, 8))
    with pytest.raises(QdotError, match="do not agree"):
        ask_in_numbers(problem, other_problem.parts[0])


def _compute_expected(problem: Problem, numeric: NumericPart) -> np.ndarray:
    assert numeric.given_values is not None
    values, chain = numeric.given_values.values, problem.chain
    arm = NumericChain(chain, {symbol.name: values[symbol.name] for symbol in chain.parameters})
    q = np.array([values[symbol.name] for symbol in chain.q])
    whole = compute_exponential_jacobian(arm, q)
    jacobian = whole[[VELOCITY_NAMES.index(row) for row in chain.task]]
    rates = np.array([values[rate.name] for rate in chain.rates])
    velocity = np.array([values[row] for row in chain.task])
    kinds: dict[str, Callable[[], Any]] = {
        "jacobian": lambda: jacobian,
        "geometric-jacobian": lambda: whole,
        "determinant": lambda: np.linalg.det(jacobian),
        "gram-determinant": lambda: np.linalg.det(jacobian @ jacobian.T),
        "inverse-velocity": lambda: np.linalg.solve(jacobian, velocity),
        "twist": lambda: whole @ rates,
        "joint-torques": lambda: jacobian.T @ np.array([values[name] for name in numeric.part.symbols]),
        "position": lambda: arm.compute_point(q)[["xyz".index(axis) for axis in chain.linear_axes]],
    }
    expected: np.ndarray = np.asarray(kinds[numeric.part.kind]())
    return expected.reshape(numeric.values.shape)


KINDS = (
    "jacobian", "determinant", "inverse-velocity", "joint-torques", "gram-determinant", "geometric-jacobian", "twist",
    "position",
)  # fmt: skip


def test_numbers_agree_with_the_product_of_exponentials(family: str) -> None:
    can = [kind for kind in KINDS if kind in list_questions_of_family(family)]
    first = list(FAMILIES).index(family)
    for kind in can[first % max(len(can), 1) :][:1]:
        problem = generate(ProblemId(family, 3, (kind,)))
        numeric = ask_in_numbers(problem, problem.parts[0])
        assert numeric is not None
        assert np.allclose(numeric.values, _compute_expected(problem, numeric), rtol=1e-8, atol=1e-9)
        assert np.abs(numeric.values).max() > 1e-3


def test_numbers_are_written_without_exponents() -> None:
    assert format_decimal(1e-7) == "0.0000001"
    assert format_decimal(123456.0) == "123456"
    assert "e" not in format_decimal(-2.5e-9)
    assert float(format_tolerance(0.0123451)) >= 0.0123451


@pytest.mark.parametrize("family", select_for_suite(["planar-3r"], ["planar-2r", "elbow-3r", "planar-3r"]))
def test_numeric_answers_are_unchanged_and_mistakes_differ(family: str) -> None:
    problem = get_problem(family, 0)
    parts = [part for part in problem.parts if isinstance(part.answer, Number)]
    assert len(parts) >= 3
    for part in parts:
        numeric = ask_in_numbers(problem, part)
        assert numeric is not None and isinstance(part.answer, Number), part.name
        right = np.array(part.answer.reference.tolist(), dtype=float)
        assert np.array_equal(numeric.values, right), part.name
        assert numeric.wrong_answers or not comes_from_stages(part), part.name
        for sentence, values in numeric.wrong_answers:
            assert values.shape != right.shape or not np.array_equal(values, right), sentence


def test_single_number_distinguishes_most_mistakes(items: list[QuizItem]) -> None:
    alone = [(item.form, item.single_number_item.form) for item in items if item.single_number_item is not None]
    counts_per_item = []
    for whole, single in alone:
        assert isinstance(whole, NumberForm) and isinstance(single, NumberForm)
        (field,) = single.fields
        able = [field for field in whole.fields if round(abs(field.value), 9) not in (0, 1)] or whole.fields
        counts_per_item.append({len(field.wrong_values) for field in able})
        assert len(field.wrong_values) == max(counts_per_item[-1])
    assert any(len(counts) > 1 for counts in counts_per_item)


def sample_value_and_tolerance(rng: random.Random) -> tuple[float, float]:
    value = float(f"{rng.choice([-1, 1]) * rng.uniform(1, 10) * 10 ** rng.randint(-3, 3):.10g}")
    floor = rng.choice([1e-5, 0.001, 0.02, 2])
    return (0.0 if rng.random() < 0.1 else value), float(f"{max(0.005 * abs(value), floor):.4g}")


def is_within(text: str, value: float, tolerance: Fraction) -> bool:
    return abs(Fraction(text) - Fraction(str(value))) <= tolerance


@pytest.mark.parametrize("seed", range(5))
def test_only_numbers_within_the_tolerance_are_accepted(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(100):
        value, tolerance = sample_value_and_tolerance(rng)
        exact_tolerance = Fraction(str(tolerance))
        texts, pattern = list_accepted_texts(value, tolerance), re.compile(make_number_pattern(value, tolerance))
        assert [text for text in texts if not is_within(text, value, exact_tolerance)] == []
        assert pattern.search(texts[0]) and len(texts) <= 40
        for _ in range(40):
            text = f"{value + rng.uniform(-2, 2) * tolerance:.{rng.randint(0, 8)}f}"
            if pattern.search(text):
                assert is_within(text, value, exact_tolerance), (value, tolerance, text)
            else:  # the first and the last of 100 steps may be refused
                assert not is_within(text, value, exact_tolerance * Fraction(97, 100)), (value, tolerance, text)


@pytest.mark.parametrize("text", ["-0.707", "-.707", "-0.71", "-0.7071", "-0.70711", "-0.707107", "-0.70710"])
def test_rounded_and_truncated_values_are_listed(text: str) -> None:
    assert text in list_accepted_texts(-0.70710678118, 0.0036)


@pytest.mark.parametrize("text", [" -0.707 ", "-,7071", "−0.70710678118", "-0.7100", "-0.71"])
def test_patterns_accept_commas_spaces_and_typeset_minus_signs(text: str) -> None:
    assert re.search(make_number_pattern(-0.70710678118, 0.0036), text)


@pytest.mark.parametrize("text", ["0.707", "-0.7", "-0.707 m", "-0.7.07", "", "-", "1-0.707", "-0.707\n1"])
def test_patterns_refuse_other_texts(text: str) -> None:
    assert not re.search(make_number_pattern(-0.70710678118, 0.0036), text)


def test_counts_are_exact() -> None:
    assert list_accepted_texts(3, 0) == ("3", "3.0", "3.00", "3.000", "3.0000", "3.00000")
    pattern = make_number_pattern(3, 0)
    assert all(re.search(pattern, text) for text in ("3", "+3", "3.00"))
    assert not any(re.search(pattern, text) for text in ("3.01", "33", "-3"))


@pytest.mark.parametrize(("value", "tolerance"), [(173.123456789, 5e-7), (-0.123456789, 1e-9), (2.5e-7, 1e-9)])
def test_numbers_that_need_many_digits_are_listed(value: float, tolerance: float) -> None:
    texts = list_accepted_texts(value, tolerance)
    assert texts and all(is_within(text, value, Fraction(str(tolerance))) for text in texts)
