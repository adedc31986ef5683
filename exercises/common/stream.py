"""Generate the random numbers behind every problem: SHAKE-256 of a text, the same on every machine permanently.

`random` and `numpy.random` guarantee the same numbers only for some methods and releases, but a hash is a standard. A
stream is always passed as an argument and never stored globally.
"""

import hashlib
import hmac
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")

_BLOCK = 1024


class Stream:
    """A random number generator whose numbers depend only on the text `seed`.

    >>> Stream("planar-2r/7").integer_below(1000)
    424
    """

    def __init__(self, seed: str) -> None:
        self._seed = seed.encode()
        self._block = 0
        self._buffer = b""

    def take_bytes(self, count: int) -> bytes:
        """Return the next `count` bytes."""
        while len(self._buffer) < count:
            block = self._seed + b"\x00" + self._block.to_bytes(8, "big")
            self._buffer += hashlib.shake_256(block).digest(_BLOCK)
            self._block += 1
        chunk, self._buffer = self._buffer[:count], self._buffer[count:]
        return chunk

    def substream(self, name: str) -> "Stream":
        """Return an independent stream with this name: it doesn't depend on what was taken from this stream."""
        return Stream(f"{self._seed.decode()}/{name}")

    def integer_below(self, n: int) -> int:
        """Return an integer from 0 to n - 1, all equally likely (rejection sampling, no modulo bias)."""
        if n < 1:
            raise ValueError(f"below() takes a positive number, not {n}")
        limit = (1 << 64) - (1 << 64) % n
        while True:
            value = int.from_bytes(self.take_bytes(8), "big")
            if value < limit:
                return value % n

    def choice(self, items: Sequence[T]) -> T:
        """Return one of the items, all equally likely."""
        return items[self.integer_below(len(items))]

    def integer(self, low: int, high: int) -> int:
        """Return an integer from `low` to `high`, both included."""
        return low + self.integer_below(high - low + 1)

    def nonzero_integer(self, maximum: int) -> int:
        """Return a nonzero integer from -maximum to maximum, all equally likely."""
        return self.choice([k for k in range(-maximum, maximum + 1) if k])

    def permutation(self, items: Sequence[T]) -> list[T]:
        """Return the items in random order (Fisher-Yates)."""
        out = list(items)
        for i in range(len(out) - 1, 0, -1):
            j = self.integer_below(i + 1)
            out[i], out[j] = out[j], out[i]
        return out

    def uniform(self, low: float, high: float) -> float:
        """Return a number in [low, high), with 53 random bits."""
        unit: float = (int.from_bytes(self.take_bytes(8), "big") >> 11) / (1 << 53)
        return low + (high - low) * unit


def derive_seed(secret: str, *parts: str) -> int:
    """Return a 63-bit seed from some names, which can't be computed without the secret (HMAC-SHA-256).

    The names are joined by a null byte, which no name may contain, so that ("a", "bc") and ("ab", "c") differ.
    """
    digest = hmac.new(secret.encode(), "\x00".join(parts).encode(), hashlib.sha256).digest()
    return int.from_bytes(digest[:8], "big") >> 1
