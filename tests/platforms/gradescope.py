"""A harness after Gradescope's documentation: it unpacks, sets up and runs the autograder in a container.

`software` is the root folder of a Linux with Python 3.11 or later and pip, as `debootstrap` makes it. The container is
a copy of it, with separate namespaces and root as the user, as on Gradescope. Gradescope itself can't be installed.
"""

import json
import os
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.exports.nbgrader import list_parts
from qdot.grader.reports.part_rows import make_part_rows
from tests.platforms.notebooks import (
    KEY,
    QdotGrading,
    compare_marks,
    export_into,
    fill_in_answers,
    make_class_assignment,
)
from tests.platforms.records import Counts, Record, today

VISIBILITIES = ("hidden", "after_due_date", "after_published", "visible")
FORMATS = ("text", "html", "simple_format", "md", "ansi")
RESULT_FIELDS = {
    "score": float, "execution_time": float, "output": str, "output_format": FORMATS, "test_output_format": FORMATS,
    "test_name_format": FORMATS, "visibility": VISIBILITIES, "stdout_visibility": VISIBILITIES, "extra_data": dict,
    "tests": list, "leaderboard": list,
}  # fmt: skip
"""The documented fields of results.json, each with its type or its possible values."""
TEST_FIELDS = {
    "score": float, "max_score": float, "status": ("passed", "failed"), "name": str, "name_format": FORMATS,
    "number": str, "output": str, "output_format": FORMATS, "tags": list, "visibility": VISIBILITIES,
    "extra_data": dict,
}  # fmt: skip
"""The documented fields of a test in results.json."""


def run(software: Path, work: Path) -> Record:
    """Set up the autograder once, and run it on each student's upload."""
    assignment, counts = make_class_assignment(work / KEY), Counts()
    folder = export_into(assignment, "gradescope", work / "exported")
    container = _Container(software, work / "root")
    container.build(folder / "autograder.zip")
    for student in assignment.roster:
        released = folder / "students" / student.id / f"{KEY}.ipynb"
        text = fill_in_answers(assignment, student.id, released.read_text(encoding="utf-8"))
        notebook = work / student.id / f"{KEY}.ipynb"
        notebook.parent.mkdir()
        notebook.write_text(text, encoding="utf-8")
        results = container.grade(student, text)
        counts.add("imported", results is not None, student.id)
        if results is not None:
            _check_results(QdotGrading(assignment, student.id, notebook), results, counts)
    stranger = container.grade(Student("eve", "Eve", "eve@example.org"), text)
    counts.add("no mark for strangers", stranger is None, f"{stranger}")
    return Record(
        "gradescope", f"Gradescope's folders and commands, simulated in {container.name}", today(), counts.freeze()
    )


# --- the harness ---


CAPABILITIES = (
    "CHOWN", "DAC_OVERRIDE", "FOWNER", "FSETID", "KILL", "MKNOD", "NET_BIND_SERVICE", "NET_RAW", "SETFCAP", "SETGID",
    "SETPCAP", "SETUID", "SYS_CHROOT", "AUDIT_WRITE",
)  # fmt: skip
"""The default capabilities of root in a Docker container."""


class _Container:
    """A container made with bubblewrap in a copy of `software`; its root user has Docker's default capabilities."""

    def __init__(self, software: Path, root: Path) -> None:
        subprocess.run(["cp", "--archive", "--reflink=auto", software, root], check=True)
        shutil.copy("/etc/resolv.conf", root / "etc" / "resolv.conf")
        self.root, self.autograder = root, root / "autograder"
        self.environment = {"HOME": "/root", "PATH": os.defpath, **_copy_certificates(root)}
        os_release = (root / "etc" / "os-release").read_text()
        system = (
            next(line for line in os_release.splitlines() if line.startswith("PRETTY_NAME=")).split("=")[1].strip('"')
        )
        python = self._run("python3", "--version").stdout.strip()
        self.name = f"a container with {system}, {python}"

    def build(self, archive: Path) -> None:
        source = self.autograder / "source"
        source.mkdir(parents=True)
        with zipfile.ZipFile(archive) as zip_file:
            for member in zip_file.infolist():
                Path(zip_file.extract(member, source)).chmod(member.external_attr >> 16)
        done = self._run("bash", "/autograder/source/setup.sh")
        if done.returncode:
            raise RuntimeError(f"setup.sh: {done.stdout[-3000:]}{done.stderr[-3000:]}")
        print(done.stdout)
        shutil.copy(source / "run_autograder", self.autograder / "run_autograder")
        (self.autograder / "run_autograder").chmod(0o755)

    def grade(self, student: Student, notebook: str) -> Any | None:
        for name in ("submission", "results"):
            shutil.rmtree(self.autograder / name, ignore_errors=True)
            (self.autograder / name).mkdir()
        (self.autograder / "submission" / "my work (1).ipynb").write_text(notebook, encoding="utf-8")
        (self.autograder / "submission_metadata.json").write_text(json.dumps(_make_metadata(student)), encoding="utf-8")
        done = self._run("/autograder/run_autograder")
        results = self.autograder / "results" / "results.json"
        if done.returncode or not results.exists():
            print(f"  run_autograder for {student.id}: code {done.returncode}: {done.stderr[-300:].strip()}")
            return None
        return json.loads(results.read_text(encoding="utf-8"))

    def _run(self, *command: str) -> subprocess.CompletedProcess[str]:
        self.autograder.mkdir(exist_ok=True)
        capabilities = [word for name in CAPABILITIES for word in ("--cap-add", f"CAP_{name}")]
        bwrap = [
            "bwrap", "--bind", self.root, "/", "--dev", "/dev", "--proc", "/proc", "--unshare-pid", "--unshare-ipc",
            "--cap-drop", "ALL", *capabilities, "--clearenv",
            *(word for name, value in self.environment.items() for word in ("--setenv", name, value)),
            "--chdir", "/autograder", "--die-with-parent", *command,
        ]  # fmt: skip
        return subprocess.run([str(word) for word in bwrap], capture_output=True, text=True, errors="replace")


def _copy_certificates(root: Path) -> dict[str, str]:
    """Copy the certificates of PIP_CERT, if set, into the container; return the variables that tell pip about them."""
    path = os.environ.get("PIP_CERT")
    if not path:
        return {}
    shutil.copy(path, root / "etc" / "pip-certificates.pem")
    return {"PIP_CERT": "/etc/pip-certificates.pem"}


def _make_metadata(student: Student) -> dict[str, Any]:
    due_dates = {"due_date": "2027-01-31T23:00:00.000000-08:00", "late_due_date": None}
    assignment = {
        **due_dates, "release_date": "2027-01-02T00:00:00.000000-08:00", "title": "Arms & <signs>",
        "total_points": "30.0",
        "group_size": None, "group_submission": False, "id": 25828, "course_id": 1234,
    }  # fmt: skip
    return {
        "id": 123456, "created_at": "2027-01-15T14:22:32.365935-08:00", "assignment": assignment,
        "submission_method": "upload", "previous_submissions": [],
        "users": [{"email": student.email, "id": 1234, "name": student.name, "assignment": due_dates}],
    }  # fmt: skip


# --- checks of the results ---


def _check_results(grading: QdotGrading, results: Any, counts: Counts) -> None:
    """Check a student's results.json: its fields, its marks, and the name and output of every test."""
    tests = {test["number"]: test for test in results["tests"]}
    undocumented = [("results", *pair) for pair in _list_undocumented(results, RESULT_FIELDS)]
    undocumented += [
        (number, *pair) for number, test in tests.items() for pair in _list_undocumented(test, TEST_FIELDS)
    ]
    counts.add("fields as documented", not undocumented, f"{grading.student}: {undocumented}")
    total = results["score"]
    counts.add("total as ours", abs(total - grading.result.score) < 1e-6, f"{grading.student}: {total}")
    rows = {row.part: row for row in make_part_rows(grading.result, grading.assignment, grading.assignment.feedback)}
    for part, _, points, title in list_parts(grading.assignment):
        test = tests.get(part, {})
        expected = {"name": title, "max_score": points, "output": rows[part].description}
        counts.add("shown", expected.items() <= test.items(), f"{grading.student}: {test}, {expected}")
    compare_marks(counts, grading, {part: test["score"] for part, test in tests.items()})


def _list_undocumented(fields: dict[str, Any], documented: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return the fields, with their values, that are not documented or have an undocumented value."""
    return [(name, value) for name, value in fields.items() if not _is_documented(value, documented.get(name, ()))]


def _is_documented(value: Any, kind: Any) -> bool:
    if isinstance(kind, tuple):
        return value in kind
    return isinstance(value, (int, float) if kind is float else kind) and not isinstance(value, bool)
