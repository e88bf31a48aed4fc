"""Counts the steps in words of the step form that stand in the ring."""


from passo.records import COUNT_MASK


def tally(words, mask, word, until, axes, position):
    """Add what the words of a ring (its size − 1 is `mask`) from count `word` to `until` step, in the step form, to
    `position`; returns how many of them step."""
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        levels = words[word & mask]
        if levels & steps:
            stepping += 1
            for axis in range(axes):
                if levels >> axis & 1:
                    position[axis] += 1 if levels >> axes + axis & 1 else -1
        word = (word + 1) & COUNT_MASK
    return stepping
