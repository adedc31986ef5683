#!/usr/bin/env python3
"""Replace GitHub's command line on PATH: record calls in $GH_STATE, and provide real repositories to push to."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

STATE = Path(os.environ.get("GH_STATE", "nowhere"))
ARGUMENTS = sys.argv[1:]


def option(name: str) -> str:
    return ARGUMENTS[ARGUMENTS.index(name) + 1]


def fail(message: str) -> int:
    sys.stderr.write(f"{message}\n")
    return 1


def bare(name: str) -> Path:
    return STATE / "repositories" / f"{name}.git"


def api(state: dict[str, Any]) -> int:
    if ARGUMENTS[1] == "--include":
        print(f"HTTP/2.0 200 OK\r\nX-Oauth-Scopes: {state['scopes']}\r\n\r\n{{}}")
        return 0
    path = next(word for word in ARGUMENTS[1:] if word.startswith("repos/"))
    if "/collaborators/" in path and path.rpartition("/")[2] not in state["logins"]:
        return fail("gh: Not Found (HTTP 404)")
    if "/issues" in path:
        opened = STATE / "issue"
        if "--method" in ARGUMENTS:
            opened.write_text("1")
        print(opened.read_text() if opened.exists() else "")
    return 0


def main() -> int:
    state = json.loads((STATE / "known.json").read_text())
    text = sys.stdin.read() if ARGUMENTS[:2] == ["secret", "set"] else ""
    with (STATE / "calls.jsonl").open("a") as calls:
        calls.write(json.dumps({"call": ARGUMENTS, "stdin": text}) + "\n")
    match ARGUMENTS[:2]:
        case ["auth", "status"]:
            return 0 if state["logged_in"] else fail("You are not logged into any GitHub hosts.")
        case ["auth", "git-credential"]:
            return 0
        case ["repo", "view"]:
            if not bare(ARGUMENTS[2]).exists():
                return fail(f"GraphQL: Could not resolve to a Repository with the name '{ARGUMENTS[2]}'. (repository)")
            print(f"file://{STATE}/repositories/{ARGUMENTS[2]}")
        case ["repo", "create"]:
            subprocess.run(["git", "init", "--quiet", "--bare", bare(ARGUMENTS[2])], check=True)
        case ["api", _]:
            return api(state)
        case ["secret", "set"]:
            if not bare(option("--repo")).exists():
                return fail("HTTP 404: Not Found")
        case _:
            return fail(f"unknown command {ARGUMENTS}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
