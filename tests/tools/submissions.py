"""`make fuzz`, too: what nobody should hand in, handed in by one of a class; it reaches nobody else.

In every round one of three students hands in something drawn from a seed (`hostile`), beside a neighbour whose notebook
is right. The class is graded as `qdot grade` does it, in this process, and now and then by the command itself. Nothing
may be raised; the neighbour has full marks; the student has a result in words that can be read; all that is written can
be read back, and nothing outside graded/ has changed. `python -m tests.tools.submissions --seconds 3600 --seed 1`
prints the finds, keeps their folders, and leaves with code 1 if there are any; `--seed 1 --only 17` repeats one round.
"""

import argparse
import contextlib
import csv
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.stream import Stream
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import find_work_status
from qdot.grader.sandbox.notebook_process import folder_removal
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions, open_submissions
from tests.support import ROOT
from tests.support.results import get_counted_file, read_results
from tests.support.submitting import make_class, make_correct_notebook, work_in_one_process
from tests.tools.hostile import ATTACKER, NEIGHBOUR, submit_random

LIMITS = Limits(seconds=6, cell_seconds=2)
LONGEST, HANGS = 60.0, 900.0
"""Limits for a class in seconds: processor time, and wall-clock time on a busy machine."""
COMMAND, ZIPPED, FLAT = 40, 9, 4
"""One of this many rounds uses the command, one a platform's zip, and one a neighbour without a folder."""

FULL = 4
STATES = ("graded", "unusable", "missing", "ungraded", "over limit", "late")
Hand = Callable[[Path, str], str]
"""A function that puts something into the submissions folder, given a right notebook, and describes it."""


class Find(AssertionError):
    """Something happened that must never happen."""


def _spent() -> float:
    """Return the processor time of this process and of those that it has seen end."""
    return sum(os.times()[:4])


class Class:
    """A class of three: an ordinary student, one who submits anything at all, and one who submits nothing."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        students = [Student(NEIGHBOUR, "Ada One"), Student(ATTACKER, "Bo Two"), Student("s03", "Cy Three")]
        self.assignment: Assignment = make_class(folder, students)
        self.right = {student: make_correct_notebook(self.assignment, student) for student in (NEIGHBOUR, ATTACKER)}
        self.submitted, self.graded = folder / "submitted", folder / "graded"
        self.clear()
        self.round(lambda *_: "nothing")  # what is kept of the problems is there from now on

    def clear(self, flat: bool = False) -> None:
        """Start again with the neighbour's submission, in a folder or as a file."""
        for folder in (self.submitted, self.graded):
            if folder.is_dir():
                folder_removal.remove_folder(str(folder))
        place = self.submitted / (f"{NEIGHBOUR}.ipynb" if flat else f"{NEIGHBOUR}/hw.ipynb")
        place.parent.mkdir(parents=True)
        place.write_text(self.right[NEIGHBOUR])

    def round(
        self, hand: Hand, by_command: bool = False, zipped: bool = False, flat: bool = False
    ) -> tuple[str, Result]:
        """Submit one thing and grade the class; return its description and the student's result. Raises Find."""
        self.clear(flat)
        case = hand(self.submitted, self.right[ATTACKER])
        try:
            source = _packed(self.submitted) if zipped else self.submitted
            before, begun = dict(_state(self.folder)), (time.monotonic(), _spent())
            said = self._by_command(source) if by_command else self._here(source)
            waited, spent = time.monotonic() - begun[0], _spent() - begun[1]
            if spent > LONGEST or waited > HANGS:
                raise Find(f"takes {spent:.0f} s of processor time, {waited:.0f} s by the clock")
            after = dict(_state(self.folder))
            if before != after:
                other = sorted(path for path in {*before, *after} if before.get(path) != after.get(path))
                raise Find(f"outside graded/ was changed: {other[:5]}")
            return case, self._looked_at(said)
        except Exception as error:
            error.add_note(case)
            raise

    def _here(self, source: Path) -> list[str]:
        """Grade in this process; return what the command would report about the folder."""
        with open_submissions(source) as root, work_in_one_process():
            looked = find_submissions(self.assignment, root)
            results = grade_class(self.assignment, looked.by_student, 0, LIMITS)
            results = write_reports(self.assignment, results)
        if _results(self.graded) != results:
            raise Find("results.jsonl is not what was graded")
        return [*looked.not_on_roster, *looked.uncertain_owners]

    def _by_command(self, source: Path) -> list[str]:
        command = [sys.executable, "-m", "qdot", "grade", self.folder, source, "--jobs", "1", "--seconds", "6"]
        done = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, timeout=HANGS)
        told = (done.stdout + done.stderr).decode()  # raises where it is no text
        if done.returncode not in (0, 2) or "Traceback" in told or "Warning:" in told or not _is_there(self.graded):
            raise Find(f"qdot grade ends with {done.returncode}: {told[-500:]}")
        return told.splitlines()

    def _looked_at(self, said: list[str]) -> Result:
        """Check all written files; return the student's result."""
        results = _results(self.graded)
        with (self.graded / "grades.csv").open(encoding="utf-8", newline="") as table:
            rows = {row["student"]: row for row in csv.DictReader(table)}
        by_id = {result.student: result for result in results}
        if set(by_id) != set(rows) or set(by_id) != {student.id for student in self.assignment.roster}:
            raise Find(f"not everybody is there: {sorted(by_id)}, {sorted(rows)}")
        for student, result in by_id.items():
            page = (self.graded / "feedback" / f"{student}.html").read_text(encoding="utf-8")
            if not page.endswith("</html>\n") or "<script>alert" in page:
                raise Find(f"the page of {student} is not whole, or runs what a student wrote")
            if find_work_status(result) not in STATES or rows[student]["status"] != find_work_status(result):
                raise Find(f"{student} is {find_work_status(result)}, and in the table {rows[student]['status']}")
            said += _words(result)
        neighbour = by_id[NEIGHBOUR]
        if (neighbour.score, find_work_status(neighbour)) != (FULL, "graded"):
            raise Find(f"the neighbour is {find_work_status(neighbour)} with {neighbour.score}: {_words(neighbour)}")
        for text in said:
            if not all(ch.isprintable() or ch == "\n" for ch in text):
                raise Find(f"this can't be shown: {text[:300]!a}")
        return by_id[ATTACKER]


def _is_there(graded: Path) -> bool:
    return (graded / "results.jsonl").is_file()


def _results(graded: Path) -> list[Result]:
    return list(read_results(graded.parent).values())


def _words(result: Result) -> list[str]:
    """Return all that is said of a result, to whomever."""
    words = [result.obstacle, get_counted_file(result), *result.notes, *result.staff_notes]
    return [text for text in (*words, *(part.reason for part in result.parts.values())) if text]


def _state(folder: Path) -> Iterator[tuple[bytes, Any]]:
    """Yield what lies in the folder but for graded/, as deep as paths go: of each file its rights, time and content."""
    stack = [os.fsencode(folder)]
    while stack:
        top = stack.pop()
        with contextlib.suppress(OSError), os.scandir(top) as entries:
            for entry in entries:
                if entry.path == os.fsencode(folder / "graded"):
                    continue
                known = entry.stat(follow_symlinks=False)
                is_small = stat.S_ISREG(known.st_mode) and known.st_size < 1_000_000
                content = None
                with contextlib.suppress(PermissionError):
                    content = sha256(Path(os.fsdecode(entry.path)).read_bytes()).digest() if is_small else None
                yield entry.path, (known.st_mode, known.st_size, known.st_mtime_ns, content)
                if entry.is_dir(follow_symlinks=False):
                    stack.append(entry.path)


def _packed(submitted: Path) -> Path:
    """Return a zip with what lies in the folder, as a platform packs it: files by their names, nothing else."""
    target = submitted.with_suffix(".zip")
    with zipfile.ZipFile(target, "w", strict_timestamps=False) as archive:
        for name, (mode, size, *_) in _state(submitted):
            path = Path(os.fsdecode(name))
            if stat.S_ISREG(mode) and size < 100_000_000:
                with contextlib.suppress(OSError, ValueError):  # names that a zip does not hold
                    archive.write(path, path.relative_to(submitted))
    return target


def drawn_round(of: Class, seed: str, number: int) -> tuple[str, Result]:
    """Grade one round, which depends only on the seed and the round's number."""
    rng, last = Stream(f"submissions/{seed}/{number}"), number % COMMAND == COMMAND - 1
    zipped, flat = number % ZIPPED == ZIPPED - 1, number % FLAT == FLAT - 1
    return of.round(lambda root, text: submit_random(root, text, rng), last, zipped, flat)


def main() -> int:
    """Run rounds for some time, and count what they find."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=120, help="how long it runs")
    parser.add_argument("--seed", default="1", help="what all rounds are drawn from")
    parser.add_argument("--only", type=int, help="one round alone, by its number")
    options = parser.parse_args()
    warnings.simplefilter("error")  # nothing of the sort belongs on a grader's screen
    folder, end = Path(tempfile.mkdtemp(prefix="qdot-hostile-")), time.monotonic() + options.seconds
    made, finds, states, failures = Class(folder / "hw"), 0, Counter[str](), Counter[str]()
    number = rounds = options.only or 0
    while number == options.only or (options.only is None and time.monotonic() < end):
        try:
            case, result = drawn_round(made, options.seed, number)
            states[find_work_status(result)] += 1
            if options.only is not None:
                sys.stdout.write(f"{case}: {find_work_status(result)}: {_words(result)}\n")
            if find_work_status(result) == "ungraded":
                failures[f"{result.problems[0].parts[0].reason[:160]}, as in --only {number}"] += 1
        except Exception as error:  # told, and kept
            finds += 1
            kept = Path(tempfile.mkdtemp(prefix=f"qdot-find-{options.seed}-{number}-"))
            for name in ("submitted", "graded"):
                with contextlib.suppress(OSError):
                    shutil.move(made.folder / name, kept / name)
            about = f"{type(error).__name__}: {str(error)[:500]}: {'; '.join(getattr(error, '__notes__', ()))}"
            sys.stdout.write(f"find: --seed {options.seed} --only {number}: {about}, kept in {kept}\n")
        number += 1
        sys.stdout.flush()
    folder_removal.remove_folder(str(folder))
    for said, count in failures.most_common():
        sys.stdout.write(f"ungraded {count} times: {said}\n")
    sys.stdout.write(f"{number - rounds} rounds ({dict(states)}): {finds} finds\n")
    return 1 if finds else 0


if __name__ == "__main__":
    sys.exit(main())
