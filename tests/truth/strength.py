"""How strong an effect is planted: as much beside the noise as was drawn."""

import numpy as np

from . import film, linear_fit, scene


def loudness(rng, given) -> tuple[float, float]:
    """Signal to noise (dB) and the declared model's error over the noise floor."""
    snr = given.get("snr", (20, 50))
    snr = rng.uniform(*snr) if isinstance(snr, tuple) else snr
    noise = 10 ** (-snr / 20)
    if given.get("ratio"):
        return snr, min(given["ratio"], max(0.35 / noise, 1.5))
    low, high = max(2.0, 0.012 / noise), min(10.0, 0.3 / noise)
    ratio = np.exp(rng.uniform(np.log(min(low, high)), np.log(max(low, high))))
    return snr, ratio


def error_of(stage, planted, shot) -> float:
    """RMS (m or px) that the declared linear model leaves of a clean film, for the effects' sake.

    What it leaves of the same film without any effect (modes too many to fit) does not count.
    """
    modal = any(p.layer == "modal" for p in planted)
    key = (modal, len(shot.values))
    if any(p.name == "aliasing" for p in planted):
        stage.without[key] = 0.0
    if key not in stage.without:
        stage.without[key] = left_of(stage, film.shoot(stage, [], []), modal, len(shot.values))
    return float(np.sqrt(max(left_of(stage, shot, modal) ** 2 - stage.without[key] ** 2, 0.0)))


def left_of(stage, shot, modal: bool, count=None) -> float:
    """RMS (m or px) of what a fit of the strongest modes leaves."""
    values = shot.values[stage.before : count, : len(stage.markers)]
    values = values.reshape(len(values), -1)
    time = shot.nominal[stage.before : count] - shot.nominal[stage.before]
    plain = film.model(stage, [])
    flat = np.array([seen(stage, shot, plain.at(n)) for n in stage.markers]).reshape(-1, plain.size)
    start, _ = scene.start_of(stage, plain)
    r = plain.size
    size = np.hypot(start[:r], start[r : 2 * r] / (2 * np.pi * plain.frequency))
    size = size * np.linalg.norm(flat, axis=0) * (plain.frequency < 0.5 * stage.fps)
    if not modal:  # free shapes: of two modes at one frequency the stronger will do
        twin = np.abs(np.diff(plain.frequency)) < 2e-3 * plain.frequency[1:]
        weaker = np.flatnonzero(twin) + (size[:-1][twin] > size[1:][twin])
        size[weaker] = 0
    strong = np.sort(np.argsort(size)[::-1][:6])
    strong = strong[size[strong] > 0.003 * size.max()]
    f, z = plain.frequency[strong], plain.damping_ratio[strong]
    return linear_fit.leftover(time, values, f, z, flat[:, strong] if modal else None)


def unseen(stage, planted, shot) -> float:
    """RMS (m or px) by which the declared model misses what a fit of free modes does not show."""
    if not stage.declared:  # no damping at all: the best steady swing misses about half the motion
        return 0.5 * spread(shot, stage)
    if [p.name for p in planted] == ["clock"] and stage.release == "gravity":
        values = shot.values[:, : len(stage.markers)]
        sag = values[-(len(values) // 3) :].mean(0) - values[0]
        factor = planted[0].parameters(1.0, shot)["factor"]
        return float(
            abs(factor**2 - 1) * np.sqrt(np.mean(sag**2))
        )  # of pitch and sag only one fits
    return 0.0


def seen(stage, shot, motion) -> np.ndarray:
    """Motion (3, r) of a marker as (d, r) of its channels, by the declared camera."""
    if shot.values.shape[2] == 3:
        return motion
    rows = np.array([stage.camera.right, stage.camera.down]) / stage.camera.metres_per_pixel
    return rows @ motion


def trim(stage, planted, shot, sigma: float, error: float):
    """Stop filming where nothing is seen to move any more, as anybody would."""
    values = shot.values[stage.before :, : len(stage.markers)]
    third = len(values) // 3
    while stage.frames > 100 and (values[-third:].std(0) ** 2).mean() < (2 * sigma) ** 2:
        stage.frames = max(int(stage.frames * 0.85), 100)
        values, third = values[: stage.frames], stage.frames // 3
    whole = stage.before + stage.frames
    if whole < len(shot.values):
        shot.nominal, shot.time, shot.values = (
            a[:whole] for a in (shot.nominal, shot.time, shot.values)
        )
        error = error_of(stage, planted, shot) if planted else error
    return shot, error


def tune(stage, planted, snr: float, ratio: float):
    """Strengths that leave `ratio` times the noise, by secant in the logarithm; else less noise."""
    strengths = [p.strength for p in planted]
    shot = film.shoot(stage, planted, strengths)
    rms = spread(shot, stage)
    sigma = rms * 10 ** (-snr / 20)
    wanted = sigma * np.sqrt(ratio**2 - 1)
    if not planted:
        return shot, strengths, sigma, left_of(stage, shot, False)
    alone = {}
    for i, one in enumerate(planted):
        strengths[i], alone[one.name] = tune_one(stage, one, wanted)
    shot = film.shoot(stage, planted, strengths)
    shot.facts["alone"] = alone
    fitted = [alone[p.name] for p in planted if p.tunable or p.name == "lost_frames"]
    if fitted:
        sigma = min(max(min(fitted) / np.sqrt(ratio**2 - 1), rms * 10**-2.5), rms * 0.1)
    return shot, strengths, sigma, error_of(stage, planted, shot)


def tune_one(stage, one, wanted: float) -> tuple[float, float]:
    """Strength whose leftover (m or px) is near `wanted`, and the leftover."""
    s, power = one.strength, 1.0
    error = error_of(stage, [one], film.shoot(stage, [one], [s]))
    if not np.isfinite(error):
        raise ValueError(f"truth: {one.name} of strength {s} blows up.")
    for _ in range(3 if one.tunable else 0):
        if abs(np.log(max(error, 1e-30) / wanted)) < 0.15:
            break
        new = float(np.clip(s * (wanted / max(error, 1e-30)) ** (1 / power), *one.limits))
        if abs(np.log(new / s)) < 0.02:
            break
        after = error_alone(stage, one, new)
        while not np.isfinite(after):  # it ran away: half as far
            new = (s * new) ** 0.5
            after = error_alone(stage, one, new)
        if min(after, error) > 0:
            power = np.clip(np.log(after / error) / np.log(new / s), 0.4, 3.0)
        s, error = new, after
    return s, error


def error_alone(stage, one, s: float) -> float:
    """What one effect of strength s leaves; infinite where its motion runs away."""
    try:
        return error_of(stage, [one], film.shoot(stage, [one], [s]))
    except ValueError:
        return np.inf


def spread(shot, stage) -> float:
    """RMS (m or px) of the object's markers about their means, after the release."""
    values = shot.values[stage.before :, : len(stage.markers)]
    return float(np.sqrt(np.mean((values - values.mean(0)) ** 2)))
