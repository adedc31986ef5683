"""Questions on singular configurations and their kind (6.8; Examples 6.2 and 6.3).

The answers include the shoulder singularity, which Example 6.3 omits. The singular set of an arm consists of
components. A component is given by values of some joints (its solutions), or by a condition on several joints.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.problem.problem import Details, list_values_by_name, recorded_as
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.exact_configurations import sample_false_root
from qdot.exercises.questions.inversion import JointValues, Lengths
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import classify
from qdot.exercises.singularities.normalized_arm import is_independent_of_joint_1, normalize_arm, normalize_joint_values
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples

KIND_OPTIONS = {
    "boundary": "a boundary singularity",
    "internal": "an internal singularity",
    "regular": "no singularity: the Jacobian has full rank there",
}
"""Answer options for questions about the kind of a configuration, keyed by kind."""


MAX_MISLEADING_TRIES, MAX_REGULAR_TRIES = 150, 200
"""When looking for a regular configuration: the maximum number of samples chosen to seem singular after a mistake, and
of all samples."""


def find_singularity_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable (no singular or no regular configurations), or None if it is suitable."""
    components = find_singular_set(chain)
    if components is None:
        return "its Jacobian has less than full rank everywhere"
    return None if components else "it has no singular configuration"


def find_lost_direction_objection(chain: Chain) -> str | None:
    """Return why an arm can't lose exactly one of several directions of motion, or None if it can."""
    m = len(chain.task)
    if objection := find_singularity_objection(chain):
        return objection
    if m > chain.n:
        return f"its task has {m} components, but its {count_noun(chain.n, 'joint')} can never produce all of them"
    return "its task has only one component of velocity" if m < 2 else None


def _find_kind_objection(chain: Chain) -> str | None:
    if not can_establish_kind(chain):
        return "qdot can't decide between boundary and internal singularities for its task"
    return find_singularity_objection(chain)


@dataclass(frozen=True)
class ConfigurationsOfOneKind:
    """The configurations whose kind is asked for: one with given joint values, or all that satisfy a condition.

    The prompt shows the joint values, or describes the condition in `words`. The condition itself is the answer to
    another question.
    """

    joints: JointValues
    condition: sp.Expr | None = None
    words: str = ""

    @property
    def values(self) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
        """The joint values in order."""
        return tuple(self.joints.items())


def find_components_containing(chain: Chain, configurations: ConfigurationsOfOneKind) -> list[Component]:
    """Return the components of the singular set that contain the configurations, restricted to the joint values."""
    components = []
    for component in find_singular_set(chain) or ():
        if configurations.condition is not None:
            if configurations.condition in component.conditions:
                components.append(component)
        elif component.solutions is not None:
            values = tuple((q, configurations.joints[q]) for q, _ in component.solutions)
            if values in component.list_value_combinations():
                components.append(component.restrict_to(values))
    return components


@dataclass(frozen=True, kw_only=True)
class KindDetails(Details):
    """Details of a question about the kind of configurations: "boundary", "internal" or "regular"."""

    configurations: ConfigurationsOfOneKind = field(metadata=recorded_as("place"))
    singularity_kind: str = field(metadata=recorded_as("type"))

    def list_shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the given joint values, by the names of the joint variables."""
        return list_values_by_name(self.configurations.joints)


def _ask_kind(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose the kind first, then sample configurations of this kind."""
    for kind in rng.permutation(tuple(KIND_OPTIONS)):
        configurations = _sample_configurations_of_kind(chain, kind, rng)
        if configurations is not None:
            answer, _ = shuffle_options(tuple(KIND_OPTIONS), kind, rng, KIND_OPTIONS.__getitem__)
            return answer, KindDetails(configurations=configurations, singularity_kind=kind)
    return None


def _sample_configurations_of_kind(chain: Chain, kind: str, rng: Stream) -> ConfigurationsOfOneKind | None:
    """Return a random configuration of a kind, or all that satisfy a random condition; None if none is found."""
    if kind == "regular":
        return _sample_regular_configuration(chain, rng)
    for component in rng.permutation(find_singular_set(chain) or ()):
        if component.solutions is None:
            classification = classify(chain, component)
            words = classification.meaning.split(",")[0]
            # The prompt gives only the words, so they must say on which axis or how far from it a point is.
            if len(component.conditions) > 1 or "axis" not in convention_of(chain).rename_origins(words):
                continue
            if classification.is_uniform and classification.kind == kind:
                return ConfigurationsOfOneKind({}, component.conditions[0], words)
        else:
            for values in rng.permutation(component.list_value_combinations() * 2):  # twice, with other joint values
                joints = {**inversion.sample_joint_values(chain, rng), **dict(values)}
                if _find_kinds_over_lengths(chain, joints) == {kind}:
                    return ConfigurationsOfOneKind(joints)
    return None


def _sample_regular_configuration(chain: Chain, rng: Stream) -> ConfigurationsOfOneKind:
    """Return a random regular configuration.

    If possible, a sign error or an error of 90 degrees makes it look singular.
    """
    roots = [
        (q, values)
        for component in find_singular_set(chain) or ()
        for q, values in component.solutions or ()
        if not any(value.has(sp.acos, sp.asin, sp.atan) and value.free_symbols for value in values)
    ]
    for attempt in range(MAX_REGULAR_TRIES):
        joints = inversion.sample_joint_values(chain, rng)
        if roots and attempt < MAX_MISLEADING_TRIES:  # perhaps every mistake leads too close to another root
            joints |= sample_false_root(roots, {}, rng)
        is_clearly_regular = _is_well_conditioned(chain, joints, rng) and not _may_become_singular(chain, joints)
        if is_clearly_regular and _find_kinds_over_lengths(chain, joints) == {"regular"}:
            return ConfigurationsOfOneKind(joints)
    raise RuntimeError(f"no regular configuration of {chain} was found; please report this")


def _may_become_singular(chain: Chain, joints: JointValues) -> bool:
    """Return whether det J at these joint values may be zero for some lengths.

    It may be zero if one of its factors has terms of both signs.
    """
    if not chain.has_square_jacobian or not chain.parameters:
        return False
    for factor in sp.Mul.make_args(derive(chain).determinant.xreplace(joints)):
        coefficients = [sp.N(value, 20) for value in sp.Poly(sp.expand(factor), *chain.parameters).coeffs()]
        signs = {bool(value > 0) for value in coefficients if abs(value) > sp.Float("1e-12")}
        if len(signs) > 1:
            return True
    return False


def _is_well_conditioned(chain: Chain, joints: JointValues, rng: Stream) -> bool:
    """Return whether sigma_min/sigma_max of J is large enough for four random sets of lengths.

    The limit is lower than in questions that ask for numbers, because all four ratios must exceed it.
    """
    min_ratio = 0.8 * inversion.find_min_conditioning(chain)
    all_lengths = (inversion.sample_lengths(chain, rng) for _ in range(4))
    return all(inversion.compute_conditioning(chain, lengths, joints) > min_ratio for lengths in all_lengths)


_TEST_LENGTHS = (sp.Rational(1, 20), sp.Rational(3, 10), sp.Rational(7, 10), sp.S(2), sp.S(6))
"""Values of symbolic lengths (m) for which the kind of a configuration is computed. It must be the same for all
values."""
_RANDOM_SET_COUNT = 20
"""Number of sets of random lengths for which the kind is also computed; twice as many if there are two or more
lengths."""


def _list_test_lengths(chain: Chain) -> Iterator[Lengths]:
    """Yield numbers for the symbolic lengths: first different test values, then random values from 5 cm to 6 m."""
    count = len(_TEST_LENGTHS) if chain.parameters else 1
    for start in range(count):
        yield {symbol: _TEST_LENGTHS[(start + 2 * i) % count] for i, symbol in enumerate(chain.parameters)}
    stream = Stream("lengths that are tried")
    for _ in range(_RANDOM_SET_COUNT * min(len(chain.parameters), 2)):
        lengths_in_cm = {symbol: round(5 * 120 ** stream.uniform(0, 1)) for symbol in chain.parameters}
        yield {symbol: sp.Rational(length, 100) for symbol, length in lengths_in_cm.items()}


def _find_kinds_over_lengths(chain: Chain, joints: JointValues) -> frozenset[str | None]:
    """Return the kinds that a configuration has for different lengths; {None} if it doesn't exist for some of them.

    If joint 1 moves the whole arm, its value does not matter and is set to zero. The arm is normalized, because arms
    that differ only in their base or joint offsets can then share a cached result.
    """
    values = normalize_joint_values(chain, joints)
    if is_independent_of_joint_1(chain):
        values = (sp.S.Zero, *values[1:])
    return _find_kinds(normalize_arm(chain), values)


@lru_cache(maxsize=4096)
def _find_kinds(chain: Chain, values: tuple[sp.Expr, ...]) -> frozenset[str | None]:
    """Return the kinds of a configuration of a normalized arm for all test lengths; {None} if it isn't always real."""
    samples = []
    for lengths in _list_test_lengths(chain):
        joints = [sp.N(value.xreplace(lengths)) for value in values]
        if not all(joint_value.is_real for joint_value in joints):  # the arm has no such configuration
            return frozenset({None})
        arm = NumericChain(chain, list_values_by_name(lengths))
        samples.append(Sample(arm, np.array([float(joint_value) for joint_value in joints])))
    return frozenset(classify_samples(chain, samples))


QUESTIONS = (
    Question(
        "singular-angles", "Singular configurations", "6.8", points=2.0, prerequisites=("determinant", "jacobian"),
        sample=lambda chain, _: (ConditionSet(find_singular_set(chain) or ()), Details()),
        find_arm_objection=find_singularity_objection, zero_formula="det(J)",
        alternative_prerequisites=(("determinant",), ("jacobian",)),
    ),
    Question(
        "singularity-type", "Type of singularity", "below 6.7", sample=_ask_kind,
        find_arm_objection=_find_kind_objection,
    ),
)  # fmt: skip
