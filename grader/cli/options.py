"""Define the arguments and options that several commands share."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot.exercises.arm.chain import CONVENTIONS, DEFAULT_CONVENTION, DEFAULT_TWIST_ORDER, TWIST_ORDERS
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_AXES, VARIATION_STEPS

Names = Iterable[str] | Callable[[], Iterable[str]]
"""A registry of names, or a function that returns one and is called only if a shell asks for completions."""


def complete_names(*registries: Names, separator: str = "", suffix: str = "") -> Callable[[str], list[str]]:
    """Return a function that lists the possible completions of a partly typed value.

    If `separator` is given, the value is a list of names, and the last name is completed. `suffix` is appended to each
    name. If no name fits, the shell completes file names.

    >>> complete_names(["position", "jacobian"], separator=",")("rank,ja"), complete_names(["scara"], suffix="/1")("s")
    (['rank,jacobian'], ['scara/1'])
    """

    def complete(incomplete: str) -> list[str]:
        earlier_names, last_separator, prefix = incomplete.rpartition(separator) if separator else ("", "", incomplete)
        names = (name for registry in registries for name in (registry() if callable(registry) else registry))
        return [f"{earlier_names}{last_separator}{name}{suffix}" for name in names if name.startswith(prefix)]

    return complete


def name_option(help: str, *flags: str, names: Names, metavar: str = "NAME", separator: str = "") -> Any:
    """Return an option whose value is one of `names`, or several names with the separator; Tab completes it."""
    return typer.Option(*flags, metavar=metavar, help=help, autocompletion=complete_names(names, separator=separator))


def name_argument(metavar: str, help: str, *names: Names, suffix: str = "") -> Any:
    """Return an argument whose value may be one of `names`, which Tab completes and extends by `suffix`."""
    return typer.Argument(metavar=metavar, help=help, autocompletion=complete_names(*names, suffix=suffix))


def _make_convention_option(default: str) -> Any:
    choices = f"{', '.join(CONVENTIONS)}; default: {default}{DEFAULT_CONVENTION}"
    return name_option(f"How arms are described: {choices}.", "--convention", names=CONVENTIONS)


def _make_twist_order_option(default: str) -> Any:
    text = f"Order of twists, for screw axes: {' or '.join(TWIST_ORDERS)}; default: {default}{DEFAULT_TWIST_ORDER}."
    return name_option(text, "--twist-order", names=TWIST_ORDERS, metavar="ORDER")


def _make_variation_option(default: str) -> Any:
    steps, names = ", ".join(VARIATION_STEPS), (*VARIATION_STEPS, *VARIATION_AXES)
    text = f"How much arms differ from the chapter's: {steps}, or axes as in lengths+base; default: {default}."
    return name_option(text, "--variation", names=names, metavar="TEXT", separator="+")


DEFAULT_FROM_ID = "that of the problem's id, else "
"""The beginning of a default value in help texts, for an option that a problem's id can also set."""
ConventionOption = Annotated[str, _make_convention_option(DEFAULT_FROM_ID)]
TwistOption = Annotated[str, _make_twist_order_option(DEFAULT_FROM_ID)]
SiteConventionOption = Annotated[str, _make_convention_option("")]
SiteTwistOption = Annotated[str, _make_twist_order_option("")]
VariationOption = Annotated[str, _make_variation_option(f"{DEFAULT_FROM_ID}{DEFAULT_VARIATION}")]
BankVariationOption = Annotated[str, _make_variation_option("that of assignment.toml")]
SiteVariationOption = Annotated[str, _make_variation_option("all steps in turn, or that of assignment.toml")]

FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="The assignment folder.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON.")]
SecondsOption = Annotated[float, typer.Option(min=1, help="Processor time for each notebook.")]
JobsOption = Annotated[
    int, typer.Option("--jobs", "-j", min=1, help="Number of parallel processes.", show_default="cores")
]


NO_FOLDER_HINT = "; there is no folder with that name either"
"""The end of the message about an argument that is neither a problem nor a folder."""
