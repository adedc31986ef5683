"""Which of several notebooks of a student count: the last, or the best of a few that came at different times.

Fifty guesses in one folder are one attempt: what is received within a while replaces what came before.
"""

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from qdot.exercises.assignment.lateness import in_words, seconds_of
from qdot.exercises.common.errors import QdotError, unknown

MOST, APART = 5, 600
"""So many attempts count where nothing is said, each so many seconds after the one before at least."""
LIMIT = 'a limit, as in attempts = {best_of = 3, apart = "1 h"}'
RULE = f'it says which of several notebooks of a student counts: it is "last", "best", or {LIMIT}'
KEYS = {
    "best_of": "it is how many attempts count, a whole number from 1, as in best_of = 3",
    "apart": 'it is a time with its unit, as in apart = "1 h": what comes sooner replaces the attempt before it',
}


@dataclass(frozen=True)
class Several:
    """The last notebook counts, or the best of the first `best_of` attempts, each so many seconds apart."""

    best_of: int | None = None
    apart: int = APART

    def __str__(self) -> str:
        return "last" if self.best_of is None else "best"

    @property
    def rule(self) -> str:
        """What is told where not all that was handed in is an attempt that counts."""
        apart = f"of those handed in within {in_words(self.apart)} the last is taken, " if self.apart else ""
        return f"{apart}{self.best_of} attempt{'' if self.best_of == 1 else 's'} count at most"

    def counting(self, received: Sequence[datetime.datetime]) -> list[int]:
        """Return which of what was received at these moments counts; of the same moment, the first does.

        >>> at = [datetime.datetime(2027, 1, 15, 12, minute) for minute in (0, 5, 11, 30)]
        >>> Several(best_of=2).counting(at), Several(best_of=None).counting(at)
        ([1, 2], [3])
        """
        if self.best_of is None:
            return [max(range(len(received)), key=lambda i: received[i])]
        attempts: list[list[int]] = []
        for i in sorted(range(len(received)), key=lambda i: received[i]):
            since = (received[i] - received[attempts[-1][0]]).total_seconds() if attempts else 0.0
            if attempts and (since == 0 or since < self.apart):
                attempts[-1].append(i)
            else:
                attempts.append([i])
        return [max(same, key=lambda i: received[i]) for same in attempts[: self.best_of]]


LAST = Several()


def read_several(said: str | Mapping[str, Any]) -> Several:
    """Return the rule that assignment.toml states. Raises QdotError.

    >>> read_several("best"), read_several({"best_of": 3, "apart": "1 h"})
    (Several(best_of=5, apart=600), Several(best_of=3, apart=3600))
    """
    if isinstance(said, str):
        if said not in ("last", "best"):
            raise QdotError(RULE)
        return Several(MOST if said == "best" else None)
    wrong = next((name for name in said if name not in KEYS), None)
    if wrong is not None:
        raise unknown("key", wrong, tuple(KEYS))
    count = said.get("best_of", MOST)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise QdotError(f"best_of: {KEYS['best_of']}")
    return Several(count, seconds_of(said["apart"], f"apart: {KEYS['apart']}") if "apart" in said else APART)
