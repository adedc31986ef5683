"""Call Linux's system calls for isolation with ctypes, because Python has no functions for them.

The names of the constants are those of Linux. Every function raises OSError if the kernel refuses. Importing this
module calls nothing, so it can be imported on any system.
"""

import ctypes
import functools
import os
import platform
import struct
import sys
from collections.abc import Sequence
from typing import Any

NEWNS, NEWUTS, NEWIPC = 0x00020000, 0x04000000, 0x08000000
NEWUSER, NEWPID, NEWNET = 0x10000000, 0x20000000, 0x40000000

MS_RDONLY, MS_NOSUID, MS_NODEV, MS_REMOUNT, MS_BIND, MS_REC, MS_PRIVATE = 1, 2, 4, 32, 4096, 16384, 1 << 18
_MS_NOEXEC, _MS_NOATIME, _MS_NODIRATIME = 8, 1024, 2048
MNT_DETACH = 2
ATTR_RDONLY, ATTR_NOSUID, ATTR_NODEV = 1, 2, 4

PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_SET_SECCOMP, PR_CAPBSET_DROP = 1, 4, 22, 24
PR_SET_CHILD_SUBREAPER, PR_SET_NO_NEW_PRIVS = 36, 38

_AT_FDCWD, _AT_RECURSIVE = -100, 0x8000
_CAPABILITY_VERSION_3 = 0x20080522
_PIVOT_ROOT = {"x86_64": 155, "aarch64": 41}
_CAPSET = {"x86_64": 126, "aarch64": 91}
_MOUNT_SETATTR, _LANDLOCK_CREATE, _LANDLOCK_ADD, _LANDLOCK_RESTRICT = 442, 444, 445, 446


@functools.cache
def _load_libc() -> Any:
    if sys.platform != "linux":
        raise OSError("this is not Linux")
    return ctypes.CDLL(None, use_errno=True)


def release_library() -> None:
    """Release the C library, so that a notebook does not find it among the objects of this process."""
    _load_libc.cache_clear()


def _check_result(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return result


def _syscall(number: int, *args: Any) -> int:
    long_args = [ctypes.c_long(arg) if isinstance(arg, int) else arg for arg in args]
    return _check_result(_load_libc().syscall(ctypes.c_long(number), *long_args))


def _look_up_call_number(numbers: dict[str, int]) -> int:
    """Return the number of a system call on this kind of machine."""
    if platform.machine() not in numbers:
        raise OSError(f"no system call numbers for {platform.machine()}")
    return numbers[platform.machine()]


def prctl(option: int, *args: Any) -> None:
    """Change a property of this process."""
    long_args = [ctypes.c_ulong(arg) if isinstance(arg, int) else arg for arg in (*args, 0, 0, 0, 0)[:4]]
    _check_result(_load_libc().prctl(ctypes.c_int(option), *long_args))


def unshare(flags: int) -> None:
    """Move this process out of its namespaces into new ones."""
    _check_result(_load_libc().unshare(ctypes.c_int(flags)))


def setns(descriptor: int, namespace_flag: int) -> None:
    """Move this process into an existing namespace; `namespace_flag` is a flag such as `NEWPID`."""
    _check_result(_load_libc().setns(ctypes.c_int(descriptor), ctypes.c_int(namespace_flag)))


def mount(source: str | None, target: str, file_system: str | None, flags: int, data: str = "") -> None:
    """Mount a file system of type `file_system` with the options `data`, or bind a folder to another path."""
    texts = [None if text is None else os.fsencode(text) for text in (source, target, file_system)]
    _check_result(_load_libc().mount(*texts, ctypes.c_ulong(flags), data.encode() or None))


def unmount(target: str) -> None:
    """Detach a file system at once; the kernel removes the file system when no process uses it any more."""
    _check_result(_load_libc().umount2(os.fsencode(target), MNT_DETACH))


def make_read_only(target: str, has_devices: bool) -> None:
    """Make a mount and all mounts below it read-only, and ignore the set-user-ID bit of their programs.

    Before Linux 5.12, this changes only the mount itself, not those below it.
    """
    attributes = ATTR_RDONLY | ATTR_NOSUID | (0 if has_devices else ATTR_NODEV)
    try:
        data = struct.pack("QQQQ", attributes, 0, 0, 0)
        _syscall(_MOUNT_SETATTR, _AT_FDCWD, os.fsencode(target), _AT_RECURSIVE, data, len(data))
    except OSError:
        # A user namespace may not remove the other flags, so they are set again.
        other_flags = os.statvfs(target).f_flag & (MS_NODEV | _MS_NOEXEC | _MS_NOATIME | _MS_NODIRATIME)
        mount(None, target, None, MS_REMOUNT | MS_BIND | MS_RDONLY | MS_NOSUID | other_flags)


def pivot_root(folder: str) -> None:
    """Make a mount the root of the file system, and detach the old root."""
    os.chdir(folder)
    _syscall(_look_up_call_number(_PIVOT_ROOT), b".", b".")
    unmount(".")
    os.chdir("/")


def drop_capabilities() -> None:
    """Give up all capabilities, including those that a program could gain by its file's capabilities."""
    for number in range(64):
        try:
            prctl(PR_CAPBSET_DROP, number)
        except OSError:  # there are no more, or this process has none to give up
            break
    _syscall(_look_up_call_number(_CAPSET), struct.pack("Ii", _CAPABILITY_VERSION_3, 0), bytes(24))


def find_landlock_version() -> int:
    """Return the version of Landlock's interface. Raises OSError if there is none."""
    return _syscall(_LANDLOCK_CREATE, None, 0, 1)


def restrict_with_landlock(restricted_rights: tuple[int, int, int], rules: Sequence[tuple[str, int]]) -> None:
    """Allow only the rights that the rules give for paths and everything below them.

    `restricted_rights` has three sets of rights, as bits: those to files, to the network, and to scopes. Landlock
    refuses these rights unless a rule gives them.
    """
    _, network_rights, scope_rights = restricted_rights
    size = 16 if network_rights else 8  # in bytes, without sets that are not needed, which old kernels don't know
    size = 24 if scope_rights else size
    ruleset = _syscall(_LANDLOCK_CREATE, struct.pack("QQQ", *restricted_rights), size, 0)
    try:
        for path, rights in rules:
            descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
            try:
                _syscall(_LANDLOCK_ADD, ruleset, 1, struct.pack("=Qi", rights, descriptor), 0)
            finally:
                os.close(descriptor)
        _syscall(_LANDLOCK_RESTRICT, ruleset, 0)
    finally:
        os.close(ruleset)


def install_seccomp_filter(program: bytes) -> None:
    """Filter this process's system calls from now on with a BPF program."""
    buffer = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("HxxxxxxP", len(program) // 8, ctypes.addressof(buffer))
    prctl(PR_SET_SECCOMP, 2, header)
