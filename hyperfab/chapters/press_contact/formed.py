"""What stays when the press opens: the formed thickness at every place, and where it misses the one that is wanted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.cases.kinds import Amount, AmountOrFile
from hyperfab.cases.press import PressCase
from hyperfab.chapters.job import Job
from hyperfab.documents.foam import ArrheniusSet, FoamDocument, MeasuredSet
from hyperfab.documents.press import FormedPart, SetPart, WantedPart
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError, placed
from hyperfab.io.csv_table import Table as Rows
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.mold import PressFrame
from hyperfab.pressing.setting import Arrhenius, SetLaw, Share, Table, identified, stays
from hyperfab.pressing.warming import Column

#: Measured thicknesses that say no share: pressed by less than this share of the thickness before.
_LEAST_STRAIN = 0.01
#: Shares outside 0 to 1 by less than this only scatter.
_SCATTER = 0.05
#: Strains of a table that differ by less are one.
_SAME_STRAIN = 1e-6


@dataclass(frozen=True)
class Setting:
    """A set law, how it is called, where it is from, the error with which it was identified, and the temperatures
    [degC], dwells [s] and strains that were tested."""

    law: SetLaw
    name: str
    source: str
    rms: float | None = None
    known: tuple[Array, Array, Array] | None = None


@dataclass(frozen=True)
class Formed:
    """At the front: the ``thickness`` (n,) [mm] that stays, ``springback`` (n,) [mm] from the closed press, the
    ``share`` of the foam's strain that stays, where any is ``pressed``, the hottest the foam becomes (n,) [degC]."""

    setting: Setting
    thickness: Array
    springback: Array
    share: Array
    pressed: Flags
    hottest: Array


def read_setting(job: Job, name: str, document: FoamDocument) -> Setting | None:
    """Return the set law of ``foam.toml``, None where it has none; InputError where its file is not sound."""
    given = document.set
    if given is None:
        return None
    if isinstance(given, ArrheniusSet):
        return Setting(Arrhenius(given.rate, given.activation), "arrhenius", name)
    if isinstance(given, MeasuredSet):
        path = Inputs.beside(name, given.measured)
        rows, strain, share = _tests(job, path, document)
        with placed(path, remedy='add tests, or give set = { table = "..." }'):
            law, rms = identified(rows["temperature"], rows["dwell"], share)
        known = rows["temperature"], rows["dwell"], strain
        return Setting(law, "arrhenius", path, rms, known)
    if isinstance(given, TableFile):
        path = Inputs.beside(name, given.table)
        rows, strain, share = _tests(job, path, document)
        table = _table(path, rows, strain, share)
        return Setting(table, "table", path, None, (table.temperatures, table.dwells, table.strains))
    return Setting(Share(float(given)), "share", name)


def formed(setting: Setting, column: Column, dwell: float, closed: Closed) -> Formed:
    """Return what stays of the pressed sandwich after a dwell [s]; its fabrics spring back."""
    sandwich, gap = closed.press.sandwich, closed.contact.gap
    foam = np.broadcast_to(np.asarray(sandwich.foam, dtype=float), gap.shape)
    now, fabric = sandwich.pressed(gap)
    strain = 1.0 - now / foam
    share, hottest = stays(setting.law, column.at_depths, dwell, strain)
    thickness = np.asarray(sandwich.thickness - share * strain * foam)
    return Formed(setting, thickness, thickness - now - fabric, share, strain > 0.0, hottest)


def note_ranges(job: Job, found: Formed, dwell: float, closed: Closed) -> None:
    """Note where the set law was used, beside what was tested."""
    if found.setting.known is None or not found.pressed.any():
        return
    temperature, dwells, strain = found.setting.known
    source, there = found.setting.source, found.pressed
    colder, later = "extrapolated", "extrapolated"
    if found.setting.name == "table":
        colder, later = "below nothing sets, above as at the hottest", "no more sets later"
    job.ranges.used("set temperature_degC", found.hottest[there], known=temperature, source=source, then=colder)
    job.ranges.used("set dwell_s", [dwell], known=[0.0, *dwells], source=source, then=later)
    if len(np.unique(strain)) > 1:
        met = closed.press.sandwich.strain(closed.contact.gap)[there]
        job.ranges.used("set strain", met, known=strain, source=source, then="the nearest strain holds")


def part_of(found: Formed, closed: Closed, places: Array) -> FormedPart:
    """Return what the document tells; ``places`` (n, 3) [mm] are the front's vertices as they are drawn."""
    area = closed.front.molding_areas
    there = np.flatnonzero(area > 0.0)
    thickness, back = found.thickness, found.springback
    pressed = found.pressed & (area > 0.0)
    share = found.share[pressed] if pressed.any() else np.zeros(1)
    weights = area[pressed] if pressed.any() else np.ones(1)
    law = found.setting.law
    return FormedPart(
        thickness_min_mm=float(thickness[there].min()),
        thickness_mean_mm=float(np.average(thickness, weights=area)),
        thickness_max_mm=float(thickness[there].max()),
        thinnest_at_mm=place(places[int(there[np.argmin(thickness[there])])]),
        springback_mean_mm=float(np.average(back[pressed], weights=weights)) if pressed.any() else 0.0,
        springback_max_mm=float(back[pressed].max()) if pressed.any() else 0.0,
        set=SetPart(
            law=found.setting.name,
            source=found.setting.source.rsplit("/", 1)[-1],
            rate_1_s=law.rate if isinstance(law, Arrhenius) else None,
            activation_J_mol=law.activation if isinstance(law, Arrhenius) else None,
            rms=found.setting.rms,
            share_min=float(share.min()),
            share_mean=float(np.average(share, weights=weights)),
            share_max=float(share.max()),
        ),
    )


class Wanted:
    """The thickness that is wanted: one, or by place, linear in the plan across the closing axis, nearest beyond."""

    def __init__(self, job: Job, case: PressCase, frame: PressFrame) -> None:
        assert case.wanted is not None
        kind = AmountOrFile(item=Amount("length", "3mm", above=0.0))
        self.even = kind.amount(case.wanted, "--wanted")
        self.within = case.within
        if self.even is not None:
            return
        columns = dict.fromkeys(("x", "y", "z", "thickness"), "length")
        rows = read_table(job.inputs.read(case.wanted), case.wanted, columns)
        remedy = "leave out places where nothing is wanted"
        if len(rows.lines) == 0:
            raise InputError("wants nothing anywhere", file=case.wanted, column="thickness", remedy=remedy)
        why = "a wanted thickness is more than 0"
        rows.refuse(rows["thickness"] <= 0.0, why, column="thickness", remedy=remedy)
        self._points = frame.inward(np.stack([rows[name] for name in "xyz"], axis=1))[:, :2]
        self._values = rows["thickness"]

    def at(self, places: Array) -> Array:
        """Return what is wanted (n,) [mm] at ``places`` (n, 3) [mm] of the press frame, on the drawing."""
        if self.even is not None:
            return np.full(len(places), self.even)
        from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
        from scipy.spatial import QhullError

        plan = places[:, :2]
        nearest = np.asarray(NearestNDInterpolator(self._points, self._values)(plan), dtype=float)
        try:
            found = np.asarray(LinearNDInterpolator(self._points, self._values)(plan), dtype=float)
        except QhullError:  # two places, or places on a line, span no plan
            return nearest
        return np.where(np.isnan(found), nearest, found)

    def beside(self, found: Formed, closed: Closed, frame: PressFrame) -> WantedPart:
        """Return by how much the product misses it."""
        area = closed.front.molding_areas
        there = np.flatnonzero(area > 0.0)
        wanted = self.at(closed.cold)
        off = found.thickness - wanted
        worst = int(there[np.argmax(np.abs(off[there]))])
        return WantedPart(
            wanted_min_mm=float(wanted[there].min()),
            wanted_max_mm=float(wanted[there].max()),
            worst_mm=float(off[worst]),
            worst_at_mm=place(frame.outward(closed.cold)[worst]),
            rms_mm=float(np.sqrt(np.average(off**2, weights=area))),
            tolerance_mm=self.within,
            outside_area_fraction=float(area[np.abs(off) > self.within].sum() / area.sum()),
        )


def place(point: Array) -> tuple[float, float, float]:
    """Return a point (3,) as a document tells it, without negative zeros."""
    x, y, z = (float(value) + 0.0 for value in point)
    return x, y, z


def _tests(job: Job, path: str, document: FoamDocument) -> tuple[Rows, Array, Array]:
    """Return the rows of a file of set tests, with strain and share of each."""
    lengths = dict.fromkeys(("before", "pressed", "after"), "length")
    rows = read_table(
        job.inputs.read(path),
        path,
        {"temperature": "temperature", "dwell": "time"},
        optional={"strain": "dimensionless", "set": "dimensionless", **lengths},
    )
    if len(rows.lines) == 0:
        raise InputError("has no test", file=path, remedy="give temperature [degC], dwell [s] and set [-]")
    rows.refuse(rows["dwell"] <= 0.0, "a dwell is more than 0", column="dwell", remedy="leave the row out")
    if "set" in rows:
        share = rows["set"]
        strain = rows["strain"] if "strain" in rows else np.zeros(len(share))
        column = "set"
    elif "pressed" in rows and "after" in rows:
        before = rows["before"] if "before" in rows else np.full(len(rows.lines), document.thickness)
        strain = 1.0 - rows["pressed"] / before
        thin = strain < _LEAST_STRAIN
        why = "was not pressed: no strain can stay"
        rows.refuse(thin, why, column="pressed", remedy="leave the row out")
        share, column = (before - rows["after"]) / (before - rows["pressed"]), "after"
    else:
        raise InputError(
            "does not say what stayed",
            file=path,
            column="set",
            remedy="give set [-], the share of the strain that stays, or before, pressed and after [mm]",
        )
    outside = (share < -_SCATTER) | (share > 1.0 + _SCATTER)
    why = "the share of the strain that stays is between 0 and 1"
    rows.refuse(outside, why, column=column, remedy="check the row")
    return rows, strain, np.clip(share, 0.0, 1.0)


def _table(path: str, rows: Rows, strain: Array, share: Array) -> Table:
    """Return the table of rows that are a full grid of temperatures, dwells and strains."""
    axes = [np.unique(rows["temperature"]), np.unique(rows["dwell"]), np.unique(strain.round(6))]
    shape = tuple(len(axis) for axis in axes)
    at = tuple(
        np.searchsorted(axis, value - _SAME_STRAIN)
        for axis, value in zip(axes, (rows["temperature"], rows["dwell"], strain), strict=True)
    )
    count = np.zeros(shape, dtype=int)
    np.add.at(count, at, 1)
    if (count != 1).any():
        missing = np.argwhere(count != 1)[0]
        t, d, e = (axis[i] for axis, i in zip(axes, missing, strict=True))
        what = "twice" if count[tuple(missing)] else "not"
        raise InputError(
            f"{t:g} degC, {d:g} s and a strain of {e:g} are {what} tested: a table has each combination once",
            file=path,
            remedy='complete it, or identify a law from it: set = { measured = "..." }',
        )
    shares = np.zeros(shape)
    shares[at] = share
    falls = np.argwhere(np.diff(shares, axis=1) < 0.0)
    if len(falls):
        t, d, e = (axis[i] for axis, i in zip(axes, falls[0] + [0, 1, 0], strict=True))
        raise InputError(
            f"less has set after {d:g} s at {t:g} degC (strain {e:g}) than sooner",
            file=path,
            column="set",
            remedy='smooth the readings, or identify a law from them: set = { measured = "..." }',
        )
    return Table(axes[0], axes[1], axes[2], shares)
