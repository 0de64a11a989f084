"""The heads of an action: the words without which it is another action, or none.

The heads of an action are its verbs. If it has none, its head is its last word that is no
direction, part of the body or size: in "zombie walk" it is "walk", in "does a pirouette"
"pirouette". A question of whose heads one is not understood is not understood as a whole, whatever
else of it is known: captures with hands do not answer "clapping hands".

No dictionary of the parts of speech is loaded. A word counts as a verb if

* it is a form of a motion verb (``lemmas.VERBS``) other than its doer ("dancer"), or ends in
  -ing, and no article stands before it ("picks up a box");
* it follows a subject ("he juggles", "they clap");
* it begins its clause and a word follows that describes no motion ("throw a ball");
* it begins its clause, can be a verb, and the next word is no motion verb ("eat pizza") and no
  participle, whose subject it is ("cop directing traffic"); where the next word can be a verb too
  ("tennis serve"), both count;
* it is the last of the words after "does a", "performs" and the like. Words before those are their
  subject, and no verbs.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence

from motiondb.language.lemmas import VERBS, is_also_verb
from motiondb.language.question.tree import LIMBS, Action, AnyOf, Node, Without, parts_of
from motiondb.language.vocabulary import MODIFIERS, join_phrases, motion_word, split_compound

_TOKEN = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?|[,;.!?()\n]")
_CLAUSE_TEXT = ", ; . ! ? ( ) and then or while after before but nor not without"
_ARTICLE_TEXT = "a an the his her its their your my one two three each"
_SINGULAR_TEXT = """
he she it person man woman guy girl boy child someone somebody subject actor performer who human
character figure
"""
_PLURAL_TEXT = "they people men women persons humans i you we"
_AUXILIARY_TEXT = """
is are was were be been being am has have had can will would who which that
"""
_LIGHT_TEXT = """
do does did doing done make makes making made perform performs performing performed show shows
showing give gives giving try tries act acts acting
"""
_CLAUSE, _ARTICLES = frozenset(_CLAUSE_TEXT.split()), frozenset(_ARTICLE_TEXT.split())
_SINGULAR, _PLURAL = frozenset(_SINGULAR_TEXT.split()), frozenset(_PLURAL_TEXT.split())
_AUXILIARY, _LIGHT = frozenset(_AUXILIARY_TEXT.split()), frozenset(_LIGHT_TEXT.split())


def verbs_in(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> frozenset[str]:
    """Lemmas of the words of a text that name its actions, known or not.

    >>> sorted(verbs_in("A man crawls on his knees, then claps hands; throw a box"))
    ['clap', 'crawl', 'throw']
    >>> sorted(verbs_in("ballet dancer does a pirouette")), sorted(verbs_in("zombie walk"))
    (['pirouette'], ['walk'])
    >>> sorted(verbs_in("eat pizza")), sorted(verbs_in("cop directing traffic"))
    (['eat'], ['direct'])
    """
    found: set[str] = set()
    clause: set[str] = set()  # Verbs of the clause so far
    light, before, is_first = False, "", True
    tokens = [
        piece.lower()
        for token in _TOKEN.findall(join_phrases(text))
        for piece in split_compound(token)
    ]
    words = [motion_word(token, synonyms or {}, lemmas) for token in tokens]
    for k, (token, word) in enumerate(zip(tokens, words)):
        follower = tokens[k + 1] if k + 1 < len(tokens) else ","
        is_last = k + 1 == len(tokens) or words[k + 1] is None or words[k + 1] in MODIFIERS
        if token in _CLAUSE:
            found |= clause
            clause, light, is_first = set(), False, True
        elif word is None and token in _LIGHT and follower not in _CLAUSE:
            clause, light = set(), True
        elif word is None or word in MODIFIERS | LIMBS:
            pass
        elif light:
            clause |= {word} if is_last else set()
            light = not is_last
        elif before not in _ARTICLES:
            begins = is_first and is_last and follower not in _CLAUSE | _AUXILIARY | MODIFIERS
            follows = None if is_last else words[k + 1]
            if begins or _is_verb(token, word, before):
                clause.add(word)
            elif is_first and follows and _begins_with_verb(token, word, follower, follows):
                clause |= {word, follows} if is_also_verb(follows) else {word}
        is_first = token in _CLAUSE or (is_first and word is None)
        before = token
    return frozenset(found | clause)


def _begins_with_verb(token: str, word: str, follower: str, follows: str) -> bool:
    """Whether the first word of a clause is its verb, by the word that follows it."""
    is_subject = follower != follows and follower.endswith("ing")
    return follows not in VERBS and not is_subject and _may_be_verb(token, word)


def _may_be_verb(token: str, word: str) -> bool:
    """Whether a word can be a verb, and does not name a doer ("fighter")."""
    return is_also_verb(word) and not (token != word and token.endswith(("er", "ers")))


def _is_verb(token: str, word: str, before: str) -> bool:
    """Whether a word is a verb by its form or by the word before it."""
    is_changed = token != word
    if word in VERBS and _may_be_verb(token, word):
        return True
    return before in _PLURAL or (is_changed and (token.endswith("ing") or before in _SINGULAR))


def heads_of(words: Sequence[str], verbs: Collection[str]) -> tuple[str, ...]:
    """The heads of an action's words, with the verbs of its text; none if it names no action.

    >>> heads_of(("clap", "hand"), {"clap"}), heads_of(("zombie", "dance"), ())
    (('clap',), ('dance',))
    """
    found = tuple(dict.fromkeys(word for word in words if word in verbs))
    named = [word for word in words if word not in MODIFIERS and word not in LIMBS]
    return found or tuple(named[-1:])


def missing_heads(
    tree: Node, verbs: Collection[str], known: Collection[str]
) -> tuple[tuple[str, ...], ...]:
    """The heads that are not known, of every requested action that has such.

    Of alternatives one that is known suffices.

    >>> missing_heads(AnyOf((Action(("walk",)), Action(("crawl",)))), ("crawl",), ("walk",))
    ()
    >>> missing_heads(Action(("clap", "hand")), ("clap",), ("hand",))
    (('clap',),)
    """
    if isinstance(tree, Action):
        lost = tuple(word for word in heads_of(tree.words, verbs) if word not in known)
        return (lost,) if lost else ()
    parts = (tree.part,) if isinstance(tree, Without) else parts_of(tree)
    below = [missing_heads(part, verbs, known) for part in parts]
    if isinstance(tree, AnyOf) and not all(below):
        return ()
    return tuple(lost for part in below for lost in part)
