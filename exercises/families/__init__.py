"""Robot families: the chapter's arm and what varies; one file and one line in `FAMILIES` for each, or a few alike.

Beside the families:

    base                    what a family is
    axes                    the axes of variation that families share
    structures, classes     every structure of 2, 3 or 4 joints (structures.txt), and when two are the same problem
    own                     an instructor's own robot as a family
    listing                 what is known of each family without drawing its arms (listing.json, by `make docs`)
"""

from qdot.exercises.families.base import Family
from qdot.exercises.families.elbow_3r import ELBOW_3R
from qdot.exercises.families.elbows import ELBOWS
from qdot.exercises.families.planar_2r import PLANAR_2R
from qdot.exercises.families.planar_3r import PLANAR_3R
from qdot.exercises.families.planar_arms import PLANAR_ARMS
from qdot.exercises.families.polar_rp import POLAR_RP
from qdot.exercises.families.positioning import POSITIONING
from qdot.exercises.families.random_n import RANDOM
from qdot.exercises.families.scara import SCARA
from qdot.exercises.families.scorbot import SCORBOT
from qdot.exercises.families.six_joints import SIX_JOINTS
from qdot.exercises.families.wrists import WRISTS

FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        PLANAR_2R, ELBOW_3R, POLAR_RP, PLANAR_3R,
        *PLANAR_ARMS, *POSITIONING, *SCARA, *ELBOWS, *WRISTS, *SCORBOT, *SIX_JOINTS, *RANDOM,
    )
}  # fmt: skip
"""Every family by name."""

__all__ = ["FAMILIES", "Family"]
