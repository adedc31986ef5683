"""Export of repositories for GitHub and GitLab: one for grading by the staff, and one per student without the secret.

Anybody who may push to a repository can change its CI jobs to print every secret that they receive. Therefore students'
repositories never receive the secret. The staff's repository fetches their work, grades it and returns feedback.
"""

import re
import sys
from collections.abc import Generator

from qdot.exercises.assignment.replacements import REPLACEMENTS_FILE
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest, list_robot_files
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.wheel import list_versions, make_wheel
from qdot.exercises.writing.render import render

WORKFLOW_FOLDERS = {"github": ".github/workflows", "gitlab": ""}
"""The folder in which each platform looks for its workflows."""

ACTIONS = {
    "checkout": "actions/checkout@d23441a48e516b6c34aea4fa41551a30e30af803  # v6.1.0",
    "setup_python": "actions/setup-python@ece7cb06caefa5fff74198d8649806c4678c61a1  # v6.3.0",
    "cache": "actions/cache@27d5ce7f107fe9357f9df03efb73ab90386fccae  # v5.0.5",
    "upload_artifact": "actions/upload-artifact@b7c566a772e6b6bfb58ed0dc250532a479d7789f  # v6.0.0",
}
"""The actions of our workflows, pinned by commit: tags can be moved, and these jobs can read the answer key."""
GITHUB_LOGIN = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9-]{0,37}[A-Za-z0-9])?")
"""A GitHub login."""


def export_github(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the files of repositories that GitHub Actions grades."""
    yield from _export_repositories(request, "github", "grade.yml", "check.yml")


def export_gitlab(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the files of projects that GitLab CI grades."""
    yield from _export_repositories(request, "gitlab", ".gitlab-ci.yml", ".gitlab-ci.yml")


def read_assignment_files(request: ExportRequest) -> list[tuple[str, bytes]]:
    """Return the files of an assignment folder that grading needs, except the secret. Raises QdotError."""
    folder = request.assignment.folder
    names = ["assignment.toml", "roster.csv"]
    names += [name for name in (REPLACEMENTS_FILE, "overrides.csv") if (folder / name).exists()]
    names += list_robot_files(request)
    return [(name, (folder / name).read_bytes()) for name in names]


def _export_repositories(
    request: ExportRequest, platform: str, grading_workflow: str, checking_workflow: str
) -> Generator[ExportedFile, None, None]:
    notebooks = collect_handouts(request)
    assignment = notebooks.assignment
    name, content = make_wheel()
    context = {
        "title": assignment.title, "key": assignment.key, "platform": platform, "wheel": name,
        "python": f"{sys.version_info.major}.{sys.version_info.minor}", "actions": ACTIONS,
    }  # fmt: skip
    constraints = list_versions()
    workflow_folder = f"{WORKFLOW_FOLDERS[platform]}/" if WORKFLOW_FOLDERS[platform] else ""
    yield ExportedFile("README.md", render("exports/repositories.md.j2", **context))
    if platform == "github":
        yield ExportedFile("setup-class.sh", render("exports/setup-class.sh.j2", **context))
    for path, data in read_assignment_files(request):
        yield ExportedFile(f"grading/{path}", data)
    for path, template in (
        (f"{workflow_folder}{grading_workflow}", f"{platform}-grade.yml.j2"), ("README.md", "grading-readme.md.j2"),
        (".gitignore", "gitignore.j2"),
    ):  # fmt: skip
        yield ExportedFile(f"grading/{path}", render(f"exports/{template}", **context))
    yield ExportedFile("grading/repositories.csv", _list_repositories(request, platform))
    yield ExportedFile(f"grading/{name}", content)
    yield ExportedFile("grading/versions.txt", constraints)
    for student, notebook in notebooks.iterate_notebooks():
        folder = f"students/{student.id}"
        yield ExportedFile(f"{folder}/{assignment.key}.ipynb", notebook)
        yield ExportedFile(f"{folder}/README.md", render("exports/student-readme.md.j2", **context))
        workflow = render(f"exports/{platform}-check.yml.j2", **context)
        yield ExportedFile(f"{folder}/{workflow_folder}{checking_workflow}", workflow)
        yield ExportedFile(f"{folder}/.qdot/{name}", content)
        yield ExportedFile(f"{folder}/.qdot/versions.txt", constraints)


def _list_repositories(request: ExportRequest, platform: str) -> str:
    """Return a table of repositories and students. A repository is KEY-STUDENT, unless the roster names another one.

    The third column is the login, from the roster's column with the platform's name. Raises QdotError if it is invalid.
    """
    lines = [f"repository,student,{platform}"]
    for student in request.assignment.roster:
        other_cells = {name.strip().casefold(): text.strip() for name, text in student.other_columns}
        login = other_cells.get(platform, "").removeprefix("@")
        if platform == "github" and login and not GITHUB_LOGIN.fullmatch(login):
            advice = "is not a valid login; write it as in github.com/LOGIN"
            raise QdotError(f"roster.csv: github = {login!r} of {student.id} {advice}")
        repository = other_cells.get("repository") or f"OWNER/{request.assignment.key}-{student.id}"
        lines.append(f"{repository},{student.id},{login}")
    return "".join(f"{line}\n" for line in lines)
