"""Render the pages of the service. The site's script then shows their texts in the reader's language."""

from functools import cache

from django.conf import settings
from django.http import HttpRequest, HttpResponse
from django.middleware.csrf import get_token
from django.urls import get_script_prefix

from qdot.exercises.site.pages import Assets, find_assets
from qdot.exercises.writing.render import render
from qdot.grader.serve.frame_sessions import find_frame_session_key


@cache
def load_assets() -> Assets:
    """Return the site's scripts and styles, which WhiteNoise sends. Raises QdotError if they are not built."""
    return find_assets()


def render_page(request: HttpRequest, template: str, *, title: str, **values: object) -> HttpResponse:
    """Return a page from a template in templates/serve, which also gets `values`.

    - student, class: `person`, who is signed in
    - home: `advice` on how to get in, or `assignments` with `key`, `title` and `is_staff`
    - choose: what to add to a course; `action`, and `assignments` with `key`, `title`, `points` and `parts` (`name`,
      `title`, `points`). The form posts `choice`, KEY or KEY/PART.
    - refused: a `sentence`
    - launch: `state`, an address of the `platform`, and its `frame` for storage. At login, also the `url` that
      continues it, the `proof` to store, and the address `tab` for a new tab; later the `id_token`, which the form
      posts, too.
    """
    assets = load_assets()
    page = render(
        template, title=title, csrf_token=get_token(request), home=get_script_prefix(), static=settings.STATIC_URL,
        session=find_frame_session_key(request),
        script=assets.scripts["serve"], modules=assets.modules["serve"], styles=assets.styles["serve"], kind="",
        **values,
    )  # fmt: skip
    return HttpResponse(page)
