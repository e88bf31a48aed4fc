"""The declared packages and dependencies are exactly those in use."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions

import pytest
from parsed import parse

from host_tools.resources import ROOT

pytestmark = pytest.mark.quick

OWN = {"passo", "host_tools", "boards", "micropython"}
ON_THE_BOARD = {"board", "machine", "passo_image", "rp2", "uctypes", "vfs"}  # of the code that host_tools/prove runs on a board


def imported(folder):
    """Names of the packages that the files of a folder import, anywhere in them."""
    found = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                found.add(node.module.split(".")[0])
    return found - set(sys.stdlib_module_names) - OWN - ON_THE_BOARD


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def pyproject():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def project():
    return pyproject()["project"]


def test_every_import_of_the_host_tools_is_declared():
    declared = {plain(re.match(r"[\w.-]+", line)[0]) for line in project()["dependencies"] + extras(project())}
    owners = packages_distributions()
    missing = {
        name for name in imported(ROOT / "host_tools") if not declared & set(map(plain, owners.get(name, [])))
    }
    assert not missing, f"imported, but not a dependency in pyproject.toml: {', '.join(sorted(missing))}"


def extras(project):
    return [line for lines in project["optional-dependencies"].values() for line in lines]


def packages():
    """Return the packages that setup.py gives to setuptools."""
    declared = []
    tree = parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    code = compile(ast.Module([node for node in tree.body if "setuptools" not in ast.dump(node)], []), "setup.py", "exec")
    names = {"setup": lambda packages: declared.extend(packages), "__file__": str(ROOT / "setup.py")}
    exec(code, names)
    return declared


def test_every_package_is_installed():
    """setup.py finds each folder with modules: one that it does not find is in no wheel."""
    mapped = pyproject()["tool"]["setuptools"]["package-dir"]
    folders = {path.parent.relative_to(ROOT).as_posix()
               for top in ("host_tools", "firmware", "boards") for path in (ROOT / top).rglob("*.py")}  # fmt: skip

    def folder_of(package):
        start = max((name for name in mapped if package == name or package.startswith(name + ".")), key=len)
        return mapped[start] + package[len(start) :].replace(".", "/")

    assert {folder_of(package) for package in packages()} == folders | {"examples"}
