"""Grade classes in which one student submits something hostile or broken; `make fuzz` includes this.

In each round, the attacker submits something generated from a seed (`hostile`), and the neighbour submits a correct
notebook. Most rounds grade the class in this process, as `qdot grade` would; some call the command itself. No exception
may be raised. The neighbour must get full marks, and the attacker's result must be printable text. All files must be
readable, and nothing outside graded/ may change. `python -m tests.tools.submissions --seconds 3600 --seed 1` prints the
faults that it finds, stores their folders, and exits with code 1 if there are any; `--seed 1 --only 17` repeats a
round.
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
MAX_PROCESSOR_SECONDS, MAX_SECONDS = 60.0, 900.0
"""Limits for a class in seconds: processor time, and wall-clock time on a busy machine."""
COMMAND_INTERVAL, ZIP_INTERVAL, FLAT_INTERVAL = 40, 9, 4
"""One round in this many calls `qdot grade`, grades a platform's zip, or gives the neighbour no folder."""

FULL_SCORE = 4
STATES = ("graded", "unusable", "missing", "ungraded", "over limit", "late")
Submit = Callable[[Path, str], str]
"""A function that writes something into the folder of submissions, given a correct notebook, and describes it."""


class Find(AssertionError):
    """A violated requirement."""


def _measure_processor_time() -> float:
    return sum(os.times()[:4])


class HostileClass:
    """A class of three students: the neighbour, the attacker, and one who submits nothing."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        students = [Student(NEIGHBOUR, "Ada One"), Student(ATTACKER, "Bo Two"), Student("s03", "Cy Three")]
        self.assignment: Assignment = make_class(folder, students)
        self.correct_notebooks = {
            student: make_correct_notebook(self.assignment, student) for student in (NEIGHBOUR, ATTACKER)
        }
        self.submitted, self.graded = folder / "submitted", folder / "graded"
        self.clear()
        self.grade_round(lambda *_: "nothing")  # so that all caches exist before the first real round

    def clear(self, flat: bool = False) -> None:
        for folder in (self.submitted, self.graded):
            if folder.is_dir():
                folder_removal.remove_folder(str(folder))
        place = self.submitted / (f"{NEIGHBOUR}.ipynb" if flat else f"{NEIGHBOUR}/hw.ipynb")
        place.parent.mkdir(parents=True)
        place.write_text(self.correct_notebooks[NEIGHBOUR])

    def grade_round(
        self, submit: Submit, by_command: bool = False, zipped: bool = False, flat: bool = False
    ) -> tuple[str, Result]:
        """Submit one thing and grade the class; return its description and the student's result. Raises Find."""
        self.clear(flat)
        description = submit(self.submitted, self.correct_notebooks[ATTACKER])
        try:
            source = _zip_submissions(self.submitted) if zipped else self.submitted
            old_states = dict(_list_file_states(self.folder))
            start, processor_start = time.monotonic(), _measure_processor_time()
            messages = self._grade_by_command(source) if by_command else self._grade_here(source)
            elapsed, processor_time = time.monotonic() - start, _measure_processor_time() - processor_start
            if processor_time > MAX_PROCESSOR_SECONDS or elapsed > MAX_SECONDS:
                raise Find(f"takes {processor_time:.0f} s of processor time, {elapsed:.0f} s by the clock")
            new_states = dict(_list_file_states(self.folder))
            if old_states != new_states:
                paths = sorted({*old_states, *new_states})
                changed_paths = [path for path in paths if old_states.get(path) != new_states.get(path)]
                raise Find(f"outside graded/ was changed: {changed_paths[:5]}")
            return description, self._check_files(messages)
        except Exception as error:
            error.add_note(description)
            raise

    def _grade_here(self, source: Path) -> list[str]:
        """Grade in this process; return what the command would report about the folder."""
        with open_submissions(source) as root, work_in_one_process():
            submissions = find_submissions(self.assignment, root)
            results = grade_class(self.assignment, submissions.by_student, 0, LIMITS)
            results = write_reports(self.assignment, results)
        if _read_class_results(self.graded) != results:
            raise Find("results.jsonl is not what was graded")
        return [*submissions.not_on_roster, *submissions.uncertain_owners]

    def _grade_by_command(self, source: Path) -> list[str]:
        command = [sys.executable, "-m", "qdot", "grade", self.folder, source, "--jobs", "1", "--seconds", "6"]
        process = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, timeout=MAX_SECONDS)
        output = (process.stdout + process.stderr).decode()  # raises an error if it is not UTF-8
        has_failed = process.returncode not in (0, 2) or "Traceback" in output or "Warning:" in output
        if has_failed or not (self.graded / "results.jsonl").is_file():
            raise Find(f"qdot grade ends with {process.returncode}: {output[-500:]}")
        return output.splitlines()

    def _check_files(self, messages: list[str]) -> Result:
        """Check all written files and the messages; return the student's result."""
        results = _read_class_results(self.graded)
        with (self.graded / "grades.csv").open(encoding="utf-8", newline="") as table:
            rows = {row["student"]: row for row in csv.DictReader(table)}
        by_id = {result.student: result for result in results}
        if set(by_id) != set(rows) or set(by_id) != {student.id for student in self.assignment.roster}:
            raise Find(f"a student is missing: {sorted(by_id)}, {sorted(rows)}")
        for student, result in by_id.items():
            page = (self.graded / "feedback" / f"{student}.html").read_text(encoding="utf-8")
            if not page.endswith("</html>\n") or "<script>alert" in page:
                raise Find(f"the page of {student} is incomplete, or runs a script of a student")
            if find_work_status(result) not in STATES or rows[student]["status"] != find_work_status(result):
                raise Find(f"{student} is {find_work_status(result)}, and in the table {rows[student]['status']}")
            messages += _list_messages(result)
        neighbour = by_id[NEIGHBOUR]
        if (neighbour.score, find_work_status(neighbour)) != (FULL_SCORE, "graded"):
            status = find_work_status(neighbour)
            raise Find(f"the neighbour is {status} with {neighbour.score}: {_list_messages(neighbour)}")
        for text in messages:
            if not all(ch.isprintable() or ch == "\n" for ch in text):
                raise Find(f"this can't be shown: {text[:300]!a}")
        return by_id[ATTACKER]


def _read_class_results(graded: Path) -> list[Result]:
    return list(read_results(graded.parent).values())


def _list_messages(result: Result) -> list[str]:
    texts = [result.obstacle, get_counted_file(result), *result.notes, *result.staff_notes]
    return [text for text in (*texts, *(part.reason for part in result.parts.values())) if text]


def _list_file_states(folder: Path) -> Iterator[tuple[bytes, Any]]:
    """Yield the paths of all files outside graded/, each with its mode, size, time and digest of the content."""
    stack = [os.fsencode(folder)]
    while stack:
        current_folder = stack.pop()
        with contextlib.suppress(OSError), os.scandir(current_folder) as entries:
            for entry in entries:
                if entry.path == os.fsencode(folder / "graded"):
                    continue
                status = entry.stat(follow_symlinks=False)
                is_small = stat.S_ISREG(status.st_mode) and status.st_size < 1_000_000
                content = None
                with contextlib.suppress(PermissionError):
                    content = sha256(Path(os.fsdecode(entry.path)).read_bytes()).digest() if is_small else None
                yield entry.path, (status.st_mode, status.st_size, status.st_mtime_ns, content)
                if entry.is_dir(follow_symlinks=False):
                    stack.append(entry.path)


def _zip_submissions(submitted: Path) -> Path:
    target = submitted.with_suffix(".zip")
    with zipfile.ZipFile(target, "w", strict_timestamps=False) as archive:
        for name, (mode, size, *_) in _list_file_states(submitted):
            path = Path(os.fsdecode(name))
            if stat.S_ISREG(mode) and size < 100_000_000:
                with contextlib.suppress(OSError, ValueError):  # names that a zip can't contain
                    archive.write(path, path.relative_to(submitted))
    return target


def grade_random_round(hostile_class: HostileClass, seed: str, number: int) -> tuple[str, Result]:
    rng, by_command = Stream(f"submissions/{seed}/{number}"), number % COMMAND_INTERVAL == COMMAND_INTERVAL - 1
    zipped, flat = number % ZIP_INTERVAL == ZIP_INTERVAL - 1, number % FLAT_INTERVAL == FLAT_INTERVAL - 1
    return hostile_class.grade_round(lambda root, text: submit_random(root, text, rng), by_command, zipped, flat)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=120, help="how long to run")
    parser.add_argument("--seed", default="1", help="the seed of all rounds")
    parser.add_argument("--only", type=int, help="run only the round with this number")
    options = parser.parse_args()
    warnings.simplefilter("error")  # graders must see no warnings
    folder, end = Path(tempfile.mkdtemp(prefix="qdot-hostile-")), time.monotonic() + options.seconds
    hostile_class, finds, states, failures = HostileClass(folder / "hw"), 0, Counter[str](), Counter[str]()
    number = first_number = options.only or 0
    while number == options.only or (options.only is None and time.monotonic() < end):
        try:
            description, result = grade_random_round(hostile_class, options.seed, number)
            states[find_work_status(result)] += 1
            if options.only is not None:
                sys.stdout.write(f"{description}: {find_work_status(result)}: {_list_messages(result)}\n")
            if find_work_status(result) == "ungraded":
                failures[f"{result.problems[0].parts[0].reason[:160]}, as in --only {number}"] += 1
        except Exception as error:  # reported below; the folders are stored
            finds += 1
            storage = Path(tempfile.mkdtemp(prefix=f"qdot-find-{options.seed}-{number}-"))
            for name in ("submitted", "graded"):
                with contextlib.suppress(OSError):
                    shutil.move(hostile_class.folder / name, storage / name)
            fault = f"{type(error).__name__}: {str(error)[:500]}: {'; '.join(getattr(error, '__notes__', ()))}"
            sys.stdout.write(f"find: --seed {options.seed} --only {number}: {fault}, stored in {storage}\n")
        number += 1
        sys.stdout.flush()
    folder_removal.remove_folder(str(folder))
    for reason, count in failures.most_common():
        sys.stdout.write(f"ungraded {count} times: {reason}\n")
    sys.stdout.write(f"{number - first_number} rounds ({dict(states)}): {finds} finds\n")
    return 1 if finds else 0


if __name__ == "__main__":
    sys.exit(main())
