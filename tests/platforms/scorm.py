"""SCORM packages under scorm-again, a run-time of both versions, in Chromium, each question answered wrong and right.

`software` is a copy of scorm-again, as `site/node_modules/scorm-again`; Node is on the path, and the site is built
(`make site/dist/.vite/manifest.json`). The run-time is told what a platform's is; no platform keeps it here.
"""

import json
import shutil
import subprocess
from pathlib import Path
from zipfile import ZipFile

from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.scorm import PACKAGE_NAMES
from tests.platforms.given import PLAIN, order
from tests.platforms.records import Counts, Record, today

SCRIPT = Path(__file__).with_name("scorm_page.mjs")


def run(software: Path, work: Path) -> Record:
    """Export a set that is ready-made, launch both packages, and answer each question of each."""
    counts, packages = Counts(), work / "packages"
    for file in EXPORT_FORMATS["scorm"].export(order(work / PLAIN, PLAIN, 1)):
        name = Path(file.path).stem.removeprefix(f"{PLAIN}-")
        archive = work / f"{name}.zip"
        archive.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
        with ZipFile(archive) as package:
            package.extractall(packages / name)
    command: list[str | Path] = [shutil.which("node") or "node", SCRIPT, software.absolute(), packages]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    for told in json.loads(done.stdout):
        version = told["version"]
        full = float(told["score"]["raw"]) == float(told["score"]["max"])
        counts.add("imported", told["status"] in ("completed", "passed") and full, f"{version}: {told['score']}")
        for one in told["questions"]:
            which = f"{version} {one['item']}"
            counts.add("shown", one["shown"], f"{which}: {one['errors']}")
            counts.add("right = full", one["right"] == "correct", f"{which}: {one['right']}")
            counts.add("wrong < full", one["wrong"] in ("wrong", "incorrect"), f"{which}: {one['wrong']}")
    assert {told["version"] for told in json.loads(done.stdout)} == set(PACKAGE_NAMES.values())
    package = json.loads((software / "package.json").read_text(encoding="utf-8"))
    return Record("scorm", f"scorm-again {package['version']}, in Chromium", today(), counts.told())
