"""Making a scene: clips from the database, sampling, polishing, and the report.

Sampling and polishing are pure. This module gives captures to them, limits their time if asked to,
and tries again with other random numbers if a rule is still broken after polishing, players touch
or move faster than people can, or a motion is impossible. Of all tries the one with the fewest such
faults is kept, then the one with the lowest error.

Settings fix the number of steps of the sampling. So the same seed gives the same scene on any
machine, unless a limit of time is given and ends the sampling; the scene then says when. Compiling
does not count as time.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from motiondb import store
from motiondb.database.loading import nearby_table
from motiondb.database.scenes.scene_texts import GRAMMAR, SceneText, shipped
from motiondb.database.session import Session
from motiondb.database.values import is_compiled, seeded
from motiondb.errors import SceneError, suggestion
from motiondb.records import MOTION_FPS, Motion
from motiondb.scene.clips import clip_cutting
from motiondb.scene.clips.caption_actions import THROW, FoundActions, ShownAction
from motiondb.scene.clips.caption_actions import find_actions as actions_of_captions
from motiondb.scene.clips.clips import ClipLibrary, VariantSettings, make_library
from motiondb.scene.energy.binding import RuleTable, bind
from motiondb.scene.energy.energy import CONTACT_RADIUS, RADIUS
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.motion_grammar import MotionGrammar, Terminal
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.polish.polish import PolishedScene, polish
from motiondb.scene.report.report_records import SceneReport
from motiondb.scene.report.scene_report import report_scene
from motiondb.scene.sampling import annealing
from motiondb.scene.sampling.metropolis import walk
from motiondb.scene.sampling.play import Play, make_play


def find_actions(session: Session, grammar: MotionGrammar, exact: bool = False) -> FoundActions:
    """Return the parts of captures that show each terminal, and what unknown words are taken as.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    captions = store.load_captions(session.store)
    captioned = [
        (info.name, captions.get(info.capture_id, ()))
        for info in store.load_captures(session.store)
    ]
    table = None if exact else nearby_table()
    found = actions_of_captions(captioned, grammar, store.load_synonyms(session.store), table)
    learned = {t.name: _segments(session, t) for t in grammar.terminals if t.learned[0]}
    return replace(found, parts={**found.parts, **learned})


def _segments(session: Session, terminal: Terminal) -> tuple[ShownAction, ...]:
    """Return the segments of a learned grammar's terminal as parts of captures."""
    name, where = terminal.learned
    grammar = store.load_grammar(session.store, where)
    if name not in grammar.terminals:
        near = suggestion(name, grammar.terminals) or f" It has {', '.join(grammar.terminals)}."
        raise SceneError(
            f"{terminal.name}: expected a terminal of the learned grammar {where},"
            f" found {name!r}.{near}"
        )
    which = np.flatnonzero(grammar.labels == grammar.terminals.index(name))
    return tuple(
        ShownAction(
            grammar.sources[int(grammar.takes[n])].name,
            float(grammar.starts[n]) / MOTION_FPS,
            float(grammar.ends[n]) / MOTION_FPS,
        )
        for n in which
    )


@dataclass(frozen=True, eq=False)
class SceneClips:
    """The clips of a grammar, and the motions of their captures by name."""

    library: ClipLibrary
    motions: Mapping[str, Motion]


def scene_clips(
    session: Session,
    grammar: MotionGrammar,
    settings: VariantSettings | None = None,
    exact: bool = False,
) -> SceneClips:
    """Return the clips of all terminals of a grammar.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    chosen = settings or VariantSettings()
    return session.kept(
        ("scene clips", grammar, chosen, exact),
        lambda: _make(session, grammar, chosen, exact),
    )


def _make(
    session: Session, grammar: MotionGrammar, settings: VariantSettings, exact: bool
) -> SceneClips:
    events = store.load_events(session.store)
    infos = {info.name: info for info in store.load_captures(session.store) if info.is_captured}
    actions = {
        terminal: _evenly([part for part in parts if part.capture in infos], settings.most)
        for terminal, parts in find_actions(session, grammar, exact).parts.items()
    }
    names = sorted({part.capture for parts in actions.values() for part in parts})
    motions = {n: store.load_motion(session.store, infos[n].capture_id) for n in names}
    shown, seen = [], dict[str, clip_cutting.BodyFrames]()
    for terminal in grammar.terminals:
        for part in actions[terminal.name]:
            start, end = _frames(part, motions[part.capture], seen)
            if end - start >= clip_cutting.SHORTEST:
                info = infos[part.capture]
                shown.append(
                    clip_cutting.ShownMotion(
                        terminal.name,
                        part.capture,
                        motions[part.capture],
                        start,
                        end,
                        terminal.event,
                        events.get(info.capture_id, ()),
                        info.tags.get("licence", ""),
                        terminal.asked and not grammar.activity.shortest_rest(terminal.name),
                    )
                )
    _check_terminals(grammar, {one.terminal for one in shown})
    library = make_library(shown, [terminal.name for terminal in grammar.terminals], settings)
    used = sorted({source.capture for source in library.source})
    return SceneClips(library, {name: motions[name] for name in used})


def _evenly(parts: list[ShownAction], most: int) -> list[ShownAction]:
    """Return at most ``most`` of the parts, evenly spaced; each gives a piece or more."""
    chosen = np.linspace(0, len(parts) - 1, min(len(parts), max(most, 1))).round().astype(int)
    return [parts[k] for k in chosen]


def _frames(
    part: ShownAction, motion: Motion, seen: dict[str, clip_cutting.BodyFrames]
) -> tuple[int, int]:
    """Return the frames that show an action; ``seen`` keeps analysed captures with throws."""
    start = 0 if part.start is None else round(part.start * MOTION_FPS)
    end = motion.n_frames if part.end is None else round(part.end * MOTION_FPS)
    end = min(end, motion.n_frames)
    if not part.stretch or end - start < clip_cutting.SHORTEST:
        return start, end
    if part.capture not in seen:
        seen[part.capture] = clip_cutting.body_frames(motion)
    first, last = clip_cutting.throw_frames(seen[part.capture], start, end)
    return (first, last) if part.stretch == THROW else (start, first)


def _check_terminals(grammar: MotionGrammar, shown: set[str]) -> None:
    """Refuse a grammar with terminals that no capture shows."""
    missing = [terminal for terminal in grammar.terminals if terminal.name not in shown]
    if not missing:
        return
    asked = "; ".join(
        f"{terminal.name} ({', '.join(map(repr, terminal.phrases)) or 'no phrase'}"
        + (f" without {', '.join(map(repr, terminal.without))}" if terminal.without else "")
        + ")"
        for terminal in missing
    )
    count = "a terminal" if len(missing) == 1 else f"{len(missing)} terminals"
    raise SceneError(
        f"{grammar.name}: expected captures for every terminal, found none for {count}: {asked}."
        " Add captures whose words say so, one action a caption (motiondb words set CAPTURE), or"
        " change the phrases in the grammar's file."
        + (_SAMPLES if grammar.name in shipped(GRAMMAR) and grammar.name != "basketball" else "")
    )


_SAMPLES = (
    " Those of this grammar are in the sample data: motiondb add sample_data/activities/captures"
    " --prefix activities/ --words sample_data/activities/captions.tsv"
    " --events sample_data/activities/events.tsv"
)


SceneProgress = Callable[[str, float, float], None]
"""Called with the name of the step, the fraction that is done, and the error (NaN if unknown)."""

_MOST_CHAINS = 64  # Most Markov chains; more only take memory
FASTEST = 8.0
"""Speed of a pelvis, m/s, above which a scene is begun again; players on a court are slower."""


GLIMPSE = 3  # Rounds before the first motion of a new scene is shown
Start = tuple[Diagram, SceneState]  # The diagram and the state of an earlier scene
FirstMotion = Callable[[PolishedScene], None]
"""Called with the motions of the first try, before they are measured and other tries are made."""


@dataclass(frozen=True)
class SceneSettings:
    """Settings of a scene."""

    seed: int = 0
    """The same seed gives the same scene, unless ``minutes`` cut the sampling short (see
    :attr:`MadeScene.cut_short`)."""
    chains: int = 4
    """Number of Markov chains; the best scene of all is kept."""
    rounds: int = annealing.SamplerSettings().rounds
    """Most rounds of sampling in a try; each has a fixed number of steps."""
    minutes: float | None = None
    """Limit of time for sampling, without compiling; None for no limit."""
    tries: int = 3
    """Most tries, if faults remain."""
    gaze: bool = True
    """Whether heads follow the ball."""
    exact: bool = False
    """Whether words of the grammar that no caption holds match nothing rather than being taken as
    words that captions hold."""

    def __post_init__(self) -> None:
        if not 1 <= self.chains <= _MOST_CHAINS:
            raise SceneError(
                f"chains: expected 1 to {_MOST_CHAINS} Markov chains, found {self.chains}."
                " Use a few more than there are processors."
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


@dataclass(frozen=True, eq=False)
class MadeScene:
    """A scene, and how it was made."""

    text: SceneText  # The diagram and the grammar
    settings: SceneSettings
    clips: SceneClips
    state: SceneState
    table: RuleTable
    polished: PolishedScene
    report: SceneReport
    trace: annealing.Trace  # The course of the sampling
    error: float  # -log P(Z) before polishing
    tries: int  # Number of the try that was kept
    seconds: dict[str, float]  # Time taken by each part of the work
    # Whether the limit of time ended the sampling, or prevented another try. The seed alone then
    # does not fix the scene
    cut_short: bool
    # The last try, its rounds that were done, and the rounds of a try
    cut_at: tuple[int, int, int] = (0, 0, 0)

    @property
    def too_fast(self) -> tuple[str, ...]:
        """The players who had to move faster than people can for the rules to hold."""
        return tuple(pace.player for pace in self.report.paces if pace.after > FASTEST)

    @property
    def clean(self) -> bool:
        """Whether rules hold, no players touch or move too fast, and no motion is impossible."""
        return self.report.clean and not self.too_fast

    @property
    def n_frames(self) -> int:
        """Frames of the scene."""
        return self.polished.timeline.n_frames


def make(
    text: SceneText,
    clips: SceneClips,
    settings: SceneSettings,
    progress: SceneProgress,
    start: Start | None = None,
    shown: FirstMotion | None = None,
) -> MadeScene:
    """Sample a scene and polish it; repeat with other random numbers while faults remain.

    `start`: The diagram and state of an earlier scene to continue from; None to begin anew.
    `shown`: Called once with a first motion: after `GLIMPSE` rounds, which change nothing of the
    scene, or where an earlier scene is continued before the report is made.
    """
    sampler = _sampler(settings, start is not None)
    most, prices = sampler.most_actions, sampler.prices
    play = make_play(text.diagram, text.grammar, clips.library, most, prices)
    what = "compiling" if is_compiled(walk) else "compiling once, 1 min"
    progress(what, 0.0, math.nan)
    annealing.warm_up(play, sampler, np.random.default_rng(0))
    progress(what, 1.0, math.nan)
    making = _Making(text, clips, settings, progress, play, sampler, start)
    if shown is not None and start is None:
        shown(making.glimpse())
    until = math.inf if settings.minutes is None else time.monotonic() + 60.0 * settings.minutes
    making = replace(making, until=until)
    best: MadeScene | None = None
    for number, rng in enumerate(seeded(settings.seed).spawn(settings.tries)):
        made = making.attempt(number, rng, shown if start and number == 0 else None)
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


def _sampler(settings: SceneSettings, warm: bool) -> annealing.SamplerSettings:
    """Return the settings of the sampler; they fix the number of its steps."""
    if warm:
        return annealing.WARM
    threads = min(settings.chains, os.cpu_count() or 1)
    return annealing.SamplerSettings(settings.chains, rounds=settings.rounds, threads=threads)


@dataclass(frozen=True, eq=False)
class _Making:
    """What all tries to make a scene share."""

    text: SceneText
    clips: SceneClips
    settings: SceneSettings
    progress: SceneProgress
    play: Play
    sampler: annealing.SamplerSettings
    start: Start | None
    until: float = math.inf  # A time of :func:`time.monotonic`
    seconds: dict[str, float] = field(default_factory=lambda: {"sampling": 0.0, "polishing": 0.0})

    def glimpse(self) -> PolishedScene:
        """The motion of a few rounds, to be looked at while the scene is sampled."""
        few = replace(self.sampler, rounds=min(GLIMPSE, self.sampler.rounds))
        state, _ = annealing.sample(self.play, few, np.random.default_rng(0))
        return self._polished(state, self._table(state), follows=False)

    def _table(self, state: SceneState) -> RuleTable:
        spans = [player.spans for player in state.players]
        return bind(self.text.diagram, self.text.grammar, list(state.trees), spans)

    def _polished(
        self,
        state: SceneState,
        table: RuleTable,
        follows: bool = True,
        contact: float = CONTACT_RADIUS,
    ) -> PolishedScene:
        clips, gaze, is_update = self.clips, self.settings.gaze, self.start is not None
        how = gaze, is_update, follows, contact
        return polish(state, clips.library, clips.motions, table, *how)

    def _measured(
        self, state: SceneState, table: RuleTable, polished: PolishedScene
    ) -> tuple[PolishedScene, SceneReport]:
        """Return a scene with its report, with more room for who touch if their limbs cross.

        To polish once more takes a second, another try a quarter of a minute.
        """
        clips = self.clips
        report = report_scene(state, clips.library, clips.motions, table, polished)
        meet = [{table.players[one], table.players[other]} for one, _, other, _ in table.contacts]
        if not any(one.kind == "limbs" and set(one.players) in meet for one in report.impossible):
            return polished, report
        apart = self._polished(state, table, contact=RADIUS)
        other = report_scene(state, clips.library, clips.motions, table, apart)
        return (apart, other) if _faults(other) < _faults(report) else (polished, report)

    def attempt(
        self, number: int, rng: np.random.Generator, shown: FirstMotion | None
    ) -> MadeScene:
        """Sample a scene once, polish it and measure it."""
        text, clips, start, progress = self.text, self.clips, self.start, self.progress
        what = "sampling" if number == 0 else f"sampling, try {number + 1}"
        rounds, cut_short = self.sampler.rounds, False

        def heard(done: int, error: float) -> bool:
            nonlocal cut_short
            progress(what, done / rounds, error)
            cut_short = done < rounds and time.monotonic() > self.until
            return cut_short

        began = time.monotonic()
        progress(what, 0.0, math.nan)
        first = annealing.warm_start(start[1], start[0], self.play, rng) if start else None
        state, trace = annealing.sample(self.play, self.sampler, rng, first, heard)
        self.seconds["sampling"] += time.monotonic() - began
        began = time.monotonic()
        progress("polishing", 0.0, trace.final)
        table = self._table(state)
        polished = self._polished(state, table)
        if shown is not None:
            shown(polished)
        polished, report = self._measured(state, table, polished)
        self.seconds["polishing"] += time.monotonic() - began
        return MadeScene(
            text,
            self.settings,
            clips,
            state,
            table,
            polished,
            report,
            trace,
            trace.final,
            number + 1,
            self.seconds,
            cut_short,
        )


def _badness(made: MadeScene) -> tuple[int, float]:
    """Return the number of faults of a scene, and its error."""
    return _faults(made.report) + len(made.too_fast), made.error


def _faults(report: SceneReport) -> int:
    """Return the number of what is wrong in a scene: broken rules, and what a viewer sees."""
    seen = sum(one.kind in ("misses", "object", "reach", "order") for one in report.seen)
    return len(report.broken) + len(report.collisions) + len(report.impossible) + seen
