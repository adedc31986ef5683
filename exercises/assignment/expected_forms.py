"""Read expected_forms.toml: for each key of assignment.toml, a phrase that says which values are expected.

Error messages and docs/assignment.md show these phrases.
"""

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from string import Template

from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS
from qdot.exercises.common.errors import make_name_error
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_AXES, VARIATION_STEPS
from qdot.exercises.problem.credit import CREDIT_ERROR
from qdot.exercises.problem.rounding import ROUNDING_FORM
from qdot.exercises.singularities.difficulty import HARDEST_LEVEL

FORMS_FILE = Path(__file__).with_name("expected_forms.toml")
_TEXT = Template(FORMS_FILE.read_text(encoding="utf-8")).substitute(
    steps=", ".join(VARIATION_STEPS), axes=", ".join(VARIATION_AXES), default_variation=DEFAULT_VARIATION,
    conventions=", ".join(CONVENTIONS), twist_orders=" or ".join(TWIST_ORDERS), hardest_level=HARDEST_LEVEL,
)  # fmt: skip
_FORMS: dict[str, dict[str, str]] = tomllib.loads(_TEXT)
EXPECTED_FORMS = _FORMS["assignment"] | {"credit": CREDIT_ERROR, "decimals": ROUNDING_FORM}
LATE_FORMS, ATTEMPT_FORMS, PAPER_FORMS = _FORMS["late"], _FORMS["attempts"], _FORMS["paper"]
"""The phrases for the keys of assignment.toml, and for the keys in its tables `late`, `attempts` and `paper`."""


def check_keys(table: Iterable[str], forms: Mapping[str, str]) -> None:
    """Raise QdotError if a table of assignment.toml has a key that is not in `forms`."""
    for name in table:
        if name not in forms:
            raise make_name_error("key", name, tuple(forms))
