"""Run `qdot serve` in separate processes, on a free port."""

import csv
import os
import random
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import psutil  # type: ignore[import-untyped]

QDOT = [sys.executable, "-m", "qdot.grader.cli.main"]


def find_free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


class RunningService:
    """`qdot serve` in separate processes. It can be started again after it was killed."""

    def __init__(self, folder: Path, database: str = "", jobs: int = 1) -> None:
        self.folder, self.port, self.jobs = folder, find_free_port(), jobs
        self.url = f"http://127.0.0.1:{self.port}"
        self.environment = {**os.environ, "QDOT_DATABASE": database, "QDOT_URL": self.url}
        links = folder.parent / "links.csv"
        self.call("links", str(folder), "--staff", "Grace", "--out", str(links))
        with links.open(encoding="utf-8-sig") as table:
            self.links = {row["student"]: row["link"] for row in csv.DictReader(table)}
        self._log = (folder.parent / "log.txt").open("w")
        self.close = self._log.close

    def call(self, *arguments: str) -> str:
        command = [*QDOT, "serve", *arguments]
        return subprocess.run(command, env=self.environment, check=True, capture_output=True, text=True).stdout

    def register(self, platform: Any) -> str:
        platform.tool, site = self.url, platform.site
        command = ("register", str(self.folder), "--platform", "moodle", "--site", site)
        match = re.search(r"http\S+/lti/login/\S+", self.call(*command))
        addresses = ("--auth-url", f"{site}/auth", "--token-url", f"{site}/token", "--keys-url", f"{site}/keys")
        self.call(*command, "--client-id", platform.client_id, *addresses)
        assert match is not None
        return match[0]

    def start(self) -> None:
        command = [*QDOT, "serve", str(self.folder), "--port", str(self.port), "--jobs", str(self.jobs)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=self._log, text=True, env=self.environment
        )
        assert self.process.stdout is not None
        assert "stop it with Ctrl-C" in self.process.stdout.readline()

    def list_workers(self) -> list[psutil.Process]:
        processes = psutil.Process(self.process.pid).children(recursive=True)
        return [process for process in processes if "resource_tracker" not in " ".join(process.cmdline())]

    def measure_processor_time(self) -> float:
        processes = [psutil.Process(self.process.pid), *self.list_workers()]
        return sum(sum(process.cpu_times()[:2]) for process in processes)

    def kill_worker(self, rng: random.Random) -> None:
        with suppress(psutil.NoSuchProcess, IndexError):
            os.kill(rng.choice(self.list_workers()).pid, signal.SIGKILL)

    def kill_and_start(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.wait()
        self.start()

    def wait(self) -> None:
        self.process.wait(20)
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextmanager
def run_service(folder: Path, database: str = "", jobs: int = 1) -> Iterator[RunningService]:
    service = RunningService(folder, database, jobs)
    service.start()
    try:
        yield service
    finally:
        service.process.kill()
        service.wait()
        service.close()
