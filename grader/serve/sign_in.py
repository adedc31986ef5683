"""Sign people in: personal links, sessions and roles."""

import hashlib
from collections.abc import Callable
from functools import wraps

from django.http import HttpRequest, HttpResponse, HttpResponseRedirect
from django.middleware.csrf import rotate_token

from qdot.grader.serve.errors import NO_PAGE, Refused
from qdot.grader.serve.models import Person
from qdot.grader.serve.rates import check_rate

SIGN_IN_ADVICE = "You are not signed in. Open your personal link, or open the assignment on your learning platform."
STAFF_PREFIX = "staff:"
"""The beginning of the identifiers of staff who come by personal links. No student's identifier contains a colon."""

WRONG_LINKS_PER_MINUTE, SIGN_INS_PER_MINUTE = 60, 30
"""Maximum per minute: wrong links from one network address, which a class may share; and sign-ins of one person."""

View = Callable[..., HttpResponse]


def sign_in(request: HttpRequest, person: Person) -> None:
    """Sign a person in, in this browser."""
    request.session.flush()
    request.session["person"], request.session["version"] = person.pk, person.session_version
    rotate_token(request)


def find_person(request: HttpRequest) -> Person:
    """Return the person who uses this browser. Raises Refused.

    The header X-Person names the person for whom the page was loaded. It differs if somebody else has signed in since,
    for example in another tab.
    """
    people = Person.objects.select_related("classroom").filter(is_active=True, classroom__is_connected=True)
    person_id, version = request.session.get("person", 0), request.session.get("version", 0)
    person = people.filter(pk=person_id, session_version=version).first()
    if person is None:
        raise Refused(401, SIGN_IN_ADVICE)
    if request.headers.get("X-Person", str(person.pk)) != str(person.pk):
        raise Refused(401, "Someone else has signed in with this browser in the meantime. Load the page again.")
    return person


def allow_roles(*roles: str) -> Callable[[View], View]:
    """Return a decorator that calls a view, with the person as second argument, only for people with these roles.

    Other people get a 404.
    """

    def decorate(view: View) -> View:
        @wraps(view)
        def check_and_call(request: HttpRequest, *args: object, **kwargs: object) -> HttpResponse:
            person = find_person(request)
            if person.role not in roles:
                raise Refused(404, NO_PAGE)
            return view(request, person, *args, **kwargs)

        return check_and_call

    return decorate


for_staff = allow_roles(Person.Role.STAFF)
for_everybody = allow_roles(Person.Role.STAFF, Person.Role.STUDENT)


def sign_in_by_link(request: HttpRequest, token: str) -> HttpResponse:
    """Sign in the person with this personal link."""
    _refuse_if_embedded(request)
    person = Person.objects.filter(link_digest=compute_digest(token), is_active=True).first()
    if person is None:
        check_rate("wrong link", request.META.get("REMOTE_ADDR", ""), WRONG_LINKS_PER_MINUTE)
        raise Refused(404, "This link is not valid any more. Ask your instructor for a new one.")
    check_rate("sign in", person.pk, SIGN_INS_PER_MINUTE)
    sign_in(request, person)
    return HttpResponseRedirect("/")


def _refuse_if_embedded(request: HttpRequest) -> None:
    """Raise Refused if a page has embedded this address, for example as an image, to sign people in or out."""
    if request.headers.get("Sec-Fetch-Dest", "document") != "document":
        raise Refused(403, "Open this link in a tab of its own.")


def sign_out(request: HttpRequest) -> HttpResponse:
    """Sign the person out in this browser."""
    _refuse_if_embedded(request)
    request.session.flush()
    return HttpResponseRedirect("/")


def compute_digest(token: str) -> str:
    """Return the digest of a personal link's token, which is stored instead of the token."""
    return hashlib.sha256(token.encode()).hexdigest()
