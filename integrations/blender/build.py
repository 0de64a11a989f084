"""Pack the extension: ``python integrations/blender/build.py motiondb-blender.zip``."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

SOURCE = Path(__file__).parent / "motiondb"


def build(target: Path) -> Path:
    """Write the extension as the zip that Blender installs; equal files give equal bytes."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(SOURCE.iterdir()):
            if path.suffix in (".py", ".toml"):
                archive.writestr(zipfile.ZipInfo(path.name), path.read_bytes())
        licence = SOURCE.parents[2] / "LICENSE"
        archive.writestr(zipfile.ZipInfo("LICENSE"), licence.read_bytes())
    return target


if __name__ == "__main__":
    build(Path(sys.argv[1] if len(sys.argv) > 1 else "motiondb-blender.zip"))
