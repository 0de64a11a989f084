"""Search by words, and the words of a motion over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from motiondb.errors import QueryError
from motiondb.learning.learned import Learned
from motiondb.learning.recognition import decode, recognise
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import MOTION_FPS, Match, Motion
from motiondb.search import alignment, by_words, certainty, reasons
from motiondb.search.by_words import WINDOW_MARGIN
from motiondb.words import decoding, vocabulary
from motiondb.words.nearby.taking import Taking


@dataclass(frozen=True, eq=False)
class WordAnswer:
    """Matches of a question in words, and how the question was understood.

    Attributes
    ----------
    matches : tuple of Match
        Best first.
    unknown : dict
        Word of the question that is not known -> nearest known words.
    actions : tuple of tuple of str
        Known words of every action; () stands for any action.
    decoding : Decoding or None
        Decoded symbols of a search by symbols; None where no sequence was found.
    reasons : tuple
        Per match what every asked word adds to its log-odds; ``search.reasons.total`` of them is
        the number that ranks the match, and ``score`` its logistic function.
    strength : float or None
        Of the best match: nats by which the action that it shows least clearly is likelier than
        usual for the words asked.
    threshold : float or None
        Strength below which nothing in the database matches; None where it could not be learned
        (``search.certainty``).
    taken : dict
        Word that no caption holds -> what it was taken as; its words follow the vocabulary in
        ``reasons``, in this order.
    suggested : dict
        Word that no caption holds -> what is made of it where it was not taken.
    """

    matches: tuple[Match, ...]
    unknown: Mapping[str, tuple[str, ...]]
    actions: tuple[tuple[str, ...], ...]
    decoding: decoding.Decoding | None = None
    reasons: tuple[tuple[reasons.WordReason, ...], ...] = ()
    strength: float | None = None
    threshold: float | None = None
    taken: Mapping[str, Taking] = field(default_factory=dict)
    suggested: Mapping[str, Taking] = field(default_factory=dict)

    @property
    def matches_anything(self) -> bool | None:
        """Whether anything in the database shows what was asked; None where this is not known."""
        return reaches(self.matches, self.strength, self.threshold)


def reaches(
    matches: Sequence[Match], strength: float | None, threshold: float | None
) -> bool | None:
    """Whether a best match is good enough; None where no threshold was learned."""
    if not matches:
        return False
    return None if strength is None or threshold is None else strength >= threshold


def search_words(
    learned: Learned,
    text: str,
    allowed: Sequence[int],
    limit: int = 10,
    by_symbols: bool = False,
    written: bool = True,
) -> WordAnswer:
    """The intervals that show what a text asks for, best first.

    Parameters
    ----------
    learned : Learned
        What was learned.
    text : str
        The question.
    allowed : sequence of int
        Numbers of the captures to search; those without segments are left out.
    limit : int
        Largest number of matches.
    by_symbols : bool
        Decode the words to symbols and align these with the captures, as in paper A.
    written : bool
        Whether captions count as evidence beside the motion.

    Raises
    ------
    QueryError
        When the text is empty or no word of it is known.
    NotLearnedError
        When no words were learned.
    """
    allowed = [capture for capture in allowed if capture in learned.rows]
    if not text.strip():
        raise QueryError("search: expected words, found an empty question. Say what to look for.")
    query = vocabulary.parse_query(text, learned.known_words, learned.synonyms, learned.lemmas)
    if by_symbols:
        return _search_decoded(learned, query, allowed, limit)
    number = learned.word_numbers
    actions = [[number[w] for w in action] for action in query.actions]
    takes = learned.takes if written else learned.seen_takes
    hits = []
    for capture in allowed:
        hit = by_words.search_take(takes[capture], actions)
        if hit is not None:
            hits.append((capture, hit))
    hits.sort(key=lambda pair: (-pair[1].log_odds, pair[0]))
    explained = [
        (capture, hit, explain_hit(learned, capture, hit, actions, written))
        for capture, hit in hits[:limit]
    ]
    explained.sort(key=lambda found: (-reasons.total(found[2]), found[0]))
    matches = tuple(
        Match(
            rank,
            learned.captures[capture].name,
            *to_seconds(learned, capture, hit.start, hit.end),
            float(1.0 / (1.0 + np.exp(-reasons.total(why)))),
            _matched(takes[capture], query.actions, number),
            _reason(hit, query.actions) + mark_generated(learned, capture, "; "),
            _word_chance(learned, why),
        )
        for rank, (capture, hit, why) in enumerate(explained, start=1)
    )
    why = tuple(why for _, _, why in explained)
    sure = learned.word_certainty
    return WordAnswer(
        matches, query.unknown, query.actions, reasons=why,
        strength=max((_strength(learned, each) for each in why), default=None),
        threshold=None if sure is None or np.isnan(sure.threshold) else sure.threshold,
    )  # fmt: skip


def with_takings(answer: WordAnswer, takings: Mapping[str, Taking]) -> WordAnswer:
    """An answer in which some words were taken as others, with what that takes off its certainty.

    The probability of every match is multiplied by that of every taking.

    Parameters
    ----------
    answer : WordAnswer
        Found with the taken words in the vocabulary (``learning.taken_words``).
    takings : mapping of str to Taking
        What is made of every word that no caption holds.
    """
    taken = {word: taking for word, taking in takings.items() if taking.is_taken}
    share = float(np.prod([taking.probability for taking in taken.values()]))
    matches = tuple(
        match if match.probability is None
        else replace(match, probability=share * match.probability)
        for match in answer.matches
    )  # fmt: skip
    suggested = {word: taking for word, taking in takings.items() if not taking.is_taken}
    unknown = {
        word: tuple(w for w, _ in suggested[word].words) or suggested[word].spelling
        if word in suggested
        else near
        for word, near in answer.unknown.items()
    }
    return replace(answer, matches=matches, unknown=unknown, taken=taken, suggested=suggested)


def _word_chance(learned: Learned, why: Sequence[reasons.WordReason]) -> float | None:
    """Calibrated probability that a match shows all actions, the product of theirs."""
    sure = learned.word_certainty
    if sure is None:
        return None
    chance = 1.0
    for log_odds, said in reasons.by_action(why):
        heard = float(sure.log_odds(np.array([log_odds - said])))
        chance *= float(certainty.probability(heard + said))
    return chance


def _strength(learned: Learned, why: Sequence[reasons.WordReason]) -> float:
    """Nats by which the action that a match shows least clearly is likelier than usual."""
    usual = certainty.usual(learned.word_map)
    asked = sorted({w.action for w in why})
    each = [float(np.mean([usual[w.word] for w in why if w.action == a])) for a in asked]
    return min(odds - level for (odds, _), level in zip(reasons.by_action(why), each))


def explain_hit(
    learned: Learned,
    capture: int,
    hit: by_words.Hit,
    actions: Sequence[Sequence[int]],
    written: bool = True,
) -> tuple[reasons.WordReason, ...]:
    """What every asked word adds to an answer, segment by segment (see ``search.reasons``).

    Parameters
    ----------
    learned : Learned
        What was learned.
    capture : int
        Number of the capture.
    hit : Hit
        The answer.
    actions : sequence of sequence of int
        Word numbers of every action.
    written : bool
        Whether captions count as evidence beside the motion.
    """
    rows = learned.rows[capture]
    table = learned.segments
    starts, ends = table.starts[rows], table.ends[rows]
    said = learned.written.get(capture) if written else None
    n_asked = sum(bool(words) for words in actions)
    why = []
    for number, words in enumerate(actions):
        peak = int(np.searchsorted(starts, hit.peaks[number], side="right")) - 1
        window = (int(starts[peak]) - WINDOW_MARGIN, int(ends[peak]) + WINDOW_MARGIN)
        for word in words:
            slope, constant = learned.word_map.linear(word)
            evidence = reasons.Evidence(
                constant, slope, learned.standardised[rows], starts, ends, table.symbols[rows],
                np.zeros(len(starts)) if said is None else said[:, word],
            )  # fmt: skip
            weight = 1.0 / (n_asked * len(words))
            why.append(reasons.explain_word(evidence, word, number, window, peak, weight))
    return tuple(why)


def _search_decoded(
    learned: Learned, query: vocabulary.ParsedQuery, allowed: Sequence[int], limit: int
) -> WordAnswer:
    decoded = decode(learned, query.words)
    if decoded is None:
        return WordAnswer((), query.unknown, query.actions, None)
    symbols = np.array(decoded.symbols)
    weights = np.full(len(symbols), 1.0 / len(symbols))
    scale = alignment.distance_scale(learned.distances)
    found = []
    for capture in allowed:
        rows = learned.rows[capture]
        score, first, last = alignment.align(
            symbols, weights, learned.segments.symbols[rows], learned.distances, scale
        )
        if last > first:
            start = int(learned.segments.starts[rows][first])
            found.append((score, capture, start, int(learned.segments.ends[rows][last - 1])))
    found.sort(key=lambda hit: (-hit[0], hit[1]))
    number = learned.word_numbers
    occurs = any(np.isclose(hit[0], 1.0) for hit in found)
    note = "" if occurs else "; this sequence of symbols never occurred, the nearest are given"
    matches = tuple(
        Match(
            rank,
            learned.captures[capture].name,
            *to_seconds(learned, capture, start, end),
            float(score),
            _matched(learned.takes[capture], query.actions, number),
            f"symbols {' '.join(str(s) for s in decoded.symbols)}{note}"
            + mark_generated(learned, capture, "; "),
        )
        for rank, (score, capture, start, end) in enumerate(found[:limit], start=1)
    )
    return WordAnswer(matches, query.unknown, query.actions, decoded)


@dataclass(frozen=True)
class Description:
    """What an interval of a motion shows.

    Attributes
    ----------
    start, end : float
        Seconds.
    words : tuple of (str, float)
        Words with their probabilities, most probable first.
    symbols : tuple of int
        Symbols of the interval's segments.
    """

    start: float
    end: float
    words: tuple[tuple[str, float], ...]
    symbols: tuple[int, ...] = ()


def describe(learned: Learned, motion: Motion, n_words: int = 5) -> tuple[Description, ...]:
    """The words of a motion over time; neighbours with the same likeliest words become one."""
    seen = recognise(learned, motion)
    starts, ends, symbols = seen.starts, seen.ends, seen.symbols
    probabilities = learned.word_map.probabilities(seen.window_vectors()) * learned.is_known()
    groups: list[list[int]] = []
    for n, row in enumerate(probabilities):
        likeliest = set(np.argsort(-row)[:2])
        if groups and set(np.argsort(-probabilities[groups[-1]].mean(axis=0))[:2]) == likeliest:
            groups[-1].append(n)
        else:
            groups.append([n])
    seconds = FEATURE_STEP / MOTION_FPS
    answers = []
    for group in groups:
        mean = np.average(probabilities[group], axis=0, weights=(ends - starts)[group])
        order = [w for w in np.argsort(-mean, kind="stable")[:n_words] if mean[w] > 0.0]
        answers.append(
            Description(
                round(float(starts[group[0]]) * seconds, 3),
                round(min(float(ends[group[-1]]) * seconds, motion.n_frames / MOTION_FPS), 3),
                tuple((learned.association.words[w], float(mean[w])) for w in order),
                tuple(int(s) for s in symbols[group]),
            )
        )
    return tuple(answers)


def to_seconds(learned: Learned, capture: int, start: int, end: int) -> tuple[float, float]:
    """An interval of a capture in seconds, from frames [start, end) at 30 a second."""
    duration = learned.captures[capture].duration
    low = round(start / MOTION_FPS, 3)
    return min(low, duration), round(min(end / MOTION_FPS, duration), 3)


def _matched(
    take: by_words.TakeScores, actions: Sequence[Sequence[str]], number: Mapping[str, int]
) -> tuple[str, ...]:
    """Asked words that are likelier than not in the capture."""
    asked = dict.fromkeys(word for action in actions for word in action)
    top = np.maximum(take.windows.max(axis=0), take.whole)
    return tuple(word for word in asked if top[number[word]] > 0.0)


def mark_generated(learned: Learned, capture: int, before: str = "") -> str:
    """The word "generated" for a generated capture, otherwise nothing."""
    return f"{before}generated" if learned.captures[capture].kind == "generated" else ""


def _reason(hit: by_words.Hit, actions: Sequence[Sequence[str]]) -> str:
    return "; ".join(
        f"{' '.join(words) or '?'} {start / MOTION_FPS:.2f}-{end / MOTION_FPS:.2f} s"
        for words, (start, end) in zip(actions, hit.parts)
    )
