"""Builds that are kept on disk for the next of the same."""

import pytest

from host_tools.build import kept, tree
from host_tools.kernels import module

BOARD = "two_motor_kit"


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(kept.FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_same_is_made_once(folder):
    made = []

    def make():
        made.append(len(made))
        return made[-1]

    assert [kept.kept(("a", 1), make), kept.kept(("a", 1), make), kept.kept(("a", 2), make), kept.kept(("a", 1), make)] == [0, 0, 1, 0]
    assert len(list(folder.iterdir())) == 2


def test_nothing_is_kept_of_what_fails_or_where_nobody_asks(folder, monkeypatch):
    with pytest.raises(ZeroDivisionError):
        kept.kept("a", lambda: 1 // 0)
    monkeypatch.delenv(kept.FOLDER)
    assert [kept.kept("a", lambda: 1), kept.kept("a", lambda: 2)] == [1, 2] and not folder.exists()


def test_other_tools_make_it_anew(folder, monkeypatch):
    kept.kept("a", lambda: 1)
    monkeypatch.setattr(kept, "_makers", lambda: "others")
    assert kept.kept("a", lambda: 2) == 2


def test_a_kept_build_is_the_build(folder, tmp_path):
    tree._module.cache_clear()  # of other tests' builds
    tree.build_tree(BOARD, tmp_path / "made")
    count = len(list(folder.iterdir()))
    tree._module.cache_clear()
    tree.build_tree(BOARD, tmp_path / "again")
    assert files(tmp_path / "made") == files(tmp_path / "again") and len(list(folder.iterdir())) == count > 50


def test_another_wish_for_the_compiler_is_another_build(monkeypatch):
    with_compiler = module.origin("armv6m")
    monkeypatch.setenv("PASSO_KERNELS", "viper")
    assert module.origin("armv6m") != with_compiler
