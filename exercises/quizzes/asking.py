"""Define a short question: asked of an arm if it makes sense and sampling finds something to ask."""

from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.arm.derivation import structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import Asked, Question


@dataclass(frozen=True)
class ShortQuestion(Question):
    """A short question on what the question `about` asks for, asked of an arm if that question makes sense.

    `otherwise` is the objection if sampling finds nothing to ask. Whether there is anything is determined once for all
    arms of a structure; if an arm's numbers leave nothing, another arm is sampled (`generate`).
    """

    about: str = ""
    otherwise: str = ""
    points: float = 0.5

    def ask(self, chain: Chain, rng: Stream) -> Asked:
        """Return what is found for the arm, else what is found for any stream."""
        try:
            return super().ask(chain, rng)
        except RuntimeError:
            asked = _find(self, chain)
            if asked is None:
                raise
            return asked

    def object_to_arm(self, chain: Chain) -> str | None:
        """Return why it makes no sense, or finds nothing to ask."""
        if refused := QUESTIONS[self.about].objects(chain) or self.objection(chain):
            return refused
        # The structure of an arm does not determine where its screws are at home.
        arms = (chain, structure(chain).chain) if self.speaks_of == SCREWS else (structure(chain).chain,)
        return self.otherwise if any(_find(self, arm) is None for arm in arms) else None


@lru_cache(maxsize=20_000)
def _find(question: ShortQuestion, chain: Chain) -> Asked | None:
    assert question.sample is not None, question.name
    return question.sample(chain, Stream(f"quiz/{question.name}"))
