"""Compute the penalty for late work as a share of the earned points, by the rule `late` in assignment.toml.

`grader.grading.final_result` deducts the penalty.
"""

import datetime
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from qdot.exercises.assignment.expected_forms import EXPECTED_FORMS, LATE_FORMS, check_keys
from qdot.exercises.common.errors import ErrorList, QdotError, count_noun

SECONDS_PER_DAY = 86400
UNITS = {"s": 1, "min": 60, "h": 3600, "day": SECONDS_PER_DAY, "days": SECONDS_PER_DAY}
"""Maps each unit of durations to its length in seconds."""


@dataclass(frozen=True)
class LateRule:
    """The rule for late work: no penalty within `grace` seconds, then a share `per_day` for each started day.

    The penalty is at most the share `at_most`. After the time `until`, all points are deducted.
    """

    grace: int = 0
    per_day: Fraction = Fraction(0)
    at_most: Fraction = Fraction(1)
    until: datetime.datetime | None = None

    def compute_penalty(
        self, due_date: datetime.datetime, received: datetime.datetime, extension: datetime.timedelta
    ) -> Fraction:
        """Return the share of the earned points that is deducted; `extension` is the length of the student's extension.

        >>> due = datetime.datetime(2027, 1, 15, 12, tzinfo=datetime.UTC)
        >>> rule = LateRule(grace=900, per_day=Fraction(1, 10), at_most=Fraction(1, 2))
        >>> times = [due + datetime.timedelta(minutes=minutes) for minutes in (15, 16, 1441)]
        >>> [str(rule.compute_penalty(due, received, datetime.timedelta(0))) for received in times]
        ['0', '1/10', '1/5']
        """
        seconds_late = (received - due_date).total_seconds()
        if seconds_late <= self.grace:
            return Fraction(0)
        if self.until is not None and received > self.until + extension:
            return Fraction(1)
        return min(self.at_most, self.per_day * math.ceil(seconds_late / SECONDS_PER_DAY))


def add_time_zone(moment: datetime.datetime, zone: datetime.tzinfo | None = None) -> datetime.datetime:
    """Return a time in `zone`, or in the machine's zone if that is None; a time with a time zone stays unchanged."""
    if moment.tzinfo is not None:
        return moment
    return moment.replace(tzinfo=zone) if zone is not None else moment.astimezone()


def describe_duration(seconds: int) -> str:
    """Return a duration in words.

    >>> describe_duration(40), describe_duration(800), describe_duration(90000), describe_duration(2 * SECONDS_PER_DAY)
    ('40 s', '13 min', '1 day 1 h', '2 days')
    """
    days, remaining_seconds = divmod(seconds, SECONDS_PER_DAY)
    hours, minutes = divmod(remaining_seconds // 60, 60)
    words = [count_noun(days, "day") if days else "", f"{hours} h" if hours else ""]
    words.append(f"{minutes} min" if minutes and not days else "")
    return " ".join(filter(None, words)) or f"{seconds} s"


def read_late_rule(table: Mapping[str, Any] | None, due_date: datetime.datetime | None) -> LateRule | None:
    """Return the rule in the table `late` of assignment.toml. Raises QdotError.

    >>> read_late_rule({"per_day": 0.1}, datetime.datetime(2027, 1, 15))
    LateRule(grace=0, per_day=Fraction(1, 10), at_most=Fraction(1, 1), until=None)
    """
    if table is None:
        return None
    if due_date is None:
        raise QdotError("`late` needs a due date; add due = 2027-01-15T23:59:00+01:00")
    errors, shares, until = ErrorList(), dict[str, Fraction](), table.get("until")
    with errors.collect():
        check_keys(table, LATE_FORMS)
        if not {"per_day", "until"} & set(table):
            raise QdotError(f"this deducts nothing; add per_day, until or both; {EXPECTED_FORMS['late']}")
        if "at_most" in table and "per_day" not in table:
            reason = "at_most limits the deduction of per_day, but per_day is missing"
            raise QdotError(f"{reason}; {EXPECTED_FORMS['late']}")
    for name in ("per_day", "at_most"):
        with errors.collect():
            if name in table:
                shares[name] = _parse_share(name, table[name])
    with errors.collect():
        if until is not None:
            is_time = isinstance(until, datetime.datetime)
            if not is_time or add_time_zone(until, due_date.tzinfo) < add_time_zone(due_date):
                raise QdotError(f"until: {LATE_FORMS['until']}")
            until = add_time_zone(until, due_date.tzinfo)
    with errors.collect():
        grace = parse_duration(table["grace"], f"grace: {LATE_FORMS['grace']}") if "grace" in table else 0
    errors.raise_all()
    return LateRule(grace, until=until, **shares)


def _parse_share(name: str, value: object) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= 1:
        raise QdotError(f"{name}: {LATE_FORMS[name]}")
    return Fraction(str(value))


def parse_duration(text: object, expected_form: str) -> int:
    """Return a duration such as "15 min" in seconds. Raises QdotError with `expected_form`."""
    match = re.fullmatch(r"\s*(\d{1,6})\s*([a-z]+)\s*", text) if isinstance(text, str) else None
    if match is None or match.group(2) not in UNITS:
        raise QdotError(f"{expected_form}; units: {', '.join(UNITS)}")
    return int(match.group(1)) * UNITS[match.group(2)]
