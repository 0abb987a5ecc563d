"""What goes to standard output and to standard error, progress, signals and exit status.

Standard output carries documents only. Everything said to a person goes to standard error. rich is loaded
only where something is drawn for a person: a table, or progress on a terminal.
"""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Literal, Protocol

from hyperfab.errors import HyperfabError
from hyperfab.system import ALARM, alarm

#: Where numba unpickles what it needs to box the result of a compiled function.
_CONVERTS = os.path.join("numba", "core", "serialize.py")

#: On a terminal that draws no bar a long run says how far it has come after this time [s], and again each time.
EVERY_S = 60.0
#: After this time [s] of work a run tells its size and how long it goes on, where that is at least so long [s].
MEASURED_S, LONG_S = 3.0, 30.0
#: A signal whose exception was swallowed is raised again after this time [s].
AGAIN_S = 0.7
#: The signals that ended, or try to end, the command now running.
_arrived: list[int] = []

#: How a run ends when the verdict of a computation is negative (no model accepted, a bound exceeded).
NEGATIVE_VERDICT = 1


class Advance(Protocol):
    """Moves a progress line: the fraction done (0 to 1) and what is being done."""

    def __call__(self, fraction: float, text: str = "") -> None: ...


def _colours() -> Literal["auto"] | None:
    """Return what rich may draw with: nothing, bold neither, where NO_COLOR asks for plain text."""
    return None if os.environ.get("NO_COLOR") else "auto"


class Interrupted(KeyboardInterrupt):
    """Ctrl-C arrived. A class of its own: where KeyboardInterrupt itself passes an exec(), as it may in an import,
    Python ends by killing itself whatever status is returned."""


class Terminated(BaseException):
    """SIGTERM arrived: unwinds the stack like KeyboardInterrupt, so that nothing half-written stays."""


class Console:
    """Standard error as the commands use it.

    ``quiet`` keeps warnings and errors and drops notes, tables and progress.
    """

    def __init__(self, quiet: bool = False) -> None:
        self.quiet = quiet
        self.warned = 0

    def warn(self, *texts: str) -> None:
        """Say what the user should know before trusting the result."""
        self.warned += len(texts)
        for text in texts:
            _say(f"hf: warning: {text}")

    def count(self) -> None:
        """Say at the end how many warnings there were: the first may have scrolled away."""
        if self.warned > 1:
            self.note(f"{self.warned} warnings")

    def note(self, *texts: str) -> None:
        """Say what a person at the terminal may like to know."""
        for text in () if self.quiet else texts:
            _say(text)

    def passing(self, text: str) -> None:
        """Say what is of use only while the work goes on, to who sits before it: as progress, on a terminal alone."""
        if sys.stderr.isatty():
            self.note(text)

    def table(self, title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """Show a small table: the first column left-aligned, the others right-aligned."""
        if self.quiet:
            return
        from rich.console import Console as RichConsole
        from rich.table import Table
        from rich.text import Text

        table = Table(title=Text(title), title_justify="left")
        for index, name in enumerate(columns):
            table.add_column(Text(name), justify="left" if index == 0 else "right")
        for row in rows:
            table.add_row(*(Text(str(value)) for value in row))
        # Written by ourselves: rich ends the program where nobody reads.
        terminal = sys.stderr.isatty()
        shown = io.StringIO()
        width = None if terminal else 200
        RichConsole(file=shown, force_terminal=terminal, color_system=_colours(), width=width).print(table)
        _say(shown.getvalue().removesuffix("\n"))

    @contextlib.contextmanager
    def progress(self, description: str, size: str = "", *, paced: bool = True) -> Iterator[Advance]:
        """Show how far a long piece of work has come: a bar; on a dumb terminal a line a minute, off one nothing.

        Where it will be long its ``size`` is told first, and about how long it goes on by the pace of its beginning;
        not of what is not ``paced``, whose fractions only say that it lives.

        >>> with Console().progress("Warming up") as advance:
        ...     advance(0.5, "100 degC")
        """
        if self.quiet or not sys.stderr.isatty():
            yield lambda fraction, text="": None
            return
        if os.environ.get("TERM") == "dumb":
            forecast = self._forecast(description, size, _say) if paced else None
            yield self._now_and_then(description, forecast)
            return
        from rich.console import Console as RichConsole
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[text]}", markup=False),
            console=RichConsole(stderr=True, color_system=_colours()),
            transient=True,
        )
        with bar:
            task = bar.add_task(description, total=1.0, text="")

            def above(words: str) -> None:
                bar.console.print(words, markup=False, highlight=False)

            forecast = self._forecast(description, size, above) if paced else None

            def advance(fraction: float, text: str = "") -> None:
                if forecast is not None:
                    forecast(fraction, time.monotonic())
                bar.update(task, completed=min(max(fraction, 0.0), 1.0), text=text)

            yield advance

    @staticmethod
    def _forecast(description: str, size: str, say: Callable[[str], None]) -> Callable[[float, float], None]:
        """Return what is told fraction and time, and says once how long the work goes on by its pace.

        Two stretches in a row must agree within a factor of two: in one of them a compiler or solver may get ready.
        """
        begun: tuple[float, float] | None = None
        before: float | None = None
        told = False

        def forecast(fraction: float, now: float) -> None:
            nonlocal begun, before, told
            if told or fraction <= 0.0:
                return
            if begun is None:
                begun = (fraction, now)
            done, took = fraction - begun[0], now - begun[1]
            if took < MEASURED_S or done < 0.01:
                return
            left = (1.0 - fraction) * took / done
            if before is None or not 0.5 <= (left + took) / before <= 2.0:
                begun, before = (fraction, now), left
                return
            told = True
            if left >= LONG_S:
                amount = f"{left / 60:.0f} min" if left >= 90.0 else f"{left:.0f} s"
                say(f"{description}: {f'{size}, ' if size else ''}about {amount} more by its pace so far")

        return forecast

    def _now_and_then(self, description: str, forecast: Callable[[float, float], None] | None) -> Advance:
        """Say once in ``EVERY_S`` how far the work has come; a short run says nothing.

        How long it took alone where there is no ``forecast``.
        """
        start = said = time.monotonic()

        def advance(fraction: float, text: str = "") -> None:
            nonlocal said
            now = time.monotonic()
            if forecast is not None:
                forecast(fraction, now)
            if now - said >= EVERY_S:
                said = now
                done = "" if forecast is None else f"{100 * fraction:.0f} % "
                words = f"{description}: {done}after {(now - start) / 60:.0f} min"
                _say(f"{words}, {text}" if text else words)

        return advance


def _say(text: str) -> None:
    """Say it on standard error. That nobody reads it any more, or a full disk takes it not, is no reason to lose the
    result."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        # What waits to be written would fail once more at the end, and so would the next message.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stderr.fileno())
        os.close(nowhere)


def run_guarded(action: Callable[[], int], debug: bool) -> int:
    """Run a command and turn whatever happens into its exit status, with one message on standard error."""
    # Set also where the parent ignores SIGINT (a job in the background of a script): the status is promised.
    if not debug:  # a library's warning about a line of ours is no message for the user
        warnings.simplefilter("ignore")
    numbers: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM)
    _arrived.clear()
    sys.unraisablehook = _unraisable
    previous = {number: signal.signal(number, _on_signal) for number in numbers}
    if ALARM is not None:
        previous[ALARM] = signal.signal(ALARM, _on_alarm)
    try:
        try:
            return action()
        except Exception as error:
            # What a library makes of a signal that fell into one of its callbacks is the signal, no defect.
            if _arrived:
                raise _ending(_arrived[0]) from error
            raise
        finally:  # a second Ctrl-C must not tear the message below
            alarm(0.0)
            for number in previous:
                signal.signal(number, signal.SIG_IGN)
    except HyperfabError as error:
        _say(f"hf: {_kind(error)}: {error}")
        return error.exit_status
    except KeyboardInterrupt:
        _say("hf: interrupted; nothing was written")
        return 130
    except Terminated:
        _say("hf: terminated; nothing was written")
        return 143
    except MemoryError:
        _say("hf: error: out of memory; use a coarser mesh or grid, or a smaller input")
        return 70
    except Exception as error:  # noqa: BLE001 - the last guard: a defect becomes status 70, never a bare traceback
        if debug:
            traceback.print_exc()
        _say(f"hf: defect: {type(error).__name__}: {error}; run again with --debug and report the traceback")
        return 70
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def _on_signal(number: int, frame: FrameType | None) -> None:
    """Raise where the signal fell, and once more a little later: callbacks of libraries swallow what is raised."""
    _arrived.append(number)
    alarm(AGAIN_S)
    if _in_conversion(frame):
        _raise_behind(number, frame)
    else:
        raise _ending(number)


def _on_alarm(number: int, frame: FrameType | None) -> None:
    if _arrived:
        _on_signal(_arrived[0], frame)


def _unraisable(swallowed: sys.UnraisableHookArgs) -> None:
    """Say nothing of a signal that a callback swallowed: it is raised again."""
    if not isinstance(swallowed.exc_value, (Interrupted, Terminated)):
        sys.__unraisablehook__(swallowed)


def _ending(number: int) -> BaseException:
    return Interrupted() if number == signal.SIGINT else Terminated()


def _raise_behind(number: int, frame: FrameType | None) -> None:
    """Raise as soon as ordinary Python goes on: on the next line of it that is traced."""

    def trace(traced: FrameType, event: str, argument: object) -> None:
        if not _in_conversion(traced):
            sys.settrace(None)
            _on_signal(number, traced)

    while frame is not None:
        frame.f_trace = trace
        frame = frame.f_back
    sys.settrace(trace)


def _in_conversion(frame: FrameType | None) -> bool:
    """Whether numba is turning native results into Python objects.

    It calls Python for that and does not look at the outcome: an exception there crashes the interpreter.
    """
    for _ in range(12):
        if frame is None:
            return False
        if frame.f_code.co_filename.endswith(_CONVERTS):
            return True
        frame = frame.f_back
    return False


def _kind(error: HyperfabError) -> str:
    return {2: "usage", 3: "input", 4: "not converged", 5: "output"}.get(error.exit_status, "error")
