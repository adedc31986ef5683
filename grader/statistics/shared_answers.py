"""Count the students whose problems have the same reference answer, from their certificates (files of digests)."""

from collections import Counter

from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.release import make_certificate_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.families.family import describe_variation
from qdot.grader.grading.certificates import read_certificate

MIN_SHARING_STUDENTS, MIN_SHARING_FRACTION = 3, 0.05
"""Shared answers are reported for at least this many students who are more than this fraction of the class."""

MOST_VARIATION = "full"
"""The step of variation with which the arms of a family differ most; an instructor's own arm has no such step,
so there is no advice."""
ADVICE = 'for fewer shared answers, set more variation in assignment.toml, such as variation = "full"'


def describe_shared_answers(assignment: Assignment) -> list[str]:
    """Return a line for each slot of the assignment in which many students share a correct answer, and then advice.

    Two students share an answer if their parts have the same digest, which covers the question, the data and the
    correct answer.
    """
    digests_by_slot: dict[str, list[dict[str, str]]] = {slot.name: [] for slot in assignment.slots}
    for student in assignment.roster:
        for name, digests in _read_digests(assignment, student.id).items():
            if name in digests_by_slot:
                digests_by_slot[name].append(digests)
    slot_lines = {slot: line for slot in assignment.slots if (line := _describe_slot(slot, digests_by_slot[slot.name]))}
    has_remedy = any(not slot.robot_digest and slot.variation != MOST_VARIATION for slot in slot_lines)
    return [*slot_lines.values(), *([ADVICE] if has_remedy else [])]


def _read_digests(assignment: Assignment, student: str) -> dict[str, dict[str, str]]:
    """Map each slot to the digests of a student's parts there; {} if the certificate is damaged or out of date."""
    try:
        certificate = read_certificate(make_certificate_path(assignment, student), assignment.key, student)
    except QdotError:
        return {}  # `qdot verify` reports the error
    if certificate is None or certificate.notebook_digest != assignment.notebook_digest_of(student):
        return {}  # the certificate of a notebook that has been replaced
    return {name: record.parts for name, record in certificate.problems.items()}


def _describe_slot(slot: Slot, student_digests: list[dict[str, str]]) -> str:
    """Return the line on a slot, given each student's digests by part; "" if few students share an answer."""
    # The keys are the number of students who share an answer, and whether all of them share the same one.
    questions_by_sharing: dict[tuple[int, bool], list[str]] = {}
    for question in slot.questions:
        if question in slot.text_questions:  # there is no reference answer to share
            continue
        digest_counts = Counter(digests[question] for digests in student_digests if question in digests)
        sharing_count = sum(count for count in digest_counts.values() if count > 1)
        if sharing_count >= MIN_SHARING_STUDENTS and sharing_count > MIN_SHARING_FRACTION * len(student_digests):
            is_one_answer = max(digest_counts.values()) == sharing_count
            questions_by_sharing.setdefault((sharing_count, is_one_answer), []).append(question)
    if not questions_by_sharing:
        return ""
    class_size, clauses = len(student_digests), list[str]()
    for (sharing_count, is_one_answer), names in sorted(questions_by_sharing.items(), reverse=True):
        students_text = f"all {class_size}" if sharing_count == class_size else f"{sharing_count} of {class_size}"
        answer = "the same answer" if is_one_answer else "the same answer as another student"
        clauses.append(f"{', '.join(names)}: {students_text} students have {answer}")
    slot_text = f"{slot.name} ({slot.family.name}, {describe_variation(slot.family, slot.variation)})"
    return f"{slot_text}, {'; '.join(clauses)}"
