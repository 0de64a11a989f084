"""The examples of README and the guide: where they stand, what they say, and how they are run.

``python tests/readme_blocks.py`` runs them in order and writes the true output (and the pictures)
into the pages. An output that ends in ``...`` is kept to its number of lines.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
GUIDE = tuple(
    ROOT / "docs" / "guide" / f"{n}.md"
    for n in ("words", "examples", "generation", "grammars", "scenes")
)
PAGES = (README, *GUIDE)  # in the order in which their examples build on one another
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURES = ("search.png", "walk_kick.png", "play_strings.png")


@dataclass(frozen=True)
class Example:
    """A command line of a page and the output that the page shows for it."""

    command: str
    output: str


def blocks(language: str, text: str) -> list[str]:
    """The fenced blocks of a language, in order."""
    return [body for actual, body in _BLOCK.findall(text) if actual == language]


def every_example() -> list[Example]:
    """The examples of all pages, in order."""
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    return [e for text in texts for block in blocks("console", text) for e in examples(block)]


def examples(block: str) -> list[Example]:
    """The commands (lines that begin with ``$``) of a block with what follows them.

    >>> examples("$ motiondb a\\nb\\n$ motiondb c\\n")
    [Example(command='motiondb a', output='b\\n'), Example(command='motiondb c', output='')]
    """
    parts = re.split(r"^\$ (.*)\n", block, flags=re.MULTILINE)[1:]
    return [Example(command, output) for command, output in zip(parts[::2], parts[1::2])]


def run(command: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a ``motiondb`` line, in this process."""
    from motiondb.cli.main import main

    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", shlex.split(command)),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
    return (
        code,
        "".join(f"{line.rstrip()}\n" for line in out.getvalue().splitlines()),
        err.getvalue(),
    )


@contextlib.contextmanager
def workplace() -> Iterator[Path]:
    """A temporary folder to work in, with the sample data where the pages expect it."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "sample_data").symlink_to(ROOT / "sample_data", target_is_directory=True)
        os.chdir(place)
        try:
            with mock.patch.dict(os.environ):
                os.environ.pop("MOTIONDB", None)
                yield place
        finally:
            os.chdir(before)


def _refreshed(example: Example) -> str:
    code, out, err = run(example.command)
    if code:
        raise SystemExit(f"{example.command}: exit {code}\n{err}")
    said = "".join(line + "\n" for line in err.splitlines() if "; left out" in line)
    out = said + out
    shown = example.output.splitlines()
    if shown and shown[-1] == "...":
        out = "\n".join([*out.splitlines()[: len(shown) - 1], "..."]) + "\n"
    return f"$ {example.command}\n{out}"


def refresh() -> None:
    """Write the true output of every example into its page, and the pictures that pages show."""
    with workplace() as place:
        for page in PAGES:
            text = page.read_text(encoding="utf-8")
            for block in blocks("console", text):
                text = text.replace(block, "".join(_refreshed(e) for e in examples(block)), 1)
            page.write_text(text, encoding="utf-8")
        for picture in PICTURES:
            shutil.copy(place / picture, ROOT / "docs" / "pictures" / picture)


if __name__ == "__main__":
    refresh()
