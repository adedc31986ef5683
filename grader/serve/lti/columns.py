"""The columns of a course's gradebook (line items): one for an assignment, or one for a single question.

A column is stored when the platform names it in a launch. `resource_id` says what it is for: the key of an assignment,
or the key and a part, as in velocity/p1.jacobian.
"""

from urllib.parse import parse_qs, quote, urlencode, urlsplit

from lti_tool.models import LtiContext, LtiLaunch, LtiLineItem, LtiResourceLink
from pylti1p3.assignments_grades import AssignmentsGradesService
from pylti1p3.lineitem import LineItem
from pylti1p3.service_connector import ServiceConnector

MANAGE_SCOPE = "https://purl.imsglobal.org/spec/lti-ags/scope/lineitem"


def make_path(resource_id: str) -> str:
    """Return the path of the page of an assignment or a question.

    >>> make_path("velocity/p1.jacobian")
    '/a/velocity/?part=p1.jacobian'
    """
    key, _, part = resource_id.partition("/")
    return f"/a/{quote(key)}/" + (f"?{urlencode({'part': part})}" if part else "")


def find_resource_id(address: str) -> str:
    """Return the resource id of the page at an address; "" if it is no page of an assignment or a question.

    >>> find_resource_id("https://qdot.example.edu/a/velocity/?part=p1.jacobian")
    'velocity/p1.jacobian'
    """
    parts = urlsplit(address)
    folders = parts.path.split("/")
    if len(folders) != 4 or folders[:2] != ["", "a"] or folders[3]:
        return ""
    return "/".join([folders[2], *parse_qs(parts.query).get("part", [])[:1]])


def save_column(launch: LtiLaunch, context: LtiContext, resource_id: str, connector: ServiceConnector) -> bool:
    """Store the column of the activity that a launch opened, and return whether it is new.

    If a teacher typed the address of the activity, the platform has made no column. qdot then makes one, provided that
    the platform allows it. Raises an error of the library or the connection.
    """
    endpoint, link = launch.ags_claim or {}, launch.resource_link
    url = endpoint.get("lineitem", "")
    if not url and endpoint.get("lineitems") and MANAGE_SCOPE in endpoint.get("scope", []):
        if LtiLineItem.objects.filter(context=context, resource_link=link).exists():
            return False
        url = _make_column(endpoint, link, resource_id, connector)
    if not url:
        return False
    column = LtiLineItem.objects.filter(url=url).first()
    if column is not None and (column.context_id != context.pk or column.resource_id == resource_id):
        return False
    values = {"label": link.title[:255], "resource_id": resource_id, "resource_link": link, "maximum_score": 0}
    LtiLineItem.objects.update_or_create(url=url, defaults={"context": context, **values})
    return True


def _make_column(endpoint: dict, link: LtiResourceLink, resource_id: str, connector: ServiceConnector) -> str:
    """Return the address of the activity's column; make the column on the platform if it is missing."""
    service = AssignmentsGradesService(connector, {**endpoint, "scope": [MANAGE_SCOPE]})
    column = LineItem({"label": link.title or resource_id, "scoreMaximum": 100, "resourceId": resource_id})
    column.set_resource_link_id(link.id_on_platform)
    return str(service.find_or_create_lineitem(column, find_by="resource_link_id").get_id() or "")
