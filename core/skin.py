"""Few points of the surface, with weights, that stand for all of it in the drag.

The points are spread evenly over what all of them do in the modes; the weights, none negative, make
the drag on every mode right for many motions, and stay near what each point stands for.
Source      Farhat, Avery, Chapman and Cortial, Int. J. Numer. Meth. Eng. 98 (2014) 625: points
            and weights that keep the work of a nonlinear force
"""

import numpy as np
from scipy.optimize import nnls
from scipy.spatial import cKDTree

POINTS = 100  # for each a row of a product that is made at every step of a march
MOTIONS = 60  # by chance, for which the drag is to be right, beside each mode's own either way
LESS = 0.2  # of its speed, with which each mode goes in half of them
LEAST = 1e-3  # of the most dragged mode's work: one that slides along its skin counts as if so much
NEAR = 0.02  # how much a weight off what its point stands for counts beside a drag off by as much


def few(moved: np.ndarray, facing: np.ndarray, areas: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which points (s,), and how much area (s,) m2 each stands for.

    moved (q, 3, K): motion of every point in the modes; facing (q, K): that along the outward
    normal; areas (q,) m2.
    """
    work = (np.abs(facing) * (moved**2).sum(axis=1)).T / 2 * areas  # (K, q) of the drag in a mode
    whole = work.sum(axis=1)
    whole = np.maximum(whole, max(LEAST * whole.max(), 1e-300))
    chance = (work / whole[:, None]).sum(axis=0)
    chance = chance / chance.sum()
    size = whole ** (-1 / 3)  # so that all modes are dragged alike
    moved, facing = moved * size, facing * size
    features = np.c_[facing, moved.reshape(len(areas), -1)]
    tree = cKDTree(features, leafsize=1, compact_nodes=False)  # its order has like beside like
    step = (np.arange(POINTS) + 0.5) / POINTS
    order = tree.indices
    some = np.searchsorted(np.cumsum(chance[order]), step)
    pick, count = np.unique(order[some], return_counts=True)
    area = areas[pick] / chance[pick] * count / POINTS
    motions = _motions(len(size))
    wanted = _drag(motions, moved, facing, "nk", areas)
    own = _drag(motions, moved[pick], facing[pick], "nkq", area).reshape(-1, len(pick))
    hold = NEAR * np.linalg.norm(own) / np.sqrt(len(pick))
    rows = np.vstack([own, hold * np.eye(len(pick))])
    try:
        share, _ = nnls(rows, np.r_[wanted.ravel(), np.full(len(pick), hold)])
    except RuntimeError:  # it gave up
        share = np.ones(len(pick))
    return pick[share > 0], (area * share)[share > 0]


def _motions(modes: int) -> np.ndarray:
    """(n, K) speeds of the modes."""
    rng = np.random.default_rng(0)
    loud = np.where(rng.random((MOTIONS, modes)) < 0.5, 1.0, LESS)
    return np.vstack([rng.standard_normal((MOTIONS, modes)) * loud, np.eye(modes), -np.eye(modes)])


def _drag(motions, moved: np.ndarray, facing: np.ndarray, of: str, areas) -> np.ndarray:
    """Drag on every mode at speeds `motions` (n, K): (n, K) of all points, or (n, K, q) of each."""
    into = np.maximum(motions @ facing.T, 0.0)
    velocity = np.einsum("qik,nk->nqi", moved, motions)
    return np.einsum(f"nq,q,nqi,qik->{of}", into, areas, velocity, moved, optimize=True)
