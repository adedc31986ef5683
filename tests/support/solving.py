"""The output of `qdot solve` for an arm, in each of its formats."""

import json
from contextlib import nullcontext
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.solve.time_limited import write_solution

SECONDS = 600.0


def solve_to_text(chain: Chain, output_format: str) -> str:
    """Return the output of `qdot solve` for a chain in a format: "text", "latex" or "json"."""
    chunks: list[str] = []
    write_solution(Robot(chain), output_format, SECONDS, chunks.append, lambda _: nullcontext())
    return "".join(chunks)


def solve_to_json(chain: Chain) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(solve_to_text(chain, "json"))
    return content
