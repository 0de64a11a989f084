"""Motion in the form of HumanML3D: 263 numbers a frame, 20 a second, and captions beside them.

The numbers of a frame, for SMPL's 22 joints, y up, metres; F is the turn about y into the frame of
the root, which looks along z:

    0       half the turn of F to the next frame, radians
    1, 2    way of the root to the next frame, x and z in F of the next one
    3       height of the root
    4:67    places of the other 21 joints in F, from the root's place on the ground
    67:193  turns of these joints in the frame of the one above, the first two columns of the matrix
    193:259 ways of all joints to the next frame, in F
    259:263 left ankle and foot, right ankle and foot stand (0 or 1)

The lowest joint of all frames is at 0; the first frame stands at the origin. Turns are those of its
authors: of the bones alone, every chain anew from the root.

Source: Guo et al., Generating diverse and natural 3D human motions from text, CVPR 2022;
https://github.com/EricGuo5513/HumanML3D (motion_representation.ipynb, cal_mean_variance.ipynb).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

from motiondb.body import rotation
from motiondb.errors import QueryError
from motiondb.files.readers.first_bytes import HUMANML3D_WIDTH
from motiondb.language.lemmas import lemma
from motiondb.language.vocabulary import forms_of
from motiondb.records import Caption, FloatArray

FPS, N_JOINTS = 20.0, 22
PARTS = MappingProxyType(
    {"root turn": (0, 1), "root way": (1, 3), "root height": (3, 4), "places": (4, 67)}
    | {"turns": (67, 193), "ways": (193, 259), "feet": (259, 263)}
)
"""Columns of the numbers."""
_CHAINS = (
    (0, 2, 5, 8, 11),
    (0, 1, 4, 7, 10),
    (0, 3, 6, 9, 12, 15),
    (9, 14, 17, 19, 21),
    (9, 13, 16, 18, 20),
)
_DOWN, _UP, _AHEAD = (0, -1, 0), (0, 1, 0), (0, 0, 1)
_LEFT, _RIGHT = (1, 0, 0), (-1, 0, 0)
_BONES = np.array(
    [
        *((0, 0, 0), _LEFT, _RIGHT, _UP, _DOWN, _DOWN, _UP, _DOWN, _DOWN, _UP, _AHEAD, _AHEAD),
        *(_UP, _LEFT, _RIGHT, _AHEAD, _DOWN, _DOWN, _DOWN, _DOWN, _DOWN, _DOWN),
    ],
    dtype=float,
)  # Directions of the bones where nothing is turned
_STANDS = 0.002  # Square of the metres that a standing foot moves in a frame, at most
_SMOOTH = 20.0  # Frames over which the direction of the root is smoothed
_HIPS, _SHOULDERS = (2, 1), (17, 16)  # Right, left
_FEET = (7, 10, 8, 11)
_CLOSED = {
    "DET": "a an the this that his her their its both all",
    "PRON": "he she it they him them someone something who himself herself",
    "AUX": "is are be was were being has have can",
    "CCONJ": "and or but then",
    "ADP": "in on at to of with from by for over under around into onto up down through across "
    "along towards toward behind after before while",
    "NUM": "one two three four five six seven eight nine ten",
}
_WORD_CLASSES = MappingProxyType(
    {word: kind for kind, words in _CLOSED.items() for word in words.split()}
)


def motion_numbers(places: FloatArray) -> FloatArray:
    """Return the numbers (frames - 1, 263) of places (frames, 22, 3), y up, metres, 20 a second."""
    places = places - [0.0, float(places[..., 1].min()), 0.0]
    places = places - places[0, 0] * [1.0, 0.0, 1.0]
    places = _rotate(_into_root(places[:1], 0.0)[0], places)
    ways = np.diff(places, axis=0)
    into = _into_root(places, _SMOOTH)
    steps = rotation.multiply(into[1:], rotation.conjugate(into[:-1]))
    local = _rotate(into[:, None], places - places[:, :1] * [1.0, 0.0, 1.0])
    matrices = rotation.to_matrix(_turns(places, into))[:, 1:]
    turns = np.concatenate([matrices[..., 0], matrices[..., 1]], axis=-1)
    frames = len(ways)
    return np.concatenate(
        [
            np.arcsin(np.clip(steps[:, 2:3], -1.0, 1.0)),
            _rotate(into[1:], ways[:, 0])[:, [0, 2]],
            places[:-1, 0, 1:2],
            local[:-1, 1:].reshape(frames, -1),
            turns[:-1].reshape(frames, -1),
            _rotate(into[:-1, None], ways).reshape(frames, -1),
            (np.square(ways[:, _FEET]).sum(axis=-1) < _STANDS).astype(float),
        ],
        axis=1,
    )


def _rotate(turns: FloatArray, vectors: FloatArray) -> FloatArray:
    return rotation.rotate(np.broadcast_to(turns, (*vectors.shape[:-1], 4)), vectors)


def _into_root(places: FloatArray, smooth: float) -> FloatArray:
    """Return the turns (frames, 4) about y into the frame of the root."""
    across = sum(places[:, right] - places[:, left] for right, left in (_HIPS, _SHOULDERS))
    ahead = np.cross([0.0, 1.0, 0.0], rotation.normalize(np.asarray(across)))
    if smooth:
        from scipy.ndimage import gaussian_filter1d

        ahead = gaussian_filter1d(ahead, smooth, axis=0, mode="nearest")
    half = -np.arctan2(ahead[:, 0], ahead[:, 2]) / 2.0
    still = np.zeros_like(half)
    return np.stack([np.cos(half), still, np.sin(half), still], axis=-1)


def _turns(places: FloatArray, root: FloatArray) -> FloatArray:
    """Return the turns (frames, 22, 4) of the bones, each chain from the root."""
    turns = np.broadcast_to(rotation.IDENTITY, (*places.shape[:2], 4)).copy()
    turns[:, 0] = root
    for chain in _CHAINS:
        above = root
        for start, end in pairwise(chain):
            bone = rotation.normalize(places[:, end] - places[:, start])
            whole = rotation.between(np.broadcast_to(_BONES[end], bone.shape), bone)
            turns[:, end] = rotation.multiply(rotation.conjugate(above), whole)
            above = whole
    return turns


def text_lines(captions: Sequence[Caption], seconds: float) -> str:
    r"""Return captions of a motion as HumanML3D has them: caption, words with classes, start, end.

    0.0 and 0.0 mean the whole motion; a part that rounds to them is left out.

    >>> text_lines([Caption("A man walks#", 1.0, 3.5)], 8.0)
    'A man walks#a/DET man/OTHER walk/OTHER#1.0#3.5\n'
    """
    lines = []
    for caption in captions:
        text = " ".join(caption.words.replace("#", " ").split())
        words = forms_of(text)
        tokens = " ".join(f"{lemma(w)}/{_WORD_CLASSES.get(w, 'OTHER')}" for w in words)
        is_whole = caption.start is None and caption.end is None
        end = 0.0 if is_whole else seconds if caption.end is None else caption.end
        span = f"{caption.start or 0.0:.1f}#{end:.1f}"
        if text and tokens and (is_whole or span != "0.0#0.0"):
            lines.append(f"{text}#{tokens}#{span}\n")
    return "".join(lines)


@dataclass(frozen=True)
class Written:
    """Numbers of what a folder holds."""

    motions: int
    frames: int
    captions: int
    without_captions: int


def write_set(folder: Path, motions: Iterable[tuple[str, FloatArray, str]]) -> Written:
    """Write motions: name, numbers (frames, 263) and lines of text, with their mean and deviation.

    One after the other: none but the last is held. `folder` is there, and empty.
    """
    from motiondb.files.readers.point_motion import humanml3d_positions

    for name in ("new_joint_vecs", "new_joints", "texts"):
        (folder / name).mkdir()
    n_motions, n_frames, n_captions, listed = 0, 0, 0, list[str]()
    # of all frames until now, and squares from it
    mean, squares = np.zeros(HUMANML3D_WIDTH), np.zeros(HUMANML3D_WIDTH)
    for name, numbers, text in motions:
        np.save(folder / "new_joint_vecs" / f"{name}.npy", numbers.astype(np.float32))
        joints = humanml3d_positions(numbers).astype(np.float32)
        np.save(folder / "new_joints" / f"{name}.npy", joints)
        if text:
            (folder / "texts" / f"{name}.txt").write_text(text, encoding="utf-8")
            listed.append(f"{name}\n")
        apart, share = numbers.mean(axis=0) - mean, len(numbers) / (n_frames + len(numbers))
        squares += len(numbers) * (numbers.var(axis=0) + (1.0 - share) * apart**2)
        mean += share * apart
        n_motions += 1
        n_frames += len(numbers)
        n_captions += text.count("\n")
    if not n_motions:
        raise QueryError("export: expected captures with the motion of a body, found none.")
    (folder / "all.txt").write_text("".join(listed), encoding="utf-8")
    deviation = np.sqrt(squares / n_frames)
    for low, high in PARTS.values():
        deviation[low:high] = deviation[low:high].mean()
    np.save(folder / "Mean.npy", mean.astype(np.float32))
    np.save(folder / "Std.npy", deviation.astype(np.float32))
    said = {
        "fps": FPS,
        "up": "y; the first frame looks along z",
        "units": "metres, radians, a frame",
        "columns": {name: list(ends) for name, ends in PARTS.items()},
        "body": "SMPL's 22 joints with the bones of SMPL's mean body, not those of HumanML3D's "
        "example 000021",
        "texts": "caption#word/CLASS ...#start#end; 0.0#0.0 is the whole motion; words of open "
        "classes have the class OTHER",
        "Mean.npy, Std.npy": "of these motions",
    }
    (folder / "humanml3d.json").write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    return Written(n_motions, n_frames, n_captions, n_motions - len(listed))
