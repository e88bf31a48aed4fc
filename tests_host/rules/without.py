"""A copy of the repository without an option or a language, and without all that asks for it.

    python tests_host/rules/without.py parking /tmp/copy            # prints all that goes with it
    python tests_host/rules/without.py parking /tmp/copy --run      # and runs the tests of `make check` there

With an option go its folder, options that share its files, and languages that ask for it. Boards go if their files ask for one of these, and modules
of host_tools that import them as they are loaded. Tests go that lie in folders of these names, import them, or load such a board (goes_with.py). Pages go that describe the option or have commands for such a board; links to them
become plain text. Goldens have the rows of the other boards, and docs/reference is made anew.
"""

import ast
import functools
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.append(str(Path(__file__).resolve().parents[1]))

import folders
import test_surface

from host_tools import boards, interpreter, options
from host_tools.build import tree
from host_tools.build.reference import load_manifests
from host_tools.resources import FIRMWARE, ROOT
from passo.config.board_error import inputs_of, options_by_value
from passo.config.boardfile import check

LANGUAGES = FIRMWARE / "passo" / "protocols"
_ROOTS = "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "docs/README.md", "docs/pt/README.md", "docs/inside/architecture.md", "tests_host/README.md"
_MADE = {".git", ".venv", ".hypothesis", ".pytest_cache", "build", "out", "dist"}
_RUN = "import sys, pytest; sys.path.append(%r); sys.exit(pytest.main(sys.argv[1:]))\n"


def language_names():
    """Return the names of the languages that links of a board file may have."""
    return sorted(path.parent.name for path in LANGUAGES.glob("*/__init__.py") if "NEEDS =" in path.read_text(encoding="utf-8"))


def parts(name):
    """Return (options, languages) that go with the option or the language `name`: those that share its files, or ask for it."""
    if name in language_names():
        return set(), {name}
    gone = {name} | {other for other, manifest in load_manifests().items() if name in getattr(manifest, "SHARES", ())}
    return gone, {language for language in language_names() if gone & set(tree.options_asked((LANGUAGES / language / "__init__.py").read_text(encoding="utf-8")))}


def asks_for(board, gone, languages):
    """Return whether a board, as its file says it, asks for one of these options or languages."""
    return bool(gone & ({key for key in board if board[key] is not None} | set(options_by_value(board))) or languages & {link["protocol"] for link in board["links"]})


def boards_with(gone, languages):
    """Return the names of the boards that go: those that ask for these, and those that are like one of them."""
    found = {name for name in boards.names() if asks_for(boards.load(name), gone, languages)}
    return found | {name for base in found for name in boards.names_like(base)}


# --- tests


@functools.lru_cache(maxsize=2)
def _modules(folder):
    """Return {name of a module: (path, names of the modules that it imports as it is loaded)} of tests_host, whose names are bare, or of host_tools."""
    bare = folder == folders.TESTS
    paths = [path for path in folder.rglob("*.py") if path.name != "__init__.py"]
    return {path.stem if bare else ".".join(path.relative_to(ROOT).with_suffix("").parts): (path, _loaded(path.read_text(encoding="utf-8"))) for path in paths}


def _loaded(text):
    """Return the dotted names that a module imports outside of its functions."""
    found, waiting = set(), list(ast.parse(text).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
        elif not isinstance(node, (ast.FunctionDef, ast.Lambda)):
            waiting += ast.iter_child_nodes(node)
    return found


def users_of(modules, folder):
    """Return {name: path} of the modules of a folder that import one of `modules` as they are loaded, or another such module."""
    files, found = _modules(folder), {}
    starts = tuple(name + "." for name in modules)
    more = {name for name, (_, loaded) in files.items() if any(each in modules or each.startswith(starts) for each in loaded)}
    while more:
        found |= {name: files[name][0] for name in more}
        more = {name for name, (_, loaded) in files.items() if loaded & found.keys()} - found.keys()
    return found


# --- pages


def _pages():
    return [path for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "tests_host" / "README.md"] if "benchmarks" not in path.name]


def pages_with(gone, languages, lost):
    """Return the pages that go: that of an option's words, those named like a language, and those with commands for one of the boards `lost`."""
    found = set()
    for option in gone & set(options.words_of_options()):
        page, _, section = getattr(options.words_of_options()[option], "PAGE", "").partition("#")
        if page and not section:
            found.add((ROOT / "docs" / "reference" / page).resolve())
    found |= {path for path in _pages() if path.stem in languages and path.parent.name in ("languages", "use", "machines")}
    commands = re.compile(r"(?:--board|passo wiring) (%s)\b" % "|".join(sorted(lost))) if lost else None
    found |= {path for path in _pages() if commands and commands.search(path.read_text(encoding="utf-8"))}
    found |= {ROOT / "docs" / "pt" / path.relative_to(ROOT / "docs" / each) for path in found for each in ("start", "use") if path.is_relative_to(ROOT / "docs" / each)}
    return {path for path in found if path.is_file() and path.relative_to(ROOT).as_posix() not in _ROOTS}


def _anchor(heading):
    """Return GitHub's name of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lstrip("#").replace("`", "").strip().lower()).replace(" ", "-")


def _unlink(copy):
    """Make plain text of links in the copy that lead nowhere, and of paths, files and methods in inline code that are gone; of those in texts for docs/reference, too."""
    pages = [path for path in copy.rglob("*.md") if ".venv" not in path.parts]
    lost = _code_names(ROOT) - _code_names(copy)
    anchors = {path.resolve(): {_anchor(line) for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")} for path in pages}
    sources = [*(copy / "firmware" / tree.OPTIONS).glob("*/words.py"), copy / "host_tools" / "build" / "board_keys.py"]
    for page in [*pages, *sources]:
        text = page.read_text(encoding="utf-8")
        folder = copy / "docs" / "reference" if page in sources else page.parent

        def leads(target, page=page, folder=folder):
            name, _, part = target.partition("#")
            path = (folder / (name or "board-file.md" if page in sources else name or page.name)).resolve()
            return re.match(r"https?:|mailto:", target) or path.exists() and (not part or part in anchors.get(path, (part,)))

        made = re.sub(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)", lambda found: found[0] if leads(found[3]) else found[2], text)
        made = re.sub(r"`([\w./]+/[\w.]+\.\w+)`", lambda found, folder=folder: found[0] if _is_left(found[1], folder, copy) else found[1], made)
        made = re.sub(r"`((\w+)\.\w+)`", lambda found: found[1] if lost & {found[1], found[2]} else found[0], made)
        if made != text:
            page.write_text(made, encoding="utf-8")


def _code_names(root):
    """Return the names of classes and files of the firmware and the tools, as pages have them in inline code."""
    paths = [path for folder in ("firmware", "host_tools") for path in (root / folder).rglob("*.py")]
    return {name for path in paths for name in (path.name, *re.findall(r"^class (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))}


def _is_left(name, folder, copy):
    """Return whether a path that a page of `folder` names is as it was: there, or no file of the repository."""
    roots = ("", "firmware/passo", "firmware", folder.relative_to(copy).as_posix())
    return not any((ROOT / root / name).exists() for root in roots) or any((copy / root / name).exists() for root in roots)


# --- the copy


def make(name, copy):
    """Make the copy in a new folder. Returns {kind: names} of the options, languages, boards, modules of tools, tests, pages and languages' parts in other folders removed."""
    gone, languages = parts(name)
    lost = boards_with(gone, languages)
    modules = {f"passo.options.{each}" for each in gone} | {f"passo.protocols.{each}" for each in languages} | {f"boards.{each}" for each in lost}
    own = {path for each in gone | languages for room in ("options", "protocols") for path in (folders.TESTS / room / each).glob("*.*")}
    tools = users_of(modules, ROOT / "host_tools")
    tests = own | set(users_of(modules | set(tools) | {path.stem for path in own if path.suffix == ".py"}, folders.TESTS).values())
    pages = pages_with(gone, languages, lost)
    files = [FIRMWARE / tree.OPTIONS / each for each in gone] + [LANGUAGES / each for each in languages]
    parts_of = [path for each in languages for path in [*(FIRMWARE / tree.OPTIONS).glob(f"*/language_{each}.py"), *LANGUAGES.glob(f"page/{each}.py")]]
    files += [path for each in lost for path in [boards.path(each), *(ROOT / "docs").rglob(f"{each}.svg")]]
    shutil.copytree(ROOT, copy, ignore=_needless)
    for path in {*files, *parts_of, *tools.values(), *tests, *pages}:
        left = copy / path.relative_to(ROOT)
        if not left.exists():
            continue  # with its folder
        shutil.rmtree(left) if path.is_dir() else left.unlink()
    for folder in (copy / "tests_host").glob("*/*"):
        if folder.is_dir() and not any(folder.glob("*.*")):
            shutil.rmtree(folder)
    _leave_rows(copy / "tests_host" / "golden" / "boards.txt", lambda row: row.split()[0] not in lost)
    only = _surface_of(lost) - _surface_of(set(boards.names()) - lost) | set(test_surface.texts()) - set(test_surface.texts(copy))
    for surface in [copy / "tests_host" / "golden" / "surface.txt", *(copy / "tests_host" / "options").glob("*/surface.txt")]:
        _leave_rows(surface, lambda row: row not in only)
    _make_environment(copy)
    for _ in range(2):  # the first removes links from the texts for the second
        run(copy, copy / "host_tools" / "build" / "reference.py")
        _unlink(copy)
    names = {what: sorted(path.relative_to(ROOT).as_posix() for path in paths) for what, paths in (("tests", tests), ("pages", pages), ("parts", parts_of))}
    return {"options": sorted(gone), "languages": sorted(languages), "boards": sorted(lost), "tools": sorted(tools), **names}


def _leave_rows(golden, is_left):
    golden.write_text("".join(row + "\n" for row in golden.read_text(encoding="utf-8").splitlines() if is_left(row)), encoding="utf-8")


def _surface_of(names):
    """Return the rows of golden/surface.txt that these boards have: settings, and inputs with a meaning."""
    checked = [check(boards.load(name)) for name in names]
    return {f"setting ${number} {rule[0]}" for board in checked for number, rule in boards.settings_of(board).items()} | {
        f"input {row[0]} {row[1]}" for board in checked for row in inputs_of(board)
    }


def _needless(folder, names):
    """Return the names that no clone has. Compiled files go along: they save half of the time."""
    return set(names) & _MADE if Path(folder) == ROOT else ()


def _make_environment(copy):
    """Give the copy an environment with the packages of this one, in which the project is the copy."""
    here, made = Path(sys.prefix), copy / ".venv"
    packages = Path(ast.__file__).parent.name  # python3.11
    inside = Path("lib") / packages / "site-packages"
    (made / inside).mkdir(parents=True)
    (made / "bin").mkdir()
    shutil.copy(here / "pyvenv.cfg", made)
    for path in (here / "bin").iterdir():
        (made / "bin" / path.name).symlink_to(os.path.realpath(path) if path.name.startswith("python") else path)
    for path in (here / inside).iterdir():
        if path.name.startswith("__editable__"):
            (made / inside / path.name).write_text(path.read_text(encoding="utf-8").replace(str(ROOT), str(copy)), encoding="utf-8")
        elif path.name != "__pycache__":
            (made / inside / path.name).symlink_to(path)


def run(copy, *arguments, may_fail=False):
    """Run a script of the copy with its own modules. Returns (status, output). Raises RuntimeError if it fails, unless it `may_fail`."""
    command = [str(copy / ".venv" / "bin" / "python"), "-P", "-E", *map(str, arguments)]
    done = subprocess.run(command, env=interpreter.environment(), cwd=copy, capture_output=True, text=True)
    if done.returncode and not may_fail:
        raise RuntimeError(done.stdout + done.stderr)
    return done.returncode, done.stdout + done.stderr


def run_tests(copy, gone, *arguments):
    """Run pytest in a copy; `gone`: the result of make(). Returns (status, output)."""
    script = copy / "run.py"
    script.write_text(_RUN % str(copy / "tests_host" / "rules"), encoding="utf-8")
    os.environ["PASSO_GONE"] = ",".join(gone["options"] + gone["languages"] + ["boards." + name for name in gone["boards"]] + gone["tools"] + gone["pages"] + gone["parts"])
    try:
        return run(copy, script, "-q", "-p", "no:cacheprovider", "-p", "goes_with", *arguments, may_fail=True)
    finally:
        del os.environ["PASSO_GONE"]


if __name__ == "__main__":
    _copy = Path(sys.argv[2]).resolve()
    _gone = make(sys.argv[1], _copy)
    for _what, _names in _gone.items():
        print(f"{_what}: {len(_names)} {' '.join(_names)}")
    if "--run" in sys.argv:
        _status, _said = run_tests(_copy, _gone, "--tier", "check", "-n", "2", "--dist", "loadgroup", *sys.argv[4:])
        print(_said)
        sys.exit(_status)
