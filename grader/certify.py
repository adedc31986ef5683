"""The certificate of a problem from the grader's side, above both packages: the reference earns full marks."""

from collections.abc import Generator, Sequence
from contextlib import closing

from exercises.generate import generate
from exercises.parallel import ordered_map
from exercises.problem import Choice, ConditionSet, Expression, Part, Problem, ProblemId
from exercises.verify import certify
from grader.marking import judge
from grader.verdict import Outcome


def reference_text(part: Part) -> str:
    """Return the reference as a student would have to type it."""
    answer = part.answer
    if isinstance(answer, Choice):
        return answer.letter
    if isinstance(answer, ConditionSet):
        return "[" + ", ".join(piece for piece in answer.pieces()) + "]"
    if isinstance(answer, Expression):
        return str(answer.reference)
    return str(answer.reference.tolist())


def failures_of(problem: Problem) -> list[str]:
    """Return what is wrong with a problem: failed checks, and references that do not get full marks."""
    failed = [f"{check.name}: {check.detail}" for check in certify(problem).checks if not check.passed]
    for part in problem.parts:
        judgement = judge(problem, part, reference_text(part), f"certify/{problem.id}/{part.name}")
        if judgement.outcome is not Outcome.CORRECT:
            failed.append(f"{part.name}: the reference itself is judged {judgement.outcome}: {judgement.reason}")
    return failed


def _failures(_: None, identity: ProblemId) -> list[str]:
    try:
        return failures_of(generate(identity))
    except RuntimeError as error:
        return [str(error)]


def certify_all(identities: Sequence[ProblemId], jobs: int) -> Generator[tuple[ProblemId, list[str]], None, None]:
    """Yield every problem with its failures, in order."""
    with closing(ordered_map(_failures, identities, jobs, _nothing, ())) as found:
        yield from zip(identities, found, strict=True)


def _nothing() -> None:
    """Prepare nothing."""
