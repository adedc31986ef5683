"""What a family is: an arm as the chapter draws it, and what may vary from one student's arm to another's."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import AXES, axes_of

Axis = Callable[[Chain, Stream], Chain]
"""What one axis of variation does to an arm, sampling from the stream."""


@dataclass(frozen=True)
class Family:
    """A kind of arm: its name, a title for people, the chapter's example it follows, and how one is sampled.

    `plain` is the arm as the chapter draws it: lengths are symbols, joints are zero where their variable is, the base
    is the world and the point of interest an origin. `axes` are the axes of variation that it has, by their names in
    `variation.AXES`. A family without a plain arm samples the structure, too, by `structures`: its arms differ in
    difficulty and in what they can be asked, so it takes, in addition to the stream and the axes, `band` (least and
    greatest step of difficulty) and `accepts` (a test of a chain). `robot` is the file, or the name in the library, of
    an arm that is no registered family's, as `qdot families` takes it.
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
        """Whether its arms differ in structure."""
        return self.structures is not None

    @property
    def has_axes(self) -> tuple[str, ...]:
        """The names of the axes along which its arms can differ, in the order in which they are sampled."""
        return tuple(name for name in AXES if name in self.axes)

    def sample(self, rng: Stream, axes: Collection[str]) -> Chain:
        """Sample an arm. Each axis has its own stream, so that its samples don't depend on what else varies."""
        chain = self.plain
        if chain is None:
            raise TypeError(f"{self.name} samples its structure, too")
        for name in self.has_axes:
            if name in axes:
                chain = self.axes[name](chain, rng.part(name))
        return chain


def describe_variation(family: Family, variation: str) -> str:
    """Return in words how far arms of a family differ; a robot file has no other variation than its [draw].

    >>> describe_variation(Family("mine", "my arm", "mine.toml", None, robot="mine.toml"), "zeros")
    'one arm for all, as no length is drawn'
    """
    if not family.robot or set(family.axes) - set(axes_of(variation)):
        return f"variation {variation}"
    return "lengths as [draw] says" if family.axes else "one arm for all, as no length is drawn"
