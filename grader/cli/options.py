"""Options of several commands that need to know what arms are told in."""

from typing import Annotated, Any

import typer

from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS
from qdot.exercises.common.completion import complete_names


def _convention(default: str) -> Any:
    return typer.Option(
        "--convention",
        metavar="NAME",
        help=f"How arms are told: {', '.join(CONVENTIONS)}; default: {default}{CONVENTIONS[0]}.",
        autocompletion=complete_names(CONVENTIONS),
    )


def _twist_order(default: str) -> Any:
    return typer.Option(
        "--twist-order",
        metavar="ORDER",
        help=f"Of arms told by their axes: {' or '.join(TWIST_ORDERS)}; default: {default}{TWIST_ORDERS[0]}.",
        autocompletion=complete_names(TWIST_ORDERS),
    )


OF_ID = "what the id says, else "
ConventionOption = Annotated[str, _convention(OF_ID)]
TwistOrderOption = Annotated[str, _twist_order(OF_ID)]
SiteConventionOption = Annotated[str, _convention("")]
SiteTwistOrderOption = Annotated[str, _twist_order("")]
