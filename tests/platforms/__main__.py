"""`python -m tests.platforms [NAME …]`: run each platform whose software the environment names, and keep records."""

import os
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from tests.platforms import PLATFORMS


def main(names: list[str]) -> int:
    """Run the platforms named, else all that can be run here; return the exit code: 1 where one fell short."""
    code = 0
    for name in names or PLATFORMS:
        variable = PLATFORMS[name]
        software = os.environ.get(variable, "")
        if not software:
            print(f"{name}: left out; {variable}=/path/of/its/software has it run")
            continue
        with tempfile.TemporaryDirectory(prefix=f"qdot-{name}-") as work:
            record = import_module(f"tests.platforms.{name}").run(Path(software), Path(work))
        record.keep(name)
        print(f"{name}: {record.software}")
        for what, count in record.counts.items():
            print(f"  {what}: {count.passed} of {count.of}{f' ({count.but})' if count.but else ''}")
            code |= not count.is_sound
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
