"""The frames of captures as questions look at them; what is computed of them is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from threading import Lock
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP
from motiondb.errors import StoreError
from motiondb.language.question.amounts import Measure
from motiondb.language.vocabulary import IN_PLACE, TRAVELS
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import LIMB_COLUMNS, FramePool
from motiondb.meaning.amounts import amounts_of
from motiondb.meaning.edge_map import averaged, frame_cues
from motiondb.meaning.occurrences import event_of, find_occurrences
from motiondb.meaning.postures import frames_without, is_held, standing
from motiondb.meaning.travelled import (
    REST,
    furthest,
    largest_part,
    longest_going,
    speeds_of,
    steady_speed,
    way_while,
    ways,
)
from motiondb.records import Float32Array, FloatArray

MOST_FRAMES = 200_000
"""Feature frames, 15 a second, of the captures that are kept: some 250 MB. Chosen by hand."""
MOST_KNOWN = 64  # Values that are kept for a capture, such as the evidence of an action
Value = TypeVar("Value")


class Frames:
    """What questions look at in captures, by their numbers."""

    def __init__(self, pool: FramePool, track: Callable[[int], FloatArray]) -> None:
        self.pool = pool
        # ``measured_track``: array (frames, columns), 30 a second; StoreError where it is away
        self.track = track
        self._lock = Lock()
        self._kept: dict[int, SeenFrames] = {}  # those asked for last at the end
        self._n_frames = 0

    def of(self, learned: Learned, capture: int) -> SeenFrames:
        """The frames of a capture, with what was computed of them before."""
        with self._lock:
            seen = self._kept.pop(capture, None)
            if seen is None or seen.learned is not learned:
                self._n_frames -= 0 if seen is None else len(seen.rows)
                seen = SeenFrames(learned, capture, self)
                self._n_frames += len(seen.rows)
            self._kept[capture] = seen
            while self._n_frames > MOST_FRAMES and len(self._kept) > 1:
                self._n_frames -= len(self._kept.pop(next(iter(self._kept))).rows)
            return seen


@dataclass(frozen=True, eq=False)
class SeenFrames:
    """The frames of one capture."""

    learned: Learned
    capture: int
    frames: Frames
    _known: dict[tuple[object, ...], Any] = field(default_factory=dict, repr=False)

    def _once(self, key: tuple[object, ...], make: Callable[[], Value]) -> Value:
        """A value of the capture that is computed once, while few others are asked for."""
        if key not in self._known:
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            self._known[key] = make()
        return cast(Value, self._known[key])

    @cached_property
    def rows(self) -> Float32Array:
        """Its rows of the pool: array (frames, columns), 15 a second, see ``frame_rows``."""
        return self.frames.pool.of_capture(self.capture)

    @property
    def n_frames(self) -> int:
        """Number of frames, 15 a second."""
        return len(self.rows)

    @cached_property
    def speeds(self) -> FloatArray:
        """Speeds over the ground and of turning: array (frames, 3), see ``speeds_of``."""
        return speeds_of(self.rows)

    @property
    def limbs(self) -> Float32Array:
        """Squared speeds of limbs: array (frames, 6), see ``speeds_of_limbs``."""
        return self.rows[:, LIMB_COLUMNS]

    def longest_going(
        self, action: Sequence[str], room: slice | None = None
    ) -> tuple[float, int, int]:
        """How long an action goes on, in some frames or all, and where: see ``longest_going``.

        Who stands does so on the feet, and who stands still moves no limb. A posture lasts as long
        as its event does; infinitely long where the motion is away.
        """
        if room is None:
            return self._once(("goes", *action), lambda: self.longest_going(action, slice(None)))
        if is_held(event_of(action)) and self.is_away:
            return inf, 0, len(self.rows)
        shown = self._once(("posture", *action), lambda: self._posture(action))
        speed = self._once(("speed",), lambda: steady_speed(self.speeds))
        inside = np.zeros_like(shown)
        inside[room] = shown[room]
        return longest_going(speed, action, inside, is_held(event_of(action)))

    def _posture(self, action: Sequence[str]) -> NDArray[np.bool_]:
        """Frames whose posture is that of an action; all if it needs none: array (frames,)."""
        event, rests = event_of(action), not REST.isdisjoint(action)
        if not is_held(event) and (not rests or TRAVELS.intersection(action) or self.is_away):
            return np.ones(len(self.rows), dtype=bool)
        posed = np.ones(len(self.track), dtype=bool)
        if is_held(event):
            posed = ~frames_without(self.events(event), len(posed))
        elif "stand" in action:
            posed = standing(self.track)
        if {"still", "freeze"}.intersection(action):
            posed = posed & frames_without(self.events("move"), len(posed))
        return posed[::FEATURE_STEP][: len(self.rows)]

    def goes_once(self, direction: str, turn: str) -> bool:
        """Whether it goes in a direction anywhere, as far as it takes to be seen."""
        key = "goes once", direction, turn
        return self._once(key, lambda: self.furthest(direction, turn, slice(None))[0] >= 1.0)

    def furthest(
        self, direction: str, turn: str, part: slice | NDArray[np.bool_], least: float = 0.0
    ) -> tuple[float, int, int]:
        """How far some frames go in a direction, and the part that does: see ``furthest``.

        `part`: The frames that are looked at, or which frames (frames,) count. Where steps are
        averaged, those around the part count too.
        """
        if direction == IN_PLACE:
            if isinstance(part, slice):
                return furthest(self.speeds[part], direction, turn, least=least)
            return furthest(self.speeds, direction, turn, part, least=least)
        key = "ways", direction, turn
        found = self._once(key, lambda: ways(self.speeds, direction, turn))
        if isinstance(part, slice):
            return max(largest_part(way[part]) for way in found)
        return max(largest_part(way_while(way, part)) for way in found)

    @cached_property
    def track(self) -> FloatArray:
        """What measured words look at: array (frames, columns), see ``measured_track``."""
        return self.frames.track(self.capture)

    @cached_property
    def contexts(self) -> FloatArray:
        """Contexts of its frames: array (frames, axes), 15 a second, see ``ContextSpace``.

        StoreError where the motion is away.
        """
        return self.learned.context_space.view(self.frames.pool.features(self.capture))

    def smooth(self, words: Sequence[int]) -> FloatArray | None:
        """As :meth:`evidence`, averaged over neighbouring frames: array (frames,)."""
        evidence = self.evidence(words)
        if evidence is None:
            return None
        return self._once(("smooth", *words), lambda: averaged(evidence))

    @property
    def is_away(self) -> bool:
        """Whether its motion is kept elsewhere and cannot be read, so that it has no track."""
        try:
            return self.track is None
        except StoreError:
            return True

    def events(self, word: str) -> list[tuple[int, int]]:
        """Where an event occurs, see ``find_occurrences``."""
        return self._once(("events", word), lambda: find_occurrences(self.track, word))

    @cached_property
    def _cues(self) -> FloatArray:
        return frame_cues(self.frames.pool.whitened(self.capture))

    def amounts(self, measure: Measure, action: Sequence[str]) -> list[tuple[float, int, int]]:
        """How far, fast or by which angle an action goes, in feature frames: ``amounts_of``."""
        key = "amounts", measure, *action
        of = measure, action, self.track, self.speeds, FEATURE_FPS
        return self._once(key, lambda: amounts_of(*of))

    def evidence(self, words: Sequence[int]) -> FloatArray | None:
        """Evidence for words whose places were learned at every frame: array (frames,).

        None if there are no words, or the places of one were not learned.
        """
        edges, placed = self.learned.edges, self.learned.placed
        if not words or edges is None or placed is None or not placed.words.issuperset(words):
            return None
        return self._once(("evidence", *words), lambda: edges.of_cues(self._cues, words))
