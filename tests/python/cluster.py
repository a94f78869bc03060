"""Tests a training set and a stream from several processes: Ray on this machine, and a SLURM array job's script.

    python cluster.py FOLDER GUIDE.md [--people N]

Generates the training split of `domain-random` in one process, in four Ray workers, in four of which one is killed, and
with the guide's array script, one task after another. All must give the same bytes. Then four Ray workers draw a
stream, also with one killed; its batches must equal those of one process.
"""

import argparse
import hashlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import ray

import edgegait

SHARDS = 8


def hashed(folder):
    """Returns the SHA-256 of a dataset's file names and contents."""
    digest = hashlib.sha256()
    for path in sorted(Path(folder).iterdir()):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


@ray.remote(num_cpus=1, max_retries=3)
def shard(folder, number, people):
    """Generates a shard, or continues one that another worker began."""
    Path(folder, f"{number}.pid").write_text(str(os.getpid()))
    out = Path(folder, str(number))
    edgegait.generate("domain-random", people=people, out=out, shard=f"{number}/{SHARDS}", resume=True, threads=1)
    return str(out / "train")


def kill_worker_of(folder, number, killed):
    """Kills the worker that generates a shard, in the middle of it."""
    pid, begun = Path(folder, f"{number}.pid"), Path(folder, str(number))
    while not (pid.exists() and begun.exists() and any(begun.glob("*.unfinished/**/*.npy"))):
        time.sleep(0.002)
    os.kill(int(pid.read_text()), signal.SIGKILL)
    killed.append(int(pid.read_text()))


def set_of_ray(folder, people, victim=None):
    """Returns the hash of a set that Ray workers generate, and the time in seconds."""
    Path(folder).mkdir()
    killed, started = [], time.monotonic()
    if victim is not None:
        threading.Thread(target=kill_worker_of, args=(folder, victim, killed), daemon=True).start()
    shards = ray.get([shard.remote(str(folder), number, people) for number in range(1, SHARDS + 1)])
    edgegait.merge(*shards, out=Path(folder, "set"))
    seconds = time.monotonic() - started
    if victim is not None:
        assert killed, "no worker was killed"
        assert int(Path(folder, f"{victim}.pid").read_text()) != killed[0], "no other worker continued"
    return hashed(Path(folder, "set")), seconds


@ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)
class Drawer:
    """Draws batches by number, and keeps the people that it has generated."""

    def __init__(self, dataset, batch):
        """Takes a pickled dataset."""
        self.stream = dataset.stream(batch)

    def draw(self, number):
        """Returns a batch."""
        return self.stream[number]

    def pid(self):
        """Returns the number of its process."""
        return os.getpid()


def hash_of(batches):
    """Returns the SHA-256 of batches in order."""
    digest = hashlib.sha256()
    for images, labels in batches:
        digest.update(images.tobytes() + labels.tobytes())
    return digest.hexdigest()


def batches_of_ray(dataset, count, victim=None):
    """Yields batches in order, drawing eight ahead."""
    drawers = [Drawer.remote(dataset, 128) for _ in range(4)]
    draw = lambda number: drawers[number % 4].draw.remote(number)  # noqa: E731
    waiting = [draw(number) for number in range(8)]
    for number in range(count):
        if number == victim:
            killed = ray.get(drawers[1].pid.remote())
            os.kill(killed, signal.SIGKILL)
        yield ray.get(waiting.pop(0))
        if number + 8 < count:
            waiting.append(draw(number + 8))
    if victim is not None:
        assert ray.get(drawers[1].pid.remote()) != killed, "the same process continued"


DESIGN = """
seed = 7
[population]
people = "0..96"
[views]
azimuth_deg = { uniform = [0, 180] }
elevation_deg = [0]
count = 2
[images]
raster = "rows"
"""


def guide_blocks(folder, guide):
    """Runs the guide's code blocks, with fewer shards, actors and batches, and checks their results."""
    blocks = re.findall(r"```py\n(.*?)```", Path(guide).read_text(), re.DOTALL)
    assert len(blocks) == 2
    folder.mkdir()
    (folder / "design.toml").write_text(DESIGN)
    dataset = edgegait.Dataset(edgegait.Design.from_toml(DESIGN), threads=1)
    names = {"dataset": dataset, "edgegait": edgegait, "ray": ray}
    source = blocks[0].replace("ray.init()", "").replace("64", "6").replace("65", "7")
    former = Path.cwd()
    os.chdir(folder)
    try:
        # The block's functions run in the workers' folders, so they need absolute paths.
        source = source.replace('"design.toml"', repr(str(folder / "design.toml")))
        source = source.replace('f"shards/{number}"', f'f"{folder}/shards/{{number}}"')
        exec(compile(source, "block", "exec"), names)
    finally:
        os.chdir(former)
    edgegait.generate(folder / "design.toml", out=folder / "one")
    assert hashed(folder / "set") == hashed(folder / "one")
    source = blocks[1].replace("32", "3").replace("64", "6").replace("1_000_000", "9").replace("256", "40")
    exec(compile(source, "block", "exec"), names)
    expected, labels = dataset.stream(40)[2]
    assert (names["images"] == expected).all()
    assert (names["labels"] == labels).all()


def array_job(folder, guide, people):
    """Returns the hash of the set that the guide's array script generates in an environment like SLURM's."""
    scripts = re.findall(r"```sh\n(#!.*?)```", Path(guide).read_text(), re.DOTALL)
    (script,) = [script for script in scripts if "SBATCH" in script]
    script = script.replace("design.toml", f"domain-random --people {people}")
    folder.mkdir()
    (folder / "job.sh").write_text(script)
    count = int(re.search(r"--array=1-(\d+)", script)[1])
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    for task in range(1, count + 1):
        environment = {"PATH": path, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": str(count)}
        subprocess.run(["bash", "job.sh"], cwd=folder, env=environment, check=True, capture_output=True)
    edgegait.merge(*(folder / "shards" / str(task) / "train" for task in range(1, count + 1)), out=folder / "set")
    return hashed(folder / "set")


def main():
    """Prints the hashes and times."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("guide", type=Path)
    parser.add_argument("--people", type=int, default=100)
    args = parser.parse_args()
    people, args.folder = args.people, args.folder.resolve()

    started = time.monotonic()
    edgegait.generate("domain-random", people=people, out=args.folder / "one", threads=1)
    seconds = time.monotonic() - started
    expected = hashed(args.folder / "one" / "train")
    print(f"one process:                 {seconds:6.1f} s  {expected[:16]}")

    ray.init(num_cpus=4, include_dashboard=False, log_to_driver=False, configure_logging=False)
    try:
        for name, victim in [("four of Ray's", None), ("four, of which one is killed", 2)]:
            found, seconds = set_of_ray(args.folder / name.replace(" ", "-"), people, victim)
            print(f"{name + ':':28} {seconds:6.1f} s  {found[:16]}")
            assert found == expected, name
        dataset = edgegait.Dataset(edgegait.Design("domain-random"), split="train", people=24, threads=1)
        stream = dataset.stream(128)
        started = time.monotonic()
        batches = hash_of(stream[number] for number in range(40))
        print(f"stream, one process:         {time.monotonic() - started:6.1f} s  {batches[:16]}")
        for name, victim in [("stream, four", None), ("stream, one of four killed", 12)]:
            started = time.monotonic()
            found = hash_of(batches_of_ray(dataset, 40, victim))
            print(f"{name + ':':28} {time.monotonic() - started:6.1f} s  {found[:16]}")
            assert found == batches, name
        guide_blocks(args.folder / "guide", args.guide)
        print("the guide's blocks:          run")
    finally:
        ray.shutdown()
    found = array_job(args.folder / "array", args.guide, people)
    print(f"array job:                             {found[:16]}")
    assert found == expected


if __name__ == "__main__":
    main()
