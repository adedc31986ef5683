"""Certificates kept with an assignment: written with the notebooks; by them `qdot verify DIR` knows what changed."""

import json
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from exercises.answers import Matrix
from exercises.assignment import load_assignment
from exercises.errors import QdotError
from exercises.generation import generate
from exercises.problem import ENGINE, Problem, ProblemId
from exercises.record import digests
from exercises.release import Released, certificate_path, init_assignment, notebook_path, release
from grader import certify as certifying
from grader.certificates import Record
from grader.certify import CERTIFIER, Task, certify_all, record_of
from grader.cli import program

pytestmark = pytest.mark.xdist_group("certificates")  # the folder is made once

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
    init_assignment(folder, "Test", "test", secret="0123456789abcdef")  # with others, two may draw alike
    (folder / "assignment.toml").write_text(PROBLEMS, encoding="utf-8")
    (folder / "Lab arm.toml").write_text(ARM, encoding="utf-8")
    release(load_assignment(folder), CERTIFIER, 1, lambda _: None)
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
        ({"problem": "planar-2r/12"}, "another problem than was handed out"),
        ({"engine": ENGINE + 1, "qdot": "9.1"}, f"made by engine {ENGINE + 1} of qdot 9.1; this version has engine"),
        ({"engine": ENGINE + 1, "news": {}}, "1 failed: 1 of another engine"),
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


def test_nothing_vouches_for_a_student_without_a_certificate(folder: Path) -> None:
    shutil.rmtree(folder / "certificates" / "s001")
    code, output = verified(folder)
    assert code == 1
    assert output.count("test.json is missing: nothing says what was handed out. Restore it from a backup") == 1
    assert "4 problems verified, 2 failed: 2 without a certificate\n" in output


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"{", "EOF while parsing"),
        (b"", "EOF while parsing"),
        (b"[]", "should be an object"),
        (b"[" * 100_000, "recursion limit"),
        (b"\xff\xfe", "not UTF-8"),
        (b'{"assignment": "test", "student": "s001", "edition": "", "notebook": {}, "problems": []}', "problems: "),
        (
            b'{"assignment": "test", "student": "s001", "edition": "", "notebook": {}, "problems": {"p1": {}}}',
            "problems.p1.problem: ",
        ),
        (None, "Is a directory"),
    ],
)
def test_a_certificate_that_can_t_be_read_fails_its_student_only(folder: Path, content: bytes | None, why: str) -> None:
    path = certificate_path(load_assignment(folder), "s001")
    path.unlink()
    path.mkdir() if content is None else path.write_bytes(content)
    edit(certificate_path(load_assignment(folder), "s002"), {"sha256": "0" * 64})
    code, output = verified(folder)
    assert code == 1
    (said,) = [line for line in output.splitlines() if line.startswith("s001: ")]
    assert "test.json can't be read as this student's certificate" in said
    assert why in said
    assert said.index("Restore it from a backup") < said.index("hand its notebook out anew")
    assert "4 problems verified, 3 failed: 1 changed, 2 with a damaged certificate\n" in output


def test_a_certificate_without_the_notebook_s_digests_is_damaged(folder: Path) -> None:
    path = certificate_path(load_assignment(folder), "s001")
    content = json.loads(path.read_text(encoding="utf-8"))
    del content["notebook"]
    path.write_text(json.dumps(content), encoding="utf-8")
    code, output = verified(folder)
    assert code == 1
    assert "(notebook: Field required)" in output


def test_a_student_to_whom_nothing_was_handed_out_yet_is_told_apart(folder: Path) -> None:
    with (folder / "roster.csv").open("a", encoding="utf-8") as roster:
        roster.write("s003,Cy Example,cy@example.org\n")
    code, output = verified(folder)
    assert code == 1
    assert "s003: neither " in output
    assert "If nothing was handed out yet, 'qdot generate' writes both" in output
    assert "6 problems verified, 2 failed: 2 without a certificate\n" in output


def test_another_student_s_certificate_vouches_for_nothing(folder: Path) -> None:
    assignment = load_assignment(folder)
    shutil.copy(certificate_path(assignment, "s002"), certificate_path(assignment, "s001"))
    code, output = verified(folder)
    assert code == 1
    assert "it is that of s002 for 'test'" in output
    assert "4 problems verified, 2 failed: 2 with a damaged certificate\n" in output


def test_all_of_a_folder_are_certified_whatever_their_certificates_are(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(folder / "certificates")
    monkeypatch.setattr(Matrix, "as_typed", lambda answer: "theta1")
    code, output = verified(folder)
    assert code == 1
    assert "the reference itself is judged" in output
    assert "4 problems verified, 4 failed: 4 not passing the checks\n" in output


Cells = list[dict[str, Any]]


def alter(folder: Path, change: Callable[[Cells], None]) -> None:
    path = notebook_path(load_assignment(folder), "s001")
    notebook = json.loads(path.read_text(encoding="utf-8"))
    change(notebook["cells"])
    path.write_text(json.dumps(notebook, indent=2), encoding="utf-8")


def cell(cells: Cells, name: str) -> dict[str, Any]:
    return next(cell for cell in cells if cell["id"] == name)


def reword(name: str) -> Callable[[Cells], None]:
    return lambda cells: cell(cells, name).update(source=cell(cells, name)["source"].replace("the", "teh", 1))


@pytest.mark.parametrize(
    ("change", "said", "failed"),
    [
        (reword("p1-statement"), "p1-statement changed", 1),
        (reword("p2-position-question"), "p2-position-question changed", 1),
        (lambda cells: cell(cells, "setup").update(source="from sympy import *"), "setup changed", 2),
        (lambda cells: cell(cells, "p1-jacobian-question").update(cell_type="raw"), "p1-jacobian-question changed", 1),
        (lambda cells: cell(cells, "p1-jacobian")["metadata"].clear(), "p1-jacobian changed", 1),
        (lambda cells: cells.remove(cell(cells, "p2-determinant")), "p2-determinant gone", 1),
        (lambda cells: cells.append({"cell_type": "raw", "source": ["Not ", "so."]}), "cell 18 added", 2),
        (lambda cells: cells.append(dict(cell(cells, "title"))), "title added", 2),
        (lambda cells: cells.append(cells.pop(3)), "cells in another order", 2),
        (lambda cells: cells.append({"cell_type": "raw", "source": "\ud800"}), "cell 18 added", 2),
        (lambda cells: cells.append([]), "", 0),
    ],
)
def test_a_notebook_that_was_altered_is_noticed(
    folder: Path, change: Callable[[Cells], None], said: str, failed: int
) -> None:
    alter(folder, change)
    code, output = verified(folder)
    assert code == bool(failed)
    assert output.count("s001: ") == bool(failed)
    assert f"4 problems verified, {failed} failed{f': {failed} in an altered notebook' if failed else ''}\n" in output
    if failed:
        assert f"test.ipynb is not as it was handed out, restore it from a backup: {said}\n" in output


def test_answers_and_what_programs_do_to_a_notebook_alter_nothing(folder: Path) -> None:
    def work(cells: Cells) -> None:
        cell(cells, "p2-position")["source"] = ["p2_position = ", "Matrix([a1, 0])"]
        cell(cells, "setup").update(outputs=[{"output_type": "stream", "name": "stdout", "text": "1"}])
        cell(cells, "setup")["execution_count"] = 3
        for each in cells:
            del each["id"]
            each["source"] = "".join(each["source"]).splitlines(keepends=True)
        cells.append({"cell_type": "code", "source": " \n", "metadata": {}, "outputs": []})

    alter(folder, work)
    assert verified(folder)[0] == 0


def test_what_a_later_version_words_differently_was_handed_out_all_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("exercises.notebook.statement", lambda *_: "Another wording.")
    monkeypatch.setattr("exercises.notebook.prompt", lambda *_: "Another question's wording.")
    monkeypatch.setattr("grader.certify.version", lambda _: "9.1")
    assert verified(folder)[0] == 0


def test_the_notebook_of_another_student_or_assignment_is_noticed(folder: Path) -> None:
    assignment = load_assignment(folder)
    path = notebook_path(assignment, "s001")
    path.write_text(path.read_text(encoding="utf-8").replace(assignment.digest, "0" * 16), encoding="utf-8")
    assert "restore it from a backup: metadata changed\n" in verified(folder)[1]
    shutil.copy(notebook_path(assignment, "s002"), path)
    code, output = verified(folder)
    assert code == 1
    assert "metadata changed, title changed" in output
    assert "2 failed: 2 in an altered notebook\n" in output


@pytest.mark.parametrize(
    ("content", "said", "kind"),
    [
        (
            None,
            "test.ipynb is missing, and can't be compared with what was handed out; restore it",
            "without a notebook",
        ),
        (b"{", "test.ipynb can't be read as a notebook (Expecting property name", "in an altered notebook"),
        (b"\xff", "test.ipynb can't be read as a notebook ('utf-8' codec", "in an altered notebook"),
        (b"[]", "test.ipynb can't be read as a notebook (it has no cells)", "in an altered notebook"),
        (b"[" * 100_000, "test.ipynb can't be read as a notebook (", "in an altered notebook"),
    ],
)
def test_a_notebook_that_is_gone_or_broken_fails_its_student_only(
    folder: Path, content: bytes | None, said: str, kind: str
) -> None:
    path = notebook_path(load_assignment(folder), "s001")
    path.unlink() if content is None else path.write_bytes(content)
    code, output = verified(folder)
    assert code == 1
    assert output.count("s001: ") == 1
    assert said in output
    assert f"4 problems verified, 2 failed: 2 {kind}\n" in output


def test_who_left_the_roster_is_verified_all_the_same(folder: Path) -> None:
    path = folder / "roster.csv"
    path.write_text("".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:-1]), encoding="utf-8")
    code, output = verified(folder)
    assert code == 0
    assert "s002 is not on the roster" in output
    assert "4 problems verified, 0 failed\n" in output
    edit(certificate_path(load_assignment(folder), "s002"), {"sha256": "0" * 64})
    assert "4 problems verified, 1 failed: 1 changed\n" in verified(folder)[1]
    shutil.rmtree(folder / "certificates" / "s002")
    assert "4 problems verified, 2 failed: 2 without a certificate\n" in verified(folder)[1]


def test_files_that_are_not_qdot_s_are_told_and_fail_nothing(folder: Path) -> None:
    for name in ("released/.DS_Store", "released/s001/.ipynb_checkpoints/test.ipynb", "released/.old/test.ipynb"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("{", encoding="utf-8")
    assert "not looked at" not in verified(folder)[1]
    (folder / "released" / "s001" / "other.ipynb").write_text("{", encoding="utf-8")
    (folder / "certificates" / "README").write_text("{", encoding="utf-8")
    code, output = verified(folder)
    assert code == 0
    assert "not looked at, neither notebooks nor certificates of this assignment: 2, as " in output
    assert f"{folder / 'released' / 's001' / 'other.ipynb'}" in output


def test_a_problem_that_is_no_longer_in_the_assignment_fails(folder: Path) -> None:
    path = folder / "assignment.toml"
    path.write_text(PROBLEMS.rpartition("[[problem]]")[0], encoding="utf-8")
    code, output = verified(folder)
    assert code == 1
    assert output.count("(position, determinant): it was handed out as p2, and is not in assignment.toml any more") == 2
    assert "4 problems verified, 2 failed: 2 changed\n" in output


def test_a_problem_that_came_into_the_assignment_later_has_no_certificate(folder: Path) -> None:
    path = folder / "assignment.toml"
    path.write_text(PROBLEMS + '[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n', encoding="utf-8")
    code, output = verified(folder)
    assert code == 1
    assert "test.json has no p3, which came into assignment.toml after handing out" in output
    assert "6 problems verified, 2 failed: 2 without a certificate\n" in output


@pytest.mark.parametrize(
    "change", [{"arm": "1"}, {"parts": {"position": "1"}}, {"questions": ["position", "jacobian"]}]
)
def test_a_certificate_that_contradicts_itself_is_damaged(folder: Path, change: dict[str, Any]) -> None:
    edit(certificate_path(load_assignment(folder), "s001"), change)
    code, output = verified(folder)
    assert code == 1
    assert "its certificate contradicts itself: it was altered" in output
    assert "4 problems verified, 1 failed: 1 with a damaged certificate\n" in output


def test_a_problem_that_fails_is_not_handed_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "released")
    monkeypatch.setattr(certifying, "failures_of", lambda *_: ["jacobian: frames: entry (1, 1): 1, expected 2"])
    told: list[Released] = []
    release(load_assignment(folder), CERTIFIER, 1, told.append)
    assert [(one.student, one.outcome) for one in told] == [("s001", "left out"), ("s002", "left out")]
    assert "s001: p1 (lab-arm): none of 10 draws can be asked. The first: jacobian: frames:" in str(told[0].given_up[0])
    assert not (folder / "released").exists()


def test_an_own_robot_that_is_singular_everywhere_is_not_handed_out(folder: Path) -> None:
    shutil.rmtree(folder / "released")
    (folder / "Lab arm.toml").write_text('task = ["wx", "wy"]\n' + ARM, encoding="utf-8")
    (folder / "assignment.toml").write_text(
        PROBLEMS.replace('"jacobian", "determinant", "singular-angles"', '"jacobian"')
    )
    said = r"full rank: J for the task wx, wy has rank 1 of 2, whatever the configuration; name another task$"
    with pytest.raises(QdotError, match=said):
        release(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    assert not (folder / "released").exists()


def test_a_record_is_the_same_each_time() -> None:
    problem = generate(ProblemId("elbow-3r", 4, ("jacobian", "singular-angles")))
    assert record_of(problem) == record_of(generate(problem.id))


def test_digests_leave_points_out() -> None:
    identity = ProblemId("elbow-3r", 4, ("jacobian", "joint-rates"))
    assert digests(generate(identity)) == digests(generate(identity, points=(5, 6)))
    other = digests(generate(ProblemId("elbow-3r", 5, identity.questions)))
    assert digests(generate(identity))["arm"] != other["arm"]


def test_an_unknown_band_fails_loudly() -> None:
    ((_, failures),) = certify_all([Task(ProblemId("planar-2r", 1, band=(4, 4)))], 1)
    assert [failure.said for failure in failures] == [
        "planar-2r/1 (all questions): planar-2r has no arm of difficulty 4; its arms are of difficulty 1"
    ]


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


def test_a_crash_is_a_failure_of_its_problem_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    made = generate

    def crashing(identity: ProblemId, **others: Any) -> Problem:
        if identity.seed == 1:
            raise ZeroDivisionError("by zero")
        return made(identity, **others)

    monkeypatch.setattr("grader.certify.generate", crashing)
    tasks = [Task(ProblemId("planar-2r", seed, ("jacobian",))) for seed in range(3)]
    found = [[failure.said for failure in failures] for _, failures in certify_all(tasks, 1)]
    said = "planar-2r/1 (jacobian): qdot itself failed: ZeroDivisionError: by zero; please report it"
    assert found == [[], [said], []]


def test_an_assignment_with_an_own_robot_goes_to_other_processes(folder: Path) -> None:
    """Its lengths are drawn by what a process can be given: it was a function in a function."""
    assignment = load_assignment(folder)
    again = pickle.loads(pickle.dumps(assignment))
    assert again.problems("ada") == assignment.problems("ada")


IDS = ("planar-2r/7", "planar-2r/7@full", "planar-2r/7@modified-dh", "scara/1@chapter@screws")


@pytest.mark.parametrize("text", IDS)
def test_every_identity_can_be_put_on_record(text: str) -> None:
    own = {"questions": (), "band": None, "engine": 1, "qdot": "0", "difficulty": 0, "sha256": "", "arm": ""}
    record = Record.model_validate({"problem": str(ProblemId.parse(text)), "parts": {}, "checks": (), **own})
    assert record.problem == text
