"""Heat that leaves through faces the model takes as insulated."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a conductance to the ambient through the outer faces without a film, to a bench that may
    warm up, or more in places."""
    h = Constant("h_W_m2K", 0.0, 0.0, 2000.0, 0.3 * context.typical_film, places=("bench",))
    share = Constant("bench_share", 0.0, 0.0, 0.95, 0.1, 0.5, ("bench_share",))
    time = Constant(
        "bench_s",
        0.2 * context.duration_s,
        0.01 * context.duration_s,
        3.0 * context.duration_s,
        0.05 * context.duration_s,
        places=("bench_s",),
    )
    uneven = [
        Constant(name, 0.0, -2.0, 2.0, 0.1, 0.5, (f"bench_{name}",))
        for name in ("from_middle", "along_x", "along_y")
    ]
    return Effect(
        id="base-conduction",
        title="heat leaves through the base",
        not_sought="" if context.bench else "every outer face has a film",
        rides_on=("above ambient_K", "probe"),
        shown_by="a thermocouple in the base plate beside one at the work surface, over a cool-down",
        source="Newton's law of cooling at the support",
        forms=(
            Form(
                "film",
                (h,),
                ((context.typical_film,), (10.0 * context.typical_film,)),
                ((0.1 * context.typical_film,),),
            ),
            Form(
                "bench that warms up",
                (h, share, time),
                ((1.0, 0.3, 0.2 * context.duration_s), (context.typical_film, 0.7, 0.3 * context.duration_s)),
                ((0.3 * context.typical_film, 0.5, 0.2 * context.duration_s),),
                refines="film",
            ),
            Form("uneven", (h, *uneven), ((1.0, 0.0, 0.0, 0.0),), refines="film"),
        ),
    )
