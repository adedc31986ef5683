"""Notebooks that attack: each has its exact verdict, costs itself only, leaks nothing, changes nothing, leaves nothing.

Every attack runs between two answers; after it, an honest notebook in the same sandbox gets all right. Attacks by native
calls run with the audit hook off, on this machine's means and on what is left with single ones switched off: what the
kernel then still guarantees, by the probe, must hold.
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
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.grader.sandbox.guarantees import (
    ENFORCED_BY_KERNEL,
    GUARANTEES,
    NOT_ENFORCED,
    WATCHED_IN_PYTHON,
    Findings,
    probe,
)
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from tests.support.suites import WHOLE, sample_for_suite, select_for_suite

pytestmark = pytest.mark.xdist_group("hostile")  # each sandbox is tried once

HONEST = ["from sympy import *\nx = symbols('x')", "h = diff(sin(x)**2, x)", "import numpy as np; g = np.ones(2)"]
NAMES = ["a", "b", "c"]
VARIANTS = {
    "everything": {"watch"}, "no namespaces": {"watch", "namespaces"}, "no Landlock": {"watch", "landlock"},
    "no seccomp": {"watch", "seccomp"}, "Landlock only": {"watch", "namespaces", "seccomp"},
    "namespaces only": {"watch", "landlock", "seccomp"}, "rlimits only": {"watch", "namespaces", "landlock", "seccomp"},
}  # fmt: skip

LEAST = {"everything": 29, "no namespaces": 29, "no Landlock": 29, "no seccomp": 26, "namespaces only": 17}
"""How many attacks are promised to fail where a machine has everything else; without seccomp and namespaces, none."""

FEW = ("everything", "no namespaces")
"""What `make test` tries: each measure is left in one of them that lacks another."""


def hook_only() -> set[str]:
    """What is switched off so that nothing but the audit hook and rlimits are left, as on macOS."""
    return {"namespaces", "landlock", "seccomp", "user", "privileges"}


OPEN: dict[frozenset[str], Sandbox] = {}


def sandbox_of(without: frozenset[str] = frozenset()) -> Sandbox:
    if without not in OPEN:
        OPEN[without] = Sandbox(Limits(seconds=3, cell_seconds=0.8, memory=1 << 30), without)
    return OPEN[without]


@functools.cache
def findings_of(without: frozenset[str]) -> Findings:
    return probe(without, quick=True)


@pytest.fixture(scope="module", autouse=True)
def closed() -> Iterator[None]:
    yield
    while OPEN:
        OPEN.popitem()[1].close()


class Machine:
    """What there is to be harmed: other students' work, a secret, an open port, an abstract socket."""

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
        listed = sorted(tmp_path.rglob("*"))
        yield machine
        for each in (server, local):
            each.setblocking(False)
            with pytest.raises(BlockingIOError):
                each.accept()
    assert sorted(tmp_path.rglob("*")) == listed
    for path, before in machine.files.items():
        assert (path.read_text(), path.stat().st_mtime_ns, path.stat().st_mode) == before


def running(sandbox: Sandbox) -> list[int]:
    """The processes of a sandbox, by what they were started with; forks have it, too."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if sandbox._folder and sandbox._folder.path.encode() in (path / "cmdline").read_bytes():
                found.append(int(path.name))
    return found


def idle_of(sandbox: Sandbox) -> set[int]:
    """The processes of a sandbox in which nothing runs, once all is tidied up: the last of them waits for a notebook."""
    assert not sandbox.has_left_processes
    usual, deadline = 2 if "namespaces" in sandbox.unavailable_measures else 3, time.monotonic() + 3
    while len(found := running(sandbox)) != usual and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(found) == usual
    return set(found)


def attacked(sandbox: Sandbox, cell: str) -> Run:
    """Run an attack between two answers, then an honest notebook; see that nothing is left of the attack."""
    if not running(sandbox):
        assert sandbox.run(["import os"], []).end == "done"
    idle = idle_of(sandbox)
    run = sandbox.run(["import os\na = 1", cell, "b = 2"], NAMES)
    assert "CANARY" not in repr(run)
    honest = sandbox.run(HONEST, ["h", "g"])
    assert honest.answers == {"h": "2*sin(x)*cos(x)", "g": "[1.0, 1.0]"} and honest.end == "done"
    left = idle_of(sandbox)
    if run.end != "lost":
        assert len(left - idle) == 1  # every notebook has a process of its own, and the others stay
    return run


GOES_ON = {
    "endless": ("while True: pass", "longer than 0.8 s"),
    "asleep": ("import time; time.sleep(60)", "it waited longer than 0.8 s"),
    "swallows everything": ("while True:\n    try:\n        while True: pass\n    except Exception: pass", "longer than 0.8 s"),
    "memory": ("import mmap\nx = []\nwhile True: x.append(mmap.mmap(-1, 10**8))", "Cannot allocate memory"),
    "memory in NumPy": ("import numpy; numpy.ones(10**11)", "MemoryError"),
    "threads": ("import threading\ndef f(): time.sleep(9)\nimport time\nfor i in range(10**4): threading.Thread(target=f).start()",
                "can't start new thread"),
    "forks": ("while True: os.fork()", "may not use os.fork"),
    "sys.exit": ("import sys; sys.exit(0)", "the cell called exit()"),
    "kills its parent": ("os.kill(os.getppid(), 9)", "may not use os.kill"),
    "kills everybody": ("os.kill(-1, 9)", "may not use os.kill"),
    "kills its group": ("os.killpg(0, 9)", "may not use os.killpg"),
    "starts a program": ("import subprocess; subprocess.Popen(['sleep', '60'])", "may not use subprocess.Popen"),
    "becomes a program": ("os.execv('/bin/sleep', ['sleep', '60'])", "may not use os.exec"),
    "collects garbage": ("import gc; gc.get_objects()", "may not use gc.get_objects"),
    "fills the disk": ("for i in range(100): open(str(i), 'wb').write(bytes(9_000_000))", "OSError: [Errno 28]"),
    "a large file": ("open('x', 'wb').write(bytes(20_000_000))", "OSError: [Errno 27]"),
    "environment of init": ("c = open('/proc/1/environ').read()", "may not open '/proc/1/environ'"),
    "own memory": ("c = open('/proc/self/maps').read()", "may not open '/proc/self/maps'"),
    "accounts": ("c = open('/etc/passwd').read()", "may not open '/etc/passwd'"),
    "raises what is no Exception": ("raise BaseException('no')", "BaseException"),
    "calls itself": ("def f(): f()\nf()", "RecursionError"),
    "a list without end": ("x = [0] * 10**11", "MemoryError"),
    "exit()": ("exit()", "exit"),
    "an exception that fights back": ("class E(Exception):\n    def __str__(self): raise SystemError\nraise E", "can't be shown"),
    "a class with a trap": ("class E(BaseException):\n    def __str__(self): os._exit\n    __repr__ = __str__\nraise E",
                            "an exception that can't be shown"),
}  # fmt: skip


@pytest.mark.parametrize("name", sample_for_suite(GOES_ON, 12))
def test_an_attack_ends_with_its_cell(name: str, machine: Machine) -> None:
    cell, said = GOES_ON[name]
    sandbox = sandbox_of()
    run = attacked(sandbox, cell)
    if name == "fills the disk" and "namespaces" in sandbox.unavailable_measures:
        return  # no file system of its own: what it wrote is gone, and no file was larger than 10 MB
    assert run.answers == {"a": "1", "b": "2"} and run.end == "done"
    assert list(run.cell_errors) == [1] and said in run.cell_errors[1]


ENDS = {
    "endless in C": ("sum(range(10**12))", {"overtime", "killed"}),
    "endless with signals ignored": (
        "import signal\nfor s in (signal.SIGALRM, signal.SIGPROF): signal.signal(s, signal.SIG_IGN)\nwhile True: pass",
        {"overtime", "killed"},
    ),
    "endless, catching all": (
        "while True:\n    try:\n        while True: pass\n    except BaseException: pass",
        {"overtime", "killed", "done"},
    ),
    "_exit": ("os._exit(0)", {"closed"}),
    "abort": ("os.abort()", {"crashed"}),
    "deep recursion": (
        "import sys\nsys.setrecursionlimit(10**9)\nl = []\nfor i in range(10**6): l = [l]\nrepr(l)",
        {"crashed", "done"},
    ),
    "floods its report": ("for fd in range(3, 64):\n    try: os.write(fd, b'{}\\n' * 40_000_000)\n    except OSError: pass",
                          {"closed", "done", "overtime"}),  # overtime where a machine is slow to write 120 MB
    "closes its report": ("os.closerange(3, 64)", {"closed"}),
    "says that it is done": ("for fd in range(3, 64):\n    try: os.write(fd, b'{\"done\": true}\\n')\n    except OSError: pass",
                             {"done"}),
}  # fmt: skip


@pytest.mark.parametrize("name", sample_for_suite([name for name in ENDS if WHOLE or "signals ignored" not in name], 2))
def test_an_attack_that_ends_the_notebook_keeps_the_answers_before(name: str, machine: Machine) -> None:
    """What ignores signals is in `make test`, too: in test_sandbox.py."""
    (cell, ends), ended = ENDS[name], ("it took longer", "it waited longer")
    run = attacked(sandbox_of(), cell)
    assert run.end in ends, run
    if run.end == "done" and name != "says that it is done":  # the alarm was faster, or Python counts the depth in C
        assert run.answers["b"] == "2"
        # A flood that the alarm cuts within a line spoils the next one, which tells of the alarm: nobody else's.
        assert run.cell_errors.get(1, ended[0] if name == "floods its report" else "").startswith(
            ("RecursionError", *ended)
        )
        return
    assert run.answers == {"a": "1"} and run.cell_errors == {}
    assert bool(run.describe_end()) == (run.end != "done")


LIES = {
    "an object that says it is a text": ("class L:\n    __class__ = str\n    def __str__(self): return 'x'\nc = L()", "a L is not an expression"),
    "an object that says it is a type": ("class L:\n    __class__ = type\n    def __str__(self): return 'x'\nc = L()", "a L is not an expression"),
    "an object whose class is none": ("class L:\n    __class__ = 5\n    def __str__(self): return 'x'\nc = L()", "a L is not an expression"),
    "a text whose slice is something else": ("class L(str):\n    def __getitem__(self, k): return {}\nc = L('right')", "right"),
    "a text that is another each time": ("class L(str):\n    def __str__(self): return str(id([]))\nc = L('right')", "right"),
    "a list that is never the same": ("class L(list):\n    def __iter__(self):\n        self.append(1)\n        return iter([len(self)])\nc = L()", "["),
    "a pickle": ("import pickle\nclass L:\n    def __reduce__(self): return (os._exit, (0,))\nc = pickle.dumps(L())", "a bytes is not"),
    "an object with __reduce__": ("class L:\n    def __reduce__(self): return (os._exit, (0,))\nc = L()", "a L is not an expression"),
    "a type that always is": ("class M(type):\n    def __instancecheck__(c, o): return True\nclass L(metaclass=M): pass\nc = L", "a M is not an expression"),
    "an endless iterator": ("class L(list):\n    def __iter__(self):\n        while True: yield 1\nc = L([1])", "longer than"),
    "an answer of 100 MB": ("c = 'x' * 10**8", "x" * 1000),
    "100 MB of output": ("for i in range(100): print('x' * 10**6)\nc = '0'", "0"),
}  # fmt: skip


@pytest.mark.parametrize("name", sample_for_suite(LIES, 6))
def test_an_answer_that_lies_is_a_text_or_none(name: str, machine: Machine) -> None:
    cell, words = LIES[name]
    run = attacked(sandbox_of(), cell)
    answer = run.answers.get("c") or run.unreadable_reasons["c"]
    assert words in answer and len(answer) <= 400_001
    assert run.answers["a"] == "1" and run.answers["b"] == "2"
    assert run.end == "done" or name == "an endless iterator"  # two alarms may be all the time that there is


PATCHES = [
    "import builtins; builtins.isinstance = lambda *a: True",
    "import builtins; builtins.str = builtins.repr = lambda *a: 'right'",
    "import sympy; sympy.Basic.__eq__ = sympy.Basic.__hash__ = sympy.Basic.__str__ = lambda *a: True",
    "import sympy.printing.str as p; p.StrPrinter.doprint = lambda *a: 'right'",
    "import numpy; numpy.ndarray = numpy.generic = object; numpy.ones = None",
    "import sys\nclass F:\n    def find_spec(*a): os._exit(0)\nsys.meta_path.insert(0, F())",
    'import json; json.dumps = lambda *a: \'{"end": "done"}\'',
    "import sys; sys.modules.clear()",
    "import os; os.write = os.read = lambda *a: 0",
    "import IPython; IPython.get_ipython().run_cell('1')",
    "import os\nfor i in range(3000): os.write(3, b'\\n' * 1000); os.write(4, b'\\n' * 1000)",  # acknowledged by nobody
    "import sys\nf = sys._getframe()\nwhile f: f.f_locals.clear() if f.f_locals is not globals() else 0; f = f.f_back",
]


@pytest.mark.parametrize("cell", sample_for_suite(PATCHES, 3))
def test_whatever_is_patched_is_patched_for_the_one_who_did_it(cell: str, machine: Machine) -> None:
    """The honest notebook after it gets everything right (see `attacked`); so do the answers before."""
    run = attacked(sandbox_of(), cell)
    assert run.answers["a"] == "1"
    assert run.end in ("done", "closed", "overtime", "killed", "crashed")


def test_nothing_of_another_student_is_in_the_memory_that_a_notebook_starts_with() -> None:
    """Frames, garbage collector, and the process that forks: no cell, answer or name of the notebook before."""
    with Sandbox(Limits(seconds=10, cell_seconds=8), {"watch"}) as sandbox:
        marker = "MARK" + "ER" * 3
        before = sandbox.run([f"a = 'x' + {marker!r}", f"b = '''{marker} and more'''"], ["a", marker.lower()])
        assert before.answers == {"a": "x" + marker}
        look = (
            "import gc, sys\nword = 'MARK' + 'ER' * 3\nseen = [o for o in gc.get_objects() if type(o) is dict]\n"
            "texts = [v for d in seen for v in list(d.values()) if type(v) is str]\n"
            "c = str(sum(word in t and t != word for t in texts))\nf, names = sys._getframe(), []\n"
            "while f: names += [repr(v) for v in f.f_locals.values() if type(v) in (str, bytes)]; f = f.f_back\n"
            "b = str(sum(word in n and n != repr(word) for n in names))"
        )
        found = sandbox.run([look], ["b", "c"])
        assert found.answers == {"b": "0", "c": "0"}, found
        for pid in idle_of(sandbox):
            with contextlib.suppress(PermissionError):  # an ordinary user may not look
                known = (b"LONGEST_REPORT", b"die_with_parent", marker.encode())
                seen = {word for region in memory_of(pid) for word in known if word in region}
                assert seen & set(known[:2])
                assert marker.encode() not in seen


def test_a_process_that_dies_while_it_waits_for_a_notebook_costs_nobody_an_answer() -> None:
    """The machine may be short of memory while the notebook before is marked: the next one is run again."""
    with Sandbox(Limits(seconds=10, cell_seconds=8)) as sandbox:
        assert sandbox.run([], []).end == "done"
        os.kill(max(idle_of(sandbox)), signal.SIGKILL)
        first, second = (sandbox.run(HONEST, ["h"]) for _ in range(2))
        assert (first.end, first.answers) == ("unbegun", {})
        assert (second.end, second.answers) == ("done", {"h": "2*sin(x)*cos(x)"})


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets one process set another's limits")
def test_a_process_that_can_not_be_made_ahead_costs_nobody_an_answer() -> None:
    with Sandbox(Limits(seconds=10, cell_seconds=8)) as sandbox:
        assert sandbox.run([], []).end == "done"
        forking, *_ = sorted(idle_of(sandbox) - {sandbox._process.pid if sandbox._process else 0})
        resource.prlimit(forking, resource.RLIMIT_NOFILE, (4, 4))  # from now on it gets no pipes
        assert sandbox.run(HONEST, ["h"]).answers == {"h": "2*sin(x)*cos(x)"}
        time.sleep(0.5)
        runs = [sandbox.run(HONEST, ["h"]) for _ in range(2)]
        assert [run.end for run in runs] in (["unbegun", "done"], ["done", "done"])
        assert runs[-1].answers == {"h": "2*sin(x)*cos(x)"}


def memory_of(pid: int) -> Iterator[bytes]:
    """The regions of a process's writable memory, where this one may read it."""
    with Path(f"/proc/{pid}/mem").open("rb", 0) as memory:
        for line in Path(f"/proc/{pid}/maps").read_text().splitlines():
            span, rights, *_ = line.split()
            first, end = (int(at, 16) for at in span.split("-"))
            if rights.startswith("rw") and "[v" not in line:
                with contextlib.suppress(OSError, OverflowError):
                    memory.seek(first)
                    yield memory.read(end - first)


def native(machine: Machine) -> dict[str, tuple[str, str]]:
    """Attacks, each with the guarantee that it is against: `c` is set where it succeeds."""
    secret, other = map(str, list(machine.files)[:2])
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
        "reads another submission natively": ("files", f"{libc}fd = libc.open({other.encode()!r}, 0); ok(fd); c = os.read(fd, 99)"),
        "lists a folder": ("files", f"c = str(os.listdir({str(machine.folder)!r}))"),
        "writes a solution": ("files", f"open({other!r}, 'a').write('x'); c = 1"),
        "removes a submission": ("files", f"os.remove({other!r}); c = 1"),
        "renames a submission": ("files", f"os.rename({other!r}, {other + '2'!r}); c = 1"),
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
def test_what_the_kernel_guarantees_holds_without_the_hook(variant: str, machine: Machine) -> None:
    without = frozenset(VARIANTS[variant])
    by = {guarantee.name: guarantee.by for guarantee in findings_of(without).guarantees}
    sandbox = sandbox_of(without)
    tried = 0
    for name, (guarantee, cell) in native(machine).items():
        if by[guarantee] != ENFORCED_BY_KERNEL:
            continue  # not promised here: see test_the_levels_are_told_as_they_are
        run = attacked(sandbox, cell)
        assert "c" not in run.answers and "c" not in run.unreadable_reasons, (name, run)
        assert run.answers.get("a") == "1", (name, run)
        tried += 1
    assert tried >= (0 if findings_of(frozenset()).lacking else LEAST.get(variant, 0))


def test_the_hook_alone_refuses_what_python_code_tries(machine: Machine) -> None:
    sandbox = sandbox_of(frozenset(hook_only()))
    for name, (guarantee, cell) in native(machine).items():
        if guarantee in ("files", "network", "processes") and name != "climbs out by a descriptor":
            run = attacked(sandbox, cell)
            assert run.answers == {"a": "1", "b": "2"} and "c" not in run.unreadable_reasons, (name, run)
            if name != "forks without end":  # it takes being refused for being done
                assert "may not" in run.cell_errors[1], (name, run)


SHARED = {
    "has whoever would write a library wait": "fcntl.fcntl(os.open(os.__file__, 0), fcntl.F_SETLEASE, fcntl.F_RDLCK)",
    "takes asynchronous input, of which the machine has so much": (
        f"assert ctypes.CDLL(None).syscall({206 * (platform.machine() == 'x86_64')}, 9, ctypes.byref(ctypes.c_ulong())) == 0"
    ),
}  # fmt: skip
"""What only the filter of system calls refuses, the first where a notebook's user owns the library."""


@pytest.mark.parametrize("name", SHARED)
@pytest.mark.parametrize("variant", ["everything", "no namespaces"])
def test_what_a_machine_shares_is_not_taken(name: str, variant: str, machine: Machine) -> None:
    if "seccomp" in findings_of(frozenset()).lacking:
        pytest.skip("nothing else refuses it")
    sandbox = sandbox_of(frozenset(VARIANTS[variant] | {"user"}))
    run = attacked(sandbox, f"import ctypes, fcntl\n{SHARED[name]}\nc = 1")
    assert run.answers == {"a": "1", "b": "2"} and list(run.cell_errors) == [1], run


@pytest.mark.parametrize(
    ("variant", "how"),
    sample_for_suite(
        [
            ("everything", "the grader ends"),
            ("rlimits only", "the grader ends"),
            ("everything", "its process is killed"),
        ],
        1,
    ),
)
def test_a_sandbox_that_is_closed_while_a_notebook_runs_leaves_nothing(
    variant: str, how: str, machine: Machine
) -> None:
    sandbox = Sandbox(Limits(seconds=20, cell_seconds=20), VARIANTS[variant])
    sandbox.run([], [])
    forks = (
        "import os, time\nfor i in range(5):\n    try:\n        if os.fork() == 0: os.setsid(); time.sleep(60)\n"
        "    except OSError: pass\ntime.sleep(60)"
    )
    begun = threading.Event()
    request = {"cells": ["a = 1", forks], "names": ["a"], "cell_seconds": 20, "calls": {}}
    thread = threading.Thread(target=sandbox.exchange, args=(request, lambda _: begun.set()))
    thread.start()
    assert begun.wait(10)
    time.sleep(0.2)
    deadline = time.monotonic() + 10
    family, control = running(sandbox), sandbox._control
    assert control is not None and sandbox._process is not None
    if how == "the grader ends":
        control.shutdown(socket.SHUT_RDWR)
    else:
        sandbox._process.kill()
    thread.join()
    while any(Path(f"/proc/{pid}").exists() for pid in family) and time.monotonic() < deadline:
        time.sleep(0.02)
    sandbox.close()
    assert len(family) > 1
    assert not [pid for pid in family if Path(f"/proc/{pid}").exists()]


def test_the_levels_are_told_as_they_are() -> None:
    all_of_it = findings_of(frozenset())
    assert {g.name: g.by for g in all_of_it.guarantees}["time"] == ENFORCED_BY_KERNEL
    assert all_of_it.is_strict or all_of_it.lacking
    nothing = findings_of(frozenset({*hook_only(), "limits", "watch"}))
    assert not nothing.is_strict
    assert {g.name: g.by for g in nothing.guarantees if g.name in ("files", "network")} == {
        "files": NOT_ENFORCED, "network": NOT_ENFORCED
    }  # fmt: skip
    watched = findings_of(frozenset(hook_only()))
    assert {g.name: g.by for g in watched.guarantees if g.name in ("files", "network")} == {
        "files": WATCHED_IN_PYTHON, "network": WATCHED_IN_PYTHON
    }  # fmt: skip
    assert [g.name for g in watched.guarantees] == list(GUARANTEES)
