"""A release: one version everywhere, a lock for all that is asked for, a workflow that runs what is there, bytes that depend on contents only."""

import hashlib
import io
import json
import os
import re
import subprocess
import tarfile
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from host_tools.build import release
from host_tools.build.frozen import CHIPS, stamp
from host_tools.build.tree import write_stamp
from host_tools.build.uf2 import label_of, uf2_of
from host_tools.resources import ROOT, version

pytestmark = pytest.mark.quick

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOW = ROOT / ".github" / "workflows" / "release.yml"
PINNED = re.compile(r"^([\w.-]+)==(\S+)(?: ; (.*?))? \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.MULTILINE)


def test_one_version(tmp_path):
    assert version() == PROJECT["version"]
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest[1] == version()
    (tmp_path / "passo").mkdir()
    write_stamp(tmp_path)
    assert re.fullmatch(re.escape(version()) + "-[0-9a-f]{8}\n", (tmp_path / "stamp.txt").read_text())
    assert len((tmp_path / "stamp.txt").read_bytes()) < 16, "one piece of a board's memory"


@pytest.mark.parametrize("chip", [name for name, chip in CHIPS.items() if chip.mcu.startswith("rp2")])
def test_a_uf2_has_the_version_in_its_stamp(chip, tmp_path):
    (tmp_path / "a.uf2").write_bytes(uf2_of(CHIPS[chip], bytes(1000)))
    told = label_of(tmp_path / "a.uf2")
    assert told == (chip, stamp(chip)) and told[1].startswith(version() + "-")


def asked(extra):
    """All that an extra asks for, other extras of this project's followed."""
    for text in PROJECT["dependencies"] + PROJECT["optional-dependencies"][extra]:
        wanted = Requirement(text)
        if wanted.name == "passo":
            for other in wanted.extras:
                yield from asked(other)
        else:
            yield wanted


def test_everything_asked_for_has_an_upper_bound():
    lines = [*PROJECT["dependencies"], *sum(PROJECT["optional-dependencies"].values(), [])]
    open_ended = [line for line in lines if not line.startswith("passo[") and not re.search(r"<|==", line)]
    assert len(lines) > 30 and not open_ended


@pytest.mark.parametrize("extra", ["test", "release"])
def test_the_lock_holds_what_is_asked_for(extra):
    text = (ROOT / "locks" / f"{extra}.txt").read_text(encoding="utf-8")
    locked = {canonicalize_name(found[1]): found[2] for found in PINNED.finditer(text)}
    assert len(locked) == len(re.findall(r"^[^ #\n]", text, re.MULTILINE)), "each line has a version and hashes"
    wanted = list(asked(extra))
    wrong = [str(each) for each in wanted if not each.specifier.contains(locked.get(canonicalize_name(each.name), "0"))]
    assert len(wanted) > 10 and not wrong, "make lock"


def test_what_is_in_both_locks_has_one_version():
    test, tools = ({found[1]: found[2] for found in PINNED.finditer((ROOT / "locks" / name).read_text())} for name in ("test.txt", "release.txt"))
    assert len(test.keys() & tools) > 20 and {name for name in test.keys() & tools if test[name] != tools[name]} == set()


def test_the_workflow_runs_what_is_there():
    text = WORKFLOW.read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    made = set(re.findall(r"\bmake ([a-z-]+)", text.split("\nname:", 1)[1]))
    assert made == {"release"} and made <= targets
    modules = re.findall(r"-m (host_tools[\w.]+)", text)
    assert modules and all((ROOT / (module.replace(".", "/") + ".py")).is_file() for module in modules)
    assert "run: .ci/run\n" in text and os.access(ROOT / ".ci" / "run", os.X_OK)
    assert str(release.OUT.relative_to(ROOT) / "assets") in text
    for action in re.findall(r"uses: (\S+)", text):
        assert re.fullmatch(r"actions/[a-z-]+@[0-9a-f]{40}", action), "an action is named by its commit: a tag can be moved"
    jobs = re.split(r"\n  (?=\w+:\n)", text.split("\njobs:")[1])[1:]
    assert len(jobs) == 4 and all("timeout-minutes:" in job for job in jobs)
    for pythons in re.findall(r"python: \[(.*)\]", text):
        assert [f"python{name}" for name in re.findall(r"[\d.]+", pythons)] == release.PYTHONS.split()


def test_a_zip_depends_on_its_contents_only(tmp_path):
    found = set()
    for number in (1, 2):
        folder = tmp_path / str(number) / "files"
        folder.mkdir(parents=True)
        for name in ("ab", "ba")[number - 1]:
            (folder / name).write_text("the same")
            os.utime(folder / name, (number * 10**9, number * 10**9))
            (folder / name).chmod(0o600 if number == 1 else 0o755)
        release.write_zip([folder], tmp_path / "made.zip", 1_700_000_000)
        found.add(release.file_digest(tmp_path / "made.zip"))
    assert len(found) == 1


def test_a_tar_depends_on_its_contents_only(tmp_path):
    found = set()
    for number, names in ((1, "ab"), (2, "ba")):
        path = tmp_path / f"{number}.tar.gz"
        with tarfile.open(path, "w:gz") as file:
            for name in names:
                info = tarfile.TarInfo(name)
                info.size, info.mtime, info.uid, info.mode, info.uname = 4, number * 10**9, number, 0o640 + number, str(number)
                file.addfile(info, io.BytesIO(b"same"))
        release.normalise_tar(path, 1_700_000_000)
        found.add(hashlib.sha256(path.read_bytes()).hexdigest())
        assert int.from_bytes(path.read_bytes()[4:8], "little") == 1_700_000_000
        with tarfile.open(path) as file:
            assert [(info.name, info.mtime, info.uid) for info in file] == [("a", 1_700_000_000, 0), ("b", 1_700_000_000, 0)]
    assert len(found) == 1


def test_a_commit_without_a_tag_is_no_release(tmp_path, monkeypatch):
    for words in ("init -q", "-c user.name=x -c user.email=x commit -q --allow-empty -m x"):
        subprocess.run(["git", *words.split()], cwd=tmp_path, check=True)
    (tmp_path / "CHANGELOG.md").write_text(f"# x\n\n## {version()}\n")
    monkeypatch.setattr(release, "ROOT", tmp_path)
    made = release.Release(tmp_path / "out")
    made.check(dry=True)
    with pytest.raises(release.Failure, match=f"no tag v{version()}"):
        made.check(dry=False)
    subprocess.run(["git", "tag", f"v{version()}"], cwd=tmp_path, check=True)
    made.check(dry=False)
    (tmp_path / "CHANGELOG.md").write_text("# x\n\n## 9.9.9\n")
    with pytest.raises(release.Failure, match="does not begin with version"):
        made.check(dry=True)
