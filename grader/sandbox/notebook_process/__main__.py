"""Start the process in which notebooks run: `python -I …/notebook_process CONFIG`, with the control socket as input."""

import importlib
import json
import os
import sys
import types
from pathlib import Path


def main() -> None:
    """Load this folder as the package `notebook_process`, and serve the grader's requests."""
    folder = str(Path(__file__).parent)
    sys.path[:] = [path for path in sys.path if path != folder]  # students can't import these modules
    sys.modules["notebook_process"] = package = types.ModuleType("notebook_process")
    package.__path__ = [folder]
    importlib.import_module("notebook_process.forking_process").main(json.loads(sys.argv[1]))
    os._exit(0)  # there is nothing to clean up, and unloading SymPy would take a long time


if __name__ == "__main__":
    main()
