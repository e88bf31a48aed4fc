"""Paths, hypothesis profiles and the corpus of real files."""

import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent

for folder in (ROOT, ROOT / "firmware", ROOT / "host_tools" / "shims", TESTS):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))

# Check modules are not test files by name; their assertions deserve the same explanations.
pytest.register_assert_rewrite(*sorted(path.stem for path in TESTS.glob("check_*.py")))

settings.register_profile("local", deadline=None, print_blob=True)
settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def pytest_configure(config):
    config.addinivalue_line("markers", "on_a_copy: the test runs in a forked process and may use up what others share")


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
    for report in terminalreporter.stats.get("passed", []) + terminalreporter.stats.get("failed", []):
        for name, value in getattr(report, "user_properties", []):
            if name == "show" and report.when == "call":
                terminalreporter.section(value[0])
                terminalreporter.write_line(value[1])
