"""Serve a database for a browser test: ``python page_serving.py DATABASE [--read-only] [FOLDER]``.

Prints the address once the page can be opened, and serves until it is killed.
"""

from __future__ import annotations

import sys
from pathlib import Path

from motiondb.page.serve import serve
from motiondb.page.settings import PageSettings


def _main() -> None:
    options = sys.argv[2:]
    folders = tuple(Path(name) for name in options if not name.startswith("--"))
    settings = PageSettings(
        database=Path(sys.argv[1]),
        port=0,
        read_only="--read-only" in options,
        folders=folders,
    )
    serve(
        settings,
        lambda address: print(address, flush=True),
        lambda warning: print(warning, file=sys.stderr),
        open_browser=False,
    )


if __name__ == "__main__":  # jobs are processes that import this file again
    _main()
