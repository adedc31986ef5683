"""What a question kind is: how it is asked of an arm, when it applies, and what it builds on."""

from collections.abc import Callable
from dataclasses import dataclass

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.problem import Answer
from exercises.stream import Stream

Asked = tuple[Answer, dict[str, object]]
"""The answer, and the quantities that the wording needs."""


def always(chain: Chain) -> str | None:
    """Return no objection."""
    return None


def square(chain: Chain) -> str | None:
    """Return the objection to an arm whose task Jacobian has no determinant."""
    if len(chain.task) != chain.n:
        return f"its Jacobian is {len(chain.task)} x {chain.n} for the task {', '.join(chain.task)}, not square"
    if derive(chain).generic_minors[0].is_zero:
        return "its determinant is zero everywhere"
    return None


@dataclass(frozen=True)
class Question:
    """A kind of question; `objection` tells why it can't be asked of an arm, or nothing."""

    name: str
    title: str
    source: str
    ask: Callable[[Chain, Stream], Asked]
    needs: tuple[str, ...] = ()
    points: float = 1.0
    objection: Callable[[Chain], str | None] = always
