"""Load the words, signs, units and notations of typed answers from vocabulary.json.

The site's parser uses the same file, so both parsers recognise a synonym that is added to it.
"""

import json
import re
from pathlib import Path
from typing import Any

VOCABULARY: dict[str, Any] = json.loads(Path(__file__).with_name("vocabulary.json").read_text(encoding="utf-8"))
LIMITS: dict[str, int] = VOCABULARY["limits"]
SPACES: str = VOCABULARY["spaces"]
"""All characters that count as spaces. (`\\s` matches different characters in Python and in a browser.)"""


class _CompiledPatterns(dict[str, re.Pattern[str]]):
    def __missing__(self, name: str) -> re.Pattern[str]:
        self[name] = re.compile(VOCABULARY["patterns"][name])
        return self[name]


PATTERNS = _CompiledPatterns()
"""The vocabulary's patterns by their names in vocabulary.json, each compiled when it is first used."""
