"""Kernels compiled as C on the emulated Pico: every operator at its edges as CPython has it, while nothing may be allocated; an access
that is not aligned is a fault."""

import pytest
import tiers
from emulated import uf2  # noqa: F401
from expressions import EDGES, checksums, module_for, target_code
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from host_tools.emulator.flash_cache import Unaligned
from host_tools.emulator.pico import EmulatedPico
from host_tools.kernels import module

pytestmark = [pytest.mark.xdist_group("kernels"), pytest.mark.skipif(module.find_compiler("armv6m") is None, reason="there is no compiler of kernels for armv6m")]
LIMIT_US = 20_000_000
EDGE_PAIRS = [(a, b, 0) for a in EDGES for b in EDGES][::3]
triples = st.lists(st.tuples(*[st.integers(-(1 << 31), (1 << 31) - 1)] * 3), min_size=30, max_size=30)


@pytest.fixture(scope="module")
def tried(uf2):
    """(unit, a Pico that has its module)"""
    unit, data = module_for("armv6m")
    return unit, EmulatedPico(files={"kernels_tried.mpy": data}, uf2=uf2).boot()


def test_operators(tried):
    unit, pico = tried

    @settings(max_examples=3 if tiers.current == "all" else 1, suppress_health_check=list(HealthCheck))
    @example(EDGE_PAIRS)
    @given(triples)
    def run(triples):
        assert pico.exec(target_code(unit, triples), limit_us=LIMIT_US).replace("\r", "") == checksums(triples)

    run()


@pytest.mark.on_a_copy
def test_an_unaligned_access_is_a_fault(tried):
    unit, pico = tried
    name = next(unit.python_name(each.kernel) for each in unit.called if each.kernel.name == "all_of")
    code = f"import uctypes\nfrom array import array\nfrom kernels_tried import {name} as all_of\nnumbers = array('i', [0] * 200)\n"
    pico.exec(code + "all_of(uctypes.addressof(numbers), 1, numbers)")
    with pytest.raises(Unaligned):
        pico.exec("all_of(uctypes.addressof(numbers) + 2, 1, numbers)")
