"""No problem blocks a class: what can't be certified is drawn anew, and at last left out and told; by faults put in."""

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
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.replacements import MAX_SEEDS, read_replacements
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.stream import Stream
from qdot.exercises.notebook.notebook import make_student_notebook
from qdot.exercises.notebook.self_check import Problems
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.reference_answers import Answer
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.verify.certificate import CHECKS
from qdot.exercises.verify.numeric_reference import Check, NumericReference
from qdot.grader.cli.demo import fill_in_answers
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from tests.support import ROOT
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import work_in_one_process

pytestmark = pytest.mark.xdist_group("drawing")

STUDENTS = [f"s{number}" for number in range(1, 7)]
TOML = """title = "T"
key = "hw"
[[problem]]
family = "planar-pr"
questions = ["jacobian"]
[[problem]]
family = "planar-2r"
questions = ["position", "determinant"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return a_class(tmp_path / "hw")


def a_class(folder: Path) -> Path:
    init_assignment(folder, "T", "hw", [Student(name) for name in STUDENTS], secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    return folder


def put_in(monkeypatch: pytest.MonkeyPatch, is_wrong: Callable[[int], bool]) -> None:
    """Have determinants fail their certificates for some seeds."""

    def check(numeric: NumericReference, part: Part) -> Iterator[Check]:
        yield Check("fault", not is_wrong(numeric.problem.id.seed), "put in")

    monkeypatch.setitem(CHECKS, "determinant", check)


def odd(seed: int) -> bool:
    return seed % 2 == 1


def seeds(assignment: Assignment, student: str) -> list[int]:
    """Return the seeds of all draws that a student can have in p2."""
    return [assignment.slots[1].make_problem_id(assignment.secret, student, n).seed for n in range(1, MAX_SEEDS + 1)]


def notebooks(folder: Path) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in folder.glob("released/*/hw.ipynb")}


def generate(folder: Path) -> str:
    return run("generate", folder, "--jobs", "1")


def left_out(folder: Path, *command: str) -> str:
    """Run a command that leaves somebody out, and return what it says of that."""
    result = runner.invoke(app, [*command[:1], str(folder), *command[1:], "--jobs", "1"])
    assert result.exit_code == 2
    return result.stderr


def test_what_fails_is_drawn_anew_and_nobody_elses_notebook_changes(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_fault = a_class(tmp_path / "sound")
    generate(without_fault)
    put_in(monkeypatch, odd)
    generate(folder)
    before = load_assignment(without_fault)
    hit = {student for student in STUDENTS if odd(seeds(before, student)[0])}
    assert hit and hit != set(STUDENTS)
    replacements = read_replacements(folder)
    assert {student for student, _ in replacements} == hit
    assert all(
        place == "p2" and replacement.first_failure == "determinant: fault: put in"
        for (_, place), replacement in replacements.items()
    )
    for student, text in notebooks(folder).items():
        assert (text == notebooks(without_fault)[student]) == (student not in hit)
    after = load_assignment(folder)
    for student in hit:
        first = next(n for n, seed in enumerate(seeds(after, student), 1) if not odd(seed))
        assert replacements[student, "p2"].seed_number == first
        # The other problem of the student's notebook stays as it was.
        ours, theirs = (json.loads(notebooks(where)[student])["cells"] for where in (folder, without_fault))
        assert [cell for cell in ours if cell["id"].startswith("p1")] == [c for c in theirs if c["id"].startswith("p1")]
    assert "6 kept" in generate(folder)
    assert "12 problems verified, 0 failed" in run("verify", folder, "--jobs", "1")


@pytest.mark.whole
def test_the_draw_that_was_handed_out_is_graded_and_shown(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_in(monkeypatch, odd)
    generate(folder)
    assignment = load_assignment(folder)
    for student, text in notebooks(folder).items():
        path = folder / "submitted" / f"{student}.ipynb"
        path.write_text(fill_in_answers(text.decode(), assignment.generate_problems(student), lambda code, _: code))
    monkeypatch.undo()  # whoever grades finds nothing wrong with the first draws, and has redrawn.csv
    with work_in_one_process():
        run("grade", folder, "--jobs", "1")
        results = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
        assert all(result["score"] == result["max_score"] for result in results)
        for result in results:
            ids = [problem["id"] for problem in result["problems"]]
            assert ids == [str(problem.id) for _, problem in assignment.generate_problems(result["student"])]
        hit = next(student for student, _ in assignment.replacements)
        identity = str(dict(assignment.generate_problems(hit))["p2"].id)
        assert identity in run("show", identity, "--questions", "position,determinant")
        # Without redrawn.csv, what comes back is no longer what would be handed out, and that is said.
        (folder / "redrawn.csv").unlink()
        result = runner.invoke(app, ["grade", str(folder), "--jobs", "1"])
        assert f"WARNING: {len(assignment.replacements)} of 6 notebooks " in result.stderr
        assert "made from another assignment.toml, redrawn.csv or secret" in result.stderr
    assert "was released instead" in run("verify", folder, "--jobs", "1", code=1)


def test_a_lost_record_is_restored_by_the_next_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_in(monkeypatch, odd)
    generate(folder)
    record, before = (folder / "redrawn.csv").read_bytes(), notebooks(folder)
    (folder / "redrawn.csv").unlink()
    assert "6 kept" in generate(folder)
    assert (folder / "redrawn.csv").read_bytes() == record
    assert notebooks(folder) == before
    # A later version that has mended the cause, or other points, leave everybody the problem that they have.
    monkeypatch.undo()
    (folder / "assignment.toml").write_text(TOML + "points = [1, 5]\n")
    ids = {student: seeds(load_assignment(folder), student) for student in STUDENTS}
    generate(folder)
    assert (folder / "redrawn.csv").read_bytes() == record
    assert ids == {student: seeds(load_assignment(folder), student) for student in STUDENTS}


def test_who_has_no_draw_that_passes_is_named_and_all_others_have_their_notebooks(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = set(seeds(load_assignment(folder), "s3"))
    put_in(monkeypatch, lambda seed: seed in lost)
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.exit_code == 2
    assert result.stdout.startswith("6 students: 5 written, 1 left out;")
    assert "s3: p2 (planar-2r): " in result.stderr and "determinant: fault: put in\n" in result.stderr
    last = result.stderr.splitlines()[-1]
    assert last.startswith("qdot: 1 of 6 students") and "(s3)" in last and "Change the questions" in last
    assert set(notebooks(folder)) == set(STUDENTS) - {"s3"}
    # With other questions, the run goes on.
    (folder / "assignment.toml").write_text(TOML.replace('["position", "determinant"]', '["position"]'))
    assert "5 rewritten" in generate(folder)
    assert set(notebooks(folder)) == set(STUDENTS)


def test_an_old_notebook_of_who_is_left_out_is_told_of(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generate(folder)
    put_in(monkeypatch, lambda _: True)
    (folder / "assignment.toml").write_text(TOML + "points = [1, 5]\n")
    assert f"{folder / 'released' / 's3' / 'hw.ipynb'} belongs to an older" in left_out(folder, "generate")


@pytest.mark.parametrize("error", [RuntimeError("no such pose"), ZeroDivisionError("division by zero")])
def test_a_draw_that_finds_nothing_to_ask_or_fails_is_drawn_anew(
    folder: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    question = ALL_QUESTIONS["determinant"]

    def ask(chain: Chain, rng: Stream) -> tuple[Answer, Details]:
        if rng.integer_below(2):
            raise error
        return question.ask(chain, rng)

    monkeypatch.setitem(ALL_QUESTIONS, "determinant", replace(question, sample=ask))
    generate(folder)
    (why,) = {replacement.first_failure for replacement in read_replacements(folder).values()}
    assert str(error) in why and ("qdot itself failed" in why) == isinstance(error, ZeroDivisionError)
    assert set(notebooks(folder)) == set(STUDENTS)


def test_who_was_left_out_does_not_keep_the_others_from_being_graded(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("threading.active_count", lambda: 1)  # s3 is graded again in a fork, with the fault
    lost, question = {str(seed) for seed in seeds(load_assignment(folder), "s3")}, ALL_QUESTIONS["determinant"]

    def ask(chain: Chain, rng: Stream) -> tuple[Answer, Details]:
        if set(rng._seed.decode().split("/")) & lost:
            raise RuntimeError("no such pose")
        return question.ask(chain, rng)

    monkeypatch.setitem(ALL_QUESTIONS, "determinant", replace(question, sample=ask))
    left_out(folder, "generate")
    assignment = load_assignment(folder)
    for student, text in notebooks(folder).items():
        right = fill_in_answers(text.decode(), load_stored_problems(assignment, student).problems, lambda code, _: code)
        (folder / "submitted" / f"{student}.ipynb").write_text(right)
    # The pose is still not to be had, so that s3 has no mark, not a zero.
    assert "s3: qdot could not grade this (RuntimeError: no such pose)" in left_out(folder, "grade")
    lines = (folder / "graded" / "results.jsonl").read_text().splitlines()
    results = {line["student"]: line for line in map(json.loads, lines)}
    assert all(results[student]["score"] == results[student]["max_score"] for student in notebooks(folder))
    assert results["s3"]["submission"] is None
    assert {part["outcome"] for problem in results["s3"]["problems"] for part in problem["parts"]} == {"ungraded"}


def test_a_notebook_that_cannot_be_written_is_one_students(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def make(title: str, key: str, student: str, problems: Problems, hinted: bool) -> NotebookNode:
        if student == "s2" and any(slot == "p2" for slot, _ in problems):
            raise KeyError("theta9")
        return make_student_notebook(title, key, student, problems, hinted)

    monkeypatch.setattr(release, "make_student_notebook", make)
    stderr = left_out(folder, "generate")
    assert "s2: p2 (planar-2r): " in stderr and "KeyError" in stderr
    assert set(notebooks(folder)) == set(STUDENTS) - {"s2"}


def test_a_run_that_is_stopped_goes_on_to_the_very_same(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was handed out before is not another afterwards."""
    put_in(monkeypatch, odd)
    whole, told = a_class(tmp_path / "whole"), list[release.ReleaseResult]()
    generate(whole)

    def stop(made: release.ReleaseResult) -> None:
        told.append(made)
        if len(told) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        release.release_notebooks(load_assignment(folder), CERTIFIER, 1, stop)
    there = notebooks(folder)
    assert there and len(there) < len(STUDENTS)
    generate(folder)
    assert notebooks(folder) == notebooks(whole) and there.items() <= notebooks(folder).items()
    assert (folder / "redrawn.csv").read_bytes() == (whole / "redrawn.csv").read_bytes()


DRIVER = """
import sys
sys.path.insert(0, {root!r})
from qdot.exercises.verify.certificate import CHECKS
from qdot.exercises.verify.numeric_reference import Check

def check(numeric, part):
    yield Check("fault", numeric.problem.id.seed % 2 == 0, "put in")

CHECKS["determinant"] = check
if __name__ == "__main__":
    from qdot.grader.cli.main import main
    main()
"""


@pytest.mark.whole
def test_a_run_that_is_killed_goes_on_to_the_very_same(tmp_path: Path) -> None:
    """On two processes; what was handed out before is not another afterwards."""
    driver = tmp_path / "driver.py"
    driver.write_text(DRIVER.format(root=str(ROOT)))
    killed, whole = a_class(tmp_path / "killed"), a_class(tmp_path / "whole")
    command = [sys.executable, str(driver), "generate"]
    subprocess.run([*command, str(whole), "--jobs", "2"], check=True, capture_output=True)
    assert read_replacements(whole)
    with subprocess.Popen([*command, str(killed), "--jobs", "2"], stderr=subprocess.DEVNULL) as run_to_kill:
        while run_to_kill.poll() is None and not (killed / "redrawn.csv").exists():
            time.sleep(0.01)
        run_to_kill.kill()
    there = notebooks(killed)
    subprocess.run([*command, str(killed), "--jobs", "1"], check=True, capture_output=True)
    assert notebooks(killed) == notebooks(whole)
    assert there.items() <= notebooks(killed).items()
    assert (killed / "redrawn.csv").read_bytes() == (whole / "redrawn.csv").read_bytes()


def test_exports_hand_out_and_take_along_the_same_draws(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_in(monkeypatch, odd)
    run("export", folder, "--to", "github", "--to", "html", "--sheet", "key", "--jobs", "1")
    exported = {
        path.parent.name: path.read_bytes() for path in (folder / "exports" / "github" / "students").glob("*/hw.ipynb")
    }
    record = (folder / "redrawn.csv").read_bytes()
    assert (folder / "exports" / "github" / "grading" / "redrawn.csv").read_bytes() == record
    generate(folder)
    assert notebooks(folder) == exported
    assert (folder / "redrawn.csv").read_bytes() == record
    (folder / "redrawn.csv").unlink()
    sheets = folder / "exports" / "html" / "key-all.html"
    before = sheets.read_bytes()
    run("export", folder, "--to", "html", "--sheet", "key", "--jobs", "1")  # paper alone settles the same draws
    assert sheets.read_bytes() == before
    assert (folder / "redrawn.csv").read_bytes() == record


def test_an_export_leaves_out_who_can_be_given_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lost = set(seeds(load_assignment(folder), "s3"))
    put_in(monkeypatch, lambda seed: seed in lost)
    for export_format, files in (("gradescope", "students/*/hw.ipynb"), ("html", "handout/*.html")):
        stderr = left_out(folder, "export", "--to", export_format)
        assert "1 of 6 students" in stderr and "(s3)" in stderr
        assert len(list((folder / "exports" / export_format).glob(files))) == 5


def test_a_bank_passes_over_what_fails_and_says_so_where_nothing_passes(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put_in(monkeypatch, odd)
    bank = ("export", folder, "--to", "prairielearn", "--variants", "4", "--jobs", "1")
    result = runner.invoke(app, [str(word) for word in bank])
    assert result.exit_code == 0
    assert "determinant: fault: put in" in result.stderr
    seeds_of = json.loads(next((folder / "exports").rglob("bank.json")).read_text())["seeds"]
    assert len(seeds_of["p2"]) == 4 and not any(odd(int(seed)) for seed in seeds_of["p2"])
    put_in(monkeypatch, lambda _: True)
    said = run_and_fail(*bank)
    assert "p2 (planar-2r): " in said and "Change the questions" in said


@pytest.mark.parametrize(
    "line", ["s1,p2,planar-2r,1,x", "s1,p2,planar-2r,11,x", "s1,p2,planar-2r,two,x", "s1,p2,planar-2r,,", "s1"]
)
def test_a_damaged_record_is_told(folder: Path, line: str) -> None:
    (folder / "redrawn.csv").write_text(f"student,problem,family,draw,why\n{line}\n")
    assert "redrawn.csv: line 2: draw = " in run_and_fail("generate", folder)


def test_a_record_of_another_family_is_passed_over(folder: Path) -> None:
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


def test_notebooks_of_who_has_left_the_roster_are_told_of(folder: Path) -> None:
    generate(folder)
    roster = (folder / "roster.csv").read_text()
    (folder / "roster.csv").write_text("".join(line for line in roster.splitlines(True) if not line.startswith("s3")))
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.exit_code == 0
    assert "(s3)" in result.stderr
