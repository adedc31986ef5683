"""What a name in an answer stands for: a symbol, a function, a sine in the shorthand of robotics, a product of such."""

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tan", "cot", "sec", "csc", "asin", "acos", "atan", "acot")},
    **{name: name for name in ("sinh", "cosh", "tanh", "exp", "log", "sqrt", "atan2", "sign")},
    **{"abs": "abs", "Abs": "abs", "ln": "log", "fabs": "abs"},
    **{"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
    **{"deg2rad": "radians", "radians": "radians"},
}
"""Every function that an expression may call, under each name that is understood for it."""

ARITY = {"atan2": 2}
CONSTANTS = ("pi", "E", "I")

LONGEST = 60
"""No name of this field is longer."""

_GREEK = {"θ": "theta", "ϑ": "theta", "α": "alpha", "β": "beta", "ω": "w", "π": "pi", "φ": "phi"}
_MODULES = ("np.", "numpy.", "math.", "sp.", "sympy.", "sym.")
_RATE = re.compile(
    r"(?:theta|th|q|d)_?dot_?(\d)|(?:theta|th|q|d)_?(\d)_?dot|dot_?(?:theta|th|q|d)_?(\d)"
    r"|d(?:theta|th|q)_?(\d)|(?:theta|th)d_?(\d)|(?:theta|th|q)_?(\d)_?d|qd_?(\d)"
)
_SHORT = re.compile(r"([csCS])_?\{?(\d{1,4})\}?")


@dataclass(frozen=True)
class Piece:
    """A part of a name: `kind` is "name", "function", or "sin", "cos" or "sum" of the angles in `parts`."""

    kind: str
    parts: tuple[str, ...]


@lru_cache(maxsize=4096)
def plain_name(name: str) -> str:
    """Return a name in the form that the symbol tables use: no module, no Greek, no underscore before digits."""
    for module in _MODULES:
        name = name.removeprefix(module)
    name = "".join(_GREEK.get(ch, ch) for ch in unicodedata.normalize("NFKC", name))
    return re.sub(r"_(?=\d)", "", name)


@lru_cache(maxsize=4096)
def pieces_of(raw: str, known: frozenset[str]) -> tuple[Piece, ...]:
    """Return what a name stands for, `known` being the symbols of the problem, which win over everything else.

    >>> [piece.kind for piece in pieces_of("a1c12", frozenset({"a1", "theta1", "theta2"}))]
    ['name', 'cos']
    """
    name = plain_name(raw)
    name = name if name in known or name.lower() not in known else name.lower()
    if name in known:
        return (Piece("name", (name,)),)
    function = FUNCTIONS.get(name) or FUNCTIONS.get(name.lower())
    if function is not None:
        return (Piece("function", (function,)),)
    one = _one(name, known)
    if one is not None:
        return (one,)
    return _split(name, known) or (Piece("name", (name,)),)


def _one(name: str, known: frozenset[str]) -> Piece | None:
    """Return what a name that is no symbol of the problem means by custom; None where it means nothing."""
    short = _SHORT.fullmatch(name)
    if short is not None and (angles := _angles(short.group(2), known)):
        return Piece("cos" if short.group(1) in "cC" else "sin", angles)
    rate = _RATE.fullmatch(name)
    if rate is not None:
        symbol = f"qd{next(filter(None, rate.groups()))}"
        return Piece("name", (symbol,)) if symbol in known or not known else None
    if name in ("e", "i", "j"):
        return Piece("name", ("E" if name == "e" else "I",))
    if not known:
        return None
    together = re.sub(r"_", "", name).replace("omega", "w")
    if together in known:
        return Piece("name", (together,))
    joint = re.fullmatch(r"(?:q|th|t|theta)(\d{1,4})", together)
    if joint is None:
        return None
    if len(joint.group(1)) == 1:
        own = [symbol for symbol in (f"theta{joint.group(1)}", f"d{joint.group(1)}") if symbol in known]
        return Piece("name", (own[0],)) if own and (own[0][0] == "t" or together[0] == "q") else None
    angles = _angles(joint.group(1), known) if together.startswith("th") else ()
    return Piece("sum", angles) if angles else None


def _angles(digits: str, known: frozenset[str]) -> tuple[str, ...]:
    """Return the angles that c12 or theta12 counts, if all are known, or nothing is."""
    angles = tuple(f"theta{digit}" for digit in digits)
    return angles if not known or all(angle in known for angle in angles) else ()


@lru_cache(maxsize=256)
def _words(known: frozenset[str]) -> re.Pattern[str]:
    words = sorted({*known, *FUNCTIONS, "pi"}, key=lambda word: (-len(word), word))
    return re.compile("|".join([*map(re.escape, words), r"[csCS]\d{1,4}"]))


def _split(name: str, known: frozenset[str]) -> tuple[Piece, ...]:
    """Return the pieces of names without a space between, as a1c12 or costheta1; nothing if a part means nothing."""
    if not known:
        return ()
    found: list[Piece] = []
    at = 0
    for match in _words(known).finditer(name):
        if match.start() != at:
            return ()
        word, at = match.group(), match.end()
        piece = Piece("name", (word,)) if word in known or word == "pi" else None
        piece = piece or (Piece("function", (FUNCTIONS[word],)) if word in FUNCTIONS else _one(word, known))
        if piece is None:
            return ()
        found.append(piece)
    return tuple(found) if at == len(name) and len(found) > 1 else ()
