"""The same promise on every machine, or a refusal: machines that refuse namespaces, Landlock or both, root and others.

Where there are no namespaces, quota, folders, processes and clean-up are enforced by other means; whatever is promised
was tried by the probe, and what it can't see is seen here.
"""

import json
import os
import platform
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.grader.sandbox.contained import attempts, folders
from qdot.grader.sandbox.guarantees import ENFORCED_BY_KERNEL, probe
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.sandbox.temporary_folder import make_temporary_folder
from tests.support.machines import DOCKERS_ROOT, NOBODY, run_restricted
from tests.support.suites import sample_for_suite

pytestmark = [
    pytest.mark.xdist_group("machines"),
    pytest.mark.skipif(
        sys.platform != "linux" or platform.machine() not in ("x86_64", "aarch64"), reason="a filter of Linux's"
    ),
]


REFUSED = {"namespaces": ["namespaces"], "Landlock": ["landlock"], "both": ["namespaces", "landlock"]}
USERS = [None, DOCKERS_ROOT, NOBODY] if os.geteuid() == 0 else [None]

ATTACKS = {
    "fills its folder": "for i in range(60): open(str(i), 'wb').write(bytes(9_900_000))",
    "fills files without names": (
        "k = []\nfor i in range(60):\n    k.append(open('x', 'wb', 0)); os.unlink('x'); k[-1].write(bytes(9_900_000))"
    ),
    "nests": "for i in range(1200): os.mkdir('d'); os.chdir('d')",
    "closes": "os.mkdir('d'); os.mkdir('d/e'); f = os.open('d', 0); os.fchmod(os.open('d/e', 0), 0); os.fchmod(f, 0)",
    "kills by a descriptor": (
        "import fcntl\nr, w = os.pipe()\nfcntl.fcntl(r, fcntl.F_SETOWN, os.getppid())\n"
        "fcntl.fcntl(r, fcntl.F_SETSIG, 9); fcntl.fcntl(r, fcntl.F_SETFL, os.O_ASYNC); os.write(w, b'x')"
    ),
    "multiplies": "while True: os.fork()",
}
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
def place() -> Iterator[Path]:
    """A folder for temporary files that any user may have, in none that pytest closes."""
    with tempfile.TemporaryDirectory(prefix="qdot-machine-") as made:
        for folder in (Path(made), Path(made) / "tmp"):
            folder.mkdir(exist_ok=True)
            folder.chmod(0o777)
        yield Path(made) / "tmp"


@pytest.mark.integration
@pytest.mark.parametrize(("name", "user"), [(name, user) for name in REFUSED for user in USERS])
def test_what_is_promised_on_a_machine_is_kept_there(name: str, user: int | None, place: Path) -> None:
    told = run_restricted(REFUSED[name], ["-m", "qdot", "doctor", "--json"], user, place)
    assert told.returncode == 0, told.stderr
    found = json.loads(told.stdout)
    assert set(REFUSED[name]) <= found["lacking"].keys()
    by = {each["name"]: each["by"] for each in found["guarantees"]}
    assert by["processes"] == by["memory"] == by["privileges"] == by["time"] == by["network"] == ENFORCED_BY_KERNEL
    is_open = {"namespaces", "landlock"} <= found["lacking"].keys()  # then nothing keeps it from reading files
    assert (by["files"] == ENFORCED_BY_KERNEL) == found["strict"] == (not is_open)
    done = run_restricted(REFUSED[name], ["-c", PROGRAM], user, place)
    assert done.returncode == 0, done.stderr
    first, *runs, last = map(json.loads, done.stdout.splitlines())
    assert first["uid"] == (os.geteuid() if user is None else user)
    assert [run["name"] for run in runs] == list(ATTACKS)
    for run in runs:
        assert run["answers"] == {"a": "1"} and run["honest"] == {"h": "2"}, run
        assert run["same"] and not run["behind"], run
    if "namespaces" in found["lacking"]:  # without a file system of its own, who writes too much is stopped
        # Folders in folders are made in no time in a file system in memory, before they are counted; they are removed.
        assert [run["end"] for run in runs][:2] == ["killed"] * 2 and runs[2]["end"] in ("killed", "done")
    assert last["left"] == []


@pytest.mark.integration
@pytest.mark.skipif(os.geteuid() != 0, reason="only root may make a namespace of processes alone")
def test_a_grader_that_is_the_first_process_of_a_container_is_told_the_same() -> None:
    """A notebook is the first of its own namespace, too: its own number is not taken for the grader's."""
    seen = """
import json, os
from qdot.grader.sandbox.guarantees import probe
found = probe(quick=True)
(processes,) = (each.achieved for each in found.guarantees if each.name == "processes")
print(json.dumps(dict(first=os.getpid() == 1, strict=found.is_strict, processes=processes)))
"""
    first = f"""
import os, sys
from qdot.grader.sandbox.contained import kernel
kernel.unshare(kernel.NEWPID)
pid = os.fork()
if pid == 0:
    assert os.getpid() == 1
    os.execv(sys.executable, [sys.executable, "-c", {seen!r}])
sys.exit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""
    done = run_restricted([], ["-c", first])
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"first": True, "strict": True, "processes": []}


@pytest.mark.parametrize(
    ("without", "guarantee", "seen"),
    sample_for_suite([
        ({"namespaces"}, "files", None),
        ({"namespaces", "quota"}, "files", {"wrote 256 MB in all", "wrote 256 MB into files without names"}),
        ({"namespaces", "landlock", "seccomp", "limits"}, "memory",
         {f"started {attempts.UNLIMITED_PROCESSES} processes"}),
        ({"namespaces", "landlock", "seccomp", "limits"}, "processes", {"started a program"}),
        ({"namespaces", "landlock", "seccomp", "user", "privileges"}, "processes",
         {"killed the process that starts notebooks"}),
        ({"namespaces", "landlock"}, "files", {"wrote into another folder"}),  # whoever may read a file, reads it
    ], 3),
)  # fmt: skip
def test_the_probe_sees_what_nothing_prevents(without: set[str], guarantee: str, seen: set[str] | None) -> None:
    achieved = {each.name: each.achieved for each in probe(without, quick=True).guarantees}[guarantee]
    assert not achieved if seen is None else seen <= set(achieved)
    assert "landlock" not in without or guarantee != "files" or any("read a file" in each for each in achieved)


def test_the_probe_sees_what_is_left_behind() -> None:
    nest = [attempt.action for attempt in attempts.SEPARATE_ATTEMPTS].index(attempts._leave_nested_folders)
    with Sandbox(Limits(seconds=10), {"namespaces"}, load_libraries=False) as sandbox:
        assert sandbox.exchange({"attempts": {"seconds": 0, "alone": nest}}, lambda _: None) == "killed"
        assert not sandbox.has_left_files
        assert sandbox._folder is not None
        for name in ("one", "two"):
            Path(sandbox._folder.path, name).mkdir()
        assert sandbox.has_left_files


def counted(cells: list[str], names: list[str]) -> Run:
    with Sandbox(Limits(seconds=20, cell_seconds=8), {"namespaces", "watch"}) as sandbox:
        return sandbox.run(["import os", *cells], names)


def test_who_writes_too_much_is_stopped_soon_and_told() -> None:
    cells = [f"open('f{i}', 'wb').write(bytes(9_900_000)); n{i} = 1" for i in range(60)]
    run = counted(cells, [f"n{i}" for i in range(60)])
    assert 5 <= len(run.answers) <= 25 and run.end == "killed"
    assert run.last_begun_cell is not None and run.last_begun_cell >= len(run.answers)
    for words in ("in cell 9 because", "3 GB", "64 MB in at most 4096 files, folders nested 32 deep"):
        assert words in run.describe_end("cell 9")


def test_what_is_written_within_the_limits_is_not_stopped() -> None:
    cells = [
        "for i in range(5): open(str(i), 'wb').write(bytes(9_900_000))",
        "import time; time.sleep(0.3)",
        "os.makedirs('/'.join('abcdefgh')); print('x' * 10**8)",
        "import tempfile\nwith tempfile.TemporaryFile() as f: f.write(b'x')\na = 1",
    ]
    run = counted(cells, ["a"])
    assert (run.answers, run.cell_errors, run.end) == ({"a": "1"}, {}, "done")


def test_a_folder_is_removed_however_deep_and_closed_it_is(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "file").touch()
    folder = tmp_path / "folder"
    folder.mkdir()
    at = os.open(folder, os.O_RDONLY)
    for _ in range(1100):  # deeper than Python's recursion, and with paths that are longer than any may be
        os.mkdir("d" * 50, dir_fd=at)
        inner = os.open("d" * 50, os.O_RDONLY, dir_fd=at)
        os.close(os.open("file", os.O_CREAT, dir_fd=inner))
        os.close(at)
        at = inner
    os.close(at)
    (folder / "link").symlink_to(kept)
    (folder / "closed" / "inner").mkdir(parents=True)
    (folder / "closed" / "link").symlink_to(kept)
    (folder / "closed" / "inner").chmod(0)
    (folder / "closed").chmod(0)
    folders.remove(str(folder))
    assert list(tmp_path.iterdir()) == [kept] and (kept / "file").exists()
    with pytest.raises(TimeoutError, match="is not empty after"):  # what takes too long is left
        folders.remove(str(kept), -1)


def test_leftovers_that_are_hard_to_remove_stop_no_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    left = tmp_path / "qdot-own-left.tmp"
    (left / "inner").mkdir(parents=True, mode=0)
    with make_temporary_folder("qdot-own-"):
        assert not left.exists()
    left.mkdir()

    def fail(*_: object) -> None:
        raise RecursionError

    monkeypatch.setattr(folders, "remove", fail)
    assert Path(make_temporary_folder("qdot-own-").path).is_dir() and left.exists()


@pytest.mark.integration
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can put a file in the place of a device")
def test_what_ended_the_probe_is_told(tmp_path: Path) -> None:
    """As after `--report github=/dev/null` as root, when a report took the place of the device."""
    (tmp_path / "null").touch()
    program = (
        "import sys; from qdot.grader.sandbox.contained import kernel; from qdot.grader.cli.main import app\n"
        "kernel.unshare(kernel.NEWNS); kernel.mount(None, '/', None, kernel.MS_REC | kernel.MS_PRIVATE)\n"
        f"kernel.mount({str(tmp_path / 'null')!r}, '/dev/null', None, kernel.MS_BIND); app(['doctor'])"
    )
    done = run_restricted([], ["-c", program])
    assert done.returncode == 2
    assert done.stderr.startswith("qdot: the sandbox does not work on this machine: its probe ended early (unbegun: ")
    assert "'/dev/null'" in done.stderr and len(done.stderr.splitlines()) == 1
