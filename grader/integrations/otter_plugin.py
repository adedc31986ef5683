"""Let Otter's autograder mark by qdot: the plugin `Marks`.

Otter works in the folder of the submission, from which Python would import whatever the student put there. So all that
came with the notebook is taken away first, the notebook is marked from elsewhere, and then what decides the answers is
taken away, too; in the notebook's place Otter runs one cell that has the marks. The tests look them up, and points in
part are set at the end. It needs otter-grader, and is imported by nothing else.
"""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_notebook
from otter.plugins import AbstractOtterPlugin

from qdot.exercises.exports.nbgrader import grade_id
from qdot.exercises.exports.otter import FOLDER
from qdot.grader.integrations.otter_marks import grade_for_otter, list_marks, write_marks_code

OTTERS = "tests"
"""The folder that Otter itself has put beside the notebook, in the place of any that the student handed in."""


class Marks(AbstractOtterPlugin):
    """Mark the submission by the assignment that is in the autograder."""

    def before_grading(self, config: Any) -> None:
        """Mark, and remove everything that could reveal answers. Raises QdotError if there can be no mark."""
        submission = Path(self.submission_path).absolute()
        _remove_all_but({submission, submission.parent / OTTERS})
        assignment = submission.parent.parent / "source" / "files" / FOLDER
        try:
            with _work_elsewhere():
                self.results = grade_for_otter(assignment, submission, self.submission_metadata)
        finally:
            shutil.rmtree(assignment, ignore_errors=True)

    def before_execution(self, submission: NotebookNode | str) -> NotebookNode:
        """Return the notebook that is run in place of the student's: a cell with the marks."""
        metadata = dict(submission.metadata) if isinstance(submission, NotebookNode) else {}
        kept = {name: metadata[name] for name in ("kernelspec", "language_info") if name in metadata}
        return new_notebook(
            metadata=kept, cells=[new_code_cell(write_marks_code(list_marks(self.results)), id="marks")]
        )

    def after_grading(self, results: Any) -> None:
        """Give each part its points, less the late penalty, and show the notes on the whole submission."""
        marks = list_marks(self.results)
        earned = sum(mark.points for mark in marks.values())
        counting = self.results.score / earned if earned else 1
        for part, mark in marks.items():
            results.update_score(grade_id(part), mark.points * counting)
        if self.results.output:
            results.set_output(self.results.output)


def _remove_all_but(kept: set[Path]) -> None:
    """Remove everything else from the folder of these files."""
    for path in next(iter(kept)).parent.iterdir():
        if path in kept:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


@contextlib.contextmanager
def _work_elsewhere() -> Iterator[None]:
    """Work in a new, empty folder; processes that are started import nothing from their working folder."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        with tempfile.TemporaryDirectory(prefix="qdot-otter-") as empty, contextlib.chdir(empty):
            yield
    finally:
        if before is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = before
