"""How many students of a class have an answer in common with another, told from the certificates of their problems."""

from collections import Counter

from exercises.assignment import Assignment, Slot
from exercises.errors import QdotError
from exercises.release import certificate_path
from exercises.variation import STEPS, axes_of
from grader.certificates import read_certificate

MANY, SHARE = 3, 0.05
"""It is told where at least so many students, and more than this share of the class, have an answer in common."""


def shared_answers(assignment: Assignment) -> list[str]:
    """Return a line for each place of the assignment in which many students share an answer, and what would help.

    Two share an answer where a part's digest is the same: what is asked, what is given, and what is right.
    """
    parts: dict[str, list[dict[str, str]]] = {slot.name: [] for slot in assignment.slots}
    for student in assignment.roster:
        for name, digests in _digests(assignment, student.id).items():
            if name in parts:
                parts[name].append(digests)
    return [said for slot in assignment.slots if (said := _told(slot, parts[slot.name]))]


def _digests(assignment: Assignment, student: str) -> dict[str, dict[str, str]]:
    try:
        certificate = read_certificate(certificate_path(assignment, student), assignment.key, student)
    except QdotError:
        return {}  # `qdot verify` says what is wrong with it
    return {} if certificate is None else {name: record.parts for name, record in certificate.problems.items()}


def _told(slot: Slot, digests: list[dict[str, str]]) -> str:
    sharing: dict[int, list[str]] = {}
    for question in slot.questions:
        often = Counter(parts[question] for parts in digests if question in parts)
        students = sum(count for count in often.values() if count > 1)
        if students >= MANY and students > SHARE * len(digests):
            sharing.setdefault(students, []).append(question)
    if not sharing:
        return ""
    counts = "; ".join(f"{students} in {', '.join(names)}" for students, names in sorted(sharing.items(), reverse=True))
    where = f"{slot.name} ({slot.family.name}, variation {slot.variation})"
    return f"{where}: of {len(digests)} students, so many share an answer with another: {counts}{_remedy(slot)}"


def _remedy(slot: Slot) -> str:
    """Return the next step that varies more, or nothing where none does."""
    has, steps = set(slot.family.axes), list(STEPS)
    own = has & set(axes_of(slot.variation))
    further = [step for step in steps if own < has & set(STEPS[step])]
    return f'; arms vary more with variation = "{further[0]}"' if further else ""
