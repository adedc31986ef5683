"""How qdot is installed, in words, and which libraries come with it only if wanted: the extras of pyproject.toml.

Whatever needs one asks `need`, so that each that is missing is told in the same way, before any work is done.
"""

from importlib.metadata import version
from importlib.util import find_spec

from qdot.exercises.common.errors import QdotError

DISTRIBUTION = "qdot-robotics"
"""What qdot is called in the package index, where `qdot` is somebody else's; imported and run it is qdot."""
RELEASED = False
"""Whether the package index has qdot. A test then names the lines of README and docs to change."""


EXTRAS = {"pdf": ("typst",), "report": ("matplotlib", "xlsxwriter"), "cluster": ("distributed",)}
"""The extras of pyproject.toml, and the libraries that each installs, by the names under which they are imported."""


def qdot_version() -> str:
    """Return the version that is installed."""
    return version(DISTRIBUTION)


def install_words(extra: str = "") -> str:
    """Return the command that installs qdot, with an extra or without.

    >>> install_words("pdf") in ("pip install '.[pdf]'", "pip install 'qdot-robotics[pdf]'")
    True
    """
    what = f"{DISTRIBUTION if RELEASED else '.'}{f'[{extra}]' if extra else ''}"
    quoted = f"'{what}'" if extra else what
    return f"pip install {quoted}"


def explain_missing(extra: str, what: str, module: str = "") -> str:
    """Return what is said where `what` can't be had without an extra, or one library of it; nothing where it is."""
    missing = [name for name in EXTRAS[extra] if module in ("", name) and find_spec(name) is None]
    if not missing:
        return ""
    where = "" if RELEASED else " (in the folder of qdot's source)"
    words = f"get it with: {install_words(extra)}{where}"
    return f"{what} needs {' and '.join(missing)}, not installed here; {words}"


def need(extra: str, what: str, module: str = "") -> None:
    """Raise QdotError where an extra is not installed, or one library of it."""
    if message := explain_missing(extra, what, module):
        raise QdotError(message)
