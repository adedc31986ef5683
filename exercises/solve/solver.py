"""Derive everything in the chapter for a user's own arm: as data, step by step for a terminal, and as LaTeX."""

import json
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES, SCREWS, Convention
from qdot.exercises.arm.derivation import TooLong, derive
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.sympy_text import matrix_json
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import MAX_JOINTS_FOR_INVERSE
from qdot.exercises.questions.screws import derive_body_jacobian, derive_space_jacobian
from qdot.exercises.singularities.numeric_rank_check import check_rank_loss
from qdot.exercises.singularities.reciprocal import elimination_applies
from qdot.exercises.singularities.singularity import Component, singular_set, special_length_components
from qdot.exercises.singularities.singularity_kinds import can_establish_kind
from qdot.exercises.solve.certified_singularities import certified_components
from qdot.exercises.solve.redundant import RedundantSingularities, redundant_stages
from qdot.exercises.solve.special_lengths import (
    SpecialLength,
    find_special_lengths,
    length_relations,
    length_requirements,
)
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_value
from qdot.exercises.writing.markup import escape_latex, to_latex
from qdot.exercises.writing.problem_texts import get_solution_steps, write_next_solution
from qdot.exercises.writing.render import render
from qdot.exercises.writing.solution_steps import SingularComponent
from qdot.exercises.writing.wording import Wording, format_coordinates

SECTIONS = (
    "home-screws", "position", "jacobian", "velocity", "joint-axes", "position-vectors", "geometric-jacobian", "twist",
    "space-jacobian", "body-jacobian", "determinant", "inverse-jacobian", "inverse-velocity", "singular-angles",
)  # fmt: skip
"""The sections of a derivation, in the chapter's order."""
INVERSE_SECTIONS = ("inverse-jacobian", "inverse-velocity")
ALWAYS_SINGULAR = (
    "The Jacobian for this task has less than full rank in every configuration, so there are no particular singular "
    "configurations. Choose other rows (`task`) or another point (`point`)."
)
NEVER_SINGULAR_FOR_GENERIC_LENGTHS = "For general lengths, no configuration is singular."
NOT_DERIVED = "The singular configurations were not derived: {}. Position and Jacobian are complete."
SPECIAL_LENGTHS_INTRODUCTION = (
    "These conditions can hold together only for special lengths; then more configurations are singular:"
)
ROUNDED_NOTE = (
    "Some numbers have no short form. They are rounded to ten decimals, and so are the results that use them."
)
CONDITIONS_ROUNDED_NOTE = "The numbers in these conditions are rounded, like those of the arm."
NEVER_SINGULAR = (
    "The Jacobian for this task has full rank in every configuration: the arm has no singular configuration."
)


@dataclass(frozen=True)
class Solution:
    """The symbolic results that `solve` returns for an arm.

    `determinant` is None if J is not square. `singular` is None if J never has full rank. Both are None if they would
    be too long; in that case, `note` explains why. `redundant` describes how the singular set of an arm with more than
    six joints was found. `special` lists lengths for which the results differ, with those results.
    """

    chain: Chain
    position: sp.Matrix
    jacobian: sp.Matrix
    geometric: sp.Matrix
    determinant: sp.Expr | None
    singular: tuple[SingularComponent, ...] | None
    note: str | None
    redundant: RedundantSingularities | None = None
    special: tuple[SpecialLength, ...] = ()

    def __repr__(self) -> str:
        return f"Solution({self.chain.name}: J {len(self.chain.task)} x {self.chain.n}, det J = {self.determinant})"


DESCRIPTION, NUMERIC_TEST, SPECIAL_LENGTHS = "meaning", "tested", "special_lengths"
"""Names of the results that follow the conditions of a singular set, in this order: description, test, lengths."""
SINGULAR_SET = "singular"
"""Name of the result that is missing if only the functions whose zeros form the singular set are known."""


@dataclass(frozen=True)
class Singularities:
    """The determinant and the singular set, None as in a Solution, with remarks.

    `remarks` are about the set itself. `lengths_remark` states which conditions can hold simultaneously only for
    special lengths. `special_cases` holds what differs for such lengths. `missing` lists the results that have not been
    computed yet.
    """

    determinant: sp.Expr | None
    singular: tuple[SingularComponent, ...] | None
    remarks: str = ""
    redundant: RedundantSingularities | None = None
    special_cases: tuple[SpecialLength, ...] = ()
    lengths_remark: str = ""
    missing: tuple[str, ...] = ()

    @property
    def note(self) -> str | None:
        """All remarks as one text; None if there are none."""
        return " ".join(filter(None, (self.remarks, self.lengths_remark))) or None


def solve(chain: Chain) -> Solution:
    """Return the chapter's results for an arm, in the base frame, in metres and radians.

    The position is 3 x 1, the Jacobian of the point 3 x n, the geometric Jacobian 6 x n (linear rows first, (6.6)).
    Results that would be too long are omitted; in that case, `note` explains why.

    >>> from qdot import Chain, Joint
    >>> arm = Chain("mine", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, "a2", 0)), ("vx", "vy"))
    >>> solve(arm)
    Solution(mine: J 2 x 2, det J = a1*a2*sin(theta2))
    """
    d = derive(chain)
    *_, last = singular_stages(chain)
    assert isinstance(last, Singularities)
    results = last.determinant, last.singular, last.note, last.redundant, last.special_cases
    return Solution(chain, d.position, d.geometric[:3, :], d.geometric, *results)


@dataclass(frozen=True)
class PartialResult:
    """The results on the singular set so far, and the names of those that are missing (`missing`).

    If the derivation stops here, `render_markdown` returns the known results in Markdown, and `make_data` returns them
    as plain data.
    """

    render_markdown: Callable[[], str]
    make_data: Callable[[], dict[str, Any]]
    missing: tuple[str, ...]


def singular_stages(chain: Chain) -> Iterator[str | PartialResult | Singularities]:
    """Yield descriptions of the next step, partial results, and results as they become available.

    A description is a string. The last `Singularities` is complete.
    """
    yield "the determinant of J" if derive(chain).is_square else "the minors of J"
    methods = [_solve_by_elimination, _solve_by_minors] if elimination_applies(chain) else [_solve_by_minors]
    for method in methods:
        try:
            singularities = yield from method(chain)
            break
        except TooLong as error:
            failed = error
    else:
        yield Singularities(None, None, NOT_DERIVED.format(failed))
        return
    if SPECIAL_LENGTHS in singularities.missing:
        yield from _solve_special_lengths(chain, singularities)


SingularStages = Generator[str | PartialResult | Singularities, None, Singularities]
"""A generator of the stages of the singular set; it returns the final result for generic lengths."""


def _solve_by_minors(chain: Chain) -> SingularStages:
    """Yield the stages of finding the common zeros of all minors (the determinant of a square J). Raises TooLong."""
    d = derive(chain)
    functions = "the determinant of J" if d.is_square else "the minors of J"
    later = (NUMERIC_TEST, SPECIAL_LENGTHS) if chain.parameters else (NUMERIC_TEST,)
    determinant = d.determinant if d.is_square else None
    if all(minor.is_zero for minor in d.generic_minors):
        singularities = Singularities(determinant, None, ALWAYS_SINGULAR)
        yield singularities
        return singularities
    yield PartialResult(partial(_render_so_far, chain, True), dict, (SINGULAR_SET,))
    yield f"where {functions} {'is' if d.is_square else 'are all'} zero"
    singular_set(chain)
    yield PartialResult(partial(_render_so_far, chain, False), partial(_conditions_json, chain), (DESCRIPTION, *later))
    yield "the geometry of the configurations in which J loses rank"
    singular = certified_components(chain)
    lengths = "" if singular else _describe_special_conditions(chain)
    no_singularity = "" if singular else NEVER_SINGULAR_FOR_GENERIC_LENGTHS if lengths else NEVER_SINGULAR
    singularities = Singularities(determinant, singular, no_singularity, lengths_remark=lengths, missing=later)
    yield singularities
    yield "the numeric test of these conditions"
    remarks = " ".join(filter(None, (no_singularity, _describe_doubts(chain, singular))))
    singularities = replace(singularities, remarks=remarks, missing=later[1:])
    yield singularities
    return singularities


def _solve_special_lengths(chain: Chain, singularities: Singularities) -> Iterator[str | Singularities]:
    """Yield descriptions of the next step, then the results, completed by what differs for special lengths."""
    yield "special lengths"
    sentences = [f"{need}." for need in length_requirements(chain, singularities.singular or ())]
    if singularities.redundant is None:
        sentences.append(_describe_special_conditions(chain))
    singularities = replace(singularities, lengths_remark=" ".join(filter(None, sentences)))
    special = []
    for stage in find_special_lengths(chain, singularities.singular or ()):
        if isinstance(stage, SpecialLength):
            special.append(stage)
        else:
            yield stage
    yield replace(singularities, special_cases=tuple(special), missing=())


def _describe_doubts(chain: Chain, singular: tuple[SingularComponent, ...]) -> str:
    """Return remarks on conditions that a numerical check finds to be false, never satisfied, or missing."""
    check = check_rank_loss(chain, [component.conditions for component in singular])
    return _render_sentences("solve/doubts.md.j2", check=check, singular=singular) if check.arms else ""


def _render_sentences(template: str, **content: Any) -> str:
    """Return the sentences of a template on one line."""
    return " ".join(render(template, **content).split())


def _conditions_in_words(conditions: Iterable[sp.Expr]) -> str:
    return " and ".join(f"`{condition} = 0`" for condition in conditions)


def _solve_by_elimination(chain: Chain) -> SingularStages:
    """Yield the stages of finding the singular set of a redundant arm with long minors. Raises TooLong."""
    later = (SPECIAL_LENGTHS,) if chain.parameters else ()
    singularities = Singularities(None, None, ALWAYS_SINGULAR)
    for stage in redundant_stages(chain):
        if isinstance(stage, str):
            yield stage
        elif stage.is_always_singular:
            singularities = replace(singularities, redundant=stage)
            yield singularities
        elif not stage.is_described:
            parts = partial(_render_redundant_so_far, chain, stage), partial(_redundant_json, chain, stage)
            yield PartialResult(*parts, (DESCRIPTION, *later))
        else:
            remarks = _describe_numeric_check(chain, stage)
            singularities = Singularities(None, stage.components, remarks, stage, missing=later)
            yield singularities
    return singularities


def _render_redundant_so_far(chain: Chain, stage: RedundantSingularities) -> str:
    return f"{_render_redundant(chain, stage)}\n{_describe_numeric_check(chain, stage)}\n"


def _redundant_json(chain: Chain, stage: RedundantSingularities) -> dict[str, Any]:
    singular = [*map(_component_json, stage.components)]
    return {"singular": singular, "tested": stage.search_counts, "note": _describe_numeric_check(chain, stage)}


def _describe_numeric_check(chain: Chain, stage: RedundantSingularities) -> str:
    """Return a description of the numerical check's result, and of the lengths for which the set holds."""
    check = stage.check
    assert check is not None
    count = sum(map(len, check.samples)) - sum(len(check.samples[k]) for k in check.full_rank_branches)
    parts = {"chain": chain, "redundant": stage, "check": check, "count": count, "never_singular": NEVER_SINGULAR}
    return _render_sentences("solve/check.md.j2", **parts)


def _render_so_far(chain: Chain, minors_only: bool) -> str:
    steps, components = get_solution_steps(chain), [] if minors_only else get_solution_steps(chain).components
    return render("solve/part.md.j2", chain=chain, steps=steps, components=components, minors_only=minors_only)


def _describe_special_conditions(chain: Chain) -> str:
    """Return a sentence on the conditions that hold simultaneously only for specially related lengths."""
    special = special_length_components(chain) if chain.parameters else ()
    cases = "; or ".join(_conditions_in_words(component.conditions) for component in special)
    return f"{SPECIAL_LENGTHS_INTRODUCTION} {cases}." if cases else ""


def data_json(content: dict[str, Any]) -> str:
    """Return plain data as JSON."""
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _singular_json(chain: Chain, singularities: Singularities) -> dict[str, Any]:
    sure = can_establish_kind(chain)

    def classified(components: Iterable[SingularComponent]) -> list[dict[str, Any]]:
        return [_classified_json(chain, component, sure) for component in components]

    determinant, singular, special = singularities.determinant, singularities.singular, singularities.special_cases
    content: dict[str, Any] = {
        "determinant": None if determinant is None else str(determinant),
        "singular": None if singular is None else classified(singular),
    }
    if singularities.redundant is not None and singularities.redundant.search_counts:
        content["tested"] = singularities.redundant.search_counts
    if special:
        cases = ({"lengths": case.relation, "singular": classified(case.components)} for case in special)
        content["special_lengths"] = list(cases)
    return content | ({"note": singularities.note} if singularities.note else {})


TWISTS, _TWIST_DERIVATIONS = ("space_jacobian", "body_jacobian"), (derive_space_jacobian, derive_body_jacobian)
"""Further results for an arm described by its axes, 6 x n each, in the order of `twist_rows`."""


def twist_jacobian_names(chain: Chain) -> tuple[str, ...]:
    """Return the names of the further results (TWISTS) that an arm has; none unless its convention has screws."""
    return TWISTS if SCREWS in convention_of(chain).features else ()


def _twist_json(chain: Chain, name: str, derive_twists: Callable[[Chain], sp.Matrix]) -> dict[str, Any]:
    """Return one of TWISTS as plain data; there is no body frame if P is not fixed to the last link."""
    convention = convention_of(chain)
    exists = name == TWISTS[0] or QUESTIONS["body-jacobian"].find_arm_objection(chain) is None
    rows = _text_rows(convention.reorder_twists(derive_twists(chain))) if exists else None
    return {"twist_rows": list(convention.velocity_names), name: rows}


def _text_rows(matrix: sp.Matrix) -> list[list[str]]:
    return [[*map(str, row)] for row in matrix.tolist()]


def _classified_json(chain: Chain, component: SingularComponent, sure: bool) -> dict[str, Any]:
    kind = {"type": component.kind.kind, "uniform": component.kind.uniform} if sure and component.kind.kind else {}
    meaning = convention_of(chain).rename_origins(component.kind.meaning) or None
    return _component_json(component) | kind | {"meaning": meaning}


def _component_json(component: SingularComponent | Component) -> dict[str, Any]:
    """Return the conditions of a component, without its kind and meaning."""
    conditions = [str(condition) for condition in component.conditions]
    solutions = {joint.name: [*map(str, values)] for joint, values in component.solutions or ()} or None
    content = {"condition": " and ".join(conditions), "conditions": conditions, "solutions": solutions}
    return content | dict.fromkeys(("type", "uniform", "meaning"))


def _conditions_json(chain: Chain) -> dict[str, Any]:
    """Return the singular set as plain data before its configurations have been described."""
    return {"singular": [*map(_component_json, get_solution_steps(chain).components)]}


# --- step by step ---


def text_heading(chain: Chain) -> str:
    """Return the heading of a derivation on a terminal."""
    title = f"Velocity kinematics of {chain.title}"
    return f"{title}\n{'=' * len(title)}\n"


def render_article(chain: Chain, blocks: Iterable[str]) -> str:
    """Return blocks of a derivation (Markdown) as a LaTeX article."""
    return render("solve/arm.tex.j2", title=escape_latex(chain.title), body="\n".join(map(to_latex, blocks)))


@dataclass(frozen=True)
class ReadyResult:
    """A result that is ready: its name, and its content, which may be empty.

    `missing` lists which results of the singular set are still missing; it is None for other results.
    """

    name: str
    content: Any
    missing: tuple[str, ...] | None = None


Stages = Iterator[str | PartialResult | ReadyResult]
"""Yields, in any order, descriptions of the next step, results that are ready, and partial results."""


def text_stages(robot: Robot) -> Stages:
    """Yield the derivation in Markdown, block by block: the arm, each section under its name, and remarks."""
    yield "its transformations"
    chain = robot.chain
    w, steps = Wording(chain), get_solution_steps(chain)
    description = _describe_arm(robot)
    shows_same = description is not None and not description.base and description.rows == w.rows
    if shows_same or not w.convention.shows_table:
        description = None  # the standard text below shows the same
    rounded = ROUNDED_NOTE if robot.is_table_rounded else ""
    arm = render("solve/arm.md.j2", chain=chain, w=w, steps=steps, tex=tex, description=description, rounded=rounded)
    yield ReadyResult("arm", arm)
    parts: list[Part] = []
    explained: set[str] = set()
    for name in SECTIONS[:-1]:
        yield QUESTIONS[name].title.lower()
        yield ReadyResult(name, _render_section(chain, name, parts, explained))
    yield from _singular_text(chain, robot, parts, explained)


def _singular_text(chain: Chain, robot: Robot, parts: list[Part], explained: set[str]) -> Stages:
    """Yield the section on the singular set, with its remarks, the result of its check, and special lengths."""
    names, number, earlier_remarks = iter((SECTIONS[-1], "test", "special lengths")), len(parts) + 3, ""
    for stage in singular_stages(chain):
        if not isinstance(stage, Singularities):
            yield stage
            continue
        name, blocks, title = next(names), [], "Remarks"
        if name == SECTIONS[-1]:
            if stage.redundant is not None:  # its test is part of this stage
                names = iter(("special lengths",))
            yield "the singular configurations, step by step"
            blocks.append(_singular_section(chain, robot, stage, parts, explained))
            number += bool(blocks[0])
            if not blocks[0]:
                title = "Singular configurations"
            elif stage.singular is not None:
                title = "Numeric test"  # for more than six joints; for other arms, the test comes later
        new_remarks, earlier_remarks = stage.remarks.removeprefix(earlier_remarks).strip(), stage.remarks
        if new_remarks:
            blocks.append(f"## {number}. {title}\n\n{new_remarks}\n")
            number += 1
        if not stage.missing and (stage.lengths_remark or stage.special_cases):
            blocks.append(_render_special_lengths(chain, stage, number))
        yield ReadyResult(name, "\n".join(filter(None, blocks)), stage.missing)


def _singular_section(
    chain: Chain, robot: Robot, singularities: Singularities, parts: list[Part], explained: set[str]
) -> str:
    """Return the section on the singular set, with the joint values that limits exclude; empty if it has no section."""
    if singularities.redundant is not None:
        text = _render_redundant(chain, singularities.redundant, len(parts) + 3)
    else:
        text = _render_section(chain, SECTIONS[-1], parts, explained)
    beyond = _describe_values_beyond_limits(chain, robot, singularities.singular or ())
    remarks = [f"The joint limits rule out {'; '.join(beyond)}."] if beyond else []
    remarks += [CONDITIONS_ROUNDED_NOTE] if singularities.singular and robot.is_table_rounded else []
    return "\n\n".join([text, *remarks]) + "\n" if remarks else text


def _render_special_lengths(chain: Chain, singularities: Singularities, number: int) -> str:
    return render(
        "solve/lengths.md.j2",
        number=number,
        note=singularities.lengths_remark,
        special=[(special, Wording(special.chain)) for special in singularities.special_cases],
        examined=length_relations(chain, singularities.singular or ()) if singularities.special_cases else [],
    )


def _render_section(chain: Chain, name: str, parts: list[Part], explained: set[str]) -> str:
    """Return the section of a question, and append the part; empty if the question does not apply to the arm."""
    question = QUESTIONS[name]
    unreadable = chain.n > MAX_JOINTS_FOR_INVERSE and name in INVERSE_SECTIONS
    if unreadable or question.find_objection(chain) is not None:
        return ""
    answer, details = question.ask(chain, Stream("solve"))
    parts.append(Part(name, name, answer, details=details))
    text = write_next_solution(Problem(ProblemId("own", 0), chain, tuple(parts)), explained)
    return f"## {len(parts) + 2}. {question.make_title(chain)}\n\n{text}"


def _render_redundant(chain: Chain, redundant: RedundantSingularities, number: int | None = None) -> str:
    """Return the section on the singular set of a redundant arm; it has no number while it is incomplete."""
    w, steps = Wording(chain), get_solution_steps(chain)
    return render("solve/redundant.md.j2", chain=chain, w=w, steps=steps, redundant=redundant, number=number)


def data_stages(chain: Chain) -> Stages:
    """Yield the parts of the plain data, named by their keys."""
    d = derive(chain)
    yield "the position"
    yield ReadyResult("position", {"position": matrix_json(d.position)})
    yield "the Jacobian"
    rows = _text_rows(d.geometric)
    yield ReadyResult("jacobian", {"jacobian": rows[:3], "geometric_jacobian": rows})
    for name, derive_twists in zip(twist_jacobian_names(chain), _TWIST_DERIVATIONS, strict=False):
        yield f"the {name.replace('_j', ' J')}"
        yield ReadyResult(name, _twist_json(chain, name, derive_twists))
    if d.is_square:
        yield "the determinant"
        with suppress(TooLong):
            yield ReadyResult("determinant", {"determinant": str(d.determinant)})
    for stage in singular_stages(chain):
        if isinstance(stage, Singularities):
            yield ReadyResult("singular", _singular_json(chain, stage), stage.missing)
        else:
            yield stage


@dataclass(frozen=True)
class _ArmDescription:
    """The arm as its file describes it, for the template: convention, cells of its rows, and its base in words."""

    convention: type[Convention]
    rows: list[list[str]]
    base: str


def _describe_arm(robot: Robot) -> _ArmDescription | None:
    """Return the arm as described in its file; None if the file has the standard table."""
    if (written_arm := robot.written_arm) is None:
        return None
    base = ""
    if written_arm.base is not None:
        position, rpy = written_arm.base
        angles = ", ".join(f"${tex_angle(angle)}$" for angle in rpy)
        base = f"at ${format_coordinates(position)}$"
        base += f", rotated by roll, pitch and yaw of {angles}" if any(rpy) else ""
    convention = written_arm.convention
    return _ArmDescription(convention, [_cells(convention, row) for row in written_arm.rows], base)


def _cells(convention: type[Convention], row: tuple[Any, ...]) -> list[str]:
    if FRAMES not in convention.features:
        direction, point = row
        return [f"({', '.join(map(tex, direction))})", "-" if point is None else format_coordinates(point)]
    return convention.order_entries(tex_angle(row[0]), tex_length(row[1]), tex_length(row[2]), tex_angle(row[3]))


def _describe_values_beyond_limits(chain: Chain, robot: Robot, singular: Iterable[SingularComponent]) -> list[str]:
    """Return texts for the joint values of singular configurations that lie outside the joint limits."""
    limits = dict(zip(chain.q, robot.limits, strict=False))
    excluded = []
    for component in singular:
        for joint, values in component.solutions or ():
            joint_limits = limits.get(joint)
            if joint_limits is None:
                continue
            low, high = joint_limits
            turns = (0,) if joint.name.startswith("d") else (-2 * sp.pi, 0, 2 * sp.pi)
            outside = [v for v in values if v.is_number and not any(low <= v + turn <= high for turn in turns)]
            span = f"from ${tex_value(low, joint)}$ to ${tex_value(high, joint)}$"
            excluded += [f"${tex(joint)} = {tex_value(value, joint)}$ ({span})" for value in outside]
    return list(dict.fromkeys(excluded))
