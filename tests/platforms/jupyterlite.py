"""Students' notebooks in JupyterLite, where Python runs in the browser and notebooks are saved in the browser.

`software` is an environment of Python with jupyterlite-core, jupyterlite-pyodide-kernel, jupyter-server and Playwright.
It contains `pyodide`, a distribution of Pyodide with the packages that its lock file names, and `wheels`, with other
packages that the kernel takes from PyPI: `python -m tests.platforms.pyodide` installs both, for JupyterLite 0.6. No
registry has Pyodide's NumPy for later versions. Chromium is on the path.
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

from tests.platforms.jupyter import make_environment
from tests.platforms.jupyterlab import check_notebook, run_in_browser, write_submissions
from tests.platforms.notebooks import KEY, QdotGrading, make_class_assignment
from tests.platforms.pyodide import find_missing_files
from tests.platforms.records import Counts, Record, today

KERNEL = "@jupyterlite/pyodide-kernel-extension:kernel"
SETTINGS = {"@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"}}
"""JupyterLite's display settings: a notebook is rendered whole, for the picture."""


def run(software: Path, work: Path) -> Record:
    """Open each student's notebook in the browser, run it, download it, and grade the downloaded file."""
    missing_files = find_missing_files(software / "pyodide")
    if missing_files:  # the kernel would wait for them silently
        raise RuntimeError(f"{software / 'pyodide'} lacks files that its lock file names: {', '.join(missing_files)}")
    assignment, counts = make_class_assignment(work / KEY), Counts()
    contents, downloads = work / "contents", work / "downloads"
    notebooks = write_submissions(assignment, contents)
    for name in notebooks:
        (downloads / name).parent.mkdir(parents=True)
    (software / "pictures").mkdir(exist_ok=True)
    with serve_folder(_build_site(software, contents, work)) as address:
        page = f"{address}/lab/index.html?path={{name}}"
        displayed = run_in_browser(software, work, page, str(downloads), notebooks)
    for name, cells in zip(notebooks, displayed, strict=True):
        check_notebook(QdotGrading(assignment, name.split("/")[0], downloads / name), cells, counts)
    return Record("generate", f"{_describe_versions(software)}, in Chromium", today(), counts.freeze())


def _describe_versions(software: Path) -> str:
    done = subprocess.run([software / "bin" / "jupyter-lite", "--version"], capture_output=True, text=True)
    lock = json.loads((software / "pyodide" / "pyodide-lock.json").read_text(encoding="utf-8"))
    sympy, numpy = (lock["packages"][name]["version"] for name in ("sympy", "numpy"))
    python = f"Pyodide's Python {lock['info']['python']}"
    return f"JupyterLite {done.stdout.strip()} with {python}, SymPy {sympy} and NumPy {numpy}"


def _build_site(software: Path, contents: Path, work: Path) -> Path:
    """Build a JupyterLite site that needs no files from elsewhere; return its folder."""
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
        cwd=source, env=make_environment(software, work), check=True, capture_output=True,
    )  # fmt: skip
    shutil.copytree(software / "pyodide", site / "pyodide")
    return site


class _QuietHandler(SimpleHTTPRequestHandler):
    extensions_map = {  # noqa: RUF012 - as the base class declares it
        **SimpleHTTPRequestHandler.extensions_map, ".mjs": "text/javascript", ".wasm": "application/wasm"
    }  # fmt: skip

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def serve_folder(folder: Path) -> Iterator[str]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_QuietHandler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
