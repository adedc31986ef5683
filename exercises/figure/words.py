"""Describe an arm's figure exactly in words, for readers who cannot see it."""

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.figure.plane import VIEW_DESCRIPTIONS, find_normal_axis, is_drawn_flat, with_exact_numbers
from qdot.exercises.figure.shapes import sign_and_lettering
from qdot.exercises.writing.languages import ENGLISH, Catalogue, catalogue
from qdot.exercises.writing.translatable_phrases import NUMBER_WORDS

_ENGLISH = catalogue(ENGLISH)
JOINT_KIND_NAMES = {"R": "revolute", "P": "prismatic"}


def make_title(chain: Chain, words: Catalogue = _ENGLISH) -> str:
    """Return a title, as in "Planar arm with joints RRR"."""
    joints = "".join(j.kind for j in chain.joints)
    if is_drawn_flat(chain):
        return words.gettext("Planar arm with joints %(joints)s", joints=joints)
    return words.gettext("Spatial arm with joints %(joints)s", joints=joints)


def make_panels_title(chain: Chain, words: Catalogue) -> str:
    """Return the title of small drawings of one arm, the first of which shows a regular configuration."""
    title = make_title(chain, words)
    return words.gettext("%(arm)s: a regular and the singular configurations", arm=title)


def alt_text(chain: Chain, is_posed: bool = False) -> str:
    """Return a description of the arm: its joints, the lengths of its links, its base, and the position of P.

    An arm that is described by its axes is described at home, even if it is drawn in another configuration
    (`is_posed`).
    """
    chain = with_exact_numbers(chain)
    count = NUMBER_WORDS[chain.n] if chain.n < len(NUMBER_WORDS) else str(chain.n)
    joints = f"{count} joint{'s' if chain.n > 1 else ''}"
    normal_axis = find_normal_axis(chain)
    view_clause = f"drawn flat {VIEW_DESCRIPTIONS[normal_axis]}" if normal_axis else "drawn in space"
    arm = f"A {'planar' if normal_axis else 'spatial'} arm with {joints} in series, {view_clause}"
    if convention_of(chain).is_drawn_at_home:
        arm = arm.replace("_w", "_s")
        home = ", not at home. At home, in the space frame s:" if is_posed else ", at home, in the space frame s."
        return " ".join([f"{arm}{home}", *_describe_axes(chain), "Lengths are not to scale."])
    sentences = [f"{arm}.", _describe_base(chain)]
    sentences += [_describe_joint(chain, i) for i in range(1, chain.n + 1)]
    return " ".join([*sentences, _describe_point(chain), "Lengths are not to scale."])


def describe_panels(captions: list[str], legend: str, remark: str, words: Catalogue, has_lost_direction: bool) -> str:
    """Return a description of small drawings of one arm, the first of which shows a regular configuration."""
    singular = "; ".join(captions[1:])
    opening = words.gettext(
        "The arm in a regular configuration and in these singular ones: %(singular)s.", singular=singular
    )
    ring = words.gettext("A dashed ring: that way is at the reader.") if has_lost_direction else ""
    scale = words.gettext("Drawn to scale.")
    return " ".join(sentence for sentence in (opening, remark, scale, legend, ring) if sentence)


def _format_plain(expression: sp.Expr, is_angle: bool) -> str:
    """Return a length or an angle in words, as in "minus 30 degrees"."""
    if expression == 0:
        return "0"
    sign, pieces = sign_and_lettering(expression, is_angle)
    words = "".join(text for text, _, _ in pieces).replace("°", " degrees")
    return f"{'minus ' if sign == '−' else ''}{words}"


def _format_triple(values: tuple[sp.Expr, sp.Expr, sp.Expr]) -> str:
    return f"({', '.join(_format_plain(value, is_angle=False) for value in values)})"


def _describe_base(chain: Chain) -> str:
    base = convention_of(chain).base
    if base.is_world:
        return "The base frame O0 is the world frame."
    rotations = [f"turned by {_format_plain(base.yaw, is_angle=True)} about z_w"] if base.yaw != 0 else []
    if base.tilt != 0:
        mount = {sp.pi: "ceiling", -sp.pi: "ceiling", sp.pi / 2: "wall", -sp.pi / 2: "wall"}.get(base.tilt)
        mounting = f" (mounted on the {mount})" if mount and not is_drawn_flat(chain) else ""
        tilt = _format_plain(base.tilt, is_angle=True)
        rotations.append(f"{'then ' if rotations else ''}tilted by {tilt} about its own x axis{mounting}")
    position = (
        "at the world's origin" if not any(base.position) else f"at {_format_triple(base.position)} in the world frame"
    )
    return f"The base frame O0 is {position}{', ' if rotations else ''}{', '.join(rotations)}."


def _describe_joint(chain: Chain, i: int) -> str:
    if convention_of(chain).is_proximal:
        return _describe_modified_joint(chain, i)
    row, is_revolute = chain.joints[i - 1], chain.joints[i - 1].kind == "R"
    motion = _describe_motion(chain, i)
    lengths = []
    if is_revolute and row.d != 0:
        lengths.append(f"{_format_plain(row.d, is_angle=False)} along z{i - 1}")
    if row.a != 0:
        lengths.append(f"{_format_plain(row.a, is_angle=False)} along x{i}")
    geometry = f"; link {i} is {' and '.join(lengths)}" if lengths else ""
    if not is_revolute and row.theta != 0:
        geometry += f"; x{i} is turned by {_format_plain(row.theta, is_angle=True)} about z{i - 1}"
    return f"Joint {i} is {JOINT_KIND_NAMES[row.kind]}: it {motion} z{i - 1}{geometry}{_describe_twist(chain, i)}."


def _describe_axes(chain: Chain) -> list[str]:
    """Return sentences on the axes and the point at home."""
    axes, point = axes_of(chain)
    sentences = []
    for i, axis in enumerate(axes, 1):
        through = "" if axis.kind == "P" else f" through {_format_point(axis.point)}"
        motion = "turns about" if axis.kind == "R" else "slides along"
        sentences.append(f"Joint {i} {motion} {_format_direction(axis.direction)}{through}.")
    if chain.point.frame != chain.n:
        return [*sentences, f"The point P is at {_format_point(point)}."]
    parallel = "there, its axes are parallel to those of s"
    return [*sentences, f"The point P, the origin of the body frame b, is at {_format_point(point)}; {parallel}."]


def _format_direction(direction: sp.Matrix) -> str:
    return f"({', '.join(_format_sum(value, '') for value in direction)})"


def _format_point(point: sp.Matrix) -> str:
    return f"({', '.join(_format_sum(value, ' m') for value in point)})"


def _format_sum(value: sp.Expr, unit: str) -> str:
    """Return a coordinate in words, term by term, with numbers to three digits and signs as words.

    Numbers without a letter are one term.

    >>> _format_sum(sp.Rational(9, 40) + sp.sqrt(3) / 20 - sp.Symbol("d1"), " m")
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


def _describe_motion(chain: Chain, i: int) -> str:
    """Return the words on a joint's motion that precede the name of its axis: "turns by theta1 about"."""
    variable, offset, is_angle = chain.q[i - 1], chain.offsets[i - 1], chain.joints[i - 1].kind == "R"
    entry = _format_plain(variable, is_angle)
    if offset != 0:
        minus = _format_plain(offset, is_angle).startswith("minus ")
        rest = _format_plain(offset, is_angle).removeprefix("minus ")
        entry += f" {'minus' if minus else 'plus'} {rest}"
    return f"turns by {entry} about" if is_angle else f"slides by {entry} along"


def _describe_modified_joint(chain: Chain, i: int) -> str:
    """Return a description of a joint in modified DH, where frame i is on the axis of joint i."""
    row = convention_of(chain).rows[i - 1]
    is_revolute, previous_axis = row.kind == "R", f"z{i - 1}"
    if row.alpha == 0:
        relation = "" if row.a == 0 else f"its axis z{i} is parallel to {previous_axis}"
    elif row.alpha in (sp.pi, -sp.pi):
        relation = f"its axis z{i} points against {previous_axis}"
    else:
        relation = (
            f"its axis z{i} is turned from {previous_axis} by {_format_plain(row.alpha, is_angle=True)} about x{i - 1}"
        )
    if row.a != 0:
        relation += f", {_format_plain(row.a, is_angle=False)} along x{i - 1} from O{i - 1}"
    geometry = f"; O{i} is {_format_plain(row.d, is_angle=False)} along z{i}" if is_revolute and row.d != 0 else ""
    if not is_revolute and row.theta != 0:
        geometry += f"; x{i} is turned by {_format_plain(row.theta, is_angle=True)} about z{i}"
    motion = f"it {_describe_motion(chain, i)} z{i}{geometry}"
    return f"Joint {i} is {JOINT_KIND_NAMES[row.kind]}: {relation}{'; ' if relation else ''}{motion}."


def _describe_twist(chain: Chain, i: int) -> str:
    """Return a clause on the twist of link i; empty if it is zero."""
    alpha = chain.joints[i - 1].alpha
    if alpha == 0:
        return ""
    if alpha in (sp.pi, -sp.pi):
        return f"; z{i} points against z{i - 1}"
    return f"; z{i} is turned from z{i - 1} by {_format_plain(alpha, is_angle=True)} about x{i}"


def _describe_point(chain: Chain) -> str:
    point = convention_of(chain).point
    frame = point.frame
    last_frame_clause = ", the last frame" if frame == chain.n else ""
    if point.is_origin:
        return f"The point P is O{frame}, the origin of frame {frame}{last_frame_clause}."
    return f"The point P is at {_format_triple(point.offset)} in frame {frame}{last_frame_clause}."
