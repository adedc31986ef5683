"""What axes and vectors are called in the convention of an arm; formulas are LaTeX without dollar signs."""

from exercises.arm.chain import Chain
from exercises.arm.told import axis_symbol, frame_on_axis, is_by_axes, slide_symbol, vector_symbol


class AxisNames:
    """Names that templates write, of what has the arm as its `chain`."""

    chain: Chain

    @property
    def is_by_axes(self) -> bool:
        """Whether the arm is told by its axes at home, so that no frames stand on its links."""
        return is_by_axes(self.chain)

    @property
    def z_i(self) -> str:
        """What the axis of joint i is called."""
        return axis_symbol(self.chain)

    @property
    def slide_i(self) -> str:
        """The same if it is prismatic."""
        return slide_symbol(self.chain)

    @property
    def axes_i(self) -> list[str]:
        """The same of all kinds of joints that the arm has."""
        if not self.is_by_axes:
            return [self.z_i]
        kinds = {joint.kind for joint in self.chain.joints}
        return [name for kind, name in (("R", self.z_i), ("P", self.slide_i)) if kind in kinds]

    @property
    def p_i(self) -> str:
        """What the vector from the axis of joint i to P is called."""
        return vector_symbol(self.chain)

    def z(self, joint: int) -> str:
        """Return what the axis of a joint is called."""
        return axis_symbol(self.chain, joint)

    def z_at_home(self, joint: int) -> str:
        """Return what the axis of a joint is called where all joint variables are zero."""
        return axis_symbol(self.chain, joint, at_home=True)

    def p(self, joint: int) -> str:
        """Return what the vector from the axis of a joint to P is called."""
        return vector_symbol(self.chain, joint)

    def on(self, joint: int) -> int:
        """Return the number of the frame on the axis of a joint, from 1."""
        return frame_on_axis(self.chain, joint)
