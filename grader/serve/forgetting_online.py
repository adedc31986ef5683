"""Remove a student from the database of the service (`qdot forget`)."""

from collections.abc import Iterator

from django.contrib.sessions.models import Session
from django.core.cache import caches
from django.db import connection, transaction
from django.db.models import Q

from qdot.exercises.common.errors import QdotError, count_noun
from qdot.grader.serve.models import Person, StaffAction


def find_people(name: str) -> list[Person]:
    """Return the rows of a student in all classes; `name` is the student's identifier, name or e-mail address.

    Raises QdotError if several students have this name or address.
    """
    people = Person.objects.filter(role=Person.Role.STUDENT)
    has_name = Q(name__iexact=name) | Q(email__iexact=name)
    matching_people = list(people.filter(student_id=name)) or list(people.filter(has_name))
    identifiers = sorted({person.student_id for person in matching_people})
    if len(identifiers) > 1:
        raise QdotError(f"{name!r} fits {' and '.join(identifiers)} in the database; enter the identifier")
    return matching_people


def describe_people(people: list[Person]) -> Iterator[str]:
    """Yield a line for each class, which says what the database stores about a student."""
    for person in people:
        contents = (
            count_noun(person.submissions.count(), "submission"), count_noun(person.drafts.count(), "draft"),
            count_noun(person.overrides.count(), "override"),
        )  # fmt: skip
        yield f"  remove   {person.student_id} ({person.name}) in {person.classroom}: {', '.join(contents)}"


def forget_people(people: list[Person]) -> None:
    """Remove everything about a student from the database; for SQLite, also from the free space of its file."""
    person_ids = {person.pk for person in people}
    with transaction.atomic():
        for person in people:
            names = [name for name in (person.name, person.student_id) if name]
            for name in names:
                StaffAction.objects.filter(classroom=person.classroom, summary__contains=name).delete()
            user = person.lti_user
            person.delete()
            if user is not None and not Person.objects.filter(lti_user=user).exists():
                user.delete()
        for session in Session.objects.all():
            if session.get_decoded().get("person") in person_ids:
                session.delete()
    caches["pages"].clear()
    if connection.vendor == "sqlite":
        with connection.cursor() as cursor:
            cursor.execute("VACUUM")
            cursor.execute("PRAGMA wal_checkpoint(TRUNCATE)")
