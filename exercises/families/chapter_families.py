"""Read the families of the chapter's arms from families.toml: for each family, an arm and its axes of variation."""

import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import REVOLUTE, Chain, Joint, Point
from qdot.exercises.families import variations
from qdot.exercises.families.family import Family, Variation

FAMILIES_FILE = Path(__file__).with_name("families.toml")

RANGES: Mapping[str, Sequence[int]] = {
    "any angle": variations.ANGLES,
    "right angle": variations.RIGHT_ANGLES,
    "hand": variations.HAND_LENGTHS,
    "height": variations.BASE_HEIGHTS,
    "slide": variations.PRISMATIC_LENGTHS,
    "slide both ways": variations.SIGNED_LENGTHS,
    "short slide both ways": tuple(length for length in variations.SIGNED_LENGTHS if abs(length) <= 50),
    "offset": (5, 10, 15, 20, 25),
    "shoulder": (10, 15, 20, 25),
    "wide shoulder": (10, 15, 20, 25, 30, 40),
    "link": (30, 35, 40, 45, 50, 60, 70, 75, 80),
    "forearm": (35, 40, 45, 50, 60, 70),
    "upper arm": (50, 60, 70, 75, 80, 90),
}
"""Maps the names of ranges in families.toml to their values: lengths in centimetres, angles in degrees."""


def read_families() -> list[Family]:
    """Return the families defined in families.toml, in the order of the file."""
    content = tomllib.loads(FAMILIES_FILE.read_text(encoding="utf-8"))
    return [_read_family(name, entry) for name, entry in content.items()]


def _read_family(name: str, entry: Mapping[str, Any]) -> Family:
    tool = Point(entry["point"]) if "point" in entry else None
    chain = Chain(name, parse_table(entry["table"]), tuple(entry["task"].split()), tool=tool, title=entry["arm"])
    return Family(name, entry["title"], entry["source"], chain, _read_variations(entry["vary"]))


def _read_variations(settings: Mapping[str, Any]) -> dict[str, Variation]:
    """Return the axes of variation that the table `vary` of a family describes."""
    lengths = {symbol: _find_range(values) for symbol, values in settings.get("lengths", {}).items()}
    offsets = {int(number): _find_range(values) for number, values in settings["zeros"].items()}
    axes: dict[str, Variation] = {
        "zeros": partial(variations.shift_zeros, ranges=offsets),
        "senses": partial(variations.reverse_axes, groups=settings["senses"]),
        "base": getattr(variations, settings["base"]),
    }
    if "together" in settings:
        axes["lengths"] = partial(variations.set_lengths_together, ranges=lengths)
    elif lengths:
        candidates = settings.get("symbolic", ())
        axes["lengths"] = partial(variations.set_lengths, ranges=lengths, candidates=candidates)
    if "frames" in settings:
        axes["tool"] = partial(variations.choose_point_frame, frames=settings["frames"])
    elif "beside" in settings:
        axes["tool"] = partial(variations.place_point_beside, distances=settings["beside"])
    else:
        axes["tool"] = getattr(variations, settings["point"])
    if "upright" in settings:
        axes["task"] = variations.stand_upright
    return axes


def _find_range(values: str | Sequence[int]) -> Sequence[int]:
    return RANGES[values] if isinstance(values, str) else values


def parse_table(rows: Sequence[str]) -> tuple[Joint, ...]:
    """Return the joints of a table.

    A row consists of the kind, d (theta for a prismatic joint), a and alpha. The row of a revolute joint may end with
    the joint offset. Angles are in degrees.

    >>> parse_table(["R d1 a1 -90", "P 0 0 0"])[0]
    Joint(kind='R', theta=theta1, d=d1, a=a1, alpha=-pi/2)
    """
    joints = []
    for number, row in enumerate(rows, 1):
        kind, fixed_entry, a, alpha, *joint_offset = row.split()
        if kind == REVOLUTE:
            theta, d = sp.Symbol(f"theta{number}") + sum(map(_parse_angle, joint_offset)), _parse_length(fixed_entry)
        else:
            theta, d = _parse_angle(fixed_entry), sp.Symbol(f"d{number}")
        joints.append(Joint(kind, theta, d, _parse_length(a), _parse_angle(alpha)))
    return tuple(joints)


def _parse_angle(degrees: str) -> sp.Expr:
    return variations.to_radians(int(degrees))


def _parse_length(name: str) -> sp.Expr:
    return sp.S.Zero if name == "0" else sp.Symbol(name)
