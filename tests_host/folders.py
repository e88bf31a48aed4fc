"""The folders of tests: one for each kind of test, and options/KEY/ for the tests of one option."""

from pathlib import Path

TESTS = Path(__file__).resolve().parent
OF_OPTIONS = sorted(path for path in (TESTS / "options").iterdir() if path.is_dir() and not path.name.startswith("_"))
# Modules that several folders use are imported by their bare names, as under MicroPython.
ALL = [*(TESTS / name for name in ("properties", "sims", "tools", "pico", "cores", "rules")), *OF_OPTIONS]
OF_CHECKS = [TESTS / "properties", *OF_OPTIONS]  # those that both interpreters look through for check_*.py


def checks():
    """Names of all check_*.py."""
    return sorted(path.stem for folder in OF_CHECKS for path in folder.glob("check_*.py"))
