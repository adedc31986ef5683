"""Read a robot from a URDF, the robot format of ROS: the axes at home of the joints from the root to a tip link.

Only the properties of a serial chain are read: joints with their type, parent, child, origin, axis and limits. A joint
that copies the motion of another joint (mimic) is refused if it is in the chain. The elements `joint` and `link` are
specified at http://wiki.ros.org/urdf/XML.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import sympy as sp

from qdot.exercises.arm.axes_to_dh import IDENTITY_POSE, ZERO_TOLERANCE, Axis, Pose, make_pose
from qdot.exercises.common.errors import QdotError, make_name_error
from qdot.exercises.common.input_file import read_text

JOINT_KINDS = {"revolute": "R", "continuous": "R", "prismatic": "P"}
"""The joint types that qdot supports apart from "fixed", with their kinds."""
ANGLE_TOLERANCE = sp.Rational(1, 1000)
"""Tolerance (rad) within which an angle counts as a multiple of pi/12: 1.57, 1.5708 and 3.1416 are common."""


@dataclass(frozen=True)
class UrdfChain:
    """The serial chain in a URDF, at home and in the frame of the root link.

    - `tip`: the position of the origin of the last link (3 x 1, m).
    - `limits`: the limits of each joint (rad or m); None for a joint without limits.
    - `notes`: messages about angles that were replaced by a multiple of pi/12.
    """

    name: str
    axes: tuple[Axis, ...]
    tip: sp.Matrix
    limits: tuple[tuple[sp.Expr, sp.Expr] | None, ...]
    notes: tuple[str, ...]


def read_urdf(path: Path, tip: str = "") -> UrdfChain:
    """Return the chain that ends at the link `tip`, by default the only link without children. Raises QdotError."""
    reader = _UrdfReader(path)
    chain_joints = reader.find_joints_to(tip)
    pose, axes, limits = IDENTITY_POSE, list[Axis](), list[tuple[sp.Expr, sp.Expr] | None]()
    for joint in chain_joints:
        pose = pose @ reader.read_origin(joint)
        kind = reader.read_kind(joint)
        if kind:
            axes.append(Axis(kind, pose.rotation * reader.read_direction(joint), pose.origin))
            limits.append(reader.read_limits(joint))
    if not axes:
        raise QdotError(f"{path}: no joint moves link {tip or reader.read_link(chain_joints[-1], 'child')!r}")
    return UrdfChain(reader.title, tuple(axes), pose.origin, tuple(limits), tuple(reader.notes))


class _UrdfReader:
    """The reader of one file; its error messages name the file, and the joint or link."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
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

    def find_joints_to(self, tip: str) -> list[ElementTree.Element]:
        """Return the joints from the root to the link `tip`, by default the only link without children.

        Raises QdotError if there is no such chain.
        """
        parents = {self.read_link(joint, "parent") for joint in self.joints}
        end_links = [link for link in self.links if link not in parents]
        if tip and tip not in self.links:
            raise QdotError(f"{self.path}: {make_name_error('link', tip, self.links)}")
        if not tip and len(end_links) != 1:
            command = f"qdot solve {self.path.name} --tip LINK (--convert dh writes it as a ROBOT.toml)"
            problem = f"several last links: {', '.join(end_links)}" if end_links else "its links form a loop"
            raise QdotError(f"{self.path}: {problem}; choose the last link: {command}")
        chain_joints, link = list[ElementTree.Element](), tip or end_links[0]
        while link in self.parent_joints:
            joint = self.parent_joints[link]
            if joint in chain_joints:
                raise self.make_joint_error(joint, "its links form a loop; qdot needs a chain of links")
            chain_joints.insert(0, joint)
            link = self.read_link(joint, "parent")
        if not chain_joints:
            raise QdotError(f"{self.path}: link {link!r} is the root, which no joint moves; choose another with --tip")
        return chain_joints

    def read_kind(self, joint: ElementTree.Element) -> str:
        """Return the kind of a joint: "R", "P", or "" if the joint is fixed. Raises QdotError for another type."""
        kind = joint.get("type", "")
        if kind == "fixed":
            return ""
        if kind not in JOINT_KINDS:
            supported = ", ".join([*JOINT_KINDS, "fixed"])
            raise self.make_joint_error(joint, f"type {kind!r} is not supported; use {supported}")
        if joint.find("mimic") is not None:
            hint = "each joint up to the last link must move on its own"
            raise self.make_joint_error(joint, f"the joint copies another joint (mimic); {hint}")
        return JOINT_KINDS[kind]

    def read_origin(self, joint: ElementTree.Element) -> Pose:
        """Return the pose of a joint's frame in its parent link, at home."""
        element = joint.find("origin")
        attributes: Mapping[str, str] = {} if element is None else element.attrib
        xyz = self._parse_numbers(joint, "origin xyz", attributes.get("xyz", "0 0 0"))
        rpy = self._parse_numbers(joint, "origin rpy", attributes.get("rpy", "0 0 0"))
        return make_pose(xyz, [self._recognize_angle(joint, angle) for angle in rpy])

    def read_direction(self, joint: ElementTree.Element) -> sp.Matrix:
        """Return the unit vector along a joint's axis, in the joint's frame."""
        element = joint.find("axis")
        axis = sp.Matrix(self._parse_numbers(joint, "axis xyz", "1 0 0" if element is None else element.get("xyz", "")))
        if axis.norm() == 0:
            raise self.make_joint_error(joint, "its axis is the zero vector")
        return axis / axis.norm()

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
            low, high = self._recognize_angle(joint, low), self._recognize_angle(joint, high)
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

    def _recognize_angle(self, joint: ElementTree.Element, angle: sp.Expr) -> sp.Expr:
        """Return the multiple of pi/12 that is within the tolerance of an angle, else the angle itself."""
        twelfths = sp.Integer(round(float(angle) * 12 / float(sp.pi)))
        multiple = sp.pi * twelfths / 12
        difference = abs(sp.N(angle - multiple, 30))
        if not twelfths or difference > ANGLE_TOLERANCE:
            return angle
        if difference > ZERO_TOLERANCE * 1000:  # angles rounded to six or more decimals need no note
            self.notes.append(
                f"{self.path}: joint {self.read_name(joint)!r}: {float(angle):g} rad is taken as exactly {multiple}"
            )
        return multiple
