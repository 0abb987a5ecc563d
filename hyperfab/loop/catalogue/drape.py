"""What the model of a draped sheet lacks on markers."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.loop.problem import Constant, Effect, Form


@dataclass(frozen=True)
class DataContext:
    """How far the effects may go: added prestretch (down, up), coefficient of friction, shear modulus [MPa], mass per
    area [g/m^2], the mold's size (a share of it), its middle from the sheet's [mm]."""

    prestretch: tuple[float, float]
    friction: float
    shear: float
    mass: float
    larger: float = 0.0
    aside: float = 0.0


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    return (
        friction(context),
        gravity(context),
        pretension(context),
        shear_stiffness(context),
        biaxial_coupling(context),
        mold_size(context),
        lateral_shift(context),
    )


def friction(context: DataContext) -> Effect:
    """Coulomb friction between sheet and mold, ``--friction``: a coefficient, added to the model's own."""
    mu = Constant("mu", 0.0, 0.0, max(context.friction, 1e-9), 0.05, places=("friction",))
    return Effect(
        id="friction",
        added=True,
        title="the sheet rubs on the mold",
        shown_by="the same drape with the mold polished, or with a film of grease",
        source="Coulomb's law",
        forms=(Form("Coulomb", (mu,), ((0.1,), (0.35,)), ((0.05,),)),) if context.friction else (),
    )


def gravity(context: DataContext) -> Effect:
    """The sheet's own weight, ``--mass``: a mass per area."""
    most = context.mass
    mass = Constant("mass_g_m2", 0.0, 0.0, most, 0.02 * most, places=("mass",))
    return Effect(
        id="gravity",
        title="the sheet hangs under its own weight",
        shown_by="the sheet on a scale; or the sag of the mounted sheet before it is draped",
        source="weight of the nodes' shares",
        forms=(Form("weight", (mass,), ((0.1 * most,), (0.5 * most,)), ((0.03 * most,),)),),
    )


def pretension(context: DataContext) -> Effect:
    """A sheet mounted taut or slack, ``--prestretch``: its stretch as mounted, alike along warp and weft, or not."""
    down, up = context.prestretch
    slack = ((-0.4 * down,),) if down > 0.0 else ()
    both = Constant("added_stretch", 0.0, -down, up, 0.005, places=("prestretch",))
    more = Constant("weft_more", 0.0, -up, up, 0.005, places=("weft more",))
    return Effect(
        id="pretension",
        added=True,
        title="the sheet was mounted under tension",
        shown_by="the force of the press over the first tenth of its way; markers where the sheet hangs free",
        source="springs shorter than the mounted sheet",
        forms=(
            Form("even", (both,), ((0.02,), (0.08,), *slack), ((0.005,),)),
            Form("each way", (both, more), ((0.03, 0.0),), ((0.0, 0.005),), refines="even"),
        ),
    )


def shear_stiffness(context: DataContext) -> Effect:
    """Threads that resist turning against each other, ``--shear-modulus``: a shear modulus, added to the model's own;
    a membrane's law has its own shear."""
    most = context.shear
    modulus = Constant("modulus_MPa", 0.0, 0.0, most, 0.02 * most, places=("shear",))
    form = Form("linear", (modulus,), ((0.1 * most,), (0.5 * most,)), ((0.03 * most,),))
    return Effect(
        id="shear-stiffness",
        added=True,
        title="the fabric resists shear",
        shown_by="a bias test, cut at 45 degrees to the warp; or markers on the diagonals",
        source="energy of the angle between the threads, G gamma^2/2",
        forms=(form,) if most else (),
        not_sought="" if most else "the law of a membrane has its own shear",
    )


def biaxial_coupling(context: DataContext) -> Effect:
    """Warp and weft that answer to each other, ``--sheet membrane``: no amount to be found, but another sheet."""
    net = bool(context.shear)  # a membrane's law leaves none of it to be found
    return Effect(
        id="biaxial-coupling",
        title="warp and weft are coupled",
        shown_by="a biaxial test of the fabric; or the force of the press",
        source="the fabric's own law as a membrane",
        forms=(),
        not_sought="a net has no amount of it: drape with --sheet membrane, and close the loop on that"
        if net
        else "a membrane's law has its own coupling",
    )


def mold_size(context: DataContext) -> Effect:
    """A mold of another size than its surface is drawn with: by one share all ways, or across the way it is pushed."""
    most = context.larger
    ways = (
        ("all ways", "larger", ("mold width", "mold height")),
        ("across", "wider", ("mold width",)),
    )
    return Effect(
        id="mold-size",
        title="the mold is larger or smaller than its drawing",
        shown_by="the mold's width and height, by a calliper",
        source="geometric similarity, about the middle of the mold's top",
        forms=tuple(
            Form(name, (Constant(key, 0.0, -most, most, 0.005, places=places),), ((0.01,), (-0.01,)), ((0.003,),))
            for name, key, places in (ways if most else ())
        ),
        not_sought="" if most else "the sheet finds no rest on a mold of another size",
        of_document=True,
    )


def lateral_shift(context: DataContext) -> Effect:
    """A mold off the middle of the sheet, ``--offset``: added to where the model has it."""
    most = context.aside
    x, y = (Constant(f"offset_{axis}_mm", 0.0, -most, most, 0.02 * most, places=(f"aside {axis}",)) for axis in "xy")
    some, little = 0.2 * most, 0.03 * most
    form = Form("displacement", (x, y), ((some, 0.0), (0.0, some)), ((little, 0.0), (0.0, little)))
    return Effect(
        id="lateral-shift",
        added=True,
        title="the mold stands off the middle of the sheet",
        shown_by="the distances from the mold to the clamps, by a calliper, before it is pushed up",
        source="geometry",
        forms=(form,) if most else (),
        not_sought="" if most else "the sheet finds no rest on a mold off its middle",
    )
