"""Configurations to choose from: an arm with numeric lengths, and its singular and regular configurations."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import substitute_arm_lengths
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import geometry
from qdot.exercises.questions.geometry import ExactConfiguration
from qdot.exercises.questions.inversion import Lengths, sample_joint_values
from qdot.exercises.short_questions.options import Blame, ConfigurationOptions, exact_or_rounded_value
from qdot.exercises.short_questions.wrong_sets import make_wrong_sets
from qdot.exercises.singularities.singularity import Component, singular_set

CLEARLY_REGULAR_RATIO = 0.12
"""Ratio of the smallest to the largest singular value at which a configuration is visibly regular."""
MAX_TRIES = 40
_SAMPLE_COUNT = 200

ConfigurationAndBlame = tuple[ExactConfiguration, Blame | None]
"""A configuration, and the mistake (if any) that makes it seem singular."""


def assign_random_lengths(chain: Chain, rng: Stream) -> tuple[Chain, Lengths]:
    """Return the arm with a random number for each symbolic length of its table, and these numbers."""
    lengths = geometry.sample_unequal_lengths(chain, rng)
    return substitute_arm_lengths(chain, lengths), lengths


@lru_cache(maxsize=256)
def find_clearly_regular_ratio(chain: Chain) -> float:
    """Return the ratio of smallest to largest singular value at which a configuration of this arm is clearly regular.

    Some arms, such as a SCARA with short links, hardly ever reach `CLEARLY_REGULAR_RATIO`. For these it is the median
    of the ratio.
    """
    rng, arm = Stream("clearness"), NumericChain(chain, {})
    q = np.array([[float(value) for value in sample_joint_values(chain, rng).values()] for _ in range(_SAMPLE_COUNT)])
    sigma = np.linalg.svd(arm.jacobian(q)[:, chain.task_rows], compute_uv=False)
    return min(CLEARLY_REGULAR_RATIO, round(float(np.median(sigma[:, -1] / np.maximum(sigma[:, 0], 1e-12))), 3))


def iterate_singular_configurations(chain: Chain, rng: Stream) -> Iterator[ConfigurationAndBlame]:
    """Yield singular configurations of an arm, from all components of its singular set in turn."""
    components = singular_set(chain) or ()
    for _ in range(MAX_TRIES):
        for component in rng.permutation(components):
            configuration = geometry.sample_displayable_configuration(chain, (component,), rng)
            if configuration is not None:
                yield configuration, None


def iterate_regular_configurations(chain: Chain, rng: Stream) -> Iterator[ConfigurationAndBlame]:
    """Yield regular configurations: first those that a known mistake makes seem singular, then random ones."""
    for component, blame in rng.permutation(_find_falsely_singular_components(chain)):
        configuration = _sample_regular_configuration_on(chain, component, rng)
        if configuration is not None:
            yield configuration, blame
    for _ in range(MAX_TRIES):
        configuration = geometry.sample_regular_configuration(chain, rng, find_clearly_regular_ratio(chain))
        if configuration is not None:
            yield configuration, None


def _find_falsely_singular_components(chain: Chain) -> list[tuple[Component, Blame]]:
    correct_set = singular_set(chain) or ()
    return [
        (component, option.behind[0])
        for option in make_wrong_sets(chain, correct_set)
        for component in option.shown
        if component not in correct_set and component.solutions is not None
    ]


def _sample_regular_configuration_on(chain: Chain, component: Component, rng: Stream) -> ExactConfiguration | None:
    """Return a regular configuration with the joint values of a component that is wrongly called singular."""
    assert component.solutions is not None
    for _ in range(6):
        configuration = geometry.sample_regular_configuration(chain, rng, find_clearly_regular_ratio(chain), False)
        if configuration is None:
            return None
        values = {q: rng.choice(values) for q, values in component.solutions}
        if (regular := make_regular_configuration(chain, {**configuration.joints, **values})) is not None:
            return regular
    return None


def make_regular_configuration(chain: Chain, joints: dict[sp.Symbol, sp.Expr]) -> ExactConfiguration | None:
    """Return the configuration with these joint values if it is clearly regular, else None."""
    if any(value.free_symbols or not sp.N(value).is_real for value in joints.values()):
        return None
    configuration = geometry.make_exact_configuration(chain, {}, geometry.wrap_angles(chain, joints))
    rank = geometry.compute_rank(chain, configuration, find_clearly_regular_ratio(chain))
    return configuration if rank == geometry.compute_full_rank(chain) else None


def take_distinct(
    candidates: Iterator[ConfigurationAndBlame], count: int, excluded: Sequence[ConfigurationAndBlame] = ()
) -> list[ConfigurationAndBlame]:
    """Return up to `count` candidates whose texts differ from each other and from those of the excluded ones."""
    texts = {write_configuration(configuration) for configuration, _ in excluded}
    distinct: list[ConfigurationAndBlame] = []
    for configuration, blame in candidates:
        if len(distinct) == count:
            break
        if write_configuration(configuration) not in texts:
            texts.add(write_configuration(configuration))
            distinct.append((configuration, blame))
    return distinct


def offer_configurations(
    singular: Sequence[ConfigurationAndBlame], regular: Sequence[ConfigurationAndBlame], lengths: Lengths, rng: Stream
) -> tuple[ConfigurationOptions, tuple[str, ...], tuple[int, ...]]:
    """Return configurations in random order as options, their texts, and the indices of the singular ones."""
    shuffled = rng.permutation([*singular, *regular])
    configurations, blames = (tuple(column) for column in zip(*shuffled, strict=True))
    correct = tuple(index for index, option in enumerate(shuffled) if option in singular)
    details = ConfigurationOptions(places=configurations, lengths=lengths, blames=blames)
    return details, tuple(map(write_configuration, configurations)), correct


def write_configuration(configuration: ExactConfiguration) -> str:
    """Return joint values as plain text, such as "theta1 = 30 deg, d2 = 0.4 m"."""
    return ", ".join(f"{q} = {_write_joint_value(configuration, q)}" for q in configuration.joints)


def _write_joint_value(configuration: ExactConfiguration, q: sp.Symbol) -> str:
    value, is_revolute = exact_or_rounded_value(configuration, q), q.name.startswith("theta")
    number = str(value) if value.is_Integer else f"{float(value):.10g}"
    return f"{number} {'deg' if is_revolute else 'm'}"


def find_options_to_draw(chain: Chain, part: Part) -> tuple[Chain, list[dict[str, float]]] | None:
    """Return the numeric arm and the configurations to draw if the options of a part are drawings, else None."""
    if not part.has_drawn_options:
        return None
    details = part.details_as(ConfigurationOptions)
    poses = [configuration.figure_values for configuration in details.places]
    return substitute_arm_lengths(chain, details.lengths), poses
