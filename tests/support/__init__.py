"""What tests share; where the checkout and its data are."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
SNAPSHOTS = ROOT / "tests" / "snapshots"
