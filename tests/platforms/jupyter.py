"""A JupyterLab server, started from an environment in a folder on a free port."""

import os
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.error import URLError

from tests.support.running_service import find_free_port

TOKEN = "token-of-the-run"
PATIENCE = 120
"""Seconds that a server may take to start."""


def make_environment(software: Path, home: Path) -> dict[str, str]:
    """Return environment variables for programs of the Python environment `software`, with a separate home folder."""
    variables = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "QDOT", "JUPYTER"))
    }
    return {**variables, "PATH": f"{software / 'bin'}{os.pathsep}{variables['PATH']}", "HOME": str(home)}


@contextmanager
def serve_jupyterlab(software: Path, folder: Path, home: Path) -> Iterator[str]:
    """Yield the address of a JupyterLab that runs in a folder; requests need the token."""
    port = find_free_port()
    command: list[str | Path] = [
        software / "bin" / "jupyter-lab", "--no-browser", "--allow-root", f"--port={port}",
        f"--IdentityProvider.token={TOKEN}",
    ]  # fmt: skip
    with (home / "server.log").open("w") as log:
        process = subprocess.Popen(command, cwd=folder, env=make_environment(software, home), stdout=log, stderr=log)
        try:
            address = f"http://127.0.0.1:{port}"
            _wait_for_server(f"{address}/api")
            yield address
        finally:
            process.terminate()
            process.wait(60)


def fetch_page(address: str) -> str:
    request = urllib.request.Request(address, headers={"Authorization": f"token {TOKEN}"})
    with urllib.request.urlopen(request, timeout=120) as response:
        return str(response.read().decode())


def _wait_for_server(address: str) -> None:
    for _ in range(PATIENCE):
        try:
            fetch_page(address)
            return
        except (URLError, ConnectionError):
            time.sleep(1)
    raise RuntimeError(f"no server answers at {address}")
