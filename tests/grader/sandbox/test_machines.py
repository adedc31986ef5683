"""Every machine keeps the sandbox's guarantees or reports what is missing, for root and ordinary users alike.

The machines lack namespaces, Landlock or both. Without namespaces, other means enforce quotas, folders, processes and
clean-up. The probe tries what it promises; these tests try what the probe can't see.
"""

import json
import os
import platform
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.grader.sandbox.guarantees import ENFORCED_BY_KERNEL, probe
from qdot.grader.sandbox.notebook_process import escape_attempts, folder_removal
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.sandbox.temporary_folder import make_temporary_folder
from tests.support import read_cases
from tests.support.machines import DOCKERS_ROOT, NOBODY, run_restricted
from tests.support.suites import sample_for_suite

pytestmark = [
    pytest.mark.xdist_group("machines"),
    pytest.mark.skipif(
        sys.platform != "linux" or platform.machine() not in ("x86_64", "aarch64"),
        reason="needs a Linux system-call filter",
    ),
]


MISSING_MEASURES = {"namespaces": ["namespaces"], "Landlock": ["landlock"], "both": ["namespaces", "landlock"]}
USERS = [None, DOCKERS_ROOT, NOBODY] if os.geteuid() == 0 else [None]

ATTACKS = dict(read_cases("sandbox")["attacks_on_machines"])
PROGRAM = f"""
import json, os, tempfile
from qdot.grader.sandbox.sandbox import Limits, Sandbox
print(json.dumps(dict(uid=os.geteuid())))
with Sandbox(Limits(seconds=20, cell_seconds=8), ["watch"]) as sandbox:
    for name, cell in {ATTACKS!r}.items():
        run = sandbox.run(["import os; a = 1", cell], ["a"])
        pid = sandbox._process.pid
        honest = sandbox.run(["h = 2"], ["h"])
        print(json.dumps(dict(
            name=name, end=run.end, honest=honest.answers, behind=sandbox.has_left_processes,
            same=sandbox._process.pid == pid, answers=run.answers,
        )))
print(json.dumps(dict(left=os.listdir(tempfile.gettempdir()))))
"""


@pytest.fixture
def shared_folder() -> Iterator[Path]:
    """A folder for temporary files that any user may write, outside pytest's private folders."""
    with tempfile.TemporaryDirectory(prefix="qdot-machine-") as root:
        for directory in (Path(root), Path(root) / "tmp"):
            directory.mkdir(exist_ok=True)
            directory.chmod(0o777)
        yield Path(root) / "tmp"


@pytest.mark.integration
@pytest.mark.parametrize(("name", "user"), [(name, user) for name in MISSING_MEASURES for user in USERS])
def test_each_machine_keeps_what_doctor_promises(name: str, user: int | None, shared_folder: Path) -> None:
    doctor = run_restricted(MISSING_MEASURES[name], ["-m", "qdot", "doctor", "--json"], user, shared_folder)
    assert doctor.returncode == 0, doctor.stderr
    report = json.loads(doctor.stdout)
    assert set(MISSING_MEASURES[name]) <= report["lacking"].keys()
    enforcement = {guarantee["name"]: guarantee["by"] for guarantee in report["guarantees"]}
    by_kernel = {enforcement[name] for name in ("processes", "memory", "privileges", "time", "network")}
    assert by_kernel == {ENFORCED_BY_KERNEL}
    reads_files = {"namespaces", "landlock"} <= report["lacking"].keys()
    assert (enforcement["files"] == ENFORCED_BY_KERNEL) == report["strict"] == (not reads_files)
    attacks = run_restricted(MISSING_MEASURES[name], ["-c", PROGRAM], user, shared_folder)
    assert attacks.returncode == 0, attacks.stderr
    first, *runs, last = map(json.loads, attacks.stdout.splitlines())
    assert first["uid"] == (os.geteuid() if user is None else user)
    assert [run["name"] for run in runs] == list(ATTACKS)
    for run in runs:
        assert run["answers"] == {"a": "1"} and run["honest"] == {"h": "2"}, run
        assert run["same"] and not run["behind"], run
    if "namespaces" in report["lacking"]:  # without a private file system, a notebook that writes too much is killed
        # Nested folders may be created before they are counted; they are removed.
        assert [run["end"] for run in runs][:2] == ["killed"] * 2 and runs[2]["end"] in ("killed", "done")
    assert last["left"] == []


@pytest.mark.integration
@pytest.mark.skipif(os.geteuid() != 0, reason="only root may create a process namespace alone")
def test_guarantees_hold_if_the_grader_is_process_1() -> None:
    """A notebook is process 1 of its own namespace: it must not be mistaken for the grader."""
    probe_program = """
import json, os
from qdot.grader.sandbox.guarantees import probe
findings = probe(quick=True)
(processes,) = (guarantee.achieved for guarantee in findings.guarantees if guarantee.name == "processes")
print(json.dumps(dict(first=os.getpid() == 1, strict=findings.is_strict, processes=processes)))
"""
    program = f"""
import os, sys
from qdot.grader.sandbox.notebook_process import kernel
kernel.unshare(kernel.NEWPID)
pid = os.fork()
if pid == 0:
    assert os.getpid() == 1
    os.execv(sys.executable, [sys.executable, "-c", {probe_program!r}])
sys.exit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""
    done = run_restricted([], ["-c", program])
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"first": True, "strict": True, "processes": []}


@pytest.mark.parametrize(
    ("without", "guarantee", "expected"),
    sample_for_suite([
        ({"namespaces"}, "files", None),
        ({"namespaces", "quota"}, "files", {"wrote 256 MB in all", "wrote 256 MB into files without names"}),
        ({"namespaces", "landlock", "seccomp", "limits"}, "memory",
         {f"started {escape_attempts.UNLIMITED_PROCESSES} processes"}),
        ({"namespaces", "landlock", "seccomp", "limits"}, "processes", {"started a program"}),
        ({"namespaces", "landlock", "seccomp", "user", "privileges"}, "processes",
         {"killed the process that starts notebooks"}),
        ({"namespaces", "landlock"}, "files", {"wrote into another folder"}),  # may be read, too
    ], 3),
)  # fmt: skip
def test_the_probe_finds_every_possible_attack(without: set[str], guarantee: str, expected: set[str] | None) -> None:
    achieved = {finding.name: finding.achieved for finding in probe(without, quick=True).guarantees}[guarantee]
    assert not achieved if expected is None else expected <= set(achieved)
    assert "landlock" not in without or guarantee != "files" or any("read a file" in finding for finding in achieved)


def test_the_probe_finds_leftover_files() -> None:
    actions = [attempt.action for attempt in escape_attempts.SEPARATE_ATTEMPTS]
    targets = {"seconds": 0, "separate_attempt": actions.index(escape_attempts._leave_nested_folders)}
    with Sandbox(Limits(seconds=10), {"namespaces"}, load_libraries=False) as sandbox:
        assert sandbox.exchange({"attempts": targets}, lambda _: None) == "killed"
        assert not sandbox.has_left_files
        assert sandbox._folder is not None
        for name in ("one", "two"):
            Path(sandbox._folder.path, name).mkdir()
        assert sandbox.has_left_files


def run_with_file_limits(cells: list[str], names: list[str]) -> Run:
    with Sandbox(Limits(seconds=20, cell_seconds=8), {"namespaces", "watch"}) as sandbox:
        return sandbox.run(["import os", *cells], names)


def test_a_notebook_that_writes_too_much_is_killed_and_told_why() -> None:
    cells = [f"open('f{i}', 'wb').write(bytes(9_900_000)); n{i} = 1" for i in range(60)]
    run = run_with_file_limits(cells, [f"n{i}" for i in range(60)])
    assert 5 <= len(run.answers) <= 25 and run.end == "killed"
    assert run.last_begun_cell is not None and run.last_begun_cell >= len(run.answers)
    for words in ("in cell 9 because", "3 GB", "64 MB in at most 4096 files, folders nested 32 deep"):
        assert words in run.describe_end("cell 9")


def test_a_notebook_may_write_within_its_limits() -> None:
    cells = [
        "for i in range(5): open(str(i), 'wb').write(bytes(9_900_000))",
        "import time; time.sleep(0.3)",
        "os.makedirs('/'.join('abcdefgh')); print('x' * 10**8)",
        "import tempfile\nwith tempfile.TemporaryFile() as f: f.write(b'x')\na = 1",
    ]
    run = run_with_file_limits(cells, ["a"])
    assert (run.answers, run.cell_errors, run.end) == ({"a": "1"}, {}, "done")


def test_deep_and_unreadable_folders_are_removed(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "file").touch()
    folder = tmp_path / "folder"
    folder.mkdir()
    descriptor = os.open(folder, os.O_RDONLY)
    for _ in range(1100):  # deeper than Python's recursion limit and the longest allowed path
        os.mkdir("d" * 50, dir_fd=descriptor)
        inner = os.open("d" * 50, os.O_RDONLY, dir_fd=descriptor)
        os.close(os.open("file", os.O_CREAT, dir_fd=inner))
        os.close(descriptor)
        descriptor = inner
    os.close(descriptor)
    (folder / "link").symlink_to(kept)
    (folder / "closed" / "inner").mkdir(parents=True)
    (folder / "closed" / "link").symlink_to(kept)
    (folder / "closed" / "inner").chmod(0)
    (folder / "closed").chmod(0)
    folder_removal.remove_folder(str(folder))
    assert list(tmp_path.iterdir()) == [kept] and (kept / "file").exists()
    with pytest.raises(TimeoutError, match="is not empty after"):  # removal that takes too long is abandoned
        folder_removal.remove_folder(str(kept), -1)


def test_leftovers_that_cannot_be_removed_prevent_no_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    leftover = tmp_path / "qdot-own-left.tmp"
    (leftover / "inner").mkdir(parents=True, mode=0)
    with make_temporary_folder("qdot-own-"):
        assert not leftover.exists()
    leftover.mkdir()

    def fail(*_: object) -> None:
        raise RecursionError

    monkeypatch.setattr(folder_removal, "remove_folder", fail)
    assert Path(make_temporary_folder("qdot-own-").path).is_dir() and leftover.exists()


@pytest.mark.integration
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can put a file in the place of a device")
def test_doctor_reports_what_ended_the_probe(tmp_path: Path) -> None:
    """Replace /dev/null by a file, as `--report github=/dev/null` did when run as root."""
    (tmp_path / "null").touch()
    program = (
        "import sys; from qdot.grader.sandbox.notebook_process import kernel; from qdot.grader.cli.main import app\n"
        "kernel.unshare(kernel.NEWNS); kernel.mount(None, '/', None, kernel.MS_REC | kernel.MS_PRIVATE)\n"
        f"kernel.mount({str(tmp_path / 'null')!r}, '/dev/null', None, kernel.MS_BIND); app(['doctor'])"
    )
    doctor = run_restricted([], ["-c", program])
    assert doctor.returncode == 2
    reason = "its probe ended early (not-started: "
    assert doctor.stderr.startswith(f"qdot: the sandbox does not work on this machine: {reason}")
    assert "'/dev/null'" in doctor.stderr and len(doctor.stderr.splitlines()) == 1
