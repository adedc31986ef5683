"""Measure the cost of exporting banks with many variants, compared with generating the problems alone."""

import sys
from collections.abc import Iterator
from pathlib import Path

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.grader.grading.certify import find_failures
from tests.support import ROOT

from .clock import processor_time
from .figures import Figure
from .starting import QDOT

VARIANTS = 30
GOALS = {"qti": 4.0, "moodle": 4.0, "stack": 7.0, "prairielearn": 1.5}
"""The largest allowed ratio of an export's time to that of the problems alone. For STACK, Maxima runs each question."""


def exporting(folder: Path) -> Iterator[Figure]:
    """Yield the time of a bank of every export format in one process; the same secret gives all the same problems."""
    place = folder / "bank"
    students, secret = (Student("ada", "Ada"),), "0123456789abcdef"
    init_assignment(place, "Homework", "homework", students, secret, problem_set=SETS[DEFAULT_SET])
    bank_alone = processor_time([sys.executable, "-m", __name__, str(place)], folder, paths=str(ROOT))
    for export_format, goal in GOALS.items():
        command = [*QDOT, "export", str(place), "--to", export_format, "--variants", str(VARIANTS), "--jobs", "1"]
        taken = processor_time(command, folder)
        what = f"`qdot export --to {export_format} --variants {VARIANTS}`"
        yield Figure(what, taken, "generating and certifying the problems", bank_alone, goal)


if __name__ == "__main__":  # only the problems of a bank
    request = ExportRequest(load_assignment(Path(sys.argv[1])), find_failures, variant_count=VARIANTS)
    if not sum(1 for _ in iterate_bank(request)):
        sys.exit("no problem was generated")
