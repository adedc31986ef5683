"""The words, signs, units and habits of those who write answers: vocabulary.json, which the site's reader has, too.

Whoever adds a synonym adds it there, and both readers know it; neither has a list of its own.
"""

import json
import re
from pathlib import Path
from typing import Any

VOCABULARY: dict[str, Any] = json.loads(Path(__file__).with_name("vocabulary.json").read_text(encoding="utf-8"))
LIMITS: dict[str, int] = VOCABULARY["limits"]
SPACES: str = VOCABULARY["spaces"]
"""What may stand between any two words; `\\s` means other signs to Python than to a browser."""


def pattern(name: str) -> re.Pattern[str]:
    """Return one of the vocabulary's patterns, compiled."""
    return re.compile(VOCABULARY["patterns"][name])
