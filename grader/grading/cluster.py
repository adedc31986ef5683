"""An existing Dask cluster as an executor: connected to, counted, and every way in which it is not there told."""

import logging
import re
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import TYPE_CHECKING

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import need
from qdot.grader.grading.remote import GO_ON

if TYPE_CHECKING:
    from distributed import Client

ADDRESS = r"(tcp|tls)://(\[[0-9A-Fa-f:.%]+\]|[^\s/:\[\]]+):[0-9]{1,5}"

CONNECTING, STARTING, RETURNING = 10.0, 10.0, 60.0
"""Seconds that are waited for the scheduler, for its first worker, and for one to come back after all were lost."""

LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application")
"""Dask's own, which print with a traceback what is told in one line here."""


@contextmanager
def connected(address: str) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Yield an executor that runs things on the cluster of a Dask scheduler, and how many may be out at a time.

    The latter raises QdotError where there has been no worker for a while. Raises QdotError where the cluster can't be
    used.
    """
    if not re.fullmatch(ADDRESS, address):
        raise QdotError(f"--executor {address!r} is no address of a Dask scheduler; one is tcp://10.0.0.5:8786")
    try:
        import dask
        from distributed import Client
        from distributed.versions import VersionMismatchWarning
    except ImportError:
        need("cluster", "--executor")
        raise  # it is here, and does not work
    with (
        _quiet(),
        warnings.catch_warnings(),
        dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"}),
    ):
        warnings.simplefilter("ignore", VersionMismatchWarning)  # what matters of that, the workers compare
        try:
            client = Client(address, timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            raise QdotError(f"no Dask scheduler answers at {address} as it should: {_first_line(error)}") from None
        with client:
            room = _Room(client, address)
            while not room.is_open:
                room()
                time.sleep(0.1)
            yield client.get_executor(pure=False), room


@contextmanager
def _quiet() -> Iterator[None]:
    before = {name: logging.getLogger(name).level for name in LOGGERS}
    try:
        for name in LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


class _Room:
    """How many tasks may be out: two for every thread that there is now, so that none waits for its next one."""

    def __init__(self, client: "Client", address: str) -> None:
        self._client, self._address = client, address
        self._threads, self.is_open = 0, False
        self._asked, self._seen = -1.0, time.monotonic()

    def __call__(self) -> int:
        now = time.monotonic()
        if now > self._asked + 1:
            self._asked, self._threads = now, self._count()
            if self._threads:
                self._seen, self.is_open = now, True
            elif now > self._seen + (RETURNING if self.is_open else STARTING):
                raise QdotError(
                    f"all workers of {self._address} are gone; {GO_ON}"
                    if self.is_open
                    else f"the Dask scheduler at {self._address} has no workers; start some: "
                    f"dask worker {self._address} --nthreads 1 --nworkers auto"
                )
        return max(1, 2 * self._threads)

    def _count(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except (OSError, RuntimeError) as error:
            raise QdotError(f"the Dask scheduler at {self._address} is gone ({_first_line(error)}); {GO_ON}") from None


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
