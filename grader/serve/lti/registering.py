"""Register a platform, by hand or dynamically, and connect its courses.

A registration begins on this machine: `qdot serve register` stores the platform's address, and prints the addresses of
qdot that the platform needs. The platform finishes it at the address /lti/register/UUID, which works once, or a person
enters the client ID. Until then it has no issuer, and nobody can sign in through it. As a registration begins on this
machine, an outsider can't register a platform.
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
"""Maximum time between the beginning of a registration and its end."""


@dataclass(frozen=True)
class CopiedValues:
    """What a person copies from the platform: its address, the client ID, and addresses that differ from the usual."""

    site: str = ""
    client_id: str = ""
    issuer: str = ""
    auth_url: str = ""
    token_url: str = ""
    keys_url: str = ""


def begin_registration(platform_name: str, site: str) -> LtiRegistration:
    """Begin to register the platform at `site`. A registration of it that was begun before is replaced."""
    _find_platform(platform_name)
    address = _check_address("--site", site)
    LtiRegistration.objects.filter(name=address, issuer="").delete()
    registration = LtiRegistration(name=address)
    registration.client_id = str(registration.uuid)  # no two registrations have the same issuer and client ID
    registration.save()
    renew_keys(timezone.now())
    return registration


def _find_platform(platform_name: str) -> Platform:
    if platform_name not in PLATFORMS:
        raise QdotError(f"--platform {platform_name!r}: expected one of {', '.join(PLATFORMS)}")
    return PLATFORMS[platform_name]


def describe_registration_steps(platform_name: str, registration: LtiRegistration, command: str) -> str:
    """Return which addresses to paste where, and the command that finishes the registration."""
    platform, url = PLATFORMS[platform_name], find_options().url
    address = f"{url}/lti/register/{registration.uuid}"
    dynamic_text = f"Registration address (works once, for {LIFETIME.days} days):\n  {address}\n\n"
    lines = [
        ("Tool address, and target of deep linking", f"{url}/"),
        ("Login (OIDC initiation)", f"{url}/lti/login/{registration.uuid}"),
        ("Redirect", f"{url}/lti/launch"),
        ("Public keys (JWKS)", f"{url}/lti/keys"),
    ]
    table = "".join(f"  {label + ':':42}{value}\n" for label, value in lines)
    finish_command = f"{command} --platform {platform_name} --site {registration.name} --client-id ID"
    return (
        f"{platform.title}: {platform.steps}\n\n{dynamic_text if platform.is_dynamic else ''}By hand:\n{table}\n"
        f"Then, with the client ID that {platform.title} shows:\n  {finish_command}\n"
    )


def finish_registration(platform_name: str, copied_values: CopiedValues) -> LtiRegistration:
    """Finish the registration that was begun for a platform. Raises QdotError if none was begun."""
    platform, site = _find_platform(platform_name), _check_address("--site", copied_values.site)
    registration = LtiRegistration.objects.filter(name=site).order_by("datetime_created").last()
    if registration is None:
        raise QdotError(f"no registration has begun for {site}; run this command without --client-id first")
    templates = {name: getattr(platform, name) for name in ("issuer", "auth_url", "token_url", "keys_url")}
    fill = {"site": site, "client_id": copied_values.client_id}
    values = {name: getattr(copied_values, name) or text.format(**fill) for name, text in templates.items()}
    return _activate(registration, copied_values.client_id, platform.audience, values)


def connect_course(classroom: Classroom) -> None:
    """Let the people of a course use the service."""
    if classroom.lti_context is not None:
        LtiDeployment.objects.filter(pk=classroom.lti_context.deployment_id).update(is_active=True)
        classroom.lti_context.deployment.is_active = True
    classroom.is_connected = True
    classroom.save(update_fields=["is_connected"])


def _activate(registration: LtiRegistration, client_id: str, audience: str, values: dict[str, str]) -> LtiRegistration:
    """Complete a registration.

    Raises QdotError for a wrong address, or if the issuer and the client ID are incomplete or registered already.
    """
    registration.auth_url, registration.token_url, registration.keyset_url = (
        _check_address(name, values[name]) for name in ("auth_url", "token_url", "keys_url")
    )
    registration.issuer, registration.client_id = values["issuer"], client_id
    registration.audience, registration.is_active = audience, True
    others = LtiRegistration.objects.filter(issuer=registration.issuer, client_id=client_id).exclude(pk=registration.pk)
    if not registration.issuer or not client_id or others.exists():
        raise QdotError(
            f"issuer {registration.issuer!r}, client ID {client_id!r}: give both; the pair must not be registered yet"
        )
    registration.save()
    return registration


def _check_address(name: str, address: str) -> str:
    """Return an address without a final slash. A service with https accepts only addresses with https.

    Raises QdotError for another address.
    """
    parts = urlsplit(address)
    schemes = ("https",) if find_options().url.startswith("https:") else ("https", "http")
    if parts.scheme not in schemes or not parts.hostname or len(address) > 200:
        raise QdotError(f"{name} {address!r}: expected a whole address that begins with {' or '.join(schemes)}://")
    return address.rstrip("/")


def _check_server(name: str, address: str, registration: LtiRegistration) -> str:
    """Return an address if it is on the registered server, or on a server that all schools of a platform share.

    Raises QdotError for other servers. Without this check, anyone with the address of a registration could make qdot
    send requests to hosts behind a firewall.
    """
    shared_urls = (
        url for platform in PLATFORMS.values() for url in (platform.issuer, platform.auth_url, platform.token_url)
    )
    servers = {urlsplit(url).netloc for url in (registration.name, *shared_urls) if "{" not in url}
    if urlsplit(_check_address(name, address)).netloc not in servers:
        raise QdotError(f"{name} {address!r}: expected an address that begins with {registration.name}")
    return address


@require_GET
def register_dynamically(request: HttpRequest, uuid: UUID) -> HttpResponse:
    """Register the platform in which an administrator entered the registration address (LTI Dynamic Registration)."""
    begun_registrations = LtiRegistration.objects.filter(issuer="", datetime_created__gt=timezone.now() - LIFETIME)
    registration = get_object_or_404(begun_registrations, uuid=uuid)
    session = PlatformSession()
    try:
        address = _check_server("openid_configuration", request.GET.get("openid_configuration", ""), registration)
        response = session.get(address, allow_redirects=False)
        response.raise_for_status()
        configuration: dict[str, Any] = response.json()
        token = request.GET.get("registration_token")
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        endpoint = _check_server("registration_endpoint", configuration["registration_endpoint"], registration)
        response = session.post(endpoint, json=describe_tool(registration), headers=headers, allow_redirects=False)
        response.raise_for_status()
        names = {"auth_url": "authorization_endpoint", "token_url": "token_endpoint", "keys_url": "jwks_uri"}
        values = {"issuer": configuration["issuer"], **{name: configuration[key] for name, key in names.items()}}
        audience = configuration.get("authorization_server") or ""
        _activate(registration, str(response.json()["client_id"]), audience, values)
    except PLATFORM_ERRORS as error:
        logger.warning("a registration failed: %s", escape_controls(str(error))[:300])
        raise Refused(400, "The registration failed; the log of the service says why.") from error
    return send_closing_page("qdot is registered. You can close this window.")


def describe_tool(registration: LtiRegistration) -> dict[str, Any]:
    """Return the description of this service for dynamic registration."""
    url = find_options().url
    return {
        "application_type": "web",
        "client_name": NAME,
        "grant_types": ["client_credentials", "implicit"],
        "response_types": ["id_token"],
        "initiate_login_uri": f"{url}/lti/login/{registration.uuid}",
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
