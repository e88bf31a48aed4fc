"""`passo shop`: the queue of all machines on a broker, and their page."""

import asyncio
import os
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.agent import make_broker
from host_tools.cli.key_option import key_in, make_key_file
from host_tools.failure import Failure, reason
from host_tools.language import _

_SHARE = Path.home() / ".local" / "share" / "passo"


def shop(
    broker: Annotated[str, typer.Option(metavar="HOST[:PORT]", help="The MQTT broker, for example Mosquitto.")],
    book: Annotated[Path, typer.Option(metavar="FILE", help="The book of jobs. Keep it: it knows which machine has which job.")] = _SHARE / "shop.sqlite",
    key: Annotated[Path, typer.Option("--shop-key", metavar="FILE", help="The key of the shop and its agents; it is made if there is none.")] = _SHARE / "shop.key",
    host: Annotated[str, typer.Option(help="Address to serve; 0.0.0.0: also other computers in this network.")] = "127.0.0.1",
    http: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page; 0: any free one.")] = 8090,
    user: Annotated[str, typer.Option(help="The broker's user for the shop.")] = "",
    password: Annotated[Optional[Path], typer.Option("--password-file", help="File with the user's password, which other users cannot read.")] = None,
    ca: Annotated[Optional[Path], typer.Option(metavar="FILE.crt", help="Certificate of the authority that has signed the broker's: speak TLS.")] = None,
):
    """Queue jobs for the machines of all agents, and show the machines on one page.

    Drop a file on the page: it is checked, and waits. A machine takes the next job that fits when somebody at it says that paper is in
    (passo agent --at-machine). The book gives each job to one machine, once; the machine's journal knows how far it has come.

    It prints the page's address with a key for those who may queue jobs. Without the key the page shows the machines, and can stop them all.
    The agents want the other key, that of --shop-key: copy the file.

    Examples:

        passo shop --broker localhost

        passo shop --broker shop.local --user shop --password-file mqtt.txt --ca ca.crt --host 0.0.0.0
    """
    from host_tools.clients.page_key import make_key
    from host_tools.shop.job_table import JobTable
    from host_tools.shop.dispatcher import Dispatcher
    from host_tools.shop.shop_server import Shop

    broker = make_broker(broker, user, password, ca)
    make_key_file(key)
    secret = key_in(key)
    try:
        book.parent.mkdir(parents=True, exist_ok=True)
        opened = JobTable(book)
    except (OSError, _database_error()) as error:
        raise Failure("cannot use the book {}: {}", book, reason(error)) from error
    page_key = make_key(os.urandom)
    dispatcher = Dispatcher(broker, secret, opened)
    try:
        served = Shop(dispatcher, opened, page_key, host)
        asyncio.run(served.run(host, http, lambda number: _print_address(host, number, page_key, key)))
    finally:
        dispatcher.close()
        opened.close()


def _database_error():
    """Return the exception class of SQLite, imported when it is needed."""
    import sqlite3

    return sqlite3.Error


def _print_address(host, number, page_key, path):
    """Print the page's address with its key, and the file of the agents' key."""
    address = f"http://{'127.0.0.1' if host == '0.0.0.0' else host}:{number}/"
    print(f"page: {address}#key={page_key}")
    print(_("the agents' key: {}", path))
    print(_("Ctrl-C ends it."), flush=True)
