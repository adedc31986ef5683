"""Run `qdot solve` within a time limit: print each result when it is ready, and list what is missing at the end.

A derivation yields events, which `solver` defines.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.common.time_limit import OutOfTime, time_limit
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import MAX_JOINTS_FOR_INVERSE
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.solver import (
    DESCRIPTION,
    INVERSE_SECTIONS,
    NUMERIC_TEST,
    SECTIONS,
    SINGULAR_SET,
    Events,
    PartialResult,
    ReadyResult,
    format_heading,
    format_json,
    generate_data_events,
    generate_text_events,
    list_twist_jacobian_names,
    render_article,
)
from qdot.exercises.writing.markup import to_text

ShowProgress = Callable[[str], AbstractContextManager[object]]
"""A function that returns a context manager, which displays a text while its block runs."""


@dataclass
class _Progress:
    """The progress of a derivation.

    - `ready_results`: the results that are ready, by name and in order.
    - `current_step`: a description of the current step.
    - `partial_result`: what is known about the singular set before the set is ready.
    - `missing_names`: the names of the missing results about the singular set; None if nothing is known about it.
    - `end_reason`: the reason why the derivation stopped early; empty if it did not.
    """

    ready_results: dict[str, Any] = field(default_factory=dict)
    current_step: str = "the arm itself"
    partial_result: PartialResult | None = None
    missing_names: tuple[str, ...] | None = None
    end_reason: str = ""


def write_solution(
    robot: Robot, output_format: str, seconds: float, write: Callable[[str], None], show_progress: ShowProgress
) -> None:
    """Print the derivation for an arm in an output format: "text", "latex" or "json".

    Text is printed section by section. The derivation stops after `seconds` of processor time, or at Ctrl+C. Then the
    results that are ready are printed. After Ctrl+C, KeyboardInterrupt is raised at the end.
    """
    chain, progress = robot.chain, _Progress()
    events = generate_data_events(chain) if output_format == "json" else generate_text_events(robot)
    interrupt: KeyboardInterrupt | None = None

    def write_block(block: str) -> None:
        write(f"\n{to_text(block)}")

    try:
        if output_format == "text":
            write(format_heading(chain))
        with time_limit(seconds):
            _process_events(events, progress, write_block if output_format == "text" else None, show_progress)
    except OutOfTime:
        progress.end_reason = f"the {seconds:g} seconds of processor time were used up (`--time` allows more)"
    except KeyboardInterrupt as error:
        progress.end_reason, interrupt = "it was interrupted", error
    if output_format == "json":
        write(format_json(_make_data(robot, progress)))
    elif output_format == "latex":
        ready_blocks = filter(None, progress.ready_results.values())
        write(render_article(chain, [*ready_blocks, *_describe_missing(chain, progress)]))
    else:
        for block in _describe_missing(chain, progress):
            write_block(block)
    if interrupt is not None:
        raise interrupt


def _process_events(
    events: Events, progress: _Progress, write: Callable[[str], None] | None, show_progress: ShowProgress
) -> None:
    """Derive results until the events end; store results as they become ready, and print them if `write` is given."""
    while True:
        with show_progress(progress.current_step):
            event = next(events, None)
        if event is None:
            return
        if isinstance(event, ReadyResult):
            if write is not None and event.content:
                write(event.content)
            # stored after printing: a partly printed section counts as missing
            progress.ready_results[event.name] = event.content
            if event.missing_names is not None:
                progress.partial_result, progress.missing_names = None, event.missing_names
        elif isinstance(event, PartialResult):
            progress.partial_result, progress.missing_names = event, event.missing_names
        else:
            progress.current_step = event


def _make_data(robot: Robot, progress: _Progress) -> dict[str, Any]:
    """Return the available results as plain data; missing results are None, and their keys are listed."""
    chain = robot.chain
    content: dict[str, Any] = {"name": chain.title} | ({"rounded": True} if robot.is_table_rounded else {})
    content |= {"position": None, "jacobian": None, "geometric_jacobian": None}
    names = list_twist_jacobian_names(chain)
    content |= {"twist_rows": list(convention_of(chain).velocity_names), **dict.fromkeys(names)} if names else {}
    content |= {"task": list(chain.task), "determinant": None, "singular": None}
    for result in progress.ready_results.values():
        content |= result
    if progress.partial_result is not None:
        content |= progress.partial_result.make_data()
    missing_keys = list(_list_missing_keys(chain, progress))
    if missing_keys:
        content["missing"] = missing_keys
        content["note"] = " ".join(filter(None, (content.get("note"), _explain_end(progress))))
    return content


def _list_missing_keys(chain: Chain, progress: _Progress) -> Iterator[str]:
    """Yield the keys of the missing results."""
    if not progress.end_reason or progress.missing_names == ():
        return
    names = ["position", "jacobian", *list_twist_jacobian_names(chain)]
    names += ["determinant"] if chain.has_square_jacobian else []
    missing_names = [name for name in names if name not in progress.ready_results]
    for key in [*missing_names, *(progress.missing_names or (SINGULAR_SET,))]:
        if key == DESCRIPTION and can_establish_kind(chain):
            yield from ("type", "uniform")
        yield key
        if key == "jacobian":
            yield "geometric_jacobian"


_RESULT_DESCRIPTIONS = {
    SINGULAR_SET: "these configurations and their geometry",
    DESCRIPTION: "the geometry of these configurations",
    NUMERIC_TEST: "the numeric test of these conditions",
}


def _describe_missing(chain: Chain, progress: _Progress) -> list[str]:
    """Return the closing remark, and what is known about the singular set, if results are missing; else nothing."""
    if not progress.end_reason or progress.missing_names == ():
        return []
    sections = [name for name in _list_expected_sections(chain) if name not in (*progress.ready_results, SECTIONS[-1])]
    missing_titles = [QUESTIONS[name].title for name in sections]
    results = [_RESULT_DESCRIPTIONS[name] for name in progress.missing_names or ()]
    missing_titles += [QUESTIONS[SECTIONS[-1]].title] if progress.missing_names is None else results
    known_results = [progress.partial_result.render_markdown()] if progress.partial_result is not None else []
    return [
        *known_results,
        f"## What is missing\n\nNot derived: {'; '.join(missing_titles)}. {_explain_end(progress)}\n",
    ]


def _explain_end(progress: _Progress) -> str:
    """Return sentences that say why results are missing, and that the other results are complete."""
    step = f"qdot stopped because {progress.end_reason}, at this step: {progress.current_step}."
    return f"{step} All results given here are complete."


def _list_expected_sections(chain: Chain) -> list[str]:
    """Return the names of all sections that an arm with this number of joints and rows has."""
    omitted_sections = set() if chain.has_square_jacobian else {"determinant", *INVERSE_SECTIONS}
    if chain.n > MAX_JOINTS_FOR_INVERSE:
        omitted_sections |= {*INVERSE_SECTIONS}
    # `find_objection` is called only for sections that need a feature of a convention; for others, it may take minutes
    sections_with_feature = [name for name in SECTIONS if QUESTIONS[name].required_feature]
    omitted_sections |= {name for name in sections_with_feature if QUESTIONS[name].find_objection(chain) is not None}
    return [name for name in SECTIONS if name not in omitted_sections]
