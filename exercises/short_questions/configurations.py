"""Questions that ask which of several configurations are singular.

The arm has numeric lengths. Some of its regular configurations seem singular to students who make a known mistake.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.exact_configurations import (
    ExactConfiguration,
    compute_full_rank,
    compute_rank,
    make_exact_configuration,
    sample_displayable_configuration,
    sample_false_root,
    sample_regular_configuration,
    sample_unequal_lengths,
    wrap_angles,
)
from qdot.exercises.questions.inversion import JointValues, Lengths, sample_joint_values
from qdot.exercises.reference_answers import Choice, Selection
from qdot.exercises.short_questions.options import Blame, ConfigurationOptions, find_shown_value
from qdot.exercises.short_questions.short_question import ShortQuestion
from qdot.exercises.short_questions.wrong_sets import make_wrong_sets
from qdot.exercises.singularities.singular_set import Component, find_singular_set

CLEARLY_REGULAR_RATIO = 0.12
"""Minimum ratio of the smallest to the largest singular value at a configuration that is visibly regular."""
MAX_TRIES = 40
"""Maximum number of samples of a singular configuration on each component, and of a regular configuration."""
MAX_COMPONENT_TRIES, MAX_ARM_TRIES = 6, 4
"""Maximum numbers of samples: of a regular configuration with joint values of a component, and of an arm's lengths."""
_SAMPLE_COUNT = 200
"""Number of random configurations at which the median ratio of singular values is computed."""
OPTION_COUNT = 5
"""Number of options if several of them are singular."""

ConfigurationAndBlame = tuple[ExactConfiguration, Blame | None]
"""A configuration, and the mistake that makes it seem singular, if any."""


def _assign_random_lengths(chain: Chain, rng: Stream) -> tuple[Chain, Lengths]:
    """Return the arm with random numbers for the symbolic lengths in its table, and these numbers."""
    lengths = sample_unequal_lengths(chain, rng)
    return substitute_in_arm(chain, lengths), lengths


@lru_cache(maxsize=256)
def _find_clearly_regular_ratio(chain: Chain) -> float:
    """Return the minimum ratio of singular values at which a configuration of an arm counts as clearly regular.

    Some arms, such as a SCARA with short links, hardly ever reach CLEARLY_REGULAR_RATIO. For these arms, return the
    median of the ratio.
    """
    rng = Stream("clearness")
    q = np.array([[float(value) for value in sample_joint_values(chain, rng).values()] for _ in range(_SAMPLE_COUNT)])
    sigma = np.linalg.svd(NumericChain(chain, {}).compute_jacobian(q)[:, chain.task_rows], compute_uv=False)
    return min(CLEARLY_REGULAR_RATIO, round(float(np.median(sigma[:, -1] / np.maximum(sigma[:, 0], 1e-12))), 3))


def _sample_singular_configurations(chain: Chain, rng: Stream) -> Iterator[ConfigurationAndBlame]:
    """Yield singular configurations of an arm: one of each component of its singular set, then another of each, etc."""
    for _ in range(MAX_TRIES):
        for component in rng.permutation(find_singular_set(chain) or ()):
            configuration = sample_displayable_configuration(chain, (component,), rng)
            if configuration is not None:
                yield configuration, None


def _sample_regular_configurations(
    chain: Chain, rng: Stream, singular_candidates: Sequence[ConfigurationAndBlame]
) -> Iterator[ConfigurationAndBlame]:
    """Yield regular configurations: first those that seem singular after a known mistake, then random ones.

    If a singular configuration contains a formula such as arctan(3/4), the first regular one contains a similar
    formula.
    """
    formula_roots = [root for configuration, _ in singular_candidates for root in configuration.formula_roots]
    for _ in range(MAX_COMPONENT_TRIES if formula_roots else 0):
        joints = {**sample_joint_values(chain, rng), **sample_false_root(formula_roots, {}, rng)}
        similar_configuration = make_regular_configuration(chain, joints)
        if similar_configuration is not None and similar_configuration.formula_roots:
            yield similar_configuration, None
            break
    for component, blame in rng.permutation(_find_falsely_singular_components(chain)):
        configuration = _sample_falsely_singular_configuration(chain, component, rng)
        if configuration is not None:
            yield configuration, blame
    for _ in range(MAX_TRIES):
        configuration = sample_regular_configuration(chain, rng, _find_clearly_regular_ratio(chain))
        if configuration is not None:
            yield configuration, None


def _find_falsely_singular_components(chain: Chain) -> list[tuple[Component, Blame]]:
    """Return the components that seem to belong to the singular set after a known mistake, each with this mistake."""
    correct_set = find_singular_set(chain) or ()
    return [
        (component, option.blames[0])
        for option in make_wrong_sets(chain, correct_set)
        for component in option.content
        if component not in correct_set and component.solutions is not None
    ]


def _sample_falsely_singular_configuration(
    chain: Chain, component: Component, rng: Stream
) -> ExactConfiguration | None:
    """Return a regular configuration with the joint values of a component that does not belong to the singular set."""
    assert component.solutions is not None
    for _ in range(MAX_COMPONENT_TRIES):
        min_ratio = _find_clearly_regular_ratio(chain)
        configuration = sample_regular_configuration(chain, rng, min_ratio, prefers_seemingly_singular=False)
        if configuration is None:
            return None
        component_values = {q: rng.choice(solutions) for q, solutions in component.solutions}
        falsely_singular = make_regular_configuration(chain, {**configuration.joints, **component_values})
        if falsely_singular is not None:
            return falsely_singular
    return None


def make_regular_configuration(chain: Chain, joints: JointValues) -> ExactConfiguration | None:
    """Return the configuration with these joint values if it is clearly regular, else None."""
    if any(value.free_symbols or not sp.N(value).is_real for value in joints.values()):
        return None
    configuration = make_exact_configuration(chain, {}, wrap_angles(joints), keeps_formulas=True)
    rank = compute_rank(chain, configuration, _find_clearly_regular_ratio(chain))
    return configuration if rank == compute_full_rank(chain) else None


def _select_distinct(
    candidates: Iterator[ConfigurationAndBlame], count: int, excluded_candidates: Sequence[ConfigurationAndBlame] = ()
) -> list[ConfigurationAndBlame]:
    """Return up to `count` candidates with different texts, none of which is the text of an excluded candidate."""
    texts = {_write_configuration(configuration) for configuration, _ in excluded_candidates}
    distinct_candidates: list[ConfigurationAndBlame] = []
    for configuration, blame in candidates:
        if len(distinct_candidates) == count:
            break
        if _write_configuration(configuration) not in texts:
            texts.add(_write_configuration(configuration))
            distinct_candidates.append((configuration, blame))
    return distinct_candidates


def _offer_configurations(
    singular_candidates: Sequence[ConfigurationAndBlame],
    regular_candidates: Sequence[ConfigurationAndBlame],
    lengths: Lengths,
    rng: Stream,
) -> tuple[ConfigurationOptions, tuple[str, ...], tuple[int, ...]]:
    """Return configurations in random order as options, their texts, and the indices of the singular options."""
    shuffled_candidates = rng.permutation([*singular_candidates, *regular_candidates])
    configurations, blames = zip(*shuffled_candidates, strict=True)
    correct = tuple(index for index, option in enumerate(shuffled_candidates) if option in singular_candidates)
    details = ConfigurationOptions(offered_configurations=configurations, lengths=lengths, blames=blames)
    return details, tuple(map(_write_configuration, configurations)), correct


def _write_configuration(configuration: ExactConfiguration) -> str:
    """Return joint values as plain text, such as "theta1 = 30 deg, d2 = 0.4 m"."""

    def write_value(q: sp.Symbol) -> str:
        value = find_shown_value(configuration, q)
        number = str(value) if value.is_Integer else f"{float(value):.10g}"
        return f"{number} {'deg' if is_joint_angle(q) else 'm'}"

    return ", ".join(f"{q} = {write_value(q)}" for q in configuration.joints)


def _ask_which_are_singular(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer five configurations, of which two or three are singular."""
    for _ in range(MAX_ARM_TRIES):
        arm, lengths = _assign_random_lengths(chain, rng)
        singular_count = rng.choice((2, 3))
        singular_candidates = _select_distinct(_sample_singular_configurations(arm, rng), singular_count)
        regular_count = OPTION_COUNT - len(singular_candidates)
        sampled_configurations = _sample_regular_configurations(arm, rng, singular_candidates)
        regular_candidates = _select_distinct(sampled_configurations, regular_count, singular_candidates)
        if (len(singular_candidates), len(regular_candidates)) == (singular_count, OPTION_COUNT - singular_count):
            details, texts, correct = _offer_configurations(singular_candidates, regular_candidates, lengths, rng)
            return Selection(texts, correct), details
    return None


def _ask_which_drawing(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer drawings of four configurations, of which one is singular."""
    for _ in range(MAX_ARM_TRIES):
        arm, lengths = _assign_random_lengths(chain, rng)
        singular_candidates = _select_distinct(_sample_singular_configurations(arm, rng), 1)
        sampled_configurations = _sample_regular_configurations(arm, rng, singular_candidates)
        regular_candidates = _select_distinct(sampled_configurations, 3, singular_candidates)
        if singular_candidates and len(regular_candidates) == 3:
            details, texts, (correct,) = _offer_configurations(singular_candidates, regular_candidates, lengths, rng)
            return Choice(texts, correct), replace(details, has_drawn_options=True)
    return None


def find_options_to_draw(chain: Chain, part: Part) -> tuple[Chain, list[dict[str, float]]] | None:
    """Return the numeric arm and the configurations to draw if the options of a part are drawings, else None.

    Each configuration maps the names of the joint variables to their values.
    """
    if not part.details.has_drawn_options:
        return None
    details = part.details_as(ConfigurationOptions)
    poses = [configuration.figure_values for configuration in details.offered_configurations]
    return substitute_in_arm(chain, details.lengths), poses


SINGULAR_CONFIGURATIONS = ShortQuestion(
    "singular-configurations", "Which of these are singular?", "6.8", points=1.0, sample=_ask_which_are_singular,
    form="selection", base_question="singular-angles", shown_answers=("singular-angles",),
    objection_if_sampling_fails="it does not have five suitable configurations",
)  # fmt: skip

SINGULAR_DRAWING = ShortQuestion(
    "singular-drawing", "Which drawing shows a singular configuration?", "6.8", sample=_ask_which_drawing,
    form="choice", base_question="singular-angles", shown_answers=("singular-angles",),
    objection_if_sampling_fails="it does not have four suitable configurations",
)  # fmt: skip
