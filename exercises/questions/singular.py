"""Questions on singular configurations and their type (6.8; Examples 6.2 and 6.3, with the shoulder omitted there)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import ConditionSet
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, values_by_name
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, make_stage_formula, shuffle_options
from qdot.exercises.questions.geometry import sample_false_root
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import classify
from qdot.exercises.singularities.normalized_arm import first_joint_moves_all, normalize_arm, normalize_joint_values
from qdot.exercises.singularities.singularity import Component, singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples

KIND_OPTIONS = {
    "boundary": "a boundary singularity",
    "internal": "an internal singularity",
    "regular": "no singularity: the Jacobian has full rank there",
}


def _ask_conditions(chain: Chain, rng: Stream) -> AnswerAndDetails:
    return ConditionSet(singular_set(chain) or ()), Details()


def object_unless_singular(chain: Chain) -> str | None:
    """Return the objection to an arm without singular configurations, or without regular ones."""
    components = singular_set(chain)
    if components is None:
        return "its Jacobian has less than full rank everywhere"
    return None if components else "it has no singular configuration"


def object_unless_direction_lost(chain: Chain) -> str | None:
    """Return the objection to an arm that can't lose exactly one of several directions of motion."""
    m = len(chain.task)
    if objection := object_unless_singular(chain):
        return objection
    if m > chain.n:
        return f"its task has {m} components, but its {count_noun(chain.n, 'joint')} can never produce all of them"
    return "its task has only one component of velocity" if m < 2 else None


def _object_to_kinds(chain: Chain) -> str | None:
    if not can_establish_kind(chain):
        return "qdot can't decide between boundary and internal singularities for its task"
    return object_unless_singular(chain)


@dataclass(frozen=True)
class ConfigurationsOfOneKind:
    """The configurations that a question is about: given joint values, or all that satisfy a condition.

    The prompt shows the joint values or `words`, never the condition, which is the answer to another question.
    """

    joints: dict[sp.Symbol, sp.Expr]
    condition: sp.Expr | None = None
    words: str = ""

    @property
    def values(self) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
        """The joint values in order."""
        return tuple(self.joints.items())


def find_components_with(chain: Chain, configurations: ConfigurationsOfOneKind) -> list[tuple[Component, Component]]:
    """Return the components that contain the configurations, each also restricted to the given joint values."""
    components = []
    for component in singular_set(chain) or ():
        if configurations.condition is not None:
            if configurations.condition in component.conditions:
                components.append((component, component))
        elif component.solutions is not None:
            given = tuple((q, configurations.joints[q]) for q, _ in component.solutions)
            if given in component.value_combinations():
                components.append((component, component.at(given)))
    return components


@dataclass(frozen=True, kw_only=True)
class KindDetails(Details):
    """Details of a question about the kind of a configuration: "boundary", "internal" or "regular"."""

    place: ConfigurationsOfOneKind
    type: str

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the given joint values."""
        return values_by_name(self.place.joints)


def _ask_type(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose the correct answer first, then configurations of that kind; the kind is computed."""
    components = singular_set(chain) or ()
    for kind in rng.permutation(tuple(KIND_OPTIONS)):
        configurations = _sample_configurations_of_kind(chain, components, kind, rng)
        if configurations is not None:
            answer, _ = shuffle_options(tuple(KIND_OPTIONS), kind, rng, KIND_OPTIONS.__getitem__)
            return answer, KindDetails(place=configurations, type=kind)
    return None


def _sample_configurations_of_kind(
    chain: Chain, components: tuple[Component, ...], kind: str, rng: Stream
) -> ConfigurationsOfOneKind | None:
    if kind == "regular":
        return _sample_regular_configuration(chain, components, rng)
    for component in rng.permutation(components):
        if component.solutions is None:
            classification = classify(chain, component)
            words = classification.meaning.split(",")[0]
            if len(component.conditions) > 1 or "axis" not in convention_of(chain).rename_origins(words):
                continue
            if classification.uniform and classification.kind == kind:
                return ConfigurationsOfOneKind({}, component.conditions[0], words)
        else:
            for joints in _sample_joint_values_on(chain, component, rng):
                if _find_kinds_over_lengths(chain, joints) == {kind}:
                    return ConfigurationsOfOneKind(joints)
    return None


def _sample_regular_configuration(
    chain: Chain, components: tuple[Component, ...], rng: Stream
) -> ConfigurationsOfOneKind:
    """Return a random regular configuration that seems singular after a mistake of a sign or a right angle."""
    roots = [
        (q, values)
        for component in components
        for q, values in component.solutions or ()
        if not any(value.has(sp.acos, sp.asin, sp.atan) and value.free_symbols for value in values)
    ]
    for attempt in range(200):
        joints = inversion.sample_joint_values(chain, rng)
        if roots and attempt < 150:  # later, accept any: perhaps no mistake leads far enough from a root
            joints |= sample_false_root(roots, {}, rng)
        is_clearly_regular = _is_well_conditioned(chain, joints, rng) and not _may_become_singular(chain, joints)
        if is_clearly_regular and _find_kinds_over_lengths(chain, joints) == {"regular"}:
            return ConfigurationsOfOneKind(joints)
    raise RuntimeError(f"no regular configuration of {chain} was found; please report this")


def _may_become_singular(chain: Chain, joints: dict[sp.Symbol, sp.Expr]) -> bool:
    """Return whether det J may be zero for some lengths, because one of its factors has terms of both signs."""
    if len(chain.task) != chain.n or not chain.parameters:
        return False
    for factor in sp.Mul.make_args(derive(chain).determinant.xreplace(joints)):
        coefficients = [sp.N(c, 20) for c in sp.Poly(sp.expand(factor), *chain.parameters).coeffs()]
        signs = {bool(c > 0) for c in coefficients if abs(c) > sp.Float("1e-12")}
        if len(signs) > 1:
            return True
    return False


def _is_well_conditioned(chain: Chain, joints: dict[sp.Symbol, sp.Expr], rng: Stream) -> bool:
    minimum = 0.8 * inversion.min_conditioning(chain)
    all_lengths = (inversion.sample_lengths(chain, rng) for _ in range(4))
    return all(inversion.compute_conditioning(chain, lengths, joints) > minimum for lengths in all_lengths)


def _sample_joint_values_on(chain: Chain, component: Component, rng: Stream) -> Iterator[dict[sp.Symbol, sp.Expr]]:
    """Yield configurations of a component: its joint values, with new random values of the other joints each time."""
    for values in rng.permutation(component.value_combinations() * 2):
        yield {**inversion.sample_joint_values(chain, rng), **dict(values)}


_TEST_LENGTHS = (sp.Rational(1, 20), sp.Rational(3, 10), sp.Rational(7, 10), sp.S(2), sp.S(6))
_RANDOM_LENGTH_COUNT = 20
"""Test values of symbolic lengths, and the number of random ones. A kind must hold for very different lengths."""


def _iterate_test_lengths(chain: Chain) -> Iterator[dict[sp.Symbol, sp.Rational]]:
    """Yield values of the symbolic lengths: the tried values in turn, then random values between 0.05 and 6."""
    count = len(_TEST_LENGTHS) if chain.parameters else 1
    for start in range(count):
        yield {s: _TEST_LENGTHS[(start + 2 * i) % count] for i, s in enumerate(chain.parameters)}
    stream = Stream("lengths that are tried")
    for _ in range(_RANDOM_LENGTH_COUNT * min(len(chain.parameters), 2)):
        yield {s: sp.Rational(round(100 * 0.05 * 120 ** stream.uniform(0, 1)), 100) for s in chain.parameters}


def _find_kinds_over_lengths(chain: Chain, joints: dict[sp.Symbol, sp.Expr]) -> frozenset[str | None]:
    """Return the kinds that a configuration has for the test values of the symbolic lengths.

    The arm is normalized first. If joint 1 moves the arm as a whole, its value does not matter and is set to zero.
    """
    values = normalize_joint_values(chain, joints)
    if first_joint_moves_all(chain):
        values = (sp.S.Zero, *values[1:])
    return _find_kinds(normalize_arm(chain), values)


@lru_cache(maxsize=4096)
def _find_kinds(chain: Chain, values: tuple[sp.Expr, ...]) -> frozenset[str | None]:
    samples = []
    for lengths in _iterate_test_lengths(chain):
        joints = [sp.N(value.xreplace(lengths)) for value in values]
        if not all(joint_value.is_real for joint_value in joints):  # no such configuration with these lengths
            return frozenset({None})
        arm = NumericChain(chain, values_by_name(lengths))
        samples.append(Sample(arm, np.array([float(joint_value) for joint_value in joints])))
    return frozenset(classify_samples(chain, samples))


QUESTIONS = (
    Question(
        "singular-angles", "Singular configurations", "6.8", points=2.0, needs=("determinant", "jacobian"),
        sample=_ask_conditions, objection=object_unless_singular, source_questions=(("determinant",), ("jacobian",)),
        zero_formula=make_stage_formula("determinant"),
    ),
    Question("singularity-type", "Type of singularity", "below 6.7", sample=_ask_type, objection=_object_to_kinds),
)  # fmt: skip
