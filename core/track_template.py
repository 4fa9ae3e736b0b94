"""Small pieces of the first picture, and where they are in another one: affine, to sub-pixel.

Inverse-compositional Gauss-Newton (Baker & Matthews, Lucas-Kanade 20 years on, IJCV 2004), all
points at once, with a gain and an offset of brightness. Both pictures are seen through a cubic
B-spline: shifting the picture shifts what is seen exactly, without the bias of interpolation.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from .data import seal

RADIUS = 15  # px, half the window
TAPER = 0.5  # outer share of the window where its weight falls to zero
MOST_STEPS = 12
APPROACH = 2  # of them through a coarse look
LEAST_GAIN = 0.2  # of contrast, against the first picture
CLOSE = 3e-3  # px, a step that ends the search
SOFT = 0.1  # prior standard deviation of one step of the affine part, beside that of 1 px of shift
LAGS = 4  # px, reach of the noise's correlation
SIDE = 2 * RADIUS + 1
GRID = np.stack(np.meshgrid(*[np.arange(-RADIUS, RADIUS + 1.0)] * 2), -1).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Templates:
    """Windows of the first picture around n points, with what a Gauss-Newton step needs."""

    points: np.ndarray  # (n, 2) px, the points themselves
    centre: np.ndarray  # (n, 2) px, the whole pixels that the windows are around
    values: np.ndarray  # (n, N) grey levels, N = 31 * 31
    weight: np.ndarray  # (n, N) 1
    columns: np.ndarray  # (n, N, 8) d(grey)/d(shift 2, affine 4, gain, offset)
    solve: np.ndarray  # (n, 8, N) weighted least squares of `columns`
    normal: np.ndarray  # (n, 2, 2) grey2/px2, information of the shift with all else free

    def __post_init__(self):
        n = len(self.points)
        seal(self, "points", float, (None, 2))
        seal(self, "centre", float, (n, 2))
        seal(self, "values", np.float32, (n, len(GRID)))

    def subset(self, which: np.ndarray) -> "Templates":
        """The templates `which` (m,) of them."""
        return Templates(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the windows were found: template place x -> affine x + place."""

    affine: np.ndarray  # (n, 2, 2) 1
    place: np.ndarray  # (n, 2) px of the window's centre
    residual: np.ndarray  # (n,) grey levels rms
    match: np.ndarray  # (n,) share of the window's contrast explained, at most 1
    left: np.ndarray  # (n, N) grey levels, what the template does not explain
    step: np.ndarray  # (n,) px, the last step: large where the search did not settle


def make_templates(grey: np.ndarray, points: np.ndarray) -> Templates:
    """The windows around `points` (n, 2) px of the picture `grey` (height, width)."""
    points = np.asarray(points, float)
    centre = np.round(points)
    identity = np.tile(np.eye(2), (len(points), 1, 1))
    values = sample(grey, identity, centre)
    weight = _window() * _inside(grey.shape, centre[:, None] + GRID, 2)
    slope = [_slope(grey, centre, axis) for axis in (0, 1)]
    x, y = GRID.T.astype(np.float32)
    flat = np.ones_like(values)
    columns = np.stack(
        [*slope, slope[0] * x, slope[0] * y, slope[1] * x, slope[1] * y, values, flat], -1
    )
    weighted = columns * weight[..., None]
    information = np.einsum("nij,nik->njk", weighted, columns, dtype=float)
    solve = np.linalg.solve(information + _prior(information), weighted.transpose(0, 2, 1))
    rest = np.linalg.pinv(information[:, 2:, 2:], rcond=1e-9, hermitian=True)
    cross = information[:, :2, 2:]
    normal = information[:, :2, :2] - cross @ rest @ cross.transpose(0, 2, 1)
    return Templates(points, centre, values, weight, columns, solve.astype(np.float32), normal)


def sample(grey: np.ndarray, affine: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Grey levels (n, N) of the windows affine x + place, through a cubic B-spline."""
    seen = np.einsum("nij,gj->nig", affine, GRID) + place[:, :, None]
    return map_coordinates(
        grey, seen[:, ::-1].transpose(1, 0, 2), np.float32, 3, mode="nearest", prefilter=False
    )


def glance(grey: np.ndarray, affine: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The same, bilinear and to a 32nd of a pixel: twenty times faster, good enough to approach."""
    seen = (np.einsum("nij,gj->nig", affine, GRID) + place[:, :, None]).astype(np.float32)
    u, v = seen[:, 0], seen[:, 1]
    return cv2.remap(grey, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(u.dtype)


def refine(first: Templates, grey: np.ndarray, affine: np.ndarray, place: np.ndarray) -> Fit:
    """The windows of `first` in the picture `grey`, searched from affine (n, 2, 2), place (n, 2).

    W(x) = A x + t,  W <- W o dW^-1  with  dW(x) = (I + D) x + d  the step that least squares give.
    """
    n = len(place)
    affine, place = affine.copy(), place.copy()
    theta, step = np.zeros((n, 8)), np.full(n, np.inf)
    seen = np.empty_like(first.values)
    going = np.arange(n)
    for k in range(MOST_STEPS):
        which = slice(None) if len(going) == n else going
        look = glance if k < APPROACH else sample
        seen[which] = look(grey, affine[which], place[which])
        difference = seen[which] - first.values[which]
        # no BLAS here: on pieces this small its threads cost more than they do
        theta[which] = np.einsum("nij,nj->ni", first.solve[which], difference)
        change = theta[which, :6] / np.clip(1 + theta[which, 6:7], LEAST_GAIN, 1 / LEAST_GAIN)
        back = np.eye(2) + np.clip(change[:, 2:].reshape(-1, 2, 2), -0.3, 0.3)
        affine[which] = affine[which] @ _inverse(back)
        place[which] -= (affine[which] @ np.clip(change[:, :2, None], -5, 5))[..., 0]
        step[which] = np.linalg.norm(change[:, :2], axis=1)
        if k >= APPROACH and not len(going := going[step[going] > CLOSE]):
            break
    said = np.einsum("nji,ni->nj", first.columns, theta.astype(np.float32))
    left = seen - first.values - said
    power, match = _likeness(first, seen, left)
    return Fit(affine, place, power, np.where(1 + theta[:, 6] > LEAST_GAIN, match, 0), left, step)


def _inverse(A: np.ndarray) -> np.ndarray:
    """(n, 2, 2) inverses by Cramer's rule."""
    a, b, c, d = A[:, 0, 0], A[:, 0, 1], A[:, 1, 0], A[:, 1, 1]
    return np.stack([d, -b, -c, a], -1).reshape(-1, 2, 2) / (a * d - b * c)[:, None, None]


def _likeness(first: Templates, seen, left) -> tuple[np.ndarray, np.ndarray]:
    """Residual rms (n,) grey levels and share (n,) of the contrast that the template explains."""
    total = first.weight.sum(1)
    middle = (first.weight * seen).sum(1) / total
    power = (first.weight * left**2).sum(1) / total
    contrast = (first.weight * (seen - middle[:, None]) ** 2).sum(1) / total
    return np.sqrt(power), 1 - power / np.maximum(contrast, 1e-6)


def positions(first: Templates, fit: Fit) -> np.ndarray:
    """(n, 2) px where the points themselves are, which need not be whole pixels at first."""
    offset = first.points - first.centre
    return fit.place + np.einsum("nij,nj->ni", fit.affine, offset)


def inside_picture(fit: Fit, first: Templates, shape) -> np.ndarray:
    """(n,) bool: all of the window that counts lies in the picture."""
    corners = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * (RADIUS - 2.0)
    whole = _inside(shape, first.centre[:, None] + corners, 0).all(1)
    seen = np.einsum("nij,gj->ngi", fit.affine, corners) + fit.place[:, None]
    centred = _inside(shape, fit.place[:, None], 1)[:, 0]
    return centred & (_inside(shape, seen, 0).all(1) | ~whole)


def noise_gain(first: Templates, correlation: np.ndarray) -> np.ndarray:
    """(n,) px per grey level: rms shift (mean of two axes) that residual noise of rms 1 makes.

    `correlation` (2 LAGS + 1, 2 LAGS + 1) of the noise between pixels so many rows, columns apart.
    With L the rows of `solve` for the shift, var = sum_xy L(x) rho(x - y) L(y).
    """
    rows = first.solve[:, :2].reshape(-1, SIDE, SIDE).astype(float)
    spread = np.abs(np.fft.rfft2(rows, (2 * SIDE, 2 * SIDE))) ** 2
    own = np.fft.irfft2(spread, (2 * SIDE, 2 * SIDE))
    lags = np.arange(-LAGS, LAGS + 1)
    variance = (own[:, lags[:, None], lags] * correlation).sum((1, 2)).reshape(-1, 2)
    return np.sqrt(np.maximum(variance.mean(1), 0))


def residual_products(first: Templates, left: np.ndarray) -> np.ndarray:
    """Sums of products of residuals so many rows, columns apart (2 LAGS + 1, 2 LAGS + 1)."""
    weighted = (left * np.sqrt(first.weight)).reshape(-1, SIDE, SIDE)
    spread = np.abs(np.fft.rfft2(weighted, (2 * SIDE, 2 * SIDE))) ** 2
    own = np.fft.irfft2(spread.sum(0), (2 * SIDE, 2 * SIDE))
    lags = np.arange(-LAGS, LAGS + 1)
    return own[lags[:, None], lags]


def _window() -> np.ndarray:
    """(N,) weights, flat inside and falling as a cosine towards the window's edge."""
    far = np.abs(np.arange(-RADIUS, RADIUS + 1)) / (RADIUS + 1)
    fall = np.clip((far - (1 - TAPER)) / TAPER, 0, 1)
    line = (1 + np.cos(np.pi * fall)) / 2
    return np.outer(line, line).ravel().astype(np.float32)


def _inside(shape, places, margin) -> np.ndarray:
    """Bool of places (..., 2) px that are in a picture of `shape`, `margin` px off its edge."""
    limit = np.array(shape[::-1]) - 1 - margin
    return ((places >= margin) & (places <= limit)).all(-1)


def _slope(grey, centre, axis) -> np.ndarray:
    """(n, N) derivative of the picture as the spline sees it, which is smooth enough for this."""
    tiny = 0.01 * np.eye(2)[axis]
    identity = np.tile(np.eye(2), (len(centre), 1, 1))
    return (sample(grey, identity, centre + tiny) - sample(grey, identity, centre - tiny)) / 0.02


def _prior(information) -> np.ndarray:
    """(n, 8, 8) that keeps what the window cannot tell (a straight edge, a plain) from running."""
    strength = np.maximum(np.einsum("njj->nj", information)[:, :2].sum(1), 1e-6) * 1e-4
    scale = np.array([1, 1, *[1 / SOFT**2] * 4, 0, 0])
    prior = strength[:, None] * scale
    prior[:, 6:] = 1e-6 * np.einsum("njj->nj", information)[:, 6:] + 1e-12
    return prior[:, :, None] * np.eye(8)
