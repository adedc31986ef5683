"""Store results of runs in real programs as tests/platforms/NAME.json; docs/export-formats.md is made from them."""

import datetime
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from qdot.exercises.common.files import write_atomically

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Count:
    """How many checks of a kind passed, out of how many; `but` is a remark for readers.

    If `excused` checks failed for a known reason, `but` gives the reason.
    """

    passed: int
    of: int
    but: str = ""
    excused: int = 0

    @property
    def is_sound(self) -> bool:
        """Return whether there were checks, and every failure has a known reason."""
        return self.of > 0 and self.passed + self.excused == self.of


@dataclass(frozen=True)
class Record:
    """A run: the export format, the program with its version, the date, and the counts.

    "generate" means the notebooks that `qdot generate` writes. The counts have the names "imported", "shown",
    "right = full", "wrong < full", "blank = 0", …, in this order.
    """

    export_format: str
    software: str
    date: str
    counts: Mapping[str, Count]

    def keep(self, name: str) -> None:
        """Write the record of a platform, replacing the last one."""
        text = json.dumps(asdict(self), indent=1, ensure_ascii=False)
        write_atomically(FOLDER / f"{name}.json", text + "\n")


class Counts:
    """The counts of a run so far, by the name of the check; `but` holds the remarks."""

    def __init__(self) -> None:
        self.passed: dict[str, int] = {}
        self.of: dict[str, int] = {}
        self.but: dict[str, str] = {}
        self.excused: dict[str, int] = {}

    def add(self, what: str, came_out: bool, which: str) -> None:
        """Count one check, and print which one it is if it failed."""
        self.passed[what] = self.passed.get(what, 0) + came_out
        self.of[what] = self.of.get(what, 0) + 1
        if not came_out:
            print(f"  {what}: {which}")

    def excuse(self, what: str, many: int, why: str) -> None:
        """Excuse a number of failures, and give the reason in a sentence."""
        self.excused[what], self.but[what] = self.excused.get(what, 0) + many, why

    def told(self) -> dict[str, Count]:
        """Return the counts of a record."""
        return {
            what: Count(self.passed[what], of, self.but.get(what, ""), self.excused.get(what, 0))
            for what, of in self.of.items()
        }


def today() -> str:
    """Return today's date in UTC."""
    return datetime.datetime.now(datetime.UTC).date().isoformat()


def kept() -> dict[str, Record]:
    """Return the records of the last runs, by the names of the platforms."""
    found = {}
    for path in sorted(FOLDER.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        counts = {name: Count(**count) for name, count in data.pop("counts").items()}
        found[path.stem] = Record(**data, counts=counts)
    return found
