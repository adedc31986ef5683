"""pytest --qdot DIR: every part of every student's submission as a test, DIR/assignment.toml::STUDENT::p1.jacobian.

A part passes with all of its points; else the failure says what was wrong. A part on which qdot itself failed is an
error, not a failure. pytest loads this module in every run, so that nothing slow is imported before it is asked for.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from qdot.exercises.assignment.assignment import Assignment, Student
    from qdot.grader.reports.rows import Row

FILE = "assignment.toml"


class PartFailed(Exception):
    """A part without all of its points, and why."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("qdot", "grading velocity-kinematics assignments")
    group.addoption(
        "--qdot", metavar="DIR", action="append", default=[], help="grade this assignment folder; may be repeated"
    )
    group.addoption(
        "--qdot-submissions", metavar="PATH", default=None,
        help="the folder with what was handed in (default: DIR/submitted)",
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    """Have the assignments collected beside what was asked for anyway. Raises pytest.UsageError."""
    for folder in config.getoption("qdot"):
        listed = _path(config, folder) / FILE
        if not listed.is_file():
            raise pytest.UsageError(f"--qdot {folder}: there is no {FILE} in it")
        if listed not in _named(config):
            config.args.append(str(listed))
    if config.getoption("qdot_submissions") and len(_named(config)) != 1:
        raise pytest.UsageError("--qdot-submissions is of one assignment: give --qdot DIR once")


def _path(config: pytest.Config, text: str) -> Path:
    """Return a path of the command line as pytest's own are: without `..`, and whatever is a link left one."""
    return Path(os.path.abspath(config.invocation_params.dir / text))  # noqa: PTH100 - resolve() follows links


def _named(config: pytest.Config) -> set[Path]:
    """Return the assignments that are arguments, alone or as the beginning of a test's id."""
    paths = {_path(config, argument.partition("::")[0]) for argument in config.args}
    return {path for path in paths if path.name == FILE}


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "AssignmentFile | None":
    """Take an assignment.toml that was asked for, by --qdot or by the id of a test in it."""
    if file_path.name != FILE or file_path not in _named(parent.config):
        return None
    # Of a file outside of its root folder, pytest would leave the name out of the tests' ids.
    own = Path(os.path.relpath(file_path, parent.config.rootpath)).as_posix()
    return AssignmentFile.from_parent(parent, path=file_path, nodeid=own)


class AssignmentFile(pytest.File):
    """An assignment, with its students."""

    def collect(self) -> Iterator["StudentNode"]:
        """Yield the students of the roster. Bad input is one line, without a traceback."""
        from qdot.exercises.assignment.assignment import load_assignment
        from qdot.exercises.common.errors import QdotError
        from qdot.grader.cli.class_commands import check_sandbox
        from qdot.grader.submissions.submission import find_submissions

        try:
            assignment = load_assignment(self.path.parent)
            told = self.config.getoption("qdot_submissions")
            looked = find_submissions(assignment, Path(told) if told else assignment.folder / "submitted")
            check_sandbox(assignment.sandbox == "strict")
        except QdotError as error:
            raise self.CollectError(str(error)) from None
        for said in (*looked.unsure, *(f"{name}: nobody on the roster; not graded" for name in looked.strangers)):
            self.warn(pytest.PytestWarning(said))
        for student in assignment.roster:
            yield StudentNode.from_parent(
                self, name=student.id, assignment=assignment, student=student, found=looked.by_student.get(student.id)
            )


class StudentNode(pytest.Collector):
    """A student of an assignment; what they handed in is graded when the first of its parts is run."""

    def __init__(self, assignment: "Assignment", student: "Student", found: Any, **others: Any) -> None:
        super().__init__(**others)
        self.assignment, self.student, self.found = assignment, student, found
        self.graded: dict[str, Row] | None = None

    def collect(self) -> Iterator["PartItem"]:
        """Yield a test for every part."""
        for slot in self.assignment.slots:
            for question in slot.questions:
                yield PartItem.from_parent(self, name=f"{slot.name}.{question}")

    def rows(self) -> dict[str, "Row"]:
        """Return what came of each part."""
        from qdot.grader.grading.one_student import grade_one
        from qdot.grader.reports.rows import rows_of
        from qdot.grader.sandbox.sandbox import Limits

        if self.graded is None:
            result = grade_one(self.assignment, self.student, self.found, Limits())
            self.graded = {row.part: row for row in rows_of(result)}
        return self.graded


class PartItem(pytest.Item):
    """A part of a submission."""

    row: "Row"

    def setup(self) -> None:
        """Grade the submission, if that is not yet done; an exception here is an error, and no failure."""
        assert isinstance(self.parent, StudentNode)
        self.row = self.parent.rows()[self.name]
        self.user_properties += [("points", self.row.points), ("max_points", self.row.max_points)]
        if self.row.points is None:
            raise RuntimeError(self.row.message)

    def runtest(self) -> None:
        """Fail where points are missing."""
        if not self.row.passed:
            raise PartFailed(f"{self.row.title}: {self.row.earned} points, {self.row.outcome}\n{self.row.message}")

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return the reason alone: where in qdot it was raised concerns nobody."""
        if isinstance(excinfo.value, PartFailed) or self.row.points is None:
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return the test's file and title: no end of its id, which pytest would write as ada::p1::jacobian then."""
        assert isinstance(self.parent, StudentNode)
        return self.path, None, f"{self.parent.name}, {self.name}"
