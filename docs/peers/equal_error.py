#!/usr/bin/env python3
"""How long does Mitsuba's path tracer need for the error that each Twinlight technique has?

    equal_error.py --scenes FOLDER [--twinlight target/release/twinlight] [--only NAME] [--quick] [-o DIR]

One bounce of indirect light on three scenes. Twinlight renders 512 x 512 pixels; both sides' pictures are compared
at --side 128 pixels, each with a reference of its own renderer. Mitsuba renders by several methods with ever more
samples, and the quickest one for the same error counts. Both are timed in turns within one run, on all cores.
See README.md for what is compared. Needs mitsuba with LLVM, numpy and pillow, and a release build of Twinlight.
"""

import argparse
import importlib.util
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
    from mitsuba_reference import Fail, build_scene, integrator, load_glb, mitsuba, read_exr, view_of, write_exr
except ImportError as e:
    print(f"equal_error: {e}; see docs/peers/README.md for what to install", file=sys.stderr)
    sys.exit(2)

RENDERED = 512  # pixels along a side of Twinlight's pictures
LANES = 1 << 30  # paths of one rendering of Mitsuba's, which has room for fewer than 2^32

SCENES = [
    {"name": "cornell-original", "eye": [0, 1, 3.4], "target": [0, 1, 0], "fov": 39,
     "light": {"kind": "point", "position": [0, 1.8, 0], "intensity": [2, 2, 2]},
     "visibility-filter": [], "samples": 32768},  # heavy tails: the lamp is close under the ceiling
    {"name": "sponza", "eye": [-11, 1.7, -0.5], "target": [8, 4.5, 0], "fov": 60,
     "light": {"kind": "sun", "direction": [0.25, -1, 0.15], "intensity": [12, 11, 9.5]},
     "visibility-filter": ["--proxies", "170000", "--grid", "32"], "samples": 8192},
    {"name": "sibenik", "eye": [-14, 4, 0], "target": [10, 7, 0], "fov": 65,
     "light": {"kind": "point", "position": [0, 8, 0], "intensity": [120, 115, 100]},
     "visibility-filter": [], "samples": 8192},
]


def contestants(scene):
    """Technique and settings of every line of the table. The path tracer is among them to tell what is owed to the
    technique and what to the program."""
    filter_ = scene["visibility-filter"]
    return [("visibility-filter", filter_), ("visibility-filter", [*filter_, "--rays", "4"]),
            ("voxel-cones", []), ("voxel-cones", ["--resolution", "256"]), ("layered-rsm", []),
            ("reference", ["--samples", "16"])]


def twinlight(a, scene, technique, settings, output, side=RENDERED):
    """What the command says, with the seconds it says it took and the wall time of the whole process."""
    light = light_options(scene["light"])
    command = [a.twinlight, "render", scene["file"], "--technique", technique, "--bounces", "1", "--only", "indirect",
               f"--eye={triple(scene['eye'])}", f"--target={triple(scene['target'])}", "--fov", str(scene["fov"]),
               "--no-scene-lights", f"{light[0]}={light[1]}", "--backend", "cpu", "--size", f"{side}x{side}", "--quiet",
               "--json", "-o", output, *settings]
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
    if importlib.util.find_spec("mitsuba") is None:
        raise Fail("mitsuba is not installed; see docs/peers/README.md")
    if subprocess.run([sys.executable, "-c", PROBE], capture_output=True).returncode:
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
    """Mitsuba on one scene: its methods, its reference, and its renderings with their time."""

    def __init__(self, scene, side):
        import drjit as dr
        self.mi, self.dr, self.side = mitsuba("llvm_ad_rgb"), dr, side
        self.view = view_of({"up": [0, 1, 0], **scene})
        self.scene, self.masked = build_scene(load_glb(scene["file"]), self.view, (side, side))
        bounce, path = second_bounce(self.mi, dr, self.masked), integrator(self.mi, 1, self.masked)
        self.direct = 0.0
        self.methods = {  # integrator, side rendered, sampler, whether direct light has to be subtracted
            "path": (path, side, "independent", True),
            "path, multijitter": (path, side, "multijitter", True),
            "bounce, multijitter": (bounce, side, "multijitter", False),
            "bounce, ldsampler": (bounce, side, "ldsampler", False),
        }
        if side < RENDERED:
            self.methods[f"bounce, {RENDERED}x{RENDERED}"] = (bounce, RENDERED, "multijitter", False)
        self.unstratified, self.sensors = (bounce, side, "independent", False), {}

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

    def render(self, method, spp, seed):
        """The picture from `spp` samples for each compared pixel, and the seconds from the end of recording the
        kernel to the end of its last run; the recording counts as part of compilation."""
        integrator_, side, sampler, subtract = method
        k = side // self.side
        passes = -(-side * side * (spp // k ** 2) // LANES)
        total, seconds = 0.0, 0.0
        for i in range(passes):
            image = self.mi.render(self.scene, sensor=self.sensor(side, sampler), integrator=integrator_,
                                   spp=spp // k ** 2 // passes, seed=seed * 1024 + i)
            start = time.perf_counter()
            self.dr.eval(image)
            self.dr.sync_thread()
            seconds += time.perf_counter() - start
            total = total + np.array(image, dtype=np.float64)[..., :3] / passes
        return total.reshape(self.side, k, self.side, k, 3).mean((1, 3)) - (self.direct if subtract else 0), seconds

    def make_references(self, samples):
        """Direct light for `path` to subtract, stratified, so without noise to speak of; indirect light with
        independent samples like Twinlight's, so that both references are about as noisy."""
        passes = max(2, min(32, samples // 64))
        direct = (integrator(self.mi, 0, self.masked), self.side, "multijitter", False)
        self.direct = np.mean([self.render(direct, 256, 3_000_000 + i)[0] for i in range(max(4, samples // 1024))], 0)
        stack = [self.render(self.unstratified, samples // passes, 2_000_000 + i)[0] for i in range(passes)]
        self.reference = np.mean(stack, 0)
        noise = math.sqrt((np.var(stack, 0, ddof=1) / passes).mean()) / self.reference.mean()
        return self.reference, float(noise)


def error_of(picture, reference):
    """Relative RMSE, and the ratio of means."""
    if not np.isfinite(picture).all():
        raise RuntimeError("a picture has pixels that are not finite")
    mean = reference.mean()
    return float(np.sqrt(((picture - reference) ** 2).mean()) / mean), float(picture.mean() / mean)


def at_error(errors, values, target):
    """The value (time or samples) at which the error is `target`: log-log between the neighbouring points, and by the
    outermost two up to four times the last value; None beyond."""
    pairs = [i for i in range(len(errors) - 1) if errors[i] > errors[i + 1] and values[i] < values[i + 1]]
    if not pairs:
        return None
    i = next((i for i in pairs if errors[i] >= target >= errors[i + 1]), pairs[0] if target > errors[0] else pairs[-1])
    share = math.log(target / errors[i]) / math.log(errors[i + 1] / errors[i])
    value = values[i] * (values[i + 1] / values[i]) ** share
    return value if values[0] / 4 <= value <= 4 * values[-1] else None


def measure(a, scene, folder):
    """Everything about one scene."""
    def say(text): print(f"{scene['name']}: {text}", file=sys.stderr, flush=True)
    picture = os.path.join(folder, f"{scene['name']}-twinlight.exr")

    say("references")
    samples = a.samples or scene["samples"]
    out = twinlight(a, scene, "reference", ["--samples", str(samples), "--seed", "977"], picture, a.side)
    right = read_exr(picture)
    noise, peer = 3 * out["indirect"]["pixel_standard_error"] / sum(out["indirect"]["mean"]), Peer(scene, a.side)
    peer_right, peer_noise = peer.make_references(samples)
    write_exr(os.path.join(folder, f"{scene['name']}-mitsuba.exr"), peer_right)

    rows = []
    with tempfile.TemporaryDirectory() as tmp:
        output, k = os.path.join(tmp, "picture.exr"), RENDERED // a.side
        for technique, settings in contestants(scene):
            say(f"{technique} {' '.join(settings)}")
            twinlight(a, scene, technique, settings, output)
            mine = read_exr(output).reshape(a.side, k, a.side, k, 3).mean((1, 3))
            error, ratio = error_of(mine, right)
            rows.append({"technique": technique, "settings": " ".join(settings), "error": error, "mean_ratio": ratio,
                         "seconds": [], "wall": []})

        # As many samples as it takes for the least error; the first rendering compiles the kernel.
        least, points = min(r["error"] for r in rows), {}
        for name, method in peer.methods.items():
            points[name], spp = [], (method[1] // a.side) ** 2 if method[1] > a.side else 4
            peer.render(method, spp, 2)
            while True:
                mine, seconds = peer.render(method, spp, 1)
                points[name].append({"samples": spp, "seconds": [], "squares": [], "mean_ratios": []})
                say(f"{name}: {spp} samples")
                # the next one takes about four times as long
                if error_of(mine, peer_right)[0] <= 0.97 * least or 4 * seconds > a.longest:
                    break
                spp *= 4

        for turn in range(a.repeats):
            say(f"turn {turn + 1} of {a.repeats}")
            for row, (technique, settings) in zip(rows, contestants(scene)):
                out = twinlight(a, scene, technique, settings, output)
                row["seconds"].append(out["seconds"])
                row["wall"].append(out["wall"])
            for name, method in peer.methods.items():
                for point in points[name]:
                    mine, seconds = peer.render(method, point["samples"], 100 + turn)
                    error, ratio = error_of(mine, peer_right)
                    point["seconds"].append(seconds)
                    point["squares"].append(error ** 2)
                    point["mean_ratios"].append(ratio)

    for point in (p for of in points.values() for p in of):
        point["error"] = math.sqrt(statistics.mean(point.pop("squares")))  # RMS over the seeds
        point["mean_ratio"] = statistics.mean(point.pop("mean_ratios"))
    for row in rows:
        row["peers"] = {name: equal(row, of) for name, of in points.items()}
        known = [n for n, p in row["peers"].items() if p]
        row["best"] = min(known, key=lambda n: row["peers"][n]["seconds"]) if known else None
    return {"scene": scene["name"], "samples": samples, "masked": peer.masked, "rows": rows, "methods": points,
            "reference_noise": {"twinlight": noise, "mitsuba": peer_noise},
            "reference_mean_ratio": float(right.mean() / peer_right.mean()),
            "reference_difference": error_of(right, peer_right)[0]}


def equal(row, points):
    """Mitsuba's seconds by one method for the error of a row, or None where they are too far from all measured. Ratios
    are taken within each turn, so that other work on the machine touches both sides."""
    errors = [p["error"] for p in points]
    turns = [at_error(errors, [p["seconds"][i] for p in points], row["error"]) for i in range(len(row["seconds"]))]
    seconds = at_error(errors, [statistics.median(p["seconds"]) for p in points], row["error"])
    if seconds is None or None in turns:
        return None
    ratios = [t / s for t, s in zip(turns, row["seconds"])]
    return {"seconds": seconds, "samples": at_error(errors, [p["samples"] for p in points], row["error"]),
            "ratio": statistics.median(ratios), "ratio_range": [min(ratios), max(ratios)]}


def number(x, digits=2):
    return "–" if x is None else f"{x:.{max(0, digits - 1 - math.floor(math.log10(x)))}f}" if x > 0 else "0"


def table(result):
    noise = result["reference_noise"]
    lines = [f"### {result['scene']}", "",
             "| technique | settings | error | mean ratio | Twinlight s | with loading | Mitsuba s | by | samples "
             "| ratio | `path` s | ratio |", "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for r in result["rows"]:
        best, plain = (r["peers"][n] if n else None for n in (r["best"], "path"))
        best, plain = best or {}, plain or {}
        lines.append(
            f"| {r['technique']} | {'`' + r['settings'] + '`' if r['settings'] else ''} | {100 * r['error']:.1f} % "
            f"| {r['mean_ratio']:.3f} | {number(statistics.median(r['seconds']), 3)} "
            f"| {number(statistics.median(r['wall']), 3)} | {number(best.get('seconds'), 3)} | {r['best'] or '–'} "
            f"| {number(best.get('samples'), 3)} | **{number(best.get('ratio'))}** "
            f"| {number(plain.get('seconds'), 3)} | {number(plain.get('ratio'))} |")
    checks = ", ".join(f"{n}: {of[-1]['mean_ratio']:.4f}" for n, of in result["methods"].items())
    if max(noise.values()) > 0.5 * min(r["error"] for r in result["rows"]):
        checks += ". **The noise is too near to the errors to tell times for them: raise --samples**"
    return "\n".join([*lines, "", (
        f"References, {result['samples']} paths: Twinlight's mean is {result['reference_mean_ratio']:.4f} of "
        f"Mitsuba's, noise {100 * noise['twinlight']:.1f} % and {100 * noise['mitsuba']:.1f} %, relative RMSE between "
        f"them {100 * result['reference_difference']:.1f} %. Means over Mitsuba's reference, most samples: {checks}."), ""])


def machine(a):
    """What it ran on and which versions."""
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
    ap.add_argument("--side", type=int, default=128, help="pixels along a side of what is compared")
    ap.add_argument("--samples", type=int, help="paths per compared pixel of the references (8192; Cornell box 32768)")
    ap.add_argument("--repeats", type=int, help="turns, each with another seed for Mitsuba (7)")
    ap.add_argument("--longest", type=float, help="seconds that one rendering of Mitsuba's may take (60)")
    ap.add_argument("--quick", action="store_true", help="1024 paths, 2 turns, 4 seconds: to try it out")
    ap.add_argument("-o", "--output", help="folder for equal_error.json, equal_error.md and the references")
    a = ap.parse_args()
    for name, value in zip(("samples", "repeats", "longest"), (1024, 2, 4.0) if a.quick else (None, 7, 60.0)):
        if getattr(a, name) is None:
            setattr(a, name, value)
    if a.side < 16 or RENDERED % a.side:
        raise Fail(f"--side must divide {RENDERED} and be at least 16")
    if (a.samples is not None and a.samples < 128) or a.repeats < 1 or a.longest <= 0:
        raise Fail("--samples must be at least 128, --repeats at least 1 and --longest above 0")
    if not os.path.isfile(a.twinlight):
        raise Fail(f"{a.twinlight} is not there; run 'cargo build --release', or give --twinlight PATH")
    scenes = [{**s, "file": os.path.join(a.scenes, s["name"] + ".glb")} for s in SCENES
              if not a.only or s["name"] in a.only]
    for s in scenes:
        if not os.path.isfile(s["file"]):
            raise Fail(f"{s['file']} is not there; choose scenes with --only, or another folder with --scenes")
    check_mitsuba()

    of = machine(a)
    head = (f"{of['cpu']}, {of['cores']} cores; {of['twinlight']}, Mitsuba {of['mitsuba']} ({of['variant']}, "
            f"{of['mitsuba_threads']} threads); {a.repeats} turns; compared at {a.side} x {a.side}\n")
    print(head, flush=True)
    with tempfile.TemporaryDirectory() as tmp:
        if a.output:
            os.makedirs(a.output, exist_ok=True)
        results, text = [], head
        for scene in scenes:
            results.append(measure(a, scene, a.output or tmp))
            print(table(results[-1]), flush=True)
            text += "\n" + table(results[-1])
            if a.output:  # after every scene, so that an interrupted run leaves the finished ones
                settings = {k: getattr(a, k) for k in ("side", "samples", "repeats", "longest", "quick")}
                with open(os.path.join(a.output, "equal_error.json"), "w") as f:
                    json.dump({"machine": of, "settings": settings, "scenes": results}, f, indent=1)
                with open(os.path.join(a.output, "equal_error.md"), "w") as f:
                    f.write(text)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Fail as e:
        print(f"equal_error: {e}", file=sys.stderr)
        sys.exit(2)
    except (OSError, RuntimeError) as e:
        print(f"equal_error: {' '.join(str(e).split())}", file=sys.stderr)
        sys.exit(1)
