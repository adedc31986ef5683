"""Limit what a student sees about a wrong answer to the level of `feedback` in assignment.toml.

Each level adds something to the previous one:

1. the outcome, and why an answer could not be parsed;
2. the mistake, or advice on what to look at, and which entries are correct;
3. a configuration where the answer is wrong, with the answer's value there, which is of no use for another attempt;
4. the correct value there;
5. the worked solution.
"""

import re
from dataclasses import replace
from typing import Any

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS
from qdot.exercises.formula.equality import SetDifference
from qdot.grader.grading.result import PartResult
from qdot.grader.marking.marking import WRONG_OR_PARTIAL

_NAMED_VALUE = r"\w+ = [-+\d.e]*\d"  # theta1 = 0.5
_CONFIGURATION = rf": (?:\(any\)|{_NAMED_VALUE}(?:, {_NAMED_VALUE})*)"  # : theta1 = 0.5, a1 = 2
_VALUE = r"(?:\([^()]*\)|[^,;().]|\.(?! ))+"  # 0.5, blank or (1 - 2j)

_CORRECT_VALUE_PATTERNS = (
    (rf"(\ban? [a-z ]+ is missing){_CONFIGURATION}", r"\1"),
    (rf", expected {_VALUE}", ", which is not right"),
    (rf", and {_VALUE} is right", ", which is not right"),
)
"""Patterns of correct values in the reasons given by `qdot.grader.judging.formulas`, with their replacements."""

_NUMBER_PATTERNS = (
    (
        rf"(\b(?:not singular|the condition|angle is wrong|(?:correct except|right but) for rounding)){_CONFIGURATION}",
        r"\1",
    ),
    (rf" at {_NAMED_VALUE}(?:, {_NAMED_VALUE})*", ""),
    (rf": yours {_VALUE}, which is not right", ""),
    (rf"(\b(?:number \d+|entry \d+|your number)) is {_VALUE}, which is not right", r"\1 is not right"),
)
"""Patterns of the numbers of a counterexample, with their replacements."""

_DEPENDENT_PHRASE_PATTERNS = (
    (r"(?:^|; )your answer differs(?=$|\. )", ""),
    (r"\bthis configuration is not singular\b", "your answer includes a configuration that is not singular"),
    (r"\bthis configuration does not satisfy the condition\b", "your answer includes a wrong configuration"),
)
"""Patterns of phrases that make no sense without the withheld counterexample, with their replacements."""
_MISTAKE_NAME_PATTERNS = ((r" \(transposed\?\)|; is it transposed\?", ""),)
"""Patterns that name a mistake in the reason why an answer could not be parsed, with their replacements."""


NAME_AT_START = r"qdot\b|[A-Za-z]+[\d_.(]|\w+ (appears|has|can't|means|with)\b"
"""Beginnings of reasons that keep their small letter: qdot, and names in formulas or in the notebook."""


def capitalize(text: str) -> str:
    """Return a text that begins with a capital letter, unless its first word is a name such as `p1_jacobian`."""
    return text if re.match(NAME_AT_START, text) else text[:1].upper() + text[1:]


def shows_at_least(level: str, other_level: str) -> bool:
    """Return whether a level of feedback shows at least as much as another level."""
    return FEEDBACK_LEVELS.index(level) >= FEEDBACK_LEVELS.index(other_level)


def limit_feedback(part: PartResult, level: str) -> PartResult:
    """Return the result of a part without what a level of feedback withholds from students.

    >>> from qdot import Outcome
    >>> reason = "number 1 is 2, and 0.624 m/s is right"
    >>> part = PartResult(name="joint-rates", outcome=Outcome.WRONG, points=0.0, max_points=1.0, reason=reason)
    >>> limit_feedback(part, "counterexample").reason
    'number 1 is 2, which is not right'
    """
    if part.outcome not in WRONG_OR_PARTIAL or shows_at_least(level, "values"):
        return part
    reason, certificate = replace_patterns(part.reason, _CORRECT_VALUE_PATTERNS), part.certificate
    example = None if certificate is None else certificate.counterexample
    if certificate is not None and example is not None:
        hidden_fields: Any = {"missing" if isinstance(example, SetDifference) else "expected": None}
        certificate = replace(certificate, counterexample=replace(example, **hidden_fields))
    if shows_at_least(level, "counterexample"):
        return replace(part, reason=reason, certificate=certificate)
    reason = replace_patterns(remove_numbers(reason), _DEPENDENT_PHRASE_PATTERNS) or "your answer is wrong"
    certificate = None if certificate is None else replace(certificate, counterexample=None)
    if shows_at_least(level, "mistake"):
        return replace(part, reason=reason, certificate=certificate)
    reason = replace_patterns(reason, _MISTAKE_NAME_PATTERNS) if certificate is None else ""
    part_without_details = replace(part, mistake=None, advice=None, entries=None, follows=None)
    return replace(part_without_details, reason=reason, certificate=certificate)


def remove_numbers(reason: str) -> str:
    """Return a reason without the numbers of its counterexample, which a table shows.

    >>> remove_numbers("entry 1 differs at a1 = 2: yours 4, expected 2")
    'entry 1 differs'
    """
    return replace_patterns(replace_patterns(reason, _CORRECT_VALUE_PATTERNS), _NUMBER_PATTERNS)


def replace_patterns(reason: str, patterns: tuple[tuple[str, str], ...]) -> str:
    """Return a reason with all matches of the patterns replaced; `patterns` are pairs (pattern, replacement)."""
    for pattern, replacement in patterns:
        reason = re.sub(pattern, replacement, reason, flags=re.IGNORECASE)
    return reason
