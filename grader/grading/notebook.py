"""Grade a notebook against problems that are at hand, without an assignment, a roster or a folder."""

import secrets
from collections.abc import Mapping
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.problem.problem import Problem
from qdot.grader.grading.attempt import run_notebook
from qdot.grader.grading.marking import mark
from qdot.grader.judging.verdict import Verdict
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.cells import OverLimit, Unreadable
from qdot.grader.submissions.submission import find_python_files, read_submission


def grade_notebook(
    path: Path | str,
    problems: Mapping[str, Problem],
    *,
    secret: str | None = None,
    limits: Limits | None = None,
    strict: bool = False,
) -> dict[str, list[Verdict]]:
    r"""Run a notebook in the sandbox and return the verdicts on its answers, by slot ("p1", "p2", …).

    `secret` seeds the points at which answers are compared, as in `mark`. `limits` are seconds and memory. With
    `strict`, a machine that can't fully sandbox a notebook is refused. The notebook is only read. For late work,
    attempts and feedback, make an assignment (`qdot grade`). Raises QdotError if the file is no notebook.

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
    seed = f"{secret}/{submission.sha256}"
    with Sandbox(limits, strict=strict) as sandbox:
        try:
            answers = run_notebook(sandbox, submission, list(problems.items()), seed)
        except OverLimit as error:
            raise QdotError(f"{path}: {error}") from None
    return {
        slot: mark(
            problem, answers.of(slot, problem),
            {part.name: answers.reason(slot, part.name) for part in problem.parts},
            secret=secret, points_seed=seed,
        )
        for slot, problem in problems.items()
    }  # fmt: skip
