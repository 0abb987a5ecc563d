"""What each worker does when it starts."""

from __future__ import annotations

import importlib
import signal
import threading
from collections.abc import Sequence
from typing import Any

from distributed import WorkerPlugin


class Warmth(WorkerPlugin):  # type: ignore[misc, unused-ignore]
    """Imports what the steps will need; in a local worker also leaves Ctrl-C to the driver.

    ``warm`` is a function's place, ``module:function``, and ``commands`` what it is called with.
    """

    name = "hyperfab"
    idempotent = True

    def __init__(self, warm: str, commands: Sequence[str], local: bool) -> None:
        self.warm = warm
        self.commands = list(commands)
        self.local = local

    def setup(self, worker: Any) -> None:
        """Run once in each worker, also in one that takes a lost one's place."""
        if self.local and threading.current_thread() is threading.main_thread():
            # A terminal sends Ctrl-C to the whole family; the driver ends it in order.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        module, name = self.warm.split(":")
        getattr(importlib.import_module(module), name)(self.commands)
