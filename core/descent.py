"""Least squares within bounds, from many places in step."""

from collections.abc import Callable

import numpy as np

HARDER = 6.0  # times as much damping after a refused step; three times so where it did nothing
IN_VAIN = 1e-3  # of what a refused step lost, by which it did nothing
FLAT = 2  # refused steps that lost no more than a last look gains, after which a search ends


def descend(look: Callable, starts: np.ndarray, bounds, end: tuple[int, float, float]) -> list:
    """(p, Jacobian, cost) where the search from each of `starts` (S, p) ends; they go in step.

    look: the residuals (R,) and Jacobian (R, p) at each of a list of places. bounds: (p,) and (p,).
    end: after how many looks, or when a look gains less than that share, or than that.
    """
    searches = [_search(p, bounds, end) for p in starts]
    asked = {i: next(search) for i, search in enumerate(searches)}
    ended = [None] * len(starts)
    while asked:
        seen = look(list(asked.values()))
        for i, one in zip(list(asked), seen, strict=True):
            try:
                asked[i] = searches[i].send(one)
            except StopIteration as done:
                ended[i] = done.value
                del asked[i]
    return ended


def _search(p, bounds, end: tuple[int, float, float]):
    """Levenberg-Marquardt within bounds (More, Lect. Notes Math. 630 (1978) 105): asks for the
    residuals and Jacobian at places, returns p, Jacobian, cost.

    The normal equations are of the few searched parameters only, so they are cheap, and scaled to
    unit diagonal they are well enough conditioned.
    """
    low, high = bounds
    evaluations, enough, close = end
    r, jacobian = yield p
    cost, damping, refused, flat = r @ r, 1e-3, np.inf, 0
    normal, slope, scale = _scaled(jacobian, r)
    for _ in range(evaluations):
        stuck = ((p <= low + 1e-12) & (slope > 0)) | ((p >= high - 1e-12) & (slope < 0))
        H = normal + damping * np.eye(len(p))
        H[stuck], H[:, stuck] = 0.0, 0.0
        H[stuck, stuck] = 1.0
        move = -np.linalg.solve(H, np.where(stuck, 0.0, slope)) / scale
        trial = np.clip(p + move, low + 1e-12, high - 1e-12)
        after, tangent = yield trial
        if after @ after < cost:
            gain, p, r, jacobian = cost - after @ after, trial, after, tangent
            cost, damping, refused, flat = r @ r, damping / 8, np.inf, 0
            normal, slope, scale = _scaled(jacobian, r)
            if gain < max(enough * cost + 0.05, close):
                break
        else:
            loss = after @ after - cost
            flat += loss < max(enough * cost, close)
            in_vain = abs(loss - refused) < IN_VAIN * refused
            damping, refused = damping * HARDER ** (3 if in_vain else 1), loss
            if damping > 1e6 or flat > FLAT:
                break
    return p, jacobian, cost


def _scaled(jacobian: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(p, p) normal matrix with ones on its diagonal, (p,) slope, and by what (p,) both are scaled;
    where the residuals do not depend on a parameter there is a nought.
    """
    normal = jacobian.T @ jacobian
    scale = np.sqrt(np.diag(normal))
    scale = np.where(scale > 0, scale, 1.0)
    return normal / np.outer(scale, scale), jacobian.T @ r / scale, scale
