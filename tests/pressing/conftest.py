"""Meshes whose gaps are known in closed form."""

import sys

import numpy as np
import pytest

from hyperfab.pressing.mold import Mold


def cap(radius, angle_deg, rings, height=0.0, twist=0.0):
    """A spherical cap about the axis, rings of 6, 12, 18, ... points; its normals point outward."""
    angle = np.radians(angle_deg)
    points, rows = [[0.0, 0.0, radius + height]], [[0]]
    for ring in range(1, rings + 1):
        theta = angle * ring / rings
        phi = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring) + twist * ring
        rows.append([len(points) + i for i in range(6 * ring)])
        points += [
            [
                radius * np.sin(theta) * np.cos(p),
                radius * np.sin(theta) * np.sin(p),
                radius * np.cos(theta) + height,
            ]
            for p in phi
        ]
    faces = []
    for ring in range(1, rings + 1):
        inner, outer = rows[ring - 1], rows[ring]
        for sector in range(6):
            for i in range(ring):
                a = inner[(sector * (ring - 1) + i) % len(inner)]
                b, c = (outer[(sector * ring + j) % len(outer)] for j in (i, i + 1))
                faces.append([a, b, c])
                if i < ring - 1:
                    faces.append([a, c, inner[(sector * (ring - 1) + i + 1) % len(inner)]])
    return np.array(points), np.array(faces)


def plate(a, b, cells_x, cells_y, height=0.0, slope=0.0):
    """A rectangle a x b about the axis, rising along x by ``slope``; its normals point up."""
    x, y = np.linspace(-a / 2, a / 2, cells_x + 1), np.linspace(-b / 2, b / 2, cells_y + 1)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(grid)).reshape(cells_x + 1, cells_y + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = np.column_stack([grid, height + slope * grid[:, 0]])
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def male(points, faces, mount=None, smooth=True):
    return Mold(points, faces, 1, points[:, 2].min() if mount is None else mount, smooth)


def female(points, faces, mount=None, smooth=True):
    """The same surface seen from above: facets turned."""
    return Mold(points, faces[:, ::-1].copy(), -1, points[:, 2].max() if mount is None else mount, smooth)


def nested_caps(rings, a=70.0, b=75.0, d=1.5, smooth=True):
    """Sphere a inside sphere b, its centre shifted by d towards the pole of b."""
    inner = male(*cap(a, 80.0, rings), mount=0.0, smooth=smooth)
    outer = female(*cap(b, 88.0, int(1.13 * rings), height=-d, twist=0.013), smooth=smooth)
    return inner, outer


@pytest.fixture(scope="session")
def shapes():
    """The functions of this module."""
    return sys.modules[__name__]
