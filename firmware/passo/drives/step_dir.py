"""STEP/DIR drivers: the step form is what their pins want, so a word needs no translation."""


def pin_names(axes):
    return [name + "_step" for name in axes] + [name + "_dir" for name in axes]
