"""The outlets by name: `qdot export DIR --to NAME`, and the table of docs/outlets.md."""

from exercises.exports.gradescope import gradescope
from exercises.exports.outlet import Outlet
from exercises.exports.paper import html_pages
from exercises.exports.repositories import github, gitlab

OUTLETS = {
    outlet.name: outlet
    for outlet in (
        Outlet("html", "Handouts as web pages", "any browser", "Chromium", "student", html_pages),
        Outlet("github", "Repositories: one that grades, one for each student", "GitHub Actions",
               "GitHub's workflow schema; bash and git, in fresh clones", "student", github),
        Outlet("gradescope", "An autograder's zip, and notebooks", "Gradescope",
               "a harness with Gradescope's folders, which runs its two scripts", "student", gradescope),
        Outlet("gitlab", "Projects: one that grades, one for each student", "GitLab CI",
               "GitLab's CI schema; bash and git, in fresh clones", "student", gitlab),
    )
}  # fmt: skip
"""Every outlet: one line each."""
