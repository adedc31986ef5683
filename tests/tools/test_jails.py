"""The comparison with bubblewrap: what the last run found is what the document says, and attacks are attacks."""

import json
import os
import platform
import shutil
import subprocess
import sys

import pytest

from tests.support import ROOT
from tests.tools import jails
from tests.tools.jailed import ATTACKS

RECORD = json.loads(jails.RECORD.read_text(encoding="utf-8"))


def test_the_document_says_what_the_last_run_found() -> None:
    text = jails.DOCUMENT.read_text(encoding="utf-8")
    assert jails.documented(text, RECORD) == text


def test_what_bubblewrap_held_ours_held() -> None:
    """On a machine with namespaces, which bubblewrap does not start without."""
    names = {f"{guarantee}: {attack}" for guarantee, attacks in ATTACKS.items() for attack in attacks}
    assert all(found.keys() == names for found in RECORD["found"].values())
    shown = dict(jails._shown(RECORD))
    assert not [attack for attack, held in shown.items() if held[jails.BUBBLEWRAP] and not held[jails.OURS]]


@pytest.mark.skipif(
    not shutil.which("bwrap") or sys.platform != "linux" or platform.machine() != "x86_64" or os.geteuid() != 0,
    reason="bubblewrap is not here",
)
def test_an_attack_succeeds_without_a_jail_and_in_none() -> None:
    name = "files: reads another submission"
    program = [sys.executable, "-m", "tests.tools.jails", "compare", "--only", name]
    own = {**os.environ, "TMPDIR": "/tmp"}  # bubblewrap has a /dev of its own, in which no folder of ours can be
    run = subprocess.run(program, capture_output=True, text=True, cwd=ROOT, env=own)
    row = json.loads(run.stdout)[name]
    assert row[jails.BARE]["achieved"] == "CANARY of a file"
    assert {jail for jail, cell in row.items() if cell["achieved"]} == {jails.BARE}
    assert all("Error" in cell["refused"] for jail, cell in row.items() if jail != jails.BARE)
