"""Mark a student's answers to a problem: judge each answer, and compute its share of the points.

An answer earns points in one of three ways: it agrees with the correct answer (the reference), it gets partial credit,
or it follows from the student's own wrong answer to an earlier part (follow-through).
"""

import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple, TypeVar

import numpy as np

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.time_limit import OutOfTime
from qdot.exercises.formula.trees import has_blank
from qdot.exercises.mistakes.base import join_words
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions import question_of
from qdot.grader.diagnosis.advice import advise
from qdot.grader.diagnosis.diagnosis import EarlierMistake, diagnose
from qdot.grader.diagnosis.groups import find_group
from qdot.grader.diagnosis.term_overlap import has_enough_terms
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import FUNCTION_TEXT, is_function_table
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Diagnosis, Judgement, Outcome, Verdict, make_missing_judgement
from qdot.grader.marking.follow_through import FollowThrough, IsCopied, find_follow_through, never_copied
from qdot.grader.marking.partial_credit import AnswerInContext, give_partial_credit
from qdot.grader.sandbox.time_budgets import Budget, TimeBudgets

DEFAULT_FOLLOW_THROUGH_SHARE = Fraction(4, 5)
"""The default share of its points that a part earns if it follows from a wrong earlier answer."""
WRONG_OR_PARTIAL = (Outcome.WRONG, Outcome.PARTIAL)


@dataclass(frozen=True)
class MarkingRules:
    """The rules for follow-through and partial credit, which depend on the assignment and its class.

    `follow_through_share` is the share of its points that a part earns if it follows from a wrong earlier answer.
    `is_copied` is a function that returns whether an answer is correct for another student's problem.
    """

    follow_through_share: Fraction = DEFAULT_FOLLOW_THROUGH_SHARE
    is_copied: IsCopied = never_copied


@np.errstate(all="ignore")  # an overflow in an answer is judged; a warning about it would only confuse the staff
def mark(
    problem: Problem, answers: Mapping[str, str], reasons: Mapping[str, str] | None = None, *,
    secret: str | None = None, functions_seed: str = "", rules: MarkingRules = MarkingRules(),
    budgets: TimeBudgets | None = None,
) -> list[Verdict]:  # fmt: skip
    """Return a verdict for each part of a problem.

    The keys of `answers` and `reasons` are the names of the parts. `reasons` says why a part has no answer.

    A part that follows from the student's own wrong answer to an earlier part earns `rules.follow_through_share` of its
    points, unless the earlier answer was copied or is not an attempt at this arm (docs/judging.md).

    If qdot's own code fails, or judging takes longer than the `budgets` allow, the part is UNGRADED. If only the search
    for the mistake takes too long, no mistake is named. `secret` and the answer determine the configurations at which
    answers are compared; `functions_seed` determines those at which Python functions were called. If `secret` is None,
    a secret is chosen at random, and equal wrong answers are not grouped, because the keys of groups depend on it.

    >>> from qdot import generate
    >>> mark(generate("polar-rp/1", ["determinant"]), {"determinant": "d2 + 0.7"}, secret="s")
    [Verdict(determinant: partial, 0.8 of 1)]
    """
    texts = {part.name: answers[part.name] for part in problem.parts if part.name in answers}
    seed = secrets.token_hex(16) if secret is None else secret
    seeds = {name: f"{seed}/{problem.id}/{name}/{text}" for name, text in texts.items()}
    marking = _ProblemMarking(problem, seeds, secret, rules, budgets or TimeBudgets())
    for part in problem.parts:
        if part.name in texts:
            marking.judgements[part.name] = marking.judge(part, texts[part.name], functions_seed)
        else:
            reason = (reasons or {}).get(part.name, "no answer was found for this part")
            marking.judgements[part.name] = make_missing_judgement(reason)
    return [marking.make_verdict(part, texts.get(part.name)) for part in problem.parts]


def compute_earned_share(problem: Problem, part: Part, text: str) -> Fraction:
    """Return the share (0 to 1) of a part's points that a typed answer earns without follow-through.

    The share is the same in every call, because the configurations depend only on the problem and the part.
    """
    seed = f"{problem.id}/{part.name}"
    parsed_answer = read_answer(problem, part, text, seed)
    answer = AnswerInContext(problem, part, parsed_answer, seed)
    judgement = give_partial_credit(answer, judge_parsed(problem, part, parsed_answer, seed))
    return Fraction(judgement.share).limit_denominator(1000)


@dataclass
class _ProblemMarking:
    """The state of marking one problem part by part: the parsed answers and judgements so far.

    `seeds` maps each part to the seed of the configurations at which its answer is compared. `reference_reasons`
    maps each part to the reason of its judgement before partial credit was given, and `earlier_mistakes` are the
    mistakes that explain the wrong answers so far. `attempt_parts` lists the parts whose answers are real attempts at
    this arm (docs/judging.md). For the `undecided_parts`, there was no time to decide this.
    """

    problem: Problem
    seeds: Mapping[str, str]
    secret: str | None
    rules: MarkingRules
    budgets: TimeBudgets
    parsed_answers: dict[str, ParsedAnswer] = field(default_factory=dict)
    judgements: dict[str, Judgement] = field(default_factory=dict)
    reference_reasons: dict[str, str] = field(default_factory=dict)
    earlier_mistakes: list[EarlierMistake] = field(default_factory=list)
    attempt_parts: list[str] = field(default_factory=list)
    undecided_parts: list[str] = field(default_factory=list)

    def judge(self, part: Part, text: str, functions_seed: str) -> Judgement:
        """Return the judgement on an answer, compared with the reference."""
        seed = self.seeds[part.name]
        try:
            with self.budgets.judging.spend():
                parsed_answer = self.parsed_answers[part.name] = read_answer(self.problem, part, text, functions_seed)
                judgement = judge_parsed(self.problem, part, parsed_answer, seed)
                self.reference_reasons[part.name] = judgement.reason
                answer = AnswerInContext(self.problem, part, parsed_answer, seed)
                return self._name_blank_parts(part, give_partial_credit(answer, judgement, self.rules.is_copied))
        except OutOfTime:
            return _make_overtime_judgement(self.budgets.judging)
        except Exception as error:  # no error in qdot may become a mark
            return _make_failure_judgement(error)

    def _name_blank_parts(self, part: Part, judgement: Judgement) -> Judgement:
        """If a formula of the answer contains a blank, add to the reason which earlier parts to fill in."""
        if judgement.outcome not in WRONG_OR_PARTIAL or not _has_blank_in_formula(self.parsed_answers[part.name]):
            return judgement
        trees = {name: parsed.tree for name, parsed in self.parsed_answers.items() if name in self.judgements}
        is_missing = {name: self.judgements[name].outcome is Outcome.MISSING for name in trees}
        blank_parts = [repr(name) for name, tree in trees.items() if is_missing[name] or (tree and has_blank(tree))]
        if not blank_parts:
            return judgement
        names = join_words(blank_parts)
        advice = f"your answer contains a blank from an earlier part. Fill in {names} first, then redo this part"
        is_refused = self.parsed_answers[part.name].refusal is not None  # because of the blank
        other_reason = "" if is_refused else f". {_capitalize(judgement.reason)}"
        return replace(judgement, reason=f"{advice}{other_reason}")

    def make_verdict(self, part: Part, text: str | None) -> Verdict:
        """Return the verdict on a part. Call this in the order of the parts, after all of them are judged."""
        follow_through = self._judge_follow_through(part)
        judgement = self.judgements[part.name]
        answer = FUNCTION_TEXT if text is not None and is_function_table(text) else text
        points = None if judgement.outcome is Outcome.UNGRADED else compute_points(part.points, judgement.share)
        verdict = Verdict(part.name, judgement, points, part.points, answer)
        if judgement.outcome in WRONG_OR_PARTIAL:
            verdict = replace(verdict, **self._explain(part, follow_through)._asdict())
            reference_reason = self.reference_reasons.get(part.name, judgement.reason)
            return _apply_follow_through(verdict, part, follow_through, self.rules, reference_reason)
        is_attempt = judgement.outcome is Outcome.CORRECT and not part.answer.offered_options
        return replace(verdict, attempt=True if is_attempt else None)

    def _judge_follow_through(self, part: Part) -> FollowThrough | None:
        """Return the judgement on a wrong answer, compared with what follows from earlier wrong answers.

        Return None if nothing follows. If qdot fails to compare the answer, the answer becomes UNGRADED, because it
        might have earned more.
        """
        names = [other_part.name for other_part in self.problem.parts]
        wrong_parts = [name for name in names if self.judgements[name].outcome in WRONG_OR_PARTIAL]
        earlier_parts = [name for name in wrong_parts if names.index(name) < names.index(part.name)]
        if part.name not in wrong_parts or not self.rules.follow_through_share or not earlier_parts:
            return None
        follow_through, answers, seed = None, self.parsed_answers, self.seeds[part.name]
        try:
            with self.budgets.judging.spend():
                follow_through = find_follow_through(
                    self.problem, part, answers, earlier_parts, seed, self.rules.is_copied, self.attempt_parts
                )
        except OutOfTime:
            self.judgements[part.name] = _make_overtime_judgement(self.budgets.judging)
        except RecursionError:  # formulas are nested deeper than in any real answer
            return None
        except Exception as error:
            self.judgements[part.name] = _make_failure_judgement(error)
        if follow_through is not None and follow_through.non_attempt_part in self.undecided_parts:
            self.judgements[part.name] = _make_overtime_judgement(self.budgets.diagnosing)
        return follow_through

    def _explain(self, part: Part, follow_through: FollowThrough | None) -> "_Explanation":
        """Return the explanation of a wrong answer."""
        arguments = (self.problem, part, self.parsed_answers[part.name], self.seeds[part.name])
        budget = self.budgets.diagnosing
        follows_completely = follow_through is not None and follow_through.judgement.outcome is Outcome.CORRECT
        is_from_attempt = follow_through is not None and follow_through.non_attempt_part is None
        follows_from_attempt = follows_completely and is_from_attempt
        earlier_mistakes = () if follows_from_attempt else tuple(self.earlier_mistakes)
        mistake_diagnosis = _run_within(budget, diagnose, *arguments, earlier_mistakes)
        diagnosis = None if follows_from_attempt else mistake_diagnosis or _run_within(budget, advise, *arguments)
        if diagnosis is not None and diagnosis.cause is not None:
            self.earlier_mistakes.append(EarlierMistake(*diagnosis.cause, part.name, question_of(part).title))
        is_attempt = None
        if part.answer.is_symbolic:
            is_explained = mistake_diagnosis is not None and mistake_diagnosis.is_single_mistake
            is_close = follows_from_attempt or _is_half_right(self.judgements[part.name]) or is_explained
            has_substance = is_close or bool(_run_within(budget, has_enough_terms, *arguments))
            # What follows from an answer that is no attempt is no attempt, either.
            is_attempt = has_substance and (follows_from_attempt or not follows_completely)
            if is_attempt:
                self.attempt_parts.append(part.name)
            elif budget.remaining_seconds <= 0:
                self.undecided_parts.append(part.name)
        group = None
        if self.secret is not None:
            group = _run_within(budget, find_group, *arguments[:3], mistake_diagnosis, self.secret)
        return _Explanation(diagnosis, group, is_attempt)


class _Explanation(NamedTuple):
    """The fields of a verdict that explain a wrong answer; each is None if it is unknown."""

    diagnosis: Diagnosis | None
    group: str | None
    attempt: bool | None


def _is_half_right(judgement: Judgement) -> bool:
    """Return whether at least half of an answer is correct.

    A single formula must be more than half correct, because one of its factors may match by chance.
    """
    return judgement.share >= Fraction(1, 2) if judgement.entries is not None else judgement.share > Fraction(1, 2)


def _has_blank_in_formula(parsed: ParsedAnswer) -> bool:
    """Return whether an entry of an answer is a formula with a blank in it, not only a blank."""
    if parsed.rows is not None:
        return any(has_blank(entry) and entry.kind != "blank" for row in parsed.rows for entry in row)
    return parsed.tree is not None and has_blank(parsed.tree)


def _capitalize(reason: str) -> str:
    return reason[:1].upper() + reason[1:]


def _apply_follow_through(
    verdict: Verdict, part: Part, follow_through: FollowThrough | None, rules: MarkingRules, reference_reason: str
) -> Verdict:
    """Return the verdict on a wrong answer, with the points for follow-through if these are more.

    `reference_reason` is the reason why the answer differs from the reference.
    """
    if follow_through is None:
        return verdict
    judgement = verdict.judgement
    follows_completely = follow_through.judgement.outcome is Outcome.CORRECT
    if follow_through.non_attempt_part is not None:
        reason = (
            f"{judgement.reason}. Your answer follows from your wrong answer to "
            f"{follow_through.non_attempt_part!r}, but this earns no points, because less than half of that answer "
            "fits this arm and no single known mistake explains it"
        )
        return replace(verdict, judgement=replace(judgement, reason=reason)) if follows_completely else verdict
    followed_points = compute_points(part.points, follow_through.judgement.share, rules.follow_through_share)
    source = f"from your wrong answer to {follow_through.earlier_part!r}"
    entry_follows = _find_following_entries(part, follow_through)
    next_step = "Correct that answer first, then redo this part."
    if followed_points <= (verdict.points or 0.0):
        reason = f"your answer follows {source}. {next_step} {_capitalize(judgement.reason)}"
        if not follows_completely:
            return verdict
        return replace(verdict, judgement=replace(judgement, reason=reason), follows=entry_follows)
    earned_words = "it earns" if follows_completely else "the entries or conditions that follow earn"
    reason = (
        f"your answer follows{'' if follows_completely else ' in part'} {source}, so {earned_words} "
        f"{100 * float(rules.follow_through_share):.4g} % of the points. {next_step} "
        f"Compared with the solution: {reference_reason}"
    )
    judgement = replace(judgement, outcome=Outcome.PARTIAL, reason=reason)
    followed_verdict = replace(verdict, judgement=judgement, points=followed_points)
    return replace(followed_verdict, followed_from=follow_through.earlier_part, follows=entry_follows)


def _find_following_entries(part: Part, follow_through: FollowThrough) -> tuple[tuple[bool, ...], ...] | None:
    """Return for each entry of an answer, in rows, whether it follows; None if the answer has no separate entries."""
    judgement = follow_through.judgement
    if judgement.entries is not None or judgement.outcome is not Outcome.CORRECT:
        return judgement.entries
    rows, columns = part.shape or (0, 0)
    return ((True,) * columns,) * rows or None


def map_max_points(assignment: Assignment) -> dict[str, float]:
    """Map each part's name in the assignment, for example "p1.jacobian", to its maximum points."""
    names = [f"{slot.name}.{question}" for slot in assignment.slots for question in slot.questions]
    return dict(zip(names, [points for slot in assignment.slots for points in slot.max_points], strict=True))


def compute_points(points: float, share: float, factor: Fraction = Fraction(1)) -> float:
    """Return `share` times `factor` times the points, with the share as a simple fraction, to four decimals.

    >>> compute_points(0.3, 1 / 3), compute_points(2, 1.0, Fraction(4, 5))
    (0.1, 1.6)
    """
    return float(round(Fraction(str(points)) * Fraction(share).limit_denominator(1000) * factor, 4))


def sum_points(points: Iterable[float | None]) -> float:
    """Return the exact sum of points, which have at most four decimals: the sum of 0.1 and 0.2 is 0.3."""
    return float(sum((Fraction(str(number)) for number in points if number is not None), Fraction(0)))


def format_points(value: float) -> str:
    """Return points as text, with up to four decimals and without trailing zeros.

    >>> format_points(2.0), format_points(123.4567), format_points(0.25)
    ('2', '123.4567', '0.25')
    """
    return f"{value:.4f}".rstrip("0").rstrip(".")


Explained = TypeVar("Explained")


def _run_within(budget: Budget, explain: Callable[..., Explained], *arguments: object) -> Explained | None:
    """Return the result of a function that helps to explain an answer; None if it fails or takes too long.

    An error in such a function must not leave the answer without a mark.
    """
    try:
        with budget.spend():
            return explain(*arguments)
    except (OutOfTime, Exception):
        return None


def _make_overtime_judgement(budget: Budget) -> Judgement:
    """Return the judgement on an answer for which no time is left in a budget."""
    cause = f"judging the answers of this notebook takes more than {budget.seconds:g} s of processor time"
    reason = f"{cause}; this answer has no mark yet. Please tell your instructor"
    return Judgement(Outcome.UNGRADED, 0.0, reason, over_limit=True)


def _make_failure_judgement(error: Exception) -> Judgement:
    """Return the judgement on an answer that qdot failed to judge because of an error in its own code."""
    cause = f"{type(error).__name__}: {error}"[:400]
    reason = f"qdot failed on this answer ({cause}); it has no mark yet. Please tell your instructor"
    return Judgement(Outcome.UNGRADED, 0.0, reason)
