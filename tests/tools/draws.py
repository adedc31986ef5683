"""Many draws of every family at every step of variation, certified: `python -m tests.tools.draws --count 200`.

Each draw is asked every question that its arm can be asked, and has the certificate that `qdot verify` prints: its
references in numbers, its singular sets both ways, full marks for the reference. How many were certified stands in
draws.json, with the failures, which the next run looks at again; it goes on where the last one ended, and loses at
most the draws in hand. Another engine begins anew: its ids are other problems.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from exercises.console import progress
from exercises.families import FAMILIES
from exercises.files import write_atomically
from exercises.problem import ENGINE, ProblemId
from exercises.variation import STEPS
from grader.certify import Task, certify_all

RECORD = Path(__file__).with_name("draws.json")
FIRST = 10_000
"""Seeds from which is drawn: other ones than those of snapshots, tests and docs."""
AT_ONCE = 10
"""Draws of a family and step that are certified together, as they share a derivation."""

Record = dict[str, Any]


def empty() -> Record:
    """Return the record of no draw."""
    return {
        "engine": ENGINE,
        "first": FIRST,
        "certified": {family: dict.fromkeys(STEPS, 0) for family in FAMILIES},
        "failed": {},
    }


def kept(path: Path) -> Record:
    """Return what earlier runs found, with new families and steps; nothing of another engine."""
    found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else empty()
    if (found["engine"], found["first"]) != (ENGINE, FIRST):
        return empty()
    for family, counts in empty()["certified"].items():
        found["certified"][family] = counts | found["certified"].get(family, {})
    return dict(found)


def left(record: Record, count: int) -> Iterator[tuple[str, str, range]]:
    """Yield what is to be certified until every family and step has `count` draws, ten of each at a time.

    >>> record = {"certified": {"planar-2r": {"chapter": 12, "full": 0}}}
    >>> [(step, list(seeds)) for _, step, seeds in left(record, 14)]
    [('full', [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]), ('chapter', [12, 13]), ('full', [10, 11, 12, 13])]
    """
    done = [(n, family, step) for family, steps in record["certified"].items() for step, n in steps.items()]
    for begin in range(0, count, AT_ONCE):
        for n, family, step in done:
            seeds = range(max(n, begin), min(count, begin + AT_ONCE))
            if seeds:
                yield family, step, seeds


def certified(draws: Sequence[ProblemId], jobs: int) -> dict[str, list[str]]:
    """Return what is wrong with which of the draws."""
    with closing(certify_all([Task(draw) for draw in draws], jobs)) as every:
        return {str(task.identity): [failure.said for failure in failures] for task, failures in every if failures}


def main() -> int:
    """Certify what is left, and keep the record after each family and step. Returns 1 if a draw failed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200, help="draws of every family and step")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--record", type=Path, default=RECORD, help="the file with what is certified")
    given = parser.parse_args()
    record = kept(given.record)
    tasks = list(left(record, given.count))
    started = time.process_time()
    record["failed"] = certified([ProblemId.parse(name) for name in record["failed"]], given.jobs)
    write_atomically(given.record, (json.dumps(record, indent=1) + "\n").encode())
    with progress("certifying", sum(len(seeds) for _, _, seeds in tasks)) as counter:
        for family, step, seeds in tasks:
            draws = [ProblemId(family, FIRST + seed).varied(step) for seed in seeds]
            record["failed"].update(certified(draws, given.jobs))
            record["certified"][family][step] = seeds.stop
            write_atomically(given.record, (json.dumps(record, indent=1) + "\n").encode())
            for _ in seeds:
                counter.step()
    counts = [n for steps in record["certified"].values() for n in steps.values()]
    print(
        f"{sum(counts)} draws, at least {min(counts)} of each of {len(counts)} families and steps, "
        f"{len(record['failed'])} failed ({time.process_time() - started:.0f} s of this process)"
    )
    for said in record["failed"].values():
        print(*said, sep="\n")
    return 1 if record["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
