"""The texts on the key `spi_drivers` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "spi_drivers": (
        "spi_drivers",
        "TMC2130 or TMC5160 drivers, set up and watched over SPI. See [drivers](../use/drivers.md#on-spi). Not beside `drivers`.",
    ),
    "spi_drivers.motors": ("spi_drivers.motors", "A list, one entry a driver; an axis without one has a driver that its own pins set up."),
}
MEANINGS = {
    "spi_drivers.chip": "All are of one kind.",
    "spi_drivers.sck": "Pin to SCK of all drivers. Any pins will do.",
    "spi_drivers.tx": "Pin to SDI.",
    "spi_drivers.rx": "Pin from SDO.",
    "spi_drivers.sense_mohm": "The resistors beside each driver, mΩ: 110 on most modules with a TMC2130, 75 with a TMC5160, 50 or less on large ones.",
    "spi_drivers.motors.axis": "Name of its axis.",
    "spi_drivers.motors.cs": "Pin to its CS. Drivers of the same pin are a chain: the first of them in this list has its SDI at `tx`, the last its SDO at `rx`.",
    "spi_drivers.motors.current_ma": "Current of a coil, RMS.",
    "spi_drivers.motors.hold_percent": "Part of it at rest.",
    "spi_drivers.motors.microsteps": "Microsteps a full step: 1, 2, 4 … 256, interpolated to 256.",
    "spi_drivers.motors.stealth": "stealthChop, quiet; `False`: spreadCycle, more torque at speed.",
    "spi_drivers.motors.stall": "Its axis homes by stall, on DIAG0 or DIAG1: SGT, −64 … 63, the lower the sooner. 64: it does not. See [drivers](../use/drivers.md#homing-by-stall-on-spi).",
    "spi_drivers.motors.stall_ma": "Current meanwhile. 0: `current_ma`.",
}
PORTUGUESE = {
    "spi_drivers: not beside drivers, which are on a UART": "spi_drivers: não ao lado de drivers, que ficam em uma UART",
}
