"""qdot uses no network except where configured, licences are respected, and the citation and links are correct."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from qdot.exercises.site.pages import render_licences
from tests.support import ROOT
from tests.support.imports import get_module_name, list_imported_names
from tests.support.suites import WHOLE

NETWORK = {
    "qdot.grader.integrations.git_hosts": "fetches pushes from the configured GitHub or GitLab",
    "qdot.grader.integrations.git_submissions": "the same",
    "qdot.grader.cli.site_commands": "`qdot site serve`, on this machine alone",
    "qdot.grader.serve.lti.connection": "asks the registered learning platforms for keys, class lists and gradebooks",
    "qdot.grader.serve.server": "`qdot serve`",
    "qdot.grader.sandbox.sandbox": "pipes to the sandbox",
    "qdot.grader.sandbox.guarantees": "a target for the probe",
    "qdot.grader.sandbox.notebook_process.escape_attempts": "the probe's attempts",
    "qdot.grader.sandbox.notebook_process.forking_process": "pipes to the sandbox",
}  # fmt: skip
"""The modules that may communicate outside their process, and why."""
LIBRARIES = {"socket", "ssl", "http", "urllib", "ftplib", "smtplib", "asyncio", "requests", "httpx", "waitress"}


def test_no_other_module_can_reach_a_network() -> None:
    modules, named = [*ROOT.glob("exercises/**/*.py"), *ROOT.glob("grader/**/*.py")], re.compile("|".join(LIBRARIES))
    naming = [path for path in modules if named.search(path.read_text(encoding="utf-8"))]
    imported = {get_module_name(path): list_imported_names(path) for path in naming}
    using = {
        module for module, names in imported.items()
        if {name.split(".")[0] for name in names if not name.startswith("urllib.parse")} & LIBRARIES
    }  # fmt: skip
    assert using == NETWORK.keys()


WATCHER = """
import sys

def hook(event, arguments):
    if event in ("socket.getaddrinfo", "socket.gethostbyname") or (
        event in ("socket.connect", "socket.sendto") and isinstance(arguments[1], tuple)
    ):
        sys.stderr.write(f"NETWORK {event} {arguments[1:]}\\n")

sys.addaudithook(hook)
from qdot.grader.cli.main import app
for arguments in %r:
    try:
        app(arguments)
    except SystemExit as left:
        assert not left.code, arguments
"""


def test_no_command_uses_the_network(tmp_path: Path) -> None:
    folder = str(tmp_path / "hw")
    commands = [["init", folder], ["families"], ["show", "polar-rp/1", "--solution"]]
    if WHOLE:
        commands += [
            [name, folder, *options, "--jobs", "1"]
            for name, *options in (["generate"], ["verify"], ["grade"], ["export", "--to", "html"])
        ]
    process = subprocess.run(
        [sys.executable, "-c", WATCHER % commands], cwd=tmp_path, capture_output=True, encoding="utf-8"
    )
    assert process.returncode == 0, process.stderr
    assert "NETWORK" not in process.stderr


def test_the_watcher_notices_network_use(tmp_path: Path) -> None:
    code = WATCHER % [] + "import socket; socket.getaddrinfo('localhost', 80)"
    process = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, encoding="utf-8")
    assert "NETWORK socket.getaddrinfo" in process.stderr


DIST = ROOT / "site" / "dist"


@pytest.mark.skipif(not DIST.is_dir(), reason="the site's scripts are not built here: make site")
def test_the_licence_page_lists_every_library_of_the_site() -> None:
    page = render_licences(DIST)
    wanted = json.loads((ROOT / "site" / "package.json").read_text(encoding="utf-8"))["dependencies"]
    listed = re.findall(r"(?m)^## (\S+) - \S+ \(([\w.-]+)\)$", page)
    assert set(wanted) <= {name for name, _ in listed}
    assert {licence for _, licence in listed} <= {"MIT", "BSD-3-Clause", "ISC"}, (
        "check whether it may be bundled and requires a notice"
    )
    assert page.count("Permission is hereby granted") >= len(listed)


def test_no_other_third_party_code_is_bundled() -> None:
    """Third-party code would have a copyright notice. The only font has its licence beside it and on the page."""
    foreign = re.compile(r"copyright|all rights reserved|SPDX", re.IGNORECASE)
    files = [path for top in ("exercises", "grader", "templates", "site/src") for path in (ROOT / top).rglob("*")]
    files = [path for path in files if path.is_file() and "__pycache__" not in path.parts]
    assert len(files) > 300
    fonts = [path for path in files if path.suffix in (".woff", ".woff2", ".ttf", ".otf", ".min.js")]
    assert [path.name for path in fonts] == ["stix-two-math.woff2"]
    assert "SIL Open Font License" in (fonts[0].parent / "OFL.txt").read_text(encoding="utf-8")
    licence_page = ROOT / "templates" / "site" / "licences.md.j2"
    assert "STIX Two Math, copyright" in licence_page.read_text(encoding="utf-8")
    texts = [path for path in files if path.suffix in (".py", ".j2", ".ts", ".tsx", ".css", ".toml", ".json")]
    texts.remove(licence_page)
    assert [path.name for path in texts if foreign.search(path.read_text(encoding="utf-8"))] == []


def test_the_citation_has_this_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["cff-version"] == "1.2.0" and {"message", "title", "authors"} <= set(citation)
    assert (citation["version"], citation["license"]) == (project["version"], project["license"])
    assert [author["name"] for author in citation["authors"]] == [author["name"] for author in project["authors"]]
