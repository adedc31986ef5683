"""Describe an arm's figure exactly in words, for readers who cannot see it."""

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.figure.plane import SEEN, exact, is_flat, plane
from qdot.exercises.figure.shapes import sign_and_lettering
from qdot.exercises.writing.languages import ENGLISH, Catalogue, catalogue
from qdot.exercises.writing.wording import NUMBER_WORDS

_ENGLISH = catalogue(ENGLISH)
KINDS = {"R": "revolute", "P": "prismatic"}


def title_text(chain: Chain, words: Catalogue = _ENGLISH) -> str:
    """Return a title, as in "Planar arm with joints RRR"."""
    joints = "".join(j.kind for j in chain.joints)
    if is_flat(chain):
        return words.gettext("Planar arm with joints %(joints)s", joints=joints)
    return words.gettext("Spatial arm with joints %(joints)s", joints=joints)


def panels_title(chain: Chain, words: Catalogue) -> str:
    """Return the title of small drawings of one arm, the first of which shows a regular configuration."""
    title = title_text(chain, words)
    return words.gettext("%(arm)s: a regular and the singular configurations", arm=title)


def alt_text(chain: Chain, posed: bool = False) -> str:
    """Return a description of the arm: its joints, the lengths of its links, its base, and the position of P.

    An arm that is described by its axes is described at home, even if it is drawn in another configuration (`posed`).
    """
    chain = exact(chain)
    count = NUMBER_WORDS[chain.n] if chain.n < len(NUMBER_WORDS) else str(chain.n)
    joints = f"{count} joint{'s' if chain.n > 1 else ''}"
    normal_axis = plane(chain)
    view_clause = f"drawn flat {SEEN[normal_axis]}" if normal_axis else "drawn in space"
    arm = f"A {'planar' if normal_axis else 'spatial'} arm with {joints} in series, {view_clause}"
    if convention_of(chain).is_drawn_at_home:
        arm = arm.replace("_w", "_s")
        home = ", not at home. At home, in the space frame s:" if posed else ", at home, in the space frame s."
        return " ".join([f"{arm}{home}", *_axes(chain), "Lengths are not to scale."])
    sentences = [f"{arm}.", _base(chain)]
    sentences += [_joint(chain, i) for i in range(1, chain.n + 1)]
    return " ".join([*sentences, _point(chain), "Lengths are not to scale."])


def panels_text(captions: list[str], key: str, remark: str, words: Catalogue, has_ring: bool) -> str:
    """Return a description of small drawings of one arm, the first of which shows a regular configuration."""
    singular = "; ".join(captions[1:])
    opening = words.gettext(
        "The arm in a regular configuration and in these singular ones: %(singular)s.", singular=singular
    )
    ring = words.gettext("A dashed ring: that way is at the reader.") if has_ring else ""
    scale = words.gettext("Drawn to scale.")
    return " ".join(sentence for sentence in (opening, remark, scale, key, ring) if sentence)


def _plain(expression: sp.Expr, angle: bool) -> str:
    """Return a length or an angle in words, as in "minus 30 degrees"."""
    if expression == 0:
        return "0"
    sign, pieces = sign_and_lettering(expression, angle)
    words = "".join(text for text, _, _ in pieces).replace("°", " degrees")
    return f"{'minus ' if sign == '−' else ''}{words}"


def _triple(values: tuple[sp.Expr, sp.Expr, sp.Expr]) -> str:
    return f"({', '.join(_plain(value, angle=False) for value in values)})"


def _base(chain: Chain) -> str:
    base = convention_of(chain).base
    if base.is_world:
        return "The base frame O0 is the world frame."
    rotations = [f"turned by {_plain(base.yaw, angle=True)} about z_w"] if base.yaw != 0 else []
    if base.tilt != 0:
        mount = {sp.pi: "ceiling", -sp.pi: "ceiling", sp.pi / 2: "wall", -sp.pi / 2: "wall"}.get(base.tilt)
        mounting = f" (mounted on the {mount})" if mount and not is_flat(chain) else ""
        rotations.append(
            f"{'then ' if rotations else ''}tilted by {_plain(base.tilt, angle=True)} about its own x axis{mounting}"
        )
    position = "at the world's origin" if not any(base.position) else f"at {_triple(base.position)} in the world frame"
    return f"The base frame O0 is {position}{', ' if rotations else ''}{', '.join(rotations)}."


def _joint(chain: Chain, i: int) -> str:
    if convention_of(chain).is_proximal:
        return _joint_of_frame(chain, i)
    row, is_revolute = chain.joints[i - 1], chain.joints[i - 1].kind == "R"
    motion = _moves(chain, i)
    lengths = []
    if is_revolute and row.d != 0:
        lengths.append(f"{_plain(row.d, angle=False)} along z{i - 1}")
    if row.a != 0:
        lengths.append(f"{_plain(row.a, angle=False)} along x{i}")
    geometry = f"; link {i} is {' and '.join(lengths)}" if lengths else ""
    if not is_revolute and row.theta != 0:
        geometry += f"; x{i} is turned by {_plain(row.theta, angle=True)} about z{i - 1}"
    return f"Joint {i} is {KINDS[row.kind]}: it {motion} z{i - 1}{geometry}{_twist(chain, i)}."


def _axes(chain: Chain) -> list[str]:
    """Return sentences on the axes and the point at home."""
    axes, point = axes_of(chain)
    sentences = []
    for i, axis in enumerate(axes, 1):
        through = "" if axis.kind == "P" else f" through {_place(axis.point)}"
        sentences.append(
            f"Joint {i} {'turns about' if axis.kind == 'R' else 'slides along'} {_way(axis.direction)}{through}."
        )
    if chain.point.frame != chain.n:
        return [*sentences, f"The point P is at {_place(point)}."]
    parallel = "there, its axes are parallel to those of s"
    return [*sentences, f"The point P, the origin of the body frame b, is at {_place(point)}; {parallel}."]


def _way(direction: sp.Matrix) -> str:
    return f"({', '.join(_sum(value, '') for value in direction)})"


def _place(point: sp.Matrix) -> str:
    return f"({', '.join(_sum(value, ' m') for value in point)})"


def _sum(value: sp.Expr, unit: str) -> str:
    """Return a coordinate in words, term by term, with numbers to three digits and signs as words.

    Numbers without a letter are one term.

    >>> _sum(sp.Rational(9, 40) + sp.sqrt(3) / 20 - sp.Symbol("d1"), " m")
    '0.312 m minus d1'
    """
    if value == 0:
        return "0"
    words = ""
    number, symbols = sp.expand(value).as_independent(sp.Symbol, as_Add=True)
    for term in (*([sp.N(number)] if number != 0 else []), *(sp.Add.make_args(symbols) if symbols != 0 else [])):
        number, symbols = term.as_independent(*term.free_symbols, as_Add=False)
        size = f"{abs(float(number)):.3g}"
        name = str(symbols) if symbols != 1 else ""
        term_text = f"{size} {name}" if name and size != "1" else name or f"{size}{unit}"
        sign = "minus " if number < 0 else "plus " if words else ""
        words += f"{' ' if words else ''}{sign}{term_text}"
    return words


def _moves(chain: Chain, i: int) -> str:
    """Return the words on a joint's motion that precede the name of its axis: "turns by theta1 about"."""
    variable, offset, is_angle = chain.q[i - 1], chain.offsets[i - 1], chain.joints[i - 1].kind == "R"
    entry = _plain(variable, is_angle)
    if offset != 0:
        minus, rest = _plain(offset, is_angle).startswith("minus "), _plain(offset, is_angle).removeprefix("minus ")
        entry += f" {'minus' if minus else 'plus'} {rest}"
    return f"turns by {entry} about" if is_angle else f"slides by {entry} along"


def _joint_of_frame(chain: Chain, i: int) -> str:
    """Return a description of a joint in modified DH, where frame i is on the axis of joint i."""
    row = convention_of(chain).rows[i - 1]
    is_revolute, previous_axis = row.kind == "R", f"z{i - 1}"
    if row.alpha == 0:
        relation = "" if row.a == 0 else f"its axis z{i} is parallel to {previous_axis}"
    elif row.alpha in (sp.pi, -sp.pi):
        relation = f"its axis z{i} points against {previous_axis}"
    else:
        relation = f"its axis z{i} is turned from {previous_axis} by {_plain(row.alpha, angle=True)} about x{i - 1}"
    if row.a != 0:
        relation += f", {_plain(row.a, angle=False)} along x{i - 1} from O{i - 1}"
    geometry = f"; O{i} is {_plain(row.d, angle=False)} along z{i}" if is_revolute and row.d != 0 else ""
    if not is_revolute and row.theta != 0:
        geometry += f"; x{i} is turned by {_plain(row.theta, angle=True)} about z{i}"
    return f"Joint {i} is {KINDS[row.kind]}: {relation}{'; ' if relation else ''}it {_moves(chain, i)} z{i}{geometry}."


def _twist(chain: Chain, i: int) -> str:
    """Return a clause on the twist of link i; empty if it is zero."""
    alpha = chain.joints[i - 1].alpha
    if alpha == 0:
        return ""
    if alpha in (sp.pi, -sp.pi):
        return f"; z{i} points against z{i - 1}"
    return f"; z{i} is turned from z{i - 1} by {_plain(alpha, angle=True)} about x{i}"


def _point(chain: Chain) -> str:
    point = convention_of(chain).point
    frame = point.frame
    last_frame_clause = ", the last frame" if frame == chain.n else ""
    if point.is_origin:
        return f"The point P is O{frame}, the origin of frame {frame}{last_frame_clause}."
    return f"The point P is at {_triple(point.offset)} in frame {frame}{last_frame_clause}."
