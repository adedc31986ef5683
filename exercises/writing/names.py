"""What axes and vectors are called in the convention of an arm; formulas are LaTeX without dollar signs."""

from collections.abc import Sequence

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
    def six_rows(self) -> str:
        """The components of a velocity in the order in which they are asked for."""
        return ", ".join(name.replace("{", "").replace("}", "") for name in velocities(self.convention.velocities))

    def twist(self, omega: str, v: str) -> str:
        """Return a twist with these halves, in the order in which it is told."""
        return f"({omega}, {v})" if self.convention.is_omega_first else f"({v}, {omega})"

    def halves(self, six: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
        """Return omega and v of what is told in that order."""
        both = [six[row] for row in self.convention.twist_rows]
        return both[:3], both[3:]

    @property
    def axes_i(self) -> list[str]:
        """What the axis of joint i is called, of each kind of joint that the arm has."""
        kinds = {joint.kind for joint in self.chain.joints}
        names = {"R": self.convention.axis(), "P": self.convention.prismatic_axis}
        return list(dict.fromkeys(name for kind, name in names.items() if kind in kinds))
