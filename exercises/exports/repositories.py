"""Export repositories for GitHub or GitLab: one for the staff, which grades, and one for each student.

Anybody who may push to a repository can change its CI jobs so that they print every secret of the repository. Therefore
students' repositories never have the assignment's secret. The staff's repository fetches students' work, grades the
work and returns feedback.
"""

import re
import sys
from collections.abc import Generator

from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.wheel import make_wheel, write_versions
from qdot.exercises.writing.render import render

WORKFLOWS = {
    "github": (".github/workflows/grade.yml", ".github/workflows/check.yml"),
    "gitlab": (".gitlab-ci.yml", ".gitlab-ci.yml"),
}
"""Maps each platform to the paths of the workflow that grades, and of the one that checks a student's notebook."""

ACTIONS = {
    "checkout": "actions/checkout@d23441a48e516b6c34aea4fa41551a30e30af803  # v6.1.0",
    "setup_python": "actions/setup-python@ece7cb06caefa5fff74198d8649806c4678c61a1  # v6.3.0",
    "cache": "actions/cache@27d5ce7f107fe9357f9df03efb73ab90386fccae  # v5.0.5",
    "upload_artifact": "actions/upload-artifact@b7c566a772e6b6bfb58ed0dc250532a479d7789f  # v6.0.0",
}
"""The actions of our workflows, pinned by commit: tags can be moved, and these jobs can read the answer key."""
GITHUB_LOGIN = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9-]{0,37}[A-Za-z0-9])?")
"""Matches a valid GitHub login."""


def export_repositories(request: ExportRequest, platform: str) -> Generator[ExportedFile, None, None]:
    """Yield the files of all repositories. `platform` is "github" or "gitlab"."""
    handouts = collect_handouts(request)
    wheel, versions = make_wheel(), write_versions()
    python_version = f"{sys.version_info.major}.{sys.version_info.minor}"
    context = handouts.context | {"platform": platform, "python": python_version, "actions": ACTIONS}
    grading_workflow, checking_workflow = WORKFLOWS[platform]
    yield ExportedFile("README.md", render("exports/repositories.md.j2", **context))
    if platform == "github":
        yield ExportedFile("setup-class.sh", render("exports/setup-class.sh.j2", **context))
    for path, data in read_assignment_files(handouts.assignment).items():
        yield ExportedFile(f"grading/{path}", data)
    yield ExportedFile(f"grading/{grading_workflow}", render(f"exports/{platform}-grade.yml.j2", **context))
    yield ExportedFile("grading/README.md", render("exports/grading-readme.md.j2", **context))
    yield ExportedFile("grading/.gitignore", render("exports/gitignore.j2", **context))
    yield ExportedFile("grading/repositories.csv", _write_repository_table(request, platform))
    yield ExportedFile(f"grading/{wheel.file_name}", wheel.content)
    yield ExportedFile("grading/versions.txt", versions)
    for student, notebook in handouts.iterate_notebooks():
        folder = f"students/{student.id}"
        yield ExportedFile(f"{folder}/{handouts.assignment.key}.ipynb", notebook)
        yield ExportedFile(f"{folder}/README.md", render("exports/student-readme.md.j2", **context))
        yield ExportedFile(f"{folder}/{checking_workflow}", render(f"exports/{platform}-check.yml.j2", **context))
        yield ExportedFile(f"{folder}/.qdot/{wheel.file_name}", wheel.content)
        yield ExportedFile(f"{folder}/.qdot/versions.txt", versions)


def _write_repository_table(request: ExportRequest, platform: str) -> str:
    """Return a table of repositories, students and logins as CSV. Raises QdotError if a login is invalid.

    The name is the cell in the roster's column `repository`, or else OWNER/KEY-STUDENT. The logins are from
    the roster's column with the platform's name.
    """
    lines = [f"repository,student,{platform}"]
    for student in request.assignment.roster:
        other_cells = {name.strip().casefold(): text.strip() for name, text in student.other_cells}
        login = other_cells.get(platform, "").removeprefix("@")
        if platform == "github" and login and not GITHUB_LOGIN.fullmatch(login):
            advice = "is not a valid login; write it as in github.com/LOGIN"
            raise QdotError(f"roster.csv: github = {login!r} of {student.id} {advice}")
        repository = other_cells.get("repository") or f"OWNER/{request.assignment.key}-{student.id}"
        lines.append(f"{repository},{student.id},{login}")
    return "".join(f"{line}\n" for line in lines)
