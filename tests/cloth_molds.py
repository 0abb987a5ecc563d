"""Molds with known geometry for the cloth's tests."""

from __future__ import annotations

import numpy as np
import trimesh

from hyperfab.surface import Surface


def ball(subdivisions: int = 5, radius: float = 60.0) -> Surface:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Surface(mesh.vertices, mesh.faces)


def long_cylinder(radius: float, sections: int, length: float = 40.0) -> Surface:
    """Cylinder along y, its polygon inscribed so that its area, and to second order its girth, is the circle's."""
    angle = 2 * np.pi * (np.arange(sections) + 0.5) / sections
    r = radius * np.sqrt(2 * np.pi / sections / np.sin(2 * np.pi / sections))
    ring = np.column_stack([r * np.sin(angle), np.zeros(sections), r * np.cos(angle)])
    half = np.array([[0.0, length / 2, 0.0]])
    vertices = np.vstack([ring - half, ring + half, -half, half])
    faces = []
    for i in range(sections):
        j = (i + 1) % sections
        faces += [[i, j, j + sections], [i, j + sections, i + sections]]
        faces += [[j, i, 2 * sections], [i + sections, j + sections, 2 * sections + 1]]
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if mesh.volume < 0:
        mesh.invert()
    return Surface(mesh.vertices, mesh.faces)


def punch(sections: int, radius: float = 40.0, height: float = 60.0) -> Surface:
    """Upright cylinder with a flat top and a sharp rim, its top at z = 0."""
    mesh = trimesh.creation.cylinder(radius=radius, height=height, sections=sections)
    return Surface(mesh.vertices - [0, 0, height / 2], mesh.faces)


def block(side: float = 80.0, height: float = 60.0, turn: float = 0.0) -> Surface:
    """Box with its top at z = 0, turned about z by ``turn`` rad."""
    mesh = trimesh.creation.box((side, side, height))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
    return Surface(mesh.vertices - [0, 0, height / 2], mesh.faces)
