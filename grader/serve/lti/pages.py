"""Send the few pages of LTI that run a script inside a platform's frame.

Their Content-Security-Policy allows exactly the scripts that are in the page.
"""

import base64
import hashlib
import re
from collections.abc import Mapping
from urllib.parse import urlsplit

from django.core.cache import cache
from django.http import HttpResponse
from django.utils.html import format_html, format_html_join
from django.utils.safestring import mark_safe
from lti_tool.models import LtiRegistration

SECONDS_OF_ORIGINS = 5
"""For how long the origins are cached, because every response contains them."""
_ORIGIN = re.compile(r"https?://[\w.:\[\]-]+", re.ASCII)
"""Matches an origin that adds nothing else to a header, because platforms state their own origins."""
_SCRIPT = re.compile(r"<script[^>]*>(.*?)</script>", re.DOTALL)
_HEAD = '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>qdot</title>'
_SUBMIT = mark_safe("<script>document.forms[0].submit()</script>")
_CLOSE = mark_safe(
    "<script>(window.opener || window.parent).postMessage({subject: 'org.imsglobal.lti.close'}, '*')</script>"
)


def list_frame_origins() -> list[str]:
    """Return the origins of the registered platforms, which may show our pages in a frame."""
    return cache.get_or_set("frame-origins", _find_frame_origins, SECONDS_OF_ORIGINS) or []


def _find_frame_origins() -> list[str]:
    rows = LtiRegistration.objects.active().values_list("name", "issuer", "auth_url")
    parts = [urlsplit(address) for row in rows for address in row]
    origins = {f"{part.scheme}://{part.netloc}" for part in parts}
    return sorted(filter(_ORIGIN.fullmatch, origins))


def send_page(html: str) -> HttpResponse:
    """Return a whole page as a response that lets a browser run the scripts in it, and no others."""
    digests = [hashlib.sha256(script.encode()).digest() for script in _SCRIPT.findall(html)]
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    frames = " ".join(["'self'", *list_frame_origins()])
    policy = (
        f"default-src 'none'; base-uri 'none'; style-src 'unsafe-inline'; script-src {hashes}; frame-ancestors {frames}"
    )
    return HttpResponse(html, headers={"Content-Security-Policy": policy})


def send_form(address: str, fields: Mapping[str, str], button: str) -> HttpResponse:
    """Return a page that posts `fields` to an address of the platform at once, or when the button is pressed."""
    inputs = format_html_join("", '<input type="hidden" name="{}" value="{}">', fields.items())
    form = _HEAD + '<form method="post" action="{}">{}<button>{}</button></form>{}'
    return send_page(format_html(form, address, inputs, button, _SUBMIT))


def send_closing_page(sentence: str) -> HttpResponse:
    """Return a page with a sentence that asks the platform to close its window."""
    return send_page(format_html(_HEAD + "<p>{}</p>{}", sentence, _CLOSE))
