"""`passo` in Portuguese: help, failures, what is printed; no words missing and none left over."""

import ast
import errno
import json
import os
import re
import string
import subprocess
import symtable

import pytest
from parsed import Trees, parse

from host_tools import language
from host_tools import options
from host_tools.clients import setting_names
from host_tools.failure import Failure, reason
from host_tools.programs import program_errors
from host_tools.programs.ngc import codes
from host_tools.prove.promises import BETTER, KEPT, PROMISES, WORSE
from host_tools.prove.proof import PARTS
from host_tools.resources import FIRMWARE, HOST_TOOLS, ROOT

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]
WORDS = json.loads((HOST_TOOLS / "pt.json").read_text(encoding="utf-8"))
BOARD_FILES = json.loads((HOST_TOOLS / "pt_boards.json").read_text(encoding="utf-8"))
PAGE = json.loads((FIRMWARE / "passo" / "web" / "page" / "pt.json").read_text(encoding="utf-8"))
SOURCES = [path for path in HOST_TOOLS.rglob("*.py") if path.parent.name != "bench"]  # that one speaks to those who build Passo
TREES = Trees({path.relative_to(HOST_TOOLS).as_posix(): path for path in SOURCES})
# Calls that take a text and the values of its fields, and which argument the text is.
TEXTS = {"_": 0, "N_": 0, "Failure": 0, "LinkError": 0, "Refused": 0, "RefusedLine": 0, "Unavailable": 0, "Aborted": 0, "Stopped": 0, "Broken": 0, "Failed": 0, "Silent": 0,
         "ProgramError": 1, "_misfit_error": 2}  # fmt: skip
# Functions that hand on a text of their caller's, or one of a table.
HANDED_ON = {
    "shop/home_assistant.py": ("discovery_messages",),
    "language.py": ("_", "translate_help", "error_text", "reword_text", "count_text"), "failure.py": ("message", "reason"), "sim/job.py": ("_failure_of",),
    "programs/compensation.py": ("_misfit_error",), "programs/file_kinds.py": ("refuse_others",), "programs/program_makers.py": ("advice_for",), "programs/program_errors.py": ("message",), "programs/ngc/interpreter.py": ("_group_codes",),
    "programs/calibration.py": ("read", "_parse_row"), "clients/setting_names.py": ("describe_line",), "cli/status.py": ("status", "grbl_rows"),
    "cli/watch.py": ("as_panel",), "cli/jobs.py": ("store",), "cli/draw.py": ("draw",), "drawings/drawing.py": ("_count_text",),
    "clients/plotter.py": ("_check_status",), "cli/usage.py": ("get_usage",), "clients/serial_port.py": ("open_exclusively",),
    "prove/proof.py": ("parts", "_part", "judge"), "prove/facts.py": ("memory", "watchdog"), "prove/report.py": ("report_table",),
    "cli/experiments.py": ("experiments",), "experiments/report.py": ("_section_html", "_sources_html", "author_text"), "experiments/authors.py": ("text",),
    "experiments/drawing.py": ("run", "_add_picture"), "experiments/lines.py": ("run",), "experiments/places.py": ("title",),
}  # fmt: skip
# Text printed for programs, and names, numbers or texts that came through the catalogue before.
AS_IT_IS = ("port", "usb", "key", "page", "passo", "run")
REASONS = (errno.ENOENT, errno.EACCES, errno.EPERM, errno.EISDIR, errno.ENOTDIR, errno.EEXIST, errno.ENOSPC, errno.EROFS, errno.EIO, errno.EBUSY,
           errno.EADDRINUSE, errno.EADDRNOTAVAIL, errno.ECONNREFUSED, errno.ECONNRESET, errno.ETIMEDOUT, errno.EHOSTUNREACH,
           errno.ENETUNREACH, errno.ENODEV, errno.EPIPE)  # fmt: skip
# English terms of the documents, and the Portuguese word that a text with them must have.
TERMS = {"spindle": "spindle", "homed": "referenciada", "drives": "drivers", "torch": "tocha", "plotter": "plotter", "pulse": "pulso", "weave": "tecer", "homing": "origem"}
# One word each, as a Brazilian shop has it: {word to avoid: word to use}; `fuso` is the lead screw.
NOT_SAID = {"armazen": "guardado", "foi salvo": "guardado", "sentiu falta": "acusou", " acionamento": "driver", "plotadora": "plotter", "chave óptica": "sensor óptico", "fila de pontos": "linha de pontos", "ao subir:": "estacionamento:",
    "que porta?": "qual porta?", "drives": "drivers",
            " um ajuste": "configuração", "é ajuste": "configuração", "nem ajustes": "configurações"}


@pytest.fixture
def portuguese():
    language.choose_language("pt")
    yield
    language.choose_language(None)


def prose(text):
    """Whether anything of a text is there to be read, besides its fields."""
    return bool(re.search("[a-z]{2}|[A-Z]{3} [A-Z]|S\\]", re.sub(r"\{[^}]*\}", "", text)))


def calls(tree):
    """(enclosing function, callee's name, call) of a module."""

    def walk(node, function):
        for child in ast.iter_child_nodes(node):
            inside = child.name if isinstance(child, ast.FunctionDef) else function
            if isinstance(child, ast.Call):
                name = child.func.id if isinstance(child.func, ast.Name) else getattr(child.func, "attr", "")
                yield inside, name, child
            yield from walk(child, inside)

    yield from walk(tree, "")


def text_of(name, call):
    """The node of the text that a call says, or None. An __init__ that gives its own text to that of Failure says it too."""
    own = name == "__init__" and call.args and isinstance(call.args[0], ast.Constant) and isinstance(call.args[0].value, str)
    at = 0 if own else TEXTS.get(name)
    return call.args[at] if at is not None and len(call.args) > at else None


def said():
    """All texts of the sources; anything but a literal is a fault."""
    found, made = set(), []
    for path, tree in TREES.items():
        for function, name, call in calls(tree):
            text = text_of(name, call)
            if isinstance(text, ast.Constant):
                found.add(text.value)
            elif text is not None and function not in HANDED_ON.get(path, ()):
                made.append(f"{path}:{call.lineno}: {ast.unparse(call)}")
    assert not made, "no literal texts:\n" + "\n".join(made)
    return {text for text in found if prose(text)}


def commands():
    """Every command of `passo`."""
    import typer

    from host_tools.cli.main import app

    waiting = [typer.main.get_command(app)]
    for command in waiting:
        waiting += getattr(command, "commands", {}).values()
    return waiting


def helps():
    """The texts of all --help."""
    shown = [each.help for command in commands() for each in [command, *command.params] if getattr(each, "help", None)]
    return {text for help_ in shown for _, text, _ in language.help_pieces(help_) if text}


def tables():
    """Texts that a _ looks up as values of a table."""
    why = {text for table in codes.NOT_ON_BOARD.values() for text in table.values()}
    why |= {text for each in PROMISES.values() for text in (each.what, each.unit, each.advice) if prose(text)} | {title for title, *_ in PARTS}
    return why | {BETTER, KEPT, WORSE, "left out"} | set(program_errors.TEXTS.values()) | set(map(os.strerror, REASONS))


def wanted():
    return said() | helps() | tables()


def test_every_text_has_its_words():
    missing = wanted() - set(WORDS) - set(PAGE)
    assert not missing, "pt.json lacks:\n" + "\n".join(json.dumps(text, ensure_ascii=False) for text in sorted(missing))


def test_each_text_gets_the_values_of_its_fields():
    faults = []
    for path, tree in TREES.items():
        for _, name, call in calls(tree):
            text = text_of(name, call)
            values = call.args[call.args.index(text) + 1 :] if text is not None else []
            if not isinstance(text, ast.Constant) or any(isinstance(value, ast.Starred) for value in values):
                continue
            named = {keyword.arg for keyword in call.keywords} - {"number", "place", "line"}
            if not values and not named and name in ("_", "N_"):
                continue  # its values come later, by format()
            fields = [field for _, field, _, _ in string.Formatter().parse(text.value) if field is not None] if values or named else []
            wanted_ = {field or str(at) for at, field in enumerate(fields)}
            if wanted_ != {str(at) for at in range(len(values))} | named or not values and not named and re.search(r"\{\W?\w*\}", text.value):
                faults.append(f"{path}:{call.lineno}: {ast.unparse(call)}")
    assert not faults, "\n".join(faults)


def test_every_kind_of_failure_is_looked_at():
    classes = [node for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    kinds = {"Failure"}
    for _ in classes:  # until all descendants are found
        kinds |= {each.name for each in classes if kinds & {getattr(base, "id", "") or getattr(base, "attr", "") for base in each.bases}}
    assert kinds <= set(TEXTS), kinds - set(TEXTS)


def test_no_words_are_left_over():
    assert not set(WORDS) - wanted()
    assert not set(WORDS) & set(PAGE), "said twice"


def sentence(node):
    """The text that an error is made of, with {} for its values."""
    if isinstance(node, ast.JoinedStr):
        return "".join(map(sentence, node.values))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mod):
        return sentence(node.left)
    if isinstance(node, ast.BinOp):
        return sentence(node.left) + sentence(node.right)
    return re.sub(r"%(\(\w+\))?[srd]", "{}", node.value) if isinstance(node, ast.Constant) else "{}"


def test_what_is_wrong_with_board_files_has_its_words():
    trees = [parse(path.read_text(encoding="utf-8")) for path in (FIRMWARE / "passo").rglob("*.py")]
    raised = {"the board file"}  # a key may be missing in it
    raised |= {sentence(call.args[0]) for tree in [*trees, TREES["boards.py"]] for _, name, call in calls(tree) if name == "BoardError"}
    plant = [TREES["sim/plant.py"], TREES["sim/input_faults.py"]]  # the machine of a virtual board, with the errors of --start and --fault
    raised |= {sentence(call.args[0]) for tree in plant for _, name, call in calls(tree) if name == "ValueError" and call.args}
    of_options = {text: words for text, words in options.portuguese_texts().items() if text in raised}
    assert raised - set(of_options) == set(BOARD_FILES), (raised - set(of_options)) ^ set(BOARD_FILES)
    for text, words in {**BOARD_FILES, **of_options}.items():
        assert text.count("{}") == words.count("{}") and words.strip(), text
        assert re.match(r"([a-z_.{}]+:)?", text)[0] == re.match(r"([a-z_.{}]+:)?", words)[0], "the key of the board file"


def test_a_wrong_board_file_in_portuguese(portuguese):
    from host_tools import boards
    from passo.config.board_error import BoardError
    from passo.config.boardfile import check

    for change, told in (
        ({"chip": "z80"}, "chip: 'z80' não é nenhum de rp2040, "),
        ({"foo": 1}, "o arquivo de placa: chave 'foo' desconhecida; conhecidas são axes, "),
        ({"axes": [{"name": "x", "pins": [1]}]}, "axes[0].steps_per_m: falta"),
    ):
        with pytest.raises(BoardError) as wrong:
            check({**boards.load("router_3axis"), **change})
        assert reason(wrong.value).startswith(told)
    assert reason(BoardError("no sentence of the firmware's")) == "no sentence of the firmware's"


def test_words_have_the_fields_of_their_text():
    def fields(text):
        named = [(name, spec, how) for _, name, spec, how in string.Formatter().parse(text) if name is not None]
        return sorted((name or str(at), spec, how or "") for at, (name, spec, how) in enumerate(named))

    for text, words in WORDS.items():
        assert words.strip(), text
        if re.search(r"\{(\w*)(![rsa])?(:[^}]*)?\}", text):
            assert fields(text) == fields(words), text


def test_words_of_options_commands_and_files_are_the_same():
    """The words that a reader would type stay as they are."""
    for text, words in WORDS.items():
        for typed in re.findall(r"(?<!\w)--[a-z][\w-]*|docs/[\w./-]+|\bM\d+\b|\bG\d+\b", text):
            assert typed in words, f"{text}: {words}"


def test_the_words_are_those_of_the_documents():
    for text, words in WORDS.items():
        for term, word in TERMS.items():
            named = term in words and re.search("grbl|passo ", words)  # as a command or a link's language
            if re.search(rf"\b{term}s?\b", text) and not named:
                assert word in words.lower(), f"{text}: {words}"


def test_one_word_for_one_thing():
    for text, words in (*WORDS.items(), *PAGE.items()):
        for wrong, right in NOT_SAID.items():
            assert wrong not in words.lower(), f"{words}: say {right}"
        assert "fuso" not in words.lower() or "screw" in text, words


def test_what_is_printed_goes_through_the_catalogue():
    """Of print, echo and rich's: a literal with prose stands in a _(…)."""
    faults = []
    for path, tree in TREES.items():
        if not path.startswith(("cli/", "programs/", "drawings/", "site/", "clients/", "panel/", "sim/", "emulator/")):
            continue
        for _, name, call in calls(tree):
            if name not in ("print", "echo", "status", "Table", "add_column", "prompt", "tell", "print_progress", "operator_agrees", "set_title", "set_xlabel", "set_ylabel"):
                continue
            for argument in call.args:
                if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                    text = argument.value
                elif isinstance(argument, ast.JoinedStr):
                    text = "".join(part.value for part in argument.values if isinstance(part, ast.Constant))
                else:
                    continue
                text = re.sub(r"\[/?\w+\]|\$JR|http://\S*", "", text)
                if prose(text) and not re.match(rf"({'|'.join(AS_IT_IS)})\b", text):
                    faults.append(f"{path}:{call.lineno}: {ast.unparse(call)}")
    assert not faults, "\n".join(faults)


def test_no_function_hides_the_catalogue():
    """One that binds _ itself cannot call it."""

    def own(table):
        for each in table.get_children():
            yield each
            yield from own(each)

    for path, tree in TREES.items():
        called = [call.lineno for _, name, call in calls(tree) if name == "_"]
        tables = own(symtable.symtable((HOST_TOOLS / path).read_text(encoding="utf-8"), path, "exec")) if called else ()
        hiding = {each.get_lineno() for each in tables if each.get_type() == "function" and "_" in each.get_locals()}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and node.lineno in hiding:
                assert not any(node.lineno <= line <= node.end_lineno for line in called), f"{path}: {node.name}"


def test_what_the_environment_asks_for():
    assert language.language_of({}) == "en"
    assert language.language_of({"LANG": "pt_BR.UTF-8"}) == "pt"
    assert language.language_of({"LC_ALL": "C", "LANG": "pt_BR.UTF-8"}) == "en"
    assert language.language_of({"LANGUAGE": "de:pt:en", "LC_ALL": "C"}) == "pt"
    assert language.language_of({"LANG": "de_DE.UTF-8"}) == "en"


def test_errors_and_settings_in_portuguese(portuguese):
    from host_tools.options import error_texts
    from passo import errors

    for number, text in error_texts().items():
        assert language.error_text(number) == language.load_catalogue("pt").words.get(text, text)
    assert language.error_text(errors.BUSY) != error_texts()[errors.BUSY]
    assert setting_names.describe_line("$110=500", 3)[0].startswith("x: ") and "highest" not in setting_names.describe_line("$110=500", 3)[0]
    assert setting_names.describe_line("$20=1", 3)[0] != setting_names.NAMES[20][0]
    assert setting_names.describe_line("G10L2P2X1", 3)[0] == "origem de G55"


def test_a_failure_is_english_until_it_is_told(portuguese):
    failure = Failure("{}: faults in {} of {}", "a{0}.nc", 3, Failure("no file {}", "{x}"))
    assert str(failure) == "a{0}.nc: faults in 3 of no file {x}"
    assert failure.message() == "a{0}.nc: falhas em 3 de não há arquivo {x}"
    assert str(Failure("{no field}")) == Failure("{no field}").message() == "{no field}"
    assert reason(OSError(errno.ENOENT, os.strerror(errno.ENOENT))) == "arquivo ou pasta não encontrado"
    error = program_errors.ProgramError(program_errors.RANGE, "F{:g}: seconds, 99.99 at most", 120, place="p.num:4")
    assert str(error) == "p.num:4: error 316: a value is out of its range: F120: seconds, 99.99 at most"
    assert error.message() == "p.num:4: erro 316: um valor está fora da faixa: F120: segundos, no máximo 99.99"


def test_a_help_in_pieces():
    help_ = "What it\nis for.\n\nExample: passo x 1\n\nExamples:\n\n    passo x --y      # this one\n    passo z"
    pieces = list(language.help_pieces(help_))
    assert [text for _, text, _ in pieces] == ["What it is for.", "Example:", "Examples:", "this one", ""]
    assert "".join(map("".join, pieces)) == help_.replace("What it\nis", "What it is")


def test_what_typer_says_of_a_wrong_command_line():
    import typer

    from host_tools.cli import main, usage

    command = typer.main.get_command(main.app)
    usage.translate_command_line(command)
    try:
        for words in ("drw", "draw", "draw x --nix", "draw x --hom", "draw x --margin y", "draw x --points y", "draw x --points 0", "check x y",
                      "draw x --margin", "draw x --home=1", "board --http 70000", "wifi bridge"):  # fmt: skip
            with pytest.raises(typer.BadParameter.__mro__[2]) as refused:
                command.main(["--lang", "pt", *words.split()], standalone_mode=False)
            english = type(refused.value).format_message(refused.value)
            assert refused.value.format_message() not in ("", english), f"{words}: {english}"
    finally:
        language.choose_language(None)


def test_what_another_program_has_said_in_all_languages():
    """In either language; fields are translated, too, and a text that is none of ours stays."""
    from passo import errors

    said = Failure("{}: line {} would be refused: {}", "a.gcode", 2, language.error_text(errors.BUSY))
    english = said.message()
    try:
        language.choose_language("pt")
        portuguese = Failure("{}: line {} would be refused: {}", "a.gcode", 2, language.error_text(errors.BUSY)).message()
        both = {"en": english, "pt": portuguese}
        assert english != portuguese
        assert language.in_languages(english) == language.in_languages(portuguese) == both
        busy = language.error_text(errors.BUSY)
    finally:
        language.choose_language(None)
    assert language.in_languages(busy)["en"] == language.error_text(errors.BUSY)
    assert language.in_languages("of {} no text") == {"en": "of {} no text", "pt": "of {} no text"} and language.in_languages("") == ""


def test_nothing_changes_in_english():
    from passo import error_texts, errors

    assert language.error_text(errors.BUSY) == error_texts.text(errors.BUSY)
    assert setting_names.describe_line("$20=1", 3)[0] == setting_names.NAMES[20][0]
