"""The order of an image's sections by how often they are read, and the linker's script that lays them so."""

import ast

import pytest

from host_tools.bench.hot import hottest_names, sections_of
from host_tools.build.frozen import CHIPS, MEMORY, modules_frozen
from host_tools.build.tree import source_of
from host_tools.build.uf2 import hot_sections, arrange_linker_script
from host_tools.resources import FIRMWARE

MAP = """
 .text.short    0x10000100        0x8 a.c.o
                0x10000100                short
 .text.a_function_with_a_long_name
                0x10000108       0x20 a.c.o
 .rodata.table  0x10000130       0x10 b.c.o
 .text.here     0x20000100        0x8 in memory
 .text.gone     0x00000000       0x10 c.c.o
 .text          0x10000200       0x10 d.S.o
"""


def test_sections_of_a_map():
    assert sections_of(MAP) == [
        (0x10000100, 8, ".text.short"),
        (0x10000108, 0x20, ".text.a_function_with_a_long_name"),
        (0x10000130, 0x10, ".rodata.table"),
    ]


@pytest.mark.quick
def test_the_dearest_byte_comes_first():
    counts = [0] * 0x100
    counts[0x100 // 8], counts[0x108 // 8], counts[0x130 // 8] = 8, 16, 0
    counts[0x128 // 8] = 99  # between two
    assert hottest_names(counts, sections_of(MAP)) == [".text.short", ".text.a_function_with_a_long_name"]
    counts[0x138 // 8] = 10_000
    assert hottest_names(counts, sections_of(MAP))[0] == ".rodata.table"


@pytest.mark.quick
def test_the_list_stands_before_all_other_code():
    rest = "        *(EXCLUDE_FILE(*libgcc.a: *gc.c.obj *vm.c.obj *parse.c.obj) .text*)\n"
    lines = arrange_linker_script("head\n" + rest + "tail\n").splitlines()
    assert lines[0] == "head" and lines[-1] == "tail" and len(lines) == len(hot_sections()) + 3
    assert lines[1] == f"        *({hot_sections()[0]})" and lines[-2].startswith("        *(EXCLUDE_FILE(")
    assert len(set(hot_sections())) == len(hot_sections())


def functions():
    """Names that frozen functions have in C, without what all begin with."""
    there = set()
    for path in modules_frozen(CHIPS["rp2040"]):
        module = "_".join(path.with_suffix("").parts).removesuffix("___init__")
        for inner in ast.walk(ast.parse(source_of(path, FIRMWARE).read_text(encoding="utf-8"))):
            if isinstance(inner, ast.FunctionDef):
                there.add(f"{module}_{inner.name}")
            elif isinstance(inner, ast.ClassDef):
                there |= {f"{module}_{inner.name}_{one.name}" for one in inner.body if isinstance(one, ast.FunctionDef)}
    return there


@pytest.mark.quick
def test_what_lies_in_memory_is_of_this_firmware():
    assert {f"passo_{name}" for name in MEMORY} <= functions()


@pytest.mark.quick
def test_the_list_is_of_this_firmware():
    """Nine in ten of its functions are there; else `python -m host_tools.bench.hot` again."""
    listed = {name.partition("fun_data_")[2] for name in hot_sections() if "fun_data_passo_" in name}
    listed = {name for name in listed if "_slash_" not in name and not name.startswith("passo_kernels_")}
    gone = sorted(listed - functions())
    assert len(listed) > 100 and 10 * len(gone) < len(listed), gone
