"""A real drawing: the contour map of the elevation model that ships inside matplotlib, saved as SVG by matplotlib.

    save_contours("out/contours.svg")

The model, jacksboro_fault_dem, is the Jacksboro fault in Tennessee at 3 arc seconds, 403 by 344 heights in metres.
"""

import math

HEIGHT_MM = 275.0
LEVEL_M = 75  # between two contour lines
_SMOOTHING = 5  # passes over the heights: a pen half a millimetre wide cannot follow single cells of 0.8 mm
_SHORTEST_MM = 6.0  # closed lines shorter than this are boulders, not relief


def save_contours(path):
    """Write the map, about 258 × 275 mm, to `path`."""
    import numpy
    from contourpy import contour_generator
    from matplotlib.cbook import get_sample_data

    from host_tools.figures import pyplot

    with get_sample_data("jacksboro_fault_dem.npz") as model:
        heights = _smooth_heights(model["elevation"].astype(float))
        middle = math.radians(float(model["ymin"] + model["ymax"]) / 2)
    rows, columns = heights.shape
    width_mm = HEIGHT_MM * columns / rows * math.cos(middle)
    lines = contour_generator(numpy.linspace(0, width_mm, columns), numpy.linspace(HEIGHT_MM, 0, rows), heights)
    plt = pyplot()
    with plt.rc_context({"svg.hashsalt": "passo", "path.simplify": False}):
        figure = plt.figure(figsize=(width_mm / 25.4, HEIGHT_MM / 25.4))
        figure.patch.set_visible(False)
        axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width_mm), ylim=(0, HEIGHT_MM))
        axes.set_axis_off()
        for level in numpy.arange(LEVEL_M * (heights.min() // LEVEL_M + 1), heights.max(), LEVEL_M):
            for line in lines.lines(level):
                length_mm = numpy.hypot(*numpy.diff(line, axis=0).T).sum()
                if length_mm >= _SHORTEST_MM:
                    axes.plot(line[:, 0], line[:, 1], color="black", linewidth=0.7)
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)


def _smooth_heights(heights):
    """Binomial smoothing, edges repeated."""
    import numpy

    for _ in range(_SMOOTHING):
        for axis in (0, 1):
            padded = numpy.pad(heights, [(1, 1) if axis == side else (0, 0) for side in (0, 1)], mode="edge")
            before, here, after = (numpy.take(padded, range(i, i + heights.shape[axis]), axis) for i in (0, 1, 2))
            heights = (before + 2 * here + after) / 4
    return heights
