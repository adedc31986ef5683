"""Run `qdot solve` within a time limit: print each result when it is ready, and finally list what is missing."""

import itertools
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.arm.singularity_kinds import kind_is_sure
from qdot.exercises.common.time_limit import OutOfTime, time_limit
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import BY_HAND
from qdot.exercises.solve.solver import (
    MEANING,
    SECTIONS,
    SPECIAL,
    TESTED,
    WHERE,
    PartialResult,
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

ShowProgress = Callable[[str], AbstractContextManager[object]]
"""A function that returns a context manager; it displays the given text while its block runs."""


@dataclass
class _Progress:
    """The results that are ready, by name and in order, and a description of the current step."""

    ready: dict[str, Any] = field(default_factory=dict)
    now: str = "the arm itself"
    partial_result: PartialResult | None = None
    """What is known about the singular set before it is ready."""
    left: tuple[str, ...] | None = None
    """The results that are still missing for that set; None if nothing is known about it."""
    ended: str = ""
    """The reason why results are missing; empty if none are."""


def write_solution(
    robot: Robot, form: str, seconds: float, say: Callable[[str], None], show_progress: ShowProgress
) -> None:
    """Print the derivation of an arm as text, LaTeX or JSON; text is printed section by section.

    The derivation stops after `seconds` of processor time. If Ctrl+C stops it, print all that is ready, then raise
    KeyboardInterrupt.
    """
    chain, progress = robot.chain, _Progress()
    stages = data_stages(chain) if form == "json" else text_stages(chain, robot)
    stop: KeyboardInterrupt | None = None
    try:
        if form == "text":
            say(text_heading(chain))
        with time_limit(seconds):
            _run_stages(
                stages, progress, (lambda block: say(f"\n{to_text(block)}")) if form == "text" else None, show_progress
            )
    except OutOfTime:
        progress.ended = f"the {seconds:g} seconds of processor time were over (`--time` gives it more)"
    except KeyboardInterrupt as error:
        progress.ended, stop = "it was stopped", error
    if form == "json":
        say(data_json(_data(robot, progress)))
    elif form == "latex":
        say(article(chain, [*filter(None, progress.ready.values()), *_missing_block(chain, progress)]))
    else:
        for block in _missing_block(chain, progress):
            say(f"\n{to_text(block)}")
    if stop is not None:
        raise stop


def _run_stages(
    stages: Stages, progress: _Progress, say: Callable[[str], None] | None, show_progress: ShowProgress
) -> None:
    """Run the stages, and store the results as they become ready."""
    while True:
        with show_progress(progress.now):
            stage = next(stages, None)
        if stage is None:
            return
        if isinstance(stage, Ready):
            if say is not None and stage.content:
                say(stage.content)
            progress.ready[stage.name] = stage.content  # after printing: a partly printed section counts as missing
            if stage.left is not None:
                progress.partial_result, progress.left = None, stage.left
        elif isinstance(stage, PartialResult):
            progress.partial_result, progress.left = stage, stage.left
        else:
            progress.now = stage


def _data(robot: Robot, progress: _Progress) -> dict[str, Any]:
    """Return the available results as plain data; missing results are null, and listed."""
    chain = robot.chain
    content: dict[str, Any] = {"name": chain.title} | ({"rounded": True} if robot.rounded else {})
    content |= {"position": None, "jacobian": None, "geometric_jacobian": None}
    twists = twists_of(chain)
    content |= {"twist_rows": list(convention_of(chain).velocities), **dict.fromkeys(twists)} if twists else {}
    content |= {"task": list(chain.task), "determinant": None, "singular": None}
    for part in progress.ready.values():
        content |= part
    if progress.partial_result is not None:
        content |= progress.partial_result.data()
    missing = _missing_keys(chain, progress)
    if missing:
        content["missing"] = missing
        content["note"] = " ".join(filter(None, (content.get("note"), _explain_end(progress))))
    return content


def _missing_keys(chain: Chain, progress: _Progress) -> list[str]:
    if not progress.ended or progress.left == ():
        return []
    keys = [("position", "position"), ("jacobian", "jacobian"), ("jacobian", "geometric_jacobian")]
    keys += [(name, name) for name in twists_of(chain)]
    keys += [("determinant", "determinant")] if _is_square(chain) else []
    remaining = progress.left or (WHERE,)
    names = [("type", "uniform", MEANING) if key == MEANING and kind_is_sure(chain) else (key,) for key in remaining]
    return [*(key for name, key in keys if name not in progress.ready), *itertools.chain(*names)]


def _is_square(chain: Chain) -> bool:
    return len(chain.task) == chain.n


_IN_WORDS = {
    WHERE: "in which configurations that is so, and what they look like",
    MEANING: "what these configurations look like",
    TESTED: "the test of these conditions in numbers",
    SPECIAL: "what holds for special lengths only",
}


def _missing_block(chain: Chain, progress: _Progress) -> list[str]:
    """Return the closing remark if results are missing, else nothing."""
    if not progress.ended or progress.left == ():
        return []
    missing = [
        QUESTIONS[name].title
        for name in _expected_sections(chain)
        if name not in progress.ready and name != SECTIONS[-1]
    ]
    missing += [QUESTIONS[SECTIONS[-1]].title] if progress.left is None else [_IN_WORDS[name] for name in progress.left]
    known_results = [progress.partial_result.block()] if progress.partial_result is not None else []
    return [*known_results, f"## What is missing\n\nNot worked out: {'; '.join(missing)}. {_explain_end(progress)}\n"]


def _explain_end(progress: _Progress) -> str:
    """Return a sentence on why results are missing, and what that means."""
    return (
        f"This ended because {progress.ended}, at work on {progress.now}. What is told was worked out to its "
        "end, and holds; of what is missing, nothing is claimed."
    )


def _expected_sections(chain: Chain) -> list[str]:
    """Return the names of all sections that an arm with this number of joints and rows has."""
    inverse = ("inverse-jacobian", "inverse-velocity")
    omitted = () if _is_square(chain) else ("determinant", *inverse)
    if chain.n > BY_HAND:
        omitted = (*omitted, *inverse)
    convention_sections = [  # `objects` is asked only for these: for other sections, it may take minutes
        name for name in SECTIONS if QUESTIONS[name].speaks_of
    ]
    omitted = (*omitted, *(name for name in convention_sections if QUESTIONS[name].objects(chain) is not None))
    return [name for name in SECTIONS if name not in omitted]
