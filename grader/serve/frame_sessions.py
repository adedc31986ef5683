"""Keep a person signed in within a platform's frame if the browser stores no cookies there.

Pages of such a session contain its key. Scripts send the key in the header X-Session; links and forms post it in a
field. The key is never in an address. `frame_requests` reads it.
"""

from django.http import HttpRequest

from qdot.grader.serve.settings import find_options

_META_KEY = "qdot.frame-session"


def use_frame_session(request: HttpRequest) -> None:
    """Flag the request, so that the pages sent in response contain the key of its session."""
    request.META[_META_KEY] = True


def find_frame_session_key(request: HttpRequest) -> str:
    """Return the key of the session if its pages contain the key, else ""."""
    return (request.session.session_key or "") if _META_KEY in request.META else ""


def is_from_own_page(request: HttpRequest) -> bool:
    """Return whether a page of this service sent the request, according to the browser."""
    own_origins = find_options().url, f"{request.scheme}://{request.get_host()}"
    return request.headers.get("Origin") in own_origins
