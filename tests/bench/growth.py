"""How time and memory grow with the class: `python -m tests.bench.growth 100 1000 10000` (hours; 30 and 100 without).

The assignment is Examples 6.1 and 6.2. Time is wall time for each student on all cores, memory that of the largest
process; both should stay the same, whatever the size.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from exercises.assignment import Student, load_assignment
from exercises.release import init_assignment
from exercises.store import kept
from grader.demo import answered

SIZES = (30, 100)
SLOT = """
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""


def main() -> int:
    """Print a line for each size."""
    sizes = [int(size) for size in sys.argv[1:]] or list(SIZES)
    sys.stdout.write(f"{'students':>8} {'generate':>22} {'grade':>22}\n")
    for size in sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "class"
            init_assignment(
                folder, "Growth", "bench", [Student(f"s{n:05d}") for n in range(size)], "a secret, long enough"
            )
            file = folder / "assignment.toml"
            file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOT, encoding="utf-8")
            made = measured("generate", folder)
            hand_in(folder)
            graded = measured("grade", folder)
            cells = (f"{1000 * seconds / size:8.0f} ms {memory:6.0f} MB" for seconds, memory in (made, graded))
            sys.stdout.write(f"{size:>8} {'   '.join(cells)}\n")
            sys.stdout.flush()
    return 0


def measured(verb: str, folder: Path) -> tuple[float, float]:
    """Return seconds and the megabytes of the largest process of a command."""
    command = [sys.executable, "-m", "grader.cli", verb, str(folder)]
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status):
        raise SystemExit(f"qdot {verb} failed")
    scale = 1 << 20 if sys.platform == "darwin" else 1 << 10
    return time.perf_counter() - start, usage.ru_maxrss / scale


def hand_in(folder: Path) -> None:
    """Hand the solutions in."""
    assignment = load_assignment(folder)
    for student in assignment.roster:
        target = folder / "submitted" / f"{student.id}.ipynb"
        text = (folder / "released" / student.id / "bench.ipynb").read_text("utf-8")
        problems = kept(assignment, student.id).problems
        target.write_text(answered(text, problems, lambda code, _: code), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
