"""Run `qdot solve` within a time limit: print each result when it is ready, and finally list what is missing."""

from collections.abc import Callable, Iterator
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
    INVERSE_SECTIONS,
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

    def write_block(block: str) -> None:
        write(f"\n{to_text(block)}")

    try:
        if output_format == "text":
            write(text_heading(chain))
        with time_limit(seconds):
            _run_stages(stages, progress, write_block if output_format == "text" else None, show_progress)
    except OutOfTime:
        progress.end_reason = f"the {seconds:g} seconds of processor time were used up (`--time` allows more)"
    except KeyboardInterrupt as error:
        progress.end_reason, stop = "it was interrupted", error
    if output_format == "json":
        write(data_json(_make_data(robot, progress)))
    elif output_format == "latex":
        ready = filter(None, progress.ready_results.values())
        write(render_article(chain, [*ready, *_describe_missing(chain, progress)]))
    else:
        for block in _describe_missing(chain, progress):
            write_block(block)
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
            # stored after printing: a partly printed section counts as missing
            progress.ready_results[stage.name] = stage.content
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
    missing = list(_missing_keys(chain, progress))
    if missing:
        content["missing"] = missing
        content["note"] = " ".join(filter(None, (content.get("note"), _explain_end(progress))))
    return content


def _missing_keys(chain: Chain, progress: _Progress) -> Iterator[str]:
    """Yield the keys of the missing results."""
    if not progress.end_reason or progress.missing == ():
        return
    names = ["position", "jacobian", *twist_jacobian_names(chain), *(["determinant"] if _is_square(chain) else [])]
    missing = [name for name in names if name not in progress.ready_results]
    for key in [*missing, *(progress.missing or (SINGULAR_SET,))]:
        if key == DESCRIPTION and can_establish_kind(chain):
            yield from ("type", "uniform")
        yield key
        if key == "jacobian":
            yield "geometric_jacobian"


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
    sections = [name for name in _expected_sections(chain) if name not in (*progress.ready_results, SECTIONS[-1])]
    missing = [QUESTIONS[name].title for name in sections]
    results = [_RESULT_DESCRIPTIONS[name] for name in progress.missing or ()]
    missing += [QUESTIONS[SECTIONS[-1]].title] if progress.missing is None else results
    known_results = [progress.partial_result.render_markdown()] if progress.partial_result is not None else []
    return [*known_results, f"## What is missing\n\nNot derived: {'; '.join(missing)}. {_explain_end(progress)}\n"]


def _explain_end(progress: _Progress) -> str:
    """Return a sentence on why results are missing, and what that means."""
    step = f"qdot stopped because {progress.end_reason}, at this step: {progress.current_step}."
    return f"{step} All results given here are complete."


def _expected_sections(chain: Chain) -> list[str]:
    """Return the names of all sections that an arm with this number of joints and rows has."""
    omitted = set() if _is_square(chain) else {"determinant", *INVERSE_SECTIONS}
    if chain.n > MAX_JOINTS_FOR_INVERSE:
        omitted |= {*INVERSE_SECTIONS}
    # `find_objection` is called only for sections of a convention: for other sections, it may take minutes
    with_feature = [name for name in SECTIONS if QUESTIONS[name].required_feature]
    omitted |= {name for name in with_feature if QUESTIONS[name].find_objection(chain) is not None}
    return [name for name in SECTIONS if name not in omitted]
