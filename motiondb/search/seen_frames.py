"""The frames of a capture as a question looks at them: what it needs of them is computed once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from motiondb.learn.learned import Learned
from motiondb.meaning.edge_map import frame_cues
from motiondb.meaning.travelled import speeds_of
from motiondb.records import Float32Array, FloatArray


@dataclass(frozen=True)
class Frames:
    """What questions look at in a capture, by its number."""

    features: Callable[[int], Float32Array]  # Recognition features (frames, 130), 15 a second
    track: Callable[[int], FloatArray]  # ``measured_track`` (frames, columns), 30 a second


@dataclass(frozen=True, eq=False)
class SeenFrames:
    """The frames of one capture."""

    learned: Learned
    capture: int
    frames: Frames
    _evidence: dict[tuple[int, ...], FloatArray] = field(default_factory=dict, repr=False)

    @cached_property
    def features(self) -> Float32Array:
        """Recognition features: array (frames, 130)."""
        return self.frames.features(self.capture)

    @cached_property
    def speeds(self) -> FloatArray:
        """Speeds over the ground and of turning: array (frames, 3), see ``speeds_of``."""
        return speeds_of(self.features)

    @cached_property
    def track(self) -> FloatArray:
        """What measured words look at: array (frames, columns), see ``measured_track``."""
        return self.frames.track(self.capture)

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
        if key not in self._evidence:
            self._evidence[key] = edges.of_cues(self._cues, words)
        return self._evidence[key]
