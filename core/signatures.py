"""Where the misfit sits: the residual's energy by signature, before any effect is named."""

import numpy as np

from .law import TimeFit

NAMES = (
    "mean", "envelope", "pitch over amplitude", "pitch over time", "harmonics", "single markers",
    "common motion", "other",
)  # fmt: skip


def budget(found: TimeFit) -> dict[str, float]:
    """Share of the residual's energy by signature, over the first fitted take; sums to 1.

    Each signature is a set of columns in time, taken off one after the other, channel by channel:
    slow ones; the modes' motion and speed times slow factors (envelope, pitch); overtones of
    the first mode. What is left is split into what one marker has alone, what all share, and rest.
    """
    law = found.law
    data = law.takes[law.fitted[0]]
    left = np.nan_to_num(found.missed(0) / data.sigma)
    left = left[data.fit][:, ~data.support]
    total = float((left**2).sum())
    shares, taken = {}, np.zeros((len(left), 0))
    for name, columns in _columns(found, data).items():
        taken = np.hstack([taken, columns])
        q, _ = np.linalg.qr(taken)
        rest = left - q @ (q.T @ left)
        shares[name] = max(total - float((rest**2).sum()) - sum(shares.values()), 0.0)
    by_marker = [float((rest[:, data.marker[~data.support] == m] ** 2).sum())
                 for m in np.unique(data.marker[~data.support])]  # fmt: skip
    even = np.median(by_marker) * len(by_marker)
    shares["single markers"] = max(sum(by_marker) - even, 0.0)
    d = data.take.recording.values.shape[2]
    mean = rest.reshape(len(rest), -1, d).mean(axis=1)
    common = float((mean**2).sum()) * len(by_marker) - sum(by_marker) / len(by_marker)
    shares["common motion"] = float(np.clip(common, 0.0, max(even, 0.0)))
    shares["other"] = max(total - sum(shares.values()), 0.0)
    whole = sum(shares.values())
    return {name: float(shares[name] / whole) for name in NAMES} if whole > 0 else {"other": 1.0}


def _columns(found: TimeFit, data) -> dict[str, np.ndarray]:
    time = data.time[data.fit]
    u = found.motions[0][data.fit]
    v = np.gradient(u, time, axis=0)
    s = 2 * time[:, None] / time[-1] - 1
    period = 2 * np.pi / found.law.setting.omega[0]
    slow = max(int(2 * 0.4 * time[-1] / period), 2)
    mean = np.hstack([np.cos(np.pi * k * (s + 1) / 2) for k in range(slow)])
    fall = np.exp(-2 * found.damping_ratio[0] * 2 * np.pi / period * time)[:, None]
    f = 2 * np.pi * time[:, None] / period
    overtones = [w(n * f) * g for n in (2, 3) for w in (np.cos, np.sin) for g in (1, fall)]
    return {
        "mean": mean,
        "envelope": np.hstack([u * s, u * s**2, u * fall]),
        "pitch over amplitude": v * fall,
        "pitch over time": np.hstack([v * s, v * s**2]),
        "harmonics": np.hstack(overtones),
    }
