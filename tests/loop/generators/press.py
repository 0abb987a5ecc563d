"""A spherical cap pressed into a spherical bowl, by formulas and quadrature: none of hyperfab's own code.

mm, N, MPa. The gap at x is R_f - |x - c|, whatever tilt and heat do to the bowl's radius R_f and centre c.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

IDS = (
    "tilt",
    "thermal-expansion",
    "foam-shrinkage",
    "foam-relaxation",
    "thickness-variation",
    "frame-compliance",
    "lateral-shift",
    "fabric-compression",
)
#: What the molds' other temperatures show, and what the opened press does.
HOT, OPENED = ("foam-softening",), ("set",)
#: What no entry of the catalogue says: a dent of the female, grit on the film, a film that saturates.
OUTSIDE = ("dent", "grit", "saturated-film")
MALE, FEMALE, REACH, BACK, TOP, GAP = 70.0, 80.0, 50.0, 29.0, 110.0, 3.0
FOAM, FABRIC = 3.5, 1.0
#: Of the molds in the press [degC]; they do not grow. The foam was tested at 20 degC.
HOT_DEGC = 200.0
PLATEAU, MODULUS, DENSE = 0.0045, 0.12, 0.0016


@dataclass
class Truth:
    """Effects, their numbers, and how the press differs from its document within what is known of it."""

    effects: tuple[str, ...]
    size: dict[str, Array] = field(default_factory=dict)
    stiffness: float = 1.0
    offset: float = 0.0
    thickness: float = 1.0


def draw(random: Generator, effects: tuple[str, ...], larger: float = 1.0) -> Truth:
    """Return a press with effects of random size, ``larger`` than usual."""
    truth = Truth(
        effects,
        stiffness=float(1.0 + 0.07 * random.standard_normal()),
        offset=float(0.012 * random.standard_normal()),
        thickness=float(1.0 + 0.006 * random.standard_normal()),
    )
    for name in effects:
        angle, share = random.uniform(0.0, 2.0 * np.pi), random.uniform(0.0, 1.0)
        truth.size[name] = np.array([larger * (0.4 + 0.6 * random.uniform()), angle, share])
    return truth


def compression(strain: Array) -> Array:
    """Return the foam's stress: a plateau and its densification."""
    e = np.clip(strain, 0.0, 0.95)
    return PLATEAU * (1.0 - np.exp(-MODULUS * e / PLATEAU)) + DENSE * (e / (1.0 - e)) ** 2


class Press:
    """The truth as it stands."""

    def __init__(self, truth: Truth) -> None:
        self.truth, size = truth, truth.size
        self.radius, self.centre = FEMALE, np.array([0.0, 0.0, MALE + GAP - FEMALE])
        self.male_strain = 0.0
        if "thermal-expansion" in size:
            big, _, share = size["thermal-expansion"]
            self.male_strain = 0.004 * big
            strain = self.male_strain * (0.9 + 0.2 * share)
            self.radius *= 1.0 + strain
            self.centre = self.centre + strain * (self.centre - np.array([0.0, 0.0, TOP]))
        self.turn = Rotation.identity()
        if "tilt" in size:
            big, angle, _ = size["tilt"]
            turn = self.turn = Rotation.from_rotvec(
                np.radians(0.25 * big) * np.array([np.cos(angle), np.sin(angle), 0.0])
            )
            pivot = np.array([0.0, 0.0, TOP])
            self.centre = pivot + turn.apply(self.centre - pivot)
        if "lateral-shift" in size:
            big, angle, _ = size["lateral-shift"]
            self.centre = self.centre + 0.5 * big * np.array([np.cos(angle), np.sin(angle), 0.0])
        self.foam = FOAM * truth.thickness * (1.0 - 0.2 * size.get("foam-shrinkage", np.zeros(3))[0])
        self.compliance = 0.006 * size.get("frame-compliance", np.zeros(3))[0]
        nodes, weights = np.polynomial.legendre.leggauss(80)
        most = np.arcsin(REACH / MALE)
        theta = 0.5 * most * (nodes + 1.0)
        phi = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
        t, p = (one.ravel() for one in np.meshgrid(theta, phi, indexing="ij"))
        self.cap = MALE * np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
        self.area = np.repeat(0.5 * most * weights * np.sin(theta), len(phi)) * MALE**2 * 2.0 * np.pi / len(phi)

    def hot(self, cold: Array) -> Array:
        """Return where places (n, 3) of the cold male are."""
        return np.asarray(cold + self.male_strain * (cold - np.array([0.0, 0.0, BACK])))

    def gap(self, cold: Array, opening: float) -> tuple[Array, Array]:
        """Return the gap (n,) and how squarely it meets the axis."""
        away = self.hot(cold) - self.centre - np.array([0.0, 0.0, opening])
        far = np.linalg.norm(away, axis=1)
        return self.radius + self.hollow(cold) - far, away[:, 2] / far

    def hollow(self, cold: Array) -> Array:
        """Return how deep (n,) the female is dented opposite to places."""
        if "dent" not in self.truth.size:
            return np.zeros(len(cold))
        big, angle, share = self.truth.size["dent"]
        middle = 0.6 * REACH * np.sqrt(share) * np.array([np.cos(angle), np.sin(angle)])
        return np.asarray(1.2 * big * np.exp(-np.sum((cold[:, :2] - middle) ** 2, axis=1) / (2.0 * 9.0**2)))

    def film(self, at: Array, pressure: Array) -> Array:
        """Return what a film reads of pressures (n,) at places (n, 3)."""
        size = self.truth.size
        if "grit" in size:
            big, angle, _ = size["grit"]
            # Streaks of a dirty roller.
            along = at[:, 0] * np.cos(angle) + at[:, 1] * np.sin(angle)
            pressure = pressure * (1.0 + 0.25 * big * (np.sin(along * 2.0 * np.pi / 17.0) > 0.3))
        if "saturated-film" in size:
            big, _, share = size["saturated-film"]
            pressure = np.minimum(pressure, np.quantile(pressure, max(0.75 - 0.4 * big * share, 0.2)))
        return pressure

    def thick(self, cold: Array) -> Array:
        """Return the foam's thickness at places (n, 3): uneven as a smooth step or a dome."""
        if "thickness-variation" not in self.truth.size:
            return np.full(len(cold), self.foam)
        big, angle, share = self.truth.size["thickness-variation"]
        u = (cold[:, 0] * np.cos(angle) + cold[:, 1] * np.sin(angle)) / REACH
        v = np.hypot(cold[:, 0], cold[:, 1]) / REACH
        shape = np.tanh(0.8 * u) if share < 0.7 else 0.5 * (1.0 - np.cos(np.pi * np.minimum(v, 1.0))) - 0.4
        return np.asarray(self.foam * (1.0 + 0.1 * big * shape))

    def relaxed(self, time: Array | float) -> Array:
        """Return what is left of the pressure after ``time`` s."""
        if "foam-relaxation" not in self.truth.size:
            return np.ones_like(np.asarray(time, dtype=float))
        big, _, share = self.truth.size["foam-relaxation"]
        fade = -np.expm1(-((np.asarray(time) / (20.0 + 60.0 * share)) ** 0.8))
        return np.asarray(1.0 - min(0.5 * big, 0.8) * fade)

    def softened(self, temperature: float) -> float:
        """Return what the foam has of its stress at 20 degC."""
        if "foam-softening" not in self.truth.size:
            return 1.0
        big, _, share = self.truth.size["foam-softening"]
        return float(1.0 - min(0.5 * big, 0.8) * (max(temperature - 20.0, 0.0) / 180.0) ** (0.7 + 0.8 * share))

    def knit(self, pressure: Array) -> Array:
        """Return the strain of fabric under pressures: van Wyk's fibres, of which ever more touch."""
        if "fabric-compression" not in self.truth.size:
            return np.zeros_like(pressure)
        big, _, share = self.truth.size["fabric-compression"]
        return np.asarray(1.0 - (1.0 + big * pressure / (0.002 + 0.004 * share)) ** (-1.0 / 3.0))

    def strain(self, cold: Array, opening: float, temperature: float = HOT_DEGC) -> Array:
        """Return the foam's strain (n,); fabric that gives way takes its part of the closing."""
        foam, (gap, _) = self.thick(cold), self.gap(cold, opening)
        closing = np.maximum(foam + FABRIC - gap, 0.0)
        low, high = np.zeros(len(foam)), np.minimum(closing / foam, 0.95)
        if "fabric-compression" not in self.truth.size:
            return np.asarray(closing / foam)
        for _ in range(30):
            middle = 0.5 * (low + high)
            stress = self.truth.stiffness * self.softened(temperature) * compression(middle)
            over = foam * middle + FABRIC * self.knit(stress) > closing
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return np.asarray(0.5 * (low + high))

    def pressure(self, cold: Array, opening: float, temperature: float = HOT_DEGC) -> Array:
        """Return the pressure (n,) before it relaxes."""
        soft = self.softened(temperature)
        return np.asarray(self.truth.stiffness * soft * compression(self.strain(cold, opening, temperature)))

    def force(self, opening: float, temperature: float = HOT_DEGC) -> float:
        """Return the closing force [N] before it relaxes."""
        _, square = self.gap(self.cap, opening)
        grown = (1.0 + self.male_strain) ** 2
        return float(np.sum(self.pressure(self.cap, opening, temperature) * square * self.area) * grown)

    def formed(self, cold: Array, opening: float) -> Array:
        """Return the thickness (n,) once the press has opened: a share of the logarithmic strain has set."""
        big, _, share = self.truth.size.get("set", np.zeros(3))
        strain = self.strain(cold, opening)
        return np.asarray(FABRIC + self.thick(cold) * (1.0 - strain) ** min(big * (0.3 + 0.5 * share), 1.0))

    def opening(self) -> float:
        """Return how far the set press stands from its drawing: what is known, and what the frame yields."""
        start = self.truth.offset
        if self.compliance == 0.0:
            return start
        return float(brentq(lambda s: s - start - self.compliance * 1.0 * self.force(s), start, start + 3.0))

    def touch(self) -> float:
        """Return the opening at the first touch."""
        above = np.concatenate([self.cap, [[0.0, 0.0, MALE]]])

        def least(opening: float) -> float:
            return float(np.min(self.gap(above, opening)[0] - self.thick(above) - FABRIC))

        return float(brentq(least, -3.0, 6.0, xtol=1e-10))


@dataclass(frozen=True)
class Read:
    """A file: kind, values, places (n, 3), stroke (n,) or load (n,), time, temperature of the molds."""

    kind: str
    values: Array
    places: Array | None = None
    stroke: Array | None = None
    time: Array | None = None
    load: Array | None = None
    temperature: float | None = None


def places(random: Generator, count: int) -> Array:
    """Return places (n, 3) spread over the cap."""
    r, phi = 0.96 * REACH * np.sqrt(random.uniform(0.0, 1.0, count)), random.uniform(0.0, 2.0 * np.pi, count)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(MALE**2 - r**2)], axis=1)


#: What a reading of each kind is off by at usual noise; pressure and force as a share of 0.006 MPa and the largest.
_SD = {
    "pressure": 0.03 * 0.006,
    "thickness": 0.03,
    "force": 0.01,
    "contact": 0.03,
    "formed": 0.03,
    "fabric": 0.01,
    "mounting": 0.01,
}


def sd_of(read: Read) -> float:
    """Return the standard deviation of readings at usual noise; of ones and zeros, the width of their edge."""
    if read.kind == "contact":
        return 0.3
    return _SD[read.kind] * (float(read.values.max()) if read.kind == "force" else 1.0)


def measure(truth: Truth, random: Generator, noise: float, protocol: str) -> list[Read]:
    """Return what was read: ``rich`` pressure, thickness and force over stroke with a hold; ``film`` pressure alone;
    ``stroke`` force over stroke alone; ``next`` and a kind of reading that alone. Beside ``rich``: ``hot`` force over
    stroke at three temperatures, ``opened`` thickness in the opened press, ``gauged`` dial gauges. ``noise`` is
    relative to 3 % of pressure, 0.03 mm, 1 % of force."""
    press = Press(truth)
    found = []
    rich = protocol in ("rich", "hot", "opened", "gauged")
    if rich or protocol in ("film", "next pressure"):
        at = places(random, 150)
        p = press.film(at, press.pressure(at, press.opening()) * press.relaxed(600.0))
        p = p + noise * _SD["pressure"] * random.standard_normal(len(at))
        found.append(Read("pressure", p, places=at, time=np.full(len(at), 600.0) if rich else None))
    if rich or protocol in ("next thickness", "next contact"):
        at = places(random, 120)
        gap, _ = press.gap(at, press.opening())
        whole = press.thick(at) + FABRIC
        off = _SD["thickness"] * noise * random.standard_normal(len(at))
        if protocol == "next contact":
            found.append(Read("contact", np.where(gap + off < whole, 1.0, 0.0), places=at))
        else:
            pressed = press.thick(at) * (1.0 - press.strain(at, press.opening()))
            knitted = FABRIC * (1.0 - press.knit(press.pressure(at, press.opening())))
            found.append(Read("thickness", np.where(gap < whole, pressed + knitted, whole) + off, places=at))
    if protocol in ("opened", "next formed"):
        at = places(random, 120)
        off = _SD["formed"] * noise * random.standard_normal(len(at))
        found.append(Read("formed", press.formed(at, press.opening()) + off, places=at))
    if protocol in ("gauged", "next mounting"):
        angle = np.radians([0.0, 90.0, 180.0, 270.0])
        at = REACH * np.stack([np.cos(angle), np.sin(angle), np.zeros(4)], axis=1)
        turned = press.turn.apply(at)[:, 2]
        off = _SD["mounting"] * noise * random.standard_normal(4)
        found.append(Read("mounting", turned - turned.mean() + off, places=at))
    if protocol == "next fabric":
        load = np.linspace(0.0005, 0.008, 10)
        off = _SD["fabric"] * noise * random.standard_normal(10)
        found.append(Read("fabric", FABRIC * (1.0 - press.knit(load)) + off, load=load))
    for temperature in (20.0, 110.0) if protocol == "hot" else (20.0,) if protocol == "next cold" else ():
        first = press.touch()
        stroke = np.linspace(0.05, 1.5, 40)
        cold = np.array([press.force(first - s, temperature) for s in stroke])
        stroke = stroke + press.compliance * cold
        cold = cold * press.relaxed(10.0)
        cold = cold + _SD["force"] * noise * float(cold.max()) * random.standard_normal(40)
        time = np.full(40, 10.0) if rich else None
        found.append(Read("force", cold, stroke=stroke, temperature=temperature, time=time))
    if rich or protocol in ("stroke", "next force"):
        first = press.touch()
        true = np.linspace(0.05, 1.5, 40)
        forces = np.array([press.force(first - s) for s in true])
        time = 2.0 * np.arange(1.0, 41.0)
        if rich:
            true, forces = np.append(true, np.full(20, true[-1])), np.append(forces, np.full(20, forces[-1]))
            time = np.append(time, 80.0 + 15.0 * np.arange(1.0, 21.0))
        stroke = true + press.compliance * forces
        forces = forces * press.relaxed(time if rich else 10.0)
        sd = _SD["force"] * noise * float(forces.max())
        forces = forces + sd * random.standard_normal(len(forces))
        found.append(Read("force", forces, stroke=stroke, time=time if rich else None))
    return found


def stl(which: str, rings: int = 48, around: int = 96) -> bytes:
    """Return the cold mold as ASCII STL, a closed body."""
    sign = 1.0 if which == "male" else -1.0
    radius, reach = (MALE, REACH) if which == "male" else (FEMALE, 1.28 * REACH)
    centre = 0.0 if which == "male" else MALE + GAP - FEMALE
    back = BACK if which == "male" else TOP
    theta = np.linspace(0.0, np.arcsin(reach / radius), rings + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [np.array([0.0, 0.0, centre + radius])]
    for t in theta[1:]:
        out, up = radius * np.sin(t), centre + radius * np.cos(t)
        points += [np.array([out * np.cos(p), out * np.sin(p), up]) for p in phi]
    rim = 1 + (rings - 1) * around
    points += [np.array([*point[:2], back]) for point in points[rim : rim + around]]
    points.append(np.array([0.0, 0.0, back]))
    faces = []
    for j in range(around):
        k = (j + 1) % around
        faces.append((0, 1 + j, 1 + k))
        for i in range(rings):
            a, b = 1 + i * around, 1 + (i + 1) * around
            faces += [(a + j, b + j, b + k), (a + j, b + k, a + k)]
        last = 1 + rings * around
        faces.append((last + j, len(points) - 1, last + k))
    lines = [f"solid {which}"]
    for face in faces:
        corners = [points[i] for i in (face if sign > 0 else face[::-1])]
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {c[0]:.12g} {c[1]:.12g} {c[2]:.12g}" for c in corners]
        lines += ["endloop", "endfacet"]
    return ("\n".join([*lines, f"endsolid {which}"]) + "\n").encode()


FOAM_TOML = f"""format = "hyperfab.foam/1"
thickness = "{FOAM} mm"
compression = {{ law = "plateau", plateau = "{PLATEAU} MPa", modulus = "{MODULUS} MPa", densification = "{DENSE} MPa" }}
fabric = {{ above = "0.5 mm", below = "0.5 mm" }}
"""
