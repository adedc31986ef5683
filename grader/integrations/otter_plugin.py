"""Let Otter's autograder mark with qdot: the plugin `Marks`.

Otter works in the folder of the submission, from which Python could import the student's files. So the plugin first
removes all files submitted with the notebook, marks the notebook from another folder, and then removes everything that
reveals answers. Instead of the notebook, Otter runs an empty one, so every test fails. Then the plugin gives each test
the points and the feedback of its part. This module needs otter-grader, and no other module imports it.
"""

import contextlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

from nbformat import NotebookNode
from nbformat.v4 import new_notebook
from otter.plugins import AbstractOtterPlugin

from qdot.exercises.exports.nbgrader import make_grade_id
from qdot.exercises.exports.otter import ASSIGNMENT_FOLDER
from qdot.grader.integrations.otter_marks import grade_for_otter
from qdot.grader.reports.gradescope import PASSED

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
        """Return the notebook that Otter runs instead of the student's: an empty one."""
        metadata = dict(submission.metadata) if isinstance(submission, NotebookNode) else {}
        kernel_metadata = {name: metadata[name] for name in ("kernelspec", "language_info") if name in metadata}
        return new_notebook(metadata=kernel_metadata)

    def after_grading(self, results: Any) -> None:
        """Give each test its part's feedback, and its points minus the late penalty; show the submission's notes."""
        earned = sum(test.score or 0.0 for test in self.results.tests)
        ratio = self.results.score / earned if earned else 1
        for test in self.results.tests:
            test_file = results.get_result(make_grade_id(test.number))
            for case_result in test_file.test_case_results:
                case_result.passed = test.status == PASSED
                case_result.message = case_result.test_case.success_message = test.output
            test_file.update_score((test.score or 0.0) * ratio)
        if self.results.output:
            results.set_output(self.results.output)


def _remove_other_files(needed_paths: set[Path]) -> None:
    """Remove everything except the paths in `needed_paths` from the folder that contains them."""
    for path in set(next(iter(needed_paths)).parent.iterdir()) - needed_paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
