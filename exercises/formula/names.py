"""Determine the meaning of a name in an answer: a symbol, a function, a robotics shorthand, or a product of these."""

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.formula.vocabulary import LIMITS, VOCABULARY, pattern

FUNCTIONS: dict[str, str] = VOCABULARY["functions"]
"""Every function that an expression may call, by each of its accepted names."""
SHORTHAND: dict[str, str] = VOCABULARY["shorthand"]
"""The functions that c and s denote before an angle."""
ARITY: dict[str, int] = VOCABULARY["arity"]
CONSTANTS = tuple(dict.fromkeys(VOCABULARY["constants"].values()))

LONGEST = LIMITS["name"]
"""Maximum length of a name."""

_SPELLED: dict[str, str] = VOCABULARY["constants"]
_LETTERS = str.maketrans(VOCABULARY["letters"])
_RATE, _SHORT = pattern("rate"), pattern("short")
_JOINTS: dict[str, list[str]] = VOCABULARY["joints"]
"""Candidates for q, th, t and the like; the first one that, with its index, is a symbol of the problem is meant."""
_JOINT = re.compile(f"({'|'.join(_JOINTS)})([0-9]{{1,4}})")
_SUMS: list[str] = VOCABULARY["sums_of_angles"]
_GLUED: str = VOCABULARY["patterns"]["short_without_space"]


@dataclass(frozen=True)
class NamePart:
    """A part of a name: `kind` is "name", "function", or "sin", "cos" or "sum" of the angles in `parts`."""

    kind: str
    parts: tuple[str, ...]


@lru_cache(maxsize=4096)
def plain_name(name: str) -> str:
    """Return a name as in the symbol tables.

    Modules and underscores before digits are removed, and Greek letters are spelled out.
    """
    for module in VOCABULARY["modules"]:
        name = name.removeprefix(module)
    return re.sub("_(?=[0-9])", "", unicodedata.normalize("NFKC", name).translate(_LETTERS))


@lru_cache(maxsize=4096)
def pieces_of(raw: str, known: frozenset[str]) -> tuple[NamePart, ...]:
    """Return the parts of a name; `known` are the symbols of the problem, which take precedence.

    >>> [piece.kind for piece in pieces_of("a1c12", frozenset({"a1", "theta1", "theta2"}))]
    ['name', 'cos']
    """
    name = plain_name(raw)
    name = name if name in known or name.lower() not in known else name.lower()
    if name in known:
        return (NamePart("name", (name,)),)
    function = FUNCTIONS.get(name) or FUNCTIONS.get(name.lower())
    if function is not None:
        return (NamePart("function", (function,)),)
    part = _usual_meaning(name, known)
    if part is not None:
        return (part,)
    for integer_name in VOCABULARY["whole_numbers"]:  # kπ
        if name in (f"{integer_name}pi", f"pi{integer_name}"):
            return (NamePart("name", (integer_name,)), NamePart("name", ("pi",)))
    if name[0] in "ij" and name[1:] in known:  # e^(iθ1)
        return (NamePart("name", ("I",)), NamePart("name", (name[1:],)))
    return _split(name, known) or (NamePart("name", (name,)),)


def factors_of(raw: str, known: frozenset[str]) -> list[str]:
    """Return the factors of a product typed with dots, as a1.a2.sin; [] if a factor is unknown, as in a1.subs.

    If no symbols are known, because there is no problem, every name that ends with a digit is accepted.

    >>> factors_of("a1.c1", frozenset({"a1", "theta1"})), factors_of("np.sin", frozenset({"a1"}))
    (['a1', 'c1'], [])
    """
    if "." not in plain_name(raw):
        return []
    names = raw.split(".")
    pieces = [piece for name in names for piece in pieces_of(name, known)]
    symbols = {piece.parts[0] for piece in pieces if piece.kind == "name"} - {*CONSTANTS, *known}
    return names if all(not known and re.search("[0-9]$", symbol) for symbol in symbols) else []


def _usual_meaning(name: str, known: frozenset[str]) -> NamePart | None:
    """Return the usual meaning of a name that is not a symbol of the problem, or None."""
    shorthand = _SHORT.fullmatch(name)
    if shorthand is not None and (angles := _angles(shorthand.group(3), known, shorthand.group(2) or "theta")):
        return NamePart(SHORTHAND[shorthand.group(1)], angles)
    rate = _RATE.fullmatch(name)
    if rate is not None:
        symbol = f"qd{next(filter(None, rate.groups()))}"
        return NamePart("name", (symbol,)) if symbol in known or not known else None
    if name in _SPELLED:
        return NamePart("name", (_SPELLED[name],))
    if not known:
        return None
    joined_name = name.replace("_", "")
    for spelled, letter in VOCABULARY["spelled"].items():
        joined_name = joined_name.replace(spelled, letter)
    joined_name = VOCABULARY["velocities"].get(joined_name, joined_name)
    for candidate in (joined_name, joined_name.lower()):
        if candidate in known:
            return NamePart("name", (candidate,))
    joint = _JOINT.fullmatch(joined_name.lower())
    if joint is None:
        return None
    spelled, digits = joint.groups()
    if len(digits) == 1:
        candidates = (f"{symbol}{digits}" for symbol in _JOINTS[spelled])
        return next((NamePart("name", (symbol,)) for symbol in candidates if symbol in known), None)
    angles = _angles(digits, known) if spelled in _SUMS else ()
    return NamePart("sum", angles) if angles else None


def _angles(digits: str, known: frozenset[str], letter: str = "theta") -> tuple[str, ...]:
    """Return the angles in c12 or theta12 if all of them are known, or if no symbols are known."""
    angles = tuple(f"{letter}{digit}" for digit in digits)
    return angles if not known or all(angle in known for angle in angles) else ()


@lru_cache(maxsize=256)
def _words(known: frozenset[str]) -> re.Pattern[str]:
    words = sorted({*known, *FUNCTIONS, "pi"}, key=lambda word: (-len(word), word))
    return re.compile("|".join([*map(re.escape, words), _GLUED]))


def _split(name: str, known: frozenset[str]) -> tuple[NamePart, ...]:
    """Return the parts of names joined without spaces, as in a1c12 or costheta1; () if a part is unknown."""
    if not known:
        return ()
    pieces: list[NamePart] = []
    position = 0
    for match in _words(known).finditer(name):
        if match.start() != position:
            return ()
        word, position = match.group(), match.end()
        piece = NamePart("name", (word,)) if word in known or word == "pi" else None
        function = FUNCTIONS.get(word) or SHORTHAND.get(word)
        piece = piece or (NamePart("function", (function,)) if function is not None else _usual_meaning(word, known))
        if piece is None:
            return ()
        pieces.append(piece)
    return tuple(pieces) if position == len(name) and len(pieces) > 1 else ()
