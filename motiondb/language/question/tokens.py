"""From the text of a question to tokens: connectives, negations, amounts and motion words.

Words that do not describe motion are left out; all others are lemmas as in captions
(``motiondb.language.vocabulary``). Adjacent connectives become one (", and then" is ``then``). A
negation that follows a comma, "and" or "but" becomes ``but_not``: it holds for everything before
it; a bare "not" or "without" holds for the part before it alone.

    kind        written as
    word        a motion word; ``manner``: an adverb in -ly or a word of speed
    quote       "several words" in quotation marks: one action
    wild        ?
    open close  ( )
    comma stop then while same or either and after before
    not         not, never, without, except, no, don't, neither, ...; ``nor``; ``but_not``
    count       twice, three times, 3x, two jumps
    which when  subject 14, in the first 2 s, immediately after, by someone, than running: told,
    soon whom   and not used
    than
    duration    for ten seconds, at least 5 s
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, takewhile

from motiondb.errors import QueryError
from motiondb.language.lemmas import VERBS
from motiondb.language.question.amounts import (
    FEW,
    manner_of,
    match_count,
    match_duration,
    match_measure,
    match_number,
    spread_amounts,
    to_number,
)
from motiondb.language.question.tree import LIMBS, NotUsed
from motiondb.language.vocabulary import MODIFIERS, join_phrases, motion_word, split_compound

_SECONDS = rf"{FEW}\s*(?:s|sec|secs|seconds?|min|mins|minutes?|ms|milliseconds?)"
_HALF = r"half\s+(?:a\s+)?"
_LENGTH = rf"(?:{_SECONDS}|(?:{_HALF})?(?:second|minute)|few\s+seconds|half|third)"
_PART = rf"(?:first|last|final)\s+{_LENGTH}"
_EDGE = r"the\s+(?:very\s+)?(?:beginning|start|end)"
_OF_TAKE = (  # a request is read without "clip" and "recording" at its end
    r"(?:the|a|each|every)(?:\s+(?:clip|take|capture|file|recording|motion|sequence)"
    r"|(?=\s*(?:[,.;?!]|$)))"
)
_UNIT = r"(?:s|sec|secs|seconds?|min|mins|minutes?|ms|milliseconds?)"
_POINT = rf"(?:second\s+{FEW}|{FEW}(?:\s*{_UNIT})?)"
WHOLE = (
    r"(?:for\s+)?the\s+(?:whole|entire)(?:\s+(?:time|clip|take|capture|recording)"
    r"|(?=\s*(?:[,.;?!]|$)))|all\s+the\s+time"
    r"|throughout(?:\s+the\s+(?:clip|take|recording)|(?!\s+(?:the|a|an)\b))|from\s+(?:start|beginning)\s+to\s+(?:finish|end)"
)
"""Pattern of what is said of a whole take."""
_SPAN = (
    rf"(?:from\s+{_POINT}\s+(?:to|until|till)\s+(?:second\s+{FEW}|{_SECONDS})"
    rf"|from\s+second\s+{FEW}\s+(?:to|until|till)\s+{FEW}"
    rf"|between\s+(?:second\s+{FEW}\s+and\s+{_POINT}|{FEW}\s*{_UNIT}\s+and\s+{_SECONDS})"
    rf"|(?:at|from|between|during)\s+{FEW}(?:\s*{_UNIT})?\s*[-–]\s*{_SECONDS})"
)
_WORDS = (
    (
        "which",
        r"(?:(?:by|from|of|in|with|for)\s+)?(?:the\s+)?"
        r"(?:(?:subject|performer|actor|participant|trial|session|capture|clip|file|recording)[\s_-]+"
        r"(?:number\s+|no\.?\s*|\#\s*)?|(?:person|player|dancer)\s+(?:number\s+|no\.?\s*|\#\s*))"
        r"[0-9]+(?![\w.,/]*\d)(?!\s*(?:x|times?|°|%|degrees?|steps?|m|cm|s|sec|seconds?|feet|kg)\b)",
    ),
    (
        "when",
        r"(?:(?:but\s+)?(?:not|never)\s+)?(?:"
        rf"(?:(?:with)?in|during|for)\s+the\s+{_PART}(?:\s+and\s+(?:in\s+)?the\s+{_PART})*"
        rf"|at\s+{_EDGE}\s+of\s+{_OF_TAKE}"
        rf"|at\s+{_EDGE}(?:\s+(?:and|or)\s+{_EDGE})*(?!\s+of\b))"
        rf"|(?:after|before|until|till)\s+(?:the\s+first\s+)?{_SECONDS}(?=\s*(?:[.;?!]|$))"
        rf"|(?:at|near|around|about|after|before|until|till)\s+second\s+{FEW}"
        rf"|at\s+(?:(?:about|around)\s+)?{_SECONDS}(?!\s+(?:each|intervals?|per)\b)"
        rf"|(?:(?:about|around)\s+)?{_SECONDS}\s+in(?:to\s+{_OF_TAKE})?(?=\s*(?:[,.;?!]|$))|{_SPAN}"
        rf"|the\s+{_PART}\s+of\b"
        rf"|(?:half-?\s?way\s+through|in\s+the\s+middle\s+of)\s+{_OF_TAKE}"
        r"|(?:half-?\s?way(?:\s+through)?|in\s+the\s+middle)(?=\s*(?:[,.;?!]|$))"
        rf"|{WHOLE}",
    ),
    (
        "skip",
        r"not\s+(?:only|just|merely|simply)(?=\W.*\bbut\b)",
    ),
    (
        "asked",
        r"how\s+(?:many(?:\s+times)?|often|much|long|far|fast|high|deep)"
        r"(?:\s+(?:is|are|was|were|do|does|did))?(?:\s+there)?",
    ),
    (
        "vague",
        r"for\s+(?:a|some|quite\s+a)\s+(?:very\s+)?(?:long\s+|short\s+|little\s+)?"
        r"(?:while|time|moment|bit)|for\s+(?:long|ages)|once\s+in\s+a\s+while|from\s+time\s+to\s+time"
        r"|briefly|sometimes|often|(?<!at\s)(?:(?:the\s+)?most(?:\s+of\s+the\s+time)?|fewest|least)"
        r"|(?:a\s+few|several|some|a\s+couple\s+of)\s+(?:met(?:er|re)s?|yards?|feet|degrees)",
    ),
    (
        "change",
        r"(?:(?:get|becom|grow|go)(?:s|es|ing|t?ing)?\s+)?(?P<more>[a-z]+er)\s+and\s+(?P=more)"
        r"|more\s+and\s+more(?:\s+[a-z]+ly)?|(?:get|becom|grow)(?:s|es|ing|ting)\s+"
        r"(?:ever\s+)?(?:fast|slow|quick|high|low|loud|wid|small|bigg|larg|weak|strong)er"
        r"|gradually|increasingly|progressively|(?:little|bit)\s+by\s+(?:little|bit)",
    ),
    (
        "soon",
        r"(?:immediately|directly|straight|just|shortly|soon|long"
        r"|(?:(?<=and\s)|(?<=,\s)|(?<=then\s)|(?<=down\s)|(?<=up\s)|^)right)"
        r"(?=\s+(?:after|before|afterwards?|thereafter)\b)",
    ),
    (
        "whom",
        r"by\s+(?:some(?:one|body)(?:\s+else)?|another(?:\s+(?:person|one|man|woman|player))?"
        r"|(?:an?|the|his|her|their)\s+(?:opponent|partner|other(?:\s+(?:person|one|player))?))"
        r"|(?:gets?|getting|got|is|are|was|were|being|been)"
        r"(?=\s+(?:hit|pushed|thrown|kicked|punched|struck|shoved|pulled|knocked|tackled|dragged)\b)",
    ),
    (
        "only",
        r"(?:but\s+)?not\s+both(?!\s+[a-z])|only|exclusively|solely|nothing\s+but|nothing\s+else",
    ),
    (
        "then",
        r"then|after\s+(?:that|this|which|a\s+while)|afterwards?|subsequently|thereafter"
        r"|(?<!the\s)next(?!\s+to\b)|later(?:\s+on)?|finally|lastly|followed\s+by",
    ),
    (
        "while",
        r"at\s+the\s+same\s+time\s+as|simultaneously\s+with|while|whilst|during"
        r"|(?:(?<=and\s)|(?<=but\s)|(?<=[,;]\s))(?:at\s+the\s+same\s+time|simultaneously"
        r"|concurrently|meanwhile)(?=\s*,?\s*\w)",
    ),
    (
        "same",
        r"(?:all\s+)?at\s+the\s+same\s+time|simultaneously|concurrently|(?:all\s+)?at\s+once"
        r"|meanwhile",
    ),
    (
        "not",
        r"not\s+(?:while|whilst|when|during)|(?:anything|everything|something|all"
        r"|any\s+(?:motion|movement|action))\s+"
        r"(?:but|except(?:\s+for)?|other\s+than|apart\s+from)|with(?:out|\s+(?:no|zero|neither))|w/o"
        r"|except(?:ing)?(?:\s+(?:for|that|when|where))?|exclud(?:es?|ing)|minus|not|never"
        r"|no\s+longer|no\s+one|neither|nobody|none|no|other\s+than|instead\s+of|rather\s+than"
        r"|apart\s+from|aside\s+from|lacking|cannot|[a-z]+n't"
        r"|(?:do|does|did|is|are|was|were|wo|ca|should|would|could|has|have|had)nt",
    ),
    (
        "than",
        r"than(?:\s+(?!(?:and|but|or|then|while|with|without|before|after|until|at|in|for|from|on"
        r"|during|once|twice)\b)[^\W\d_]+)+",
    ),
    ("nor", r"nor"),
    ("or", r"and/or|or\s+else|or|alternatively"),
    ("either", r"either|whether"),
    ("and", r"as\s+well\s+as|but\s+also|and\s+also|in\s+addition\s+to|plus|and"),
    ("but", r"but|yet|however|though|although"),
    ("after", r"after|preceded\s+by"),
    ("before", r"before|prior\s+to|until|till"),
)
_SIGNS = (
    ("then", r"[-=]+>|[→»>]+"),
    ("not", r"(?<!\w)non(?=-\w)|(?<!\w)!(?=\w)|(?<!\S)-(?=[^\W\d_])"),
    ("or", r"\|+"),
    ("and", r"[&+]+"),
    ("quote", r'["“”„«](?P<quoted>[^"“”„«»]{1,500})["“”»]'),
    ("wild", r"(?:(?<=[\s,;.(])|^)\?(?=[\s,;.?)]|\Z)"),
    ("comma", r","),
    ("stop", r"[.;!?\n]+"),
    ("open", r"\("),
    ("close", r"\)"),
)
_FLAGS = re.IGNORECASE
PATTERNS: tuple[tuple[str, re.Pattern[str]], ...] = (
    *((kind, re.compile(rf"(?<!\w)(?:{pattern})(?!\w)", _FLAGS)) for kind, pattern in _WORDS),
    *((kind, re.compile(pattern, _FLAGS)) for kind, pattern in _SIGNS),
)  # Kind of a token and its pattern


def match_connective(text: str, place: int) -> tuple[str, re.Match[str]] | None:
    """The connective at a position of a text, with its kind.

    >>> kind, found = match_connective("walk, but not run", 10)
    >>> kind, found.group()
    ('not', 'not')

    The first pattern of the table that matches at a position of the text counts, so longer phrases
    come before the words that they begin with.
    """
    for kind, pattern in PATTERNS:
        match = pattern.match(text, place)
        if match is not None:
            return kind, match
    return None


EDGE = 3.0  # Seconds of a take, or half of it, that are its beginning or its end
_TIME_OF_TAKE = re.compile(
    rf"(?:(?:with)?in|during|for)\s+the\s+(?P<which>first|last|final)\s+(?P<length>{_LENGTH})"
    r"|at\s+the\s+(?:very\s+)?(?P<edge>beginning|start|end)(?:\s+of\b.*)?"
    rf"|(?P<side>after|before|until|till)\s+(?:the\s+first\s+)?(?P<limit>{_POINT})"
    rf"|(?:at|near|around|about)\s+(?:(?:about|around)\s+)?(?P<at>{_POINT})"
    rf"|(?:(?:about|around)\s+)?(?P<into>{_SECONDS})\s+in(?:to\b.*)?"
    rf"|(?:from|between|at|during)\s+(?P<from>{_POINT})\s*(?:to|until|till|and|-|–)\s*(?P<to>{_POINT})"
    rf"|(?P<middle>half|in\s+the\s+middle).*|{WHOLE}",
)
NEAR = 1.0  # Seconds before and after a moment of a take in which something is at it


def time_of_take(text: str, seconds: float) -> tuple[float, float] | None:
    """The seconds [a, b) of a take that a part of a question names; None if it names none.

    >>> time_of_take("at the end", 10.0), time_of_take("in the first half", 10.0)
    ((7.0, 10.0), (0.0, 5.0))
    >>> time_of_take("in the last 2 s", 10.0), time_of_take("after 4 seconds", 10.0)
    ((8.0, 10.0), (4.0, 10.0))
    >>> time_of_take("in the first half second", 9.0), time_of_take("in the first two seconds", 9.0)
    ((0.0, 0.5), (0.0, 2.0))
    >>> time_of_take("in the last few seconds", 9.0), time_of_take("not at the end", 9.0)
    ((6.0, 9.0), None)
    >>> time_of_take("at 3 s", 9.0), time_of_take("from 2 to 4 s", 3.0)
    ((2.0, 4.0), (2.0, 3.0))
    >>> time_of_take("around second 1", 9.0), time_of_take("halfway through the take", 9.0)
    ((0.0, 2.0), (3.0, 6.0))
    >>> time_of_take("at 3-5 s", 9.0), time_of_take("at 500 ms", 9.0)
    ((3.0, 5.0), (0.0, 1.5))
    >>> time_of_take("the whole time", 9.0)
    (0.0, 9.0)
    """
    found = _TIME_OF_TAKE.fullmatch(text.strip().lower())
    if found is None:
        return None
    moment = found["at"] or found["into"]
    if found["side"]:
        limit = _duration(found["limit"])
        start, end = (limit, seconds) if found["side"] == "after" else (0.0, limit)
    elif moment:
        start, end = _duration(moment) - NEAR, _duration(moment) + NEAR
    elif found["from"]:
        unit = re.search(rf"(?:{_UNIT})?$", found["to"])
        bare = re.fullmatch(FEW, found["from"])
        start = _duration(f"{found['from']} {unit[0] if unit and bare else ''}")
        start, end = sorted((start, _duration(found["to"])))
    elif found["middle"]:
        start, end = seconds / 3.0, 2.0 * seconds / 3.0
    elif not (found["edge"] or found["length"]):
        start, end = 0.0, seconds
    else:
        return _at_an_end(found, seconds)
    return min(max(start, 0.0), seconds), min(end, seconds)


def _at_an_end(found: re.Match[str], seconds: float) -> tuple[float, float]:
    """The first or last seconds of a take, as many as are said."""
    if found["edge"]:
        length, is_first = min(EDGE, seconds / 2.0), found["edge"] != "end"
    else:
        share = {"half": seconds / 2.0, "third": seconds / 3.0}.get(found["length"])
        length = _duration(found["length"]) if share is None else share
        is_first = found["which"] == "first"
    length = min(length, seconds)
    return (0.0, length) if is_first else (seconds - length, seconds)


def _duration(text: str) -> float:
    """The seconds of "2 s", "half a second", "second", "few seconds" and "second 5"."""
    text = re.sub(rf"^second\s+(?={FEW})", "", text).strip()
    if re.fullmatch(FEW, text):
        return to_number(text)
    found = match_duration(text) or match_duration(f"one {text}")
    return EDGE if found is None else found[1]


MOST_CHARACTERS = 5_000  # Longest question; captions have some 100 characters
MOST_TOKENS = 250  # Largest number of words and connectives of a question; captions have up to 40

_WORD = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_DIGITS = re.compile(r"[0-9]+(?:[.,][0-9]+)*")
_SPACE = re.compile(r"\s+")
_SEPARATORS = ("or", "while", "after", "before", "then", "stop", "comma", "but", "and")
"""Kinds that join parts; of several adjacent ones, the first in this order is used."""
_AMOUNTS = ("number", "vague", "filler")  # Kinds between a verb and the steps of its way
_MEASURED_IN_STEPS = VERBS - MODIFIERS - LIMBS - {"take", "climb", "ascend", "descend"}
_UNUSED = {
    "asked": "answers are places in captures; nothing is summed up",
    "vague": "it names neither a duration nor a count",
    "change": "how it changes is not compared",
    "soon": "how soon one action follows another is not compared",
    "only": "what else a capture shows is not compared",
    "whom": "who does it to whom is not compared",
    "which": "performers and captures are chosen by filters (--where)",
    "when": "where in a capture it is shown is not compared",
    "than": "with what else it is compared is not looked at",
    "rate": "what it measures is not compared",
    "number": "it says neither how often nor how long",
}


@dataclass(frozen=True)
class Token:
    """A piece of a question."""

    kind: str  # As in the module's table
    text: str
    words: tuple[str, ...] = ()  # Lemmas of a word or a quote; the adjective of a manner
    least: float = 0.0  # Lower limit of a count or a duration, see ``question.amounts``
    most: float | None = None  # Upper limit; None if there is none
    what: str = ""  # What an amount measures, see ``Measure``


def tokenize(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> tuple[list[Token], list[NotUsed]]:
    """The tokens of a question, and its unused parts.

    >>> [token.kind for token in tokenize("A person walks, but does not wave twice.")[0]]
    ['word', 'but_not', 'word', 'count', 'stop']
    >>> _, unused = tokenize("subject 14 walks in the first 2 s, then sits after 5 s")
    >>> [part.text for part in unused]
    ['subject 14', 'in the first 2 s', 'after 5 s']
    >>> tokenize("the person 3 times jumps after 2 s of walking")[1]
    []
    """
    _check_length(len(text), MOST_CHARACTERS, "characters")
    words = _words(_scan(join_phrases(spread_amounts(text))), synonyms or {}, lemmas)
    raw = _numbers_to_counts(_uncount_steps(list(words)))
    not_used = [NotUsed(t.text, _UNUSED[t.kind]) for t in raw if t.kind in _UNUSED]
    tokens = _join_separators([t for t in raw if t.kind not in _UNUSED and t.kind != "filler"])
    _check_length(len(tokens), MOST_TOKENS, "words")
    return tokens, not_used


def _check_length(length: int, most: int, unit: str) -> None:
    if length > most:
        raise QueryError(
            f"question: expected at most {most:,} {unit}, found {length:,}. "
            "Ask for fewer actions at a time."
        )


def _scan(text: str) -> Iterator[Token]:
    """Tokens in the order of the text, words not yet looked up."""
    place = 0
    while place < len(text):
        token, end = _token_at(text, place)
        if token is not None:
            yield token
        place = end


def _token_at(text: str, place: int) -> tuple[Token | None, int]:
    """The token at a place and where it ends; None for spaces and signs without a meaning."""
    space = _SPACE.match(text, place)
    if space is not None and "\n" not in space.group():
        return None, space.end()
    connective = match_connective(text, place)
    if connective is not None and connective[0] == "when":  # "at 3 s" is no duration
        return Token("when", connective[1].group()), connective[1].end()
    if duration := match_duration(text, place):
        return Token("duration", text[place : duration[0]], (), *duration[1:]), duration[0]
    if measured := match_measure(text, place):
        end, amount = measured
        limits = (amount.least, amount.most, amount.what)
        return Token("measure" if amount.what else "rate", text[place:end], (), *limits), end
    if count := match_count(text, place):
        return Token("count", text[place : count[0]], (), *count[1:]), count[0]
    if connective is not None:
        kind, match = connective
        quoted = match.group("quoted") if kind == "quote" else match.group()
        return Token(kind, quoted), match.end()
    if number := match_number(text, place):
        return Token("number", text[place : number[0]], (), *number[1:]), number[0]
    for kind, pattern in (("number", _DIGITS), ("text", _WORD)):
        matched = pattern.match(text, place)
        if matched is not None:
            return Token(kind, matched.group()[:30], (), -1.0), matched.end()
    return None, place + 1


def _words(
    tokens: Iterator[Token], synonyms: Mapping[str, str], lemmas: Mapping[str, str] | None
) -> Iterator[Token]:
    """Words looked up: motion words, manners, and fillers that do not describe motion."""
    for token in tokens:
        if token.kind == "quote":
            pieces = [p for spelling in _WORD.findall(token.text) for p in split_compound(spelling)]
            words = tuple(w for p in pieces if (w := motion_word(p, synonyms, lemmas)) is not None)
            yield replace(token, words=words) if words else Token("filler", token.text)
        elif token.kind in ("text", "skip"):
            for piece in split_compound(token.text):
                word = motion_word(piece, synonyms, lemmas) if token.kind == "text" else None
                yield _word_token(piece, word, word in synonyms.values())
        else:
            yield token


def _word_token(piece: str, word: str | None, synonym: bool) -> Token:
    """A motion word, a manner, or a filler; a user's synonym is a word."""
    if word is None:
        return Token("filler", piece)
    manner = None if synonym else manner_of(piece, word)
    return Token("word", piece, (word,)) if manner is None else Token("manner", piece, (manner,))


def _uncount_steps(tokens: list[Token]) -> list[Token]:
    """Numbers of steps are no counts ("three steps back"), nor steps that measure a verb's way.

    >>> [token.text for token in tokenize("walk a few steps back, then two steps to the left")[0]]
    ['walk', 'back', ', then', 'two steps', 'steps', 'left']
    """
    resolved: list[Token] = []
    for token in tokens:
        said = [t for t in reversed(resolved) if t.kind not in (*_AMOUNTS, "measure")]
        if token.what == "steps" and resolved and resolved[-1].words in (("up",), ("down",)):
            resolved += [replace(token, kind="number"), Token("word", "steps", ("step",))]
            continue  # those of stairs
        if token.what == "steps":
            since = takewhile(lambda t: t.kind not in _SEPARATORS, said)
            is_said = any((_MEASURED_IN_STEPS | {"step"}).intersection(t.words) for t in since)
            resolved += [token] if is_said else [token, Token("word", "steps", ("step",))]
            continue
        is_way = token.words == ("step",) and bool(resolved) and resolved[-1].kind in _AMOUNTS
        if not (is_way and said and _MEASURED_IN_STEPS.intersection(said[0].words)):
            resolved.append(token)
    return resolved


def _numbers_to_counts(tokens: list[Token]) -> list[Token]:
    """A number before the first verb of an action counts it ("two jumps"); others are not used.

    "One" is an article where neither a verb nor a part of the body follows.
    """
    resolved = []
    for n, token in enumerate(tokens):
        if token.kind == "number":
            following = tokens[n + 1] if n + 1 < len(tokens) else Token("stop", "")
            before = next((t for t in reversed(tokens[:n]) if t.kind != "filler"), None)
            first = (
                before is None or before.kind not in ("word", "manner") or before.words == ("take",)
            )
            verb = following.kind == "word" and set(following.words) <= VERBS - MODIFIERS - LIMBS
            whole = token.least >= 0 and token.least == int(token.least)
            if verb and first and whole:
                token = replace(token, kind="count")
            elif token.least == token.most == 1 and not (
                following.words and following.words[0] in LIMBS
            ):
                token = Token("filler", token.text)
        resolved.append(token)
    return resolved


def _join_separators(tokens: Sequence[Token]) -> list[Token]:
    """Adjacent separators become one; followed by a negation, ``but_not``."""
    joined: list[Token] = []
    for is_separator, run in groupby(tokens, key=lambda token: token.kind in _SEPARATORS):
        group = list(run)
        joined.extend([_joined(group)] if is_separator else group)
    result: list[Token] = []
    for token in joined:
        wide = result and result[-1].kind in ("and", "but", "comma", "stop")
        if token.kind in ("not", "nor") and wide:
            result[-1] = replace(token, kind="nor" if token.kind == "nor" else "but_not")
        else:
            result.append(token)
    return result


def _joined(group: Sequence[Token]) -> Token:
    kinds = {token.kind for token in group}
    kind = next(kind for kind in _SEPARATORS if kind in kinds)
    if kind == "but":
        kind = "and"
    text = " ".join(token.text for token in group)
    apart = bool(kinds & {"comma", "stop", "then"})
    return Token(kind, text, ("apart",) if apart else ())
