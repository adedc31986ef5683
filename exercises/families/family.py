"""Define what a family of arms is: an arm as drawn in the chapter, and the properties that may vary among students."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_AXES, list_variation_axes

Variation = Callable[[Chain, Stream], Chain]
"""An axis of variation: a function that changes one property of an arm at random."""


@dataclass(frozen=True)
class Family:
    """A family of arms.

    - `source`: the example or the equations in the chapter to which the family belongs.
    - `chapter_arm`: the arm as drawn in the chapter. Its lengths are symbols, its joints have no offset, its base
      frame is the world frame, and its point of interest is the origin of a frame.
    - `variations`: the family's axes of variation; the keys are names in `common.variation`.
    - `sample_structure`: for a family without an arm in the chapter, a function that samples an arm and its structure:
      the kinds of the joints, their twists, and which lengths are zero. The arms of such a family differ in difficulty
      and in the questions that apply to them. The arguments are a stream, the names of the axes of variation, a minimum
      and a maximum difficulty, and a test that the arm must pass.
    - `robot_argument`: for the family of an instructor's robot, the argument of `qdot families`: the robot's file, or
      its name in the library.
    """

    name: str
    title: str
    source: str
    chapter_arm: Chain | None
    variations: Mapping[str, Variation] = field(default_factory=dict, hash=False)
    sample_structure: Callable[..., Chain] | None = None
    robot_argument: str = ""

    @property
    def is_robot(self) -> bool:
        """Whether this is the family of an instructor's robot."""
        return bool(self.robot_argument)

    @property
    def has_varied_structure(self) -> bool:
        """Whether the arms of the family differ in structure."""
        return self.sample_structure is not None

    @property
    def variation_names(self) -> tuple[str, ...]:
        """The names of the family's axes of variation, in the order in which they change an arm."""
        return tuple(name for name in VARIATION_AXES if name in self.variations)

    def sample(self, rng: Stream, axes: Collection[str]) -> Chain:
        """Return a random arm that varies along some axes; each axis has its own stream of random numbers."""
        chain = self.chapter_arm
        if chain is None:
            raise TypeError(f"{self.name} also chooses its structure at random")
        for name in self.variation_names:
            if name in axes:
                chain = self.variations[name](chain, rng.substream(name))
        return chain


def describe_variation(family: Family, variation: str) -> str:
    """Return a phrase that says how the arms of a family differ at a step of variation.

    >>> describe_variation(Family("mine", "my arm", "mine.toml", None, robot_argument="mine.toml"), "zeros")
    'the same arm for all, as no length is chosen at random'
    """
    if not family.is_robot or set(family.variations) - set(list_variation_axes(variation)):
        return f"variation {variation}"
    no_variation = "the same arm for all, as no length is chosen at random"
    return "lengths in the ranges of [draw]" if family.variations else no_variation
