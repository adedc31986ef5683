"""Load the assignments of the service, and load them again when an instructor has edited their files."""

import logging
import re
from collections.abc import Sequence
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.common.errors import QdotError

WATCHED_FILES = ("assignment.toml", "roster.csv", "redrawn.csv", "secret.txt")
logger = logging.getLogger("qdot.serve")


class Assignments:
    """The assignments in some folders, by key. While an edited file has an error, the previous version stays in use.

    `errors` maps folders to errors; `changes` counts how often files were read again.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders, self.errors, self.changes = folders, dict[Path, str](), 0
        self._stamps: dict[Path, list[int | None]] = {}
        self._loaded: dict[Path, Assignment] = {}
        for folder in folders:
            self._stamps[folder], self._loaded[folder] = _read_stamps(folder), load_assignment(folder)
        keys = [assignment.key for assignment in self._loaded.values()]
        if duplicate := next((key for key in keys if keys.count(key) > 1), None):
            raise QdotError(f"two assignments have the key {duplicate!r}; the addresses of their pages contain the key")

    def load_all(self) -> dict[str, Assignment]:
        """Map each key to its assignment, in the order of the folders."""
        for folder in self._folders:
            stamps = _read_stamps(folder)
            if stamps != self._stamps[folder]:
                self._stamps[folder] = stamps
                self.changes += 1
                self.errors.pop(folder, None)
                try:
                    self._loaded[folder] = load_assignment(folder)
                except QdotError as error:
                    self.errors[folder] = "; ".join(str(error).splitlines())
                    place = re.match(r".*?\.(toml|csv)(: line \d+)?", str(error))  # the rest may name students
                    logger.error("%s has an error; the last good version is in use", place[0] if place else folder)
        return {assignment.key: assignment for assignment in self._loaded.values()}


def _read_stamps(folder: Path) -> list[int | None]:
    """Return the times at which the files of an assignment were changed; None for a file that doesn't exist."""
    paths = [folder / name for name in WATCHED_FILES]
    return [path.stat().st_mtime_ns if path.exists() else None for path in paths]
