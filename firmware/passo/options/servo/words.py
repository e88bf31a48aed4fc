"""The texts on the key `servo` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "servo": (
        "servo",
        "A servo that lifts and lowers the pen. It follows the tool; `tool.pin` stays, and may show it on a lamp.",
    ),
}
MEANINGS = {
    "servo.pin": "Its pulses, every 20 ms.",
    "servo.up_us": "Length of the pulse that lifts the pen, µs.",
    "servo.down_us": "Length of the pulse that presses it down, µs; shorter than `up_us` if the arm is on the other side.",
    "servo.up_ms": "Time from down to up; `tool.off_ms` is 20 ms more, or longer.",
    "servo.down_ms": "Time from up to down; `tool.on_ms` is 20 ms more, or longer.",
    "servo.by_s": "S of G-code is the pressure: with `$30=1000`, `M3 S600` goes down 60 % of the way.",
}
PORTUGUESE = {
    "servo.by_s: only links that speak grbl know S": "servo.by_s: só ligações que falam grbl conhecem S",
    "servo: it is the tool; leave out spindle.pwm and spindle.laser": "servo: ele é a ferramenta; omita spindle.pwm e spindle.laser",
    "tool.{}: the servo takes {} ms": "tool.{}: o servo leva {} ms",
}
