"""The types of the page's script are those of the description of the interface."""

from __future__ import annotations

from motiondb.page.web.typescript import TYPES, describe, types_of


def test_the_types_of_typescript_are_those_of_the_description() -> None:
    """Where this fails: ``python motiondb/page/web/typescript.py`` writes them again."""
    assert TYPES.read_text() == types_of(describe())
