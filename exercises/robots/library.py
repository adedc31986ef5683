"""List the library of real robots, and find a robot's file by its name.

This folder has one file for each robot, in the convention of the source of its numbers. A robot's name is the name of
its file without the extension, such as panda or ur5e. In a name, upper case, hyphens and spaces don't matter.
"""

import difflib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

from qdot.exercises.common.errors import QdotError

ROBOT_FOLDER = Path(__file__).parent
FILE_EXTENSIONS = (".toml", ".urdf", ".xml")
"""File extensions of arms. A text with such an extension, or with a folder, is a path and not a robot's name."""


@dataclass(frozen=True)
class ListedRobot:
    """A robot in the list of the library. `joints` are the kinds of its joints, such as RRPR."""

    name: str
    title: str
    joints: str
    convention: str
    source: str

    @property
    def path(self) -> Path:
        """The robot's file."""
        return ROBOT_FOLDER / f"{self.name}.toml"


@cache
def list_robots() -> Mapping[str, ListedRobot]:
    """Map the name of each robot of the library to the robot; names are sorted with numbers in numeric order.

    >>> list(list_robots())[-6:]
    ['ur3', 'ur3e', 'ur5', 'ur5e', 'ur10', 'ur10e']
    """

    def make_sort_key(path: Path) -> list[tuple[str, int]]:
        return [(letters, int(digits or 0)) for letters, digits in re.findall(r"(\D*)(\d*)", path.stem)]

    robots_by_name = {}
    for path in sorted(ROBOT_FOLDER.glob("*.toml"), key=make_sort_key):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        joints, convention = "".join(joint["kind"] for joint in content["joint"]), content.get("convention", "dh")
        robots_by_name[path.stem] = ListedRobot(path.stem, content["name"], joints, convention, content["source"])
    return MappingProxyType(robots_by_name)


def find_robot_path(name_or_path: str, folder: Path = Path()) -> Path:
    """Return the path of an arm's file: the file with this name in the folder, or the library's robot with this name.

    Raises QdotError if there is neither; the message suggests the robot with the most similar name.

    >>> find_robot_path("Panda").name
    'panda.toml'
    """
    path = folder / name_or_path
    try:
        if path.is_file():
            return path
    except OSError as error:  # for example, the name is too long for the file system
        raise QdotError(f"can't open {path}: {error.strerror}") from None
    robots_by_name = {_normalize_name(name): robot for name, robot in list_robots().items()}
    if path.suffix.lower() in FILE_EXTENSIONS or {"/", "\\"} & {*name_or_path}:
        robot = robots_by_name.get(_normalize_name(path.stem))
        hint = f"; for the robot of the library, write {robot.name}, without folder and ending" if robot else ""
        raise QdotError(f"there is no file {path}{hint}")
    name = _normalize_name(name_or_path)
    if name in robots_by_name:
        return robots_by_name[name].path
    if path.is_dir():
        raise QdotError(f"{path} is a folder; give a file, or a name listed by 'qdot robots'")
    close_names = difflib.get_close_matches(name, robots_by_name, n=1)
    hint = f" (did you mean {robots_by_name[close_names[0]].name!r}?)" if close_names else ""
    raise QdotError(f"there is no file {path} and no robot {name_or_path!r}{hint}; 'qdot robots' lists the robots")


def is_in_library(name: str) -> bool:
    """Return whether the library has a robot with that name."""
    return _normalize_name(name) in map(_normalize_name, list_robots())


def _normalize_name(name: str) -> str:
    return re.sub(r"[-_\s]", "", name.casefold())
