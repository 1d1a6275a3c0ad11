#!/usr/bin/env python3
"""Rays a second of Twinlight and of Embree on one scene, in turns within one run.

    rays.py --views views.json --view sponza-nave [--twinlight target/release/twinlight] [--size 512x512] [--repeats 9]

Runs `twinlight render --technique direct --json` and Embree (embree_rays.py), fast and robust, one after
the other, --repeats times on all cores, and prints medians and the ratio Twinlight/Embree, taken within
each turn. See README.md for what is compared. Needs embreex and numpy, and a release build of Twinlight.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

from embree_rays import build, embree_version, measure, primary_rays, shadow_rays, tile_order
from mitsuba_reference import Fail, load_glb, parse_size, read_views, view_of


def corners(path):
    """Positions and vertex normals of every triangle's corners."""
    positions, normals = [], []
    for p in load_glb(path, textures=False):
        tri = p["positions"][p["triangles"]].astype(np.float32)
        positions.append(tri)
        flat = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])[:, None].repeat(3, 1)
        normals.append(flat if p["normals"] is None else p["normals"][p["triangles"]])
    return np.concatenate(positions), np.concatenate(normals)


def facing(hit, normals, directions, to_light):
    """Which hits Twinlight traces a shadow ray from: the shading normal, turned to the viewer, faces the light."""
    ok = hit["primID"] >= 0
    n, u, v = normals[hit["primID"][ok]], hit["u"][ok, None], hit["v"][ok, None]
    n = n[:, 0] * (1 - u - v) + n[:, 1] * u + n[:, 2] * v
    n *= np.where((n * directions[ok]).sum(1) > 0, -1, 1)[:, None]
    return (n * to_light).sum(1) > 0


def twinlight_command(a, scene, view, picture):
    def triple(v):
        return ",".join(str(x) for x in v)
    light = view["lights"][0]
    if light["kind"] == "sun":
        lit = ["--sun", f"{triple(light['direction'])}:{triple(light['intensity'])}"]
    elif light["kind"] == "point":
        lit = ["--point", f"{triple(light['position'])}:{triple(light['intensity'])}"]
    else:
        raise Fail("choose a view with a sun or a point light: outside a spot's cone no shadow rays are traced")
    return [a.twinlight, "render", scene, "--technique", "direct", "--no-scene-lights", *lit, "--size", a.size,
            "--eye", triple(view["eye"]), "--target", triple(view["target"]), "--up", triple(view["up"]),
            "--fov", str(view["fov"]), "--json", "-o", picture]


def twinlight_seconds(command):
    """Seconds of the passes that trace primary and shadow rays."""
    out = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    ms = {p["pass"]: p["ms"] for p in out["passes"]}
    return ms["trace_primary"] * 1e-3, ms["light_visibility"] * 1e-3


def row(name, seconds, counts, peer=None):
    """A line of the table: rays a second, and the ratio to Twinlight within each turn."""
    text = f"{name:<16}"
    for kind in (0, 1):
        rates = [counts[kind] / s[kind] / 1e6 for s in seconds]
        text += f"  {statistics.median(rates):7.3f} ({min(rates):7.3f} .. {max(rates):7.3f})"
    for kind in (0, 1) if peer else ():
        text += f"  {statistics.median(s[kind] / t[kind] for s, t in zip(seconds, peer)):6.3f}"
    print(text)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--views", required=True)
    ap.add_argument("--view", required=True)
    ap.add_argument("--twinlight", default=os.path.join(os.path.dirname(__file__), "../../target/release/twinlight"))
    ap.add_argument("--size", default="512x512")
    ap.add_argument("--repeats", type=int, default=9)
    a = ap.parse_args()
    views = read_views(a.views)
    if a.view not in views:
        raise Fail(f"no view '{a.view}'; there are {', '.join(views)}")
    view, (w, h) = view_of(views[a.view]), parse_size(a.size)
    scene = os.path.join(os.path.dirname(a.views), views[a.view]["scene"])
    tri, normals = corners(scene)
    cores = len(os.sched_getaffinity(0))

    embree = {"embree fast": build(tri, False), "embree robust": build(tri, True)}
    order = tile_order(w, h)
    o, d = (np.ascontiguousarray(v[order]) for v in primary_rays(view, w, h))
    hit = embree["embree fast"][0].run(o, d, output=True)
    eps = 1e-4 * max(1.0, float(np.abs(tri).max()) / 10)
    shadow = shadow_rays(view, tri, o, d, hit, eps)
    keep = facing(hit, normals, d, shadow[1])
    shadow = tuple(np.ascontiguousarray(v[keep]) for v in shadow)
    jobs, counts = [(o, d, None), shadow], (len(o), len(shadow[0]))

    seconds = {"twinlight": [], **{name: [] for name in embree}}
    with tempfile.TemporaryDirectory() as tmp:
        command = twinlight_command(a, scene, view, os.path.join(tmp, "picture.png"))
        for _ in range(a.repeats):
            seconds["twinlight"].append(twinlight_seconds(command))
            for name, (tracer, *_) in embree.items():
                seconds[name].append([m[0] for m in measure(tracer, jobs, cores, 1, warm=1)])

    print(f"{a.view}, {a.size}, {len(tri)} triangles, {counts[0]} primary and {counts[1]} shadow rays, "
          f"{cores} cores, {a.repeats} turns, Embree {embree_version()}")
    print("millions of rays a second: median (least .. most) of primary and of shadow rays; then Twinlight/Embree")
    row("twinlight", seconds["twinlight"], counts)
    for name in embree:
        row(name, seconds[name], counts, seconds["twinlight"])
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Fail as e:
        print(f"rays: {e}", file=sys.stderr)
        sys.exit(2)
    except (OSError, subprocess.CalledProcessError) as e:
        print(f"rays: {e}", file=sys.stderr)
        sys.exit(1)
