"""How long tests take, for the suites: from what pytest prints with --durations=0 --durations-min=0.02.

QDOT_SUITE=whole python -m pytest -n auto --dist loadgroup --durations=0 --durations-min=0.02 > FILE
python -m tests.tools.seconds FILE
"""

import json
import re
import sys
from collections import defaultdict
from pathlib import Path

from exercises.families import FAMILIES
from exercises.files import write_atomically
from tests.support import ROOT
from tests.support.suites import TURNS

TABLE = ROOT / "tests" / "support" / "seconds.json"
LINE = re.compile(r"\s*([\d.]+)s (call|setup|teardown)\s+(\S.*?)(?:@([\w-]+))?\s*$")


def seconds_of(printed: str) -> dict[str, float]:
    """Return the mean over its parameters of what each test takes, of those that take long enough to have turns.

    What takes too long for `make test` with some parameters only is listed by itself, and so is what a group makes
    once: its longest setup, which counts for no test.

    >>> seconds_of("3.00s call     tests/a.py::test_b[x]@group\\n1.00s setup    tests/a.py::test_b[y]")
    {'tests/a.py::test_b': 2.0}
    >>> seconds_of("3.00s setup    tests/a.py::test_b@group\\n0.90s call     tests/a.py::test_b@group")
    {'@group': 3.0, 'tests/a.py::test_b': 0.9}
    """
    items: dict[str, float] = defaultdict(float)
    shared: dict[str, float] = defaultdict(float)
    for found in filter(None, map(LINE.match, printed.splitlines())):
        seconds, phase, name, group = float(found[1]), found[2], found[3], found[4]
        if phase == "setup" and group and group not in FAMILIES:
            shared[f"@{group}"] = max(shared[f"@{group}"], seconds)
        else:
            items[name] += seconds
    tests: dict[str, list[float]] = defaultdict(list)
    for name, seconds in items.items():
        tests[name.partition("[")[0]].append(seconds)
    means = {name: round(sum(each) / len(each), 1) for name, each in sorted(tests.items())}
    longest = {name: round(seconds, 1) for name, seconds in sorted(items.items()) if seconds >= TURNS[-1][0]}
    return {name: round(mean, 1) for name, mean in (shared | means).items() if mean >= TURNS[0][0]} | longest


def main(path: str) -> None:
    """Write the table from a run's output; what that run did not run keeps its old figure."""
    old = json.loads(TABLE.read_text(encoding="utf-8")) if TABLE.exists() else {}
    new = seconds_of(Path(path).read_text(encoding="utf-8"))
    write_atomically(TABLE, (json.dumps({**old, **new}, indent=1, sort_keys=True) + "\n").encode())


if __name__ == "__main__":
    main(sys.argv[1])
