"""How many students share an answer, as `qdot generate` tells it."""

from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.statistics.shared_answers import describe_shared_answers
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


def test_answers_that_students_share_are_told(folder: Path) -> None:
    """The chapter's arm has one determinant; rates at a configuration are each student's own, as are full arms."""
    for outcome in ("written", "kept"):
        done = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
        assert f"6 {outcome}" in done.stdout
        first, last = (line for line in done.stderr.splitlines() if "share" in line)
        assert first.startswith("p1 (polar-rp, variation chapter): of 6 ") and first.endswith(": 6 in determinant")
        assert last.startswith("p3 (planar-2r, variation chapter): of 6 ")
        assert last.endswith(": 6 in jacobian, determinant")


def test_a_robot_has_no_other_variation_than_its_lengths(folder: Path) -> None:
    joint = '[[joint]]\nkind = "R"\ntheta = "q{0}"\nd = 0\na = "a{0}"\nalpha = 0\n'
    arm = 'name = "My arm"\n' + joint.format(1) + joint.format(2)
    (folder / "planar-2r.toml").write_text(arm, encoding="utf-8")
    (folder / "drawn.toml").write_text(arm + "[draw]\na1 = [0.3, 0.31]\n", encoding="utf-8")
    asked = '[[problem]]\nrobot = "{}.toml"\nvariation = "{}"\nquestions = ["jacobian"]\n'
    robots = "".join(asked.format(*each) for each in (("planar-2r", "zeros"), ("drawn", "zeros"), ("drawn", "+base")))
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{robots}', encoding="utf-8")
    lines = runner.invoke(app, ["generate", str(folder), "--jobs", "1"]).stderr.splitlines()
    shared = [line for line in lines if "share" in line]
    assert len(shared) == 3 and all(line.endswith(": 6 in jacobian") for line in shared)
    begins = ("p1 (planar-2r, the same arm for all", "p2 (drawn, lengths", "p3 (drawn, variation base)")
    assert all(line.startswith(begin) for line, begin in zip(shared, begins, strict=True))


def test_nothing_is_told_of_few_students_and_of_a_certificate_that_cannot_be_read(folder: Path) -> None:
    (folder / "roster.csv").write_text("student\ns0\ns1\n", encoding="utf-8")
    assignment = load_assignment(folder)
    release_notebooks(assignment, CERTIFIER, 1, lambda released: None)
    assert describe_shared_answers(assignment) == []
    text = (folder / "assignment.toml").read_text(encoding="utf-8")
    (folder / "assignment.toml").write_text(text.replace('"T"', '"Another"'), encoding="utf-8")
    assert (
        describe_shared_answers(load_assignment(folder)) == []
    )  # certificates of notebooks that are no longer handed out
    (folder / "certificates" / "s0" / "hw.json").write_text("{", encoding="utf-8")
    assert describe_shared_answers(assignment) == []
