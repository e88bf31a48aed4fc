"""Makes the modules of machine code that are in a release: builds that find them need no compiler.

    python -m host_tools.build.ship       # compiles into host_tools/kernels/modules; then: pip wheel --no-deps .

For each board file of boards/, on each chip for which there is a compiler. Most other board files find them too, because few keys change a kernel.
module.py takes the file whose name is the hash of its C.
"""

import sys

from host_tools import boards
from host_tools.build.tree import MARCH, kernels_of
from host_tools.failure import Failure
from host_tools.kernels import module as modules
from host_tools.kernels.build import RUNTIME
from host_tools.kernels.unit import Unit
from host_tools.language import _

CHIPS = "rp2040", "rp2350", "esp32c3"  # one of each instruction set


def modules_of(names, chips=CHIPS):
    """Return {name of file: (C, names, instruction set)} of all modules of these boards."""
    found = {}
    for board in names:
        for chip in chips:
            try:
                program, groups = kernels_of(board, chip)
            except Failure:
                continue  # the board cannot have this chip
            for _group, kernels in groups:
                unit = Unit(program, kernels)
                given = unit.text(RUNTIME), unit.names, MARCH[chip]
                found[modules.file_name_of(*given)] = given
    return found


def ship_modules(names, folder=modules.SHIPPED, chips=CHIPS):
    """Compile the modules of these boards into a folder, and remove all others; return {name of file: compiler}. Raises Failure if there is no
    compiler for one."""
    folder.mkdir(parents=True, exist_ok=True)
    by = {}
    for name, (text, kernel_names, march) in modules_of(names, chips).items():
        made = modules.compile_here(text, kernel_names, march)
        if made is None:
            raise Failure("nothing here compiles kernels for {}: pip install 'passo[kernels]'", march)
        (folder / name).write_bytes(made.data)
        by[name] = made.by
    for stale in set(folder.glob("*.mpy")) - {folder / name for name in by}:
        stale.unlink()
    return by


if __name__ == "__main__":
    try:
        made = ship_modules(boards.names())
    except Failure as failure:
        sys.exit(str(failure))
    print(_("{} modules in {}, compiled by {}", len(made), modules.SHIPPED, ", ".join(sorted(set(made.values())))))
