"""How sure an extended model is: the covariance of all that was fitted, as the numbers of its document have it, and the
mark of terms beside which something stays unexplained, in the model and in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.documents.certainty import FitUncertainty
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import Fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.replicates import CLOTH_COUNTS
from hyperfab.numerics.propagation import Source

#: Steps of differences, over a standard deviation; no constant moves by more than a share of itself and a little.
_STEP, _SHARE, _LEAST = 0.02, 0.01, 1e-6


def tell_sure(
    document: MaterialDocument, found: Finding, extended: Callable[[Fit], MaterialDocument], specimens: int
) -> None:
    """Write into an extended ``document`` how sure its numbers are, and into its effects each constant's own.

    ``extended`` makes the document of a fit: constants of a document are not those of the fit, where one law is told
    along warp and weft or at each temperature. Nothing is written where the data leave a constant open.
    """
    for record in document.effects or []:
        record.pop("parameters_sd", None)  # of the constants it had
    fit, noise = found.after.fit, found.noise
    readings, differ = errors_of_constants(found)
    covariance = readings + differ
    if not np.isfinite(covariance).all() or not covariance.any():
        return
    names = [place for place, _ in numbers(document.to_json())]

    def at(x: Array) -> Array:
        known = dict(numbers(extended(replace(fit, x=x)).to_json()))
        return np.array([known.get(name, np.nan) for name in names])

    root = Source("", covariance).root
    columns = []
    for way in root.T:
        # Constants that the data leave open have standard deviations beyond all that a law stands.
        step = min(_STEP, float(np.min((_SHARE * np.abs(fit.x) + _LEAST) / np.maximum(np.abs(way), 1e-300))))
        columns.append((at(fit.x + step * way) - at(fit.x - step * way)) / (2.0 * step))
    along = np.array(columns).T
    if not np.isfinite(along).all():
        return
    sd = dict(zip(names, np.sqrt((along**2).sum(axis=1)), strict=True))
    for index, record in enumerate(document.effects or []):
        places = {name: f"effects.{index}.parameters.{name}" for name in record["parameters"]}
        record["parameters_sd"] = {name: float(sd[place]) for name, place in places.items() if place in sd}
    document.joint_uncertainty = FitUncertainty(
        order=names,
        covariance=(along @ along.T).tolist(),
        specimens=specimens,
        degrees_of_freedom=_freedom(along, np.linalg.pinv(root) @ differ @ np.linalg.pinv(root).T, noise),
        source="specimens" if noise.gain_sd > 0.0 else "readings",
    )


def errors_of_constants(found: Finding) -> tuple[Array, Array]:
    """Return the covariance of the constants of the model with its effects, (k, k), by the readings and by how
    specimens differ; where something is left, the readings scatter by more than their noise."""
    scale = max(found.after.judgement.chi2_reduced, 1.0)
    readings, differ = found.after.fit.errors(found.noise)
    return readings * scale, differ * scale


def _freedom(along: Array, differ: Array, noise: Noise) -> float:
    """Return the least degrees of freedom of numbers that go ``along`` (n, r) unit directions, of whose covariance
    (r, r) so much is by how specimens ``differ``; 0 where they are known beyond doubt (Welch and Satterthwaite)."""
    whole = (along**2).sum(axis=1)
    apart = np.einsum("ik,kl,il->i", along, differ, along)
    known = whole > 0.0
    share = np.clip(apart[known] / whole[known], 0.0, 1.0)
    # Where none were led alike, the scatter that all tell counts what is usual of one cloth.
    free = sum(len(which) - 1 for which in noise.alike) or CLOTH_COUNTS
    unsure = float(np.max(share**2 / free + (1.0 - share) ** 2 / noise.dof, initial=0.0))
    return 1.0 / unsure if unsure else 0.0


def numbers(data: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Yield the constants of a material document, plain data, by their place in it.

    >>> list(numbers({"parameters": {"C10_MPa": 0.2}, "effects": [{"id": "rate", "parameters": {"g": 0.1}}]}))
    [('parameters.C10_MPa', 0.2), ('effects.0.parameters.g', 0.1)]
    """
    inside = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in inside:
        at = f"{place}.{key}" if place else str(key)
        if key == "parameters":
            yield from ((f"{at}.{name}", one) for name, one in value.items() if isinstance(one, float))
        elif key in ("directions", "temperatures", "effects", "warp", "weft") or isinstance(key, int):
            yield from numbers(value, at)


def mark(records: Iterable[dict[str, Any]], found: Finding) -> None:
    """Mark the terms of a model's ``effects`` that were added though something stays unexplained; unmark all where
    nothing does."""
    for record in records:
        if found.verdict != "unexplained":
            record.pop("tentative", None)
        elif record.get("id") in found.after.ids:
            record["tentative"] = True


def caution(found: Finding) -> str:
    """Return what is to be said of a model with such terms; empty where it has none."""
    if found.verdict != "unexplained" or not found.after.ids:
        return ""
    names = list(found.after.ids)
    are = "are the nearest" if len(names) > 1 else "is the nearest"
    return (
        f"{', '.join(names)} {are} that the catalogue has, though something stays unexplained: constants of the "
        "extended model may stand for what is not in it, and it is no better than these data beyond them"
    )


def noted(text: str, toml: bytes) -> bytes:
    """Return a TOML document with ``text`` as a comment at its head.

    >>> noted("take care", b"a = 1"), noted("", b"a = 1")
    (b'# take care\\na = 1', b'a = 1')
    """
    return f"# {text}\n".encode() + toml if text else toml
