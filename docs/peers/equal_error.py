#!/usr/bin/env python3
"""How long does Mitsuba's path tracer need for the error that each Twinlight technique has?

    equal_error.py --scenes FOLDER [--twinlight target/release/twinlight] [--only NAME] [--quick] [-o DIR]
    equal_error.py --only soft-spheres [...]

One bounce of indirect light on three scenes, and all light of a soft sky on one that is made here; 512 x 512 pixels on
both sides, compared pixel by pixel; and, in a second table, averages of 128 x 128, where Mitsuba samples just the
128 x 128 pixels. Both are timed in turns within one run, on all cores. See README.md for the method. Needs mitsuba with
LLVM, numpy, pillow, and a release build.
"""

import argparse
import json
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time

try:
    import numpy as np

    import soft_scene
    from compare_means import light_options, triple
    from equal_peer import Peer, check_mitsuba
    from mitsuba_reference import Fail, mitsuba, read_exr
except ImportError as e:
    print(f"equal_error: {e}; see docs/peers/README.md for what to install", file=sys.stderr)
    sys.exit(2)

HEAD = """# Equal error: Mitsuba 3 beside Twinlight

Written by `equal_error.py`; how it is measured: [README.md](README.md#equal-error).

Ratio: Mitsuba's seconds over Twinlight's, above 1 where Twinlight is quicker. *: beyond measured samples, by
1/√samples. >: more than four times them.
"""

SIDES = (512, 128)  # pixels along a side: as rendered, and averaged for the second table

SCENES = [
    {"name": "cornell-original", "eye": [0, 1, 3.4], "target": [0, 1, 0], "fov": 39,
     "light": {"kind": "point", "position": [0, 1.8, 0], "intensity": [2, 2, 2]},
     "visibility-filter": [], "samples": 128},  # heavy tails: the lamp is close under the ceiling
    {"name": "sponza", "eye": [-11, 1.7, -0.5], "target": [8, 4.5, 0], "fov": 60,
     "light": {"kind": "sun", "direction": [0.25, -1, 0.15], "intensity": [12, 11, 9.5]},
     "visibility-filter": ["--proxies", "170000", "--grid", "32"], "samples": 64},
    {"name": "sibenik", "eye": [-14, 4, 0], "target": [10, 7, 0], "fov": 65,
     "light": {"kind": "point", "position": [0, 8, 0], "intensity": [120, 115, 100]},
     "visibility-filter": [], "samples": 64},
    soft_scene.SCENE,
]


def contestants(scene):
    """Technique and settings of each row; the path tracer, to tell what the technique does and what the program."""
    if "contestants" in scene:
        return scene["contestants"]
    filter_ = scene["visibility-filter"]
    return [("visibility-filter", filter_), ("visibility-filter", [*filter_, "--rays", "4"]),
            ("voxel-cones", []), ("voxel-cones", ["--resolution", "256"]), ("layered-rsm", []),
            ("reference", ["--samples", "16"])]


def twinlight(a, scene, technique, settings, output):
    """What the command says, with the seconds it says it took and the wall time of the whole process."""
    light = "=".join(light_options(scene["light"]) if "light" in scene else ["--environment", scene["environment"]])
    command = [a.twinlight, "render", scene["file"], "--technique", technique, "--bounces", "1",
               "--only", scene.get("only", "indirect"),
               f"--eye={triple(scene['eye'])}", f"--target={triple(scene['target'])}", "--fov", str(scene["fov"]),
               "--no-scene-lights", light, "--backend", "cpu", "--quiet", "--json",
               "--size", f"{SIDES[0]}x{SIDES[0]}", "-o", output, *settings]
    start = time.perf_counter()
    run = subprocess.run(command, capture_output=True, text=True)
    wall = time.perf_counter() - start
    if run.returncode:
        raise RuntimeError(f"{technique} on {scene['name']}: {run.stderr.strip() or run.returncode}")
    out = json.loads(run.stdout)
    seconds = sum(p["ms"] for p in out["passes"]) * 1e-3 if "passes" in out else out["seconds"]
    return {**out, "seconds": seconds, "wall": wall}


def averaged(picture, side):
    if not np.isfinite(picture).all():
        raise RuntimeError("a picture has pixels that are not finite")
    k = len(picture) // side
    return picture.reshape(side, k, side, k, 3).mean((1, 3))


def square(x, y, halves):
    """Mean square error by two independent halves of a reference, whose noise adds nothing to it on average."""
    return float(((x - halves[0]) * (y - halves[1])).mean())


def relative(mean_square, halves):
    """Relative RMSE; 0 where noise has made the estimate negative."""
    return math.sqrt(max(mean_square, 0)) / float(np.mean(halves))


def uncertainty(x, halves):
    """Standard error of the RMSE, as a share of it; at most, as the error's own variation over pixels counts, too."""
    products = ((x - halves[0]) * (x - halves[1])).mean(-1)
    return float(products.std() / math.sqrt(products.size) / (2 * products.mean())) if products.mean() > 0 else 1.0


def at_error(points, seconds, target):
    """Samples and seconds at which the error is `target`, and a mark: log-log between the neighbouring points; beyond
    them (*), error as 1/sqrt(samples), up to four times as many or as few; further off, a bound (> or <)."""
    errors, samples = ([p[key] for p in points] for key in ("error", "samples"))
    if target <= 0 or min(errors) <= 0:
        return None
    for i in range(len(points) - 1):
        if errors[i] >= target >= errors[i + 1] and errors[i] > errors[i + 1]:
            share = math.log(target / errors[i]) / math.log(errors[i + 1] / errors[i])
            return *(of[i] * (of[i + 1] / of[i]) ** share for of in (samples, seconds)), ""
    i = 0 if target > errors[0] else -1
    factor = (errors[i] / target) ** 2
    mark, factor = "<" if factor < 0.25 else ">" if factor > 4 else "*", min(max(factor, 0.25), 4)
    return samples[i] * factor, seconds[i] * factor, mark


def sample(peer, name, side, point, seed, halves):
    x, seconds, point["samples"] = peer.render(name, side, point["samples"], seed)
    x = averaged(x, side)
    for key, value in (("seconds", seconds), ("squares", square(x, x, halves)), ("means", float(x.mean()))):
        point.setdefault(key, []).append(value)
    return x


def climb(a, peer, name, side, halves, least):
    """The first turn: ever four times as many samples, until the least error or --longest."""
    peer.render(name, side, 1, 1)  # compiles
    points, spp = [], 4
    while True:
        points.append({"samples": spp})
        x, point = sample(peer, name, side, points[-1], 10 + len(points), halves), points[-1]
        spp, needed = point["samples"], (relative(point["squares"][0], halves) / max(least, 1e-6)) ** 2
        room = 2 ** 31 / side ** 2 / spp  # one rendering has room for fewer than 2^32 paths
        following = int(spp * min(4, 1.1 * needed, a.longest / point["seconds"][0], room))
        if following < 1.4 * spp:
            return points, x
        spp = following


def measure(a, scene, folder):
    def say(text): print(f"{scene['name']}: {text}", file=sys.stderr, flush=True)
    say("references")
    if scene is soft_scene.SCENE:
        scene = {**scene, **soft_scene.write(folder)}
    output, full = os.path.join(folder, "picture.exr"), SIDES[0]
    samples, mine = a.samples or scene["samples"], []
    for seed in (977, 978):
        twinlight(a, scene, "reference", ["--samples", str(samples), "--seed", str(seed)], output)
        mine.append(read_exr(output))
    peer = Peer(scene, soft_scene.mitsuba_sky() if "environment" in scene else None)
    other = list(peer.methods)[-1]
    theirs = [peer.render(other, full, samples, 2_000_000 + i)[0] for i in range(2)]
    mine, theirs = ({side: [averaged(h, side) for h in halves] for side in SIDES} for halves in (mine, theirs))
    rows = [{"technique": t, "settings": " ".join(s), "seconds": [], "wall": []} for t, s in contestants(scene)]
    points, last = {}, {}
    for turn in range(a.repeats):
        say(f"turn {turn + 1} of {a.repeats}")
        for row, (technique, settings) in zip(rows, contestants(scene)):
            out = twinlight(a, scene, technique, settings, output)
            for key in ("seconds", "wall"):
                row[key].append(out[key])
            for side in SIDES if turn == 0 else ():  # the later pictures are the same, bit by bit
                x, halves = averaged(read_exr(output), side), mine[side]
                row[side] = {"error": relative(square(x, x, halves), halves), "uncertainty": uncertainty(x, halves),
                             "mean_ratio": float(x.mean() / np.mean(halves))}
        for side, name in ((side, name) for side in SIDES for name in peer.methods):
            if turn == 0:
                points[side, name], x = climb(a, peer, name, side, theirs[side], min(r[side]["error"] for r in rows))
                say(f"{name}, {side} x {side}: {', '.join(str(p['samples']) for p in points[side, name])} samples")
            else:
                for i, point in enumerate(points[side, name]):
                    x = sample(peer, name, side, point, 1000 * turn + i, theirs[side])
            last.setdefault((side, name), []).append(x)
    for (side, name), of in points.items():
        for point in of:
            point["error"] = relative(statistics.mean(point.pop("squares")), theirs[side])
            point["mean_ratio"] = statistics.mean(point.pop("means")) / float(np.mean(theirs[side]))
        for row in rows:
            row[side][name] = equal(row[side]["error"], row["seconds"], of)
    pairs = [(x, y) for x in last[full, peer.stock] for y in last[full, peer.stock] if x is not y]
    checks = {  # apart: what differs beyond noise, by products of independent differences
        "noise": {who: {side: relative(((halves[side][0] - halves[side][1]) ** 2).mean() / 2, halves[side])
                        for side in SIDES} for who, halves in (("twinlight", mine), ("mitsuba", theirs))},
        "reference_mean_ratio": float(np.mean(mine[full]) / np.mean(theirs[full])),
        "references_apart": {side: relative(square(*mine[side], theirs[side]), theirs[side]) for side in SIDES},
        "stock_apart": pairs and relative(statistics.mean(square(*p, theirs[full]) for p in pairs), theirs[full])}
    return {"scene": scene["name"], "samples": samples, "stock": peer.stock, "other": other, "rows": rows,
            "checks": checks, "methods": [{"side": side, "method": name, "points": of} for (side, name), of in points.items()]}


def equal(error, ours, points):
    """Mitsuba's seconds for an error, or None; ratios within each turn, as other work then touches both sides."""
    found = at_error(points, [statistics.median(p["seconds"]) for p in points], error)
    if found is None:
        return None
    ratios = [at_error(points, [p["seconds"][i] for p in points], error)[1] / s for i, s in enumerate(ours)]
    return {"samples": found[0], "seconds": found[1], "mark": found[2],
            "ratio": statistics.median(ratios), "ratio_range": [min(ratios), max(ratios)]}


def number(x, digits=2):
    return "–" if x is None else f"{x:.{max(0, digits - 1 - math.floor(math.log10(x)))}f}" if x > 0 else "0"


def table(result):
    checks, stock, other = (result[key] for key in ("checks", "stock", "other"))
    lines = [f"### {result['scene']}", "", where(result)]
    for side in SIDES:
        lines += ["", f"Compared at {side} × {side}:", "",
                  f"| technique | settings | error | mean ratio | Twinlight s | `{stock}` samples | `{stock}` s "
                  f"| ratio (range) | `{other}` samples | `{other}` s | ratio |", "|---" * 11 + "|"]
        for r in result["rows"]:
            cells = []
            for p in (r[side][stock], r[side][other]):
                form = {"*": "{}\\*", ">": "> {}", "<": "< {}"}.get(p and p["mark"], "{}")
                cells += [form.format(number(p and p[key], digits)) for key, digits in
                          (("samples", 3), ("seconds", 3), ("ratio", 2))]
            if r[side][stock]:
                cells[2] = f"**{cells[2]}** ({' to '.join(number(x) for x in r[side][stock]['ratio_range'])})"
            lines.append(f"| {r['technique']} | {r['settings'] and '`' + r['settings'] + '`'} "
                         f"| {100 * r[side]['error']:.1f} % | {r[side]['mean_ratio']:.3f} "
                         f"| {number(statistics.median(r['seconds']), 3)} | {' | '.join(cells)} |")
    def percents(of): return " and ".join(f"{100 * of[side]:.1f} %" for side in SIDES)
    worst, noise = max(r[side]["uncertainty"] for r in result["rows"] for side in SIDES), checks["noise"]
    means = ", ".join(f"`{m['method']}` {m['points'][-1]['mean_ratio']:.4f}" for m in result["methods"][:2])
    if checks["stock_apart"] != []:
        means += f" (`{stock}` differs beyond noise by {100 * checks['stock_apart']:.1f} %)"
    return "\n".join([*lines, "", (
        f"References: 2 × {result['samples']} paths a pixel. Noise of one half, which adds nothing to the errors: "
        f"Twinlight {percents(noise['twinlight'])}, Mitsuba {percents(noise['mitsuba'])}. Twinlight's errors are "
        f"known to {100 * worst:.1f} % of themselves or better. Between the references beyond noise: "
        f"{percents(checks['references_apart'])}; ratio of means {checks['reference_mean_ratio']:.4f}. Mean over "
        f"Mitsuba's reference at most samples: {means}."), ""])


def where(result):
    """One line on which machine, by what, and how a scene was measured."""
    of, settings = result["machine"], result["settings"]
    return (f"{of['date']}; {of['cpu']}, {of['cores']} cores; {of['twinlight']}, Mitsuba {of['mitsuba']} "
            f"({of['variant']}, {of['mitsuba_threads']} threads); {settings['repeats']} turns, "
            f"`--longest {settings['longest']:g}`.")


def keep(folder, result):
    """Writes a scene's result into the folder's files, where it takes the place of the scene's earlier one."""
    file, text = (os.path.join(folder, "equal_error" + end) for end in (".json", ".md"))
    results, sections = {}, {"head": HEAD}
    if os.path.exists(file):
        with open(file, encoding="utf-8") as f:
            shared = json.load(f)  # machine and settings, of files from before scenes had their own
            results = {r["scene"]: {**shared, **r} for r in shared.pop("scenes")}
    if os.path.exists(text):
        with open(text, encoding="utf-8") as f:
            head, *others = re.split("(?m)^### ", f.read())
        sections = {"head": head, **{s.split("\n")[0]: "### " + s for s in others}}
    results[result["scene"]], sections[result["scene"]] = result, table(result)
    with open(file, "w", encoding="utf-8") as f:
        json.dump({"scenes": list(results.values())}, f, indent=1)
    with open(text, "w", encoding="utf-8") as f:
        f.write("\n\n".join(s.strip() for s in sections.values()) + "\n")


def machine(a):
    import drjit as dr
    mi, cpu = mitsuba("llvm_ad_rgb"), platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo") as f:
            cpu = next((l.split(":", 1)[1].strip() for l in f if l.startswith("model name")), cpu)
    version = subprocess.run([a.twinlight, "--version"], capture_output=True, text=True).stdout.strip()
    return {"date": time.strftime("%Y-%m-%d"), "cpu": cpu, "cores": len(os.sched_getaffinity(0)),
            "mitsuba_threads": dr.thread_count(), "load_average": os.getloadavg()[0], "twinlight": version, "mitsuba": mi.__version__,
            "variant": mi.variant(), "drjit": dr.__version__, "python": platform.python_version()}


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../target/release/twinlight")
    ap.add_argument("--scenes", help="folder of cornell-original.glb, sponza.glb, sibenik.glb; soft-spheres needs none")
    ap.add_argument("--twinlight", default=os.path.normpath(beside))
    ap.add_argument("--only", action="append", choices=[s["name"] for s in SCENES], help="this scene; repeatable")
    ap.add_argument("--samples", type=int, help="paths a pixel of each half of the references (64; Cornell 128)")
    ap.add_argument("--repeats", type=int, help="turns, each with other seeds for Mitsuba (3)")
    ap.add_argument("--longest", type=float, help="seconds that one rendering of Mitsuba's may take (10)")
    ap.add_argument("--quick", action="store_true", help="16 paths, 1 turn, 2 seconds: to try it out")
    ap.add_argument("-o", "--output", help="folder of equal_error.json and equal_error.md; other scenes in them stay")
    a = ap.parse_args()
    for name, value, quick in (("samples", None, 16), ("repeats", 3, 1), ("longest", 10.0, 2.0)):
        if getattr(a, name) is None:
            setattr(a, name, quick if a.quick else value)
    if (a.samples is not None and not 4 <= a.samples <= 4096) or a.repeats < 1 or not 0 < a.longest < 3600:
        raise Fail("--samples must be from 4 to 4096, --repeats at least 1, and --longest above 0 and below 3600")
    scenes = [s for s in SCENES if not a.only or s["name"] in a.only]
    if a.scenes is None and scenes != [soft_scene.SCENE]:
        raise Fail(f"--scenes FOLDER is needed, except with --only {soft_scene.SCENE['name']}")
    scenes = [s if s is soft_scene.SCENE else {**s, "file": os.path.join(a.scenes, s["name"] + ".glb")}
              for s in scenes]
    for path, hint in ((a.twinlight, "run 'cargo build --release', or give --twinlight PATH"),
                       *((s["file"], "choose scenes with --only, or another folder with --scenes") for s in scenes if "file" in s)):
        if not os.path.isfile(path):
            raise Fail(f"{path} is not there; {hint}")
    check_mitsuba()

    print(HEAD, flush=True)
    settings = {k: getattr(a, k) for k in ("samples", "repeats", "longest", "quick")}
    if a.output:
        os.makedirs(a.output, exist_ok=True)
    for scene in scenes:
        of = machine(a)
        with tempfile.TemporaryDirectory() as folder:
            result = {**measure(a, scene, folder), "machine": of, "settings": settings}
        print(table(result), flush=True)
        if a.output:  # after every scene, so that an interrupted run leaves the finished ones
            keep(a.output, result)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Fail, OSError, RuntimeError) as e:
        print(f"equal_error: {' '.join(str(e).split())}", file=sys.stderr)
        sys.exit(2 if isinstance(e, Fail) else 1)
