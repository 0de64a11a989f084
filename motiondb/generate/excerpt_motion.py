"""Motion from excerpts of captures: choice of the excerpts, tempo, repetitions, seams.

Notation: action k has candidates i, excerpts with cuts moved by some frames. Dynamic programming
(:mod:`motiondb.generate.stitching`) finds the sequence of least

    sum_k target_k(i_k) + JOIN_WEIGHT sum_k join_k(i_k, i_{k+1}),

where the target cost is minus the score of the excerpt, which counts the frames in which the action
is not to be seen (a run that stops joins best with what follows, but who stands does not run), and
for "slowly" and "fast" a cost of the distance from the speed that is asked for. Choice 0 is that
sequence. Choice c > 0 prefers place c of each action (:mod:`motiondb.generate.excerpts`), counted
modulo their number: the place is made as good as the best one, and excerpts of other places cost
``OTHER_PLACE`` more. A place that is wished for one action must be one of its places.

Tempo: frame t of the result is frame r t of the source, so that a rate r > 1 is faster; path values
that are speeds are multiplied by r. The *speed* of a motion is the mean speed of its joints in the
world, metres a second on the standard body. A rate is *natural* if the resulting speed lies within
the speeds of recorded motions of the same action.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from motiondb.body import pose_vectors, retarget, rotation
from motiondb.body.contacts import find_contacts
from motiondb.body.features import FEATURE_STEP
from motiondb.errors import QueryError
from motiondb.generate import contact, cuts, stitching
from motiondb.generate.action_sources import ActionSources
from motiondb.generate.excerpts import (
    DIRECTION_WEIGHT,
    LONGEST,
    NOT_DONE,
    SHORTEST,
    UNSEEN_WEIGHT,
    Excerpt,
    Layout,
    Movement,
    complete,
    direct,
    find_excerpts,
    lay_out,
    number_places,
    occurrences_in,
    recount,
    with_unseen,
)
from motiondb.generate.material import Material, SequenceMotion, Takes, gather, pose_vectors_of
from motiondb.generate.sentence_plan import PlannedAction, is_within
from motiondb.learn.learned import Learned
from motiondb.meaning.direction import ONCE, gone, lacking
from motiondb.meaning.edge_map import averaged
from motiondb.meaning.occurrences import FLIGHTS, OVER, measured_track
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion

JOIN_WEIGHT = 0.5  # Weight of join costs relative to target costs
MOST_JOIN = 30.0
"""Join costs approach this, so that of seams that all do not fit, the better excerpts are taken."""
_AT_ENDS = {"stop", "start"}  # Words of which the evidence says only that they occur
OTHER_PLACE = 4.0
"""Cost of an excerpt of another place than the preferred one, nats, so that only a much better seam
outweighs it."""
SEEN = 0.5  # Share of the largest evidence of a capture from which on a frame shows an action
MOST_EXCERPTS = 24  # Number of excerpts of an action among which the sequence is chosen
WORST = 6.0
"""Nats by which a candidate may score below the best, besides what it costs not to do what is
measured."""
SPEED_WEIGHT = 6.0  # Cost of a factor e between the speed of an excerpt and the one asked for
SHORT_WEIGHT = 0.7
"""Cost of an excerpt that is shorter by a factor e than the duration asked for, because it must be
repeated."""
LEAST_FRAMES = 15
"""Smallest bound on the length of an excerpt, frames (0.5 s), however short the requested
duration."""
LEAST_CHANGE = 0.02  # Smallest relative change of the tempo that is made
SLOW_SHARE, FAST_SHARE = 0.15, 0.85
"""Quantiles of the recorded speeds that "slowly" and "fast" ask for."""
SMOOTHINGS = 3  # How often the speed over the ground is smoothed where it jumps by ``cuts.ROUGH``
MOST_CHANGE = 1.4
"""Largest factor by which a recorded motion is played faster or slower. Beyond it jumps look as if
gravity had changed."""
SWIFT = frozenset((*FLIGHTS, *OVER, "kick", "punch"))  # Actions that are none if they are slow
MOST_FITTED = 1.25  # The same where a duration is asked for, and no speed


@dataclass(frozen=True, eq=False)
class ShownExcerpt:
    """The excerpt of one action, and how it is played."""

    action: PlannedAction
    excerpt: Excerpt  # Where it comes from, in frames of the capture
    layout: Layout  # Parts that are played, in frames of the capture at the new tempo
    rate: float = 1.0  # Tempo: 2 is twice as fast as recorded
    # Mean speed of the joints of the excerpt as recorded, and the least and largest of all excerpts
    # of the action, m/s; None where no speed was asked for
    speeds: tuple[float, float, float] | None = None
    directions: tuple[str, ...] = ()  # Measured words that its captures can show
    place: int = 0  # Number of its place; -1 if it is not among those comparable with the best one
    n_places: int = 1  # Number of places that show the action about as clearly as the best one
    does: bool = True  # Whether it does all that is measured
    is_picked: bool = False  # Whether it was asked for
    # Other excerpts that are played after the first part of the layout
    between: tuple[stitching.Piece, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return self.layout.n_frames + sum(piece.end - piece.start for piece in self.between)


@dataclass(frozen=True, eq=False)
class ExcerptMotion:
    """A motion made of excerpts."""

    made: SequenceMotion  # The motion; its lengths are those of the actions
    shown: tuple[ShownExcerpt, ...]


@dataclass(frozen=True, eq=False)
class _Material(Material):
    """Captures as paths and pose vectors with what excerpts are compared by."""

    tracks: Mapping[int, FloatArray]  # Capture -> measured track: array (frames, 16)
    scale: FloatArray  # (values,): standard deviations of the pose vectors
    takes: dict[int, cuts.Take]  # Capture -> what cutting looks at
    contacts: Mapping[int, NDArray[np.bool_]]  # Capture -> feet on the ground: array (frames, 2)


@dataclass(frozen=True)
class PlaceWish:
    """Where the excerpt of one action is to come from."""

    place: int | None = None  # Number of a place (``ShownExcerpt.place``), or None
    excerpt: tuple[int, int, int] | None = None  # Capture, first frame, last frame + 1


@dataclass(frozen=True)
class Choices:
    """Which of the places that show each action about as clearly are preferred."""

    place: int = 0  # For every action without a wish: 0 the best, 1 the next, and so on
    wishes: tuple[PlaceWish, ...] = ()  # One for each action, or none

    def of(self, action: int) -> PlaceWish:
        """Return the wish for the action of a number."""
        wish = self.wishes[action] if self.wishes else PlaceWish()
        return replace(wish, place=self.place) if wish.place is None else wish


ANY_PLACE = Choices()  # No wishes: the best places


def excerpt_motion(
    learned: Learned,
    takes: Takes,
    actions: Sequence[ActionSources],
    rng: np.random.Generator,
    choice: Choices = ANY_PLACE,
) -> ExcerptMotion:
    """Make a motion that shows actions in order."""
    wishes = [choice.of(n) for n in range(len(actions))]
    likely = [
        _likely(each) if wish.excerpt is None else [Excerpt(*wish.excerpt, 0.0, wish.excerpt[1:])]
        for each, wish in zip(actions, wishes)
    ]
    material = _gather(takes, {e.capture for each in likely for e in each})
    rows = [
        _rows(learned, takes, material, of, excerpts, wish)
        for of, excerpts, wish in zip(actions, likely, wishes)
    ]
    if choice.wishes:
        _check_places(rows, choice.wishes)
    picked, owners = _pick(material, rows, rng)
    shown, pieces, sources, lengths = [], [], dict(material.paths), []
    origins: dict[int, tuple[int, float]] = {c: (c, 1.0) for c in sources}
    for number, (row, n, excerpt) in enumerate(zip(rows, owners, picked)):
        is_last = number == len(actions) - 1
        one = _lay_out(material, row, n, excerpt, is_last)
        key = excerpt.capture
        if one.rate != 1.0:
            key = -2 - number
            sources[key] = resample(*material.paths[excerpt.capture], one.rate)
            origins[key] = (excerpt.capture, one.rate)
        elif cuts.is_monotonous(one.layout):
            one = _vary(material, row, one, is_last, rng)
        played = [stitching.Piece(key, a, b) for a, b in one.layout.parts]
        played[1:1] = one.between
        pieces += played
        lengths.append(one.n_frames)
        shown.append(one)
    legs = [material.motions[origins[piece.capture][0]].leg_length for piece in pieces]
    stitched = stitching.stitch(pieces, sources)
    made = _finish(stitched, material, origins, lengths, float(np.median(legs)))
    if any(one.layout.is_measured for one in shown):
        parts = np.split(measured_track(made.motion), np.cumsum(lengths)[:-1])
        shown = [
            replace(one, layout=recount(one.action, one.layout, part))
            for one, part in zip(shown, parts)
        ]
    return ExcerptMotion(made, tuple(shown))


@dataclass(frozen=True, eq=False)
class _Rows:
    """The excerpts of an action among which one is chosen."""

    of: ActionSources
    excerpts: list[Excerpt]
    words: tuple[str, ...]  # Measured words that its captures can show
    speeds: FloatArray  # (excerpts,): mean speed of the joints, m/s
    costs: FloatArray  # (excerpts,): of the distance from the speed that is asked for
    values: FloatArray  # (excerpts,)
    does: NDArray[np.bool_]  # (excerpts,): whether each does what is measured
    places: IntArray  # (excerpts,)
    unseen: Mapping[int, FloatArray]  # Capture -> 1 where the action is not to be seen: (frames,)
    wish: PlaceWish


def _rows(
    learned: Learned,
    takes: Takes,
    material: _Material,
    of: ActionSources,
    excerpts: list[Excerpt],
    wish: PlaceWish,
) -> _Rows:
    """The excerpts of an action, cut to what is measured, with what they are chosen by."""
    words: tuple[str, ...] = ()
    unseen: dict[int, FloatArray] = {}
    if wish.excerpt is None:
        excerpts, words = _direct(material, of, excerpts)
        unseen = {} if _AT_ENDS & {*words} else _unseen(learned, takes, of.action, excerpts)
    excerpts = with_unseen(excerpts, unseen)
    speeds = _speeds(material, excerpts)
    costs = _speed_costs(of.action, speeds)
    values = np.array([e.score for e in excerpts]) - costs
    does = _does(material, excerpts, words)
    places = number_places(excerpts, values, does, words)
    return _Rows(of, excerpts, words, speeds, costs, values, does, places, unseen, wish)


def _check_places(rows: Sequence[_Rows], wishes: Sequence[PlaceWish]) -> None:
    """Raise QueryError if an action is wanted from a place that it does not have."""
    for number, (row, wish) in enumerate(zip(rows, wishes), start=1):
        last = int(row.places.max())
        if wish.excerpt is None and wish.place is not None and not 0 <= wish.place <= last:
            raise QueryError(
                f"places: expected a number from 0 to {last} for action {number}"
                f" ({' '.join(row.of.action.words)}), found {wish.place}. Choose one of those, or"
                " None for any."
            )


def _unseen(
    learned: Learned, takes: Takes, action: PlannedAction, excerpts: Sequence[Excerpt]
) -> dict[int, FloatArray]:
    """Per capture 1 at the frames whose evidence for an action is below SEEN of the largest."""
    placed, edges = learned.placed, learned.edges
    words = [learned.word_numbers[w] for w in action.words if w in learned.word_numbers]
    if placed is None or edges is None or not words or not placed.words.issuperset(words):
        return {}
    unseen = {}
    for capture in sorted({e.capture for e in excerpts}):
        frames = takes.frames.whitened(capture)
        evidence = averaged(edges.evidence(frames, words))
        least = SEEN * float(evidence.max())
        unseen[capture] = np.repeat((evidence < least) | (least <= 0.0), FEATURE_STEP).astype(float)
    return unseen


def _pick(
    material: _Material, rows: Sequence[_Rows], rng: np.random.Generator
) -> tuple[list[Excerpt], list[int]]:
    """The excerpts of the sequence with their cuts, and the number of each among its action's."""
    candidates = []
    for k, row in enumerate(rows):
        timed = row.of.action.seconds is not None
        position = cuts.Position(k == 0, k == len(rows) - 1, bool(row.words), timed)
        preferred = row.costs + _preference(row.places, row.values, row.wish.place or 0)
        preferred = preferred + rng.uniform(0.0, 0.05, size=len(preferred))
        moved, owner = _moved(material, row, preferred, position)
        candidates.append((_with_directions(material, moved, row.words, position), owner))
    chosen = stitching.choose([candidate for candidate, _ in candidates], JOIN_WEIGHT, MOST_JOIN)
    owners = [int(owner[i]) for i, (_, owner) in zip(chosen, candidates)]
    picked = [
        replace(row.excerpts[n], start=int(moved.starts[i]), end=int(moved.ends[i]))
        for i, n, row, (moved, _) in zip(chosen, owners, rows, candidates)
    ]
    fixed = [
        row.of.action.seconds is not None or bool(row.words) or row.wish.excerpt is not None
        for row in rows
    ]
    return cuts.refine(picked, material.takes, fixed), owners


def _moved(
    material: _Material, row: _Rows, costs: FloatArray, position: cuts.Position
) -> tuple[stitching.Candidates, IntArray]:
    """The excerpts of an action with moved cuts, and the number of the excerpt of each."""
    values = {
        s.capture: cuts.frame_values(s, len(material.takes[s.capture].poses))
        for s in row.of.sources
        if s.capture in material.takes
    }
    for capture, unseen in row.unseen.items():
        n = min(len(unseen), len(values[capture]))
        values[capture][:n] -= UNSEEN_WEIGHT * unseen[:n]
    if row.wish.excerpt is None:
        return cuts.moved_cuts(row.excerpts, material.takes, values, costs, position)
    (capture, *_) = row.wish.excerpt
    values.setdefault(capture, np.zeros(len(material.takes[capture].poses)))
    moved, owner = cuts.moved_cuts(row.excerpts, material.takes, values, costs, position)
    itself = stitching.Candidates(*(getattr(moved, one.name)[:1] for one in fields(moved)))
    return itself, owner[:1]


def _vary(
    material: _Material,
    row: _Rows,
    one: ShownExcerpt,
    is_last: bool,
    rng: np.random.Generator,
) -> ShownExcerpt:
    """The same with other excerpts of the action in place of a loop's repetitions."""
    moved = _moved(material, row, row.costs, cuts.Position(False, False))
    asked = one.action.seconds
    layout, between = cuts.vary(
        one.excerpt.capture,
        one.layout,
        moved,
        material.takes,
        (JOIN_WEIGHT, MOST_JOIN),
        is_last,
        asked is not None and asked.most is None,
        rng,
    )
    return replace(one, layout=layout, between=between)


def _finish(
    stitched: stitching.Stitched,
    material: _Material,
    origins: Mapping[int, tuple[int, float]],
    lengths: Sequence[int],
    leg_length: float,
) -> SequenceMotion:
    """A stitched motion with locked feet, and the origin of its frames in the captures."""
    for _ in range(SMOOTHINGS):
        jumps = maximum_filter1d(cuts.jumps_of(np.hypot(*stitched.path[:, 1:3].T)), 7) > cuts.ROUGH
        stitching.smooth_speeds(stitched.path, jumps.astype(float))
    motion = pose_vectors.from_path(stitched.path, stitched.rotations, leg_length=leg_length)
    rates = np.array([origins[int(c)][1] for c in stitched.captures])
    edits = []
    for share, rate in zip(stitched.shares, rates):
        done = [f"blend {share:.2f}"] if share != 1 else []
        done += [f"speed {rate:.3f}"] if rate != 1 else []
        edits.append(", ".join([*done, "foot lock"]))
    captures = np.array([origins[int(c)][0] for c in stitched.captures])
    frames = stitched.frames * rates
    nearest = np.rint(frames).astype(np.int64)
    stands = np.array([material.contacts[c][f] for c, f in zip(captures.tolist(), nearest)])
    return SequenceMotion(
        contact.lock_feet(motion, contacts=stands, bent=stitched.shares < 1.0),
        captures,
        frames,
        tuple(edits),
        tuple(lengths),
    )


def _preference(places: IntArray, values: FloatArray, choice: int) -> FloatArray:
    """Cost of each excerpt for not being of the place that a choice prefers: array (excerpts,).

    The preferred place is made as good as the best one.
    """
    if choice == 0:
        return np.zeros(len(places))
    inside = places == choice % (places.max() + 1)
    return np.where(inside, values[inside].max() - values.max(), OTHER_PLACE)


def _does(
    material: _Material, excerpts: Sequence[Excerpt], directions: Sequence[str]
) -> NDArray[np.bool_]:
    """Whether excerpts do what measured words say: array (excerpts,)."""
    return np.array(
        [
            not any(
                lacking(gone(material.tracks[e.capture][e.start : e.end], d), d) for d in directions
            )
            for e in excerpts
        ]
    )


def _with_directions(
    material: _Material,
    moved: stitching.Candidates,
    directions: Sequence[str],
    position: cuts.Position,
) -> stitching.Candidates:
    """Candidates that cost more where cuts leave too little of a measured word.

    What seams bend does not count.
    """
    if not directions:
        return moved
    targets = moved.targets.copy()
    bent = stitching.BLEND_FRAMES
    ahead, behind = 0 if position.is_first else bent, 0 if position.is_last else bent
    for n, (c, a, b) in enumerate(zip(moved.captures, moved.starts, moved.ends)):
        track = material.tracks[int(c)][a + ahead : b - behind]
        targets[n] += NOT_DONE * sum(lacking(gone(track, word), word) for word in directions)
    return replace(moved, targets=targets)


def _likely(of: ActionSources) -> list[Excerpt]:
    """The best excerpts of an action."""
    longest = _longest(of.action)
    wanted = 0.0 if of.action.seconds is None else of.action.seconds.wanted * MOTION_FPS
    likely = [
        replace(
            e,
            score=e.score
            - SHORT_WEIGHT * max(float(np.log(max(wanted, SHORTEST) / (e.end - e.start))), 0.0),
        )
        for e in find_excerpts(of.sources, longest)
    ]
    likely.sort(key=lambda e: -e.score)
    worst = WORST + (NOT_DONE + DIRECTION_WEIGHT if of.directions else 0.0)
    return [e for e in likely if e.score >= likely[0].score - worst][:MOST_EXCERPTS]


def _longest(action: PlannedAction) -> int:
    """Most frames of an excerpt of an action."""
    if action.seconds is not None:
        return max(round(action.seconds.wanted * MOTION_FPS), LEAST_FRAMES)
    if action.times is not None:
        return round(LONGEST * min(max(action.times.wanted, 1.0), 4.0))
    return LONGEST


def _direct(
    material: _Material, of: ActionSources, excerpts: Sequence[Excerpt]
) -> tuple[list[Excerpt], tuple[str, ...]]:
    """Excerpts that do what the measured words of an action say, and begin and end as usual."""
    directed, honoured = direct(excerpts, material.tracks, of.directions, _longest(of.action))
    every = np.concatenate(list(material.vectors.values()))
    centre = every.mean(axis=0)
    unusual = {
        c: np.mean(((v - centre) / material.scale) ** 2, axis=1)
        for c, v in material.vectors.items()
    }
    if of.action.seconds is None:
        directed = [complete(e, unusual[e.capture]) for e in directed]
    return directed, honoured


def _gather(takes: Takes, captures: Iterable[int]) -> _Material:
    """The material of some captures, with measured tracks."""
    base = gather(takes, captures)
    scale = np.concatenate(list(base.vectors.values())).std(axis=0) + 1e-6
    tracks = {c: measured_track(m) for c, m in base.motions.items()}
    seen, contacts = {}, {}
    for c, motion in base.motions.items():
        positions = retarget.motion_positions(motion)[0]
        edges = cuts.edges_of(*base.paths[c], base.vectors[c], scale)
        speeds = np.hypot(*base.paths[c][0][:, 1:3].T)
        seen[c] = cuts.Take(edges, base.vectors[c][:, 4:], cuts.restlessness(positions), speeds)
        contacts[c] = find_contacts(positions)
    return _Material(**vars(base), tracks=tracks, scale=scale, takes=seen, contacts=contacts)


def _speeds(material: _Material, excerpts: Sequence[Excerpt]) -> FloatArray:
    """Mean speed of the joints of every excerpt: array (excerpts,), m/s."""
    of = {c: joint_speeds(material.motions[c]) for c in {e.capture for e in excerpts}}
    return np.array([float(of[e.capture][e.start : e.end].mean()) for e in excerpts])


def _speed_costs(action: PlannedAction, speeds: FloatArray) -> FloatArray:
    """Cost of the distance from the speed that is asked for: array (excerpts,)."""
    if not action.speed:
        return np.zeros(len(speeds))
    wanted = wanted_speed(speeds, action.speed == "fast")
    return SPEED_WEIGHT * np.abs(np.log(np.maximum(speeds, 1e-3) / max(wanted, 1e-3)))


def _lay_out(
    material: _Material, row: _Rows, n: int, excerpt: Excerpt, is_last: bool
) -> ShownExcerpt:
    """Play excerpt n of an action, as cut, at the tempo and as often and long as is asked for.

    Its tempo also fits it to a duration that its loops miss; but a slow kick is none.
    """
    action, rate, range_of = row.of.action, 1.0, None
    if action.speed:
        speed = float(_speeds(material, [excerpt])[0])
        fast = action.speed == "fast"
        wanted = wanted_speed(row.speeds, fast)
        rate = natural_rate(speed, wanted, row.speeds, fast)
        rate = round(rate, 3) if abs(rate - 1.0) >= LEAST_CHANGE else 1.0
        range_of = (speed, float(row.speeds.min()), float(row.speeds.max()))
    shown = _played(material, row, n, excerpt, is_last, rate)
    seconds, asked = shown.n_frames / MOTION_FPS, action.seconds
    is_fixed = bool(action.speed) or not SWIFT.isdisjoint(action.words)
    if asked is None or is_fixed or is_within(seconds, asked) or asked.wanted <= 0.0:
        return replace(shown, speeds=range_of)
    fitting = float(np.clip(seconds / asked.wanted, 1.0 / MOST_FITTED, MOST_FITTED))
    again = _played(material, row, n, excerpt, is_last, round(fitting, 3))
    return again if is_within(again.n_frames / MOTION_FPS, asked) else shown


def _played(
    material: _Material, row: _Rows, n: int, excerpt: Excerpt, is_last: bool, rate: float
) -> ShownExcerpt:
    """Play excerpt n of an action, as cut, at a tempo, as often and long as is asked for."""
    action = row.of.action
    take = material.takes[excerpt.capture]
    poses, edges, restless = take.poses, take.edges, take.restless
    span = excerpt.start, excerpt.end
    if rate != 1.0:
        path = resample(*material.paths[excerpt.capture], rate)
        vectors = pose_vectors_of(path, material.means)
        poses, edges = vectors[:, 4:], cuts.edges_of(*path, vectors, material.scale)
        which = np.minimum(np.rint(np.arange(len(poses)) * rate), len(restless) - 1)
        restless = restless[which.astype(np.int64)]
        span = round(span[0] / rate), min(round(span[1] / rate), len(vectors))
    movement = Movement(
        poses,
        edges,
        any(word in ONCE for word in row.words),
        occurrences_in(excerpt, action, material.tracks[excerpt.capture], rate),
        is_last,
        restless,
    )
    is_picked = row.wish.excerpt is not None
    return ShownExcerpt(
        action,
        excerpt,
        lay_out(action, span, movement),
        rate,
        None,
        row.words,
        -1 if is_picked else int(row.places[n]),
        int(row.places.max()) + 1,
        bool(row.does[n]),
        is_picked,
    )


def joint_speeds(motion: Motion) -> FloatArray:
    """Mean speed of the joints at every frame: array (frames,), metres a second."""
    positions, _ = retarget.motion_positions(motion)
    if len(positions) < 2:
        return np.zeros(len(positions))
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=-1).mean(axis=1) * MOTION_FPS
    return np.append(steps, steps[-1])


def wanted_speed(speeds: FloatArray, fast: bool) -> float:
    """Speed that "fast" or "slowly" asks for, among the recorded speeds of the action.

    >>> wanted_speed(np.array([1.0, 2.0, 3.0]), True)
    2.7
    """
    return round(float(np.quantile(speeds, FAST_SHARE if fast else SLOW_SHARE)), 9)


def natural_rate(speed: float, wanted: float, speeds: FloatArray, fast: bool) -> float:
    """Playback rate at which a motion has a requested speed, within the range of recorded speeds.

    A motion that is fast enough is not slowed down where it is to be fast, and the other way round.

    >>> natural_rate(1.0, 1.3, np.array([0.8, 1.2]), True)
    1.2
    >>> natural_rate(1.5, 1.3, np.array([0.8, 1.5]), True)
    1.0
    """
    wanted = float(np.clip(wanted, speeds.min(), speeds.max()))
    rate = wanted / max(speed, 1e-6)
    rate = max(rate, 1.0) if fast else min(rate, 1.0)
    return float(np.clip(rate, 1.0 / MOST_CHANGE, MOST_CHANGE))


def resample(path: FloatArray, rotations: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Play a path (frames, 4) and its rotations (frames, joints, 4) at another rate."""
    times = np.arange(0.0, len(path) - 1 + 1e-9, rate)
    low = np.minimum(times.astype(np.int64), max(len(path) - 2, 0))
    share = times - low
    high = np.minimum(low + 1, len(path) - 1)
    values = path[low] * (1.0 - share[:, None]) + path[high] * share[:, None]
    values[:, 1:] *= rate
    weights = np.repeat(share[:, None], rotations.shape[1], axis=1)
    return values, rotation.slerp(rotations[low], rotations[high], weights)
