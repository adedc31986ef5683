"""Attacking notebooks: each gets its exact verdict, harms only itself, leaks and changes nothing, leaves nothing behind.

Every attack runs between two answers; after it, an honest notebook in the same sandbox gets its answers. Native attacks
run with the audit hook off, with all of this machine's measures and with some of them switched off: the guarantees that
the probe then still reports as enforced by the kernel must hold.
"""

import contextlib
import functools
import os
import platform
import resource
import signal
import socket
import sys
import threading
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.grader.sandbox.guarantees import (
    ENFORCED_BY_KERNEL,
    NOT_ENFORCED,
    PROMISES,
    WATCHED_IN_PYTHON,
    Findings,
    probe,
)
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from tests.support import DATA
from tests.support.suites import WHOLE, sample_for_suite, select_for_suite

pytestmark = pytest.mark.xdist_group("hostile")  # each sandbox is probed once

HONEST = ["from sympy import *\nx = symbols('x')", "h = diff(sin(x)**2, x)", "import numpy as np; g = np.ones(2)"]
NAMES = ["a", "b", "c"]
VARIANTS = {
    "everything": {"watch"}, "no namespaces": {"watch", "namespaces"}, "no Landlock": {"watch", "landlock"},
    "no seccomp": {"watch", "seccomp"}, "Landlock only": {"watch", "namespaces", "seccomp"},
    "namespaces only": {"watch", "landlock", "seccomp"}, "rlimits only": {"watch", "namespaces", "landlock", "seccomp"},
}  # fmt: skip

FEWEST_PREVENTED = {"everything": 29, "no namespaces": 29, "no Landlock": 29, "no seccomp": 26, "namespaces only": 17}
"""The minimum number of attacks that the kernel must prevent; 0 without seccomp and namespaces."""

FEW = ("everything", "no namespaces")
"""The variants of `make test`."""


def measures_other_than_hook() -> set[str]:
    """Return the measures to switch off so that only the audit hook and rlimits are left, as on macOS."""
    return {"namespaces", "landlock", "seccomp", "user", "privileges"}


OPEN_SANDBOXES: dict[frozenset[str], Sandbox] = {}


def open_sandbox(without: frozenset[str] = frozenset()) -> Sandbox:
    if without not in OPEN_SANDBOXES:
        OPEN_SANDBOXES[without] = Sandbox(Limits(seconds=3, cell_seconds=0.8, memory=1 << 30), without)
    return OPEN_SANDBOXES[without]


@functools.cache
def probe_without(without: frozenset[str]) -> Findings:
    return probe(without, quick=True)


@pytest.fixture(scope="module", autouse=True)
def close_sandboxes() -> Iterator[None]:
    yield
    while OPEN_SANDBOXES:
        OPEN_SANDBOXES.popitem()[1].close()


class Machine:
    """Targets of attacks: other students' work, a secret, an open port, an abstract socket."""

    def __init__(self, folder: Path, port: int, abstract: str) -> None:
        self.folder, self.port, self.abstract = folder, port, abstract
        self.files = {}
        for name in ("secret.txt", "submitted/s02/hw.ipynb", "solutions/s02/hw.ipynb"):
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f"CANARY {name}")
            self.files[path] = path.read_text(), path.stat().st_mtime_ns, path.stat().st_mode


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[Machine]:
    abstract = f"\0qdot-test-{tmp_path}"[:90] if sys.platform == "linux" else str(tmp_path / "s")[:90]
    with socket.create_server(("127.0.0.1", 0)) as server, socket.socket(socket.AF_UNIX) as local:
        local.bind(abstract)
        local.listen()
        machine = Machine(tmp_path, server.getsockname()[1], abstract)
        paths = sorted(tmp_path.rglob("*"))
        yield machine
        for listener in (server, local):
            listener.setblocking(False)
            with pytest.raises(BlockingIOError):
                listener.accept()
    assert sorted(tmp_path.rglob("*")) == paths
    for path, before in machine.files.items():
        assert (path.read_text(), path.stat().st_mtime_ns, path.stat().st_mode) == before


def sandbox_processes(sandbox: Sandbox) -> list[int]:
    """Return the ids of a sandbox's processes, found by their command line, which forks inherit."""
    pids = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if sandbox._folder and sandbox._folder.path.encode() in (path / "cmdline").read_bytes():
                pids.append(int(path.name))
    return pids


def idle_processes(sandbox: Sandbox) -> set[int]:
    """Return the ids of an idle sandbox's processes after clean-up; the last one waits for a notebook."""
    assert not sandbox.has_left_processes
    expected, deadline = 2 if "namespaces" in sandbox.unavailable_measures else 3, time.monotonic() + 3
    while len(pids := sandbox_processes(sandbox)) != expected and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(pids) == expected
    return set(pids)


def run_attack(sandbox: Sandbox, cell: str) -> Run:
    """Run an attack between two answers, then an honest notebook; check that nothing of the attack is left."""
    if not sandbox_processes(sandbox):
        assert sandbox.run(["import os"], []).end == "done"
    idle = idle_processes(sandbox)
    run = sandbox.run(["import os\na = 1", cell, "b = 2"], NAMES)
    assert "CANARY" not in repr(run)
    honest = sandbox.run(HONEST, ["h", "g"])
    assert honest.answers == {"h": "2*sin(x)*cos(x)", "g": "[1.0, 1.0]"} and honest.end == "done"
    left = idle_processes(sandbox)
    if run.end != "lost":
        assert len(left - idle) == 1  # each notebook gets a new process, and the others stay
    return run


ATTACKS = tomllib.loads((DATA / "attacks.toml").read_text(encoding="utf-8"))
ENDED_WITH_CELL = ATTACKS["ended-with-cell"]


@pytest.mark.parametrize("name", sample_for_suite(ENDED_WITH_CELL, 12))
def test_an_attack_ends_with_its_cell(name: str, machine: Machine) -> None:
    error, cell = ENDED_WITH_CELL[name].values()
    sandbox = open_sandbox()
    run = run_attack(sandbox, cell)
    if name == "fills the disk" and "namespaces" in sandbox.unavailable_measures:
        return  # without a private file system, only single files are limited
    assert run.answers == {"a": "1", "b": "2"} and run.end == "done"
    assert list(run.cell_errors) == [1] and error in run.cell_errors[1]


ENDED_WITH_NOTEBOOK = ATTACKS["ended-with-notebook"]


@pytest.mark.parametrize(
    "name", sample_for_suite([name for name in ENDED_WITH_NOTEBOOK if WHOLE or "signals ignored" not in name], 2)
)
def test_answers_before_an_attack_that_ends_the_notebook_are_kept(name: str, machine: Machine) -> None:
    """Ignored signals are tested in test_sandbox.py, too."""
    (ends, cell), timeouts = ENDED_WITH_NOTEBOOK[name].values(), ("it took longer", "it waited longer")
    run = run_attack(open_sandbox(), cell)
    assert run.end in ends, run
    if run.end == "done" and name != "says that it is done":  # the alarm was faster, or Python counts the depth in C
        assert run.answers["b"] == "2"
        # If the alarm cuts the flood within a line, the next line, which reports the alarm, is lost.
        assert run.cell_errors.get(1, timeouts[0] if name == "floods its report" else "").startswith(
            ("RecursionError", *timeouts)
        )
        return
    assert run.answers == {"a": "1"} and run.cell_errors == {}
    assert bool(run.describe_end()) == (run.end != "done")


LIES = ATTACKS["lies"]


@pytest.mark.parametrize("name", sample_for_suite(LIES, 6))
def test_a_lying_object_becomes_text_or_no_answer(name: str, machine: Machine) -> None:
    words, cell = LIES[name].values()
    run = run_attack(open_sandbox(), cell)
    answer = run.answers.get("c") or run.unreadable_reasons["c"]
    assert words in answer and len(answer) <= 400_001
    assert run.answers["a"] == "1" and run.answers["b"] == "2"
    assert run.end == "done" or name == "an endless iterator"  # two alarms may use up the time


PATCHES: list[str] = ATTACKS["patches"]["cells"]


@pytest.mark.parametrize("cell", sample_for_suite(PATCHES, 3))
def test_patches_affect_only_the_notebook_that_made_them(cell: str, machine: Machine) -> None:
    """`run_attack` runs an honest notebook afterwards; the answer before the patch counts, too."""
    run = run_attack(open_sandbox(), cell)
    assert run.answers["a"] == "1"
    assert run.end in ("done", "closed", "overtime", "killed", "crashed")


def test_a_notebook_finds_nothing_of_the_last_one_in_memory() -> None:
    """Look in frames, the garbage collector and the forking process for cells, answers and names of the last notebook."""
    with Sandbox(Limits(seconds=10, cell_seconds=8), {"watch"}) as sandbox:
        marker = "MARK" + "ER" * 3
        before = sandbox.run([f"a = 'x' + {marker!r}", f"b = '''{marker} and more'''"], ["a", marker.lower()])
        assert before.answers == {"a": "x" + marker}
        search = (
            "import gc, sys\nword = 'MARK' + 'ER' * 3\nseen = [o for o in gc.get_objects() if type(o) is dict]\n"
            "texts = [v for d in seen for v in list(d.values()) if type(v) is str]\n"
            "c = str(sum(word in t and t != word for t in texts))\nf, names = sys._getframe(), []\n"
            "while f: names += [repr(v) for v in f.f_locals.values() if type(v) in (str, bytes)]; f = f.f_back\n"
            "b = str(sum(word in n and n != repr(word) for n in names))"
        )
        run = sandbox.run([search], ["b", "c"])
        assert run.answers == {"b": "0", "c": "0"}, run
        for pid in idle_processes(sandbox):
            with contextlib.suppress(PermissionError):  # an ordinary user may not read it
                words = (b"MAX_REPORT_BYTES", b"die_with_parent", marker.encode())
                seen = {word for region in read_memory(pid) for word in words if word in region}
                assert seen & set(words[:2])
                assert marker.encode() not in seen


def test_the_death_of_a_waiting_process_costs_no_answer() -> None:
    """If a machine runs out of memory between two notebooks, the caller runs the second one again."""
    with Sandbox(Limits(seconds=10, cell_seconds=8)) as sandbox:
        assert sandbox.run([], []).end == "done"
        os.kill(max(idle_processes(sandbox)), signal.SIGKILL)
        first, second = (sandbox.run(HONEST, ["h"]) for _ in range(2))
        assert (first.end, first.answers) == ("not-started", {})
        assert (second.end, second.answers) == ("done", {"h": "2*sin(x)*cos(x)"})


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets one process set another's limits")
def test_a_failed_fork_of_the_next_process_costs_no_answer() -> None:
    with Sandbox(Limits(seconds=10, cell_seconds=8)) as sandbox:
        assert sandbox.run([], []).end == "done"
        forking, *_ = sorted(idle_processes(sandbox) - {sandbox._process.pid if sandbox._process else 0})
        resource.prlimit(forking, resource.RLIMIT_NOFILE, (4, 4))  # from now on it gets no pipes
        assert sandbox.run(HONEST, ["h"]).answers == {"h": "2*sin(x)*cos(x)"}
        time.sleep(0.5)
        runs = [sandbox.run(HONEST, ["h"]) for _ in range(2)]
        assert [run.end for run in runs] in (["not-started", "done"], ["done", "done"])
        assert runs[-1].answers == {"h": "2*sin(x)*cos(x)"}


def read_memory(pid: int) -> Iterator[bytes]:
    """Yield the readable regions of a process's writable memory."""
    with Path(f"/proc/{pid}/mem").open("rb", 0) as memory:
        for line in Path(f"/proc/{pid}/maps").read_text().splitlines():
            span, rights, *_ = line.split()
            first, end = (int(address, 16) for address in span.split("-"))
            if rights.startswith("rw") and "[v" not in line:
                with contextlib.suppress(OSError, OverflowError):
                    memory.seek(first)
                    yield memory.read(end - first)


def native_attacks(machine: Machine) -> dict[str, tuple[str, str]]:
    """Return attacks by name, each with the guarantee that it tries to break; it sets `c` if it succeeds."""
    secret, solution = map(str, list(machine.files)[:2])
    daemon = (
        "pid = os.fork()\nif pid == 0:\n    os.setsid()\n    if os.fork() == 0:\n        import time\n"
        "        for i in range(100):\n            time.sleep(0.05)\n"
        f"            open({str(machine.folder / 'late')!r}, 'w').write('x')\n    os._exit(0)\n"
    )
    libc = (
        "import ctypes\nlibc = ctypes.CDLL(None, use_errno=True)\ndef ok(r):\n    if r < 0: raise OSError('refused')\n"
    )
    return {
        "reads the secret": ("files", f"c = open({secret!r}).read()"),
        "reads another submission natively": ("files", f"{libc}fd = libc.open({solution.encode()!r}, 0); ok(fd); c = os.read(fd, 99)"),
        "lists a folder": ("files", f"c = str(os.listdir({str(machine.folder)!r}))"),
        "writes a solution": ("files", f"open({solution!r}, 'a').write('x'); c = 1"),
        "removes a submission": ("files", f"os.remove({solution!r}); c = 1"),
        "renames a submission": ("files", f"os.rename({solution!r}, {solution + '2'!r}); c = 1"),
        "makes the secret public": ("files", f"os.chmod({secret!r}, 0o777); c = 1"),
        "changes a time": ("files", f"os.utime({secret!r}, (0, 0)); c = 1"),
        "truncates": ("files", f"os.truncate({secret!r}, 0); c = 1"),
        "links to the secret": ("files", f"os.symlink({secret!r}, 'l'); c = open('l').read()"),
        "links hard": ("files", f"os.link({secret!r}, 'l'); c = open('l').read()"),
        "closes a library": ("files", "f = os.open(os.__file__, 0); os.fchmod(f, os.fstat(f).st_mode & 0o7777); c = 1"),
        "gives a library attributes": ("files", "f = os.open(os.__file__, 0); os.setxattr(f, 'user.qdot', b'x'); c = 1; os.removexattr(f, 'user.qdot')"),
        "flags a library": ("files", "import fcntl; f = os.open(os.__file__, 0); fcntl.ioctl(f, 0x40086602, fcntl.ioctl(f, 0x80086601, bytes(8))); c = 1"),
        "flags a library by its path": ("files", f"{libc}ok(libc.syscall(469, -100, os.__file__.encode(), bytes(24), 24, 0)); c = 1"),  # file_setattr, of Linux 6.17
        "reads the grader's environment": ("files", "c = open('/proc/%d/environ' % (os.getppid() or 1)).read()"),
        "climbs out by a descriptor": ("files", f"os.chdir('/proc/1/root'); c = open({secret!r}).read()"),
        "connects": ("network", f"import socket; socket.create_connection(('127.0.0.1', {machine.port}), 1); c = 1"),
        "connects to an abstract socket": ("network", f"import socket; socket.socket(socket.AF_UNIX).connect({machine.abstract!r}); c = 1"),
        "starts a daemon": ("processes", daemon),
        "starts a program": ("processes", f"os.spawnv(os.P_NOWAIT, {sys.executable!r}, ['x', '-c', 'while 1: pass'])"),
        "forks without end": ("processes", "while True:\n    try: os.fork()\n    except OSError: break"),
        "kills its parent": ("processes", "os.kill(os.getppid() or -1, 9); c = 1"),
        "traces the parent": ("processes", f"{libc}ok(libc.ptrace(0x4206, os.getppid() or 99999, 0, 0)); c = 1"),
        "takes memory": ("memory", "import mmap; m = mmap.mmap(-1, 3 << 30); c = 1"),
        "takes timers": ("memory", f"{libc}t = ctypes.c_int()\nfor i in range(20_000): ok(libc.timer_create(1, None, ctypes.byref(t)))\nc = 1"),
        "raises its limits": ("memory", "import resource as r; r.setrlimit(r.RLIMIT_AS, (-1, -1)); c = 1"),
        "becomes root": ("privileges", f"{libc}ok(libc.unshare(0x10000000)); c = 1"),
        "changes root": ("privileges", "os.chroot('.'); c = 1"),
    }  # fmt: skip


@pytest.mark.parametrize("variant", select_for_suite(FEW[:1], tuple(VARIANTS)))
def test_the_kernel_keeps_its_guarantees_without_the_hook(variant: str, machine: Machine) -> None:
    without = frozenset(VARIANTS[variant])
    enforcement = {guarantee.name: guarantee.enforcement for guarantee in probe_without(without).guarantees}
    sandbox = open_sandbox(without)
    tried = 0
    for name, (guarantee, cell) in native_attacks(machine).items():
        if enforcement[guarantee] != ENFORCED_BY_KERNEL:
            continue  # not promised here: see test_the_probe_reports_each_level_of_enforcement
        run = run_attack(sandbox, cell)
        assert "c" not in run.answers and "c" not in run.unreadable_reasons, (name, run)
        assert run.answers.get("a") == "1", (name, run)
        tried += 1
    assert tried >= (0 if probe_without(frozenset()).lacking else FEWEST_PREVENTED.get(variant, 0))


def test_the_hook_alone_refuses_attacks_in_python(machine: Machine) -> None:
    sandbox = open_sandbox(frozenset(measures_other_than_hook()))
    for name, (guarantee, cell) in native_attacks(machine).items():
        if guarantee in ("files", "network", "processes") and name != "climbs out by a descriptor":
            run = run_attack(sandbox, cell)
            assert run.answers == {"a": "1", "b": "2"} and "c" not in run.unreadable_reasons, (name, run)
            if name != "forks without end":  # the attack catches the error
                assert "may not" in run.cell_errors[1], (name, run)


SHARED_RESOURCES = {
    "has whoever would write a library wait": "fcntl.fcntl(os.open(os.__file__, 0), fcntl.F_SETLEASE, fcntl.F_RDLCK)",
    "takes asynchronous input, of which the machine has so much": (
        f"assert ctypes.CDLL(None).syscall({206 * (platform.machine() == 'x86_64')}, 9, ctypes.byref(ctypes.c_ulong())) == 0"
    ),
}  # fmt: skip
"""Attacks that only the system-call filter refuses; the first works if the notebook's user owns the library."""


@pytest.mark.parametrize("name", SHARED_RESOURCES)
@pytest.mark.parametrize("variant", ["everything", "no namespaces"])
def test_shared_resources_of_the_machine_are_refused(name: str, variant: str, machine: Machine) -> None:
    if "seccomp" in probe_without(frozenset()).lacking:
        pytest.skip("nothing else refuses it")
    sandbox = open_sandbox(frozenset(VARIANTS[variant] | {"user"}))
    run = run_attack(sandbox, f"import ctypes, fcntl\n{SHARED_RESOURCES[name]}\nc = 1")
    assert run.answers == {"a": "1", "b": "2"} and list(run.cell_errors) == [1], run


@pytest.mark.parametrize(
    ("variant", "event"),
    sample_for_suite(
        [
            ("everything", "the grader ends"),
            ("rlimits only", "the grader ends"),
            ("everything", "its process is killed"),
        ],
        1,
    ),
)
def test_closing_a_sandbox_ends_its_running_notebook(variant: str, event: str, machine: Machine) -> None:
    sandbox = Sandbox(Limits(seconds=20, cell_seconds=20), VARIANTS[variant])
    sandbox.run([], [])
    forks = (
        "import os, time\nfor i in range(5):\n    try:\n        if os.fork() == 0: os.setsid(); time.sleep(60)\n"
        "    except OSError: pass\ntime.sleep(60)"
    )
    started = threading.Event()
    request = {"cells": ["a = 1", forks], "names": ["a"], "cell_seconds": 20, "arguments": {}}
    thread = threading.Thread(target=sandbox.exchange, args=(request, lambda _: started.set()))
    thread.start()
    assert started.wait(10)
    time.sleep(0.2)
    deadline = time.monotonic() + 10
    pids, control = sandbox_processes(sandbox), sandbox._control
    assert control is not None and sandbox._process is not None
    if event == "the grader ends":
        control.shutdown(socket.SHUT_RDWR)
    else:
        sandbox._process.kill()
    thread.join()
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.02)
    sandbox.close()
    assert len(pids) > 1
    assert not [pid for pid in pids if Path(f"/proc/{pid}").exists()]


def test_the_probe_reports_each_level_of_enforcement() -> None:
    full_findings = probe_without(frozenset())
    enforcement = {guarantee.name: guarantee.enforcement for guarantee in full_findings.guarantees}
    assert enforcement["time"] == ENFORCED_BY_KERNEL
    assert full_findings.is_strict or full_findings.lacking
    unprotected = probe_without(frozenset({*measures_other_than_hook(), "limits", "watch"}))
    assert not unprotected.is_strict
    assert {guarantee.name: guarantee.enforcement for guarantee in unprotected.guarantees if guarantee.name in ("files", "network")} == {
        "files": NOT_ENFORCED, "network": NOT_ENFORCED
    }  # fmt: skip
    watched = probe_without(frozenset(measures_other_than_hook()))
    assert {guarantee.name: guarantee.enforcement for guarantee in watched.guarantees if guarantee.name in ("files", "network")} == {
        "files": WATCHED_IN_PYTHON, "network": WATCHED_IN_PYTHON
    }  # fmt: skip
    assert [guarantee.name for guarantee in watched.guarantees] == list(PROMISES)
