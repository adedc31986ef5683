"""Read the stored properties of each family: joints, difficulty, questions. `make docs` computes them."""

import json
from dataclasses import dataclass
from functools import cache
from operator import itemgetter
from pathlib import Path

LISTING_FILE = Path(__file__).with_name("listing.json")


@dataclass(frozen=True)
class FamilyListing:
    """The properties of a family: its kinds of joints, such as RRP, its difficulty, and its questions.

    `steps` are the minimum and the maximum difficulty. `by_variation` is the difficulty at each step of variation,
    empty if the structure is sampled.
    """

    kinds: str
    steps: tuple[int, int]
    questions: tuple[str, ...]
    by_variation: tuple[int, ...] = ()

    @property
    def difficulty(self) -> str:
        """The range of steps as text, such as "1" or "1 to 2"."""
        low, high = self.steps
        return str(low) if low == high else f"{low} to {high}"


@cache
def listing() -> dict[str, FamilyListing]:
    """Return the stored listings by the family's name."""
    keys = itemgetter("kinds", "steps", "questions", "by_variation")
    entries = {name: keys(entry) for name, entry in json.loads(LISTING_FILE.read_text(encoding="utf-8")).items()}
    return {
        name: FamilyListing(kinds, (low, high), tuple(questions), tuple(by_variation))
        for name, (kinds, (low, high), questions, by_variation) in entries.items()
    }
