"""Making a scene: clips from the database, sampling, polishing, and what the rules say of it.

Sampling and polishing are pure; what is here brings captures to them, has an eye on the clock, and
tries again, from other random numbers, where a rule is still broken after polishing, somebody
touches somebody, or goes faster than people do. The best of all tries is kept: the fewest such
faults, then the lowest error.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from motiondb.database.scenes.scene_files import GRAMMAR, TACTICS, grammar_file, text_of
from motiondb.database.scenes.scene_library import SceneClips
from motiondb.errors import SceneError
from motiondb.scene.energy.binding import Binder
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.energy.scene_state import SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.polish.polish import PolishedScene, polish
from motiondb.scene.report.report_records import SceneReport
from motiondb.scene.report.scene_report import report_scene
from motiondb.scene.sampling.play import Play, make_play
from motiondb.scene.sampling.tempering import SamplerSettings, Trace, sample, warm_up
from motiondb.scene.sampling.warm_start import WARM, warm_start
from motiondb.scene.services import services

SceneProgress = Callable[[str, float, float], None]
"""Told what is being done, the share of it that is done, and the error (NaN: not known)."""

_MOST_CHAINS = 64
FASTEST = 8.0
"""Metres a second: who is polished into going faster than that goes as nobody does on a court."""


Start = tuple[Diagram, SceneState]
"""An earlier scene."""


@dataclass(frozen=True)
class SceneSettings:
    """How to make a scene.

    Attributes
    ----------
    seed : the same seed gives the same scene, unless ``minutes`` cut the work short (as
        ``MadeScene.cut_short`` says).
    chains : Markov chains at different temperatures; 1 is a single chain.
    minutes : sample for no longer than that.
    tries : how often to begin anew where rules stay broken.
    gaze : whether heads follow the ball.
    """

    seed: int = 0
    chains: int = 4
    rounds: int = SamplerSettings().rounds
    minutes: float | None = None
    tries: int = 3
    gaze: bool = True

    def __post_init__(self) -> None:
        if not 1 <= self.chains <= _MOST_CHAINS:
            raise SceneError(
                f"chains: expected 1 to {_MOST_CHAINS} Markov chains, found {self.chains}."
                " A few more than processors do well."
            )
        if self.rounds < 1:
            raise SceneError(f"rounds: expected at least 1, found {self.rounds}. Leave it out.")
        if self.minutes is not None and not (math.isfinite(self.minutes) and self.minutes > 0.0):
            raise SceneError(
                f"minutes: expected a number above 0, found {self.minutes:g}."
                " Leave it out for no limit of time."
            )
        if self.tries < 1:
            raise SceneError(f"tries: expected at least 1, found {self.tries}. Try 3.")

    @property
    def temperatures(self) -> tuple[float, ...]:
        """One for each chain, from cold to hot: the sampler's own, or more in the same ratio.

        >>> SceneSettings(chains=1).temperatures
        (0.15,)
        """
        known = SamplerSettings().temperatures
        ratio = known[-1] / known[-2]
        more = [known[-1] * ratio**n for n in range(1, self.chains - len(known) + 1)]
        return (*known, *more)[: self.chains]


@dataclass(frozen=True, eq=False)
class SceneText:
    """A diagram and its grammar, read, with the texts that they were read from."""

    diagram: Diagram
    grammar: MotionGrammar
    diagram_text: str
    grammar_text: str


@dataclass(frozen=True, eq=False)
class MadeScene:
    """A scene, and how it came about.

    Attributes
    ----------
    table : the rules that bind it. report : how far each is kept.
    error : -log P(Z) before polish. seconds : what took how long, by name.
    tries : how often it was begun. cut_short : whether time ended the sampling, or kept it from
        being begun again; then the seed alone does not fix the scene.
    """

    text: SceneText
    settings: SceneSettings
    clips: SceneClips
    state: SceneState
    table: RuleTable
    polished: PolishedScene
    report: SceneReport
    trace: Trace
    error: float
    tries: int
    seconds: dict[str, float]
    cut_short: bool
    cut_at: tuple[int, int, int] = (0, 0, 0)

    @property
    def too_fast(self) -> tuple[str, ...]:
        """The players who had to go faster than people do, so that the rules hold."""
        return tuple(pace.player for pace in self.report.paces if pace.after > FASTEST)

    @property
    def clean(self) -> bool:
        """Whether every rule is kept, nobody touches anybody, and nobody goes too fast."""
        return self.report.clean and not self.too_fast

    @property
    def n_frames(self) -> int:
        """Frames of the scene."""
        return self.polished.timeline.n_frames


def read_scene_text(diagram: str | os.PathLike[str]) -> SceneText:
    """A diagram by its file or name, with its grammar, which allows what is drawn (SceneError)."""
    text, where = text_of(str(diagram), TACTICS)
    read = read_diagram(text, where)
    grammar_text, grammar_where = text_of(grammar_file(read, str(diagram)), GRAMMAR)
    grammar = read_motion_grammar(grammar_text, grammar_where)
    services.cast(read, grammar, where)
    return SceneText(read, grammar, text, grammar_text)


def make(
    text: SceneText,
    clips: SceneClips,
    settings: SceneSettings,
    progress: SceneProgress,
    start: Start | None = None,
) -> MadeScene:
    """Sample a scene and polish it; again, from other random numbers, while rules are broken.

    Parameters
    ----------
    start : the diagram and state of an earlier scene to go on from; None: begin from nothing.

    Raises
    ------
    SceneError : the grammar has no string that does what the diagram asks of a player.
    """
    seeds = np.random.default_rng(settings.seed).spawn(settings.tries)
    sampler = _sampler(settings, start is not None)
    most, prices = sampler.most_actions, sampler.prices
    play = make_play(text.diagram, text.grammar, clips.library, most, prices)
    progress("compiling", 0.0, math.nan)
    warm_up(play, sampler, np.random.default_rng(0))
    progress("compiling", 1.0, math.nan)
    until = math.inf if settings.minutes is None else time.monotonic() + 60.0 * settings.minutes
    best: MadeScene | None = None
    seconds = {"sampling": 0.0, "polishing": 0.0}
    for number, rng in enumerate(seeds):
        how = _How(play, sampler, start, rng, until, number, seconds)
        made = _attempt(text, clips, settings, progress, how)
        if best is None or _badness(made) < _badness(best):
            best = made
        cut_short = made.cut_short
        if made.clean:
            break
        if time.monotonic() > until:
            cut_short |= number + 1 < settings.tries
            break
    assert best is not None
    cut_at = made.tries, len(made.trace.best) - 1, sampler.rounds
    return replace(best, cut_short=cut_short, cut_at=cut_at)


def _sampler(settings: SceneSettings, warm: bool) -> SamplerSettings:
    """Return the settings of the sampler; they fix the number of its steps."""
    if warm:
        return WARM
    threads = min(settings.chains, os.cpu_count() or 1)
    return SamplerSettings(
        temperatures=settings.temperatures, rounds=settings.rounds, threads=threads
    )


class _How(NamedTuple):
    """How to make one try; ``until`` is a time of :func:`time.monotonic`."""

    play: Play
    sampler: SamplerSettings
    start: Start | None
    rng: np.random.Generator
    until: float
    number: int
    seconds: dict[str, float]


def _attempt(
    text: SceneText,
    clips: SceneClips,
    settings: SceneSettings,
    progress: SceneProgress,
    how: _How,
) -> MadeScene:
    """Sample a scene once, polish it and measure it."""
    play, sampler, start, rng, until, number, seconds = how
    what = "sampling" if number == 0 else f"sampling, try {number + 1}"

    cut_short = False

    def heard(done: int, error: float) -> bool:
        nonlocal cut_short
        progress(what, done / sampler.rounds, error)
        cut_short = done < sampler.rounds and time.monotonic() > until
        return cut_short

    began = time.monotonic()
    progress(what, 0.0, math.nan)
    first = warm_start(start[1], start[0], play, rng) if start else None
    state, trace = sample(play, sampler, rng, first, heard)
    seconds["sampling"] += time.monotonic() - began
    began = time.monotonic()
    progress("polishing", 0.0, trace.final)
    table = Binder(text.diagram, text.grammar).bind(list(state.trees))
    polished = polish(state, clips.library, clips.motions, table, settings.gaze, start is not None)
    found = report_scene(state, clips.library, clips.motions, table, polished)
    seconds["polishing"] += time.monotonic() - began
    return MadeScene(
        text, settings, clips, state, table, polished, found, trace, trace.final, number + 1,
        seconds, cut_short,
    )  # fmt: skip


def _badness(made: MadeScene) -> tuple[int, float]:
    report = made.report
    wrong = len(report.broken) + len(report.collisions) + len(made.too_fast)
    return wrong + len(report.impossible), made.error
