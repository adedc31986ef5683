"""Render the pages of the service."""

from typing import Any

from django.http import HttpRequest, HttpResponse
from django.middleware.csrf import get_token

from qdot.exercises.writing.render import render


def render_page(request: HttpRequest, template: str, *, title: str, script: str, **values: Any) -> HttpResponse:
    """Return a page from a template; `script` is the name of its script, "" for none."""
    return HttpResponse(render(template, title=title, script=script, csrf=get_token(request), **values))
