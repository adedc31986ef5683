"""Read the table [paper] of assignment.toml: what an exam on paper says above its first problem."""

import base64
import datetime
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.expected_forms import PAPER_FORMS, check_keys
from qdot.exercises.common.errors import ErrorList, QdotError
from qdot.exercises.questions.custom.texts import check_formulas

IMAGE_TYPES = {"png": "image/png", "jpg": "image/jpeg", "jpeg": "image/jpeg", "svg": "image/svg+xml"}
"""Maps the ending of a logo's file to the media type."""
IMAGE_STARTS = {"png": b"\x89PNG", "jpg": b"\xff\xd8", "jpeg": b"\xff\xd8", "svg": b"<"}
"""Maps the ending of a logo's file to the bytes with which the content begins."""
MAX_LOGO_SIZE, MAX_TEXT_LENGTH = 2_000_000, 5000
"""Maximum size of a logo in bytes, and of a text in characters."""


@dataclass(frozen=True)
class Logo:
    """An image file; `extension` is a key of `IMAGE_TYPES`."""

    content: bytes
    extension: str

    @property
    def file_name(self) -> str:
        """The name under which the image is saved beside an exported file."""
        return f"logo.{self.extension}"

    @property
    def data_uri(self) -> str:
        """The image as a data URI, for the `src` of an <img>."""
        return f"data:{IMAGE_TYPES[self.extension]};base64,{base64.b64encode(self.content).decode()}"


@dataclass(frozen=True)
class FrontPage:
    """What an exam says above its first problem, besides its title. `instructions` is Markdown."""

    instructions: str = ""
    date: str = ""
    time_allowed: str = ""
    logo: Logo | None = None


def read_front_page(table: Mapping[str, Any], folder: Path) -> FrontPage:
    """Return the front page that the table [paper] describes; its logo is a file in the folder. Raises QdotError.

    >>> read_front_page({"date": datetime.date(2027, 2, 11), "time_allowed": "90 minutes"}, Path()).date
    '11 February 2027'
    """
    errors, texts, logo = ErrorList(), dict[str, str](), None
    with errors.collect():
        check_keys(table, PAPER_FORMS)
    for name, value in table.items():
        with errors.collect():
            if name in PAPER_FORMS and name != "logo":
                texts[name] = _read_text(name, value)
    with errors.collect():
        logo = _read_logo(table["logo"], folder) if "logo" in table else None
    errors.raise_all()
    return FrontPage(**texts, logo=logo)


def _read_text(name: str, value: object) -> str:
    if name == "date" and type(value) is datetime.date:
        return f"{value.day} {value:%B %Y}"
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_TEXT_LENGTH:
        raise QdotError(f"{name}: {PAPER_FORMS[name]}")
    if name == "instructions":
        try:
            check_formulas(value)
        except QdotError as error:
            raise QdotError(f"{name}: {error}") from None
    return value.strip()


def _read_logo(name: object, folder: Path) -> Logo:
    extension = str(name).rpartition(".")[2].lower()
    if not isinstance(name, str) or extension not in IMAGE_TYPES:
        raise QdotError(f"logo: {PAPER_FORMS['logo']}")
    path = folder / name
    try:
        is_too_large = path.stat().st_size > MAX_LOGO_SIZE
        content = b"" if is_too_large else path.read_bytes()
    except OSError as error:
        raise QdotError(f"logo: can't read {path}: {error.strerror}") from None
    if is_too_large:
        raise QdotError(f"logo: {path} has more than {MAX_LOGO_SIZE // 1_000_000} MB; make the image smaller")
    if not content.lstrip(b"\xef\xbb\xbf \r\n").startswith(IMAGE_STARTS[extension]):
        raise QdotError(f"logo: {path} is not an image of the type .{extension}")
    return Logo(content, extension)
