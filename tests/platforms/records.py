"""Results of a run in a real program, as stored in tests/platforms/NAME.json and shown in docs/export-formats.md."""

import datetime
import json
import subprocess
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from qdot.exercises.common.files import write_atomically

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Count:
    """How many of the checks of one kind `passed`, `of` how many.

    `but` is a remark for the reader; `excused` is the number of checks that failed for the reason in the remark.
    """

    passed: int
    of: int
    but: str = ""
    excused: int = 0

    @property
    def all_passed_or_excused(self) -> bool:
        """Return whether every check passed or is excused, and there was at least one."""
        return self.of > 0 and self.passed + self.excused == self.of


@dataclass(frozen=True)
class Record:
    """A run: the `export_format`, the program with its version (`software`), the date, and the counts by kind of check.

    The format "generate" stands for the notebooks that `qdot generate` writes, "serve" for `qdot serve` as a tool of a
    learning platform. Kinds of checks are "imported", "shown", "right = full" (right answers earn full marks),
    "wrong < full", "blank = 0", …
    """

    export_format: str
    software: str
    date: str
    counts: Mapping[str, Count]

    def save(self, name: str) -> None:
        text = json.dumps(asdict(self), indent=1, ensure_ascii=False)
        write_atomically(FOLDER / f"{name}.json", text + "\n")


class Counts:
    """The counts of a run in progress: the fields of a `Count`, by kind of check."""

    def __init__(self) -> None:
        self.passed: dict[str, int] = {}
        self.of: dict[str, int] = {}
        self.but: dict[str, str] = {}
        self.excused: dict[str, int] = {}

    def add(self, check: str, passed: bool, details: str) -> None:
        self.passed[check] = self.passed.get(check, 0) + passed
        self.of[check] = self.of.get(check, 0) + 1
        if not passed:
            print(f"  {check}: {details}")

    def excuse(self, check: str, number: int, reason: str) -> None:
        self.excused[check], self.but[check] = self.excused.get(check, 0) + number, reason

    def freeze(self) -> dict[str, Count]:
        return {
            check: Count(self.passed[check], of, self.but.get(check, ""), self.excused.get(check, 0))
            for check, of in self.of.items()
        }


def describe_checkout(software: Path) -> str:
    """Return the date and the hash of the last commit of a checkout."""
    command = ["git", "-C", str(software), "log", "-1", "--format=%cs (%h)"]
    return subprocess.run(command, capture_output=True, text=True).stdout.strip()


def today() -> str:
    return datetime.datetime.now(datetime.UTC).date().isoformat()


def load_records() -> dict[str, Record]:
    records = {}
    for path in sorted(FOLDER.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        counts = {name: Count(**count) for name, count in data.pop("counts").items()}
        records[path.stem] = Record(**data, counts=counts)
    return records
