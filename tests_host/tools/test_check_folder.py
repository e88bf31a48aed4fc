"""`passo check FOLDER`: one table of all programs, by processes of this PC and by a Dask cluster; workers that die."""

import contextlib
import csv
import os
import signal
import time
from collections import Counter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from host_tools import language, workers
from host_tools.cli import check_folder
from host_tools.cli.main import app

GOOD = "G21 G90\nG1 X{} Y5 F600\nG1 X0 Y0\n"


def doubled(item):
    return 2 * item


def dies_once(item):
    """Kills its process at the first look at an odd item."""
    folder, number = item
    mark = Path(folder) / str(number)
    if number % 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def dies(item):
    if item == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def raises(item):
    raise ValueError(f"no {item}")


def test_each_item_once():
    assert sorted(workers.in_processes(doubled, range(20), 2)) == [(number, 2 * number) for number in range(20)]
    assert list(workers.in_processes(doubled, [], 2)) == []


def test_a_worker_that_dies_costs_its_item_only(tmp_path):
    items = [(str(tmp_path), number) for number in range(5)]
    assert sorted(workers.in_processes(dies_once, items, 2)) == [(item, item[1]) for item in items]


def test_an_item_that_kills_each_worker_is_given_up():
    assert dict(workers.in_processes(dies, range(3), 2)) == {0: 0, 1: workers.DIED, 2: 2}


def test_what_the_work_raises_ends_it():
    with pytest.raises(ValueError, match="no 7"):
        list(workers.in_processes(raises, [7], 1))


def programs(folder, count):
    (folder / "deep").mkdir()
    for number in range(1, count + 1):
        (folder / f"p{number:02}.nc").write_text(GOOD.format(number))
    (folder / "deep" / "big.gcode").write_text("G21 G90\nG1 X0 F600\nG1 X9999\nG1 X9998\n")
    (folder / "note.txt").write_text("no program")


def invoked(*words):
    return CliRunner().invoke(app, ["check", *map(str, words)])


def test_a_table_of_all_programs(tmp_path):
    programs(tmp_path, 2)
    (tmp_path / "empty.nc").write_text("")
    out = tmp_path / "table.csv"
    told = invoked(tmp_path, "--workers", 2, "-o", out)
    assert told.exit_code == 1
    lines = told.stdout.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == ["deep/big.gcode", "empty.nc", "p01.nc", "p02.nc"]
    assert "fault: line 3: G1X9999" in lines[0] and "2 lines in all" in lines[0]
    assert "2.0 x 5.0 x 0.0 mm" in lines[3]
    assert lines[-1].startswith("4 programs in ") and lines[-1].endswith(", 2 with a fault")
    rows = list(csv.DictReader(out.open()))
    assert [row["file"] for row in rows] == ["deep/big.gcode", "empty.nc", "p01.nc", "p02.nc"]
    assert rows[3]["high"] == "2.000 5.000 0.000" and float(rows[3]["seconds"]) > 0.5 and not rows[3]["fault"]


def test_what_cannot_be(tmp_path):
    file = tmp_path / "a.nc"
    file.write_text("G1 X1 F100\n")
    for words, what in (
        ((file, "--workers", 2), "are for a folder"),
        ((file, "--dask", "tcp://127.0.0.1:1"), "are for a folder"),
        ((tmp_path, "--workers", 2, "--dask", "tcp://127.0.0.1:1"), "give one of them"),
        ((tmp_path, "-o", "picture.png"), "writes a table"),
    ):
        told = invoked(*words)
        assert told.exit_code == 1 and what in str(told.exception), told.output
    file.unlink()
    assert "no program in" in str(invoked(tmp_path).exception)


def test_what_travels_is_all_that_a_worker_needs(tmp_path, monkeypatch):
    """Nothing of the sender's disk is there any more."""
    monkeypatch.setattr(language, "_chosen", language.current_language())  # as it was, behind the test
    file = tmp_path / "p.nc"
    file.write_text(GOOD.format(3))
    board = tmp_path / "mine.py"
    board.write_text((Path(__file__).parents[2] / "boards" / "router_3axis.py").read_text())
    item = check_folder.Item(check_folder.Sent.from_path(file, True), check_folder.Sent.from_path(board, True), None, None, ((), None, None), "pt")
    file.unlink()
    board.unlink()
    row = check_folder.check_item(item)
    assert row.fault == "" and row.high == pytest.approx((3, 5, 0), abs=0.01)


@contextlib.contextmanager
def cluster_of(count, **changes):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None, **changes) as cluster:
        yield cluster


def test_small_items_go_to_a_cluster_several_a_task(monkeypatch):
    distributed = pytest.importorskip("distributed")
    asked = []
    submit = distributed.Client.submit

    def counted(client, task, work, items, **how):
        asked.append(len(items))
        return submit(client, task, work, items, **how)

    monkeypatch.setattr(distributed.Client, "submit", counted)
    with cluster_of(1, processes=False) as cluster:
        found = list(workers.on_cluster(doubled, range(200), cluster.scheduler_address))
    assert sorted(found) == [(number, 2 * number) for number in range(200)]
    assert asked[0] == 1 and sum(asked) == 200 and len(asked) <= 30


@pytest.mark.slow
def test_an_item_that_kills_each_worker_of_a_cluster_is_given_up():
    with cluster_of(2, processes=True) as cluster:
        found = list(workers.on_cluster(dies, [*range(3, 60), 1, *range(60, 90)], cluster.scheduler_address))
    assert Counter(item for item, _ in found) == Counter([1, *range(3, 90)])
    assert [row for row in found if row[1] == workers.DIED] == [(1, workers.DIED)]


@pytest.mark.slow
def test_on_a_cluster_of_which_a_worker_is_killed_twice(tmp_path):
    programs(tmp_path, 30)
    with cluster_of(2, processes=True) as cluster:
        killed = []
        began = []

        def counted(items):
            for item in items:
                began.append(item)
                if len(began) in (14, 24):
                    victim = next(iter(cluster.workers.values()))
                    killed.append(victim.pid)
                    os.kill(victim.pid, signal.SIGKILL)
                    limit = time.monotonic() + 60
                    while victim.pid == killed[-1] or not victim.pid:
                        assert time.monotonic() < limit
                        time.sleep(0.05)
                yield item

        items = [
            check_folder.Item(check_folder.Sent.from_path(path, True), "router_3axis", None, None, ((), None, None), "en")
            for path in sorted(tmp_path.glob("*.nc"))
        ]
        found = list(workers.on_cluster(check_folder.check_item, counted(items), cluster.scheduler_address))
    assert len(killed) == 2
    assert Counter(item.program.path for item, _ in found) == Counter(item.program.path for item in items)
    assert all(row != workers.DIED and row.fault == "" for _, row in found)
