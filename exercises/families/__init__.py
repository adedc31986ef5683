"""Robot families: the chapter's arm and what varies from student to student; an entry of families.toml for each.

Beside the families:

    base            what a family is
    axes            what may vary: lengths, zeros, senses of the axes, base, point, task
    textbook        the families of families.toml
    random_n        families whose structure is sampled, too
    structures      the structures of 2, 3 or 4 joints that make a problem (structures.txt)
    own             an instructor's own robot as a family
    listing         what is known of each family without sampling its arms (listing.json, by `make docs`)
"""

from qdot.exercises.families.base import Family
from qdot.exercises.families.random_n import RANDOM
from qdot.exercises.families.textbook import read_families

FAMILIES: dict[str, Family] = {family.name: family for family in (*read_families(), *RANDOM)}
"""Every family by name."""

__all__ = ["FAMILIES", "Family"]
