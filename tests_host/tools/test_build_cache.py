"""Results of a build, kept on disk for the next build of the same texts."""

import pytest

from host_tools.build import build_cache, tree
from host_tools.kernels import module

BOARD = "two_motor_kit"


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(build_cache.FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_same_is_made_once(folder):
    made = []

    def make():
        made.append(len(made))
        return made[-1]

    assert [build_cache.load_or_make(key, make) for key in (("a", 1), ("a", 1), ("a", 2), ("a", 1))] == [0, 0, 1, 0]
    assert len(list(folder.iterdir())) == 2


def test_a_failed_build_is_not_kept_nor_any_without_the_folder(folder, monkeypatch):
    with pytest.raises(ZeroDivisionError):
        build_cache.load_or_make("a", lambda: 1 // 0)
    monkeypatch.delenv(build_cache.FOLDER)
    assert [build_cache.load_or_make("a", lambda: 1), build_cache.load_or_make("a", lambda: 2)] == [1, 2] and not folder.exists()


def test_other_tools_make_it_anew(folder, monkeypatch):
    build_cache.load_or_make("a", lambda: 1)
    monkeypatch.setattr(build_cache, "_makers_digest", lambda: "others")
    assert build_cache.load_or_make("a", lambda: 2) == 2


def test_a_kept_build_is_the_build(folder, tmp_path):
    tree._module_bytes.cache_clear()  # of other tests' builds
    tree.build_tree(BOARD, tmp_path / "made")
    count = len(list(folder.iterdir()))
    tree._module_bytes.cache_clear()
    tree.build_tree(BOARD, tmp_path / "again")
    assert files(tmp_path / "made") == files(tmp_path / "again") and len(list(folder.iterdir())) == count > 50


def test_another_wish_for_the_compiler_is_another_build(monkeypatch):
    with_compiler = module.origin_of("armv6m")
    monkeypatch.setenv("PASSO_KERNELS", "viper")
    assert module.origin_of("armv6m") != with_compiler
