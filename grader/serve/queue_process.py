"""The process that grades the notebooks in the queue. It imports Django's tables only after configuring Django."""

import multiprocessing
import os
import signal
import threading

from django.core.management import call_command
from django.db import InterfaceError, OperationalError

from qdot.grader.serve.errors import report_failed
from qdot.grader.serve.settings import ServiceOptions, configure


def process_queue(options: ServiceOptions, name: str) -> None:
    """Grade the notebooks in the queue, one after the other, until the service ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    configure(options)
    threading.Thread(target=_end_with_service, daemon=True).start()
    os.nice(5)  # typed answers come first
    try:
        call_command("db_worker", worker_id=name, interval=0.5, startup_delay=False, reload=False, verbosity=0)
    except (OperationalError, InterfaceError) as error:  # the service starts it again when the database answers
        report_failed("the queue of notebooks", error)


def _end_with_service() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os.kill(os.getpid(), signal.SIGKILL)  # a task that is running is put back into the queue at the next start
