"""`make platforms`: our exports in the programs that they are for, each from a copy of its software on this machine.

`MOODLE=/path make platforms` imports our exports with Moodle's own importer, shows and answers every question with its
engine, and compares points and feedback with ours. It is not part of `make test`: the person who runs it finds or
fetches a copy of the program. Each run is recorded beside its script; docs/export-formats.md has a table of the
records. What a run teaches becomes a check of `make test`, against data of ours.

    given       the assignments that are exported, the answers that are given, and what qdot gives for them
    notebooks   a class that submits notebooks, and what qdot gives for them
    repositories    a class that pushes to GitHub and GitLab
    records     what a run showed, as it is kept
    pictures/   the pictures of docs/, taken by a browser that clicks what the docs say
    pyodide     the Python of JupyterLite's browser, put together from registries
    __main__    the command

`make platforms` installs what the registries of Python, Node and Debian have (`INSTALLED`), and runs it without being
told a path; the others are left out unless their path is named. Of one that can't be run that is said, and the next one
is run.

A platform is a module with `run(software, work) -> Record`, its line in `PLATFORMS`, and its record in `NAME.json`:
`software` is the path of the copy, `work` an empty folder to install and to export into.
"""

PLATFORMS: dict[str, str] = {
    "moodle": "MOODLE", "canvas": "QTI_MIGRATION", "qti": "QTI_SDK", "github": "GITHUB_RUNNER",
    "gitlab": "GITLAB_RUNNER", "otter": "OTTER", "nbgrader": "NBGRADER", "gradescope": "GRADESCOPE_ROOT",
    "jupyterlab": "JUPYTERLAB", "scorm": "SCORM_AGAIN", "jupyterlite": "JUPYTERLITE",
    "moodle_scorm": "MOODLE", "stack": "STACK", "prairielearn": "PRAIRIELEARN",
}  # fmt: skip
"""Modules of this package by name, each with the variable of the environment that holds the path of its software.

The dearest are last.
"""
INSTALLED: dict[str, str] = {
    "GITLAB_RUNNER": ".venvs/platforms/node_modules/.bin/gitlab-ci-local", "OTTER": ".venvs/platforms/otter",
    "NBGRADER": ".venvs/platforms/nbgrader", "GRADESCOPE_ROOT": ".venvs/platforms/debian",
    "JUPYTERLAB": ".venvs/platforms/jupyterlab", "SCORM_AGAIN": "site/node_modules/scorm-again",
    "JUPYTERLITE": ".venvs/platforms/jupyterlite",
}  # fmt: skip
"""The folders in which the Makefile installs software, by the variable that can name another copy."""
