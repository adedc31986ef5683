"""Run `qdot solve` within a time limit: print each result when it is ready, and finally list what is missing."""

import itertools
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.common.time_limit import OutOfTime, time_limit
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import MAX_JOINTS_FOR_INVERSE
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.solver import (
    DESCRIPTION,
    NUMERIC_TEST,
    SECTIONS,
    SINGULAR_SET,
    SPECIAL_LENGTHS,
    PartialResult,
    ReadyResult,
    Stages,
    data_json,
    data_stages,
    render_article,
    text_heading,
    text_stages,
    twist_jacobian_names,
)
from qdot.exercises.writing.markup import to_text

ShowProgress = Callable[[str], AbstractContextManager[object]]
"""A function that returns a context manager; it displays the given text while its block runs."""


@dataclass
class _Progress:
    """The results that are ready, by name and in order, and a description of the current step."""

    ready_results: dict[str, Any] = field(default_factory=dict)
    current_step: str = "the arm itself"
    partial_result: PartialResult | None = None
    """What is known about the singular set before it is ready."""
    missing: tuple[str, ...] | None = None
    """The results that are still missing for that set; None if nothing is known about it."""
    end_reason: str = ""
    """The reason why results are missing; empty if none are."""


def write_solution(
    robot: Robot, output_format: str, seconds: float, write: Callable[[str], None], show_progress: ShowProgress
) -> None:
    """Print the derivation of an arm as text, LaTeX or JSON; text is printed section by section.

    The derivation stops after `seconds` of processor time. If Ctrl+C stops it, print all that is ready, then raise
    KeyboardInterrupt.
    """
    chain, progress = robot.chain, _Progress()
    stages = data_stages(chain) if output_format == "json" else text_stages(robot)
    stop: KeyboardInterrupt | None = None
    try:
        if output_format == "text":
            write(text_heading(chain))
        with time_limit(seconds):
            _run_stages(
                stages,
                progress,
                (lambda block: write(f"\n{to_text(block)}")) if output_format == "text" else None,
                show_progress,
            )
    except OutOfTime:
        progress.end_reason = f"the {seconds:g} seconds of processor time were used up (`--time` allows more)"
    except KeyboardInterrupt as error:
        progress.end_reason, stop = "it was interrupted", error
    if output_format == "json":
        write(data_json(_make_data(robot, progress)))
    elif output_format == "latex":
        write(
            render_article(chain, [*filter(None, progress.ready_results.values()), *_describe_missing(chain, progress)])
        )
    else:
        for block in _describe_missing(chain, progress):
            write(f"\n{to_text(block)}")
    if stop is not None:
        raise stop


def _run_stages(
    stages: Stages, progress: _Progress, write: Callable[[str], None] | None, show_progress: ShowProgress
) -> None:
    """Run the stages, and store the results as they become ready."""
    while True:
        with show_progress(progress.current_step):
            stage = next(stages, None)
        if stage is None:
            return
        if isinstance(stage, ReadyResult):
            if write is not None and stage.content:
                write(stage.content)
            progress.ready_results[stage.name] = (
                stage.content
            )  # after printing: a partly printed section counts as missing
            if stage.missing is not None:
                progress.partial_result, progress.missing = None, stage.missing
        elif isinstance(stage, PartialResult):
            progress.partial_result, progress.missing = stage, stage.missing
        else:
            progress.current_step = stage


def _make_data(robot: Robot, progress: _Progress) -> dict[str, Any]:
    """Return the available results as plain data; missing results are null, and listed."""
    chain = robot.chain
    content: dict[str, Any] = {"name": chain.title} | ({"rounded": True} if robot.is_table_rounded else {})
    content |= {"position": None, "jacobian": None, "geometric_jacobian": None}
    twists = twist_jacobian_names(chain)
    content |= {"twist_rows": list(convention_of(chain).velocity_names), **dict.fromkeys(twists)} if twists else {}
    content |= {"task": list(chain.task), "determinant": None, "singular": None}
    for part in progress.ready_results.values():
        content |= part
    if progress.partial_result is not None:
        content |= progress.partial_result.make_data()
    missing = _missing_keys(chain, progress)
    if missing:
        content["missing"] = missing
        content["note"] = " ".join(filter(None, (content.get("note"), _explain_end(progress))))
    return content


def _missing_keys(chain: Chain, progress: _Progress) -> list[str]:
    if not progress.end_reason or progress.missing == ():
        return []
    keys = [("position", "position"), ("jacobian", "jacobian"), ("jacobian", "geometric_jacobian")]
    keys += [(name, name) for name in twist_jacobian_names(chain)]
    keys += [("determinant", "determinant")] if _is_square(chain) else []
    remaining = progress.missing or (SINGULAR_SET,)
    names = [
        ("type", "uniform", DESCRIPTION) if key == DESCRIPTION and can_establish_kind(chain) else (key,)
        for key in remaining
    ]
    return [*(key for name, key in keys if name not in progress.ready_results), *itertools.chain(*names)]


def _is_square(chain: Chain) -> bool:
    return len(chain.task) == chain.n


_RESULT_DESCRIPTIONS = {
    SINGULAR_SET: "these configurations and their geometry",
    DESCRIPTION: "the geometry of these configurations",
    NUMERIC_TEST: "the numeric test of these conditions",
    SPECIAL_LENGTHS: "the case of special lengths",
}


def _describe_missing(chain: Chain, progress: _Progress) -> list[str]:
    """Return the closing remark if results are missing, else nothing."""
    if not progress.end_reason or progress.missing == ():
        return []
    missing = [
        QUESTIONS[name].title
        for name in _expected_sections(chain)
        if name not in progress.ready_results and name != SECTIONS[-1]
    ]
    missing += (
        [QUESTIONS[SECTIONS[-1]].title]
        if progress.missing is None
        else [_RESULT_DESCRIPTIONS[name] for name in progress.missing]
    )
    known_results = [progress.partial_result.render_markdown()] if progress.partial_result is not None else []
    return [*known_results, f"## What is missing\n\nNot derived: {'; '.join(missing)}. {_explain_end(progress)}\n"]


def _explain_end(progress: _Progress) -> str:
    """Return a sentence on why results are missing, and what that means."""
    return (
        f"qdot stopped because {progress.end_reason}, at this step: {progress.current_step}. All results given here "
        "are complete."
    )


def _expected_sections(chain: Chain) -> list[str]:
    """Return the names of all sections that an arm with this number of joints and rows has."""
    inverse = ("inverse-jacobian", "inverse-velocity")
    omitted = () if _is_square(chain) else ("determinant", *inverse)
    if chain.n > MAX_JOINTS_FOR_INVERSE:
        omitted = (*omitted, *inverse)
    convention_sections = [  # `find_objection` is asked only for these: for other sections, it may take minutes
        name for name in SECTIONS if QUESTIONS[name].required_feature
    ]
    omitted = (*omitted, *(name for name in convention_sections if QUESTIONS[name].find_objection(chain) is not None))
    return [name for name in SECTIONS if name not in omitted]
