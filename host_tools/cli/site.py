"""`passo site`: the page with the firmware in it, as files that any web server serves."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.language import _


def site(
    out: Annotated[Path, typer.Option("--out", help="Folder to write; emptied first, if it holds an older site.")] = Path("build/site"),
    serve: Annotated[
        Optional[int], typer.Option("--serve", metavar="PORT", min=0, max=65535, help="Serve it here, for this PC only. 0: any free port.")
    ] = None,
):
    """Write the page as a static site in which the firmware itself runs, in the browser's tab: no board, nothing installed.

    MicroPython for the browser (WebAssembly) comes from npm's registry the first time, is checked against its known checksum and
    kept in ~/.cache/passo. The site asks for nothing outside of itself.

    Examples:

        passo site --serve 8000                # then open http://127.0.0.1:8000/
        passo site --out public                # for any file server; try it: python -m http.server -d public
    """
    from rich.console import Console

    from host_tools.site import builder

    with Console(stderr=True).status(_("MicroPython from npm, the firmware, the page")):
        size = builder.build(out, builder.load_package())
    print(_("site: {}, {} files, {:.1f} MB", out, len(list(out.iterdir())), size / 1e6))
    if serve is not None:
        _serve_folder(out, serve)


def _serve_folder(folder, port):
    """Serve a folder on 127.0.0.1 until Ctrl-C."""
    from functools import partial
    from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

    class Quiet(SimpleHTTPRequestHandler):
        """A file server that prints nothing."""

        def log_message(self, *_):
            """Print nothing about requests of the page."""

    with ThreadingHTTPServer(("127.0.0.1", port), partial(Quiet, directory=folder)) as server:
        try:
            print(f"page: http://127.0.0.1:{server.server_port}/\n" + _("Ctrl-C ends it."), flush=True)
            server.serve_forever()
        except KeyboardInterrupt:
            pass
