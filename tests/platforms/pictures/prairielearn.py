"""PrairieLearn's question server, whose panels are shown with its own styles and MathJax in a frame of ours.

`PRAIRIELEARN` is a checkout as the module prairielearn beside this package needs it.
"""

import re
from pathlib import Path
from typing import Any

from playwright.sync_api import Route  # type: ignore[import-not-found, unused-ignore]

from exercises.exports.bank import bank
from exercises.exports.prairielearn import question_id
from tests.platforms.pictures.album import Album, browser, opened
from tests.platforms.pictures.given import KEY, assignment, exported, order
from tests.platforms.prairielearn import APP, Server
from tests.support.elements import filled

ADDRESS = "http://prairielearn.test/"
ASSET = re.compile(r"/assets/(node_modules|elements)/[0-9a-f]+/(.*)")
PAGE = """<!doctype html><meta charset="utf-8">
<link href="/assets/node_modules/0/bootstrap/dist/css/bootstrap.min.css" rel="stylesheet">
<link href="/assets/node_modules/0/@fortawesome/fontawesome-free/css/all.min.css" rel="stylesheet">
<link href="/assets/node_modules/0/bootstrap-icons/font/bootstrap-icons.css" rel="stylesheet">
<script src="/assets/node_modules/0/bootstrap/dist/js/bootstrap.bundle.min.js"></script>
{headers}
<script src="/assets/node_modules/0/mathjax/tex-svg.js"></script>
<main class="p-2"><div class="card mb-3"><div class="card-body" id="question">{question}</div></div>
<div class="card"><div class="card-body" id="submission">{submission}</div></div></main>
"""


def questions(software: Path, work: Path) -> None:
    """Take the pictures of a question's panel, and of a submission's whose determinant has another sign."""
    made = assignment(work / KEY)
    course = exported(made, "prairielearn", work / "course")
    variant = next(iter(bank(order(made))))
    qid = question_id(made, variant.slot)
    server = Server(software, course)

    def make(what: str, **told: Any) -> Any:
        answer, issues = server.make(qid, what, **told)
        assert not issues, issues
        return answer

    asked = make("variant")
    form: dict[str, Any] = {}
    for part in variant.problem.parts:
        text = part.answer.as_typed()
        form |= filled(part, f"-({text})" if part.name == "determinant" else text, asked["params"])
    pages = make("pages", variant=asked, submission=None)
    submission = make("submission", variant=asked, form=form)
    (told,) = make("pages", variant=asked, submission=submission)["submissionHtmls"]
    server.close()
    page_text = PAGE.format(headers=pages["extraHeadersHtml"], question=pages["questionHtml"], submission=told)

    def served(route: Route) -> None:
        asset = ASSET.search(route.request.url)
        if asset is None:
            route.fulfill(body=page_text, content_type="text/html")
        else:
            route.fulfill(path=software / APP / asset[1] / asset[2])

    album = Album("prairielearn")
    with browser() as chromium:
        page = opened(chromium)
        page.route(f"{ADDRESS}**", served)
        page.goto(ADDRESS)
        page.locator("mjx-container").first.wait_for()
        page.wait_for_timeout(3000)
        album.take("question", page, page.locator("#question"), tallest=800)
        album.take("submission", page, page.locator("#submission"), tallest=600)
