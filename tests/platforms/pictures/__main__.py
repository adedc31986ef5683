"""`python -m tests.platforms.pictures [NAME …]`: take the pictures whose software the environment names."""

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.platforms.pictures import jupyter, own

PICTURES: dict[str, tuple[str, Callable[[Path, Path], None]]] = {
    "qdot": ("", own.run),
    "jupyterlab": ("JUPYTERLAB", jupyter.notebook),
}
"""Platforms by name, each with the variable for the path of its software, if any, and what takes its pictures."""


def main(names: list[str]) -> int:
    """Take the pictures of the platforms named, else of all whose software is named."""
    for name in names or PICTURES:
        variable, take = PICTURES[name]
        if variable and not os.environ.get(variable):
            print(f"{name}: left out; {variable}=/path/of/its/software has its pictures taken")
            continue
        with tempfile.TemporaryDirectory(prefix=f"qdot-{name}-") as work:
            take(Path(os.environ.get(variable, "")), Path(work))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
