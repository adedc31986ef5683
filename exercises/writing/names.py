"""What axes and vectors are called in the convention of an arm; formulas are LaTeX without dollar signs."""

from collections.abc import Sequence

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.questions.base import velocities


class AxisNames:
    """Names that templates write, of what has the arm as its `chain`."""

    chain: Chain

    @property
    def convention(self) -> Convention:
        """The convention of the arm."""
        return convention_of(self.chain)

    @property
    def is_omega_first(self) -> bool:
        """Whether the angular velocity comes first in what is asked."""
        return self.convention.is_omega_first

    @property
    def six_rows(self) -> str:
        """The components of a velocity in the order in which they are asked for."""
        return ", ".join(name.replace("{", "").replace("}", "") for name in velocities(self.convention.velocities))

    def twist(self, omega: str, v: str) -> str:
        """Return a twist with these halves, in the order in which it is told."""
        return f"({omega}, {v})" if self.is_omega_first else f"({v}, {omega})"

    @property
    def upper(self) -> str:
        """The half of a twist that stands above the other."""
        return "\\omega" if self.is_omega_first else "v"

    @property
    def lower(self) -> str:
        """The other half."""
        return "v" if self.is_omega_first else "\\omega"

    @property
    def turning_screw(self) -> str:
        """The screw of a revolute joint at home."""
        return self.twist("\\omega_i", "-\\omega_i \\times q_i")

    @property
    def sliding_screw(self) -> str:
        """The screw of a prismatic joint at home."""
        return self.twist("0", "v_i")

    @property
    def turned_screw(self) -> str:
        """The screw of a revolute joint as the joints before it have moved it."""
        return self.twist("\\omega_i'", "-\\omega_i' \\times q_i'")

    @property
    def slid_screw(self) -> str:
        """The screw of a prismatic joint as the joints before it have turned it."""
        return self.twist("0", "v_i'")

    def twist_told(self, twist: sp.Matrix) -> sp.Matrix:
        """Return a twist (omega, v) in the order in which it is told."""
        return self.convention.twist(twist)

    def halves(self, six: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
        """Return omega and v of what is told in that order."""
        both = [six[row] for row in self.convention.twist_rows]
        return both[:3], both[3:]

    @property
    def z_i(self) -> str:
        """What the axis of joint i is called."""
        return self.convention.axis()

    @property
    def slide_i(self) -> str:
        """The same if it is prismatic."""
        return self.convention.prismatic_axis

    @property
    def axes_i(self) -> list[str]:
        """The same of all kinds of joints that the arm has."""
        kinds = {joint.kind for joint in self.chain.joints}
        names = [name for kind, name in (("R", self.z_i), ("P", self.slide_i)) if kind in kinds]
        return list(dict.fromkeys(names))

    @property
    def p_i(self) -> str:
        """What the vector from the axis of joint i to P is called."""
        return self.convention.vector()

    def z(self, joint: int) -> str:
        """Return what the axis of a joint is called."""
        return self.convention.axis(joint)

    def z_at_home(self, joint: int) -> str:
        """Return what the axis of a joint is called where all joint variables are zero."""
        return self.convention.axis(joint, at_home=True)

    def p(self, joint: int) -> str:
        """Return what the vector from the axis of a joint to P is called."""
        return self.convention.vector(joint)

    def on(self, joint: int) -> int:
        """Return the number of the frame on the axis of a joint, from 1."""
        return self.convention.frame_on_axis(joint)
