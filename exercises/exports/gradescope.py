"""Export an autograder for Gradescope: a zip with the assignment, its secret and qdot itself, for staff to upload.

Students never see the zip. Students' code runs in the autograder's container, which holds the zip's contents, but as
another user and in the usual sandbox. The setup script makes the contents of the zip readable by root only.
"""

from collections.abc import Generator

from qdot.exercises.assignment.assignment import SECRET_FILE
from qdot.exercises.common.files import make_zip
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.wheel import make_wheel, write_versions
from qdot.exercises.writing.render import render


def export_gradescope(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the autograder's zip, a README on how to set it up, and every student's notebook."""
    handouts = collect_handouts(request)
    assignment, context = handouts.assignment, handouts.context
    scripts = {"setup.sh": "exports/gradescope-setup.sh.j2", "run_autograder": "exports/gradescope-run.sh.j2"}
    private_files = read_assignment_files(assignment) | {SECRET_FILE: f"{assignment.secret}\n".encode()}
    files: dict[str, str | bytes] = {path: render(template, **context) for path, template in scripts.items()}
    files |= {f"assignment/{path}": data for path, data in private_files.items()}
    files |= {make_wheel().file_name: make_wheel().content, "versions.txt": write_versions()}
    permissions = dict.fromkeys(scripts, 0o755) | {f"assignment/{path}": 0o600 for path in private_files}
    yield ExportedFile("autograder.zip", make_zip(files, permissions), is_private=True)
    yield ExportedFile("README.md", render("exports/gradescope-readme.md.j2", **context))
    for student, notebook in handouts.iterate_notebooks():
        yield ExportedFile(f"students/{student.id}/{assignment.key}.ipynb", notebook)
