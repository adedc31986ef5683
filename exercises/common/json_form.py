"""Convert frozen dataclasses to JSON and back; types are checked when JSON is read."""

import json
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, TypeVar

from pydantic import TypeAdapter

Kind = TypeVar("Kind")


OMITTED_IF_NONE = {"is_optional": True}
"""Metadata of a field that is omitted from JSON if it is None."""


def as_json(value: Any) -> Any:
    """Return a value in a form for `json.dumps`: a dataclass becomes a dictionary of its fields, in their order.

    >>> from qdot.exercises.formula.equality import Certificate
    >>> as_json((Certificate("exact", 1),))
    [{'method': 'exact', 'points': 1, 'bound': None, 'counterexample': None}]
    """
    if is_dataclass(value):
        pairs = ((field, getattr(value, field.name)) for field in fields(value))
        included = [(f.name, content) for f, content in pairs if content is not None or f.metadata != OMITTED_IF_NONE]
        return {name: as_json(content) for name, content in included}
    if isinstance(value, Mapping):
        return {key: as_json(item) for key, item in value.items()}
    return [as_json(item) for item in value] if isinstance(value, tuple | list) else value


def from_json(dataclass_type: type[Kind], text: str | bytes) -> Kind:
    """Return an instance of a dataclass from its JSON text, without unknown keys. Raises ValueError for wrong types."""
    content = json.loads(text)  # pydantic's own parser rejects lone surrogates
    instance: Kind = _type_adapter(dataclass_type).validate_python(content)
    return instance


_type_adapter: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)
