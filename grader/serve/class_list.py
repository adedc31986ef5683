"""The assignments of the service, and the students of a class as the roster of an assignment."""

from dataclasses import replace
from functools import cache
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.grader.serve.assignments import Assignments
from qdot.grader.serve.errors import NO_PAGE, Refused
from qdot.grader.serve.judge_process import ClassOfAssignment
from qdot.grader.serve.models import Classroom, Extension, Person
from qdot.grader.serve.settings import find_options


@cache
def _find_assignments() -> Assignments:
    return Assignments(find_options().folders)


def load_assignments() -> dict[str, Assignment]:
    """Map each key to its assignment, as the files in the folder describe it now."""
    return _find_assignments().load_all()


def describe_file_error(key: str) -> str:
    """Return a sentence about an error in an assignment's files; "" if there is none."""
    error = _find_assignments().errors.get(load_assignments()[key].folder, "")
    return error and f"{error}. The last version without this error is in use."


def count_file_changes() -> int:
    """Return how often the files of the assignments were read again because they had changed."""
    return _find_assignments().changes


def find_folder_class() -> Classroom:
    """Return the class of the rosters in the folders, whose students sign in by personal links."""
    return Classroom.objects.get_or_create(lti_context=None, defaults={"is_connected": True})[0]


def update_folder_class() -> Classroom:
    """Update the people of the folder's class from roster.csv; former students stay, but can't sign in."""
    classroom = find_folder_class()
    students = {student.id: student for assignment in load_assignments().values() for student in assignment.roster}
    people = {person.student_id: person for person in classroom.people.filter(role=Person.Role.STUDENT)}
    for identifier, student in students.items():
        fields: dict[str, Any] = {"name": student.name, "email": student.email, "is_active": True}
        person = people.get(identifier)
        if person is None:
            Person.objects.create(classroom=classroom, role=Person.Role.STUDENT, student_id=identifier, **fields)
        elif any(getattr(person, key) != value for key, value in fields.items()):
            Person.objects.filter(pk=person.pk).update(**fields)
    former_keys = [person.pk for name, person in people.items() if name not in students and person.is_active]
    Person.objects.filter(pk__in=former_keys).update(is_active=False)
    return classroom


def load_class_assignment(classroom: Classroom, key: str) -> Assignment:
    """Return an assignment with the students of a class as its roster, with their extensions. Raises Refused."""
    assignment = load_assignments().get(key)
    if assignment is None:
        raise Refused(404, NO_PAGE)
    extensions = Extension.objects.filter(person__classroom=classroom, assignment=key)
    due_dates = dict(extensions.values_list("person__student_id", "due"))
    if classroom.lti_context_id is None:
        students = assignment.roster
    else:
        people = classroom.people.filter(role=Person.Role.STUDENT, is_active=True).order_by("student_id")
        students = tuple(Student(person.student_id, person.name, person.email) for person in people)
    roster = (replace(student, due_date=due_dates.get(student.id, student.due_date)) for student in students)
    return replace(assignment, roster=tuple(roster))


def find_student(assignment: Assignment, person: Person) -> Student:
    """Return a person as a student of the assignment. Raises Refused if the person isn't one."""
    student = next((student for student in assignment.roster if student.id == person.student_id), None)
    if student is None:
        raise Refused(404, NO_PAGE)
    return student


def describe_class(assignment: Assignment) -> ClassOfAssignment:
    """Return what the judges need to know about an assignment whose roster is a class."""
    return ClassOfAssignment(assignment.key, tuple(student.id for student in assignment.roster))
