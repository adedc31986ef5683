"""Look up what docs/dependencies.md tells of each library: version, licence, size, and when it was last released.

    python -m tests.tools.dependencies uv.lock

`uv lock` in a copy of pyproject.toml writes uv.lock, which has the time of each release; versions are the latest that
our bounds allow. Sizes and licences are those of the libraries that are installed here.
"""

import datetime
import json
import platform
import re
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.docs.dependencies import DATA
from tests.support import ROOT

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


def look_up(lock: Path) -> dict[str, Any]:
    """Return all that is told."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    asked = [(Requirement(line).name, "") for line in project["dependencies"]]
    asked += [(Requirement(line).name, name) for name, lines in extras.items() for line in lines if name != "all"]
    locked = {one["name"]: one for one in tomllib.loads(lock.read_text(encoding="utf-8"))["package"]}
    libraries = {
        name: {
            "extra": extra, "version": locked[name]["version"], "licence": licence_of(name),
            "megabytes": f"{bytes_of(name) / 1e6:.1f}",
            "released": str(max(wheel["upload-time"] for wheel in locked[name]["wheels"]))[:10],
        }
        for name, extra in sorted(asked)
    }  # fmt: skip
    together = set().union(*(brought(name) for name, extra in asked if not extra))
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(), "python": platform.python_version(),
        "base": {"count": len(together), "megabytes": round(sum(map(bytes_of, together)) / 1e6)},
        "libraries": libraries,
    }  # fmt: skip


if __name__ == "__main__":
    try:
        content = look_up(Path(sys.argv[1]))
    except (IndexError, OSError, PackageNotFoundError) as error:
        sys.exit(f"{error}\n{__doc__}")
    write_atomically(DATA, json.dumps(content, indent=1) + "\n")
    say(f"wrote {DATA.relative_to(ROOT)}")
