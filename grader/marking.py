"""Mark a student's answers to a problem: each part against its reference, points by the judgement's share."""

from collections.abc import Mapping

from exercises.problem import Part, Problem, variable
from grader.diagnosis import diagnose
from grader.functions import SHOWN, is_table
from grader.parts import judge
from grader.verdict import Diagnosis, Judgement, Outcome, Verdict, missing


def mark(
    problem: Problem,
    slot: str,
    answers: Mapping[str, str],
    reasons: Mapping[str, str],
    secret: str,
    points_seed: str = "",
) -> list[Verdict]:
    """Return a verdict for each part; `answers` and `reasons` (why there is none) are by variable name.

    What goes wrong in our own code is UNGRADED: it is told loudly, and is no mark.
    """
    verdicts = []
    for part in problem.parts:
        name, diagnosis = variable(slot, part.name), None
        answer = answers.get(name)
        if answer is None:
            judgement = missing(reasons.get(name, "no answer was found for this part"))
        else:
            seed = f"{secret}/{problem.id}/{part.name}/{answer}"
            judgement = _judged(problem, part, answer, seed, points_seed)
            if judgement.outcome in (Outcome.WRONG, Outcome.PARTIAL):
                diagnosis = _diagnosed(problem, part, answer, seed, points_seed)
        points = None if judgement.outcome is Outcome.UNGRADED else round(part.points * judgement.share, 4)
        shown = SHOWN if answer is not None and is_table(answer) else answer
        verdicts.append(Verdict(part.name, judgement, points, part.points, shown, diagnosis))
    return verdicts


def _diagnosed(problem: Problem, part: Part, answer: str, seed: str, points_seed: str) -> Diagnosis | None:
    try:
        return diagnose(problem, part, answer, seed, points_seed)
    except Exception:  # no mark hangs on it, and the verdict is sound without
        return None


def _judged(problem: Problem, part: Part, answer: str, seed: str, points_seed: str) -> Judgement:
    try:
        return judge(problem, part, answer, seed, points_seed)
    except Exception as error:  # our own failure, whatever it is, must not become a mark
        reason = (
            f"qdot failed on this answer ({type(error).__name__}: {error}); it has no mark yet, tell your instructor"
        )
        return Judgement(Outcome.UNGRADED, 0.0, reason[:500])
