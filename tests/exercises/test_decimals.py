"""What an assignment allows decimals to be off: read, told to the student, and held to."""

from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from exercises.answers import ConditionSet, Matrix, Number
from exercises.assignment import Assignment, load_assignment
from exercises.decimals import read_decimals
from exercises.errors import QdotError
from exercises.formula.identity import Rounding
from exercises.generation import generate
from exercises.problem import Part, Problem, ProblemId
from exercises.release import init_assignment
from exercises.writing.statement import prompt
from grader.parts import judge
from grader.verdict import Outcome

THREE = Rounding(0.005, 0.0, "to three significant digits")
NAMES = ("position", "jacobian", "joint-rates", "singular-angles")


def problem(rounding: Rounding | None, *names: str) -> Problem:
    made = generate(ProblemId("planar-2r", 3, names))
    return replace(made, parts=tuple(replace(part, rounding=rounding) for part in made.parts))


def right(asked: Problem, answer: object) -> bool:
    return judge(asked, asked.parts[0], str(answer), "seed").outcome is Outcome.CORRECT


def rounded(part: Part, digits: int) -> str:
    assert isinstance(part.answer, Matrix)
    numbers = {atom: sp.Float(atom, digits) for atom in part.answer.reference.atoms(sp.Rational) if atom.q > 1}
    return str(part.answer.reference.evalf(digits).xreplace(numbers).tolist())


def test_formulas_are_exact_unless_the_assignment_says_otherwise() -> None:
    for digits, policy, due in ((3, None, False), (3, THREE, True), (12, None, False), (1, THREE, False)):
        asked = problem(policy, "jacobian")
        assert right(asked, rounded(asked.parts[0], digits)) == due, (digits, policy)


def test_a_wrong_formula_stays_wrong_with_rounding() -> None:
    asked = problem(THREE, "jacobian")
    answer = asked.parts[0].answer
    assert isinstance(answer, Matrix)
    assert not right(asked, (answer.reference * sp.Rational(102, 100)).tolist())
    assert not right(asked, answer.reference.xreplace({sp.Symbol("theta2"): sp.Symbol("theta1")}).tolist())


def test_values_of_joints_may_be_rounded_where_that_is_allowed() -> None:
    exact, loose = (problem(policy, "singular-angles") for policy in (None, THREE))
    answer = exact.parts[0].answer
    assert isinstance(answer, ConditionSet)
    values = [float(value) for part in answer.components for value in dict(part.solutions or ())[sp.Symbol("theta2")]]
    for digits, due in ((2, True), (0, False)):
        claimed = f"{{theta2: {[round(value, digits) for value in values]}}}"
        assert right(loose, claimed) == due
        assert not right(exact, claimed)


def test_a_tolerance_replaces_that_of_numbers() -> None:
    asked = problem(Rounding(0.0, 0.01, "within 0.01 rad/s"), "joint-rates")
    answer = asked.parts[0].answer
    assert isinstance(answer, Number)
    due = [float(value) for value in answer.reference]
    assert right(asked, [value + 0.009 for value in due])
    assert not right(asked, [value + 0.011 for value in due])
    fine = problem(Rounding(5e-6, 0.0, "to six significant digits"), "joint-rates")
    assert right(fine, due)
    assert not right(fine, [value * 1.001 for value in due])


def test_the_student_is_told() -> None:
    within = Rounding(0.0, 0.01, "within 0.01 rad/s")
    for policy, name, said in (
        (THREE, "jacobian", "three significant digits"), (None, "jacobian", ""), (within, "joint-rates", "within 0.01"),
        (THREE, "joint-rates", "three significant digits"),
    ):  # fmt: skip
        asked = problem(policy, name)
        text = prompt(asked, asked.parts[0])
        assert said in text and ("Decimals are" in text) == (bool(policy) and name == "jacobian"), name


@pytest.mark.parametrize(
    ("policy", "expected"),
    [
        (None, {}),
        ("exact", {}),
        (3, dict.fromkeys(NAMES, THREE)),
        ({"jacobian": 3}, {"jacobian": THREE}),
        (
            {"joint-rates": "1 deg/s", "jacobian": "exact"},
            {"joint-rates": Rounding(0.0, 0.017453292519943295, "within 1 deg/s")},
        ),
        ("2mm", dict.fromkeys(NAMES, Rounding(0.0, 0.002, "within 2 mm"))),
    ],
)
def test_policies(policy: object, expected: dict[str, Rounding]) -> None:
    assert dict(read_decimals(policy, NAMES)) == expected  # type: ignore[arg-type]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path / "hw", "T", "t", [], "a secret that is long enough")
    (tmp_path / "hw" / "roster.csv").write_text("student\nann\n")
    return tmp_path / "hw"


def _assigned(folder: Path, line: str) -> Assignment:
    problem = f'[[problem]]\nfamily = "planar-2r"\nquestions = ["jacobian"]\n{line}\n'
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "t"\n{problem}')
    return load_assignment(folder)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("decimals = 1", "from 2 to 12"), ("decimals = true", "from 2 to 12"), ("decimals = 2.5", "from 2 to 12"),
        ('decimals = "some"', "unit"), ('decimals = "0 m"', "more than 0"),
        ('decimals = "1 inch"', "'inch'.*known: m, cm"), ("decimals = {jacobi = 3}", "'jacobi'.*jacobian"),
    ],
)  # fmt: skip
def test_a_policy_that_is_none_is_told_by_its_line(folder: Path, line: str, said: str) -> None:
    with pytest.raises(QdotError, match=f"line 6.*{said}"):
        _assigned(folder, line)


def test_notebooks_of_another_policy_are_another_edition(folder: Path) -> None:
    exact, loose = _assigned(folder, ""), _assigned(folder, "decimals = 3")
    assert exact.edition != loose.edition and exact.digest == loose.digest
    assert loose.problems("ann")[0][1].parts[0].rounding == THREE
