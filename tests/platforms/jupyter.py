"""Jupyter's server as a run starts it: a program of an environment, in a folder, on a port that is free."""

import os
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.error import URLError

TOKEN = "token-of-the-run"
PATIENCE = 120
"""Seconds that a server may take to start."""


def variables(software: Path, home: Path) -> dict[str, str]:
    """Return the variables of the environment `software`, with a home folder of its own."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "QDOT", "JUPYTER"))}
    return {**own, "PATH": f"{software / 'bin'}{os.pathsep}{own['PATH']}", "HOME": str(home)}


@contextmanager
def jupyter(software: Path, folder: Path, home: Path) -> Iterator[str]:
    """Yield the address of a JupyterLab that runs in a folder; its pages are asked for with the token."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command: list[str | Path] = [
        software / "bin" / "jupyter-lab", "--no-browser", "--allow-root", f"--port={port}",
        f"--IdentityProvider.token={TOKEN}",
    ]  # fmt: skip
    with (home / "server.log").open("w") as log:
        process = subprocess.Popen(command, cwd=folder, env=variables(software, home), stdout=log, stderr=log)
        try:
            address = f"http://127.0.0.1:{port}"
            _wait(f"{address}/api")
            yield address
        finally:
            process.terminate()
            process.wait(60)


def page(address: str) -> str:
    """Return what the server gives under an address."""
    request = urllib.request.Request(address, headers={"Authorization": f"token {TOKEN}"})
    with urllib.request.urlopen(request, timeout=120) as answer:
        return str(answer.read().decode())


def _wait(address: str) -> None:
    for _ in range(PATIENCE):
        try:
            page(address)
            return
        except (URLError, ConnectionError):
            time.sleep(1)
    raise RuntimeError(f"nothing is served at {address}")
