"""Odd texts made from a seed: typing errors, and texts that are meant to break a reader.

``text_case(seed)`` gives the same kind and bytes on every machine. Each case starts from a whole
text of one language of motiondb. It is damaged as captures are (``odd_captures.damage``), or its
tokens are drawn at random, repeated thousands of times, or nested.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from importlib import resources
from types import MappingProxyType

import numpy as np
from odd_captures import NUMBERS, damage

_CFG = "S -> a S b | A [0.5] | empty   # nested\nA -> x A | y [0.25] | B C\nB -> b\nC -> c C | c\n"
_SYNONYMS = "jog = run\nstroll\twalk  # slowly\namble = stroll\nleap = jump\n"
_JOINTS = (
    "pelvis = Hips\nl_hip = LeftUpLeg # left\nl_knee=LeftLeg\nhead = end:Neck\nchest = Spine2\n"
)
_PAGE = (
    "<TABLE><TR><TD></TD><TD>3</TD><TD>run/jog &amp; <B>turn</B></TD>"
    '<TD><A HREF="http://site/subjects/16/16_03.amc">amc</A></TD><TD>120</TD></TR>'
    '<TR><TD></TD><TD>4</TD><TD>jump</TD><TD><A HREF="/16_04.amc">amc</TD><TD>60</TD></TABLE>'
)

WHOLE: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "synonyms": (_SYNONYMS,),
        "joint map": (_JOINTS,),
        "filter": (
            "performer=14 and duration>2.5",
            "name ~ 'walk' and fps >= 60 and kind=captured",
            'licence != "CC0-1.0" and leg_length<1.0',
        ),
        "question": (
            "walk, turn left, sit down",
            "a person walks then kicks",
            "someone bows politely and jumps with both feet. then she waves",
        ),
        "grammar": (_CFG,),
        "motion grammar": ("carrying.grammar", "basketball.grammar"),
        "tactics": ("give-and-go.tactics", "screen.tactics", "figure-3.tactics"),
        "actions": (
            "hold pivot_left dribble layup",
            "run walk guard block push",
            "catch pivot_left fake_shot dribble dribble pass run",
        ),
        "terminals": ("a b b a a", "a", "b a c d e"),
        "name": ("demo/walk_2", "walk_1", "ana/long_1"),
        "unit": ("cm", "0.0254", "inch"),
        "subjects": ("14 7 07", "1 999"),
        "page": (_PAGE,),
    }
)
"""Kind of text -> whole texts; those that end in .grammar or .tactics are shipped files."""
_FOLDERS = {".grammar": "grammars", ".tactics": "diagrams"}
_TOKEN = re.compile(r"\w+|[^\w\s]+|\s+")
_ODD_TOKENS = (
    "\n", "\t", " ", '"', "'", "(", ")", "[", "]", "[nan]", "[1e999]", "[0]", "[-1]", "->", ":=",
    "|", "#", "=", "~", "<=", ",", ";", "\\", "%", "_", "*", "?", "/", "..", "\0", "\u202e", "𝕎",
    "ﬁ", "İ", "ß", "\u0301", "\ud800", "empty", "and", "DROP TABLE capture", "{}", "{0}", "%s",
    "__class__", "nan",
)  # fmt: skip
MOST_BYTES = 200_000
"""Bytes of a text at most, so that a case takes seconds."""


def text_case(seed: int, kind: str | None = None) -> tuple[str, bytes]:
    """Make an odd text.

    Parameters
    ----------
    seed : int
        Number of the case, from 0.
    kind : str, optional
        One of :data:`WHOLE`; None: drawn.

    Returns
    -------
    kind : str
        What the text should be.
    data : bytes
        The text, mostly in UTF-8.
    """
    rng = np.random.default_rng([seed, 11])
    kinds = tuple(WHOLE)
    drawn = kinds[int(rng.integers(len(kinds)))]
    kind = drawn if kind is None else kind
    texts = WHOLE[kind]
    text = whole_text(texts[int(rng.integers(len(texts)))])
    how = rng.random()
    if how < 0.55:
        return kind, damage(text.encode(), rng)
    if how < 0.8:
        made = _tokens_anew(text, rng)
    elif how < 0.9:
        made = _repeated(text, rng)
    else:
        made = _nested(text, rng)
    return kind, made.encode("utf-8", "surrogatepass")[:MOST_BYTES]


@cache
def whole_text(name: str) -> str:
    """A text, or the content of the shipped file that it names."""
    folder = _FOLDERS.get(name[name.rfind(".") :])
    if folder is None:
        return name
    return resources.files("motiondb.scene").joinpath(folder, name).read_text(encoding="utf-8")


def _tokens_anew(text: str, rng: np.random.Generator) -> str:
    """Tokens of the text, odd ones among them, in random order."""
    tokens = [*_TOKEN.findall(text), *_ODD_TOKENS, *NUMBERS]
    weights = np.r_[np.full(len(tokens) - len(_ODD_TOKENS) - len(NUMBERS), 4.0), np.ones(
        len(_ODD_TOKENS) + len(NUMBERS)
    )]  # fmt: skip
    count = int(10 ** rng.uniform(0, 2.5))
    drawn = rng.choice(len(tokens), count, p=weights / weights.sum())
    between = ("", " ")[int(rng.integers(2))]
    return between.join(tokens[n] for n in drawn)


def _repeated(text: str, rng: np.random.Generator) -> str:
    """A token, a line or the whole text, up to some thousand times."""
    count = int(10 ** rng.uniform(0, 4))
    what = int(rng.integers(4))
    if what == 0:
        return text * min(count, 200)
    parts = text.splitlines(keepends=True) if what == 1 else _TOKEN.findall(text)
    place = int(rng.integers(len(parts)))
    between = " " if what == 3 else ""
    return "".join(parts[:place]) + between.join([parts[place]] * count) + "".join(parts[place:])


def _nested(text: str, rng: np.random.Generator) -> str:
    """Brackets, quotes or names, one within the other or one after the other."""
    depth = int(10 ** rng.uniform(0, 3.5))
    place = int(rng.integers(len(text) + 1))
    left, right = (("(", ")"), ("[", "]"), ('"', '"'), ("'", ""), ("<A>", "</A>"), ("&", ";"))[
        int(rng.integers(6))
    ]
    if rng.random() < 0.4:  # a chain of rules or of pairs, each of which names the next
        arrow = " -> " if "->" in text else " = "
        lines = "".join(f"N{n}{arrow}N{n + 1}\n" for n in range(depth))
        return lines + text if rng.random() < 0.5 else text + "\n" + lines
    return text[:place] + left * depth + text[place:] + right * depth
