"""How many students of a class have an answer in common with another, told from the certificates of their problems."""

from collections import Counter
from collections.abc import Mapping

from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.release import certificate_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import STEPS, axes_of
from qdot.exercises.docs.sharing import known_share
from qdot.exercises.families.base import describe_variation
from qdot.grader.grading.certificates import read_certificate

FEW = 0.1
"""A step of variation is a remedy where fewer than this share of a class were found to have an answer in common."""

MANY, SHARE = 3, 0.05
"""It is told where at least so many students, and more than this share of the class, have an answer in common."""


def describe_shared_answers(assignment: Assignment) -> list[str]:
    """Return a line for each place of the assignment in which many students share an answer, and what would help.

    Two share an answer where a part's digest is the same: what is asked, what is given, and what is right.
    """
    parts: dict[str, list[dict[str, str]]] = {slot.name: [] for slot in assignment.slots}
    for student in assignment.roster:
        for name, digests in _answer_digests(assignment, student.id).items():
            if name in parts:
                parts[name].append(digests)
    return [line for slot in assignment.slots if (line := _describe_sharing(slot, parts[slot.name]))]


def _answer_digests(assignment: Assignment, student: str) -> dict[str, dict[str, str]]:
    try:
        certificate = read_certificate(certificate_path(assignment, student), assignment.key, student)
    except QdotError:
        return {}  # `qdot verify` says what is wrong with it
    if certificate is None or certificate.edition != assignment.edition_of(student):
        return {}  # of a notebook that is no longer handed out
    return {name: record.parts for name, record in certificate.problems.items()}


def _describe_sharing(slot: Slot, digests: list[dict[str, str]]) -> str:
    sharing: dict[int, list[str]] = {}
    for question in slot.questions:
        often = Counter(parts[question] for parts in digests if question in parts)
        students = sum(count for count in often.values() if count > 1)
        if students >= MANY and students > SHARE * len(digests):
            sharing.setdefault(students, []).append(question)
    if not sharing:
        return ""
    counts = "; ".join(f"{students} in {', '.join(names)}" for students, names in sorted(sharing.items(), reverse=True))
    where = f"{slot.name} ({slot.family.name}, {describe_variation(slot.family, slot.variation)})"
    remedy = _suggest_variation(slot, sharing)
    return f"{where}: of {len(digests)} students, so many share an answer with another: {counts}{remedy}"


def _suggest_variation(slot: Slot, sharing: Mapping[int, list[str]]) -> str:
    """Return the step that varies more and at which few were found to share most of these answers, or nothing."""
    if slot.family.robot:  # the measured shares are those of registered families
        return ""
    has = set(slot.family.axes)
    varied = has & set(axes_of(slot.variation))
    asked = [name for names in sharing.values() for name in names]
    further = [step for step, axes in STEPS.items() if varied < has & set(axes)]
    helped = {step: [name for name in asked if _is_shared_by_few(slot.family.name, step, name)] for step in further}
    best = max(further, key=lambda step: len(helped[step]), default="")
    return f'; with variation = "{best}" few share {", ".join(helped[best])}' if best and helped[best] else ""


def _is_shared_by_few(family: str, step: str, question: str) -> bool:
    share = known_share(family, step, question)
    return share is not None and share[0] < FEW * share[1]
