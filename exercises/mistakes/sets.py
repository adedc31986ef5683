"""Mistakes in sets of singular configurations."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy as sp

from exercises.answers import ConditionSet
from exercises.arm.chain import Chain
from exercises.arm.singularity import Component
from exercises.mistakes.base import Mistake, Taken
from exercises.problem import Part

Components = tuple[Component, ...]


def _components(part: Part) -> Components:
    return part.answer.components if isinstance(part.answer, ConditionSet) else ()


def _set(components: Sequence[Component], **words: object) -> Taken:
    return Taken(ConditionSet(tuple(components)), words)


def _with(components: Components, index: int, new: Component) -> Components:
    return (*components[:index], new, *components[index + 1 :])


def _thinned(component: Component, keep: int) -> Component:
    """Return a component with one value of each joint."""
    assert component.solutions is not None
    kept = tuple((joint, (values[min(keep, len(values) - 1)],)) for joint, values in component.solutions)
    return replace(component, solutions=kept)


def _one_root(chain: Chain, part: Part) -> Iterator[Taken]:
    components = _components(part)
    several = [
        k
        for k, component in enumerate(components)
        if component.solutions and any(len(v) > 1 for _, v in component.solutions)
    ]
    for keep in (0, 1):
        if len(several) > 1:
            yield _set([_thinned(c, keep) if k in several else c for k, c in enumerate(components)])
        for k in several:
            yield _set(_with(components, k, _thinned(components[k], keep)))


def _missed(chain: Chain, part: Part) -> Iterator[Taken]:
    components = _components(part)
    for k, component in enumerate(components):
        if len(components) > 1:
            yield _set((*components[:k], *components[k + 1 :]), kind=_kind(component))
    for k in range(len(components)):
        if len(components) > 2:
            yield _set((components[k],), kind="more than one kind of condition")


def _kind(component: Component) -> str:
    return "a condition that ties several joints" if component.solutions is None else "values of a joint"


def _tied_missed(chain: Chain, part: Part) -> Iterator[Taken]:
    """Leave out the shoulder and whatever else ties several joints: the rest is seen from one joint at a time."""
    components = _components(part)
    solved = [component for component in components if component.solutions is not None]
    if solved and len(solved) < len(components):
        yield _set(solved)


def _moved(component: Component, to: sp.Symbol) -> Component:
    assert component.solutions is not None
    return replace(component, solutions=tuple((to, values) for _, values in component.solutions))


def _other_joint(chain: Chain, part: Part) -> Iterator[Taken]:
    components = _components(part)
    for k, component in enumerate(components):
        if component.solutions is None or len(component.solutions) > 1:
            continue
        own = component.solutions[0][0]
        for joint, q in zip(chain.joints, chain.q, strict=True):
            if q != own and (joint.kind == "R") == own.name.startswith("theta"):
                yield _set(_with(components, k, _moved(component, q)), joint=q)


def _angles(component: Component) -> bool:
    return component.solutions is not None and all(q.name.startswith("theta") for q, _ in component.solutions)


def _shifted(component: Component, by: sp.Expr) -> Component:
    assert component.solutions is not None
    return replace(component, solutions=tuple((q, tuple(v + by for v in values)) for q, values in component.solutions))


def _quarter(chain: Chain, part: Part) -> Iterator[Taken]:
    components = _components(part)
    which = [k for k, component in enumerate(components) if _angles(component)]
    for chosen in ([k] for k in which):
        yield _set([_shifted(c, sp.pi / 2) if k in chosen else c for k, c in enumerate(components)])
    if len(which) > 1:
        yield _set([_shifted(c, sp.pi / 2) if k in which else c for k, c in enumerate(components)])


def _straight(q: sp.Symbol) -> Component:
    return Component((sp.sin(q),), ((q, (sp.S.Zero, sp.pi)),))


def _joint_added(chain: Chain, part: Part) -> Iterator[Taken]:
    """Call a joint singular at 0 or pi that is not: the book's own slip."""
    components = _components(part)
    singular = {q for component in components for q, _ in component.solutions or ()}
    for joint, q in zip(chain.joints, chain.q, strict=True):
        if joint.kind == "R" and q not in singular:
            for component in (_straight(q), _thinned(_straight(q), 0)) if components else ():
                yield _set((*components, component), joint=q)
                tied = [k for k, other in enumerate(components) if other.solutions is None]
                if tied:
                    yield _set(_with(components, tied[0], component), joint=q)


def _all_joints(chain: Chain, part: Part) -> Iterator[Taken]:
    revolute = [q for joint, q in zip(chain.joints, chain.q, strict=True) if joint.kind == "R"]
    if _components(part) and len(revolute) > 1:
        yield _set([_straight(q) for q in revolute])


def _degrees(chain: Chain, part: Part) -> Iterator[Taken]:
    components = _components(part)
    if any(map(_angles, components)):
        yield _set([_in_degrees(component) if _angles(component) else component for component in components])


def _in_degrees(component: Component) -> Component:
    assert component.solutions is not None
    return replace(
        component, solutions=tuple((q, tuple(v * 180 / sp.pi for v in values)) for q, values in component.solutions)
    )


def _conditions(part: Part) -> Iterator[tuple[int, int, sp.Expr]]:
    """Yield where a condition that ties several joints stands, and the condition."""
    for k, component in enumerate(_components(part)):
        if component.solutions is None:
            for index, condition in enumerate(component.conditions):
                if condition.is_Add:
                    yield k, index, condition


def _altered(part: Part, k: int, index: int, new: sp.Expr, **words: object) -> Taken:
    components = _components(part)
    conditions = list(components[k].conditions)
    conditions[index] = new
    return _set(_with(components, k, Component(tuple(conditions), None)), **words)


def _term_sign(chain: Chain, part: Part) -> Iterator[Taken]:
    for k, index, condition in _conditions(part):
        for term in condition.args:
            yield _altered(part, k, index, condition - 2 * term)


def _term_lost(chain: Chain, part: Part) -> Iterator[Taken]:
    for k, index, condition in _conditions(part):
        for term in condition.args:
            yield _altered(part, k, index, condition - term)


def _relative(chain: Chain, part: Part) -> Iterator[Taken]:
    for k, index, condition in _conditions(part):
        sums = {trig.args[0] for trig in condition.atoms(sp.sin, sp.cos) if trig.args[0].is_Add}
        own = {angle: max(angle.free_symbols, key=lambda symbol: symbol.name) for angle in sums}
        if own:
            yield _altered(part, k, index, condition.xreplace(own))


def _trigs(chain: Chain, part: Part) -> Iterator[Taken]:
    for k, index, condition in _conditions(part):
        swap = {w: (sp.cos if isinstance(w, sp.sin) else sp.sin)(w.args[0]) for w in condition.atoms(sp.sin, sp.cos)}
        yield _altered(part, k, index, condition.xreplace(swap))


MISTAKES = (
    Mistake(
        "one-root-only", "Only one of two roots",
        "Only one of several values of a joint seems to be given: a sine or cosine takes the same value more than once "
        "in a turn.", "6.8", takes=_one_root,
    ),
    Mistake(
        "shoulder-missed", "Condition that ties several joints missed",
        "What depends on more than one joint at once seems to be left out, as where the point lies on the first axis. "
        "Every factor of det J counts.", "6.8 and Example 6.3", takes=_tied_missed,
    ),
    Mistake(
        "component-missed", "Part of the singular set missed",
        "A part of the singular configurations seems to be left out: {kind}. Every factor of det J counts.", "6.8",
        takes=_missed,
    ),
    Mistake(
        "quarter-turn-singular", "Sine for cosine in the condition",
        "The angles seem to be a quarter turn off: where does the sine vanish, and where the cosine?", "6.8",
        takes=_quarter,
    ),
    Mistake(
        "joint-called-singular", "A joint called singular that is not",
        "{joint} = 0 or pi seems to be called singular. Is it a factor of det J? (The book has this slip in its own "
        "Example 6.3.)", "6.8", takes=_joint_added,
    ),
    Mistake(
        "all-joints-straight", "All joints at 0 or pi called singular",
        "Every joint at 0 or pi seems to be called singular. Only what makes det J vanish is.", "6.8",
        takes=_all_joints,
    ),
    Mistake(
        "condition-for-other-joint", "Condition for another joint",
        "The condition seems to be given for {joint}, and it is one for another joint.", "6.8", takes=_other_joint,
    ),
    Mistake(
        "angles-in-degrees", "Degrees where radians are due",
        "The angles seem to be given in degrees: radians are due.", "6.8", takes=_degrees,
    ),
    Mistake(
        "relative-angle-in-condition", "Relative angle for absolute in the condition",
        "In the condition that ties several joints, a joint's own angle seems to stand where an absolute angle is due.",
        "6.8", takes=_relative,
    ),
    Mistake(
        "sign-in-condition", "Sign in the condition",
        "In the condition that ties several joints, a term seems to have the wrong sign.", "6.8", takes=_term_sign,
    ),
    Mistake(
        "term-lost-in-condition", "Term of the condition lost",
        "The condition that ties several joints seems to lack a term.", "6.8", takes=_term_lost,
    ),
    Mistake(
        "waves-exchanged-in-condition", "Sine and cosine exchanged in the condition",
        "In the condition that ties several joints, sine and cosine seem to be exchanged.", "6.8", takes=_trigs,
    ),
)  # fmt: skip
