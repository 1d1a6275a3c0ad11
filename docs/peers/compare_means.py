#!/usr/bin/env python3
"""Render the views of views.json with the twinlight reference and compare image means with Mitsuba's.

    compare_means.py --twinlight target/release/twinlight --views VIEWS.json --scenes DIR --references DIR

DIR of references is what `mitsuba_reference.py references` wrote. Prints one row per view and depth: the ratio of
image means (r + g + b), and the standard error of that ratio from both sides.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile


def triple(values):
    return ",".join(str(v) for v in values)


def light_options(light):
    colour = triple(light["intensity"])
    if light["kind"] == "point":
        return ["--point", f"{triple(light['position'])}:{colour}"]
    if light["kind"] == "spot":
        outer, inner = light["cone"]
        return ["--spot", f"{triple(light['position'])}:{triple(light['direction'])}:{colour}:{outer},{inner}"]
    return ["--sun", f"{triple(light['direction'])}:{colour}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--twinlight", required=True)
    parser.add_argument("--views", required=True)
    parser.add_argument("--scenes", required=True)
    parser.add_argument("--references", required=True)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--only")
    a = parser.parse_args()
    references = pathlib.Path(a.references)
    print(f"{'view':<18} {'bounces':>7} {'mean':>10} {'mitsuba':>10} {'ratio':>8} {'std err':>8}")
    for view in json.load(open(a.views))["views"]:
        if a.only and a.only not in view["name"]:
            continue
        for bounces in (0, 1, 4):
            summary = references / f"{view['name']}-b{bounces}.json"
            if not summary.exists():
                continue
            reference = json.load(open(summary))
            with tempfile.TemporaryDirectory() as folder:
                command = [
                    a.twinlight, "render", str(pathlib.Path(a.scenes) / view["scene"]),
                    "--technique", "reference", "--bounces", str(bounces), "--samples", str(a.samples),
                    "--size", "256x256", "--no-scene-lights", "--eye", triple(view["eye"]),
                    "--target", triple(view["target"]), "--up", triple(view["up"]), "--fov", str(view["fov"]),
                    "--json", "--quiet", "-o", str(pathlib.Path(folder) / "out.exr"), *light_options(view["light"]),
                ]
                result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            ours = sum(result["all"]["mean"]) / 3
            theirs = sum(reference["mean"]) / 3
            error = (result["all"]["standard_error"] / ours) ** 2 + (max(reference["mean_se"]) / theirs) ** 2
            print(f"{view['name']:<18} {bounces:>7} {ours:>10.6f} {theirs:>10.6f} {ours / theirs:>8.4f} {error ** 0.5:>8.4f}",
                  flush=True)


if __name__ == "__main__":
    main()
