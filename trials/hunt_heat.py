"""Inputs chosen to break ``hf mold-heat``, each judged by an invariance, a balance or a formula.

Run as ``PYTHONPATH=. python -m trials.hunt_heat [part of a name]``: one line a case, status 1 if any is wrong.
"""

from __future__ import annotations

import copy
import json
import sys
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from trials.hunting import Hunt, Ran, asked, on_files
from trials.surfaces import graph

Tree = dict[str, Any]
#: How far temperatures [K] of one mold told in two ways may be apart: meshes differ, and so do time steps.
NEAR = 0.15


def toml(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def text(tree: Tree) -> str:
    """Return a mold document as TOML, its lists of tables as inline ones."""
    rows = []
    for key, value in tree.items():
        rows.append(f"{key} = {toml(value)}")
    return "\n".join(rows) + "\n"


def mm(*values: float) -> list[str]:
    """Return lengths as people write them."""
    return [f"{value!r} mm" for value in values]


def box(origin: tuple[float, ...], size: tuple[float, ...]) -> Tree:
    """Return a box."""
    return {"box": {"origin": mm(*origin), "size": mm(*size)}}


ALUMINIUM = {"density": "2702 kg/m^3", "conductivity": "237 W/m/K", "specific_heat": "903 J/kg/K"}
STEEL = {"density": "7850 kg/m^3", "conductivity": "45 W/m/K", "specific_heat": "460 J/kg/K"}
#: An L of two parts, heated from below at one end, cooled on all faces, read at three places.
MOLD: Tree = {
    "format": "hyperfab.mold/1",
    "material": {"aluminium": ALUMINIUM, "steel": STEEL},
    "part": [
        {"name": "plate", "material": "aluminium", **box((0, 0, 0), (100, 60, 20))},
        {"name": "post", "material": "steel", **box((0, 0, 20), (30, 60, 40))},
    ],
    "heater": [{"on": "plate.z-", "power": "600 W"}],
    "convection": [{"on": "exposed", "h": "15 W/m^2/K", "ambient": "25 degC"}],
    "probe": [
        {"name": "far", "at": mm(95, 30, 10)},
        {"name": "top", "at": mm(15, 30, 60)},
        {"name": "low", "at": mm(5, 5, 0)},
    ],
    "work_surface": {"on": "post.z+"},
    "run": {"start": "25 degC", "until": "400 s", "mesh_size": "20 mm"},
}


def changed(change: Callable[[Tree], Any], tree: Tree = MOLD) -> Tree:
    """Return a mold document with a change."""
    tree = copy.deepcopy(tree)
    change(tree)
    return tree


def heat(tree: Tree, files: Mapping[str, str] = {}, **options: Any) -> Ran:
    """Heat a mold."""
    given = {"": "mold.toml"} | {key.replace("_", "-"): value for key, value in options.items()}
    return on_files("mold-heat", given, {"mold.toml": text(tree), **files})


def told(one: Ran) -> str:
    """What a run came to, in a word."""
    if not isinstance(one.document, dict):
        return f"{one.status} {one.said.strip()[-100:]}"
    probes = " ".join(f"{value['final_degC']:.4g}" for value in one["probes"].values())
    return f"{one.status} {probes} degC, off by {one['energy']['imbalance_relative']:.0e}"


def sound(one: Ran) -> bool:
    """Whether a run converged and its account of heat closes."""
    return one.status == 0 and one["converged"] and one["energy"]["imbalance_relative"] < 1e-9


def apart(one: Ran, two: Ran) -> float:
    """Return how far probes and the work surface of two runs are apart at most [K]."""
    found = [abs(one["probes"][name]["final_degC"] - two["probes"][name]["final_degC"]) for name in one["probes"]]
    if "work_surface" in one.document:
        found += [
            abs(one["work_surface"][key] - two["work_surface"][key]) for key in ("mean_degC", "min_degC", "max_degC")
        ]
    return float(max(found))


def moved(tree: Tree, axes: tuple[int, int, int], shift: tuple[float, float, float], mirror: bool = False) -> Tree:
    """Return a mold of boxes with its axes renamed (cyclically) and shifted, or mirrored along x."""

    def point(at: list[str], size: list[str] | None = None) -> list[str]:
        values = [float(one.split()[0]) for one in at]
        if mirror:
            values[0] = -values[0] - (float(size[0].split()[0]) if size else 0.0)
        return mm(*[values[k] + s for k, s in zip(axes, shift, strict=True)])

    def way(on: Any) -> Any:
        if not isinstance(on, str) or on[-1:] not in "+-" or on[-3:-2] != ".":
            return on
        sign = on[-1]
        if mirror and on[-2] == "x":
            sign = "+" if sign == "-" else "-"
        return on[:-2] + "xyz"[axes.index("xyz".index(on[-2]))] + sign

    tree = copy.deepcopy(tree)
    for body in [*tree["part"], *tree.get("cavity", [])]:
        size = body["box"]["size"]
        body["box"] = {"origin": point(body["box"]["origin"], size), "size": [size[k] for k in axes]}
    for probe in tree["probe"]:
        probe["at"] = point(probe["at"])
    for key in ("heater", "convection", "temperature", "radiation"):
        for one in tree.get(key, []):
            one["on"] = way(one["on"])
    tree["work_surface"]["on"] = way(tree["work_surface"]["on"])
    return tree


def invariances(hunt: Hunt) -> None:
    """The same mold told otherwise."""
    plain = partial(heat, MOLD)

    def same(way: str, other: Callable[[], Ran], near: float = NEAR) -> None:
        def judged() -> tuple[bool, object]:
            one, two = plain(), other()
            off = apart(one, two)
            return sound(one) and sound(two) and off < near, f"{told(two)} {off:.1e} K"

        hunt.case(f"the same: {way}", judged)

    def put(way: str, change: Callable[[Tree], Any], files: Mapping[str, str] = {}, near: float = NEAR) -> None:
        same(way, lambda: heat(changed(change), files), near)

    same("mirrored", lambda: heat(moved(MOLD, (0, 1, 2), (0.0, 0.0, 0.0), mirror=True)))
    same("axes renamed", lambda: heat(moved(MOLD, (1, 2, 0), (0.0, 0.0, 0.0))))
    same("axes renamed again", lambda: heat(moved(MOLD, (2, 0, 1), (0.0, 0.0, 0.0))))
    same("shifted far", lambda: heat(moved(MOLD, (0, 1, 2), (12345.0, -678.0, 90.0))))
    put("parts in another order", lambda t: t["part"].reverse())
    put("probes in another order", lambda t: t["probe"].reverse(), near=1e-9)
    put(
        "lengths in metres and inches",
        lambda t: t["part"][0].update(box={"origin": mm(0, 0, 0), "size": ["0.1 m", f"{60 / 25.4!r} inch", "2 cm"]}),
    )
    put("power in kilowatts", lambda t: t["heater"][0].update(power="0.6 kW"), near=1e-9)
    put(
        "power as flux",
        lambda t: t["heater"][0].pop("power") and t["heater"][0].update(flux="10 W/cm^2"),
        near=1e-6,
    )
    put(
        "power in two heaters",
        lambda t: t.update(
            heater=[
                {"on": {"part": "plate", "box": box((0, 0, -1), (40, 60, 1))["box"]}, "flux": "10 W/cm^2"},
                {"on": {"part": "plate", "box": box((40, 0, -1), (60, 60, 1))["box"]}, "power": "360 W"},
            ]
        ),
        near=NEAR,
    )
    put(
        "power by schedule",
        lambda t: t.update(heater=[{"on": "plate.z-", "schedule": "p.csv"}]),
        {"p.csv": "time [s],power [W]\n0,600\n1000,600\n"},
        near=1e-6,
    )
    put(
        "power by schedule in minutes and kW",
        lambda t: t.update(heater=[{"on": "plate.z-", "schedule": "p.csv"}]),
        {"p.csv": "time [min],power [kW]\n0,0.6\n10,0.6\n"},
        near=1e-6,
    )
    put(
        "a thermostat that never switches",
        lambda t: t["heater"][0].update(control={"probe": "top", "set": "900 degC", "band": "2 K"}),
        near=1e-6,
    )
    put(
        "temperatures in kelvin",
        lambda t: (t["run"].update(start="298.15 K"), t["convection"][0].update(ambient="298.15 K")),
        near=1e-6,
    )
    put(
        "temperatures in fahrenheit",
        lambda t: (t["run"].update(start="77 degF"), t["convection"][0].update(ambient="77 degF")),
        near=1e-6,
    )
    put(
        "the film by a table",
        lambda t: t["convection"][0].update(h={"table": "h.csv"}),
        {"h.csv": "temperature [degC],h [W/m^2/K]\n0,15\n500,15\n"},
        near=1e-3,
    )
    put(
        "the film by a table, other units and order",
        lambda t: t["convection"][0].update(h={"table": "h.csv"}),
        {"h.csv": "h [W/m^2/K];temperature [K]\n15;273.15\n15;773.15\n"},
        near=1e-3,
    )
    put(
        "conductivity by a table",
        lambda t: t["material"].update(aluminium=ALUMINIUM | {"conductivity": {"table": "k.csv"}}),
        {"k.csv": "temperature [degC],conductivity [W/m/K]\n0,237\n100,237\n500,237\n"},
        near=1e-3,
    )
    put(
        "specific heat by a table",
        lambda t: t["material"].update(steel=STEEL | {"specific_heat": {"table": "c.csv"}}),
        {"c.csv": "temperature [degC],specific heat [J/kg/K]\n0,460\n500,460\n"},
        near=1e-3,
    )
    put(
        "radiation of nothing",
        lambda t: t.update(radiation=[{"on": "exposed", "emissivity": 1e-9, "ambient": "25 degC"}]),
        near=1e-4,
    )
    put(
        "a joint that conducts perfectly",
        lambda t: t.update(contact=[{"between": ["plate", "post"], "h": "1e7 W/m^2/K"}]),
    )
    put(
        "a joint named the other way",
        lambda t: t.update(contact=[{"between": ["post", "plate"], "h": "1e7 W/m^2/K"}]),
    )
    put(
        "the plate in two parts",
        lambda t: t["part"].__setitem__(
            0,
            {
                "name": "plate",
                "material": "aluminium",
                "shapes": [box((0, 0, 0), (50, 60, 20)), box((50, 0, 0), (50, 60, 20))],
            },
        ),
    )
    put(
        "the plate of shapes that overlap",
        lambda t: t["part"].__setitem__(
            0,
            {
                "name": "plate",
                "material": "aluminium",
                "shapes": [box((0, 0, 0), (70, 60, 20)), box((30, 0, 0), (70, 60, 20))],
            },
        ),
    )
    put(
        "films part by part",
        lambda t: t.update(
            convection=[
                {"on": on, "h": "15 W/m^2/K", "ambient": "25 degC"}
                for on in (
                    "plate.x-",
                    "plate.x+",
                    "plate.y-",
                    "plate.y+",
                    "post.all",
                    {"part": "plate", "box": box((30, 0, 20), (70, 60, 0.001))["box"]},
                )
            ]
        ),
    )
    put("a finer mesh", lambda t: t["run"].update(mesh_size="10 mm"), near=0.3)
    put("a coarser mesh", lambda t: t["run"].update(mesh_size="60 mm"), near=1.0)
    put("a tenth of the tolerance", lambda t: t["run"].update(tolerance="0.01 K"), near=0.3)
    put("a start for each part", lambda t: [part.update(start="25 degC") for part in t["part"]], near=1e-6)
    block = graph(lambda u, v: 20.0 + 0.0 * u, (50.0, 30.0), (10, 6), 0.0).moved(shift=[50.0, 30.0, 0.0])
    same(
        "the plate as STL",
        lambda: heat(
            changed(lambda t: t["part"].__setitem__(0, {"name": "plate", "material": "aluminium", "stl": "p.stl"})),
            {"p.stl": block.stl()},
        ),
    )
    same(
        "the plate as STL in inches",
        lambda: heat(
            changed(lambda t: t["part"].__setitem__(0, {"name": "plate", "material": "aluminium", "stl": "p.stl"})),
            {"p.stl": block.stl(25.4)},
            stl_unit="inch",
        ),
    )
    same(
        "the plate as STL, facets split and shuffled",
        lambda: heat(
            changed(lambda t: t["part"].__setitem__(0, {"name": "plate", "material": "aluminium", "stl": "p.stl"})),
            {"p.stl": block.split().shuffled().stl()},
        ),
    )


def lump(**run: Any) -> Tree:
    """Return a cube of 20 mm that conducts so well that it has one temperature."""
    return {
        "format": "hyperfab.mold/1",
        "material": {"m": {"density": "1000 kg/m^3", "conductivity": "1e6 W/m/K", "specific_heat": "1000 J/kg/K"}},
        "part": [{"name": "cube", "material": "m", **box((0, 0, 0), (20, 20, 20))}],
        "probe": [{"name": "p", "at": mm(10, 10, 10)}],
        "run": {"start": "25 degC", "until": "100 s", "mesh_size": "20 mm", "tolerance": "0.001 K", **run},
    }


def known(hunt: Hunt) -> None:
    """Bodies whose temperature is a formula."""
    capacity, area = 8.0, 6.0 * 4e-4  # J/K, m^2

    def ends_at(
        name: str,
        tree: Tree,
        expected: float,
        near: float = 0.01,
        probe: str = "p",
        files: Mapping[str, str] = {},
    ) -> None:
        def judged() -> tuple[bool, object]:
            one = heat(tree, files)
            off = abs(one["probes"][probe]["final_degC"] - expected)
            return sound(one) and off < near, f"{told(one)} {off:.1e} K"

        hunt.case(f"a formula: {name}", judged)

    film = [{"on": "exposed", "h": "50 W/m^2/K", "ambient": "25 degC"}]
    heater = [{"on": "cube.z-", "power": "4 W"}]
    ends_at("a lump that is heated", lump() | {"heater": heater}, 25.0 + 4.0 * 100.0 / capacity)
    ends_at("heated in its volume", lump() | {"heater": [{"volume": "cube", "power": "4 W"}]}, 25.0 + 50.0)
    rate = 50.0 * area / capacity
    ends_at(
        "a lump that cools",
        lump(start="225 degC") | {"convection": film},
        25.0 + 200.0 * np.exp(-rate * 100.0),
    )
    five = 50.0 * area * 5.0 / 6.0
    ends_at(
        "heated and cooled, but for the heated face",
        lump() | {"convection": film, "heater": heater},
        25.0 + 4.0 / five * (1.0 - np.exp(-five / capacity * 100.0)),
    )
    ends_at(
        "the same after all time",
        lump(steady=True) | {"convection": film, "heater": heater},
        25.0 + 4.0 / five,
    )
    sigma = 5.670374419e-8
    hot = (4.0 / (sigma * 0.8 * area * 5.0 / 6.0) + 298.15**4) ** 0.25 - 273.15
    ends_at(
        "radiation after all time",
        lump(steady=True)
        | {"heater": heater, "radiation": [{"on": "exposed", "emissivity": 0.8, "ambient": "25 degC"}]},
        hot,
    )
    ramp = {"p.csv": "time [s],power [W]\n0,0\n100,8\n"}
    ends_at(
        "power that rises",
        lump() | {"heater": [{"on": "cube.z-", "schedule": "p.csv"}]},
        25.0 + 50.0,
        files=ramp,
    )
    step = {"p.csv": "time [s],power [W]\n0,10\n30,10\n30.001,0\n1000,0\n"}
    ends_at(
        "power that is cut off",
        lump() | {"heater": [{"on": "cube.z-", "schedule": "p.csv"}]},
        25.0 + 10.0 * 30.0005 / capacity,
        files=step,
    )
    ends_at(
        "h that grows with temperature, steady",
        lump(steady=True)
        | {
            "heater": heater,
            "convection": [{"on": "exposed", "h": {"table": "h.csv"}, "ambient": "25 degC"}],
        },
        25.0 + (-10.0 + np.sqrt(100.0 + 4.0 * 0.5 * 4.0 / (area * 5.0 / 6.0))) / (2.0 * 0.5),
        files={"h.csv": "temperature [degC],h [W/m^2/K]\n25,10\n425,210\n"},
    )

    def wall(length: float, **more: Any) -> Tree:
        return {
            "format": "hyperfab.mold/1",
            "material": {"a": ALUMINIUM},
            "part": [{"name": "w", "material": "a", **box((0, 0, 0), (length, length / 2, length / 4))}],
            "temperature": [{"on": "w.x-", "value": "200 degC"}, {"on": "w.x+", "value": "50 degC"}],
            "probe": [{"name": "p", "at": mm(length / 4, length / 4, length / 8)}],
            "run": {"start": "25 degC", "steady": True, "mesh_size": f"{length / 4!r} mm"},
            **more,
        }

    for length in (0.05, 1.0, 100.0, 20000.0):
        ends_at(f"a wall of {length:g} mm between two temperatures", wall(length), 162.5, 1e-4)
    kirchhoff = wall(100.0, material={"a": ALUMINIUM | {"conductivity": {"table": "k.csv"}}})
    # k = 100 + T: the integral of k is linear along the wall.
    whole = 100.0 * 150.0 + 0.5 * (200.0**2 - 50.0**2)
    at = -100.0 + np.sqrt(100.0**2 + 2.0 * (100.0 * 200.0 + 0.5 * 200.0**2 - whole / 4.0))
    ends_at(
        "k(T) between two temperatures",
        kirchhoff,
        at,
        0.05,
        files={"k.csv": "temperature [degC],conductivity [W/m/K]\n0,100\n400,500\n"},
    )
    joint = {
        "part": [
            {"name": "w", "material": "a", **box((0, 0, 0), (50, 50, 25))},
            {"name": "v", "material": "a", **box((50, 0, 0), (50, 50, 25))},
        ],
        "temperature": [{"on": "w.x-", "value": "200 degC"}, {"on": "v.x+", "value": "50 degC"}],
        "contact": [{"between": ["w", "v"], "h": "500 W/m^2/K"}],
    }
    flux = 150.0 / (0.1 / 237.0 + 1.0 / 500.0)
    ends_at("a joint between two temperatures", wall(100.0, **joint), 200.0 - flux * 0.025 / 237.0, 1e-4)
    radius, long = np.array([10.0, 40.0]), 30.0
    tube = {
        "part": [
            {
                "name": "w",
                "material": "a",
                "cylinder": {"origin": mm(0, 0, 0), "axis": "z", "length": f"{long} mm", "radius": "40 mm"},
            }
        ],
        "cavity": [
            {
                "name": "c",
                "cylinder": {"origin": mm(0, 0, 0), "axis": "z", "length": f"{long} mm", "radius": "10 mm"},
            }
        ],
        "temperature": [{"on": "c.all", "value": "200 degC"}],
        "convection": [
            {
                "on": {"part": "w", "box": box((-50, -50, 1), (100, 100, 28))["box"]},
                "h": "100 W/m^2/K",
                "ambient": "20 degC",
            }
        ],
        "probe": [{"name": "p", "at": mm(20, 0, 15)}],
    }
    tube["convection"] = [{"on": "exposed", "h": "100 W/m^2/K", "ambient": "20 degC"}]
    tube["insulated"] = [{"on": "w.z-"}, {"on": "w.z+"}]
    flow = 180.0 / (np.log(radius[1] / radius[0]) / 237.0 + 1.0 / (100.0 * 0.04))
    ends_at("a tube with a film", wall(100.0, **tube), 200.0 - flow * np.log(2.0) / 237.0, 0.02)
    ball = {
        "part": [{"name": "w", "material": "a", "ellipsoid": {"centre": mm(0, 0, 0), "semi_axes": mm(30, 30, 30)}}],
        "heater": [{"volume": "w", "power": "900 W"}],
        "convection": [{"on": "exposed", "h": "300 W/m^2/K", "ambient": "20 degC"}],
        "probe": [{"name": "p", "at": mm(0, 0, 0)}],
    }
    solid = wall(24.0, **ball)
    del solid["temperature"]
    density = 900.0 / (4.0 / 3.0 * np.pi * 0.03**3)
    ends_at(
        "a ball heated in its volume",
        solid,
        20.0 + density * 0.03 / (3.0 * 300.0) + density * 0.03**2 / (6.0 * 237.0),
        0.3,
    )

    def weighs(name: str, part: Tree, volume_mm3: float, near: float) -> None:
        def judged() -> tuple[bool, object]:
            tree = lump() | {"part": [{"name": "cube", "material": "m", **part}], "probe": []}
            one = heat(tree | {"heater": [{"volume": "cube", "power": "1 W"}]})
            off = abs(one["mass_kg"] / (volume_mm3 * 1e-6) - 1.0)
            return sound(one) and off < near, f"{one.status} {one['mass_kg']:.6g} kg {off:.1e}"

        hunt.case(f"weighs: {name}", judged)

    weighs("a box", box((0, 0, 0), (20, 30, 40)), 24000.0, 1e-9)
    weighs(
        "a cylinder along x",
        {"cylinder": {"origin": mm(5, 5, 5), "axis": "x", "length": "40 mm", "radius": "15 mm"}},
        np.pi * 225.0 * 40.0,
        2e-3,
    )
    weighs(
        "an elliptic cylinder",
        {"cylinder": {"origin": mm(0, 0, 0), "axis": "z", "length": "40 mm", "semi_axes": mm(20, 10)}},
        np.pi * 200.0 * 40.0,
        2e-3,
    )
    for way in ("x-", "y+", "z+"):
        weighs(
            f"half an ellipsoid, {way}",
            {"ellipsoid": {"centre": mm(1, 2, 3), "semi_axes": mm(30, 20, 25), "half": way}},
            2.0 / 3.0 * np.pi * 15000.0,
            5e-3,
        )
    weighs(
        "two boxes that overlap",
        {"shapes": [box((0, 0, 0), (20, 20, 20)), box((10, 10, 10), (20, 20, 20))]},
        15000.0,
        1e-9,
    )
    ends: dict[str, tuple[Tree, tuple[int, ...]]] = {
        "no heat and no way out": (lump(), (0,)),
        "steady without a way out": (lump(steady=True) | {"heater": heater}, (3,)),
        "a probe beside the mold": (lump() | {"probe": [{"name": "p", "at": mm(90, 0, 0)}]}, (3,)),
        "a probe called with a comma": (lump() | {"probe": [{"name": 'a,b;"c"', "at": mm(1, 1, 1)}]}, (0,)),
        "a heater on no face": (lump() | {"heater": [{"on": "cube.q+", "power": "4 W"}]}, (3,)),
        "a part without a material": (
            lump() | {"part": [{"name": "c", "material": "gold", **box((0, 0, 0), (1, 1, 1))}]},
            (3,),
        ),
        "parts that overlap": (
            lump()
            | {
                "part": [
                    {"name": n, "material": "m", **box((k, 0, 0), (20, 20, 20))} for n, k in (("a", 0), ("b", 10))
                ],
                "probe": [],
            },
            (3,),
        ),
        "a cavity that takes all": (
            lump() | {"cavity": [{"name": "c", **box((-1, -1, -1), (30, 30, 30))}]},
            (3,),
        ),
        "a cavity beside the mold": (
            lump() | {"cavity": [{"name": "c", **box((50, 50, 50), (3, 3, 3))}], "heater": heater},
            (0, 3),
        ),
        "a bare number where a unit is due": (lump(until=100), (3,)),
        "a mesh that does not fit": (lump(mesh_size="0.05 mm"), (3,)),
        "a target below the start": (
            lump(target="20 degC") | {"work_surface": {"on": "cube.z+"}, "heater": heater},
            (0, 3),
        ),
        "a target that is never reached": (
            lump(target="900 degC") | {"work_surface": {"on": "cube.z+"}, "heater": heater},
            (0, 1),
        ),
        "a cold lump that is cooled below zero kelvin": (
            lump() | {"heater": [{"on": "cube.z-", "power": "-40 W"}]},
            (0, 3, 4),
        ),
        "a time of a nanosecond": (lump(until="1e-9 s") | {"heater": heater}, (0,)),
        "a time of a century": (lump(until="3e9 s") | {"heater": heater, "convection": film}, (0,)),
    }
    for name, (tree, statuses) in ends.items():

        def ended(tree: Tree = tree, statuses: tuple[int, ...] = statuses) -> tuple[bool, object]:
            one = heat(tree)
            return one.status in statuses and (one.status == 0 or bool(one.said)), told(one)

        hunt.case(f"ends with a status of its own: {name}", ended)


def main() -> int:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    for part in (invariances, known):
        part(hunt)
    return hunt.ended("hf mold-heat")


if __name__ == "__main__":
    raise SystemExit(main())
