"""Files of pushes, presses and drapes as labs write them: which rows are readings, whose, and counted from where."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Run

from hyperfab.chapters.close_loop import names_of
from hyperfab.chapters.close_loop.contact import read_force_depth
from hyperfab.chapters.close_loop.domain import How
from hyperfab.chapters.close_loop.drape import read_markers
from hyperfab.chapters.close_loop.press import read_press
from hyperfab.chapters.close_loop.taken import past_touch
from hyperfab.chapters.fit.prepare import Steps
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.errors import InputError, UsageError
from hyperfab.io.layout import layout

DEPTH = np.linspace(0.0, 20.0, 21)
FORCE = 0.05 * DEPTH**2
#: Three sheets of one cloth, which differ in stiffness.
SHEETS = {"KN-1": 0.98 * FORCE, "KN-2": FORCE, "KN-3": 1.03 * FORCE}
READ = {"contact": read_force_depth, "press": read_press, "drape": read_markers}


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """What reads a text as a file of a domain, and counts what it leaves out."""
    monkeypatch.chdir(tmp_path)

    def found(domain: str, text: str, columns: str = "", left: Counter[str] | None = None, **more: Any) -> Any:
        Path("lab.csv").write_text(text)
        how = layout([columns] if columns else [], own=names_of(domain, {}))
        job = Job("close-loop", [], Console())
        return READ[domain](job, "lab.csv", how, Counter() if left is None else left, **more)

    return found


def rows(*columns: Any) -> str:
    return "".join(",".join(map(str, row)) + "\n" for row in zip(*columns, strict=True))


def beside(head: str) -> str:
    force = [*SHEETS.values()]
    return head + rows(*(column for one in force for column in (DEPTH, one)))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("specimen,depth [mm],force [N]\n" + "".join(rows([k] * 21, DEPTH, f) for k, f in SHEETS.items()), [*SHEETS]),
        ("cloth,depth [mm],force [N]\n" + "".join(rows([k] * 21, DEPTH, f) for k, f in SHEETS.items()), [*SHEETS]),
        ("No,test no,depth [mm],force [N]\n"
         + "".join(rows(range(21), [k] * 21, DEPTH, f) for k, f in enumerate(SHEETS.values())), ["0", "1", "2"]),
        (beside("depth,force,depth,force,depth,force\nmm,N,mm,N,mm,N\n"), ["1", "2", "3"]),
        (beside("A,,B,,C,\ndepth [mm],force [N],depth [mm],force [N],depth [mm],force [N]\n"), ["1", "2", "3"]),
        ("depth [mm],Specimen 1 [N],Specimen 2 [N],Specimen 3 [N]\n" + rows(DEPTH, *SHEETS.values()), ["1", "2", "3"]),
        ("".join(f"Specimen {k}\ndepth [mm],force [N]\n{rows(DEPTH, f)}\n" for k, f in enumerate(SHEETS.values(), 1)),
         ["1", "2", "3"]),
    ],
    ids=["column", "words", "numbers", "repeated titles", "merged titles", "shared depth", "stacked"],
)  # fmt: skip
@pytest.mark.parametrize("domain", ["contact", "press"])
def test_specimens_in_one_file_are_each_its_own(read: Any, domain: str, text: str, names: list[str]) -> None:
    """They were read as one push, whose scatter was the noise of a load cell, or refused."""
    found = read(domain, text if domain == "contact" else text.replace("depth", "stroke"))
    assert [one.name for one in found] == [f"lab.csv {name}" for name in names]
    for one, force in zip(found, SHEETS.values(), strict=True):
        assert one.values == pytest.approx(force, abs=1e-12)


def test_pushes_at_several_temperatures_are_one_specimen_s(read: Any) -> None:
    text = (
        "depth [mm],force [N],temperature [degC]\n"
        + rows(DEPTH, FORCE, [23] * 21)
        + rows(DEPTH, 0.8 * FORCE, [80] * 21)
    )
    [found] = read("contact", text)
    assert len(found.force) == 42


def test_parts_of_one_push_are_no_specimens(read: Any) -> None:
    part = ["preload"] * 4 + ["push"] * 17
    [found] = read("contact", "what,depth [mm],force [N]\n" + rows(part, DEPTH**2 / 20.0, FORCE))
    assert len(found.force) == 21


def test_a_second_force_is_asked_for(read: Any) -> None:
    """One of three was taken, the others not told."""
    text = "depth [mm],Force 1 [N],Force 2 [N],Force 3 [N]\n" + rows(DEPTH, *SHEETS.values())
    with pytest.raises(InputError, match=r'--columns "Force 1 \[N\]=aside,Force 2 \[N\]=aside"'):
        read("contact", text)


@pytest.mark.parametrize("cycles", [2, 3])
def test_of_cycles_what_is_pushed_for_the_first_time_is_taken(read: Any, cycles: int) -> None:
    """Each cycle goes farther, and comes back along a softer path: all were fitted by one curve."""
    way, force = [0.0], [0.0]
    for reach in (10.0, 14.0, 20.0)[:cycles]:
        up = np.arange(0.5, reach + 0.1, 0.5)
        farther = up > max(way)
        way += [*up, *up[-2::-1]]
        force += [*np.where(farther, 1.0, 0.7) * 0.05 * up**2, *0.6 * 0.05 * up[-2::-1] ** 2]
    left: Counter[str] = Counter()
    [found] = read("contact", "depth [mm],force [N]\n" + rows(way, force), left=left)
    assert found.force == pytest.approx(0.05 * found.depth**2)
    assert np.max(found.depth) == max(way)
    assert left == {"lab.csv: on the way back or pushed again": len(way) - len(found.depth)}


@pytest.mark.parametrize(("down", "push"), [(-1, 1), (1, -1), (-1, -1)])
@pytest.mark.parametrize(("domain", "way"), [("contact", "depth"), ("press", "stroke")])
def test_what_is_counted_against_the_push_is_turned_round(
    read: Any, domain: str, way: str, down: int, push: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """A load cell in compression counts below 0: the residual was unexplained, twice the force."""
    [found] = read(domain, f"{way} [mm],force [N]\n" + rows(down * DEPTH, push * FORCE))
    assert found.values == pytest.approx(FORCE)
    assert (found.depth if domain == "contact" else found.stroke) == pytest.approx(DEPTH)
    assert "counted the other way: taken times -1" in capsys.readouterr().err


def test_a_push_counts_from_where_it_is_told_to(read: Any) -> None:
    text = "depth [mm],force [N]\n" + rows([0.0, 2.0, *DEPTH + 4.0], [0.01, 0.01, *FORCE + 0.01])
    left: Counter[str] = Counter()
    [found] = read("contact", text, left=left, steps=Steps(preload="0.06N"))
    assert found.depth == pytest.approx(DEPTH[1:] - 1.0)
    assert found.force == pytest.approx(FORCE[1:] + 0.01)
    assert left == {"lab.csv: before 0.06N": 3}
    [found] = read("contact", text, steps=Steps(zero=True))
    assert found.force[0] == 0.0
    assert found.force[-1] == pytest.approx(20.0)
    with pytest.raises(InputError, match="does not reach the preload of 50N"):
        read("contact", text, steps=Steps(preload="50N"))
    with pytest.raises(UsageError, match="of a push it is a force"):
        read("contact", text, steps=Steps(preload="2MPa"))


def test_a_way_that_never_passes_the_first_touch_is_refused_with_what_counts_from_there() -> None:
    with pytest.raises(InputError, match=r"has no stroke above 0; count stroke from the first touch: --zero"):
        past_touch("press.csv", np.array([-250.0, -247.5]), "stroke")
    past_touch("press.csv", np.array([-0.1, 2.0]), "stroke")


@pytest.mark.parametrize("kind", ["contact", "press", "drape", "mold"])
def test_where_a_push_counts_from_may_be_said_of_a_push_alone(kind: str) -> None:
    counted, chosen = How(steps=Steps(zero=True, preload="0.1N")), How(steps=Steps(branch="load"))
    if kind in ("contact", "press"):
        counted.check(kind)
    else:
        with pytest.raises(UsageError, match="are for tests of a fabric"):
            counted.check(kind)
    with pytest.raises(UsageError, match="are for tests of a fabric"):
        chosen.check(kind)


PLACES = [(float(x), float(y)) for x in range(4) for y in range(3)]


@pytest.mark.parametrize("domain", ["press", "drape"])
def test_frames_and_stages_are_no_repeats(read: Any, domain: str) -> None:
    """Half a pressure, then all of it, was read as one film with a noise of a quarter."""
    head = "x [mm],y [mm],z [mm],pressure [kPa]" if domain == "press" else "x0 [mm],y0 [mm],x [mm],y [mm],z [mm]"
    text = f"Frame,Row,{head}\n" + "".join(
        f"{k},{row},{x},{y},{0 if domain == 'press' else x},{s * (x + y) if domain == 'press' else y}"
        + (f",{s * x}\n" if domain == "drape" else "\n")
        for k, s in enumerate((0.5, 1.0)) for row, (x, y) in enumerate(PLACES)
    )  # fmt: skip
    with pytest.raises(InputError, match=r'column "Frame": tells 2 readings of each place apart') as caught:
        read(domain, text)
    for said, count in (("specimen", 2), ("aside", 1)):
        assert f'--columns "Frame={said}"' in str(caught.value)
        assert len(read(domain, text, f"Frame={said}")) == count


def test_rows_that_lack_a_reading_are_left_out_and_counted(read: Any) -> None:
    """A camera's NaN had to be deleted by hand, and what it writes for a marker that it does not see was fitted."""
    text = "x0 [mm],y0 [mm],x [mm],y [mm],z [mm]\n" + "".join(f"{x},{y},{x},{y},{x * y + 1}\n" for x, y in PLACES)
    left: Counter[str] = Counter()
    lacking = "7,1,NaN,NaN,NaN\n7,2,,,\n7,3,0,0,0\n7,4,0,0,0\n7,5,0,0,0\n"
    [found] = read("drape", text + lacking, left=left)
    assert len(found.flat) == len(PLACES)
    assert left == {
        "lab.csv: lacking a reading": 2,
        "lab.csv: marker that was not seen, at one place with others": 3,
    }
    [film] = read("press", "x [mm],y [mm],z [mm],pressure [kPa]\n1,2,0,3\n2,2,0,OVER\n2,3,0,>5\n3,2,0,4\n")
    assert film.values.tolist() == [0.003, 0.004]


@pytest.mark.parametrize(
    "head",
    [
        "X [mm],Y [mm],Z [mm],U [mm],V [mm],W [mm]",
        "x0 [mm],y0 [mm],h,dx [mm],dy [mm],dz [mm]",
        "Coordinate x [mm],Coordinate y [mm],Coordinate z [mm],Displacement x [mm],Displacement y [mm],"
        "Displacement z [mm]",
        "draped",
    ],
    ids=["VIC", "flat", "Istra", "draped"],
)
def test_displacements_of_image_correlation_are_read(read: Any, head: str) -> None:
    """They were offered as places: ``U [mm]=x0 [mm]``."""
    flat, moved = np.array(PLACES), np.array([(0.1 * x, -0.2 * y, 5.0 + 3.0 * x * y) for x, y in PLACES])
    there = np.column_stack([flat + moved[:, :2], moved[:, 2]])
    first = there if head == "draped" else np.column_stack([flat, np.zeros(len(flat))])
    title = "x [mm],y [mm],z [mm],u [mm],v [mm],w [mm]" if head == "draped" else head
    [found] = read("drape", f"{title},exx [%]\n" + rows(*first.T, *moved.T, 0 * first[:, 0]))
    assert found.flat == pytest.approx(flat)
    assert found.found == pytest.approx(there)


def test_displacements_from_no_flat_sheet_are_refused(read: Any) -> None:
    title = "x [mm],y [mm],z [mm],u [mm],v [mm],w [mm]\n"
    with pytest.raises(InputError, match="lie on a flat sheet"):
        read("drape", title + "".join(f"{x},{y},{x},0,0,{y}\n" for x, y in PLACES))


@pytest.mark.parametrize(
    ("domain", "text", "said"),
    [
        ("press", "x;y;z;Spaltmass\nmm;mm;mm;mm\n1;2;0;3\n2;2;0;4\n", 'Spaltmass=thickness [mm]"'),
        ("press", "x_mm,y_mm,z_mm,gap_mm\n1,2,0,3\n2,2,0,4\n", 'gap_mm=thickness [mm]"'),
        ("press", "Zeit;Istposition;Istkraft\ns;mm;kN\n0;1;2\n1;2;3\n", 'Istposition=stroke [mm],Istkraft=force [kN]"'),
        (
            "press",
            "x [mm],y [mm],z [mm],Peak p [kPa],Mean p [kPa]\n1,2,0,4,3\n2,2,0,4,3\n",
            'Mean p [kPa]=pressure [kPa]"',
        ),
        ("press", "stroke [mm],force (ton)\n1,2\n2,3\n", "ton is no unit that is known"),
        ("drape", "index_x,x_undef,y_undef,x,y,z\n1,2,3,4,5,6\n", '"x_undef=x0 [mm],y_undef=y0 [mm],x=x [mm],y=y [mm]'),
    ],
)
def test_what_is_offered_is_what_a_column_may_be(read: Any, domain: str, text: str, said: str) -> None:
    """A gap was offered as a pressure, a position and a force too, an index as a place, a ton as a newton."""
    with pytest.raises(InputError) as caught:
        read(domain, text)
    assert said in str(caught.value)


def test_what_is_told_already_stays_in_what_is_offered(read: Any) -> None:
    with pytest.raises(InputError, match=r'--columns "A=x \[mm\],D=pressure \[MPa\]"'):
        read("press", "A,y [mm],z [mm],D\n1,2,0,4\n2,2,0,4\n", "A=x [mm]")


def test_no_strain_is_offered_as_a_place(read: Any) -> None:
    with pytest.raises(InputError, match="has no column x;") as caught:
        read("drape", "x0 [mm],y0 [mm],Exx (Green-Lagrange),Eyy\n1,2,0.1,0.2\n2,3,0.1,0.2\n")
    assert "--columns" not in str(caught.value)


CELLS = "\n".join(",".join(f"{(3 * k + j) % 5}.25" for j in range(9)) for k in range(4))


@pytest.mark.parametrize(
    "above", ["", "ROWS 4\nUNITS kPa\nASCII_DATA @@\n\nFrame 1\n", "Sensor:,PX100\nTime:,10:11:12\n"]
)
def test_a_matrix_of_cells_is_told(read: Any, above: str) -> None:
    """Its first four columns were offered as x, y, z and pressure, or its rows to be completed."""
    with pytest.raises(InputError, match="is a grid of readings, cell beside cell; write a row for each place"):
        read("press", above + CELLS + "\n")
    with pytest.raises(InputError, match="is a grid of readings, cell beside cell; write a row for each reading"):
        read("contact", above + CELLS + "\n")


MOLD = """format = "hyperfab.mold/1"
material.steel = { density = "7850 kg/m^3", conductivity = "50 W/m/K", specific_heat = "460 J/kg/K" }
part = [{ name = "slab", material = "steel", box.origin = ["0 m", "0 m", "0 m"], box.size = ["9 cm", "9 cm", "3 cm"] }]
heater = [{ on = "slab.z-", power = "800 W", control = { probe = "cup", set = "80 degC", band = "2 K" } }]
convection = [{ on = "exposed", h = "9 W/m^2/K", ambient = "22 degC" }]
probe = [{ name = "cup", at = ["45 mm", "45 mm", "30 mm"] }]
work_surface = { on = "slab.z+" }
run = { start = "22 degC", until = "600 s", mesh_size = "15 mm" }
"""


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ("P1 [W],U [V],P2 [kW]", '--columns "P1 [W]=power [W],P2 [kW]=power [kW]"'),
        ("Duty [%],U [V]", 'if Duty [%] is the share of 800 W that was on, --columns "Duty [%]=power [%]"'),
    ],
)
def test_what_the_heaters_drew_is_shown_with_its_columns(hf: Run, tmp_path: Path, columns: str, said: str) -> None:
    """A power meter's columns had to be found out from the page."""
    (tmp_path / "mold.toml").write_text(MOLD)
    width = columns.count(",") + 1
    log = "".join(f"{10 * k},{22 + k}{',50' * width}\n" for k in range(30))
    (tmp_path / "log.csv").write_text(f"time [s],cup [degC],{columns}\n{log}")
    done = hf("close-loop", "mold.toml", "log.csv", "-o", "loop.json", cwd=tmp_path)
    assert done.returncode == 3
    assert said in done.stderr.decode()
