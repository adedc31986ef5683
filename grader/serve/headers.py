"""Add headers to every response that restrict what a page may do in the browser."""

from collections.abc import Callable, Iterable
from typing import Any
from wsgiref.types import StartResponse, WSGIApplication

from django.http import HttpRequest, HttpResponse

from qdot.grader.serve.lti.pages import list_frame_origins

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self' data:; connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors {ancestors}"
)
"""The policy of the static site; in addition, only the registered platforms may show the service in a frame."""


class HeadersMiddleware:
    """Adds the headers, unless a view has set a policy of its own."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Return the response of the view with the headers."""
        response = self._get_response(request)
        if "Content-Security-Policy" not in response:
            response["Content-Security-Policy"] = POLICY.format(ancestors=" ".join(["'self'", *list_frame_origins()]))
        response.setdefault("Permissions-Policy", "camera=(), geolocation=(), microphone=()")
        if not request.path.startswith("/static/"):
            response.setdefault("Cache-Control", "no-store")  # the next user of a shared computer must not see it
        return response


def partition_cookies(application: WSGIApplication) -> WSGIApplication:
    """Return the application with partitioned cookies, which browsers store in frames even if they block third parties.

    A browser stores them separately for each site with such a frame. Django 5.2 doesn't support this attribute.
    """

    def call(environ: dict[str, Any], start_response: StartResponse) -> Iterable[bytes]:
        def start(status: str, headers: list[tuple[str, str]], *error: Any) -> Any:
            new_headers = [(name, f"{text}; Partitioned" if name == "Set-Cookie" else text) for name, text in headers]
            return start_response(status, new_headers, *error)

        return application(environ, start)

    return call
