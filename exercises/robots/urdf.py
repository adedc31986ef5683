"""Read a robot from a URDF, the robot format of ROS: the axes of the joints from a base link to a tip link.

Only the properties of a serial chain are read: joints with their type, parent, child, origin, axis, limits and mimic.
All axes are given at home, where all joint variables are zero. A joint that copies the motion of another joint (mimic)
becomes an independent joint. If both joints are in the chain, this is an error. The elements `joint` and `link` are
specified at http://wiki.ros.org/urdf/XML.

Files made by CAD programs and by calibration contain rounding errors. Therefore angles near a multiple of pi/12 and
offsets near zero are snapped: replaced by that multiple, and by zero.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import sympy as sp

from qdot.exercises.arm.axes_to_dh import IDENTITY_POSE, Axis, Pose, make_pose
from qdot.exercises.common.errors import QdotError, make_name_error, write_first
from qdot.exercises.common.input_file import read_text

JOINT_KINDS = {"revolute": "R", "continuous": "R", "prismatic": "P"}
"""Maps each joint type that qdot supports, apart from "fixed", to the kind of the joint."""
ANGLE_TOLERANCE = sp.Rational(1, 1000)
"""Tolerance (rad) within which an angle counts as a multiple of pi/12: 1.57, 1.5708 and 3.1416 are common."""
MAX_OFFSET_TOLERANCE, RELATIVE_OFFSET_TOLERANCE = sp.Rational(1, 1000), sp.Rational(1, 1000)
"""Maximum size of an offset that counts as zero: in m, and as a fraction of the length of the chain."""
_SILENT_TOLERANCE = sp.Rational(1, 10**6)
"""Numbers that change by less than this (rad or m) are snapped without a note."""
_TOOL_FRAME_PATTERN = re.compile(r"(.*[_/-])?(tool0?|tcp|ee_link)")
"""Matches the usual names of tool frames, such as tool0 in ROS-Industrial, with or without a prefix."""
_MAX_LISTED_LINKS = 8


@dataclass(frozen=True)
class UrdfChain:
    """The serial chain in a URDF, at home and in the frame of the base link.

    - `tip`: the position of the origin of the last link (3 x 1, m).
    - `limits`: the limits of each joint (rad or m); None for a joint without limits.
    - `offset_tolerance`: the maximum size of an offset that counts as zero (m).
    - `notes`: messages about the frame, about mimic joints, and about angles and offsets that were snapped.
    """

    name: str
    axes: tuple[Axis, ...]
    tip: sp.Matrix
    limits: tuple[tuple[sp.Expr, sp.Expr] | None, ...]
    offset_tolerance: sp.Expr
    notes: tuple[str, ...]


def read_urdf(path: Path, tip: str = "", base: str = "") -> UrdfChain:
    """Return the chain from the link `base`, by default the root, to the link `tip`, by default the only end.

    Raises QdotError.
    """
    reader = _UrdfReader(path)
    chain_joints = reader.find_joints(tip, base)
    reader.set_offset_tolerance(chain_joints)
    reader.check_mimic_joints(chain_joints)
    pose, axes, limits = IDENTITY_POSE, list[Axis](), list[tuple[sp.Expr, sp.Expr] | None]()
    for joint in chain_joints:
        pose = pose @ reader.read_origin(joint)
        kind = reader.read_kind(joint)
        if kind:
            axes.append(Axis(kind, pose.rotation * reader.read_direction(joint), pose.origin))
            limits.append(reader.read_limits(joint))
    if not axes:
        proposal = reader.propose_tip(base)
        hint = f"; choose another --tip, as in --tip {proposal}" if proposal else ""
        raise QdotError(f"{path}: no joint moves link {reader.read_link(chain_joints[-1], 'child')!r}{hint}")
    notes = reader.make_notes()
    if base:
        notes = (f"{path}: the world frame is the frame of link {base!r}", *notes)
    return UrdfChain(reader.title, tuple(axes), pose.origin, tuple(limits), reader.offset_tolerance, notes)


class _UrdfReader:
    """The reader of one file; its error messages name the file, and the joint or link."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.offset_tolerance: sp.Expr = sp.S.Zero
        self.mimic_notes: list[str] = []
        self.snapped_angles: list[str] = []
        self.snapped_offsets: list[str] = []
        text = read_text(path)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise QdotError(f"{path}: remove the DOCTYPE; a URDF does not need one")
        try:
            root = ElementTree.fromstring(text)  # noqa: S314 - the instructor's own file, without entities
        except ElementTree.ParseError as error:
            raise QdotError(f"{path}: line {error.position[0]}: not valid XML: {str(error).split(':')[0]}") from None
        if root.tag != "robot":
            raise QdotError(f"{path}: the root element is <{root.tag}>; a URDF needs <robot>")
        if any("xacro" in element.tag for element in root.iter()):
            raise QdotError(f"{path}: the file has macros; expand them with xacro {path.name} > robot.urdf")
        self.title = root.get("name") or path.stem
        self.links = [self.read_name(link) for link in root.findall("link")]
        if not self.links:
            raise QdotError(f"{path}: the file describes no robot: it has no <link> in <robot>")
        self.joints = root.findall("joint")
        self.parent_joints: dict[str, ElementTree.Element] = {}
        for joint in self.joints:
            child = self.read_link(joint, "child")
            if child in self.parent_joints:
                earlier_joint = self.read_name(self.parent_joints[child])
                raise self.make_joint_error(joint, f"link {child!r} is also the child of joint {earlier_joint!r}")
            self.parent_joints[child] = joint

    def make_joint_error(self, joint: ElementTree.Element, message: str) -> QdotError:
        """Return an error whose message names the file and the joint."""
        return QdotError(f"{self.path}: joint {self.read_name(joint)!r}: {message}")

    def read_name(self, element: ElementTree.Element) -> str:
        """Return the name of a link or joint. Raises QdotError if the element has no name."""
        name = element.get("name")
        if not name:
            raise QdotError(f"{self.path}: a <{element.tag}> has no name")
        return name

    def read_link(self, joint: ElementTree.Element, role: str) -> str:
        """Return the name of a joint's "parent" or "child" link. Raises QdotError if there is no such link."""
        element = joint.find(role)
        link = "" if element is None else element.get("link", "")
        if link not in self.links:
            problem = f"its {role} is link {link!r}, which does not exist" if link else f"the {role} is missing"
            raise self.make_joint_error(joint, problem)
        return link

    # --- the chain ---

    def find_joints(self, tip: str, base: str) -> list[ElementTree.Element]:
        """Return the joints from the link `base`, by default the root, to the link `tip`, by default the only end.

        Raises QdotError if there is no such chain.
        """
        for option, link in (("--tip", tip), ("--base", base)):
            if link and link not in self.links:
                raise QdotError(f"{self.path}: {option}: {make_name_error('link', link, self.links)}")
        last_link = tip or self._find_only_end(base)
        joints_from_root = self._list_joints_above(last_link)
        path_links = [*(self.read_link(joint, "parent") for joint in joints_from_root), last_link]
        if base and base not in path_links:
            message = f"link {base!r} is not on the way from the root to link {last_link!r}"
            raise QdotError(f"{self.path}: {message}; choose --base from {', '.join(path_links[:-1]) or last_link}")
        chain_joints = joints_from_root[path_links.index(base) if base else 0 :]
        if not chain_joints:
            problem = f"link {last_link!r} is the {'base' if base else 'root'}, which no joint moves"
            proposal = self.propose_tip(base)
            hint = f", as in --tip {proposal}" if proposal else ""
            raise QdotError(f"{self.path}: {problem}; choose another --tip{hint}")
        return chain_joints

    def _find_only_end(self, base: str) -> str:
        """Return the only link without children that is `base` or comes after it. Raises QdotError."""
        ends = self._list_ends(base)
        if len(ends) == 1:
            return ends[0]
        problem = f"several last links: {write_first(ends, _MAX_LISTED_LINKS)}" if ends else "its links form a loop"
        command = f"qdot solve {self.path.name} --tip {self.propose_tip(base) or 'LINK'}"
        remark = "add --convert dh to write it as a ROBOT.toml"
        raise QdotError(f"{self.path}: {problem}; choose the last link, as in: {command} ({remark})")

    def _list_ends(self, base: str) -> list[str]:
        """Return the links without children; with a `base`, only those that come after it."""
        parents = {self.read_link(joint, "parent") for joint in self.joints}
        ends = [link for link in self.links if link not in parents]
        return [link for link in ends if not base or base in self._list_links_to(link)]

    def _list_joints_above(self, link: str) -> list[ElementTree.Element]:
        """Return the joints from the root to a link. Raises QdotError if the links form a loop."""
        joints, upper_link = list[ElementTree.Element](), link
        while upper_link in self.parent_joints:
            joint = self.parent_joints[upper_link]
            if joint in joints:
                raise self.make_joint_error(joint, "its links form a loop; qdot needs a chain of links")
            joints.insert(0, joint)
            upper_link = self.read_link(joint, "parent")
        return joints

    def _list_links_to(self, link: str) -> list[str]:
        return [*(self.read_link(joint, "parent") for joint in self._list_joints_above(link)), link]

    def propose_tip(self, base: str) -> str:
        """Return a link that is probably meant as the last link; empty if no joint moves any link.

        The candidates are tool frames, then the last link before the longest branches split (such as the hand that
        carries the fingers), then the end of the first of these branches. The first candidate with more than half the
        joints of these branches is returned.
        """
        ends = self._list_ends(base)
        count_to_base = self._count_independent_joints(base)
        joint_counts = {link: self._count_independent_joints(link) - count_to_base for link in self.links}
        most_joints = max((joint_counts[link] for link in ends), default=0)
        if not most_joints:
            return ""
        longest_ends = [link for link in ends if joint_counts[link] == most_joints]
        links_to_ends = [self._list_links_to(link) for link in longest_ends]
        shared_links = [link for link in links_to_ends[0] if all(link in links for links in links_to_ends)]
        tool_frames = filter(_TOOL_FRAME_PATTERN.fullmatch, ends)
        candidates = (*tool_frames, shared_links[-1], longest_ends[0])
        return next(link for link in candidates if 2 * joint_counts[link] > most_joints)

    def _count_independent_joints(self, link: str) -> int:
        """Return the number of joints between the root and a link that move and are no mimic joints."""
        joints = self._list_joints_above(link)
        return sum(joint.get("type") != "fixed" and joint.find("mimic") is None for joint in joints)

    def check_mimic_joints(self, chain_joints: Sequence[ElementTree.Element]) -> None:
        """Add a note about each mimic joint of the chain. Raises QdotError if its original is in the chain, too."""
        first_joints: dict[str, ElementTree.Element] = {}  # for each original joint: the first joint that moves like it
        for joint in chain_joints:
            if joint.get("type") == "fixed":
                continue
            first_joint, mimic = first_joints.setdefault(self._find_original(joint), joint), joint.find("mimic")
            if first_joint is not joint:
                name, first_name = self.read_name(joint), self.read_name(first_joint)
                problem = f"it moves together with joint {first_name!r} (mimic), but qdot needs independent joints"
                rate = f"how far {name!r} moves per unit of {first_name!r}"
                chain_rule = f"add the column of {name!r}, times {rate}, to that of {first_name!r}"
                parent, child = self.read_link(joint, "parent"), self.read_link(first_joint, "child")
                raise self.make_joint_error(
                    joint,
                    f"{problem}; delete this joint's <mimic> and, in the Jacobian, {chain_rule} (chain rule), but "
                    "ignore the singular configurations, which are those of independent joints; or end the chain "
                    f"before this joint (--tip {parent}), or begin it after the other one (--base {child})",
                )
            if mimic is not None:
                note = f"joint {self.read_name(joint)!r}: it copies joint {mimic.get('joint')!r} (mimic)"
                remark = "which is not in the chain; here, the joint has a variable of its own"
                self.mimic_notes.append(f"{self.path}: {note}, {remark}")

    def _find_original(self, joint: ElementTree.Element) -> str:
        """Return the name of the joint that a joint copies, perhaps through other joints; its own if it copies none.

        Raises QdotError if there is no such joint.
        """
        joints_by_name = {self.read_name(any_joint): any_joint for any_joint in self.joints}
        names = [self.read_name(joint)]
        while (mimic := joints_by_name[names[-1]].find("mimic")) is not None:
            original = mimic.get("joint", "")
            if original not in joints_by_name:
                raise self.make_joint_error(joint, f"it copies (mimic) joint {original!r}, which does not exist")
            if original in names:
                raise self.make_joint_error(joint, f"it copies (mimic) itself: {' → '.join([*names, original])}")
            names.append(original)
        return names[-1]

    # --- joints ---

    def read_kind(self, joint: ElementTree.Element) -> str:
        """Return the kind of a joint: "R", "P", or "" if the joint is fixed. Raises QdotError for another type."""
        kind = joint.get("type", "")
        if kind == "fixed":
            return ""
        if kind not in JOINT_KINDS:
            supported = ", ".join([*JOINT_KINDS, "fixed"])
            raise self.make_joint_error(joint, f"type {kind!r} is not supported; use {supported}")
        return JOINT_KINDS[kind]

    def read_origin(self, joint: ElementTree.Element) -> Pose:
        """Return the pose of a joint's frame in its parent link, at home."""
        position = zip("xyz", self._read_position(joint), strict=True)
        xyz = [self._snap_offset(joint, axis, value) for axis, value in position]
        element = joint.find("origin")
        rpy_text = "0 0 0" if element is None else element.get("rpy", "0 0 0")
        rpy = self._parse_numbers(joint, "origin rpy", rpy_text)
        names = ("roll", "pitch", "yaw")
        return make_pose(xyz, [self._snap_angle(joint, name, angle) for name, angle in zip(names, rpy, strict=True)])

    def _read_position(self, joint: ElementTree.Element) -> Sequence[sp.Expr]:
        """Return the position of a joint's frame in its parent link, at home."""
        element = joint.find("origin")
        return self._parse_numbers(joint, "origin xyz", "0 0 0" if element is None else element.get("xyz", "0 0 0"))

    def set_offset_tolerance(self, chain_joints: Sequence[ElementTree.Element]) -> None:
        """Set the maximum size (m) of an offset that counts as zero in a chain."""
        length = sp.Add(*(sp.Matrix(self._read_position(joint)).norm() for joint in chain_joints))
        self.offset_tolerance = min(MAX_OFFSET_TOLERANCE, RELATIVE_OFFSET_TOLERANCE * length.n(), key=float)

    def read_direction(self, joint: ElementTree.Element) -> sp.Matrix:
        """Return the unit vector along a joint's axis, in the joint's frame; tiny components are snapped to zero."""
        element = joint.find("axis")
        axis = sp.Matrix(self._parse_numbers(joint, "axis xyz", "1 0 0" if element is None else element.get("xyz", "")))
        if axis.norm() == 0:
            raise self.make_joint_error(joint, "its axis is the zero vector")
        snapped_axis = axis.applyfunc(lambda entry: entry if abs(entry) > ANGLE_TOLERANCE * axis.norm() else sp.S.Zero)
        tilt = (axis - snapped_axis).norm() / axis.norm()
        if tilt > _SILENT_TOLERANCE:
            numbers = ", ".join(f"{float(entry):g}" for entry in axis)
            self.snapped_angles.append(f"the axis ({numbers}) of {self.read_name(joint)!r}")
        return snapped_axis / snapped_axis.norm()

    def read_limits(self, joint: ElementTree.Element) -> tuple[sp.Expr, sp.Expr] | None:
        """Return the limits of a joint (rad or m); None if the joint has no limits."""
        element = joint.find("limit")
        if element is None or joint.get("type") == "continuous" or not {"lower", "upper"} <= {*element.attrib}:
            return None
        (low,) = self._parse_numbers(joint, "limit lower", element.attrib["lower"], 1)
        (high,) = self._parse_numbers(joint, "limit upper", element.attrib["upper"], 1)
        if not low <= high:
            message = f"its lower limit {float(low):g} is above its upper limit {float(high):g}"
            raise self.make_joint_error(joint, message)
        if joint.get("type") == "revolute":
            low, high = self._snap_angle(joint, "lower limit", low), self._snap_angle(joint, "upper limit", high)
        return (low, high) if low < high else None  # some programs write 0 and 0 for unknown limits

    def _parse_numbers(
        self, joint: ElementTree.Element, attribute: str, text: str, count: int = 3
    ) -> Sequence[sp.Expr]:
        words = text.split()
        number = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,2})?"
        if len(words) != count or not all(re.fullmatch(number, word) for word in words):
            expectation = "three numbers" if count == 3 else "a number"
            raise self.make_joint_error(joint, f"{attribute} = {text!r}: expected {expectation}")
        return [sp.Rational(word) for word in words]

    # --- snapping ---

    def _snap_angle(self, joint: ElementTree.Element, name: str, angle: sp.Expr) -> sp.Expr:
        """Return the multiple of pi/12 that is within the tolerance of an angle, else the angle itself."""
        multiple = sp.pi * sp.Integer(round(float(angle) * 12 / float(sp.pi))) / 12
        difference = abs(sp.N(angle - multiple, 30))
        if difference > ANGLE_TOLERANCE:
            return angle
        if difference > _SILENT_TOLERANCE:
            degrees = f"{float(angle):g} rad as {180 * multiple / sp.pi}°"
            self.snapped_angles.append(f"{name} of {self.read_name(joint)!r} ({degrees})")
        return multiple

    def _snap_offset(self, joint: ElementTree.Element, axis: str, offset: sp.Expr) -> sp.Expr:
        """Return zero if an offset (m) is within the tolerance of zero, else the offset itself."""
        if abs(offset) > self.offset_tolerance:
            return offset
        if abs(offset) > _SILENT_TOLERANCE:
            self.snapped_offsets.append(f"{axis} of {self.read_name(joint)!r} ({format_offset(offset)})")
        return sp.S.Zero

    def make_notes(self) -> tuple[str, ...]:
        """Return a note about each mimic joint, one about all snapped angles, and one about all snapped offsets."""
        notes = list(self.mimic_notes)
        if self.snapped_angles:
            subject = "taken as multiples of 15°, from which they differ by at most 0.001 rad"
            notes.append(f"{self.path}: {subject}: {', '.join(self.snapped_angles)}")
        if self.snapped_offsets:
            notes.append(make_offset_note(self.path, self.snapped_offsets, self.offset_tolerance))
        return tuple(notes)


def make_offset_note(path: Path, snapped_offsets: Sequence[str], tolerance: sp.Expr) -> str:
    """Return the note that some offsets of at most a tolerance (m) were snapped to zero."""
    return f"{path}: taken as 0, because at most {format_offset(tolerance)}: {', '.join(snapped_offsets)}"


def format_offset(offset: sp.Expr) -> str:
    """Return a small length (m) in millimetres.

    >>> format_offset(sp.Rational(-976, 10**6))
    '-0.976 mm'
    """
    return f"{float(1000 * offset):.4g} mm"
