"""What the model of a heated mold lacks on thermocouple readings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form

#: What the air of a room does: so far over a shift, with its doors, and so fast when it is heated or aired.
FARTHEST_K, FASTEST_K_S = 20.0, 0.01
#: Periods of a swing that are looked for, and times in which a joint closes, by a law of decay or evenly, as shares of
#: the run.
_SWINGS, _CLOSING, _EVENLY = (0.9, 0.6, 0.4, 0.27), (0.2, 0.04), (0.5, 0.2)
#: What a log that was begun before or after the run is called beside the lag of sensors, and what shows it.
CLOCK = "clock of the log"
CLOCK_SHOWN_BY = "note by the log's own clock when the heaters switch, or log their power beside the probes"


@dataclass(frozen=True)
class DataContext:
    """Length of the experiment, its rise of temperature, and what the mold has.

    ``opened`` counts joints that conduct perfectly in the model, ``declared`` the others; ``bench`` says whether
    faces have no film.
    """

    duration_s: float
    rise_K: float
    power_W: float
    films: int
    heaters: int
    opened: int
    declared: int
    probes: int
    bench: bool
    emits: bool
    typical_film: float


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    return (
        ambient_drift(context),
        base_conduction(context),
        contact_resistance(context),
        convection_law(context),
        power_loss(context),
        property_drift(context),
        radiation(context),
        sensor_lag(context),
    )


def ambient_drift(context: DataContext) -> Effect:
    """Surroundings that warm up or cool down during the run: ambient linear in time, quadratic, cubic; or
    that swing."""
    whole = context.duration_s
    most = min(FARTHEST_K / whole, FASTEST_K_S)
    far, step = 4.0 * most, 2.0 / whole
    slope = Constant("drift_K_s", 0.0, -far, far, step, places=("ambient_per_s",))
    far, step = 4.0 * most / whole, 2.0 / whole**2
    bend = Constant("drift_K_s2", 0.0, -far, far, step, places=("ambient_per_s2",))
    far, step = 8.0 * most / whole**2, 2.0 / whole**3
    twist = Constant("drift_K_s3", 0.0, -far, far, step, places=("ambient_per_s3",))
    # A swing of the day, or of a thermostat in the hall.
    sine, cosine = (
        Constant(f"swing_{way}_K", 0.0, -FARTHEST_K, FARTHEST_K, 1.0, places=(f"ambient_{way}_K",))
        for way in ("sin", "cos")
    )
    period = Constant("period_s", whole, 0.05 * whole, 4.0 * whole, 0.1 * whole, places=("ambient_period_s",))
    begins = tuple((1.0, 1.0, share * whole) for share in _SWINGS)
    swings = tuple((*way, share * whole) for share in _SWINGS for way in ((1.0, 0.0), (0.0, 1.0)))
    return Effect(
        id="ambient-drift",
        title="the ambient changes with time",
        not_sought="" if context.films else "no face has a film",
        shown_by="a thermometer in the air, away from the mold",
        source="Newton's law of cooling with a moving ambient",
        forms=(
            Form("linear", (slope,), ((8.0 / whole,), (-8.0 / whole,)), ((2.0 / whole,),)),
            Form("quadratic", (slope, bend), ((8.0 / whole, 0.0),), refines="linear"),
            Form("cubic", (slope, bend, twist), ((8.0 / whole, 0.0, 0.0),), refines="quadratic"),
            Form("swing", (sine, cosine, period), begins, swings, screened=True),
        ),
    )


def _uneven(what: str) -> list[Constant]:
    """Return how much more a face or a joint conducts in places."""
    ways = ("from_middle", "along_x", "along_y")
    return [Constant(way, 0.0, -2.0, 2.0, 0.1, 0.5, (f"{what}_{way}",)) for way in ways]


def base_conduction(context: DataContext) -> Effect:
    """Heat that leaves through faces the model takes as insulated: a conductance to the ambient through the outer faces
    without a film, to a bench that may warm up, or more in places."""
    whole, film = context.duration_s, context.typical_film
    h = Constant("h_W_m2K", 0.0, 0.0, 2000.0, 0.3 * film, places=("bench",))
    share = Constant("bench_share", 0.0, 0.0, 0.95, 0.1, 0.5, ("bench_share",))
    time = Constant("bench_s", 0.2 * whole, 0.01 * whole, 3.0 * whole, 0.05 * whole, places=("bench_s",))
    return Effect(
        id="base-conduction",
        title="heat leaves through the base",
        not_sought="" if context.bench else "every outer face has a film: name what it stands on in [[insulated]]",
        shown_by="a thermocouple in the base plate beside one at the work surface, over a cool-down",
        source="Newton's law of cooling at the support",
        forms=(
            Form("film", (h,), ((film,), (10.0 * film,)), ((0.1 * film,),)),
            Form(
                "bench that warms up",
                (h, share, time),
                ((1.0, 0.3, 0.2 * whole), (film, 0.7, 0.3 * whole)),
                ((0.3 * film, 0.5, 0.2 * whole),),
                refines="film",
            ),
            Form("uneven", (h, *_uneven("bench")), ((1.0, 0.0, 0.0, 0.0),), refines="film"),
        ),
    )


def contact_resistance(context: DataContext) -> Effect:
    """A joint that does not conduct perfectly, ``[[contact]]`` of the mold document: a resistance of the joints that
    conduct perfectly in the model, or in series with its joints.

    One for all, of each its own, closing as the mold warms up or as time goes on, or greater in places.
    """
    joints = context.opened + context.declared
    places = [f"resistance.{k}" for k in range(joints)]
    # A film of air of a few hundredths of a millimetre: 1e-3 m^2 K/W.
    all_of_them = tuple(places[: context.opened] or places)
    resistance = Constant("resistance_m2K_W", 0.0, 0.0, 0.1, 2e-4, places=all_of_them)
    forms = [Form("gap", (resistance,), ((3e-4,), (3e-3,)), ((5e-5,), (5e-4,)))]
    each = [
        Constant(f"resistance_{k}_m2K_W", 0.0, 0.0, 0.1, 2e-4, places=(place,))
        for k, place in enumerate(places, start=1)
    ]
    if joints > 1:
        probes = [tuple(5e-4 if i == k else 0.0 for i in range(joints)) for k in range(joints)]
        forms.append(Form("each", tuple(each), ((1e-3,) * joints, (1e-4,) * joints), tuple(probes)))
    if context.opened:
        rise = context.rise_K
        warm = Constant("closing_per_K", 0.0, -0.9 / rise, 5.0 / rise, 0.05 / rise, places=("joint_per_K",))
        forms.append(Form("closing with warmth", (resistance, warm), ((1e-3, 0.0),), refines="gap"))
        forms += _in_time(context, resistance, each)
        if joints > 1:
            start, simpler = (0.0, *(1e-3 for _ in each)), ("each", "closing with warmth")
            forms.append(Form("each, closing with warmth", (warm, *each), (start,), refines=simpler))
        forms.append(Form("uneven", (resistance, *_uneven("joint")), ((1e-3, 0.0, 0.0, 0.0),), refines="gap"))
    return Effect(
        id="contact-resistance",
        title="parts that touch do not conduct perfectly",
        not_sought="" if joints else "the mold has one part",
        shown_by="a thermocouple on each side of the joint",
        source="Yovanovich (2005), doi:10.1109/TCAPT.2005.848483",
        forms=tuple(forms),
    )


def _in_time(context: DataContext, resistance: Constant, each: Sequence[Constant]) -> Iterator[Form]:
    """Yield joints that close as time goes on, by a law of decay or evenly; of several each with its own resistance."""
    whole = context.duration_s
    closes = Constant("closing_share", 0.0, -0.9, 20.0, 0.1, places=("joint_closes",))
    slow = Constant("closing_s", 0.2 * whole, 0.005 * whole, 3.0 * whole, 0.05 * whole, places=("joint_closes_s",))
    more = Constant("tightening_share", 0.0, -0.9, 20.0, 0.1, places=("joint_tightens",))
    within = Constant("tightening_s", 0.5 * whole, 0.01 * whole, whole, 0.05 * whole, places=("joint_tightens_s",))
    for name, way, shares in (
        ("closing in time", (closes, slow), _CLOSING),
        ("closing evenly", (more, within), _EVENLY),
    ):
        starts, probes = ([(size, how, share * whole) for share in shares] for size, how in ((1e-3, 1.0), (2e-4, 0.1)))
        yield Form(name, (resistance, *way), tuple(starts), tuple(probes), refines="gap", screened=True)
        if len(each) > 1:
            start, simpler = (1.0, shares[0] * whole, *(1e-3 for _ in each)), ("each", name)
            pointers = tuple((0.1, share * whole, *(2e-4 for _ in each)) for share in shares)
            yield Form(f"each, {name}", (*way, *each), (start,), pointers, refines=simpler, screened=True)


def convection_law(context: DataContext) -> Effect:
    """A film coefficient that grows with the temperature difference, as free convection does: ``h ~ (T - ambient)^n``;
    free convection has n from 1/4 to 1/3."""
    exponent = Constant("exponent", 0.0, -0.5, 1.0, 0.05, places=("exponent",))
    return Effect(
        id="convection-law",
        title="the film coefficient depends on the temperature difference in another way",
        not_sought="" if context.films else "no face has a film",
        shown_by="plateaus at three powers, and a cool-down with the power off",
        source="Churchill & Chu (1975), doi:10.1016/0017-9310(75)90243-4",
        forms=(Form("power", (exponent,), ((0.25,), (-0.15,)), ((0.05,),)),),
    )


def power_loss(context: DataContext) -> Effect:
    """Heaters that give less than their rating, the less the hotter: a share lost, constant or growing with the
    heater's temperature, or out of its back.

    A wire that resists more when hot draws less at the same voltage.
    """
    share = Constant("lost_share", 0.0, -0.3, 0.9, 0.05, places=("lost",))
    rise, loss = context.rise_K, context.power_W / context.rise_K
    warm = Constant("lost_share_per_K", 0.0, -0.5 / rise, 0.9 / rise, 0.05 / rise, places=("lost_per_K",))
    far, step = 0.9 / rise**2, 0.05 / rise**2
    bend = Constant("lost_share_per_K2", 0.0, -far, far, step, places=("lost_per_K2",))
    back = Constant("back_W_K", 0.0, 0.0, 0.9 * loss, 0.05 * loss, places=("back_W_K",))
    # Metals resist 0.004 more a kelvin, nickel 0.006, heater alloys less: CRC Handbook of Chemistry and Physics.
    wire = Constant("resistance_per_K", 0.0, 0.0, 4.0 / rise, 0.05 / rise, 0.004, ("wire_per_K",))
    return Effect(
        id="power-loss",
        title="part of the power does not reach the mold",
        not_sought="" if context.heaters else "the model has no heater",
        shown_by="a power meter at the heaters at two plateaus",
        source="energy balance of a resistance heater",
        forms=(
            Form("constant", (share,), ((0.15,),), ((0.03,),)),
            Form(
                "with temperature",
                (share, warm),
                ((0.1, 0.1 / rise), (0.02, 0.2 / rise)),
                ((0.03, 0.0), (0.0, 0.03 / rise)),
            ),
            Form(
                "through the back",
                (share, back),
                ((0.02, 0.1 * context.power_W / rise),),
                ((0.0, 0.03 * context.power_W / rise),),
            ),
            # A straight decline passes for a film: where there is one body alone, only the bend shows.
            Form("wire", (wire,), ((0.1 / rise,), (0.5 / rise,)), ((0.05 / rise,), (0.5 / rise,))),
            Form("wire and share", (share, wire), ((0.0, 0.0),), refines="wire"),
            Form("bent", (share, warm, bend), ((0.0, 0.0, 0.0),), refines=("with temperature", "wire")),
        ),
    )


def property_drift(context: DataContext) -> Effect:
    """Conductivity and specific heat that change with temperature: one or both linear in it, then with a bend.

    Solids store no less the hotter they are, up to where they melt or change their lattice.
    """
    rise = context.rise_K
    high, step = 2.0 / rise, 0.05 / rise
    c = Constant("specific_heat_per_K", 0.0, 0.0, high, step, places=("capacity_per_K",))
    k = Constant("conductivity_per_K", 0.0, -0.7 / rise, high, step, places=("conductivity_per_K",))
    low, high, step = -0.5 / rise**2, 2.0 / rise**2, 0.05 / rise**2
    bend = Constant("specific_heat_per_K2", 0.0, low, high, step, places=("capacity_per_K2",))
    return Effect(
        id="property-drift",
        title="conductivity or specific heat change with temperature",
        shown_by="heating and cooling through the same temperatures at two powers",
        source="Touloukian (1970), Thermophysical Properties of Matter",
        forms=(
            Form("specific heat", (c,), ((0.2 / rise,), (0.05 / rise,)), ((0.03 / rise,),)),
            Form("conductivity", (k,), ((0.2 / rise,), (-0.3 / rise,)), ((0.03 / rise,),)),
            Form("both", (c, k), ((0.1 / rise, -0.1 / rise), (0.0, -0.3 / rise)), ((0.0, 0.03 / rise),)),
            Form("bent", (c, bend), ((0.0, 0.0),), refines="specific heat"),
            Form("bent both", (c, bend, k), ((0.0, 0.0, 0.0),), refines=("bent", "both")),
        ),
    )


def radiation(context: DataContext) -> Effect:
    """Heat radiated to the surroundings, ``[[radiation]]`` of the mold document: a grey emissivity of the faces that
    have a film, to surroundings as warm as the air or not."""
    emissivity = Constant("emissivity", 0.0, 0.0, 1.0, 0.1, places=("emissivity",))
    surroundings = Constant("surroundings_K", 0.0, -40.0, 40.0, 2.0, 8.0, ("surroundings_K",))
    return Effect(
        id="radiation",
        title="the mold radiates to its surroundings",
        not_sought=HAS_IT if context.emits else "" if context.films else "no face has a film",
        shown_by="a plateau at twice the temperature rise, and a cool-down with the power off",
        source="Stefan-Boltzmann law",
        forms=(
            Form("grey", (emissivity,), ((0.3,), (0.8,)), ((0.1,),)),
            Form("other surroundings", (emissivity, surroundings), ((0.3, 0.0),), refines="grey"),
        ),
    )


def sensor_lag(context: DataContext) -> Effect:
    """Thermocouples that follow late, ``lag`` of a probe: a first-order lag of all probes; one each; or two in a row,
    of sheath and sensor."""
    whole = context.duration_s
    most, step = 0.2 * whole, 0.005 * whole
    lag = Constant("lag_s", 0.0, 0.0, most, 0.01 * whole, places=("lag_s",))
    second = Constant("second_lag_s", 0.0, 0.0, most, step, places=("second_lag_s",))
    own = [
        Constant(f"of_probe_{k}_s", 0.0, -most, most, step, places=(f"lag_s.{k - 1}",))
        for k in range(2, context.probes + 1)
    ]
    forms = [
        Form("first-order", (lag,), ((0.01 * whole,), (0.04 * whole,)), ((0.002 * whole,), (0.02 * whole,))),
        Form("two-stage", (lag, second), ((0.01 * whole,) * 2,), refines="first-order"),
    ]
    if own:
        start = (0.01 * whole, *(0.0 for _ in own))
        forms.append(Form("each", (lag, *own), (start,), refines="first-order"))
    return Effect(
        id="sensor-lag",
        added=True,
        title="the sensors lag behind the metal, or sit where it warms up later than at the place stated",
        shown_by="a step of power sampled closely, with a probe of known quick response beside, its place measured",
        source="first-order lag; ASTM E839",
        forms=tuple(forms),
    )
