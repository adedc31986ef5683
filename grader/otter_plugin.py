"""What Otter's autograder calls, so that it marks by qdot: the plugin `Marks`.

Before anything of the student's is run, the notebook is marked, and what decides the answers is taken away; in its
place Otter runs one cell that has the marks. The tests look them up, and points in part are set at the end. It needs
otter-grader, and is imported by nothing else.
"""

import shutil
from pathlib import Path
from typing import Any

from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_notebook
from otter.plugins import AbstractOtterPlugin

from exercises.exports.nbgrader import grade_id
from exercises.exports.otter import FOLDER
from grader.otter_marks import content_for, handed_over, marks_of


class Marks(AbstractOtterPlugin):
    """Marks the submission by the assignment that is in the autograder."""

    def before_grading(self, config: Any) -> None:
        """Mark, and take away all by which answers could be found. Raises QdotError where there can be no mark."""
        submission = Path(self.submission_path)
        copies = submission.parent / FOLDER, submission.parent.parent / "source" / "files" / FOLDER
        try:
            self.content = content_for(copies[1], submission, self.submission_metadata)
        finally:
            for folder in copies:
                shutil.rmtree(folder, ignore_errors=True)

    def before_execution(self, submission: NotebookNode | str) -> NotebookNode:
        """Return what is run in the place of the student's notebook: a cell with the marks."""
        metadata = dict(submission.metadata) if isinstance(submission, NotebookNode) else {}
        kept = {name: metadata[name] for name in ("kernelspec", "language_info") if name in metadata}
        return new_notebook(metadata=kept, cells=[new_code_cell(handed_over(marks_of(self.content)), id="marks")])

    def after_grading(self, results: Any) -> None:
        """Give each part its points, less what is taken off for lateness, and say what is said of the whole."""
        marks = marks_of(self.content)
        earned = sum(mark["points"] for mark in marks.values())
        counting = self.content["score"] / earned if earned else 1
        for part, mark in marks.items():
            results.update_score(grade_id(part), mark["points"] * counting)
        if self.content["output"]:
            results.set_output(self.content["output"])
