"""Limit what a student sees about a wrong answer to the level of `feedback` in assignment.toml.

Each level adds something to the previous one:

1. the outcome, and why an answer could not be parsed;
2. the mistake, or advice on what to look at, and which entries are correct;
3. a configuration where the answer is wrong, with the answer's own value there, which a student can't resubmit;
4. the correct value there;
5. the worked solution.
"""

import re
from dataclasses import replace

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.formula.identity import Certificate, SetDifference
from qdot.grader.grading.marking import NOT_RIGHT
from qdot.grader.grading.result import PartResult

_NAMED = r"\w+ = [-+\d.e]+"
_POSE = rf": (?:\(any\)|{_NAMED}(?:, {_NAMED})*)"
_VALUE = r"(?:\([^()]*\)|[^,;()])+"

_RIGHT_VALUES = (
    (rf"(\ban? [a-z ]+ is missing){_POSE}", r"\1"),
    (rf", expected {_VALUE}", ", which is not right"),
    (rf", and {_VALUE} is right", ", which is not right"),
)
"""Patterns of correct values in the reasons given by `qdot.grader.judging.formulas`, with their replacements."""

_NUMBERS = (
    (rf"(\bno [a-z ]+|right but for rounding){_POSE}", r"\1"),
    (rf" at {_NAMED}(?:, {_NAMED})*", ""),
    (rf": yours {_VALUE}, which is not right", ""),
    (rf"(\b(?:number|entry) \d+) is {_VALUE}, which is not right", r"\1 is not right"),
)
"""Patterns of the numbers of a counterexample, with their replacements."""


_ALONE = (
    (r"(?:^|; )differs$", ""),
    (r"\bclaimed, but no (singular configuration)$", r"what is claimed is not everywhere a \1"),
)
"""Patterns of phrases that make no sense without the withheld counterexample, with their replacements."""
_NAMES = ((r" \(transposed\?\)", ""),)
"""Patterns that name a mistake in the reason why an answer could not be parsed, with their replacements."""


def at_least(level: str, wanted: str) -> bool:
    """Return whether the first level of feedback shows at least as much as the second."""
    return FEEDBACK.index(level) >= FEEDBACK.index(wanted)


def hold_back(part: PartResult, level: str) -> PartResult:
    """Return a part of a result without the information that this level of feedback withholds from students.

    >>> from qdot import Outcome
    >>> reason = "number 1 is 2, and 0.624 m/s is right"
    >>> part = PartResult(name="joint-rates", outcome=Outcome.WRONG, points=0.0, max_points=1.0, reason=reason)
    >>> hold_back(part, "counterexample").reason
    'number 1 is 2, which is not right'
    """
    if part.outcome not in NOT_RIGHT or at_least(level, "values"):
        return part
    reason, certificate = _replace_patterns(part.reason, _RIGHT_VALUES), _without_right_values(part.certificate)
    if at_least(level, "counterexample"):
        return replace(part, reason=reason, certificate=certificate)
    reason = _replace_patterns(remove_numbers(reason), _ALONE) or "it is not what is due"
    certificate = None if part.certificate is None else replace(part.certificate, counterexample=None)
    if at_least(level, "mistake"):
        return replace(part, reason=reason, certificate=certificate)
    reason = _replace_patterns(reason, _NAMES) if certificate is None else ""
    outcome_only = replace(part, mistake=None, advice=None, entries=None, follows=None)
    return replace(outcome_only, reason=reason, certificate=certificate)


def remove_numbers(reason: str) -> str:
    """Return a reason without the numbers of its counterexample, which a table shows.

    >>> remove_numbers("entry 1 differs at a1 = 2: yours 4, expected 2")
    'entry 1 differs'
    """
    return _replace_patterns(_replace_patterns(reason, _RIGHT_VALUES), _NUMBERS)


def _replace_patterns(reason: str, patterns: tuple[tuple[str, str], ...]) -> str:
    for pattern, replacement in patterns:
        reason = re.sub(pattern, replacement, reason)
    return reason


def _without_right_values(certificate: Certificate | None) -> Certificate | None:
    """Return a certificate whose counterexample shows no correct values."""
    if certificate is None or certificate.counterexample is None:
        return certificate
    example = certificate.counterexample
    if isinstance(example, SetDifference):
        return replace(certificate, counterexample=replace(example, missing=None))
    return replace(certificate, counterexample=replace(example, expected=None))
