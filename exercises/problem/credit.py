"""Compute the share of the points that a partly correct answer earns, and parse the setting `credit` of an assignment.

The share depends on what is correct and what is wrong, never on the arm: equal mistakes earn equal shares. The grader
and the STACK export compare the answers, and then compute the share with these functions. See docs/partial-credit.md
for the rules with examples.
"""

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from qdot.exercises.common.errors import QdotError

Setting = TypeVar("Setting", bound=str | float)
CREDIT_RULES = ("entries", "columns", "factors", "pieces", "whole")
"""Partial credit by entries, columns, factors of a product or pieces of a set; "whole" means no partial credit.

A piece is a value of a joint, or conditions that hold simultaneously.
"""

CREDIT_ERROR = (
    'expected a rule for partly correct answers: "columns" or "entries" of a matrix, "whole" for no partial '
    "credit, a factor from 0 to 1 that multiplies the usual partial credit, or a table of these by question, as in "
    'credit = {jacobian = "columns", determinant = 0.5}'
)
"""The message for a wrong value of `credit`."""


@dataclass(frozen=True)
class Credit:
    """How partly correct answers earn points: the share by `rule`, multiplied by `factor`.

    The rule is one of CREDIT_RULES, or "" for the usual rule of the question.
    """

    rule: str = ""
    factor: Fraction = Fraction(1)

    @property
    def covers_known_mistakes(self) -> bool:
        """Whether an answer also earns a share if a single known mistake explains it."""
        return self.rule not in ("entries", "columns", "whole")


# --- the rules ---

SIGN_OR_FACTOR_COST = Fraction(1, 5)
"""The share that is lost for all wrong signs together, for a wrong common factor, or for rounded joint values."""
INCOMPLETE_CONDITION_FACTOR = Fraction(2, 3)
"""Factor of the share for each condition of which only some joint values were found."""
MISTAKE_FACTOR = Fraction(1, 2)
"""Factor of the share for one known mistake, and for each wrong factor, forgotten condition and false condition."""
MAX_WRONG_FACTORS = 2
"""Maximum number of wrong, missing or extra factors for which a product still earns a share."""


def compute_share_up_to_sign_and_factor(is_sign_wrong: bool, is_factor_wrong: bool) -> Fraction:
    """Return the share for an answer that is correct except for signs, a common factor, or both.

    >>> compute_share_up_to_sign_and_factor(is_sign_wrong=True, is_factor_wrong=False)
    Fraction(4, 5)
    """
    return 1 - SIGN_OR_FACTOR_COST * (is_sign_wrong + is_factor_wrong)


def compute_share_of_product(expected_count: int, missing_count: int, extra_count: int) -> Fraction:
    """Return the share for a product of `expected_count` factors if factors are missing or extra.

    A wrong factor counts as one missing and one extra factor. Each mistake halves the share. If more factors are wrong
    than correct, the share is 0, because factors may be correct by chance.

    >>> [str(compute_share_of_product(2, missing_count=1, extra_count=extra_count)) for extra_count in (0, 1, 2)]
    ['1/2', '1/2', '0']
    >>> compute_share_of_product(4, missing_count=2, extra_count=0)
    Fraction(1, 4)
    """
    wrong_count = max(missing_count, extra_count)
    earns_share = wrong_count <= min(MAX_WRONG_FACTORS, expected_count - missing_count)
    return MISTAKE_FACTOR**wrong_count if earns_share else Fraction(0)


def compute_share_of_entries(
    is_correct: Sequence[bool], is_zero: Sequence[bool], is_blank: Sequence[bool] | None = None
) -> Fraction:
    """Return the share for a matrix, or for several numbers, if at least one entry is wrong.

    The share is a fraction of the nonzero entries: the number of those that are correct, minus the number of zeros that
    were answered with something else. `is_zero` says which entries of the reference are zero, and `is_blank` which
    entries the student left blank.

    >>> compute_share_of_entries([True, False, True, True], is_zero=[False, False, True, False])
    Fraction(2, 3)
    """
    entries = zip(is_correct, is_zero, strict=True)
    nonzero_results = [is_right for is_right, should_be_zero in entries if not should_be_zero]
    results = nonzero_results or list(is_correct)
    earned_count = min(sum(results) - count_spoiled_zeros(is_correct, is_zero, is_blank), len(results) - 1)
    return max(Fraction(0), Fraction(earned_count, len(results)))


def count_spoiled_zeros(
    is_correct: Sequence[bool], is_zero: Sequence[bool], is_blank: Sequence[bool] | None = None
) -> int:
    """Return how many entries that should be zero have another answer; blanks do not count.

    Return 0 if the reference has only zeros.
    """
    if all(is_zero):
        return 0
    entries = zip(is_correct, is_zero, is_blank or [False] * len(is_correct), strict=True)
    return sum(should_be_zero and not (is_right or has_blank) for is_right, should_be_zero, has_blank in entries)


def compute_share_of_columns(is_correct: Sequence[bool]) -> Fraction:
    """Return the share for a matrix that is graded by columns, if at least one column is wrong.

    `is_correct` says for each nonzero column whether the column is correct.

    >>> compute_share_of_columns([True, False, True])
    Fraction(2, 3)
    """
    return Fraction(min(sum(is_correct), len(is_correct) - 1), max(len(is_correct), 1))


def compute_share_of_set(
    found_and_expected: Sequence[tuple[int, int]], false_conditions: int, *, is_rounded: bool = False
) -> Fraction:
    """Return the share for a set of singular configurations that is not entirely correct.

    `found_and_expected` has, for each condition, the number of joint values that the student found and the number of
    all its joint values. `false_conditions` is the number of the student's conditions that are false
    (`count_false_conditions`). If it exceeds the number of conditions that were found at least in part, the answer
    counts as guessed and earns nothing. Rounded values count as found; together they cost as much as wrong signs.

    >>> compute_share_of_set([(1, 2)], 0), compute_share_of_set([(0, 2), (1, 1)], 0)
    (Fraction(2, 3), Fraction(1, 2))
    >>> compute_share_of_set([(2, 2)], 1), compute_share_of_set([(2, 2), (0, 1)], 1), compute_share_of_set([(2, 2)], 2)
    (Fraction(1, 2), Fraction(1, 4), Fraction(0, 1))
    >>> compute_share_of_set([(2, 2)], 0, is_rounded=True)
    Fraction(4, 5)
    """
    found_conditions = sum(found_count > 0 for found_count, _ in found_and_expected)
    if found_conditions == 0 or false_conditions > found_conditions:
        return Fraction(0)
    share = MISTAKE_FACTOR**false_conditions * (1 - SIGN_OR_FACTOR_COST * is_rounded)
    for found_count, expected_count in found_and_expected:
        if found_count != expected_count:
            share *= INCOMPLETE_CONDITION_FACTOR if found_count else MISTAKE_FACTOR
    return share if share < 1 else MISTAKE_FACTOR  # the only error is an additional condition without a solution


def count_false_conditions(false_claims: Sequence[Hashable], true_claims: Collection[Hashable]) -> int:
    """Return how many of a student's conditions count as false.

    `false_claims` has the joint (or joints) of each false condition, and `true_claims` those of the true conditions.
    All false values of a joint together count as one condition. But if the student also found a true value of the
    joint, each false value counts.

    >>> (count_false_conditions(["theta1", "theta1"], ["theta2"]),
    ... count_false_conditions(["theta2", "theta2"], ["theta2"]))
    (1, 2)
    """
    return len(set(false_claims) - set(true_claims)) + sum(joints in true_claims for joints in false_claims)


# --- the setting `credit` of an assignment ---


def parse_credit_policy(
    policy: str | float | Mapping[str, str | float] | None, questions: Sequence[str]
) -> tuple[tuple[str, Credit], ...]:
    """Return (question, rule) for each question to which the setting applies. Raises QdotError for a wrong value.

    >>> parse_credit_policy({"jacobian": "columns"}, ["position", "jacobian"])
    (('jacobian', Credit(rule='columns', factor=Fraction(1, 1))),)
    """

    def parse_setting(setting: str | float) -> Credit:
        if isinstance(setting, str) and setting in CREDIT_RULES:
            return Credit(setting)
        if isinstance(setting, (str, bool)) or not 0 <= setting <= 1:
            raise QdotError(CREDIT_ERROR)
        return Credit("", Fraction(str(setting)))

    return tuple((name, parse_setting(setting)) for name, setting in list_settings_by_question(policy, questions))


def list_settings_by_question(
    policy: Setting | Mapping[str, Setting] | None, questions: Sequence[str]
) -> list[tuple[str, Setting]]:
    """Return (question, setting) for the questions that have a setting.

    `policy` is one setting for all questions, a table of settings by question, or None. Raises QdotError if the table
    has an unknown question.
    """
    if policy is None:
        return []
    if not isinstance(policy, Mapping):
        return [(name, policy) for name in questions]
    unknown_name = next((name for name in policy if name not in questions), None)
    if unknown_name is not None:
        raise QdotError(f"{unknown_name!r} is not a question of this problem; its questions: {', '.join(questions)}")
    return [(name, policy[name]) for name in questions if name in policy]
