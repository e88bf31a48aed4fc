"""littlefs images: the file system of an emulated Pico, made on the PC and read back.

    image = make_image({"main.py": b"...", "passo/app.mpy": b"..."})
    files = read_image(image)

A MicroPython binary tells the position of its file system (`location_of`): RPI_PICO has 352 blocks of 4096 bytes at the end of
2 MB of flash, RPI_PICO_W 212.
"""

import struct
from pathlib import Path, PurePosixPath

BLOCK_BYTES = 4096
BLOCKS = 352
FLASH_OFFSET = 0xA0000
FLASH_BYTES = 2 << 20
_FLASH = 0x10000000
_BLOCK_DEVICE = 7, 0x504D  # pico-sdk's binary_info_block_device of MicroPython
PROGRAM_BYTES = 256
WRITTEN_VERSION = 0x0002_0000  # 2.0, which every MicroPython reads


def location_of(uf2):
    """Return (offset in flash, blocks) of the file system of a MicroPython binary; a Pico's if it does not say."""
    data = Path(uf2).read_bytes()
    flash = bytearray(FLASH_BYTES)
    for at in range(0, len(data) - 511, 512):
        address, size = struct.unpack_from("<2I", data, at + 12)
        if 0 <= address - _FLASH <= FLASH_BYTES - size and size <= 476:
            flash[address - _FLASH : address - _FLASH + size] = data[at + 32 : at + 32 + size]
    found, at = set(), -1
    while (at := flash.find(struct.pack("<2H", *_BLOCK_DEVICE), at + 1, FLASH_BYTES - 16)) >= 0:
        address, size = struct.unpack_from("<2I", flash, at + 8)
        offset = address - _FLASH
        if 0 < offset and offset + size == FLASH_BYTES and not size % BLOCK_BYTES:
            found.add((offset, size // BLOCK_BYTES))
    return found.pop() if len(found) == 1 else (FLASH_OFFSET, BLOCKS)


def _mount_image(image=None, blocks=BLOCKS):
    """Return the file system of an image, or a new one."""
    from littlefs import LittleFS, UserContext

    blocks = len(image) // BLOCK_BYTES if image else blocks
    context = UserContext(buffsize=blocks * BLOCK_BYTES)
    options = {} if image else {"disk_version": WRITTEN_VERSION}
    system = LittleFS(
        context=context,
        block_size=BLOCK_BYTES,
        block_count=blocks,
        prog_size=PROGRAM_BYTES,
        mount=False,
        **options,
    )
    if image:
        context.buffer[:] = image
    else:
        system.format()
    system.mount()
    return system


def make_image(files, blocks=BLOCKS):
    """Return the image of {path: bytes}; folders are made as needed."""
    system = _mount_image(blocks=blocks)
    for name in sorted(files):
        folder = PurePosixPath(name).parent
        if folder.parts:
            system.makedirs(str(folder), exist_ok=True)
        with system.open(name, "wb") as file:
            file.write(files[name])
    system.unmount()
    return bytes(system.context.buffer)


def read_image(image):
    """Return {path: bytes} of an image. Raises littlefs.LittleFSError if it holds no file system."""
    system = _mount_image(image)
    files = {}
    for folder, _, names in system.walk("/"):
        for name in names:
            path = f"{folder.rstrip('/')}/{name}"
            with system.open(path, "rb") as file:
                files[path.lstrip("/")] = file.read()
    system.unmount()
    return files


def folder_files(folder):
    """Return {path: bytes} of all files below a folder of the PC."""
    folder = Path(folder)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
