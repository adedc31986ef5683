"""Limit how often a person may do something, so that one person can't block the service for others."""

import threading
import time
from collections import defaultdict, deque

from qdot.grader.serve.errors import Refused

SECONDS = 60.0
"""The length of the period in which requests are counted."""

_lock = threading.Lock()
_times: dict[tuple[str, str], deque[float]] = defaultdict(deque)
"""Maps each pair (action, actor) to the times of the actor's latest requests."""


def check_rate(action: str, actor: object, limit: int) -> None:
    """Count an action of a person or address. Raises Refused after more than `limit` such actions within a minute."""
    now = time.monotonic()
    with _lock:
        times = _times[action, str(actor)]
        while times and times[0] < now - SECONDS:
            times.popleft()
        if len(times) >= limit:
            raise Refused(429, "This is more often than qdot accepts. Wait a minute, and try again.")
        times.append(now)
        if len(_times) > 10_000:  # forget those who have done nothing for a minute
            for key in [key for key, moments in _times.items() if moments[-1] < now - SECONDS]:
                del _times[key]
