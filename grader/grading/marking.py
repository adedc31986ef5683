"""Mark a student's answers to a problem: each part against its reference, points by the judgement's share."""

import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeVar

import numpy as np

from qdot.exercises.problem.credit import HALF
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.grader.diagnosis.advice import advise
from qdot.grader.diagnosis.diagnosis import Cause, diagnose
from qdot.grader.diagnosis.follow_through import Followed, IsCopied, follow, nothing_copied
from qdot.grader.diagnosis.groups import group_of
from qdot.grader.diagnosis.term_overlap import has_terms
from qdot.grader.grading.partial_credit import credited
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.answer_parser import read_answer
from qdot.grader.judging.functions import SHOWN, is_table
from qdot.grader.judging.judge import judge_given
from qdot.grader.judging.verdict import Diagnosis, Judgement, Outcome, Verdict, missing
from qdot.grader.sandbox.clock import Allowance, Budget, Overlong

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
    allowance: Allowance | None = None,
) -> list[Verdict]:
    """Return a verdict for each part; `answers` and `reasons` (why there is none) are by the name of the part.

    A part that follows from the student's own wrong answer to an earlier one earns `credit` of its points, unless that
    answer `is_copied`, or is no attempt at this arm. It is an attempt if half of its entries or of the solution's terms
    are right, if one known mistake gives it, or if it follows from an attempt; what follows from no attempt is none.
    What goes wrong in our own code is UNGRADED: it is told loudly, and is no mark. Points at which answers are compared
    are drawn from `secret` and the answer; without one, a secret is drawn, and no answer has a group, whose key depends
    on it. Of the `allowance`, what is left is for other problems: an answer that takes too long to judge is UNGRADED,
    and where it takes too long to find out what is behind a wrong one, nothing is told of it.

    >>> from qdot import generate
    >>> mark(generate("polar-rp/1", ["determinant"]), {"determinant": "d2 + 0.7"}, secret="s")
    [Verdict(determinant: partial, 0.8 of 1)]
    """
    texts = {part.name: answers[part.name] for part in problem.parts if part.name in answers}
    drawn = secrets.token_hex(16) if secret is None else secret
    seeds = {name: f"{drawn}/{problem.id}/{name}/{text}" for name, text in texts.items()}
    one = _One(problem, seeds, secret, credit, is_copied, allowance or Allowance())
    for part in problem.parts:
        if part.name in texts:
            one.judged[part.name] = one.judge(part, texts[part.name], points_seed)
        else:
            one.judged[part.name] = missing((reasons or {}).get(part.name, "no answer was found for this part"))
    verdicts = []
    for part in problem.parts:
        name = part.name
        followed, told = one.follow(part), _Told()
        if one.judged[name].outcome in NOT_RIGHT:
            told = one.look(part, followed)
        elif one.judged[name].outcome is Outcome.CORRECT and not part.answer.offered:
            told = _Told(attempt=True)
        shown = SHOWN if name in texts and is_table(texts[name]) else texts.get(name)
        made = verdict(part, one.judged[name], shown, told.diagnosis, followed, credit)
        verdicts.append(replace(made, group=told.group, attempt=told.attempt))
    return verdicts


def share_earned(problem: Problem, part: Part, text: str) -> Fraction:
    """Return what share of a part's points an answer earns by itself, as it is typed; the same at every call."""
    seed = f"{problem.id}/{part.name}"
    given = read_answer(problem, part, text, seed)
    judgement = credited(problem, part, judge_given(problem, part, given, seed), given, seed)
    return Fraction(judgement.share).limit_denominator(1000)


@dataclass(frozen=True)
class _Told:
    """What is known of an answer beside the judgement on it: the mistake, its group, whether it is an attempt."""

    diagnosis: Diagnosis | None = None
    group: str | None = None
    attempt: bool | None = None


@dataclass
class _One:
    """A problem that is being marked: how, and what is known of its parts so far, from the first to the last.

    `undecided` are wrong answers of which it could not be found out in time whether they are attempts.
    """

    problem: Problem
    seeds: Mapping[str, str]
    secret: str | None
    credit: Fraction
    is_copied: IsCopied
    time: Allowance
    own: dict[str, ParsedAnswer] = field(default_factory=dict)
    judged: dict[str, Judgement] = field(default_factory=dict)
    causes: list[Cause] = field(default_factory=list)
    attempts: list[str] = field(default_factory=list)
    undecided: list[str] = field(default_factory=list)

    def judge(self, part: Part, text: str, points_seed: str) -> Judgement:
        """Return the judgement on an answer against the reference."""
        try:
            with self.time.judging.spend():
                given = self.own[part.name] = read_answer(self.problem, part, text, points_seed)
                judgement = judge_given(self.problem, part, given, self.seeds[part.name])
                return credited(self.problem, part, judgement, given, self.seeds[part.name], self.is_copied)
        except Overlong:
            return _overlong(self.time.judging)
        except Exception as error:  # our own failure, whatever it is, must not become a mark
            return _failed(error)

    def follow(self, part: Part) -> Followed | None:
        """Return the judgement on a wrong answer against what follows from wrong ones before.

        Where that can't be found out, the answer has no mark: it may have earned more.
        """
        names = [each.name for each in self.problem.parts]
        wrong = [name for name in names if self.judged[name].outcome in NOT_RIGHT]
        before = [name for name in wrong if names.index(name) < names.index(part.name)]
        if part.name not in wrong or not self.credit or not before:
            return None
        followed, seed = None, self.seeds[part.name]
        try:
            with self.time.judging.spend():
                followed = follow(self.problem, part, self.own, before, seed, self.is_copied, self.attempts)
        except Overlong:
            self.judged[part.name] = _overlong(self.time.judging)
        except RecursionError:  # formulas that nest as deep as nobody writes them
            return None
        except Exception as error:
            self.judged[part.name] = _failed(error)
        if followed is not None and followed.idle in self.undecided:
            self.judged[part.name] = _overlong(self.time.looking)
        return followed

    def look(self, part: Part, followed: Followed | None) -> _Told:
        """Find out what is behind a wrong answer."""
        about, looking = (self.problem, part, self.own[part.name], self.seeds[part.name]), self.time.looking
        causes = () if _is_followed(followed) else tuple(self.causes)
        diagnosis = behind = _looked(looking, diagnose, *about, causes)
        if _is_followed(followed):
            diagnosis = None
        elif diagnosis is None:
            diagnosis = _looked(looking, advise, *about)
        if diagnosis is not None and diagnosis.cause is not None:
            self.causes.append(Cause(*diagnosis.cause, part.name, ASKED[part.kind].title))
        attempt = None
        if part.answer.is_formulas:
            attempt = (
                _is_followed(followed)
                or _is_half_right(self.judged[part.name])
                or (behind is not None and behind.is_one)
            )
            attempt = attempt or bool(_looked(looking, has_terms, *about))
            attempt = attempt and not _is_followed(followed, from_attempt=False)
            self.attempts += [part.name] if attempt else []
            self.undecided += [part.name] if not attempt and looking.left <= 0 else []
        group = None if self.secret is None else _looked(looking, group_of, *about[:3], behind, self.secret)
        return _Told(diagnosis, group, attempt)


NOT_RIGHT = (Outcome.WRONG, Outcome.PARTIAL)


def _is_followed(followed: Followed | None, *, from_attempt: bool = True) -> bool:
    """Tell whether an answer is all that follows from an earlier attempt, or from what is none."""
    is_whole = followed is not None and followed.judgement.outcome is Outcome.CORRECT
    return is_whole and followed is not None and (followed.idle is None) is from_attempt


def _is_half_right(judgement: Judgement) -> bool:
    """Tell whether half of an answer is right; of one formula more than half, as a factor may be shared by chance."""
    return judgement.share >= HALF if judgement.entries is not None else judgement.share > HALF


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
    if followed is not None and followed.idle is not None:
        if followed.judgement.outcome is Outcome.CORRECT:
            judgement = replace(judgement, reason=f"{judgement.reason}; {_no_attempt(followed.idle)}")
        return Verdict(part.name, judgement, points, part.points, answer, diagnosis)
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


def _no_attempt(earlier: str) -> str:
    return (
        f"it follows from your own answer to {earlier!r}, and earns nothing by that: less than half of that answer is "
        "of this arm, and no single known mistake gives it"
    )


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
        with budget.spend():
            return _safely(look, *about)
    except Overlong:
        return None


def _overlong(budget: Budget) -> Judgement:
    reason = (
        f"to judge the answers of this notebook takes longer than {budget.seconds:g} s of processor time; this one has "
        "no mark yet, tell your instructor"
    )
    return Judgement(Outcome.UNGRADED, 0.0, reason, over_limit=True)


def _failed(error: Exception) -> Judgement:
    reason = f"qdot failed on this answer ({type(error).__name__}: {error}); it has no mark yet, tell your instructor"
    return Judgement(Outcome.UNGRADED, 0.0, reason[:500])
