"""The mesher's door: exact volumes, named faces, refusals, and a watchdog that always comes back."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from hyperfab.errors import InputError, NotConverged
from hyperfab.thermal import netgen_process, netgen_worker
from hyperfab.thermal.faces import Faces
from hyperfab.thermal.geometry import Body, Box, Cylinder, Ellipsoid, Geometry, Patch
from hyperfab.thermal.mesh import build_mesh
from hyperfab.thermal.mesher import begin_mesh, expected_tetrahedra, make_mesh, mesh_job


def meshed(geometry, size):
    raw = make_mesh(geometry, size)
    return raw, build_mesh(raw.points / 1e3, raw.elements, raw.parts, raw.surface, raw.surface_face)


@pytest.fixture(scope="module")
def domed():
    """A block with a dome on top, a chamber of the same kind below, and a plate it stands on."""
    block = Box((-50.0, -40.0, 10.0), (100.0, 80.0, 30.0), name="block")
    dome = Ellipsoid((0.0, 0.0, 40.0), (35.0, 30.0, 20.0), "z+", name="dome")
    shaft = Cylinder((0.0, 0.0, 10.0), "z", 25.0, (20.0, 15.0), name="shaft")
    geometry = Geometry(
        (Body("plate", (Box((-60.0, -40.0, 0.0), (120.0, 80.0, 10.0)),)), Body("mold", (block, dome))),
        (Body("chamber", (shaft,)),),
        (Patch("plate", Box((-60.0, -40.0, -1.0), (30.0, 30.0, 1.0))),),
    )
    raw, mesh = meshed(geometry, 12.0)
    return raw, mesh, Faces(mesh, geometry)


def test_volumes_are_those_of_the_formulas(domed):
    from hyperfab.thermal import elements

    raw, mesh, _ = domed
    volume = np.bincount(mesh.parts, elements.metric(mesh.points[mesh.elements]).volume.sum(axis=1)) * 1e9
    mold = 100 * 80 * 30 + 2 / 3 * np.pi * 35 * 30 * 20 - np.pi * 20 * 15 * 25
    np.testing.assert_allclose(volume, [120 * 80 * 10, mold], rtol=2e-4)
    np.testing.assert_allclose(raw.volumes, [120 * 80 * 10, mold], rtol=1e-5)


def test_faces_have_the_areas_of_the_formulas(domed):
    _, _, faces = domed

    def area(name):
        return faces.area(faces.named(name)) * 1e6

    assert area("plate.z-") == pytest.approx(120 * 80, rel=1e-9)
    assert area("plate.x+") == pytest.approx(10 * 80, rel=1e-9)
    assert area("plate.z+") == pytest.approx(120 * 80 - np.pi * 20 * 15, rel=2e-3)  # not the chamber's floor
    assert area("chamber.z-") == pytest.approx(np.pi * 20 * 15, rel=2e-3)
    assert area("chamber.z+") == pytest.approx(np.pi * 20 * 15, rel=2e-3)
    perimeter = 2 * np.pi * np.sqrt((20**2 + 15**2) / 2) * 0.9922  # of the ellipse, within half a percent
    assert area("shaft.all") - 2 * np.pi * 20 * 15 == pytest.approx(25 * perimeter, rel=0.01)
    top = 100 * 80 - np.pi * 35 * 30
    assert area("mold.z+") - area("dome.z+") == pytest.approx(top, rel=2e-3)
    joint = faces.interface("plate", "mold")
    assert faces.area(joint) * 1e6 == pytest.approx(100 * 80 - np.pi * 20 * 15, rel=2e-3)


def test_faces_in_a_box_end_at_its_outline(domed):
    _, _, faces = domed
    found = faces.inside("plate", Box((-60.0, -40.0, -1.0), (30.0, 30.0, 1.0)))
    assert faces.area(found) * 1e6 == pytest.approx(900.0, rel=1e-9)


def test_the_nearest_names_are_offered(domed):
    with pytest.raises(InputError, match=r"dome\.z\+"):
        domed[2].named("domme.z+")
    with pytest.raises(InputError, match=r"NAME\.WAY"):
        domed[2].named("dome.up")


def test_a_part_may_be_finer_than_its_neighbour():
    plate, sheet = Box((0.0, 0.0, 0.0), (40.0, 40.0, 20.0)), Box((0.0, 0.0, 20.0), (40.0, 40.0, 4.0))
    raw = make_mesh(Geometry((Body("plate", (plate,)), Body("sheet", (sheet,), mesh_size=2.0))), 10.0)
    corners = raw.points[raw.elements[:, :4]]
    edges = np.linalg.norm(corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]], axis=2)
    assert np.median(edges[raw.parts == 1]) < 2.5
    assert edges[raw.parts == 0].max() > 10.0


def test_the_same_geometry_gives_the_same_mesh():
    geometry = Geometry((Body("ball", (Ellipsoid((0.0, 0.0, 0.0), (10.0, 8.0, 12.0)),)),))
    first, second = make_mesh(geometry, 5.0), make_mesh(geometry, 5.0)
    assert first.points.tobytes() == second.points.tobytes()
    assert first.elements.tobytes() == second.elements.tobytes()


@pytest.mark.parametrize("axes", [(10.0, 8.0, 12.0), (8.0, 12.0, 10.0), (12.0, 10.0, 8.0)])
def test_semi_axes_are_along_x_y_z(axes):
    raw = make_mesh(Geometry((Body("ball", (Ellipsoid((1.0, 2.0, 3.0), axes),)),)), 4.0)
    np.testing.assert_allclose(raw.points.max(axis=0) - [1.0, 2.0, 3.0], axes, rtol=0.02)
    assert raw.volumes[0] == pytest.approx(4 / 3 * np.pi * np.prod(axes), rel=1e-5)


@pytest.mark.parametrize(("axis", "low", "high"), [("x", (0, -3, -5), (20, 3, 5)), ("y", (-5, 0, -3), (5, 20, 3))])
def test_elliptic_cylinders_take_their_semi_axes_in_cyclic_order(axis, low, high):
    raw = make_mesh(Geometry((Body("rod", (Cylinder((0.0, 0.0, 0.0), axis, 20.0, (3.0, 5.0)),)),)), 3.0)
    np.testing.assert_allclose(raw.points.min(axis=0), low, atol=0.1)
    np.testing.assert_allclose(raw.points.max(axis=0), high, atol=0.1)


def test_no_thread_waits_for_another_and_the_mesh_is_the_same(monkeypatch):
    # Netgen's threads wait without sleep: where something else runs too, most of the time would be theirs.
    import netgen.occ as occ

    given, made, told = [], occ.OCCGeometry.GenerateMesh, lambda arrays: None

    def one(geometry, **parameters):
        given.append(parameters)
        return made(geometry, **parameters)

    def several(geometry, **parameters):
        return made(geometry, **parameters | {"parallel_meshing": True})

    body = Body("block", (Box((0.0, 0.0, 0.0), (30.0, 20.0, 10.0)), Cylinder((15.0, 10.0, 5.0), "z", 10.0, (5.0, 4.0))))
    job = json.loads(mesh_job(Geometry((body,)), 5.0))
    meshes = []
    for how in (one, several):
        monkeypatch.setattr(occ.OCCGeometry, "GenerateMesh", how)
        meshes.append(netgen_worker.mesh(job, told))
    assert [parameters["parallel_meshing"] for parameters in given] == [False]
    for name, values in meshes[0].items():
        np.testing.assert_array_equal(values, meshes[1][name], err_msg=name)


def test_a_mesher_that_takes_too_long_is_stopped():
    geometry = Geometry((Body("block", (Box((0.0, 0.0, 0.0), (100.0, 100.0, 100.0)),)),))
    with pytest.raises(NotConverged, match="stopped"):
        make_mesh(geometry, 1.5, patience=1.0)


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script stands for the mesher")
@pytest.mark.parametrize("says", ["", "a word", "words that are no mesh and no length of one"])
def test_a_mesher_that_answers_nonsense_has_failed(tmp_path, monkeypatch, says):
    script = tmp_path / "python"
    script.write_text(f"#!/bin/sh\nprintf '{says}'\n")
    script.chmod(0o755)
    monkeypatch.setattr(netgen_process, "_begun", [])
    monkeypatch.setattr(netgen_process.sys, "executable", str(script))
    geometry = Geometry((Body("block", (Box((0.0, 0.0, 0.0), (10.0, 10.0, 10.0)),)),))
    with pytest.raises(NotConverged, match="failed"):
        make_mesh(geometry, 5.0)


def test_the_volumes_come_before_the_mesh():
    geometry = Geometry((Body("block", (Box((0.0, 0.0, 0.0), (20.0, 10.0, 5.0)),)),))
    order = []
    raw = make_mesh(geometry, 5.0, built=lambda volumes: order.append(volumes.tolist()))
    assert order == [pytest.approx([1000.0])]
    np.testing.assert_array_equal(raw.volumes, order[0])


def test_how_many_tetrahedra_to_expect_is_what_fills_the_boxes():
    """A tetrahedron of edge h fills 1/(6 sqrt 2) = 0.118 of h cubed; a part may ask for finer ones."""
    boxes = [(np.zeros(3), np.array([60.0, 40.0, 10.0])), (np.ones(3), np.array([11.0, 11.0, 6.0]))]
    sizes = zip(boxes, (None, 1.0), strict=True)
    geometry = SimpleNamespace(parts=[SimpleNamespace(bounds=box, mesh_size=size) for box, size in sizes])
    found = expected_tetrahedra(geometry, 2.0)
    assert found == pytest.approx((24000.0 / 2.0**3 + 500.0 / 1.0**3) * 6.0 * np.sqrt(2.0), rel=0.02)


@pytest.mark.parametrize("half", ["x-", "x+", "y-", "y+", "z-", "z+"])
def test_half_an_ellipsoid_is_meshed_wherever_it_stands(half):
    raw = make_mesh(Geometry((Body("dome", (Ellipsoid((1.0, 2.0, 3.0), (30.0, 20.0, 25.0), half),)),)), 20.0)
    assert raw.volumes[0] == pytest.approx(2.0 / 3.0 * np.pi * 30.0 * 20.0 * 25.0, rel=1e-6)
    assert len(raw.elements) > 0


def test_a_mesher_that_was_begun_is_taken_and_one_that_ended_is_not(monkeypatch):
    monkeypatch.setattr(netgen_process, "_begun", [])
    netgen_process.begin()
    netgen_process.begin()
    [(begun, _)] = netgen_process._begun
    with netgen_process.taken(b"") as process:
        assert process is begun
        process.kill()
    netgen_process._begun.append((begun, b""))
    with netgen_process.taken(b"") as process:
        assert process is not begun
        process.stdin.close()
        assert process.wait(60) == 0
    netgen_process.begin()
    [(begun, _)] = netgen_process._begun
    netgen_process.end()
    assert begun.poll() is not None
    assert netgen_process._begun == []


@pytest.mark.slow
def test_a_mesh_that_was_begun_is_the_one_that_is_made_and_another_is_made_anew(monkeypatch):
    monkeypatch.setattr(netgen_process, "_begun", [])
    geometry = Geometry((Body("block", (Box((0.0, 0.0, 0.0), (20.0, 10.0, 5.0)),)),))
    for size, begins in ((5.0, 1), (4.0, 2)):
        netgen_process.begin()
        begin_mesh(geometry, 5.0)
        [(begun, _)] = netgen_process._begun
        started = count_started(monkeypatch)
        mesh = make_mesh(geometry, size)
        assert len(started) == begins - 1  # another size is another job
        assert begun.poll() is not None
        assert netgen_process._begun == []
        monkeypatch.undo()
        monkeypatch.setattr(netgen_process, "_begun", [])
        assert mesh.points.tobytes() == make_mesh(geometry, size).points.tobytes()


def count_started(monkeypatch):
    """Return a list that grows with every process of the mesher that is started from now on."""
    started = []
    start = netgen_process._started

    def counted():
        started.append(start())
        return started[-1]

    monkeypatch.setattr(netgen_process, "_started", counted)
    return started
