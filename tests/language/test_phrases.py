"""The table of phrases is sound: every name is used, and rules read what they should."""

from __future__ import annotations

import inspect
import re
from importlib import resources

import pytest

from motiondb.language import requests
from motiondb.language.phrases import phrases, read_phrases


def test_every_pattern_with_a_name_is_used() -> None:
    text = resources.files("motiondb.language").joinpath("request_phrases.txt").read_text("utf-8")
    rules = "".join(line for line in text.splitlines() if not line.startswith("#"))
    asked_for = re.findall(r'"([A-Z_]{4,})"', inspect.getsource(requests))
    used = {*re.findall(r"\{([A-Z_]+)\}", rules), *asked_for}
    assert set(phrases("request").expressions) == used


def test_patterns_go_on_in_lines_that_are_set_in_and_words_may_begin_with_a_space() -> None:
    table = read_phrases(
        '# no rule\nSIDE = {left\n  |right}\n{SIDE}\n  \\s+(side) => " on \\1"\nat all =>\n'
    )
    assert table.replaced("step left  side at all") == "step  on side "


def test_a_line_that_is_no_rule_is_refused() -> None:
    with pytest.raises(AssertionError, match="expected PATTERN => WORDS, found 'seated'"):
        read_phrases("seated")
