"""``hf sweep``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, run_chapter

SHORT_HELP = "Many runs over materials, molds and settings"


def sweep(
    context: typer.Context,
    study: Annotated[
        str, typer.Argument(metavar="STUDY.toml", help="Study: axes, chain of commands, figures to collect.")
    ],
    out: Annotated[
        str, typer.Option("--out", metavar="DIR", help="Folder that takes every case and the table.")
    ],
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Worker processes on this machine; default: one a core.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler of a cluster, tcp://... or tls://...."),
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Run failed cases again.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write the table as Parquet too.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not stop at more than a million cases.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Run a chain of commands over all combinations of a study, and collect one table.

    A finished step is never run twice: stop it at any time, run the same line again, and it goes on.

    \b
    Example:
      hf sweep molds/study.toml --out build/study
    """
    run_chapter(context, runner="hyperfab.cli.steps")
