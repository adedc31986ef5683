"""`python -m tests.platforms [NAME …]`: run each platform whose software is found, and save the records."""

import os
import resource
import sys
import tempfile
import time
import traceback
from importlib import import_module
from pathlib import Path

from tests.platforms import INSTALLED, PLATFORMS
from tests.platforms.records import Record
from tests.support import ROOT


def main(names: list[str]) -> int:
    """Run the named platforms, or all whose software is found; return the exit code, 1 if a check or a run failed."""
    failed = []
    for name in names or PLATFORMS:
        variable = PLATFORMS[name]
        software = find_software(variable)
        if software is None:
            print(f"{name}: skipped; set {variable} to the path of its software to run it")
            continue
        start, start_processor = time.monotonic(), _measure_processor_time()
        try:
            with tempfile.TemporaryDirectory(prefix=f"qdot-{name}-") as work:
                record: Record = import_module(f"tests.platforms.{name}").run(software, Path(work))
        except Exception:  # the other platforms still run
            print(f"{name}: the run failed\n{traceback.format_exc()}", flush=True)
            failed.append(name)
            continue
        record.save(name)
        print(f"{name}: {record.software}")
        for check, count in record.counts.items():
            print(f"  {check}: {count.passed} of {count.of}{f' ({count.but})' if count.but else ''}")
        elapsed, processor_time = time.monotonic() - start, _measure_processor_time() - start_processor
        print(f"  in {elapsed:.0f} s, {processor_time:.0f} s of processor time", flush=True)
        if not all(count.all_passed_or_excused for count in record.counts.values()):
            failed.append(name)
    if failed:
        print(f"failed: {', '.join(failed)}")
    return int(bool(failed))


def find_software(variable: str) -> Path | None:
    named = os.environ.get(variable)
    if named:
        return Path(named)
    installed = ROOT / INSTALLED[variable] if variable in INSTALLED else None
    return installed if installed is not None and installed.exists() else None


def _measure_processor_time() -> float:
    """Return the seconds of processor time of this process and of its child processes that have ended."""
    usages = resource.getrusage(resource.RUSAGE_CHILDREN), resource.getrusage(resource.RUSAGE_SELF)
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
