"""A joint that does not conduct perfectly: ``[[contact]]`` of the mold document."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a resistance of the joints that conduct perfectly in the model, or in series with its joints.

    One for all, of each its own, closing as the mold warms up, or greater in places.
    """
    joints = context.opened + context.declared
    places = [f"resistance.{k}" for k in range(joints)]
    # A film of air of a few hundredths of a millimetre: 1e-3 m^2 K/W.
    all_of_them = tuple(places[: context.opened] or places)
    resistance = Constant("resistance_m2K_W", 0.0, 0.0, 0.1, 2e-4, places=all_of_them)
    forms = [Form("gap", (resistance,), ((3e-4,), (3e-3,)), ((5e-5,), (5e-4,)))]
    if joints > 1:
        each = [
            Constant(f"resistance_{k}_m2K_W", 0.0, 0.0, 0.1, 2e-4, places=(place,))
            for k, place in enumerate(places, start=1)
        ]
        probes = [tuple(5e-4 if i == k else 0.0 for i in range(joints)) for k in range(joints)]
        forms.append(Form("each", tuple(each), ((1e-3,) * joints, (1e-4,) * joints), tuple(probes)))
    if context.opened:
        uneven = [
            Constant(name, 0.0, -2.0, 2.0, 0.1, 0.5, (f"joint_{name}",))
            for name in ("from_middle", "along_x", "along_y")
        ]
        rise = context.rise_K
        warm = Constant("closing_per_K", 0.0, -0.9 / rise, 5.0 / rise, 0.05 / rise, places=("joint_per_K",))
        forms.append(Form("closing with warmth", (resistance, warm), ((1e-3, 0.0),), refines="gap"))
        if joints > 1:
            forms.append(
                Form(
                    "each, closing with warmth",
                    (warm, *each),
                    ((0.0, *(1e-3 for _ in each)),),
                    refines=("each", "closing with warmth"),
                )
            )
        forms.append(Form("uneven", (resistance, *uneven), ((1e-3, 0.0, 0.0, 0.0),), refines="gap"))
    return Effect(
        id="contact-resistance",
        title="parts that touch do not conduct perfectly",
        not_sought="" if joints else "the mold has one part",
        rides_on=("power_W", "probe"),
        shown_by="a thermocouple on each side of the joint",
        source="Yovanovich (2005), doi:10.1109/TCAPT.2005.848483",
        forms=tuple(forms),
    )
