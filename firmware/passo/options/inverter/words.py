"""The texts on the key `inverter` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "inverter": (
        "inverter",
        "The spindle's frequency inverter, over Modbus RTU. See [spindle](../use/spindle.md). `spindle.max_rpm` is S at its fastest.",
    ),
}
MEANINGS = {
    "inverter.make": "`delta` (VFD-B, -E, -EL, -M), `yl620` (Yalang), `h100` (Huanyang H100, GT) `nowforever` (D100, E100) or `teco` (A510, E510, L510).",
    "inverter.port": "`uart0` or `uart1` (ESP32: also `uart2`), with an RS-485 transceiver that switches its direction by itself.",
    "inverter.tx": "The pin that sends.",
    "inverter.rx": "The pin that receives.",
    "inverter.baud": "Bits a second, as set at the inverter.",
    "inverter.parity": "As set at the inverter.",
    "inverter.stop_bits": "As set at the inverter.",
    "inverter.address": "As set at the inverter.",
    "inverter.poles": "Of the motor: rpm = 120 · Hz / poles. Two for 24 000 rpm at 400 Hz.",
    "inverter.timeout_ms": "A request without an answer is sent again after this time, ms; thrice in all.",
    "inverter.at_speed_percent": "At this distance from S it is at speed.",
    "inverter.spin_up_ms": "If it is not at speed by then, ms: alarm 244.",
}
PORTUGUESE = {
    "inverter: it sets the spindle's speed; leave out spindle.pwm and spindle.laser": "inverter: ele define a velocidade do fuso; omita spindle.pwm e spindle.laser",
    "inverter: {} is link {}'s; take another": "inverter: {} é da ligação {}; use outra",
}
