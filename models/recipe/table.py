"""Measures every shipped recognizer on people that none was trained on, and prints the tables of models/README.md.

    python models/recipe/table.py --work target/recipe

    python models/recipe/table.py --work target/recipe --tree "made elsewhere=FOLDER" --fps 30 --subjects 103,112

The tables include PCA + LDA, trained on the people of the networks, and the small network for GEIs, trained on as many
people without clothes, loads and faults, and on dressed people without loads and faults. The command caches the answers
of networks, so that an interrupted run continues.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SHIPPED = ["side", "spread", "gei-small", "geinet", "geinet-int8", "gaitset-small"]
# The recognizer that the others are compared with, person by person.
BEST = "gei-small"
OF_SILHOUETTES = "gaitset-small"
# Test people: a seed that no training used.
UNSEEN = {"seed": 77, "people": "0..30"}


def run(*command):
    """Runs a command, and exits if it fails."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(part) for part in command)}: ended with status {done.returncode}")


def percent(rate):
    return f"{100 * rate:.1f}"


def interval(entry, name="rank1"):
    """Formats rank-1 with its interval over people."""
    low, high = entry[f"{name}_low"], entry[f"{name}_high"]
    return f"{percent(entry[name])} ({percent(low)} - {percent(high)})"


def points(rates):
    """Formats a difference of rates with its interval, in percentage points."""
    # Adding 0 turns -0 into 0.
    return "{:+.1f} ({:+.1f} - {:+.1f})".format(*[round(100 * rate, 1) + 0.0 for rate in rates])


class Table:
    """Runs the command, and keeps its results."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.work = arguments.work / "table"
        self.work.mkdir(parents=True, exist_ok=True)
        self.models = [self.enrolled_at_side(name) for name in SHIPPED]
        lda = self.work / "pca-lda.onnx"
        if not lda.exists():
            run(arguments.edgegait, "train", self.geis(), "--components", "200", "--out", lda)
        self.models.append(self.enrolled_at_side("pca-lda", lda))
        dressed = re.sub(r"(?s)\n\[\[conditions\]\].*", "", (HERE / "people.toml").read_text())
        bare = dressed.replace('dressed = "per-take"', 'dressed = "never"')
        for kind, design in (("bare", bare), ("dressed", dressed)):
            self.models.append(self.enrolled_at_side(f"{BEST}-{kind}", self.trained_on(kind, design)))

    def trained_on(self, kind, design):
        """Returns the small network for GEIs, trained on people of another design."""
        path = self.work / f"people-{kind}.toml"
        path.write_text(design)
        out = self.work / kind
        if not (out / f"{BEST}.onnx").exists():
            run(
                sys.executable, HERE / "make.py", "--design", path, "--networks", BEST, "--out", out,
                "--work", self.work, "--edgegait", self.arguments.edgegait,
            )
        return out / f"{BEST}.onnx"

    def geis(self):
        """Returns the GEIs of the networks' people, without silhouettes, for the command to train on."""
        folder = self.work / "geis"
        if not folder.exists():
            design = self.work / "geis.toml"
            design.write_text((HERE / "people.toml").read_text().replace('["gei", "silhouettes"]', '"gei"'))
            run(self.arguments.edgegait, "generate", design, "--out", folder)
        return folder

    def enrolled_at_side(self, name, path=None):
        """Copies a model with training from the side in its contract, so that all enrol people there."""
        path = path or self.arguments.models / f"{name}.onnx"
        copy = self.work / "models" / f"{name}.onnx"
        copy.parent.mkdir(exist_ok=True)
        shutil.copyfile(path, copy)
        contract = path.with_suffix(".toml").read_text()
        stated, count = re.subn(r"(?m)^viewpoints = .*$", "viewpoints = [[90.0, 0.0]]", contract)
        if count != 1:
            sys.exit(f"{path.with_suffix('.toml')}: expected one line of viewpoints, found {count}")
        copy.with_suffix(".toml").write_text(re.sub(r"(?m)^name = .*$", f'name = "{name}"', stated))
        return copy

    def asked(self, name, command, *arguments):
        """Runs a command and returns its results from JSON."""
        path = self.work / f"{name}.json"
        out = ["--out", self.work / f"{name}-report"] if command == "score" else []
        run(self.arguments.edgegait, command, *arguments, *out, "--overwrite", "--json", path)
        return json.loads(path.read_text())

    def scored(self, name, *arguments, of_geis=False):
        """Returns the results of all models, or only of those for GEIs, and of baselines, by name; and their differences."""
        models = [path for path in self.models if not (of_geis and path.stem == OF_SILHOUETTES)]
        results = self.asked(name, "score", *models, *arguments)
        found = {}
        # Baselines occur once for each kind of input; the first count.
        names = {}
        for result in results["recognizers"]:
            name = result["name"].partition(" as ")[0]
            if name not in found:
                found[name] = result
                names[result["name"]] = name
        beyond = {}
        for pair in results["paired"]:
            one, other, probes = names.get(pair["recognizer"]), names.get(pair["other"]), pair["probe_set"]
            rates = [pair[key] for key in ("difference", "low", "high")]
            beyond[one, other, probes] = points(rates)
            beyond[other, one, probes] = points([-rates[0], -rates[2], -rates[1]])
        return found, beyond

    def protocol(self, name):
        return ["--protocol", HERE / "protocols" / f"{name}.toml"]


def rows(heads, lines):
    """Returns a Markdown table whose first column is aligned left."""
    alignment = ["---", *["--:"] * (len(heads) - 1)]
    return "\n".join("| " + " | ".join(line) + " |" for line in [heads, alignment, *lines])


def costs(table):
    """Returns the table of parameters, multiply-accumulates, bytes, latency and memory."""
    found = {}
    # The models of other populations are the same network.
    models = [path for path in table.models if not path.stem.startswith(f"{BEST}-")]
    for runtime in ("rten", "ort"):
        library = ["--ort-lib", table.arguments.ort_lib] if table.arguments.ort_lib and runtime == "ort" else []
        bench = table.asked(f"bench-{runtime}", "bench", *models, "--views", "side", "--max-seconds", "10", "--runtime", runtime, *library)
        found[runtime] = {model["name"]: model for model in bench["models"]}
    heads = ["", "parameters", "multiply-accumulates", "bytes", "rten, p50 us", "ONNX Runtime, p50 us", "peak memory over the program's, rten, MB"]
    lines = []
    for name, model in found["rten"].items():
        macs = f"{model['macs']:,}" if model.get("macs") else ""
        memory = model.get("peak_rss_over_baseline_bytes")
        lines.append(
            [f"`{name}`", f"{model['params']:,}", macs, f"{model['bytes']:,}", f"{model['p50_us']:,.0f}"]
            + [f"{found['ort'][name]['p50_us']:,.0f}", f"{memory / 1e6:.1f}" if memory else ""]
        )
    return rows(heads, lines)


def beyond_others(best, heads, columns):
    """Returns the table of one network minus the others; each column is a result of `scored` and a probe set."""
    names = [name for name in columns[-1][0][0] if name != best]
    lines = [[f"`{name}`", *[beyond.get((best, name, probes), "") for (_, beyond), probes in columns]] for name in names]
    return f"`{best}` minus the others on the same probes, in points of rank-1, with intervals of the difference, paired over people:\n\n" + rows(
        ["beyond", *heads], [line for line in lines if any(line[1:])]
    )


def everywhere(table):
    """Returns the tables of rank-1 over 703 viewpoints, by enrolment and angle from the side, and under conditions."""
    pack = table.work / "unseen.egp"
    if not pack.exists():
        run(
            table.arguments.edgegait, "cohort", "--people", UNSEEN["people"], "--seed", UNSEEN["seed"],
            "--speeds-kmh", "5", "--dressed", "--quick", "--out", pack,
        )
    drawn = ["--raster", "rows"]
    by_enrolment = [
        table.scored(name, pack, "--views", "paper", *drawn, *table.protocol(name))
        for name in ("enrolled-at-side", "enrolled-there", "enrolled-all-round")
    ]
    casia = table.scored("casia-b", pack, *drawn, "--protocol", "casia-b")
    heads = ["enrolled from the side", "from the probe's viewpoint", "from all 703"]
    heads += ["11 level viewpoints crosswise: NM", "BG", "CL"]
    conditions = ["NM", "BG", "CL"]
    beyond = [(found, None) for found in by_enrolment] + [(casia, condition) for condition in conditions]
    beyond = beyond_others(BEST, heads, beyond)
    by_enrolment, casia = [found for found, _ in by_enrolment], casia[0]
    lines = []
    for name, result in casia.items():
        # Some baselines are absent if there is too much to compare.
        cells = [interval(found[name]) if name in found else "" for found in by_enrolment]
        sets = {probe_set["name"]: probe_set for probe_set in result["probe_sets"]}
        lines.append([f"`{name}`", *cells, *[interval(sets[condition]) for condition in conditions]])
    from_side = by_enrolment[0]
    bins = [entry["to_deg"] for entry in next(iter(from_side.values()))["by_angle"]]
    angles = [[f"`{name}`", *[interval(entry) for entry in result["by_angle"]]] for name, result in from_side.items()]
    heads_of_angles = ["rank-1 %, enrolled from the side, seen", "from there", *[f"to {to:.0f}°" for to in bins[1:]]]
    return "\n\n".join([rows(["rank-1 %", *heads], lines), beyond, rows(heads_of_angles, angles)])


def trees(table):
    """Returns the tables of rank-1 on silhouettes of other software."""
    parts = []
    for stated in table.arguments.tree:
        title, _, folder = stated.partition("=")
        chosen = ["--subjects", table.arguments.subjects] if table.arguments.subjects else []
        fps = ["--fps", table.arguments.fps]
        asked = {
            "another take, same side": ["--protocol", "leave-one-take-out", *fps],
            "another take, other sides": ["--protocol", "cross-view", *fps],
            "any cycle, other sides": [*table.protocol("sides"), *fps],
        }
        whole = [*table.protocol("sides"), "--whole-recordings"]
        stem = re.sub(r"\W+", "-", title)
        found = [table.scored(f"{stem}-{at}", folder, *chosen, *how, of_geis=True) for at, how in enumerate(asked.values())]
        asked["any recording, other sides"] = whole
        found.append(table.scored(f"{stem}-whole", folder, *chosen, *whole))
        # Networks for silhouettes take whole recordings of a tree, not cycles.
        cell = lambda name, results: interval(results[name]) if name in results else ""
        lines = [[f"`{name}`", *[cell(name, results) for results, _ in found]] for name in found[-1][0]]
        beyond = beyond_others(BEST, list(asked), [(results, None) for results in found])
        recordings = beyond_others(OF_SILHOUETTES, list(asked)[-1:], [(found[-1], None)])
        parts.append("\n\n".join([title, rows(["rank-1 %", *asked], lines), beyond, recordings]))
    return "\n\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=Path, default=ROOT / "models", help="folder of the models")
    parser.add_argument("--edgegait", type=Path, default=ROOT / "target/release/edgegait", help="the edgegait command")
    parser.add_argument("--work", type=Path, default=ROOT / "target/recipe", help="folder that make.py worked in")
    parser.add_argument("--ort-lib", help="the library of ONNX Runtime")
    parser.add_argument("--tree", action="append", default=[], metavar="TITLE=FOLDER", help="a tree of silhouettes")
    parser.add_argument("--subjects", help="use only these people of the trees")
    parser.add_argument("--fps", default="25", help="frames a second of the trees")
    parser.add_argument("--only", choices=["costs", "everywhere", "trees"], help="print only this table")
    arguments = parser.parse_args()
    table = Table(arguments)
    for make in (costs, everywhere, trees):
        if arguments.only in (None, make.__name__):
            print(make(table), end="\n\n", flush=True)


if __name__ == "__main__":
    main()
