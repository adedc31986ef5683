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
"""The platforms by name: the variable with the path of the software, if any, and the function for the pictures."""


def main(names: list[str]) -> int:
    """Take the pictures of the named platforms, or of all whose software is configured."""
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
