"""Define `QdotError`, the one exception whose message is for the user, and make common messages."""

import errno
from collections.abc import Iterator, Sequence
from contextlib import contextmanager


class QdotError(Exception):
    """Bad input, described in one sentence: what is wrong, where, and what is expected.

    The command line prints the message without a traceback, and exits with code 2.
    """


class ErrorList:
    """Collects errors in independent parts of an input, so that the user sees all of them at once."""

    def __init__(self) -> None:
        self._messages: list[str] = []

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Keep a QdotError that is raised in the block."""
        try:
            yield
        except QdotError as error:
            self._messages.append(str(error))

    def raise_all(self) -> None:
        """Raise a QdotError with the messages so far, one in each line, if there are any."""
        if self._messages:
            raise QdotError("\n".join(dict.fromkeys(self._messages)))


class Reason(str):
    """The reason why something is impossible, for functions that return it instead of a result."""


class KeyReason(Reason):
    """The reason why the value of a `key` in a file is impossible; "given.m" is the key m in the table `given`."""

    key: str

    def __new__(cls, key: str, text: str) -> "KeyReason":
        """Return the reason why the value of a key is impossible."""
        reason = super().__new__(cls, text)
        reason.key = key
        return reason

    def __reduce__(self) -> tuple[type["KeyReason"], tuple[str, str]]:
        """Return a function and its arguments; `pickle` calls it to create the reason in another process."""
        return KeyReason, (self.key, str(self))


def make_open_files_error(error: BaseException) -> QdotError | None:
    """Return the error to show if this process has reached its limit of open files; None for any other error.

    >>> print(make_open_files_error(OSError(errno.EMFILE, "Too many open files")))
    this process has reached its limit of open files; raise it, as with 'ulimit -n 1024', and run the same command again
    """
    if not isinstance(error, OSError) or error.errno != errno.EMFILE:
        return None
    advice = "raise it, as with 'ulimit -n 1024', and run the same command again"
    return QdotError(f"this process has reached its limit of open files; {advice}")


def make_name_error(kind: str, name: str, known_names: Sequence[str], suggestion: str = "") -> QdotError:
    """Return the error for a name that is not in a list; its message has the list and a suggestion.

    Without a `suggestion`, the most similar name is suggested.

    >>> print(make_name_error("family", "scra", ["planar-2r", "scara"]))
    unknown family 'scra' (did you mean 'scara'?); known: planar-2r, scara
    """
    shown_suggestion = suggestion or find_most_similar(name, known_names)
    hint = f" (did you mean {shown_suggestion!r}?)" if shown_suggestion else ""
    return QdotError(f"unknown {kind} {name!r}{hint}; known: {', '.join(known_names)}")


def count_noun(number: int, noun: str) -> str:
    """Return a number with a noun in the singular or plural; the plural must end with s.

    >>> count_noun(1, "student"), count_noun(3, "student")
    ('1 student', '3 students')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def write_first(names: Sequence[str], shown_count: int) -> str:
    """Return the first `shown_count` names as text, and how many more there are.

    >>> write_first(["ada", "bo", "cy", "di"], 2)
    'ada, bo and 2 more'
    """
    others_text = f" and {len(names) - shown_count} more" if len(names) > shown_count else ""
    return ", ".join(names[:shown_count]) + others_text


def shorten(text: str, kept_length: int) -> str:
    """Return the first `kept_length` characters of a text; " …" shows that some are left out."""
    return text if len(text) <= kept_length else f"{text[:kept_length]} …"


def find_most_similar(name: str, known_names: Sequence[str]) -> str:
    """Return the known name that is most similar to an unknown name, or whose initials are this name; "" if none is.

    >>> find_most_similar("scra", ["planar-2r", "scara"]), find_most_similar("x", ["planar-2r", "scara"])
    ('scara', '')
    >>> find_most_similar("cc", ["canvas", "common-cartridge"])
    'common-cartridge'
    """
    import difflib

    named_by_initials = [
        known_name for known_name in known_names if "".join(word[:1] for word in known_name.split("-")) == name
    ]
    similar_names = difflib.get_close_matches(name, known_names, n=1)
    return next(iter([*similar_names, *(named_by_initials if len(name) > 1 else [])]), "")
