"""`qdot solve`: results as they are ready; where time or Ctrl-C ends it, what is missing is said."""

import itertools
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinds import kind_is_sure
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.common.time_limit import OutOfTime, time_limit
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import BY_HAND
from qdot.exercises.solve.solver import (
    MEANING,
    SECTIONS,
    SPECIAL,
    TESTED,
    WHERE,
    Kept,
    Ready,
    Stages,
    article,
    data_json,
    data_stages,
    text_heading,
    text_stages,
    twists_of,
)
from qdot.exercises.writing.markup import to_text
from qdot.exercises.writing.worked import SingularComponent

Shown = Callable[[str], AbstractContextManager[object]]
"""Shows while a block lasts what is worked out in it."""


@dataclass
class _Told:
    """What is ready, by name and in order, and what is being worked out."""

    ready: dict[str, Any] = field(default_factory=dict)
    now: str = "the arm itself"
    kept: Kept | None = None
    """What is known of the singular set, as long as it is not ready."""
    left: tuple[str, ...] | None = None
    """What is still to be found out of that set, None where nothing is known of it."""
    singular: tuple[SingularComponent, ...] | None = None
    """The set, None where it is not ready, or is all there is."""
    ended: str = ""
    """Why not all is there: nothing, if all is."""


def write_solution(
    robot: Robot, form: str, seconds: float, say: Callable[[str], None], shown: Shown
) -> tuple[SingularComponent, ...] | None:
    """Say the derivation of an arm as text, latex or json; text section by section, as they are ready.

    It ends once it has taken `seconds` of processor time. Raises KeyboardInterrupt where that ended it, all that was
    ready being said. Returns the singular set, None where it is not ready, or where the arm is singular throughout.
    """
    chain, told = robot.chain, _Told()
    stages = data_stages(chain) if form == "json" else text_stages(chain, robot)
    stop: KeyboardInterrupt | None = None
    try:
        if form == "text":
            say(text_heading(chain))
        with time_limit(seconds):
            _follow(stages, told, (lambda block: say(f"\n{to_text(block)}")) if form == "text" else None, shown)
    except OutOfTime:
        told.ended = f"the {seconds:g} seconds of processor time were over (`--time` gives it more)"
    except KeyboardInterrupt as error:
        told.ended, stop = "it was stopped", error
    if form == "json":
        say(data_json(_data(robot, told)))
    elif form == "latex":
        say(article(chain, [*filter(None, told.ready.values()), *_missing_block(chain, told)]))
    else:
        for block in _missing_block(chain, told):
            say(f"\n{to_text(block)}")
    if stop is not None:
        raise stop
    return told.singular


def _follow(stages: Stages, told: _Told, say: Callable[[str], None] | None, shown: Shown) -> None:
    """Go through the stages, and keep what is ready."""
    while True:
        with shown(told.now):
            stage = next(stages, None)
        if stage is None:
            return
        if isinstance(stage, Ready):
            if say is not None and stage.content:
                say(stage.content)
            told.ready[stage.name] = stage.content  # only now: what was stopped while it was said is missing
            if stage.left is not None:
                told.kept, told.left, told.singular = None, stage.left, stage.singular
        elif isinstance(stage, Kept):
            told.kept, told.left = stage, stage.left
        else:
            told.now = stage


def _data(robot: Robot, told: _Told) -> dict[str, Any]:
    """Return what is ready as plain data; what is missing is null and named."""
    chain = robot.chain
    content: dict[str, Any] = {"name": chain.title} | ({"rounded": True} if robot.rounded else {})
    content |= {"position": None, "jacobian": None, "geometric_jacobian": None}
    twists = twists_of(chain)
    content |= {"twist_rows": list(convention_of(chain).velocities), **dict.fromkeys(twists)} if twists else {}
    content |= {"task": list(chain.task), "determinant": None, "singular": None}
    for part in told.ready.values():
        content |= part
    if told.kept is not None:
        content |= told.kept.data()
    missing = _missing_keys(chain, told)
    if missing:
        content["missing"] = missing
        content["note"] = " ".join(filter(None, (content.get("note"), _said(told))))
    return content


def _missing_keys(chain: Chain, told: _Told) -> list[str]:
    if not told.ended or told.left == ():
        return []
    keys = [("position", "position"), ("jacobian", "jacobian"), ("jacobian", "geometric_jacobian")]
    keys += [(name, name) for name in twists_of(chain)]
    keys += [("determinant", "determinant")] if _is_square(chain) else []
    left = told.left or (WHERE,)
    of_each = [("type", "uniform", MEANING) if key == MEANING and kind_is_sure(chain) else (key,) for key in left]
    return [*(key for name, key in keys if name not in told.ready), *itertools.chain(*of_each)]


def _is_square(chain: Chain) -> bool:
    return len(chain.task) == chain.n


_IN_WORDS = {
    WHERE: "in which configurations that is so, and what they look like",
    MEANING: "what these configurations look like",
    TESTED: "the test of these conditions in numbers",
    SPECIAL: "what holds for special lengths only",
}


def _missing_block(chain: Chain, told: _Told) -> list[str]:
    """Return what is said in the end where something is missing."""
    if not told.ended or told.left == ():
        return []
    missing = [QUESTIONS[name].title for name in _due(chain) if name not in told.ready and name != SECTIONS[-1]]
    missing += [QUESTIONS[SECTIONS[-1]].title] if told.left is None else [_IN_WORDS[name] for name in told.left]
    known = [told.kept.block()] if told.kept is not None else []
    return [*known, f"## What is missing\n\nNot worked out: {'; '.join(missing)}. {_said(told)}\n"]


def _said(told: _Told) -> str:
    """Return why something is missing, and what that means."""
    return (
        f"This ended because {told.ended}, at work on {told.now}. What is told was worked out to its end, and holds; "
        "of what is missing, nothing is claimed."
    )


def _due(chain: Chain) -> list[str]:
    """Return the names of all sections that an arm of this shape has."""
    inverse = ("inverse-jacobian", "inverse-velocity")
    left_out = () if _is_square(chain) else ("determinant", *inverse)
    if chain.n > BY_HAND:
        left_out = (*left_out, *inverse)
    told_otherwise = [  # looked at for these only: of others, whether they can be asked may take minutes to find out
        name for name in SECTIONS if QUESTIONS[name].speaks_of
    ]
    left_out = (*left_out, *(name for name in told_otherwise if QUESTIONS[name].objects(chain) is not None))
    return [name for name in SECTIONS if name not in left_out]
