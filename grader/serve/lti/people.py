"""Find the role of a person in a course, and read the class list of the course (Names and Role Provisioning Services).

A role holds in one course only: an administrator of the platform, or a teacher elsewhere, is no teacher here.
"""

import base64
import datetime
import hashlib
import re
from collections.abc import Iterable, Mapping
from typing import Any

from django.db import transaction
from lti_tool.models import LtiUser

from qdot.exercises.common.errors import QdotError
from qdot.grader.serve.class_list import load_assignments
from qdot.grader.serve.lti.connection import Connections, read_pages
from qdot.grader.serve.models import Classroom, Person

_COURSE_ROLE = re.compile(r"(?:http://purl\.imsglobal\.org/vocab/lis/v2/membership(?:/(\w+))?#)?(\w+)")
"""Matches a role in the course. The groups are the main role, if the role is a sub-role, and the role's name."""
_STAFF_ROLES = {"Instructor", "Administrator", "TeachingAssistant"}
MEMBERS_SCOPE = "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly"
MEMBERS_TYPE = "application/vnd.ims.lti-nrps.v2.membershipcontainer+json"


def find_role(roles: Iterable[object]) -> Person.Role | None:
    """Return a person's role in the course; None for a person who is neither student nor staff, such as an observer.

    >>> find_role(["http://purl.imsglobal.org/vocab/lis/v2/membership/Instructor#TeachingAssistant"])
    Person.Role.STAFF
    >>> find_role(["http://purl.imsglobal.org/vocab/lis/v2/institution/person#Instructor", "Learner"])
    Person.Role.STUDENT
    """
    matches = [match for role in roles if isinstance(role, str) and (match := _COURSE_ROLE.fullmatch(role))]
    names = {match[1] or match[2] for match in matches}
    if names & _STAFF_ROLES:
        return Person.Role.STAFF
    return Person.Role.STUDENT if "Learner" in names else None


def save_person(classroom: Classroom, user: LtiUser, role: Person.Role, identifier: object) -> Person:
    """Save the person of the course whom the platform calls `user`, with the current role, and return the person.

    `identifier` is the person's number at the institution, if the platform knows it. By this number or by e-mail, a new
    student is matched to roster.csv, to get the same problems in a notebook and online. A change of role ends the
    person's other sessions.
    """
    with transaction.atomic():
        Classroom.objects.select_for_update().get(pk=classroom.pk)
        person = Person.objects.filter(classroom=classroom, lti_user=user).first()
        if person is None:
            person = Person(classroom=classroom, lti_user=user, role=role)
            person.student_id = _choose_student_id(person, user, {str(identifier or ""), user.email})
        elif person.role != role:
            person.session_version += 1
        person.role, person.is_active = role, True
        person.name = (user.name or f"{user.given_name} {user.family_name}".strip())[:500]
        person.email = user.email[:320]
        person.save()
    return person


def _choose_student_id(person: Person, user: LtiUser, identifiers: set[str]) -> str:
    """Return the identifier of the one student in roster.csv with one of `identifiers`, or else a new identifier."""
    names = {text.strip().casefold() for text in identifiers} - {""}
    roster = {student for assignment in load_assignments().values() for student in assignment.roster}
    matches = {student.id for student in roster if names & {student.id.casefold(), student.email.casefold()}}
    if person.role == Person.Role.STUDENT and len(matches) == 1:
        student_id = matches.pop()
        if not person.classroom.people.filter(student_id=student_id).exists():
            return student_id
    digest = hashlib.sha256(f"{user.registration.issuer}\n{user.sub}".encode()).digest()
    return "lti-" + base64.b32encode(digest).decode().lower()[:12]


def read_class_list(classroom: Classroom, connections: Connections, now: datetime.datetime) -> None:
    """Update the people of a course from the platform's list. People who have left become inactive.

    Raises QdotError, or an error of the library or the connection.
    """
    context = classroom.lti_context
    if context is None or not context.memberships_url:
        return
    platform = context.deployment.registration
    pages = read_pages(connections.open(platform, now), MEMBERS_SCOPE, context.memberships_url, MEMBERS_TYPE)
    members: list[Mapping[str, Any]] = [member for page in pages for member in page["members"]]
    if not members:
        raise QdotError("the platform's list of the class is empty")
    context.update_memberships([{"status": "Active", **member} for member in members])
    users = {user.sub: user for user in LtiUser.objects.filter(registration=platform)}
    present_user_ids = set()
    for member in members:
        role = find_role(member["roles"])
        if role is not None and member.get("status", "Active") == "Active":
            user = users[str(member["user_id"])]
            save_person(classroom, user, role, member.get("lis_person_sourcedid"))
            present_user_ids.add(user.pk)
    people = classroom.people.filter(lti_user__isnull=False, is_active=True)
    people.exclude(lti_user__in=present_user_ids).update(is_active=False)
