"""Two motors on one axis: the words of the step form as pins, and back as steps."""

from array import array

from passo.options.gantry.drive import GantryDrive
from passo.machine_builder import make_drive

CASES = {
    "check_words_become_pins_and_steps_again": (
        ("axes", 1, 4), ("axis", 0, 3), ("motors", 1, 3), ("words", "list", 40, ("steps", 0, 15), ("dirs", 0, 15), ("tool", 0, 1)),
    ),
}


def check_words_become_pins_and_steps_again(axes, axis, motors, words):
    axis = axis % axes
    field = (1 << axes) - 1
    bits = 2 * axes + 3
    drive = GantryDrive(axes, axis)
    drive.use_motors(motors)
    ring = array("I", [0] * 64)
    at = 5
    position = array("i", [-7] * axes)
    wanted = [-7] * axes
    stepping = 0
    for number in range(len(words)):
        steps, dirs, tool = words[number]
        steps, dirs = steps & field, dirs & field
        ring[at + number] = (number + 100) << bits | tool << bits - 1 | dirs << axes | steps
        stepping += 1 if steps else 0
        for each in range(axes):
            if steps >> each & 1:
                wanted[each] += 1 if dirs >> each & 1 else -1
    drive.apply(ring, at, len(words))
    for number in range(len(words)):
        steps, dirs, tool = words[number]
        word = ring[at + number]
        assert word >> bits == number + 100 and word >> bits - 1 & 1 == tool
        for each in range(axes):
            on = steps >> each & 1 and (each != axis or motors & 1)
            assert word >> each & 1 == (1 if on else 0)
            assert word >> axes + 1 + each & 1 == dirs >> each & 1
        assert word >> axes & 1 == (steps >> axis & 1 and motors >> 1)
        assert word >> 2 * axes + 1 & 1 == dirs >> axis & 1
    assert drive.tally(ring, 63, at, at + len(words), position) == stepping
    assert list(position) == wanted


class Added:
    more_motors = [{"name": "x2", "axis": 0}]
    drive_module = "passo.options.gantry.drive"


def check_names_are_in_the_order_of_the_bits():
    board = {"drive": {"kind": "step_dir"}, "axes": [{"name": "x"}, {"name": "y"}], "additions": Added}
    assert make_drive(board)[0].pin_names == ["x_step", "y_step", "x2_step", "x_dir", "y_dir", "x2_dir", "tool"]
    drive = GantryDrive(2, 1)
    assert drive.pin_masks(0) == (2, 16) and drive.pin_masks(1) == (4, 32)
