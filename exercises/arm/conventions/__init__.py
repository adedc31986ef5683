"""The conventions in which arms are presented: a class for each, which answers all that depends on the convention.

    base           what every convention answers
    standard_dh    a standard (distal) Denavit-Hartenberg table
    modified_dh    a modified (proximal) one, of Craig
    screws         the joint axes at home

Everybody else asks `convention_of(chain)`, and nobody tests which convention an arm has.
"""

from typing import TYPE_CHECKING

from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.arm.conventions.modified_dh import ModifiedDh
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.arm.conventions.standard_dh import StandardDh

if TYPE_CHECKING:
    from qdot.exercises.arm.chain import Chain

REGISTRY: dict[str, type[Convention]] = {each.name: each for each in (StandardDh, ModifiedDh, Screws)}
"""All conventions by their names; the first is the usual one."""

ALIASES = {alias: each.name for each in REGISTRY.values() for alias in each.aliases}
"""What conventions are called elsewhere, and here."""


def convention_of(chain: "Chain") -> Convention:
    """Return the convention of an arm, which answers for this arm.

    >>> from qdot.exercises.arm.chain import Chain, Joint
    >>> arm = Chain("arm", (Joint("R", "theta1", 0, "a1", 0),), ("vx",), convention="modified-dh")
    >>> convention_of(arm).axis(), convention_of(arm).axis(1)
    ('z_{i}', 'z_{1}')
    """
    return REGISTRY[chain.convention](chain)
