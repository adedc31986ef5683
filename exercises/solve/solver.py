"""Derive the results of the chapter for a user's own arm: as data, step by step for a terminal, and as LaTeX.

The derivation is a generator of *events*: descriptions of the next step, results that are ready, and partial results.
So `time_limited` can print each result when it is ready. If time runs out, it can say which results are missing.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import SCREWS, Convention
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import TooLong, derive
from qdot.exercises.formula.sympy_text import make_matrix_json
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import MAX_JOINTS_FOR_INVERSE
from qdot.exercises.questions.screws import derive_body_jacobian, derive_space_jacobian
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.singularities.existence_conditions import find_existence_condition
from qdot.exercises.singularities.reciprocal import elimination_applies
from qdot.exercises.singularities.singular_set import Component, find_singular_set, find_special_length_components
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certify_components
from qdot.exercises.solve.numeric_rank_check import check_rank_loss
from qdot.exercises.solve.redundant import RedundantSingularities, generate_redundant_events
from qdot.exercises.writing.latex import tex, tex_angle, tex_degrees, tex_length, tex_result
from qdot.exercises.writing.markup import escape_latex, to_latex
from qdot.exercises.writing.problem_texts import get_solution_steps, write_next_solution
from qdot.exercises.writing.render import render
from qdot.exercises.writing.solution_steps import SingularComponent
from qdot.exercises.writing.wording import Wording, format_coordinates

SECTIONS = (
    "home-screws", "position", "jacobian", "velocity", "joint-axes", "position-vectors", "geometric-jacobian", "twist",
    "space-jacobian", "body-jacobian", "determinant", "inverse-jacobian", "inverse-velocity", "singular-angles",
)  # fmt: skip
"""The sections of a derivation, in the chapter's order; each is named after its question."""
INVERSE_SECTIONS = ("inverse-jacobian", "inverse-velocity")
"""The sections that arms with more than MAX_JOINTS_FOR_INVERSE joints don't have."""
ARM_SECTION_COUNT = 2
"""Number of sections before SECTIONS: they describe the arm and its transformations."""
ALWAYS_SINGULAR = (
    "The Jacobian for this task has less than full rank in every configuration, so there are no particular singular "
    "configurations. Choose other rows (`task`) or another point (`point`)."
)
NEVER_SINGULAR = (
    "The Jacobian for this task has full rank in every configuration: the arm has no singular configuration."
)


@dataclass(frozen=True)
class Solution:
    """The symbolic results that `solve` returns for an arm.

    - `position`: the position of the point of interest (3 x 1, m).
    - `jacobian`: the linear rows of the geometric Jacobian (3 x n).
    - `geometric`: the geometric Jacobian (6 x n), linear rows first.
    - `determinant`: the determinant of the task Jacobian; None if J is not square, or if the formula is too long.
    - `singular`: the components of the singular set; None if every configuration is singular, or if the formulas are
      too long.
    - `note`: remarks on the results, for example why some are missing; None if there are no remarks.
    - `redundant`: how elimination found the singular set of an arm with more joints than task rows; None if the minors
      of the Jacobian gave the set.
    """

    chain: Chain
    position: sp.Matrix
    jacobian: sp.Matrix
    geometric: sp.Matrix
    determinant: sp.Expr | None
    singular: tuple[SingularComponent, ...] | None
    note: str | None
    redundant: RedundantSingularities | None = None

    def __repr__(self) -> str:
        return f"Solution({self.chain.name}: J {len(self.chain.task)} x {self.chain.n}, det J = {self.determinant})"


DESCRIPTION, NUMERIC_TEST = "meaning", "tested"
"""The names of results about a singular set: the description of its configurations, and the numeric test of its
conditions. They are derived in this order, after the conditions."""
SINGULAR_SET = "singular"
"""The name of the first result about a singular set: its conditions."""


@dataclass(frozen=True)
class Singularities:
    """The determinant and the components of the singular set, with remarks.

    - `determinant`, `components` and `redundant`: as in a Solution.
    - `remark`: a remark on the set itself, for example that it is empty or was not derived; after elimination, the
      result of the numeric check.
    - `test_remark`: a remark on the result of the numeric test of conditions from minors.
    - `lengths_remark`: a remark on conditions that can hold, or hold simultaneously, only for some lengths.
    - `missing_names`: the names of the results that have not been derived yet.
    """

    determinant: sp.Expr | None
    components: tuple[SingularComponent, ...] | None
    remark: str = ""
    redundant: RedundantSingularities | None = None
    test_remark: str = ""
    lengths_remark: str = ""
    missing_names: tuple[str, ...] = ()

    @property
    def note(self) -> str | None:
        """All remarks as one text; None if there are no remarks."""
        return " ".join(filter(None, (self.remark, self.test_remark, self.lengths_remark))) or None


def solve(chain: Chain) -> Solution:
    """Return the position, Jacobian, determinant and singular configurations of an arm, in the world frame (m, rad).

    Results that would be too long are omitted; in that case, `note` explains why.

    >>> from qdot import Chain, Joint
    >>> arm = Chain("mine", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, "a2", 0)), ("vx", "vy"))
    >>> solve(arm)
    Solution(mine: J 2 x 2, det J = a1*a2*sin(theta2))
    """
    derivation = derive(chain)
    *_, singularities = generate_singular_events(chain)
    assert isinstance(singularities, Singularities)
    return Solution(
        chain, derivation.position, derivation.linear_rows, derivation.geometric_jacobian, singularities.determinant,
        singularities.components, singularities.note, singularities.redundant,
    )  # fmt: skip


@dataclass(frozen=True)
class PartialResult:
    """The results on the singular set so far, in case the derivation stops before the set is complete.

    - `render_markdown`: a function that returns the known results in Markdown.
    - `make_data`: a function that returns the known results as plain data.
    - `missing_names`: the names of the results that are still missing.
    """

    render_markdown: Callable[[], str]
    make_data: Callable[[], dict[str, Any]]
    missing_names: tuple[str, ...]


def generate_singular_events(chain: Chain) -> Iterator[str | PartialResult | Singularities]:
    """Yield events of the derivation of the singular set: descriptions of the next step, partial results, and results.

    The last event is a complete `Singularities`.
    """
    yield "the determinant of J" if derive(chain).is_square else "the minors of J"
    methods = [_solve_by_elimination, _solve_by_minors] if elimination_applies(chain) else [_solve_by_minors]
    for method in methods:
        try:
            yield from method(chain)
            return
        except TooLong as error:
            reason = error
    remark = f"The singular configurations were not derived: {reason}. Position and Jacobian are complete."
    yield Singularities(determinant=None, components=None, remark=remark)


def _solve_by_minors(chain: Chain) -> Iterator[str | PartialResult | Singularities]:
    """Find the singular set by the minors of J, or by the determinant if J is square; yield events. Raises TooLong."""
    derivation = derive(chain)
    step = "where the determinant of J is zero" if derivation.is_square else "where the minors of J are all zero"
    determinant = derivation.determinant if derivation.is_square else None
    if all(minor.is_zero for minor in derivation.symbolic_minors):
        yield Singularities(determinant, None, ALWAYS_SINGULAR)
        return
    yield PartialResult(partial(_render_partial_set, chain, has_only_minors=True), dict, (SINGULAR_SET,))  # no data
    yield step
    find_singular_set(chain)  # its result is cached
    render_conditions = partial(_render_partial_set, chain, has_only_minors=False)
    yield PartialResult(render_conditions, partial(_make_conditions_data, chain), (DESCRIPTION, NUMERIC_TEST))
    yield "the geometry of the configurations in which J loses rank"
    components = certify_components(chain)
    special_conditions = _describe_special_conditions(chain)
    never_singular = "For general lengths, no configuration is singular." if special_conditions else NEVER_SINGULAR
    lengths_remark = f"{_describe_length_requirements(chain, components)} {special_conditions}".strip()
    singularities = Singularities(
        determinant, components, "" if components else never_singular, lengths_remark=lengths_remark
    )
    yield replace(singularities, missing_names=(NUMERIC_TEST,))
    yield "the numeric test of these conditions"
    yield replace(singularities, test_remark=_describe_doubts(chain, components))


def _describe_length_requirements(chain: Chain, components: Iterable[SingularComponent]) -> str:
    """Return sentences on what the symbolic lengths must satisfy so that the conditions have solutions."""
    conditions = (condition for component in components for condition in component.conditions)
    requirements = filter(None, (find_existence_condition(condition, chain) for condition in conditions))
    return " ".join(f"{requirement}." for requirement in requirements)


def _describe_doubts(chain: Chain, components: tuple[SingularComponent, ...]) -> str:
    """Return remarks on conditions that a numerical check finds to be wrong, never satisfied, or missing."""
    check = check_rank_loss(chain, [component.conditions for component in components])
    return _render_sentences("solve/doubts.md.j2", check=check, components=components) if check.arms else ""


def _render_sentences(template: str, **content: Any) -> str:
    """Return the sentences of a template on one line."""
    return " ".join(render(template, **content).split())


def _solve_by_elimination(chain: Chain) -> Iterator[str | PartialResult | Singularities]:
    """Find the singular set of a redundant arm by elimination; yield events. Raises TooLong."""
    for event in generate_redundant_events(chain):
        if isinstance(event, str):
            yield event
        elif event.is_always_singular:
            yield Singularities(None, None, ALWAYS_SINGULAR, redundant=event)
        else:
            remark = _describe_numeric_check(chain, event)
            if event.is_described:
                lengths_remark = _describe_length_requirements(chain, event.components)
                yield Singularities(None, event.components, remark, event, lengths_remark=lengths_remark)
            else:
                components = [*map(_make_component_data, event.components)]
                data = {"singular": components, "tested": event.search_counts, "note": remark}
                render_text = partial(_render_redundant, chain, event, remark=remark)
                yield PartialResult(render_text, partial(dict, data), (DESCRIPTION,))


def _describe_numeric_check(chain: Chain, redundant: RedundantSingularities) -> str:
    """Return a description of the numerical check's result, and of the lengths for which the result is valid."""
    check = redundant.check
    assert check is not None
    checked_count = sum(map(len, check.samples)) - sum(len(check.samples[k]) for k in check.full_rank_branches)
    content = {"chain": chain, "redundant": redundant, "check": check, "checked_count": checked_count}
    return _render_sentences("solve/check.md.j2", **content, never_singular=NEVER_SINGULAR)


def _render_partial_set(chain: Chain, has_only_minors: bool) -> str:
    """Return what is known about the singular set: the conditions without descriptions, or only the minors."""
    steps = get_solution_steps(chain)
    components = [] if has_only_minors else steps.components
    return render("solve/part.md.j2", chain=chain, steps=steps, components=components, has_only_minors=has_only_minors)


def _describe_special_conditions(chain: Chain) -> str:
    """Return a sentence on the conditions that hold simultaneously only for specially related lengths."""
    components = find_special_length_components(chain) if chain.parameters else ()
    cases = "; or ".join(" and ".join(f"`{c} = 0`" for c in component.conditions) for component in components)
    introduction = "These conditions can hold together only for special lengths; then more configurations are singular:"
    return f"{introduction} {cases}." if cases else ""


def format_json(content: dict[str, Any]) -> str:
    """Return plain data as the text of a JSON file."""
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _make_singular_data(chain: Chain, singularities: Singularities) -> dict[str, Any]:
    """Return the singular set as plain data."""
    has_kinds = can_establish_kind(chain)
    determinant, components = singularities.determinant, singularities.components
    content: dict[str, Any] = {
        "determinant": None if determinant is None else str(determinant),
        "singular": None if components is None else [_make_classified_data(chain, c, has_kinds) for c in components],
    }
    if singularities.redundant is not None and singularities.redundant.search_counts:
        content["tested"] = singularities.redundant.search_counts
    return content | ({"note": singularities.note} if singularities.note else {})


TWIST_JACOBIANS = {"space_jacobian": derive_space_jacobian, "body_jacobian": derive_body_jacobian}
"""Further results for an arm described by its axes, 6 x n each: their names, and the functions that derive them."""


def list_twist_jacobian_names(chain: Chain) -> tuple[str, ...]:
    """Return the names of the TWIST_JACOBIANS of an arm; none unless the arm's convention has screws."""
    return tuple(TWIST_JACOBIANS) if SCREWS in convention_of(chain).features else ()


def _make_twist_data(chain: Chain, name: str) -> dict[str, Any]:
    """Return one of TWIST_JACOBIANS as plain data; there is no body Jacobian if P is not fixed to the last link."""
    convention = convention_of(chain)
    has_result = name != "body_jacobian" or QUESTIONS["body-jacobian"].find_arm_objection(chain) is None
    rows = _to_text_rows(convention.reorder_twists(TWIST_JACOBIANS[name](chain))) if has_result else None
    return {"twist_rows": list(convention.velocity_names), name: rows}


def _to_text_rows(matrix: sp.Matrix) -> list[list[str]]:
    return [[*map(str, row)] for row in matrix.tolist()]


def _make_classified_data(chain: Chain, component: SingularComponent, has_kind: bool) -> dict[str, Any]:
    """Return the conditions, the kind and the meaning of a component as plain data."""
    classification = component.classification
    kind = {"type": classification.kind, "uniform": classification.is_uniform} if classification.kind else {}
    meaning = convention_of(chain).rename_origins(classification.meaning) or None
    return _make_component_data(component) | (kind if has_kind else {}) | {"meaning": meaning}


def _make_component_data(component: SingularComponent | Component) -> dict[str, Any]:
    """Return the conditions of a component as plain data; kind and meaning are None."""
    conditions = [str(condition) for condition in component.conditions]
    solutions = {joint.name: [*map(str, values)] for joint, values in component.solutions or ()} or None
    content = {"condition": " and ".join(conditions), "conditions": conditions, "solutions": solutions}
    return content | dict.fromkeys(("type", "uniform", "meaning"))


def _make_conditions_data(chain: Chain) -> dict[str, Any]:
    """Return the singular set as plain data before its configurations have been described."""
    return {"singular": [*map(_make_component_data, get_solution_steps(chain).components)]}


# --- step by step ---


def format_heading(chain: Chain) -> str:
    """Return the heading of a derivation on a terminal."""
    title = f"Velocity kinematics of {chain.title}"
    return f"{title}\n{'=' * len(title)}\n"


def render_article(chain: Chain, blocks: Iterable[str]) -> str:
    """Return the blocks of a derivation, which are Markdown, as a LaTeX article."""
    return render("solve/arm.tex.j2", title=escape_latex(chain.title), body="\n".join(map(to_latex, blocks)))


@dataclass(frozen=True)
class ReadyResult:
    """An event: a result that is ready.

    - `name`: the name of a section, or a key of the plain data.
    - `content`: the result, in Markdown or as plain data; it may be empty.
    - `missing_names`: the names of results about the singular set that are still missing; None for a result about
      something else.
    """

    name: str
    content: Any
    missing_names: tuple[str, ...] | None = None


Events = Iterator[str | PartialResult | ReadyResult]
"""An iterator of events: descriptions of the next step, partial results, and results that are ready."""


def generate_text_events(robot: Robot) -> Events:
    """Yield the events of a derivation in Markdown: the arm, then each section under its name, then remarks."""
    yield "the arm's transformations"
    chain = robot.chain
    wording, steps = Wording(chain), get_solution_steps(chain)
    description = _describe_arm(robot)
    is_same_table = description is not None and not description.base and description.rows == wording.rows
    if is_same_table or not wording.convention.shows_table:
        description = None  # because the template's standard text would repeat it
    content = {"chain": chain, "w": wording, "steps": steps, "tex": tex, "description": description}
    yield ReadyResult("arm", render("solve/arm.md.j2", **content, is_rounded=robot.is_table_rounded))
    parts: list[Part] = []
    explained_terms: set[str] = set()
    for name in SECTIONS[:-1]:
        yield QUESTIONS[name].title.lower()
        yield ReadyResult(name, _render_section(chain, name, parts, explained_terms))
    yield from _generate_singular_text_events(chain, robot, parts, explained_terms)


def _generate_singular_text_events(chain: Chain, robot: Robot, parts: list[Part], explained_terms: set[str]) -> Events:
    """Yield the events of the section on the singular set and of its numeric test."""
    # The first Singularities is for the section on the set, the second (if any) for its numeric test.
    names = iter((SECTIONS[-1], "test"))
    number = len(parts) + 1 + ARM_SECTION_COUNT
    for event in generate_singular_events(chain):
        if not isinstance(event, Singularities):
            yield event
            continue
        name, blocks = next(names), list[str]()
        if name == "test":
            title, remark = "Remarks", event.test_remark
        else:
            yield "the singular configurations, step by step"
            section = _render_singular_section(chain, robot, event, parts, explained_terms)
            blocks.append(section)
            number += 1 if section else 0
            title_after_section = "Remarks" if event.components is None else "Numeric test"  # of elimination
            title, remark = title_after_section if section else "Singular configurations", event.remark
        if remark:
            blocks.append(f"## {number}. {title}\n\n{remark}\n")
            number += 1
        if event.lengths_remark and not event.missing_names:
            blocks.append(f"## {number}. Special lengths\n\n{event.lengths_remark}\n")
        yield ReadyResult(name, "\n".join(filter(None, blocks)), event.missing_names)


def _render_singular_section(
    chain: Chain, robot: Robot, singularities: Singularities, parts: list[Part], explained_terms: set[str]
) -> str:
    """Return the section on the singular set, with the joint values that limits exclude.

    The section is empty if the question about singular configurations does not apply to the arm.
    """
    if singularities.redundant is not None:
        text = _render_redundant(chain, singularities.redundant, len(parts) + 1 + ARM_SECTION_COUNT)
    else:
        text = _render_section(chain, SECTIONS[-1], parts, explained_terms)
    excluded_values = _describe_values_beyond_limits(chain, robot, singularities.components or ())
    remarks = [f"The joint limits rule out {'; '.join(excluded_values)}."] if excluded_values else []
    if singularities.components and robot.is_table_rounded:
        remarks.append("The numbers in these conditions are rounded, like those of the arm.")
    return "\n\n".join([text, *remarks]) + "\n" if remarks else text


def _render_section(chain: Chain, name: str, parts: list[Part], explained_terms: set[str]) -> str:
    """Return the section of a question, and append the question's part to `parts`.

    The section is empty if the question does not apply to the arm, or if the answer would be too long to be read.
    `explained_terms` collects the terms that earlier sections have explained.
    """
    question = QUESTIONS[name]
    is_unreadable = chain.n > MAX_JOINTS_FOR_INVERSE and name in INVERSE_SECTIONS
    if is_unreadable or question.find_objection(chain) is not None:
        return ""
    answer, details = question.ask(chain, Stream("solve"))
    parts.append(Part(name, name, answer, details=details))
    text = write_next_solution(Problem(ProblemId("own", 0), chain, tuple(parts)), explained_terms)
    return f"## {len(parts) + ARM_SECTION_COUNT}. {question.make_title(chain)}\n\n{text}"


def _render_redundant(
    chain: Chain, redundant: RedundantSingularities, number: int | None = None, remark: str = ""
) -> str:
    """Return the section on the singular set of a redundant arm, with a remark at its end.

    An incomplete section has no number.
    """
    wording, steps = Wording(chain), get_solution_steps(chain)
    text = render("solve/redundant.md.j2", chain=chain, w=wording, steps=steps, redundant=redundant, number=number)
    return f"{text}\n{remark}\n" if remark else text


def generate_data_events(chain: Chain) -> Events:
    """Yield the events of a derivation as plain data; the names of results are keys."""
    derivation = derive(chain)
    yield "the position"
    yield ReadyResult("position", {"position": make_matrix_json(derivation.position)})
    yield "the Jacobian"
    rows = _to_text_rows(derivation.geometric_jacobian)
    yield ReadyResult("jacobian", {"jacobian": rows[:3], "geometric_jacobian": rows})
    for name in list_twist_jacobian_names(chain):
        yield f"the {name.replace('_j', ' J')}"  # such as "the space Jacobian"
        yield ReadyResult(name, _make_twist_data(chain, name))
    if derivation.is_square:
        yield "the determinant"
        with suppress(TooLong):
            yield ReadyResult("determinant", {"determinant": str(derivation.determinant)})
    for event in generate_singular_events(chain):
        if isinstance(event, Singularities):
            yield ReadyResult("singular", _make_singular_data(chain, event), event.missing_names)
        else:
            yield event


@dataclass(frozen=True)
class _ArmDescription:
    """The arm as its file describes it: the convention, the cells of the rows in LaTeX, and the base in words."""

    convention: type[Convention]
    rows: list[list[str]]
    base: str


def _describe_arm(robot: Robot) -> _ArmDescription | None:
    """Return the arm as described in its file; None if the file contains the standard table."""
    if (written_arm := robot.written_arm) is None:
        return None
    base = ""
    if written_arm.base is not None:
        position, rpy = written_arm.base
        angles = ", ".join(f"${tex_angle(angle)}$" for angle in rpy)
        base = f"at ${format_coordinates(position)}$"
        base += f", rotated by roll, pitch and yaw of {angles}" if any(rpy) else ""
    convention = written_arm.convention
    return _ArmDescription(convention, [_format_cells(convention, row) for row in written_arm.rows], base)


def _format_cells(convention: type[Convention], row: Joint | Axis) -> list[str]:
    """Return the cells, in LaTeX, of a row that describes a joint."""
    if isinstance(row, Axis):
        point = "-" if row.is_prismatic else format_coordinates(row.point)
        return [f"({', '.join(map(tex, row.direction))})", point]
    return convention.order_entries(tex_angle(row.theta), tex_length(row.d), tex_length(row.a), tex_angle(row.alpha))


def _describe_values_beyond_limits(chain: Chain, robot: Robot, components: Iterable[SingularComponent]) -> list[str]:
    """Return the joint values of singular configurations that lie outside the joint limits, as texts."""
    limits = dict(zip(chain.q, robot.limits, strict=False))
    excluded_values = []
    for component in components:
        for joint, values in component.solutions or ():
            joint_limits = limits.get(joint)
            if joint_limits is None:
                continue
            low, high = joint_limits
            is_length = joint.name.startswith("d")
            turns = (0,) if is_length else (-2 * sp.pi, 0, 2 * sp.pi)  # a joint may also reach an angle a turn away
            outer_values = [v for v in values if v.is_number and not any(low <= v + turn <= high for turn in turns)]
            format_limit = tex_length if is_length else tex_degrees
            limits_text = f"from ${format_limit(low)}$ to ${format_limit(high)}$"
            excluded_values += [
                f"${tex(joint)} = {tex_result(value, joint)}$ ({limits_text})" for value in outer_values
            ]
    return list(dict.fromkeys(excluded_values))
