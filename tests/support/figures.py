"""Find what makes a figure unreadable: overlapping labels, crossing leaders, crossing links."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.figure.arm_figure import draw_with_labels
from qdot.exercises.figure.plane import choose_view
from qdot.exercises.figure.pose import compute_skeletons, list_segments
from qdot.exercises.figure.shapes import Figure, Polyline, Text, Vector2D

Segment = tuple[Vector2D, ...]
MAX_LEADER_SHARE = 0.35
"""The share of a figure's labels that may have a leader."""


def draw_arm(chain: Chain, pose: Mapping[str, float] | None = None) -> Figure:
    figure, _ = draw_with_labels(chain, None if pose is None else tuple(pose.items()))
    return figure


def list_leaders(figure: Figure) -> list[Segment]:
    return [shape.points for shape in figure.shapes if isinstance(shape, Polyline) and shape.style == "leader"]


def segments_cross(first: Segment, second: Segment) -> bool:
    def sides(line: Segment, points: Segment) -> float:
        (x, y), (u, v) = line
        return float(np.prod([(u - x) * (q - y) - (v - y) * (p - x) for p, q in points]))

    return sides(first, second) < 0 and sides(second, first) < 0


def covers_line(text: Text, line: Segment) -> bool:
    """Return whether a label covers a leader other than its own, which starts at its edge."""
    left, top, right, bottom = text.box
    start, end = np.array(line)
    points = start + np.linspace(0, 1, 60)[:, None] * (end - start)
    inside = ((points > (left + 0.5, top + 0.5)) & (points < (right - 0.5, bottom - 0.5))).all(axis=1)
    starts_at_label = left - 0.1 <= start[0] <= right + 0.1 and top - 0.1 <= start[1] <= bottom + 0.1
    return bool(inside.any()) and not starts_at_label


def labels_overlap(first: Text, second: Text) -> bool:
    a, b = first.box, second.box
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def find_faults(figure: Figure) -> list[str]:
    lines, faults = list_leaders(figure), []
    if any(labels_overlap(*pair) for pair in combinations(figure.texts, 2)):
        faults.append("two labels overlap")
    if any(segments_cross(*pair) for pair in combinations(lines, 2)):
        faults.append("two leaders cross")
    if any(covers_line(text, line) for text in figure.texts for line in lines):
        faults.append("a label lies on a leader")
    if len(lines) > MAX_LEADER_SHARE * len(figure.texts):
        faults.append(f"{len(lines)} of {len(figure.texts)} labels have leaders")
    return faults


def count_link_crossings(chain: Chain, arm: Chain, entries: np.ndarray) -> int:
    frames, corners, path = compute_skeletons(arm, entries[None])
    links = list_segments(frames, corners, path, arm.point.frame)[0] @ choose_view(chain)[:2].T
    count = 0
    for i, j in combinations(range(len(links)), 2):
        (a, b), (c, d) = links[i], links[j]
        if j > i + 1 and abs(np.linalg.det(np.column_stack([b - a, c - d]))) > 1e-9:
            fractions = np.linalg.solve(np.column_stack([b - a, c - d]), c - a)
            count += bool(((fractions > 1e-6) & (fractions < 1 - 1e-6)).all())
    return count
