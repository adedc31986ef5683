"""The outlets by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from exercises.exports.canvas import canvas_zip
from exercises.exports.moodle import moodle_xml
from exercises.exports.outlet import Outlet
from exercises.exports.paper import html_pages

OUTLETS = {
    outlet.name: outlet
    for outlet in (
        Outlet("html", "Handouts as web pages", "any browser", "Chromium", "student", html_pages),
        Outlet("moodle", "A question bank as Moodle XML", "Moodle 4", "our checks of its rules", "variant", moodle_xml),
        Outlet("canvas", "A quiz as QTI 1.2", "Canvas", "our checks of its rules", "variant", canvas_zip),
    )
}  # fmt: skip
"""Every outlet: one line each."""
