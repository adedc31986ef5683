"""Attacks inside bubblewrap and inside qdot's sandbox, side by side: whatever bubblewrap holds, ours is to hold.

    python -m tests.tools.jails            # run them, as root: jails.json, and the table in docs/sandbox.md (minutes)
    python -m tests.tools.jails show       # the table of the last run, all rows of it

Each attack runs without any jail, too: what does not succeed there has shown nothing. bubblewrap is set up as a careful
administrator would: all namespaces, no more of them inside, no capabilities, a file system of 64 MB, nothing else to
write to, limits of resources, a clock. Ours runs with the audit hook off, so that the kernel's measures are compared:
all of them, and those where namespaces are refused. Both are run as root and as an ordinary user.
"""

import argparse
import contextlib
import ctypes
import datetime
import json
import os
import platform
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from exercises.files import write_atomically
from grader.contained import guard
from grader.sandbox import Limits, Sandbox
from tests.support import ROOT
from tests.support.machines import NOBODY, run_on
from tests.tools.jailed import ATTACKS, PRELUDE

RECORD = Path(__file__).with_suffix(".json")
DOCUMENT = ROOT / "docs" / "sandbox.md"
BEGIN, END = "<!-- from tests/tools/jails.json, by `python -m tests.tools.jails` -->", "<!-- end -->"

SECONDS, PATIENCE, MEMORY = 3, 8, 1 << 30
"""Processor time and memory that an attack may have; seconds on the clock after which it is stopped."""

BARE, BUBBLEWRAP, OURS, PLAIN = "no jail", "bubblewrap", "qdot", "qdot without namespaces"
USERS = {"root": 0, "an ordinary user": NOBODY}

VICTIM = """
import ctypes, sys, time
word = ctypes.create_string_buffer(b"CANARY in memory")
print(ctypes.addressof(word), flush=True)
time.sleep(600)
"""


class Machine:
    """What there is to be harmed, and what was: a submission, a library, sockets, a process in the grader's place."""

    def __init__(self, work: Path) -> None:
        self.work = work
        self.file, self.open, self.library = work / "s02" / "hw.ipynb", work / "open", work / "lib" / "library.py"
        for path in (self.file, self.library, self.open / "there"):
            path.parent.mkdir(parents=True, exist_ok=True)
        self.open.chmod(0o777)
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("127.0.0.1", 0))
        self.udp.setblocking(False)
        self.sockets = [
            socket.create_server(("127.0.0.1", 0)),
            socket.socket(socket.AF_UNIX),
            socket.socket(socket.AF_UNIX),
        ]
        self.abstract = f"\0qdot-jails-{os.getpid()}"
        self.sockets[1].bind(self.abstract)
        self.sockets[2].bind(str(work / "socket"))
        (work / "socket").chmod(0o777)
        for each in self.sockets[1:]:
            each.listen()
        self.victim: subprocess.Popen[str] | None = None
        self.restored()

    def restored(self) -> None:
        """Make what there is to be harmed as it was."""
        for path in (self.file, self.library):
            path.unlink(missing_ok=True)
            path.write_text("CANARY of a file")
            path.chmod(0o644)
            os.utime(path, (1e9, 1e9))
        (self.open / "planted").unlink(missing_ok=True)
        for path in [*self.work.rglob("qdot-left*"), *Path("/dev/shm").glob("qdot-left*"), *self.work.rglob("core*")]:
            with contextlib.suppress(OSError):
                path.unlink() if not path.is_dir() else subprocess.run(["rm", "-rf", path])
        libc = ctypes.CDLL(None)
        for make, control, arguments in (
            ("shmget", "shmctl", (4096, 0)),
            ("msgget", "msgctl", (0,)),
            ("semget", "semctl", (1, 0)),
        ):
            number = getattr(libc, make)(0x71646F74, *arguments)
            if number >= 0:
                getattr(libc, control)(number, *((0,) * (make == "semget")), 0, None)
        libc.syscall(241, b"qdot-left")
        for ring in (-3, -4, -5):
            key = libc.syscall(250, 10, ring, b"user", b"qdot-left", 0)
            if key > 0:
                libc.syscall(250, 3, key)  # revoked
                libc.syscall(250, 9, key, ring)
        if self.victim is None or self.victim.poll() is not None:
            self.victim = subprocess.Popen(
                [sys.executable, "-c", VICTIM, "CANARY of arguments"], stdout=subprocess.PIPE, text=True,
                env={"CANARY": "CANARY of the environment"}, start_new_session=True,
            )  # fmt: skip
            assert self.victim.stdout is not None
            self.address = int(self.victim.stdout.readline())

    def prey(self) -> dict[str, Any]:
        """Return what an attack is told of it."""
        assert self.victim is not None
        return {
            "file": str(self.file), "open": str(self.open), "library": str(self.library), "root": os.geteuid() == 0,
            "port": self.sockets[0].getsockname()[1], "udp": self.udp.getsockname()[1], "abstract": self.abstract,
            "socket": str(self.work / "socket"), "pid": self.victim.pid, "group": self.victim.pid,
            "address": self.address, "mark": "CANARY of arguments"[::-1], "name": socket.gethostname(),
        }  # fmt: skip

    def harm(self) -> Iterator[str]:
        """Say what an attack did that shows outside."""
        for path in (self.file, self.library):
            if not path.exists():
                yield f"{path.name} is gone"
            elif path.stat().st_mode & 0o777 != 0o644 or path.stat().st_mtime != 1e9:
                yield f"{path.name} is altered"
        if (self.open / "planted").exists():
            yield "a file was planted"
        if [*self.work.rglob("qdot-left*"), *Path("/dev/shm").glob("qdot-left*")]:
            yield "files are left"
        if [*self.work.rglob("core*")]:
            yield "a core dump is left"
        with contextlib.suppress(BlockingIOError):
            self.udp.recv(9)
            yield "a datagram arrived"
        yield from self._kept_by_the_kernel()
        time.sleep(0.1)
        for path in Path("/proc").glob("[0-9]*/comm"):
            with contextlib.suppress(OSError):
                if path.read_text() == "qdot-left\n" and ") Z" not in path.with_name("stat").read_text():
                    os.kill(int(path.parent.name), signal.SIGKILL)
                    yield "a process is left"
        assert self.victim is not None
        if self.victim.poll() is not None:
            yield "the grader is dead"

    def _kept_by_the_kernel(self) -> Iterator[str]:
        libc = ctypes.CDLL(None)
        if any(
            getattr(libc, make)(0x71646F74, *rest) >= 0
            for make, rest in (("shmget", (0, 0)), ("msgget", (0,)), ("semget", (0, 0)))
        ):
            yield "System V's objects are left"
        queue = libc.syscall(240, b"qdot-left", 0, 0, None)
        if queue >= 0:
            os.close(queue)
            yield "a message queue is left"
        if any(libc.syscall(250, 10, ring, b"user", b"qdot-left", 0) > 0 for ring in (-3, -4, -5)):
            yield "a key is left"

    def close(self) -> None:
        """End what was started for it."""
        assert self.victim is not None
        self.victim.kill()
        self.victim.wait()
        for each in (*self.sockets, self.udp):
            each.close()


def _bubblewrap(folder: Path, library: Path) -> list[str]:
    """Return how a careful administrator starts Python in bubblewrap."""
    shown = {os.path.realpath(path): path for path in (sys.base_prefix, sys.prefix, *guard.LIBRARIES)}
    tops = [path for path in shown if not any(path != other and path.startswith(f"{other}/") for other in shown)]
    bound = [
        text
        for path in tops
        if not path.startswith("/usr") and Path(path).exists()
        for text in ("--ro-bind", path, path)
    ]
    return [
        "bwrap", "--unshare-all", "--unshare-user", "--disable-userns", "--die-with-parent", "--new-session",
        "--uid", "65534", "--gid", "65534", "--cap-drop", "ALL", "--clearenv", "--setenv", "PATH", "/usr/bin",
        "--hostname", "jail",
        "--ro-bind", "/usr", "/usr", "--symlink", "usr/lib", "/lib", "--symlink", "usr/lib64", "/lib64",
        "--symlink", "usr/bin", "/bin", *bound, "--ro-bind", str(library), str(library),
        "--ro-bind", "/etc/ld.so.cache", "/etc/ld.so.cache", "--proc", "/proc",
        "--dev", "/dev", "--remount-ro", "/dev", "--size", "64000000", "--tmpfs", str(folder), "--chdir", str(folder),
        "--remount-ro", "/",
        "prlimit", f"--as={MEMORY}", f"--cpu={SECONDS}", "--nproc=64", "--fsize=10000000", "--nofile=64", "--core=0",
        "--",
    ]  # fmt: skip


def _in_a_program(command: list[str], folder: Path, prey: dict[str, Any], code: str) -> tuple[str, str]:
    """Run an attack as a program; return what it achieved, and how it ended otherwise."""
    source = f"P = {prey!r}\n{PRELUDE}\ndef done(what): print('DONE', what, flush=True)\n{code}"
    began = time.monotonic()
    with tempfile.TemporaryFile(dir=folder) as said:
        run = subprocess.Popen(
            ["timeout", "-s", "KILL", str(PATIENCE), *command, sys.executable, "-I", "-c", source], cwd=folder,
            stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT,
            env={**os.environ, "CANARY": "CANARY of the environment"} if not command else None,
        )  # fmt: skip
        run.wait()
        took = time.monotonic() - began
        said.seek(0)
        text = said.read().decode(errors="replace")
    achieved = " ".join(re.findall(r"(?m)^DONE (.*)$", text))
    if not achieved and not command and took >= PATIENCE:
        achieved = f"went on for {PATIENCE} s, until it was stopped"
    return achieved, (text.strip().splitlines() or [f"code {run.returncode}"])[-1]


def _in_ours(sandbox: Sandbox, prey: dict[str, Any], code: str) -> tuple[str, str]:
    source = f"P = {prey!r}\n{PRELUDE}\ndef done(what):\n    global c\n    c = 'DONE ' + repr(what)\n"
    began = time.monotonic()
    run = sandbox.run([source, code], ["c"])
    achieved = run.answers.get("c", "") or run.failures.get("c", "")
    if time.monotonic() - began > 2 * PATIENCE:
        achieved = achieved or "went on"
    if sandbox.left_running:
        achieved += " left a process running"
    return achieved, run.cell_errors.get(0) or run.cell_errors.get(1) or run.note()


def compare(only: str) -> dict[str, Any]:
    """Run every attack in every jail as this user; return, by both, what was achieved, and how it was refused."""
    found: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory(prefix="qdot-jails-") as name:
        work = Path(name)
        work.chmod(0o755)
        tempfile.tempdir = name
        machine = Machine(work)
        os.environ["LD_LIBRARY_PATH"] = str(machine.library.parent)
        os.environ["CANARY"] = "CANARY of the environment"
        limits = Limits(seconds=SECONDS, cell_seconds=SECONDS, memory=MEMORY)
        folder = work / "own"
        folder.mkdir()
        with Sandbox(limits, ["watch"]) as ours, Sandbox(limits, ["watch", "namespaces"]) as plain:
            jails: dict[str, Callable[[dict[str, Any], str], tuple[str, str]]] = {
                BARE: lambda prey, code: _in_a_program([], folder, prey, code),
                BUBBLEWRAP: lambda prey, code: _in_a_program(
                    _bubblewrap(folder, machine.library.parent), folder, prey, code
                ),
                OURS: lambda prey, code: _in_ours(ours, prey, code),
                PLAIN: lambda prey, code: _in_ours(plain, prey, code),
            }
            for guarantee, attacks in ATTACKS.items():
                for attack, code in attacks.items():
                    if only in f"{guarantee}: {attack}":
                        row = found[f"{guarantee}: {attack}"] = {}
                        for jail, run in jails.items():
                            machine.restored()
                            achieved, refused = run(machine.prey(), code)
                            harm = ", ".join(machine.harm())
                            refused = refused.replace(str(work), "…")[:100]
                            row[jail] = {"achieved": (achieved or harm)[:100], "refused": refused}
                        print(
                            guarantee,
                            attack,
                            {jail: tuple(cell.values()) for jail, cell in row.items()},
                            file=sys.stderr,
                        )
                        for path in folder.iterdir():
                            subprocess.run(["rm", "-rf", path])
        machine.restored()
        machine.close()
    return found


def _run() -> dict[str, Any]:
    """Compare as root and as an ordinary user; return the record."""
    found = {}
    for user, number in USERS.items():
        with tempfile.TemporaryDirectory() as home:
            os.chown(home, number, number)
            run = run_on((), ["-m", "tests.tools.jails", "compare"], number or None, Path(home), timeout=600)
            sys.stderr.write(run.stderr)
            found[user] = json.loads(run.stdout)
    version = subprocess.run(["bwrap", "--version"], capture_output=True, text=True).stdout.strip()
    return {
        "date": f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d}", "bubblewrap": version.removeprefix("bubblewrap "),
        "linux": platform.release(), "machine": platform.machine(), "found": found,
    }  # fmt: skip


def _text(record: dict[str, Any]) -> str:
    """Return a record as JSON, a line an attack."""
    row = re.compile(r"\{\n {4}\S.*?\n {3}\}", re.DOTALL)
    return (
        row.sub(lambda found: re.sub(r"\n *", " ", found[0]), json.dumps(record, indent=1, ensure_ascii=False)) + "\n"
    )


def _shown(record: dict[str, Any]) -> Iterator[tuple[str, dict[str, bool]]]:
    """Go through what succeeds without a jail: the attack, and by jail whether it was held for every user it harms."""
    for attack in dict.fromkeys(attack for found in record["found"].values() for attack in found):
        rows = [found[attack] for found in record["found"].values() if found[attack][BARE]["achieved"]]
        if rows:
            yield attack, {jail: not any(row[jail]["achieved"] for row in rows) for jail in (BUBBLEWRAP, OURS, PLAIN)}


def table(record: dict[str, Any], whole: bool = False) -> str:
    """Return what a run found, in Markdown: the attacks that not every jail held, or all of them."""
    shown = dict(_shown(record))
    counts = {jail: sum(held[jail] for held in shown.values()) for jail in (BUBBLEWRAP, OURS, PLAIN)}
    linux = record["linux"].split("-")[0]
    lines = [
        f"Of {len(shown)} attacks that succeed without a jail, bubblewrap {record['bubblewrap']} held",
        f"{counts[BUBBLEWRAP]}, qdot {counts[OURS]}, and qdot where namespaces are refused {counts[PLAIN]}",
        f"(Linux {linux} on {record['machine']}, {record['date']}, as root and as an ordinary user).",
        "",
        f"| {'attack' if whole else 'not held by all'} | bubblewrap | qdot | qdot without namespaces |",
        "|---|---|---|---|",
    ]  # fmt: skip
    for attack, held in shown.items():
        if whole or not all(held.values()):
            lines.append(f"| {attack} | {' | '.join('held' if holds else '**not**' for holds in held.values())} |")
    return "\n".join(lines)


def documented(text: str, record: dict[str, Any]) -> str:
    """Return the document with the table of a run in its place."""
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n\n{table(record)}\n\n{END}{rest.split(END)[1]}"


def _main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", nargs="?", choices=["run", "show", "compare"], default="run")
    parser.add_argument("--only", default="", help="for compare, as this user: the attacks whose names hold this")
    asked = parser.parse_args()
    if asked.step == "compare":
        print(json.dumps(compare(asked.only)))
        return
    if asked.step == "run":
        record = _run()
        write_atomically(RECORD, _text(record))
        write_atomically(DOCUMENT, documented(DOCUMENT.read_text(encoding="utf-8"), record))
    print(table(json.loads(RECORD.read_text(encoding="utf-8")), whole=True))


if __name__ == "__main__":
    _main()
