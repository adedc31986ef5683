"""Define a short question: asked of an arm for which it makes sense and of which the draws find something to ask."""

from collections.abc import Callable, Sequence
from functools import lru_cache

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import Asked, Question, no_names

Ask = Callable[[Chain, Stream], Asked | None]
"""Returns None where the draws find nothing to ask."""


def short_question(
    name: str,
    title: str,
    source: str,
    ask: Ask,
    form: str,
    about: str,
    otherwise: str,
    shows: tuple[str, ...] = (),
    sense: Callable[[Chain], str | None] = lambda _: None,
    points: float = 0.5,
    template: str = "",
    entry_names: Callable[[Chain, Part], Sequence[str]] = no_names,
    undiagnosed: str = "",
) -> Question:
    """Return a short question about what the question `about` asks for, where that makes sense.

    `sense` returns an objection of this question; `otherwise` is the objection if the draws find nothing to ask;
    `undiagnosed` is the reason why no mistake is named behind a wrong answer. Whether there is anything to ask is
    determined once for all arms of a structure; if an arm's numbers leave nothing, another is drawn (`generate`).
    """

    @lru_cache(maxsize=2048)
    def find_question(chain: Chain) -> Asked | None:
        return ask(chain, Stream(f"quiz/{name}"))

    def ask_question(chain: Chain, rng: Stream) -> Asked:
        question = ask(chain, rng) or find_question(chain)
        if question is None:
            raise RuntimeError(f"{name} finds nothing to ask of {chain}; please report this")
        return question

    def objection(chain: Chain) -> str | None:
        refused = QUESTIONS[about].objects(chain) or sense(chain)
        return refused or (None if find_question(structure(chain).chain) is not None else otherwise)

    return Question(
        name=name, title=title, source=source, ask=ask_question, points=points, objection=objection, form=form,
        shows=shows, template=template, entry_names=entry_names, speaks_of=QUESTIONS[about].speaks_of,
        without={
            **({"diagnosis": undiagnosed} if undiagnosed else {}),
            **({"STACK": "STACK has no input for several letters"} if form in ("selection", "matching") else {}),
        },
    )  # fmt: skip
