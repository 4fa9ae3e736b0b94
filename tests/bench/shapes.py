"""Surfaces that the benchmarks cut into tetrahedra: a bar, a pudding, an ear."""

import numpy as np

from core.data import Surface


def bar() -> Surface:
    """1 m x 0.1 m x 0.1 m, from x = 0."""
    return lofted(np.linspace(0, 1, 31), lambda s, t: squircle(s, t, 40))


def squircle(s: float, t: np.ndarray, power: int) -> np.ndarray:
    """A rounded square of 0.1 m at x = s."""
    c, d = np.cos(t), np.sin(t)
    r = 0.05 / np.maximum(np.abs(c), np.abs(d))
    return np.column_stack([np.full_like(t, s), r * c, r * d])


def pudding() -> Surface:
    """A truncated cone 0.08 m high, 0.12 m wide at its foot z = 0, fluted, its top dented."""

    def ring(s, t):
        radius = (0.06 - 0.02 * s) * (1 + 0.06 * np.cos(6 * t))
        return np.column_stack([radius * np.cos(t), radius * np.sin(t), np.full_like(t, 0.08 * s)])

    return lofted(np.linspace(0, 1, 17), ring)


def ear() -> Surface:
    """A bent, tapering leaf 0.12 m long and 0.008 m to 0.02 m thick, its root at z = 0."""

    def ring(s, t):
        wide = 0.03 * np.sin(np.pi * (0.25 + 0.68 * s)) + 0.002
        thick = 0.010 * (1 - 0.6 * s)
        x = wide * np.cos(t)
        y = thick * np.sin(t) + 4 * x**2 + 0.03 * s**2
        return np.column_stack([x, y, np.full_like(t, 0.12 * s)])

    return lofted(np.linspace(0, 1, 25), ring)


def lofted(stations: np.ndarray, ring, around: int = 48) -> Surface:
    """A closed skin through the rings ring(station, angles) (n, 3), fans over both ends."""
    angles = np.pi / 4 + np.arange(around) * 2 * np.pi / around
    rings = np.concatenate([ring(s, angles) for s in stations])
    ends = np.stack([rings[:around].mean(0), rings[-around:].mean(0)])
    i, j = np.meshgrid(np.arange(len(stations) - 1), np.arange(around), indexing="ij")
    a, b = (i * around + j).ravel(), (i * around + (j + 1) % around).ravel()
    c, d = b + around, a + around
    sides = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    k = np.arange(around)
    foot = np.stack([np.full(around, len(rings)), (k + 1) % around, k], 1)
    last = len(rings) - around
    top = np.stack([np.full(around, len(rings) + 1), last + k, last + (k + 1) % around], 1)
    surface = Surface(np.concatenate([rings, ends]), np.concatenate([sides, foot, top]))
    a, b, c = surface.vertices[surface.faces].transpose(1, 0, 2)
    if np.einsum("fi,fi->", a, np.cross(b, c)) < 0:
        return Surface(surface.vertices, surface.faces[:, ::-1])
    return surface
