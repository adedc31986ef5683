"""Tests of the questions of `questions.statics`."""

from collections.abc import Callable, Iterator

from exercises.problem import Part
from exercises.verify.ground import Check, Ground

CHECKS: dict[str, Callable[[Ground, Part], Iterator[Check]]] = {}
