"""A problem that fails its certificate is regenerated from another seed; if all seeds fail, the student is left out."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from nbformat import NotebookNode

from qdot.exercises.arm.chain import Chain
from qdot.exercises.assignment import release
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.replacements import MAX_SEEDS, read_replacements
from qdot.exercises.common.stream import Stream
from qdot.exercises.notebook.notebook import NotebookContent, make_student_notebook
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.reference_answers import Answer
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.verify.certificate import CHECKS
from qdot.exercises.verify.numeric_model import Check, NumericModel
from qdot.grader.cli.main import app
from tests.support import ROOT, read_data
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import answer_and_submit, make_class, work_in_one_process

pytestmark = pytest.mark.xdist_group("replacements")

STUDENTS = [f"s{number}" for number in range(1, 7)]
TOML = read_data("assignments/replacements.toml")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return make_folder(tmp_path / "hw")


def make_folder(folder: Path) -> Path:
    return make_class(folder, [Student(name) for name in STUDENTS], TOML).folder


def inject_failure(monkeypatch: pytest.MonkeyPatch, is_wrong: Callable[[int], bool]) -> None:
    """Let determinants fail their certificates for some seeds."""

    def check(model: NumericModel, part: Part) -> Iterator[Check]:
        yield Check("fault", not is_wrong(model.problem.id.seed), "put in")

    monkeypatch.setitem(CHECKS, "determinant", check)


def is_odd(seed: int) -> bool:
    return seed % 2 == 1


def list_seeds(assignment: Assignment, student: str) -> list[int]:
    return [assignment.slots[1].make_problem_id(assignment.secret, student, n).seed for n in range(1, MAX_SEEDS + 1)]


def read_notebooks(folder: Path) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in folder.glob("released/*/hw.ipynb")}


def generate(folder: Path) -> str:
    return run("generate", folder, "--jobs", "1")


def run_incomplete(folder: Path, *command: str) -> str:
    result = runner.invoke(app, [*command[:1], str(folder), *command[1:], "--jobs", "1"])
    assert result.exit_code == 2
    return result.stderr


def test_only_failing_problems_are_regenerated(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sound_folder = make_folder(tmp_path / "sound")
    generate(sound_folder)
    inject_failure(monkeypatch, is_odd)
    generate(folder)
    before = load_assignment(sound_folder)
    affected = {student for student in STUDENTS if is_odd(list_seeds(before, student)[0])}
    assert affected and affected != set(STUDENTS)
    replacements = read_replacements(folder)
    assert {student for student, _ in replacements} == affected
    assert all(
        slot == "p2" and replacement.first_failure == "determinant: fault: put in"
        for (_, slot), replacement in replacements.items()
    )
    for student, text in read_notebooks(folder).items():
        assert (text == read_notebooks(sound_folder)[student]) == (student not in affected)
    after = load_assignment(folder)
    for student in affected:
        first = next(n for n, seed in enumerate(list_seeds(after, student), 1) if not is_odd(seed))
        assert replacements[student, "p2"].seed_number == first
        # The other problem of the student's notebook stays as it was.
        cells, sound_cells = (json.loads(read_notebooks(source)[student])["cells"] for source in (folder, sound_folder))
        assert [cell for cell in cells if cell["id"].startswith("p1")] == [
            cell for cell in sound_cells if cell["id"].startswith("p1")
        ]
    assert "6 kept" in generate(folder)
    assert "12 problems verified, 0 failed" in run("verify", folder, "--jobs", "1")


@pytest.mark.whole
def test_the_released_problem_is_graded_and_shown(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inject_failure(monkeypatch, is_odd)
    generate(folder)
    assignment = load_assignment(folder)
    for student in STUDENTS:
        answer_and_submit(assignment, student)
    monkeypatch.undo()  # the grader sees no failure, but has redrawn.csv
    with work_in_one_process():
        run("grade", folder, "--jobs", "1")
        results = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
        assert all(result["score"] == result["max_score"] for result in results)
        for result in results:
            ids = [problem["id"] for problem in result["problems"]]
            assert ids == [str(problem.id) for _, problem in assignment.generate_problems(result["student"])]
        affected = next(student for student, _ in assignment.replacements)
        identity = str(dict(assignment.generate_problems(affected))["p2"].id)
        assert identity in run("show", identity, "--questions", "position,determinant")
        (folder / "redrawn.csv").unlink()
        result = runner.invoke(app, ["grade", str(folder), "--jobs", "1"])
        assert f"WARNING: {len(assignment.replacements)} of 6 notebooks " in result.stderr
        assert "made from another assignment.toml, redrawn.csv or secret" in result.stderr
    assert "was released instead" in run("verify", folder, "--jobs", "1", code=1)


def test_a_lost_record_is_restored_by_the_next_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inject_failure(monkeypatch, is_odd)
    generate(folder)
    record, before = (folder / "redrawn.csv").read_bytes(), read_notebooks(folder)
    (folder / "redrawn.csv").unlink()
    assert "6 kept" in generate(folder)
    assert (folder / "redrawn.csv").read_bytes() == record
    assert read_notebooks(folder) == before
    # A version without the failure, or with other points, changes nobody's problem.
    monkeypatch.undo()
    (folder / "assignment.toml").write_text(TOML + "points = [1, 5]\n")
    ids = {student: list_seeds(load_assignment(folder), student) for student in STUDENTS}
    generate(folder)
    assert (folder / "redrawn.csv").read_bytes() == record
    assert ids == {student: list_seeds(load_assignment(folder), student) for student in STUDENTS}


def test_a_student_without_a_valid_problem_is_named_and_the_others_get_notebooks(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing = set(list_seeds(load_assignment(folder), "s3"))
    inject_failure(monkeypatch, lambda seed: seed in failing)
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.exit_code == 2
    assert result.stdout.startswith("6 students: 5 written, 1 left out;")
    assert "s3: p2 (planar-2r): " in result.stderr and "determinant: fault: put in\n" in result.stderr
    last = result.stderr.splitlines()[-1]
    assert last.startswith("qdot: 1 of 6 students") and "(s3)" in last and "Change the questions" in last
    assert set(read_notebooks(folder)) == set(STUDENTS) - {"s3"}
    # With other questions, every student gets a notebook.
    (folder / "assignment.toml").write_text(TOML.replace('["position", "determinant"]', '["position"]'))
    rewriting = runner.invoke(app, ["generate", str(folder)])
    assert "5 rewritten" in rewriting.stdout and "hints or site" in rewriting.stderr
    assert set(read_notebooks(folder)) == set(STUDENTS)


def test_an_outdated_notebook_of_a_student_left_out_is_reported(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generate(folder)
    inject_failure(monkeypatch, lambda _: True)
    (folder / "assignment.toml").write_text(TOML + "points = [1, 5]\n")
    assert f"{folder / 'released' / 's3' / 'hw.ipynb'} belongs to an older" in run_incomplete(folder, "generate")


@pytest.mark.parametrize("error", [RuntimeError("no such pose"), ZeroDivisionError("division by zero")])
def test_a_problem_that_cannot_be_generated_is_regenerated(
    folder: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    question = ALL_QUESTIONS["determinant"]

    def fail_half_the_time(chain: Chain, rng: Stream) -> tuple[Answer, Details]:
        if rng.integer_below(2):
            raise error
        return question.ask(chain, rng)

    monkeypatch.setitem(ALL_QUESTIONS, "determinant", replace(question, sample=fail_half_the_time))
    generate(folder)
    (reason,) = {replacement.first_failure for replacement in read_replacements(folder).values()}
    assert str(error) in reason and ("qdot itself failed" in reason) == isinstance(error, ZeroDivisionError)
    assert set(read_notebooks(folder)) == set(STUDENTS)


def test_the_others_are_graded_although_one_student_was_left_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("threading.active_count", lambda: 1)  # s3 is graded again in a fork, with the fault
    failing = {str(seed) for seed in list_seeds(load_assignment(folder), "s3")}
    question = ALL_QUESTIONS["determinant"]

    def fail_for_student(chain: Chain, rng: Stream) -> tuple[Answer, Details]:
        if set(rng._seed.decode().split("/")) & failing:
            raise RuntimeError("no such pose")
        return question.ask(chain, rng)

    monkeypatch.setitem(ALL_QUESTIONS, "determinant", replace(question, sample=fail_for_student))
    run_incomplete(folder, "generate")
    assignment = load_assignment(folder)
    for student in read_notebooks(folder):
        answer_and_submit(assignment, student)
    # The question still fails, so s3 has no mark instead of a zero.
    assert "s3: qdot could not grade this (RuntimeError: no such pose)" in run_incomplete(folder, "grade")
    lines = (folder / "graded" / "results.jsonl").read_text().splitlines()
    results = {line["student"]: line for line in map(json.loads, lines)}
    assert all(results[student]["score"] == results[student]["max_score"] for student in read_notebooks(folder))
    assert results["s3"]["submission"] is None
    assert {part["outcome"] for problem in results["s3"]["problems"] for part in problem["parts"]} == {"ungraded"}


def test_a_notebook_that_cannot_be_written_affects_one_student(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail_for_student(content: NotebookContent) -> NotebookNode:
        if content.student == "s2" and any(slot == "p2" for slot, _ in content.problems):
            raise KeyError("theta9")
        return make_student_notebook(content)

    monkeypatch.setattr(release, "make_student_notebook", fail_for_student)
    stderr = run_incomplete(folder, "generate")
    assert "s2: p2 (planar-2r): " in stderr and "KeyError" in stderr
    assert set(read_notebooks(folder)) == set(STUDENTS) - {"s2"}


DRIVER = """
import sys
sys.path.insert(0, {root!r})
from qdot.exercises.verify.certificate import CHECKS
from qdot.exercises.verify.numeric_model import Check

def check(numeric, part):
    yield Check("fault", numeric.problem.id.seed % 2 == 0, "put in")

CHECKS["determinant"] = check
if __name__ == "__main__":
    from qdot.grader.cli.main import main
    main()
"""


@pytest.mark.whole
def test_a_killed_run_continues_with_the_same_problems(tmp_path: Path) -> None:
    """Two processes are killed; notebooks written before don't change."""
    driver = tmp_path / "driver.py"
    driver.write_text(DRIVER.format(root=str(ROOT)))
    killed, complete = make_folder(tmp_path / "killed"), make_folder(tmp_path / "whole")
    command = [sys.executable, str(driver), "generate"]
    subprocess.run([*command, str(complete), "--jobs", "2"], check=True, capture_output=True)
    assert read_replacements(complete)
    with subprocess.Popen([*command, str(killed), "--jobs", "2"], stderr=subprocess.DEVNULL) as run_to_kill:
        while run_to_kill.poll() is None and not (killed / "redrawn.csv").exists():
            time.sleep(0.01)
        run_to_kill.kill()
    written = read_notebooks(killed)
    subprocess.run([*command, str(killed), "--jobs", "1"], check=True, capture_output=True)
    assert read_notebooks(killed) == read_notebooks(complete)
    assert written.items() <= read_notebooks(killed).items()
    assert (killed / "redrawn.csv").read_bytes() == (complete / "redrawn.csv").read_bytes()


def test_exports_release_and_record_the_same_problems(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inject_failure(monkeypatch, is_odd)
    run("export", folder, "--to", "github", "--to", "html", "--sheet", "key", "--jobs", "1")
    exported = {
        path.parent.name: path.read_bytes() for path in (folder / "exports" / "github" / "students").glob("*/hw.ipynb")
    }
    record = (folder / "redrawn.csv").read_bytes()
    assert (folder / "exports" / "github" / "grading" / "redrawn.csv").read_bytes() == record
    generate(folder)
    assert read_notebooks(folder) == exported
    assert (folder / "redrawn.csv").read_bytes() == record
    (folder / "redrawn.csv").unlink()
    sheets = folder / "exports" / "html" / "key-all.html"
    before = sheets.read_bytes()
    # An export to paper alone chooses the same seeds.
    run("export", folder, "--to", "html", "--sheet", "key", "--jobs", "1")
    assert sheets.read_bytes() == before
    assert (folder / "redrawn.csv").read_bytes() == record


def test_an_export_leaves_out_a_student_without_a_valid_problem(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    failing = set(list_seeds(load_assignment(folder), "s3"))
    inject_failure(monkeypatch, lambda seed: seed in failing)
    for export_format, files in (("gradescope", "students/*/hw.ipynb"), ("html", "handout/*.html")):
        stderr = run_incomplete(folder, "export", "--to", export_format)
        assert "1 of 6 students" in stderr and "(s3)" in stderr
        assert len(list((folder / "exports" / export_format).glob(files))) == 5


def test_a_bank_skips_failing_seeds_and_fails_if_none_passes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inject_failure(monkeypatch, is_odd)
    bank = ("export", folder, "--to", "prairielearn", "--variants", "4", "--jobs", "1")
    result = runner.invoke(app, [str(word) for word in bank])
    assert result.exit_code == 0
    assert "determinant: fault: put in" in result.stderr
    bank_seeds = json.loads(next((folder / "exports").rglob("bank.json")).read_text())["seeds"]
    assert len(bank_seeds["p2"]) == 4 and not any(is_odd(int(seed)) for seed in bank_seeds["p2"])
    inject_failure(monkeypatch, lambda _: True)
    message = run_and_fail(*bank)
    assert "p2 (planar-2r): " in message and "Change the questions" in message


@pytest.mark.parametrize(
    "line", ["s1,p2,planar-2r,1,x", "s1,p2,planar-2r,11,x", "s1,p2,planar-2r,two,x", "s1,p2,planar-2r,,", "s1"]
)
def test_a_damaged_record_is_an_error_with_its_line(folder: Path, line: str) -> None:
    (folder / "redrawn.csv").write_text(f"student,problem,family,draw,why\n{line}\n")
    assert "redrawn.csv: line 2: draw = " in run_and_fail("generate", folder)


def test_a_record_of_another_family_is_ignored(folder: Path) -> None:
    first = load_assignment(folder)
    (folder / "redrawn.csv").write_text("student,problem,family,draw,why\ns1,p2,polar-rp,3,x\ns2,p2,planar-2r,3,x\n")
    after = load_assignment(folder)
    slot = after.slots[1]
    assert after.make_problem_id(slot, "s1") == first.make_problem_id(slot, "s1") != after.make_problem_id(slot, "s2")
    assert (
        after.notebook_digest_of("s1")
        == first.notebook_digest
        == after.notebook_digest
        != after.notebook_digest_of("s2")
    )


def test_notebooks_of_former_students_are_reported(folder: Path) -> None:
    generate(folder)
    roster = (folder / "roster.csv").read_text()
    (folder / "roster.csv").write_text("".join(line for line in roster.splitlines(True) if not line.startswith("s3")))
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.exit_code == 0
    assert "(s3)" in result.stderr
