"""Define a family of arms: an arm as drawn in the chapter, and what may vary from one student's arm to another's."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_AXES, list_variation_axes

Variation = Callable[[Chain, Stream], Chain]
"""An axis of variation: a function that changes one property of an arm at random, with numbers from the stream."""


@dataclass(frozen=True)
class Family:
    """A family of arms: its name, its title, its source in the chapter, and how arms are sampled.

    `textbook_arm` is the arm as drawn in the chapter. Its lengths are symbols, its joints have no offset, its base
    frame is the world frame, and its tool point is a frame's origin. `variations` are the family's axes of variation:
    for each name in `common.variation`, the function that varies the arm.

    A family without such an arm has `sample_structure`, a function that also samples the structure. Its arms differ in
    difficulty and in the questions that apply to them. Therefore the function takes a stream, the names of the axes of
    variation, the minimum and maximum difficulty, and a test that the chain must pass. For the family of an
    instructor's robot, `robot_argument` is the file or the name in the library, as given to `qdot families`.
    """

    name: str
    title: str
    source: str
    textbook_arm: Chain | None
    variations: Mapping[str, Variation] = field(default_factory=dict, hash=False)
    sample_structure: Callable[..., Chain] | None = None
    robot_argument: str = ""

    @property
    def has_varied_structure(self) -> bool:
        """Whether the arms of the family differ in structure."""
        return self.sample_structure is not None

    @property
    def variation_names(self) -> tuple[str, ...]:
        """The names of the family's axes of variation, in the order in which they are sampled."""
        return tuple(name for name in VARIATION_AXES if name in self.variations)

    def sample(self, rng: Stream, axes: Collection[str]) -> Chain:
        """Return a random arm; each axis of variation has a stream of its own, so it doesn't depend on the others."""
        chain = self.textbook_arm
        if chain is None:
            raise TypeError(f"{self.name} also chooses its structure at random")
        for name in self.variation_names:
            if name in axes:
                chain = self.variations[name](chain, rng.substream(name))
        return chain


def describe_variation(family: Family, variation: str) -> str:
    """Return a phrase that says how the arms of a family differ; of a robot in a file, only the lengths in [draw] vary.

    >>> describe_variation(Family("mine", "my arm", "mine.toml", None, robot_argument="mine.toml"), "zeros")
    'the same arm for all, as no length is chosen at random'
    """
    if not family.robot_argument or set(family.variations) - set(list_variation_axes(variation)):
        return f"variation {variation}"
    no_variation = "the same arm for all, as no length is chosen at random"
    return "lengths in the ranges of [draw]" if family.variations else no_variation
