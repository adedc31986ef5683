"""Starts the process in which notebooks run: `python -I …/contained CONFIG`, with the control socket as its input."""

import importlib
import importlib.util
import json
import os
import sys
from pathlib import Path


def main() -> None:
    """Load this folder as the package `contained`, and serve the grader's requests."""
    folder = Path(__file__).parent
    sys.path[:] = [path for path in sys.path if path != str(folder)]  # students can't import these modules
    spec = importlib.util.spec_from_file_location(
        "contained", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec is not None
    assert spec.loader is not None
    sys.modules["contained"] = package = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    importlib.import_module("contained.zygote").main(json.loads(sys.argv[1]))
    os._exit(0)  # there is nothing to clean up, and unloading SymPy would take a long time


if __name__ == "__main__":
    main()
