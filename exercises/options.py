"""Options of several commands that need to know what arms are told in."""

from typing import Annotated

import typer

from exercises.arm.chain import CONVENTIONS, TWIST_ORDERS
from exercises.completion import among

ConventionOption = Annotated[
    str,
    typer.Option(
        "--convention",
        metavar="NAME",
        help=f"How arms are told: {', '.join(CONVENTIONS)}; default: what the id says, else {CONVENTIONS[0]}.",
        autocompletion=among(CONVENTIONS),
    ),
]

TwistOrderOption = Annotated[
    str,
    typer.Option(
        "--twist-order",
        metavar="ORDER",
        help=f"Of arms told by their axes: {' or '.join(TWIST_ORDERS)}; default: what the id says, else "
        f"{TWIST_ORDERS[0]}.",
        autocompletion=among(TWIST_ORDERS),
    ),
]
