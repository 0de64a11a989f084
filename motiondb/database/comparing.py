"""Two motions compared: their alignment, how far they are apart, and a picture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from motiondb import pictures
from motiondb.answers.questions import Comparison, JointDistance
from motiondb.body.body import JOINTS
from motiondb.records import MOTION_FPS, Motion
from motiondb.search.alignment import MOST_POSES, align
from motiondb.search.copies import copy_poses, mirror_poses


def compare(
    names: tuple[str, str],
    motions: tuple[Motion, Motion],
    starts: tuple[float, float],
    png: Path | None,
) -> Comparison:
    """Align two motions, measure how far they are apart, and draw it if asked for."""
    step = math.ceil(max(motion.n_frames for motion in motions) / MOST_POSES)
    first, second = (copy_poses(motion)[::step] for motion in motions)
    found = align(first, second)
    mirrored = align(mirror_poses(first), second)
    seconds = step / MOTION_FPS
    times = [found.path[:, n].astype(np.float64) * seconds + starts[n] for n in (0, 1)]
    if png is not None:
        spans = [(start, start + m.n_frames / MOTION_FPS) for start, m in zip(starts, motions)]
        figure = pictures.comparison_figure(
            names, found.costs, (times[0], times[1]), (spans[0], spans[1])
        )
        pictures.save_png(figure, png)
    order = np.argsort(-found.joint_distances)
    return Comparison(
        *names,
        round(float(found.distances.mean()), 4),
        round(float(mirrored.distances.mean()), 4),
        round(motions[0].duration, 3),
        round(motions[1].duration, 3),
        tuple(JointDistance(JOINTS[n], round(float(found.joint_distances[n]), 4)) for n in order),
        tuple((round(float(a), 3), round(float(b), 3)) for a, b in zip(*times)),
        png,
    )
