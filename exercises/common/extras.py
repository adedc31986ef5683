"""Check that optional libraries (the extras of pyproject.toml) are installed, and write the command that installs them.

Code that uses an optional library calls `require_extra` first, so that users get the same message for every missing
library, before any work is done.
"""

from importlib.metadata import version
from importlib.util import find_spec

from qdot.exercises.common.errors import QdotError

DISTRIBUTION = "qdot-robotics"
"""The name of qdot in the package index, where `qdot` is another project; the import and the command are qdot."""
IS_RELEASED = False
"""Whether qdot is in the package index. If so, a test lists the lines of README and docs that must change."""
EXTRAS = {
    "pdf": ("typst",),
    "report": ("xlsxwriter",),
    "cluster": ("distributed",),
    "serve": ("django", "lti_tool", "django_tasks_db", "psycopg", "waitress", "whitenoise"),
}
"""Maps each extra of pyproject.toml to the import names of the libraries that it installs."""


def find_qdot_version() -> str:
    """Return the installed version of qdot."""
    return version(DISTRIBUTION)


def make_install_command(extra: str = "") -> str:
    """Return the command that installs qdot, with an extra unless it is "".

    >>> make_install_command("pdf") in ("pip install '.[pdf]'", "pip install 'qdot-robotics[pdf]'")
    True
    """
    package = f"{DISTRIBUTION if IS_RELEASED else '.'}{f'[{extra}]' if extra else ''}"
    argument = f"'{package}'" if extra else package
    return f"pip install {argument}"


def explain_missing(extra: str, feature: str) -> str:
    """Return the message that a feature needs libraries which are not installed; "" if nothing is missing."""
    missing_modules = [name for name in EXTRAS[extra] if find_spec(name) is None]
    if not missing_modules:
        return ""
    folder_hint = "" if IS_RELEASED else " (in the folder of qdot's source)"
    advice = f"install it with: {make_install_command(extra)}{folder_hint}"
    return f"{feature} needs {' and '.join(missing_modules)}, which is not installed; {advice}"


def require_extra(extra: str, feature: str) -> None:
    """Raise QdotError if `explain_missing` returns a message."""
    if message := explain_missing(extra, feature):
        raise QdotError(message)
