"""The one exception that a user is meant to read."""

import errno


class QdotError(Exception):
    """Bad input, told in one sentence: what was wrong, where, and what would be right.

    The command line prints the message and leaves with code 2; no traceback is shown.
    """


def of_machine(error: BaseException) -> QdotError | None:
    """Return what to tell of an error for which this machine's limit of open files is to blame; None of any other.

    >>> print(of_machine(OSError(errno.EMFILE, "Too many open files")))
    this process may open no more files; allow more, as with 'ulimit -n 1024', and run the same command again
    """
    if not isinstance(error, OSError) or error.errno != errno.EMFILE:
        return None
    return QdotError(
        "this process may open no more files; allow more, as with 'ulimit -n 1024', and run the same command again"
    )


def unknown(what: str, name: str, known: list[str] | tuple[str, ...]) -> QdotError:
    """Return the error for a name that is not in a list, with the list and the likeliest meant.

    >>> print(unknown("family", "scra", ["planar-2r", "scara"]))
    unknown family 'scra' (did you mean 'scara'?); known: planar-2r, scara
    """
    meant = likeliest(name, known)
    hint = f" (did you mean {meant!r}?)" if meant else ""
    return QdotError(f"unknown {what} {name!r}{hint}; known: {', '.join(known)}")


def likeliest(name: str, known: list[str] | tuple[str, ...]) -> str:
    """Return the known name that is most like one that isn't known; nothing where none is like it.

    >>> likeliest("scra", ["planar-2r", "scara"]), likeliest("x", ["planar-2r", "scara"])
    ('scara', '')
    """
    import difflib

    return next(iter(difflib.get_close_matches(name, known, n=1)), "")
