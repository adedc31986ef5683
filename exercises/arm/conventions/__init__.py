"""Define the conventions in which arms are presented: one class for each, with all that depends on the convention.

    base           the base class, with the properties and methods of every convention
    standard_dh    the standard (distal) Denavit-Hartenberg table
    modified_dh    the modified (proximal) Denavit-Hartenberg table of Craig
    screws         the joint axes at home, without frames on the links

`REGISTRY` lists them; docs/adding/convention.md says how to add one. All other code calls methods of
`convention_of(chain)`; it does not test which convention an arm has.
"""

from typing import TYPE_CHECKING

from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.arm.conventions.modified_dh import ModifiedDh
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.arm.conventions.standard_dh import StandardDh

if TYPE_CHECKING:
    from qdot.exercises.arm.chain import Chain

REGISTRY: dict[str, type[Convention]] = {convention.name: convention for convention in (StandardDh, ModifiedDh, Screws)}
"""Maps the name of each convention to its class; the first convention is the default."""

ALIASES = {alias: convention.name for convention in REGISTRY.values() for alias in convention.aliases}
"""Maps other common names of conventions to the names that are used here."""


def convention_of(chain: "Chain") -> Convention:
    """Return the convention in which an arm is presented, as an object that knows the arm.

    >>> from qdot.exercises.arm.chain import Chain, Joint
    >>> arm = Chain("arm", (Joint("R", "theta1", 0, "a1", 0),), ("vx",), convention="modified-dh")
    >>> convention_of(arm).name_axis(), convention_of(arm).name_axis(1)
    ('z_{i}', 'z_{1}')
    """
    return REGISTRY[chain.convention](chain)
