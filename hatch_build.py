"""Build the site's scripts before a wheel or a source distribution is packed, if Node is installed.

Hatchling runs this hook. Without Node the package is complete except for these scripts, which SCORM packages and
`qdot site build` need; these two commands then say how to get them.
"""

import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = (
    "site/src",
    "site/package.json",
    "site/package-lock.json",
    "site/vite.config.ts",
    "exercises/formula/vocabulary.json",
)
"""The files and folders from which the scripts are built."""
MANIFEST = "site/dist/.vite/manifest.json"
"""The list of the built scripts, which Vite writes last."""
COMMANDS = (("ci", "--no-audit", "--no-fund"), ("run", "--silent", "bundle"))
"""The commands of npm that build the scripts, in the folder site/."""
SHOWN_LINES = 5
"""The number of lines to show of what npm wrote before it failed."""


class SiteScriptsHook(BuildHookInterface):
    """Builds the scripts, unless they are newer than their sources. If that fails, the package has no scripts."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the scripts; an editable install reads those of its checkout, which `make site` builds."""
        root = Path(self.root)
        if version == "editable" or not (root / "site" / "package.json").is_file() or has_current_scripts(root):
            return
        npm = shutil.which("npm")
        if npm is None:
            self.app.display_warning(
                "Node and npm are not installed, so this package has no scripts for SCORM packages"
            )
            return
        for arguments in COMMANDS:
            process = subprocess.run(
                [npm, *arguments], cwd=root / "site", capture_output=True, encoding="utf-8", errors="replace"
            )
            if process.returncode:
                last_lines = "\n".join((process.stdout + process.stderr).strip().splitlines()[-SHOWN_LINES:])
                self.app.display_warning(f"the site's scripts were not built: npm {' '.join(arguments)}: {last_lines}")
                return


def has_current_scripts(root: Path) -> bool:
    """Return whether the scripts are built, and no source is newer."""
    if not (root / MANIFEST).is_file():
        return False
    built_time = (root / MANIFEST).stat().st_mtime
    files = (file for source in SOURCES for file in (root / source, *(root / source).rglob("*")) if file.is_file())
    return all(file.stat().st_mtime <= built_time for file in files)
