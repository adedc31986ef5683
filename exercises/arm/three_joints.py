"""Whether an arm of three joints brings its point to a place, for many arms and places at once, without a search.

The first joint can't change two numbers of the place: height along its axis and distance from it, or, if it is
prismatic, the two coordinates across it. The second joint moves the point round a circle or along a line, on which both
numbers are linear. What remains is one condition on the third joint, on a circle or a line, too: a polynomial whose
sign says whether it has a root; or, if the second joint can't change one of the numbers, a linear condition, at whose
roots the other number has to be in range.
"""

from dataclasses import dataclass

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross

YES, NO, UNSURE = 1, 0, -1

_ZERO = 1e-9
"""What counts as zero, relative to the arm's size."""
_SURE = 1e-10
"""How far from zero a polynomial has to be, relative to its terms, for its sign to be certain."""
_GRID, _LEAST, _REFINED, _STILL = 48, 4, 25, 1e-9
"""Places on the circle at which a polynomial is evaluated, the lowest of them from which Newton steps start, and the
number of steps: where two minima merge, a step removes only a third of the remaining distance."""


def reaches_places(arms: NumericChain, places: np.ndarray) -> np.ndarray:
    """Tell of each arm whether its point can be at its place (k x 3): YES, NO or UNSURE, in an array (k).

    The arms, as `NumericChain.stack` puts them together, have three joints, which all carry the point.
    """
    arm = _normalize(arms, places)
    with np.errstate(all="ignore"):  # a division by zero makes the answer UNSURE
        sole, looks = _second_joint(arm)
        answer = np.where(sole, _decide_by_sign(arm, looks), _decide_by_roots(arm, looks))
    return np.asarray(np.where(arm.moves_point, answer, UNSURE))


@dataclass(frozen=True)
class _NormalizedArms:
    """Arms (k) with their places, scaled by the sizes of both, seen from a place on the first axis.

    `axes` and `origins` (k x 3 joints x 3) are at home, `required` is the place. The third joint brings the point to
    `middle` + x `along` + y `across`, (x, y) being on the unit circle, or y = 0.
    """

    kinds: tuple[str, ...]
    axes: np.ndarray
    origins: np.ndarray
    target: np.ndarray
    middle: np.ndarray
    along: np.ndarray
    across: np.ndarray

    @property
    def moves_point(self) -> np.ndarray:
        """Whether the third joint moves the point."""
        return np.asarray(_size(self.along) > _ZERO)

    def point(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the point (k x m x 3) with the third joint at x and y (m, or k x m)."""
        return np.asarray(
            self.middle[:, None] + x[..., None] * self.along[:, None] + y[..., None] * self.across[:, None]
        )


def _normalize(arms: NumericChain, places: np.ndarray) -> _NormalizedArms:
    home = arms.frames(np.zeros((len(places), 1, 3)))
    point, home = arms.point_of(home)[:, 0], home[:, 0]
    axes, origins = home[:, :3, :3, 2], home[:, :3, :3, 3]
    first = axes[:, 0]
    start = origins[:, 0] + first * _dot(origins[:, 1] - origins[:, 0], first)[:, None]  # the second origin's foot
    size = _size(np.diff(np.concatenate([origins, point[:, None]], axis=1), axis=1)).sum(axis=1)
    size = np.maximum(size + _size(places - start), 1e-12)[:, None]  # the arm may have no length but a slide
    origins, point = (origins - start[:, None]) / size[:, None], (point - start) / size
    if arms.kinds[2] == "P":
        middle, along, across = point, axes[:, 2], np.zeros_like(point)
    else:
        out = point - origins[:, 2]
        along = out - axes[:, 2] * _dot(out, axes[:, 2])[:, None]
        middle, across = point - along, cross(axes[:, 2], along)
    return _NormalizedArms(arms.kinds, axes, origins, (places - start) / size, middle, along, across)


@dataclass(frozen=True)
class _Residual:
    """The residual `zero` for the third joint at x and y, and how far the other number is in range: `room`.

    If a polynomial is the only condition (`sole`), it is `zero`, and there is always `room`.
    """

    arm: _NormalizedArms
    sole: np.ndarray
    matrix: np.ndarray

    def __call__(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return both, k x m."""
        point = self.arm.point(x, y)
        return self._for_revolute(point) if self.arm.kinds[1] == "R" else self._for_prismatic(point)

    def _for_revolute(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Evaluate for a revolute second joint: the part across its axis has a length and two required components."""
        arm = self.arm
        out = point - arm.origins[:, None, 1]
        axis = arm.axes[:, None, 1]
        height = _dot(out, axis)
        squared = _dot(out, out)
        required = _required_components(arm, height, squared)
        u, sigma, _ = np.linalg.svd(self.matrix)
        components = np.einsum("kji,kmj->kmi", u, required)
        across = squared - height**2
        both = np.sum((components / sigma[:, None]) ** 2, axis=2) - across
        room = across - (components[..., 0] / sigma[:, None, 0]) ** 2
        return self._select(both, components[..., 1], room)

    def _for_prismatic(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Evaluate for a prismatic second joint."""
        arm = self.arm
        first, slide = arm.axes[:, None, 0], arm.axes[:, None, 1]
        if arm.kinds[0] == "P":
            off = _dot(cross(first, slide), point - arm.target[:, None])
            return off, np.ones_like(off)
        height, distance = _dot(arm.target, arm.axes[:, 0])[:, None], _dot(arm.target, arm.target)[:, None]
        missing = height - _dot(point, first)
        there = point + (missing / self.matrix[:, :1, 0])[..., None] * slide
        both = _dot(there, there) - distance
        room = _dot(point, slide) ** 2 - _dot(point, point) + distance
        return self._select(both, missing, room)

    def _select(self, both: np.ndarray, zero: np.ndarray, room: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        sole = self.sole[:, None]
        return np.where(sole, both, zero), np.where(sole, 1.0, room)


def _second_joint(arm: _NormalizedArms) -> tuple[np.ndarray, _Residual]:
    """Return for which arms one polynomial is the only condition, and the residual."""
    first, second = arm.axes[:, 0], arm.axes[:, 1]
    if arm.kinds[1] == "P":
        along = _dot(first, second)
        sole = (np.abs(along) > _ZERO) & (arm.kinds[0] == "R")
        return sole, _Residual(arm, sole, along[:, None, None])
    basis = np.stack(_perpendiculars(second), axis=1)
    if arm.kinds[0] == "R":
        directions = np.stack([first, 2 * arm.origins[:, 1]], axis=1)
    else:
        directions = np.stack(_perpendiculars(first), axis=1)
    matrix = directions @ basis.swapaxes(1, 2)
    sigma = np.linalg.svd(matrix, compute_uv=False)
    sole = sigma[:, 1] > _ZERO
    return sole, _Residual(arm, sole, matrix)


def _required_components(arm: _NormalizedArms, height: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """Return the components (k x m x 2) that the second joint has to give to a point of some height and distance."""
    first, second, origin = arm.axes[:, 0], arm.axes[:, 1], arm.origins[:, 1]
    if arm.kinds[0] == "R":
        height_change = _dot(arm.target, first) - _dot(origin, first)
        distance = _dot(arm.target, arm.target) - _dot(origin, origin)
        return np.stack(
            [
                height_change[:, None] - _dot(first, second)[:, None] * height,
                distance[:, None] - squared - 2 * _dot(origin, second)[:, None] * height,
            ],
            axis=2,
        )
    ways = _perpendiculars(first)
    required = (_dot(way, arm.target - origin)[:, None] - _dot(way, second)[:, None] * height for way in ways)
    return np.stack(list(required), axis=2)


# --- a polynomial by itself ---


def _decide_by_sign(arm: _NormalizedArms, looks: _Residual) -> np.ndarray:
    """Decide whether the polynomial has a root, by the signs that it takes."""
    return (
        _sign_on_circle(looks) if arm.kinds[2] == "R" else _sign_on_line(looks, 4 if arm.kinds[:2] == ("R", "R") else 2)
    )


def _sign_on_circle(looks: _Residual) -> np.ndarray:
    """Look for both signs of a0 + a1 cos + b1 sin + a2 cos 2 + b2 sin 2."""
    eighth = np.arange(8) * np.pi / 4
    values = looks(np.cos(eighth), np.sin(eighth))[0]
    waves = np.fft.rfft(values, axis=1)[:, :3] / 4
    a, b = waves.real, -waves.imag
    a[:, 0] /= 2
    terms = np.abs(a).sum(axis=1) + np.abs(b[:, 1:]).sum(axis=1)
    grid = np.linspace(0, 2 * np.pi, _GRID, endpoint=False)
    values, sure = _wave_sum(a, b, np.broadcast_to(grid, (len(a), _GRID)), 0), _SURE * terms
    above, below = values.max(axis=1) > sure, values.min(axis=1) < -sure
    answer = np.where(above & below, YES, UNSURE)
    for side, one_sided in ((1, above & ~below), (-1, below & ~above)):
        rows = np.flatnonzero(one_sided)
        if len(rows):
            starts = grid[np.argsort(side * values[rows], axis=1, kind="stable")[:, :_LEAST]]
            least = _least(side * a[rows], side * b[rows], starts)
            answer[rows] = np.where(least < -sure[rows], YES, np.where(least > sure[rows], NO, UNSURE))
    return answer


def _wave_sum(a: np.ndarray, b: np.ndarray, angle: np.ndarray, power: int) -> np.ndarray:
    """Return the sum of waves, or its derivative of order `power`, at angles (k x m)."""
    times = np.arange(3)
    waves = angle[..., None] * times + power * np.pi / 2
    size = times**power if power else np.ones(3)
    return np.asarray(
        np.einsum("kmi,ki->km", np.cos(waves), a * size) + np.einsum("kmi,ki->km", np.sin(waves), b * size)
    )


def _least(a: np.ndarray, b: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the minimum (k) of such a sum, by Newton steps from angles (k x m) to where its slope is zero."""
    for _ in range(_REFINED):
        bend = _wave_sum(a, b, angle, 2)
        step = np.where(bend > 0, _wave_sum(a, b, angle, 1) / np.where(bend > 0, bend, 1.0), 0.0)
        angle = angle - np.clip(step, -2 * np.pi / _GRID, 2 * np.pi / _GRID)
        if np.abs(step).max() < _STILL:
            break
    return np.asarray(_wave_sum(a, b, angle, 0).min(axis=1))


def _sign_on_line(looks: _Residual, degree: int) -> np.ndarray:
    """Look for both signs of a polynomial of degree four, which rises on both sides, or two."""
    powers = _polynomial_coefficients(looks, 0, degree)
    terms = np.abs(powers).sum(axis=1)
    if degree == 4:
        rises = powers[:, 4] > _ZERO
        companion = np.zeros((len(powers), 3, 3))
        companion[:, 1, 0] = companion[:, 2, 1] = 1.0
        slope = powers[:, 1:] * np.arange(1, 5)
        companion[:, :, 2] = -slope[:, :3] / np.where(rises, slope[:, 3], 1.0)[:, None]
        extreme = np.linalg.eigvals(companion).real
        values = np.sum(powers[:, None] * extreme[..., None] ** np.arange(5), axis=2)
        scale = np.sum(np.abs(powers[:, None]) * np.abs(extreme[..., None]) ** np.arange(5), axis=2)
        least = np.argmin(values, axis=1)
        rows = np.arange(len(powers))
        value, sure = values[rows, least], _SURE * scale[rows, least]
        return np.where(rises, np.where(value < -sure, YES, np.where(value > sure, NO, UNSURE)), UNSURE)
    low, slope, high = powers.T
    bent = np.abs(high) > _ZERO * terms
    inside = slope**2 - 4 * high * low
    sure = _SURE * (slope**2 + np.abs(4 * high * low))
    by_bend = np.where(inside > sure, YES, np.where(inside < -sure, NO, UNSURE))
    return np.where(bent, by_bend, np.where(np.abs(slope) > _SURE * terms, YES, UNSURE))


def _polynomial_coefficients(looks: _Residual, which: int, degree: int) -> np.ndarray:
    """Return the coefficients (k x degree + 1), lowest first, of a residual along the line."""
    x = np.linspace(-1, 1, degree + 1)
    return np.asarray(looks(x, np.zeros_like(x))[which] @ np.linalg.inv(np.vander(x, increasing=True)).T)


# --- a linear condition, and what has to be in range ---


def _decide_by_roots(arm: _NormalizedArms, looks: _Residual) -> np.ndarray:
    """Decide whether the other number is in range at a root of the linear condition."""
    x, y, real = _roots_on_circle(looks) if arm.kinds[2] == "R" else _roots_on_line(looks)
    room = looks(x, y)[1]
    is_there, is_out = real[:, None] == YES, real == NO
    fits, fails = np.any(is_there & (room > _SURE), axis=1), np.all(is_there & (room < -_SURE), axis=1)
    return np.where(is_out | fails, NO, np.where(fits, YES, UNSURE))


def _roots_on_circle(looks: _Residual) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the two roots (k x 2) of a condition that is linear in x and y, and whether there are any (k)."""
    quarter = np.arange(3) * np.pi / 2
    ahead, aside, behind = looks(np.cos(quarter), np.sin(quarter))[0].T
    constant, slope = (ahead + behind) / 2, (ahead - behind) / 2
    cross_slope = aside - constant
    size = np.hypot(slope, cross_slope)
    share = constant / np.where(size > _ZERO, size, 1.0)
    angle = np.arctan2(cross_slope, slope)[:, None] + np.arccos(np.clip(-share, -1, 1))[:, None] * np.array([1, -1])
    real = np.where(np.abs(share) < 1 - _SURE, YES, np.where(np.abs(share) > 1 + _SURE, NO, UNSURE))
    still = np.where(np.abs(constant) > _SURE, NO, UNSURE)
    return np.cos(angle), np.sin(angle), np.where(size > _ZERO, real, still)


def _roots_on_line(looks: _Residual) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the same of a condition along a line, of degree two at most."""
    low, slope, high = _polynomial_coefficients(looks, 0, 2).T
    bent = np.abs(high) > _ZERO
    inside = slope**2 - 4 * high * low
    root = np.sqrt(np.maximum(inside, 0.0))[:, None] * np.array([1, -1])
    straight = -low / np.where(np.abs(slope) > _ZERO, slope, 1.0)
    x = np.where(bent[:, None], (root - slope[:, None]) / np.where(bent, 2 * high, 1.0)[:, None], straight[:, None])
    sure = _SURE * (slope**2 + np.abs(4 * high * low))
    by_bend = np.where(inside > sure, YES, np.where(inside < -sure, NO, UNSURE))
    by_slope = np.where(np.abs(slope) > _ZERO, YES, np.where(np.abs(low) > _SURE, NO, UNSURE))
    return x, np.zeros_like(x), np.where(bent, by_bend, by_slope)


def _perpendiculars(axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors (k x 3 each) perpendicular to each axis and to each other."""
    helper = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    first = cross(axes, helper)
    first /= _size(first)[:, None]
    return first, cross(axes, first)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.sum(a * b, axis=-1))


def _size(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
