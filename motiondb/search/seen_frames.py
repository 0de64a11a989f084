"""The frames of captures as questions look at them; what is computed of them is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP
from motiondb.errors import StoreError
from motiondb.language.vocabulary import IN_PLACE
from motiondb.learn.learned import Learned
from motiondb.meaning.edge_map import averaged, frame_cues
from motiondb.meaning.occurrences import HELD, event_of, find_occurrences, standing
from motiondb.meaning.travelled import (
    REST,
    TRAVELS,
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
"""Feature frames, 15 a second, of the captures that are kept: some 200 MB. Chosen by hand."""
_MOST_ACTIONS = 32  # Actions whose evidence is kept for a capture


class Frames:
    """What questions look at in captures, by their numbers: functions that give it."""

    def __init__(
        self, features: Callable[[int], Float32Array], track: Callable[[int], FloatArray]
    ) -> None:
        self.features = features  # Recognition features: array (frames, 130), 15 a second
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
                self._n_frames -= 0 if seen is None else len(seen.features)
                seen = SeenFrames(learned, capture, self)
                self._n_frames += len(seen.features)
            self._kept[capture] = seen
            while self._n_frames > MOST_FRAMES and len(self._kept) > 1:
                self._n_frames -= len(self._kept.pop(next(iter(self._kept))).features)
            return seen


@dataclass(frozen=True, eq=False)
class SeenFrames:
    """The frames of one capture."""

    learned: Learned
    capture: int
    frames: Frames
    _evidence: dict[tuple[int, ...], FloatArray] = field(default_factory=dict, repr=False)
    _smooth: dict[tuple[int, ...], FloatArray] = field(default_factory=dict, repr=False)
    _events: dict[str, list[tuple[int, int]]] = field(default_factory=dict, repr=False)
    _shown: dict[tuple[str, ...], NDArray[np.bool_]] = field(default_factory=dict, repr=False)
    _longest: dict[tuple[str, ...], tuple[float, int, int]] = field(
        default_factory=dict, repr=False
    )
    _ways: dict[tuple[str, str], list[FloatArray]] = field(default_factory=dict, repr=False)

    @cached_property
    def features(self) -> Float32Array:
        """Recognition features: array (frames, 130)."""
        return self.frames.features(self.capture)

    @cached_property
    def speeds(self) -> FloatArray:
        """Speeds over the ground and of turning: array (frames, 3), see ``speeds_of``."""
        return speeds_of(self.features)

    @cached_property
    def steady(self) -> FloatArray:
        """Averaged speed over the ground: array (frames,), see ``steady_speed``."""
        return steady_speed(self.speeds)

    def longest_going(
        self, action: Sequence[str], room: slice | None = None
    ) -> tuple[float, int, int]:
        """How long an action goes on, in some frames, and where: see ``longest_going``.

        Who stands does so on the feet, and who stands still moves no limb. A posture lasts as long
        as its event does; infinitely long where the motion is away.
        """
        key, event = tuple(action), event_of(action)
        if event in HELD:
            if self.is_away:
                return inf, 0, len(self.features)
            low, high, _ = (room or slice(None)).indices(len(self.features))
            times = [(a // FEATURE_STEP, -(-b // FEATURE_STEP)) for a, b in self.events(event)]
            cut = [(max(a, low), min(b, high)) for a, b in times]
            first, behind = max([(0, 0), *cut], key=lambda time: time[1] - time[0])
            return (behind - first) / FEATURE_FPS, first, behind
        if key not in self._shown:
            self._shown[key] = self._resting(action)
        shown = self._shown[key]
        if room is not None:
            inside = np.zeros(len(shown), dtype=bool)
            inside[room] = True
            return longest_going(self.steady, action, inside & shown)
        if key not in self._longest:
            self._longest[key] = longest_going(self.steady, action, shown)
        return self._longest[key]

    def _resting(self, action: Sequence[str]) -> NDArray[np.bool_]:
        """Frames whose posture is that of an action at rest; all for other actions: (frames,)."""
        shown = np.ones(len(self.features), dtype=bool)
        if REST.isdisjoint(action) or not TRAVELS.isdisjoint(action) or self.is_away:
            return shown
        posed = np.ones(len(self.track), dtype=bool)
        if "stand" in action:
            posed = standing(self.track)
        if {"still", "freeze"}.intersection(action):
            for start, end in self.events("move"):
                posed[start:end] = False
        return posed[::FEATURE_STEP][: len(shown)]

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
        found = self._ways.get((direction, turn))
        if found is None:
            found = self._ways[direction, turn] = ways(self.speeds, direction, turn)
        if isinstance(part, slice):
            return max(largest_part(way[part]) for way in found)
        return max(largest_part(way_while(way, part)) for way in found)

    @cached_property
    def track(self) -> FloatArray:
        """What measured words look at: array (frames, columns), see ``measured_track``."""
        return self.frames.track(self.capture)

    def smooth(self, words: Sequence[int]) -> FloatArray | None:
        """As :meth:`evidence`, averaged over neighbouring frames: array (frames,)."""
        key, evidence = tuple(words), self.evidence(words)
        if evidence is not None and key not in self._smooth:
            self._smooth[key] = averaged(evidence)
        return None if evidence is None else self._smooth[key]

    @property
    def is_away(self) -> bool:
        """Whether its motion is kept elsewhere and cannot be read, so that it has no track."""
        try:
            return self.track is None
        except StoreError:
            return True

    def events(self, word: str) -> list[tuple[int, int]]:
        """Where an event occurs, see ``find_occurrences``."""
        if word not in self._events:
            self._events[word] = find_occurrences(self.track, word)
        return self._events[word]

    @cached_property
    def _cues(self) -> FloatArray:
        return frame_cues(self.learned.frames_of(self.capture, self.frames.features))

    def evidence(self, words: Sequence[int]) -> FloatArray | None:
        """Evidence for words whose places were learned at every frame: array (frames,).

        None if there are no words, or the places of one were not learned.
        """
        edges, placed = self.learned.edges, self.learned.placed
        if not words or edges is None or placed is None or not placed.words.issuperset(words):
            return None
        key = tuple(words)
        found = self._evidence.get(key)
        if found is None:
            if len(self._evidence) >= _MOST_ACTIONS:
                self._evidence.clear()
                self._smooth.clear()
            found = self._evidence[key] = edges.of_cues(self._cues, words)
        return found
