"""`make planted`: 120 mistakes, planted one at a time in modules of all kinds, and which test finds each.

It answers whether a suite that got faster got blind. planted.json holds the mistakes: a place in the text and what
stands there instead. They were chosen at random once, so that the same question can be asked again. A mistake is
planted in a copy of the checkout, in which the tests that reach its place are run until one fails or the time for a
mistake is over. The steps, each of which resumes where it was stopped:

    python -m tests.tools.planted record --suite test     # one run of the suite: which test reaches which place
    python -m tests.tools.planted try --suite test        # the mistakes; --only 3,17 for some of them
    python -m tests.tools.planted show --suite test       # write the results into planted.md

`--suite` is check, test or whole; `--checkout` another checkout than this one, `--name` what its results are called.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.support import ROOT
from tests.tools import markers
from tests.tools.places import marked

HERE = Path(__file__).parent
MISTAKES = HERE / "planted.json"
DOCUMENT = HERE / "planted.md"
BEGIN, END = "<!-- written by `python -m tests.tools.planted show` -->", "<!-- end -->"
WORK = ROOT / ".planted"
"""Copies of the checkout, and what was found so far; not tracked."""
MINUTES = 3
"""How long tests are run for one mistake."""
LONGEST = 60
"""Seconds more than ten times what the longest of the tests takes: then a test hangs."""
OF_ANY_CHANGE = "tests/exercises/arm/test_shipped.py::test_it_is_what_is_worked_out"
"""Fails after any change of the modules that derive, right or wrong: it finds nothing."""
MOST = 1500
"""How many tests are run for one mistake, at most."""


@dataclass(frozen=True)
class Mistake:
    """A place in a file of the checkout, and what is put there instead: whole lines."""

    number: int
    path: str
    line: int
    old: str
    new: str
    what: str

    @property
    def in_site(self) -> bool:
        """Whether it is in the site's scripts, whose tests are their own."""
        return self.path.startswith("site/")

    def place(self, text: str) -> int:
        """Return where in the file's text the lines stand, at the place nearest to where they were drawn.

        Raises ValueError where the text has changed, so that the mistake can't be planted any more.
        """
        places = [at for at in range(len(text)) if text.startswith(self.old, at)] if self.old in text else []
        if not places:
            raise ValueError(f"mistake {self.number}: {self.path} no longer holds the lines {self.old!r}")
        return min(places, key=lambda place: abs(text.count("\n", 0, place) + 1 - self.line))

    def row(self, text: str) -> int:
        """Return the number of the row in which they begin. Raises ValueError as `place` does."""
        return text.count("\n", 0, self.place(text)) + 1

    def planted(self, text: str) -> str:
        """Return the file's text with the mistake. Raises ValueError as `place` does."""
        at = self.place(text)
        return text[:at] + self.new + text[at + len(self.old) :]


def mistakes() -> list[Mistake]:
    """Return those that are kept."""
    return [Mistake(**record) for record in json.loads(MISTAKES.read_text(encoding="utf-8"))]


@dataclass(frozen=True)
class Recorded:
    """One run of a suite: the tests that come to each mistake's place, and what each test took."""

    tests: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))

    @classmethod
    def of(cls, path: Path) -> "Recorded":
        """Read what `record` wrote."""
        made = cls()
        for line in path.read_text(encoding="utf-8").splitlines():
            first, name, *took = line.split("\t")
            test = re.sub(r"@[^@\]\[/]*$", "", name)  # the group that pytest-xdist adds
            if test.startswith(OF_ANY_CHANGE):
                continue
            if first == "took":
                made.seconds[test] += float(took[0])
            elif test:
                made.tests[int(first)].add(test)
        return made

    def only(self, names: set[str]) -> "Recorded":
        """Return what was recorded of some tests."""
        tests = {number: there & names for number, there in self.tests.items()}
        return Recorded(tests, {name: took for name, took in self.seconds.items() if name in names})

    def chosen(self, mistake: Mistake) -> list[str]:
        """Return the tests to run: those called like the module, the others that come to the place, shortest first.

        Then those called like it that were not seen there, as a mark may be lost where something is kept or in the
        sandbox, and last the rest of the files of all, where a fixture may have come there.
        """
        words = set(Path(mistake.path).with_suffix("").parts) - {"exercises", "grader"}
        words |= {"sandbox"} if "contained" in words else set()
        alike = {test for test in self.seconds if words & set(re.split(r"\W|test_|_", test.split("::")[0]))}
        here = self.tests.get(mistake.number, set()) & self.seconds.keys()
        files = {test.split("::")[0] for test in here}
        rest = {test for test in self.seconds if test.split("::")[0] in files}
        places = {**dict.fromkeys(rest, 3), **dict.fromkeys(alike, 2), **dict.fromkeys(here, 1)}
        places |= dict.fromkeys(here & alike, 0)
        return sorted(places, key=lambda test: (places[test], self.seconds.get(test, 0.0), test))


def copied(checkout: Path, to: Path) -> Path:
    """Copy what git tracks of a checkout, with links to its environments and to the site's libraries."""
    shutil.rmtree(to, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=checkout, capture_output=True, text=True, check=True).stdout
    for name in listed.rstrip("\0").split("\0"):
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(checkout / name, to / name)
    for name in (".venvs", "site/node_modules"):
        (to / name).symlink_to(checkout / name)
    return to


def environment(tree: Path) -> dict[str, str]:
    """Return the environment in which a copy is imported, and `tests.tools.markers` of this checkout."""
    plugin = WORK / "plugin"
    plugin.mkdir(parents=True, exist_ok=True)
    shutil.copy2(Path(markers.__file__), plugin / "qdot_markers.py")
    path = f"{tree}{os.pathsep}{plugin}"
    return {**os.environ, "PYTHONPATH": path, "CI": "true", "PYTHONDONTWRITEBYTECODE": "1"}


def pytest(
    tree: Path, *arguments: str, variables: Mapping[str, str], seconds: float | None = None
) -> "subprocess.CompletedProcess[str]":
    """Run pytest in a copy, so many seconds at most; it is ended by signal 9 then."""
    command = [sys.executable, "-m", "pytest", "-p", "qdot_markers", "-p", "no:cacheprovider", "-q", *arguments]
    with subprocess.Popen(
        command, cwd=tree, env={**environment(tree), **variables}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    ) as process:  # fmt: skip
        try:
            out, _ = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            out, _ = process.communicate()
            return subprocess.CompletedProcess(command, -9, out)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, 9)  # what a mistake left running
    return subprocess.CompletedProcess(command, process.returncode, out)


def record(checkout: Path, name: str, suite: str) -> None:
    """Run a suite once in a copy with marks at all places."""
    tree = copied(checkout, WORK / f"{name}-marked")
    of_file: dict[str, list[Mistake]] = defaultdict(list)
    for mistake in mistakes():
        if mistake.path.endswith(".py") and "contained" not in mistake.path:
            of_file[mistake.path].append(mistake)
    for path, here in of_file.items():
        text = (tree / path).read_text(encoding="utf-8")
        rows = {}
        for one in here:
            try:
                rows[one.number] = one.row(text)
            except ValueError as error:
                sys.stderr.write(f"{error}\n")
        (tree / path).write_text(marked(text, rows), encoding="utf-8")
    lines = WORK / f"{name}.marks"
    lines.unlink(missing_ok=True)
    variables = {markers.FILE: str(lines), "QDOT_KEPT": "0", **selection(suite)}
    ended = pytest(tree, "-n", "auto", "--dist", "loadgroup", "--durations=25", variables=variables)
    sys.stdout.write(ended.stdout[-2000:])


def collected(tree: Path, suite: str) -> set[str]:
    """Return the tests of a suite as they are now: what was recorded may have been left to `make whole` since."""
    return set(pytest(tree, "--collect-only", "-n", "0", variables=selection(suite)).stdout.splitlines())


def selection(suite: str) -> dict[str, str]:
    """Return the environment variables that choose a suite."""
    return {"QDOT_SUITE": suite} if suite else {}


def tried(mistake: Mistake, recorded: Recorded, tree: Path, suite: str) -> dict[str, object]:
    """Plant a mistake in a copy, run what may find it, and take it back; return what was seen."""
    path, start = tree / mistake.path, time.monotonic()
    try:
        text = path.read_text(encoding="utf-8")
        path.write_text(mistake.planted(text), encoding="utf-8")
    except (OSError, ValueError) as error:
        return {"number": mistake.number, "found": f"can't be planted any more: {error}", "seconds": 0}
    try:
        found = in_site(tree) if mistake.in_site else in_python(mistake, recorded, tree, suite)
    finally:
        path.write_text(text, encoding="utf-8")
    return {"number": mistake.number, "found": found, "seconds": round(time.monotonic() - start)}


def in_python(mistake: Mistake, recorded: Recorded, tree: Path, suite: str) -> str | None:
    """Return the test that finds a mistake in a module of Python, or None."""
    some: list[str] = []
    passed = 0.0
    for test in recorded.chosen(mistake):
        passed += recorded.seconds.get(test, 0.0)
        if passed > 60 * MINUTES or len(some) > MOST:
            break
        some.append(test)
    if not some:
        return None
    limit = int(LONGEST + 10 * max((recorded.seconds.get(test, 0.0) for test in some), default=0.0))
    options = {markers.LIMITS: str(limit), **selection(suite)}
    ended = pytest(tree, "-x", "-n", "0", *some, seconds=60 * MINUTES, variables=options)
    said = ended.stdout.splitlines()
    if ended.returncode == markers.HUNG:
        return next((line for line in said if line.startswith("hung: ")), "hung")
    if ended.returncode in (1, 2):
        failed = [line for line in said if line.startswith(("FAILED", "ERROR"))]
        return failed[0].split(" - ")[0] if failed else f"collection: {ended.stdout[-300:]}"
    return None if ended.returncode in (0, 5, -9) else f"exit {ended.returncode}: {ended.stdout[-300:]}"


def in_site(tree: Path) -> str | None:
    """Return what of the site's own tests finds a mistake in its scripts, or None."""
    site = tree / "site"
    steps = ("npx tsc --noEmit", "npx vitest run --bail 1", "npx vite build", "npm run --silent e2e")
    variables = {**environment(tree), "QDOT": str(Path(sys.executable).parent / "qdot")}
    for step in steps:
        try:
            ended = subprocess.run(
                step.split(), cwd=site, env=variables, capture_output=True, text=True, timeout=60 * MINUTES
            )
        except subprocess.TimeoutExpired:
            return f"hung: {step}"
        if ended.returncode:
            said = (ended.stdout + ended.stderr).splitlines()
            told = [line.strip() for line in said if any(sign in line for sign in ("FAIL", "✖", "not ok", "error TS"))]
            return f"{step}: {told[0][:160] if told else ended.stderr[-160:]}"
    return None


def results(name: str) -> dict[int, dict[str, object]]:
    """Return what was seen so far."""
    path = WORK / f"{name}.jsonl"
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return {row["number"]: row for row in map(json.loads, lines)}


def try_all(checkout: Path, name: str, suite: str, only: Sequence[int], jobs: int) -> Iterator[dict[str, object]]:
    """Try every mistake that was not tried before, on several copies, and keep what was seen of each at once."""
    done, recorded = results(name), Recorded.of(WORK / f"{name}.marks")
    todo = [one for one in mistakes() if (one.number in only) or (not only and one.number not in done)]
    trees = [copied(checkout, WORK / f"{name}-{job}") for job in range(jobs)]
    if suite and not all(mistake.in_site for mistake in todo):
        recorded = recorded.only(collected(trees[0], suite))
    free = list(trees)

    def one(mistake: Mistake) -> dict[str, object]:
        tree = free.pop()
        try:
            return tried(mistake, recorded, tree, suite)
        finally:
            free.append(tree)

    with ThreadPoolExecutor(jobs) as pool, (WORK / f"{name}.jsonl").open("a", encoding="utf-8") as file:
        for row in (ended.result() for ended in as_completed([pool.submit(one, mistake) for mistake in todo])):
            file.write(json.dumps(row) + "\n")
            file.flush()
            yield row


def write_results(rows: dict[int, dict[str, object]], suite: str) -> None:
    """Write which test finds each mistake into planted.md."""
    found = sum(bool(row["found"]) for row in rows.values())
    lines = [
        f"`make planted QDOT_SUITE={suite}` found {found} of {len(rows)}.",
        "",
        "| mistake | place | found by |",
        "|---|---|---|",
    ]
    for mistake in mistakes():
        result = str(rows[mistake.number]["found"] or "**nothing**") if mistake.number in rows else "not tried"
        test = result.removeprefix("FAILED ").removeprefix("tests/").replace("|", "&#124;").split("\n")[0][:150]
        lines.append(f"| {mistake.number} | {mistake.path}:{mistake.line} | {test} |")
    before, rest = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)
    table = "\n".join(lines)
    DOCUMENT.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{rest.split(END, 1)[1]}", encoding="utf-8")
    sys.stdout.write(f"{lines[0]}\n")


def main() -> int:
    """Do a step."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("step", choices=("record", "try", "show"))
    parser.add_argument("--suite", default="", choices=("", "check", "test", "whole"))
    parser.add_argument("--checkout", type=Path, default=ROOT)
    parser.add_argument("--name", default="")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    name = options.name or options.suite or "all"
    WORK.mkdir(exist_ok=True)
    if options.step == "record":
        record(options.checkout, name, options.suite)
    elif options.step == "try":
        only = [int(number) for number in options.only.split(",") if number]
        for row in try_all(options.checkout, name, options.suite, only, options.jobs):
            sys.stdout.write(f"{row['number']:>3} {row['seconds']:>4} s  {row['found'] or 'NOT FOUND'}\n")
            sys.stdout.flush()
    else:
        write_results(results(name), options.suite or "all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
