"""Writes package.json in the project's root: every module of the firmware that runs on some chip.

    python -m host_tools.build.package_list

A list of sources in mip's format. Boards need compiled files: `passo build` writes a package.json for them (build/tree.py).
"""

import json

from host_tools.build.tree import PAGES, module_files, runs_on
from host_tools.resources import FIRMWARE, ROOT, version

PACKAGE = ROOT / "package.json"


def package():
    """What package.json should hold."""
    files = [path.as_posix() for path in module_files() if runs_on(path)]
    files += sorted(path.relative_to(FIRMWARE).as_posix() for path in (FIRMWARE / PAGES).iterdir())
    return {"urls": [[path, f"firmware/{path}"] for path in files], "deps": [], "version": version()}


def text():
    """package.json with one module a line."""
    rows = [f"    {json.dumps(row)}" for row in package()["urls"]]
    return '{\n  "urls": [\n%s\n  ],\n  "deps": [],\n  "version": %s\n}\n' % (
        ",\n".join(rows),
        json.dumps(package()["version"]),
    )


if __name__ == "__main__":
    PACKAGE.write_text(text(), encoding="utf-8")
