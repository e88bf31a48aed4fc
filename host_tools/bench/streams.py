"""Lines and dots a second over each link, beside what they must be, for `bench`."""

from host_tools.bench.moving import _percentile_99
from host_tools.bench.pico import CLOCKS_MHZ
from host_tools.emulator import rows
from host_tools.emulator.copies import on_a_copy

THINK_US = 1000
TIMES = 4  # as long as a test's streams: some 200 `?` and more
MUST = {"lines": (1400, 2000), "dots": (1600, 2500), "clusters": (3500, 5000), "packed": (7000, 10_000)}  # at 125 MHz, at 200
WHAT = {
    "lines": "lines of 0.2 mm, three axes",
    "dots": "dots of 0.1 mm, a line each",
    "clusters": "dots of 0.08 mm, 16 a line, in clusters",
    "packed": "dots of 0.04 mm, 100 a line, packed",
}


def measure_streams():
    """Measure lines and dots a second over USB and a UART, at each clock of CLOCKS_MHZ, beside those of MUST; a UART must carry half of them. Returns
    (header, rows)."""
    table = []
    for at, mhz in enumerate(CLOCKS_MHZ):
        router, laser = rows.fast_router(mhz), rows.fast_laser(mhz)
        for kind in MUST:
            machine = router if kind == "lines" else laser
            for share, port in ((1, "usb"), (2, "uart0")):
                link = next(link["name"] for link in machine.board["links"] if link["port"] == port)
                run = on_a_copy(lambda: rows.measure_stream(machine, link, kind, THINK_US, TIMES))
                name = "USB" if port == "usb" else f"a UART of {rows.BAUD // 1000} {rows.BAUD % 1000} baud"
                figures = round(run["rate"]), run["late"], run["stands"], len(run["asked_ms"]), f"{_percentile_99(run['asked_ms']):.1f}"
                table.append((WHAT[kind], name, mhz, MUST[kind][at] // share, *figures))
    return ("what", "link", "MHz", "must, a second", "measured", "words late", "standstills", "`?` asked", "p99, ms"), table


PARTS = {"streams": measure_streams}
