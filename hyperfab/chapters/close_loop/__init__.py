"""``hf close-loop``: hold a model against measured data, find what it lacks, add it, and say how sure that is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from typing import Any

from hyperfab.cases.loop import LoopCase
from hyperfab.chapters.close_loop.domain import Given, How, kind_of
from hyperfab.chapters.fit.prepare import steps_of
from hyperfab.chapters.fit.specimens import geometry
from hyperfab.chapters.job import Job
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import layout

#: The kinds of model that the loop can be closed on.
BUILT = ("material", "mold", "press", "contact", "drape")
_OF_A_PRESS = ("pressure", "contact", "thickness", "formed thickness", "height", "force")
#: Columns of readings that no test of a fabric has.
_NAMES = {
    "press": (*"xyz", "stroke", *_OF_A_PRESS, *(f"{name} sd" for name in _OF_A_PRESS)),
    "contact": ("depth", "force sd"),
    "drape": ("x0", "y0", *"xyzuvw", "x sd", "position sd"),
}


def run(job: Job, case: LoopCase) -> int:
    """Close the loop on the model of the case: 0, or 1 where the residual stays unexplained."""
    kinds = {name: test for test in ("uniaxial", "shear", "biaxial") for name in getattr(case, test)}
    if not case.readings:
        raise UsageError("nothing to compare with; give measured data as FILE.csv behind the model")
    how = How(kinds, geometry(case), steps_of(case))
    kind, data = kind_of(job, case.model)
    if kind not in BUILT:
        raise InputError(
            f"is a {kind} document, a model is needed",
            file=case.model,
            key="format",
            remedy="give a material, contact, drape or press document, or a mold.toml",
        )
    if kind != "material":
        how.check(kind)
    if case.upstream and kind not in ("press", "drape"):
        raise UsageError(f"--upstream is for a press or a drape document, and the model is a {kind}")
    _refuse_doubles(job, case.readings, case.held)
    told = layout(case.columns, case.skip_rows, case.decimal, own=names_of(kind, data))
    return domain_of(kind)(job, Given(data, case, told, how))


def names_of(kind: str, data: Mapping[str, Any]) -> Sequence[str]:
    """Return what columns may be called beside the names of a fabric's tests: of a mold, by the ``data`` of a document
    that is not checked yet, its probes, and the power of all its heaters and of each.

    >>> names_of("contact", {})
    ('depth', 'force sd')
    """
    if kind != "mold":
        return _NAMES.get(kind, ())
    probes, heaters = (found if isinstance(found := data.get(key), list) else [] for key in ("probe", "heater"))
    called = [one["name"] for one in probes if isinstance(one, Mapping) and isinstance(one.get("name"), str)]
    return [*called, "power", *(f"heater.{k}.power" for k in range(len(heaters)))]


def domain_of(kind: str) -> Callable[[Job, Given], int]:
    """Return what closes the loop on a kind of model; imported only when it is asked for."""
    domain: Callable[[Job, Given], int]
    if kind == "material":
        from hyperfab.chapters.close_loop.fabric import run as domain
    elif kind == "mold":
        from hyperfab.chapters.close_loop.heat import run as domain
    elif kind == "press":
        from hyperfab.chapters.close_loop.press import run as domain
    elif kind == "contact":
        from hyperfab.chapters.close_loop.contact import run as domain
    else:
        from hyperfab.chapters.close_loop.drape import run as domain
    return domain


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
            raise UsageError(f"--hold-out {name}: {what} also --measured; what the model is fitted to is no prediction")
        if other is not name:
            what = "is given twice" if other == name else f"holds the very readings of {other}"
            raise UsageError(f"{name} {what}; its readings would count double")
