"""Run the service: the web server, the processes that judge, and the process for the queue of notebooks."""

import logging
import multiprocessing
import os
import signal
import uuid
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from typing import Any

from django.core.management import call_command
from django.core.wsgi import get_wsgi_application
from django.db import DEFAULT_DB_ALIAS, connection, connections, transaction
from django.urls import resolve
from django_tasks_db.models import DBTaskResult
from waitress.server import create_server

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import lock
from qdot.grader.serve.headers import partition_cookies
from qdot.grader.serve.html_pages import load_assets
from qdot.grader.serve.lti.outbox import process_outbox
from qdot.grader.serve.marking_online import (
    MAX_FAILURES,
    get_judge_pool,
    give_up,
    queue_unmarked,
    run_periodically,
)
from qdot.grader.serve.queue_process import process_queue
from qdot.grader.serve.settings import ServiceOptions, find_options

THREADS, MAX_CONNECTIONS, IDLE_SECONDS = 32, 800, 30
"""Numbers of requests answered at the same time and of open connections, and how long a connection may be idle.

A browser keeps several connections open; at the maximum, nobody else gets in."""
SECONDS_BETWEEN_CHECKS = 2.0
"""Seconds between checks that the claim on the database holds, that the queue process lives, and that no submission is
unmarked."""
MAX_REQUEST_BYTES = 25_000_000
"""Maximum size of a request, which is more than the maximum size of a notebook (`submitting`)."""
CLAIM_FILE, CLAIM_NUMBER = "service.lock", 0x71646F74
"""What a running service locks: a file beside the database, or a number in PostgreSQL."""
ALREADY_SERVED = "another `qdot serve` is using this database; stop it first (Ctrl-C, or `systemctl stop qdot`)"
logger = logging.getLogger("qdot.serve")


def prepare_database() -> None:
    """Make or update the tables of the database, and remove sessions that have ended."""
    call_command("migrate", verbosity=0, interactive=False)
    call_command("clearsessions")


@contextmanager
def claim_database() -> Iterator[Callable[[], None]]:
    """Keep other processes from serving from the database, or replacing it, during the block. Raises QdotError.

    The claim ends with this process, even if the process is killed. It also ends if PostgreSQL restarts. The yielded
    function then claims the database again, or ends this service if another one was faster.
    """
    if connection.vendor == "postgresql":
        with closing(connections.create_connection(DEFAULT_DB_ALIAS)) as own_connection:
            own_connection.inc_thread_sharing()
            _claim_postgresql(own_connection)
            yield partial(_renew_claim_if_lost, own_connection)
        return
    with (find_options().online_folder / CLAIM_FILE).open("w") as file:
        try:
            lock(file.fileno(), wait=False)
        except BlockingIOError:
            raise QdotError(ALREADY_SERVED) from None
        yield lambda: None


def _claim_postgresql(own_connection: Any) -> None:
    with own_connection.cursor() as cursor:
        cursor.execute("SELECT pg_try_advisory_lock(%s)", [CLAIM_NUMBER])
        if cursor.fetchone() != (True,):
            raise QdotError(ALREADY_SERVED)


def _renew_claim_if_lost(own_connection: Any) -> None:
    if own_connection.is_usable():
        return
    own_connection.close()
    try:
        _claim_postgresql(own_connection)
    except QdotError as error:
        logger.error("%s; this one ends", error)
        os.kill(os.getpid(), signal.SIGINT)


def run_service(
    options: ServiceOptions, host: str, port: int, keep_claim: Callable[[], None], on_ready: Callable[[], None]
) -> None:
    """Serve until the process is asked to end; `on_ready` is called when the service answers. Raises QdotError.

    `keep_claim` is what `claim_database` yields.
    """
    resolve("/")  # loads all views
    load_assets()
    get_judge_pool().warm_up()
    queue = QueueProcess(options)
    queue.start()
    run_periodically(keep_claim, SECONDS_BETWEEN_CHECKS)
    run_periodically(queue_unmarked, SECONDS_BETWEEN_CHECKS)
    run_periodically(queue.watch, SECONDS_BETWEEN_CHECKS)
    run_periodically(process_outbox, 1.0)
    try:
        server = open_server(get_wsgi_application(), options.url, host, port)
    except OSError as error:
        queue.stop()
        raise QdotError(f"port {port} can't be used: {error.strerror}; choose another with --port") from None
    on_ready()
    try:
        server.run()
    finally:
        queue.stop()
        get_judge_pool().close()


def open_server(application: Any, url: str, host: str, port: int) -> Any:
    """Return a web server that listens. Raises OSError if it can't."""
    is_behind_proxy = url.startswith("https:")
    proxy = {"trusted_proxy": "*", "trusted_proxy_headers": "x-forwarded-for x-forwarded-proto"}
    return create_server(
        partition_cookies(application) if is_behind_proxy else application, host=host, port=port, threads=THREADS,
        ident=None, clear_untrusted_proxy_headers=True, max_request_body_size=MAX_REQUEST_BYTES,
        connection_limit=MAX_CONNECTIONS, channel_timeout=IDLE_SECONDS, asyncore_use_poll=True,
        **(proxy if is_behind_proxy else {}),
    )  # fmt: skip


class QueueProcess:
    """The process that grades the notebooks in the queue; it is started again when it dies."""

    def __init__(self, options: ServiceOptions) -> None:
        self._options, self._is_stopped, self._name = options, False, ""
        self._process: multiprocessing.process.BaseProcess | None = None

    def start(self) -> None:
        """Put the tasks of a killed process back into the queue, and start a new process."""
        reclaim_tasks()
        connections.close_all()
        self._name = uuid.uuid4().hex
        context = multiprocessing.get_context("spawn")
        self._process = context.Process(target=process_queue, args=(self._options, self._name), daemon=True)
        self._process.start()

    def watch(self) -> None:
        """Start the process again if it has died."""
        if not self._is_stopped and self._process is not None and not self._process.is_alive():
            self.start()
            logger.error("the process that grades notebooks had died; it was started again")

    def stop(self) -> None:
        """End the process."""
        self._is_stopped = True
        if self._process is not None:
            self._process.terminate()
            self._process.join(5)


def reclaim_tasks() -> None:
    """Put tasks whose process was killed back into the queue, unless this has happened too often."""
    for row in DBTaskResult.objects.running():
        with transaction.atomic():
            if len(row.worker_ids) >= MAX_FAILURES:
                give_up(row.task_path, *row.args_kwargs["args"])
                row.set_failed(RuntimeError("the task's process died too often"))
            else:
                DBTaskResult.objects.filter(pk=row.pk).update(status="READY")
