"""Isolate a notebook by several measures, each of which is tried separately to find out whether it works here.

The forking process calls `enter_namespaces` and `make_private_root` once; each child calls `apply_measures` before it
runs a student's code. If a measure is not available, the others still apply. docs/sandbox.md explains what each measure
achieves.
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
from functools import partial
from pathlib import Path

from . import audit_hook, kernel, system_calls

try:
    import resource
except ImportError:  # on Windows, where this module is imported but never runs
    resource = None  # type: ignore[assignment]

# The notebook's folder in a private root. The folder is not /tmp if Python itself is installed there, because a mount
# on /tmp would hide Python.
NOTEBOOK_FOLDER = "/qdot" if any(path.startswith("/tmp/") for path in audit_hook.READABLE_PATHS) else "/tmp"  # noqa: S108
MAX_REPORT_BYTES = 4_000_000
"""Maximum number of bytes that a notebook may report in total."""
MAX_DISK_BYTES = 64_000_000
"""Maximum number of bytes in a notebook's folder."""
MAX_FILE_BYTES = 10_000_000
"""Maximum number of bytes in a file."""
MAX_FILES = 4096
"""Maximum number of files and folders in a notebook's folder."""
MAX_DEPTH = 32
"""Maximum depth of nested folders; it is checked only without a private root."""
MAX_PROCESSES = 64
"""Maximum number of processes and threads."""
MAX_DESCRIPTORS = 64
"""Maximum number of open files."""
MAX_SIGNALS = 256
"""Maximum number of timers and waiting signals."""
MAX_SLOWDOWN = 10
"""In real time, a notebook may take its limit plus this many times its processor time, as the machine may be busy."""
MAX_REPLACED_SYMBOLS = 20
"""Maximum number of symbols that are reported as replaced by numbers."""


@dataclass
class Measures:
    """The measures on this machine; `unavailable` maps each measure that is not available to the reason.

    The names of the measures are the keys of `grader.sandbox.guarantees.MEASURES`.

    A notebook's limits are `memory_bytes`, `processor_seconds` and `max_processes`, the number of processes of its
    user. If this process is root, `user` is the user that a child becomes.
    """

    unavailable: dict[str, str]
    memory_bytes: int
    processor_seconds: int
    user: int | None = None
    max_processes: int | None = None

    def is_applied(self, name: str) -> bool:
        """Return whether a measure is applied."""
        return name not in self.unavailable

    def try_out(self, name: str, action: Callable[[], None]) -> None:
        """Try a measure in a child process; if the measure fails, add it to `unavailable`."""
        if self.is_applied(name):
            try:
                run_in_child(action)
            except OSError as error:
                self.unavailable[name] = str(error)


def run_in_child(action: Callable[[], str | None]) -> str:
    """Run an action in a child process, and return the text that it returns. Raises OSError if the action fails.

    The child writes the text after a ".", or the reason for the failure after a "!".
    """
    reading_end, writing_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        outcome = b"!the process ended"
        try:
            outcome = b"." + (action() or "").encode()
        except BaseException as error:
            outcome = b"!" + (str(error) or type(error).__name__).encode()[:500]
        finally:
            os.write(writing_end, outcome)
            os._exit(0)
    os.close(writing_end)
    with os.fdopen(reading_end, "rb") as pipe:
        text = pipe.read().decode(errors="replace") or "!the process that tried it was killed"
    os.waitpid(pid, 0)
    if text[0] == "!":
        raise OSError(text[1:])
    return text[1:]


# --- called once, in the forking process ---


def enter_namespaces() -> None:
    """Leave the machine's namespaces: get a separate network that is down, no other processes, and separate mounts.

    Root needs no user namespace. Any other user gets a new user namespace, and has privileges only there.
    """
    user, group = os.geteuid(), os.getegid()
    namespaces = kernel.NEWNS | kernel.NEWNET | kernel.NEWIPC | kernel.NEWUTS | kernel.NEWPID
    try:
        kernel.unshare(namespaces)
    except OSError:
        kernel.unshare(namespaces | kernel.NEWUSER)
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    kernel.mount(None, "/", None, kernel.MS_REC | kernel.MS_PRIVATE)


def make_private_root(mountpoint: str) -> None:
    """Make a read-only root folder at `mountpoint`, with Python, its libraries and an empty folder for notebooks."""
    kernel.mount("qdot", mountpoint, "tmpfs", kernel.MS_NOSUID | kernel.MS_NODEV, "size=4m,mode=755")
    bound_paths: list[str] = []
    for path in sorted(audit_hook.READABLE_PATHS, key=len):
        resolved_path = _copy_links(path, mountpoint)
        if os.path.exists(resolved_path) and not audit_hook.is_inside(resolved_path, tuple(bound_paths)):
            _bind_read_only(resolved_path, mountpoint)
            bound_paths.append(resolved_path)
    for folder in audit_hook.LIBRARY_FOLDERS:
        for name in audit_hook.HIDDEN_PACKAGES:
            if os.path.isdir(hidden_folder := mountpoint + os.path.realpath(f"{folder}/{name}")):
                kernel.mount("qdot", hidden_folder, "tmpfs", kernel.MS_RDONLY, "size=4k")
    os.makedirs(mountpoint + NOTEBOOK_FOLDER, exist_ok=True)
    kernel.pivot_root(mountpoint)
    kernel.mount(None, "/", None, kernel.MS_REMOUNT | kernel.MS_BIND | kernel.MS_RDONLY | kernel.MS_NOSUID)


def _bind_read_only(path: str, mountpoint: str) -> None:
    """Make a file or folder of the machine visible in the new root, read-only."""
    target = mountpoint + path
    if os.path.isdir(path):
        os.makedirs(target, exist_ok=True)
    else:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        Path(target).touch()
    kernel.mount(path, target, None, kernel.MS_BIND | kernel.MS_REC)
    kernel.make_read_only(target, has_devices=path in audit_hook.DEVICES)


def _copy_links(path: str, mountpoint: str) -> str:
    """Copy the symbolic links along a path into the new root, and return the path with links resolved."""
    for _ in range(40):  # the number of links that Linux follows along a path
        parts = Path(path).parts
        for length in range(2, len(parts) + 1):
            prefix = os.path.join(*parts[:length])
            if os.path.islink(prefix):
                if not os.path.lexists(mountpoint + prefix):
                    os.makedirs(os.path.dirname(mountpoint + prefix), exist_ok=True)
                    os.symlink(os.readlink(prefix), mountpoint + prefix)
                path = os.path.normpath(os.path.join(os.path.dirname(prefix), os.readlink(prefix), *parts[length:]))
                break
        else:
            break
    return path


def make_folder(measures: Measures, parent: str) -> str:
    """Return the path of a new empty folder for a notebook, inside `parent` unless there is a private root.

    In a private root, the folder is in a new file system of limited size.
    """
    has_private_root = measures.is_applied("namespaces")
    actual_parent = NOTEBOOK_FOLDER if has_private_root else parent
    if has_private_root:
        data = f"size={MAX_DISK_BYTES},nr_inodes={MAX_FILES},mode=755"
        kernel.mount("qdot", NOTEBOOK_FOLDER, "tmpfs", kernel.MS_NOSUID | kernel.MS_NODEV, data)
    folder = tempfile.mkdtemp(prefix="qdot-run-", dir=actual_parent)
    if measures.user is not None and measures.is_applied("user"):
        os.chmod(actual_parent, 0o711)  # noqa: S103 - that user has to reach its folder
        os.chown(folder, measures.user, measures.user)
    return folder


def exceeds_disk_limit(measures: Measures, folder: str, pid: int) -> bool:
    """Return whether a notebook has written more than its limit, or its files can't be counted.

    Deleted files that are still open also count. On a disk, the number of bytes that the process has written includes
    them. A file system in memory has no such number, so the deleted files that are open or mapped are counted.
    """
    try:
        with _become_notebook_user(measures):
            if _count_written_bytes(pid) > MAX_DISK_BYTES or _count_deleted_bytes(pid, folder) > MAX_DISK_BYTES:
                return True
        byte_count = file_count = 0
        unvisited_folders = [(folder, 0)]
        while unvisited_folders:
            path, depth = unvisited_folders.pop()
            for entry in _list_entries(path):
                file_count += 1
                if entry.is_dir(follow_symlinks=False):
                    unvisited_folders.append((entry.path, depth + 1))
                else:
                    with contextlib.suppress(FileNotFoundError):  # the notebook may have removed the file by now
                        byte_count += STAT_BLOCK_BYTES * entry.stat(follow_symlinks=False).st_blocks
                if byte_count > MAX_DISK_BYTES or file_count > MAX_FILES or depth > MAX_DEPTH:
                    return True
    except OSError:
        return True
    return False


@contextlib.contextmanager
def _become_notebook_user(measures: Measures) -> Iterator[None]:
    """Become the notebook's user during the block, because only this user may inspect the notebook's process."""
    if measures.user is None or not measures.is_applied("user"):
        yield
        return
    os.setegid(measures.user)
    os.seteuid(measures.user)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)


def _list_entries(path: str) -> list[os.DirEntry[str]]:
    """Return the entries of a folder; an empty list if the notebook has removed the folder in the meantime."""
    with contextlib.suppress(FileNotFoundError), os.scandir(path) as entries:
        return list(entries)
    return []


def _count_written_bytes(pid: int) -> int:
    """Return the number of bytes that a process has written to disks; 0 if unknown."""
    with contextlib.suppress(OSError):
        match = re.search(r"(?m)^write_bytes: (\d+)", Path(f"/proc/{pid}/io").read_text())
        return int(match[1]) if match else 0
    return 0


STAT_BLOCK_BYTES = 512
"""The unit of `st_blocks` on every system, whatever the block size of the disk."""


def _count_deleted_bytes(pid: int, folder: str) -> int:
    """Return the size in bytes of the deleted files that a process has open or mapped, as far as known."""
    byte_count = 0
    with contextlib.suppress(OSError):
        for name in os.listdir(f"/proc/{pid}/fd"):
            with contextlib.suppress(OSError):  # the file may be closed by now
                file = os.stat(f"/proc/{pid}/fd/{name}")
                is_deleted = stat.S_ISREG(file.st_mode) and not file.st_nlink
                byte_count += STAT_BLOCK_BYTES * file.st_blocks if is_deleted else 0
    with contextlib.suppress(OSError):
        mappings = Path(f"/proc/{pid}/maps").read_text(errors="replace")
        for start, end, path in re.findall(r"(?m)^([0-9a-f]+)-([0-9a-f]+) .*? (/.*) \(deleted\)$", mappings):
            byte_count += int(end, 16) - int(start, 16) if path.startswith(f"{folder}/") else 0
    return byte_count


# --- called for every notebook, in its own process ---


def apply_measures(measures: Measures, folder: str, parent_pid: int) -> dict[str, str]:
    """Apply all measures except the audit hook to this process; return the measures that failed, each with the reason.

    The order matters, because some measures would prevent others. From now on, this process ends if its parent ends.
    """
    failed_measures: dict[str, str] = {}

    def apply_measure(name: str, action: Callable[[], None]) -> None:
        if measures.is_applied(name):
            try:
                action()
            except (OSError, ValueError, AttributeError) as error:
                failed_measures[name] = str(error) or type(error).__name__

    apply_measure("limits", lambda: _limit_resources(measures))
    apply_measure("user", lambda: change_user(measures.user))
    die_with_parent(parent_pid)  # after the change of user, which would cancel this setting
    apply_measure("privileges", lambda: _give_up_privileges(measures))
    if not measures.is_applied("privileges") and measures.is_applied("seccomp") and sys.platform == "linux":
        apply_measure("seccomp", lambda: kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1))
    apply_measure("landlock", lambda: _restrict_files(folder))
    make_filter = partial(system_calls.make_filter_program, sees_machine_files=not measures.is_applied("namespaces"))
    apply_measure("seccomp", lambda: kernel.install_seccomp_filter(make_filter(os.getpid())))
    kernel.release_library()
    return failed_measures


def die_with_parent(parent_pid: int) -> None:
    """Have Linux kill this process when its parent ends, so that a stopped grader leaves nothing running."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            kernel.prctl(kernel.PR_SET_PDEATHSIG, signal.SIGKILL)
    # If the parent has already ended, this process has another parent. 0 means that the parent is in another namespace.
    if os.getppid() not in (parent_pid, 0):
        os._exit(1)


def _limit_resources(measures: Measures) -> None:
    """Set the limits on resources. Raises OSError, which names the limits, if the kernel refuses any."""
    limits = [
        ("RLIMIT_CPU", measures.processor_seconds), ("RLIMIT_FSIZE", MAX_FILE_BYTES),
        ("RLIMIT_NOFILE", MAX_DESCRIPTORS), ("RLIMIT_AS", measures.memory_bytes),
        ("RLIMIT_CORE", 1),  # with 0, Linux would still pipe core dumps to a program, if one is set up for them
    ]  # fmt: skip
    if sys.platform == "linux":  # waiting signals and timers, which are counted for all of a user's processes together
        limits.append(("RLIMIT_SIGPENDING", MAX_SIGNALS))
    if measures.max_processes is not None:
        limits.append(("RLIMIT_NPROC", measures.max_processes))
    refused_limits = []
    for name, value in limits:
        try:
            resource.setrlimit(getattr(resource, name), (value, value))
        except (AttributeError, ValueError, OSError) as error:
            refused_limits.append(f"{name}: {error}")
    if refused_limits:
        raise OSError("; ".join(refused_limits))


def change_user(user: int | None) -> None:
    """Become the user with this number, who owns nothing; do nothing for None.

    Raises OSError if the user can't read the libraries.
    """
    if user is None:
        return
    libraries = [path for path in audit_hook.LIBRARY_FOLDERS if os.path.isdir(path)]
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)
    for path in libraries:
        if not os.access(path, os.R_OK | os.X_OK):
            raise OSError(f"only root can read {path}")


def _give_up_privileges(measures: Measures) -> None:
    kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1)
    # The forking process must be able to inspect this process if it counts the bytes written (`exceeds_disk_limit`).
    kernel.prctl(kernel.PR_SET_DUMPABLE, 0 if measures.is_applied("namespaces") else 1)
    kernel.drop_capabilities()


# Landlock's rights to files and folders
_READ_FILE, _READ_FOLDER, _WRITE, _TRUNCATE, _REFER = 1 << 2, 1 << 3, 1 << 1, 1 << 14, 1 << 13
_CHANGE_FOLDER = (1 << 4) | (1 << 5) | (1 << 7) | (1 << 8)  # remove and make folders and files


def _restrict_files(folder: str) -> None:
    """Have Landlock allow only reading the libraries, and reading and writing in the notebook's folder.

    Each version of Landlock knows more rights; all rights that the kernel's version knows are restricted.
    """
    version = kernel.find_landlock_version()
    # Version 1 has 13 rights to files; versions 2, 3 and 5 add one each. Version 4 adds TCP (bind and connect), and
    # version 6 adds the scopes: abstract sockets and signals.
    file_rights = (1 << (13 + min(version - 1, 2))) - 1 | (1 << 15 if version >= 5 else 0)
    network_rights, scopes = (3 if version >= 4 else 0), (3 if version >= 6 else 0)
    rules = [(folder, (_READ_FILE | _READ_FOLDER | _WRITE | _CHANGE_FOLDER | _TRUNCATE | _REFER) & file_rights)]
    for path in audit_hook.RESOLVED_READABLE_PATHS:
        if os.path.isdir(path):
            rules.append((path, _READ_FILE | _READ_FOLDER))
        elif os.path.exists(path):
            rules.append((path, _READ_FILE | _WRITE if path in audit_hook.DEVICES else _READ_FILE))
    kernel.restrict_with_landlock((file_rights, network_rights, scopes), rules)
