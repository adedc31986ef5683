"""Properties of all export formats, and the bank of variants that some of them use."""

import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.console import ProgressCounter
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports import scorm
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.bank import convert_bank, iterate_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.robots.library import ROBOT_FOLDER
from qdot.exercises.verify.certificate import certify
from qdot.grader.cli import export_commands
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import find_failures
from qdot.grader.marking.marking import compute_earned_share
from tests.support.command import run, run_and_fail, runner
from tests.support.site_scripts import write_stand_in_assets
from tests.support.submitting import make_class
from tests.support.suites import select_for_suite


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    assignment = make_class(tmp_path_factory.mktemp("bank") / "hw", [Student("ada")])
    return ExportRequest(assignment, find_failures, variant_count=4, compute_earned_share=compute_earned_share)


def test_bank_has_distinct_certified_problems_and_extends_a_shorter_one(export_request: ExportRequest) -> None:
    steps: list[None] = []
    short = list(iterate_bank(replace(export_request, on_step=lambda: steps.append(None))))
    assert [variant.key for variant in short] == ["p1-001", "p1-002", "p1-003", "p1-004"]
    assert len(steps) == 4 == EXPORT_FORMATS["html"].count_steps(export_request) * 4
    assert len({compute_digests(variant.problem).sha256 for variant in short}) == 4
    assert not [failed for variant in short for failed in certify(variant.problem).failures]
    longer = list(iterate_bank(replace(export_request, variant_count=6, jobs=2)))
    assert [str(variant.problem.id) for variant in longer[:4]] == [str(variant.problem.id) for variant in short]
    student_ids = {str(problem.id) for _, problem in export_request.assignment.generate_problems("ada")}
    assert not student_ids & {str(variant.problem.id) for variant in longer}


def test_small_family_gives_all_its_problems_with_a_note(
    export_request: ExportRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    same = export_request.assignment.slots[0].generate_problem("secret", "ada")
    monkeypatch.setattr("qdot.exercises.exports.bank.generate_and_certify", lambda make, vouch: (same, None))
    notes: list[str] = []
    steps: list[None] = []
    worked: list[Problem] = []  # duplicates are not processed
    request = replace(export_request, report=notes.append, on_step=lambda: steps.append(None))
    assert len(list(convert_bank(request, lambda _order, _slot, problem: worked.append(problem)))) == 1
    assert worked == [same]
    assert len(steps) == 4
    assert len(notes) == 1 and notes[0].startswith("p1: planar-2r") and "variation zeros" in notes[0]


def test_robot_with_fixed_lengths_is_noted_as_same_for_all(tmp_path: Path) -> None:
    """The note does not mention a variation, which a robot does not have."""
    make_class(tmp_path, [Student("ada")])
    request = '[[problem]]\nrobot = "scorbot"\nquestions = ["jacobian"]\n'
    (tmp_path / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{request}')
    assignment = load_assignment(tmp_path)
    notes: list[str] = []
    assert len(list(iterate_bank(ExportRequest(assignment, find_failures, variant_count=3, report=notes.append)))) == 1
    assert len(notes) == 1 and notes[0].startswith("p1: scorbot") and "variation" not in notes[0]


def test_several_formats_share_the_progress_and_each_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[tuple[str, int]] = []

    @contextmanager
    def record_progress(title: str, total: int) -> Iterator[ProgressCounter]:
        shown.append((title, total))
        yield ProgressCounter(title, total)

    monkeypatch.setattr(export_commands, "show_progress", record_progress)
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    same = assignment.slots[0].generate_problem("secret", "ada")
    monkeypatch.setattr("qdot.exercises.exports.bank.generate_and_certify", lambda make, vouch: (same, None))
    command = (
        "export", str(assignment.folder), *("--to", "moodle"), *("--to", "qti"), "--variants", "2", "--jobs", "1",
    )  # fmt: skip
    result = runner.invoke(app, command)
    assert [line.partition(":")[0] for line in result.stdout.splitlines()] == ["moodle", "qti"]
    assert result.stderr.count("p1: planar-2r has only one different problem") == 1
    assert shown == [("exporting to moodle, qti", 4)]


def test_export_uses_the_requested_variation(export_request: ExportRequest, tmp_path: Path) -> None:
    """Formats that generate problems from assignment.toml refuse the option."""
    assignment = export_request.assignment.with_variation("base+lengths")
    request = replace(export_request, assignment=assignment, variant_count=2)
    assert {variant.problem.id.variation for variant in iterate_bank(request)} == {"lengths+base"}
    folder = export_request.assignment.folder
    command: list[str | Path] = ["export", folder, "--to", "moodle", "--variants", "1", "--out"]
    assert "moodle: 2 files in" in run(*command, tmp_path / "m", "--variation", "chapter")
    run(*command, tmp_path / "own")
    plain, unchanged = (sorted((tmp_path / name).iterdir()) for name in ("m", "own"))
    assert [path.name for path in plain] == [path.name for path in unchanged]
    assert [path.read_bytes() for path in plain] != [path.read_bytes() for path in unchanged]
    for export_format in ("prairielearn", "html"):
        refused = run_and_fail("export", folder, "--to", export_format, "--variation", "chapter")
        assert "(moodle, canvas, common-cartridge, qti, scorm, stack)" in refused and f"for {export_format}," in refused
    assert "'plain'" in run_and_fail(*command, tmp_path / "plain", "--variation", "plain")

    # A slot whose questions don't apply to other arms is named.
    tied = export_request.assignment.slots[0]
    tied = replace(tied, family=FAMILIES["scara"], questions=("determinant", "jacobian"), band=(0, 0))
    with pytest.raises(QdotError, match=r"^p1, with variation full: "):
        replace(export_request.assignment, slots=(tied,)).with_variation("full")


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    stand_in = write_stand_in_assets(tmp_path_factory.mktemp("scripts") / "dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scorm, "find_assets", lambda: stand_in)
        yield


@pytest.mark.parametrize("export_format", EXPORT_FORMATS)
def test_problem_that_fails_its_certificate_is_not_exported(
    export_request: ExportRequest, assets: None, export_format: str
) -> None:
    request = replace(export_request, find_failures=lambda _: ["wrong"], variant_count=1)
    with pytest.raises(QdotError, match=r"p1.* \(planar-2r\): none of 10 attempts .* The first one failed: wrong"):
        list(EXPORT_FORMATS[export_format].export(request))


def test_files_outside_the_folder_are_copied_into_the_export(tmp_path: Path) -> None:
    """Two robots with the same name, a file of questions and the logo lie outside; a robot in the folder stays."""
    folder, robot = make_class(tmp_path / "hw", [Student("ada")]).folder, (ROBOT_FOLDER / "cobra600.toml").read_bytes()
    for path in ("other/arm.toml", "arm.toml", "hw/shared/arm.toml"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(robot)
    question = 'prompt = "x"\nanswer = "p"\n'
    (tmp_path / "mine.toml").write_text(f"[question.mine]\n{question}[question.other]\n{question}")
    (tmp_path / "logo.svg").write_text("<svg/>")
    robots = ("../arm.toml", "shared/arm.toml", f"{tmp_path.as_posix()}/other/arm.toml")
    problems = "".join(f"[[problem]]\nrobot = '{name}'\nquestions = [ '../mine.toml#mine' ] # '\n" for name in robots)
    text = f'title = "T"\nkey = "hw"\n[paper]\nlogo = "../logo.svg"\n{problems}'
    (folder / "assignment.toml").write_text(text)
    assignment = load_assignment(folder)
    files = read_assignment_files(assignment)
    assert [path for path in files if "/" in path] == [
        "shared/arm.toml", "shared-2/arm.toml", "shared-3/arm.toml", "shared/mine.toml", "shared/logo.svg",
    ]  # fmt: skip
    for path, content in {**files, "secret.txt": assignment.secret.encode()}.items():
        (tmp_path / "export" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "export" / path).write_bytes(content)
    exported = load_assignment(tmp_path / "export")
    assert exported.slots[0].questions == ("mine",)
    assert exported.notebook_digest == assignment.notebook_digest and exported.front_page == assignment.front_page


@pytest.fixture(scope="module")
def certified(export_request: ExportRequest) -> ExportRequest:
    """A request with solutions, whose problems are certified once for all export formats."""
    known: dict[str, Sequence[str]] = {}

    def find_failures_once(problem: Problem) -> Sequence[str]:
        name = str(problem.id)
        if name not in known:
            known[name] = find_failures(problem)
        return known[name]

    return replace(
        export_request, variant_count=select_for_suite(1, 2), has_solutions=True, find_failures=find_failures_once
    )


@pytest.mark.parametrize("export_format", EXPORT_FORMATS)
def test_every_export_format_writes_the_same_files_twice(
    certified: ExportRequest, assets: None, export_format: str
) -> None:
    files = list(EXPORT_FORMATS[export_format].export(certified))
    assert files and files == list(EXPORT_FORMATS[export_format].export(certified))
    paths = [file.path for file in files]
    assert len(set(paths)) == len(paths)
    assert not [path for path in paths if path.startswith("/") or ".." in path.split("/")]
    public = [file.content for file in files if not file.is_private]
    content = [file_content if isinstance(file_content, bytes) else file_content.encode() for file_content in public]
    assert not [data for data in content if certified.assignment.secret.encode() in data]
    # Anyone who knows the id of a problem can see its solution with `qdot show`.
    ids = [variant.problem.id for variant in iterate_bank(certified)]
    ids += [problem.id for _, problem in certified.assignment.generate_problems("ada")]
    assert not [identity for identity in ids for data in content if str(identity.seed).encode() in data]


def test_export_command_writes_files_with_safe_permissions(export_request: ExportRequest, tmp_path: Path) -> None:
    folder = export_request.assignment.folder
    assert "html: 1 file in" in run("export", folder, "--to", "html", "--solutions", "--jobs", "1")
    page = folder / "exports" / "html" / "handout-solutions" / "ada.html"
    assert stat.S_IMODE(page.stat().st_mode) == 0o600  # it has the answers
    run("export", folder, "--to", "latex", "--page", "letter", "--out", tmp_path / "here", "--jobs", "1")
    source = tmp_path / "here" / "handout" / "ada.tex"
    assert stat.S_IMODE(source.stat().st_mode) == 0o644 and "letterpaper" in source.read_text()
    assert "'htm' (did you mean 'html'?)" in run_and_fail("export", folder, "--to", "htm")
    assert "no-such" in run_and_fail("export", tmp_path / "no-such", "--to", "html")
