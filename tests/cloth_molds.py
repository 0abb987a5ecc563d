"""Molds with known geometry for the cloth's tests."""

from __future__ import annotations

from collections.abc import Callable

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


def height_block(
    height: Callable[[np.ndarray, np.ndarray], np.ndarray],
    half: tuple[float, float],
    cells: tuple[int, int],
    base: float,
) -> Surface:
    """Block of half sides ``half`` with upright walls; its top is the graph of ``height`` on ``cells``."""
    n, m = cells[0] + 1, cells[1] + 1
    u, v = np.meshgrid(np.linspace(-half[0], half[0], n), np.linspace(-half[1], half[1], m), indexing="ij")
    top = np.column_stack([u.ravel(), v.ravel(), height(u, v).ravel()])
    floor = np.column_stack([u.ravel(), v.ravel(), np.full(n * m, base)])
    number, k = np.arange(n * m).reshape(n, m), n * m
    a, b, c, d = (number[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[1:, -1][::-1], number[0, 1:][::-1]])
    on = np.roll(rim, -1)
    faces = [[a, b, c], [a, c, d], [a + k, c + k, b + k], [a + k, d + k, c + k]]
    faces += [[rim, on + k, on], [rim, rim + k, on + k]]
    return Surface(np.vstack([top, floor]), np.vstack([np.column_stack(face) for face in faces]))


def saddle(half: float = 60.0, height: float = 25.0, cells: int = 40, turned: bool = False) -> Surface:
    """Block with a saddle on top: two ridges face each other, arched (or, ``turned``, straight and aslope)."""

    def top(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return height * (u * v if turned else u * u - v * v) / half**2

    return height_block(top, (half, half), (cells, cells), -height - 40.0)


def under(surface: Surface, depth: float) -> tuple[float, float, float]:
    """Shift that centres a surface under the sheet, its top ``depth`` mm above the sheet's plane."""
    low, high = surface.vertices.min(0), surface.vertices.max(0)
    return -0.5 * (low[0] + high[0]), -0.5 * (low[1] + high[1]), depth - high[2]
