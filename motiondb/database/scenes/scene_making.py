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
from motiondb.scene.polish.scene_report import SceneReport, report_scene
from motiondb.scene.sampling.play import make_play
from motiondb.scene.sampling.tempering import SamplerSettings, Trace, sample
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
    minutes: float = 1.0
    tries: int = 3
    gaze: bool = True

    def __post_init__(self) -> None:
        if not 1 <= self.chains <= _MOST_CHAINS:
            raise SceneError(
                f"chains: expected 1 to {_MOST_CHAINS} Markov chains, found {self.chains}."
                " A few more than processors do well."
            )
        if not (math.isfinite(self.minutes) and self.minutes > 0.0):
            raise SceneError(
                f"minutes: expected a number above 0, found {self.minutes:g}."
                " Scenes take some seconds; 1 is plenty."
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
    until = time.monotonic() + 60.0 * settings.minutes
    best: MadeScene | None = None
    seconds = {"sampling": 0.0, "polishing": 0.0}
    for number, rng in enumerate(seeds):
        made = _attempt(text, clips, settings, progress, (start, rng, until, number, seconds))
        if best is None or _badness(made) < _badness(best):
            best = made
        cut_short = made.cut_short
        if made.clean:
            break
        if time.monotonic() > until:
            cut_short |= number + 1 < settings.tries
            break
    assert best is not None
    return replace(best, cut_short=cut_short)


_How = tuple[Start | None, np.random.Generator, float, int, dict[str, float]]


def _attempt(
    text: SceneText,
    clips: SceneClips,
    settings: SceneSettings,
    progress: SceneProgress,
    how: _How,
) -> MadeScene:
    start, rng, until, number, seconds = how
    threads = min(settings.chains, os.cpu_count() or 1)
    sampler = SamplerSettings(temperatures=settings.temperatures, threads=threads)
    sampler = WARM if start else sampler
    what = "sampling" if number == 0 else f"sampling, try {number + 1}"

    cut_short = False

    def heard(done: int, error: float) -> bool:
        nonlocal cut_short
        progress(what, done / sampler.rounds, error)
        cut_short = done < sampler.rounds and time.monotonic() > until
        return cut_short

    began = time.monotonic()
    progress(what, 0.0, math.nan)
    first = _warm(text, clips, start, rng, sampler) if start else None
    state, trace = sample(first, clips.library, text.diagram, text.grammar, sampler, rng, heard)
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


def _warm(
    text: SceneText,
    clips: SceneClips,
    start: Start,
    rng: np.random.Generator,
    sampler: SamplerSettings,
) -> SceneState:
    """The earlier scene as far as it still does what is asked."""
    before, state = start
    most, prices = sampler.most_actions, sampler.prices
    play = make_play(text.diagram, text.grammar, clips.library, most, prices)
    return warm_start(state, before, play, rng)


def _badness(made: MadeScene) -> tuple[int, float]:
    wrong = len(made.report.broken) + len(made.report.collisions) + len(made.too_fast)
    return wrong, made.error
