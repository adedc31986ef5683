"""What the Tab key makes of a value that is begun: names of a registry. Where none fits, a shell completes files."""

from collections.abc import Callable, Iterable


def complete_names(
    *registries: Iterable[str] | Callable[[], Iterable[str]], between: str = "", behind: str = ""
) -> Callable[[str], list[str]]:
    """Return what completes a value to names; of several with `between` between them, the last.

    A registry that is a function is asked when a shell asks.

    >>> complete_names(["position", "jacobian"], between=",")("rank,ja"), complete_names(["scara"], behind="/1")("s")
    (['rank,jacobian'], ['scara/1'])
    """

    def complete(incomplete: str) -> list[str]:
        before, sign, begun = incomplete.rpartition(between) if between else ("", "", incomplete)
        names = (name for registry in registries for name in (registry() if callable(registry) else registry))
        return [f"{before}{sign}{name}{behind}" for name in names if name.startswith(begun)]

    return complete
