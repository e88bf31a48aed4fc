"""littlefs images: the file system of an emulated Pico, made on the PC and read back.

    image = make_image({"main.py": b"...", "passo/app.mpy": b"..."})
    files = read_image(image)

The geometry is that of MicroPython's RPI_PICO: 352 blocks of 4096 bytes at the end of 2 MB of flash.
"""

from pathlib import Path, PurePosixPath

BLOCK_BYTES = 4096
BLOCKS = 352
FLASH_OFFSET = 0xA0000
PROGRAM_BYTES = 256
WRITTEN_VERSION = 0x0002_0000  # 2.0, which every MicroPython reads


def _littlefs(image=None):
    """The file system of an image, or a new one."""
    from littlefs import LittleFS, UserContext

    context = UserContext(buffsize=BLOCKS * BLOCK_BYTES)
    options = {} if image else {"disk_version": WRITTEN_VERSION}
    system = LittleFS(
        context=context,
        block_size=BLOCK_BYTES,
        block_count=BLOCKS,
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


def make_image(files):
    """The image of {path: bytes}; folders are made as needed."""
    system = _littlefs()
    for name in sorted(files):
        folder = PurePosixPath(name).parent
        if folder.parts:
            system.makedirs(str(folder), exist_ok=True)
        with system.open(name, "wb") as file:
            file.write(files[name])
    system.unmount()
    return bytes(system.context.buffer)


def read_image(image):
    """{path: bytes} of an image. Raises littlefs.LittleFSError if it holds no file system."""
    system = _littlefs(image)
    files = {}
    for folder, _, names in system.walk("/"):
        for name in names:
            path = f"{folder.rstrip('/')}/{name}"
            with system.open(path, "rb") as file:
                files[path.lstrip("/")] = file.read()
    system.unmount()
    return files


def folder_files(folder):
    """{path: bytes} of all files below a folder of the PC."""
    folder = Path(folder)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
