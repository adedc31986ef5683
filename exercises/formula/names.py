"""Determine the meaning of a name in an answer: a symbol, a function, a robotics shorthand, or a product of these."""

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.formula.vocabulary import LIMITS, PATTERNS, VOCABULARY

FUNCTIONS: dict[str, str] = VOCABULARY["functions"]
"""Maps each name of a function that an answer may contain to the function's standard name."""
SHORTHAND: dict[str, str] = VOCABULARY["shorthand"]
"""Maps c and s to the functions that they denote before an angle, as in c12."""
ARITY: dict[str, int] = VOCABULARY["arity"]
"""Maps each function that doesn't have exactly one argument to its number of arguments."""
CONSTANTS = tuple(dict.fromkeys(VOCABULARY["constants"].values()))
"""The constants in formulas: pi, E and I."""

MAX_NAME_LENGTH = LIMITS["name"]
"""Maximum length of a name."""

_CONSTANT_NAMES: dict[str, str] = VOCABULARY["constants"]
_LETTER_TABLE = str.maketrans(VOCABULARY["letters"])
_JOINT_SYMBOLS: dict[str, list[str]] = VOCABULARY["joints"]
"""Maps q, th, t etc. to the letters that they may stand for. The first that gives a symbol of the problem is used."""
_JOINT_PATTERN = re.compile(f"({'|'.join(_JOINT_SYMBOLS)})([0-9]{{1,4}})")
_ANGLE_SUM_LETTERS: list[str] = VOCABULARY["sums_of_angles"]
"""Letters that, before several digits, denote a sum of angles, as in theta12."""
_SHORTHAND_WITHOUT_SPACE: str = VOCABULARY["patterns"]["shorthand_without_space"]


@dataclass(frozen=True)
class NamePart:
    """A part of a typed name, such as a1 or c12 in a1c12.

    If the `kind` is "name" or "function", `names` has one name. If the `kind` is "sum", "sin" or "cos", the part is the
    sum of the angles `names`, or the sine or cosine of this sum.
    """

    kind: str
    names: tuple[str, ...]


@lru_cache(maxsize=4096)
def normalize_name(name: str) -> str:
    """Return a name without a module such as np., without underscores before digits, with Greek letters spelled out."""
    name_in_module = name
    for module in VOCABULARY["modules"]:
        name_in_module = name_in_module.removeprefix(module)
    return re.sub("_(?=[0-9])", "", unicodedata.normalize("NFKC", name_in_module).translate(_LETTER_TABLE))


@lru_cache(maxsize=4096)
def split_name(typed_name: str, known_symbols: frozenset[str]) -> tuple[NamePart, ...]:
    """Return the parts of a name; `known_symbols` are the symbols of the problem, which take precedence.

    >>> [part.kind for part in split_name("a1c12", frozenset({"a1", "theta1", "theta2"}))]
    ['name', 'cos']
    """
    name = normalize_name(typed_name)
    name = name if name in known_symbols or name.lower() not in known_symbols else name.lower()
    if name in known_symbols:
        return (NamePart("name", (name,)),)
    if function := FUNCTIONS.get(name) or FUNCTIONS.get(name.lower()):
        return (NamePart("function", (function,)),)
    if part := _find_usual_meaning(name, known_symbols):
        return (part,)
    for integer_name in VOCABULARY["whole_numbers"]:  # kπ
        if name in (f"{integer_name}pi", f"pi{integer_name}"):
            return (NamePart("name", (integer_name,)), NamePart("name", ("pi",)))
    if name[0] in "ij" and name[1:] in known_symbols:  # e^(iθ1)
        return (NamePart("name", ("I",)), NamePart("name", (name[1:],)))
    return _split_joined_names(name, known_symbols) or (NamePart("name", (name,)),)


def split_dotted_product(typed_name: str, known_symbols: frozenset[str]) -> list[str]:
    """Return the factors of a product typed with dots, as in a1.a2.sin; [] if a factor is unknown, as in a1.subs.

    If no symbols are known, because there is no problem, every name that ends with a digit counts as known.

    >>> split_dotted_product("a1.c1", frozenset({"a1", "theta1"})), split_dotted_product("np.sin", frozenset({"a1"}))
    (['a1', 'c1'], [])
    """
    if "." not in normalize_name(typed_name):
        return []
    names = typed_name.split(".")
    parts = [part for name in names for part in split_name(name, known_symbols)]
    unknown_symbols = {part.names[0] for part in parts if part.kind == "name"} - {*CONSTANTS, *known_symbols}
    is_known = not unknown_symbols or (not known_symbols and all(symbol[-1].isdigit() for symbol in unknown_symbols))
    return names if is_known else []


def _find_usual_meaning(name: str, known_symbols: frozenset[str]) -> NamePart | None:
    """Return the usual meaning of a name such as c12 in robotics; None if it has none."""
    if (shorthand := PATTERNS["shorthand_name"].fullmatch(name)) is not None:
        function, letter, digits = shorthand.groups()
        if angles := _list_angles(digits, known_symbols, letter or "theta"):
            return NamePart(SHORTHAND[function], angles)
    rate = PATTERNS["rate"].fullmatch(name)
    if rate is not None:
        symbol = f"qd{next(filter(None, rate.groups()))}"
        return NamePart("name", (symbol,)) if symbol in known_symbols or not known_symbols else None
    if name in _CONSTANT_NAMES:
        return NamePart("name", (_CONSTANT_NAMES[name],))
    if not known_symbols:
        return None
    joined_name = name.replace("_", "")
    for letter_name, letter in VOCABULARY["spelled_letters"].items():
        joined_name = joined_name.replace(letter_name, letter)
    joined_name = VOCABULARY["velocities"].get(joined_name, joined_name)
    for candidate in (joined_name, joined_name.lower()):
        if candidate in known_symbols:
            return NamePart("name", (candidate,))
    joint = _JOINT_PATTERN.fullmatch(joined_name.lower())
    if joint is None:
        return None
    joint_letters, digits = joint.groups()
    if len(digits) == 1:
        candidates = (f"{symbol}{digits}" for symbol in _JOINT_SYMBOLS[joint_letters])
        return next((NamePart("name", (symbol,)) for symbol in candidates if symbol in known_symbols), None)
    angles = _list_angles(digits, known_symbols) if joint_letters in _ANGLE_SUM_LETTERS else ()
    return NamePart("sum", angles) if angles else None


def _list_angles(digits: str, known_symbols: frozenset[str], letter: str = "theta") -> tuple[str, ...]:
    """Return the angles in c12 or theta12; () if symbols are known, and an angle is not among them."""
    angles = tuple(f"{letter}{digit}" for digit in digits)
    return angles if not known_symbols or all(angle in known_symbols for angle in angles) else ()


@lru_cache(maxsize=256)
def _compile_word_pattern(known_symbols: frozenset[str]) -> re.Pattern[str]:
    """Return a pattern for symbols, functions and shorthand, the longest words first."""
    words = sorted({*known_symbols, *FUNCTIONS, "pi"}, key=lambda word: (-len(word), word))
    return re.compile("|".join([*map(re.escape, words), _SHORTHAND_WITHOUT_SPACE]))


def _split_joined_names(name: str, known_symbols: frozenset[str]) -> tuple[NamePart, ...]:
    """Return the parts of names joined without spaces, as in a1c12 or costheta1; () if a part is unknown."""
    if not known_symbols:
        return ()
    parts: list[NamePart] = []
    position = 0
    for match in _compile_word_pattern(known_symbols).finditer(name):
        if match.start() != position:
            return ()
        word, position = match.group(), match.end()
        function = FUNCTIONS.get(word) or SHORTHAND.get(word)
        if word in known_symbols or word == "pi":
            part: NamePart | None = NamePart("name", (word,))
        else:
            part = NamePart("function", (function,)) if function else _find_usual_meaning(word, known_symbols)
        if part is None:
            return ()
        parts.append(part)
    return tuple(parts) if position == len(name) and len(parts) > 1 else ()
