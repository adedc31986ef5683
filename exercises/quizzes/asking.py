"""How a short question is asked: of an arm for which it makes sense, and for which something is found to ask."""

from collections.abc import Callable, Sequence
from functools import lru_cache

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import structure
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import Asked, Question, no_names

Ask = Callable[[Chain, Stream], Asked | None]
"""Returns nothing where the draws lead to nothing that could be asked."""


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

    `otherwise` is the objection where nothing is found to ask, `sense` one of its own, `undiagnosed` why no mistake is
    named behind a wrong answer. It is looked once for all arms
    of a structure whether there is anything; where an arm's numbers leave nothing, another is drawn (`generate`).
    """

    @lru_cache(maxsize=2048)
    def sure(chain: Chain) -> Asked | None:
        return ask(chain, Stream(f"quiz/{name}"))

    def asked(chain: Chain, rng: Stream) -> Asked:
        question = ask(chain, rng) or sure(chain)
        if question is None:
            raise RuntimeError(f"{name} finds nothing to ask of {chain}; please report this")
        return question

    def objection(chain: Chain) -> str | None:
        refused = QUESTIONS[about].objects(chain) or sense(chain)
        return refused or (None if sure(structure(chain).chain) is not None else otherwise)

    return Question(
        name=name, title=title, source=source, ask=asked, points=points, objection=objection, form=form, shows=shows,
        template=template, entry_names=entry_names, speaks_of=QUESTIONS[about].speaks_of,
        without={
            **({"diagnosis": undiagnosed} if undiagnosed else {}),
            **({"STACK": "STACK has no input for several letters"} if form in ("selection", "matching") else {}),
        },
    )  # fmt: skip
