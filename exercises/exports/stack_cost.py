"""The processor time that marking takes, measured by running question tests of STACK questions in Maxima here.

STACK gives up on a question after 30 seconds, some of which it needs for itself. Our marking does not use STACK's
library, so it is not needed here.
"""

import shutil
import subprocess
from collections.abc import Sequence

from qdot.exercises.exports.stack_parts import Case, StackPart

LIMIT = 5.0
"""Maximum processor time for marking one answer, in seconds."""
NEXT_TO_NOTHING = LIMIT / 10
PATIENCE = 60.0
"""Seconds after which Maxima is stopped."""


def costs(parts: Sequence[StackPart]) -> list[float] | None:
    """Return the seconds that the most expensive question test of each part takes; None if there is no Maxima.

    If the first test of a part takes next to nothing, the others are not run. A part that was stopped counts PATIENCE.
    """
    program = shutil.which("maxima")
    if program is None:
        return None
    seconds: list[float] = []
    while len(seconds) < len(parts):
        measured = _measure_costs(program, parts[len(seconds) :])
        if measured is None:
            return None
        seconds += measured or [PATIENCE]
    return seconds


def _measure_costs(program: str, parts: Sequence[StackPart]) -> list[float] | None:
    """Return the cost of each part in turn, of those that Maxima finished before it ended or was stopped.

    None if it ended by itself before it finished any.
    """
    was_stopped = False
    script = "\n".join(map(_script, parts)).encode()
    try:
        command = [program, "--very-quiet"]
        printed = subprocess.run(command, input=script, capture_output=True, timeout=PATIENCE, check=False).stdout
    except subprocess.TimeoutExpired as stopped:
        printed, was_stopped = stopped.stdout or b"", True
    lines = printed.decode(errors="replace").splitlines()
    seconds = [float(line.split()[1]) for line in lines if line.startswith("COST")]
    return seconds if seconds or was_stopped else None


def _script(part: StackPart) -> str:
    """Return Maxima code that prints the seconds for the variables and the most expensive test.

    All tests run the same lines. If the first takes next to nothing, none of the others is too expensive.
    """
    first, *others = (_test_lines(part, case) for case in part.cases)
    lines = ["qdot_start: elapsed_run_time()", *part.variables, "qdot_variables: elapsed_run_time() - qdot_start"]
    lines += [
        "qdot_dearest: 0",
        first,
        f"if qdot_variables + qdot_dearest > {NEXT_TO_NOTHING} then {_join_lines(others)}",
    ]
    lines.append('print("COST", float(qdot_variables + qdot_dearest))')
    return "\n".join(f"{line.removesuffix(';')}$" for line in lines)


def _test_lines(part: StackPart, case: Case) -> str:
    lines = ["qdot_start: elapsed_run_time();", f"ans1: {case.value};", *part.marking]
    return _join_lines([*lines, "qdot_dearest: max(qdot_dearest, elapsed_run_time() - qdot_start);"])


def _join_lines(lines: Sequence[str]) -> str:
    """Return one expression that runs the lines in turn."""
    return f"({', '.join(line.removesuffix(';') for line in lines)})"
