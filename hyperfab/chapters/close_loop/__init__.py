"""``hf close-loop``: hold a model against measured data, find what it lacks, add it, and say how sure that is."""

from __future__ import annotations

import importlib

from hyperfab.chapters.close_loop.domain import Given, kind_of
from hyperfab.chapters.close_loop.recall import Parse
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError, UsageError
from hyperfab.io.units import quantity

#: The kinds of model that the loop can be closed on, and the module of each.
BUILT = {"material": "fabric", "mold": "heat", "press": "press", "contact": "contact", "drape": "drape"}


def run(
    job: Job,
    *,
    model: str,
    measured: list[str],
    hold_out: list[str],
    noise: str | None,
    fix: list[str],
    prior: str | None,
    decimal: str | None,
    output: str,
    parse: Parse,
) -> int:
    """Close the loop on ``model``: 0, or 1 where the residual stays unexplained.

    ``parse`` reads the words of another command's line, for documents that are models by how they were made.
    """
    if not measured:
        raise UsageError("nothing to compare with; give measured data with --measured FILE.csv")
    kind, data = kind_of(job, model)
    if kind not in BUILT:
        raise InputError(
            f"is a {kind} document, a model is needed",
            file=model,
            key="format",
            remedy="give a material, contact, drape or press document, or a mold.toml",
        )
    chapter = importlib.import_module(f"hyperfab.chapters.close_loop.{BUILT[kind]}")
    given = Given(
        model,
        data,
        measured,
        hold_out,
        noise,
        fix,
        None if prior is None else _share(prior),
        decimal,
        output,
        parse,
    )
    status: int = chapter.run(job, given)
    return status


def _share(prior: str) -> float:
    """Return the relative standard deviation of the model's own constants."""
    share = quantity(prior, "dimensionless", option="--prior")
    if not 0.0 < share <= 1.0:
        raise UsageError(
            f"--prior {prior}: is {share:.4g} of the value; give more than 0 and at most 100%, as 10%"
        )
    return share
