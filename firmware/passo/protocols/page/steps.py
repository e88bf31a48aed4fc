"""Places and ways of an order in steps, for the languages that move in steps: an order names some axes, in mm.

    steps_by({"x": 1.5}, "xyz", scale)              # [120, 0, 0]
    steps_to({"x": 1.5}, "xyz", scale, at)          # x at 1.5 mm, y and z where they are
"""


def steps_by(way, axes, scale):
    """The way {axis: mm}; `scale`: steps/mm of each axis."""
    return [round(way.get(axes[axis], 0) * scale[axis]) for axis in range(len(scale))]


def steps_to(position, axes, scale, at):
    """The position {axis: mm}; `at`: the steps of where the machine is, for axes that are not named."""
    return [round(position[axes[axis]] * scale[axis]) if axes[axis] in position else at[axis] for axis in range(len(scale))]
