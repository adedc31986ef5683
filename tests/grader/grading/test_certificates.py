"""Certificates kept with an assignment: written with the notebooks; by them `qdot verify DIR` knows what changed."""

import json
import pickle
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import (
    ReleaseResult,
    certificate_path,
    init_assignment,
    notebook_path,
    release_notebooks,
)
from qdot.exercises.common.errors import QdotError
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ENGINE, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.reference_answers import Matrix
from qdot.grader.cli.main import make_program
from qdot.grader.grading import certify as certifying
from qdot.grader.grading.certificates import ProblemRecord
from qdot.grader.grading.certify import CERTIFIER, VerificationTask, make_record, verify_all

JOINTS = [("theta1", '"d1"', "0", '"pi/2"'), ("theta2", "0", '"a2"', "0"), ("theta3", "0", '"a3"', "0")]
ROWS = [f'[[joint]]\nkind = "R"\ntheta = "{q}"\nd = {d}\na = {a}\nalpha = {alpha}\n' for q, d, a, alpha in JOINTS]
ARM = f'name = "lab arm"\n{"".join(ROWS)}[draw]\na2 = [0.3, 0.8]\na3 = [0.3, 0.8]\n'
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
    release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    return folder


@pytest.fixture
def folder(released: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(released, tmp_path / "hw"))


def verified(folder: Path) -> tuple[int, str]:
    """Return how many problems fail, and what is printed."""
    found = CliRunner().invoke(make_program(), ["verify", str(folder), "--jobs", "1"])
    counts = re.search(r"(\d+) problems? verified, (\d+) failed", found.output)
    assert counts, found.output
    assert found.exit_code == (counts[2] != "0")
    return int(counts[2]), found.output


Cells = list[dict[str, Any]]
Change = Callable[[Path], object]


def change_json(path: Path, change: Callable[[Any], object]) -> None:
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content, indent=2), encoding="utf-8")


def certificate(folder: Path, student: str = "s001") -> Path:
    return certificate_path(load_assignment(folder), student)


def notebook(folder: Path, student: str = "s001") -> Path:
    return notebook_path(load_assignment(folder), student)


def edited(change: dict[str, Any], student: str = "s002") -> Change:
    """Change a certificate of a problem."""
    return lambda folder: change_json(certificate(folder, student), lambda made: made["problems"]["p2"].update(change))


def altered(change: Callable[[Cells], object]) -> Change:
    """Change the cells of a notebook."""
    return lambda folder: change_json(notebook(folder), lambda made: change(made["cells"]))


def rewritten(name: str, change: Callable[[str], str]) -> Change:
    """Change the text of a file."""

    def rewrite(folder: Path) -> None:
        path = folder / name
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")

    return rewrite


def damaged(content: bytes | None) -> Change:
    """Put other bytes, or a folder, in the place of a certificate; another one says of a problem what isn't so."""

    def damage(folder: Path) -> None:
        path = certificate(folder)
        path.unlink()
        path.mkdir() if content is None else path.write_bytes(content)
        edited({"sha256": "0" * 64})(folder)

    return damage


def cell(cells: Cells, name: str) -> dict[str, Any]:
    return next(cell for cell in cells if cell["id"] == name)


def reworded(name: str) -> Change:
    return altered(lambda cells: cell(cells, name).update(source=cell(cells, name)["source"].replace("the", "teh", 1)))


def broken(content: bytes | None) -> Change:
    """Put other bytes, or nothing, in the place of a notebook."""

    return lambda folder: notebook(folder).unlink() if content is None else notebook(folder).write_bytes(content)


def of_another_edition(folder: Path) -> None:
    digest = load_assignment(folder).problems_digest
    rewritten(str(notebook(folder).relative_to(folder)), lambda text: text.replace(digest, "0" * 16))(folder)


SHA = {"sha256": "0" * 64}
EMPTY = '{"assignment": "test", "student": "s001", "edition": "", "notebook": {}, "problems": '
LATER = PROBLEMS + '[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'
NOTEBOOK = "test.ipynb"
ALTERED: dict[str, tuple[Change, int, str, str]] = {
    "nothing": (lambda _: None, 0, "", ""),
    "digests of parts": (
        edited({**SHA, "parts": {"position": "1", "determinant": "2"}}), 1, "2", "planar-2r/|position, determinant",
    ),
    "digest of the arm": (edited({**SHA, "arm": "1"}), 1, "2", "planar-2r/|the arm"),
    "another problem": (edited({**SHA, "problem": "planar-2r/12"}), 1, "2", "planar-2r/|was released instead"),
    "another problem, same digest": (edited({"problem": "planar-2r/12"}), 1, "2", "planar-2r/|was released instead"),
    "another engine": (edited({"engine": ENGINE + 1, "qdot": "9.1"}), 1, "2", f"planar-2r/|{ENGINE + 1}|9.1"),
    "another engine with news": (edited({"engine": ENGINE + 1, "news": {}}), 1, "2", "1 of another engine"),
    "a robot": (
        rewritten("Lab arm.toml", lambda text: text.replace('"pi/2"', '"-pi/2"')), 2, "12", "the arm|2 changed",
    ),
    "no certificate": (
        lambda folder: shutil.rmtree(folder / "certificates" / "s001"), 2, "1", "test.json|2 without a certificate",
    ),
    "a certificate cut off": (damaged(b"{"), 3, "12", "test.json|EOF|2 with a damaged certificate|1 changed"),
    "an empty certificate": (damaged(b""), 3, "12", "test.json|EOF|2 with a damaged certificate"),
    "a list for a certificate": (damaged(b"[]"), 3, "12", "object|2 with a damaged certificate"),
    "a deep certificate": (damaged(b"[" * 100_000), 3, "12", "recursion|2 with a damaged certificate"),
    "a certificate in no encoding": (damaged(b"\xff\xfe"), 3, "12", "UTF-8|2 with a damaged certificate"),
    "a list of problems": (damaged(f"{EMPTY}[]}}".encode()), 3, "12", "problems: |2 with a damaged"),
    "a problem without keys": (damaged(f'{EMPTY}{{"p1": {{}}}}}}'.encode()), 3, "12", "problems.p1.problem: "),
    "a folder for a certificate": (damaged(None), 3, "12", "Is a directory|2 with a damaged certificate"),
    "no digests of the notebook": (
        lambda folder: change_json(certificate(folder), lambda made: made.pop("notebook")), 2, "1",
        "notebook: |2 with a damaged certificate",
    ),
    "another student's certificate": (
        lambda folder: shutil.copy(certificate(folder, "s002"), certificate(folder)), 2, "1", "s002|2 with a damaged",
    ),
    "an arm only": (edited({"arm": "1"}, "s001"), 1, "1", "1 with a damaged certificate"),
    "parts only": (edited({"parts": {"position": "1"}}, "s001"), 1, "1", "1 with a damaged certificate"),
    "questions only": (edited({"questions": ["position", "jacobian"]}, "s001"), 1, "1", "1 with a damaged certificate"),
    "a student who is new": (
        rewritten("roster.csv", lambda text: f"{text}s003,Cy Example,cy@example.org\n"), 2, "3",
        "qdot generate|2 without a certificate",
    ),
    "a problem that is gone": (
        rewritten("assignment.toml", lambda text: text.rpartition("[[problem]]")[0]), 2, "12",
        "p2|assignment.toml|2 changed",
    ),
    "a problem that is new": (rewritten("assignment.toml", lambda _: LATER), 2, "12", "p3|2 without a certificate"),
    "a statement": (reworded("p1-statement"), 1, "1", f"{NOTEBOOK}|p1-statement|1 in an altered notebook"),
    "a question": (reworded("p2-position-question"), 1, "1", f"{NOTEBOOK}|p2-position-question"),
    "the set-up": (altered(lambda cells: cell(cells, "setup").update(source="from sympy import *")), 2, "1", "setup"),
    "a type of cell": (
        altered(lambda cells: cell(cells, "p1-jacobian-question").update(cell_type="raw")), 1, "1",
        "p1-jacobian-question",
    ),
    "metadata": (altered(lambda cells: cell(cells, "p1-jacobian")["metadata"].clear()), 1, "1", "p1-jacobian changed"),
    "a cell that is gone": (
        altered(lambda cells: cells.remove(cell(cells, "p2-determinant"))), 1, "1", "p2-determinant",
    ),
    "a cell that is added": (
        altered(lambda cells: cells.append({"cell_type": "raw", "source": ["Not ", "so."]})), 2, "1", "cell 18",
    ),
    "a cell that is there twice": (altered(lambda cells: cells.append(dict(cell(cells, "title")))), 2, "1", "title"),
    "another order": (altered(lambda cells: cells.append(cells.pop(3))), 2, "1", "order|2 in an altered notebook"),
    "text that is none": (
        altered(lambda cells: cells.append({"cell_type": "raw", "source": "\ud800"})), 2, "1", "cell 18",
    ),
    "a cell that is none": (altered(lambda cells: cells.append([])), 0, "", ""),  # type: ignore[arg-type]
    "another student's notebook": (
        lambda folder: shutil.copy(notebook(folder, "s002"), notebook(folder)), 2, "1", "metadata|title|2 in an",
    ),
    "another edition's notebook": (of_another_edition, 2, "1", "metadata|2 in an altered notebook"),
    "no notebook": (broken(None), 2, "1", f"{NOTEBOOK}|2 without a notebook"),
    "a notebook cut off": (broken(b"{"), 2, "1", f"{NOTEBOOK}|2 in an altered notebook"),
    "a notebook in no encoding": (broken(b"\xff"), 2, "1", f"{NOTEBOOK}|utf-8|2 in an altered notebook"),
    "a notebook without cells": (broken(b"[]"), 2, "1", f"{NOTEBOOK}|no cells|2 in an altered notebook"),
    "a deep notebook": (broken(b"[" * 100_000), 2, "1", f"{NOTEBOOK}|2 in an altered notebook"),
}  # fmt: skip
"""What is changed, how many problems fail by it and of which students, and what is printed."""


@pytest.mark.parametrize("case", ALTERED)
def test_what_was_altered_fails_its_student(folder: Path, case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    change, failed, students, words = ALTERED[case]
    if case != "nothing":  # to prove all problems again takes longest
        monkeypatch.setattr(certifying, "find_failures", lambda _: [])
    change(folder)
    count, output = verified(folder)
    assert (count, [word for word in words.split("|") if word not in output]) == (failed, []), output
    named = {line[:5] for line in output.splitlines() if re.match(r"s00\d: ", line)}
    assert named == {f"s00{number}:" for number in students}, output


def test_a_certificate_says_what_was_made_by_what_and_what_it_passed(released: Path) -> None:
    assignment = load_assignment(released)
    content = json.loads(certificate_path(assignment, "s001").read_text(encoding="utf-8"))
    own, plain = content["problems"]["p1"], content["problems"]["p2"]
    assert own["problem"].startswith("lab-arm/")
    assert (plain["engine"], plain["band"], plain["questions"]) == (ENGINE, [1, 2], ["position", "determinant"])
    assert 10 <= plain["difficulty"] < 24
    assert {"jacobian: product of exponentials", "singular-angles: complete"} <= set(own["checks"])
    assert set(own["parts"]) == {"jacobian", "determinant", "singular-angles"}
    (_, problem), _ = assignment.generate_problems("s001")
    assert own["sha256"] == compute_digests(problem).sha256


def test_students_draw_different_lengths_of_an_own_robot(released: Path) -> None:
    assignment = load_assignment(released)
    arms = {assignment.generate_problems(student.id)[0][1].chain for student in assignment.roster}
    assert len(arms) == len(assignment.roster)
    assert all(not arm.parameters or {s.name for s in arm.parameters} == {"d1"} for arm in arms)
    again = pickle.loads(pickle.dumps(assignment))  # as it goes to other processes
    assert again.generate_problems("ada") == assignment.generate_problems("ada")


def test_all_of_a_folder_are_certified_whatever_their_certificates_are(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(folder / "certificates")
    monkeypatch.setattr(Matrix, "as_typed", lambda answer: "theta1")
    failed, output = verified(folder)
    assert failed == 4 and "4 not passing the checks" in output


def test_answers_and_what_programs_do_to_a_notebook_alter_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def work(cells: Cells) -> None:
        cell(cells, "p2-position")["source"] = ["p2_position = ", "Matrix([a1, 0])"]
        cell(cells, "setup").update(outputs=[{"output_type": "stream", "name": "stdout", "text": "1"}])
        cell(cells, "setup")["execution_count"] = 3
        for each in cells:
            del each["id"]
            each["source"] = "".join(each["source"]).splitlines(keepends=True)
        cells.append({"cell_type": "code", "source": " \n", "metadata": {}, "outputs": []})

    altered(work)(folder)
    monkeypatch.setattr(
        "qdot.exercises.writing.problem_texts.write_statement", lambda *_: "Another wording."
    )  # as of a later version
    monkeypatch.setattr("qdot.exercises.writing.problem_texts.write_prompt", lambda *_: "Another question's wording.")
    monkeypatch.setattr("qdot.grader.grading.certify.find_qdot_version", lambda: "9.1")
    assert verified(folder)[0] == 0


def test_who_left_the_roster_is_verified_all_the_same(folder: Path) -> None:
    rewritten("roster.csv", lambda text: "".join(text.splitlines(keepends=True)[:-1]))(folder)
    failed, output = verified(folder)
    assert failed == 0 and "s002" in output
    edited(SHA)(folder)
    assert verified(folder)[0] == 1
    shutil.rmtree(folder / "certificates" / "s002")
    assert verified(folder)[0] == 2


def test_files_that_are_not_qdots_fail_nothing(folder: Path) -> None:
    for name in ("released/.DS_Store", "released/s001/.ipynb_checkpoints/test.ipynb", "released/.old/test.ipynb"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("{", encoding="utf-8")
    (folder / "released" / "s001" / "other.ipynb").write_text("{", encoding="utf-8")
    (folder / "certificates" / "README").write_text("{", encoding="utf-8")
    assert verified(folder)[0] == 0


def test_a_problem_that_fails_is_not_handed_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "released")
    monkeypatch.setattr(certifying, "find_failures", lambda *_: ["jacobian: frames: entry (1, 1): 1, expected 2"])
    told: list[ReleaseResult] = []
    release_notebooks(load_assignment(folder), CERTIFIER, 1, told.append)
    assert [(one.student, one.outcome) for one in told] == [("s001", "left out"), ("s002", "left out")]
    assert "s001: p1 (lab-arm): 10 attempts, but no valid problem. The first attempt: jacobian: frames:" in str(
        told[0].failed_slots[0]
    )
    assert not (folder / "released").exists()


def test_an_own_robot_that_is_singular_everywhere_is_not_handed_out(folder: Path) -> None:
    shutil.rmtree(folder / "released")
    (folder / "Lab arm.toml").write_text('task = ["wx", "wy"]\n' + ARM, encoding="utf-8")
    (folder / "assignment.toml").write_text(
        PROBLEMS.replace('"jacobian", "determinant", "singular-angles"', '"jacobian"')
    )
    said = r"full rank: J for the task wx, wy has rank 1 of 2, whatever the configuration; choose another task$"
    with pytest.raises(QdotError, match=said):
        release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    assert not (folder / "released").exists()


def test_a_record_is_the_same_each_time_whatever_the_points() -> None:
    problem = generate(ProblemId("elbow-3r", 4, ("jacobian", "singular-angles")))
    assert make_record(problem) == make_record(generate(problem.id))
    assert compute_digests(problem) == compute_digests(generate(problem.id, points=(5, 6)))
    other = compute_digests(generate(ProblemId("elbow-3r", 5, problem.id.questions)))
    assert compute_digests(problem).arm != other.arm


def test_an_unknown_band_fails_loudly() -> None:
    ((_, failures),) = verify_all([VerificationTask(ProblemId("planar-2r", 1, band=(4, 4)))], 1)
    assert [failure.message for failure in failures] == [
        "planar-2r/1 (all questions): planar-2r has no arm of difficulty 4; its arms are of difficulty 1"
    ]


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('robot = "none.toml"', 'robot = "none.toml": there is no file'),
        ('family = "planar-2r"\nrobot = "Lab arm.toml"', "either a family, .* or a robot"),
        ("questions = []", "either a family, .* or a robot"),
        ('family = "planar-2r"\ndifficulty = 4', "difficulty = 4: planar-2r"),
        ('family = "planar-2r"\ndifficulty = 9', "difficulty = 9: .*from 0 to 4"),
        ('family = "planar-2r"\ndifficulty = [2, 1]', r"difficulty = \[2, 1\]"),
        ('robot = "Lab arm.toml"\nquestions = ["gram-determinant"]', "gram-determinant"),
        ("a9 = [0.1, 0.2]", r"draw: a9 = \[0.1, 0.2\]: .*a2, a3, d1"),
        ("a2 = [0.5, 0.2]", "draw: a2"),
        ("a2 = 0.5", "draw: a2 = 0.5: .*metres"),
        ("a2 = [0.501, 0.502]", "whole centimetres"),
    ],
)
def test_an_entry_or_a_range_that_can_t_be_made_is_said(folder: Path, entry: str, said: str) -> None:
    if entry.startswith("a"):
        (folder / "Lab arm.toml").write_text(ARM.partition("[draw]")[0] + f"[draw]\n{entry}\n", encoding="utf-8")
        said = rf"Lab arm\.toml: .*{said}"
    else:
        text = f'title = "T"\nkey = "t"\n[[problem]]\n{entry}\n'
        (folder / "assignment.toml").write_text(text, encoding="utf-8")
        said = rf"assignment\.toml: line \d: problem 1: .*{said}"
    with pytest.raises(QdotError, match=said):
        load_assignment(folder)


def test_a_crash_is_a_failure_of_its_problem_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    made = generate

    def crashing(identity: ProblemId, **others: Any) -> Problem:
        if identity.seed == 1:
            raise ZeroDivisionError("by zero")
        return made(identity, **others)

    monkeypatch.setattr("qdot.grader.grading.certify.generate", crashing)
    tasks = [VerificationTask(ProblemId("planar-2r", seed, ("jacobian",))) for seed in range(3)]
    found = [[failure.message for failure in failures] for _, failures in verify_all(tasks, 1)]
    said = "planar-2r/1 (jacobian): qdot failed: ZeroDivisionError: by zero; please report this error"
    assert found == [[], [said], []]


IDS = ("planar-2r/7", "planar-2r/7@full", "planar-2r/7@modified-dh", "scara/1@chapter@screws")


@pytest.mark.parametrize("text", IDS)
def test_every_identity_can_be_put_on_record(text: str) -> None:
    own = {"questions": (), "band": None, "engine": 1, "qdot": "0", "difficulty": 0, "sha256": "", "arm": ""}
    record = ProblemRecord.model_validate({"problem": str(ProblemId.parse(text)), "parts": {}, "checks": (), **own})
    assert record.problem == text
