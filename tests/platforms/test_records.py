"""Each stored record belongs to a platform, and every failed check in it is excused."""

from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.platforms import PLATFORMS
from tests.platforms.records import FOLDER, load_records


def test_each_record_belongs_to_a_platform_and_every_failed_check_is_excused() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} >= set(PLATFORMS)
    for name, record in load_records().items():
        assert name in PLATFORMS and record.export_format in {"generate", "serve", *EXPORT_FORMATS}
        assert record.software and record.counts
        assert [check for check, count in record.counts.items() if not count.all_passed_or_excused] == []
