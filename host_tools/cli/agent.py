"""`passo agent`: tells an MQTT broker of the machines beside this PC."""

import contextlib
import os
import queue
import re
import signal
import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.key_option import key_in, make_key_file, read_secret
from host_tools.failure import Failure
from host_tools.language import _

_PAGE_KEY = Path.home() / ".local" / "share" / "passo" / "at-machine.key"


def agent(
    broker: Annotated[str, typer.Option(metavar="HOST[:PORT]", help="The MQTT broker, for example Mosquitto.")],
    port: Annotated[
        Optional[list[str]], typer.Option(metavar="[NAME=]PORT", help="Serial port, pty or pyserial URL of a board; give one for each board.")
    ] = None,
    virtual: Annotated[Optional[list[str]], typer.Option(metavar="[NAME=]BOARD", help="A virtual board of this board file; give one for each.")] = None,
    emulated: Annotated[Optional[list[str]], typer.Option(metavar="[NAME=]BOARD", hidden=True, help="The old name of --virtual.")] = None,
    baud: Annotated[Optional[int], typer.Option(help="Bits per second of the serial ports.")] = None,
    protocol: Annotated[
        Optional[str], typer.Option(help="Language of the boards on --port: grbl, pulses, torch, plotter or keys. Default: grbl, pulses and torch are found by asking.")
    ] = None,
    board: Annotated[Optional[str], typer.Option(help="Board file of the boards on --port: what their language does not tell (steps/mm).")] = None,
    user: Annotated[str, typer.Option(help="The broker's user for this agent.")] = "",
    password: Annotated[Optional[Path], typer.Option("--password-file", help="File with the user's password, which other users cannot read.")] = None,
    ca: Annotated[Optional[Path], typer.Option(metavar="FILE.crt", help="Certificate of the authority that has signed the broker's: speak TLS.")] = None,
    figures: Annotated[Optional[str], typer.Option(metavar="[HOST:]PORT", help="Serve figures for Prometheus there (HOST: 127.0.0.1).")] = None,
    home_assistant: Annotated[
        Optional[str], typer.Option(metavar="PREFIX", help="Have Home Assistant find the machines; its discovery prefix is homeassistant.")
    ] = None,
    shop_key: Annotated[
        Optional[Path], typer.Option(metavar="FILE", help="Take jobs of passo shop: its key, in a file that other users cannot read.")
    ] = None,
    at_machine: Annotated[
        Optional[int], typer.Option(min=0, max=65535, metavar="PORT", help="With --shop-key: serve the page at the machine, on this PC only; 0: any free port.")
    ] = None,
    page_key: Annotated[
        Optional[Path], typer.Option("--page-key", metavar="FILE", help="With --at-machine: the key of its page, in a file that other users cannot read; it is made if there is none. Without a terminal it tells the key.")
    ] = None,
    tool: Annotated[Optional[list[str]], typer.Option(metavar="NAME=TEXT", help="With --shop-key: what the machine draws with, for jobs that want it.")] = None,
    laser_class: Annotated[Optional[list[str]], typer.Option(metavar="NAME=CLASS", help="With --shop-key: class of its laser as the machine stands, enclosure and all (IEC 60825-1): 1 … 4.")] = None,
    page: Annotated[Optional[list[str]], typer.Option(metavar="NAME=URL", help="With --shop-key: the machine's own page, to which that of the shop leads.")] = None,
):
    """Tell an MQTT broker of the machines beside this PC: state, job, progress, place, time left, alarms, counters.

    Topics are passo/NAME/… and are retained; passo/NAME/log has what happens, as it happens. If the agent dies, the broker says that the
    machine is gone. A message to passo/NAME/stop, or to passo/stop for all, stops them; else machines are sent nothing but questions. The ports are the agent's alone as long as it runs.

    With --shop-key machines that speak grbl and keep a journal take jobs of passo shop: one for each time that somebody at the machine says so, on
    the page of --at-machine or by its button resume. The page's address has a key, without which its buttons move nothing; STOP needs none. It is printed in a terminal only: else it stands in the file of --page-key.

    Examples:

        passo agent --port /dev/ttyACM0 --broker shop.local

        passo agent --port mill=/dev/ttyUSB0 --port laser=/dev/ttyUSB1 --broker 192.168.1.20 --user pc-3 --password-file mqtt.txt --ca ca.crt

        passo agent --virtual a=router_3axis --virtual b=plotter_2014 --broker localhost
    """
    _check_options(shop_key, at_machine, page_key, tool or laser_class or page)
    served = _parse_address("--figures", figures if ":" in figures else f"127.0.0.1:{figures}") if figures else None
    boards = _parse_boards(port or [], _add_old_name(virtual or [], emulated or []))
    key = key_in(shop_key) if shop_key else ""
    about = (_parse_machine_texts(*each, boards) for each in (("--tool", tool), ("--laser-class", laser_class), ("--page", page)))
    told = make_broker(broker, user, password, ca), home_assistant, key, about
    stopped = _collect_stop_signals()
    with contextlib.ExitStack() as stack:
        made = {name: (where, _start_virtual(where, stack) if virtual else _find_real(where, baud, protocol, board)) for name, (where, virtual) in boards.items()}
        agent = _connect_agent(made, served, told, stack)
        _run_agent(agent, (at_machine, page_key), stopped, stack)


def _add_old_name(virtual, emulated):
    """Return `virtual` and the boards of --emulated, its old name; if there are any, print the new name on stderr."""
    if emulated:
        print(_("--emulated is now called --virtual; the old name still works"), file=sys.stderr, flush=True)
    return [*virtual, *emulated]


def _check_options(shop_key, at_machine, page_key, more):
    """Raise Failure if an option lacks the one that it needs: --shop-key for --at-machine and the texts, --at-machine for --page-key."""
    if (at_machine is not None or more) and not shop_key:
        raise Failure("--at-machine, --tool, --laser-class and --page want --shop-key")
    if page_key and at_machine is None:
        raise Failure("--page-key wants --at-machine")


def _collect_stop_signals():
    """Catch SIGTERM and Ctrl-C; return a list that stays empty until one of them comes."""
    found = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: found.append(True))
    return found


def _run_agent(agent, page, stopped, stack):
    """Run the agent until `stopped` has an item. `page`: (port of the page at the machine or None, file of its key or None)."""
    asked = queue.SimpleQueue()
    if page[0] is not None:
        _serve_page(*page, agent, asked, stack)
    print(_("Ctrl-C ends it."), flush=True)
    agent.run(lambda: stopped, asked)


def _connect_agent(boards, served, told, stack):
    """Return an Agent connected to all boards. `boards`: {name: (port or board file, (language, board file's table, make_port))}; `served`: (host,
    port) for figures, or None; `told`: (Broker, prefix for Home Assistant, key of the shop, ({name: tool}, {name: laser class}, {name: page}))."""
    from host_tools.shop.agent import Agent
    from host_tools.shop.home_assistant import discovery_messages
    from host_tools.shop.link import ROOT, Link

    broker, home_assistant, key, (tools, lasers, pages) = told
    agent = Agent(_serve_figures(served, stack))
    stack.callback(agent.close)
    for name, (where, (language, table, make_port)) in boards.items():
        more = {f"{ROOT}/{name}/language": language, **(discovery_messages(home_assistant, f"{ROOT}/", name) if home_assistant else {})}
        link = Link(broker, name, lambda text, name=name: print(f"{name}: {text}", file=sys.stderr, flush=True), more, bool(key))
        agent.add_board(name, language, table, make_port, link, key, {"kind": table["name"], "tool": tools.get(name, ""), "laser": lasers.get(name, ""), "page": pages.get(name, "")})
        print(_("{}: {} at {}", name, language, where), flush=True)
    return agent


def _choose_page_key(file, terminal):
    """Return (key of the page at the machine, file that keeps it or None). Without a terminal to print the key on, keep it in a file."""
    from host_tools.clients.page_key import make_key

    if file is None and terminal:
        return make_key(os.urandom), None
    file = file or _PAGE_KEY
    make_key_file(file)
    return key_in(file), file


def _serve_page(port, file, agent, asked, stack):
    """Serve the page for people at the machines. Its orders run in the agent's thread and wait for it, 10 s at most; STOP waits for nothing."""
    from concurrent.futures import Future

    from host_tools.shop.local_page import serve

    terminal = sys.stdout.isatty()
    key, file = _choose_page_key(file, terminal)

    def run_in_agent(function):
        """Return function() as run by the agent's thread. Raises what it raises, or TimeoutError after 10 s."""
        done = Future()

        def answer_call():
            """Run the function in the agent's thread, and give its result or its error to the caller."""
            try:
                done.set_result(function())
            except Exception as error:  # the page hears of it; the agent goes on
                done.set_exception(error)

        asked.put(answer_call)
        return done.result(10)

    close, port = serve(port, key, lambda: run_in_agent(agent.machines), lambda name, what: run_in_agent(lambda: agent.carry_out(name, what)), agent.stop)
    stack.callback(close)
    print(f"page: http://127.0.0.1:{port}/" + (f"#key={key}" if terminal else ""), flush=True)  # a log is no place for a key
    if file:
        print(_("the page's key: {}", file), flush=True)


def _parse_machine_texts(option, texts, boards):
    """Return {machine: text} of the NAME=TEXT of an option. Raises Failure if a machine is unknown, or an address or a laser class is wrong."""
    from host_tools.shop.dispatcher import LASER_CLASSES

    found = dict(text.partition("=")[::2] for text in texts or ())
    for name, text in found.items():
        if name not in boards or not text:
            raise Failure("{} {}={}: NAME=… of a machine is wanted", option, name, text)
        if option == "--page" and not text.startswith(("http://", "https://")):
            raise Failure("--page {}={}: an address is wanted, http://…", name, text)
        if option == "--laser-class" and text not in LASER_CLASSES:
            raise Failure("--laser-class {}={}: one of {} is wanted", name, text, ", ".join(LASER_CLASSES))
    return found


def make_broker(text, user, password, ca):
    """Return the Broker of the command's options. Raises Failure if the address is wrong, or one of --user and --password-file is missing."""
    from host_tools.shop.link import Broker

    host, number = _parse_address("--broker", text)
    if bool(user) != bool(password):
        raise Failure("--user and --password-file belong together")
    return Broker(host, number, user, read_secret(password) if password else "", str(ca) if ca else None)


def _parse_address(option, text):
    """Return (host, port) of HOST:PORT; port 0 if it is missing. Raises Failure."""
    host, colon, number = text.rpartition(":") if text.count(":") == 1 else (text, "", "0")
    if not host or not number.isdigit() or colon and not 0 < int(number) < 65536:
        raise Failure("{} {}: HOST or HOST:PORT is wanted", option, text)
    return host, int(number)


def _serve_figures(address, stack):
    """Serve Figures for Prometheus at `address`, (host, port), until the stack ends, and return them; None if the address is None."""
    if address is None:
        return None
    from host_tools.shop.figures import Figures

    found = Figures()
    stack.callback(found.serve(*address))
    return found


def _parse_boards(ports, virtual):
    """Return {name: (port or board file, True if virtual)} of [NAME=]WHERE texts; a missing name is made of the file's. Raises Failure if a name is
    wrong or comes twice, or there is no board."""
    from host_tools.shop.machines import NAME

    found = {}
    for text, is_virtual in [*((each, False) for each in ports), *((each, True) for each in virtual)]:
        name, equals, where = text.partition("=")
        if not equals or "/" in name:
            name, where = re.sub(r"[^A-Za-z0-9._-]+", "-", Path(text).stem).strip("-._"), text
        if not NAME.fullmatch(name):
            raise Failure("{!r} is no machine's name: at most 40 letters, digits, '.', '_' and '-'", name)
        if name in found:
            raise Failure("two machines are called {}: give names, NAME=…", name)
        found[name] = where, is_virtual
    if not found:
        raise Failure("which board? --port PORT, or --virtual BOARD without hardware")
    return found


def _start_virtual(name, stack):
    """Start a virtual board of the board file `name`; return (language, board file's table, make_port)."""
    from host_tools import boards
    from host_tools.panel.board import Demo, Port

    table = boards.load(name)
    demo = Demo(name)
    stack.callback(demo.close)
    return table["links"][0]["protocol"], table, lambda changed: Port(demo.name, 115_200, changed)


def _find_real(port, baud, protocol, board):
    """Return (language, board file's table, make_port) of the board on a serial port; without `protocol` ask the board, up to some seconds. Raises
    Failure if the agent does not speak its language."""
    from host_tools import boards
    from host_tools.cli.log import find_language
    from host_tools.panel import languages
    from host_tools.panel.board import Port

    language = protocol or find_language(port, baud or languages.BAUD["grbl"])
    if language not in languages.BOARDS:
        raise Failure("{}: the agent speaks {}", language, ", ".join(languages.BOARDS))
    table = boards.load(board or languages.BOARDS[language])
    return language, table, lambda changed: Port(port, baud or languages.BAUD[language], changed)
