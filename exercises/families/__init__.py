"""Robot families: each draws a chain; one file and one line in `FAMILIES` for each."""

from exercises.families.base import Family
from exercises.families.elbow_3r import ELBOW_3R
from exercises.families.planar_2r import PLANAR_2R
from exercises.families.planar_3r import PLANAR_3R
from exercises.families.polar_rp import POLAR_RP

FAMILIES: dict[str, Family] = {family.name: family for family in (PLANAR_2R, ELBOW_3R, POLAR_RP, PLANAR_3R)}

__all__ = ["FAMILIES", "Family"]
