"""List the English phrases in problems that are translated; the phrases are the lines of translatable_phrases.txt.

A name in braces matches words, which are translated separately. The first phrase that matches a text is used, so
specific phrases come before general ones.
"""

from pathlib import Path

from qdot.exercises.families import FAMILIES

ARMS = (
    "arm",  # of an arm without a name
    *dict.fromkeys(family.chapter_arm.title for family in FAMILIES.values() if family.chapter_arm is not None),
    "{kinds} arm",
    "{name}",
)
"""Names of arms. "{kinds} arm" matches a random arm, and "{name}" a name that an instructor has chosen."""

PHRASES = tuple(Path(__file__).with_suffix(".txt").read_text(encoding="utf-8").splitlines())
"""Numbers as words, options, precisions, descriptions of configurations, parts of matrices."""

NUMBER_WORDS = PHRASES[: PHRASES.index("ten")]
"""The numbers from 0 to 9 as words: "no", "one", …"""
