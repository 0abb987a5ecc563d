"""``hf drape`` as its users meet it: document, files, refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib.image
import numpy as np
import pytest
import trimesh
from cloth_molds import height_block, saddle

from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.drape.result import way_out
from hyperfab.cli import main
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.surface import Surface

FABRIC = {
    "format": "hyperfab.material/1",
    "model": "neo-hookean",
    "parameters": {"C10_MPa": 0.2},
    "thickness_mm": 0.8,
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    (tmp_path / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def drape(folder, monkeypatch, capfd) -> Callable[..., tuple[int, str, str]]:
    def run(*arguments: str, mold: str = "ball.stl", fabric: str | None = "fabric.json") -> tuple[int, str, str]:
        words = ["hf", "drape", *([fabric] if fabric else []), "--mold", mold]
        for name, value in (("--grid", "31x21"), ("--size", "200mmx180mm"), ("--depth", "50mm")):
            if name not in arguments:
                words += [name, value]
        monkeypatch.setattr("sys.argv", [*words, *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capfd.readouterr()
        return int(end.value.code or 0), out, err

    return run


@pytest.mark.pictures
def test_the_document_has_what_the_contract_promises(drape, folder):
    status, out, _ = drape("-o", "drape.json")
    assert status == 0
    assert out == ""
    document = json.loads((folder / "drape.json").read_text())
    for key in ("iterations", "residual_max_N", "residual_relative", "energy_J", "force_N", "contact_nodes",
                "penetration_max_mm", "slack_springs", "stress_warp_max_MPa", "stress_weft_max_MPa",
                "thickness_min_mm"):  # fmt: skip
        assert isinstance(document[key], (int, float)), key
    assert document["format"] == "hyperfab.drape/1"
    assert document["converged"] is True
    assert document["residual_relative"] <= 1e-6
    assert document["penetration_nodes_mm"] <= 1e-9
    assert 0.3 < document["thickness_min_mm"] < 0.8
    assert document["mold"]["shift_mm"][2] == pytest.approx(-10.0)
    assert set(document["files"]) == {"drape.vtu", "drape.csv", "drape.png", "drape.mold.stl"}
    head, *rows = (folder / "drape.csv").read_text().splitlines()
    assert head.split(",")[3:5] == ["energy_J", "residual_relative"]
    assert float(rows[-1].split(",")[3]) == document["energy_J"]
    picture = matplotlib.image.imread(folder / "drape.png")[..., :3].min(axis=2)
    tall, wide = picture.shape
    assert (picture[: tall // 8, : wide // 4] < 0.5).any(), "no word on the worst place at the top left"
    assert (picture[:, :4] > 0.99).all(), "the sheet is cut at the left"


def test_the_field_has_nodes_cells_and_named_arrays(drape, folder):
    import meshio

    drape("-o", "drape.json")
    field = meshio.read(folder / "drape.vtu")
    assert field.points.shape == (31 * 21, 3)
    assert field.cells_dict["quad"].shape == (30 * 20, 4)
    assert {"stress_warp_MPa", "stress_weft_MPa", "contact", "residual_N", "flat_mm"} <= set(field.point_data)
    assert {"thickness_mm", "stretch_warp", "stretch_weft", "slack"} <= set(field.cell_data)
    corner = field.points[field.cells_dict["quad"][0]]
    assert np.allclose(corner[0], [-100, -90, 0])


def test_the_largest_stretch_is_told_with_its_place_on_the_sheet_and_in_space(drape, folder):
    import meshio

    _, _, err = drape("-o", "drape.json")
    document = json.loads((folder / "drape.json").read_text())
    field = meshio.read(folder / "drape.vtu")
    net = field.points.reshape(31, 21, 3)
    warp = np.linalg.norm(np.diff(net, axis=0), axis=2) / (200.0 / 30)
    weft = np.linalg.norm(np.diff(net, axis=1), axis=2) / (180.0 / 20)
    assert document["stretch_max"] == pytest.approx(max(warp.max(), weft.max()), rel=1e-12)
    along, stretch = (0, warp) if warp.max() >= weft.max() else (1, weft)
    i, j = np.unravel_index(stretch.argmax(), stretch.shape)
    k, l = (i + 1, j) if along == 0 else (i, j + 1)
    flat = field.point_data["flat_mm"].reshape(31, 21, 3)
    place = document["stretch_max_at_mm"]
    assert place["flat"] == pytest.approx(0.5 * (flat[i, j] + flat[k, l])[:2], abs=1e-9)
    assert place["draped"] == pytest.approx(0.5 * (net[i, j] + net[k, l]), abs=1e-9)
    cells = {
        name: field.cell_data[name][0].reshape(30, 20) for name in ("stretch_warp", "stretch_weft", "stretch_larger")
    }
    assert cells["stretch_warp"] == pytest.approx(0.5 * (warp[:, 1:] + warp[:, :-1]), rel=1e-12)
    assert cells["stretch_weft"] == pytest.approx(0.5 * (weft[1:] + weft[:-1]), rel=1e-12)
    assert (cells["stretch_larger"] == np.maximum(cells["stretch_warp"], cells["stretch_weft"])).all()
    said = [row for row in err.splitlines() if row.startswith("force")]
    assert len(said) == 1
    for figure in (
        f"{document['force_N']:.4g} N",
        f"{document['stretch_max']:.3f}",
        f"{document['contact_nodes']} nodes",
    ):
        assert figure in said[0]
    assert "force" not in drape("-o", "drape.json", "--quiet")[2]


def test_the_mold_is_written_where_it_stands_under_the_draped_sheet(drape, folder):
    import meshio

    mesh = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices + np.array([300.0, -40.0, 7.0]), mesh.faces))
    drape("-o", "drape.json", "--depths", "20mm,50mm")
    document = json.loads((folder / "drape.json").read_text())
    assert document["mold"]["shift_mm"] == pytest.approx([-300.0, 40.0, -17.0], abs=1e-4)
    mold = trimesh.load(folder / "drape.mold.stl")
    assert mold.bounds[1, 2] == pytest.approx(50.0, abs=1e-4)
    field = meshio.read(folder / "drape.vtu")
    on_it = field.points[field.point_data["contact"].astype(bool)]
    assert len(on_it) == document["contact_nodes"]
    near = Surface(mold.vertices, mold.faces).nearest(on_it)
    assert np.abs(near.distance).max() < 1e-4
    at_origin = stl_bytes(mesh.vertices, mesh.faces)
    (folder / "ball.stl").write_bytes(at_origin)
    zero = json.loads(drape("--depth", "60mm")[1])["mold"]["shift_mm"]
    assert [str(v) for v in zero] == ["0.0", "0.0", "0.0"]


def test_springs_are_not_counted_against_a_range_that_nobody_knows(drape):
    document = json.loads(drape()[1])  # constants without tests
    for direction in ("warp", "weft"):
        assert "beyond_tested" not in document[direction]
        assert "tested_stretch_max" not in document[direction]


def test_standard_output_carries_the_document_and_nothing_else(drape, folder):
    status, out, _ = drape()
    assert status == 0
    assert json.loads(out)["files"] == []
    assert sorted(path.name for path in folder.iterdir()) == ["ball.stl", "fabric.json"]


def test_each_direction_has_its_own_constants(drape, folder):
    fabric = {
        **FABRIC,
        "directions": {"warp": {"parameters": {"C10_MPa": 0.2}}, "weft": {"parameters": {"C10_MPa": 0.4}}},
    }
    (folder / "fabric.json").write_text(json.dumps(fabric))
    _, out, _ = drape("--grid", "31x31", "--size", "200mm")
    document = json.loads(out)
    assert document["stress_weft_max_MPa"] > 1.5 * document["stress_warp_max_MPa"]


def test_facets_wound_the_wrong_way_are_turned_with_a_warning(drape, folder):
    _, right, _ = drape("--quiet")
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    faces = mesh.faces.copy()
    faces[::7] = faces[::7, ::-1]
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, faces))
    status, mended, err = drape("--quiet")
    assert status == 0
    assert "wrong way" in err
    assert json.loads(mended)["energy_J"] == pytest.approx(json.loads(right)["energy_J"], rel=1e-6)
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces[:, ::-1]))
    status, turned, err = drape("--quiet")
    assert "inward" in err
    assert json.loads(turned)["energy_J"] == pytest.approx(json.loads(right)["energy_J"], rel=1e-6)


def test_a_hole_above_the_sheet_is_refused_and_one_below_is_not(drape, folder):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    centres = mesh.triangles_center[:, 2]
    top = np.argmax(centres)
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, np.delete(mesh.faces, top, 0)))
    status, out, err = drape()
    assert status == 3
    assert out == ""
    assert "ball.stl, facet" in err
    assert "hole" in err
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces[centres > -20]))
    status, out, _ = drape()
    assert status == 0
    assert json.loads(out)["mold"]["closed"] is False


def test_only_what_there_is_is_told_of_further_facets(drape, folder):
    """A fin has one facet with an open edge, a hole of one facet has three beside it."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=60.0)
    top = int(np.argmax(mesh.triangles_center[:, 2]))
    edge = mesh.faces[top][:2]
    vertices = np.vstack([mesh.vertices, mesh.vertices[edge].mean(0) + np.array([0.0, 0.0, 5.0])])
    (folder / "ball.stl").write_bytes(stl_bytes(vertices, np.vstack([mesh.faces, [*edge, len(vertices) - 1]])))
    fin = drape()[2]
    assert "an open edge" in fin
    assert "more such" not in fin
    (folder / "ball.stl").write_bytes(stl_bytes(mesh.vertices, np.delete(mesh.faces, top, 0)))
    assert "mm, and 2 more such facets; if" in drape()[2]


def test_a_mold_that_reaches_the_clamped_edge_is_refused(drape):
    status, _, err = drape("--size", "90mmx90mm")
    assert status == 3
    assert "clamped edge" in err
    assert "--size" in err


@pytest.mark.parametrize(("solver", "steps"), [("relaxation", 3), ("dynamic", 2)])
def test_no_equilibrium_names_what_to_try_and_that_works(drape, solver, steps):
    status, out, err = drape("-o", "-", "--solver", solver, "--steps", str(steps))
    assert status == 4
    way = f"; try --solver newton, or --steps {4 * steps}"
    assert way in err
    assert json.loads(out)["status"].endswith(way)
    status, _, _ = drape("-o", "-", "--solver", "newton")
    assert status == 0


def test_where_no_step_lowers_the_energy_another_grid_and_less_depth_are_named():
    case = DrapeCase(material="f.json", mold=("m.stl",), grid=(40, 31), depth=50.0, size=(200.0, 200.0))
    model = SimpleNamespace(case=case)
    assert way_out(model) == "try --grid 41x51, then --depth 40mm, then --solver dynamic (slow)"
    model.case = replace(case, friction=0.3)
    assert way_out(model) == "try --load-steps 40, then --grid 41x51, then --depth 40mm"


def test_constants_that_soften_where_they_are_used_end_with_status_4(drape, folder):
    unstable = {**FABRIC, "model": "yeoh-2", "parameters": {"C10_MPa": 0.2, "C20_MPa": -0.6}}
    (folder / "fabric.json").write_text(json.dumps(unstable))
    status, out, err = drape()
    assert status == 4
    assert "unstable" in err
    assert json.loads(out)["warp"]["softens_at"] > 1.0


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--grid", "100", "100x100"),
        ("--grid", "2x50", "at least 3"),
        ("--grid", "9999x9999", "fewer"),
        ("--size", "200x200", "unit"),
        ("--depth", "60", "60mm"),
        ("--depth", "-5mm", "0mm or more"),
        ("--clamp", "north", "x-,x+,y-,y+"),
        ("--thickness", "0mm", "more than 0mm"),
        ("--tolerance", "0", "1e-6"),
        ("--slide", "x-", "clamped"),
        ("--prestretch", "5mm", "1.05x1.1"),
        ("--mass", "180", "g/m^2"),
        ("--solver", "magic", "relaxation"),
        ("--max-stretch", "0.5", "1.8"),
    ],
)
def test_an_option_that_means_nothing_is_refused_with_the_right_form(drape, option, value, says):
    status, out, err = drape(f"{option}={value}")
    assert status == 2
    assert out == ""
    assert says in err


def test_edges_that_are_free_are_drawn_in_and_sliding_ones_stay_on_their_line(drape):
    # An even number of rows: a row along the ball's ridge of facets slides off it to one side or the other.
    _, out, _ = drape("--clamp", "x-,x+", "--grid", "32x22")
    free = json.loads(out)["draw_in_mm"]
    assert free["y-"] > 1.0
    assert free["y-"] == pytest.approx(free["y+"], abs=1e-3)
    _, out, _ = drape("--clamp", "x-,x+", "--slide", "y-,y+")
    assert json.loads(out)["draw_in_mm"] == {"y-": 0.0, "y+": 0.0}


def test_prestretch_weight_and_shear_stiffness_act_and_are_off_by_default(drape):
    _, out, _ = drape()
    plain = json.loads(out)
    names = [text.split(":")[0] for text in plain["left_out"]]
    assert names == [
        "friction",
        "pre-tension",
        "gravity",
        "shear stiffness",
        "temperature",
        "bending stiffness",
        "biaxial coupling",
        "lateral contraction",
    ]
    for option in ("--prestretch=1.05x1.1", "--mass=2 kg/m^2", "--shear-modulus=50 kPa"):
        status, out, _ = drape(option)
        document = json.loads(out)
        assert status == 0
        assert document["force_N"] > plain["force_N"]
        assert len(document["left_out"]) == 7


def test_a_stretch_beyond_what_the_fabric_bears_ends_with_status_1(drape):
    status, out, err = drape("--max-stretch", "1.1")
    assert status == 1
    assert "tear" in err
    assert json.loads(out)["over_max_stretch"] > 0
    assert drape("--max-stretch", "1.9")[0] == 0


def test_the_relaxation_of_the_report_does_not_reach_equilibrium_and_says_so(drape):
    status, out, _ = drape("--solver", "relaxation", "--steps", "600")
    document = json.loads(out)
    assert status == 4
    assert document["converged"] is False
    assert "1/c" in document["status"]
    assert document["residual_relative"] > 1e-2


def test_the_dynamic_relaxation_confirms_newtons_energy(drape):
    energies = []
    for solver in ("newton", "dynamic"):
        status, out, _ = drape("--solver", solver, "--tolerance", "1e-8")
        document = json.loads(out)
        assert status == 0
        assert document["solver"] == solver
        energies.append(document["energy_J"])
    # Nodes rest within one or the other of the mold's large facets; on small ones tests/cloth finds 1e-8.
    assert energies[1] == pytest.approx(energies[0], rel=1e-4)


def test_several_molds_in_one_frame_carry_one_sheet(drape, folder):
    for name, x, z in (("left", -40.0, 0.0), ("right", 40.0, 8.0)):
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=30.0)
        (folder / f"{name}.stl").write_bytes(stl_bytes(mesh.vertices + np.array([x, 0.0, z]), mesh.faces))
    status, out, _ = drape("--mold", "right.stl", "--depth", "40mm", mold="left.stl")
    document = json.loads(out)
    assert status == 0
    assert document["mold"]["facets"] == 2 * 1280
    assert document["mold"]["shift_mm"][2] == pytest.approx(2.0)
    assert len(document["provenance"]["inputs"]) == 3


def test_friction_costs_force_and_its_work_is_accounted_for(drape):
    _, out, _ = drape()
    plain = json.loads(out)
    status, out, _ = drape("--friction", "0.3")
    rubbed = json.loads(out)
    assert status == 0
    assert rubbed["friction"] == 0.3
    assert "friction" not in rubbed["left_out"]
    assert "friction" in plain["left_out"]
    assert rubbed["force_N"] > 1.02 * plain["force_N"]
    assert rubbed["residual_relative"] <= 1e-6
    assert abs(rubbed["rubbing"]["balance_relative"]) < 5e-3
    assert rubbed["rubbing"]["rubbed_J"] > 0.01 * rubbed["rubbing"]["work_J"]
    assert rubbed["rubbing"]["sliding_nodes"] + rubbed["rubbing"]["sticking_nodes"] > 0


def test_effects_at_their_null_value_change_no_digit(drape):
    documents = []
    for options in ((), ("--friction", "0", "--prestretch", "1", "--mass", "0 g/m^2")):
        document = json.loads(drape(*options)[1])
        del document["provenance"]
        documents.append(document)
    assert documents[0] == documents[1]


def test_states_on_the_way_give_the_force_depth_curve_and_a_series(drape, folder):
    status, _, _ = drape("--states", "3", "-o", "drape.json")
    document = json.loads((folder / "drape.json").read_text())
    assert status == 0
    assert [row["depth_mm"] for row in document["states"]] == pytest.approx([50 / 3, 100 / 3, 50])
    assert [row[1] for row in document["force_depth"]] == [row["force_N"] for row in document["states"]]
    assert document["force_depth"][-1] == [50.0, document["force_N"]]
    assert np.all(np.diff([row[1] for row in document["force_depth"]]) > 0)
    assert {"drape.001.vtu", "drape.003.vtu", "drape.pvd"} <= set(document["files"])
    assert 'timestep="50.0"' in (folder / "drape.pvd").read_text()
    alone = json.loads(drape()[1])
    assert alone["force_N"] == document["force_N"]
    named = json.loads(drape("--depths", "25mm,50mm", "--depth", "60mm")[1])
    assert [row[0] for row in named["force_depth"]] == [25.0, 50.0]


def test_a_blank_holder_lets_its_edges_be_drawn_in_and_the_others_not(drape):
    firm = json.loads(drape("--blank-holder", "5N/mm")[1])
    plain = json.loads(drape()[1])
    assert firm["draw_in_mm"] == {"x-": 0.0, "x+": 0.0, "y-": 0.0, "y+": 0.0}
    # On so coarse a ball a net has several places to rest among the facets.
    assert firm["energy_J"] == pytest.approx(plain["energy_J"], rel=1e-4)
    status, out, _ = drape("--blank-holder", "y-,y+=0.05N/mm")
    loose = json.loads(out)
    assert status == 0
    assert loose["blank_holder_N_mm"] == {"y-": 0.05, "y+": 0.05}
    assert loose["draw_in_mm"]["y-"] > 1.0
    assert loose["draw_in_mm"]["y-"] == pytest.approx(loose["draw_in_mm"]["y+"], rel=0.05)
    assert loose["rubbing"]["drawn_J"] > 0
    assert loose["force_N"] < plain["force_N"]


def test_tests_are_taken_as_laws_as_they_stand(drape, folder):
    stretch = np.linspace(1.0, 2.5, 301)
    stress = 2 * 0.2 * (stretch - stretch**-2)
    rows = "\n".join(f"{s - 1:.6f},{p:.8f}" for s, p in zip(stretch, stress, strict=True))
    (folder / "warp.csv").write_text(f"# thickness: 0.5 mm\nstrain [-],stress [MPa]\n{rows}\n")
    status, out, err = drape("--warp", "warp.csv", fabric=None)
    measured = json.loads(out)
    assert status == 0
    assert "both directions" in err
    assert measured["thickness_mm"] == 0.5
    assert measured["warp"]["model"] == "measured"
    assert measured["warp"]["tested_stretch_max"] == 2.5
    fitted = json.loads(drape("--thickness", "0.5mm")[1])
    assert measured["energy_J"] == pytest.approx(fitted["energy_J"], rel=1e-4)
    short = "\n".join(rows.splitlines()[:30])
    (folder / "warp.csv").write_text(f"strain [-],stress [MPa]\n{short}\n")
    status, out, err = drape("--warp", "warp.csv")
    assert status == 0
    assert "beyond what is known: stretch along the warp" in err
    assert json.loads(out)["warp"]["beyond_tested"] > 0
    assert json.loads(out)["weft"]["model"] == "neo-hookean"


def test_a_specimen_that_failed_says_where_the_fabric_would_tear(drape, folder):
    (folder / "warp.csv").write_text("strain [-],stress [MPa]\n0.05,0.02\n0.1,0.05\n0.2,0.04\n0.3,0.01\n")
    status, out, err = drape("--warp", "warp.csv")
    assert status == 1
    assert "tear" in err
    assert "2 rows left out" in err
    assert json.loads(out)["warp"]["fails_at"] == pytest.approx(1.1)


@pytest.mark.slow
def test_what_a_bias_test_shows_beyond_its_threads_is_the_law_of_shear(drape, folder):
    # A strip at 45 degrees of threads of modulus E that resist shear by G: 1/E45 = 1/2E + 1/4G at small strain.
    modulus, shear = 3 * 2 * 0.2, 0.05
    slope = 1.0 / (1.0 / (2.0 * modulus) + 1.0 / (4.0 * shear))
    rows = "\n".join(f"{e:g},{slope * e:.8f}" for e in np.linspace(0.002, 0.3, 150))
    (folder / "bias.csv").write_text(f"# direction: 45\nstrain [-],stress [MPa]\n{rows}\n")
    square = ("--grid", "31x31", "--size", "200mm")
    measured = json.loads(drape(*square, "--shear-law", "bias.csv")[1])
    stated = json.loads(drape(*square, "--shear-modulus", "50 kPa")[1])
    assert measured["shear_law"] == "measured"
    plain = json.loads(drape(*square)[1])
    added = [document["energy_J"] - plain["energy_J"] for document in (measured, stated)]
    assert added[0] == pytest.approx(added[1], rel=0.1)  # the angles of this drape are not all small
    (folder / "bias.csv").write_text("# direction: 45\nstrain [-],stress [MPa]\n0.1,5\n0.2,10\n")
    status, _, err = drape(*square, "--shear-law", "bias.csv")
    assert status == 3
    assert "bias.csv" in err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--friction", "much"), "0.3"),
        (("--friction", "-0.1"), "0.3"),
        (("--blank-holder", "5"), "N/mm"),
        (("--blank-holder", "0N/mm"), "--clamp"),
        (("--blank-holder", "y-=1N/mm", "--clamp", "x-,x+"), "--clamp"),
        (("--depths", "20mm,20mm"), "20mm,40mm,60mm"),
        (("--depths", "20mm", "--states", "2"), "one of them"),
        (("--states", "0"), "six"),
        (("--load-steps", "5"), "--friction"),
        (("--friction", "0.3", "--solver", "relaxation"), "relaxation"),
        (("--shear-law", "bias.csv", "--shear-modulus", "1 MPa"), "one of them"),
    ],
)
def test_effects_that_mean_nothing_are_refused_with_the_right_form(drape, options, says):
    status, out, err = drape(*options)
    assert status == 2
    assert out == ""
    assert says in err


def test_a_mold_that_no_node_meets_is_named(drape, folder):
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    (folder / "pin.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    status, out, err = drape("--grid", "30x30", "--depth", "0.9mm", mold="pin.stl")
    assert status == 4
    assert "finer --grid" in err
    assert json.loads(out)["contact_nodes"] == 0


def test_a_sheet_that_hangs_on_sharp_ridges_is_a_result(drape, folder):
    surface = saddle()
    (folder / "saddle.stl").write_bytes(stl_bytes(surface.vertices, surface.faces))
    status, _, err = drape("--grid", "61x61", "--size", "220mm", "--depth", "20mm", "-o", "d.json", mold="saddle.stl")
    document = json.loads((folder / "d.json").read_text())
    assert status == 0, err
    assert document["converged"] is True
    assert "status" not in document
    assert document["contact_edges"] > 10
    assert document["force_N"] > 1.0


def test_a_pin_that_stands_through_the_net_is_told_with_its_size(drape, folder):
    import meshio

    ball = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    balls = [ball.copy().apply_translation([x, 0.0, 0.0]) for x in (-40.0, 40.0)]
    options = ("--grid", "41x41", "--size", "200mm", "--depth", "40mm")
    both = trimesh.util.concatenate(balls)
    (folder / "balls.stl").write_bytes(stl_bytes(both.vertices, both.faces))
    status, _, err = drape(*options, "-o", "d.json", mold="balls.stl")
    assert status == 0, err
    row = meshio.read(folder / "d.vtu").points.reshape(41, 41, 3)[
        20:22, 20
    ]  # a spring that spans freely; but for the facet its neighbours rest on, on y = 0
    x, y, z = row.mean(axis=0) - [0.0, 0.0, 10.0]  # in the balls' own frame
    assert np.abs(row[:, 1]).max() < 0.01
    pin = trimesh.creation.cylinder(radius=0.25, height=20.0, sections=32)
    both = trimesh.util.concatenate([*balls, pin.apply_translation([x, y + 0.004, z - 4.0])])
    (folder / "pin.stl").write_bytes(stl_bytes(both.vertices, both.faces))
    status, out, err = drape(*options, mold="pin.stl")
    document = json.loads(out)
    assert status == 0
    assert 0.24 < document["penetration_edges_mm"] < 0.25
    assert document["penetration_max_mm"] == document["penetration_edges_mm"]
    assert document["stands_through_mm"] == pytest.approx(6.0, abs=0.1)
    assert document["stands_through_at_mm"]["draped"][2] == pytest.approx(row[:, 2].mean() + 6.0, abs=1e-3)
    assert "mm out through the net" in err
    long = trimesh.util.concatenate([*balls, pin.apply_translation([0.0, 0.0, 8.0])])  # 14 mm, the spacing is 5 mm
    (folder / "pin.stl").write_bytes(stl_bytes(long.vertices, long.faces))
    status, out, err = drape(*options, mold="pin.stl")
    assert (status, json.loads(out)["converged"]) == (4, True)
    assert "more than 2 spacings: part of it passes between the nodes" in err


def test_a_depth_that_locks_the_law_is_named(drape, folder):
    locking = {**FABRIC, "model": "gent", "parameters": {"mu_MPa": 0.4, "Im": 1.0}}
    (folder / "fabric.json").write_text(json.dumps(locking))
    status, out, err = drape("--depth", "100mm", "--size", "140mmx140mm", "--grid", "25x25")
    assert status == 4
    assert "the law ends" in err
    assert json.loads(out)["warp"]["ends_at"] < json.loads(out)["warp"]["stretch_max"]


def test_friction_over_a_sharp_rim_says_what_it_leaves_out(drape, folder):
    mesh = trimesh.creation.cylinder(40.0, 60.0, sections=48)
    (folder / "punch.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    status, out, _ = drape("--friction", "0.3", "--load-steps", "5", "--depth", "30mm", mold="punch.stl")
    assert status == 0
    assert any("sharp edges" in text for text in json.loads(out)["left_out"])


def test_a_membrane_obeys_the_law_as_a_whole_and_says_what_it_leaves_out(drape, folder):
    assert drape("-o", "net.json")[0] == 0
    status, _, err = drape("--sheet", "membrane", "-o", "membrane.json")
    assert status == 0
    assert "wrinkled or slack" in err
    net, whole = (json.loads((folder / name).read_text()) for name in ("net.json", "membrane.json"))
    assert (net["sheet"], whole["sheet"]) == ("net", "membrane")
    assert 1.3 < whole["force_N"] / net["force_N"] < 1.8
    assert whole["stress_max_MPa"] > whole["stress_nominal_max_MPa"] > 0.99 * whole["stress_warp_max_MPa"] > 0.0
    assert whole["residual_relative"] <= 1e-6
    assert whole["penetration_nodes_mm"] < 1e-9
    assert any("biaxial" in text for text in net["left_out"])
    for word in ("biaxial", "lateral", "shear"):
        assert not any(word in text for text in whole["left_out"])
    assert b"stress_larger_MPa" in (folder / "membrane.vtu").read_bytes()
    again = drape("--like", "membrane.json", "-o", "again.json", mold="ball.stl")
    assert again[0] == 0
    assert json.loads((folder / "again.json").read_text())["force_N"] == whole["force_N"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--warp", "test.csv"), "one direction"),
        (("--shear-modulus", "0.05MPa"), "leave --shear-modulus out"),
        (("--shear-law", "test.csv"), "leave --shear-law out"),
        (("--solver", "relaxation"), "newton or dynamic"),
    ],
)
def test_what_only_springs_have_is_refused_with_a_membrane(drape, options, words):
    status, _, err = drape("--sheet", "membrane", *options)
    assert status == 2
    assert words in " ".join(err.split())


def test_an_unstable_law_is_told_of_a_membrane(drape, folder):
    falling = {
        **FABRIC,
        "model": "yeoh-3",
        "parameters": {"C10_MPa": 0.2, "C20_MPa": -0.3, "C30_MPa": 0.25},
    }
    (folder / "falling.json").write_text(json.dumps(falling))
    status, _, err = drape("--sheet", "membrane", fabric="falling.json")
    assert status == 4
    assert "unstable" in err


def test_a_law_that_has_no_answer_for_it_is_unstable_is_told_so(drape, folder):
    """Not that its chains lock, nor by a defect: nothing holds the sheet's width where this weft wrinkles."""
    ways = {"warp": (0.6826, 0.6337), "weft": (0.63457, -0.61555)}
    each = {name: {"parameters": {"C10_MPa": one, "C01_MPa": two}} for name, (one, two) in ways.items()}
    falling = {**FABRIC, "model": "mooney-rivlin-2", **each["warp"], "directions": each}
    (folder / "falling.json").write_text(json.dumps(falling))
    status, _, err = drape("--sheet", "membrane", fabric="falling.json")
    assert status == 4, err
    assert "unstable" in err
    assert "--stable" in err


@pytest.mark.parametrize(("grid", "depth"), [("31x31", "54mm"), ("21x21", "60mm")])
def test_a_law_whose_sheet_necks_is_told_and_no_finer_grid_is_asked_for(drape, folder, grid, depth):
    """From 53.5 mm on, as hf fabric-contact finds, stretch gathers in one row of cells; then the ball is through."""
    each = {name: {"parameters": {"mu_MPa": mu, "f": 0.0, "nu": 0.25}} for name, mu in (("warp", 6.26), ("weft", 0.27))}
    foam = {**FABRIC, "thickness_mm": 0.6, "model": "blatz-ko", **each["warp"], "directions": each}
    (folder / "necks.json").write_text(json.dumps(foam))
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=40.0)
    (folder / "small.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    words = ("--sheet", "membrane", "--shape", "disc", "--size", "200mm", "--grid", grid, "--depth", depth)
    status, _, err = drape(*words, mold="small.stl", fabric="necks.json")
    assert status == 4
    assert "stretch gather in bands" in err
    assert "take a finer --grid" not in err


def test_a_mold_that_has_passed_between_the_nodes_is_no_result(drape, folder):
    """A wall thinner than the spacing slips through: the net beside it bears nothing, which is no equilibrium on it."""
    wall = height_block(lambda u, v: 0.0 * u, (50.0, 1.0), (10, 1), -60.0)
    (folder / "wall.stl").write_bytes(stl_bytes(wall.vertices, wall.faces))
    status, out, _ = drape("--grid", "31x27", mold="wall.stl")
    found = json.loads(out)
    assert (status, found["force_N"] > 1.0) in ((4, False), (0, True))
    if status == 4:
        assert "between the nodes" in found["status"]


def test_a_membrane_whose_law_ends_before_the_mold_does_is_refused(drape, folder):
    short = {**FABRIC, "model": "gent", "parameters": {"mu_MPa": 0.4, "Im": 0.1}}
    (folder / "short.json").write_text(json.dumps(short))
    status, _, err = drape("--sheet", "membrane", fabric="short.json")
    assert status == 3
    assert "less --depth" in " ".join(err.split())


def test_a_disc_is_the_one_of_the_published_loads_and_drapes_again_from_its_document(drape, folder):
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=40.0)
    (folder / "fine.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    given = [
        "--sheet",
        "membrane",
        "--shape",
        "disc",
        "--size",
        "200mm",
        "--grid",
        "61x61",
        "--depths",
        "40mm,60mm",
    ]
    assert drape(*given, "--thickness", "1mm", "-o", "disc.json", mold="fine.stl")[0] == 0
    document = json.loads((folder / "disc.json").read_text())
    assert document["shape"] == document["setup"]["shape"] == "disc"
    for (_, force), exact in zip(document["force_depth"], (14.679562516, 41.576556565), strict=True):
        assert force == pytest.approx(exact, rel=4e-3)
    assert document["stretch_max"] == pytest.approx(1.2854086307, abs=2e-3)
    assert document["stress_max_MPa"] == pytest.approx(0.4 * (1.2854086307**2 - 1.2854086307**-4), rel=5e-3)
    assert (document["wrinkled_area_fraction"], document["slack_springs"]) == (0.0, 0)
    again = [
        "--like",
        "disc.json",
        "--size",
        "200mm",
        "--grid",
        "21x21",
        "--depth",
        "40mm",
        "-o",
        "again.json",
    ]
    assert drape(*again, mold="fine.stl")[0] == 0
    shallow = json.loads((folder / "again.json").read_text())
    assert (shallow["shape"], shallow["size_mm"]) == ("disc", [200.0, 200.0])


def test_a_disc_over_a_ring_lies_flat_inside_it_and_on_its_round(drape, folder):
    """A torus, 30 and 20 mm, frictionless: by shooting along the meridian from the flat, evenly stretched middle.

    At 30 mm: 17.587857 N, 139.45341 N mm, and 1.0634065 both ways in the middle, which touches nothing.
    """
    around, across = np.arange(192) * (2 * np.pi / 192), np.arange(96) * (2 * np.pi / 96)
    u, v = (angle.ravel() for angle in np.meshgrid(around, across, indexing="ij"))
    far = 30.0 + 20.0 * np.cos(v)
    points = np.column_stack([far * np.cos(u), far * np.sin(u), 20.0 * np.sin(v)])
    number = np.arange(len(points)).reshape(192, 96)
    a, b = number.ravel(), np.roll(number, -1, 0).ravel()
    c, d = np.roll(number, (-1, -1), (0, 1)).ravel(), np.roll(number, -1, 1).ravel()
    faces = np.vstack([np.column_stack(corners) for corners in ((a, b, c), (a, c, d))])
    (folder / "ring.stl").write_bytes(stl_bytes(points, faces))
    words = ["--sheet", "membrane", "--shape", "disc", "--size", "200mm", "--grid", "81x81", "--depth", "30mm"]
    assert drape(*words, "--thickness", "1mm", "-o", "ring.json", mold="ring.stl")[0] == 0
    document = json.loads((folder / "ring.json").read_text())
    # Facets inscribed in the round lie up to 0.02 mm inside it.
    assert document["force_N"] == pytest.approx(17.587857, rel=4e-3)
    assert document["energy_J"] == pytest.approx(0.13945341, rel=5e-3)
    grid = read_vtu((folder / "ring.vtu").read_bytes(), "ring.vtu")
    middle = np.hypot(grid.points[:, 0], grid.points[:, 1]) < 25.0
    assert np.ptp(grid.points[middle, 2]) < 0.05
    assert grid.point_data["contact"][middle].sum() == 0
    cells = grid.points[grid.cells["quad"]].mean(1)
    inner = np.hypot(cells[:, 0], cells[:, 1]) < 25.0
    assert grid.cell_data["thickness_mm"][inner] == pytest.approx(np.full(inner.sum(), 1.0634065**-2), rel=1e-3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "no round rim to end at; take --sheet membrane"),
        (("--sheet", "membrane", "--size", "200mmx180mm"), "two diameters"),
        (("--sheet", "membrane", "--size", "200mm", "--clamp", "x-,x+"), "leave --clamp out"),
        (
            ("--sheet", "membrane", "--size", "200mm", "--clamp", "x-,x+,y-", "--slide", "y+"),
            "leave --slide out",
        ),
        (("--sheet", "membrane", "--size", "200mm", "--blank-holder", "1N/mm"), "leave --blank-holder out"),
    ],
)
def test_what_a_disc_cannot_be_is_refused(drape, options, words):
    status, _, err = drape("--shape", "disc", *options)
    assert status == 2
    assert words in " ".join(err.split())


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["square", "disc"])
def test_a_membrane_over_a_ball_agrees_with_the_elements_of_fabric_contact(drape, folder, monkeypatch, capfd, shape):
    mesh = trimesh.creation.icosphere(subdivisions=7, radius=40.0)
    (folder / "fine.stl").write_bytes(stl_bytes(mesh.vertices, mesh.faces))
    orthotropic = {"C10_MPa": 0.15, "C20_MPa": 0.01, "k1_warp_MPa": 0.4, "k2_warp": 0.3, "G_MPa": 0.03}
    if shape == "disc":
        (folder / "fabric.json").write_text(json.dumps({**FABRIC, "model": "orthotropic", "parameters": orthotropic}))
    options = ("--grid", "151x151", "--size", "200mmx200mm", "--depth", "60mm", "--sheet", "membrane")
    options += ("--shape", "disc" if shape == "disc" else "rectangle")
    assert drape(*options, "-o", "sheet.json", mold="fine.stl")[0] == 0
    words = f"hf fabric-contact fabric.json --shape {shape} --size 200mm --depth 60mm --mesh-size 5mm"
    monkeypatch.setattr("sys.argv", [*words.split(), "--sphere-radius", "40mm", "-o", "contact.json"])
    with pytest.raises(SystemExit) as end:
        main()
    assert int(end.value.code or 0) == 0
    capfd.readouterr()
    sheet, elements = (json.loads((folder / name).read_text()) for name in ("sheet.json", "contact.json"))
    assert sheet["force_N"] == pytest.approx(elements["force_N"], rel=1e-3)
    assert sheet["stretch_max"] == pytest.approx(elements["stretch_max"], rel=2e-3)
    for name in ("stress_max_MPa", "stress_nominal_max_MPa"):
        assert sheet[name] == pytest.approx(elements[name], rel=5e-3)
