"""Count the students of a class whose correct answer is the same as another student's, from their certificates."""

from collections import Counter

from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.release import make_certificate_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.families.family import describe_variation
from qdot.grader.grading.certificates import read_certificate

MIN_SHARING_STUDENTS, MIN_SHARING_FRACTION = 3, 0.05
"""Minimum number of students, and fraction of the class that must be exceeded, for shared answers to be reported."""

MOST_VARIATION = "full"
"""The step of variation with which the arms of a family differ most; arms of an instructor have fewer steps."""
ADVICE = 'for fewer shared answers, set a later step of variation in assignment.toml, such as variation = "full"'


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
    lines = {slot: line for slot in assignment.slots if (line := _describe_sharing(slot, digests_by_slot[slot.name]))}
    has_remedy = any(not slot.robot_digest and slot.variation != MOST_VARIATION for slot in lines)
    return [*lines.values(), *([ADVICE] if has_remedy else [])]


def _read_digests(assignment: Assignment, student: str) -> dict[str, dict[str, str]]:
    """Map each slot to the digests of a student's parts there; {} if the certificate is damaged or out of date."""
    try:
        certificate = read_certificate(make_certificate_path(assignment, student), assignment.key, student)
    except QdotError:
        return {}  # `qdot verify` reports the error
    if certificate is None or certificate.notebook_digest != assignment.notebook_digest_of(student):
        return {}  # the certificate of a notebook that has been replaced
    return {name: record.parts for name, record in certificate.problems.items()}


def _describe_sharing(slot: Slot, digests: list[dict[str, str]]) -> str:
    """Return the line on a slot, given the digests of each student by part; "" if few students share an answer."""
    # The keys are the number of students who share an answer, and whether all of them share the same one.
    questions_by_sharing: dict[tuple[int, bool], list[str]] = {}
    for question in slot.questions:
        if question in slot.text_questions:  # there is no reference answer to share
            continue
        digest_counts = Counter(parts[question] for parts in digests if question in parts)
        students = sum(count for count in digest_counts.values() if count > 1)
        if students >= MIN_SHARING_STUDENTS and students > MIN_SHARING_FRACTION * len(digests):
            is_one_answer = max(digest_counts.values()) == students
            questions_by_sharing.setdefault((students, is_one_answer), []).append(question)
    if not questions_by_sharing:
        return ""
    student_count, clauses = len(digests), list[str]()
    for (students, is_one_answer), names in sorted(questions_by_sharing.items(), reverse=True):
        students_text = f"all {student_count}" if students == student_count else f"{students} of {student_count}"
        answer = "the same answer" if is_one_answer else "the same answer as another student"
        clauses.append(f"{', '.join(names)}: {students_text} students have {answer}")
    slot_text = f"{slot.name} ({slot.family.name}, {describe_variation(slot.family, slot.variation)})"
    return f"{slot_text}, {'; '.join(clauses)}"
