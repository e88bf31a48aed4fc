"""Builds what a release consists of, in a clean clone of this commit, twice where bytes are compared, and tries the wheel.

    make release                                            # build/release/assets; the commit has the tag of the version
    make release DRY=1                                      # without a tag
    make release DRY=1 ARGS=tests_host/rules CHIPS=rp2040   # some of the tests (ARGS=- none), some of the UF2s

Runs .ci/run, then: kernels' modules, sdist and wheel, a UF2 of each chip, the RP2040's on an emulated Pico, the firmware of each board for mip,
the site, SBOM, checksums.
Makes environments anew from the hashes in locks/, and uses nothing of ~/.cache/passo. PYTHONS names the Pythons in which
the wheel is tried; one that is not there is named, and so is a service that does not answer. The wheel's modules depend on the compiler
for a Pico (arm-none-eabi-gcc, or else the ziglang of the lock), so the same bytes want the same compiler.
"""

import gzip
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import zipfile
from pathlib import Path

from host_tools import interpreter
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import ROOT, version

OUT = ROOT / "build" / "release"
CHIPS = "rp2040 rp2040_w rp2350 rp2350_w"
PYTHONS = "python3.11 python3.12 python3.13 python3.14"
EMULATED = {"rp2040": "tests_host/pico/test_pico_frozen.py", "rp2040_w": "tests_host/pico/test_pico_frozen_w.py"}
_TOO_LARGE = re.compile(r"wants Passo's UF2|\d+ kB of memory wanted, \d+ there")
_NO_ANSWER = re.compile(r"ConnectionError|ServiceError|Max retries|Timeout|NameResolution|\b(404|403|50\d)\b.*(Error|url)", re.IGNORECASE)


def main():
    """Carry out each step of a release, and print its time. Raises Failure."""
    os.umask(0o022)
    release = Release(OUT)
    release.check(bool(os.environ.get("DRY")))
    for step in (release.clone, release.test, release.prepare, release.packages, release.uf2s, release.mip, release.site, release.bill, release.audit,
                 release.sums, release.try_wheel):  # fmt: skip
        started = time.monotonic()
        print(f"-- {step.__name__}", flush=True)
        step()
        print(f"   {time.monotonic() - started:.0f} s", flush=True)
    print(_("release {} is in {}", version(), release.assets))


class Release:
    """The steps of a release, in the order of main(); each raises Failure if it cannot be done."""

    def __init__(self, out):
        """Name the folders below `out`, and the environments of the steps."""
        self.assets = out / "assets"
        self._out, self._clone, self._again, self._tools = out, out / "passo", out / "again", out / "tools"
        self._python = python_of(self._tools)
        self._commit_s = int(output_of("git", "log", "-1", "--format=%ct", folder=ROOT))
        kept = {name: value for name, value in interpreter.environment().items() if name not in ("VIRTUAL_ENV", "PASSO_KERNELS", "DRY")}
        self._user = kept
        cache = os.environ.get("PIP_CACHE_DIR") or Path.home() / ".cache" / "pip"  # pip checks every file of it by its hash
        self._clean = {name: value for name, value in kept.items() if not name.startswith(("PASSO_", "MAKE", "MFLAGS", "XDG_"))}
        self._clean |= {
            "HOME": str(out / "home"), "PIP_CACHE_DIR": str(cache), "SOURCE_DATE_EPOCH": str(self._commit_s), "LANG": "C.UTF-8",
            "PASSO_UF2_FROZEN": str(self.assets),
        }  # fmt: skip

    def check(self, dry):
        """Raise Failure if this commit is no release. `dry`: it needs no tag."""
        tag = f"v{version()}"
        if not (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split("\n## ", 1)[1].startswith(version()):
            raise Failure("CHANGELOG.md does not begin with version {}", version())
        if output_of("git", "status", "--porcelain", folder=ROOT):
            print(_("what is not committed is not in it"))
        if tag not in output_of("git", "tag", "--points-at", "HEAD", folder=ROOT).split():
            if not dry:
                raise Failure("this commit has no tag {}: git tag -s {}, or DRY=1", tag, tag)
            print(_("no tag {} here: a try", tag))

    def clone(self):
        """Clone this commit twice, into empty folders. Raises Failure."""
        shutil.rmtree(self._out, ignore_errors=True)
        self.assets.mkdir(parents=True)
        (self._out / "home").mkdir()
        for folder in (self._clone, self._again):
            run("git", "clone", "--quiet", str(ROOT), str(folder), environment=self._clean)

    def test(self):
        """Run .ci/run in the clone, unless ARGS=-. Raises Failure."""
        if os.environ.get("ARGS") == "-":
            print(_("not run: ARGS=-"))
        else:
            run(str(self._clone / ".ci" / "run"), folder=self._clone, environment=self._user)

    def prepare(self):
        """Make the environment of the tools, by the hashes of locks/release.txt. Raises Failure."""
        run(*interpreter.python(), "-m", "venv", str(self._tools), environment=self._clean)
        self._run_pip("--no-deps", "--require-hashes", "-r", "locks/release.txt")
        self._run_pip("--no-deps", "--no-build-isolation", "-e", ".")

    def packages(self):
        """Build sdist and wheel, the wheel out of the sdist; again in another clone. Raises Failure if the bytes differ."""
        self._run_module("host_tools.build.ship")
        shutil.copytree(self._clone / "host_tools" / "kernels" / "modules", self._again / "host_tools" / "kernels" / "modules")
        for folder in (self._clone, self._again):
            run(str(self._python), "-m", "build", "--no-isolation", "--outdir", "dist", folder=folder, environment=self._clean)
            for path in (folder / "dist").glob("*.tar.gz"):
                normalise_tar(path, self._commit_s)
        first, second = ({path.name: file_digest(path) for path in sorted((folder / "dist").iterdir())} for folder in (self._clone, self._again))
        if first != second or len(first) != 2:
            raise Failure("two builds differ: {} and {}", first, second)
        print(_("built twice, the same bytes: {}", ", ".join(first)))
        for path in (self._clone / "dist").iterdir():
            shutil.copy(path, self.assets)

    def uf2s(self):
        """Build the UF2 of each of CHIPS, and run the emulated Pico's tests with it. Raises Failure."""
        for chip in os.environ.get("CHIPS", CHIPS).split():
            self._run_module("host_tools.build.uf2", chip)
            if chip in EMULATED and os.environ.get("ARGS") != "-":  # it says so where it has no Pico to be run on
                run(str(python_of(self._clone / ".venv")), "-m", "pytest", "-q", EMULATED[chip], folder=self._clone,
                    environment={**self._user, "PASSO_UF2_FROZEN": str(self.assets)})  # fmt: skip

    def mip(self):
        """Zip a folder of files for each board that stock MicroPython has room for, with the package.json that mip takes. Raises Failure."""
        for board in sorted(path.stem for path in (self._clone / "boards").glob("[a-z]*.py")):
            try:
                self._run_module("host_tools.cli.main", "build", "--board", board)
            except Failure as failure:
                if not _TOO_LARGE.search(str(failure)):  # it wants the UF2, or an ESP32's image
                    raise
                print(_("not for mip: {}", str(failure).splitlines()[-1]))
                shutil.rmtree(self._clone / "build" / board, ignore_errors=True)
        built = [path for path in sorted((self._clone / "build").iterdir()) if (path / "package.json").is_file()]
        write_zip(built, self.assets / f"passo-{version()}-mip.zip", self._commit_s)

    def site(self):
        """Build the static site, and zip it. Raises Failure."""
        self._run_module("host_tools.cli.main", "site", "--out", "build/site")
        write_zip([self._clone / "build" / "site"], self.assets / f"passo-{version()}-site.zip", self._commit_s)

    def bill(self):
        """Write the SBOM: the packages that the lock installs, with licences. Raises Failure."""
        target = self.assets / f"passo-{version()}.cdx.json"
        run(str(self._python), "-m", "cyclonedx_py", "environment", "--output-reproducible", "--pyproject", "pyproject.toml", "-o", str(target),
            str(self._python), folder=self._clone, environment=self._clean)  # fmt: skip

    def audit(self):
        """Look for known holes of the installed packages. Raises Failure if there is one."""
        command = [str(self._python), "-m", "pip_audit", "--disable-pip", "--require-hashes", "--progress-spinner", "off", "--timeout", "20"]
        command += ["-r", "locks/test.txt", "-r", "locks/release.txt"]
        done = subprocess.run(command, cwd=self._clone, env=self._clean, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
        print(done.stdout.strip()[-2000:])
        unknown = done.stdout.count("could not be audited")  # pip-audit calls that a success
        if unknown:
            print(_("pip-audit could not ask about {} packages", unknown))
        if done.returncode and _NO_ANSWER.search(done.stdout):
            print(_("pip-audit could not ask: no service answered"))
        elif done.returncode:
            raise Failure("pip-audit: {}", done.stdout.strip().splitlines()[-1])

    def sums(self):
        """Copy CHANGELOG.md, and write SHA256SUMS of all assets."""
        shutil.copy(self._clone / "CHANGELOG.md", self.assets)
        rows = [f"{file_digest(path)}  {path.name}\n" for path in sorted(self.assets.iterdir())]
        (self.assets / "SHA256SUMS").write_text("".join(rows), encoding="ascii")
        print("".join(rows), end="")

    def try_wheel(self):
        """Install the wheel by pip in each Python of PYTHONS, and run try_installed there; with the UF2 of an RP2040, if one was built. Raises
        Failure."""
        wheel, = self.assets.glob("*.whl")
        uf2 = [str(path) for path in self.assets.glob("passo-rp2040-*.uf2")]
        for name in os.environ.get("PYTHONS", PYTHONS).split():
            if shutil.which(name) is None or subprocess.run([name, "-c", ""], capture_output=True).returncode:
                print(_("not tried, because it is not here: {}", name))
                continue
            folder = self._out / "tried" / Path(name).as_posix().replace("/", "_")
            run(name, "-m", "venv", str(folder), environment=self._clean)
            python = python_of(folder)
            run(str(python), "-m", "pip", "install", "--quiet", f"{wheel}[draw,emulate]", environment=self._clean)
            run(str(python), "-m", "host_tools.build.try_installed", *uf2, folder=self._out / "home", environment=self._clean)

    def _run_pip(self, *words):
        """Install packages into the environment of the tools. Raises Failure."""
        run(str(self._python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *words, folder=self._clone, environment=self._clean)

    def _run_module(self, *words):
        """Run a module in the clone, by the tools' Python. Raises Failure."""
        run(str(self._python), "-m", *words, folder=self._clone, environment=self._clean)


def python_of(folder):
    """Return the Python of a virtual environment."""
    return folder / ("Scripts" if os.name == "nt" else "bin") / "python"


def run(*command, environment, folder=ROOT):
    """Run a command, and print its output as it comes. Raises Failure with its last lines."""
    print("$", *command, flush=True)
    process = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    lines = []
    for line in process.stdout:
        print(line, end="", flush=True)
        lines = [*lines[-20:], line]
    if process.wait():
        raise Failure("{} ended with {}: {}", " ".join(command[:4]), process.returncode, "".join(lines).strip())


def output_of(*command, folder):
    """Return a command's output. Raises CalledProcessError."""
    return subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def file_digest(path):
    """Return a file's SHA-256 in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_zip(folders, target, when_s):
    """Write the files of these folders to a zip file, sorted, with one time and one mode: equal files give equal bytes."""
    with zipfile.ZipFile(target, "w") as file:
        for path in sorted(path for folder in folders for path in folder.rglob("*") if path.is_file()):
            folder = next(folder for folder in folders if path.is_relative_to(folder))
            info = zipfile.ZipInfo(path.relative_to(folder.parent).as_posix(), time.gmtime(when_s)[:6])
            info.external_attr, info.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
            file.writestr(info, path.read_bytes())


def normalise_tar(path, when_s):
    """Write a .tar.gz anew with sorted files, one time, no owners, and modes 644 or 755: equal files give equal bytes."""
    with tarfile.open(path) as file:
        members = [(info, file.extractfile(info).read()) for info in sorted(file.getmembers(), key=lambda info: info.name) if info.isfile()]
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as file:
        for old, data in members:
            info = tarfile.TarInfo(old.name)
            info.size, info.mtime, info.mode = len(data), when_s, 0o755 if old.mode & 0o100 else 0o644
            file.addfile(info, io.BytesIO(data))
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", fileobj=raw, mtime=when_s) as file:
        file.write(packed.getvalue())


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        sys.exit(str(failure))
