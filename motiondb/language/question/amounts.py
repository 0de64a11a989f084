"""How often and how long: numbers in digits or words, counts, durations, other measures.

An amount is a pair (least, most), most None if there is no upper limit:

    "three times", "3x", "thrice"    (3, 3)        "for half a minute"    (30, 30)
    "at least twice", "twice or more" (2, None)     "at least 5 s"         (5, None)
    "more than twice"                (3, None)     "longer than 5 s"      (5, None)
    "at most 3 times"                (0, 3)        "for up to 2 seconds"  (0, 2)
    "two or three times"             (2, 3)        "5 to 10 s"            (5, 10)
    "several times", "repeatedly"    (2, None)

Angles, ways, speeds and numbers of steps are amounts with a measure (:class:`Measure`).

"About five seconds" is five seconds. How an action is done is said by the adjective of an adverb
in -ly (happily: happy, gently: gentle). The caption words for it are searched among the adjective,
the adverb and, for speed, the words of the same meaning.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from motiondb.language.lemmas import FORMS

_ONES_TEXT = """
zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen
sixteen seventeen eighteen nineteen
"""
_TENS_TEXT = "twenty thirty forty fifty sixty seventy eighty ninety"
_ONES, _TENS = _ONES_TEXT.split(), _TENS_TEXT.split()
_NUMBERS = {word: n for n, word in enumerate(_ONES)} | {
    word: 10 * n for n, word in enumerate(_TENS, start=2)
}  # Value of each number word
_BELOW_HUNDRED = (
    rf"(?:(?:{'|'.join(_TENS)})(?:[ -](?:{'|'.join(_ONES[1:10])}))?"
    rf"|(?:{'|'.join(sorted(_ONES, key=len, reverse=True))}))"
)
NUMBER = (
    r"(?:(?<![\d.])[0-9]{1,6}(?:[.,][0-9]{1,6})?(?!\d)"
    rf"|\b(?:(?:a|{'|'.join(_ONES[1:10])})[ -]hundred(?:(?:\s+and)?[\s-]+{_BELOW_HUNDRED})?"
    rf"|{_BELOW_HUNDRED})\b)"
)  # Pattern of a number of at most six digits, or in words below a thousand

FEW = rf"(?:[0-9]{{1,4}}(?:[.,][0-9]{{1,2}})?|{'|'.join(_ONES[1:])})"
"""Pattern of a number in digits, or in words below twenty: of seconds of a take."""

_HALVES = (
    rf"(?:{NUMBER}\ and\ a\ half|{NUMBER}\ 1/2|(?:one|a)?\ ?half(?:\ of)?(?:\ an?)?"
    rf"|(?:a\ )?quarter\ of\ an?|three\ quarters\ of\ an?)"
)
_AT_LEAST = (
    r"at\ least|(?:no|not)\ less\ than|no\ fewer\ than|a\ minimum\ of|minimum(?:\ of)?"
    r"|(?:more|longer|faster|higher|further|farther|greater)\ than|over"
)
_AT_MOST = (
    r"at\ most|(?:no|not)\ (?:more|longer|faster|higher|further|farther)\ than"
    r"|a\ maximum\ of|maximum(?:\ of)?|up\ to|within"
    r"|(?:less|fewer|shorter|slower|lower)\ than|under"
)
_CLEARLY_AT_MOST = r"at\ most|(?:no|not)\ (?:more|longer)\ than|less\ than|shorter\ than|within"
"""Also without "for": others are directions, as in "walk up to a second person"."""
_ABOUT = r"about|around|approximately|approx\.?|roughly|almost|nearly|exactly|precisely|some"
_LIMIT = rf"(?:(?P<more>{_AT_LEAST})|(?P<fewer>{_AT_MOST})|{_ABOUT})"
_COUNT_LIMIT = _LIMIT.replace("|around", "")  # "turn around twice" is not to turn about twice
_RANGE = r"\s?(?:to|or|-|–|and)\s?"
_UNIT = (
    r"(?P<unit>milliseconds?|msecs?|ms|seconds?|secs?|s|minutes?|mins?|min|hours?|hrs?|h)"
    r"(?![\w'])\.?(?!\w)"
)
_MORE = r"(?:\s+or\s+(?:(?P<plus>more|longer|further|farther|faster|higher)"
_MORE += r"|(?P<minus>less|fewer|shorter|slower)))?"

_DURATION_PATTERN = rf"""
    (?:\b(?:for|lasting|lasts|between|from|during)\s+)?
    (?:\b(?:{_LIMIT})\s+)?
    (?:(?P<half>(?!half\ as\b){_HALVES})|(?P<low>{NUMBER})(?:{_RANGE}(?P<high>{NUMBER}))?)
    [\s-]*{_UNIT}{_MORE}(?:\s+long\b)?
    |\b(?:for|lasting|lasts)\s+(?:{_ABOUT}\s+)?(?P<one>an?)\s+(?P<one_unit>second|minute|hour)\b
    |\b(?:{_AT_LEAST})\s+(?P<least_one>an?)\s+(?P<least_unit>second|minute|hour)\b
    |\b(?:(?:for|lasting|lasts|in)\s+(?:{_AT_MOST})|{_CLEARLY_AT_MOST})
     \s+an?\s+(?P<most_unit>second|minute|hour)\b
"""

_TIMES = r"(?:times\b(?!\s+as\b)|×|x(?![\w]))"
_COUNT_PATTERN = rf"""
    (?:\b(?:{_COUNT_LIMIT})\s+)?
    (?:(?P<adverb>\b(?:once|twice|thrice)\b)(?:\s+or\s+(?P<adverb2>twice|thrice|three\s+times))?
      |(?P<low>{NUMBER})(?:{_RANGE}(?P<high>{NUMBER}))?\s?
       (?:{_TIMES}|(?:repetitions|repetition|reps|rep|repeats)\b(?:\s+of\b)?
          |or\s+(?P<early>more|fewer|less)\s+times\b)
      |(?P<some>\b(?:a\s+few|several|a\s+couple\s+of|many|multiple|numerous|some)\s+
        (?:times|repetitions|reps|repeats)\b(?:\s+of\b)?))
    {_MORE}(?:\s+in\s+a\s+row\b)?
    |(?P<again>\brepeatedly\b|\b(?:over\s+and\s+over|again\s+and\s+again|time\s+and\s+again)\b
       (?:\s+again\b)?)
    |(?<!\w)[x×]\s?(?P<after>[0-9]{{1,6}})\b
"""

_TURNS = r"(?:turns?|spins?|rotations?|revolutions?)"
_TURNED = rf"(?:(?:left|right)\s+)?{_TURNS}"
_LENGTH = r"(?:(?:centi|kilo|milli)?met(?:er|re)s?|cm|mm|km|m|yards?|miles?|inch(?:es)?)"
_JUMPED = r"(?:jump|leap|hop|skip|walk|run|jog|sprint|dash|march|stroll|and|or|then|to|in|on|over)"
_MEASURE_PATTERN = rf"""
    (?P<before>\b(?:from|at|on|every|within)\s+(?:an?\s+)?)?
    (?:\b(?:by|through|for)\s+)?(?:\b(?:{_COUNT_LIMIT})\s+)?
    (?:(?:(?:in|along)\s+)?(?:(?P<turns>{NUMBER})\s+(?=full|whole|complete)|an?\s+|one\s+)?
        (?P<part>full|whole|complete|half|three[\s-]quarters?|quarter)
        (?:\s+(?:of\s+)?an?)?[\s-]+(?:circles?\b|(?={_TURNS}\b))
      |(?P<halves>{NUMBER})\s+and\s+a\s+half\s+(?={_TURNS}\b)
      |(?P<round>(?:90|270)(?=[\s-]+{_TURNED}\b)
          |(?:180|360|540|720)(?=[\s-]+{_TURNED}\b|\s*(?:[,.;]|$)|\s+(?:and|then|left|right)\b))
      |(?:between\s+(?P<from>{NUMBER})\s+and\s+(?P<till>{NUMBER})
          |(?P<one>an?)(?=\s+(?:(?:kilo)?met(?:er|re)|mile|yard|inch))
          |(?P<low>{NUMBER})(?:\s?(?:to|or|-|–)\s?(?P<high>{NUMBER}))?)
       (?:\s+or\s+(?P<early>more|fewer|less))?[\s-]*
       (?P<unit>{_LENGTH}(?:\s*/\s*|\s+(?:per|an?)\s+)(?:seconds?|sec|s|hours?|h)\b|kph\b|mph\b
          |steps?\b(?:\s+(?:per|an?)\s+(?:second|minute)\b)?|degrees?\b|°|º|deg\b
          |{_LENGTH}(?![\w/])|feet(?=\ (?:high|long|far|up)\b)|%|percent\b|bpm\b|fps\b))
    {_MORE}
    (?P<thing>\s+(?:tall|wide|deep|thick|(?:high|long)(?=\s+(?!{_JUMPED})[^\W\d_]))\b
       |(?=\s+(?:away|behind|apart|above|below|from|in\s+front)\b))?
"""
_OF_TURNS = {"half": 180.0, "quarter": 90.0}  # Parts of a turn, degrees; others are whole
_LENGTHS = {"cm": 0.01, "centi": 0.01, "mm": 0.001, "milli": 0.001, "km": 1e3, "kilo": 1e3}
_LENGTHS |= {"mile": 1609.344, "m": 1.0, "yard": 0.9144, "inch": 0.0254, "feet": 0.3048}
"""The beginning of a unit of length -> its size, m; the first that fits counts."""

_DURATION = re.compile(_DURATION_PATTERN, re.VERBOSE | re.IGNORECASE)
_COUNT = re.compile(_COUNT_PATTERN, re.VERBOSE | re.IGNORECASE)
_NUMBER = re.compile(
    r"(?:(?:(?P<more>at least|no fewer than|more than)"
    r"|(?P<fewer>at most|no more than|fewer than|less than)|exactly) )?"
    rf"(?:(?:between (?P<from>{NUMBER}) and (?P<till>{NUMBER})"
    rf"|(?P<number>{NUMBER})(?:{_RANGE.replace('|and', '')}(?P<high>{NUMBER}))?)"
    r"(?: or (?P<plus>more))?"
    r"|(?:a\s+|one\s+)?single(?=\s))",
    re.IGNORECASE,
)
_MEASURE = re.compile(_MEASURE_PATTERN, re.VERBOSE | re.IGNORECASE)


def to_number(text: str) -> float:
    """A number from digits or words.

    >>> to_number("2,5"), to_number("twenty-five"), to_number("a hundred")
    (2.5, 25.0, 100.0)
    >>> to_number("twenty-one"), to_number("1,000"), to_number("one hundred and eighty")
    (21.0, 1000.0, 180.0)
    """
    text = text.lower().strip(" -")
    if re.fullmatch(r"[1-9]\d{0,2},\d{3}", text):  # a comma before three digits parts thousands
        return float(text.replace(",", ""))
    if text[0].isdigit():
        return float(text.replace(",", "."))
    if "hundred" in text:
        hundreds, _, rest = re.sub(r"\band\b", "", text).partition("hundred")
        most = to_number(rest) if rest.strip(" -") else 0.0
        return 100.0 * (_NUMBERS.get(hundreds.strip(" -"), 1)) + most
    return float(sum(_NUMBERS[word] for word in re.split(r"[\s-]+", text)))


def match_duration(text: str, place: int = 0) -> tuple[int, float, float | None] | None:
    """End of the duration at a position, with its least and most seconds.

    >>> match_duration("for half a minute"), match_duration("at least 5 s")
    ((17, 30.0, 30.0), (12, 5.0, None))
    >>> match_duration("2 to 4 seconds"), match_duration("under 1.5 min")
    ((14, 2.0, 4.0), (13, 0.0, 90.0))
    >>> match_duration("for up to a second"), match_duration("up to a second")
    ((18, 0.0, 1.0), None)
    """
    match = _DURATION.match(text, place)
    if match is None:
        return None
    if match["one"] or match["least_one"]:
        seconds = _unit_seconds(match["one_unit"] or match["least_unit"])
        return match.end(), seconds, None if match["least_one"] else seconds
    if match["most_unit"]:
        return match.end(), 0.0, _unit_seconds(match["most_unit"])
    seconds = _unit_seconds(match["unit"])
    if match["half"]:
        low = high = _fraction(match["half"]) * seconds
    else:
        low = to_number(match["low"]) * seconds
        high = to_number(match["high"]) * seconds if match["high"] else low
    low, high = min(low, high), max(low, high)
    if match["more"] or match["plus"]:
        return match.end(), low, None
    return match.end(), 0.0 if match["fewer"] or match["minus"] else low, high


def match_count(text: str, place: int = 0) -> tuple[int, int, int | None] | None:
    """End of the count at a position, with the least and most repeats.

    >>> match_count("three times"), match_count("at least twice"), match_count("over 2 times")
    ((11, 3, 3), (14, 2, None), (12, 3, None))
    >>> match_count("two or three times"), match_count("fewer than 3x"), match_count("repeatedly")
    ((18, 2, 3), (13, 0, 2), (10, 2, None))
    """
    match = _COUNT.match(text, place)
    return None if match is None else (match.end(), *_repeats(match))


@dataclass(frozen=True)
class Measure:
    """How far, how fast or by which angle: from ``least`` to ``most`` (None: no upper limit)."""

    what: str  # "angle" (degrees), "way" (m), "speed" (m/s) or "steps"; "" for what is not measured
    least: float
    most: float | None

    def say(self) -> str:
        """The amount, as a question says it.

        >>> Measure("angle", 90, 90).say(), Measure("way", 0.0, 1.5).say()
        ('90 degrees', 'at most 1.5 m')
        >>> Measure("steps", 3, None).say(), Measure("speed", 1, 1).say()
        ('at least 3 steps', '1 m/s')
        """
        unit = {"angle": "degrees", "way": "m", "speed": "m/s"}.get(self.what, self.what)
        low = f"{self.least:.10g}"
        if self.most is None:
            return f"at least {low} {unit}"
        one = unit.removesuffix("s") if unit.isalpha() else unit  # "1 step", but "1 m/s"
        high = f"{self.most:.10g} {one if self.most == 1 else unit}"
        if self.least == self.most:
            return high
        return f"{low} to {high}" if self.least else f"at most {high}"


def match_measure(text: str, place: int = 0) -> tuple[int, Measure] | None:
    """End of the angle, length or speed at a position, and what it measures.

    >>> match_measure("90-degree turn")
    (9, Measure(what='angle', least=90.0, most=90.0))
    >>> match_measure("at least 20 cm"), match_measure("2 hops")
    ((14, Measure(what='way', least=0.2, most=None)), None)
    >>> match_measure("half a turn")[1].say(), match_measure("100 bpm")[1].what
    ('180 degrees', '')
    """
    match = _MEASURE.match(text, place)
    if match is None:
        return None
    what, size = _unit(match["unit"].lower()) if match["unit"] else ("angle", 1.0)
    low, high = sorted(round(size * amount, 6) for amount in _amounts(match))
    if what == "steps":  # whole ones: more than three are four
        low += bool(re.match("more|over", match["more"] or "", re.IGNORECASE))
        high -= bool(re.match("less|fewer|under", match["fewer"] or "", re.IGNORECASE))
    elif match["thing"] is not None or (match["before"] and what != "speed"):
        what = ""
    early = (match["early"] or "").lower()
    more = match["more"] or match["plus"] or early == "more"
    fewer = match["fewer"] or match["minus"] or early in ("fewer", "less")
    return match.end(), Measure(what, 0.0 if fewer else low, None if more else high)


def _amounts(match: re.Match[str]) -> tuple[float, float]:
    """The two limits of a measure, in its unit; parts of turns in degrees."""
    if match["part"]:
        part = re.split(r"[\s-]", match["part"].lower())[0]
        turn = 270.0 if part == "three" else _OF_TURNS.get(part, 360.0)
        return (turn * to_number(match["turns"] or "1"),) * 2
    if match["halves"]:
        return (360.0 * (to_number(match["halves"]) + 0.5),) * 2
    low = match["round"] or match["low"] or match["from"] or "1"
    return to_number(low), to_number(match["high"] or match["till"] or low)


def _unit(text: str) -> tuple[str, float]:
    """What a unit measures, and its size in m, m/s, degrees or steps; "" for others.

    >>> _unit("metres per second"), _unit("km/h"), _unit("degrees"), _unit("fps")
    (('speed', 1.0), ('speed', 0.2777777777777778), ('angle', 1.0), ('', 1.0))
    """
    text = {"kph": "km/h", "mph": "miles/h"}.get(text, text)
    name, *time = re.split(r"\s*/\s*|\s+(?:per|an?)\s+", text)
    if name.startswith("step"):
        return ("", 1.0) if time else ("steps", 1.0)
    if name.startswith(("deg", "°", "º")):
        return "angle", 1.0
    size = next((size for start, size in _LENGTHS.items() if name.startswith(start)), 0.0)
    if not size:
        return "", 1.0
    return ("speed", size / (3600.0 if time[0].startswith("h") else 1.0)) if time else ("way", size)


_EITHER_AMOUNT = re.compile(
    rf"({NUMBER})\s+or\s+({NUMBER})([\s-]*(?:degrees?\b|°|{_LENGTH}(?![\w/])))", re.IGNORECASE
)
_SOME_UNIT = (
    rf"(?:degrees?\b|°|{_LENGTH}(?:\s*/\s*[sh]\b)?(?![\w/])|steps?\b|times\b"
    rf"|{_UNIT.replace('?P<unit>', '?:')})"
)
_BOTH_LIMITS = re.compile(
    rf"\b(?P<least>{_AT_LEAST})\s+(?P<low>{NUMBER})(?P<own>\s*{_SOME_UNIT})?"
    rf"\s*,?\s*(?:and|but)\s+(?P<most>{_AT_MOST})\s+(?P<high>{NUMBER})"
    rf"(?P<unit>[\s-]*{_SOME_UNIT})",
    re.VERBOSE | re.IGNORECASE,
)
_HALF_UNITS = tuple(
    re.compile(rf"\b{said}", re.IGNORECASE)
    for said in (
        rf"(?P<n>an?|{NUMBER})\s+(?P<unit>{_LENGTH})\s+and\s+a\s+half\b",
        rf"(?P<n>{NUMBER})\s+and\s+a\s+half\s+(?P<unit>{_LENGTH})(?![\w/])",
        rf"(?:(?:an?|one)\s+)?half(?:\s+(?:of\s+)?an?)?[\s-]+(?P<unit>{_LENGTH})(?![\w/])",
    )
)


def spread_amounts(text: str) -> str:
    """A text in which each of two amounts has its unit, unless they are next to one another.

    A lower and an upper limit become one amount.

    >>> spread_amounts("turn 90 or 180 degrees"), spread_amounts("walk two or three steps")
    ('turn 90 degrees or 180 degrees', 'walk two or three steps')
    >>> spread_amounts("more than 3 but less than 5 m"), spread_amounts("two and a half meters")
    ('3 to 5 m', '2.5 meters')
    >>> spread_amounts("more than 2 but fewer than 5 steps"), spread_amounts("half a meter")
    ('3 to 4 steps', '0.5 meter')
    """

    def each(match: re.Match[str]) -> str:
        one, other, unit = match.groups()
        near = abs(to_number(other) - to_number(one)) <= 1.0
        return match.group() if near else f"{one}{unit} or {other}{unit}"

    def half(match: re.Match[str]) -> str:
        whole = match.groupdict().get("n", "0").lower()
        number = 1.0 if whole in ("a", "an") else to_number(whole)
        return f"{number + 0.5:g} {match['unit']}"

    for pattern in _HALF_UNITS:
        text = pattern.sub(half, text)
    return _EITHER_AMOUNT.sub(each, _BOTH_LIMITS.sub(_between, text))


def _between(match: re.Match[str]) -> str:
    """Two limits as one amount, unless they are of two measures: "more than 5 s but ... 2 m"."""
    low, high, unit = match["low"], match["high"], match["unit"].strip(" -")
    own = (match["own"] or unit).strip()
    if own != unit and not all(re.fullmatch(_LENGTH, each, re.IGNORECASE) for each in (own, unit)):
        return match[0]
    if own != unit:
        low = f"{to_number(low) * _unit(own.lower())[1] / _unit(unit.lower())[1]:.10g}"
    if unit.startswith(("step", "times")):  # whole ones: more than three are four
        low = f"{to_number(low) + match['least'].lower().startswith(('more', 'over')):g}"
        high = f"{to_number(high) - match['most'].lower().startswith(('less', 'fewer', 'under')):g}"
    return f"{low} to {high} {unit}"


def match_number(text: str, place: int = 0) -> tuple[int, float, float | None] | None:
    """End of the number at a position, with its least and its most.

    >>> match_number("twenty-five jumps"), match_number("jump")
    ((11, 25.0, 25.0), None)
    >>> match_number("at least three jumps"), match_number("fewer than 3 jumps")
    ((14, 3.0, None), (12, 0.0, 2.0))
    >>> match_number("two or three jumps"), match_number("a single jump")
    ((12, 2.0, 3.0), (8, 1.0, 1.0))
    >>> match_number("between 2 and 4 jumps"), match_number("two or more jumps")
    ((15, 2.0, 4.0), (11, 2.0, None))
    """
    match = _NUMBER.match(text, place)
    if match is None:
        return None
    number = to_number(match["number"] or match["from"] or "one")
    high = match["high"] or match["till"]
    high = to_number(high) if high else number
    more, fewer = (match["more"] or match["plus"] or "").lower(), (match["fewer"] or "").lower()
    if more:
        return match.end(), number + (more == "more than"), None
    if fewer:
        return match.end(), 0.0, max(high - (fewer in ("fewer than", "less than")), 0.0)
    return match.end(), number, high


def _repeats(match: re.Match[str]) -> tuple[int, int | None]:
    if match["again"] or match["some"]:
        return 2, None
    if match["after"]:
        low = high = int(match["after"])
    elif match["adverb"]:
        low = _ADVERBS[match["adverb"].lower()]
        high = _ADVERBS["".join(match["adverb2"].lower().split())] if match["adverb2"] else low
    else:
        low = round(to_number(match["low"]))
        high = round(to_number(match["high"])) if match["high"] else low
    low, high = min(low, high), max(low, high)
    more, fewer = (match["more"] or "").lower(), (match["fewer"] or "").lower()
    if more or match["plus"] or (match["early"] or "").lower() == "more":
        return low + (more in ("more than", "over")), None
    if fewer or match["minus"] or match["early"]:
        return 0, max(high - (fewer in ("less than", "fewer than", "under")), 0)
    return low, high


_ADVERBS = {"once": 1, "twice": 2, "thrice": 3, "threetimes": 3}
"""Number of times that an adverb says."""


def _unit_seconds(unit: str) -> float:
    unit = unit.lower()
    if unit.startswith("ms") or unit.startswith("mil"):
        return 0.001
    return {"s": 1.0, "m": 60.0, "h": 3600.0}[unit[0]]


def _fraction(text: str) -> float:
    """The value of "half a", "one and a half", "2 1/2", "three quarters of a"."""
    text = text.lower()
    for ending, more in ((" and a half", 0.5), (" 1/2", 0.5)):
        if text.endswith(ending):
            return to_number(text.removesuffix(ending)) + more
    if text.startswith("three"):
        return 0.75
    return 0.25 if "quarter" in text else 0.5


SPEEDS = (
    ("slow", "slowly"),
    ("fast", "quick", "quickly", "rapid", "rapidly", "brisk", "briskly", "speedy", "speedily"),
)  # Words of speed that mean the same, adjectives and adverbs
_SPEED_WORDS = frozenset(word for group in SPEEDS for word in group)
_NO_ADVERBS_TEXT = """
ally anomaly apply assembly belly bully butterfly comply curly daily doily dolly early elderly
family filly firefly fly folly friendly gully holly homely imply jelly jolly likely lily lonely
lovely lively monthly multiply only rally rely reply silly sly supply tally ugly weekly wobbly
woolly yearly
"""
_NO_ADVERBS = frozenset(_NO_ADVERBS_TEXT.split())  # Words in -ly that are not adverbs of manner
_LOST_LE = frozenset(("gent", "humb", "simp", "nimb", "subt", "doub", "trip", "amp"))
"""Stems of adverbs whose adjective ends in -le."""


def manner_of(word: str, base: str | None = None) -> str | None:
    """The adjective of a word that says how something is done, or None for any other word.

    >>> [manner_of(w) for w in ("slowly", "happily", "gently", "belly", "laterally")]
    ['slow', 'happy', 'gentle', None, None]
    >>> manner_of("faster", "fast")
    'fast'
    """
    word = word.lower()
    base = word if base is None else base
    if base in _SPEED_WORDS or not word.endswith("ly"):
        return _adjective(base) if base in _SPEED_WORDS else None
    if word in _NO_ADVERBS or word in FORMS or len(word) < 5:
        return None
    return _adjective(word)


def forms_of_manner(manner: str) -> tuple[str, ...]:
    """Words that captions may use for a manner, nearest first.

    >>> forms_of_manner("happy")
    ('happy', 'happily')
    >>> forms_of_manner("quick")[:4]
    ('quick', 'quickly', 'fast', 'rapid')
    """
    same = next((group for group in SPEEDS if manner in group), ())
    return tuple(dict.fromkeys((manner, adverb_of(manner), *same)))


def known_manner(manner: str, counts: Mapping[str, int]) -> str | None:
    """The word for a manner that most captions have; None if no caption has one.

    >>> known_manner("slow", {"slowly": 2, "slow": 5}), known_manner("angry", {"slow": 5})
    ('slow', None)
    """
    known = [word for word in forms_of_manner(manner) if counts.get(word, 0) > 0]
    return max(known, key=lambda word: counts[word]) if known else None


def _adjective(adverb: str) -> str:
    """The adjective of an adverb in -ly; any other word is one already."""
    if not adverb.endswith("ly"):
        return adverb
    stem = adverb[:-2]
    if stem.endswith("ical"):
        return stem[:-2]
    if stem.endswith("i"):
        return stem[:-1] + "y"
    return stem + "le" if stem in _LOST_LE else stem


def adverb_of(adjective: str) -> str:
    """The adverb of an adjective; an adverb in -ly is itself.

    >>> [adverb_of(word) for word in ("slow", "happy", "gentle", "energetic", "fast", "slowly")]
    ['slowly', 'happily', 'gently', 'energetically', 'fast', 'slowly']
    """
    if adjective == "fast" or adjective.endswith("ly"):
        return adjective
    if adjective.endswith("y"):
        return adjective[:-1] + "ily"
    if adjective.endswith("le"):
        return adjective[:-1] + "y"
    return adjective + ("ally" if adjective.endswith("ic") else "ly")
