"""What a command tells while it works, where nobody watches a bar."""

import time

import pytest

from exercises import console


def test_a_line_of_progress_says_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with console.progress("verifying", 5) as counter:
        for _ in range(4):
            now[0] += 0.4 * console.EVERY
            counter.step()
    assert capsys.readouterr().err.splitlines() == ["verifying: 3 of 5"]
