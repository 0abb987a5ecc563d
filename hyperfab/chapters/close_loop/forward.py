"""The mold that the loop writes, run as ``hf mold-heat`` runs it: does it read what the loop says it does?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.problem import MoldBuilder
from hyperfab.chapters.mold_heat.recipe import heated
from hyperfab.chapters.rerun import Overlay
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import HyperfabError
from hyperfab.io.output import Output
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.engine import Finding
from hyperfab.loop.heat import HeatProblem
from hyperfab.thermal.history import curve, curve_times
from hyperfab.thermal.sensors import as_shown

#: Share of the noise from which on it is told what the written mold reads beside what the loop predicts.
_TOLD = 0.1


def written_otherwise(
    files: Mapping[str, bytes], out: Output, given: MoldBuilder, problem: HeatProblem, found: Finding
) -> Iterator[str]:
    """Yield by how much the written mold differs from what is predicted, where that is not small beside the noise.

    ``files`` are those that will be written, by suffix; ``given`` has built the mold that was given. It takes a run of
    the whole mold, and is asked where an effect was added and materials change with temperature: all else the reduced
    mold answers for to a share of that. A thermostat that was seen to switch is not followed.
    """
    changing = "property-drift" in found.after.ids or problem.runs[0].mold.changes.shape[2] > 1
    ruled = any(heater.control is not None for heater in given.document.heater)
    if not found.after.ids or not changing or ruled:
        return
    path = str(out.path(".model.toml"))
    times, kept = problem.runs[0].times, problem.runs[0].kept
    try:
        document = parse_document(load_toml(files[".model.toml"], path), path, MoldDocument)
        builder = MoldBuilder(document, path, Overlay({str(out.path(suffix)): data for suffix, data in files.items()}))
        builder.take_mesh(given)
        read = _read(builder, problem, times).ravel()[kept]
    except HyperfabError as error:
        yield f"hf mold-heat does not run with what was found: {error}"
        return
    known = np.isfinite(read)
    off = (read - found.after.fit.predicted)[known]
    if not len(off):
        return
    size, noise = float(np.sqrt(np.mean(off**2))), float(np.sqrt(np.mean(found.noise.sd[known] ** 2)))
    if size > _TOLD * noise:
        yield (
            f"the mold as it is written reads {size:.2g} K (rms, {np.max(np.abs(off)):.2g} K at most) beside what is "
            f"predicted here, {100.0 * size / noise:.2g} % of the noise: hf mold-heat computes it on all of its mesh"
        )


def _read(builder: MoldBuilder, problem: HeatProblem, times: Array) -> Array:
    """Return what the probes of a mold show at ``times`` (t,) [s], (probes, t) [degC]; nan before it begins."""
    document = builder.document
    built = builder.build()
    until = document.run.model_copy(update={"until": float(times[-1]), "target": None})
    whole = document.model_copy(update={"run": until})
    history = heated(whole, built, builder.start_field(built), lambda fraction, text="": None)
    at = curve_times(history)
    shown = [as_shown(at, curve(history, built.probes[name], at), built.lags[name]) for name in problem.names]
    return np.array([np.where(times < at[0], np.nan, np.interp(times, at, row)) for row in shown])
