"""Shared helpers of the tests; the paths of the checkout and its data."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
SNAPSHOTS = ROOT / "tests" / "snapshots"
