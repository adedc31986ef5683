"""Generating beside commit 99c67fc, whose code is taken from the repository: processor time of the same work."""

import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

from tests.support import ROOT

from .clock import processor_time

COMMIT = "99c67fc"
NEEDED = "latex2mathml>=3.77.0,<4"
"""What it needs that qdot no longer does."""
MIXED = ("planar-2r", "polar-rp", "planar-pr", "cylindrical", "elbow-3r")
"""Families of a class's five problems; five questions each."""
OF_SITE = ("planar-2r", "polar-rp")
"""Families of the site's records."""
SLOT = """
[[problem]]
family = "{}"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""
RECORDS = """
import sys
from exercises.problem import ProblemId
from exercises.verify import certify
try:
    from exercises.generation import generate
except ImportError:
    from exercises.generate import generate
from exercises.site.record import site_record, solutions_record, translated_record, translated_solutions
families, first, last = sys.argv[1].split(","), int(sys.argv[2]), int(sys.argv[3])
for seed in range(first, last):
    for family in families:
        problem = generate(ProblemId(family, seed))
        certify(problem)
        record = site_record(problem)
        solutions_record(problem), translated_record(problem, record, "de"), translated_solutions(problem, "de")
"""


def unpacked(folder: Path) -> Path | None:
    """Return the folder of the older code; None where that can't be had, as in a shallow clone."""
    done = subprocess.run(["git", "archive", COMMIT, "exercises", "grader", "templates"], cwd=ROOT, capture_output=True)
    if done.returncode:
        return None
    packed = folder / "older.tar"
    packed.write_bytes(done.stdout)
    with tarfile.open(packed) as archive:
        archive.extractall(folder / "older", filter="data")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "install", "--no-deps"]
    done = subprocess.run([*pip, "--target", str(folder / "older"), NEEDED], capture_output=True)
    return None if done.returncode else folder / "older"


def generating(code: Path, folder: Path, more: int) -> float:
    """Return the seconds for each student more: a class of two beside one with so many more, structures all met."""
    return (_class(code, folder / "large", 2 + more) - _class(code, folder / "small", 2)) / more


def _class(code: Path, folder: Path, students: int) -> float:
    command = [sys.executable, "-m", "grader.cli"]
    roster = folder.with_suffix(".csv")
    roster.parent.mkdir(parents=True, exist_ok=True)
    roster.write_text("student,name,email\n" + "".join(f"s{n:05d},,\n" for n in range(students)), encoding="utf-8")
    processor_time([*command, "init", str(folder), "--key", "bench"], folder.parent, str(code))
    (folder / "roster.csv").write_bytes(roster.read_bytes())
    file = folder / "assignment.toml"
    head = file.read_text("utf-8").split("\n[[problem]]")[0]
    file.write_text(head + "".join(map(SLOT.format, MIXED)), encoding="utf-8")
    return processor_time([*command, "generate", str(folder), "--jobs", "1"], folder.parent, str(code))


def records(code: Path, more: int) -> float:
    """Return the seconds for each record of the site more, every question asked, structures all met."""

    def taken(last: int) -> float:
        with tempfile.TemporaryDirectory() as folder:
            line = [sys.executable, "-c", RECORDS, ",".join(OF_SITE), "1", str(last)]
            return processor_time(line, Path(folder), str(code))

    return (taken(2 + more) - taken(2)) / (more * len(OF_SITE))
