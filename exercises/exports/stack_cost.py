"""What marking costs: question tests of STACK questions run by Maxima on this machine, and their processor time.

STACK gives up on what takes it longer than 30 seconds, of which it needs some for itself. Its own library takes no
part in our marking, and is not needed here.
"""

import shutil
import subprocess
from collections.abc import Sequence

from qdot.exercises.exports.stack_parts import Case, StackPart

LIMIT = 5.0
"""Seconds of processor time that the marking of one answer may take."""
NEXT_TO_NOTHING = LIMIT / 10
PATIENCE = 60.0
"""Seconds after which Maxima is stopped."""


def costs(parts: Sequence[StackPart]) -> list[float] | None:
    """Return the seconds that the dearest question test of each part takes; None where no Maxima runs.

    Of a part whose first test takes next to nothing, that is what the first one takes.

    What had to be stopped has cost PATIENCE.
    """
    program = shutil.which("maxima")
    if program is None:
        return None
    found: list[float] = []
    while len(found) < len(parts):
        measured = _measured(program, parts[len(found) :])
        if measured is None:
            return None
        found += measured or [PATIENCE]
    return found


def _measured(program: str, parts: Sequence[StackPart]) -> list[float] | None:
    """Return the cost of each part in turn, of those with which Maxima was done before it stopped or was stopped.

    None where it stopped by itself before it was done with any.
    """
    was_stopped = False
    script = "\n".join(map(_script, parts)).encode()
    try:
        command = [program, "--very-quiet"]
        printed = subprocess.run(command, input=script, capture_output=True, timeout=PATIENCE, check=False).stdout
    except subprocess.TimeoutExpired as stopped:
        printed, was_stopped = stopped.stdout or b"", True
    lines = printed.decode(errors="replace").splitlines()
    found = [float(line.split()[1]) for line in lines if line.startswith("COST")]
    return found if found or was_stopped else None


def _script(part: StackPart) -> str:
    """Return Maxima that prints the seconds of the variables and of the dearest test.

    All tests run the same lines. Where the first takes next to nothing, none of the others is too dear.
    """
    first, *others = (_run(part, case) for case in part.cases)
    lines = ["qdot_start: elapsed_run_time()", *part.variables, "qdot_variables: elapsed_run_time() - qdot_start"]
    lines += ["qdot_dearest: 0", first, f"if qdot_variables + qdot_dearest > {NEXT_TO_NOTHING} then {_all(others)}"]
    lines.append('print("COST", float(qdot_variables + qdot_dearest))')
    return "\n".join(f"{line.removesuffix(';')}$" for line in lines)


def _run(part: StackPart, case: Case) -> str:
    lines = ["qdot_start: elapsed_run_time();", f"ans1: {case.value};", *part.marking]
    return _all([*lines, "qdot_dearest: max(qdot_dearest, elapsed_run_time() - qdot_start);"])


def _all(lines: Sequence[str]) -> str:
    """Return one expression that runs lines in turn."""
    return f"({', '.join(line.removesuffix(';') for line in lines)})"
