"""The documentation site builds without a warning, where MkDocs is installed."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import motiondb

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
@pytest.mark.skipif(
    not (importlib.util.find_spec("material") and importlib.util.find_spec("mkdocstrings")),
    reason="needs the extra docs (pip install 'motiondb[docs]')",
)
def test_the_site_is_built_without_a_warning_and_has_every_public_name(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path / "site"],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert "WARNING" not in done.stderr, done.stderr[-3000:]
    page = (tmp_path / "site/reference/python.html").read_text(encoding="utf-8")
    shown = {place.rpartition(".")[2] for place in re.findall(r'<h2 id="([^"]+)"', page)}
    assert set(motiondb.__all__) <= shown | {"CMU_TERMS", "CMU_URL", "__version__"}
    commands = (tmp_path / "site/reference/commands.html").read_text(encoding="utf-8")
    assert 'id="motiondb-words-history"' in commands
