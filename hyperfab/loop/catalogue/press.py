"""What the model of a press lacks on readings between the molds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.press_reading import Changes, Frame, Reading, Setting
from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form
from hyperfab.pressing import foam_law


@dataclass(frozen=True, kw_only=True)
class PressEffect(Effect):
    """An entry that is more than amounts at places: ``move`` adds to a press what it changes of it where the entry's
    constants have these values by name; a simpler form has fewer."""

    move: Callable[[Changes, Mapping[str, float]], None]


@dataclass(frozen=True)
class FoamContext:
    """What the model has of the sandwich: how thick [mm] its fabrics are, whether they give way across, whether a law
    says what stays of the foam's strain, and at which temperature [degC] its stiffness holds, None where several are
    told; whether it is as hot at each place as both molds, and whether it shrinks in the model already."""

    fabric_mm: float = 0.0
    across: bool = False
    sets: bool = False
    law_degC: float | None = None
    even: bool = True
    shrinks: bool = False


@dataclass(frozen=True)
class DataContext:
    """How the press was set, and what the model has of the sandwich; the largest force [N], the travel from the first
    touch [mm], and the longest time [s] that was read, None where none was.

    ``pressure_MPa`` is the foam's at half its thickness, ``temperatures`` [degC] those of the molds as readings were
    taken; ``strokes`` and ``formed`` tell whether strokes were read, and thickness after the press had opened.
    """

    setting: Setting
    foam: FoamContext
    force_N: float
    travel_mm: float
    time_s: float | None
    pressure_MPa: float
    temperatures: tuple[float, ...]
    strokes: bool
    formed: bool


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data; places are those of ``Changes.of``."""
    return (
        fabric_compression(context),
        foam_relaxation(context),
        foam_shrinkage(context),
        foam_softening(context),
        frame_compliance(context),
        lateral_shift(),
        set_of_foam(context),
        thermal_expansion(),
        thickness_variation(),
        tilt(context),
    )


def fabric_compression(context: DataContext) -> PressEffect:
    """Fabrics that give way across, ``fabric.compression`` of foam.toml: a strain in proportion to the pressure, or
    fabric that stiffens as it is pressed."""
    whole = 1.0 / context.pressure_MPa
    soft = Constant("compliance_1_MPa", 0.0, 0.0, 20.0 * whole, 0.02 * whole)
    stiffening = Constant("stiffening", 4.0, 0.5, 40.0, 1.0)
    starts = ((0.3 * whole, 4.0), (whole, 10.0))
    return PressEffect(
        id="fabric-compression",
        title="the fabrics give way across",
        not_sought="there is no fabric" if context.foam.fabric_mm <= 0.0 else HAS_IT if context.foam.across else "",
        shown_by="the thickness of the fabrics alone under rising pressure (ISO 5084)",
        source="a linear spring; B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, one term",
        forms=(
            Form("linear", (soft,), ((0.1 * whole,), (0.5 * whole,)), ((0.02 * whole,),)),
            Form("stiffening", (soft, stiffening), starts, ((0.1 * whole, 4.0),), refines="linear"),
        ),
        move=_give_way,
    )


def _give_way(press: Changes, at: Mapping[str, float]) -> None:
    soft = at["compliance_1_MPa"]
    if soft == 0.0:
        return
    if "stiffening" in at:
        # One term without a ratio of Poisson's: its modulus at rest is 2 mu.
        press.across = foam_law.hyperfoam(0.5 / soft, -at["stiffening"], 0.0)
    else:
        press.across = foam_law.linear(1.0 / soft)


def foam_relaxation(context: DataContext) -> PressEffect:
    """Foam whose pressure dies away while it is held, ``relaxation`` of foam.toml: a share of the pressure, and with
    readings over time its time."""
    share = Constant("share", 0.0, 0.0, 0.95, 0.03)
    forms = [Form("share", (share,), ((0.2,), (0.5,)), ((0.05,),))]
    if context.time_s is not None:
        whole, half = context.time_s, 0.3 * context.time_s
        time = Constant("time_s", half, 1e-3 * whole, 30.0 * whole, 0.1 * whole)
        power = Constant("power", 1.0, 0.2, 1.5, 0.1)
        starts, probes = ((0.2, half), (0.2, 0.1 * half)), ((0.05, half), (0.05, 0.1 * half))
        forms.append(Form("in time", (share, time), starts, probes))
        forms.append(Form("stretched", (share, time, power), ((0.2, half, 1.0),), refines="in time"))
    return PressEffect(
        id="foam-relaxation",
        title="the foam's pressure relaxes",
        shown_by="the force at a held gap over time",
        source="ISO 3385; one Maxwell branch, or Kohlrausch's stretched exponential",
        forms=tuple(forms),
        move=_fade,
    )


def _fade(press: Changes, at: Mapping[str, float]) -> None:
    """Let the pressure fade while it is held, or throughout where no time is known."""
    press.left.append(lambda reading: 1.0 - at["share"] * _come(at, reading))


def _come(at: Mapping[str, float], reading: Reading) -> Array | float:
    """Return the share of what comes in time that is there when a reading is taken; all where no time is known."""
    if "time_s" not in at or reading.time_s is None:
        return 1.0
    return np.asarray(-np.expm1(-((reading.time_s / at["time_s"]) ** at.get("power", 1.0))))


def foam_shrinkage(context: DataContext) -> PressEffect:
    """Foam that has lost thickness to heat, ``shrinkage`` of foam.toml: a share of its thickness, and with
    readings over time its time."""
    amount = Constant("amount", 0.0, 0.0, 0.8, 0.02)
    forms = [Form("share", (amount,), ((0.05,), (0.2,)), ((0.02,),))]
    if context.time_s is not None and not context.foam.shrinks:
        whole, half = context.time_s, 0.3 * context.time_s
        time = Constant("time_s", half, 1e-3 * whole, 30.0 * whole, 0.1 * whole)
        forms.append(Form("in time", (amount, time), ((0.05, half), (0.05, 0.1 * half)), ((0.02, half),)))
    return PressEffect(
        id="foam-shrinkage",
        title="the foam has shrunk",
        shown_by="the thickness of the foam before and after it was heated without load",
        source="ASTM D2126: response of rigid cellular plastics to heat",
        forms=tuple(forms),
        move=_shrink,
    )


def _shrink(press: Changes, at: Mapping[str, float]) -> None:
    """Let the foam lose thickness in time, or have lost it from the first where no time is known."""
    press.lost.append(lambda reading: at["amount"] * _come(at, reading))


def foam_softening(context: DataContext) -> PressEffect:
    """Foam that is softer when hot than where it was tested, a ``compression`` of several temperatures in foam.toml:
    the stress goes exponentially with temperature."""
    law, met = context.foam.law_degC, context.temperatures
    reason = ""
    if law is None:
        reason = HAS_IT
    elif not context.foam.even:
        reason = "the foam is not equally hot everywhere: leave out --dwell, and give both molds one temperature"
    elif max(abs(one - law) for one in met) < 1.0:
        reason = "no reading was taken at another temperature than the foam's law holds at"
    far = max(abs(one - (law or 0.0)) for one in met) or 1.0
    rate = Constant("softening_1_K", 0.0, -2.0 / far, 4.0 / far, 0.05 / far)
    forms = [Form("exponential", (rate,), ((0.3 / far,), (1.0 / far,)), ((0.05 / far,),))]
    if len(met) > 2:
        bend = Constant("softening_1_K2", 0.0, -4.0 / far**2, 4.0 / far**2, 0.05 / far**2)
        forms.append(Form("curved", (rate, bend), ((0.3 / far, 0.0),), ((0.0, 0.05 / far**2),), "exponential"))
    return PressEffect(
        id="foam-softening",
        title="the foam is softer when it is hot",
        not_sought=reason,
        shown_by="force over stroke with the molds cold",
        source="an exponential of temperature",
        forms=tuple(forms),
        move=partial(_soften, law or 0.0, context.setting.temperature),
    )


def softened(above: float, at: Mapping[str, float]) -> float:
    """Return the share of the foam's stress that is left ``above`` [K] where its law holds."""
    return float(np.exp(-(at["softening_1_K"] + at.get("softening_1_K2", 0.0) * above) * above))


def _soften(law_degC: float, molds_degC: float, press: Changes, at: Mapping[str, float]) -> None:
    """Take from the foam's pressure what it is softer by when each reading is taken."""

    def left(reading: Reading) -> float:
        here = molds_degC if reading.warmth is None else reading.warmth.temperature
        return softened(here - law_degC, at)

    press.left.append(left)


def frame_compliance(context: DataContext) -> PressEffect:
    """A press that yields under its force, ``[press] stiffness`` of foam.toml: the frame opens in proportion to it,
    or further while its joints have play, and is the stiffer the further they are closed."""
    whole = 1e3 * context.travel_mm / context.force_N
    unread = context.setting.force is not None and not context.strokes
    compliance = Constant("compliance_mm_kN", 0.0, 0.0, 20.0 * whole, 0.02 * whole)
    travel, force = context.travel_mm, context.force_N
    play = Constant("play_mm", 0.0, 0.0, travel, 0.02 * travel)
    taken_up = Constant("taken_up_N", 0.2 * force, 1e-3 * force, 3.0 * force, 0.1 * force)
    begins, probes = (tuple((much * travel, share * force) for share in (0.2, 0.02)) for much in (0.1, 0.02))
    return PressEffect(
        id="frame-compliance",
        added=True,
        title="the frame of the press yields",
        not_sought="the press is set by its force, and no stroke was read" if unread else "",
        shown_by="force over stroke with the molds metal on metal, or a dial gauge between the platens",
        source="a linear spring in series; joints that close as rough faces do",
        forms=(
            Form("spring", (compliance,), ((0.1 * whole,), (0.5 * whole,)), ((0.02 * whole,),)),
            Form("play", (play, taken_up), begins, probes),
            Form(
                "play and spring",
                (play, taken_up, compliance),
                ((*begins[0], 0.1 * whole),),
                refines=("play", "spring"),
            ),
        ),
        move=_open,
    )


def _open(press: Changes, at: Mapping[str, float]) -> None:
    press.frame = Frame(1e-3 * at.get("compliance_mm_kN", 0.0), at.get("play_mm", 0.0), at.get("taken_up_N", 1.0))


def _along_both(name: str, step: float) -> tuple[Constant, ...]:
    """Return a constant of that name for each of the two axes across, added where it is called so."""
    names = (name.format(axis) for axis in "xy")
    return tuple(Constant(one, 0.0, -5.0, 5.0, step, places=(one,)) for one in names)


def _both_ways(much: float) -> tuple[tuple[float, float], ...]:
    """Return starts of two constants: one of them, that ``much`` either way."""
    return (much, 0.0), (0.0, much), (-much, 0.0), (0.0, -much)


def lateral_shift() -> Effect:
    """A female mounted off the male's axis, ``[press] offset`` of foam.toml: a displacement along each of the two axes
    across the closing axis."""
    some = 0.1
    both = _along_both("offset_{}_mm", 0.5 * some)
    return Effect(
        id="lateral-shift",
        added=True,
        title="the molds are mounted off each other's axis",
        shown_by="the thickness on opposite flanks, and a dial gauge on the mounting face, which a tilt moves",
        source="rigid displacement",
        forms=(Form("displacement", both, _both_ways(2.0 * some), ((some, 0.0), (0.0, some))),),
    )


def set_of_foam(context: DataContext) -> Effect:
    """Foam that does not spring back from all of its compression, ``set`` of foam.toml: a share of the strain, the same
    of all or going with the strain."""
    reason = HAS_IT if context.foam.sets else ""
    share = Constant("share", 0.0, -1.0, 1.0, 0.05, places=("stays",))
    more = Constant("share_more", 0.0, -1.0, 1.0, 0.05, places=("stays_more",))
    return Effect(
        id="set",
        title="a share of the foam's compression stays",
        not_sought=reason if context.formed else "no thickness was read after the press had opened",
        shown_by="the thickness after the press has opened beside that in the closed press",
        source="ISO 1856: compression set",
        forms=(
            Form("share", (share,), ((0.3,), (0.8,)), ((0.05,),)),
            Form("with strain", (share, more), ((0.3, 0.0),), ((0.0, 0.05),), refines="share"),
        ),
    )


def thermal_expansion() -> Effect:
    """Molds that have grown with heat, ``expansion`` of foam.toml and the temperature of the press: thermal strain of
    both, or of each, beyond what the model has."""
    # 23e-6 1/K: aluminium, 100 K.
    strain = Constant("strain", 0.0, -0.03, 0.03, 2e-4, places=("strain_male", "strain_female"))
    more = Constant("female_more", 0.0, -0.03, 0.03, 2e-4, places=("strain_female",))
    return Effect(
        id="thermal-expansion",
        added=True,
        title="the molds have grown with heat",
        shown_by="the thickness of the sandwich on top and on the flanks, cold and hot",
        source="linear thermal expansion about the mounting face",
        forms=(
            Form("both molds", (strain,), ((2e-3,), (-2e-3,)), ((2e-4,),)),
            Form("each mold", (strain, more), ((2e-3, 0.0),), ((0.0, 2e-4),), refines="both molds"),
        ),
    )


def thickness_variation() -> Effect:
    """Foam that is not equally thick everywhere, ``variation`` of foam.toml: a wedge, a bowl, or both, or bent ones,
    over the plan of the male."""

    def terms(*names: str) -> tuple[Constant, ...]:
        return tuple(Constant(name, 0.0, -0.8, 0.8, 0.02, places=(f"uneven.{name}",)) for name in names)

    x, y, xx, xy, yy = terms("x", "y", "xx", "xy", "yy")
    cubes, fours = terms("xxx", "xxy", "xyy", "yyy"), terms("xxxx", "xxyy", "yyyy")
    some, zeros = 0.05, (0.0,) * 11
    wedge = _both_ways(some)
    return Effect(
        id="thickness-variation",
        title="the foam is not equally thick everywhere",
        shown_by="the thickness of the foam before it is pressed, at nine places",
        source="a polynomial over the plan",
        forms=(
            Form("wedge", (x, y), wedge, ((0.02, 0.0), (0.0, 0.02))),
            Form("bowl", (xx, yy), wedge[:1] + wedge[2:3], ((0.02, 0.0), (0.0, 0.02))),
            Form("quadric", (x, y, xx, xy, yy), ((some, *zeros[:4]),), ((*zeros[:4], 0.02),), refines="wedge"),
            Form("quadric of a bowl", (xx, yy, x, y, xy), ((some, *zeros[:4]),), refines="bowl"),
            Form("cubic", (x, y, xx, xy, yy, *cubes), ((some, *zeros[:8]),), refines="quadric"),
            Form("flat bowl", (xx, yy, *fours), ((some, *zeros[:4]),), refines="bowl"),
            Form(
                "quartic", (x, y, xx, xy, yy, *cubes, *fours), ((some, *zeros),), refines=("cubic", "flat bowl")
            ),
        ),
    )  # fmt: skip


def tilt(context: DataContext) -> Effect:
    """A female that stands out of parallel, ``[press] tilt`` of foam.toml: a rotation about each of the two axes across
    the closing axis."""
    edge = math.degrees(0.1 / context.setting.half_mm)
    both = _along_both("tilt_{}_deg", 0.5 * edge)
    return Effect(
        id="tilt",
        added=True,
        title="the molds are not parallel",
        not_sought="a floating female finds its own tilt" if context.setting.floating else "",
        shown_by="pressure or thickness on opposite sides of the mold",
        source="rigid rotation, Rodrigues' formula",
        forms=(Form("rotation", both, _both_ways(2.0 * edge), ((edge, 0.0), (0.0, edge))),),
    )
