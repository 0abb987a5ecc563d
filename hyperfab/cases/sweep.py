"""What is asked of ``hf sweep``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import file, flag, text, whole
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class SweepCase(Case):
    """Run a chain of commands over all combinations of a study, and collect one table.

    A finished step is never run twice: stop it at any time, run the same line again, and it goes on.

    \b
    Example:
      hf sweep molds/study.toml --out build/study
    """

    COMMAND = "sweep"
    KIND = "sweep"
    OUTPUT = None

    study: str = file("STUDY.toml", "Study: axes, chain of commands, figures to collect.", argument=True, required=True)
    out: str = text("DIR", "Folder that takes every case and the table.", required=True, kept=False)
    jobs: int | None = whole(
        "N", "Worker processes on this machine; default: one a core.", example="4", least=1, kept=False,
        over=("scheduler",),
    )  # fmt: skip
    scheduler: str | None = text(
        "ADDRESS", "Dask scheduler of a cluster, tcp://... or tls://....", kept=False, over=("jobs",)
    )
    retry_failed: bool = flag("Run failed cases again.", kept=False)
    parquet: bool = flag("Write the table as Parquet too.")
    yes: bool = flag("Do not stop at more than a million cases.", kept=False)

    def check(self) -> None:
        """Refuse what means nothing together."""
        super().check()
        if self.jobs is not None and self.scheduler is not None:
            raise UsageError("--jobs and --scheduler exclude each other: a cluster brings its own workers")
        if self.scheduler is not None and not re.fullmatch(r"(\w+://)?[^/\s]+:\d+", self.scheduler):
            raise UsageError(f"--scheduler {self.scheduler}: an address has a host and a port, as tcp://10.0.0.5:8786")
