"""Students' notebooks in JupyterLite, where Python runs in the browser and no server keeps what is saved.

`software` is an environment of Python with jupyterlite-core, jupyterlite-pyodide-kernel, jupyter-server and Playwright.
In it are `pyodide`, a distribution of Pyodide with the packages that its lock file names, and `wheels`, with what the
kernel takes from PyPI besides: `python -m tests.platforms.pyodide` puts both there, for JupyterLite 0.6. For later
ones no registry has Pyodide's own NumPy. Chromium is on the path.
"""

import json
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from tests.platforms.jupyter import variables
from tests.platforms.jupyterlab import hold, watched
from tests.platforms.notebooks import BLANK, KEY, MISTAKEN, RIGHT, WRONG, Ours, a_class, answered
from tests.platforms.pyodide import missing
from tests.platforms.records import Counts, Record, today
from tests.support.command import run as qdot

KERNEL = "@jupyterlite/pyodide-kernel-extension:kernel"
SETTINGS = {"@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"}}
"""The settings for showing a whole notebook at once, for the picture."""


def run(software: Path, work: Path) -> Record:
    """Open everybody's notebook in the browser, run it, download it, and grade what was downloaded."""
    lacking = missing(software / "pyodide")
    if lacking:  # the kernel would wait for them without a word
        raise RuntimeError(f"{software / 'pyodide'} is short of what its lock file names: {', '.join(lacking)}")
    assignment, counts = a_class(work / KEY, RIGHT, WRONG, MISTAKEN, BLANK), Counts()
    qdot("generate", assignment.folder)
    students = [one.id for one in assignment.roster]
    contents, saved = work / "contents", work / "saved"
    for student in students:
        text = (assignment.folder / "released" / student / f"{KEY}.ipynb").read_text(encoding="utf-8")
        for folder in (contents / student, saved / student):
            folder.mkdir(parents=True)
        (contents / student / f"{KEY}.ipynb").write_text(answered(assignment, student, text), encoding="utf-8")
    (software / "pictures").mkdir(exist_ok=True)
    with served(_site(software, contents, work)) as address:
        page = f"{address}/lab/index.html?path={{name}}"
        told = watched(software, work, page, str(saved), [f"{student}/{KEY}.ipynb" for student in students])
    for student, shown in zip(students, told, strict=True):
        hold(Ours(assignment, student, saved / student / f"{KEY}.ipynb"), shown, counts)
    return Record("generate", f"{_versions(software)}, in Chromium", today(), counts.told())


def _versions(software: Path) -> str:
    done = subprocess.run([software / "bin" / "jupyter-lite", "--version"], capture_output=True, text=True)
    lock = json.loads((software / "pyodide" / "pyodide-lock.json").read_text(encoding="utf-8"))
    sympy, numpy = (lock["packages"][name]["version"] for name in ("sympy", "numpy"))
    python = f"Pyodide's Python {lock['info']['python']}"
    return f"JupyterLite {done.stdout.strip()} with {python}, SymPy {sympy} and NumPy {numpy}"


def _site(software: Path, contents: Path, work: Path) -> Path:
    """Build the site with all files that JupyterLite needs."""
    kernel: dict[str, Any] = {"pyodideUrl": "./pyodide/pyodide.js", "disablePyPIFallback": True}
    config = {"litePluginSettings": {KERNEL: kernel}}
    source, site = work / "lite", work / "site"
    source.mkdir()
    about = {"jupyter-lite-schema-version": 0, "jupyter-config-data": config}
    (source / "jupyter-lite.json").write_text(json.dumps(about), encoding="utf-8")
    (source / "overrides.json").write_text(json.dumps(SETTINGS), encoding="utf-8")
    wheels = [word for wheel in (software / "wheels").glob("*.whl") for word in ("--piplite-wheels", str(wheel))]
    subprocess.run(
        [
            software / "bin" / "jupyter-lite", "build", "--lite-dir", source, "--contents", contents,
            "--output-dir", site, *wheels,
        ],
        cwd=source, env=variables(software, work), check=True, capture_output=True,
    )  # fmt: skip
    shutil.copytree(software / "pyodide", site / "pyodide")
    return site


class _Quiet(SimpleHTTPRequestHandler):
    extensions_map = {  # noqa: RUF012 - the library's way
        **SimpleHTTPRequestHandler.extensions_map, ".mjs": "text/javascript", ".wasm": "application/wasm"
    }  # fmt: skip

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Yield the address under which a folder's files are given, and nothing else."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
