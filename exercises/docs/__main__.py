"""`python -m qdot.exercises.docs`: write the generated pages into docs/ of the checkout."""

from pathlib import Path

from qdot.exercises.common.console import say
from qdot.exercises.docs import write

if __name__ == "__main__":
    for path in write(Path(__file__).resolve().parents[2] / "docs"):
        say(f"wrote {path.name}")
