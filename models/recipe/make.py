"""Makes the shipped networks from a seed: dataset, training, ONNX, contracts, 8-bit weights, and a comparison.

    python models/recipe/make.py --out target/networks

Run it in a clone of the repository, after `cargo build --release` and `pip install -r
models/recipe/requirements.txt`. Files that exist in the folder `--work` are used again, so that an interrupted
run continues. `--people 24 --passes 1` tries everything in a minute.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# Each group is trained one after another, with one thread; the two groups run in parallel.
TURNS = [["gei-small", "geinet"], ["gaitset-small"]]
SHIPPED = ["gei-small", "geinet", "geinet-int8", "gaitset-small"]


def run(*command):
    """Runs a command, and exits if it fails."""
    done = subprocess.run([str(part) for part in command])
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(part) for part in command)}: ended with status {done.returncode}")


def generated(arguments):
    """Returns the folder of the dataset, after generating it unless it exists."""
    folder = arguments.work / arguments.design.stem
    if not (folder / "manifest.json").exists():
        fewer = ["--people", arguments.people] if arguments.people else []
        more = ["--resume"] if folder.exists() else []
        run(arguments.edgegait, "generate", arguments.design, *fewer, *more, "--out", folder)
    return folder


def weights_path(arguments, name, manifest):
    """Returns the path of a network's weights, which changes with everything that determines them."""
    parts = [manifest, *(HERE / file for file in ("data.py", "networks.py", "train.py"))]
    content = b"".join(path.read_bytes() for path in parts)
    made_of = hashlib.sha256(content + f"{arguments.seed} {arguments.passes}".encode()).hexdigest()
    return arguments.work / f"{name}-{made_of[:12]}.pt"


def train_all(arguments, folder):
    """Trains networks without weights, two at a time, and returns the paths of all weights."""
    turns = [[name for name in turn if name in arguments.networks] for turn in TURNS]
    paths = {name: weights_path(arguments, name, folder / "manifest.json") for turn in turns for name in turn}

    def train_turn(names):
        for name in names:
            if not paths[name].exists():
                partial = paths[name].with_suffix(".partial")
                command = [sys.executable, HERE / "train.py", folder, "--network", name, "--out", partial]
                passes = ["--passes", arguments.passes] if arguments.passes else []
                run(*command, "--seed", arguments.seed, *passes)
                os.replace(partial, paths[name])

    with ThreadPoolExecutor(len(turns)) as pool:
        list(pool.map(train_turn, turns))
    return paths


def compare(arguments):
    """Compares each model with the shipped one."""
    shipped = ROOT / "models"
    for name in SHIPPED:
        here, there = arguments.out / f"{name}.onnx", shipped / f"{name}.onnx"
        if not here.exists() or not there.exists() or here.resolve() == there.resolve():
            continue
        if here.read_bytes() == there.read_bytes():
            print(f"{name}: same bytes as the shipped model")
            continue
        print(f"{name}: bytes differ from the shipped model")
        subprocess.run([str(part) for part in (arguments.edgegait, "parity", there, here)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder for the models and their contracts")
    parser.add_argument("--edgegait", type=Path, default=ROOT / "target/release/edgegait", help="the edgegait command")
    parser.add_argument("--design", type=Path, default=HERE / "people.toml", help="design of the training set")
    parser.add_argument("--work", type=Path, default=ROOT / "target/recipe", help="folder for intermediate files")
    parser.add_argument("--seed", type=int, default=1, help="seed of weights and batches")
    parser.add_argument("--networks", nargs="+", choices=sum(TURNS, []), default=sum(TURNS, []), help="the networks to make")
    parser.add_argument("--people", type=int, help="use only this many people, to try the recipe")
    parser.add_argument("--passes", type=int, help="passes over the data, instead of the recipe's")
    arguments = parser.parse_args()
    if not arguments.edgegait.exists():
        sys.exit(f"{arguments.edgegait}: not found (run `cargo build --release`, or give the command with --edgegait)")
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    folder = generated(arguments)
    weights = train_all(arguments, folder)

    # These imports need PyTorch.
    import torch

    import export
    from data import People
    from networks import NETWORKS

    people = People(folder)
    inputs = people.manifest["inputs"]
    design = f"{arguments.design.name} (SHA-256 {inputs[0]['sha256'][:12]})" if inputs else arguments.design.name
    for name, path in weights.items():
        network = NETWORKS[name]()
        network.load_state_dict(torch.load(path, weights_only=True))
        description = f"{len(people)} sequences of {len(people.names)} people of models/recipe/{design}, models/recipe/make.py, seed {arguments.seed}"
        apart = export.export(people, name, network, arguments.out, description)
        print(f"{name}: ONNX Runtime and PyTorch differ by {apart:.1e} of the largest value")
    sizes = {path.name: path.stat().st_size for path in sorted(arguments.out.glob("*.onnx"))}
    print(json.dumps(sizes, indent=2))
    compare(arguments)


if __name__ == "__main__":
    main()
