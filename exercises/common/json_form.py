"""Frozen dataclasses written as JSON, and read from it: what a file holds has a type as soon as it is read."""

import json
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, TypeVar

from pydantic import TypeAdapter

Kind = TypeVar("Kind")


OPTIONAL = {"is_optional": True}
"""Metadata of a field that JSON leaves out where it is None."""


def as_json(value: Any) -> Any:
    """Return a value as `json.dumps` takes it: a dataclass as a dictionary with a key for each field, in their order.

    >>> from qdot.exercises.formula.identity import Certificate
    >>> as_json((Certificate("exact", 1),))
    [{'method': 'exact', 'points': 1, 'bound': None, 'counterexample': None}]
    """
    if is_dataclass(value):
        pairs = ((each, getattr(value, each.name)) for each in fields(value))
        return {each.name: as_json(has) for each, has in pairs if has is not None or each.metadata != OPTIONAL}
    if isinstance(value, Mapping):
        return {key: as_json(item) for key, item in value.items()}
    return [as_json(item) for item in value] if isinstance(value, tuple | list) else value


def from_json(kind: type[Kind], text: str | bytes) -> Kind:
    """Return the dataclass that a text holds; unknown keys are passed over. Raises ValueError for anything else."""
    made: Kind = _reader(kind).validate_python(json.loads(text))  # its own parser takes no lone surrogates
    return made


_reader: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)
