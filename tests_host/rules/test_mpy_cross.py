"""Every firmware file compiles for every instruction set that a board may have."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from host_tools.build.tree import FIRMWARE, compile_module, unix_tree

pytestmark = pytest.mark.quick

ARCHITECTURES = ("armv6m", "armv7emsp", "xtensawin", "rv32imc")

FILES = sorted(path.relative_to(FIRMWARE) for path in FIRMWARE.rglob("*.py"))


def compiled_size(path, architecture, firmware, folder):
    """Bytes of the compiled file."""
    target = folder / architecture / path.with_suffix(".mpy")
    root = firmware if path.parts[0] == "passo" else FIRMWARE
    compile_module(root / path, target, architecture, path)
    return target.stat().st_size


def test_every_file_compiles(tmp_path, show):
    jobs = [(path, architecture) for path in FILES for architecture in ARCHITECTURES]
    firmware = unix_tree()  # here: CPython 3.11 must not parse in two threads at once
    with ThreadPoolExecutor(2) as pool:
        sizes = dict(zip(jobs, pool.map(lambda job: compiled_size(*job, firmware, tmp_path), jobs)))
    rows = [(path.as_posix(), [sizes[path, name] for name in ARCHITECTURES]) for path in FILES]
    rows.append(("bytes in all", [sum(sizes[path, name] for path in FILES) for name in ARCHITECTURES]))
    show("firmware compiled, in bytes", table(rows))


def table(rows):
    width = max(len(name) for name, _ in rows)
    lines = [" " * width + "".join(name.rjust(11) for name in ARCHITECTURES)]
    for name, sizes in rows:
        lines.append(name.ljust(width) + "".join(str(size).rjust(11) for size in sizes))
    return "\n".join(lines)


def test_native_and_viper_code_compiles(tmp_path):
    source = tmp_path / "kernel.py"
    source.write_text(
        "import micropython\n\n\n@micropython.viper\ndef fill(words: ptr32, count: int):\n"
        "    for i in range(count):\n        words[i] = i\n\n\n@micropython.native\ndef twice(x):\n    return 2 * x\n"
    )
    for architecture in ARCHITECTURES:
        compile_module(source, tmp_path / f"{architecture}.mpy", architecture, "kernel.py")
