"""Certificates kept with an assignment: written with the notebooks; by them `qdot verify DIR` knows what changed."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from exercises import ENGINE
from exercises.assignment import load_assignment
from exercises.errors import QdotError
from exercises.generate import generate
from exercises.problem import ProblemId
from exercises.record import digests
from exercises.release import certificate_path, init_assignment, release
from grader import certify as certifying
from grader.certify import Task, certificate_text, certify_all, record_of
from grader.cli import program

ARM = """
name = "lab arm"
[[joint]]
kind = "R"
theta = "theta1"
d = "d1"
a = 0
alpha = "pi/2"
[[joint]]
kind = "R"
theta = "theta2"
d = 0
a = "a2"
alpha = 0
[[joint]]
kind = "R"
theta = "theta3"
d = 0
a = "a3"
alpha = 0
[draw]
a2 = [0.3, 0.8]
a3 = [0.3, 0.8]
"""
PROBLEMS = """
title = "Test"
key = "test"
[[problem]]
robot = "Lab arm.toml"
questions = ["jacobian", "determinant", "singular-angles"]
[[problem]]
family = "planar-2r"
difficulty = [1, 2]
questions = ["position", "determinant"]
"""


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certified") / "hw"
    init_assignment(folder, "Test", "test")
    (folder / "assignment.toml").write_text(PROBLEMS, encoding="utf-8")
    (folder / "Lab arm.toml").write_text(ARM, encoding="utf-8")
    release(load_assignment(folder), certificate_text, 1, lambda _: None)
    return folder


@pytest.fixture
def folder(released: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(released, tmp_path / "hw"))


def verified(folder: Path) -> tuple[int, str]:
    found = CliRunner().invoke(program(), ["verify", str(folder), "--jobs", "1"])
    return found.exit_code, found.output


def edit(path: Path, change: dict[str, Any], slot: str = "p2") -> None:
    content = json.loads(path.read_text(encoding="utf-8"))
    content["problems"][slot].update(change)
    path.write_text(json.dumps(content), encoding="utf-8")


def test_a_certificate_says_what_was_made_by_what_and_what_it_passed(released: Path) -> None:
    assignment = load_assignment(released)
    content = json.loads(certificate_path(assignment, "s001").read_text(encoding="utf-8"))
    own, plain = content["problems"]["p1"], content["problems"]["p2"]
    assert own["problem"].startswith("lab-arm/")
    assert (plain["engine"], plain["band"], plain["questions"]) == (ENGINE, [1, 2], ["position", "determinant"])
    assert 10 <= plain["difficulty"] < 24
    assert "jacobian: product of exponentials" in own["checks"]
    assert "singular-angles: complete" in own["checks"]
    assert set(own["parts"]) == {"jacobian", "determinant", "singular-angles"}
    (_, problem), _ = assignment.problems("s001")
    assert own["sha256"] == digests(problem)["sha256"]


def test_an_untouched_folder_passes(folder: Path) -> None:
    assert verified(folder)[0] == 0


def test_students_draw_different_lengths_of_an_own_robot(released: Path) -> None:
    assignment = load_assignment(released)
    arms = {assignment.problems(student.id)[0][1].chain for student in assignment.roster}
    assert len(arms) == len(assignment.roster)
    assert all(not arm.parameters or {s.name for s in arm.parameters} == {"d1"} for arm in arms)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sha256": "0" * 64, "parts": {"position": "1", "determinant": "2"}}, "position, determinant changed since"),
        ({"sha256": "0" * 64, "arm": "1"}, "the arm changed since"),
        ({"sha256": "0" * 64, "problem": "planar-2r/12"}, "another problem than was handed out"),
        ({"engine": ENGINE + 1}, f"made by engine {ENGINE + 1}"),
    ],
)
def test_what_changed_is_said(folder: Path, change: dict[str, Any], said: str) -> None:
    edit(certificate_path(load_assignment(folder), "s002"), change)
    code, output = verified(folder)
    assert code == 1
    assert "s002: planar-2r/" in output
    assert said in output
    assert "4 problems verified, 1 failed" in output


def test_a_robot_that_was_edited_is_another_arm(folder: Path) -> None:
    path = folder / "Lab arm.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"pi/2"', '"-pi/2"'), encoding="utf-8")
    code, output = verified(folder)
    assert code == 1
    assert output.count("the arm changed") == 2


def test_students_without_a_certificate_are_verified_all_the_same(folder: Path) -> None:
    shutil.rmtree(folder / "certificates" / "s001")
    code, output = verified(folder)
    assert code == 0
    assert "1 of 2 students have no certificate" in output
    assert "4 problems verified" in output


def test_a_broken_certificate_is_said_by_its_file(folder: Path) -> None:
    certificate_path(load_assignment(folder), "s001").write_text("{", encoding="utf-8")
    code, output = verified(folder)
    assert code == 2
    assert "test.json can't be read as a certificate" in output


def test_a_problem_that_fails_is_not_handed_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "released")
    monkeypatch.setattr(certifying, "failures_of", lambda *_: ["jacobian: frames: entry (1, 1): 1, expected 2"])
    with pytest.raises(QdotError, match=r"failed its own certificate and is not handed out: jacobian: frames"):
        release(load_assignment(folder), certificate_text, 1, lambda _: None)
    assert not (folder / "released").exists()


def test_a_record_is_the_same_each_time() -> None:
    problem = generate(ProblemId("elbow-3r", 4, ("jacobian", "singular-angles")))
    assert record_of(problem) == record_of(generate(problem.id))


def test_digests_leave_points_out() -> None:
    identity = ProblemId("elbow-3r", 4, ("jacobian", "joint-rates"))
    assert digests(generate(identity)) == digests(generate(identity, (5, 6)))
    other = digests(generate(ProblemId("elbow-3r", 5, identity.questions)))
    assert digests(generate(identity))["arm"] != other["arm"]


def test_an_unknown_band_fails_loudly() -> None:
    ((_, failures),) = certify_all([Task(ProblemId("planar-2r", 1, band=(4, 4)))], 1)
    assert failures == ["planar-2r has no arm of difficulty 4; its arms are of difficulty 1"]


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('robot = "none.toml"', 'robot = "none.toml": there is no file'),
        ('family = "planar-2r"\nrobot = "Lab arm.toml"', "either family = .* or robot"),
        ("questions = []", "either family = .* or robot"),
        ('family = "planar-2r"\ndifficulty = 4', "difficulty = 4: planar-2r has no arm of difficulty 4; its arms are"),
        ('family = "planar-2r"\ndifficulty = 9', r"difficulty = 9: it is a step from 0 to 4"),
        ('family = "planar-2r"\ndifficulty = [2, 1]', r"difficulty = \[2, 1\]: it is"),
        ('robot = "Lab arm.toml"\nquestions = ["gram-determinant"]', "gram-determinant"),
    ],
)
def test_an_entry_that_can_t_be_made_is_said(folder: Path, entry: str, said: str) -> None:
    text = f'title = "T"\nkey = "t"\n[[problem]]\n{entry}\n'
    (folder / "assignment.toml").write_text(text, encoding="utf-8")
    with pytest.raises(QdotError, match=rf"assignment\.toml: line \d: problem 1: .*{said}"):
        load_assignment(folder)


@pytest.mark.parametrize(
    ("draw", "said"),
    [
        ("a9 = [0.1, 0.2]", r"draw: a9 = \[0.1, 0.2\]: 'a9' is no open length of the table; open are: a2, a3, d1"),
        ("a2 = [0.5, 0.2]", "draw: a2"),
        ("a2 = 0.5", r"draw: a2 = 0.5: a length has a range in metres"),
        ("a2 = [0.501, 0.502]", "whole centimetres"),
    ],
)
def test_a_range_that_is_wrong_is_said(folder: Path, draw: str, said: str) -> None:
    (folder / "Lab arm.toml").write_text(ARM.partition("[draw]")[0] + f"[draw]\n{draw}\n", encoding="utf-8")
    with pytest.raises(QdotError, match=rf"Lab arm\.toml: .*{said}"):
        load_assignment(folder)


def test_a_sweep_over_all_families_has_so_many_problems() -> None:
    found = CliRunner().invoke(program(), ["verify", "--family", "all", "--count", "2", "--jobs", "1"])
    assert found.exit_code == 0
    assert "2 problems verified, 0 failed" in found.output
