"""Decide which of a student's notebooks count: the last one, or the best of a few submitted at different times.

A notebook replaces another one that was received shortly before, so several guesses in quick succession are one
attempt.
"""

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from qdot.exercises.assignment.expected_forms import ATTEMPT_FORMS, EXPECTED_FORMS, check_keys
from qdot.exercises.assignment.late_rule import describe_duration, parse_duration
from qdot.exercises.common.errors import ErrorList, QdotError, count_noun

DEFAULT_BEST_OF, DEFAULT_MIN_INTERVAL = 5, 600
"""Default number of attempts that count, and default minimum number of seconds between two attempts."""


@dataclass(frozen=True)
class AttemptPolicy:
    """The last notebook counts if `best_of` is None; otherwise the best of the first `best_of` attempts.

    A notebook received less than `min_interval` seconds after the first one of an attempt belongs to the same attempt.
    `tries` is how often a student may answer each question online; None means any number of times.
    """

    best_of: int | None = None
    min_interval: int = DEFAULT_MIN_INTERVAL
    tries: int | None = None

    def __str__(self) -> str:
        return "last" if self.best_of is None else "best"

    @property
    def rule(self) -> str:
        """An explanation for students why only some of their notebooks count as attempts."""
        limit = f"at most {count_noun(self.best_of or 1, 'attempt')} {'counts' if self.best_of == 1 else 'count'}"
        if not self.min_interval:
            return limit
        return f"if several come within {describe_duration(self.min_interval)}, only the last counts; {limit}"

    def select_counting_indices(self, received: Sequence[datetime.datetime]) -> list[int]:
        """Return the indices of the notebooks that count, given the times at which all notebooks were received.

        Of several notebooks received at the same time, the first one in the sequence counts.

        >>> times = [datetime.datetime(2027, 1, 15, 12, minute) for minute in (0, 5, 11, 30)]
        >>> [AttemptPolicy(best_of=best_of).select_counting_indices(times) for best_of in (2, None)]
        [[1, 2], [3]]
        """
        return [max(attempt, key=lambda i: received[i]) for attempt in self.group_attempts(received)]

    def group_attempts(self, received: Sequence[datetime.datetime]) -> list[list[int]]:
        """Return the indices of the notebooks of each attempt that counts, from the first received to the last."""
        order = sorted(range(len(received)), key=lambda i: received[i])
        if self.best_of is None:
            return [order]
        attempts: list[list[int]] = []
        for i in order:
            elapsed = (received[i] - received[attempts[-1][0]]).total_seconds() if attempts else 0.0
            if attempts and (elapsed == 0 or elapsed < self.min_interval):
                attempts[-1].append(i)
            else:
                attempts.append([i])
        return attempts[: self.best_of]


def read_attempt_policy(setting: str | Mapping[str, Any]) -> AttemptPolicy:
    """Return the policy that assignment.toml sets. Raises QdotError.

    >>> read_attempt_policy("best"), read_attempt_policy({"best_of": 3, "apart": "1 h"})
    (AttemptPolicy(best_of=5, min_interval=600, tries=None), AttemptPolicy(best_of=3, min_interval=3600, tries=None))
    >>> read_attempt_policy({"tries": 3})
    AttemptPolicy(best_of=None, min_interval=600, tries=3)
    """
    if isinstance(setting, str):
        if setting not in ("last", "best"):
            raise QdotError(EXPECTED_FORMS["attempts"])
        return AttemptPolicy(DEFAULT_BEST_OF if setting == "best" else None)
    errors, limits = ErrorList(), dict[str, int]()
    with errors.collect():
        check_keys(setting, ATTEMPT_FORMS)
    for name in ("best_of", "tries"):
        with errors.collect():
            count = setting.get(name, 1)
            if isinstance(count, bool) or not isinstance(count, int) or count < 1:
                raise QdotError(f"{name}: {ATTEMPT_FORMS[name]}")
            if name in setting:
                limits[name] = count
    # If only `tries` is set, the last attempt counts.
    default_best_of = None if setting.keys() == {"tries"} else DEFAULT_BEST_OF
    policy = AttemptPolicy(limits.get("best_of", default_best_of), tries=limits.get("tries"))
    with errors.collect():
        if "apart" in setting:
            interval = parse_duration(setting["apart"], f"apart: {ATTEMPT_FORMS['apart']}")
            policy = replace(policy, min_interval=interval)
    errors.raise_all()
    return policy
