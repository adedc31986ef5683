"""What an answer earns that is right in part: the rules, and what an assignment says of them (`credit`).

A rule is a function of what is right and what is wrong, never of the arm: equal mistakes earn equal shares. Whoever
marks (the grader, STACK's questions) finds out what is wrong, and takes the share from here. docs/partial-credit.md
tells the rules with examples.
"""

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from qdot.exercises.common.errors import QdotError

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

    @property
    def is_by_mistakes(self) -> bool:
        """Whether it counts that a single mistake gives all that is wrong, beside the places that are right."""
        return self.by not in ("entries", "columns", "whole")


OWN = Credit()
"""Each answer by the rule of its type."""


# --- the rules ---

AMISS = Fraction(1, 5)
"""What wrong signs cost, however many there are, a common factor that is wrong, and rounded values of joints."""
FORGOTTEN = Fraction(2, 3)
"""By what a condition multiplies the share if some of its configurations are forgotten."""
HALF = Fraction(1, 2)
"""What one known mistake leaves, and each wrong factor, forgotten condition and false condition."""
MOST_WRONG = 2
"""So many factors of a product may be wrong, lost or too many."""


def share_but_for_a_factor(is_sign_wrong: bool, is_factor_wrong: bool) -> Fraction:
    """Return the share of an answer that is right but for signs, or for a common factor, or for both.

    >>> share_but_for_a_factor(is_sign_wrong=True, is_factor_wrong=False)
    Fraction(4, 5)
    """
    return 1 - AMISS * (is_sign_wrong + is_factor_wrong)


def share_of_product(due: int, lost: int, too_many: int) -> Fraction:
    """Return the share of a product of `due` factors of which some are lost or too many; a wrong one is both.

    Each halves it. If more are wrong than right, those that are right may be there by chance.

    >>> share_of_product(2, lost=1, too_many=0), share_of_product(2, lost=1, too_many=1), share_of_product(4, 2, 0)
    (Fraction(1, 2), Fraction(1, 2), Fraction(1, 4))
    >>> share_of_product(2, lost=1, too_many=2)
    Fraction(0, 1)
    """
    wrong = max(lost, too_many)
    return HALF**wrong if wrong <= min(MOST_WRONG, due - lost) else Fraction(0)


def share_of_entries(right: Sequence[bool], zeros: Sequence[bool], blanks: Sequence[bool] | None = None) -> Fraction:
    """Return the share of a matrix or of numbers that are not all right.

    It is that of the right entries among those that are not zero in the solution, less the zeros that were answered
    with something else, and never more than all but one.

    >>> share_of_entries([True, False, True, True], zeros=[False, False, True, False])
    Fraction(2, 3)
    """
    counted = [same for same, zero in zip(right, zeros, strict=True) if not zero] or list(right)
    return max(Fraction(0), Fraction(min(sum(counted) - spoiled(right, zeros, blanks), len(counted) - 1), len(counted)))


def spoiled(right: Sequence[bool], zeros: Sequence[bool], blanks: Sequence[bool] | None = None) -> int:
    """Return how many zeros were answered with something else, where not all are zeros."""
    left = blanks or [False] * len(right)
    wrong = [zero and not same and not blank for same, zero, blank in zip(right, zeros, left, strict=True)]
    return 0 if all(zeros) else sum(wrong)


def share_of_columns(right: Sequence[bool]) -> Fraction:
    """Return the share of a matrix that is marked by columns, of which these, not of zeros alone, are right throughout.

    >>> share_of_columns([True, False, True])
    Fraction(2, 3)
    """
    return Fraction(min(sum(right), len(right) - 1), max(len(right), 1))


def share_of_set(found: Sequence[tuple[int, int]], unsound: int, *, is_rounded: bool = False) -> Fraction:
    """Return the share of a set that is not right: of each condition, how many configurations are `found`, of how many.

    `unsound` conditions are claimed and don't hold (`false_conditions`). If they are more than those of which something
    is found, they are guesses. Values that are right but for rounding are found; all of them together cost what wrong
    signs do.

    >>> share_of_set([(1, 2)], 0), share_of_set([(0, 2), (1, 1)], 0), share_of_set([(2, 2)], 1)
    (Fraction(2, 3), Fraction(1, 2), Fraction(1, 2))
    >>> share_of_set([(2, 2), (0, 1)], 1), share_of_set([(2, 2)], 2), share_of_set([(2, 2)], 0, is_rounded=True)
    (Fraction(1, 4), Fraction(0, 1), Fraction(4, 5))
    """
    conditions = sum(some > 0 for some, _ in found)
    if conditions == 0 or unsound > conditions:
        return Fraction(0)
    share = HALF**unsound * (1 - AMISS * is_rounded)
    for some, due in found:
        share *= 1 if some == due else FORGOTTEN if some else HALF
    return share if share < 1 else HALF  # something is claimed that holds nowhere


def false_conditions(false: Sequence[Hashable], true: Collection[Hashable]) -> int:
    """Return how many false conditions there are, of the joints of each `false` claim and of those that are `true`.

    All false values of a joint are one, unless true ones are claimed beside them: then each is one more guess.

    >>> false_conditions(["theta1", "theta1"], ["theta2"]), false_conditions(["theta2", "theta2"], ["theta2"])
    (1, 2)
    """
    return len({joints for joints in false if joints not in true}) + sum(joints in true for joints in false)


# --- what an assignment says ---


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
