"""The project as pip installs it, not editable: a wheel of a copy of the sources, in a fresh environment, used in another
folder. The packages it depends on are those of the environment in which the tests run; the project itself is not.
"""

import ast
import importlib.metadata
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import tomllib
import urllib.request
import venv
import zipfile
from pathlib import Path

import pytest

from host_tools import boards, interpreter
from host_tools.resources import FIRMWARE, ROOT
from test_docs import PAGES, shown_commands

pytestmark = pytest.mark.xdist_group("install")
COPIED = ("LICENSE", "README.md", "boards", "examples", "firmware", "host_tools", "pyproject.toml", "setup.py")
GCODE = "G21G90\nG1X10F600\nG2X20Y10I10J0\nM2\n"
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">'
    '<path d="M5 5 L35 5 L35 25 Z" fill="none" stroke="black"/></svg>'
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel's file."""
    pytest.importorskip("setuptools", "70.1")
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copyfile(ROOT / name, source / name)
    modules = source / "host_tools" / "kernels" / "modules"  # as `make wheel` fills it
    modules.mkdir(exist_ok=True)
    (modules / "0123.mpy").write_bytes(b"M")
    command = [*interpreter.python(), "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-index", "--no-build-isolation"]
    done = subprocess.run([*command, "-w", folder, source], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return next(folder.glob("passo-*.whl"))


@pytest.fixture(scope="module")
def passo(wheel, tmp_path_factory):
    """passo(*arguments) runs the installed command in `passo.folder`; with start=True it only starts it. `keys`: the bytes that a pipe gives it."""
    folder = tmp_path_factory.mktemp("installed")
    environment = folder / "environment"
    venv.create(environment, with_pip=False)
    python = environment / "bin" / "python"
    command = [*interpreter.python(), "-m", "pip", "--quiet", "--disable-pip-version-check", "--python", python, "install"]
    done = subprocess.run([*command, "--no-deps", "--no-index", "--no-compile", wheel], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    site = next((environment / "lib").glob("python*/site-packages"))
    # A path in a .pth file is searched, but the .pth files there are not read: an editable project stays out of it.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    kept = {name: value for name, value in interpreter.environment().items() if name != "VIRTUAL_ENV"}

    def run(*arguments, start=False, keys=""):
        words = [environment / "bin" / "passo", *arguments]
        options = {"cwd": elsewhere, "env": {**kept, "COLUMNS": "200"}, "text": True}
        if start:
            return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
        return subprocess.run(words, input=keys, capture_output=True, timeout=300, **options)

    run.folder = elsewhere
    run.site = site
    return run


def good(result):
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_the_wheel_is_whole(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    modules = {path.relative_to(FIRMWARE).as_posix() for path in (FIRMWARE / "passo").rglob("*.py")}
    modules |= {path.relative_to(ROOT).as_posix() for path in (ROOT / "host_tools").rglob("*")
                if path.is_file() and path.suffix not in (".md", ".pyc")}  # fmt: skip
    modules |= {f"passo_boards/{name}.py" for name in boards.names()} | {"host_tools/firmware/main.py", "host_tools/kernels/modules/0123.mpy"}
    assert not modules - names


def test_its_top_level_has_names_of_its_own(wheel):
    top = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {name for name in top if not name.endswith(".dist-info")} == {"host_tools", "passo", "passo_boards", "passo_examples"}


def test_version_and_first_steps(passo):
    assert re.fullmatch(r"passo \d+\.\d+\.\d+\n", good(passo("--version")))
    assert "Try this first" in good(passo())


def test_nothing_of_the_checkout_is_used(passo):
    script = "import host_tools.resources as r, passo; print(r.FIRMWARE, r.MAIN, r.BOARDS, passo.__path__[0])"
    python = passo.site.parents[2] / "bin" / "python"
    said = subprocess.run([python, "-c", script], cwd=passo.folder, capture_output=True, text=True, check=True).stdout
    places = [Path(place) for place in said.split()]
    assert len(places) == 4 and all(place.is_relative_to(passo.site) and place.exists() for place in places)


def test_build_and_flash_from_another_folder(passo):
    assert "bytes in all" in good(passo("build", "--board", "plotter_2014"))
    built = passo.folder / "build" / "plotter_2014"
    assert (built / "main.py").read_text() == (FIRMWARE / "main.py").read_text()
    assert (built / "board.py").read_text() == (ROOT / "boards" / "plotter_2014.py").read_text()
    assert (built / "passo" / "app.mpy").is_file() and (built / "passo" / "protocols" / "plotter" / "__init__.mpy").is_file()
    last = good(passo("flash", "--board", "plotter_2014", "--dry-run")).splitlines()[-1]
    assert str(passo.site / "host_tools" / "build" / "remove_stale.py") in last


@pytest.mark.slow
def test_a_board_file_of_the_users_own_by_path(passo, tmp_path):
    own = tmp_path / "mine.py"
    own.write_text((ROOT / "boards" / "plotter_2014.py").read_text().replace('"baud": 57600', '"baud": 19200'))
    assert own.read_text() != (ROOT / "boards" / "plotter_2014.py").read_text()
    good(passo("build", "--board", own))
    assert (passo.folder / "build" / "mine" / "board.py").read_text() == own.read_text()
    relative = os.path.relpath(own, passo.folder)
    good(passo("flash", "--board", relative, "--dry-run"))
    process = passo("board", "--board", relative, "--time", "fast", start=True)
    assert process.stdout.readline().startswith("port: /dev/")
    process.send_signal(signal.SIGTERM)
    assert process.wait(20) == 0, process.stderr.read()
    process.stdout.close()
    process.stderr.close()


def test_check_and_draw(passo):
    (passo.folder / "part.gcode").write_text(GCODE)
    (passo.folder / "part.svg").write_text(SVG)
    assert "time" in good(passo("check", "part.gcode"))
    good(passo("draw", "part.svg", "--dry-run"))


def by_themselves(page):
    """The commands of `passo` on a page that want no machine and no file of the reader's own."""
    for words in shown_commands(page.read_text(encoding="utf-8"), "passo"):
        of_docs = any((ROOT / word).is_file() for word in words if word.startswith("examples/"))
        alone = words[:1] in (["check"], ["compile"], ["calibrate"]) or "--dry-run" in words
        if "--help" in words or of_docs and alone:
            yield words


# Guides are run whole, below; those in Portuguese have the same commands (tests_host/rules/test_guides.py).
START = ROOT / "docs" / "start"
GUIDES = sorted([*(START / "machines").glob("*.md"), START / "class.md", START / "try.md", START / "quick-start.md", ROOT / "README.md"])
REFUSED = {"stream examples/first.gcode --port /tmp/router": "in alarm"}  # as class.md shows
OTHERS = [page for page in PAGES if (page.name == "README.md" or page not in GUIDES) and "pt" not in page.parts and any(by_themselves(page))]


@pytest.mark.parametrize("page", [pytest.param(page, id=page.name) for page in OTHERS])
def test_what_a_document_shows(passo, page):
    emptied(passo)
    good(passo("examples"))
    for words in by_themselves(page):
        good(passo(*words))


# --- guides, from the first command to the last

FOR_PEOPLE = ("--open", "--serve")  # they show their result in a browser, tested elsewhere: those that wait for one are started and ended


def sessions(page):
    """[(board file, [words of its commands, in their order])] of each section of a guide; the board is that which the section flashes, or the page."""
    text = page.read_text(encoding="utf-8")
    board = _flashed(text, "router_3axis")
    for section in re.split(r"^## ", text, flags=re.MULTILINE):
        yield _flashed(section, board), shown_commands(section, "passo", mentioned=False)


def _flashed(text, otherwise):
    found = re.search(r"passo flash --board (\w+)", text)
    return found[1] if found else otherwise


def emptied(passo):
    """The folder of `passo`, with nothing in it."""
    shutil.rmtree(passo.folder)
    passo.folder.mkdir()
    return passo.folder


class Session:
    """Runs the commands of a section; a virtual board goes on behind those that follow until it is ended, as Ctrl-C would."""

    def __init__(self, passo, board, link):
        self._passo, self._board, self._link = passo, board, link
        self._running, self._panel = [], None

    def run(self, words):
        waits = words[:1] == ["board"] or any(word in words for word in FOR_PEOPLE)
        if words[:1] == ["plot"]:
            self.end()
        elif self._panel is not None:  # one program has a port at a time
            self._running.remove(self._panel)
            self._ended(self._panel)
            self._panel = None
        refused = REFUSED.get(" ".join(words))
        words = [str(self._link) if word.startswith(("/tmp/", "/dev/tty")) else word for word in words]
        if words[:1] == ["flash"]:
            words = [*words[: words.index("--port")], "--dry-run"]
        elif str(self._link) in words and words[:1] != ["board"] and not self._running:
            self._start(["board", "--board", self._board, "--link", str(self._link), "--time", "fast"])
        if waits:
            self._start([word for word in words if word != "--open"])
        elif refused:
            done = self._passo(*words)
            assert done.returncode == 1 and refused in done.stderr, done
        elif words[:1] != ["ports"]:  # whose boards are those of this PC
            good(self._passo(*words))

    def _start(self, words):
        if words[0] == "site":
            words[words.index("--serve") + 1] = "0"
        elif words[0] == "panel":
            words += ["--http", "0"]
        process = self._passo(*words, start=True)
        self._running.append(process)
        self._panel = process if words[0] == "panel" else self._panel
        for line in process.stdout:
            if re.match("port|page|http|.*http://", line):
                return
        raise AssertionError(f"passo {' '.join(words)}: {process.stderr.read()}")

    def end(self):
        while self._running:
            self._ended(self._running.pop())

    def _ended(self, process):
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        process.stdout.close()
        process.stderr.close()


@pytest.mark.parametrize("page", [
    pytest.param(page, id=page.stem, marks=[] if page.stem == "kit" else pytest.mark.slow) for page in GUIDES
])  # fmt: skip
def test_every_command_of_a_guide(passo, page, tmp_path):
    """In an empty folder and the page's order: a virtual board stands for the real one, and `flash` only says what it would copy."""
    emptied(passo)
    count = 0
    for board, commands in sessions(page):
        session = Session(passo, board, tmp_path / "port")
        try:
            for words in commands:
                session.run(words)
                count += 1
        finally:
            session.end()
    assert count >= 3


@pytest.mark.slow
def test_the_first_motion_of_the_quick_start(passo, tmp_path):
    """The lines that the quick start types into the terminal: state, unlock, a jog; the board answers as the page says."""
    import serial

    text = (START / "quick-start.md").read_text(encoding="utf-8")
    terminal = re.search(r"pyserial-miniterm -e --eol LF (\S+) (\d+)\n\n +`(.)` shows the state, `(\S+)` unlocks, `([^`]+)` jogs a millimetre", text)
    assert terminal, "the quick start says something else"
    process = passo("board", "--board", "router_3axis", "--link", str(tmp_path / "port"), "--time", "fast", start=True)
    try:
        assert process.stdout.readline().startswith("port: ")
        with serial.Serial(str(tmp_path / "port"), int(terminal[2]), timeout=20) as port:

            def said(text, until):
                port.write(text.encode())
                heard = port.read_until(until)
                assert heard.endswith(until), heard
                return heard

            where = re.search(rb"MPos:([-\d.]+)", said(terminal[3], b">"))
            said(terminal[4] + "\n", b"ok\r\n")
            said(terminal[5] + "\n", b"ok\r\n")
            report = b""
            while b"Idle" not in report:
                report = said(terminal[3], b">")
            assert float(re.search(rb"MPos:([-\d.]+)", report)[1]) - float(where[1]) == pytest.approx(1, abs=0.01)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=30)
        process.stdout.close()
        process.stderr.close()


def test_a_panel_and_its_page(passo):
    """The packages that `passo panel` imports come with the command, and its page lies in the wheel."""
    process = passo("panel", "--demo", "--http", "0", start=True)
    try:
        address = ""
        for line in process.stdout:
            found = re.search(r"http://127\.0\.0\.1:\d+/", line)
            if found:
                address = found[0]
                break
        assert address, process.stderr.read()
        page = urllib.request.urlopen(address, timeout=30).read().decode()
        assert "<title>Passo" in page
        assert b"enable" in urllib.request.urlopen(address + "panel.js", timeout=30).read()
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
        process.stdout.close()
        process.stderr.close()


def test_what_a_panel_imports_is_no_extra():
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    assert any(name.startswith("microdot") for name in wanted)
    plain = {re.split(r"[<>=]", name)[0].replace("-", "_") for name in wanted} | {"serial", "passo", "host_tools"}
    for path in (ROOT / "host_tools" / "panel").glob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [node.module] if isinstance(node, ast.ImportFrom) else [each.name for each in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                first = name.split(".")[0]
                assert first in plain or first in sys.stdlib_module_names, (path.name, name)


def _link_packages(site, names):
    """Link the files of these distributions and of those that they require into a folder `site`."""
    wanted, linked = list(names), set()
    while wanted:
        name = wanted.pop()
        if name in linked:
            continue
        linked.add(name)
        distribution = importlib.metadata.distribution(name)
        for top in {file.parts[0] for file in distribution.files or () if not file.parts[0].startswith(("..", "__pycache__"))}:
            if not (site / top).exists():
                (site / top).symlink_to(distribution.locate_file(top))
        wanted += [re.match(r"[\w.-]+", text)[0] for text in distribution.requires or () if ";" not in text]


@pytest.mark.parametrize("page", ["README.md", "docs/pt/README.md", "docs/use/core.md", "docs/pt/core.md"])
def test_the_core_is_tested_with_the_packages_that_a_page_names(page, tmp_path):
    """In an environment that has those, and neither Passo nor what `make check` brings."""
    text = (ROOT / page).read_text(encoding="utf-8")
    packages = re.search(r"^    python -m pip install (.+)$", text, re.MULTILINE)[1].split()
    arguments = re.search(r"^    python -m pytest (.+)$", text, re.MULTILINE)[1].split()
    venv.create(tmp_path / "environment", with_pip=False)
    _link_packages(next((tmp_path / "environment" / "lib").glob("python*/site-packages")), packages)
    command = [tmp_path / "environment" / "bin" / "python", "-m", "pytest", "-p", "no:cacheprovider", *arguments]
    done = subprocess.run(command, cwd=ROOT, env=interpreter.environment(), capture_output=True, text=True)
    assert done.returncode == 0 and " passed" in done.stdout and not re.search("skipped|warning", done.stdout), done.stdout + done.stderr


def test_the_line_that_a_newcomer_changes_is_there(tmp_path):
    """As core.md says: its command stops at the test that it names, and all of them find what it says."""
    text = (ROOT / "docs" / "use" / "core.md").read_text(encoding="utf-8")
    part = text[text.index("## Change a line") : text.index("## Draw what it makes")]
    line = re.search(r"^    (state.+)$", part, re.MULTILINE)[1]
    for name in ("firmware", "host_tools", "tests_host"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copyfile(ROOT / "pyproject.toml", tmp_path / "pyproject.toml")
    file = tmp_path / re.search(r"`(firmware/\S+)`", part)[1]
    source = file.read_text(encoding="utf-8")
    assert source.count(line + "\n") == 1
    file.write_text(source.replace(line + "\n", line + " + 1\n"), encoding="utf-8")
    arguments = re.search(r"^    python -m pytest (.+)$", part, re.MULTILINE)[1].split()
    assert arguments[0] == "-x"
    named = re.findall(r"`(check_\w+)`", part)
    for words, expected in ((arguments, named[:1]), (arguments[1:], named)):
        command = [*interpreter.python(), "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *words]
        done = subprocess.run(command, cwd=tmp_path, env=interpreter.environment(CI="1"), capture_output=True, text=True)
        assert re.findall(r"^FAILED \S+::(\w+)", done.stdout, re.MULTILINE) == expected, done.stdout + done.stderr
