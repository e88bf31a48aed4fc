"""What the feeder remembers of each segment it has made, so that position is exact at any word and never a long walk.

    words     …  aaaaaaa bbbbbbbbbb ccc  …          a, b, c: segments
    marks           ^a        ^b     ^c             words, ticks and position so far, at each segment's end
                    ^oldest: the last one played    ^newest

All is in two arrays of integers, `state` and `marks`, for the sake of the twins in machine code. The feeder writes
them, in an interrupt on some boards; the main loop reads them, and reads again what has changed under its hands.

    room(state, marks, lead_ticks)                              may a segment be made?
    begin(state, words, moving, negative, steps, ticks)         directions, and the terms of its words
    end(state, marks, made, count, ticks, ends)                 it is counted, and has left its mark
    retire(state, marks, played)                                room is given back
    find(state, marks, played, place)                           the last mark played, and where that was

What they do, and the fields of the two arrays, stands in checkpoints_plain.py.
"""

try:
    from passo.steps.checkpoints_viper import begin, end, find, retire, room
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    from passo.steps.checkpoints_plain import begin, end, find, retire, room
