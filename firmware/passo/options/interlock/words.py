"""The texts on the key `interlock` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "interlock": (
        "interlock",
        "Inputs that forbid steps in a direction, outputs or the tool. See [interlock](../use/interlock.md). Its inputs have the polarity "
        "of the board file; `$4` and `$5` change nothing.",
    ),
}
MEANINGS = {
    "interlock.rows": "`{name: sum of products}`: when something may be, or the hardware's own equation.",
    "interlock.signals": "`{signal: meaning}`: another name of an input, or an order of the board: `x.step`, `x.dir` … of an axis, "
    "`tool`, an output.",
    "interlock.elsewhere": "Signals that this board does not see, separated by blanks. They count as 0.",
    "interlock.limits": "`{\"x+\": input}`: the limit at each end. It forbids steps that way; alarm 201, letters in reports.",
    "interlock.release_ms": "How long an input must allow something before it is allowed again.",
    "interlock.unasked_ms": "Outputs that a row switches on though the board does not ask go on once inputs and machine have been at "
    "rest for this time; 0: never. Never the tool.",
}
STATUS = {"Fb": "inputs that forbid"}
PORTUGUESE = {
    "inputs that forbid": "entradas que proíbem",
}
