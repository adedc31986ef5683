"""Support pages in a frame without cookies: read the session's key that they send, and pass it on in redirections."""

from collections.abc import Callable
from urllib.parse import urlsplit

from django.conf import settings
from django.http import HttpRequest, HttpResponse

from qdot.grader.serve.errors import Refused, respond
from qdot.grader.serve.frame_sessions import find_frame_session_key, is_from_own_page, use_frame_session
from qdot.grader.serve.lti.pages import send_form
from qdot.grader.serve.sign_in import SIGN_IN_ADVICE

FORM_TYPE = "application/x-www-form-urlencoded"


class FrameSessionMiddleware:
    """Uses the session's key that a page sent instead of the session's cookie.

    A form with the field `method` requests a page, as a link does.
    """

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Return the response of the view; a redirection becomes a form that also sends the key."""
        is_form = request.method == "POST" and request.content_type == FORM_TYPE
        form = request.POST.dict() if is_form else {}
        if key := request.headers.get("X-Session") or form.get("session"):
            needs_origin = request.method != "GET" or "Origin" in request.headers
            has_other_session = request.COOKIES.get(settings.SESSION_COOKIE_NAME, key) != key
            if has_other_session or (needs_origin and not is_from_own_page(request)):
                return respond(request, Refused(401, SIGN_IN_ADVICE))
            use_frame_session(request)
            request.COOKIES[settings.SESSION_COOKIE_NAME] = key
            if token := request.headers.get("X-CSRFToken") or form.get("csrfmiddlewaretoken"):
                request.COOKIES[settings.CSRF_COOKIE_NAME] = token
            if form.get("method") == "GET":
                request.method = "GET"
        response = self._get_response(request)
        address, key = response.get("Location"), find_frame_session_key(request)
        if key and address and not urlsplit(address).netloc:
            return send_form(address, {"session": key, "method": "GET"}, "Continue")
        return response
