"""`python -m tests.platforms.pictures [NAME …]`: take the pictures whose software the environment names."""

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.platforms.pictures import feedback_and_site, jupyter

PICTURES: dict[str, tuple[str, Callable[[Path, Path], None]]] = {
    "qdot": ("", feedback_and_site.take_pictures),
    "jupyterlab": ("JUPYTERLAB", jupyter.take_notebook_pictures),
}
"""Platforms by name: the environment variable of the software's path, or "", and the function that takes pictures."""


def main(names: list[str]) -> int:
    for name in names or PICTURES:
        variable, take_pictures = PICTURES[name]
        if variable and not os.environ.get(variable):
            print(f"{name}: skipped; set {variable} to the path of its software to take its pictures")
            continue
        with tempfile.TemporaryDirectory(prefix=f"qdot-{name}-") as work:
            take_pictures(Path(os.environ.get(variable, "")), Path(work))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
