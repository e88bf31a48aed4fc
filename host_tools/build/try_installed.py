"""The first commands of a newcomer with an installed Passo, on any system: run it by that installation's Python.

    python -m host_tools.build.try_installed [UF2]

Wants the extra `draw`. With Passo's UF2 of an RP2040 `passo prove` measures an emulated Pico that runs it; this wants the extra `emulate`, and a C
compiler to be done in two minutes. The virtual board and what stands on it (a port of its own, the demo) want Linux or macOS; elsewhere it leaves
them out, and names them. Every wait has an end.
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import urllib.request
from pathlib import Path

from host_tools import interpreter
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import version

WAIT_S = 600
PROVE_S = 1800  # without a C compiler
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40"><path d="M5 5H55V35H5Z" fill="none" stroke="black"/></svg>'


def main():
    """Run the first commands, and a proof on an emulated Pico if a UF2 is named. Raises Failure."""
    uf2 = Path(sys.argv[1]).resolve() if sys.argv[1:] else None
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("part.svg").write_text(SVG, encoding="utf-8")
        shown = run_passo("--version")
        if shown.strip() != f"passo {version()}":
            raise Failure("passo --version says {!r}", shown)
        run_passo("flash", "--board", "router_3axis", "--dry-run")
        run_passo("draw", "part.svg", "--dry-run")
        if os.name == "nt":
            print(_("left out on Windows: passo board, passo panel --demo"))
        else:
            with Started("port: ", "board", "--link", "port", "--time", "fast"):
                run_passo("draw", "part.svg", "--port", "port")
            with Started(r"http://127\.0\.0\.1:\d+/", "panel", "--demo", "--http", "0") as panel:
                page = urllib.request.urlopen(panel.found, timeout=WAIT_S).read().decode()
                if "<title>Passo" not in page:
                    raise Failure("the panel's page is {!r}", page[:200])
        if uf2:
            print(run_passo("prove", "--emulated", "router_3axis", "--uf2", str(uf2), wait_s=PROVE_S))
        else:
            print(_("left out, because no UF2 was named: passo prove"))
        os.chdir(Path(__file__).parent)  # Windows removes no folder that a program is in
    print(_("tried: Passo {} in Python {} on {}", version(), ".".join(map(str, sys.version_info[:3])), sys.platform))


def passo_command(*words):
    """Return the command that runs this installation's `passo`."""
    return [*interpreter.passo(), *words]


def run_passo(*words, wait_s=WAIT_S):
    """Return the output of a command, which has `wait_s` to end. Raises Failure if it fails, TimeoutExpired."""
    print("$ passo", *words, flush=True)
    done = subprocess.run(passo_command(*words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, timeout=wait_s)
    if done.returncode:
        raise Failure("passo {} ended with {}: {}", " ".join(words), done.returncode, done.stdout)
    return done.stdout


class Started:
    """A command that runs until its `with` block ends; `found`: the match in its output."""

    def __init__(self, wanted, *words):
        print("$ passo", *words, flush=True)
        self._wanted, self._words, self.found = wanted, words, ""

    def __enter__(self):
        self._process = subprocess.Popen(passo_command(*self._words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
        late = threading.Timer(WAIT_S, self._process.kill)
        late.start()
        heard = []
        for line in self._process.stdout:
            heard.append(line)
            match = re.search(self._wanted, line)
            if match:
                late.cancel()
                self.found = match[0]
                return self
        late.cancel()
        raise Failure("passo {} ended: {}", " ".join(self._words), "".join(heard))

    def __exit__(self, *_error):
        self._process.terminate()
        self._process.communicate(timeout=60)


if __name__ == "__main__":
    try:
        main()
    except (Failure, subprocess.TimeoutExpired) as failure:
        sys.exit(str(failure))
