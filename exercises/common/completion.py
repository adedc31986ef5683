"""What the Tab key makes of a value that is begun: names of a registry. Where none fits, a shell completes files."""

from collections.abc import Callable, Iterable


def among(
    *registries: Iterable[str] | Callable[[], Iterable[str]], between: str = "", behind: str = ""
) -> Callable[[str], list[str]]:
    """Return what completes a value to names; of several with `between` between them, the last.

    A registry that is a function is asked when a shell asks.

    >>> among(["position", "jacobian"], between=",")("rank,ja"), among(["scara"], behind="/1")("s")
    (['rank,jacobian'], ['scara/1'])
    """

    def completed(incomplete: str) -> list[str]:
        before, sign, begun = incomplete.rpartition(between) if between else ("", "", incomplete)
        names = (name for one in registries for name in (one() if callable(one) else one))
        return [f"{before}{sign}{name}{behind}" for name in names if name.startswith(begun)]

    return completed
