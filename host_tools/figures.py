"""matplotlib, as every picture of Passo is drawn by it.

    figure, axes = pyplot().subplots()
"""


def pyplot():
    """Return matplotlib.pyplot, which draws into files, with matplotlib's own defaults: a `matplotlibrc` in the current folder may be another's, and
    could have it run LaTeX."""
    import matplotlib

    matplotlib.rcdefaults()
    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot
