"""Make the page on the command line, with the texts of `--help`, from the program itself."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.render import render


@dataclass(frozen=True)
class Command:
    """A command: its full name, its usage, its help as HTML, and its parameters, each with its meaning."""

    name: str
    usage: str
    help_html: str
    parameters: tuple[tuple[str, str], ...]
    examples: str = ""


def list_commands(program: Any, name: str) -> Iterator[Command]:
    """Yield the commands of a program (Click's object) that is called `name`, including commands in groups."""
    if hasattr(program, "commands"):
        for command_name, command in program.commands.items():
            yield from list_commands(command, f"{name} {command_name}")
        return
    if program.hidden:
        return
    context = program.context_class(program, info_name=name)
    records = filter(None, (parameter.get_help_record(context) for parameter in program.params))
    usage = " ".join(program.collect_usage_pieces(context))
    parameters = tuple((parameter, " ".join(_remove_marks(meaning).split())) for parameter, meaning in records)
    help_html, examples = to_html(_remove_marks(program.help or "")), _remove_marks(program.epilog or "").strip()
    yield Command(name, f"{name} {usage}", help_html, parameters, examples)


def _remove_marks(text: str) -> str:
    r"""Return a help text without the marks that are not shown: \b (do not wrap) and the backslash before a bracket."""
    return text.replace("\b", "").replace("\\[", "[")


def render_reference(program: Any) -> str:
    """Return the body of the page, as HTML."""
    return render("site/commands.html.j2", commands=list(list_commands(program, "qdot")))
