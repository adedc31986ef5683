"""Describe the figure of an arm exactly in words, for readers who cannot see it."""

import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint, Triple
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.figure.lettering import write_sign_and_size
from qdot.exercises.figure.plane import VIEW_DESCRIPTIONS, find_normal_axis, is_drawn_flat, make_numbers_exact
from qdot.exercises.writing.languages import ENGLISH, Catalogue, load_catalogue
from qdot.exercises.writing.translatable_phrases import NUMBER_WORDS

_ENGLISH = load_catalogue(ENGLISH)
JOINT_KIND_NAMES = {"R": "revolute", "P": "prismatic"}


def make_title(chain: Chain, catalogue: Catalogue = _ENGLISH) -> str:
    """Return a title of an arm's figure, such as "Planar arm with joints RRR"."""
    joints = "".join(j.kind for j in chain.joints)
    if is_drawn_flat(chain):
        return catalogue.gettext("Planar arm with joints %(joints)s", joints=joints)
    return catalogue.gettext("Spatial arm with joints %(joints)s", joints=joints)


def make_panels_title(chain: Chain, catalogue: Catalogue) -> str:
    """Return the title of small drawings of one arm, the first of which shows a regular configuration."""
    title = make_title(chain, catalogue)
    return catalogue.gettext("%(arm)s: a regular and the singular configurations", arm=title)


def describe_figure(chain: Chain, is_away_from_home: bool = False) -> str:
    """Return a description of the arm: its joints, the lengths of its links, its base, and the position of P.

    If the arm is presented by its axes, its home configuration is described, even if the figure shows the arm in
    another configuration (`is_away_from_home`).
    """
    exact_chain = make_numbers_exact(chain)
    joint_count = NUMBER_WORDS[chain.n] if chain.n < len(NUMBER_WORDS) else str(chain.n)
    normal_axis = find_normal_axis(exact_chain)
    kind, view = ("planar", f"flat {VIEW_DESCRIPTIONS[normal_axis]}") if normal_axis else ("spatial", "in space")
    arm = f"A {kind} arm with {joint_count} joint{'s' if chain.n > 1 else ''} in series, drawn {view}"
    if convention_of(chain).is_drawn_at_home:
        arm_at_home = f"{arm.replace('_w', '_s')}, {'not ' if is_away_from_home else ''}in its home configuration."
        home = "In the home configuration, with coordinates in the space frame s:"
        sentences = [arm_at_home, home, *_describe_axes(exact_chain)]
    else:
        joints = [_describe_joint(exact_chain, i) for i in range(1, chain.n + 1)]
        sentences = [f"{arm}.", _describe_base(exact_chain), *joints, _describe_point(exact_chain)]
    return " ".join([*sentences, "Lengths are not to scale."])


def describe_panels(
    captions: list[str], legend: str, remark: str, has_lost_direction: bool, catalogue: Catalogue
) -> str:
    """Return a description of the drawings in a `small.PanelSet`, the first of which shows a regular configuration.

    `has_lost_direction` says whether a lost direction is marked.
    """
    singular_captions = "; ".join(captions[1:])
    opening = catalogue.gettext(
        "The arm in a regular configuration and in these singular ones: %(singular)s.", singular=singular_captions
    )
    ring = catalogue.gettext("A dashed ring marks a direction towards the reader.") if has_lost_direction else ""
    scale = catalogue.gettext("Drawn to scale.")
    return " ".join(sentence for sentence in (opening, remark, scale, legend, ring) if sentence)


def _format_in_words(expression: sp.Expr, is_angle: bool = False) -> str:
    """Return a length or an angle in words, such as "minus 30 degrees"."""
    if expression == 0:
        return "0"
    sign, lettering = write_sign_and_size(expression, is_angle)
    words = "".join(text for text, _, _ in lettering).replace("°", " degrees")
    return f"{'minus ' if sign == '−' else ''}{words}"


def _format_triple(values: Triple) -> str:
    return f"({', '.join(_format_in_words(value) for value in values)})"


def _describe_base(chain: Chain) -> str:
    base = convention_of(chain).base
    if base.is_world:
        return "The base frame O0 is the world frame."
    rotations = [f"rotated by {_format_in_words(base.yaw, is_angle=True)} about z_w"] if base.yaw != 0 else []
    if base.tilt != 0:
        mount = {sp.pi: "ceiling", sp.pi / 2: "wall"}.get(abs(base.tilt))
        mounting = f" (mounted on the {mount})" if mount and not is_drawn_flat(chain) else ""
        tilt = _format_in_words(base.tilt, is_angle=True)
        rotations.append(f"{'then ' if rotations else ''}tilted by {tilt} about its own x axis{mounting}")
    is_moved = any(base.position)
    position = f"at {_format_triple(base.position)} in the world frame" if is_moved else "at the world's origin"
    return f"The base frame O0 is {', '.join([position, *rotations])}."


def _describe_joint(chain: Chain, i: int) -> str:
    """Return a description of a joint: its motion, and its row of the table that students see."""
    row, is_proximal = convention_of(chain).rows[i - 1], convention_of(chain).is_proximal
    axis = f"z{convention_of(chain).find_frame_on_axis(i)}"
    clauses = [f"it {_describe_motion(chain, i)} {axis}"]
    if is_proximal:
        clauses = _describe_modified_axis(row, i) + clauses
    lengths = [f"{_format_in_words(row.d)} along {axis}"] if row.is_revolute and row.d != 0 else []
    if row.a != 0 and not is_proximal:
        lengths.append(f"{_format_in_words(row.a)} along x{i}")
    if lengths:
        clauses.append(f"{f'O{i}' if is_proximal else f'link {i}'} is {' and '.join(lengths)}")
    if row.is_prismatic and row.theta != 0:
        clauses.append(_describe_rotation("x", i, row.theta, axis))
    if row.alpha != 0 and not is_proximal:
        clauses.append(_describe_rotation("z", i, row.alpha, f"x{i}"))
    return f"Joint {i} is {JOINT_KIND_NAMES[row.kind]}: {'; '.join(clauses)}."


def _describe_modified_axis(row: Joint, i: int) -> list[str]:
    """Return a clause on the axis of joint i relative to frame i - 1 of a modified table; none if the axes coincide."""
    length = f", {_format_in_words(row.a)} along x{i - 1} from O{i - 1}" if row.a != 0 else ""
    if row.alpha != 0:
        return [f"its axis {_describe_rotation('z', i, row.alpha, f'x{i - 1}')}{length}"]
    return [f"its axis z{i} is parallel to z{i - 1}{length}"] if length else []


def _describe_rotation(axis: str, i: int, angle: sp.Expr, rotation_axis: str) -> str:
    """Return a clause on the angle from an axis of frame i - 1 to the same axis of frame i."""
    if axis == "z" and angle in (sp.pi, -sp.pi):
        return f"z{i} points opposite to z{i - 1}"
    start = f" from z{i - 1}" if axis == "z" else ""
    return f"{axis}{i} is rotated{start} by {_format_in_words(angle, is_angle=True)} about {rotation_axis}"


def _describe_axes(chain: Chain) -> list[str]:
    """Return sentences on the axes and the point at home."""
    axes, point = compute_home_geometry(chain)
    sentences = []
    for i, axis in enumerate(axes, 1):
        point_clause = "" if axis.is_prismatic else f" through {_format_vector(axis.point, ' m')}"
        motion = "rotates about" if axis.is_revolute else "moves along"
        sentences.append(f"Joint {i} {motion} {_format_vector(axis.direction)}{point_clause}.")
    if chain.point.frame != chain.n:
        return [*sentences, f"The point P is at {_format_vector(point, ' m')}."]
    point_text = f"The point P, the origin of the body frame b, is at {_format_vector(point, ' m')}"
    return [*sentences, f"{point_text}. The axes of b are parallel to those of s."]


def _format_vector(vector: sp.Matrix, unit: str = "") -> str:
    return f"({', '.join(_format_sum(value, unit) for value in vector)})"


def _format_sum(value: sp.Expr, unit: str) -> str:
    """Return a coordinate in words, term by term, with numbers to three digits and signs as words.

    All numbers without a symbol form one term.

    >>> _format_sum(sp.Rational(9, 40) + sp.sqrt(3) / 20 - sp.Symbol("d1"), " m")
    '0.312 m minus d1'
    """
    if value == 0:
        return "0"
    words = ""
    constant, symbolic_sum = sp.expand(value).as_independent(sp.Symbol, as_Add=True)
    numeric_terms = [sp.N(constant)] if constant != 0 else []
    symbolic_terms = sp.Add.make_args(symbolic_sum) if symbolic_sum != 0 else ()
    for term in (*numeric_terms, *symbolic_terms):
        factor, symbols = term.as_independent(*term.free_symbols, as_Add=False)
        size = f"{abs(float(factor)):.3g}"
        name = str(symbols) if symbols != 1 else ""
        term_text = f"{size} {name}" if name and size != "1" else name or f"{size}{unit}"
        sign = "minus " if factor < 0 else "plus " if words else ""
        words += f"{' ' if words else ''}{sign}{term_text}"
    return words


def _describe_motion(chain: Chain, i: int) -> str:
    """Return the words on a joint's motion that precede the name of the axis: "rotates by theta1 about"."""
    variable, offset, is_angle = chain.q[i - 1], chain.offsets[i - 1], chain.joints[i - 1].is_revolute
    entry = _format_in_words(variable, is_angle)
    if offset != 0:
        words = _format_in_words(offset, is_angle)
        entry += f" {words}" if words.startswith("minus ") else f" plus {words}"
    return f"rotates by {entry} about" if is_angle else f"moves by {entry} along"


def _describe_point(chain: Chain) -> str:
    point = convention_of(chain).point
    frame = point.frame
    last_frame_clause = ", the last frame" if frame == chain.n else ""
    position = f"O{frame}, the origin of" if point.is_origin else f"at {_format_triple(point.offset)} in"
    return f"The point P is {position} frame {frame}{last_frame_clause}."
