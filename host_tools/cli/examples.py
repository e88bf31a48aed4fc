"""`passo examples`: the files that the documents use, in a folder of yours."""

import shutil
from pathlib import Path
from typing import Annotated

import typer

from host_tools.language import _

OWN = "mine.py"  # a board file to change


def examples(
    folder: Annotated[Path, typer.Argument(help="Where they go; made if it is not there.")] = Path("examples"),
):
    """Write the files that the documents use: drawings, programs, a photograph, and a board file of your own to change.

    A file that is there already stays as it is.

    Examples:

        passo examples                                   # into examples/
        passo draw examples/map.svg --dry-run            # what a plotter would draw
        passo check examples/slot.gcode
        passo board --board examples/mine.py             # a router, to change as you like
    """
    from host_tools.resources import BOARDS, EXAMPLES

    folder.mkdir(parents=True, exist_ok=True)
    sources = {path.name: path for path in sorted(EXAMPLES.iterdir()) if path.is_file() and path.suffix != ".pyc"}
    sources[OWN] = BOARDS / "router_3axis.py"
    new = [name for name in sources if not (folder / name).exists()]
    for name in new:
        shutil.copyfile(sources[name], folder / name)
    print(_("{}: {} files, {} of them new", folder, len(sources), len(new)))
