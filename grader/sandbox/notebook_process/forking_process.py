"""The forking process: isolate itself, load the libraries, and fork a child for every notebook.

A child reads its notebook from one pipe, and reports into another pipe. So the child's memory contains no other
student's work, and nobody can confuse its output with another child's. The child is forked and isolated in advance,
while the grader marks the previous notebook. At first, the forking process sends {"unavailable": …} on the control
socket: the measures that are not available, each with the reason. The grader's requests are single letters:

    r       send both pipes of the waiting child
    t       send {"used": …}: the processor time that the child has used, in seconds
    s, c    end the child, and send {"signal": …, "seconds": …, "memory": …}: the signal that had ended the child before
            (0 for none), its processor time, and its memory in bytes; c means that the child has closed its pipe itself

If the forking process fails, it sends {"failed": …} with the reason, and ends.
"""

import contextlib
import gc
import json
import os
import resource
import select
import signal
import socket
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from . import audit_hook, escape_attempts, folder_removal, isolation, kernel
from .isolation import Measures


def main(config: dict[str, Any]) -> None:
    """Isolate this process, load the libraries, find out which measures work, and serve until the grader ends."""
    control = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    measures = Measures(
        dict.fromkeys(config["disabled_measures"], "switched off"), config["memory"], config["seconds"],
        2_000_000_000 + os.getpid() if os.geteuid() == 0 else None,  # a user that does not exist
    )  # fmt: skip
    namespace = None
    try:
        measures.try_out("namespaces", lambda: _try_namespaces(measures, config["folder"]))
        if measures.is_applied("namespaces"):
            namespace = _enter_namespace(control)
        else:  # become the parent of orphaned processes, to end them, because no namespace does
            with contextlib.suppress(OSError):
                kernel.prctl(kernel.PR_SET_CHILD_SUBREAPER, 1)
        measures.max_processes = _find_process_limit(measures)
        if config["load_libraries"]:
            _load_libraries(config["warm_up"])
        if measures.is_applied("namespaces"):
            isolation.make_private_root(config["folder"])
        if measures.user is not None:
            measures.try_out("user", lambda: isolation.change_user(measures.user))
        measures.unavailable.update(_find_failing_measures(measures, config["folder"]))
        _reply(control, {"unavailable": measures.unavailable})
        _serve(control, measures, config["folder"], namespace)
    except BaseException as error:
        with contextlib.suppress(OSError):
            _reply(control, {"failed": f"{type(error).__name__}: {error}"[:500]})
        raise


def _reply(control: socket.socket, line: dict[str, Any]) -> None:
    control.sendall((json.dumps(line) + "\n").encode())


def _load_libraries(warm_up: bool) -> None:
    """Load the libraries of notebooks, without garbage collection, because they contain no garbage."""
    gc.disable()
    from . import runner

    if warm_up:
        runner.warm_up()
    gc.freeze()  # garbage collection in a child then does not write to the memory that it shares with its parent
    gc.enable()


# --- called once ---


def _try_namespaces(measures: Measures, folder: str) -> None:
    """Try to make a child with separate namespaces, root and folder. Raises OSError if any step fails."""
    isolation.enter_namespaces()

    def set_up_inside() -> None:
        isolation.make_private_root(folder)
        isolation.make_folder(measures, "")
        kernel.unshare(kernel.NEWPID)
        isolation.run_in_child(lambda: None)

    isolation.run_in_child(set_up_inside)


def _enter_namespace(control: socket.socket) -> int:
    """Continue as the first process of a new process namespace, and return a descriptor of the namespace.

    When this process ends, the kernel ends all other processes in the namespace. The original process stays outside and
    waits; if it is killed, this process ends, too.
    """
    isolation.enter_namespaces()
    outside_pid = os.getpid()
    pid = os.fork()
    if pid:
        control.close()
        os.waitpid(pid, 0)
        os._exit(0)
    isolation.die_with_parent(outside_pid)
    return os.open("/proc/self/ns/pid", os.O_RDONLY)


def _find_process_limit(measures: Measures) -> int | None:
    """Return the limit for the processes and threads of a notebook's user; None if they can't be counted.

    If the user is that of this process, the limit includes the processes that the user has already.
    """
    if measures.user is not None and measures.is_applied("user"):
        return isolation.MAX_PROCESSES
    with contextlib.suppress(ValueError, OSError):
        kernel_version = tuple(int(part) for part in os.uname().release.split(".")[:2])
        # Since version 5.14, Linux counts the processes in each user namespace separately.
        if measures.is_applied("namespaces") and kernel_version >= (5, 14):
            return isolation.MAX_PROCESSES
    user_id, thread_count = os.geteuid(), 0
    with contextlib.suppress(OSError):
        for process in Path("/proc").iterdir():
            with contextlib.suppress(OSError):
                if process.name.isdigit() and process.stat().st_uid == user_id:
                    thread_count += len(list(process.joinpath("task").iterdir()))
        return thread_count + 2 * isolation.MAX_PROCESSES
    return None


def _find_failing_measures(measures: Measures, parent: str) -> dict[str, str]:
    """Return the measures that fail when a child applies all measures, each with the reason."""
    folder = isolation.make_folder(measures, parent)

    def apply_all() -> str:
        os.chdir(folder)
        return json.dumps(isolation.apply_measures(measures, folder, os.getppid()))

    try:
        failed_measures: dict[str, str] = json.loads(isolation.run_in_child(apply_all))
    except OSError as error:
        failed_measures = {"all": str(error)}
    _remove_folder(measures, folder)
    return failed_measures


# --- called for every notebook ---


class _Child(NamedTuple):
    """A child that waits for its notebook: its process, its folder, and the grader's ends of its two pipes.

    The pipes are those for the request and for the report, in this order.
    """

    pid: int
    folder: str
    pipes: tuple[int, int]


def _serve(control: socket.socket, measures: Measures, parent: str, namespace: int | None) -> None:
    """Fork a child in advance for each notebook, and answer the grader's requests until the grader ends."""
    while True:
        child = _fork_child(measures, parent, namespace)
        request = b""  # an empty request means that the grader has ended
        with contextlib.suppress(ConnectionError):  # raised if the grader ended and left something unread
            if control.recv(1):
                socket.send_fds(control, [b"p"], child.pipes)
                for descriptor in child.pipes:
                    os.close(descriptor)
                _watch_until_request(control, measures, child)
                while (request := control.recv(1)) == b"t":
                    _reply(control, {"used": _read_processor_time(child.pid)})
                    _watch_until_request(control, measures, child)
        ending_signal, cost = _end_child(child.pid, patience=0.2 if request == b"c" else 0.0)
        _remove_folder(measures, child.folder)
        if not request:
            return
        _reply(control, {"signal": ending_signal, **cost})


COUNT_INTERVAL = 0.01
"""Interval in seconds at which the files that a notebook has written are counted."""


def _watch_until_request(control: socket.socket, measures: Measures, child: _Child) -> None:
    """Wait for a request of the grader; meanwhile, kill the notebook if it writes more than its limit.

    In a private root, nothing is counted, because the folder is a file system of limited size.
    """
    is_counted = measures.is_applied("quota") and not measures.is_applied("namespaces")
    while is_counted and not select.select([control], [], [], COUNT_INTERVAL)[0]:
        if isolation.exceeds_disk_limit(measures, child.folder, child.pid):
            with contextlib.suppress(OSError):
                os.kill(child.pid, signal.SIGKILL)


def _read_processor_time(pid: int) -> float:
    """Return the processor time of a process in seconds; 0 if the system doesn't report the time (macOS)."""
    try:
        return time.clock_gettime(~pid << 3 | 2)  # the clock that clock_getcpuclockid returns on Linux
    except OSError:
        return 0.0


def _fork_child(measures: Measures, parent: str, namespace: int | None) -> _Child:
    """Fork a child with a separate namespace, folder and pipes; `namespace` is the descriptor of this process's own."""
    request_reader, request_writer = os.pipe()
    report_reader, report_writer = os.pipe()
    folder = isolation.make_folder(measures, parent)
    if namespace is not None:
        kernel.setns(namespace, kernel.NEWPID)
        kernel.unshare(kernel.NEWPID)
    parent_pid = os.getpid()
    pid = os.fork()
    if pid == 0:
        _run_child(measures, folder, parent_pid, request_reader, report_writer)
    os.close(request_reader)
    os.close(report_writer)
    return _Child(pid, folder, (request_writer, report_reader))


def _run_child(measures: Measures, folder: str, parent_pid: int, request_reader: int, report_writer: int) -> NoReturn:
    """Run one notebook in this process, and end the process."""
    try:
        os.setsid()
        sys.setrecursionlimit(3000)  # for long formulas; Python's default is 1000
        os.environ.update(HOME=folder, TMPDIR=folder, MPLCONFIGDIR=folder, XDG_CACHE_HOME=folder)
        tempfile.tempdir = folder
        try:
            null_device = os.open(os.devnull, os.O_RDWR)
            for descriptor in (0, 1, 2):
                os.dup2(null_device, descriptor)
            _close_descriptors_except({request_reader, report_writer})
            os.chdir(folder)
            failed_measures = isolation.apply_measures(measures, folder, parent_pid)
        except OSError as error:
            _report(report_writer, {"failed": str(error)})
        else:
            _report(report_writer, {"unprotected": failed_measures} if failed_measures else {"isolated": True})
            if not failed_measures:
                _run_request(measures, folder, request_reader, report_writer)
    finally:
        os._exit(0)


def _run_request(measures: Measures, folder: str, request_reader: int, report_writer: int) -> None:
    """Read the request, and run the notebook or make the attempts of a probe."""
    with open(request_reader, "rb", closefd=False) as pipe:
        line = pipe.readline()
    if not line.endswith(b"\n"):  # the grader has closed the pipe
        os._exit(0)
    request = json.loads(line)
    _report(report_writer, {"begun": True})
    sent_bytes = 0

    def report(line: dict[str, Any]) -> None:
        nonlocal sent_bytes
        sent_bytes += _report(report_writer, line) if sent_bytes <= isolation.MAX_REPORT_BYTES else 0
        os.read(request_reader, 1)  # wait until the grader has the line, before another cell runs and may do harm

    if "attempts" in request:
        escape_attempts.make_attempts(request["attempts"], report)
        return
    from . import runner

    for name, source in request.get("modules", {}).items():
        Path(name).write_text(source, encoding="utf-8", errors="replace")
    if measures.is_applied("watch"):
        sys.addaudithook(audit_hook.make_audit_hook(folder))
    runner.run_cells(request, report)


def _report(report_writer: int, line: dict[str, Any]) -> int:
    """Write a line of JSON to the grader; return its length in bytes."""
    data = (json.dumps(line) + "\n").encode()
    unsent_bytes = data
    while unsent_bytes:
        unsent_bytes = unsent_bytes[os.write(report_writer, unsent_bytes) :]
    return len(data)


def _close_descriptors_except(pipes: set[int]) -> None:
    """Close every descriptor above standard error, including the control socket, except the pipes."""
    soft_limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    first_descriptor = 3
    # Linux closes a range at once, so its end may lie far above all open descriptors.
    for descriptor in (*sorted(pipes), soft_limit if sys.platform == "darwin" else 65536):
        os.closerange(first_descriptor, descriptor)
        first_descriptor = descriptor + 1


def _end_child(pid: int, patience: float) -> tuple[int, dict[str, float]]:
    """Kill a child and its descendants; return the signal that had already ended the child (0 if none), and its cost.

    The cost is the child's processor time in seconds and its memory in bytes. The child first gets `patience` seconds
    to end by itself: if it has closed its pipe, the signal that ends it shows the cause.
    """
    deadline = time.monotonic() + patience
    ended_pid, status, usage = os.wait4(pid, os.WNOHANG)  # not waitid, which macOS has only since Python 3.13
    while not ended_pid and time.monotonic() < deadline:
        time.sleep(0.001)
        ended_pid, status, usage = os.wait4(pid, os.WNOHANG)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    if not ended_pid:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(pid, signal.SIGKILL)
        _, _, usage = os.wait4(pid, 0)
    _kill_orphans()
    ending_signal = os.WTERMSIG(status) if ended_pid and os.WIFSIGNALED(status) else 0
    return ending_signal, {"seconds": usage.ru_utime + usage.ru_stime, "memory": usage.ru_maxrss * _MEMORY_UNIT}


_MEMORY_UNIT = 1 if sys.platform == "darwin" else 1024
"""Number of bytes in the unit in which the system reports memory."""


def _kill_orphans() -> None:
    """Kill the orphaned processes of a dead child, and the orphans that this makes, until no process is left."""
    while True:
        with contextlib.suppress(OSError):
            for pid in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split():
                os.kill(int(pid), signal.SIGKILL)
        try:
            if os.waitpid(-1, os.WNOHANG)[0] == 0:
                time.sleep(0.001)
        except ChildProcessError:
            return


def _remove_folder(measures: Measures, folder: str) -> None:
    if measures.is_applied("namespaces"):
        kernel.unmount(isolation.NOTEBOOK_FOLDER)
    else:
        with contextlib.suppress(OSError):  # remaining files are removed with the sandbox's folder
            folder_removal.remove_folder(folder)
