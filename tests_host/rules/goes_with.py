"""A plug-in of pytest for a copy without an option (without.py): tests that ask for it at run time go with it.

PASSO_GONE has the names of the options, languages, boards, tools and pages removed. A test asks for one if it, or a program that it starts, loads a board file with
the option's key, or one of these boards; if it reads one of these pages or board files; or if a file of tests_host imports the module. It is skipped: "goes with
parking". An import of such a module by any other file is a fault.
"""

import os
import re
from pathlib import Path

import pytest

GONE = set(filter(None, os.environ.get("PASSO_GONE", "").split(",")))
_TESTS = Path(__file__).resolve().parents[1].name
# {prefix of the name in GONE: texts of errors}
_TEXTS = {
    "": r"unknown key '(\w+)'|asks for the option (\w+)|protocol: '(\w+)' is none of",
    "drive_": r"drive\.kind: '(\w+)' is none of",
    "player_": r"player: '(\w+)' is none of",
    "boards.": r"unknown board '(\w+)'|[Nn]o module named '(?:boards\.)?(\w+)'",
}


def asked_for(error):
    """Return the name of an option, a language or a board that caused the error because it is removed; None if the cause is another."""
    while error is not None:
        name = next(iter(_names_in(error) & GONE), None)
        if name:
            return name
        error = error.__cause__ or error.__context__
    return None


def _names_in(error):
    """Return the names that an error may be about, as GONE has them."""
    if isinstance(error, ModuleNotFoundError) and (error.name or "").startswith("host_tools."):
        return {error.name}
    if isinstance(error, ModuleNotFoundError) and (error.name or "").startswith("passo."):
        return {error.name.split(".")[2]} if error.name.count(".") > 1 and _TESTS in _importer(error).parts else set()
    if isinstance(error, FileNotFoundError):
        return {name for name in GONE if str(error.filename).endswith(f"/{name[7:]}.py" if name.startswith("boards.") else "/" + name)}
    return {start + name for start, texts in _TEXTS.items() for found in re.finditer(texts, str(error)) for name in found.groups() if name}


def _importer(error):
    """Return the path of the file with the import statement."""
    found, trace = "", error.__traceback__
    while trace:
        name = trace.tb_frame.f_code.co_filename
        found = found if name.startswith("<frozen importlib") else name
        trace = trace.tb_next
    return Path(found)


def _leave_out(report, error):
    name = report.outcome == "failed" and error is not None and asked_for(error)
    if name:
        report.outcome, report.longrepr = "skipped", (str(getattr(report, "fspath", report.nodeid)), 0, f"goes with {name}")
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    return _leave_out(report, call.excinfo.value if call.excinfo else None)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    report = yield
    call = getattr(report, "call", None)
    return _leave_out(report, call.excinfo.value if call and call.excinfo else None)
