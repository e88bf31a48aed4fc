"""Starts CPython and MicroPython so that they find only modules of Python, of Passo and of packages installed beside it.

    subprocess.Popen(passo("board", "--board", "plotter_2014"))
    subprocess.run([*python(), "-c", "print(1)"])
    subprocess.run([*micropython_command(), script], env=environment(folder), cwd=folder)

A user stands in a folder of downloads, where a `struct.py` or a folder `passo` may lie: neither the current folder nor the paths of the
user's environment are searched (-P, -E). The user's own site-packages are, for Passo may be installed there.
MicroPython always searches its current folder first, so it starts in one of ours.

Every program that Passo or a test starts goes by this module, and main() of `passo` calls isolate_process() for the rest:
multiprocessing, mpremote's own children, a page's browser.
"""

import importlib.util
import os
import sys

_PATHS = "PYTHONPATH", "PYTHONHOME", "MICROPYPATH"  # the user's variables with folders of modules
_RUN_SCRIPT = "import runpy, sys; sys.path[:0] = {!r}; del sys.argv[0]; runpy.run_path(sys.argv[0], run_name='__main__')"
_RUN_MICROPYTHON = "import sys; sys.path.append({!r}); import micropython_unix; micropython_unix.main()"


def python(*folders):
    """Return the command that runs CPython; -m MODULE, -c CODE or a script follow. With `folders` a script follows, which finds modules
    there, too."""
    flags = ["-P", "-E", *["-s"] * bool(sys.flags.no_user_site), *["-X", "utf8"] * bool(sys.flags.utf8_mode)]
    return [sys.executable, *flags, *(["-c", _RUN_SCRIPT.format([os.path.abspath(each) for each in folders])] if folders else [])]


def passo(*words):
    """Return the command that runs `passo` with these words."""
    return [*python(), "-m", "host_tools.cli", *map(str, words)]


def mpremote_command(port):
    """Return the command that runs mpremote with the board on `port`; its own commands follow."""
    return [*python(), "-m", "mpremote", "connect", port]


def micropython_command():
    """Return the command that runs MicroPython, None if it is not installed. It runs as a module of CPython, and starts in 6 ms instead of 18 because
    it looks for no other modules."""
    found = importlib.util.find_spec("micropython_unix")
    return [sys.executable, "-I", "-S", "-c", _RUN_MICROPYTHON.format(os.path.dirname(found.origin))] if found else None


def environment(*folders, **more):
    """Return the environment of a program that is started, with `more` in it. MicroPython finds modules in `folders`; the user's paths are
    left out."""
    kept = {name: value for name, value in os.environ.items() if name not in _PATHS}
    return {**kept, **({"MICROPYPATH": os.pathsep.join(map(str, folders))} if folders else {}), **more}


def isolate_process():
    """Let this process find no modules in the current folder, and processes that it starts in other ways neither there nor in the user's paths.
    Windows looks for programs in the current folder first if no variable forbids it."""
    for name in _PATHS:
        os.environ.pop(name, None)
    os.environ |= {"PYTHONSAFEPATH": "1", "NoDefaultCurrentDirectoryInExePath": "1"}
    leave_current_folder()


def leave_current_folder():
    """Take the current folder off the path of modules, unless Passo itself lies there."""
    try:
        here = os.getcwd()
    except OSError:
        return  # it has been removed
    if here != os.path.dirname(os.path.dirname(os.path.abspath(__file__))):
        sys.path[:] = [each for each in sys.path if each not in ("", os.curdir, here)]
