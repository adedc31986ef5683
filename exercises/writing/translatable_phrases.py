"""List the English phrases in problems as messages; a name in braces matches words that are translated themselves.

The phrases are the lines of translatable_phrases.txt. The first pattern that matches a text is used, so special
patterns come before general ones. "In your answer" begins the sentence on a mistake in finished formulas.
"""

from pathlib import Path

from qdot.exercises.families import FAMILIES

ARMS = (
    "arm",  # of an arm without a name
    *dict.fromkeys(family.textbook_arm.title for family in FAMILIES.values() if family.textbook_arm is not None),
    "{kinds} arm",
    "{name}",
)
"""Names of arms. The last but one matches a random arm, the last one matches a name given by an instructor."""

PHRASES = tuple(Path(__file__).with_suffix(".txt").read_text(encoding="utf-8").splitlines())
"""Numbers as words, options, precisions, descriptions of configurations, parts of matrices."""

NUMBER_WORDS = PHRASES[: PHRASES.index("ten")]
"""The numbers from 0 to 9 as words: "no", "one" ..."""
