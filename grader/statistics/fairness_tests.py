"""Test whether students with some arms did better than students with other arms by more than chance.

Each student gets a different arm of about the same difficulty. The arms are grouped by visible features: the kinds of
joints, offsets, senses of the axes, and so on. A permutation test computes how often random groups of students differ
as much. The p-values are corrected by Holm's method, because there are many such tests.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.errors import count_noun
from qdot.exercises.singularities.difficulty import rate_difficulty_level
from qdot.grader.statistics.class_statistics import compute_permutation_p_value, correct_by_holm

MIN_GROUP_SIZE = 3
"""Minimum number of students in a group; smaller groups are merged into `OTHERS_GROUP`."""
OTHERS_GROUP = "others"
SIGNIFICANCE_LEVEL = 0.05
"""A corrected p-value below this is reported as "probably not chance"."""


@dataclass(frozen=True)
class Comparison:
    """For each group of arms with the same `feature`, the shares of a problem's points (in %) that its students earned.

    `p_value` is the p-value of the permutation test, and `corrected_p_value` the p-value after Holm's correction for
    all comparisons of the class.
    """

    slot: str
    feature: str
    shares_by_group: Mapping[str, tuple[float, ...]]
    p_value: float
    corrected_p_value: float = 1.0

    @property
    def verdict(self) -> str:
        """The meaning of the corrected p-value, in words."""
        return describe_p_value(self.corrected_p_value)


def _describe_twists(chain: Chain) -> str:
    """Return how many twist angles (alpha) of the DH table are negative or 180°."""
    twists = [row.alpha for row in convention_of(chain).rows if row.alpha.is_number]
    count = sum(bool(twist < 0) or twist == sp.pi for twist in twists)
    return f"{count_noun(count, 'twist')} negative or 180°"


def _describe_base(chain: Chain) -> str:
    """Return in words how the base frame differs from the world frame."""
    base = convention_of(chain).base
    if base.is_world:
        return "base frame = world frame"
    if base.tilt != 0:
        return "base tilted"
    return "base rotated" if base.yaw != 0 else "base translated"


def _describe_point(chain: Chain) -> str:
    """Return in words whether the point P is the origin of the last frame."""
    return f"P {'at' if convention_of(chain).point.is_origin else 'not at'} the origin of the last frame"


def _describe_axis_directions(chain: Chain) -> str:
    """Return how many axes are oblique when the arm is at home."""
    axes = compute_home_geometry(chain).axes
    oblique_count = sum(sum(entry != 0 for entry in axis.direction) > 1 for axis in axes)
    return f"{oblique_count} of {chain.n} axes at home not parallel to a coordinate axis"


def _describe_axis_senses(chain: Chain) -> str:
    """Return how many axes have a direction with a negative component when the arm is at home."""
    axes = compute_home_geometry(chain).axes
    count = sum(any(bool(entry < 0) for entry in axis.direction if entry.is_number) for axis in axes)
    return f"{count} of {chain.n} axes at home with a negative component"


Features = Mapping[str, Callable[[Chain], str]]
"""Maps the name of a feature to a function that describes the feature of an arm."""
FEATURES: Features = {
    "kinds of joints": lambda chain: "".join(joint.kind for joint in chain.joints),
    "lengths": lambda chain: count_noun(len(chain.parameters), "symbolic length"),
}
"""Features in which the arms of any family may differ."""
TABLE_FEATURES: Features = {
    "joint offsets": lambda chain: f"{sum(offset != 0 for offset in chain.offsets)} of {chain.n} joints have an offset",
    "senses of the axes": _describe_twists,
    "base": _describe_base,
    "point of interest": _describe_point,
}
"""Features in which arms described by a DH table may differ, in the frames of that table."""
SCREW_FEATURES: Features = {
    "directions of the axes": _describe_axis_directions,
    "senses of the axes": _describe_axis_senses,
}
"""Features in which arms described by their axes, which have no frames, may differ."""
STRUCTURE_FEATURES: Features = {"difficulty": lambda chain: f"difficulty {rate_difficulty_level(chain)}"}
"""Features in which arms differ only if their family samples the structure, too; they take time to compute."""


def compare_groups(
    slot: str, chains: Sequence[Chain], shares: Sequence[float], seed: str, *, has_varied_structure: bool
) -> list[Comparison]:
    """Return a comparison for every feature in which the arms of a slot of the assignment differ.

    `chains` are the students' arms, and `shares` the percentages of the points that the students earned. If
    `has_varied_structure`, the family also samples the structure: the kinds and the order of joints and links.
    """
    comparisons = []
    features = {**FEATURES, **(STRUCTURE_FEATURES if has_varied_structure else {})}
    table_count = sum(convention_of(chain).shows_table for chain in chains)
    if table_count in (0, len(chains)):
        features |= TABLE_FEATURES if table_count else SCREW_FEATURES
    for feature, describe in features.items():
        descriptions = [describe(chain) for chain in chains]
        group_sizes = Counter(descriptions)
        groups = [OTHERS_GROUP if group_sizes[text] < MIN_GROUP_SIZE else text for text in descriptions]
        distinct_groups = sorted(set(groups), key=lambda group: (group == OTHERS_GROUP, group))
        has_small_group = 0 < groups.count(OTHERS_GROUP) < MIN_GROUP_SIZE
        if has_small_group or len(distinct_groups) < 2 or len(set(shares)) < 2:
            continue
        p_value = compute_permutation_p_value(shares, groups, f"{seed}/{slot}/{feature}")
        shares_by_group = {
            group: tuple(share for share, group_of_share in zip(shares, groups, strict=True) if group_of_share == group)
            for group in distinct_groups
        }
        comparisons.append(Comparison(slot, feature, shares_by_group, p_value))
    return comparisons


def correct_p_values(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """Return the comparisons with their corrected p-values, the smallest p-values first."""
    p_values = correct_by_holm([comparison.p_value for comparison in comparisons])
    pairs = zip(comparisons, p_values, strict=True)
    corrected_comparisons = [replace(comparison, corrected_p_value=p_value) for comparison, p_value in pairs]
    return sorted(corrected_comparisons, key=lambda c: (c.corrected_p_value, c.p_value, c.slot, c.feature))


def describe_p_value(p_value: float) -> str:
    """Return the meaning of a p-value in plain words.

    >>> describe_p_value(0.34), describe_p_value(0.0002)
    ('could be chance: p = 0.34', 'probably not chance: p < 0.001')
    """
    decimals = 3 if p_value < 0.1 else 2
    p = "p < 0.001" if p_value < 0.001 else f"p = {p_value:.{decimals}f}"
    return f"{'probably not' if p_value < SIGNIFICANCE_LEVEL else 'could be'} chance: {p}"
