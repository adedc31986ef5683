"""The outlets by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from exercises.exports.outlet import Outlet
from exercises.exports.paper import html_pages

OUTLETS = {
    outlet.name: outlet
    for outlet in (
        Outlet("html", "Handouts as web pages", "any browser", "Chromium", "student", html_pages),
    )
}  # fmt: skip
"""Every outlet: one line each."""
