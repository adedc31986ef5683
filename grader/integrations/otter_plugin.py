"""Let Otter's autograder mark with qdot: the plugin `Marks`.

Otter works in the folder of the submission, from which Python could import the student's files. So the plugin first
removes all files submitted with the notebook, marks the notebook from another folder, and then removes everything that
reveals answers. Instead of the notebook, Otter runs one cell with the marks, and its tests look the marks up. At the
end, the plugin sets the partial points. This module needs otter-grader, and no other module imports it.
"""

import contextlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_notebook
from otter.plugins import AbstractOtterPlugin

from qdot.exercises.exports.nbgrader import make_grade_id
from qdot.exercises.exports.otter import ASSIGNMENT_FOLDER
from qdot.grader.integrations.otter_marks import grade_for_otter, list_marks, write_marks_code

OTTER_TESTS_FOLDER = "tests"
"""The folder of tests that Otter puts next to the notebook; it replaces any submitted folder of that name."""


class Marks(AbstractOtterPlugin):
    """Otter plugin that marks the submission with the assignment in the autograder."""

    def before_grading(self, config: Any) -> None:
        """Mark the submission, and remove everything that could reveal answers.

        Raises QdotError if it can't be marked.
        """
        submission = Path(self.submission_path).absolute()
        _remove_other_files({submission, submission.parent / OTTER_TESTS_FOLDER})
        assignment = submission.parent.parent / "source" / "files" / ASSIGNMENT_FOLDER
        try:
            # New processes then import nothing from their working folder.
            safe_path = mock.patch.dict(os.environ, PYTHONSAFEPATH="1")
            with tempfile.TemporaryDirectory(prefix="qdot-otter-") as folder, contextlib.chdir(folder), safe_path:
                self.results = grade_for_otter(assignment, submission, self.submission_metadata)
        finally:
            shutil.rmtree(assignment, ignore_errors=True)

    def before_execution(self, submission: NotebookNode | str) -> NotebookNode:
        """Return the notebook that Otter runs instead of the student's: one cell with the marks."""
        metadata = dict(submission.metadata) if isinstance(submission, NotebookNode) else {}
        kernel_metadata = {name: metadata[name] for name in ("kernelspec", "language_info") if name in metadata}
        cell = new_code_cell(write_marks_code(list_marks(self.results)), id="marks")
        return new_notebook(metadata=kernel_metadata, cells=[cell])

    def after_grading(self, results: Any) -> None:
        """Set each part's points minus the late penalty, and show the notes on the whole submission."""
        marks = list_marks(self.results)
        earned = sum(mark.points for mark in marks.values())
        ratio = self.results.score / earned if earned else 1
        for part, mark in marks.items():
            results.update_score(make_grade_id(part), mark.points * ratio)
        if self.results.output:
            results.set_output(self.results.output)


def _remove_other_files(needed_paths: set[Path]) -> None:
    """Remove everything except the paths in `needed_paths` from the folder that contains them."""
    for path in set(next(iter(needed_paths)).parent.iterdir()) - needed_paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
