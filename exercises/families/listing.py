"""Read the properties of each family (joints, difficulty, questions) from listing.json, which `make docs` writes."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from qdot.exercises.singularities.difficulty import describe_band

LISTING_FILE = Path(__file__).with_name("listing.json")


@dataclass(frozen=True)
class FamilyListing:
    """The properties of a family.

    - `kinds`: the kinds of the joints, such as RRP.
    - `band_range`: the minimum and the maximum level of difficulty (`singularities.difficulty`).
    - `questions`: the names of the questions that apply to the family's arms.
    - `step_difficulties`: the difficulty at each step of variation; () if the family also samples structures.
    """

    kinds: str
    band_range: tuple[int, int]
    questions: tuple[str, ...]
    step_difficulties: tuple[int, ...] = ()

    @property
    def difficulty(self) -> str:
        """The range of levels of difficulty as text, such as "1" or "1 to 2"."""
        return describe_band(*self.band_range)


@cache
def read_listing() -> dict[str, FamilyListing]:
    """Return the stored properties of each family by the family's name."""
    content = json.loads(LISTING_FILE.read_text(encoding="utf-8"))
    keys = ("band_range", "questions", "step_difficulties")
    return {
        name: FamilyListing(entry["kinds"], *(tuple(entry[key]) for key in keys)) for name, entry in content.items()
    }
