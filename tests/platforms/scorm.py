"""SCORM packages in scorm-again, a run-time of both versions, in Chromium: each question is answered wrong and right.

`software` is a copy of scorm-again, such as `site/node_modules/scorm-again`; Node is on the path, and the site is built
(`make site/dist/.vite/manifest.json`). The run-time gets the calls that it gets on a platform, but stores nothing.
"""

import json
import shutil
import subprocess
from pathlib import Path
from zipfile import ZipFile

from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.scorm import PACKAGE_NAMES
from tests.platforms.assignments import PLAIN, make_request, write_files
from tests.platforms.records import Counts, Record, today

SCRIPT = Path(__file__).with_name("scorm_page.mjs")


def run(software: Path, work: Path) -> Record:
    """Export a ready-made set, launch both packages, and answer all their questions."""
    counts, packages = Counts(), work / "packages"
    exported_files = EXPORT_FORMATS["scorm"].export(make_request(work / PLAIN, PLAIN, 1))
    for archive in write_files(exported_files, work / "exported"):
        with ZipFile(archive) as package:
            package.extractall(packages / archive.stem.removeprefix(f"{PLAIN}-"))
    command: list[str | Path] = [shutil.which("node") or "node", SCRIPT, software.absolute(), packages]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    results = json.loads(done.stdout)
    for result in results:
        version = result["version"]
        full = float(result["score"]["raw"]) == float(result["score"]["max"])
        counts.add("imported", result["status"] in ("completed", "passed") and full, f"{version}: {result['score']}")
        for question in result["questions"]:
            details = f"{version} {question['item']}"
            counts.add("shown", question["shown"], f"{details}: {question['errors']}")
            counts.add("right = full", question["right"] == "correct", f"{details}: {question['right']}")
            counts.add("wrong < full", question["wrong"] in ("wrong", "incorrect"), f"{details}: {question['wrong']}")
    assert {result["version"] for result in results} == set(PACKAGE_NAMES.values())
    package = json.loads((software / "package.json").read_text(encoding="utf-8"))
    return Record("scorm", f"scorm-again {package['version']}, in Chromium", today(), counts.freeze())
