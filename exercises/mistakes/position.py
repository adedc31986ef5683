"""Mistakes in the position of the point of interest, the sum of the link vectors from the base to this point."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, matrix_product
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import Change, StageResults, links_to_point, rotation_x, rotation_z
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator, joints_of_kind, variants_if

LinkVectors = list[np.ndarray]


def first_joint_of_run(chain: Chain, link: int) -> int:
    """Return the first joint of the run of consecutive parallel joints that a link's joint belongs to, from 0."""
    start = min(link, chain.n - 1)
    while start > 0 and sp.sin(chain.joints[start - 1].alpha) == 0:
        start -= 1
    return start


def earlier_joints_in_run(chain: Chain, link: int) -> list[int]:
    """Return the revolute joints that come before a link's own joint in the same run of parallel joints."""
    return [i for i in range(first_joint_of_run(chain, link), min(link, chain.n)) if chain.joints[i].kind == "R"]


def _rotate_without(
    w: StageResults, frame: int, omitted_joints: list[int], keeps_constants: bool = False
) -> np.ndarray:
    """Return the rotation of a frame without the angles of some joints; their offsets remain if `keeps_constants`."""
    rotation = w["base rotation"]
    for i, row in enumerate(w["table"].rows[:frame]):
        constant = row.theta - w.arithmetic.table_entry(w.chain.q[i]) if keeps_constants else row.theta * 0
        theta = constant if i in omitted_joints else row.theta
        rotation = matrix_product(rotation, matrix_product(rotation_z(w, theta), rotation_x(w, row.alpha)))
    return rotation


def _relative_link(w: StageResults, link: int, keeps_constants: bool = False) -> np.ndarray:
    frame = w.chain.point.frame if link == w.n else link
    return apply_matrix(
        _rotate_without(w, frame, earlier_joints_in_run(w.chain, link), keeps_constants), w["own links"][link]
    )


def moving_links(chain: Chain) -> list[int]:
    """Return the links between the base and the point of interest that have a nonzero length."""
    lengths = [joint.kind == "P" or (joint.a, joint.d) != (0, 0) for joint in chain.joints]
    return [k for k in links_to_point(chain) if [*lengths, not chain.point.is_origin][k]]


def link_words(chain: Chain, link: int) -> dict[str, object]:
    """Return the number of a link (from 1) for the message; the vector to P has its frame's number."""
    return {"link": chain.point.frame if link == chain.n else link + 1}


def _change_links(
    change: Callable[[StageResults, LinkVectors, int], np.ndarray],
    applies: Callable[[Chain, int], bool] = lambda chain, link: True,
) -> VariantGenerator:
    """Return a function that yields one variant per link that `applies` accepts, with this link's vector changed."""

    def variants(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for link in moving_links(chain):
            if applies(chain, link):
                yield MistakeVariant({"links": _change_link(link, change)}, link_words(chain, link))

    return variants


def _change_link(link: int, change: Callable[[StageResults, LinkVectors, int], np.ndarray]) -> Change:
    return lambda w, links: [change(w, links, k) if k == link else vector for k, vector in enumerate(links)]


def _use_relative_angle(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    for keeps_constants in _choices_for_constants(chain):
        yield from _change_links(
            lambda w, _, link, keeps=keeps_constants: _relative_link(w, link, keeps),  # type: ignore[misc]
            lambda chain, link: (
                link < chain.n and chain.joints[link].a != 0 and bool(earlier_joints_in_run(chain, link))
            ),
        )(chain, shape)


def _choices_for_constants(chain: Chain) -> tuple[bool, ...]:
    """Return whether to keep the constants: False, and also True if the table adds a constant to an angle."""
    return (False, True) if any(chain.offsets[i] != 0 for i in joints_of_kind(chain, "R")) else (False,)


def _use_relative_angles(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which every frame ignores the earlier joints of its run of parallel joints."""

    def rotations(w: StageResults, correct_rotations: LinkVectors, keeps_constants: bool) -> LinkVectors:
        return [
            _rotate_without(w, frame, _inner_joints(w.chain, frame), keeps_constants)
            for frame in range(len(correct_rotations))
        ]

    def links(w: StageResults, correct_links: LinkVectors, keeps_constants: bool) -> LinkVectors:
        return [_relative_link(w, link, keeps_constants) for link in range(len(correct_links))]

    relative_links = sum(bool(earlier_joints_in_run(chain, link)) for link in range(chain.n))
    for keeps in _choices_for_constants(chain):
        changes: dict[str, Change] = {"links": partial(links, keeps_constants=keeps)}
        if relative_links > 1:
            yield MistakeVariant(changes, {"link": "each"})
        if relative_links:
            yield MistakeVariant({"rotations": partial(rotations, keeps_constants=keeps), **changes}, {"link": "each"})


def _inner_joints(chain: Chain, frame: int) -> list[int]:
    """Return the revolute joints before a frame that are not the last of their run of parallel joints."""
    revolute_joints = [i for i in joints_of_kind(chain, "R") if i < frame]
    return [i for i in revolute_joints if any(j > i and first_joint_of_run(chain, j) <= i for j in revolute_joints)]


def _swap_coordinates(w: StageResults, links: LinkVectors, link: int) -> np.ndarray:
    """Return the vector of a link with sine and cosine of its absolute angle exchanged.

    Its x and y coordinates in the frame before its run of parallel joints are exchanged.
    """
    run_rotation = w["rotations"][first_joint_of_run(w.chain, link)]
    local_vector = apply_matrix(run_rotation.swapaxes(0, 1), links[link])
    return apply_matrix(run_rotation, local_vector[[1, 0, 2]])


def _has_angle(chain: Chain, link: int) -> bool:
    return link < chain.n and chain.joints[link].kind == "R" and chain.joints[link].a != 0


def _swap_all_coordinates(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def swap(w: StageResults, links: LinkVectors) -> LinkVectors:
        return [_swap_coordinates(w, links, k) if k in rotated_links else vector for k, vector in enumerate(links)]

    rotated_links = [link for link in moving_links(chain) if _has_angle(chain, link)]
    if len(rotated_links) > 1:
        yield MistakeVariant({"links": swap})


def _slide_along_axes_in_order(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant in which the joints of a prismatic arm move along x, y and z of the world frame, in order."""

    def apply_change(w: StageResults, links: LinkVectors) -> LinkVectors:
        rows = enumerate(w["table"].rows)
        slide_vectors = [np.stack([row.d if axis == k else 0 * row.d for axis in range(3)]) for k, row in rows]
        return [*slide_vectors, links[-1]]

    if 1 < chain.n <= 3 and all(joint.kind == "P" for joint in chain.joints):
        joints = ", ".join(str(k + 1) for k in range(chain.n))
        yield MistakeVariant({"links": apply_change}, {"joint": joints, "axis": ", ".join("xyz"[: chain.n])})


VARIANTS: dict[str, VariantGenerator] = {
    "relative-angle": _use_relative_angle,
    "all-relative-angles": _use_relative_angles,
    "sine-for-cosine": _change_links(_swap_coordinates, _has_angle),
    "all-sines-for-cosines": _swap_all_coordinates,
    "link-subtracted": _change_links(lambda w, links, link: -links[link]),
    "link-left-out": _change_links(lambda w, links, k: links[k] * 0, lambda chain, _: len(moving_links(chain)) > 1),
    "link-not-rotated": _change_links(lambda w, links, link: w["own links"][link], lambda chain, link: link > 0),
    "links-not-rotated": variants_if(
        lambda chain: sum(k > 0 for k in moving_links(chain)) > 1,
        {"links": lambda w, _: w["own links"]},
        {"link": "each"},
    ),
    "slides-in-order": _slide_along_axes_in_order,
}
