"""Harmonic inversion beside the Cramer-Rao bound: `python -m tests.bench.inversion`.

Two modes 3.1 and 3.4 Hz, damping ratios 2 and 2.5 %, 30 frames/s, 4 s; how many of 40 records are
merged, what the frequencies' errors are over the bound, how long it takes. Then one fit of given
poles to 500 frames of 18 channels.
"""

import time

import numpy as np

from core.data import poles
from core.harmonic_inversion import fit_poles, invert
from core.noise_floor import noise_floor

FREQUENCY, DAMPING = np.array([3.1, 3.4]), np.array([0.02, 0.025])
SECONDS = np.arange(120) / 30
RECORDS = 40


def bound(level: float) -> np.ndarray:
    """(2,) Hz: the least standard deviation of any unbiased estimate, offset unknown too."""

    def model(v):
        phase = np.exp(np.outer(SECONDS, poles(v[:2], v[2:4])))
        return (phase @ (v[4:6] + 1j * v[6:8])).real + v[8]

    v = np.concatenate([FREQUENCY, DAMPING, [1, 0], [0, 1], [0]])
    steps = 1e-6 * np.eye(9)
    J = np.stack([(model(v + s) - model(v - s)) / 2e-6 for s in steps], axis=1)
    return level * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))[:2]


def pair(decibel: float) -> None:
    clean = (np.exp(np.outer(SECONDS, poles(FREQUENCY, DAMPING))) @ np.array([[1], [1j]])).real
    level = np.sqrt(np.mean(clean**2)) * 10 ** (-decibel / 20)
    errors, begun = [], time.process_time()
    for seed in range(RECORDS):
        noise = np.random.default_rng(seed).standard_normal(clean.shape)
        found = np.sort(invert(SECONDS, clean + level * noise).frequency)
        if len(found) == 2:
            errors.append(found - FREQUENCY)
    spent = (time.process_time() - begun) / RECORDS
    ratio = np.sqrt(np.mean(np.square(errors), axis=0)) / bound(level)
    print(
        f"{decibel:3g} dB: {RECORDS - len(errors):2d} of {RECORDS} merged or missed, "
        f"rms over bound {ratio[0]:.2f} {ratio[1]:.2f}, {1e3 * spent:.0f} ms each"
    )


def speed() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(500) / 100
    f, z = np.array([3.0, 7.0, 12.0]), np.array([0.02, 0.03, 0.05])
    y = (np.exp(np.outer(t, poles(f, z))) @ rng.standard_normal((3, 18))).real
    y += 0.03 * rng.standard_normal(y.shape)
    for name, verb in (
        ("fit_poles", lambda: fit_poles(t, y, 1.02 * f, 1.3 * z)),
        ("invert", lambda: invert(t, y)),
        ("noise_floor", lambda: noise_floor(t, y)),
    ):
        spent = []
        for _ in range(5):
            begun = time.process_time()
            verb()
            spent.append(time.process_time() - begun)
        print(f"{name}, 500 frames, 18 channels, 3 modes: {1e3 * min(spent):.1f} ms")


if __name__ == "__main__":
    for decibel in (10, 20, 30, 40):
        pair(decibel)
    speed()
