"""The HTML pages: their English is that of the site's texts, and names from outside are escaped."""

import html
import json
import re

import pytest
from django.test import RequestFactory

from qdot.exercises.writing.render import find_template_folder
from qdot.grader.serve import html_pages
from tests.support import ROOT
from tests.support.serving import ASSETS

TEXTS = json.loads((ROOT / "site" / "src" / "text" / "en.json").read_text(encoding="utf-8"))
HOSTILE = "<b>\"Week\" & 'one'</b>"


@pytest.mark.parametrize("name", sorted(path.name for path in (find_template_folder() / "serve").glob("*.j2")))
def test_texts_without_javascript_are_those_that_the_script_shows(name: str) -> None:
    template = (find_template_folder() / "serve" / name).read_text(encoding="utf-8")
    for key, text in re.findall(r'data-text="([^"]+)"[^>]*>([^<]*)<', template):
        shown = text.replace('{{ "%g" % assignment.points }}', "{points}").replace(
            '{{ "%g" % part.points }}', "{points}"
        )
        assert TEXTS[key] == shown or shown.startswith("{{ advice"), key


def test_the_choice_for_a_course_escapes_titles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html_pages, "load_assets", lambda: ASSETS)
    part = {"name": "p1.jacobian", "title": HOSTILE, "points": 2.5}
    assignment = {"key": "week-1", "title": HOSTILE, "points": 4.0, "parts": [part]}
    request = RequestFactory().get("/lti/choose")
    page = html_pages.render_page(
        request, "serve/choose.html.j2", title=HOSTILE, action="/lti/choose", assignments=[assignment]
    ).content.decode()  # fmt: skip
    assert "<b>" not in page and page.count("&lt;b&gt;") == 3
    assert re.findall(r'name="choice" value="([^"]*)"', page) == ["week-1", "week-1/p1.jacobian"]
    values = [json.loads(html.unescape(text)) for text in re.findall(r"data-values='([^']*)'", page)]
    assert values == [{"points": 4.0}, {"points": 2.5}]
    (token,) = re.findall(r'name="csrf" content="(\w+)"', page)
    assert f'name="csrfmiddlewaretoken" value="{token}"' in page
