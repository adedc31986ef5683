"""Update docs/dependencies.md: the licence, size and last release of each library.

    python -m tests.tools.dependencies uv.lock

`uv lock`, run beside a copy of pyproject.toml, writes uv.lock with the latest versions within our bounds. Sizes and
licences are those of the installed libraries.
"""

import datetime
import platform
import re
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

from qdot.exercises.common.console import print_result
from qdot.exercises.common.files import write_atomically
from tests.support import ROOT

PAGE = ROOT / "docs" / "dependencies.md"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LICENCES = {
    "BSD": "BSD-3-Clause",
    "BSD 3-Clause License": "BSD-3-Clause",
    "License agreement for matplotlib": "PSF-like",
}
"""SPDX names of licences for which libraries give a longer description."""


def find_licence(name: str) -> str:
    metadata = distribution(name).metadata
    expression = next(iter(metadata.get_all("License-Expression", [])), "")
    classified = [
        line.split(" :: ")[-1] for line in metadata.get_all("Classifier", []) if line.startswith("License ::")
    ]
    if expression:
        return expression if len(expression) < 40 else expression.split(" AND ")[0] + " and others"
    first = (next(iter(metadata.get_all("License", [])), "") or (classified or ["?"])[0]).split("\n")[0]
    spdx_name = next((spdx for begins, spdx in LICENCES.items() if first.startswith(begins)), first)
    return {"BSD License": "BSD-3-Clause", "MIT License": "MIT"}.get(spdx_name, spdx_name)


def measure_size(name: str) -> int:
    package = distribution(name)
    files = (Path(str(package.locate_file(file))) for file in package.files or ())
    return sum(path.stat().st_size for path in files if path.is_file() and "__pycache__" not in path.parts)


def find_requirements(name: str) -> set[str]:
    waiting, found_libraries = [name], set[str]()
    while waiting:
        library = re.sub(r"[-_.]+", "-", waiting.pop()).lower()
        if library not in found_libraries:
            found_libraries.add(library)
            requirements = (Requirement(line) for line in distribution(library).requires or ())
            waiting += [
                requirement.name
                for requirement in requirements
                if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
            ]
    return found_libraries


def look_up(page: str, lock: Path) -> str:
    """Return the page with updated columns, date and totals."""
    locked = {package["name"]: package for package in tomllib.loads(lock.read_text(encoding="utf-8"))["package"]}
    bases = [Requirement(line).name for line in PROJECT["dependencies"]]
    together = set().union(*map(find_requirements, bases))
    date, python = datetime.datetime.now(datetime.UTC).date().isoformat(), platform.python_version()
    megabytes = round(sum(map(measure_size, together)) / 1e6)
    page = re.sub(r"dates are as of \S+ \(Python [^)]*\)", f"dates are as of {date} (Python {python})", page)
    page = re.sub(r"\d+ libraries, \d+ MB", f"{len(together)} libraries, {megabytes} MB", page)

    def row(match: re.Match[str]) -> str:
        name, released = match[1], max(wheel["upload-time"] for wheel in locked[match[1]]["wheels"])
        size = f"{measure_size(name) / 1e6:.1f}"
        cells = (name, match[2], find_licence(name), size, str(released)[:10])
        return f"| {' | '.join(cells)} |"

    return re.sub(r"(?m)^\| ([\w-]+) \| ([^|]+) \|(?: [^|]+ \|){2} 20\d\d-\d\d-\d\d \|$", row, page)


if __name__ == "__main__":
    try:
        text = look_up(PAGE.read_text(encoding="utf-8"), Path(sys.argv[1]))
    except (IndexError, OSError, PackageNotFoundError) as error:
        sys.exit(f"{error}\n{__doc__}")
    write_atomically(PAGE, text)
    print_result(f"wrote {PAGE.relative_to(ROOT)}")
