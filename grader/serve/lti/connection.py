"""Send requests to a platform, and store the keys that sign them.

A platform may cache qdot's public keys. Therefore a new key is published a day before it signs, and an old key stays
published after a newer one has replaced it.
"""

import datetime
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import requests
from lti_tool.models import Key, LtiRegistration
from pylti1p3.exception import LtiException
from pylti1p3.registration import Registration
from pylti1p3.service_connector import ServiceConnector
from requests.utils import parse_header_links

from qdot.exercises.common.errors import QdotError

TIMEOUT = 10
"""Number of seconds within which a platform must answer."""
KEY_PUBLICATION = datetime.timedelta(days=1)
KEY_LIFETIME = datetime.timedelta(days=180)
KEY_OVERLAP = datetime.timedelta(days=14)
"""How long a key is published before it signs, how old the newest key may be, and how long a key that was replaced
stays published."""
TOKEN_LIFETIME = datetime.timedelta(minutes=20)
"""How long an access token of a platform is reused; platforms issue tokens for an hour."""
PLATFORM_ERRORS = (LtiException, QdotError, requests.RequestException, LookupError, TypeError, ValueError)
"""The errors of a request: the platform refuses it, sends an unexpected answer, or can't be reached."""


class PlatformSession(requests.Session):
    """A session in which every request has a time limit."""

    def request(self, *args: Any, **kwargs: Any) -> requests.Response:
        """Send a request."""
        kwargs.setdefault("timeout", TIMEOUT)
        return super().request(*args, **kwargs)


def renew_keys(now: datetime.datetime) -> None:
    """Make a new key if there is none or the newest one is old, and stop publishing keys that were replaced."""
    newest = Key.objects.active().order_by("datetime_created").last()
    if newest is None or newest.datetime_created <= now - KEY_LIFETIME:
        Key.objects.generate()
    if newest is not None:
        expired = Key.objects.active().filter(datetime_created__lte=now - KEY_LIFETIME - KEY_OVERLAP)
        expired.exclude(pk=newest.pk).update(is_active=False)


def find_signing_key(now: datetime.datetime) -> Key:
    """Return the newest key that platforms have had time to fetch; the oldest key if there is no such key."""
    keys = list(Key.objects.active().order_by("datetime_created"))
    return next((key for key in reversed(keys) if key.datetime_created <= now - KEY_PUBLICATION), keys[0])


def make_registration(platform: LtiRegistration, now: datetime.datetime) -> Registration:
    """Return the platform as PyLTI1p3 describes it, with the key that signs qdot's messages."""
    registration = platform.to_registration()
    key = find_signing_key(now)
    registration.set_tool_private_key(key.private_key)
    registration.set_tool_public_key(key.public_key)
    return registration


def make_connector(platform: LtiRegistration, now: datetime.datetime) -> ServiceConnector:
    """Return a new connection to a platform."""
    return ServiceConnector(make_registration(platform, now), PlatformSession())


class Connections:
    """The connections to platforms; each stores its access tokens for some minutes."""

    def __init__(self) -> None:
        self._connectors: dict[int, tuple[datetime.datetime, ServiceConnector]] = {}

    def open(self, platform: LtiRegistration, now: datetime.datetime) -> ServiceConnector:
        """Return the connection to a platform."""
        opening_time, connector = self._connectors.get(platform.pk, (None, None))
        if connector is None or opening_time is None or now - opening_time > TOKEN_LIFETIME:
            connector = make_connector(platform, now)
            self._connectors[platform.pk] = now, connector
        return connector

    def close(self, platform: LtiRegistration) -> None:
        """Forget the platform's access tokens."""
        self._connectors.pop(platform.pk, None)


def read_pages(connector: ServiceConnector, scope: str, url: str, media_type: str) -> Iterator[Any]:
    """Yield the pages of a list, beginning at `url`. Raises QdotError.

    The access token is sent only to the server of the first page. PyLTI1p3's own function is not used, because it
    changes addresses to lower case.
    """
    server, next_url = urlsplit(url)[:2], url
    for _ in range(1000):  # no class has so many pages
        response = connector.make_service_request([scope], next_url, accept=media_type, case_insensitive_headers=True)
        yield response["body"]
        links = parse_header_links(response["headers"].get("Link", ""))
        next_url = next((link["url"] for link in links if link.get("rel") == "next"), "")
        if not next_url:
            return
        if urlsplit(next_url)[:2] != server:
            raise QdotError("the next page of the platform's list is on another server")
    raise QdotError("the platform's list has too many pages")
