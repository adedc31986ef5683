"""Measure how long commands take. The baseline is a Python process that only loads SymPy and NumPy."""

import sys
from collections.abc import Iterator
from pathlib import Path

from .clock import middle, processor_time
from .figures import Figure

QDOT = [sys.executable, "-m", "qdot"]
LOADED = "loading SymPy and NumPy"


def loading() -> float:
    """Return the seconds of loading SymPy and NumPy: what everything is measured beside."""
    return middle(lambda: processor_time([sys.executable, "-c", "import sympy, numpy, os; os._exit(0)"]))


def starting(notebook: Path, folder: Path) -> Iterator[Figure]:
    """Yield what commands take that do one thing; `notebook` is a student's, and robots are written into a folder."""
    beside = loading()

    def figure(what: str, goal: float, *command: str) -> Figure:
        seconds = middle(lambda: processor_time(command, folder))
        return Figure(what, seconds, LOADED, beside, goal, of_seconds=True)

    robot = folder / "arm.toml"
    joint = '[[joint]]\nkind = "R"\ntheta = "theta{0}"\nd = 0\na = {1}\nalpha = 0\n'
    about = 'name = "arm"\ntask = ["vx", "vy"]\n'
    robot.write_text(about + joint.format(1, 0.5) + joint.format(2, 0.4), encoding="utf-8")
    yield figure("`import qdot`", 0.3, sys.executable, "-c", "import qdot")
    yield figure("`qdot --help`", 0.3, *QDOT, "--help")
    yield figure("`qdot check NOTEBOOK`", 1, *QDOT, "check", str(notebook))
    yield figure("`qdot show planar-2r/7`", 0.5, *QDOT, "show", "planar-2r/7")
    yield figure("`qdot solve`, a planar arm of two joints", 0.5, *QDOT, "solve", str(robot))
