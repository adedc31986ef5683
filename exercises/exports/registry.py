"""The outlets by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from exercises.exports.outlet import Outlet
from exercises.exports.paper import html, latex, pdf

OUTLETS = {
    outlet.name: outlet
    for outlet in (
        Outlet("html", "Handouts, exams and keys as web pages", "any browser", "Chromium, html5lib", "student", html),
        Outlet("pdf", "Handouts, exams and keys as PDF/UA-1, also one for the whole class", "any reader of PDF",
               "Poppler", "student", pdf),
        Outlet("latex", "Handouts, exams and keys as LaTeX source", "LaTeX with TikZ", "our reader of LaTeX", "student",
               latex),
    )
}  # fmt: skip
"""Every outlet: one line each."""
