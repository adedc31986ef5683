"""What a name in an answer stands for: a symbol, a function, a sine in the shorthand of robotics, a product of such."""

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.formula.vocabulary import LIMITS, VOCABULARY, pattern

FUNCTIONS: dict[str, str] = VOCABULARY["functions"]
"""Every function that an expression may call, under each name that is understood for it."""
SHORTHAND: dict[str, str] = VOCABULARY["shorthand"]
"""What c and s are before an angle."""
ARITY: dict[str, int] = VOCABULARY["arity"]
CONSTANTS = tuple(dict.fromkeys(VOCABULARY["constants"].values()))

LONGEST = LIMITS["name"]
"""No name of this field is longer."""

_SPELLED: dict[str, str] = VOCABULARY["constants"]
_LETTERS = str.maketrans(VOCABULARY["letters"])
_RATE, _SHORT = pattern("rate"), pattern("short")
_JOINTS: dict[str, list[str]] = VOCABULARY["joints"]
"""What q1, th1 and t1 may be, the first of them that is a symbol of the problem."""
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
    """Return a name in the form that the symbol tables use: no module, no Greek, no underscore before digits."""
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
    for whole in VOCABULARY["whole_numbers"]:  # kπ
        if name in (f"{whole}pi", f"pi{whole}"):
            return (NamePart("name", (whole,)), NamePart("name", ("pi",)))
    if name[0] in "ij" and name[1:] in known:  # e^(iθ1)
        return (NamePart("name", ("I",)), NamePart("name", (name[1:],)))
    return _split(name, known) or (NamePart("name", (name,)),)


def factors_of(raw: str, known: frozenset[str]) -> list[str]:
    """Return the factors of a product that is written with dots, as a1.a2.sin; [] if one is unknown, as in a1.subs.

    Without a problem, whose symbols are not known, they end with a digit.

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
    """Return the customary meaning of a name that is no symbol of the problem, or None."""
    short = _SHORT.fullmatch(name)
    if short is not None and (angles := _angles(short.group(3), known, short.group(2) or "theta")):
        return NamePart(SHORTHAND[short.group(1)], angles)
    rate = _RATE.fullmatch(name)
    if rate is not None:
        symbol = f"qd{next(filter(None, rate.groups()))}"
        return NamePart("name", (symbol,)) if symbol in known or not known else None
    if name in _SPELLED:
        return NamePart("name", (_SPELLED[name],))
    if not known:
        return None
    together = name.replace("_", "")
    for spelled, letter in VOCABULARY["spelled"].items():
        together = together.replace(spelled, letter)
    together = VOCABULARY["velocities"].get(together, together)
    for written in (together, together.lower()):
        if written in known:
            return NamePart("name", (written,))
    joint = _JOINT.fullmatch(together.lower())
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
    """Return the parts of names without spaces between them, as in a1c12 or costheta1; () if one is unknown."""
    if not known:
        return ()
    split: list[NamePart] = []
    at = 0
    for match in _words(known).finditer(name):
        if match.start() != at:
            return ()
        word, at = match.group(), match.end()
        piece = NamePart("name", (word,)) if word in known or word == "pi" else None
        function = FUNCTIONS.get(word) or SHORTHAND.get(word)
        piece = piece or (NamePart("function", (function,)) if function is not None else _usual_meaning(word, known))
        if piece is None:
            return ()
        split.append(piece)
    return tuple(split) if at == len(name) and len(split) > 1 else ()
