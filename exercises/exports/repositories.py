"""Repositories for GitHub and GitLab: one in which the staff grade, and one for every student, which holds no key.

Whoever may push to a repository can print every secret that its jobs are given, by changing what the jobs do. So the
secret is never given to a student's repository: the staff's fetches what was pushed, grades it and hands feedback back.
"""

import sys
from collections.abc import Generator

from exercises.exports.handouts import handouts
from exercises.exports.outlet import File, Order, robots
from exercises.exports.wheel import versions, wheel
from exercises.redrawn import REDRAWN
from exercises.render import render

PLATFORMS = {"github": ".github/workflows", "gitlab": ""}
"""Where each platform looks for what it is to run."""


def github(order: Order) -> Generator[File, None, None]:
    """Yield repositories that GitHub Actions grades."""
    yield from _repositories(order, "github", "grade.yml", "check.yml")


def gitlab(order: Order) -> Generator[File, None, None]:
    """Yield projects that GitLab CI grades."""
    yield from _repositories(order, "gitlab", ".gitlab-ci.yml", ".gitlab-ci.yml")


def assignment_files(order: Order) -> list[tuple[str, bytes]]:
    """Return the files of an assignment folder by which it is graded, but the secret. Raises QdotError."""
    folder = order.assignment.folder
    names = ["assignment.toml", "roster.csv"]
    names += [name for name in (REDRAWN, "overrides.csv") if (folder / name).exists()]
    names += robots(order.assignment)
    return [(name, (folder / name).read_bytes()) for name in names]


def _repositories(order: Order, platform: str, grade: str, check: str) -> Generator[File, None, None]:
    notebooks = handouts(order)
    assignment = notebooks.assignment
    name, content = wheel()
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    about = {"title": assignment.title, "key": assignment.key, "platform": platform, "wheel": name, "python": python}
    own = versions()
    place = f"{PLATFORMS[platform]}/" if PLATFORMS[platform] else ""
    yield File("README.md", render("exports/repositories.md.j2", **about))
    for path, data in assignment_files(order):
        yield File(f"grading/{path}", data)
    for path, template in (
        (f"{place}{grade}", f"{platform}-grade.yml.j2"), ("collect.sh", "collect.sh.j2"),
        ("hand-back.sh", "hand-back.sh.j2"), ("README.md", "grading-readme.md.j2"), (".gitignore", "gitignore.j2"),
    ):  # fmt: skip
        yield File(f"grading/{path}", render(f"exports/{template}", **about))
    yield File("grading/repositories.csv", _listing(order))
    yield File(f"grading/{name}", content)
    yield File("grading/versions.txt", own)
    for student, notebook in notebooks.all():
        folder = f"students/{student.id}"
        yield File(f"{folder}/{assignment.key}.ipynb", notebook)
        yield File(f"{folder}/README.md", render("exports/student-readme.md.j2", **about))
        yield File(f"{folder}/{place}{check}", render(f"exports/{platform}-check.yml.j2", **about))
        yield File(f"{folder}/.qdot/{name}", content)
        yield File(f"{folder}/.qdot/versions.txt", own)


def _listing(order: Order) -> str:
    """Return which repository is whose: by the roster's column `repository`, else called KEY-STUDENT."""
    lines = ["repository,student"]
    for student in order.assignment.roster:
        named = dict(student.others).get("repository", "").strip()
        lines.append(f"{named or f'OWNER/{order.assignment.key}-{student.id}'},{student.id}")
    return "".join(f"{line}\n" for line in lines)
