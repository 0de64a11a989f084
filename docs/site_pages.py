"""Pages of the documentation site that are made of other things, and links that lead out of it.

A hook of MkDocs (``mkdocs.yml``): the first page is README, the commands are described by their own
help, every public name of motiondb by its docstring, and notebooks become pages.
"""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def on_files(files: Any, config: Any) -> Any:  # noqa: ANN401  MkDocs' own types
    """Add the pages that are made."""
    from mkdocs.structure.files import File

    readme = (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "](")
    made = {
        "index.md": readme,
        "reference/commands.md": commands_page(),
        "reference/python.md": python_page(),
    }
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        made[f"notebooks/{path.stem}.md"] = notebook_page(path)
    for name, text in made.items():
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, files: Any, **_more: object) -> str:  # noqa: ANN401
    """Turn links to what is not part of the site into plain text."""
    at = posixpath.dirname(page.file.src_uri)
    known = {file.src_uri for file in files if not file.inclusion.is_excluded()}

    def link(found: re.Match[str]) -> str:
        mark, text, target = found.groups()
        place = target.partition("#")[0]
        if not place or ":" in place:
            return found.group()
        if place.endswith(".ipynb"):
            target = target.replace(".ipynb", ".md")
        inside = posixpath.normpath(posixpath.join(at, target.partition("#")[0]))
        if inside == "../README.md":
            return f"{mark}[{text}]({posixpath.relpath('index.md', at or '.')})"
        return f"{mark}[{text}]({target})" if inside in known else text

    return _LINK.sub(link, markdown)


def notebook_page(path: Path) -> str:
    """The cells of a notebook, with what they print."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", ()):
            said = output.get("text") or output["data"]["text/plain"]
            parts.append(f"```text\n{''.join(said).rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


def commands_page() -> str:
    """The help of every command."""
    import click
    import typer

    from motiondb.cli.main import make_app

    lines = ["# Every command", "", "What `motiondb COMMAND --help` prints."]

    def walk(name: str, command: Any) -> Iterator[tuple[str, Any]]:  # noqa: ANN401
        if name != "motiondb":
            yield name, command
        for below, child in sorted(getattr(command, "commands", {}).items()):
            yield from walk(f"{name} {below}", child)

    for name, command in walk("motiondb", typer.main.get_command(make_app())):
        context = click.Context(command, info_name=name)
        text = command.get_help(context)
        lines += ["", f"## {name}", "", "```text", text.rstrip(), "```"]
    return "\n".join(lines) + "\n"


def python_page() -> str:
    """The docstring of every public name."""
    import motiondb

    lines = [
        "# Every public name",
        "",
        (motiondb.__doc__ or "").partition(">>>")[0],
        "",
        "Units and frames of reference, where nothing else is said: metres, seconds, radians; a "
        "right-handed world frame with y up; quaternions in the order w, x, y, z.",
    ]
    for name in sorted(motiondb.__all__, key=str.lower):
        value = getattr(motiondb, name)
        place = getattr(value, "__module__", None)
        own = isinstance(place, str) and place.startswith("motiondb") and hasattr(value, "__name__")
        if own:
            lines += ["", f"::: {place}.{value.__qualname__}"]
    return "\n".join(lines) + "\n"
