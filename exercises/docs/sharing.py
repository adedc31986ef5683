"""How many students of a class would share an answer, as `python -m tests.tools.sharing` measured it (sharing.json)."""

import json
from functools import cache
from pathlib import Path
from typing import Any

MEASURED = Path(__file__).with_name("sharing.json")

GROUPS: dict[str, tuple[str, ...]] = {
    "position": ("position",),
    "J": ("velocity", "jacobian", "inverse-jacobian", "inverse-velocity", "joint-torques", "self-motion"),
    "axes": ("joint-axes",),
    "vectors": ("position-vectors",),
    "6 x n": ("geometric-jacobian", "twist"),
    "det": ("determinant", "block-determinants", "gram-determinant"),
    "blocks": ("arm-block",),
    "wrist": ("wrist-block",),
    "singular": ("singular-angles",),
}
"""Questions that are shared alike, as their formulas are results of one stage, by the heading of their column."""


@cache
def load_measured() -> dict[str, Any]:
    """Return the stored measurements."""
    content: dict[str, Any] = json.loads(MEASURED.read_text(encoding="utf-8"))
    return content
