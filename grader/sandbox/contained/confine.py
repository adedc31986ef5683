"""The measures that isolate a notebook. Each is tried separately, to know which ones work on this machine.

The forking process calls `enter` and `private_root` once; each child calls `apply` before it runs a student's code. If
a measure is not available, the others still apply: docs/sandbox.md explains what each of them achieves.
"""

import contextlib
import os
import re
import signal
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from . import calls, guard, kernel

try:
    import resource
except ImportError:  # Windows, where this is imported, and never runs
    resource = None  # type: ignore[assignment]

MEASURES = ("namespaces", "landlock", "seccomp", "user", "privileges", "limits", "quota", "watch")
"""Namespaces with a root of their own; rules on files; a filter of system calls; another user than root; no rights and
no new ones; limits on resources; what is written counted, where the root is not its own; the audit hook."""

# In a root of its own, where nothing else is; not /tmp where Python itself is below that, and must stay in sight.
OWN = "/qdot" if any(place.startswith("/tmp/") for place in guard.PLACES) else "/tmp"  # noqa: S108
DISK, FILE, FILES, DEPTH, PROCESSES, DESCRIPTORS, SIGNALS = 64_000_000, 10_000_000, 4096, 32, 64, 64, 256
"""Bytes in a notebook's folder, in one file of it, how many files, folders in folders where they have to be counted,
processes or threads, open files, timers."""


@dataclass
class Measures:
    """The measures that are `lacking`, with reasons; `user` is the user of a child if this process is root."""

    lacking: dict[str, str]
    memory: int
    seconds: int
    user: int | None = None
    processes: int | None = None

    def holds(self, name: str) -> bool:
        """Whether a measure is applied."""
        return name not in self.lacking

    def try_out(self, name: str, action: Callable[[], None]) -> None:
        """Try a measure in a child process; if it fails, it is lacking."""
        if self.holds(name):
            try:
                run_in_child(action)
            except OSError as error:
                self.lacking[name] = str(error)


def run_in_child(action: Callable[[], str | None]) -> str:
    """Run an action in a child process, which ends then; return its text. Raises OSError if it fails."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        outcome = b"!it ended"
        try:
            outcome = b"." + (action() or "").encode()
        except BaseException as error:
            outcome = b"!" + (str(error) or type(error).__name__).encode()[:500]
        finally:
            os.write(writing, outcome)
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        text = pipe.read().decode(errors="replace") or "!the process that tried it was killed"
    os.waitpid(pid, 0)
    if text[0] == "!":
        raise OSError(text[1:])
    return text[1:]


# --- once, in the process that forks for every notebook ---


def enter() -> None:
    """Leave the machine's namespaces: a separate network that is down, no other processes, separate mounts.

    Root needs no user namespace; other users become the only user of a new one, with privileges only in it.
    """
    user, group = os.geteuid(), os.getegid()
    others = kernel.NEWNS | kernel.NEWNET | kernel.NEWIPC | kernel.NEWUTS | kernel.NEWPID
    try:
        kernel.unshare(others)
    except OSError:
        kernel.unshare(others | kernel.NEWUSER)
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    kernel.mount(None, "/", None, kernel.MS_REC | kernel.MS_PRIVATE)


def private_root(mountpoint: str) -> None:
    """Make a read-only root with Python, its libraries and an empty folder."""
    kernel.mount("qdot", mountpoint, "tmpfs", kernel.MS_NOSUID | kernel.MS_NODEV, "size=4m,mode=755")
    shown: list[str] = []
    for path in sorted(guard.PLACES, key=len):
        real = _copy_links(path, mountpoint)
        if os.path.exists(real) and not guard.is_inside(real, tuple(shown)):
            _show(real, mountpoint)
            shown.append(real)
    for folder in guard.LIBRARIES:
        for name in guard.HIDDEN:
            if os.path.isdir(hidden := mountpoint + os.path.realpath(f"{folder}/{name}")):
                kernel.mount("qdot", hidden, "tmpfs", kernel.MS_RDONLY, "size=4k")
    os.makedirs(mountpoint + OWN, exist_ok=True)
    kernel.pivot_root(mountpoint)
    kernel.mount(None, "/", None, kernel.MS_REMOUNT | kernel.MS_BIND | kernel.MS_RDONLY | kernel.MS_NOSUID)


def _show(path: str, mountpoint: str) -> None:
    target = mountpoint + path
    if os.path.isdir(path):
        os.makedirs(target, exist_ok=True)
    else:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        Path(target).touch()
    kernel.mount(path, target, None, kernel.MS_BIND | kernel.MS_REC)
    kernel.make_read_only(target, devices=path in guard.DEVICES)


def _copy_links(path: str, mountpoint: str) -> str:
    """Copy the links along a path into the new root, and return the path with links resolved."""
    for _ in range(40):
        parts = Path(path).parts
        for length in range(2, len(parts) + 1):
            at = os.path.join(*parts[:length])
            if os.path.islink(at):
                if not os.path.lexists(mountpoint + at):
                    os.makedirs(os.path.dirname(mountpoint + at), exist_ok=True)
                    os.symlink(os.readlink(at), mountpoint + at)
                path = os.path.normpath(os.path.join(os.path.dirname(at), os.readlink(at), *parts[length:]))
                break
        else:
            break
    return path


def make_folder(measures: Measures, parent: str) -> str:
    """Return a new empty folder for a notebook; in a private root it is a file system of limited size."""
    if measures.holds("namespaces"):
        data = f"size={DISK},nr_inodes={FILES},mode=755"
        kernel.mount("qdot", OWN, "tmpfs", kernel.MS_NOSUID | kernel.MS_NODEV, data)
        parent = OWN
    folder = tempfile.mkdtemp(prefix="qdot-run-", dir=parent)
    if measures.user is not None and measures.holds("user"):
        os.chmod(parent, 0o711)  # noqa: S103 - it has to get there
        os.chown(folder, measures.user, measures.user)
    return folder


def is_overdrawn(measures: Measures, folder: str, pid: int) -> bool:
    """Whether a notebook has written more than its limit, or has written where it can't be counted.

    Removed files that are still open are in no folder. They are counted by what the process has written to disks and,
    for file systems in memory, by its open files and mappings without names.
    """
    try:
        with _as_its_user(measures):
            if _bytes_written(pid) > DISK or _nameless_bytes(pid, folder) > DISK:
                return True
        size = number = 0
        left = [(folder, 0)]
        while left:
            path, depth = left.pop()
            for entry in _entries(path):
                number += 1
                if entry.is_dir(follow_symlinks=False):
                    left.append((entry.path, depth + 1))
                else:
                    size += _size(entry)
                if size > DISK or number > FILES or depth > DEPTH:
                    return True
    except OSError:
        return True
    return False


@contextlib.contextmanager
def _as_its_user(measures: Measures) -> Iterator[None]:
    """Become the notebook's user during the block, as only that user, or a privileged root, may read its data."""
    if measures.user is None or not measures.holds("user"):
        yield
        return
    os.setegid(measures.user)
    os.seteuid(measures.user)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)


def _entries(path: str) -> list[os.DirEntry[str]]:
    """Return the entries of a folder; empty if the notebook has removed it in the meantime."""
    with contextlib.suppress(FileNotFoundError), os.scandir(path) as entries:
        return list(entries)
    return []


def _size(entry: os.DirEntry[str]) -> int:
    with contextlib.suppress(FileNotFoundError):
        return 512 * entry.stat(follow_symlinks=False).st_blocks
    return 0


def _bytes_written(pid: int) -> int:
    """Return the number of bytes that a process has written to disks; 0 if unknown."""
    with contextlib.suppress(OSError):
        match = re.search(r"(?m)^write_bytes: (\d+)", Path(f"/proc/{pid}/io").read_text())
        return int(match[1]) if match else 0
    return 0


def _nameless_bytes(pid: int, folder: str) -> int:
    """Return the size of files without names that a process has open or mapped, as far as known."""
    held = 0
    with contextlib.suppress(OSError):
        for name in os.listdir(f"/proc/{pid}/fd"):
            with contextlib.suppress(OSError):  # closed by now
                file = os.stat(f"/proc/{pid}/fd/{name}")
                held += 512 * file.st_blocks if stat.S_ISREG(file.st_mode) and not file.st_nlink else 0
    with contextlib.suppress(OSError):
        mapped = Path(f"/proc/{pid}/maps").read_text(errors="replace")
        for start, end, path in re.findall(r"(?m)^([0-9a-f]+)-([0-9a-f]+) .*? (/.*) \(deleted\)$", mapped):
            held += int(end, 16) - int(start, 16) if path.startswith(f"{folder}/") else 0
    return held


# --- for every notebook, in its process ---


def apply(measures: Measures, folder: str, parent: int) -> dict[str, str]:
    """Apply all measures except the audit hook, in an order in which none prevents the next.

    Returns those that failed, with the reason. This process ends with its `parent`.
    """
    failed: dict[str, str] = {}

    def take(name: str, action: Callable[[], None]) -> None:
        if measures.holds(name):
            try:
                action()
            except (OSError, ValueError, AttributeError) as error:
                failed[name] = str(error) or type(error).__name__

    take("limits", lambda: _limit(measures))
    take("user", lambda: become(measures.user))
    die_with_parent(parent)  # a change of user would cancel this
    take("privileges", lambda: _give_up_privileges(measures))
    if not measures.holds("privileges") and measures.holds("seccomp") and sys.platform == "linux":
        take("seccomp", lambda: kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1))
    take("landlock", lambda: _rule_files(folder))
    take("seccomp", lambda: kernel.seccomp(calls.filter_program(os.getpid(), not measures.holds("namespaces"))))
    kernel.forget()
    return failed


def die_with_parent(parent: int) -> None:
    """Let Linux kill this process when its parent ends, so that a stopped grader leaves nothing running."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            kernel.prctl(kernel.PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() not in (parent, 0):  # it has ended before this was asked for; 0 is a parent in another namespace
        os._exit(1)


def _limit(measures: Measures) -> None:
    wanted = [
        ("RLIMIT_CPU", measures.seconds), ("RLIMIT_FSIZE", FILE), ("RLIMIT_NOFILE", DESCRIPTORS),
        ("RLIMIT_AS", measures.memory),
        ("RLIMIT_CORE", 1),  # with 0, Linux pipes a dump to a program, where it does so
    ]  # fmt: skip
    if sys.platform == "linux":  # signals that wait, and timers, of which a user has so many in all its processes
        wanted.append(("RLIMIT_SIGPENDING", SIGNALS))
    if measures.processes is not None:
        wanted.append(("RLIMIT_NPROC", measures.processes))
    refused = []
    for name, value in wanted:
        try:
            resource.setrlimit(getattr(resource, name), (value, value))
        except (AttributeError, ValueError, OSError) as error:
            refused.append(f"{name}: {error}")
    if refused:
        raise OSError("; ".join(refused))


def become(user: int | None) -> None:
    """Become a user who owns nothing, if root started this. Raises OSError if that user can't read the libraries."""
    if user is None:
        return
    libraries = [path for path in guard.LIBRARIES if os.path.isdir(path)]
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)
    for path in libraries:
        if not os.access(path, os.R_OK | os.X_OK):
            raise OSError(f"only root may read {path}")


def _give_up_privileges(measures: Measures) -> None:
    kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1)
    # Where it has to be counted what it writes (`is_overdrawn`), the process that forks must be able to ask.
    kernel.prctl(kernel.PR_SET_DUMPABLE, 0 if measures.holds("namespaces") else 1)
    kernel.drop_capabilities()


_READ_FILE, _READ_FOLDER, _WRITE, _TRUNCATE, _REFER = 1 << 2, 1 << 3, 1 << 1, 1 << 14, 1 << 13
_CHANGE_FOLDER = (1 << 4) | (1 << 5) | (1 << 7) | (1 << 8)  # remove folders and files, make them


def _rule_files(folder: str) -> None:
    version = kernel.landlock_version()
    files = (1 << (13 + min(version - 1, 2))) - 1 | (1 << 15 if version >= 5 else 0)
    network, scopes = (3 if version >= 4 else 0), (3 if version >= 6 else 0)
    rules = [(folder, (_READ_FILE | _READ_FOLDER | _WRITE | _CHANGE_FOLDER | _TRUNCATE | _REFER) & files)]
    for path in guard.READABLE:
        if os.path.isdir(path):
            rules.append((path, _READ_FILE | _READ_FOLDER))
        elif os.path.exists(path):
            rules.append((path, _READ_FILE | _WRITE if path in guard.DEVICES else _READ_FILE))
    kernel.landlock((files, network, scopes), rules)
