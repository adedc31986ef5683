"""Mark a student's answers to a problem: each part against its reference, points by the judgement's share."""

import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

import numpy as np

from exercises.mistakes.catalogue import NO_OFTENER, Oftener
from exercises.problem import Part, Problem
from exercises.quizzes import ASKED
from grader.advice import advise
from grader.answer import Given
from grader.clock import Allowance, Budget, Overlong
from grader.credit import credited
from grader.diagnosis import Cause, diagnose
from grader.follow import Followed, IsCopied, follow, nothing_copied
from grader.function_values import SHOWN, is_table
from grader.groups import group_of
from grader.parts import judge_given
from grader.reading import read_answer
from grader.verdict import Diagnosis, Judgement, Outcome, Verdict, missing

CREDIT = Fraction(4, 5)
"""The share of its points that a part earns by what follows from a wrong earlier answer, if nothing else is said."""


@np.errstate(all="ignore")  # what overflows in an answer is judged, and is no news for the staff
def mark(
    problem: Problem,
    answers: Mapping[str, str],
    reasons: Mapping[str, str] | None = None,
    *,
    secret: str | None = None,
    points_seed: str = "",
    credit: Fraction = CREDIT,
    is_copied: IsCopied = nothing_copied,
    oftener: Oftener = NO_OFTENER,
    allowance: Allowance | None = None,
) -> list[Verdict]:
    """Return a verdict for each part; `answers` and `reasons` (why there is none) are by the name of the part.

    A part that follows from the student's own wrong answer to an earlier one earns `credit` of its points, unless that
    answer `is_copied`. What goes wrong in our own code is UNGRADED: it is told loudly, and is no mark. Points at which
    answers are compared are drawn from `secret` and the answer; without one, a secret is drawn, and no answer has a
    group, whose key depends on it. `oftener` is what is known of mistakes that a class makes more. Of the `allowance`,
    what is left is for other problems: an answer that takes too long to judge is UNGRADED, and where it takes too long
    to find out what is behind a wrong one, nothing is told of it.

    >>> from exercises import generate
    >>> mark(generate("polar-rp/1", ["determinant"]), {"determinant": "d2 + 0.7"}, secret="s")
    [Verdict(determinant: partial, 0.8 of 1)]
    """
    texts = {part.name: answers[part.name] for part in problem.parts if part.name in answers}
    drawn = secrets.token_hex(16) if secret is None else secret
    seeds = {name: f"{drawn}/{problem.id}/{name}/{text}" for name, text in texts.items()}
    time = allowance or Allowance()
    own: dict[str, Given] = {}
    judged: dict[str, Judgement] = {}
    for part in problem.parts:
        if part.name not in texts:
            judged[part.name] = missing((reasons or {}).get(part.name, "no answer was found for this part"))
            continue
        try:
            with time.judging.spent():
                own[part.name] = read_answer(problem, part, texts[part.name], points_seed)
                judgement = judge_given(problem, part, own[part.name], seeds[part.name])
                judged[part.name] = credited(problem, part, judgement, own[part.name], seeds[part.name])
        except Overlong:
            judged[part.name] = _overlong(time.judging)
        except Exception as error:  # our own failure, whatever it is, must not become a mark
            judged[part.name] = _failed(error)
    wrong = [name for name, judgement in judged.items() if judgement.outcome in NOT_RIGHT]
    verdicts: list[Verdict] = []
    causes: list[Cause] = []
    for part in problem.parts:
        name = part.name
        diagnosis, followed, group = None, None, None
        before = [other for other in wrong if _is_before(problem, other, name)]
        if name in wrong and credit and before:
            try:
                with time.judging.spent():
                    followed = _safely(follow, problem, part, own, before, seeds[name], is_copied)
            except Overlong:  # it may have earned more
                judged[name] = _overlong(time.judging)
        judgement = judged[name]
        if judgement.outcome in NOT_RIGHT:
            about = (problem, part, own[name], seeds[name])
            if followed is None or followed.judgement.outcome is not Outcome.CORRECT:
                diagnosis = _looked(time.looking, diagnose, *about, tuple(causes), oftener)
                behind = diagnosis
                if diagnosis is None:
                    diagnosis = _looked(time.looking, advise, *about)
                if diagnosis is not None and diagnosis.cause is not None:
                    causes.append(Cause(*diagnosis.cause, name, ASKED[part.kind].title))
            else:
                behind = _looked(time.looking, diagnose, *about, (), oftener)
            group = None if secret is None else _looked(time.looking, group_of, *about[:3], behind, secret)
        shown = SHOWN if name in texts and is_table(texts[name]) else texts.get(name)
        verdicts.append(replace(verdict(part, judgement, shown, diagnosis, followed, credit), group=group))
    return verdicts


NOT_RIGHT = (Outcome.WRONG, Outcome.PARTIAL)


def _is_before(problem: Problem, one: str, other: str) -> bool:
    names = [part.name for part in problem.parts]
    return names.index(one) < names.index(other)


def verdict(
    part: Part,
    judgement: Judgement,
    answer: str | None,
    diagnosis: Diagnosis | None = None,
    followed: Followed | None = None,
    credit: Fraction = CREDIT,
) -> Verdict:
    """Return the verdict on a part: its points by the judgement, or by what follows where that is more."""
    if judgement.outcome is Outcome.UNGRADED:
        return Verdict(part.name, judgement, None, part.points, answer)
    points = points_of(part.points, judgement.share)
    if followed is None or (more := points_of(part.points, followed.judgement.share, credit)) <= points:
        return Verdict(part.name, judgement, points, part.points, answer, diagnosis)
    how_far = "follows" if followed.judgement.outcome is Outcome.CORRECT else "follows in part"
    reason = (
        f"this {how_far} from your own answer to {followed.earlier!r}, which is not right, and earns "
        f"{float(credit):.0%} of what it would; against the solution: {judgement.reason}"
    )
    followed_from = replace(judgement, outcome=Outcome.PARTIAL, reason=reason)
    follows = _entries(part, followed.judgement)
    return Verdict(part.name, followed_from, more, part.points, answer, diagnosis, followed.earlier, follows=follows)


def _entries(part: Part, judgement: Judgement) -> tuple[tuple[bool, ...], ...] | None:
    """Return which entries are as they should be, of an answer that has several."""
    if judgement.entries is not None or judgement.outcome is not Outcome.CORRECT:
        return judgement.entries
    rows, columns = part.shape or (0, 0)
    return ((True,) * columns,) * rows or None


def points_of(points: float, share: float, credit: Fraction = Fraction(1)) -> float:
    """Return a share of the points, exactly, to four decimals.

    >>> points_of(0.3, 1 / 3), points_of(2, 1.0, Fraction(4, 5))
    (0.1, 1.6)
    """
    return float(round(Fraction(str(points)) * Fraction(share).limit_denominator(1000) * credit, 4))


def total(points: Iterable[float | None]) -> float:
    """Return the sum of points of four decimals, exactly: 0.1 and 0.2 are 0.3."""
    return float(sum((Fraction(str(number)) for number in points if number is not None), Fraction(0)))


def number(value: float) -> str:
    """Return points as they are, to four decimals.

    >>> number(2.0), number(123.4567), number(0.25)
    ('2', '123.4567', '0.25')
    """
    return f"{value:.4f}".rstrip("0").rstrip(".")


Found = TypeVar("Found")


def _safely(look: Callable[..., Found], *about: object) -> Found | None:
    """Return what is found out about a wrong answer, None where that fails: the verdict is sound without it."""
    try:
        return look(*about)
    except Exception:
        return None


def _looked(budget: Budget, look: Callable[..., Found], *about: object) -> Found | None:
    """Return what is found out within a budget, None where nothing is left of it."""
    try:
        with budget.spent():
            return _safely(look, *about)
    except Overlong:
        return None


def _overlong(budget: Budget) -> Judgement:
    reason = (
        f"to judge the answers of this notebook takes longer than {budget.seconds:g} s of processor time; this one has "
        "no mark yet, tell your instructor"
    )
    return Judgement(Outcome.UNGRADED, 0.0, reason)


def _failed(error: Exception) -> Judgement:
    reason = f"qdot failed on this answer ({type(error).__name__}: {error}); it has no mark yet, tell your instructor"
    return Judgement(Outcome.UNGRADED, 0.0, reason[:500])
