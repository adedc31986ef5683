"""Mistakes in sets of singular configurations.

A set consists of components (`singularities.singular_set`). A component has conditions that must hold simultaneously,
such as sin(theta2) = 0. Its solutions give the values of a joint for each condition, such as 0 and pi for theta2. A
component without solutions has a condition that ties several joints, such as a condition on theta2 and theta3.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, islice, product
from operator import mul

import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.mistakes.base import AnswerGenerator, MistakenAnswer, join_words
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.singularities.singular_set import Component

Components = tuple[Component, ...]

FALSELY_SINGULAR_ANGLES: tuple[tuple[sp.Expr, ...], ...] = (
    (sp.S.Zero, sp.pi), (sp.S.Zero,), (sp.pi,), (sp.pi / 2, -sp.pi / 2), (sp.pi / 2,), (-sp.pi / 2,),
)  # fmt: skip
"""Sets of joint angles that students may falsely call singular."""
MAX_COMBINATIONS = 20
"""Maximum number of combinations that are tried if conditions are omitted from several components at once."""


def _change_sets(change: Callable[[Chain, Components], Iterator[MistakenAnswer]]) -> AnswerGenerator:
    """Return a function that yields the wrong sets that `change` makes from the components of the correct set.

    Mistakes with messages about the determinant are made only in sets of singular configurations. These messages have
    the words "zero" or "instead".
    """

    def generate(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
        if isinstance(part.answer, ConditionSet) and part.answer.components:
            for mistaken_answer in change(chain, part.answer.components):
                if part.answer.is_singular_set:
                    yield mistaken_answer
                elif "zero" not in mistaken_answer.words and not mistaken_answer.words.get("instead"):
                    yield replace(mistaken_answer, words=advise_on_any_set(mistaken_answer.words))

    return generate


def _write_advice(chain: Chain) -> str:
    """Return advice on what to set to zero, as a sentence without a full stop."""
    if chain.has_square_jacobian:
        return "Set every factor of det J to zero"
    return "Find all ways in which all maximal minors can be zero at the same time"


def write_zero_question(chain: Chain) -> str:
    """Return a question, without its question mark, by which a student can test whether a configuration is singular."""
    return "Is det J zero there" if chain.has_square_jacobian else "Are all maximal minors zero there"


def advise_on_any_set(words: Mapping[str, object]) -> dict[str, object]:
    """Return the words for a message about any set, in which advice on the determinant of J is replaced."""
    return {**words, "every": "Find all ways in which the condition can hold"} if "every" in words else dict(words)


def _make_answer(components: Sequence[Component], **words: object) -> MistakenAnswer:
    """Return the answer with these components, and the words that complete the message about the mistake."""
    return MistakenAnswer(ConditionSet(tuple(components)), words=words)


def _replace_component(components: Components, index: int, new_component: Component) -> Components:
    return (*components[:index], new_component, *components[index + 1 :])


def _keep_one_value(component: Component, value_index: int, only_joint: sp.Symbol | None = None) -> Component:
    """Return a component with a single value of each joint: that at an index, or the last one if there are fewer.

    If `only_joint` is given, the other joints keep all values.
    """
    if not component.solutions:
        return component
    solutions = []
    for q, values in component.solutions:
        kept_value = values[min(value_index, len(values) - 1)]
        solutions.append((q, (kept_value,) if only_joint in (None, q) else values))
    return replace(component, solutions=tuple(solutions))


def _find_multivalued_components(components: Components) -> list[int]:
    """Return the indices of the components that give several values of a joint."""
    return [k for k, c in enumerate(components) if c.solutions and any(len(values) > 1 for _, values in c.solutions)]


def _keep_one_value_in(components: Components, indices: Collection[int], value_index: int) -> MistakenAnswer:
    """Return the answer with a single value of each joint in the components with these indices."""
    return _make_answer([_keep_one_value(c, value_index) if k in indices else c for k, c in enumerate(components)])


def _keep_one_root(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers that give one value of a joint instead of several: in all components, in one, or for one joint."""
    indices = _find_multivalued_components(components)
    index_choices = [[k] for k in indices]
    if len(indices) > 1:
        index_choices.insert(0, indices)
    for value_index in (0, 1):
        for chosen_indices in index_choices:
            yield _keep_one_value_in(components, chosen_indices, value_index)
        for k in indices:  # only one of several joints has a single value
            solutions = components[k].solutions or ()
            for joint, _ in solutions if len(solutions) > 1 else ():
                shortened_component = _keep_one_value(components[k], value_index, joint)
                yield _make_answer(_replace_component(components, k, shortened_component))


def name_missed_component(chain: Chain, component: Component) -> tuple[str, dict[str, object]]:
    """Return the name of the mistake of omitting a component, and the words for the message."""
    if _ties_several_joints(chain, component):
        return "shoulder-missed", {"every": _write_advice(chain), "instead": ""}
    return "component-missed", {"kind": "a condition on a joint variable", "every": _write_advice(chain)}


def _miss_component(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers without one of the components, and answers with only one of three or more components."""
    advice, count = _write_advice(chain), len(components)
    for k, component in enumerate(components if count > 1 else ()):
        is_tied = _ties_several_joints(chain, component)
        kind = "a condition that involves several joints" if is_tied else "a condition on a joint variable"
        yield _make_answer((*components[:k], *components[k + 1 :]), kind=kind, every=advice)
    for component in components if count > 2 else ():
        yield _make_answer((component,), kind="more than one condition", every=advice)


def _ties_several_joints(chain: Chain, component: Component) -> bool:
    """Return whether any condition of a component depends on several joints."""
    return any(len(condition.free_symbols & set(chain.q)) > 1 for condition in component.conditions)


def _miss_tied_conditions(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers without the conditions that tie several joints, such as a shoulder singularity.

    The answer may give values of a single joint instead.
    """
    untied_components = [component for component in components if not _ties_several_joints(chain, component)]
    if len(untied_components) == len(components):
        return
    if untied_components:
        yield _make_answer(untied_components, every=_write_advice(chain), instead="")
    for q, singular_component in _list_false_components(chain, components):
        instead = f", and to have given {q} = {_write_values(singular_component)} as singular instead"
        yield _make_answer((*untied_components, singular_component), every=_write_advice(chain), instead=instead)


def _list_false_components(chain: Chain, components: Components) -> Iterator[tuple[sp.Symbol, Component]]:
    """Yield joints that a student may falsely call singular, each with a component that gives values of this joint."""
    singular_joints = {q for component in components for q, _ in component.solutions or ()}
    for joint, q in zip(chain.joints, chain.q, strict=True):
        if joint.is_revolute and q not in singular_joints:
            for values in FALSELY_SINGULAR_ANGLES:
                yield q, Component((q,), ((q, values),))


def _write_values(component: Component) -> str:
    """Return the values of all joints in a component, separated by commas."""
    return ", ".join(str(value) for _, values in component.solutions or () for value in values)


def _keep_some_conditions(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers with only some of the conditions that must hold simultaneously.

    Conditions are omitted from one component, or from all components that have several.
    """
    for count in (1, 2):
        long_components = {k: c for k, c in enumerate(components) if len(c.conditions) > count}
        choices_by_index = {k: list(_keep_conditions(c, count)) for k, c in long_components.items()}
        replacements = [{k: choice} for k, choices in choices_by_index.items() for choice in choices]
        if len(choices_by_index) > 1:
            combinations_of_all = islice(product(*choices_by_index.values()), MAX_COMBINATIONS)
            replacements += [dict(zip(choices_by_index, choice, strict=True)) for choice in combinations_of_all]
        for replacement in replacements:
            new_components = [replacement.get(k, component) for k, component in enumerate(components)]
            yield _make_answer(new_components, joint=_name_joints(chain, [*replacement.values()]))


def _keep_conditions(component: Component, condition_count: int) -> Iterator[Component]:
    """Yield components that have only `condition_count` of the conditions of a component."""
    for indices in combinations(range(len(component.conditions)), condition_count):
        conditions = tuple(component.conditions[i] for i in indices)
        solutions = component.solutions
        yield Component(conditions, None if solutions is None else tuple(solutions[i] for i in indices))


def _name_joints(chain: Chain, components: Sequence[Component]) -> str:
    symbols = {q for component in components for condition in component.conditions for q in condition.free_symbols}
    return join_words([str(q) for q in chain.q if q in symbols])


def _use_other_joint(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers in which the values of a joint are given for another joint of the same kind."""
    for k, component in enumerate(components):
        if component.solutions is None or len(component.solutions) > 1:
            continue
        ((singular_joint, values),) = component.solutions
        for joint, q in zip(chain.joints, chain.q, strict=True):
            if q != singular_joint and joint.is_revolute == is_joint_angle(singular_joint):
                other_component = replace(component, solutions=((q, values),))
                yield _make_answer(_replace_component(components, k, other_component), joint=q)


def _find_revolute_components(components: Components) -> list[int]:
    """Return the indices of the components that give only values of revolute joints."""
    solutions = [component.solutions for component in components]
    return [k for k, s in enumerate(solutions) if s is not None and all(is_joint_angle(q) for q, _ in s)]


def _change_values(
    components: Components, indices: Collection[int], change: Callable[[sp.Expr], sp.Expr]
) -> Components:
    """Return all components, with every value of a joint changed in the components with these indices."""
    return tuple(c.map_values(lambda _, value: change(value)) if k in indices else c for k, c in enumerate(components))


def _shift_quarter_turn(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers with all angles shifted by pi/2: in one component, or in all of them."""
    angle_indices = _find_revolute_components(components)
    index_choices = [[k] for k in angle_indices]
    if len(angle_indices) > 1:
        index_choices.append(angle_indices)
    for chosen_indices in index_choices:
        yield _make_answer(_change_values(components, chosen_indices, lambda value: value + sp.pi / 2))


def _scale_angles(*factors: sp.Expr) -> AnswerGenerator:
    """Return a function that yields, for each factor, the answer with all angles multiplied by this factor."""

    def generate(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
        angle_indices = _find_revolute_components(components)
        for factor in factors if angle_indices else ():
            yield _make_answer(_change_values(components, angle_indices, partial(mul, factor)))

    return _change_sets(generate)


def _add_joint(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers in which a joint is falsely called singular."""
    for q, singular_component in _list_false_components(chain, components):
        words = {"joint": q, "values": _write_values(singular_component), "zero": write_zero_question(chain)}
        yield _make_answer((*components, singular_component), **words)


def _misuse_offsets(factor: int) -> AnswerGenerator:
    """Return a function that yields answers in which all conditions misuse a joint's constant offset.

    The offset is omitted (factor 1), or has the opposite sign (factor 2).
    """

    def generate(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
        prismatic_joints = {chain.q[i] for i in chain.prismatic_joints}
        for constants in (dict(zip(chain.q, chain.offsets, strict=True)), _find_constants(chain, components)):
            offsets = {  # skip shifts by half a turn, which usually give the same set
                q: factor * constant
                for q, constant in constants.items()
                if constant != 0 and (q in prismatic_joints or sp.sin(factor * constant) != 0)
            }
            for q, offset in offsets.items():
                shifted_components = tuple(_shift_by_offset(component, {q: offset}) for component in components)
                if shifted_components != components:
                    yield _make_answer(shifted_components, joint=str(q))
            if len(offsets) > 1:
                shifted_components = tuple(_shift_by_offset(component, offsets) for component in components)
                yield _make_answer(shifted_components, joint=join_words([*map(str, offsets)]))

    return _change_sets(generate)


def _find_constants(chain: Chain, components: Components) -> dict[sp.Symbol, sp.Expr]:
    """Return the constants that the conditions add to single joint variables in sines and cosines.

    These constants may differ from the offsets in the table.
    """
    conditions = (condition for component in components for condition in component.conditions)
    angles = [trig.args[0] for condition in conditions for trig in condition.atoms(sp.sin, sp.cos)]
    constants = {q: angle - q for angle in angles for q in chain.q if q in angle.free_symbols}
    return {q: constant for q, constant in constants.items() if constant.is_number}


def _shift_by_offset(component: Component, offsets: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component in which q - c replaces each joint variable q that has a constant c in `offsets`."""
    conditions = tuple(condition.xreplace({q: q - c for q, c in offsets.items()}) for condition in component.conditions)
    return replace(component.map_values(lambda q, value: value + offsets.get(q, 0)), conditions=conditions)


def _split_conjunction(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers with alternatives instead of conditions that must hold simultaneously."""
    for k, component in enumerate(components):
        if len(component.conditions) > 1:
            yield _make_answer((*components[:k], *_keep_conditions(component, condition_count=1), *components[k + 1 :]))


def _zero_each_term(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers that set every term of a sum to zero, although the terms may also cancel."""
    for k, component in enumerate(components):
        terms = sp.Add.make_args(component.conditions[0])
        if component.solutions is None and len(component.conditions) == 1 and len(terms) > 1:
            yield _make_answer(_replace_component(components, k, Component(tuple(terms), None)))


def _keep_one_root_each(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers that give one value of a joint instead of several, in two or three components, but not in all."""
    indices = _find_multivalued_components(components)
    for chosen_count in range(2, min(len(indices), 4)):
        for chosen_indices, value_index in product(combinations(indices, chosen_count), (0, 1)):
            yield _keep_one_value_in(components, chosen_indices, value_index)


def _join_alternatives(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers in which alternatives must hold simultaneously.

    Either two alternatives that give joint values are joined, or all of them.
    """
    solved_components = [component for component in components if component.solutions is not None]
    for joined_count in sorted({2, len(solved_components)} - {0, 1}):
        for joined_components in combinations(solved_components, joined_count):
            solutions = tuple(solution for component in joined_components for solution in component.solutions or ())
            if len({q for q, _ in solutions}) == len(solutions):
                conditions = tuple(condition for component in joined_components for condition in component.conditions)
                other_components = (component for component in components if component not in joined_components)
                yield _make_answer((*other_components, Component(conditions, solutions)))


def _add_condition(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers that add an unnecessary condition on another joint to a sufficient condition."""
    all_solutions = [component.solutions for component in components if component.solutions]
    sole_solutions = [solutions[0] for solutions in all_solutions if len(solutions) == 1]
    sufficient_values = {(q, value) for q, values in sole_solutions for value in values}
    for k, component in enumerate(components):
        singular_joints = {q for q, _ in component.solutions or ()}
        for joint, q in zip(chain.joints, chain.q, strict=True):
            if component.solutions and q not in singular_joints:
                for value in (sp.S.Zero, sp.pi) if joint.is_revolute else (sp.S.Zero,):
                    if (q, value) in sufficient_values:  # the whole component would be left out
                        continue
                    new_component = Component((*component.conditions, q), (*component.solutions, (q, (value,))))
                    yield _make_answer(_replace_component(components, k, new_component), joint=str(q))


def _invert_tangent(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield the answer with the ratio in each arctangent inverted."""

    def invert(value: sp.Expr) -> sp.Expr:
        return value.replace(sp.atan, lambda ratio: sp.atan(1 / ratio))

    if (changed_components := _change_values(components, range(len(components)), invert)) != components:
        yield _make_answer(changed_components)


def _flip_values(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield answers with the sign of one value of a joint flipped, or of all its values."""
    for k, component in enumerate(components):
        solutions = component.solutions or ()
        for solution_index, (q, values) in enumerate(solutions):
            angles = {value % (2 * sp.pi) for value in values}
            flipped_values = [tuple(-v if v == value else v for v in values) for value in values if value != 0]
            for new_values in dict.fromkeys([*flipped_values, tuple(-value for value in values)]):
                if {sp.expand(value) % (2 * sp.pi) for value in new_values} != angles:  # pi/2 and -pi/2 stay the same
                    new_solutions = (*solutions[:solution_index], (q, new_values), *solutions[solution_index + 1 :])
                    new_component = replace(component, solutions=new_solutions)
                    yield _make_answer(_replace_component(components, k, new_component), joint=str(q))


def _call_all_singular(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
    """Yield the answer that the arm is singular whenever a revolute joint is at 0 or pi."""
    revolute_joints = [chain.q[i] for i in chain.revolute_joints]
    if len(revolute_joints) > 1:
        zeros = [Component((sp.sin(q),), ((q, (sp.S.Zero, sp.pi)),)) for q in revolute_joints]
        yield _make_answer(zeros, zero=write_zero_question(chain))


def _change_tied_condition(change: Callable[[sp.Expr], Iterator[sp.Expr]]) -> AnswerGenerator:
    """Return a function that yields answers in which one condition that ties several joints is changed."""

    def generate(chain: Chain, components: Components) -> Iterator[MistakenAnswer]:
        for k, component in enumerate(components):
            for index, condition in enumerate(component.conditions if component.solutions is None else ()):
                for new_condition in change(condition) if condition.is_Add else ():
                    conditions = (*component.conditions[:index], new_condition, *component.conditions[index + 1 :])
                    yield _make_answer(_replace_component(components, k, Component(conditions, None)))

    return _change_sets(generate)


def _use_relative_angle(condition: sp.Expr) -> Iterator[sp.Expr]:
    """Yield a condition with each sum of joint angles replaced by its last angle."""
    sums = {trig.args[0] for trig in condition.atoms(sp.sin, sp.cos) if trig.args[0].is_Add}
    last_angles = {angle: max(angle.free_symbols, key=lambda symbol: symbol.name) for angle in sums}
    if last_angles:
        yield condition.xreplace(last_angles)


def _exchange_sines_and_cosines(condition: sp.Expr) -> Iterator[sp.Expr]:
    trigs = condition.atoms(sp.sin, sp.cos)
    yield condition.xreplace({trig: (sp.cos if isinstance(trig, sp.sin) else sp.sin)(trig.args[0]) for trig in trigs})


ANSWERS: dict[str, AnswerGenerator] = {
    "one-root-only": _change_sets(_keep_one_root),
    "shoulder-missed": _change_sets(_miss_tied_conditions),
    "component-missed": _change_sets(_miss_component),
    "condition-of-several-forgotten": _change_sets(_keep_some_conditions),
    "quarter-turn-singular": _change_sets(_shift_quarter_turn),
    "joint-called-singular": _change_sets(_add_joint),
    "all-joints-straight": _change_sets(_call_all_singular),
    "condition-for-other-joint": _change_sets(_use_other_joint),
    "angles-in-degrees": _scale_angles(180 / sp.pi),
    "relative-angle-in-condition": _change_tied_condition(_use_relative_angle),
    "sign-in-condition": _change_tied_condition(lambda condition: (condition - 2 * term for term in condition.args)),
    "term-lost-in-condition": _change_tied_condition(lambda condition: (condition - term for term in condition.args)),
    "waves-exchanged-in-condition": _change_tied_condition(_exchange_sines_and_cosines),
    "offset-forgotten-in-set": _misuse_offsets(factor=1),
    "offset-sign-in-set": _misuse_offsets(factor=2),
    "or-for-and": _change_sets(_split_conjunction),
    "terms-set-to-zero": _change_sets(_zero_each_term),
    "one-root-of-each": _change_sets(_keep_one_root_each),
    "and-for-or": _change_sets(_join_alternatives),
    "unneeded-condition": _change_sets(_add_condition),
    "values-in-wrong-radians": _scale_angles(sp.S.Half, sp.S(2)),
    "tangent-inverted": _change_sets(_invert_tangent),
    "value-sign-in-set": _change_sets(_flip_values),
}
