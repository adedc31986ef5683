"""The library of real robots: files of `exercises/robots`, one a robot, each in the convention of its source.

A robot is named by its file without the ending, in small or capital letters, with or without hyphens: panda, UR5e.
Published models of the same robots, against which they are held, are in the tests' data.
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

FOLDER = Path(__file__).parents[1] / "robots"
ENDINGS = (".toml", ".csv", ".urdf", ".xml")
"""What the name of a file ends in; a name with any of them, or with a folder, is no robot's."""


@dataclass(frozen=True)
class Listed:
    """A robot of the library as it is listed: its name, what it is called, kinds of joints as in RRPR, and source."""

    name: str
    title: str
    joints: str
    convention: str
    source: str

    @property
    def path(self) -> Path:
        """Its file."""
        return FOLDER / f"{self.name}.toml"


@cache
def robots() -> Mapping[str, Listed]:
    """Return all robots of the library by their names, in the order of their names; numbers in it count as numbers.

    >>> list(robots())[-6:]
    ['ur3', 'ur3e', 'ur5', 'ur5e', 'ur10', 'ur10e']
    """
    paths = sorted(FOLDER.glob("*.toml"), key=lambda path: _in_order(path.stem))
    return MappingProxyType({path.stem: _listed(path) for path in paths})


def _in_order(name: str) -> list[tuple[str, int]]:
    return [(letters, int(digits or 0)) for letters, digits in re.findall(r"(\D*)(\d*)", name)]


def _listed(path: Path) -> Listed:
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    kinds = "".join(joint["kind"] for joint in content["joint"])
    return Listed(path.stem, content["name"], kinds, content.get("convention", "dh"), content["source"])


def robot_path(given: str, folder: Path = Path()) -> Path:
    """Return the file that is meant: one in a folder, else the robot of the library of that name.

    Raises QdotError for what is neither, with the robot that is most like it.

    >>> robot_path("Panda").name
    'panda.toml'
    """
    path = folder / given
    try:
        if path.is_file():
            return path
    except OSError as error:  # as of a name that is too long for a disk
        raise QdotError(f"there is no file {path}: {error.strerror}") from None
    known = {_plain(name): robot for name, robot in robots().items()}
    if path.suffix.lower() in ENDINGS or {"/", "\\"} & {*given}:
        robot = known.get(_plain(path.stem))
        hint = f"; the library's robot is called {robot.name}, without folder and ending" if robot else ""
        raise QdotError(f"there is no file {path}{hint}")
    if _plain(given) in known:
        return known[_plain(given)].path
    if path.is_dir():
        raise QdotError(f"{path} is a folder; an arm is told by a file, or by a name that 'qdot robots' lists")
    close = [known[name].name for name in difflib.get_close_matches(_plain(given), known, n=1)]
    hint = f" (did you mean {close[0]!r}?)" if close else ""
    raise QdotError(f"there is no file {path}, and the library has no robot {given!r}{hint}; 'qdot robots' lists them")


def is_in_library(name: str) -> bool:
    """Whether the library has a robot of that name."""
    return _plain(name) in map(_plain, robots())


def _plain(name: str) -> str:
    return re.sub(r"[-_\s]", "", name.casefold())
