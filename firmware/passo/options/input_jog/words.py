"""The texts of the option `input_jog` for people. No board has this file."""

PORTUGUESE = {
    "a pendant (inputs jog_…) wants a link that speaks grbl": "um pendente (entradas jog_…) precisa de uma ligação que fale grbl",
    "input {}: a pendant's are {}": "input {}: as de um pendente são {}",
}
