"""G-code files on the PC: the lines that a controller should get, with their numbers in the file."""

from pathlib import Path

from host_tools.failure import Failure


def read(path):
    """[(number, bytes)] of the lines that are not empty, without comments and blanks. Raises Failure."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise Failure(f"cannot read {path}: {error.strerror}") from error
    if b"\0" in data:
        raise Failure(f"{path} is no text: there are zero bytes in it")
    lines = []
    for number, line in enumerate(data.splitlines(), 1):
        stripped = strip(line)
        if stripped and stripped != b"%":
            lines.append((number, stripped))
    if not lines:
        raise Failure(f"{path} has no line of G-code")
    return lines


def strip(line):
    """`line` as the controller sees it: without comments, blanks and anything but printable ASCII."""
    kept = bytearray()
    inside = False
    for byte in line:
        if inside:
            inside = byte != ord(")")
        elif byte == ord("("):
            inside = True
        elif byte == ord(";"):
            break
        elif 32 < byte < 127 and byte not in b"?!~":
            kept.append(byte)
    return bytes(kept)


def clock(seconds):
    """Seconds as h:mm:ss, or m:ss below an hour."""
    minutes, seconds = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
