"""``hf close-loop``: hold a model against measured data, find what it lacks, add it, and say how sure that is."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from hashlib import sha256

from hyperfab.chapters.close_loop.domain import Given, How, kind_of
from hyperfab.chapters.fit.prepare import Steps
from hyperfab.chapters.fit.specimens import geometry
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import layout
from hyperfab.io.units import quantity

#: The kinds of model that the loop can be closed on, and the module of each.
BUILT = {"material": "fabric", "mold": "heat", "press": "press", "contact": "contact", "drape": "drape"}


def run(
    job: Job,
    *,
    model: str,
    measured: Sequence[str] = (),
    hold_out: Sequence[str] = ("auto",),
    noise: str | None = None,
    fix: Sequence[str] = (),
    prior: str | None = None,
    files: Sequence[str] = (),
    uniaxial: Sequence[str] = (),
    shear: Sequence[str] = (),
    biaxial: Sequence[str] = (),
    specimen: str | None = None,
    gauge_length: str | None = None,
    width: str | None = None,
    thickness: str | None = None,
    diameter: str | None = None,
    branch: str = "all",
    cycle: str = "all",
    zero: bool = False,
    preload: str | None = None,
    resample: int | None = None,
    columns: Sequence[str] = (),
    skip_rows: int | None = None,
    decimal: str | None = None,
    output: str = "-",
) -> int:
    """Close the loop on ``model``: 0, or 1 where the residual stays unexplained."""
    kinds = {
        name: test
        for test, names in (("uniaxial", uniaxial), ("shear", shear), ("biaxial", biaxial))
        for name in names
    }
    measured = [*files, *measured, *uniaxial, *shear, *biaxial]
    if not measured:
        raise UsageError("nothing to compare with; give measured data as FILE.csv behind the model")
    lengths = {"gauge_length": gauge_length, "width": width, "thickness": thickness, "diameter": diameter}
    steps = Steps(branch, cycle, zero, preload, resample)
    steps.check()
    how = How(kinds, geometry(specimen, lengths), steps)
    kind, data = kind_of(job, model)
    if kind not in BUILT:
        raise InputError(
            f"is a {kind} document, a model is needed",
            file=model,
            key="format",
            remedy="give a material, contact, drape or press document, or a mold.toml",
        )
    if kind != "material":
        how.check(kind)
    chapter = importlib.import_module(f"hyperfab.chapters.close_loop.{BUILT[kind]}")
    _refuse_doubles(job, measured, [name for name in hold_out if name != "auto"])
    given = Given(
        model,
        data,
        measured,
        list(hold_out),
        noise,
        list(fix),
        None if prior is None else _share(prior),
        layout(columns, skip_rows, decimal),
        output,
        how,
    )
    status: int = chapter.run(job, given)
    return status


def _refuse_doubles(job: Job, measured: list[str], held: list[str]) -> None:
    """Refuse readings that would count twice, or take part and be predicted: whatever their files are called."""
    seen: dict[str, str] = {}
    for name, role in [
        *((name, "--measured") for name in measured),
        *((name, "--hold-out") for name in held),
    ]:
        other = seen.setdefault(sha256(job.inputs.read(name)).hexdigest(), name)
        if role == "--hold-out" and other in measured:
            what = "is" if other == name else f"holds the readings of {other}, which is"
            raise UsageError(
                f"--hold-out {name}: {what} also --measured; what the model is fitted to is no prediction"
            )
        if other is not name:
            what = "is given twice" if other == name else f"holds the very readings of {other}"
            raise UsageError(f"{name} {what}; its readings would count double")


def _share(prior: str) -> float:
    """Return the relative standard deviation of the model's own constants."""
    share = quantity(prior, "dimensionless", option="--prior")
    if not 0.0 < share <= 1.0:
        raise UsageError(
            f"--prior {prior}: is {share:.4g} of the value; give more than 0 and at most 100%, as 10%"
        )
    return share
