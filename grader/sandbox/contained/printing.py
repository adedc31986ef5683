"""Loads the printer of `exercises`, which writes answers as text, from its file: no other part of qdot is available."""

import importlib.util
from pathlib import Path
from typing import Any

_FILE = Path(__file__).parents[3] / "exercises" / "formula" / "printing.py"


def _load_printer() -> Any:
    spec = importlib.util.spec_from_file_location("contained.sympy_text", _FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.FullPrinter


Printer = _load_printer()
