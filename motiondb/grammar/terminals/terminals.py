"""Find the terminals of takes: segments, K groups of segments that are alike, and their names.

Poses are described so that d(x_t, x_t') is cheap (:mod:`.distances`). A coarse search at 15 frames
a second over candidate cuts finds segments and medoids together, and divides medoids that hold two
movements (:mod:`.exchange`). Then cuts slide to single frames (:mod:`.tuning`), and all segments
are grouped once more from the medoids; the better grouping is kept. The takes become strings over
the terminals; no segment crosses the end of a take.

The objective is the F of the paper minus a price for every cut: F alone grows when segments get
shorter, down to the shortest that is allowed. The price and the weight of R were chosen on one take
of each of the three grammars of the sample data, so that boundaries and groups agree best with the
truth; ``docs/measured/grammar.md`` reports the other takes.

Notation: segments s_i of L(s_i) frames tile T frames; group k has the medoid s_k^c.

    R  = (1 / T) sum_k L(s_k^c)                                 in [0, 1], 1 exactly when n = K
    E' = (1 / d_max) sum_k sum_{i in k} L(s_i) / T D(s_i, s_k^c)    in [0, 1]
    F  = 1 / (w R + (1 - w) E')

R is low if few frames represent all, that is, if terminals repeat. E' is low if segments that share
a terminal are alike. Both fall when segments become shorter, so F alone would cut to the least
length that is allowed; ``shortest`` and the number of segments N work against that.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 4; equations 3 to 5 for R, E' and F.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import product
from string import ascii_lowercase

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import candidates, exchange, tuning
from motiondb.grammar.terminals.distances import Poses, distances_to, make_poses, segment_distances
from motiondb.grammar.terminals.exchange import divide
from motiondb.grammar.terminals.medoids import group_by_medoids
from motiondb.grammar.terminals.tuning import Costs
from motiondb.records import BoolArray, FloatArray, IntArray, Motion, SegmentTable

REPETITION_WEIGHT = 0.1
"""w, the share of R in the objective. Chosen on one take of each sample grammar."""


@dataclass(frozen=True)
class Score:
    """R, E' and F of a grouping."""

    repetition: float
    error: float
    objective: float


def score(
    lengths: IntArray,
    medoids: IntArray,
    to_medoid: FloatArray,
    largest: float,
    weight: float = REPETITION_WEIGHT,
) -> Score:
    """Compute R, E' and F.

    Shapes: `lengths`, `to_medoid` (segments,); `medoids` (K,).

    `largest`: d_max. Where it is 0 all poses are the same, and E' is 0.

    >>> import numpy as np
    >>> ends = np.array([2, 2, 4])
    >>> score(ends, np.array([0, 2]), np.array([0.0, 0.5, 0.0]), 1.0, 0.5)
    Score(repetition=0.75, error=0.125, objective=2.2857142857142856)
    """
    n_frames = int(lengths.sum())
    repetition = float(lengths[medoids].sum()) / n_frames
    error = float(lengths @ to_medoid) / n_frames / largest if largest > 0.0 else 0.0
    return Score(repetition, error, objective(repetition, error, weight))


def objective(repetition: float, error: float, weight: float = REPETITION_WEIGHT) -> float:
    """Return F = 1 / (w R + (1 - w) E'), infinite if both are 0."""
    total = weight * repetition + (1.0 - weight) * error
    return 1.0 / total if total > 0.0 else float("inf")


COARSE_STEP = 2  # Frames per frame of the coarse search: 15 frames a second


FEWEST_TRIALS, MOST_TRIALS, TRIED_CELLS = 6_000, 16_000, 32_000_000
"""Bounds of the number of medoids that are tried, and of the number of cells computed for all of
them. Chosen so that a long take needs seconds; see ``docs/measured/grammar.md``, Speed."""


@dataclass(frozen=True)
class TerminalSettings:
    """Settings of the search for terminals.

    Prices were chosen on one take of each sample grammar, the other values by hand.
    """

    shortest: int = 8  # Smallest number of frames of a segment
    longest: int = 75  # Largest number of frames of a segment
    grid: int = 10  # Largest number of frames between candidate cuts
    weight: float = REPETITION_WEIGHT  # w, the share of R
    # Price of a segment, in mean distances of a pose from the mean pose times frames
    segment_price: float = 2.0
    rest: float = 3.0  # Price of a cut at the mean speed of the takes, in the same unit
    most_segments: int | None = None  # N; no bound unless given
    n_starts: int = 16  # Number of starts of the exchange search
    # Number of trials of the exchange search; :func:`trials_for` unless given
    n_trials: int | None = None
    # Settings of the tuning of cuts
    tuning: tuning.TuningSettings = field(default_factory=tuning.TuningSettings)


def trials_for(n_cells: int) -> int:
    """Return the number of medoids to try; the time of a trial grows with the number of cells.

    >>> trials_for(1_000), trials_for(4_000), trials_for(20_000)
    (16000, 8000, 6000)
    """
    return min(MOST_TRIALS, max(FEWEST_TRIALS, TRIED_CELLS // n_cells))


def check_settings(n_terminals: int, settings: TerminalSettings) -> None:
    """Check settings; raise GrammarError with advice if they are not valid."""
    if n_terminals < 1:
        raise GrammarError(
            f"terminals: expected at least 1, found {n_terminals}. Ask for more terminals."
        )
    most = settings.most_segments
    if most is not None and most < n_terminals:
        raise GrammarError(
            f"terminals: expected room for {n_terminals} segments or more, found at most {most} "
            "allowed. Allow more segments, or ask for fewer terminals."
        )
    if not 0.0 <= settings.weight < 1.0:
        raise GrammarError(
            f"terminals: expected a weight of R from 0 to below 1, found {settings.weight}. "
            "Choose one such as 0.1."
        )
    if not 2 <= settings.shortest <= settings.longest or settings.grid < COARSE_STEP:
        raise GrammarError(
            "terminals: expected 2 <= shortest <= longest frames and a grid of 2 frames or more, "
            f"found {settings.shortest}, {settings.longest} and {settings.grid}. Change them."
        )


TUNED = 4  # Number of the best starts that are tuned; the best of them is kept

Progress = Callable[[int, int, str], None]
"""Called with the amount done, the total amount, and the name of the step."""


@dataclass(frozen=True, eq=False)
class Terminals:
    """Segments of takes and their terminals."""

    names: tuple[str, ...]  # K names, numbered as ``labels`` number them
    takes: IntArray  # (segments,): number of the take, in the order given
    # (segments,): first frame of each segment in the canonical motion; the segments of a take tile
    # it
    starts: IntArray
    ends: IntArray  # (segments,): frame after the last of each segment
    labels: IntArray  # (segments,): number of the terminal; every terminal is used
    medoids: IntArray  # (K,): the most central segment of every terminal
    objective: float


def find_terminals(
    takes: Sequence[Motion],
    n_terminals: int,
    rng: np.random.Generator,
    *,
    settings: TerminalSettings | None = None,
    progress: Progress | None = None,
) -> Terminals:
    """Find segments and terminals of takes; `progress` gets the amounts of each step anew."""
    settings = settings or TerminalSettings()
    tell = progress or _silent
    check_settings(n_terminals, settings)
    tell(0, 1, "describe poses")
    poses = make_poses(takes)
    costs = cut_costs(poses, settings)
    tell(0, 100, "search terminals")

    def advance(share: float) -> None:
        tell(round(100 * share), 100, "search terminals")

    groupings = _search(poses, costs, n_terminals, settings, rng, advance)
    tell(0, 1, "tune cuts")

    def finish(job: tuple[tuning.Grouping, np.random.Generator]) -> tuning.Grouping:
        tuned, _ = tuning.tune(job[0], costs, job[1], settings.tuning)
        again = _grouped(tuned.cuts, costs, n_terminals, tuned.medoids)
        return min((tuned, again), key=lambda g: tuning.total_cost(g, costs))

    finished = []
    with ThreadPoolExecutor(2) as pool:
        for done in pool.map(finish, zip(groupings, rng.spawn(len(groupings)))):
            finished.append(done)
            tell(len(finished), len(groupings), "tune cuts")
    best = min(finished, key=lambda g: tuning.total_cost(g, costs))
    return as_terminals(poses, best, settings.weight)


def strings_of(terminals: Terminals) -> tuple[tuple[str, ...], ...]:
    """Return one string a take: the names of its segments' terminals in order of time."""
    strings: list[list[str]] = [[] for _ in range(int(terminals.takes.max()) + 1)]
    for take, label in zip(terminals.takes, terminals.labels):
        strings[take].append(terminals.names[label])
    return tuple(tuple(string) for string in strings)


def terminals_from_symbols(
    takes: Sequence[Motion],
    capture_ids: Sequence[int],
    segments: SegmentTable,
) -> Terminals:
    """Use the segments and symbols of a learned database as terminals."""
    poses = make_poses(takes)
    rows = [np.flatnonzero(segments.capture_ids == number) for number in capture_ids]
    for number, (take_rows, take) in enumerate(zip(rows, takes, strict=True)):
        tiles = np.concatenate([[0], segments.ends[take_rows]])
        if not (len(take_rows) and (tiles[:-1] == segments.starts[take_rows]).all()) or (
            tiles[-1] != take.n_frames
        ):
            raise GrammarError(
                f"take {number + 1}: expected segments that tile its {take.n_frames} frames, found "
                f"{len(take_rows)} up to frame {tiles[-1]}. Run `motiondb learn` again."
            )
    order = np.concatenate(rows)
    offsets = np.repeat(poses.bounds[:-1], [len(take_rows) for take_rows in rows])
    cuts = np.append(offsets + segments.starts[order], poses.n_frames)
    used, labels = np.unique(segments.symbols[order], return_inverse=True)
    medoids = np.array([_middle(poses, cuts, labels == k) for k in range(len(used))])
    grouping = tuning.Grouping(cuts, labels.astype(np.int64), medoids)
    return as_terminals(poses, grouping, REPETITION_WEIGHT, [f"s{symbol}" for symbol in used])


def terminal_names(n: int) -> tuple[str, ...]:
    """Return n names: a to z, then aa, ab, ...

    >>> terminal_names(28)[-3:]
    ('z', 'aa', 'ab')
    """
    names: list[str] = []
    length = 1
    while len(names) < n:
        names += ["".join(letters) for letters in product(ascii_lowercase, repeat=length)]
        length += 1
    return tuple(names[:n])


def _silent(_done: int, _total: int, _text: str) -> None:
    pass


def cut_costs(poses: Poses, settings: TerminalSettings) -> Costs:
    """Return the costs of segments, distances and cuts, as parts of 1 / F."""
    n_frames = poses.n_frames
    weight = (1.0 - settings.weight) / (n_frames * poses.largest) if poses.largest > 0.0 else 0.0
    mean = float(np.linalg.norm(poses.values - poses.values.mean(axis=0), axis=1).mean())
    pace = np.append(poses.speeds / max(float(poses.speeds.mean()), 1e-12), 0.0)
    pace[poses.bounds] = 0.0
    rest = weight * mean * (settings.segment_price + settings.rest * pace)
    fixed = np.zeros(n_frames + 1, dtype=bool)
    fixed[poses.bounds] = True
    price = settings.weight / n_frames
    return Costs(poses.values, fixed, rest, price, weight, settings.shortest)


def _search(
    poses: Poses,
    costs: Costs,
    n_terminals: int,
    settings: TerminalSettings,
    rng: np.random.Generator,
    advance: Callable[[float], None],
) -> list[tuning.Grouping]:
    thin = candidates.thinned(poses, COARSE_STEP)
    cuts = candidates.candidate_cuts(
        thin, settings.grid // COARSE_STEP, -(-settings.shortest // COARSE_STEP)
    )
    frames = candidates.unthinned(cuts, thin, poses, COARSE_STEP)
    cells = candidates.make_cells(cuts, frames, thin.bounds, settings.shortest, settings.longest)
    _check_room(cells, n_terminals, settings)
    unit = COARSE_STEP * costs.weight if costs.weight > 0.0 else 1.0
    task = exchange.Task(
        thin, cells, costs.rest[frames] / unit, COARSE_STEP * costs.price / unit, n_terminals
    )
    trials = trials_for(len(cells.firsts)) if settings.n_trials is None else settings.n_trials

    def advance_half(share: float) -> None:
        advance(share / 2.0)

    n_starts = settings.n_starts
    states = exchange.exchange_search(task, rng, n_starts, trials, advance_half)[:TUNED]
    groupings = []
    for number, state in enumerate((divide(task, one) for one in states), start=1):
        path = _path_within(task, state, n_terminals, settings.most_segments)
        bounds = np.append(frames[cells.firsts[path]], poses.n_frames)
        medoids = exchange.path_medoids(task, state, path)
        groupings.append(_grouped(bounds, costs, n_terminals, medoids))
        advance((1.0 + number / len(states)) / 2.0)
    return groupings


def _check_room(cells: candidates.Cells, n_terminals: int, settings: TerminalSettings) -> None:
    """Check that the takes can be cut into at least K and at most N segments."""
    ones, free = np.ones(len(cells.firsts)), np.zeros(len(cells.cuts))
    most = len(candidates.cheapest_path(cells, -ones, free)[1])
    least = len(candidates.cheapest_path(cells, ones, free)[1])
    if most < n_terminals:
        raise GrammarError(
            f"terminals: expected takes long enough for {n_terminals} terminals, found "
            f"{most} segments of {settings.shortest} frames or more at most. "
            "Ask for fewer terminals, or add captures."
        )
    if settings.most_segments is not None and least > settings.most_segments:
        raise GrammarError(
            f"terminals: expected at least {least} segments (none longer than {settings.longest} "
            f"frames or across takes), found at most {settings.most_segments} allowed. "
            "Allow more segments, or longer ones."
        )


def _path_within(
    task: exchange.Task, state: exchange.State, fewest: int, most: int | None
) -> IntArray:
    """Return the path of the state, or the cheapest with K to N segments."""
    if len(state.path) >= fewest and (most is None or len(state.path) <= most):
        return state.path
    return candidates.bounded_path(task.cells, state.least, task.cut_costs, fewest, most)


def _grouped(
    cuts: IntArray, costs: Costs, n_groups: int, initial: IntArray | None
) -> tuning.Grouping:
    """Return the groups of the largest F for given cuts."""
    starts, ends = cuts[:-1], cuts[1:]
    lengths = ends - starts
    distances = segment_distances(costs.values, starts, ends)
    medoids, labels = group_by_medoids(
        distances,
        n_groups,
        weights=costs.weight * lengths,
        prices=costs.price * lengths,
        initial=initial,
    )
    return tuning.Grouping(cuts, labels, medoids)


def _middle(poses: Poses, cuts: IntArray, in_group: BoolArray) -> int:
    """Return the segment with the least distance to all of a group, weighted by frames."""
    members = np.flatnonzero(in_group)
    starts, ends = cuts[members], cuts[members + 1]
    distances = segment_distances(poses.values, starts, ends)
    return int(members[int(np.argmin((ends - starts) @ distances))])


def as_terminals(
    poses: Poses, grouping: tuning.Grouping, weight: float, names: Sequence[str] | None = None
) -> Terminals:
    """Return the record; terminals without names are named in order of first appearance."""
    starts, ends = grouping.cuts[:-1], grouping.cuts[1:]
    to_medoid = np.empty(len(starts))
    for k, m in enumerate(grouping.medoids):
        some = np.flatnonzero(grouping.labels == k)
        to_medoid[some] = distances_to(poses.values, starts[m], ends[m], starts[some], ends[some])
    scored = score(ends - starts, grouping.medoids, to_medoid, poses.largest, weight)
    n_groups = len(grouping.medoids)
    first = np.array([int(np.argmax(grouping.labels == k)) for k in range(n_groups)])
    order = np.argsort(first) if names is None else np.arange(n_groups)
    rank = np.argsort(order)
    takes = np.searchsorted(poses.bounds, starts, side="right") - 1
    return Terminals(
        names=terminal_names(n_groups) if names is None else tuple(names),
        takes=takes,
        starts=starts - poses.bounds[takes],
        ends=ends - poses.bounds[takes],
        labels=rank[grouping.labels],
        medoids=grouping.medoids[order],
        objective=scored.objective,
    )
