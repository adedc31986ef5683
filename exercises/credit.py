"""What an assignment gives for an answer that is right in part: `credit` of a [[problem]], for all or by question."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from exercises.errors import QdotError

WAYS = ("entries", "columns", "factors", "pieces", "whole")

CREDIT = (
    'it is how an answer that is right in part is marked: "columns" or "entries" of a matrix, "whole" for none, a '
    "number from 0 to 1 by which it is multiplied, or a table of these by question, as in "
    'credit = {jacobian = "columns", determinant = 0.5}'
)


@dataclass(frozen=True)
class Credit:
    """By what an answer that is right in part is marked (one of WAYS, "" for the question's own), and times what."""

    by: str = ""
    worth: Fraction = Fraction(1)


OWN = Credit()
"""Matrices by entries, determinants by factors, singular sets by pieces."""


def read_credit(
    policy: str | float | Mapping[str, str | float] | None, questions: Sequence[str]
) -> tuple[tuple[str, Credit], ...]:
    """Return how partly right answers are marked, for the questions for which that is said. Raises QdotError.

    >>> read_credit({"jacobian": "columns"}, ["position", "jacobian"])
    (('jacobian', Credit(by='columns', worth=Fraction(1, 1))),)
    """
    if isinstance(policy, Mapping):
        unknown = next((name for name in policy if name not in questions), None)
        if unknown is not None:
            raise QdotError(f"{unknown!r} is none of the questions of this problem, {', '.join(questions)}")
        return tuple((name, _credit(policy[name])) for name in questions if name in policy)
    return () if policy is None else tuple((name, _credit(policy)) for name in questions)


def _credit(said: str | float) -> Credit:
    if isinstance(said, bool) or (isinstance(said, str) and said not in WAYS):
        raise QdotError(CREDIT)
    if isinstance(said, str):
        return Credit(said)
    if not 0 <= said <= 1:
        raise QdotError(CREDIT)
    return Credit("", Fraction(str(said)))
