"""Two motions aligned in time, and how far they are apart."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, pictures
from motiondb.body.body import JOINTS
from motiondb.database.catalogue.parts import load_example
from motiondb.database.session import Session
from motiondb.records import MOTION_FPS
from motiondb.search.alignment import MOST_POSES, align
from motiondb.search.copies import copy_poses, mirror_poses

if TYPE_CHECKING:
    from motiondb.database.values import Example


def compare(
    session: Session, first: Example, second: Example, png: str | Path | None = None
) -> answers.Comparison:
    """Align two examples by dynamic time warping, and measure how far they are apart."""
    names = [str(e) if isinstance(e, str | Path) else "motion" for e in (first, second)]
    motions = load_example(session, first), load_example(session, second)
    step = math.ceil(max(motion.n_frames for motion in motions) / MOST_POSES)
    poses, others = (copy_poses(motion)[::step] for motion in motions)
    found, mirrored = align(poses, others), align(mirror_poses(poses), others)
    times = found.path.T * (step / MOTION_FPS)
    if png is not None:
        spans = [(0.0, motion.n_frames / MOTION_FPS) for motion in motions]
        figure = pictures.comparison_figure(
            (names[0], names[1]), found.costs, (times[0], times[1]), (spans[0], spans[1])
        )
        pictures.save_png(figure, png)
    order = np.argsort(-found.joint_distances)
    return answers.Comparison(
        names[0],
        names[1],
        round(float(found.distances.mean()), 4),
        round(float(mirrored.distances.mean()), 4),
        round(motions[0].duration, 3),
        round(motions[1].duration, 3),
        tuple(
            answers.JointDistance(JOINTS[n], round(float(found.joint_distances[n]), 4))
            for n in order
        ),
        tuple((round(float(a), 3), round(float(b), 3)) for a, b in zip(*times)),
        None if png is None else Path(png),
    )
