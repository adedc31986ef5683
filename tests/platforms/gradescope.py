"""Gradescope's harness by its documentation, in a root of its own: the zip is unpacked, set up and run as there.

`software` is the root of a Linux with Python 3.11 or later and pip, as `debootstrap` makes it. It is copied, and
entered by chroot in namespaces of its own, by root, as in Gradescope's containers; Gradescope itself is a service.
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
from tests.platforms.notebooks import BLANK, KEY, MISTAKEN, RIGHT, WRONG, Ours, a_class, answered, exported, hold
from tests.platforms.records import Counts, Record, today

VISIBILITIES = ("hidden", "after_due_date", "after_published", "visible")
FORMATS = ("text", "html", "simple_format", "md", "ansi")
TOTALS = {
    "score": float, "execution_time": float, "output": str, "output_format": FORMATS, "test_output_format": FORMATS,
    "test_name_format": FORMATS, "visibility": VISIBILITIES, "stdout_visibility": VISIBILITIES, "extra_data": dict,
    "tests": list, "leaderboard": list,
}  # fmt: skip
"""The fields of results.json in Gradescope's documentation, with their types or allowed words."""
TESTS = {
    "score": float, "max_score": float, "status": ("passed", "failed"), "name": str, "name_format": FORMATS,
    "number": str, "output": str, "output_format": FORMATS, "tags": list, "visibility": VISIBILITIES,
    "extra_data": dict,
}  # fmt: skip
"""The fields of a test in results.json."""


def run(software: Path, work: Path) -> Record:
    """Set up the autograder once, and run it on each student's upload."""
    assignment, counts = a_class(work / KEY, RIGHT, WRONG, MISTAKEN, BLANK), Counts()
    folder = exported(assignment, "gradescope", work / "exported")
    container = _Container(software, work / "root")
    container.build(folder / "autograder.zip")
    for student in assignment.roster:
        handed_out = folder / "students" / student.id / f"{KEY}.ipynb"
        text = answered(assignment, student.id, handed_out.read_text(encoding="utf-8"))
        notebook = work / student.id / f"{KEY}.ipynb"
        notebook.parent.mkdir()
        notebook.write_text(text, encoding="utf-8")
        results = container.grade(student, text)
        counts.add("imported", results is not None, student.id)
        if results is not None:
            _hold(Ours(assignment, student.id, notebook), results, counts)
    stranger = container.grade(Student("eve", "Eve", "eve@example.org"), text)
    counts.add("no mark for strangers", stranger is None, f"{stranger}")
    return Record("gradescope", f"Gradescope's folders and calls in {container.name}", today(), counts.told())


# --- the harness ---


CAPABILITIES = (
    "CHOWN", "DAC_OVERRIDE", "FOWNER", "FSETID", "KILL", "MKNOD", "NET_BIND_SERVICE", "NET_RAW", "SETFCAP", "SETGID",
    "SETPCAP", "SETUID", "SYS_CHROOT", "AUDIT_WRITE",
)  # fmt: skip
"""The capabilities of root in a Docker container by default."""


class _Container:
    """A container by bubblewrap in a copy of `software`, whose root has the capabilities that Docker gives."""

    def __init__(self, software: Path, root: Path) -> None:
        subprocess.run(["cp", "--archive", "--reflink=auto", software, root], check=True)
        shutil.copy("/etc/resolv.conf", root / "etc" / "resolv.conf")
        self.root, self.autograder = root, root / "autograder"
        self.environment = {"HOME": "/root", "PATH": os.defpath, **_certificates(root)}
        about = (root / "etc" / "os-release").read_text()
        system = next(line for line in about.splitlines() if line.startswith("PRETTY_NAME=")).split("=")[1].strip('"')
        python = self._called("python3", "--version").stdout.strip()
        self.name = f"a container with {system}, {python}"

    def build(self, archive: Path) -> None:
        """Unpack the zip and set it up, as where the image is built."""
        source = self.autograder / "source"
        source.mkdir(parents=True)
        with zipfile.ZipFile(archive) as packed:
            for about in packed.infolist():
                Path(packed.extract(about, source)).chmod(about.external_attr >> 16)
        done = self._called("bash", "/autograder/source/setup.sh")
        if done.returncode:
            raise RuntimeError(f"setup.sh: {done.stdout[-3000:]}{done.stderr[-3000:]}")
        print(done.stdout)
        shutil.copy(source / "run_autograder", self.autograder / "run_autograder")
        (self.autograder / "run_autograder").chmod(0o755)

    def grade(self, student: Student, notebook: str) -> Any | None:
        """Return results.json for what a student uploads; None where the autograder fails and leaves none."""
        for name in ("submission", "results"):
            shutil.rmtree(self.autograder / name, ignore_errors=True)
            (self.autograder / name).mkdir()
        (self.autograder / "submission" / "my work (1).ipynb").write_text(notebook, encoding="utf-8")
        (self.autograder / "submission_metadata.json").write_text(json.dumps(_metadata(student)), encoding="utf-8")
        done = self._called("/autograder/run_autograder")
        results = self.autograder / "results" / "results.json"
        if done.returncode or not results.exists():
            print(f"  run_autograder for {student.id}: code {done.returncode}: {done.stderr[-300:].strip()}")
            return None
        return json.loads(results.read_text(encoding="utf-8"))

    def _called(self, *command: str) -> subprocess.CompletedProcess[str]:
        """Run a command in the container, by root, in /autograder."""
        self.autograder.mkdir(exist_ok=True)
        kept = [word for name in CAPABILITIES for word in ("--cap-add", f"CAP_{name}")]
        inside = [
            "bwrap", "--bind", self.root, "/", "--dev", "/dev", "--proc", "/proc", "--unshare-pid", "--unshare-ipc",
            "--cap-drop", "ALL", *kept, "--clearenv",
            *(word for name, value in self.environment.items() for word in ("--setenv", name, value)),
            "--chdir", "/autograder", "--die-with-parent", *command,
        ]  # fmt: skip
        return subprocess.run([str(word) for word in inside], capture_output=True, text=True, errors="replace")


def _certificates(root: Path) -> dict[str, str]:
    """Give the container the certificates by which pip trusts its registry on this machine, if it is told any."""
    named = os.environ.get("PIP_CERT")
    if not named:
        return {}
    shutil.copy(named, root / "etc" / "pip-certificates.pem")
    return {"PIP_CERT": "/etc/pip-certificates.pem"}


def _metadata(student: Student) -> dict[str, Any]:
    """Return what Gradescope's documentation has in submission_metadata.json."""
    due = {"due_date": "2027-01-31T23:00:00.000000-08:00", "late_due_date": None}
    about = {
        **due, "release_date": "2027-01-02T00:00:00.000000-08:00", "title": "Arms & <signs>", "total_points": "30.0",
        "group_size": None, "group_submission": False, "id": 25828, "course_id": 1234,
    }  # fmt: skip
    return {
        "id": 123456, "created_at": "2027-01-15T14:22:32.365935-08:00", "assignment": about,
        "submission_method": "upload", "previous_submissions": [],
        "users": [{"email": student.email, "id": 1234, "name": student.name, "assignment": due}],
    }  # fmt: skip


# --- what is held ---


def _hold(ours: Ours, results: Any, counts: Counts) -> None:
    """Hold a student's results.json: by the documentation, against ours, and what is shown of every test."""
    tests = {test["number"]: test for test in results["tests"]}
    named = [("results", *pair) for pair in _undocumented(results, TOTALS)]
    named += [(number, *pair) for number, test in tests.items() for pair in _undocumented(test, TESTS)]
    counts.add("fields as documented", not named, f"{ours.student}: {named}")
    total = results["score"]
    counts.add("total as ours", abs(total - ours.result.score) < 1e-6, f"{ours.student}: {total}")
    rows = {row.part: row for row in make_part_rows(ours.result, ours.assignment.feedback)}
    for part, _, points, title in list_parts(ours.assignment):
        test = tests.get(part, {})
        shown = (test.get("name"), test.get("max_score")) == (title, points) and rows[part].message in test["output"]
        counts.add("shown", shown, f"{ours.student}: {test}, {rows[part].message}")
    hold(counts, ours, {part: test["score"] for part, test in tests.items()})


def _undocumented(what: dict[str, Any], known: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return what a part of results.json holds that the documentation does not know."""
    return [(name, value) for name, value in what.items() if not _is_known(value, known.get(name, ()))]


def _is_known(value: Any, kind: Any) -> bool:
    if isinstance(kind, tuple):
        return value in kind
    return isinstance(value, (int, float) if kind is float else kind) and not isinstance(value, bool)
