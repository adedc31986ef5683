"""Define a family of arms: an arm as drawn in the chapter, and what may vary from one student's arm to another's."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import AXES, axes_of

Axis = Callable[[Chain, Stream], Chain]
"""An axis of variation: a function that changes one property of an arm at random, with numbers from the stream."""


@dataclass(frozen=True)
class Family:
    """A family of arms: its name, its title, its source in the chapter, and how arms are sampled.

    `plain` is the arm as drawn in the chapter. Its lengths are symbols, its joints have no offset, its base frame is
    the world frame, and its tool point is a frame's origin. `axes` are the family's axes of variation: for each name in
    `common.variation`, the function that varies the arm.

    A family without such an arm has `structures`, a function that also samples the structure. Its arms differ in
    difficulty and in the questions that apply to them. Therefore the function takes a stream, the names of the axes of
    variation, the minimum and maximum difficulty, and a test that the chain must pass. For the family of an
    instructor's robot, `robot` is the file or the name in the library, as given to `qdot families`.
    """

    name: str
    title: str
    source: str
    plain: Chain | None
    axes: Mapping[str, Axis] = field(default_factory=dict, hash=False)
    structures: Callable[..., Chain] | None = None
    robot: str = ""

    @property
    def varied(self) -> bool:
        """Whether the arms of the family differ in structure."""
        return self.structures is not None

    @property
    def has_axes(self) -> tuple[str, ...]:
        """The names of the family's axes of variation, in the order in which they are sampled."""
        return tuple(name for name in AXES if name in self.axes)

    def sample(self, rng: Stream, axes: Collection[str]) -> Chain:
        """Return a random arm; each axis of variation has a stream of its own, so it doesn't depend on the others."""
        chain = self.plain
        if chain is None:
            raise TypeError(f"{self.name} samples its structure, too")
        for name in self.has_axes:
            if name in axes:
                chain = self.axes[name](chain, rng.part(name))
        return chain


def describe_variation(family: Family, variation: str) -> str:
    """Return a phrase that says how the arms of a family differ; of a robot in a file, only the lengths in [draw] vary.

    >>> describe_variation(Family("mine", "my arm", "mine.toml", None, robot="mine.toml"), "zeros")
    'one arm for all, as no length is drawn'
    """
    if not family.robot or set(family.axes) - set(axes_of(variation)):
        return f"variation {variation}"
    return "lengths as [draw] says" if family.axes else "one arm for all, as no length is drawn"
