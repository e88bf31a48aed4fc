"""The packages of a wheel: every folder that has modules, and two folders under names of their own. All else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup

ROOT = Path(__file__).resolve().parent


def packages(folder, name):
    """Names of the packages in a folder that is package `name`."""
    return sorted({".".join([name, *path.parent.relative_to(folder).parts]) for path in folder.rglob("*.py")})


setup(
    packages=[
        *packages(ROOT / "host_tools", "host_tools"),
        "host_tools.firmware",  # main.py
        *packages(ROOT / "firmware" / "passo", "passo"),
        "passo_boards",
        "passo_examples",
    ]
)
