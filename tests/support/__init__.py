"""Shared helpers of the tests; the paths of the checkout and its data."""

import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
SNAPSHOTS = ROOT / "tests" / "snapshots"


def read_data(name: str) -> str:
    """Return the text of a file in tests/data."""
    return (DATA / name).read_text(encoding="utf-8")


def read_cases(name: str) -> dict[str, Any]:
    """Return the cases of a TOML file in tests/data."""
    return tomllib.loads(read_data(f"{name}.toml"))
