"""Paths, hypothesis profiles, the collection of check_*.py, tiers, and the corpus of real files."""

import gc
import importlib.util
import os
import signal
import sys
import time
from pathlib import Path

# Programs that tests start import compiled files: else each takes half a second more.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
BUILDS, KEPT_S = ROOT / "build" / "kept", 86_400

for folder in (ROOT, ROOT / "firmware", ROOT / "host_tools" / "shims", TESTS):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))

import folders  # noqa: E402  it lies in TESTS

sys.path += [str(folder) for folder in folders.ALL if str(folder) not in sys.path]

import own_fonts  # noqa: E402  it lies in TESTS
import tiers  # noqa: E402  it lies in TESTS

from host_tools.emulator import cycles  # noqa: E402

settings.register_profile("local", deadline=None, print_blob=True)
settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "local")


_CYCLES = pytest.StashKey[int]()  # that emulated Picos had lived before the test
MOST = 10  # tests whose emulated time is printed
MARKERS = """
on_a_copy: the test runs in a forked process and may use up what others share
quick: `make check` runs it too
slow: only `make test-all` runs it
unmeasured: no coverage is measured while it runs
programs_measured: coverage is measured of the programs that it starts, too
"""


def pytest_addoption(parser):
    parser.addoption("--tier", choices=tiers.TIERS, default="all", help="how much runs: see tests_host/tiers.py")
    if importlib.util.find_spec("pytest_timeout") is None:  # the core's tests run without it, and warn of nothing
        for name in ("timeout", "timeout_method"):
            parser.addini(name, "of pytest-timeout, which is not installed")


def pytest_configure(config):
    os.environ["LANGUAGE"] = "en"  # tests compare the texts of `passo`
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # a run in the background ignores Ctrl-C, and so would what it starts
        signal.signal(signal.SIGINT, signal.default_int_handler)
    own_fonts.bring()
    os.environ.setdefault("PASSO_PC_KERNELS", "plain")  # coverage sees kernels as Python; test_compiled.py has them as C
    if "PASSO_BUILDS" not in os.environ:  # a board of the same texts is built once, for all workers
        os.environ["PASSO_BUILDS"] = str(BUILDS)
        _forget_old_builds()
    for line in MARKERS.strip().splitlines():
        config.addinivalue_line("markers", line)
    tiers.current = config.getoption("--tier")  # before the test modules are imported


def _forget_old_builds():
    for path in BUILDS.glob("*"):
        if path.stat().st_mtime < time.time() - KEPT_S:
            path.unlink(missing_ok=True)


class CheckModule(pytest.Module):
    """A file of properties: each `check_*` function is a test, with hypothesis if it has parameters."""

    def collect(self):
        from checks import make_tests

        for name, test in make_tests(self.obj).items():
            yield pytest.Function.from_parent(self, name=name, callobj=test)


def pytest_pycollect_makemodule(module_path, parent):
    return CheckModule.from_parent(parent, path=module_path) if module_path.name.startswith("check_") else None


class Backwards(pytest.Dir):
    """A folder whose files are collected from the last to the first."""

    def collect(self):
        return reversed(list(super().collect()))


def pytest_collect_directory(path, parent):
    """Every other worker of xdist collects backwards: each compiles half of the modules imported for the first time, and reads the other half."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0")
    return Backwards.from_parent(parent, path=path) if int(worker[2:]) % 2 else None


def pytest_ignore_collect(collection_path, config):
    """Files of which the tier runs nothing are not imported: most of them, for `make check`."""
    if collection_path.suffix == ".py" and collection_path.name.startswith("test_"):
        return not tiers.reads(collection_path.read_text(encoding="utf-8"), config.getoption("--tier")) or None
    return None


def pytest_collection_modifyitems(config, items):
    """Only what belongs to the tier runs, and of that first what takes a worker longest: the groups of one machine."""
    left_out = [item for item in items if not tiers.runs(_marked(item, "slow"), _marked(item, "quick"))]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in set(left_out)]
    for item in items:
        if item.path.name.startswith("test_pico_"):
            item.add_marker("unmeasured")  # it runs none of the firmware here
        if _marked(item, "slow"):
            item.add_marker(pytest.mark.timeout(0))
    for item in items:
        if not _marked(item, "xdist_group") and _shares(item):
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
        if config.getoption("loadgroup", False):
            _name_its_group(item)
    items.sort(key=lambda item: (not _marked(item, "xdist_group"), item.path))


def _shares(item):
    """Whether it uses a fixture that is made once for its file."""
    return any(made[-1].scope == "module" for made in item._fixtureinfo.name2fixturedefs.values())


def _name_its_group(item):
    """The group stands at the end of a test's id, where xdist's scheduler looks. pytest 9.2 keeps the id elsewhere than xdist 3.8 writes it."""
    if hasattr(item, "_id"):
        group = item.get_closest_marker("xdist_group")
        if group:
            item._id = type(item._id).parse(f"{item.nodeid}@{group.args[0]}")


def _marked(item, name):
    return item.get_closest_marker(name) is not None


def _measuring(item):
    return tiers.measuring(not _marked(item, "unmeasured"), _marked(item, "programs_measured"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    item.stash[_CYCLES] = cycles.spent[0]
    _keep_collections_short(item.path)
    with _measuring(item):
        return (yield)


def _keep_collections_short(path, last=[None]):
    """The firmware collects garbage often. It looks through the objects of pytest, numpy and others only once a file."""
    if path != last[0]:
        last[0] = path
        gc.collect()
        gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if call.when == "call" and cycles.spent[0] > item.stash[_CYCLES]:
        seconds = (cycles.spent[0] - item.stash[_CYCLES]) / cycles.CYCLES_PER_S
        report.user_properties.append(("emulated_s", seconds))
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    with _measuring(item):
        return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    if not pyfuncitem.get_closest_marker("on_a_copy"):
        return None
    from host_tools.emulator.copies import CopyFailed, on_a_copy

    def work():
        wanted = pyfuncitem._fixtureinfo.argnames
        pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in wanted})
        return pyfuncitem.user_properties

    try:
        pyfuncitem.user_properties[:] = on_a_copy(work)
    except CopyFailed as failure:
        pytest.fail(str(failure), pytrace=False)
    return True


@pytest.fixture
def corpus():
    """The folder of real drawings and programs; the test skips where PASSO_CORPUS names none."""
    folder = os.environ.get("PASSO_CORPUS")
    if not folder or not Path(folder).is_dir():
        pytest.skip("PASSO_CORPUS names no folder of real files")
    return Path(folder)


@pytest.fixture
def show(record_property):
    """`show(title, text)` prints at the end of the run, also from a worker of xdist."""

    def add(title, text):
        record_property("show", (title, text))

    return add


def pytest_terminal_summary(terminalreporter):
    reports = terminalreporter.stats.get("passed", []) + terminalreporter.stats.get("failed", [])
    told = [(report, name, value) for report in reports if report.when == "call"
            for name, value in getattr(report, "user_properties", [])]
    for _, name, value in told:
        if name == "show":
            terminalreporter.section(value[0])
            terminalreporter.write_line(value[1])
    emulated = sorted([(value, report.nodeid) for report, name, value in told if name == "emulated_s"], reverse=True)
    if emulated:
        terminalreporter.section(f"{sum(seconds for seconds, _ in emulated):.1f} s of emulated Picos, their boots included")
        for seconds, test in emulated[:MOST]:
            terminalreporter.write_line(f"{seconds:7.2f} s  {test}")
