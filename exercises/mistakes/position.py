"""Mistakes in the position of the point of interest P, which is the sum of the link vectors from the base to P.

A run is a sequence of consecutive joints with parallel axes. The absolute angle of a link is the sum of the angles of
the revolute joints of its run, from the first joint to the link's own; its relative angle is only the last of these
angles. Links and joints are counted from 0. The last link vector leads from the origin of P's frame to P.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation import graph
from qdot.exercises.derivation.arithmetic import apply_matrix, matrix_product
from qdot.exercises.derivation.graph import Change, StageResults
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator, join_words, vary_if

LinkVectors = list[np.ndarray]
"""The n + 1 link vectors, each (3, …)."""


def find_first_joint_of_run(chain: Chain, link: int) -> int:
    """Return the first joint of the run to which the joint of a link belongs."""
    start = min(link, chain.n - 1)
    while start > 0 and sp.sin(chain.joints[start - 1].alpha) == 0:
        start -= 1
    return start


def list_earlier_joints(chain: Chain, link: int) -> list[int]:
    """Return the revolute joints whose angles the relative angle of a link leaves out.

    These are the joints of its run up to its own joint, except the last.
    """
    last_joint = min(link, chain.n - 1)
    run = range(find_first_joint_of_run(chain, link), last_joint + 1)
    return [i for i in run if chain.joints[i].is_revolute][:-1]


def _compute_rotation_without(
    stages: StageResults, frame: int, omitted_joints: list[int], keeps_offsets: bool = False
) -> np.ndarray:
    """Return the rotation of a frame without the angles of some joints; if `keeps_offsets`, their offsets remain."""
    rotation = stages["base rotation"]
    for i, row in enumerate(stages["table"].rows[:frame]):
        constant = row.theta - stages.arithmetic.convert_entry(stages.chain.q[i]) if keeps_offsets else row.theta * 0
        theta = constant if i in omitted_joints else row.theta
        row_rotation = matrix_product(graph.make_rotation_z(stages, theta), graph.make_rotation_x(stages, row.alpha))
        rotation = matrix_product(rotation, row_rotation)
    return rotation


def _compute_relative_link(stages: StageResults, link: int, keeps_offsets: bool = False) -> np.ndarray:
    """Return the vector of a link without the angles of the earlier joints of its run."""
    frame = stages.chain.point.frame if link == stages.n else link
    return apply_matrix(
        _compute_rotation_without(stages, frame, list_earlier_joints(stages.chain, link), keeps_offsets),
        stages["local link vectors"][link],
    )


def list_nonzero_links(chain: Chain) -> list[int]:
    """Return the links between the base and P with nonzero vectors."""
    is_nonzero = [joint.is_prismatic or (joint.a, joint.d) != (0, 0) for joint in chain.joints]
    is_nonzero.append(not chain.point.is_origin)
    return [link for link in graph.list_links_to_point(chain) if is_nonzero[link]]


def make_link_words(chain: Chain, link: int) -> dict[str, object]:
    """Return the word for the placeholder "link" of a message: the number of a link, counted from 1.

    The vector to P has the number of the frame from whose origin it starts.
    """
    return {"link": chain.point.frame if link == chain.n else link + 1}


def _vary_each_link(
    change: Callable[[StageResults, LinkVectors, int], np.ndarray],
    applies: Callable[[Chain, int], bool] = lambda chain, link: True,
) -> VariantGenerator:
    """Return a function that yields one variant for each link that `applies` accepts, with its vector changed."""

    def generate(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for link in list_nonzero_links(chain):
            if applies(chain, link):
                yield MistakeVariant({"link vectors": _change_link(link, change)}, words=make_link_words(chain, link))

    return generate


def _change_link(link: int, change: Callable[[StageResults, LinkVectors, int], np.ndarray]) -> Change:
    return lambda stages, links: [change(stages, links, k) if k == link else vector for k, vector in enumerate(links)]


def _use_relative_angle(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which one link has its relative angle instead of its absolute angle."""
    for keeps_offsets in _list_offset_choices(chain):
        yield from _vary_each_link(
            lambda stages, _, link, keeps=keeps_offsets: _compute_relative_link(stages, link, keeps),  # type: ignore[misc]
            lambda chain, link: link < chain.n and chain.joints[link].a != 0 and bool(list_earlier_joints(chain, link)),
        )(chain, shape)


def _list_offset_choices(chain: Chain) -> tuple[bool, ...]:
    """Return the values of `keeps_offsets` to try: False, and also True if a revolute joint has an offset."""
    return (False, True) if any(chain.offsets[i] != 0 for i in chain.revolute_joints) else (False,)


def _use_relative_angles(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with relative angles in all link vectors, or in these and in the rotations of all frames."""

    def change_rotations(
        stages: StageResults, correct_rotations: list[np.ndarray], keeps_offsets: bool
    ) -> list[np.ndarray]:
        frames = range(len(correct_rotations))
        return [
            _compute_rotation_without(stages, k, _list_earlier_joints_of_all_runs(stages.chain, k), keeps_offsets)
            for k in frames
        ]

    def change_links(stages: StageResults, correct_links: LinkVectors, keeps_offsets: bool) -> LinkVectors:
        return [_compute_relative_link(stages, link, keeps_offsets) for link in range(len(correct_links))]

    relative_link_count = sum(bool(list_earlier_joints(chain, link)) for link in range(chain.n))
    for keeps_offsets in _list_offset_choices(chain):
        changes: dict[str, Change] = {"link vectors": partial(change_links, keeps_offsets=keeps_offsets)}
        if relative_link_count > 1:
            yield MistakeVariant(changes, words={"link": "each"})
        if relative_link_count:
            changes = {"rotations": partial(change_rotations, keeps_offsets=keeps_offsets), **changes}
            yield MistakeVariant(changes, words={"link": "each"})


def _list_earlier_joints_of_all_runs(chain: Chain, frame: int) -> list[int]:
    """Return all revolute joints before a frame, except the last one of each run."""
    revolute_joints = [i for i in chain.revolute_joints if i < frame]
    return [
        i for i in revolute_joints if any(j > i and find_first_joint_of_run(chain, j) <= i for j in revolute_joints)
    ]


def _swap_coordinates(stages: StageResults, links: LinkVectors, link: int) -> np.ndarray:
    """Return the vector of a link with sine and cosine of the link's absolute angle exchanged.

    This exchanges the x and y coordinates of the vector in the frame before the link's run.
    """
    run_rotation = stages["rotations"][find_first_joint_of_run(stages.chain, link)]
    local_vector = apply_matrix(run_rotation.swapaxes(0, 1), links[link])
    return apply_matrix(run_rotation, local_vector[[1, 0, 2]])


def _has_angle(chain: Chain, link: int) -> bool:
    """Return whether the direction of a link depends on the angle of its joint."""
    return link < chain.n and chain.joints[link].is_revolute and chain.joints[link].a != 0


def _generate_all_swapped(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant with sines and cosines exchanged in all links, if several links rotate."""

    def swap(stages: StageResults, links: LinkVectors) -> LinkVectors:
        return [_swap_coordinates(stages, links, k) if k in rotated_links else vector for k, vector in enumerate(links)]

    rotated_links = [link for link in list_nonzero_links(chain) if _has_angle(chain, link)]
    if len(rotated_links) > 1:
        yield MistakeVariant({"link vectors": swap})


def _slide_along_world_axes(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant in which the joints of a prismatic arm move along the world axes x, y and z, in this order."""

    def apply_change(stages: StageResults, links: LinkVectors) -> LinkVectors:
        rows = enumerate(stages["table"].rows)
        slide_vectors = [np.stack([row.d if axis == k else 0 * row.d for axis in range(3)]) for k, row in rows]
        return [*slide_vectors, links[-1]]

    if 1 < chain.n <= 3 and not chain.revolute_joints:
        joints, axes = join_words([str(k + 1) for k in range(chain.n)]), join_words("xyz"[: chain.n])
        yield MistakeVariant({"link vectors": apply_change}, words={"joint": joints, "axis": axes})


VARIANTS: dict[str, VariantGenerator] = {
    "relative-angle": _use_relative_angle,
    "all-relative-angles": _use_relative_angles,
    "sine-for-cosine": _vary_each_link(_swap_coordinates, _has_angle),
    "all-sines-for-cosines": _generate_all_swapped,
    "link-subtracted": _vary_each_link(lambda stages, links, link: -links[link]),
    "link-left-out": _vary_each_link(
        lambda stages, links, k: links[k] * 0, lambda chain, _: len(list_nonzero_links(chain)) > 1
    ),
    "link-not-rotated": _vary_each_link(
        lambda stages, links, link: stages["local link vectors"][link], lambda chain, link: link > 0
    ),
    "links-not-rotated": vary_if(
        lambda chain: sum(k > 0 for k in list_nonzero_links(chain)) > 1,
        {"link vectors": lambda stages, _: stages["local link vectors"]},
        words={"link": "each"},
    ),
    "prismatic-joints-along-xyz": _slide_along_world_axes,
}
