"""Answer invalid requests with one sentence and an HTTP status, never with a traceback."""

import logging
import sys
from collections.abc import Callable

from django.core.cache import cache
from django.core.exceptions import BadRequest, DisallowedHost, PermissionDenied, RequestDataTooBig, SuspiciousOperation
from django.db import InterfaceError, OperationalError
from django.http import Http404, HttpRequest, HttpResponse, JsonResponse

from qdot.exercises.common.console import escape_controls
from qdot.grader.serve.settings import find_options

logger = logging.getLogger("qdot.serve")


class Refused(Exception):
    """Raised to refuse a request, with the HTTP status and a sentence for the person."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status, self.sentence = status, sentence


NO_PAGE = "There is no such page, or it isn't yours."
"""The sentence for pages that don't exist and for pages of another person, so that nobody can tell them apart."""
TOO_LARGE = "This is larger than qdot accepts: an answer or a comment may have a few thousand characters."
REPORT_SECONDS = 60
"""Minimum number of seconds between two lines in the log about a database that doesn't answer, or about wrong hosts."""
RETRY_SECONDS = 30
"""Number of seconds after which a program that sent too many requests should try again."""
FAILURE = "qdot itself failed. Nothing that you submitted is lost; try again in a minute, and tell your instructor."


def find_refusal(error: Exception) -> Refused:
    """Return the status and the sentence for an exception that a view raised."""
    if isinstance(error, Refused):
        return error
    if isinstance(error, RequestDataTooBig):
        return Refused(413, TOO_LARGE)
    if isinstance(error, Http404):
        return Refused(404, NO_PAGE)
    if isinstance(error, PermissionDenied):
        return Refused(403, "You may not do this.")
    if isinstance(error, (BadRequest, SuspiciousOperation, UnicodeDecodeError)):
        return Refused(400, "qdot couldn't read this request; load the page again.")
    if isinstance(error, TimeoutError):
        return Refused(503, "qdot is busy at the moment. Try again in a minute.")
    report_failed("a request", error)
    return Refused(500, FAILURE)


def report_failed(work: str, error: BaseException | None) -> None:
    """Log an error; if a database doesn't answer, log only one line per minute."""
    if not isinstance(error, (OperationalError, InterfaceError)):
        logger.error("%s failed", work, exc_info=error)
    elif cache.add("database-failed", True, REPORT_SECONDS):
        logger.error("%s failed: the database can't be used: %s", work, " ".join(str(error).split()))


def respond(request: HttpRequest, refusal: Refused) -> HttpResponse:
    """Return the answer to a refused request: a page if the browser shows it, JSON if a script sent the request."""
    headers = {"Retry-After": str(RETRY_SECONDS)} if refusal.status == 429 else {}
    if "text/html" in request.headers.get("Accept", ""):
        from qdot.grader.serve.html_pages import render_page

        if refusal.status == 401:
            page = render_page(request, "serve/home.html.j2", title="qdot", advice=refusal.sentence, assignments=[])
        else:
            page = render_page(request, "serve/refused.html.j2", title="qdot", sentence=refusal.sentence)
        page.status_code = refusal.status
        for name, value in headers.items():
            page[name] = value
        return page
    return JsonResponse({"error": refusal.sentence}, status=refusal.status, headers=headers)


class RefusalMiddleware:
    """Turns every exception of a view into one sentence."""

    def __init__(self, get_response: Callable[[HttpRequest], HttpResponse]) -> None:
        self._get_response = get_response

    def __call__(self, request: HttpRequest) -> HttpResponse:
        """Return the response of the view."""
        return self._get_response(request)

    def process_exception(self, request: HttpRequest, error: Exception) -> HttpResponse:
        """Return the answer to a request whose view raised an exception."""
        return respond(request, find_refusal(error))


def report_refused_request(request: HttpRequest, exception: Exception) -> HttpResponse:
    """Answer a request that Django refused before any view."""
    if isinstance(exception, DisallowedHost):
        host, url = escape_controls(request.headers.get("Host", ""))[:100], find_options().url
        sentence = f"qdot is at {url}, but a request named the host {host!r}. Pass the header Host on, or change --url."
        if cache.add("unknown-host", True, REPORT_SECONDS):
            logger.error("a request was refused: %s", sentence)
        return respond(request, Refused(400, sentence))
    return respond(request, find_refusal(exception))


def report_failure(request: HttpRequest) -> HttpResponse:
    """Answer a request on which qdot failed outside of a view."""
    report_failed("a request", sys.exception())
    return respond(request, Refused(500, FAILURE))


def report_forged_request(request: HttpRequest, **_: object) -> HttpResponse:
    """Answer a request without the token that proves that it comes from a page of the service."""
    return respond(request, Refused(403, "This page is out of date. Load it again, and repeat what you did."))
