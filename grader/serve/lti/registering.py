"""Register a platform, by hand or dynamically, and connect its courses.

A registration begins on this machine: `qdot serve register` stores the address of the platform, and prints ours. The
platform finishes it at the address /lti/register/UUID, which works once, or a person enters the client ID. Until then
it has no issuer, and nobody can sign in through it. So nobody can register a platform of their own.
"""

import datetime
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit
from uuid import UUID

from django.http import HttpRequest, HttpResponse
from django.shortcuts import get_object_or_404
from django.utils import timezone
from django.views.decorators.http import require_GET
from lti_tool.models import LtiDeployment, LtiRegistration

from qdot.exercises.common.console import escape_controls
from qdot.exercises.common.errors import QdotError
from qdot.grader.serve.errors import Refused, logger
from qdot.grader.serve.lti.columns import MANAGE_SCOPE
from qdot.grader.serve.lti.connection import PLATFORM_ERRORS, PlatformSession, renew_keys
from qdot.grader.serve.lti.outbox import SCORE_SCOPE
from qdot.grader.serve.lti.pages import send_closing_page
from qdot.grader.serve.lti.people import MEMBERS_SCOPE
from qdot.grader.serve.lti.platforms import PLATFORMS, Platform
from qdot.grader.serve.models import Classroom
from qdot.grader.serve.settings import find_options

NAME = "qdot"
LIFETIME = datetime.timedelta(days=7)
"""For how long the platform can finish a registration that was begun."""


@dataclass(frozen=True)
class PlatformAnswers:
    """What a person copies from the platform: its address, the client ID, and addresses that differ from the usual."""

    site: str = ""
    client_id: str = ""
    issuer: str = ""
    auth_url: str = ""
    token_url: str = ""
    keys_url: str = ""


def begin(kind: str, site: str) -> LtiRegistration:
    """Store that the platform at `site` is to be registered; a registration that was begun before is begun again."""
    _find_kind(kind)
    site = _check_address("--site", site)
    LtiRegistration.objects.filter(name=site, issuer="").delete()
    row = LtiRegistration(name=site)
    row.client_id = str(row.uuid)  # no two rows have the same issuer and client ID
    row.save()
    renew_keys(timezone.now())
    return row


def _find_kind(kind: str) -> Platform:
    if kind not in PLATFORMS:
        raise QdotError(f"--platform {kind!r}: expected one of {', '.join(PLATFORMS)}")
    return PLATFORMS[kind]


def describe_steps(kind: str, row: LtiRegistration, command: str) -> str:
    """Return what a person pastes where, and the command that finishes it."""
    platform, url = PLATFORMS[kind], find_options().url
    dynamic = f"Registration address (works once, for {LIFETIME.days} days):\n  {url}/lti/register/{row.uuid}\n\n"
    lines = [
        ("Tool address, and target of deep linking", f"{url}/"),
        ("Login (OIDC initiation)", f"{url}/lti/login/{row.uuid}"),
        ("Redirect", f"{url}/lti/launch"),
        ("Public keys (JWKS)", f"{url}/lti/keys"),
    ]
    table = "".join(f"  {label + ':':42}{address}\n" for label, address in lines)
    finish = f"{command} --platform {kind} --site {row.name} --client-id ID"
    return (
        f"{platform.title}: {platform.steps}\n\n{dynamic if platform.is_dynamic else ''}By hand:\n{table}\n"
        f"Then, with the client ID that {platform.title} shows:\n  {finish}\n"
    )


def finish(kind: str, answers: PlatformAnswers) -> LtiRegistration:
    """Finish the registration that was begun for a platform. Raises QdotError if none was begun."""
    platform, site = _find_kind(kind), _check_address("--site", answers.site)
    row = LtiRegistration.objects.filter(name=site).order_by("datetime_created").last()
    if row is None:
        raise QdotError(f"no registration has begun for {site}; run this command without --client-id first")
    usual = {name: getattr(platform, name) for name in ("issuer", "auth_url", "token_url", "keys_url")}
    fill = {"site": site, "client_id": answers.client_id}
    values = {name: getattr(answers, name) or text.format(**fill) for name, text in usual.items()}
    return _activate(row, answers.client_id, platform.audience, values)


def connect(classroom: Classroom) -> None:
    """Let the people of a course use the service."""
    if classroom.lti_context is not None:
        LtiDeployment.objects.filter(pk=classroom.lti_context.deployment_id).update(is_active=True)
        classroom.lti_context.deployment.is_active = True
    classroom.is_connected = True
    classroom.save(update_fields=["is_connected"])


def _activate(row: LtiRegistration, client_id: str, audience: str, values: dict[str, str]) -> LtiRegistration:
    """Store what the platform gave. Raises QdotError for a wrong address, or if its client ID is registered already."""
    row.auth_url, row.token_url, row.keyset_url = (
        _check_address(name, values[name]) for name in ("auth_url", "token_url", "keys_url")
    )
    row.issuer, row.client_id, row.audience, row.is_active = values["issuer"], client_id, audience, True
    same = LtiRegistration.objects.filter(issuer=row.issuer, client_id=client_id).exclude(pk=row.pk)
    if not row.issuer or not client_id or same.exists():
        raise QdotError(f"issuer {row.issuer!r}, client ID {client_id!r}: expected ones that are not registered yet")
    row.save()
    return row


def _check_address(name: str, address: str) -> str:
    """Return an address without a final slash. It needs https, unless the service itself is on this machine."""
    parts = urlsplit(address)
    schemes = ("https",) if find_options().url.startswith("https:") else ("https", "http")
    if parts.scheme not in schemes or not parts.hostname or len(address) > 200:
        raise QdotError(f"{name} {address!r}: expected a whole address that begins with {' or '.join(schemes)}://")
    return address.rstrip("/")


def _check_server(name: str, address: str, row: LtiRegistration) -> str:
    """Return an address on the server that is registered, or on one that all schools of a platform share.

    Raises QdotError for other servers; otherwise, anyone with the address of a registration could make qdot send
    requests to hosts behind a firewall.
    """
    shared = (address for kind in PLATFORMS.values() for address in (kind.issuer, kind.auth_url, kind.token_url))
    servers = {urlsplit(url).netloc for url in (row.name, *shared) if "{" not in url}
    if urlsplit(_check_address(name, address)).netloc not in servers:
        raise QdotError(f"{name} {address!r}: expected an address that begins with {row.name}")
    return address


@require_GET
def register_dynamically(request: HttpRequest, uuid: UUID) -> HttpResponse:
    """Register the platform whose administrator opened the registration address there (LTI Dynamic Registration)."""
    begun = LtiRegistration.objects.filter(issuer="", datetime_created__gt=timezone.now() - LIFETIME)
    row = get_object_or_404(begun, uuid=uuid)
    session = PlatformSession()
    try:
        address = _check_server("openid_configuration", request.GET.get("openid_configuration", ""), row)
        answer = session.get(address, allow_redirects=False)
        answer.raise_for_status()
        platform: dict[str, Any] = answer.json()
        token = request.GET.get("registration_token")
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        endpoint = _check_server("registration_endpoint", platform["registration_endpoint"], row)
        answer = session.post(endpoint, json=describe_tool(row), headers=headers, allow_redirects=False)
        answer.raise_for_status()
        names = {"auth_url": "authorization_endpoint", "token_url": "token_endpoint", "keys_url": "jwks_uri"}
        values = {"issuer": platform["issuer"], **{name: platform[key] for name, key in names.items()}}
        audience = platform.get("authorization_server") or ""
        _activate(row, str(answer.json()["client_id"]), audience, values)
    except PLATFORM_ERRORS as error:
        logger.warning("a registration failed: %s", escape_controls(str(error))[:300])
        raise Refused(400, "The registration failed; the log of the service says why.") from error
    return send_closing_page("qdot is registered. You can close this window.")


def describe_tool(row: LtiRegistration) -> dict[str, Any]:
    """Return the description of this service for dynamic registration."""
    url = find_options().url
    return {
        "application_type": "web",
        "client_name": NAME,
        "grant_types": ["client_credentials", "implicit"],
        "response_types": ["id_token"],
        "initiate_login_uri": f"{url}/lti/login/{row.uuid}",
        "redirect_uris": [f"{url}/lti/launch"],
        "jwks_uri": f"{url}/lti/keys",
        "token_endpoint_auth_method": "private_key_jwt",
        "scope": f"{MANAGE_SCOPE} {SCORE_SCOPE} {MEMBERS_SCOPE}",
        "https://purl.imsglobal.org/spec/lti-tool-configuration": {
            "domain": urlsplit(url).netloc,
            "target_link_uri": f"{url}/",
            "claims": ["iss", "sub", "name", "given_name", "family_name", "email"],
            "messages": [
                {"type": "LtiResourceLinkRequest", "target_link_uri": f"{url}/"},
                {"type": "LtiDeepLinkingRequest", "target_link_uri": f"{url}/", "label": NAME},
            ],
        },
    }
