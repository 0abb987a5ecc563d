"""The entry of ``hf``, also as ``python -m hyperfab``: signals are obeyed from the first moment."""

from __future__ import annotations

import gc
import os
import signal
import sys


def main() -> None:
    """Run ``hf``; what the command line is made of is imported only once Ctrl-C ends without a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    _hold_standard_streams()
    # Sums over threads are rounded by their number: on one thread the same inputs give the same bytes on any share
    # of the machine. The work here is sparse; more threads gain nothing in it.
    os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"))
    # Imports and compiled kernels leave many objects and few cycles: looking for these all the time takes a fifth of
    # a first run.
    gc.set_threshold(100_000)
    from hyperfab.cli import main as hf

    try:
        hf()
    finally:
        # The interpreter would look through all that is left before it lets go of it: half a second.
        gc.freeze()


def _hold_standard_streams() -> None:
    """Put something in the place of closed standard streams.

    Their numbers would go to the next files opened, and Python prints on standard output what is meant for a
    standard error that is None. Standard output becomes unwritable, so that a document that goes there is not lost
    in silence.
    """
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)
    if sys.stdin is None:
        sys.stdin = open(0, closefd=False, encoding="utf-8")  # noqa: SIM115 - it stays open
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False, encoding="utf-8")  # noqa: SIM115 - it stays open
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False, encoding="utf-8")  # noqa: SIM115 - it stays open


def _leave(number: int, frame: object) -> None:
    """Leave at once: no work has begun, or all of it is done."""
    os._exit(128 + number)


if __name__ == "__main__":
    main()
