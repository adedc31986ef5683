"""Define the screw convention: an arm is described by its joint axes at home in the space frame {s}.

The links have no frames. Home is the configuration in which all joint variables are zero. omega_i is an axis at home;
the prime of omega_i' marks the same axis after earlier joints have moved. Twists are (omega, v) or (v, omega),
depending on the arm's `twist_order`. Results are derived from the standard table, which students do not see.
"""

from typing import TYPE_CHECKING, ClassVar

from qdot.exercises.arm.conventions.base import SCREWS, Convention

if TYPE_CHECKING:
    from qdot.exercises.writing.languages import Catalogue


class Screws(Convention):
    """Joint axes with the directions omega_i (revolute) or v_i (prismatic), through the points q_i."""

    name, title = "screws", "axes"
    aliases = ("axes", "twists", "poe", "lynch-park", "product-of-exponentials")
    features = frozenset({SCREWS})
    twist_orders: ClassVar[tuple[str, ...]] = ("omega-v", "v-omega")  # of Lynch and Park, and of Murray, Li and Sastry
    joint_keys = ("kind", "axis", "point")  # a prismatic joint has no point
    shows_table, is_drawn_at_home, fixed_frame = False, True, "s"
    caption = "Joint axes at home"
    frame_index = twist_axis = ""

    @property
    def frame_numbers(self) -> range:
        """An empty range, because the links have no frames."""
        return range(0)

    @property
    def is_omega_first(self) -> bool:
        """Whether the angular velocity comes first in twists, which is the default."""
        return self.chain.twist_order == self.twist_orders[0]

    def name_axis(self, joint: int | None = None, is_at_home: bool = False) -> str:
        """Return the name of an axis direction, with a prime unless the axis is at home."""
        letter = "v" if joint is not None and self.chain.joints[joint - 1].is_prismatic else r"\omega"
        return f"{letter}_{{{joint or 'i'}}}{'' if is_at_home else chr(39)}"

    @property
    def prismatic_axis_name(self) -> str:
        """The name of the axis of a prismatic joint i."""
        return "v_{i}'"

    @property
    def axis_in_words(self) -> str:
        """The name of the axis of joint i for sentences without formulas."""
        return "omega_i, or v_i for a prismatic joint" if self.chain.prismatic_joints else "omega_i"

    def name_vector(self, joint: int | None = None) -> str:
        """Return the name of the vector from the axis of a joint to the point of interest."""
        return f"p_{{{joint or 'i'}}}"

    def name_typed_axis(self, joint: int) -> str:
        """Return the name of the direction of a joint's axis, as students type it."""
        return f"{'v' if self.chain.joints[joint - 1].is_prismatic else 'omega'}{joint}"

    def name_vector_start(self, joint: int, catalogue: "Catalogue") -> str:
        """Return the name of the point on a joint's axis at which the vector to the point of interest starts."""
        return catalogue.gettext("a point on the axis")

    def name_reference_frame(self, catalogue: "Catalogue") -> str:
        """Return the name of the frame in which positions and directions are expressed."""
        return catalogue.gettext("the space frame {s}")

    def name_origin(self, frame: int) -> str | None:
        """Return None, because the links have no frames."""
        return None

    def describe_origin(self, frame: int) -> str | None:
        """Return the name of the point on the axis of the next joint; None if that joint is prismatic."""
        return f"q{frame + 1}'" if frame < self.chain.n and self.chain.joints[frame].is_revolute else None
