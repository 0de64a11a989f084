"""Motion grammars and tactics diagrams from files, or the shipped ones by name."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from motiondb.errors import SceneError, suggestion
from motiondb.files.safe_files import is_file, read_bounded_text
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics import Diagram

GRAMMAR, TACTICS = ".grammar", ".tactics"
_FOLDERS = {GRAMMAR: "grammars", TACTICS: "diagrams"}
_KINDS = {GRAMMAR: "motion grammar", TACTICS: "tactics diagram"}


def shipped(ending: str) -> tuple[str, ...]:
    """Return the names, without ending, of the shipped files with an ending.

    >>> shipped(GRAMMAR)
    ('basketball', 'carrying')
    """
    folder = resources.files("motiondb.scene").joinpath(_FOLDERS[ending])
    names = [entry.name for entry in folder.iterdir()]
    return tuple(sorted(name.removesuffix(ending) for name in names if name.endswith(ending)))


def read_grammar(name: str | Path) -> MotionGrammar:
    """Read a motion grammar from a file, or the shipped one of this name."""
    return read_motion_grammar(*text_of(name, GRAMMAR))


def grammar_file(diagram: Diagram, beside: str | Path = "") -> str | Path:
    """Return the file beside the diagram's that holds its grammar, or the name of a shipped one."""
    path = Path(beside).parent / f"{diagram.grammar}{GRAMMAR}"
    return path if beside and is_file(path) else diagram.grammar


def shipped_text(name: str, ending: str) -> str:
    """Return the text of a shipped file, and of no other."""
    if name not in shipped(ending):
        near = suggestion(name, shipped(ending)) or f" There are: {', '.join(shipped(ending))}."
        raise SceneError(f"{name}: expected a shipped {_KINDS[ending]}, found no such name.{near}")
    folder = resources.files("motiondb.scene").joinpath(_FOLDERS[ending])
    return folder.joinpath(name + ending).read_text(encoding="utf-8")


def text_of(name: str | Path, ending: str) -> tuple[str, str]:
    """Return the text of a file or of a shipped one, and its name in messages."""
    path = Path(name)
    plain = str(name).removesuffix(ending)
    if not is_file(path) and plain in shipped(ending):
        return shipped_text(plain, ending), plain + ending
    try:
        return read_bounded_text(path), str(name)
    except UnicodeDecodeError:
        raise SceneError(
            f"{name}: expected text in UTF-8, found other bytes. Is it a {_KINDS[ending]}?"
        ) from None
    except OSError as error:
        near = suggestion(plain, shipped(ending)) or (
            f" Name a file, or one of {', '.join(shipped(ending))}."
        )
        raise SceneError(
            f"{name}: expected a {_KINDS[ending]}, found: {error.strerror or error}.{near}"
        ) from None
