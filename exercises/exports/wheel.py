"""Make a wheel (a Python package) of qdot and list the versions of its libraries, for machines that grade.

The wheel is made from the installed files, in the format of packaging.python.org; the same files give the same bytes.
The wheel contains no assignment and reveals no answers.
"""

import base64
import contextlib
import hashlib
import re
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import NamedTuple

from qdot.exercises.common.extras import DISTRIBUTION
from qdot.exercises.common.files import make_zip
from qdot.exercises.writing.render import find_template_folder

PACKAGE_FOLDER = Path(__file__).parents[2]
"""The folder of the package qdot. In a checkout, its entries `exercises` and `grader` are links."""


class Wheel(NamedTuple):
    """A wheel: its file name and content."""

    file_name: str
    content: bytes


@cache
def make_wheel() -> Wheel:
    """Return the wheel of the installed qdot."""
    qdot_distribution = distribution(DISTRIBUTION)
    name = f"{DISTRIBUTION.replace('-', '_')}-{qdot_distribution.version}"
    info_folder = f"{name}.dist-info"
    files = _read_package_files() | {
        f"{info_folder}/METADATA": (qdot_distribution.read_text("METADATA") or "").encode(),
        f"{info_folder}/WHEEL": b"Wheel-Version: 1.0\nGenerator: qdot\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info_folder}/entry_points.txt": (qdot_distribution.read_text("entry_points.txt") or "").encode(),
    }
    record = ""
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(data)}\n"
    files[f"{info_folder}/RECORD"] = f"{record}{info_folder}/RECORD,,\n".encode()
    return Wheel(f"{name}-py3-none-any.whl", make_zip(files))


def _read_package_files() -> dict[str, bytes]:
    """Return the files of the package; the templates are inside `exercises`, as in a wheel."""
    folders = [(f"qdot/{name}", (PACKAGE_FOLDER / name).resolve()) for name in ("exercises", "grader")]
    name_by_path = {
        path: f"{name}/{path.relative_to(root).as_posix()}" for name, root in folders for path in root.rglob("*")
    }
    name_by_path |= {path: f"qdot/{path.name}" for path in PACKAGE_FOLDER.glob("*") if path.is_file()}
    templates = find_template_folder()
    for path in templates.rglob("*"):
        name_by_path[path] = f"qdot/exercises/templates/{path.relative_to(templates).as_posix()}"
    paths = [path for path in name_by_path if path.is_file() and "__pycache__" not in path.parts]
    path_by_name = {name_by_path[path]: path for path in paths if not path.name.startswith(".")}
    return {name: path.read_bytes() for name, path in sorted(path_by_name.items())}


def write_versions() -> str:
    """Return the versions of the libraries installed here, one per line, as a constraints file for pip."""
    pinned_versions: dict[str, str] = {}
    unvisited_distributions = [distribution(DISTRIBUTION)]
    while unvisited_distributions:
        for dependency in _find_dependencies(unvisited_distributions.pop()):
            if dependency.name.lower() not in pinned_versions:
                pinned_versions[dependency.name.lower()] = f"{dependency.name}=={dependency.version}"
                unvisited_distributions.append(dependency)
    return "".join(f"{pinned_versions[name]}\n" for name in sorted(pinned_versions))


def _find_dependencies(package: Distribution) -> list[Distribution]:
    """Return the installed dependencies of a package, without the dependencies of its extras."""
    dependencies = []
    for line in package.requires or ():
        name, _, marker = line.partition(";")
        if "extra" not in marker:
            with contextlib.suppress(PackageNotFoundError):  # the dependency is for another operating system
                dependencies.append(distribution(re.split(r"[^A-Za-z0-9._-]", name, maxsplit=1)[0]))
    return dependencies
