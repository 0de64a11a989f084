"""What is right for a question: captions and facts of the motion, as the table writes them.

A key is alternatives, with " / " between them, of terms that must all hold:

    walk     some word of the captions begins so     =run     is that word
    a|b      one of several                          -a       not
    85/      the capture's name begins so            top>2.3  a fact of the motion

"nothing" says that no capture is right; a leading "~" that something of the question cannot be
measured, so that no answer may have a probability of one half or more. Facts are computed here,
from positions of joints, without the program's measures of the same things.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget
from motiondb.body.features import headings, runs
from motiondb.database import MotionDB
from motiondb.records import FloatArray, Motion

_I = body.INDEX
_FACT = re.compile(r"([a-z]+)([<>=])([\d.]+)")


@dataclass(frozen=True)
class Shown:
    """One capture as the key sees it."""

    name: str
    words: tuple[str, ...]
    facts: Mapping[str, float]


def captures_of(db: MotionDB) -> list[Shown]:
    learned, every = db.learned, []
    for number, info in learned.captures.items():
        said = " ".join(caption.words for caption in learned.captions.get(number, ()))
        apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", said)  # "KickFlipStumble"
        words = tuple(re.findall(r"[a-z0-9]+", f"{apart} {said}".lower()))
        every.append(Shown(info.name, words, facts_of(db.motion(info.name))))
    return every


def facts_of(motion: Motion) -> dict[str, float]:
    """Speeds in m/s, times in s, turns in degrees, lengths in m."""
    positions, world = retarget.motion_positions(motion)
    points = positions.astype(np.float64)
    root, heading = points[:, 0], headings(world)
    steps = np.diff(root[:, [0, 2]], axis=0, append=root[-1:, [0, 2]]) * 30.0
    speed = _mean(np.hypot(*steps.T))
    ahead = _mean(steps[:, 0] * np.sin(heading) + steps[:, 1] * np.cos(heading))
    aside = _mean(steps[:, 0] * np.cos(heading) - steps[:, 1] * np.sin(heading))
    turned = np.degrees(heading)
    ankles, toes = (
        points[:, [_I[f"l_{j}"], _I[f"r_{j}"]], 1] - low
        for j, low in (("ankle", body.ANKLE_HEIGHT), ("toe", 0.02))
    )
    aloft = np.asarray((np.minimum(ankles, toes) > 0.05).all(axis=1))
    flights = [(a, b) for a, b in runs(aloft) if 4 <= b - a < 30]
    stand = float(np.percentile(root[:, 1], 90))
    ways = [float(np.linalg.norm(root[b - 1, [0, 2]] - root[a, [0, 2]])) for a, b in flights]
    inverted = points[:, _I["head"], 1] < root[:, 1] - 0.1
    return {
        "seconds": motion.duration,
        "top": float(speed.max()),
        "run": _longest(speed > 1.8),
        "go": _longest(speed > 0.4),
        "still": _longest(speed < 0.1),
        "back": _longest(ahead < -0.25),
        "side": max(_longest(aside > 0.3), _longest(aside < -0.3)),
        "left": float((turned - np.minimum.accumulate(turned)).max()),
        "right": float((np.maximum.accumulate(turned) - turned).max()),
        "low": _longest(root[:, 1] < 0.62),
        "inverted": float(inverted.sum()) / 30.0,
        "flights": float(len(flights)),
        "rise": max((float(root[a:b, 1].max()) - stand for a, b in flights), default=0.0),
        "far": max(ways, default=0.0),
    }


def _mean(values: FloatArray) -> FloatArray:
    """The mean over half a second around every frame."""
    padded = np.pad(values, 7, mode="edge")
    return np.convolve(padded, np.ones(15) / 15.0, "valid")


def _longest(mask: NDArray[np.bool_]) -> float:
    return max((b - a for a, b in runs(mask)), default=0) / 30.0


def is_right(key: str, shown: Shown) -> bool:
    """Whether a capture fulfils a key.

    >>> walk = Shown("07/07_01", ("slow", "walking"), {"top": 1.2})
    >>> [is_right(key, walk) for key in ("walk -run top<2", "run / 07/", "walk slow|fast top>2")]
    [True, True, False]
    """
    return any(
        all(_holds(term, shown) for term in one.split()) for one in key.split(" / ") if one.strip()
    )


def _holds(term: str, shown: Shown) -> bool:
    if term.startswith("-"):
        return not _holds(term[1:], shown)
    fact = _FACT.fullmatch(term)
    if fact is not None:
        value, bound = shown.facts[fact[1]], float(fact[3])
        return {"<": value < bound, ">": value > bound, "=": value == bound}[fact[2]]
    if re.match(r"\d+/", term):
        return shown.name.startswith(term)
    return any(
        word == part[1:] if part.startswith("=") else word.startswith(part)
        for part in term.split("|")
        for word in shown.words
    )
