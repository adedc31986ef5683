"""Certificates stored with an assignment: `qdot verify DIR` uses them to find what changed."""

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
    init_assignment,
    make_certificate_path,
    make_notebook_path,
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
from tests.support import read_data

JOINTS = [("theta1", '"d1"', "0", '"pi/2"'), ("theta2", "0", '"a2"', "0"), ("theta3", "0", '"a3"', "0")]
ROWS = [f'[[joint]]\nkind = "R"\ntheta = "{q}"\nd = {d}\na = {a}\nalpha = {alpha}\n' for q, d, a, alpha in JOINTS]
ARM = f'name = "lab arm"\n{"".join(ROWS)}[draw]\na2 = [0.3, 0.8]\na3 = [0.3, 0.8]\n'
PROBLEMS = read_data("assignments/certificates.toml")


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certified") / "hw"
    # With another secret, two students may get the same lengths.
    init_assignment(folder, "Test", "test", secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(PROBLEMS, encoding="utf-8")
    (folder / "Lab arm.toml").write_text(ARM, encoding="utf-8")
    release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    return folder


@pytest.fixture
def folder(released: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(released, tmp_path / "hw"))


def verify_folder(folder: Path) -> tuple[int, str]:
    result = CliRunner().invoke(make_program(), ["verify", str(folder), "--jobs", "1"])
    counts = re.search(r"(\d+) problems? verified, (\d+) failed", result.output)
    assert counts, result.output
    assert result.exit_code == (counts[2] != "0")
    return int(counts[2]), result.output


Cells = list[dict[str, Any]]
Change = Callable[[Path], object]


def change_json(path: Path, change: Callable[[Any], object]) -> None:
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content, indent=2), encoding="utf-8")


def find_certificate(folder: Path, student: str = "s001") -> Path:
    return make_certificate_path(load_assignment(folder), student)


def find_notebook(folder: Path, student: str = "s001") -> Path:
    return make_notebook_path(load_assignment(folder), student)


def edit_entry(change: dict[str, Any], student: str = "s002") -> Change:
    update = lambda content: content["problems"]["p2"].update(change)  # noqa: E731
    return lambda folder: change_json(find_certificate(folder, student), update)


def edit_cells(change: Callable[[Cells], object]) -> Change:
    return lambda folder: change_json(find_notebook(folder), lambda content: change(content["cells"]))


def edit_file(name: str, change: Callable[[str], str]) -> Change:
    def rewrite(folder: Path) -> None:
        path = folder / name
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")

    return rewrite


def damage(content: bytes | None) -> Change:
    """Return a change that replaces a certificate by bytes or a folder, and falsifies another certificate."""

    def replace_content(folder: Path) -> None:
        path = find_certificate(folder)
        path.unlink()
        path.mkdir() if content is None else path.write_bytes(content)
        edit_entry({"sha256": "0" * 64})(folder)

    return replace_content


def find_cell(cells: Cells, name: str) -> dict[str, Any]:
    return next(cell for cell in cells if cell["id"] == name)


def reword_cell(name: str) -> Change:
    def misspell(cells: Cells) -> None:
        find_cell(cells, name)["source"] = find_cell(cells, name)["source"].replace("the", "teh", 1)

    return edit_cells(misspell)


def break_notebook(content: bytes | None) -> Change:
    """Return a change that replaces a notebook by bytes, or removes it."""

    def replace_content(folder: Path) -> None:
        path = find_notebook(folder)
        path.unlink() if content is None else path.write_bytes(content)

    return replace_content


def claim_another_version(folder: Path) -> None:
    digest = load_assignment(folder).problems_digest
    edit_file(str(find_notebook(folder).relative_to(folder)), lambda text: text.replace(digest, "0" * 16))(folder)


SHA = {"sha256": "0" * 64}
EMPTY = '{"assignment": "test", "student": "s001", "notebook_digest": "", "notebook": {}, "problems": '
LATER = PROBLEMS + '[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'
NOTEBOOK = "test.ipynb"
CHANGES: dict[str, tuple[Change, int, str, str]] = {
    "nothing": (lambda _: None, 0, "", ""),
    "digests of parts": (
        edit_entry({**SHA, "parts": {"position": "1", "determinant": "2"}}), 1, "2", "planar-2r/|position, determinant",
    ),
    "digest of the arm": (edit_entry({**SHA, "arm": "1"}), 1, "2", "planar-2r/|the arm"),
    "another problem": (edit_entry({**SHA, "problem": "planar-2r/12"}), 1, "2", "planar-2r/|was released instead"),
    "another problem, same digest": (
        edit_entry({"problem": "planar-2r/12"}), 1, "2", "planar-2r/|was released instead",
    ),
    "another engine": (edit_entry({"engine": ENGINE + 1, "qdot": "9.1"}), 1, "2", f"planar-2r/|{ENGINE + 1}|9.1"),
    "another engine with news": (edit_entry({"engine": ENGINE + 1, "news": {}}), 1, "2", "1 of another version"),
    "a robot": (
        edit_file("Lab arm.toml", lambda text: text.replace('"pi/2"', '"-pi/2"')), 2, "12", "the arm|2 changed",
    ),
    "no certificate": (
        lambda folder: shutil.rmtree(folder / "certificates" / "s001"), 2, "1", "test.json|2 without a certificate",
    ),
    "a certificate cut off": (damage(b"{"), 3, "12", "test.json|EOF|2 with a damaged certificate|1 changed"),
    "an empty certificate": (damage(b""), 3, "12", "test.json|EOF|2 with a damaged certificate"),
    "a list for a certificate": (damage(b"[]"), 3, "12", "object|2 with a damaged certificate"),
    "a deep certificate": (damage(b"[" * 100_000), 3, "12", "recursion|2 with a damaged certificate"),
    "a certificate in no encoding": (damage(b"\xff\xfe"), 3, "12", "UTF-8|2 with a damaged certificate"),
    "a list of problems": (damage(f"{EMPTY}[]}}".encode()), 3, "12", "problems: |2 with a damaged"),
    "a problem without keys": (damage(f'{EMPTY}{{"p1": {{}}}}}}'.encode()), 3, "12", "problems.p1.problem: "),
    "a folder for a certificate": (damage(None), 3, "12", "Is a directory|2 with a damaged certificate"),
    "no digests of the notebook": (
        lambda folder: change_json(find_certificate(folder), lambda content: content.pop("notebook")), 2, "1",
        "notebook: |2 with a damaged certificate",
    ),
    "another student's certificate": (
        lambda folder: shutil.copy(find_certificate(folder, "s002"), find_certificate(folder)), 2, "1",
        "s002|2 with a damaged",
    ),
    "an arm only": (edit_entry({"arm": "1"}, "s001"), 1, "1", "1 with a damaged certificate"),
    "parts only": (edit_entry({"parts": {"position": "1"}}, "s001"), 1, "1", "1 with a damaged certificate"),
    "questions only": (
        edit_entry({"questions": ["position", "jacobian"]}, "s001"), 1, "1", "1 with a damaged certificate",
    ),
    "a student who is new": (
        edit_file("roster.csv", lambda text: f"{text}s003,Cy Example,cy@example.org\n"), 2, "3",
        "qdot generate|2 without a certificate",
    ),
    "a problem that is gone": (
        edit_file("assignment.toml", lambda text: text.rpartition("[[problem]]")[0]), 2, "12",
        "p2|assignment.toml|2 changed",
    ),
    "a problem that is new": (edit_file("assignment.toml", lambda _: LATER), 2, "12", "p3|2 without a certificate"),
    "a statement": (reword_cell("p1-statement"), 1, "1", f"{NOTEBOOK}|p1-statement|1 in an altered notebook"),
    "a question": (reword_cell("p2-position-question"), 1, "1", f"{NOTEBOOK}|p2-position-question"),
    "the set-up": (
        edit_cells(lambda cells: find_cell(cells, "setup").update(source="from sympy import *")), 2, "1", "setup",
    ),
    "a type of cell": (
        edit_cells(lambda cells: find_cell(cells, "p1-jacobian-question").update(cell_type="raw")), 1, "1",
        "p1-jacobian-question",
    ),
    "metadata": (
        edit_cells(lambda cells: find_cell(cells, "p1-jacobian")["metadata"].clear()), 1, "1", "p1-jacobian changed",
    ),
    "a cell that is gone": (
        edit_cells(lambda cells: cells.remove(find_cell(cells, "p2-determinant"))), 1, "1", "p2-determinant",
    ),
    "a cell that is added": (
        edit_cells(lambda cells: cells.append({"cell_type": "raw", "source": ["Not ", "so."]})), 2, "1", "cell 17",
    ),
    "a cell that is there twice": (
        edit_cells(lambda cells: cells.append(dict(find_cell(cells, "title")))), 2, "1", "title",
    ),
    "another order": (edit_cells(lambda cells: cells.append(cells.pop(3))), 2, "1", "order|2 in an altered notebook"),
    "text that is none": (
        edit_cells(lambda cells: cells.append({"cell_type": "raw", "source": "\ud800"})), 2, "1", "cell 17",
    ),
    "a cell that is none": (edit_cells(lambda cells: cells.append([])), 0, "", ""),  # type: ignore[arg-type]
    "another student's notebook": (
        lambda folder: shutil.copy(find_notebook(folder, "s002"), find_notebook(folder)), 2, "1",
        "metadata|title|2 in an",
    ),
    "notebook of another version": (claim_another_version, 2, "1", "metadata|2 in an altered notebook"),
    "no notebook": (break_notebook(None), 2, "1", f"{NOTEBOOK}|2 without a notebook"),
    "a notebook cut off": (break_notebook(b"{"), 2, "1", f"{NOTEBOOK}|2 in an altered notebook"),
    "a notebook in no encoding": (break_notebook(b"\xff"), 2, "1", f"{NOTEBOOK}|utf-8|2 in an altered notebook"),
    "a notebook without cells": (break_notebook(b"[]"), 2, "1", f"{NOTEBOOK}|no cells|2 in an altered notebook"),
    "a deep notebook": (break_notebook(b"[" * 100_000), 2, "1", f"{NOTEBOOK}|2 in an altered notebook"),
}  # fmt: skip
"""A change, how many problems fail, the numbers of their students, and words of the output."""


@pytest.mark.parametrize("case", CHANGES)
def test_verify_finds_every_change(folder: Path, case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    change, failed, students, words = CHANGES[case]
    if case != "nothing":  # to prove all problems again takes longest
        monkeypatch.setattr(certifying, "find_failures", lambda _: [])
    change(folder)
    count, output = verify_folder(folder)
    assert (count, [word for word in words.split("|") if word not in output]) == (failed, []), output
    named = {line[:5] for line in output.splitlines() if re.match(r"s00\d: ", line)}
    assert named == {f"s00{number}:" for number in students}, output


def test_a_certificate_records_problem_version_and_checks(released: Path) -> None:
    assignment = load_assignment(released)
    content = json.loads(make_certificate_path(assignment, "s001").read_text(encoding="utf-8"))
    robot, family = content["problems"]["p1"], content["problems"]["p2"]
    assert robot["problem"].startswith("lab-arm/")
    assert (family["engine"], family["band"], family["questions"]) == (ENGINE, [1, 2], ["position", "determinant"])
    assert 10 <= family["difficulty"] < 24
    assert {"jacobian: product of exponentials", "singular-angles: complete"} <= set(robot["checks"])
    assert set(robot["parts"]) == {"jacobian", "determinant", "singular-angles"}
    (_, problem), _ = assignment.generate_problems("s001")
    assert robot["sha256"] == compute_digests(problem).sha256


def test_students_get_different_lengths_of_an_own_robot(released: Path) -> None:
    assignment = load_assignment(released)
    arms = {assignment.generate_problems(student.id)[0][1].chain for student in assignment.roster}
    assert len(arms) == len(assignment.roster)
    assert all(not arm.parameters or {s.name for s in arm.parameters} == {"d1"} for arm in arms)
    again = pickle.loads(pickle.dumps(assignment))  # as when it is sent to other processes
    assert again.generate_problems("ada") == assignment.generate_problems("ada")


def test_all_problems_are_checked_without_certificates(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "certificates")
    monkeypatch.setattr(Matrix, "as_typed", lambda answer: "theta1")
    failed, output = verify_folder(folder)
    assert failed == 4 and "4 not passing the checks" in output


def test_answering_and_saving_a_notebook_is_no_change(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def answer_and_save(cells: Cells) -> None:
        find_cell(cells, "p2-position")["source"] = ["p2_position = ", "Matrix([a1, 0])"]
        find_cell(cells, "setup").update(outputs=[{"output_type": "stream", "name": "stdout", "text": "1"}])
        find_cell(cells, "setup")["execution_count"] = 3
        for cell in cells:
            del cell["id"]
            cell["source"] = "".join(cell["source"]).splitlines(keepends=True)
        cells.append({"cell_type": "code", "source": " \n", "metadata": {}, "outputs": []})

    edit_cells(answer_and_save)(folder)
    monkeypatch.setattr(
        "qdot.exercises.writing.problem_texts.write_statement", lambda *_: "Another wording."
    )  # as of a later version
    monkeypatch.setattr("qdot.exercises.writing.problem_texts.write_prompt", lambda *_: "Another question's wording.")
    monkeypatch.setattr("qdot.grader.grading.certify.find_qdot_version", lambda: "9.1")
    assert verify_folder(folder)[0] == 0


def test_notebooks_of_former_students_are_verified(folder: Path) -> None:
    edit_file("roster.csv", lambda text: "".join(text.splitlines(keepends=True)[:-1]))(folder)
    failed, output = verify_folder(folder)
    assert failed == 0 and "s002" in output
    edit_entry(SHA)(folder)
    assert verify_folder(folder)[0] == 1
    shutil.rmtree(folder / "certificates" / "s002")
    assert verify_folder(folder)[0] == 2


def test_unrelated_files_are_ignored(folder: Path) -> None:
    for name in ("released/.DS_Store", "released/s001/.ipynb_checkpoints/test.ipynb", "released/.old/test.ipynb"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("{", encoding="utf-8")
    (folder / "released" / "s001" / "other.ipynb").write_text("{", encoding="utf-8")
    (folder / "certificates" / "README").write_text("{", encoding="utf-8")
    assert verify_folder(folder)[0] == 0


def test_a_failing_problem_is_not_released(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "released")
    monkeypatch.setattr(certifying, "find_failures", lambda *_: ["jacobian: frames: entry (1, 1): 1, expected 2"])
    released: list[ReleaseResult] = []
    release_notebooks(load_assignment(folder), CERTIFIER, 1, released.append)
    assert [(result.student, result.outcome) for result in released] == [("s001", "left out"), ("s002", "left out")]
    start = "s001: p1 (lab-arm): none of 10 attempts gave a valid problem. The first one failed: jacobian: frames:"
    assert start in str(released[0].failed_slots[0])
    assert not (folder / "released").exists()


def test_an_own_robot_that_is_always_singular_is_not_released(folder: Path) -> None:
    shutil.rmtree(folder / "released")
    (folder / "Lab arm.toml").write_text('task = ["wx", "wy"]\n' + ARM, encoding="utf-8")
    (folder / "assignment.toml").write_text(
        PROBLEMS.replace('"jacobian", "determinant", "singular-angles"', '"jacobian"')
    )
    message = r"full rank: J for the task wx, wy has rank 1 of 2, whatever the configuration; choose another task$"
    with pytest.raises(QdotError, match=message):
        release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    assert not (folder / "released").exists()


def test_a_record_is_reproducible_and_independent_of_points() -> None:
    problem = generate(ProblemId("elbow-3r", 4, ("jacobian", "singular-angles")))
    assert make_record(problem) == make_record(generate(problem.id))
    assert compute_digests(problem) == compute_digests(generate(problem.id, points=(5, 6)))
    another = compute_digests(generate(ProblemId("elbow-3r", 5, problem.id.questions)))
    assert compute_digests(problem).arm != another.arm


def test_an_impossible_difficulty_is_a_failure() -> None:
    ((_, failures),) = verify_all([VerificationTask(ProblemId("planar-2r", 1, band=(4, 4)))], 1)
    assert [failure.message for failure in failures] == [
        "planar-2r/1 (all questions): planar-2r has no arm of difficulty 4; its arms are of difficulty 1"
    ]


def test_a_crash_fails_only_its_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    content = generate

    def crashing(identity: ProblemId, **options: Any) -> Problem:
        if identity.seed == 1:
            raise ZeroDivisionError("by zero")
        return content(identity, **options)

    monkeypatch.setattr("qdot.grader.grading.certify.generate", crashing)
    tasks = [VerificationTask(ProblemId("planar-2r", seed, ("jacobian",))) for seed in range(3)]
    messages = [[failure.message for failure in failures] for _, failures in verify_all(tasks, 1)]
    expected = "planar-2r/1 (jacobian): qdot failed: ZeroDivisionError: by zero; please report this error"
    assert messages == [[], [expected], []]


IDS = ("planar-2r/7", "planar-2r/7@full", "planar-2r/7@modified-dh", "scara/1@chapter@screws")


@pytest.mark.parametrize("text", IDS)
def test_every_problem_id_can_be_recorded(text: str) -> None:
    fields = {"questions": (), "band": None, "engine": 1, "qdot": "0", "difficulty": 0, "sha256": "", "arm": ""}
    record = ProblemRecord.model_validate({"problem": str(ProblemId.parse(text)), "parts": {}, "checks": (), **fields})
    assert record.problem == text
