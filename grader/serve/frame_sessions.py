"""Keep a person signed in within a platform's frame if the browser stores no cookies there.

Pages of such a session contain its key. Their scripts send it as the header X-Session, their links and forms as a field
of a form that is posted: never in an address. `frame_requests` reads it there.
"""

from django.http import HttpRequest

from qdot.grader.serve.settings import find_options

_MARK = "qdot.frame-session"


def begin_frame_session(request: HttpRequest) -> None:
    """Let the session of this request live in the pages that it gets, instead of in a cookie."""
    request.META[_MARK] = True


def find_frame_session(request: HttpRequest) -> str:
    """Return the key of the session if it lives in pages, else ""."""
    return request.session.session_key or "" if _MARK in request.META else ""


def is_own_page(request: HttpRequest) -> bool:
    """Return whether a page of this service sent the request, as the browser says."""
    own_origins = find_options().url, f"{request.scheme}://{request.get_host()}"
    return request.headers.get("Origin") in own_origins
