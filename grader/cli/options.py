"""Define the arguments and options that several commands share."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS
from qdot.exercises.common.completion import complete_names

Names = Iterable[str] | Callable[[], Iterable[str]]


def name_option(help: str, *flags: str, names: Names, metavar: str = "NAME", separator: str = "") -> Any:
    """Return an option whose value is one of `names`, or several names with the separator; Tab completes it."""
    return typer.Option(*flags, metavar=metavar, help=help, autocompletion=complete_names(names, separator=separator))


def name_argument(metavar: str, help: str, *names: Names, suffix: str = "") -> Any:
    """Return an argument whose value may be one of `names`, which Tab completes and extends by `suffix`."""
    return typer.Argument(metavar=metavar, help=help, autocompletion=complete_names(*names, suffix=suffix))


def _make_convention_option(default: str) -> Any:
    choices = f"{', '.join(CONVENTIONS)}; default: {default}{CONVENTIONS[0]}"
    return name_option(f"How arms are described: {choices}.", "--convention", names=CONVENTIONS)


def _make_twist_order_option(default: str) -> Any:
    text = f"Order of twists, for screw axes: {' or '.join(TWIST_ORDERS)}; default: {default}{TWIST_ORDERS[0]}."
    return name_option(text, "--twist-order", names=TWIST_ORDERS, metavar="ORDER")


DEFAULT_FROM_ID = "that of the problem's id, else "
"""The beginning of a default value in help texts, for an option that a problem's id can also set."""
ConventionOption = Annotated[str, _make_convention_option(DEFAULT_FROM_ID)]
TwistOrderOption = Annotated[str, _make_twist_order_option(DEFAULT_FROM_ID)]
SiteConventionOption = Annotated[str, _make_convention_option("")]
SiteTwistOrderOption = Annotated[str, _make_twist_order_option("")]

FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="The assignment folder.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON.")]
SecondsOption = Annotated[float, typer.Option(min=1, help="Processor time for each notebook.")]
JobsOption = Annotated[
    int, typer.Option("--jobs", "-j", min=1, help="Number of parallel processes.", show_default="cores")
]
