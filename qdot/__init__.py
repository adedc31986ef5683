"""qdot: randomised manipulator-velocity problems, written out and graded.

`exercises` is what is asked, `grader` what is handed in; both lie at the top of the checkout, and are linked here. What
a library or a notebook needs is offered by this package itself (`__all__`), and loaded when it is asked for:

>>> from qdot import generate, judge
>>> problem = generate("polar-rp/1", ["determinant"])
>>> judge(problem, problem["determinant"], "-(7/10 + d2)")
Judgement(correct, 1: right)
"""

from typing import TYPE_CHECKING, Any

from qdot import exercises, grader

if TYPE_CHECKING:
    from qdot.exercises import *  # noqa: F403
    from qdot.grader import *  # noqa: F403

__all__: list[str] = []
__all__ += exercises.__all__
__all__ += grader.__all__


def __getattr__(name: str) -> Any:
    for package in (exercises, grader):
        if name in package.__all__:
            return getattr(package, name)
    raise AttributeError(f"module 'qdot' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
