"""From a ring-down to the law that the time layer fits: which modes, at which reference."""

from dataclasses import replace

import numpy as np

from .channels import Channels
from .data import RingDown
from .effects.base import Setting
from .elasticity import surface_quadrature
from .law import Law
from .skin import few

PLACES = 48  # where a force may sit, in each direction
PLANES = 12  # where it may rub in a plane
WAYS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of another mode's direction to one of the first's
ALONG = 0.87  # cosine from which two modes move a place along one line


def real_shapes(amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Real shapes (K, C) and complex starts (K,) with amplitude ~ start x shape (K, C).

    The phase that makes each row most nearly real: half that of the sum of squares.
    """
    turn = np.exp(-0.5j * np.angle((amplitude**2).sum(axis=1)))
    shape = (amplitude * turn[:, None]).real
    return shape, np.conj(turn)


def px_per_metre(data: Channels, on=slice(None)) -> float:
    """Channel units per metre of motion across the view, of the channels `on`; 1 for 3-D tracks."""
    if data.take.recording.camera is None:
        return 1.0
    return float(np.sqrt((data.directions[on] ** 2).sum(axis=1).mean()))


def reference_weights(shape: np.ndarray, data: Channels) -> np.ndarray:
    """(C,) weights w: w . shape is the motion, m, of the marker that moves most."""
    size = np.array([np.linalg.norm(shape[data.marker == m]) for m in range(data.marker.max() + 1)])
    size[np.unique(data.marker[data.support])] = 0
    best = data.marker == int(np.argmax(size))
    return np.where(best, shape, 0) / (np.linalg.norm(shape[best]) * px_per_metre(data))


def build_law(
    rings: list[RingDown],
    takes: tuple[Channels, ...],
    condition: tuple[int, ...],
    pitch: tuple[int, ...] | None = None,
) -> tuple[Law, np.ndarray]:
    """The declared law and its starting parameters from the ring-downs of the fitted takes.

    All ring-downs hold the same K modes in the same order; their t0 is the release.
    """
    first = rings[0]
    shapes, _ = real_shapes(first.amplitude)
    shapes[:, takes[0].support] = 0
    weights = np.array([reference_weights(s, takes[0]) for s in shapes])
    fitted = [i for i, t in enumerate(takes) if not t.take.held_out]
    pitch = condition if pitch is None else pitch
    starts, conditions = [], max(pitch[i] for i in fitted) + 1
    gauges = _gauges(rings, [(takes[i], condition[i]) for i in fitted], weights)
    block = [None] * conditions
    for ring, index in zip(rings, fitted, strict=True):
        z = np.clip(ring.damping_ratio, 1e-4, 0.85)
        if block[pitch[index]] is None:
            block[pitch[index]] = np.r_[np.log(ring.frequency), z]
        at = (
            ring.amplitude @ gauges[condition[index]].T
        ).diagonal()  # complex, m at the references
        pole = -z + 1j * np.sqrt(1 - z**2)
        starts.append(np.concatenate([at.real, (at * pole).real]))
    sizes = [np.hypot(s[: len(weights)], s[len(weights) :]) for s in starts]
    unit = shapes / np.einsum("kc,kc->k", weights, shapes)[:, None]
    couple = unit @ weights[0]
    setting = Setting(
        omega=2 * np.pi * first.frequency,
        zeta=np.clip(first.damping_ratio, 1e-4, 0.85),
        couple=couple,
        places=couple[None, 1:],
        levers=np.ones(1),
        planes=np.zeros((0, 2, len(couple) - 1)),
        skin=np.zeros((len(couple), 0)),
        facing=np.zeros((len(couple), 0)),
        wind=np.zeros((0, len(couple))),
        masses=np.ones(len(couple)),
        amplitude=float(max(s[0] for s in sizes)),
        modal_mass=np.nan,
        drag_area=np.nan,
        reference=weights,
        duration=float(max(takes[i].time[takes[i].fit][-1] for i in fitted)),
    )
    law = Law(takes, condition, pitch, weights, setting, gauges=gauges)
    return law, np.concatenate([*block, *starts])


def _gauges(rings, fitted, weights: np.ndarray) -> tuple[np.ndarray, ...]:
    """Per condition (K, C): the first mode's reference is the same in all, the others' their own.

    With a load on the body a mode may stand still where it moved most before.
    """
    out = {}
    for ring, (data, condition) in zip(rings, fitted, strict=True):
        if condition in out:
            continue
        shapes, _ = real_shapes(ring.amplitude)
        shapes[:, data.support] = 0
        own = np.array([reference_weights(s, data) for s in shapes])
        out[condition] = np.vstack([weights[:1], own[1:]]) if out else weights
    return tuple(out.get(c, weights) for c in range(max(out) + 1))


def with_body(law: Law, data: Channels, body, turn: np.ndarray) -> Law:
    """The law told by the matched modes what a force on the body does to each of them.

    turn (m, K): of the computed modes to the measured ones, as the take `data` shows them.
    """
    shapes, seen = body.modes.shapes @ turn, body.seen(data)
    unit = np.einsum("kc,kc->k", law.reference, turn.T @ seen)  # at the reference per q_k
    per_metre = shapes / unit
    masses = 1 / unit**2
    operator, normals, areas = surface_quadrature(body.model)
    moved = (operator @ per_metre.reshape(-1, shapes.shape[2])).reshape(len(areas), 3, -1)
    first = np.linalg.norm(moved[:, :, 0], axis=1)
    places, levers = _places(moved, first)
    facing = np.einsum("qi,qik->qk", normals, moved)
    area = float((np.abs(facing[:, 0]) * first**2 / 2) @ areas)
    pick, share = few(moved, facing, areas)
    skin = np.swapaxes(moved[pick], 1, 2)
    share = share / (share * first[pick] ** 2 * np.abs(facing[pick, 0])).sum()  # work 1 in mode 1
    wind = skin * share[:, None, None] * (masses[0] / masses)[None, :, None]
    setting = replace(
        law.setting,
        modal_mass=float(masses[0]),
        masses=masses[0] / masses,
        drag_area=area,
        places=np.vstack([law.setting.places, places]),
        levers=np.r_[law.setting.levers, levers],
        planes=_planes(moved, first),
        skin=np.ascontiguousarray(skin.transpose(1, 2, 0).reshape(skin.shape[1], -1)),
        facing=np.ascontiguousarray(facing[pick].T),
        wind=np.ascontiguousarray(wind.transpose(2, 0, 1).reshape(-1, wind.shape[1])),
        reach=_reach(body, data, per_metre[:, :, 0]),
        support=_shaken(body, data, turn[:, 0], law.setting),
        towards=_towards(data, body, per_metre[:, :, 0]),
        behind=behind(body.case.surface.vertices, data),
    )
    return replace(law, setting=setting)


def _reach(body, data: Channels, per_metre: np.ndarray) -> float:
    """m by which the marker on the object that moves most does so, unseen directions included."""
    moved = np.linalg.norm((body.markers @ per_metre.ravel()).reshape(-1, 3), axis=1)
    return float(moved[np.unique(data.marker[~data.support])].max())


def _shaken(body, data: Channels, first: np.ndarray, setting: Setting):
    """Hz -> (C, 3) complex: what the channels see per m that the support swings along each axis.

    first (m,): the first measured mode in terms of the computed ones. All of them answer, at
    pitches over its own as computed and damped as it is (Ewins, Modal Testing, 2000, 2.6).
    """
    modes, seen = body.modes, body.seen(data)
    axes = np.tile(np.eye(3), (len(modes.shapes), 1))
    push = modes.shapes.reshape(len(axes), -1).T @ (body.model.mass @ axes)
    own = np.average(modes.frequency, weights=first**2)
    pitch = modes.frequency / own * setting.omega[0] / (2 * np.pi)

    def seen_at(frequency: float) -> np.ndarray:
        r = frequency / pitch
        answer = r**2 / (1 - r**2 + 2j * setting.zeta[0] * r)
        return data.directions + (seen.T * answer) @ push

    return seen_at


def behind(vertices: np.ndarray, data: Channels) -> float:
    """m by which the object's middle lies further from the camera than that of its markers.

    vertices (V, 3) m; nought where no camera was declared.
    """
    camera = data.take.recording.camera
    if camera is None:
        return 0.0
    places = np.array([marker.position for marker in data.take.recording.markers])
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return float((middle - places.mean(axis=0)) @ camera.rows[2])


def _towards(data: Channels, body, per_metre: np.ndarray) -> np.ndarray | None:
    """(C,) what each channel shows of mode 1 times how its marker nears the camera, over m2."""
    camera = data.take.recording.camera
    if camera is None:
        return None
    moved = (body.markers @ per_metre.ravel()).reshape(-1, 3)[data.marker]
    seen = np.einsum("ci,ci->c", data.directions, moved)
    return -seen * (moved @ camera.rows[2])


def _places(moved: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(Q, K - 1) couples and (Q,) levers of places far apart in how they share in the modes.

    A force acts along mode 1 there, first those far apart, or between it and another mode.
    """
    direction = moved[:, :, 0] / np.maximum(first, 1e-300)[:, None]
    couples, levers = _shares(moved, direction)
    if not len(levers):
        return np.zeros((0, moved.shape[2] - 1)), np.zeros(0)
    if not couples.shape[1]:  # one mode does not tell where: the body's whole range
        return np.zeros((PLACES, 0)), np.quantile(levers, np.linspace(1, 0, PLACES))
    some = _spread_out(couples, levers)  # searches begin there
    whole = [(couples[some], levers[some])]
    for k in range(1, moved.shape[2]):
        other = moved[:, :, k] / np.maximum(np.linalg.norm(moved[:, :, k], axis=1), 1e-300)[:, None]
        free = np.abs(np.einsum("qi,qi->q", direction, other)) < ALONG
        free &= first > 0  # a held point has no direction
        for way in WAYS if free.any() else ():
            between = direction[free] + way * other[free]
            size = np.linalg.norm(between, axis=1)
            couples, levers = _shares(moved[free], between / size[:, None])
            if couples.size:
                some = _spread_out(np.c_[couples, levers], levers)
                whole.append((couples[some], levers[some]))
    return np.vstack([c for c, _ in whole]), np.concatenate([v for _, v in whole])


def _planes(moved: np.ndarray, first: np.ndarray) -> np.ndarray:
    """(Q, 2, K - 1) couples of places far apart along mode 1's direction there, and along that
    across it in which the other modes move most.
    """
    able = first > 0.1 * first.max()
    moved, first = moved[able], first[able]
    along = moved[:, :, 0] / first[:, None]
    own = np.einsum("qi,qik->qk", along, moved[:, :, 1:])
    rest = moved[:, :, 1:] - along[:, :, None] * own[:, None]
    across = np.linalg.svd(rest, full_matrices=False)[0][:, :, :1] if own.size else rest
    sideways = np.einsum("qin,qik->qk", across, rest)
    if own.size:  # the other way is the same plane
        most = np.abs(sideways).argmax(axis=1)[:, None]
        sideways = sideways * np.sign(np.take_along_axis(sideways, most, axis=1))
    both = np.stack([own, sideways], axis=1) / first[:, None, None]
    if not own.size:
        return both[:0]
    return both[_spread_out(both.reshape(len(both), -1), first)[:PLANES]]


def _shares(moved: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, K - 1) couples and (n,) levers of those places that move along `direction` (q, 3)."""
    along = np.einsum("qi,qik->qk", direction, moved)
    along = along * np.where(along[:, :1] < 0, -1.0, 1.0)  # a line has no sign
    able = along[:, 0] > 0.1 * along[:, 0].max()
    return along[able, 1:] / along[able, :1], along[able, 0]


def _spread_out(where: np.ndarray, levers: np.ndarray) -> list[int]:
    """Indices of places far apart in `where` (n, p), from that with the longest lever on."""
    chosen, gap = [int(np.argmax(levers))], np.inf
    while len(chosen) < PLACES:
        gap = np.minimum(gap, ((where - where[chosen[-1]]) ** 2).sum(axis=1))
        if not gap.max() > 0:
            break
        chosen.append(int(np.argmax(gap)))
    return chosen
