"""The words and signs that join, order, exclude and group the actions of a question.

The first pattern of the table that matches at a position of the text counts, so longer phrases come
before the words that they begin with.
"""

from __future__ import annotations

import re

_WORDS = (
    ("skip", r"not\s+(?:only|just|merely|simply)(?=\W.*\bbut\b)"),
    (
        "vague",
        r"for\s+(?:a|some|quite\s+a)\s+(?:very\s+)?(?:long\s+|short\s+|little\s+)?"
        r"(?:while|time|moment|bit)|for\s+(?:long|ages)|once\s+in\s+a\s+while|from\s+time\s+to\s+time"
        r"|briefly|sometimes|often|all\s+the\s+time",
    ),
    ("only", r"only|exclusively|solely|nothing\s+but|nothing\s+else"),
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
        r"(?:anything|everything|something|all|any\s+(?:motion|movement|action))\s+"
        r"(?:but|except(?:\s+for)?|other\s+than|apart\s+from)|with(?:out|\s+no|\s+neither)|w/o"
        r"|except(?:ing)?(?:\s+(?:for|that|when|where))?|exclud(?:es?|ing)|minus|not|never"
        r"|no\s+longer|no\s+one|neither|nobody|none|no|other\s+than|instead\s+of|rather\s+than"
        r"|apart\s+from|aside\s+from|lacking|cannot|[a-z]+n't"
        r"|(?:do|does|did|is|are|was|were|wo|ca|should|would|could|has|have|had)nt",
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
    """
    for kind, pattern in PATTERNS:
        match = pattern.match(text, place)
        if match is not None:
            return kind, match
    return None
