#!/usr/bin/env python3
"""How long does Mitsuba's path tracer need for the error that each Twinlight technique has?

    equal_error.py --scenes FOLDER [--twinlight target/release/twinlight] [--only NAME] [--quick] [-o DIR]

One bounce of indirect light on three scenes, 512 x 512 pixels on both sides, compared pixel by pixel; and, in a
second table, averages of 128 x 128, where Mitsuba samples just the 128 x 128 pixels. Both are timed in turns within
one run, on all cores. See README.md for the method. Needs mitsuba with LLVM, numpy, pillow, and a release build.
"""

import argparse
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time

try:
    import numpy as np

    from compare_means import light_options, triple
    from mitsuba_reference import Fail, build_scene, integrator, load_glb, mitsuba, read_exr, view_of
except ImportError as e:
    print(f"equal_error: {e}; see docs/peers/README.md for what to install", file=sys.stderr)
    sys.exit(2)

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
]


def contestants(scene):
    """Technique and settings of each row; the path tracer, to tell what the technique does and what the program."""
    filter_ = scene["visibility-filter"]
    return [("visibility-filter", filter_), ("visibility-filter", [*filter_, "--rays", "4"]),
            ("voxel-cones", []), ("voxel-cones", ["--resolution", "256"]), ("layered-rsm", []),
            ("reference", ["--samples", "16"])]


def twinlight(a, scene, technique, settings, output):
    """What the command says, with the seconds it says it took and the wall time of the whole process."""
    command = [a.twinlight, "render", scene["file"], "--technique", technique, "--bounces", "1", "--only", "indirect",
               f"--eye={triple(scene['eye'])}", f"--target={triple(scene['target'])}", "--fov", str(scene["fov"]),
               "--no-scene-lights", "=".join(light_options(scene["light"])), "--backend", "cpu", "--quiet", "--json",
               "--size", f"{SIDES[0]}x{SIDES[0]}", "-o", output, *settings]
    start = time.perf_counter()
    run = subprocess.run(command, capture_output=True, text=True)
    wall = time.perf_counter() - start
    if run.returncode:
        raise RuntimeError(f"{technique} on {scene['name']}: {run.stderr.strip() or run.returncode}")
    out = json.loads(run.stdout)
    seconds = sum(p["ms"] for p in out["passes"]) * 1e-3 if "passes" in out else out["seconds"]
    return {**out, "seconds": seconds, "wall": wall}


PROBE = """import mitsuba as mi
mi.set_variant('llvm_ad_rgb')
scene = mi.cornell_box(); scene['sensor']['film'].update(width=8, height=8)
print(float(mi.render(mi.load_dict(scene), spp=1).array[0]))"""


def check_mitsuba():
    """In a process of its own, as an LLVM that is too old for Dr.Jit ends the process."""
    run = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True)
    if "No module named" in run.stderr:
        raise Fail("mitsuba is not installed; see docs/peers/README.md")
    if run.returncode:
        raise Fail("Mitsuba's llvm_ad_rgb does not work here: install a newer LLVM library (such as libllvm19) and "
                   "point DRJIT_LIBLLVM_PATH at it")


def second_bounce(mi, dr, masked):
    """An integrator of the indirect light of one bounce alone: three rays a path instead of the four of `path`, and
    none of the noise of direct light. For lights without extent only: what the bounce hits is taken to emit nothing."""

    class SecondBounce(mi.SamplingIntegrator):  # dr.syntax compiles anew: its functions see no variables of this one
        def hole(self, si, active):
            return active & si.is_valid() & (si.bsdf().eval_null_transmission(si, active).x > 0.5)

        @dr.syntax
        def nearest(self, scene, ray, active):
            si = scene.ray_intersect(ray, active)
            if self.masked:
                hole = self.hole(si, active)
                while hole:
                    si = scene.ray_intersect(si.spawn_ray(ray.d), hole)
                    hole = self.hole(si, hole)
            return si

        @dr.syntax
        def blocked(self, scene, si, point, active):
            ray = si.spawn_ray_to(point)
            if not self.masked:
                hit = scene.ray_test(ray, active)
            else:
                hit, going = active & False, active & True
                while going:
                    between = scene.ray_intersect(ray, going)
                    hole = self.hole(between, going)
                    hit |= going & between.is_valid() & ~hole
                    ray = between.spawn_ray_to(point)
                    going = hole
            return hit

        def sample(self, scene, sampler, ray, medium=None, active=True):
            context = mi.BSDFContext()
            first = self.nearest(scene, ray, mi.Bool(active))
            active = first.is_valid() & active
            way, weight = first.bsdf().sample(context, first, sampler.next_1d(active), sampler.next_2d(active), active)
            active &= way.pdf > 0
            second = self.nearest(scene, first.spawn_ray(first.to_world(way.wo)), active)
            active &= second.is_valid()
            light, incident = scene.sample_emitter_direction(second, sampler.next_2d(active), False, active)
            seen = weight * incident * second.bsdf().eval(context, second, second.to_local(light.d), active)
            active &= dr.any(seen > 0)  # no shadow ray where no light would come
            active &= ~self.blocked(scene, second, light.p, active)
            return dr.select(active, seen, 0), active, []

    made = SecondBounce(mi.Properties())
    made.masked = masked
    return made


class Peer:
    """Mitsuba on one scene: references, and renderings with their time."""

    def __init__(self, scene):
        import drjit as dr
        self.mi, self.dr, self.sensors = mitsuba("llvm_ad_rgb"), dr, {}
        self.mi.set_log_level(self.mi.LogLevel.Error)  # no word on every number of samples that gets rounded
        self.view = view_of({"up": [0, 1, 0], **scene})
        self.scene, self.masked = build_scene(load_glb(scene["file"]), self.view, SIDES[:1] * 2)
        self.stock = "volpath" if self.masked else "path"
        direct, path = (integrator(self.mi, bounces, self.masked) for bounces in (0, 1))
        self.methods = {  # integrator, what to subtract, sampler
            self.stock: (path, direct, "independent"),
            "bounce": (second_bounce(self.mi, dr, self.masked), None, "multijitter"),
        }

    def sensor(self, side, sampler):
        if (side, sampler) not in self.sensors:
            v, T = self.view, self.mi.ScalarTransform4f
            self.sensors[side, sampler] = self.mi.load_dict({
                "type": "perspective", "fov": float(v["fov"]), "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e5,
                "to_world": T().look_at(origin=v["eye"], target=v["target"], up=v["up"]),
                "film": {"type": "hdrfilm", "width": side, "height": side, "pixel_format": "rgb",
                         "component_format": "float32", "rfilter": {"type": "box"}},
                "sampler": {"type": sampler}})
        return self.sensors[side, sampler]

    def render(self, name, side, spp, seed):
        """The indirect light, the seconds of the kernels (not of recording and compiling them), and the samples of a
        pixel, which multijitter may round up. From the stock integrator's picture, that of the same seed without the
        bounce is taken, untimed: its camera rays and light samples are the same, so direct light cancels exactly."""
        whole, direct, sampler = self.methods[name]
        sensor = self.sensor(side, sampler)
        image = self.mi.render(self.scene, sensor=sensor, integrator=whole, spp=spp, seed=seed)
        start = time.perf_counter()
        self.dr.eval(image)
        self.dr.sync_thread()
        seconds = time.perf_counter() - start
        picture = np.array(image, dtype=np.float64)[..., :3]
        if direct is not None:
            less = self.mi.render(self.scene, sensor=sensor, integrator=direct, spp=spp, seed=seed)
            picture = picture - np.array(less, dtype=np.float64)[..., :3]
        return picture, seconds, sensor.sampler().sample_count()


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
    output, full = os.path.join(folder, "picture.exr"), SIDES[0]
    samples, mine = a.samples or scene["samples"], []
    for seed in (977, 978):
        twinlight(a, scene, "reference", ["--samples", str(samples), "--seed", str(seed)], output)
        mine.append(read_exr(output))
    peer = Peer(scene)
    theirs = [peer.render("bounce", full, samples, 2_000_000 + i)[0] for i in range(2)]
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
    return {"scene": scene["name"], "samples": samples, "stock": peer.stock, "rows": rows, "checks": checks,
            "methods": [{"side": side, "method": name, "points": of} for (side, name), of in points.items()]}


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
    checks, stock, lines = result["checks"], result["stock"], [f"### {result['scene']}"]
    for side in SIDES:
        lines += ["", f"Compared at {side} × {side}:", "",
                  f"| technique | settings | error | mean ratio | Twinlight s | `{stock}` samples | `{stock}` s "
                  "| ratio (range) | `bounce` samples | `bounce` s | ratio |", "|---" * 11 + "|"]
        for r in result["rows"]:
            cells = []
            for p in (r[side][stock], r[side]["bounce"]):
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


def machine(a):
    import drjit as dr
    mi, cpu = mitsuba("llvm_ad_rgb"), platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo") as f:
            cpu = next((l.split(":", 1)[1].strip() for l in f if l.startswith("model name")), cpu)
    version = subprocess.run([a.twinlight, "--version"], capture_output=True, text=True).stdout.strip()
    return {"cpu": cpu, "cores": len(os.sched_getaffinity(0)), "mitsuba_threads": dr.thread_count(),
            "load_average": os.getloadavg()[0], "twinlight": version, "mitsuba": mi.__version__,
            "variant": mi.variant(), "drjit": dr.__version__, "python": platform.python_version()}


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../target/release/twinlight")
    ap.add_argument("--scenes", required=True, help="folder of cornell-original.glb, sponza.glb, sibenik.glb")
    ap.add_argument("--twinlight", default=os.path.normpath(beside))
    ap.add_argument("--only", action="append", choices=[s["name"] for s in SCENES], help="this scene; repeatable")
    ap.add_argument("--samples", type=int, help="paths a pixel of each half of the references (64; Cornell 128)")
    ap.add_argument("--repeats", type=int, help="turns, each with other seeds for Mitsuba (3)")
    ap.add_argument("--longest", type=float, help="seconds that one rendering of Mitsuba's may take (10)")
    ap.add_argument("--quick", action="store_true", help="16 paths, 1 turn, 2 seconds: to try it out")
    ap.add_argument("-o", "--output", help="folder for equal_error.json and equal_error.md")
    a = ap.parse_args()
    for name, value, quick in (("samples", None, 16), ("repeats", 3, 1), ("longest", 10.0, 2.0)):
        if getattr(a, name) is None:
            setattr(a, name, quick if a.quick else value)
    if (a.samples is not None and not 4 <= a.samples <= 4096) or a.repeats < 1 or not 0 < a.longest < 3600:
        raise Fail("--samples must be from 4 to 4096, --repeats at least 1, and --longest above 0 and below 3600")
    scenes = [{**s, "file": os.path.join(a.scenes, s["name"] + ".glb")} for s in SCENES
              if not a.only or s["name"] in a.only]
    for path, hint in ((a.twinlight, "run 'cargo build --release', or give --twinlight PATH"),
                       *((s["file"], "choose scenes with --only, or another folder with --scenes") for s in scenes)):
        if not os.path.isfile(path):
            raise Fail(f"{path} is not there; {hint}")
    check_mitsuba()

    of = machine(a)
    head = (f"{of['cpu']}, {of['cores']} cores; {of['twinlight']}, Mitsuba {of['mitsuba']} ({of['variant']}, "
            f"{of['mitsuba_threads']} threads); {a.repeats} turns. Ratio: Mitsuba's seconds over Twinlight's, above 1 "
            "where Twinlight is quicker. *: beyond measured samples, by 1/√samples. >: more than four times them.\n")
    print(head, flush=True)
    settings, results, text = {k: getattr(a, k) for k in ("samples", "repeats", "longest", "quick")}, [], head
    os.makedirs(a.output or ".", exist_ok=True)
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            results.append(measure(a, scene, folder))
        print(table(results[-1]), flush=True)
        text += "\n" + table(results[-1])
        if a.output:  # after every scene, so that an interrupted run leaves the finished ones
            everything = json.dumps({"machine": of, "settings": settings, "scenes": results}, indent=1)
            for name, content in (("equal_error.json", everything), ("equal_error.md", text)):
                with open(os.path.join(a.output, name), "w", encoding="utf-8") as f:
                    f.write(content)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Fail, OSError, RuntimeError) as e:
        print(f"equal_error: {' '.join(str(e).split())}", file=sys.stderr)
        sys.exit(2 if isinstance(e, Fail) else 1)
