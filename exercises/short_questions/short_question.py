"""Define what a short question is. It applies to an arm if something to ask about the arm can be sampled."""

from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import make_symbolic_arm
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import AnswerAndDetails, Question


@dataclass(frozen=True)
class ShortQuestion(Question):
    """A short question about the result that another question, `base_question`, asks for.

    A short question applies to an arm only if its base question does. `objection_if_sampling_fails` is the objection to
    an arm if sampling finds nothing to ask. Whether there is an objection depends only on the arm's structure (the arm
    with symbols for all lengths and oblique angles). If nothing can be asked about an arm because of its numbers,
    `generate` samples another arm.
    """

    base_question: str = ""
    objection_if_sampling_fails: str = ""
    points: float = 0.5

    def ask(self, chain: Chain, rng: Stream) -> AnswerAndDetails:
        """Return an answer and details sampled from `rng`, or else from a fixed stream. Raises RuntimeError."""
        try:
            return super().ask(chain, rng)
        except RuntimeError:
            answer_and_details = _sample_from_fixed_stream(self, chain)
            if answer_and_details is None:
                raise
            return answer_and_details

    def find_applicability_objection(self, chain: Chain) -> str | None:
        """Return why the question can't be asked about an arm; None if it can."""
        if objection := QUESTIONS[self.base_question].find_objection(chain) or self.find_arm_objection(chain):
            return objection
        # An arm's structure does not determine its screws at home.
        arms = [*([chain] if self.required_feature == SCREWS else []), make_symbolic_arm(chain).chain]
        is_found = all(_sample_from_fixed_stream(self, arm) is not None for arm in arms)
        return None if is_found else self.objection_if_sampling_fails


@lru_cache(maxsize=20_000)
def _sample_from_fixed_stream(question: ShortQuestion, chain: Chain) -> AnswerAndDetails | None:
    assert question.sample is not None, question.name
    return question.sample(chain, Stream(f"quiz/{question.name}"))
