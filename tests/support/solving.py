"""What `qdot solve` writes for an arm, in each of its forms."""

import json
from contextlib import nullcontext
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.solve.time_limited import write_solution

SECONDS = 600.0


def written(chain: Chain, form: str) -> str:
    """Return what `qdot solve` writes for a chain: "text", "latex" or "json"."""
    said: list[str] = []
    write_solution(Robot(chain), form, SECONDS, said.append, lambda _: nullcontext())
    return "".join(said)


def written_data(chain: Chain) -> dict[str, Any]:
    """Return what `qdot solve` writes for a chain as JSON."""
    content: dict[str, Any] = json.loads(written(chain, "json"))
    return content
