"""What one comparison costs, beside SymPy's `simplify(a - b) == 0` on the same pairs, in processor time."""

import json
import signal
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import sympy as sp

from grader.compare import compare_line

CORPUS = Path(__file__).parents[1] / "data" / "corpus.jsonl"
LONGEST = 20
"""Seconds of processor time after which SymPy is stopped."""


def bench_comparing() -> None:
    """Print medians and 99th percentiles of processor time over the checked pairs, and the ratio of the medians."""
    cases = [json.loads(line) for line in CORPUS.read_text(encoding="utf-8").splitlines()]
    for case in cases[:5]:
        ours(case)
    times = [cpu(ours, case) for case in cases]
    show(f"compare: all {len(times)} pairs of the corpus", times)
    pairs = [case for case in cases if case["type"] == "expression" and case["group"] in ("core", "domain")]
    own = [cpu(ours, case) for case in pairs]
    theirs = [cpu(simplify, case) for case in pairs]
    show(f"compare: {len(pairs)} formulas", own)
    show("SymPy: simplify(a - b) == 0, the same", theirs)
    ratio = statistics.median(theirs) / statistics.median(own)
    sys.stdout.write(f"{'SymPy over ours, at the median':<46} {ratio:9.1f} x\n")


def ours(case: dict[str, Any]) -> None:
    """Compare a pair as `qdot compare --batch` does, reading both texts."""
    compare_line(json.dumps(case), 1)


def simplify(case: dict[str, Any]) -> None:
    """Compare a pair as a plain checker would; the text is from our own corpus, so that SymPy may read it."""
    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        _ = sp.simplify(sp.sympify(case["student"].replace("^", "**")) - sp.sympify(case["reference"])) == 0
    except TimeoutError:
        pass
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


def stop(_signal: int, _frame: object) -> None:
    """End what takes too long."""
    raise TimeoutError


def cpu(work: Callable[[dict[str, Any]], None], case: dict[str, Any]) -> float:
    """Return the processor time of a call in milliseconds."""
    start = time.process_time()
    work(case)
    return 1000 * (time.process_time() - start)


def show(name: str, times: list[float]) -> None:
    """Print one line of the table."""
    ordered = sorted(times)
    sys.stdout.write(
        f"{name:<46} {statistics.median(times):9.2f} ms, 99 % below {ordered[int(0.99 * (len(ordered) - 1))]:.1f} ms\n"
    )


if __name__ == "__main__":
    bench_comparing()
