"""`python -m tests.platforms [NAME …]`: run each platform whose software is there, and keep records."""

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
    """Run the platforms named, else all that can be run here; return the exit code: 1 where one fell short."""
    short = []
    for name in names or PLATFORMS:
        variable = PLATFORMS[name]
        software = software_of(variable)
        if software is None:
            print(f"{name}: left out; {variable}=/path/of/its/software has it run")
            continue
        began, used = time.monotonic(), _processor()
        try:
            with tempfile.TemporaryDirectory(prefix=f"qdot-{name}-") as work:
                record: Record = import_module(f"tests.platforms.{name}").run(software, Path(work))
        except Exception:  # one that can't be run here keeps no other from its run
            print(f"{name}: not run to its end\n{traceback.format_exc()}", flush=True)
            short.append(name)
            continue
        record.keep(name)
        print(f"{name}: {record.software}")
        for what, count in record.counts.items():
            print(f"  {what}: {count.passed} of {count.of}{f' ({count.but})' if count.but else ''}")
        print(f"  in {time.monotonic() - began:.0f} s, {_processor() - used:.0f} s of processor time", flush=True)
        if not all(count.is_sound for count in record.counts.values()):
            short.append(name)
    if short:
        print(f"fell short: {', '.join(short)}")
    return int(bool(short))


def software_of(variable: str) -> Path | None:
    """Return the copy of the software that the environment names, else the one that is installed here, if any."""
    named = os.environ.get(variable)
    if named:
        return Path(named)
    installed = ROOT / INSTALLED[variable] if variable in INSTALLED else None
    return installed if installed is not None and installed.exists() else None


def _processor() -> float:
    """Return the seconds of processor time of all programs that a run has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN), resource.getrusage(resource.RUSAGE_SELF)
    return sum(one.ru_utime + one.ru_stime for one in used)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
