"""Mistakes in adding up the links, from the base to the point of interest."""

from collections.abc import Callable, Iterator

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import applied, product
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import Change, Working, carried, turn_x, turn_z
from qdot.exercises.mistakes.base import Mistake, Shape, Slip, of_frames

Links = list[np.ndarray]


def run_start(chain: Chain, link: int) -> int:
    """Return the first joint (from 0) of the run of parallel joints that a link (from 0) turns with."""
    start = min(link, chain.n - 1)
    while start > 0 and sp.sin(chain.joints[start - 1].alpha) == 0:
        start -= 1
    return start


def before_in_run(chain: Chain, link: int) -> list[int]:
    """Return the revolute joints before a link's own, parallel to it."""
    return [i for i in range(run_start(chain, link), min(link, chain.n)) if chain.joints[i].kind == "R"]


def _not_turned(w: Working, frame: int, left_out: list[int], constants: bool = False) -> np.ndarray:
    """Return the rotation of a frame without the angles of some joints, with or without the constants in these."""
    turn = w["base rotation"]
    for i, row in enumerate(w["table"].rows[:frame]):
        rest = row.theta - w.arithmetic.stepped(w.chain.q[i]) if constants else row.theta * 0
        theta = rest if i in left_out else row.theta
        turn = product(turn, product(turn_z(w, theta), turn_x(w, row.alpha)))
    return turn


def _relative_link(w: Working, link: int, constants: bool = False) -> np.ndarray:
    frame = w.chain.point.frame if link == w.n else link
    return applied(_not_turned(w, frame, before_in_run(w.chain, link), constants), w["own links"][link])


def _moving(chain: Chain) -> list[int]:
    """Return the links with a length that leads to the point."""

    def has_length(k: int) -> bool:
        if k == chain.n:
            return not chain.point.is_origin
        joint = chain.joints[k]
        return joint.kind == "P" or (joint.a, joint.d) != (0, 0)

    return [k for k in carried(chain) if has_length(k)]


def _words(chain: Chain, link: int) -> dict[str, object]:
    return {"link": chain.point.frame if link == chain.n else link + 1}


def _one(link: int, change: Callable[[Working, np.ndarray], np.ndarray]) -> Change:
    def changed(w: Working, links: Links) -> Links:
        return [change(w, vector) if k == link else vector for k, vector in enumerate(links)]

    return changed


def _relative(chain: Chain, _: Shape) -> Iterator[Slip]:
    turned = [k for k in _moving(chain) if k < chain.n and chain.joints[k].a != 0 and before_in_run(chain, k)]
    for constants in _ways(chain):
        for k in turned:
            change = _one(k, lambda w, _, k=k, c=constants: _relative_link(w, k, c))  # type: ignore[misc]
            yield Slip({"links": change}, _words(chain, k))


def _ways(chain: Chain) -> tuple[bool, ...]:
    """Return how an angle is lost: with the constant that the table adds to it, or after that was taken in."""
    turning = (o for joint, o in zip(chain.joints, chain.offsets, strict=True) if joint.kind == "R")
    return (False, True) if any(offset != 0 for offset in turning) else (False,)


def _all_relative(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Every frame turned by its own joint only, within each run of parallel joints."""
    for constants in _ways(chain):

        def rotations(w: Working, right: Links, c: bool = constants) -> Links:
            return [_not_turned(w, frame, _inner(w.chain, frame), c) for frame in range(len(right))]

        def links(w: Working, right: Links, c: bool = constants) -> Links:
            return [_relative_link(w, k, c) for k in range(len(right))]

        if sum(bool(before_in_run(chain, k)) for k in range(chain.n)) > 1:
            yield Slip({"links": links}, {"link": "each"})
        if any(before_in_run(chain, k) for k in range(chain.n)):
            yield Slip({"rotations": rotations, "links": links}, {"link": "each"})


def _inner(chain: Chain, frame: int) -> list[int]:
    """Return the joints that are not the last of their run before a frame."""
    slips = []
    for i in range(frame):
        behind = [j for j in range(i + 1, frame) if run_start(chain, j) <= i and chain.joints[j].kind == "R"]
        if behind and chain.joints[i].kind == "R":
            slips.append(i)
    return slips


def _swapped(w: Working, links: Links, which: list[int]) -> Links:
    """Exchange sine and cosine of the absolute angle of links: the coordinates in the plane of their run."""
    out = list(links)
    for k in which:
        start = run_start(w.chain, k)
        outer = w["rotations"][start]
        inside = applied(outer.swapaxes(0, 1), out[k])
        out[k] = applied(outer, inside[[1, 0, 2]])
    return out


def _sine_for_cosine(chain: Chain, _: Shape) -> Iterator[Slip]:
    turning = [k for k in _moving(chain) if k < chain.n and chain.joints[k].kind == "R" and chain.joints[k].a != 0]
    for k in turning:
        yield Slip({"links": lambda w, links, k=k: _swapped(w, links, [k])}, _words(chain, k))  # type: ignore[misc]


def _all_sines(chain: Chain, _: Shape) -> Iterator[Slip]:
    turning = [k for k in _moving(chain) if k < chain.n and chain.joints[k].kind == "R" and chain.joints[k].a != 0]
    if len(turning) > 1:
        yield Slip({"links": lambda w, links: _swapped(w, links, turning)})


def _subtracted(chain: Chain, _: Shape) -> Iterator[Slip]:
    for k in _moving(chain):
        yield Slip({"links": _one(k, lambda _, vector: -vector)}, _words(chain, k))


def _left_out(chain: Chain, _: Shape) -> Iterator[Slip]:
    if len(_moving(chain)) > 1:
        for k in _moving(chain):
            yield Slip({"links": _one(k, lambda _, vector: vector * 0)}, _words(chain, k))


def _not_rotated(chain: Chain, _: Shape) -> Iterator[Slip]:
    for k in _moving(chain):
        if k > 0:
            yield Slip(
                {"links": lambda w, links, k=k: [*links[:k], w["own links"][k], *links[k + 1 :]]},  # type: ignore[misc]
                _words(chain, k),
            )


def _none_rotated(chain: Chain, _: Shape) -> Iterator[Slip]:
    if len([k for k in _moving(chain) if k > 0]) > 1:
        yield Slip({"links": lambda w, links: w["own links"]}, {"link": "each"})


def _along_axes_in_order(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Let the joints of an arm that only slides move along x, y and z of the world frame by their numbers."""

    def changed(w: Working, links: Links) -> Links:
        rows = enumerate(w["table"].rows)
        along = [np.stack([row.d if axis == k else 0 * row.d for axis in range(3)]) for k, row in rows]
        return [*along, links[-1]]

    if 1 < chain.n <= 3 and all(joint.kind == "P" for joint in chain.joints):
        joints = ", ".join(str(k + 1) for k in range(chain.n))
        yield Slip({"links": changed}, {"joint": joints, "axis": ", ".join("xyz"[: chain.n])})


_ALL = (
    Mistake(
        "relative-angle", "Relative angle for absolute",
        "For link {link}, the angle of its own joint seems to stand where its absolute angle is due: the angles of "
        "parallel joints before it turn it, too.", "Example 6.1", _relative,
    ),
    Mistake(
        "all-relative-angles", "Relative angles throughout",
        "Each link seems to be turned by its own joint only: the angles of parallel joints add up from link to link.",
        "Example 6.1", _all_relative,
    ),
    Mistake(
        "sine-for-cosine", "Sine for cosine",
        "In what link {link} adds, sine and cosine seem to be exchanged: the angle is counted from the x axis.",
        "Example 6.1", _sine_for_cosine,
    ),
    Mistake(
        "all-sines-for-cosines", "Sines for cosines throughout",
        "Sines and cosines seem to be exchanged throughout: angles are counted from the x axis.",
        "Example 6.1", _all_sines,
    ),
    Mistake(
        "link-subtracted", "Link with the wrong sign",
        "What link {link} adds seems to have the wrong sign.", "6.1", _subtracted,
    ),
    Mistake(
        "link-left-out", "Link left out",
        "What link {link} adds seems to be left out: the links add up from the base to the point.", "6.1", _left_out,
    ),
    Mistake(
        "link-not-rotated", "Link vector not turned into the base frame",
        "The vector of link {link} seems to be taken as its own frame sees it: it must be turned into the base frame "
        "before it is added.", "6.13", _not_rotated,
    ),
    Mistake(
        "links-not-rotated", "Link vectors not turned into the base frame",
        "The link vectors seem to be taken as their own frames see them: each must be turned into the base frame "
        "before it is added.", "6.13", _none_rotated,
    ),
    Mistake(
        "slides-in-order", "Slides along x, y, z in order",
        "Joints {joint} seem to slide along {axis} in this order: each slides along its own z axis, which the twists "
        "before it turn.", "Example 6.1", _along_axes_in_order, rare=True,
    ),
)  # fmt: skip

OF_FRAMES = frozenset({"link-not-rotated", "links-not-rotated", "slides-in-order"})
"""Those that speak of frames on the links, or of vectors from their origins."""
MISTAKES = of_frames(_ALL, but={one.name for one in _ALL} - OF_FRAMES)
