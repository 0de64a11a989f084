"""The progress of a job as a whole, from 0 to 1, and the time that is left.

A job tells the share of its present step, which begins anew with each step. The steps of a kind of
job have weights: their shares of its time, measured on the sample data and on real captures.
"""

from __future__ import annotations

_STEPS: dict[str, dict[str, float]] = {
    "add": {"reading captures": 0.6, "saving captures": 0.4},
    "learn": {
        "features": 0.14,
        "symbols compete": 0.14,
        "cutting anew": 0.04,
        "cutting": 0.1,
        "scoring": 0.02,
        "symbol space": 0.04,
        "words": 0.5,
        "saving": 0.02,
    },
    "grammar": {
        "describe poses": 0.03,
        "search terminals": 0.55,
        "tune cuts": 0.12,
        "find sentences": 0.25,
        "parses": 0.05,
    },
}
_BY_TURNS = ("add",)  # Kinds whose steps go on by turns, batch after batch
LEAST_SECONDS, LEAST_SHARE = 3.0, 0.08  # Before this, the time that is left is not told


class WholeProgress:
    """The share of a whole job that is done; it never falls."""

    def __init__(self, kind: str) -> None:
        self._steps, self._by_turns = _STEPS.get(kind, {}), kind in _BY_TURNS
        self._done: dict[str, float] = {}
        self.share: float | None = 0.0 if self._steps else None

    def tell(self, step: str, share: float) -> None:
        """Record the share of a step that is done."""
        if self.share is None or step not in self._steps:
            return
        self._done[step] = max(self._done.get(step, 0.0), share)
        if not self._by_turns:  # what stands before it is over, also what this job left out
            for earlier in list(self._steps)[: list(self._steps).index(step)]:
                self._done[earlier] = 1.0
        done = sum(self._steps[name] * part for name, part in self._done.items())
        self.share = max(self.share, min(done / sum(self._steps.values()), 1.0))

    def left(self, seconds: float) -> float | None:
        """Return the seconds that are left if it goes on as fast; None where it is too early.

        `seconds`: What it has taken so far.

        >>> progress = WholeProgress("add")
        >>> progress.tell("reading captures", 0.5)
        >>> progress.share, progress.left(6.0), progress.left(1.0)
        (0.3, 14.0, None)
        """
        if self.share is None or seconds < LEAST_SECONDS or self.share < LEAST_SHARE:
            return None
        return round(seconds * (1.0 - self.share) / self.share, 1)
