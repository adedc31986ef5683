"""qdot as a wheel, and the versions of its libraries, for machines that can't install it from a package index.

The wheel is made from the installed files according to the format (packaging.python.org); the same files give the same
bytes. It contains no assignment, and nothing that reveals answers.
"""

import base64
import contextlib
import hashlib
import io
import re
import zipfile
from collections.abc import Iterable
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from qdot.exercises.common.extras import DISTRIBUTION
from qdot.exercises.writing.render import template_folder

PACKAGE = Path(__file__).parents[2]
"""The package; in a checkout, `exercises` and `grader` are links in it."""
DATE = (1980, 1, 1, 0, 0, 0)
"""The date of every file in an archive: the earliest possible one in a zip."""


def zip_files(files: Iterable[tuple[str, bytes, int]]) -> bytes:
    """Return a zip archive of files (name, content, permissions), in this order; its bytes depend on nothing else."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content, mode in files:
            about = zipfile.ZipInfo(name, DATE)
            about.compress_type, about.create_system = zipfile.ZIP_DEFLATED, 3
            about.external_attr = (0o100000 | mode) << 16
            archive.writestr(about, content)
    return out.getvalue()


@cache
def wheel() -> tuple[str, bytes]:
    """Return the wheel's file name and content."""
    installed = distribution(DISTRIBUTION)
    name = f"{DISTRIBUTION.replace('-', '_')}-{installed.version}"
    about = f"{name}.dist-info"
    files = [
        *_modules(),
        (f"{about}/METADATA", (installed.read_text("METADATA") or "").encode()),
        (f"{about}/WHEEL", b"Wheel-Version: 1.0\nGenerator: qdot\nRoot-Is-Purelib: true\nTag: py3-none-any\n"),
        (f"{about}/entry_points.txt", (installed.read_text("entry_points.txt") or "").encode()),
    ]
    record = "".join(f"{name},sha256={_digest(data)},{len(data)}\n" for name, data in files)
    files.append((f"{about}/RECORD", f"{record}{about}/RECORD,,\n".encode()))
    return f"{name}-py3-none-any.whl", zip_files((name, data, 0o644) for name, data in files)


def _modules() -> list[tuple[str, bytes]]:
    """Return the files of the package; the templates are inside `exercises`, as in a wheel."""
    folders = [(f"qdot/{name}", (PACKAGE / name).resolve()) for name in ("exercises", "grader")]
    names = {path: f"{name}/{path.relative_to(root).as_posix()}" for name, root in folders for path in root.rglob("*")}
    names |= {path: f"qdot/{path.name}" for path in PACKAGE.glob("*") if path.is_file()}
    templates = template_folder()
    for path in templates.rglob("*"):
        names[path] = f"qdot/exercises/templates/{path.relative_to(templates).as_posix()}"
    files = {name: path for path, name in names.items() if path.is_file() and not _is_made(path)}
    return [(name, files[name].read_bytes()) for name in sorted(files)]


def _is_made(path: Path) -> bool:
    return "__pycache__" in path.parts or path.name.startswith(".")


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def versions() -> str:
    """Return the versions of the libraries installed here, one per line, as a constraints file for pip."""
    pinned: dict[str, str] = {}
    waiting = [distribution(DISTRIBUTION)]
    while waiting:
        for needed in _needed_by(waiting.pop()):
            if needed.name.lower() not in pinned:
                pinned[needed.name.lower()] = f"{needed.name}=={needed.version}"
                waiting.append(needed)
    return "".join(f"{pinned[name]}\n" for name in sorted(pinned))


def _needed_by(package: Distribution) -> list[Distribution]:
    """Return the installed dependencies of a package, without those of its extras."""
    needed = []
    for line in package.requires or ():
        name, _, marker = line.partition(";")
        if "extra" not in marker:
            with contextlib.suppress(PackageNotFoundError):  # another system's
                needed.append(distribution(re.split(r"[^A-Za-z0-9._-]", name, maxsplit=1)[0]))
    return needed
