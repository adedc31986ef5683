"""What all export formats have in common, and the bank of variants behind those that draw from one."""

import os
import stat
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Slot, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports import scorm
from qdot.exercises.exports.bank import iterate_bank, process_bank
from qdot.exercises.exports.export_format import ExportRequest, list_used_files
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.verify.certificate import certify
from qdot.grader.grading.certify import find_failures
from qdot.grader.reports.formats import FORMATS
from tests.support import ROOT
from tests.support.command import run, run_and_fail
from tests.support.site_scripts import write_stand_in_assets
from tests.support.submitting import make_class
from tests.support.suites import select_for_suite
from tests.tools.reference_pages import export_formats_page

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    return ExportRequest(
        make_class(tmp_path_factory.mktemp("bank") / "hw", [Student("ada")]), find_failures, variant_count=4
    )


def test_a_bank_is_of_certified_problems_that_differ_and_begins_like_a_longer_one(order: ExportRequest) -> None:
    told: list[None] = []
    short = list(iterate_bank(replace(order, on_step=lambda: told.append(None))))
    assert [variant.key for variant in short] == ["p1-001", "p1-002", "p1-003", "p1-004"]
    assert len(told) == 4 == EXPORT_FORMATS["html"].count_steps(order) * 4
    assert len({compute_digests(variant.problem).sha256 for variant in short}) == 4
    assert not [failed for variant in short for failed in certify(variant.problem).failures]
    longer = list(iterate_bank(replace(order, variant_count=6, jobs=2)))
    assert [str(variant.problem.id) for variant in longer[:4]] == [str(variant.problem.id) for variant in short]
    drawn = {str(problem.id) for _, problem in order.assignment.generate_problems("ada")}
    assert not drawn & {str(variant.problem.id) for variant in longer}


def test_a_family_with_few_problems_gives_all_it_has_and_says_so(
    order: ExportRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    same = order.assignment.slots[0].generate_problem("secret", "ada")
    monkeypatch.setattr("qdot.exercises.exports.bank.generate_and_certify", lambda make, vouch: (same, None))
    notes: list[str] = []
    told: list[None] = []
    worked: list[Problem] = []  # nothing is made of what was there
    asked = replace(order, report=notes.append, on_step=lambda: told.append(None))
    assert len(list(process_bank(asked, lambda _order, _slot, problem: worked.append(problem)))) == 1
    assert worked == [same]
    assert len(told) == 4
    assert len(notes) == 1 and notes[0].startswith("p1: planar-2r") and "variation zeros" in notes[0]


def test_a_robot_of_fixed_lengths_is_told_to_be_the_same_for_all(tmp_path: Path) -> None:
    """And not that it is so at a variation, of which it has none."""
    make_class(tmp_path, [Student("ada")])
    asked = '[[problem]]\nrobot = "scorbot"\nquestions = ["jacobian"]\n'
    (tmp_path / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{asked}')
    assignment = load_assignment(tmp_path)
    notes: list[str] = []
    assert len(list(iterate_bank(ExportRequest(assignment, find_failures, variant_count=3, report=notes.append)))) == 1
    assert len(notes) == 1 and notes[0].startswith("p1: scorbot") and "variation" not in notes[0]


@pytest.mark.whole
def test_what_is_made_of_a_bank_is_made_by_many_processes_and_is_the_same(order: ExportRequest) -> None:
    """Nobody but this process is told how far it is, and of what can't be asked."""
    steps, notes = list[int](), list[str]()
    alone = replace(order, variant_count=2, has_solutions=True, on_step=lambda: steps.append(1), report=notes.append)
    many = replace(alone, jobs=2)
    elsewhere = {process for _, process in process_bank(many, _process)}
    assert elsewhere and os.getpid() not in elsewhere
    for export_format in ("moodle", "stack"):
        counted, told = len(steps), len(notes)
        one = list(EXPORT_FORMATS[export_format].export(alone))
        assert (len(steps) - counted, notes[told:]) == (2, notes[: len(notes) - told])
        two = list(EXPORT_FORMATS[export_format].export(many))
        assert two == one


def _process(_order: ExportRequest, _slot: Slot, _problem: Problem) -> int:
    return os.getpid()


def test_a_bank_is_of_the_variation_that_is_asked_for(order: ExportRequest, tmp_path: Path) -> None:
    """Where problems are drawn by assignment.toml again, that says how arms vary."""
    asked = replace(order, assignment=order.assignment.with_variation("base+lengths"), variant_count=2)
    assert {variant.problem.id.variation for variant in iterate_bank(asked)} == {"lengths+base"}
    folder = order.assignment.folder
    command: list[str | Path] = ["export", folder, "--to", "moodle", "--variants", "1", "--out"]
    assert "moodle: 2 files in" in run(*command, tmp_path / "m", "--variation", "chapter")
    run(*command, tmp_path / "own")
    plain, own = (sorted((tmp_path / name).iterdir()) for name in ("m", "own"))
    assert [path.name for path in plain] == [path.name for path in own]
    assert [path.read_bytes() for path in plain] != [path.read_bytes() for path in own]
    for export_format in ("prairielearn", "html"):
        refused = run_and_fail("export", folder, "--to", export_format, "--variation", "chapter")
        assert "(moodle, canvas, qti, scorm, stack)" in refused and f"for {export_format}," in refused
    assert "'plain'" in run_and_fail(*command, tmp_path / "plain", "--variation", "plain")

    # A place that can't be asked of other arms is named.
    tied = order.assignment.slots[0]
    tied = replace(tied, family=FAMILIES["scara"], questions=("lost-motion", "jacobian"), band=(0, 0))
    with pytest.raises(QdotError, match=r"^p1, with variation full: "):
        replace(order.assignment, slots=(tied,)).with_variation("full")


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What stands for the site's scripts, which packages of SCORM hold."""
    made = write_stand_in_assets(tmp_path_factory.mktemp("scripts") / "dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scorm, "find_assets", lambda: made)
        yield


@pytest.mark.parametrize("export_format", EXPORT_FORMATS)
def test_a_problem_that_fails_its_certificate_is_not_exported(
    order: ExportRequest, assets: None, export_format: str
) -> None:
    with pytest.raises(
        QdotError, match=r"p1.* \(planar-2r\): 10 attempts, but no valid problem\. The first attempt: wrong"
    ):
        list(EXPORT_FORMATS[export_format].export(replace(order, find_failures=lambda _: ["wrong"], variant_count=1)))


@pytest.mark.parametrize(
    "export_format", [name for name, export_format in EXPORT_FORMATS.items() if export_format.check is list_used_files]
)
def test_a_robot_outside_of_the_folder_is_refused(order: ExportRequest, export_format: str, tmp_path: Path) -> None:
    (tmp_path / "assignment.toml").write_text('title = "T"\nkey = "hw"\n[[problem]]\nrobot = "../arm.toml"\n')
    with pytest.raises(QdotError, match="is outside"):
        EXPORT_FORMATS[export_format].check(replace(order, assignment=replace(order.assignment, folder=tmp_path)))


@pytest.fixture(scope="module")
def certified(order: ExportRequest) -> ExportRequest:
    """An order with solutions, each of whose problems is certified once for all export formats."""
    known: dict[str, Sequence[str]] = {}

    def failures(problem: Problem) -> Sequence[str]:
        name = str(problem.id)
        if name not in known:
            known[name] = find_failures(problem)
        return known[name]

    return replace(order, variant_count=select_for_suite(1, 2), has_solutions=True, find_failures=failures)


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
    content = [one if isinstance(one, bytes) else one.encode() for one in public]
    assert not [data for data in content if certified.assignment.secret.encode() in data]
    # Who knows the id of a problem is shown its solution by `qdot show`.
    ids = [variant.problem.id for variant in iterate_bank(certified)]
    ids += [problem.id for _, problem in certified.assignment.generate_problems("ada")]
    assert not [identity for identity in ids for data in content if str(identity.seed).encode() in data]


def test_export_as_an_instructor_uses_it(order: ExportRequest, tmp_path: Path) -> None:
    folder = order.assignment.folder
    assert "html: 1 file in" in run("export", folder, "--to", "html", "--solutions", "--jobs", "1")
    page = folder / "exports" / "html" / "handout-solutions" / "ada.html"
    assert stat.S_IMODE(page.stat().st_mode) == 0o600  # it has the answers
    run("export", folder, "--to", "latex", "--page", "letter", "--out", tmp_path / "here", "--jobs", "1")
    source = tmp_path / "here" / "handout" / "ada.tex"
    assert stat.S_IMODE(source.stat().st_mode) == 0o644 and "letterpaper" in source.read_text()
    assert "'htm' (did you mean 'html'?)" in run_and_fail("export", folder, "--to", "htm")
    assert "no-such" in run_and_fail("export", tmp_path / "no-such", "--to", "html")


def test_reports_are_asked_for_by_format_and_path(order: ExportRequest, tmp_path: Path) -> None:
    folder = order.assignment.folder
    of_a_class = [name for name, form in FORMATS.items() if not form.is_for_one_student]
    asked = [part for name in of_a_class for part in ("--report", f"{name}={tmp_path / name}")]
    run("grade", folder, *asked, "--jobs", "1")
    assert (tmp_path / "csv").read_text() == (folder / "graded" / "grades.csv").read_text()
    assert all((tmp_path / name).stat().st_size for name in of_a_class)
    printed = run("grade", folder, "--report", "csv=-", "--jobs", "1")
    assert printed == (tmp_path / "csv").read_text()  # the summary is elsewhere
    assert "FORMAT=PATH" in run_and_fail("grade", folder, "--report", "csv")
    assert "'cvs'" in run_and_fail("grade", folder, "--report", "cvs=x")


def test_the_page_of_export_formats_is_up_to_date() -> None:
    """Where this fails, run: make docs"""
    assert (DOCS / "export-formats.md").read_text(encoding="utf-8") == export_formats_page()
