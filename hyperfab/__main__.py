"""The entry of ``hf``, also as ``python -m hyperfab``: signals are obeyed from the first moment."""

from __future__ import annotations

import os
import signal


def main() -> None:
    """Run ``hf``; what the command line is made of is imported only once Ctrl-C ends without a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    from hyperfab.cli import main as hf

    hf()


def _leave(number: int, frame: object) -> None:
    """Leave at once: no work has begun, or all of it is done."""
    os._exit(128 + number)


if __name__ == "__main__":
    main()
