"""Gradescope's autograder: a zip with the assignment, its secret and qdot itself, for the staff to upload.

Students never see the zip. Their code runs in the same container, as another user and in the usual sandbox; the setup
script makes the contents of the zip readable by root only.
"""

from collections.abc import Generator

from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.handouts import handouts
from qdot.exercises.exports.repositories import assignment_files
from qdot.exercises.exports.wheel import versions, wheel, zip_files
from qdot.exercises.writing.render import render


def gradescope(order: Order) -> Generator[File, None, None]:
    """Yield the autograder's zip, a README on how to set it up, and every student's notebook."""
    notebooks = handouts(order)
    assignment = notebooks.assignment
    name, content = wheel()
    about = {"title": assignment.title, "key": assignment.key, "wheel": name}
    files = [
        ("setup.sh", render("exports/gradescope-setup.sh.j2", **about).encode(), 0o755),
        ("run_autograder", render("exports/gradescope-run.sh.j2", **about).encode(), 0o755),
        *((f"assignment/{path}", data, 0o600) for path, data in assignment_files(order)),
        ("assignment/secret.txt", f"{assignment.secret}\n".encode(), 0o600),
        (name, content, 0o644),
        ("versions.txt", versions().encode(), 0o644),
    ]
    yield File("autograder.zip", zip_files(files), private=True)
    yield File("README.md", render("exports/gradescope-readme.md.j2", **about))
    for student, notebook in notebooks.all():
        yield File(f"students/{student.id}/{assignment.key}.ipynb", notebook)
