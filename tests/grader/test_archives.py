"""Archives of a class: their limits."""

import zipfile
from pathlib import Path

import pytest

from grader import archives
from grader.cells import Unreadable


def test_a_class_may_have_as_many_files_as_are_allowed_and_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archives, "MOST_OF_CLASS", 3)
    for count in (3, 4):
        path = tmp_path / f"{count}.zip"
        with zipfile.ZipFile(path, "w") as archive:
            for k in range(count):
                archive.writestr(f"s{k}/hw.ipynb", "{}")
        if count > 3:
            with pytest.raises(Unreadable, match="more than 3 files"), archives.unpacked(path):
                pass
            continue
        with archives.unpacked(path) as (folder, left_out):
            assert len(list(folder.rglob("*.ipynb"))) == 3 and not left_out
