"""Every stored run is of a known platform, and every failed check has a reason."""

from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.platforms import PLATFORMS
from tests.platforms.records import FOLDER, kept


def test_each_record_is_of_a_platform_and_nothing_fell_short_without_a_reason() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} >= set(PLATFORMS)
    for name, record in kept().items():
        assert name in PLATFORMS and record.export_format in {"generate", *EXPORT_FORMATS}
        assert record.software and record.counts
        assert [what for what, count in record.counts.items() if not count.is_sound] == []
