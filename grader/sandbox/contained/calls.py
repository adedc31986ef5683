"""Lists the system calls that a notebook may not use, and makes the kernel's filter (seccomp, in classic BPF).

Calls that NumPy, SymPy and Python need to compute are allowed: files, memory, threads, time. Calls that start programs
or processes, open sockets, reach other processes, mount file systems, or change the machine fail with EPERM.
"""

import platform
import struct

# name: number on x86_64, number on aarch64; None if the machine has no such call
REFUSED_CALLS: dict[str, tuple[int | None, int | None]] = {
    # programs and processes; for clone, see below
    "fork": (57, None), "vfork": (58, None), "execve": (59, 221), "execveat": (322, 281), "setsid": (112, 157),
    "setpgid": (109, 154),
    # the network, and sockets on this machine
    "socket": (41, 198), "socketpair": (53, 199), "connect": (42, 203), "bind": (49, 200), "listen": (50, 201),
    "accept": (43, 202), "accept4": (288, 242), "sendto": (44, 206), "sendmsg": (46, 211), "sendmmsg": (307, 269),
    "recvmsg": (47, 212), "recvmmsg": (299, 243),
    # ways around a filter
    "io_uring_setup": (425, 425), "io_uring_enter": (426, 426), "io_uring_register": (427, 427),
    "seccomp": (317, 277), "bpf": (321, 280), "userfaultfd": (323, 282), "perf_event_open": (298, 241),
    "modify_ldt": (154, None), "personality": (135, 92), "open_by_handle_at": (304, 265),
    "name_to_handle_at": (303, 264),
    # other processes
    "ptrace": (101, 117), "process_vm_readv": (310, 270), "process_vm_writev": (311, 271), "kcmp": (312, 272),
    "pidfd_open": (434, 434), "pidfd_getfd": (438, 438), "pidfd_send_signal": (424, 424),
    "process_madvise": (440, 440), "process_mrelease": (448, 448), "tkill": (200, 130),
    "rt_sigqueueinfo": (129, 138), "rt_tgsigqueueinfo": (297, 240), "setpriority": (141, 140),
    "ioprio_set": (251, 30), "sched_setscheduler": (144, 119), "sched_setparam": (142, 118),
    "sched_setattr": (314, 274), "sched_setaffinity": (203, 122), "migrate_pages": (256, 238),
    "move_pages": (279, 239),
    # memory that no limit counts or that outlives the process; resources that the whole machine shares
    "io_setup": (206, 0),
    "shmget": (29, 194), "msgget": (68, 186), "semget": (64, 190), "mq_open": (240, 180), "memfd_create": (319, 279),
    "memfd_secret": (447, 447), "add_key": (248, 217), "request_key": (249, 218), "keyctl": (250, 219),
    # namespaces and mounts
    "unshare": (272, 97), "setns": (308, 268), "mount": (165, 40), "umount2": (166, 39), "pivot_root": (155, 41),
    "chroot": (161, 51), "mount_setattr": (442, 442), "open_tree": (428, 428), "move_mount": (429, 429),
    "fsopen": (430, 430), "fsconfig": (431, 431), "fsmount": (432, 432), "fspick": (433, 433),
    # the machine
    "kexec_load": (246, 104), "kexec_file_load": (320, 294), "init_module": (175, 105), "finit_module": (313, 273),
    "delete_module": (176, 106), "reboot": (169, 142), "swapon": (167, 224), "swapoff": (168, 225), "acct": (163, 89),
    "syslog": (103, 116), "quotactl": (179, 60), "sethostname": (170, 161), "setdomainname": (171, 162),
    "settimeofday": (164, 170), "clock_settime": (227, 112), "adjtimex": (159, 171), "clock_adjtime": (305, 266),
    "ioperm": (173, None), "iopl": (172, None), "vhangup": (153, 58), "fanotify_init": (300, 262),
}  # fmt: skip

CALLS_REFUSED_ON_MACHINE_FILES: dict[str, tuple[int | None, int | None]] = {
    "truncate": (76, 45), "chmod": (90, None), "fchmodat": (268, 53), "fchmodat2": (452, 452), "chown": (92, None),
    "lchown": (94, None), "fchownat": (260, 54), "utime": (132, None), "utimes": (235, None), "futimesat": (261, None),
    "utimensat": (280, 88), "setxattr": (188, 5), "lsetxattr": (189, 6), "removexattr": (197, 14),
    "lremovexattr": (198, 15), "fallocate": (285, 47), "fchmod": (91, 52), "fchown": (93, 55), "fsetxattr": (190, 7),
    "fremovexattr": (199, 16),
}  # fmt: skip
"""Calls that are also refused if a notebook sees the machine's own files: Landlock does not restrict metadata changes.

With the descriptor of an open library, a notebook could make the library unreadable for everybody. fallocate is refused
because reserved space that is not written can't be counted there.
"""

_CLONE, _CLONE3, _PRCTL, _IOCTL, _FCNTL = (56, 220), (435, 435), (157, 167), (16, 29), (72, 25)
_KILL, _TGKILL, _PRLIMIT, _OPENAT, _OPEN = (62, 129), (234, 131), (302, 261), (257, 56), (2, -1)
_OPENAT2 = (437, 437)
_THREAD_FLAG, _THREAD_NAME_OPTIONS = 0x10000, (15, 16, 0x53564D41)
_ALLOWED_IOCTL_REQUESTS = (0x5401, 0x802C542A, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
"""The requests of ioctl that are allowed: whether a file is a terminal (TCGETS, TCGETS2), its width, how much can be
read, whether reading waits, and whether started programs inherit the file."""
_OWNER_COMMANDS, _LEASE_COMMAND = (
    (8, 10, 15),
    1024,
)  # F_SETOWN, F_SETSIG, F_SETOWN_EX; F_SETLEASE, which makes others wait for a file
_FIRST_UNKNOWN_CALL = (
    463  # the first call of Linux 6.13: some calls since then change file attributes, and nothing needs them
)
_TMPFILE_FLAG = 0x400000  # the bit of O_TMPFILE that O_DIRECTORY does not have
_EPERM, _ENOSYS = 1, 38
_ARCHITECTURES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW, _KILL_PROCESS, _ERROR = 0x7FFF0000, 0x80000000, 0x00050000
_CALL_NUMBER_OFFSET, _ARCHITECTURE_OFFSET, _FIRST_ARGUMENT_OFFSET, _SECOND_ARGUMENT_OFFSET, _THIRD_ARGUMENT_OFFSET = (
    0,
    4,
    16,
    24,
    32,
)  # byte offsets in struct seccomp_data


def _instruction(code: int, operand: int, jump_if_true: int = 0, jump_if_false: int = 0) -> bytes:
    """Return an instruction of a BPF program, as bytes.

    After a comparison, the program skips `jump_if_true` instructions if it holds, and else `jump_if_false`.
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
    refuse, allow = _instruction(_RETURN, _ERROR | _EPERM), _instruction(_RETURN, _ALLOW)
    program = [
        _instruction(_LOAD, _ARCHITECTURE_OFFSET),
        _instruction(_EQUAL, architecture, 1),
        _instruction(_RETURN, _KILL_PROCESS),
    ]
    program += [
        _instruction(_LOAD, _CALL_NUMBER_OFFSET),
        _instruction(_AT_LEAST, 0x40000000, 0, 1),
        refuse,
    ]  # x32: other numbers for the same calls
    program += [_instruction(_AT_LEAST, _FIRST_UNKNOWN_CALL, 0, 1), _instruction(_RETURN, _ERROR | _ENOSYS)]

    def add_case(numbers: tuple[int, int], *instructions: bytes) -> None:
        if numbers[column] < 0:  # this machine has no such call
            return
        program.extend((_instruction(_EQUAL, numbers[column], 0, len(instructions)), *instructions))

    def allow_only(argument_offset: int, *values: int) -> list[bytes]:
        """Return instructions that allow the call only if an argument is one of the values.

        They compare the lower half of the argument, because the kernel uses only that.
        """
        tests = [_instruction(_EQUAL, value, len(values) - i) for i, value in enumerate(values)]
        return [_instruction(_LOAD, argument_offset), *tests, refuse, allow]

    def refuse_only(argument_offset: int, *values: int) -> list[bytes]:
        """Return instructions that refuse the call if an argument is one of the values."""
        tests = [_instruction(_EQUAL, value, len(values) - i) for i, value in enumerate(values)]
        return [_instruction(_LOAD, argument_offset), *tests, allow, refuse]

    add_case(
        _CLONE, _instruction(_LOAD, _FIRST_ARGUMENT_OFFSET), _instruction(_ANY_BIT, _THREAD_FLAG, 1), refuse, allow
    )
    add_case(_CLONE3, _instruction(_RETURN, _ERROR | _ENOSYS))
    add_case(_KILL, *allow_only(_FIRST_ARGUMENT_OFFSET, pid))
    add_case(_TGKILL, *allow_only(_FIRST_ARGUMENT_OFFSET, pid))
    add_case(_PRLIMIT, *allow_only(_FIRST_ARGUMENT_OFFSET, 0, pid))
    add_case(_PRCTL, *allow_only(_FIRST_ARGUMENT_OFFSET, *_THREAD_NAME_OPTIONS))
    add_case(_IOCTL, *allow_only(_SECOND_ARGUMENT_OFFSET, *_ALLOWED_IOCTL_REQUESTS))
    add_case(_FCNTL, *refuse_only(_SECOND_ARGUMENT_OFFSET, *_OWNER_COMMANDS, _LEASE_COMMAND))
    if sees_machine_files:  # refuse O_TMPFILE, because files that never had a name can't be counted
        for call, flags in ((_OPENAT, _THIRD_ARGUMENT_OFFSET), (_OPEN, _SECOND_ARGUMENT_OFFSET)):
            add_case(call, _instruction(_LOAD, flags), _instruction(_ANY_BIT, _TMPFILE_FLAG, 0, 1), refuse, allow)
        add_case(_OPENAT2, _instruction(_RETURN, _ERROR | _ENOSYS))
    for numbers in (*REFUSED_CALLS.values(), *(CALLS_REFUSED_ON_MACHINE_FILES.values() if sees_machine_files else ())):
        number = numbers[column]
        if number is not None:
            program += [_instruction(_EQUAL, number, 0, 1), refuse]
    return b"".join((*program, allow))
