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
    "input {}: filter_us is for inputs that the interlock's rows name": "input {}: filter_us é para entradas que as linhas do intertravamento nomeiam",
    "input {}: it halts at once: filter_us and halt exclude each other": "input {}: para a máquina na hora: filter_us e halt se excluem",
    "interlock.limits: there is no direction {}; x+ is one": "interlock.limits: não há sentido {}; x+ é um",
    "interlock.rows.{}: it asks for more than one thing": "interlock.rows.{}: pede mais de uma coisa",
    "interlock.signals.{}: {} is no input, no output, and no axis's step or dir": "interlock.signals.{}: {} não é entrada, nem saída, nem step ou dir de um eixo",
    "interlock.{}: names are wanted, in an interlock with texts behind them": "interlock.{}: nomes são esperados, em um intertravamento com textos atrás deles",
    "interlock: its rows gate nothing": "interlock: suas linhas não controlam nada",
    "interlock: no input lets {} be: it can never be on": "interlock: nenhuma entrada permite {}: nunca poderá ligar",
    "{}: a sum of products is wanted, not {}": "{}: é esperada uma soma de produtos, e não {}",
    "{}: {} and not {} in one product: it is never true": "{}: {} e não {} em um só produto: nunca é verdade",
    "{}: {} is neither an input nor one of interlock.signals or interlock.elsewhere": "{}: {} não é entrada nem está em interlock.signals ou interlock.elsewhere",
    "{}: {} is no name; sums of products are written a & !b | c": "{}: {} não é um nome; somas de produtos se escrevem a & !b | c",
}
