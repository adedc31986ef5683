"""`make platforms`: test our exports in the programs that import them, with copies installed on this machine.

`MOODLE=/path make platforms` imports our exports with Moodle's own importer, shows and answers every question with its
engine, and compares points and feedback with ours. It is not part of `make test`, because you have to find or
download the program yourself. Each run is recorded beside its script; docs/export-formats.md has a table of the
records. When a run reveals a problem, a check of our own data is added to `make test`.

    assignments     the assignments that are exported
    notebooks       a class that submits notebooks, and the marks that qdot gives them
    repositories    a class that pushes to GitHub and GitLab
    records         the results of a run, and how they are stored
    pictures        the README's pictures of a feedback page and the site, taken in a browser
    __main__        the command

`make platforms` installs the programs that are in the registries of Python, Node and Debian (`INSTALLED`), and needs no
path for them. The others are skipped unless an environment variable names their path. A program that fails to run
is reported, and the next one runs.

A platform is a module with `run(software, work) -> Record`, its line in `PLATFORMS`, and its record in `NAME.json`:
`software` is the path of the copy, `work` an empty folder to install and to export into.
"""

PLATFORMS: dict[str, str] = {
    "moodle": "MOODLE", "canvas": "QTI_MIGRATION", "new_quizzes": "QTI_GEM", "qti": "QTI_SDK",
    "github": "GITHUB_RUNNER",
    "gitlab": "GITLAB_RUNNER", "otter": "OTTER", "nbgrader": "NBGRADER", "gradescope": "GRADESCOPE_ROOT",
    "jupyterlab": "JUPYTERLAB", "scorm": "SCORM_AGAIN",
    "moodle_cartridge": "MOODLE", "moodle_scorm": "MOODLE", "moodle_lti": "MOODLE", "stack": "STACK",
    "prairielearn": "PRAIRIELEARN",
}  # fmt: skip
"""Modules of this package by name, each with the environment variable that holds the path of its software.

The slowest come last.
"""
INSTALLED: dict[str, str] = {
    "GITLAB_RUNNER": ".venvs/platforms/node_modules/.bin/gitlab-ci-local", "OTTER": ".venvs/platforms/otter",
    "NBGRADER": ".venvs/platforms/nbgrader", "GRADESCOPE_ROOT": ".venvs/platforms/debian",
    "JUPYTERLAB": ".venvs/platforms/jupyterlab", "SCORM_AGAIN": "site/node_modules/scorm-again",
}  # fmt: skip
"""Where the Makefile installs software in the repository, by the variable that selects another copy."""
