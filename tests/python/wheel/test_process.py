"""Long-lived processes: interruptions, forks and leaks."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import edgegait


def interrupted(work, is_time):
    """Returns the seconds from SIGINT, sent once `is_time`, to the KeyboardInterrupt in some work."""
    at = []

    def press():
        while not is_time():
            time.sleep(0.01)
        at.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        thread.join()
    return time.monotonic() - at[0]


@pytest.mark.parametrize(
    "work",
    [
        lambda: edgegait.Dataset(views="paper").batch(range(18278)),
        lambda: edgegait.Dataset(edgegait.Design("domain-random"), split="train").batch(range(0, 6000, 8)),
        lambda: list(edgegait.sweep(views="paper", cycles=8)),
        lambda: edgegait.cohort(people=200),
        lambda: edgegait.cohort(people=2000, quick=True),
        lambda: edgegait.cohort(people=2000),
        lambda: edgegait.score("pixels", views="paper"),
        lambda: edgegait.score(
            edgegait.Recognizer(lambda images: images.reshape(len(images), -1), name="mine"), views="paper"
        ),
    ],
    ids=["batch", "people", "sweep", "cohort", "quick", "population", "score", "callable"],
)
def test_control_c_ends_work(work):
    begun = time.monotonic()
    assert interrupted(work, lambda: time.monotonic() > begun + 0.5) < 10
    # Later work is not blocked.
    assert len(edgegait.Dataset(views="side", raster="rows").batch(range(26))[0]) == 26
    assert edgegait.score("pixels", views="side", raster="rows", no_baselines=True)["recognizers"][0]["rank1"] == 1


def test_a_generation_that_was_interrupted_is_gone_on_with(tmp_path):
    out = tmp_path / "set"
    make = lambda **more: edgegait.generate("domain-random", people=60, out=out, **more)  # noqa: E731
    # Interrupt when the journal, which is replaced whole, counts the first people; all take some seconds.
    journal = out / "train.unfinished" / "journal.json"
    interrupted(make, lambda: journal.exists() and json.loads(journal.read_text())["done"] > 0)
    assert not (out / "train").exists()
    with pytest.raises(ValueError, match="did not finish"):
        make()
    make(resume=True)
    edgegait.generate("domain-random", people=60, out=tmp_path / "again")
    for part in ["train", "test"]:
        for name in ["geis.npy", "index.csv"]:
            assert (out / part / name).read_bytes() == (tmp_path / "again" / part / name).read_bytes()


def waited_for(child):
    """Returns the status of a child that must end within a minute."""
    deadline = time.monotonic() + 60
    while (done := os.waitpid(child, os.WNOHANG))[0] == 0:
        if time.monotonic() > deadline:
            os.kill(child, signal.SIGKILL)
            pytest.fail("the child hangs")
        time.sleep(0.01)
    return done[1]


def test_a_process_that_forks_while_a_thread_draws_goes_on():
    dataset = edgegait.Dataset(edgegait.Design("casia-b-like"), split="train", people=8)
    stop = threading.Event()

    def draw():
        while not stop.is_set():
            dataset.batch(range(0, len(dataset), 7))

    thread = threading.Thread(target=draw)
    thread.start()
    try:
        for _ in range(8):
            child = os.fork()
            if child == 0:
                os._exit(0 if len(dataset.batch(range(12))[0]) == 12 else 1)
            assert waited_for(child) == 0
    finally:
        stop.set()
        thread.join()


def test_models_that_were_loaded_before_a_fork_are_refused_after_it():
    how = {"views": "side", "raster": "rows", "no_baselines": True, "cache": "none"}
    edgegait.score("gei-small", **how)
    child = os.fork()
    if child == 0:
        # Other recognizers do not use the runtime's threads.
        is_right = edgegait.score("pixels", **how)["recognizers"][0]["probes"] == 26
        try:
            edgegait.score("gei-small", **how)
            is_right = False
        except edgegait.Error as error:
            is_right &= "was started before this process forked" in str(error)
        os._exit(0 if is_right else 1)
    assert waited_for(child) == 0


def rss():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_memory_does_not_grow_with_items():
    items = int(os.environ.get("EDGEGAIT_ITEMS", "20000"))
    pack = edgegait.cohort(people=4, speeds_kmh=[5], quick=True)
    dataset = edgegait.Dataset(pack, views="paper", raster="rows")
    design = edgegait.Dataset(edgegait.Design("casia-b-like"), split="train", people=4)

    # A tenth of the items is drawn singly, and half of the batches are of generated people.
    def draw(first, last):
        for at in range(first, last, 500):
            dataset.batch([(at + step) % len(dataset) for step in range(200)])
            design.batch([(at + step) % len(design) for step in range(250)])
            for step in range(50):
                dataset[(at + step) % len(dataset)]

    draw(0, items // 10)
    before = rss()
    draw(0, items)
    grown = rss() - before
    print(f"{items} items: resident memory {before / 1e6:.1f} MB, then {grown / 1e6:+.1f} MB")
    assert grown < 8e6


def test_the_package_has_the_command(program):
    found = subprocess.run([sys.executable, "-m", "edgegait", "--version"], capture_output=True, text=True, check=True)
    assert found.stdout.startswith("edgegait 0.1.0")
    wrong = subprocess.run(
        [sys.executable, "-m", "edgegait", "sweep", "--raster", "x"], capture_output=True, text=True, check=False
    )
    assert wrong.returncode == 2
    assert "possible values" in wrong.stderr
