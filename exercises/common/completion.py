"""Complete names when a user presses Tab in a shell. If no name fits, the shell completes file names."""

from collections.abc import Callable, Iterable


def complete_names(
    *registries: Iterable[str] | Callable[[], Iterable[str]], separator: str = "", suffix: str = ""
) -> Callable[[str], list[str]]:
    """Return a function that lists the possible completions of a partly typed value.

    A registry is a collection of names, or a function that returns one; the function is called only if a shell asks for
    completions. If `separator` is given, the value is a list of names, and the last name is completed. `suffix` is
    appended to each name.

    >>> complete_names(["position", "jacobian"], separator=",")("rank,ja"), complete_names(["scara"], suffix="/1")("s")
    (['rank,jacobian'], ['scara/1'])
    """

    def complete(incomplete: str) -> list[str]:
        earlier_names, sign, prefix = incomplete.rpartition(separator) if separator else ("", "", incomplete)
        names = (name for registry in registries for name in (registry() if callable(registry) else registry))
        return [f"{earlier_names}{sign}{name}{suffix}" for name in names if name.startswith(prefix)]

    return complete
