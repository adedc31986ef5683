"""Mistakes in sets of singular configurations."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, islice, product
from operator import mul

import sympy as sp

from qdot.exercises.answer_types import ConditionSet
from qdot.exercises.arm.chain import Chain
from qdot.exercises.mistakes.base import AnswerGenerator, Mistake, MistakenAnswer, restrict_to_tables
from qdot.exercises.problem.problem import Part
from qdot.exercises.singularities.singularity import Component

Components = tuple[Component, ...]
JointValues = tuple[sp.Expr, ...]

FALSELY_SINGULAR_ANGLES: tuple[tuple[sp.Expr, ...], ...] = (
    (sp.S.Zero, sp.pi), (sp.S.Zero,), (sp.pi,), (sp.pi / 2, -sp.pi / 2), (sp.pi / 2,), (-sp.pi / 2,),
)  # fmt: skip
"""Sets of joint angles that students may falsely call singular."""
MAX_COMBINATIONS = 20
"""Maximum number of combinations that are tried if conditions are omitted from several components at once."""


def _components(part: Part) -> Components:
    return part.answer.components if isinstance(part.answer, ConditionSet) else ()


def _count_clause(chain: Chain) -> str:
    """Return a clause that says which factors of det J, or which minors, have to be considered."""
    square = chain.n == len(chain.task)
    return "check every factor of det J" if square else "check every way in which all minors can be zero"


def zero_question(chain: Chain) -> str:
    """Return the question with which a student can test whether a configuration is singular."""
    return "is det J zero there" if chain.n == len(chain.task) else "are all minors zero there"


def _make_answer(components: Sequence[Component], **words: object) -> MistakenAnswer:
    return MistakenAnswer(ConditionSet(tuple(components)), words)


def _replace_component(components: Components, index: int, new: Component) -> Components:
    return (*components[:index], new, *components[index + 1 :])


def _map_solutions(component: Component, change: Callable[[sp.Symbol, JointValues], JointValues]) -> Component:
    """Return a component with its joint values changed, or unchanged if it has none."""
    if component.solutions is None:
        return component
    return replace(component, solutions=tuple((q, change(q, values)) for q, values in component.solutions))


def _keep_one_value(component: Component, index: int, only_joint: sp.Symbol | None = None) -> Component:
    """Return a component with one value of each joint.

    If `only_joint` is given, the other joints keep all their values.
    """
    return _map_solutions(component, lambda q, values: values[: index + 1][-1:] if only_joint in (None, q) else values)


def _find_multivalued(components: Components) -> list[int]:
    return [k for k, c in enumerate(components) if c.solutions and any(len(values) > 1 for _, values in c.solutions)]


def _keep_one_root(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    components = _components(part)
    multivalued = _find_multivalued(components)
    for index in (0, 1):
        if len(multivalued) > 1:
            yield _make_answer([_keep_one_value(c, index) if k in multivalued else c for k, c in enumerate(components)])
        for k in multivalued:
            yield _make_answer(_replace_component(components, k, _keep_one_value(components[k], index)))
        for k in multivalued:  # reduce the values of one joint only, if the component restricts several
            solutions = components[k].solutions or ()
            for joint, _ in solutions if len(solutions) > 1 else ():
                yield _make_answer(_replace_component(components, k, _keep_one_value(components[k], index, joint)))


def name_missed_component(chain: Chain, component: Component) -> tuple[str, dict[str, object]]:
    """Return the name of the mistake in which a component is omitted, and the words for its message."""
    if _ties_several_joints(chain, component):
        return "shoulder-missed", {"every": _count_clause(chain), "instead": ""}
    return "component-missed", {"kind": "values of a joint", "every": _count_clause(chain)}


def _miss_component(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    components = _components(part)
    for k, component in enumerate(components):
        if len(components) > 1:
            if _ties_several_joints(chain, component):
                kind = "a condition that involves several joints"
            else:
                kind = "values of a joint"
            yield _make_answer((*components[:k], *components[k + 1 :]), kind=kind, every=_count_clause(chain))
    for k in range(len(components)):
        if len(components) > 2:
            yield _make_answer((components[k],), kind="more than one kind of condition", every=_count_clause(chain))


def _ties_several_joints(chain: Chain, component: Component) -> bool:
    """Return whether any condition of a component depends on several joints."""
    return any(len(condition.free_symbols & set(chain.q)) > 1 for condition in component.conditions)


def _miss_tied_conditions(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers without the conditions that tie several joints, such as a shoulder singularity.

    Values of one joint may be given instead. The other conditions can be found by looking at one joint at a time.
    """
    components = _components(part)
    untied_components = [component for component in components if not _ties_several_joints(chain, component)]
    if len(untied_components) == len(components):
        return
    if untied_components:
        yield _make_answer(untied_components, every=_count_clause(chain), instead="")
    for q, singular_component in _call_singular(chain, components):
        instead = f", and {q} = {_values_in_words(singular_component)} is given as singular instead"
        yield _make_answer((*untied_components, singular_component), every=_count_clause(chain), instead=instead)


def _call_singular(chain: Chain, components: Components) -> Iterator[tuple[sp.Symbol, Component]]:
    """Yield joints that are falsely called singular, with a component that gives zeros of a sine or cosine."""
    singular_joints = {q for component in components for q, _ in component.solutions or ()}
    for joint, q in zip(chain.joints, chain.q, strict=True):
        if joint.kind == "R" and q not in singular_joints and components:
            for values in FALSELY_SINGULAR_ANGLES:
                yield q, Component((q,), ((q, values),))


def _values_in_words(component: Component) -> str:
    return ", ".join(str(value) for _, values in component.solutions or () for value in values)


def _keep_some_conditions(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers with only some of the conditions that must hold simultaneously.

    Conditions are omitted from one component, or from all components that have several.
    """
    components = _components(part)
    for kept_count in (1, 2):
        partial_sets = {
            k: list(_partial_components(c, kept_count))
            for k, c in enumerate(components)
            if len(c.conditions) > kept_count
        }
        for k, alternatives in partial_sets.items():
            for shortened_component in alternatives:
                yield _make_answer(
                    _replace_component(components, k, shortened_component),
                    joint=_joints_in_words(chain, [shortened_component]),
                )
        if len(partial_sets) > 1:
            for combination in islice(product(*partial_sets.values()), MAX_COMBINATIONS):
                new_components = [
                    dict(zip(partial_sets, combination, strict=True)).get(k, c) for k, c in enumerate(components)
                ]
                yield _make_answer(new_components, joint=_joints_in_words(chain, combination))


def _partial_components(component: Component, condition_count: int) -> Iterator[Component]:
    """Yield components that have only `condition_count` of the conditions of a component."""
    for indices in combinations(range(len(component.conditions)), condition_count):
        conditions = tuple(component.conditions[i] for i in indices)
        solutions = component.solutions
        yield Component(conditions, None if solutions is None else tuple(solutions[i] for i in indices))


def _joints_in_words(chain: Chain, components: Sequence[Component]) -> str:
    symbols = {q for component in components for condition in component.conditions for q in condition.free_symbols}
    return ", ".join(str(q) for q in chain.q if q in symbols)


def _use_other_joint(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    all_components = _components(part)
    for k, component in enumerate(all_components):
        if component.solutions is None or len(component.solutions) > 1:
            continue
        ((singular_joint, values),) = component.solutions
        for joint, q in zip(chain.joints, chain.q, strict=True):
            if q != singular_joint and (joint.kind == "R") == singular_joint.name.startswith("theta"):
                yield _make_answer(
                    _replace_component(all_components, k, replace(component, solutions=((q, values),))), joint=q
                )


def _find_revolute_components(part: Part) -> list[int]:
    """Return the indices of the components that give only values of revolute joints."""
    return [
        k
        for k, component in enumerate(_components(part))
        if component.solutions is not None and all(q.name.startswith("theta") for q, _ in component.solutions)
    ]


def _change_angles(part: Part, change: Callable[[sp.Expr], sp.Expr], component_indices: Collection[int]) -> Components:
    """Return all components; those with indices in `component_indices` have every value changed."""
    return tuple(
        _map_solutions(component, lambda _, values: tuple(map(change, values))) if k in component_indices else component
        for k, component in enumerate(_components(part))
    )


def _shift_quarter_turn(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    angle_indices = _find_revolute_components(part)
    for chosen_indices in [*([k] for k in angle_indices), *([angle_indices] if len(angle_indices) > 1 else [])]:
        yield _make_answer(_change_angles(part, lambda value: value + sp.pi / 2, chosen_indices))


def _scale_angles(*factors: sp.Expr) -> AnswerGenerator:
    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        angle_indices = _find_revolute_components(part)
        for factor in factors if angle_indices else ():
            yield _make_answer(_change_angles(part, partial(mul, factor), angle_indices))

    return answers


def _zero_sine_component(q: sp.Symbol) -> Component:
    return Component((sp.sin(q),), ((q, (sp.S.Zero, sp.pi)),))


def _add_joint(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers in which a joint is falsely called singular, a mistake that the book itself makes."""
    components = _components(part)
    for q, singular_component in _call_singular(chain, components):
        yield _make_answer(
            (*components, singular_component),
            joint=q,
            values=_values_in_words(singular_component),
            zero=zero_question(chain),
        )


def _misuse_offsets(factor: int) -> AnswerGenerator:
    """Return a function that yields answers in which all conditions misuse a joint's constant offset.

    The offset is omitted (factor 1), or has the opposite sign (factor 2).
    """

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        components = _components(part)
        prismatic_joints = {q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "P"}
        for constants in (dict(zip(chain.q, chain.offsets, strict=True)), _constants_in(chain, components)):
            offsets = {  # a shift by half a turn is skipped because it usually gives the same set
                q: factor * constant
                for q, constant in constants.items()
                if constant != 0 and (q in prismatic_joints or sp.sin(factor * constant) != 0)
            }
            for q, offset in offsets.items():
                shifted_components = tuple(_shift_by_offset(component, {q: offset}) for component in components)
                if shifted_components != components:
                    yield _make_answer(shifted_components, joint=str(q))
            if components and len(offsets) > 1:
                yield _make_answer([_shift_by_offset(c, offsets) for c in components], joint="the joints")

    return answers


def _constants_in(chain: Chain, components: Components) -> dict[sp.Symbol, sp.Expr]:
    """Return the constants that the conditions add to single joint variables in sines and cosines.

    They may differ from the constants in the table.
    """
    conditions = (condition for component in components for condition in component.conditions)
    angles = [trig.args[0] for condition in conditions for trig in condition.atoms(sp.sin, sp.cos)]
    constants = {q: angle - q for angle in angles for q in chain.q if q in angle.free_symbols}
    return {q: constant for q, constant in constants.items() if constant.is_number}


def _shift_by_offset(component: Component, offsets: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with q replaced by q - c, for each joint variable q with a constant c in `offsets`."""
    conditions = tuple(condition.xreplace({q: q - c for q, c in offsets.items()}) for condition in component.conditions)
    shifted_component = _map_solutions(
        component, lambda q, values: tuple(value + offsets.get(q, 0) for value in values)
    )
    return replace(shifted_component, conditions=conditions)


def _split_conjunction(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers in which conditions that must hold simultaneously are alternatives."""
    components = _components(part)
    for k, component in enumerate(components):
        if len(component.conditions) > 1:
            yield _make_answer((*components[:k], *_partial_components(component, 1), *components[k + 1 :]))


def _keep_one_root_each(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers that give one value instead of several in two or three of the components."""
    components = _components(part)
    multivalued = _find_multivalued(components)
    for chosen_count in range(2, min(len(multivalued), 4)):
        for chosen_indices, index in product(combinations(multivalued, chosen_count), (0, 1)):
            yield _make_answer(
                [_keep_one_value(c, index) if k in chosen_indices else c for k, c in enumerate(components)]
            )


def _join_alternatives(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers in which alternatives have become conditions that must hold simultaneously.

    Two of the alternatives that give joint values are joined, or all of them.
    """
    components = _components(part)
    solved_components = [component for component in components if component.solutions is not None]
    for joined_count in sorted({2, len(solved_components)} - {0, 1}):
        for joined_components in combinations(solved_components, joined_count):
            solutions = tuple(solution for component in joined_components for solution in component.solutions or ())
            if len({q for q, _ in solutions}) == len(solutions):
                conditions = tuple(condition for component in joined_components for condition in component.conditions)
                others = (component for component in components if component not in joined_components)
                yield _make_answer((*others, Component(conditions, solutions)))


def _add_condition(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers in which a sufficient condition is restricted by an unnecessary one on another joint."""
    components = _components(part)
    for k, component in enumerate(components):
        singular_joints = {q for q, _ in component.solutions or ()}
        for joint, q in zip(chain.joints, chain.q, strict=True):
            if component.solutions and q not in singular_joints:
                for value in (sp.S.Zero, sp.pi) if joint.kind == "R" else (sp.S.Zero,):
                    extended = Component((*component.conditions, q), (*component.solutions, (q, (value,))))
                    yield _make_answer(_replace_component(components, k, extended), joint=str(q))


def _invert_tangent(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield the answer in which the ratio in each arctangent is inverted."""
    components = _components(part)
    invert = lambda value: value.replace(sp.atan, lambda ratio: sp.atan(1 / ratio))  # noqa: E731
    if (changed_components := _change_angles(part, invert, range(len(components)))) != components:
        yield _make_answer(changed_components)


def _flip_values(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Yield answers with the sign of one value of a joint flipped, or of all its values."""
    components = _components(part)
    for k, component in enumerate(components):
        for index, (q, values) in enumerate(component.solutions or ()):
            flipped_values = [tuple(-v if v == value else v for v in values) for value in values if value != 0]
            for new_values in dict.fromkeys([*flipped_values, tuple(-value for value in values)]):
                if {sp.expand(value) % (2 * sp.pi) for value in new_values} == {
                    value % (2 * sp.pi) for value in values
                }:
                    continue  # the values are the same, such as pi/2 and -pi/2
                solutions = list(component.solutions or ())
                solutions[index] = (q, new_values)
                yield _make_answer(
                    _replace_component(components, k, replace(component, solutions=tuple(solutions))), joint=str(q)
                )


def _call_all_singular(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    revolute_joints = [q for joint, q in zip(chain.joints, chain.q, strict=True) if joint.kind == "R"]
    if _components(part) and len(revolute_joints) > 1:
        yield _make_answer([_zero_sine_component(q) for q in revolute_joints], zero=zero_question(chain))


def _change_tied_condition(change: Callable[[sp.Expr], Iterator[sp.Expr]]) -> AnswerGenerator:
    """Return a function that yields answers in which one condition that ties several joints is changed."""

    def answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        components = _components(part)
        for k, component in enumerate(components):
            for index, condition in enumerate(component.conditions if component.solutions is None else ()):
                for new_condition in change(condition) if condition.is_Add else ():
                    conditions = (*component.conditions[:index], new_condition, *component.conditions[index + 1 :])
                    yield _make_answer(_replace_component(components, k, Component(conditions, None)))

    return answers


def _use_relative_angle(condition: sp.Expr) -> Iterator[sp.Expr]:
    sums = {trig.args[0] for trig in condition.atoms(sp.sin, sp.cos) if trig.args[0].is_Add}
    last_angle = {angle: max(angle.free_symbols, key=lambda symbol: symbol.name) for angle in sums}
    if last_angle:
        yield condition.xreplace(last_angle)


def _exchange_sines_and_cosines(condition: sp.Expr) -> Iterator[sp.Expr]:
    trigs = condition.atoms(sp.sin, sp.cos)
    yield condition.xreplace({trig: (sp.cos if isinstance(trig, sp.sin) else sp.sin)(trig.args[0]) for trig in trigs})


_ALL_MISTAKES = (
    Mistake("one-root-only", "Only one of two roots",
            "You seem to have given only one of several values of a joint. A sine or cosine can take the same value "
            "more than once in a full turn.", "6.8", answers=_keep_one_root),
    Mistake("shoulder-missed", "Condition that involves several joints missed",
            "You seem to have left out a condition that involves several joints, for example that the point lies on "
            "the first axis{instead}: {every}.", "6.8 and Example 6.3", answers=_miss_tied_conditions),
    Mistake("component-missed", "Part of the singular configurations missed",
            "You seem to have left out part of the singular configurations, namely {kind}: {every}.", "6.8",
            answers=_miss_component),
    Mistake("condition-of-several-forgotten", "One of several conditions forgotten",
            "You seem to have forgotten a condition that must hold together with the one for {joint}. J is not "
            "square: it loses rank only if all of its maximal minors are zero.", "6.8",
            answers=_keep_some_conditions),
    Mistake("quarter-turn-singular", "Sine instead of cosine in the condition",
            "Your angles seem to be off by 90°. For which angles is the sine zero, and for which the cosine?", "6.8",
            answers=_shift_quarter_turn),
    Mistake("joint-called-singular", "Condition for a joint that does not matter",
            "You seem to have given {joint} as singular at {values}: {zero}? (The book makes this mistake in its own "
            "Example 6.3.)", "6.8", answers=_add_joint),
    Mistake("value-called-singular", "Value that is not singular",
            "You seem to have given {joint} = {values} as singular: {zero}?", "6.8"),
    Mistake("all-joints-straight", "All joints given as singular at 0 or pi",
            "You seem to have given every joint as singular at 0 or pi: {zero}?", "6.8", answers=_call_all_singular),
    Mistake("condition-for-other-joint", "Condition for another joint",
            "You seem to have given a condition for {joint} that applies to another joint.", "6.8",
            answers=_use_other_joint),
    Mistake("angles-in-degrees", "Degrees instead of radians in the conditions",
            "You seem to have given the angles in degrees. Give them in radians.",
            "6.8", answers=_scale_angles(180 / sp.pi)),
    Mistake("relative-angle-in-condition", "Relative instead of absolute angle in the condition",
            "In the condition that involves several joints, you seem to have used a joint's own angle instead of an "
            "absolute angle.", "6.8", answers=_change_tied_condition(_use_relative_angle)),
    Mistake("sign-in-condition", "Wrong sign in the condition",
            "In the condition that involves several joints, one term seems to have the wrong sign.", "6.8",
            answers=_change_tied_condition(lambda condition: (condition - 2 * term for term in condition.args))),
    Mistake("term-lost-in-condition", "Term missing from the condition",
            "In the condition that involves several joints, one term seems to be missing.", "6.8",
            answers=_change_tied_condition(lambda condition: (condition - term for term in condition.args))),
    Mistake("waves-exchanged-in-condition", "Sine and cosine exchanged in the condition",
            "In the condition that involves several joints, you seem to have exchanged sine and cosine.", "6.8",
            answers=_change_tied_condition(_exchange_sines_and_cosines)),
    Mistake("offset-forgotten-in-set", "Joint offset left out of the conditions",
            "You seem to have left out the constant that is added to {joint}. Give the conditions for the joint "
            "variable itself.", "6.8", answers=_misuse_offsets(1), rare=True),
    Mistake("offset-sign-in-set", "Joint offset on the wrong side",
            "The constant that is added to {joint} seems to have the wrong sign. Solve for the joint variable: the "
            "constant moves to the other side.", "6.8", answers=_misuse_offsets(2), rare=True),
    Mistake("or-for-and", '"Or" instead of "and" in the conditions',
            "You seem to have given conditions as alternatives that must hold together. J loses rank only if all of "
            "its maximal minors are zero.", "6.8", answers=_split_conjunction, rare=True),
    Mistake("one-root-of-each", "One root of several joints",
            "For more than one joint, you seem to have given only one of several values. A sine or cosine can take "
            "the same value more than once in a full turn.", "6.8", answers=_keep_one_root_each, rare=True),
    Mistake("and-for-or", '"And" instead of "or" in the conditions',
            "You seem to have given alternatives as conditions that hold together. Each of them is enough by itself.",
            "6.8",
            answers=_join_alternatives, rare=True),
    Mistake("condition-too-many", "Condition that is not needed",
            "You seem to have added a condition for {joint} to one that is enough by itself.", "6.8",
            answers=_add_condition,
            rare=True),
    Mistake("values-in-wrong-radians", "Values converted to the wrong radians",
            "You seem to have doubled or halved the angles when you converted them. Note that 180° is pi.", "6.8",
            answers=_scale_angles(sp.S.Half, sp.S(2)), rare=True),
    Mistake("tangent-turned-over", "Inverted tangent",
            "You seem to have inverted the tangent. Which of the two factors multiplies the sine, and which one the "
            "cosine?", "6.8", answers=_invert_tangent, rare=True),
    Mistake("value-sign-in-set", "Value of a joint with the wrong sign",
            "A value of {joint} seems to have the wrong sign. Check it in your condition.",
            "6.8", answers=_flip_values, rare=True),
)  # fmt: skip

TABLE_MISTAKES = frozenset({"offset-forgotten-in-set", "offset-sign-in-set"})
"""The mistakes about the constants that a table adds to joint variables."""
MISTAKES = restrict_to_tables(_ALL_MISTAKES, TABLE_MISTAKES)
