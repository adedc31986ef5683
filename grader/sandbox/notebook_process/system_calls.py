"""List the system calls that a notebook may not use, and make the kernel's filter (seccomp, in classic BPF).

Calls that NumPy, SymPy and Python need to compute are allowed: files, memory, threads, time. Calls that start programs
or processes, open sockets, reach other processes, mount file systems, or change the machine fail with EPERM.
"""

import csv
import platform
import struct
from pathlib import Path

with Path(__file__).with_name("refused_calls.csv").open(encoding="utf-8") as file:
    REFUSED_CALLS = tuple(csv.DictReader(file))
"""The calls that are refused, with their number on each kind of machine; empty if a machine has no such call.

The calls are grouped by what they reach, such as sockets or other processes. The group "filter" contains ways around a
filter of calls. The group "memory" contains memory that no limit covers or that outlives the process, and resources
that the whole machine shares.

Calls of the group "machine files" are refused only if a notebook sees the machine's own files. Landlock does not
restrict changes of metadata: with the descriptor of an open library, a notebook could make the library unreadable for
everybody. fallocate is in this group, because space that is reserved but not written can't be counted.
"""

_CLONE, _CLONE3, _PRCTL, _IOCTL, _FCNTL = (56, 220), (435, 435), (157, 167), (16, 29), (72, 25)
_KILL, _TGKILL, _PRLIMIT, _OPENAT, _OPEN = (62, 129), (234, 131), (302, 261), (257, 56), (2, -1)
_OPENAT2 = (437, 437)
"""The numbers of system calls on x86_64 and on aarch64; -1 if the machine has no such call."""
_THREAD_FLAG, _THREAD_NAME_OPTIONS = 0x10000, (15, 16, 0x53564D41)
_ALLOWED_IOCTL_REQUESTS = (0x5401, 0x802C542A, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
"""The requests of ioctl that are allowed: whether a file is a terminal (TCGETS, TCGETS2), its width, how much can be
read, whether reading waits, and whether started programs inherit the file."""
_OWNER_COMMANDS, _LEASE_COMMAND = (8, 10, 15), 1024
"""Refused commands of fcntl: F_SETOWN, F_SETSIG, F_SETOWN_EX; and F_SETLEASE, which makes others wait for a file."""
_FIRST_UNKNOWN_CALL = 463
"""The number of the first call that is new in Linux 6.13: some newer calls change file attributes, and Python needs
none of them."""
_TMPFILE_FLAG = 0x400000  # the bit of O_TMPFILE that O_DIRECTORY does not have
_EPERM, _ENOSYS = 1, 38
_ARCHITECTURES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW, _KILL_PROCESS, _ERROR = 0x7FFF0000, 0x80000000, 0x00050000
_CALL_NUMBER_OFFSET, _ARCHITECTURE_OFFSET = 0, 4
_FIRST_ARGUMENT_OFFSET, _SECOND_ARGUMENT_OFFSET, _THIRD_ARGUMENT_OFFSET = 16, 24, 32
"""Byte offsets in struct seccomp_data."""


def _encode(code: int, operand: int, jump_if_true: int = 0, jump_if_false: int = 0) -> bytes:
    """Return an instruction of a BPF program, as bytes.

    After a comparison, the program skips `jump_if_true` instructions if the comparison holds, otherwise `jump_if_false`
    instructions.
    """
    return struct.pack("HBBI", code, jump_if_true, jump_if_false, operand)


def make_filter_program(pid: int, sees_machine_files: bool) -> bytes:
    """Return the filter for the process `pid`. Raises OSError for a processor whose system calls are not listed here.

    The process can send signals only to itself, including those that an open file sends to its owner. clone makes only
    threads. clone3 and openat2 are reported as missing, because a filter can't inspect their flags; the C library then
    uses clone and openat. Calls that are newer than this list are also reported as missing.
    """
    machine = platform.machine()
    if machine not in _ARCHITECTURES:
        raise OSError(f"system calls of {machine} are not known")
    architecture, column = _ARCHITECTURES[machine]
    refuse, allow = _encode(_RETURN, _ERROR | _EPERM), _encode(_RETURN, _ALLOW)
    report_missing = _encode(_RETURN, _ERROR | _ENOSYS)
    program = [_encode(_LOAD, _ARCHITECTURE_OFFSET), _encode(_EQUAL, architecture, 1)]
    program += [_encode(_RETURN, _KILL_PROCESS), _encode(_LOAD, _CALL_NUMBER_OFFSET)]
    program += [_encode(_AT_LEAST, 0x40000000, 0, 1), refuse]  # x32: other numbers for the same calls
    program += [_encode(_AT_LEAST, _FIRST_UNKNOWN_CALL, 0, 1), report_missing]

    def add_case(numbers: tuple[int, int], *instructions: bytes) -> None:
        if numbers[column] < 0:  # this machine has no such call
            return
        program.extend((_encode(_EQUAL, numbers[column], 0, len(instructions)), *instructions))

    def test_argument(offset: int, values: tuple[int, ...], if_equal: bytes, if_different: bytes) -> list[bytes]:
        """Return instructions that end with `if_equal` if an argument is one of the values, else with `if_different`.

        The instructions compare the lower half of the argument, because the kernel uses only this half.
        """
        tests = [_encode(_EQUAL, value, len(values) - i) for i, value in enumerate(values)]
        return [_encode(_LOAD, offset), *tests, if_different, if_equal]

    is_thread = _encode(_ANY_BIT, _THREAD_FLAG, 1)
    add_case(_CLONE, _encode(_LOAD, _FIRST_ARGUMENT_OFFSET), is_thread, refuse, allow)
    add_case(_CLONE3, report_missing)
    add_case(_KILL, *test_argument(_FIRST_ARGUMENT_OFFSET, (pid,), allow, refuse))
    add_case(_TGKILL, *test_argument(_FIRST_ARGUMENT_OFFSET, (pid,), allow, refuse))
    add_case(_PRLIMIT, *test_argument(_FIRST_ARGUMENT_OFFSET, (0, pid), allow, refuse))
    add_case(_PRCTL, *test_argument(_FIRST_ARGUMENT_OFFSET, _THREAD_NAME_OPTIONS, allow, refuse))
    add_case(_IOCTL, *test_argument(_SECOND_ARGUMENT_OFFSET, _ALLOWED_IOCTL_REQUESTS, allow, refuse))
    add_case(_FCNTL, *test_argument(_SECOND_ARGUMENT_OFFSET, (*_OWNER_COMMANDS, _LEASE_COMMAND), refuse, allow))
    if sees_machine_files:  # refuse O_TMPFILE, because files that never had a name can't be counted
        for numbers, flags_offset in ((_OPENAT, _THIRD_ARGUMENT_OFFSET), (_OPEN, _SECOND_ARGUMENT_OFFSET)):
            add_case(numbers, _encode(_LOAD, flags_offset), _encode(_ANY_BIT, _TMPFILE_FLAG, 0, 1), refuse, allow)
        add_case(_OPENAT2, report_missing)
    for call in REFUSED_CALLS:
        if call[machine] and (sees_machine_files or call["group"] != "machine files"):
            program += [_encode(_EQUAL, int(call[machine]), 0, 1), refuse]
    return b"".join((*program, allow))
