"""What a run in a real program showed, as stored in tests/platforms/NAME.json and shown in docs/export-formats.md."""

import datetime
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from qdot.exercises.common.files import write_atomically

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Count:
    """Of so many things, so many came out as they are to; `but` is what one has to know with it.

    So many `excused` fell short for the reason that it gives.
    """

    passed: int
    of: int
    but: str = ""
    excused: int = 0

    @property
    def is_sound(self) -> bool:
        """Tell whether nothing fell short without a reason, and there was something at all."""
        return self.of > 0 and self.passed + self.excused == self.of


@dataclass(frozen=True)
class Record:
    """A run: what was exported (`export format`), into which program and version, on which day, and what was counted.

    "generate" stands for the notebooks that `qdot generate` writes.

    The counts are called as the table of docs/export-formats.md calls them: "imported", "shown", "right = full",
    "wrong < full", "blank = 0", … in this order.
    """

    export_format: str
    software: str
    date: str
    counts: Mapping[str, Count]

    def keep(self, name: str) -> None:
        """Write the record of a platform, in place of the last one."""
        text = json.dumps(asdict(self), indent=1, ensure_ascii=False)
        write_atomically(FOLDER / f"{name}.json", text + "\n")


class Counts:
    """Counts while a run goes on; what has to be known with one is in `but`."""

    def __init__(self) -> None:
        self.passed: dict[str, int] = {}
        self.of: dict[str, int] = {}
        self.but: dict[str, str] = {}
        self.excused: dict[str, int] = {}

    def add(self, what: str, came_out: bool, which: str) -> None:
        """Count one more, and print which one it is where it did not come out."""
        self.passed[what] = self.passed.get(what, 0) + came_out
        self.of[what] = self.of.get(what, 0) + 1
        if not came_out:
            print(f"  {what}: {which}")

    def excuse(self, what: str, many: int, why: str) -> None:
        """Say that so many more may fall short, and why."""
        self.excused[what], self.but[what] = self.excused.get(what, 0) + many, why

    def told(self) -> dict[str, Count]:
        """Return the counts of a record."""
        return {
            what: Count(self.passed[what], of, self.but.get(what, ""), self.excused.get(what, 0))
            for what, of in self.of.items()
        }


def today() -> str:
    """Return the day of a run."""
    return datetime.datetime.now(datetime.UTC).date().isoformat()


def kept() -> dict[str, Record]:
    """Return the records of the last runs, by the names of the platforms."""
    found = {}
    for path in sorted(FOLDER.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        counts = {name: Count(**count) for name, count in data.pop("counts").items()}
        found[path.stem] = Record(**data, counts=counts)
    return found
