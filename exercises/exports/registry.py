"""The outlets by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from exercises.exports.outlet import Outlet
from exercises.exports.paper import html_pages
from exercises.exports.prairielearn import course
from exercises.exports.stack import stack_questions

OUTLETS = {
    outlet.name: outlet
    for outlet in (
        Outlet("html", "Handouts as web pages", "any browser", "Chromium", "student", html_pages),
        Outlet("stack", "STACK questions in Moodle XML", "Moodle with STACK", "Maxima", "variant", stack_questions),
        Outlet(
            "prairielearn", "A course folder whose questions call qdot", "PrairieLearn", "Mustache, its JSON Schemas",
            "variant", course,
        ),
    )
}  # fmt: skip
"""Every outlet: one line each."""
