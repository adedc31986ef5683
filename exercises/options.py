"""Options of several commands that need to know what arms are told in."""

from typing import Annotated

import typer

from exercises.arm.chain import CONVENTIONS

ConventionOption = Annotated[
    str,
    typer.Option(
        "--convention",
        metavar="NAME",
        help=f"How arms are told: {', '.join(CONVENTIONS)}; default: what the id says, else {CONVENTIONS[0]}.",
    ),
]
