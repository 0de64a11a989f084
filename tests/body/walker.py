"""A made walker, of whom it is known when the feet strike and leave the ground."""

from __future__ import annotations

import numpy as np

from motiondb.body import body

STRIDE_TIME, STANCE, SPEED, WIDTH = 1.1, 0.6, 1.2, 0.12  # Seconds, share, m/s, metres
_I = body.INDEX


def strikes(side: str, seconds: float) -> np.ndarray:
    """Times at which a foot strikes; the right one half a stride after the left."""
    first = 0.15 + (STRIDE_TIME / 2 if side == "r" else 0.0)
    return np.arange(first - 3 * STRIDE_TIME, seconds + 3 * STRIDE_TIME, STRIDE_TIME)


def walker(fps: float, seconds: float = 4.0, size: float = 1.0, speed: float = SPEED) -> np.ndarray:
    """Places (frames, 21, 3) of a walk along +z; a foot swings as fast as it can at once."""
    times = np.arange(round(seconds * fps)) / fps
    points = np.zeros((len(times), 21, 3))
    rest = np.zeros((21, 3))
    for joint in range(1, 21):
        rest[joint] = rest[body.PARENTS[joint]] + body.OFFSETS[joint]
    points[:] = rest - rest[_I["l_ankle"]] * [0, 1, 0] + [0, 0.08, 0]
    points[..., 2] += (speed * times / size)[:, None]
    shares = np.linspace(0.0, 1.0, 1001)
    carried = np.cumsum(np.sin(np.pi * shares) ** 0.25)
    carried /= carried[-1]
    for side in "lr":
        hits = strikes(side, seconds)
        offs = hits + STANCE * STRIDE_TIME
        nth = np.searchsorted(hits, times, side="right") - 1
        swing = np.clip((times - offs[nth]) / ((1 - STANCE) * STRIDE_TIME), 0.0, 1.0)
        stride = speed * STRIDE_TIME / size
        place = stride * (nth + np.interp(swing, shares, carried)) + speed * hits[0] / size + 0.3
        lift = np.exp(-0.5 * ((times[:, None] - offs - 0.07) / 0.07) ** 2).sum(axis=1)
        ankle, toe = _I[f"{side}_ankle"], _I[f"{side}_toe"]
        for joint, ahead, height in ((ankle, 0.0, 0.08), (toe, 0.14, 0.02)):
            points[:, joint, 0] = WIDTH / 2 * (1 if side == "l" else -1)
            points[:, joint, 2] = place + ahead
            points[:, joint, 1] = height
        points[:, ankle, 1] += 0.1 * lift
        points[:, toe, 1] += 0.05 * np.sin(np.pi * swing) ** 2
    return points * size
