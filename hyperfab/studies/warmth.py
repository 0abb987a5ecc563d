"""What each worker does when it starts."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Sequence
from typing import Any

from distributed import WorkerPlugin


class Warmth(WorkerPlugin):  # type: ignore[misc, unused-ignore]
    """Imports what the steps will need; in a local worker also leaves Ctrl-C to the driver.

    ``warm`` is called with ``commands``; a worker imports it with its module.
    """

    name = "hyperfab"
    idempotent = True

    def __init__(self, warm: Callable[[Sequence[str]], None], commands: Sequence[str], local: bool) -> None:
        self.warm = warm
        self.commands = list(commands)
        self.local = local

    def setup(self, worker: Any) -> None:
        """Run once in each worker, also in one that takes a lost one's place."""
        if self.local and threading.current_thread() is threading.main_thread():
            # A terminal sends Ctrl-C to the whole family; the driver ends it in order.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        self.warm(self.commands)
