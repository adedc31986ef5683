"""Convert frozen dataclasses to JSON and back; types are checked when JSON is read."""

import json
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, TypeVar

from pydantic import TypeAdapter

Dataclass = TypeVar("Dataclass")

OMITTED_IF_NONE = {"is_optional": True}
"""Metadata of a field that is omitted from JSON if it is None."""


def to_jsonable(value: Any) -> Any:
    """Return a value in a form for `json.dumps`: a dataclass becomes a dictionary of its fields, in their order.

    The metadata of a field may contain an "alias", the key of the field in JSON.

    >>> from qdot.exercises.formula.equality import Certificate
    >>> to_jsonable((Certificate("exact", 1),))
    [{'method': 'exact', 'points': 1, 'bound': None, 'counterexample': None}]
    """
    if is_dataclass(value):
        shown_fields = [
            field
            for field in fields(value)
            if field.metadata != OMITTED_IF_NONE or getattr(value, field.name) is not None
        ]
        return {
            field.metadata.get("alias", field.name): to_jsonable(getattr(value, field.name)) for field in shown_fields
        }
    if isinstance(value, Mapping):
        return {key: to_jsonable(item) for key, item in value.items()}
    return [to_jsonable(item) for item in value] if isinstance(value, tuple | list) else value


def parse_dataclass(dataclass_type: type[Dataclass], text: str | bytes) -> Dataclass:
    """Return an instance of a dataclass from its JSON text, without unknown keys. Raises ValueError for wrong types."""
    content = json.loads(text)  # pydantic's own parser rejects lone surrogates
    instance: Dataclass = _make_type_adapter(dataclass_type).validate_python(content)
    return instance


_make_type_adapter: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)
