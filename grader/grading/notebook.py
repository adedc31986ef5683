"""A notebook graded by itself, against problems that are at hand: without an assignment, a roster or a folder."""

import secrets
from collections.abc import Mapping
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.notebook.setup_cell import setup_cell
from qdot.exercises.problem.problem import Problem
from qdot.grader.grading.marking import mark
from qdot.grader.judging.functions import calls_of
from qdot.grader.judging.verdict import Verdict
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.answer_locator import find_answers
from qdot.grader.submissions.cells import OverLimit, Unreadable, without_self_checks
from qdot.grader.submissions.submission import find_python_files, read_submission


def grade_notebook(
    path: Path | str,
    problems: Mapping[str, Problem],
    *,
    secret: str | None = None,
    limits: Limits | None = None,
    strict: bool = False,
) -> dict[str, list[Verdict]]:
    r"""Run a notebook, contained, and return the verdicts on the answers to problems, by slot ("p1", "p2", …).

    `secret` draws the points at which answers are compared, as in `mark`; `limits` are seconds and memory; a `strict`
    run refuses a machine that can't contain a notebook. The notebook is read only; whoever wants late work,
    attempts and feedback has an assignment (`qdot grade`). Raises QdotError for a file that is no notebook.

    >>> import tempfile
    >>> from qdot import generate
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "mine.md"
    ...     _ = path.write_text("```python\np1_determinant = '-d2 - 0.7'\n```")
    ...     grade_notebook(path, {"p1": problem})
    {'p1': [Verdict(determinant: correct, 1 of 1)]}
    """
    try:
        submission = read_submission(Path(path), siblings=find_python_files(Path(path)))
    except Unreadable as error:
        raise QdotError(str(error)) from None
    secret = secrets.token_hex(16) if secret is None else secret
    drawn = f"{secret}/{submission.sha256}"
    parts = [f"{slot}.{part.name}" for slot, problem in problems.items() for part in problem.parts]
    calls = {slot: calls_of(problem, problem.domain(), drawn) for slot, problem in problems.items()}
    cells, setup = without_self_checks(submission.cells, list(problems.items())), setup_cell(list(problems.items()))
    with Sandbox(limits, strict=strict) as sandbox:
        try:
            answers = find_answers(
                cells, parts, lambda cells, names: sandbox.run(cells, names, calls, setup, submission.modules)
            )
        except OverLimit as error:
            raise QdotError(f"{path}: {error}") from None
    return {
        slot: mark(
            problem, answers.of(slot, problem),
            {part.name: answers.reason(slot, part.name) for part in problem.parts},
            secret=secret, points_seed=drawn,
        )
        for slot, problem in problems.items()
    }  # fmt: skip
