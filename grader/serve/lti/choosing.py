"""Deep linking: a teacher adds an assignment or a question to a course in the platform's own editor."""

from collections.abc import Iterator
from typing import Any

from django.http import HttpRequest, HttpResponse, HttpResponseRedirect
from django.utils import timezone
from django.views.decorators.http import require_http_methods
from lti_tool.models import LtiLaunch, LtiRegistration
from pylti1p3.deep_link import DeepLink
from pylti1p3.deep_link_resource import DeepLinkResource
from pylti1p3.lineitem import LineItem

from qdot.grader.serve.class_list import load_assignments
from qdot.grader.serve.errors import Refused
from qdot.grader.serve.html_pages import render_page
from qdot.grader.serve.lti.columns import make_path
from qdot.grader.serve.lti.connection import make_registration
from qdot.grader.serve.lti.pages import send_form
from qdot.grader.serve.models import Person
from qdot.grader.serve.settings import find_options
from qdot.grader.serve.sign_in import for_staff

_REVIEWABLE = ["InProgress", "Submitted", "Completed"]


def begin_choosing(request: HttpRequest, launch: LtiLaunch, person: Person) -> HttpResponse:
    """Store what the reply to the platform needs, and go to the page on which a teacher chooses. Raises Refused."""
    if person.role != Person.Role.STAFF:
        raise Refused(403, "Only a teacher of the course can add activities.")
    launch.get_message_launch().get_deep_link()  # raises an error if the settings are missing
    settings_claim = launch.get_claim("https://purl.imsglobal.org/spec/lti-dl/claim/deep_linking_settings")
    if not str(settings_claim["deep_link_return_url"]).startswith(("https://", "http://")):
        raise Refused(400, "The platform didn't say where to send your choice.")
    request.session["choosing"] = [launch.registration.pk, launch.deployment.deployment_id, settings_claim]
    return HttpResponseRedirect("/lti/choose")


@require_http_methods(["GET", "POST"])
@for_staff
def choose(request: HttpRequest, _: Person) -> HttpResponse:
    """Show the assignments and questions to choose from, or send the choice to the platform."""
    if "choosing" not in request.session:
        raise Refused(400, "Begin in your course: add an activity, and select qdot.")
    assignments = _list_assignments()
    if request.method == "GET":
        values = {"action": "/lti/choose", "assignments": assignments}
        return render_page(request, "serve/choose.html.j2", title="Choose an assignment", **values)
    choice = request.POST.get("choice", "")
    activities = {resource_id: (title, points) for resource_id, title, points in _list_activities(assignments)}
    if choice not in activities:
        raise Refused(400, "Choose an assignment or a question.")
    title, points = activities[choice]
    platform_id, deployment_id, settings_claim = request.session.pop("choosing")
    column = LineItem({"label": title, "scoreMaximum": points, "resourceId": choice})
    column.set_submission_review(_REVIEWABLE)
    link = DeepLinkResource().set_title(title).set_url(find_options().url + make_path(choice))
    link.set_custom_params({"resource": choice})  # Moodle refuses a link without any parameter
    if settings_claim.get("accept_lineitem", True):
        link.set_lineitem(column)
    registration = make_registration(LtiRegistration.objects.active().get(pk=platform_id), timezone.now())
    response = DeepLink(registration, deployment_id, settings_claim).get_response_jwt([link])
    return send_form(settings_claim["deep_link_return_url"], {"JWT": response}, "Add to the course")


def _list_assignments() -> list[dict[str, Any]]:
    """Return the assignments and their questions, as the page shows them."""
    assignments = []
    for key, assignment in load_assignments().items():
        parts = [
            {"name": f"{slot.name}.{name}", "title": slot.find_question(name).title, "points": points}
            for slot in assignment.slots
            for name, points in slot.points_by_question.items()
        ]
        total = sum(sum(slot.max_points) for slot in assignment.slots)
        assignments.append({"key": key, "title": assignment.title, "points": total, "parts": parts})
    return assignments


def _list_activities(assignments: list[dict[str, Any]]) -> Iterator[tuple[str, str, float]]:
    """Yield the resource id (see `columns`), the title and the points of each activity to choose from."""
    for assignment in assignments:
        yield assignment["key"], assignment["title"], assignment["points"]
        for part in assignment["parts"]:
            title = f"{assignment['title']}: {part['name']} {part['title']}"
            yield f"{assignment['key']}/{part['name']}", title, part["points"]
