"""Worker processes: results in order, whatever happens to them; and what a run leaves behind."""

import os
import signal
import subprocess
import sys
import time

import pytest

from ragdoll import InputError
from ragdoll.batch.part_file import PartFile
from ragdoll.batch.pool import Pool


def work(task):
    """What tasks ask for."""
    if task == "hang":
        time.sleep(1000)
    if task == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if task == "leave":
        os._exit(7)
    if task == "fail":
        raise KeyError("no such thing")
    if isinstance(task, float):
        time.sleep(task)
    return str(task).encode(), {"task": task}


def run(tasks, count=3, seconds=30.0):
    with Pool(work, count, seconds) as pool:
        return list(pool.outcomes(iter(tasks)))


def test_results_come_in_the_order_of_the_tasks():
    tasks = [0.3, *range(50), 0.1, 0.0]
    outcomes = run(tasks)
    assert [task for task, _ in outcomes] == tasks
    assert [outcome.data for _, outcome in outcomes] == [str(task).encode() for task in tasks]


def test_no_task_gives_no_result():
    assert run([]) == []


@pytest.mark.parametrize(
    "task, words",
    [
        ("hang", "longer than 0.5 s"),
        ("crash", "died of SIGSEGV"),
        ("leave", "ended with code 7"),
        ("fail", "KeyError"),
    ],
)
@pytest.mark.parametrize("count", [1, 2])
def test_a_task_that_goes_wrong_costs_itself_alone(task, words, count):
    outcomes = run([1, task, 2, 3], count, seconds=0.5)
    assert [outcome.data for _, outcome in outcomes] == [b"1", b"", b"2", b"3"]
    assert words in outcomes[1][1].facts["error"]


def test_a_task_that_hangs_does_not_hold_up_the_others():
    given = []

    def tasks():
        for task in ["hang", *range(200)]:
            given.append(task)
            yield task

    with Pool(work, 2, 1.0) as pool:
        outcomes = pool.outcomes(tasks())
        first = next(outcomes)
        assert "longer" in first[1].facts["error"]
        assert len(given) > 100


def test_tasks_are_not_taken_far_ahead():
    given = []

    def tasks():
        for number in range(100_000):
            given.append(number)
            yield number

    with Pool(work, 2, 30.0) as pool:
        outcomes = pool.outcomes(tasks())
        for _ in range(10):
            next(outcomes)
        assert len(given) < 5000


def test_workers_end_with_their_parent_also_when_it_is_killed(tmp_path):
    code = """
import os, sys, time
from ragdoll.batch.pool import Pool
def work(task):
    open(f"{sys.argv[1]}/{os.getpid()}", "w").close()
    time.sleep(1000)
with Pool(work, 2, 1000) as pool:
    list(pool.outcomes(iter([1, 2])))
"""
    parent = subprocess.Popen([sys.executable, "-c", code, tmp_path])
    try:
        while len(os.listdir(tmp_path)) < 2:
            assert parent.poll() is None
            time.sleep(0.05)
    finally:
        parent.kill()
        parent.wait()
    workers = [int(name) for name in os.listdir(tmp_path)]
    end = time.monotonic() + 20
    while any(is_running(worker) for worker in workers):
        assert time.monotonic() < end
        time.sleep(0.05)


def is_running(process):
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


# ------------------------------------------------------------------------------ unfinished outputs


def started(tmp_path, about=None, fingerprint="f", force=False):
    return PartFile(tmp_path / "out.sdf", about or {"count": 5}, fingerprint, force)


def test_an_unfinished_output_is_taken_up_where_it_ended(tmp_path):
    with started(tmp_path) as part:
        part.add(b"one\n", {"record": 0})
        part.add(b"", {"record": 1})
    with started(tmp_path) as part:
        assert (part.count, part.taken_up) == (2, 2)
        part.add(b"three\n", {"record": 2})
        assert [entry["record"] for entry in part.entries()] == [0, 1, 2]
        assert [data for _, data in part.blocks()] == [b"one\n", b"", b"three\n"]
        part.publish()
    assert (tmp_path / "out.sdf").read_bytes() == b"one\nthree\n"
    assert os.listdir(tmp_path) == ["out.sdf"]


@pytest.mark.parametrize("cut", range(1, 60, 3))
def test_whatever_a_kill_tears_off_the_journal_is_done_again(tmp_path, cut):
    with started(tmp_path) as part:
        for number in range(4):
            part.add(b"%d\n" % number, {"record": number})
    journal = tmp_path / "out.sdf.partial.jsonl"
    os.truncate(journal, max(journal.stat().st_size - cut, 0))
    with started(tmp_path) as part:
        for number in range(part.count, 4):
            part.add(b"%d\n" % number, {"record": number})
        assert [data for _, data in part.blocks()] == [b"0\n", b"1\n", b"2\n", b"3\n"]


@pytest.mark.parametrize("size", range(9))
def test_data_that_a_crash_of_the_machine_lost_is_made_again(tmp_path, size):
    with started(tmp_path) as part:
        for number in range(4):
            part.add(b"%d\n" % number, {"record": number})
    os.truncate(tmp_path / "out.sdf.partial", size)
    with started(tmp_path) as part:
        assert part.count == size // 2
        assert [data for _, data in part.blocks()] == [b"%d\n" % k for k in range(size // 2)]


def test_what_another_run_left_is_refused_unless_forced(tmp_path):
    with started(tmp_path) as part:
        part.add(b"one\n", {"record": 0})
    with pytest.raises(InputError, match="count 5.*--force"):
        started(tmp_path, {"count": 6}, "g")
    with started(tmp_path) as part:
        assert part.count == 1
    with started(tmp_path, {"count": 6}, "g", force=True) as part:
        assert part.count == 0
        assert (tmp_path / "out.sdf.partial").stat().st_size == 0


def test_two_runs_do_not_write_one_output(tmp_path):
    with started(tmp_path), pytest.raises(InputError, match="Another run"):
        started(tmp_path)
    with started(tmp_path):
        pass


def test_a_foreign_file_in_the_place_of_the_journal_is_not_touched(tmp_path):
    journal = tmp_path / "out.sdf.partial.jsonl"
    journal.write_text('{"end": 3}\n')
    with pytest.raises(InputError, match="move it away"):
        started(tmp_path)
    assert journal.read_text() == '{"end": 3}\n'


def test_a_foreign_file_in_the_place_of_the_data_is_not_touched(tmp_path):
    (tmp_path / "out.sdf.partial").write_text("mine")
    with pytest.raises(InputError, match="move it away"):
        started(tmp_path)
    assert (tmp_path / "out.sdf.partial").read_text() == "mine"
