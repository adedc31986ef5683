"""Everything the chapter derives for a user's own arm: as data, step by step for a terminal, and as LaTeX."""

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
from qdot.exercises.arm.kinds import kind_is_sure
from qdot.exercises.arm.numeric_rank_check import tried
from qdot.exercises.arm.reciprocal import applies
from qdot.exercises.arm.robot_file import Limits, Robot, read_robot
from qdot.exercises.arm.singularity import Component, for_special_lengths, singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.text import matrix_json
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.base import BY_HAND
from qdot.exercises.questions.screws import body_jacobian, space_jacobian
from qdot.exercises.solve.certified_singularities import sound_components
from qdot.exercises.solve.redundant import Redundant, redundant_stages
from qdot.exercises.solve.special_lengths import Special, needs, relations, special_lengths
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_value
from qdot.exercises.writing.markup import latex_escaped, to_latex, to_text
from qdot.exercises.writing.render import render
from qdot.exercises.writing.statement import next_solution, worked_steps
from qdot.exercises.writing.wording import Wording, triple
from qdot.exercises.writing.worked import SingularComponent

SECTIONS = (
    "home-screws", "position", "jacobian", "velocity", "joint-axes", "position-vectors", "geometric-jacobian", "twist",
    "space-jacobian", "body-jacobian", "determinant", "inverse-jacobian", "inverse-velocity", "singular-angles",
)  # fmt: skip
"""What is derived, in the chapter's order."""
ALWAYS_SINGULAR = (
    "The Jacobian for this task has less than full rank in every configuration, so that no configuration stands out as "
    "singular. Count other rows (`task`), or look at another point (`point`)."
)
NEVER_IN_GENERAL = "For lengths that nothing is special about, no configuration is singular."
NOT_WORKED_OUT = "The singular configurations are not worked out: {}. Position and Jacobian are right."
IN_GENERAL = (
    "All of this is for lengths that nothing is special about: with lengths of a special relation to each other, more "
    "configurations may be singular."
)
FOR_SPECIAL_LENGTHS = (
    "Only for lengths that are related to each other in a way of its own can these conditions hold together, and are "
    "more configurations singular:"
)
ROUNDED = (
    "Some of its numbers have no short form and are rounded to ten decimals; what follows from them is no more exact."
)
CONDITIONS_ROUNDED = "Numbers in these conditions are rounded, as those of the arm are."
NEVER_SINGULAR = (
    "The Jacobian for this task has full rank in every configuration: the arm has no singular configuration."
)


@dataclass(frozen=True)
class Solution:
    """The results for a chain.

    `determinant` is None where J is not square, `singular` where it never has full rank; both where they would be too
    long, as `note` then says. `robot` is the file that the arm was read from, if it was; `redundant` is how the
    singular set of an arm of more than six joints was found, and `special` what differs for special lengths.
    """

    chain: Chain
    position: sp.Matrix
    jacobian: sp.Matrix
    geometric: sp.Matrix
    determinant: sp.Expr | None
    singular: tuple[SingularComponent, ...] | None
    note: str | None
    robot: Robot | None = None
    redundant: Redundant | None = None
    special: tuple[Special, ...] = ()

    def __repr__(self) -> str:
        return f"Solution({self.chain.name}: J {len(self.chain.task)} x {self.chain.n}, det J = {self.determinant})"


MEANING, TESTED, SPECIAL = "meaning", "tested", "special_lengths"
"""What there is to find out of a singular set whose conditions are known, in that order."""
WHERE = "singular"
"""The set itself, where no more is known of it than of what it is the zeros."""


@dataclass(frozen=True)
class Singularities:
    """Determinant and singular set, None as in a Solution, and what there is to say of them.

    `remarks` are on the set itself, `lengths` is what conditions hold together for special lengths only. `left` are
    those of MEANING, TESTED and SPECIAL that have not been worked out yet.
    """

    determinant: sp.Expr | None
    singular: tuple[SingularComponent, ...] | None
    remarks: str = ""
    redundant: Redundant | None = None
    special: tuple[Special, ...] = ()
    lengths: str = ""
    left: tuple[str, ...] = ()

    @property
    def note(self) -> str | None:
        """All that there is to say, None if there is nothing."""
        return " ".join(filter(None, (self.remarks, self.lengths))) or None


def solve(chain: Chain) -> Solution:
    """Return what the chapter would derive for `chain`; base frame, metres, radians.

    The position is 3 x 1, the Jacobian of the point 3 x n, the geometric one 6 x n (linear rows first, (6.6)). What
    would be too long is left out, as `note` then says.

    >>> from qdot import Chain, Joint
    >>> arm = Chain("mine", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, "a2", 0)), ("vx", "vy"))
    >>> solve(arm)
    Solution(mine: J 2 x 2, det J = a1*a2*sin(theta2))
    """
    d = derive(chain)
    found = _singularities(chain)
    results = found.determinant, found.singular, found.note
    solution = Solution(chain, d.position, d.geometric[:3, :], d.geometric, *results)
    return replace(solution, redundant=found.redundant, special=found.special)


def _singularities(chain: Chain) -> Singularities:
    """Return determinant, singular set and what there is to say of them."""
    *_, last = singular_stages(chain)
    assert isinstance(last, Singularities)
    return last


@dataclass(frozen=True)
class Kept:
    """What is known of the singular set before all of it is, and what is `left`.

    Where it ends there, `block` writes what is known in Markdown, `data` as plain data.
    """

    block: Callable[[], str]
    data: Callable[[], dict[str, Any]]
    left: tuple[str, ...]


def singular_stages(chain: Chain) -> Iterator[str | Kept | Singularities]:
    """Yield in words what is worked out next, what is known so far, and the results, as far as they are there.

    The last of these are all.
    """
    yield "the determinant of J" if derive(chain).is_square else "the minors of J"
    ways = [_by_elimination, _by_minors] if applies(chain) else [_by_minors]
    for way in ways:
        try:
            found = yield from way(chain)
            break
        except TooLong as error:
            failed = error
    else:
        yield Singularities(None, None, NOT_WORKED_OUT.format(failed))
        return
    if SPECIAL in found.left:
        yield from _for_special_lengths(chain, found)


Found = Generator[str | Kept | Singularities, None, Singularities]
"""Stages of the singular set, and what is known of it in the end, for lengths in general."""


def _by_minors(chain: Chain) -> Found:
    """Yield the stages of the zeros of all minors, of a square J its determinant. Raises TooLong."""
    d = derive(chain)
    what = "the determinant of J" if d.is_square else "the minors of J"
    later = (TESTED, SPECIAL) if chain.parameters else (TESTED,)
    determinant = d.determinant if d.is_square else None
    if all(minor.is_zero for minor in d.generic_minors):
        found = Singularities(determinant, None, ALWAYS_SINGULAR)
        yield found
        return found
    yield Kept(partial(_known_so_far, chain, True), dict, (WHERE,))
    yield f"where {what} {'is' if d.is_square else 'are all'} zero"
    singular_set(chain)
    yield Kept(partial(_known_so_far, chain, False), partial(_conditions_json, chain), (MEANING, *later))
    yield "what the configurations look like in which J loses rank"
    singular = sound_components(chain)
    lengths = "" if singular else _only_for_special_lengths(chain)
    never = "" if singular else NEVER_IN_GENERAL if lengths else NEVER_SINGULAR
    found = Singularities(determinant, singular, never, lengths=lengths, left=later)
    yield found
    yield "the test of these conditions in numbers"
    remarks = " ".join(filter(None, (never, _doubt(chain, singular))))
    found = replace(found, remarks=remarks, left=later[1:])
    yield found
    return found


def _for_special_lengths(chain: Chain, found: Singularities) -> Iterator[str | Singularities]:
    """Yield what is looked at, and the results with what differs where open lengths are related to each other."""
    yield "lengths of a special relation to each other"
    wanted = [f"{need}." for need in needs(chain, found.singular or ())]
    if found.redundant is None:
        wanted.append(_only_for_special_lengths(chain))
    found = replace(found, lengths=" ".join(filter(None, wanted)))
    special = []
    for stage in special_lengths(chain, found.singular or ()):
        if isinstance(stage, Special):
            special.append(stage)
        else:
            yield stage
    yield replace(found, special=tuple(special), left=())


def _doubt(chain: Chain, singular: tuple[SingularComponent, ...]) -> str:
    """Return what a test in numbers found amiss: conditions that seem never to hold, or to be too few or too many."""
    out, said = tried(chain, [one.conditions for one in singular]), []
    if not out.arms:
        return ""
    for k, one in enumerate(singular):
        if k in out.wrong:
            said.append(
                f"In numbers, J was found to keep its rank somewhere where {_in_words(one.conditions)}: don't rely on "
                "this condition."
            )
        elif not out.samples[k]:
            said.append(_undecided(one.conditions, out.searches))
    if out.unexplained:
        said.append(
            f"Of {out.searches} searches for lost rank from random starts, {len(out.unexplained)} ended in "
            "configurations that none of these conditions accounts for: the list is not complete."
        )
    return " ".join(said)


def _in_words(conditions: Iterable[sp.Expr]) -> str:
    return " and ".join(f"`{condition} = 0`" for condition in conditions)


def _undecided(conditions: Iterable[sp.Expr], searches: int) -> str:
    """Return what is said of conditions for which no configuration was found."""
    return (
        f"No configuration was found in which {_in_words(conditions)}, in {searches} searches from random starts; "
        "whether there is one was not decided."
    )


def _by_elimination(chain: Chain) -> Found:
    """Yield the same of an arm with more joints than rows whose minors are long. Raises TooLong."""
    later = (SPECIAL,) if chain.parameters else ()
    found = Singularities(None, None, ALWAYS_SINGULAR)
    for stage in redundant_stages(chain):
        if isinstance(stage, str):
            yield stage
        elif stage.always:
            found = replace(found, redundant=stage)
            yield found
        elif not stage.described:
            parts = partial(_redundant_so_far, chain, stage), partial(_redundant_json, chain, stage)
            yield Kept(*parts, (MEANING, *later))
        else:
            found = Singularities(None, stage.components, _said_of_test(chain, stage), stage, left=later)
            yield found
    return found


def _redundant_so_far(chain: Chain, stage: Redundant) -> str:
    return f"{_redundant_block(chain, stage)}\n{_said_of_test(chain, stage)}\n"


def _redundant_json(chain: Chain, stage: Redundant) -> dict[str, Any]:
    singular = [_component_json(one) for one in stage.components]
    return {"singular": singular, "tested": stage.searched, "note": _said_of_test(chain, stage)}


def _said_of_test(chain: Chain, stage: Redundant) -> str:
    """Return what came out of the test in numbers, and what the set holds for."""
    out, said = stage.tried, []
    assert out is not None
    count = sum(map(len, out.samples)) - sum(len(out.samples[k]) for k in out.wrong)
    if stage.components:
        said.append(f"In numbers, J was found to lose rank at each of {count} configurations in which they hold.")
    elif stage.never:
        said.append(NEVER_SINGULAR)
    drawn = f", with {out.choices} choices of the open lengths" if chain.parameters else ""
    said.append(f"Of {out.searches} searches for lost rank from random starts{drawn}, {out.ended} came to an end")
    if out.unexplained:
        said[-1] += (
            f"; {len(out.unexplained)} of them ended in configurations that none of these conditions accounts for: the "
            "list is not complete."
        )
    else:
        said[-1] += ", each where one of these conditions holds." if out.ended else "."
    said.append("That is a test of what was derived, and no proof.")
    if stage.doubtful:
        said.append(f"{len(stage.doubtful)} more conditions were derived and left out, as they failed this test.")
    said += [_undecided(conditions, out.searches) for conditions in stage.undecided]
    if chain.parameters:
        said.append(IN_GENERAL)
    return " ".join(said)


def _known_so_far(chain: Chain, minors_only: bool) -> str:
    steps, components = worked_steps(chain), [] if minors_only else worked_steps(chain).components
    return render("solve/part.md.j2", chain=chain, steps=steps, components=components, minors_only=minors_only)


def _only_for_special_lengths(chain: Chain) -> str:
    """Return which conditions hold together for lengths of a special relation only, in words."""
    special = for_special_lengths(chain) if chain.parameters else ()
    cases = "; or ".join(_in_words(one.conditions) for one in special)
    return f"{FOR_SPECIAL_LENGTHS} {cases}." if cases else ""


def solution_json(solution: Solution) -> str:
    """Return the results as JSON, in the form of docs/schemas/solve.json."""
    return data_json(solution_data(solution))


def data_json(content: dict[str, Any]) -> str:
    """Return plain data as JSON."""
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def solution_data(solution: Solution) -> dict[str, Any]:
    """Return the results as plain data."""
    content: dict[str, Any] = {
        "name": solution.chain.title,
        **({"rounded": True} if solution.robot is not None and solution.robot.rounded else {}),
        "position": matrix_json(solution.position),
        "jacobian": _rows(solution.jacobian),
        "geometric_jacobian": _rows(solution.geometric),
        **{key: value for part in _screw_parts(solution.chain) for key, value in part().items()},
        "task": list(solution.chain.task),
        **_singular_json(
            solution.chain,
            Singularities(
                solution.determinant, solution.singular, solution.note or "", solution.redundant, solution.special
            ),
        ),
    }
    return content


def _singular_json(chain: Chain, found: Singularities) -> dict[str, Any]:
    sure = kind_is_sure(chain)
    content: dict[str, Any] = {
        "determinant": None if found.determinant is None else str(found.determinant),
        "singular": None if found.singular is None else [_found_json(chain, one, sure) for one in found.singular],
    }
    if found.redundant is not None and found.redundant.searched:
        content["tested"] = found.redundant.searched
    if found.special:
        content["special_lengths"] = [
            {"lengths": one.relation, "singular": [_found_json(chain, part, sure) for part in one.components]}
            for one in found.special
        ]
    return content | ({"note": found.note} if found.note else {})


TWISTS = "space_jacobian", "body_jacobian"
"""What an arm that is told by its axes has beside the others, 6 x n each, in the order of `twist_rows`."""


def twists_of(chain: Chain) -> tuple[str, ...]:
    """Return which of TWISTS an arm has: those of screws."""
    return TWISTS if SCREWS in convention_of(chain).has else ()


def _screw_parts(chain: Chain) -> tuple[Callable[[], dict[str, Any]], ...]:
    """Return what works out the Jacobians of TWISTS as plain data, nothing where an arm is told by a table.

    There is no body frame where P is no point of the last link.
    """
    if not twists_of(chain):
        return ()
    has_body = QUESTIONS["body-jacobian"].objection(chain) is None
    return (
        lambda: {
            "twist_rows": list(convention_of(chain).velocities),
            TWISTS[0]: _rows(convention_of(chain).twist(space_jacobian(chain))),
        },
        lambda: {TWISTS[1]: _rows(convention_of(chain).twist(body_jacobian(chain))) if has_body else None},
    )


def _rows(matrix: sp.Matrix) -> list[list[str]]:
    return [[str(entry) for entry in row] for row in matrix.tolist()]


def _found_json(chain: Chain, found: SingularComponent, sure: bool) -> dict[str, Any]:
    kind = {"type": found.kind.kind, "uniform": found.kind.uniform} if sure and found.kind.kind else {}
    return _component_json(found) | kind | {"meaning": convention_of(chain).rename_origins(found.kind.meaning) or None}


def _component_json(found: SingularComponent | Component) -> dict[str, Any]:
    """Return the conditions of a component, and nothing of what it is."""
    conditions = [str(condition) for condition in found.conditions]
    solved = found.solutions and {joint.name: [str(value) for value in values] for joint, values in found.solutions}
    said = {"condition": " and ".join(conditions), "conditions": conditions, "solutions": solved or None}
    return said | dict.fromkeys(("type", "uniform", "meaning"))


def _conditions_json(chain: Chain) -> dict[str, Any]:
    """Return what is known of the singular set when nothing is of what it looks like."""
    return {"singular": [_component_json(one) for one in worked_steps(chain).components]}


# --- step by step ---


def solution_text(solution: Solution) -> str:
    """Return the derivation step by step for a terminal."""
    blocks = (to_text(block) for block in _blocks(solution.chain, solution.robot))
    return f"{text_heading(solution.chain)}\n" + "\n".join(blocks)


def text_heading(chain: Chain) -> str:
    """Return what stands above a derivation on a terminal."""
    title = f"Velocity kinematics of {chain.title}"
    return f"{title}\n{'=' * len(title)}\n"


def solution_latex(solution: Solution) -> str:
    """Return the derivation step by step as a LaTeX article."""
    return article(solution.chain, _blocks(solution.chain, solution.robot))


def article(chain: Chain, blocks: Iterable[str]) -> str:
    """Return blocks of a derivation (Markdown) as a LaTeX article."""
    return render("solve/arm.tex.j2", title=latex_escaped(chain.title), body="\n".join(map(to_latex, blocks)))


def _blocks(chain: Chain, robot: Robot | None) -> list[str]:
    """Return the derivation in Markdown."""
    return [stage.content for stage in text_stages(chain, robot) if isinstance(stage, Ready) and stage.content]


@dataclass(frozen=True)
class Ready:
    """A result that is ready: its name, and what is to be shown of it, which is empty where there is nothing.

    `left` is what is still to be found out of the singular set, None where this is no result on it; `singular` is the
    set, as far as it is there.
    """

    name: str
    content: Any
    left: tuple[str, ...] | None = None
    singular: tuple[SingularComponent, ...] | None = None


Stages = Iterator[str | Kept | Ready]
"""What is worked out next, in words, results as they are ready, and what is known of one before it is."""


def text_stages(chain: Chain, robot: Robot | None = None) -> Stages:
    """Yield the derivation in Markdown, block by block: the arm, each section by its name, and what is to be added."""
    yield "its transformations"
    w, steps = Wording(chain), worked_steps(chain)
    given = _given(robot)
    if given is not None and (not w.convention.has_frames or (not given.base and given.rows == w.rows)):
        given = None  # it is told so below
    rounded = ROUNDED if robot is not None and robot.rounded else ""
    yield Ready("arm", render("solve/arm.md.j2", chain=chain, w=w, steps=steps, tex=tex, given=given, rounded=rounded))
    parts: list[Part] = []
    explained: set[str] = set()
    for name in SECTIONS[:-1]:
        yield QUESTIONS[name].title.lower()
        yield Ready(name, _section(chain, name, parts, explained))
    yield from _singular_text(chain, robot, parts, explained)


def _singular_text(chain: Chain, robot: Robot | None, parts: list[Part], explained: set[str]) -> Stages:
    """Yield the section on the singular set with what is said of it, what its test found, and special lengths."""
    names, number, told = iter((SECTIONS[-1], "test", "special lengths")), len(parts) + 3, ""
    for stage in singular_stages(chain):
        if not isinstance(stage, Singularities):
            yield stage
            continue
        name, blocks, title = next(names), [], "Remarks"
        if name == SECTIONS[-1]:
            if stage.redundant is not None:  # its test comes with it
                names = iter(("special lengths",))
            yield "the singular configurations, step by step"
            blocks.append(_singular_section(chain, robot, stage, parts, explained))
            number += bool(blocks[0])
            if not blocks[0]:
                title = "Singular configurations"
            elif stage.singular is not None:
                title = "Test in numbers"  # of more than six joints: of others, it comes later
        new, told = stage.remarks.removeprefix(told).strip(), stage.remarks
        if new:
            blocks.append(f"## {number}. {title}\n\n{new}\n")
            number += 1
        if not stage.left and (stage.lengths or stage.special):
            blocks.append(_special_block(chain, stage, number))
        yield Ready(name, "\n".join(filter(None, blocks)), stage.left, stage.singular)


def _singular_section(
    chain: Chain, robot: Robot | None, found: Singularities, parts: list[Part], explained: set[str]
) -> str:
    """Return the section on the singular set with what limits of joints rule out, nothing where there is none."""
    if found.redundant is not None:
        text = _redundant_block(chain, found.redundant, len(parts) + 3)
    else:
        text = _section(chain, SECTIONS[-1], parts, explained)
    beyond = _beyond(chain, robot, found.singular or ())
    said = [f"Limits of the joints rule out {'; '.join(beyond)}."] if beyond else []
    said += [CONDITIONS_ROUNDED] if found.singular and robot is not None and robot.rounded else []
    return "\n\n".join([text, *said]) + "\n" if said else text


def _special_block(chain: Chain, found: Singularities, number: int) -> str:
    return render(
        "solve/lengths.md.j2",
        number=number,
        note=found.lengths,
        special=[(one, Wording(one.chain)) for one in found.special],
        looked_at=relations(chain, found.singular or ()) if found.special else [],
    )


def _section(chain: Chain, name: str, parts: list[Part], explained: set[str]) -> str:
    """Return the section of a question, and add it to the parts before it; nothing if such an arm is not asked it."""
    question = QUESTIONS[name]
    unreadable = chain.n > BY_HAND and name in ("inverse-jacobian", "inverse-velocity")
    if unreadable or question.objects(chain) is not None:
        return ""
    answer, details = question.ask(chain, Stream("solve"))
    parts.append(Part(name, name, answer, details=details))
    text = next_solution(Problem(ProblemId("own", 0), chain, tuple(parts)), explained)
    return f"## {len(parts) + 2}. {question.heading(chain)}\n\n{text}"


def _redundant_block(chain: Chain, redundant: Redundant, number: int | None = None) -> str:
    """Return the section on the singular set of such an arm, without a number where it is not whole."""
    w, steps = Wording(chain), worked_steps(chain)
    return render("solve/redundant.md.j2", chain=chain, w=w, steps=steps, found=redundant, number=number)


def data_stages(chain: Chain) -> Stages:
    """Yield parts of the plain data, by the names of its keys."""
    d = derive(chain)
    yield "the position"
    yield Ready("position", {"position": matrix_json(d.position)})
    yield "the Jacobian"
    yield Ready("jacobian", {"jacobian": _rows(d.geometric[:3, :]), "geometric_jacobian": _rows(d.geometric)})
    for name, part in zip(TWISTS, _screw_parts(chain), strict=False):
        yield f"the {name.replace('_j', ' J')}"
        yield Ready(name, part())
    if d.is_square:
        yield "the determinant"
        with suppress(TooLong):
            yield Ready("determinant", {"determinant": str(d.determinant)})
    for stage in singular_stages(chain):
        if isinstance(stage, Singularities):
            yield Ready("singular", _singular_json(chain, stage), stage.left, stage.singular)
        else:
            yield stage


@dataclass(frozen=True)
class _Told:
    """How an arm was told, for the template: a convention, the cells of its rows, and what is said of its base."""

    convention: type[Convention]
    rows: list[list[str]]
    base: str


def _given(robot: Robot | None) -> _Told | None:
    """Return how the arm was told, None where that is the standard table."""
    given = robot.given if robot else None
    if given is None:
        return None
    base = ""
    if given.base is not None:
        position, rpy = given.base
        turned = ", ".join(f"${tex_angle(angle)}$" for angle in rpy)
        base = f"at ${triple(position)}$" + (f", turned by roll, pitch and yaw of {turned}" if any(rpy) else "")
    return _Told(given.convention, [_cells(given.convention, row) for row in given.rows], base)


def _cells(convention: type[Convention], row: tuple[Any, ...]) -> list[str]:
    if FRAMES not in convention.has:
        direction, point = row
        return [f"({', '.join(map(tex, direction))})", "-" if point is None else triple(point)]
    return convention.cells(tex_angle(row[0]), tex_length(row[1]), tex_length(row[2]), tex_angle(row[3]))


def _beyond(chain: Chain, robot: Robot | None, singular: Iterable[SingularComponent]) -> list[str]:
    """Return the values of joints in singular configurations that the limits of the joints rule out, in words."""
    limits = dict(zip(chain.q, robot.limits, strict=False)) if robot else {}
    said = []
    for component in singular:
        for joint, values in component.solutions or ():
            ends = limits.get(joint)
            if ends is None:
                continue
            low, high = (tex_value(end, joint) for end in ends)
            out = [v for v in values if v.is_number and not any(_within(v + turn, ends) for turn in _turns(joint))]
            said += [f"${tex(joint)} = {tex_value(value, joint)}$ (from ${low}$ to ${high}$)" for value in out]
    return list(dict.fromkeys(said))


def _turns(joint: sp.Symbol) -> tuple[sp.Expr, ...]:
    return (sp.S.Zero,) if joint.name.startswith("d") else tuple(2 * sp.pi * turn for turn in (-1, 0, 1))


def _within(value: sp.Expr, ends: Limits) -> bool:
    return bool(ends[0] <= value) and bool(value <= ends[1])


__all__ = ["Solution", "read_robot", "solution_data", "solution_json", "solution_latex", "solution_text", "solve"]
