"""Prepares an image for the ESP32 with the firmware frozen into MicroPython: everything but ESP-IDF, which builds it.

    .venv/bin/python -m host_tools.build.esp32_image build/esp32-image      # and prints what to type

Writes a board's definition: manifest and frozen modules (all languages and features), partition table, settings of ESP-IDF. Frozen code stays
in flash, machine code too, so a router takes 123 kB of the chip's memory instead of 361. The image has not been built here, nor run on an
ESP32; the same modules and manifest, frozen into MicroPython's qemu port, start and make the same words (tests_host/cores/test_esp32_memory.py).
"""

import shutil
import sys
from pathlib import Path

from host_tools.build.frozen import RELEASE, frozen_tree, stamp
from host_tools.failure import Failure
from host_tools.language import _

BOARD = "PASSO_ESP32"
MANIFEST = """import sys
sys.path.insert(0, {project!r})
from host_tools.build.uf2 import mend_frozen_code  # machine code that begins at words
tools = sys.modules["__main__"]
run = tools.system
tools.system = lambda command: mend_frozen_code(*run(command), ())
freeze_mpy({tree!r})  # first: they are looked for one after the other
"""
_OTHERS = 'include("$(PORT_DIR)/boards/manifest.py")\nrequire("sdcard")\n'
_TEXTS = {
    "mpconfigboard.h": '#define MICROPY_HW_BOARD_NAME "Passo on a generic ESP32 module"\n#define MICROPY_HW_MCU_NAME "ESP32"\n',
    # Without Bluetooth, which the firmware does not use: more memory.
    "mpconfigboard.cmake": """set(SDKCONFIG_DEFAULTS boards/sdkconfig.base ${MICROPY_BOARD_DIR}/sdkconfig.board)
set(MICROPY_PY_BLUETOOTH OFF)
set(MICROPY_FROZEN_MANIFEST ${MICROPY_BOARD_DIR}/manifest.py)
""",
    "sdkconfig.board": 'CONFIG_PARTITION_TABLE_CUSTOM=y\nCONFIG_PARTITION_TABLE_CUSTOM_FILENAME="{folder}/partitions.csv"\n'
    "CONFIG_BT_ENABLED=n\n",
    # 2.5 MB for the image, the rest of 4 MB for files, at the same place in every release.
    "partitions.csv": """# Name,   Type, SubType, Offset,  Size
nvs,      data, nvs,     0x9000,   0x6000
phy_init, data, phy,     0xf000,   0x1000
factory,  app,  factory, 0x10000,  0x280000
vfs,      data, fat,     0x290000, 0x170000
""",
}
_TYPED = """cd $MICROPYTHON/ports/esp32                     # {release}, ESP-IDF 5.5.1
export PYTHON=python  # with what Passo wants: pip install -e .
make submodules BOARD_DIR={folder}/{board} BOARD={board}
make BOARD_DIR={folder}/{board} BOARD={board}
python -m esptool --chip esp32 write_flash -z 0x1000 build-{board}/firmware.bin
passo flash --board plotter_esp32 --port /dev/ttyUSB0"""


def manifest_text(tree):
    """Return the manifest that freezes a folder."""
    return MANIFEST.format(project=str(Path(__file__).parents[2]), tree=str(tree))


def prepare_image(folder):
    """Write the board's definition to a folder; return the commands to type. Raises Failure."""
    folder = Path(folder).resolve()
    board = folder / BOARD
    shutil.rmtree(board, ignore_errors=True)
    tree = board / "frozen"
    frozen_tree("esp32", tree)
    for name, text in _TEXTS.items():
        (board / name).write_text(text.replace("{folder}", str(board)))
    (board / "manifest.py").write_text(manifest_text(tree) + _OTHERS)
    return _TYPED.format(folder=folder, board=BOARD, release=RELEASE)


def main():
    """Prepare the image in the folder named on the command line. Raises Failure."""
    if len(sys.argv) != 2:
        raise Failure("which folder? python -m host_tools.build.esp32_image build/esp32-image")
    typed = prepare_image(sys.argv[1])
    print(_("build {} of Passo is prepared in {}; with ESP-IDF:", stamp("esp32"), sys.argv[1]))
    print(typed)


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        sys.exit(str(failure))
