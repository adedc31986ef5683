"""The message of `qdot generate` on answers that students share."""

from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.statistics.shared_answers import ADVICE, describe_shared_answers
from tests.support.command import runner

PROBLEM = '\n[[problem]]\nfamily = "{}"\nvariation = "{}"\nquestions = ["{}"]\n'
PROBLEMS = 'title = "T"\nkey = "hw"\n' + "".join(
    PROBLEM.format(family, variation, '", "'.join(questions))
    for family, variation, *questions in (
        ("polar-rp", "chapter", "determinant", "joint-rates"), ("planar-2r", "full", "jacobian"),
        ("planar-2r", "chapter", "jacobian", "determinant"),
    )
)  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path, "T", "hw", [Student(f"s{i}") for i in range(6)], "a secret that is long enough")
    (tmp_path / "assignment.toml").write_text(PROBLEMS, encoding="utf-8")
    return tmp_path


def test_generate_reports_shared_answers(folder: Path) -> None:
    """All chapter arms have the same determinant; joint rates at a configuration and full arms differ."""
    for outcome in ("written", "kept"):
        run = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
        assert f"6 {outcome}" in run.stdout
        first, last = (line for line in run.stderr.splitlines() if "same answer" in line)
        assert first == "p1 (polar-rp, variation chapter), determinant: all 6 students have the same answer"
        assert last == "p3 (planar-2r, variation chapter), jacobian, determinant: all 6 students have the same answer"
        assert ADVICE in run.stderr.splitlines()


def test_an_own_robot_varies_only_in_its_lengths(folder: Path) -> None:
    joint = '[[joint]]\nkind = "R"\ntheta = "q{0}"\nd = 0\na = "a{0}"\nalpha = 0\n'
    arm = 'name = "My arm"\n' + joint.format(1) + joint.format(2)
    (folder / "planar-2r.toml").write_text(arm, encoding="utf-8")
    (folder / "drawn.toml").write_text(arm + "[draw]\na1 = [0.3, 0.31]\n", encoding="utf-8")
    problem_toml = '[[problem]]\nrobot = "{}.toml"\nvariation = "{}"\nquestions = ["jacobian"]\n'
    problems = (("planar-2r", "zeros"), ("drawn", "zeros"), ("drawn", "+base"))
    robots = "".join(problem_toml.format(*problem) for problem in problems)
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{robots}', encoding="utf-8")
    lines = runner.invoke(app, ["generate", str(folder), "--jobs", "1"]).stderr.splitlines()
    shared = [line for line in lines if "same answer" in line]
    assert len(shared) == 3 and all("jacobian: all 6 students have the same answer" in line for line in shared)
    beginnings = ("p1 (planar-2r, the same arm for all", "p2 (drawn, lengths", "p3 (drawn, variation base)")
    assert all(line.startswith(beginning) for line, beginning in zip(shared, beginnings, strict=True))
    assert ADVICE not in lines


def test_answers_in_words_are_not_shared(folder: Path) -> None:
    question = '[question.why]\nprompt = "Why?"\nanswer = "text"\n'
    problem = PROBLEM.format("planar-2r", "chapter", 'jacobian", "why')
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{question}{problem}', encoding="utf-8")
    errors = runner.invoke(app, ["generate", str(folder), "--jobs", "1"]).stderr
    assert "jacobian: all 6 students have the same answer" in errors and "why" not in errors


def test_small_classes_and_unusable_certificates_are_not_reported(folder: Path) -> None:
    (folder / "roster.csv").write_text("student\ns0\ns1\n", encoding="utf-8")
    assignment = load_assignment(folder)
    release_notebooks(assignment, CERTIFIER, 1, lambda released: None)
    assert describe_shared_answers(assignment) == []
    text = (folder / "assignment.toml").read_text(encoding="utf-8")
    (folder / "assignment.toml").write_text(text.replace('"T"', '"Another"'), encoding="utf-8")
    assert describe_shared_answers(load_assignment(folder)) == [], "certificates of former notebooks don't count"
    (folder / "certificates" / "s0" / "hw.json").write_text("{", encoding="utf-8")
    assert describe_shared_answers(assignment) == []
