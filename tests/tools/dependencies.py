"""Look up each library of docs/dependencies.md: its licence, size, version, and the date of its last release.

    python -m tests.tools.dependencies uv.lock

`uv lock` in a copy of pyproject.toml writes uv.lock, which has the time of each release; versions are the latest that
our bounds allow. Sizes and licences are those of the libraries that are installed here.
"""

import datetime
import platform
import re
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from tests.support import ROOT

PAGE = ROOT / "docs" / "dependencies.md"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LICENCES = {
    "BSD": "BSD-3-Clause",
    "BSD 3-Clause License": "BSD-3-Clause",
    "License agreement for matplotlib": "PSF-like",
}
"""What libraries say of their licence at length, as SPDX has it."""


def licence_of(name: str) -> str:
    """Return the licence of an installed library, by its metadata."""
    about = distribution(name).metadata
    said = next(iter(about.get_all("License-Expression", [])), "")
    classified = [line.split(" :: ")[-1] for line in about.get_all("Classifier", []) if line.startswith("License ::")]
    if said:
        return said if len(said) < 40 else said.split(" AND ")[0] + " and others"
    first = (next(iter(about.get_all("License", [])), "") or (classified or ["?"])[0]).split("\n")[0]
    named = next((spdx for begins, spdx in LICENCES.items() if first.startswith(begins)), first)
    return {"BSD License": "BSD-3-Clause", "MIT License": "MIT"}.get(named, named)


def bytes_of(name: str) -> int:
    """Return the size of an installed library."""
    found = distribution(name)
    files = (Path(str(found.locate_file(file))) for file in found.files or ())
    return sum(path.stat().st_size for path in files if path.is_file() and "__pycache__" not in path.parts)


def brought(name: str) -> set[str]:
    """Return a library with all that it brings along here."""
    waiting, known = [name], set[str]()
    while waiting:
        one = re.sub(r"[-_.]+", "-", waiting.pop()).lower()
        if one not in known:
            known.add(one)
            asked = (Requirement(line) for line in distribution(one).requires or ())
            waiting += [each.name for each in asked if each.marker is None or each.marker.evaluate({"extra": ""})]
    return known


def look_up(page: str, lock: Path) -> str:
    """Return the page with the columns that can be looked up, the date and the sum."""
    locked = {package["name"]: package for package in tomllib.loads(lock.read_text(encoding="utf-8"))["package"]}
    bases = [Requirement(line).name for line in PROJECT["dependencies"]]
    together = set().union(*map(brought, bases))
    date, python = datetime.datetime.now(datetime.UTC).date().isoformat(), platform.python_version()
    megabytes = round(sum(map(bytes_of, together)) / 1e6)
    page = re.sub(r"dates are as of \S+ \(Python [^)]*\)", f"dates are as of {date} (Python {python})", page)
    page = re.sub(r"\d+ libraries, \d+ MB", f"{len(together)} libraries, {megabytes} MB", page)

    def row(match: re.Match[str]) -> str:
        name, released = match[1], max(wheel["upload-time"] for wheel in locked[match[1]]["wheels"])
        size = f"{bytes_of(name) / 1e6:.1f}"
        return (
            f"| {name} | {match[2]} | {licence_of(name)} | {size} | {locked[name]['version']} | {str(released)[:10]} |"
        )

    return re.sub(r"(?m)^\| ([\w-]+) \| ([^|]+) \|(?: [^|]+ \|){3} 20\d\d-\d\d-\d\d \|$", row, page)


if __name__ == "__main__":
    try:
        text = look_up(PAGE.read_text(encoding="utf-8"), Path(sys.argv[1]))
    except (IndexError, OSError, PackageNotFoundError) as error:
        sys.exit(f"{error}\n{__doc__}")
    write_atomically(PAGE, text)
    say(f"wrote {PAGE.relative_to(ROOT)}")
