"""The registers of both chips, as the pico-sdk's headers have them: src/{rp2040,rp2350}/hardware_regs/include/hardware/regs.

There is no emulated RP2350: an address that only the RP2040 has is found here or on the bench.
"""

import ast
import os
import re
import sys
import types
from pathlib import Path

import pytest

from host_tools.build.tree import FIRMWARE

pytestmark = pytest.mark.quick

RP2 = FIRMWARE / "passo" / "ports" / "rp2"
OPTIONS = FIRMWARE / "passo" / "options"
CHIPS = "rp2040", "rp2350"
# Name in chip.py or vectors.py: macros whose sum it is, and the values on either chip.
DIFFERENT = {
    "IO_BANK0": (("IO_BANK0_BASE",), 0x40014000, 0x40028000),
    "PWM": (("PWM_BASE",), 0x40050000, 0x400A8000),
    "WATCHDOG": (("WATCHDOG_BASE",), 0x40058000, 0x400D8000),
    "ABORT": (("DMA_BASE", "DMA_CHAN_ABORT_OFFSET"), 0x50000444, 0x50000464),
    "TOGGLE": (("SIO_BASE", "SIO_GPIO_OUT_XOR_OFFSET"), 0xD000001C, 0xD0000028),
    "COUNTER": (("CLOCKS_BASE", "CLOCKS_FC0_REF_KHZ_OFFSET"), 0x40008080, 0x4001008C),
    "BUSY": (("DMA_CH0_CTRL_TRIG_BUSY_BITS",), 1 << 24, 1 << 26),
    "UART0": (("UART0_BASE", "UART_UARTDR_OFFSET"), 0x40034000, 0x40070000),
    "UART1": (("UART1_BASE", "UART_UARTDR_OFFSET"), 0x40038000, 0x40078000),
    "UART0_REQUEST": (("DREQ_UART0_RX",), 21, 29),
    "PIO_IRQ_1": (("PIO0_IRQ_1",), 8, 16),
    "IRQ1_INTE": (("PIO_IRQ1_INTE_OFFSET",), 0x138, 0x17C),
    "_OUT_OVER": (("IO_BANK0_GPIO0_CTRL_OUTOVER_LSB",), 8, 12),
}
ONLY_RP2040 = {
    ("VREG_AND_CHIP_RESET_BASE", "VREG_AND_CHIP_RESET_VREG_OFFSET"): 0x40064000,
    ("VREG_AND_CHIP_RESET_VREG_VSEL_BITS",): 0xF0,
    ("VREG_AND_CHIP_RESET_VREG_ROK_BITS",): 1 << 12,
}
PROCESSOR = {  # name in vectors.py or chip.py: macros of either chip, from PPB_BASE
    "_SYSTICK": ("M0PLUS_SYST_CSR_OFFSET", "M33_SYST_CSR_OFFSET", 0xE000E010),
    "_ENABLE": ("M0PLUS_NVIC_ISER_OFFSET", "M33_NVIC_ISER0_OFFSET", 0xE000E100),
    "_DISABLE": ("M0PLUS_NVIC_ICER_OFFSET", "M33_NVIC_ICER0_OFFSET", 0xE000E180),
    "_PRIORITY": ("M0PLUS_NVIC_IPR0_OFFSET", "M33_NVIC_IPR0_OFFSET", 0xE000E400),
    "_VTOR": ("M0PLUS_VTOR_OFFSET", "M33_VTOR_OFFSET", 0xE000ED08),
}
COUNTER = {  # of the frequency counter: from its first register
    "CLOCKS_FC0_MIN_KHZ_OFFSET": 4,
    "CLOCKS_FC0_MAX_KHZ_OFFSET": 8,
    "CLOCKS_FC0_INTERVAL_OFFSET": 16,
    "CLOCKS_FC0_SRC_OFFSET": 20,
    "CLOCKS_FC0_STATUS_OFFSET": 24,
    "CLOCKS_FC0_RESULT_OFFSET": 28,
}
SAME = {
    ("WATCHDOG_LOAD_OFFSET",): 4,
    ("DMA_CH0_WRITE_ADDR_OFFSET",): 4,
    ("CLOCKS_FC0_SRC_VALUE_CLK_SYS",): 9,
    ("CLOCKS_FC0_STATUS_DONE_BITS",): 1 << 4,
    ("CLOCKS_FC0_RESULT_KHZ_LSB",): 5,
    ("IO_BANK0_GPIO0_CTRL_INOVER_LSB",): 16,
    ("IO_BANK0_GPIO0_CTRL_OFFSET",): 4,
    ("IO_BANK0_GPIO1_CTRL_OFFSET",): 12,
    ("IO_BANK0_GPIO0_CTRL_FUNCSEL_VALUE_PIO0_0",): 6,
    ("IO_BANK0_GPIO0_CTRL_FUNCSEL_VALUE_PIO1_0",): 7,
    ("WATCHDOG_CTRL_OFFSET",): 0,
    ("WATCHDOG_CTRL_ENABLE_BITS",): 1 << 30,
    ("DMA_BASE",): 0x50000000,
    ("DMA_CH1_READ_ADDR_OFFSET",): 0x40,
    ("DMA_CH0_CTRL_TRIG_OFFSET",): 0x0C,
    ("DMA_CH0_AL1_CTRL_OFFSET",): 0x10,
    ("DMA_CH0_AL1_READ_ADDR_OFFSET",): 0x14,
    ("DMA_CH0_AL1_TRANS_COUNT_TRIG_OFFSET",): 0x1C,
    ("DMA_CH0_AL3_READ_ADDR_TRIG_OFFSET",): 4 * 15,
    ("PIO0_BASE",): 0x50200000,
    ("PIO1_BASE",): 0x50300000,
    ("PIO1_BASE",): 0x50300000,
    ("PIO_CTRL_OFFSET",): 0,
    ("PIO_CTRL_SM_RESTART_LSB",): 4,
    ("PIO_CTRL_CLKDIV_RESTART_LSB",): 8,
    ("PIO_FLEVEL_OFFSET",): 4 * 3,
    ("PIO_TXF0_OFFSET",): 0x10,
    ("PIO_IRQ_OFFSET",): 4 * 12,
    ("PIO_IRQ0_INTE_SM0_LSB",): 8,
    ("PIO_SM0_CLKDIV_OFFSET",): 0xC8,
    ("PIO_SM1_CLKDIV_OFFSET",): 0xC8 + 0x18,
    ("PIO_SM0_EXECCTRL_OFFSET",): 0xC8 + 4,
    ("PIO_SM0_EXECCTRL_WRAP_BOTTOM_LSB",): 7,
    ("PIO_SM0_SHIFTCTRL_OFFSET",): 0xC8 + 4 * 2,
    ("PIO_SM0_SHIFTCTRL_FJOIN_RX_LSB",): 31,
    ("PIO_SM0_ADDR_OFFSET",): 0xC8 + 4 * 3,
    ("PIO_SM0_INSTR_OFFSET",): 0xC8 + 4 * 4,
    ("PIO_SM0_PINCTRL_OFFSET",): 0xC8 + 4 * 5,
    ("PIO_SM0_PINCTRL_OUT_COUNT_LSB",): 20,
    ("PIO_SM0_PINCTRL_SET_BASE_LSB",): 5,
    ("PIO_SM0_PINCTRL_SET_COUNT_LSB",): 26,
    ("SIO_BASE", "SIO_GPIO_IN_OFFSET"): 0xD0000004,
    ("SIO_BASE", "SIO_GPIO_OUT_OFFSET"): 0xD0000010,
    ("PWM_CH0_CC_OFFSET",): 12,
    ("PWM_CH0_TOP_OFFSET",): 16,
    ("PWM_CH1_CSR_OFFSET",): 20,
    ("DREQ_PIO0_TX0",): 0,
    ("DREQ_PIO1_TX0",): 8,
}
# In ports/rp2, beside chip.py and vectors.py: SysTick, DMA, PIO block 0, its CTRL's clearing alias, GPIO_IN, GPIO_OUT.
ELSEWHERE = {PROCESSOR["_ENABLE"][2], PROCESSOR["_DISABLE"][2], 0xE000E010, 0x50000000, 0x50200000, 0x50203000, 0x50300000, 0xD0000004, 0xD0000010}


@pytest.mark.parametrize("number", [0, 1])
def test_what_differs(number, monkeypatch):
    fake = types.SimpleNamespace(Pin=None, mem32={}, freq=None)
    monkeypatch.setitem(sys.modules, "machine", fake)
    monkeypatch.setattr(sys.implementation, "_machine", "Raspberry Pi Pico with " + CHIPS[number].upper(), raising=False)
    chip = {"__name__": "chip"}
    exec((RP2 / "chip.py").read_text(encoding="utf-8"), chip)
    vectors = {"__name__": "vectors"}
    monkeypatch.setitem(sys.modules, "uctypes", types.SimpleNamespace())
    monkeypatch.setitem(sys.modules, "passo.ports.rp2.chip", types.SimpleNamespace(RP2350=chip["RP2350"]))
    exec((RP2 / "vectors.py").read_text(encoding="utf-8"), vectors)
    for name, (_, *values) in DIFFERENT.items():
        assert {**vectors, **chip}[name] == values[number], name
    for name, (*_, value) in PROCESSOR.items():
        assert {**vectors, **chip}[name] == value, name
    assert chip["REGULATOR"] == 0x40064000


def test_no_other_address_is_written_out():
    found = set()
    for path in [*RP2.glob("*.py"), *OPTIONS.glob("*/port_rp2.py")]:
        if path.name not in ("chip.py", "vectors.py"):
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            found |= {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, int)}
    assert {value for value in found if value >= 0x40000000 and value != 0xFFFFFFFF} == ELSEWHERE


def test_as_the_headers_have_them():
    sdk = os.environ.get("PICO_SDK_PATH")
    if not sdk:
        pytest.skip("PICO_SDK_PATH names no pico-sdk")
    for number, chip in enumerate(CHIPS):
        folder = Path(sdk) / "src" / chip / "hardware_regs" / "include" / "hardware" / "regs"
        names = ["addressmap", "clocks", "dma", "dreq", "intctrl", "io_bank0", "pio", "pwm", "sio", "uart", "watchdog", ("m0plus", "m33")[number]]
        names += ["vreg_and_chip_reset"] * (chip == "rp2040")
        text = "".join((folder / (name + ".h")).read_text() for name in names)
        defined = {name: int(value, 0) for name, value in
                   re.findall(r"#define (\w+)\s+(?:_u\()?(0x[0-9a-fA-F]+|\d+)\)?\s", text)}  # fmt: skip
        wanted = {macros: values[number] for macros, *values in DIFFERENT.values()}
        for macros, value in {**wanted, **SAME, **(ONLY_RP2040 if chip == "rp2040" else {})}.items():
            assert sum(defined[macro] for macro in macros) == value, (chip, macros)
        for *macros, value in PROCESSOR.values():
            assert defined["PPB_BASE"] + defined[macros[number]] == value, (chip, macros)
        for macro, value in COUNTER.items():
            assert defined[macro] - defined["CLOCKS_FC0_REF_KHZ_OFFSET"] == value, (chip, macro)
