#!/usr/bin/env python3
"""Rays a second of Embree (through embreex) on a .glb, for comparison with Twinlight's own tracer.

    embree_rays.py --view NAME --views views.json [--size 512x512] [--repeats 15] [--robust] [--native]

Prints one JSON line for one process and one for all cores. Primary rays go through pixel centres
(nearest hit); shadow rays go from their hit points to the view's light (any hit). Alpha masks are
ignored: every triangle is solid. Only tracing is timed. Needs embreex and numpy, and
mitsuba_reference.py (its .glb reader; Mitsuba itself is not needed). See README.md.

embreex traces ray by ray. --native also runs the same Embree library from a small C loop (needs a
C compiler and Linux), ray by ray and in packets of 8 and 16, which is what Embree can do at best.
"""

import argparse
import ctypes
import json
import math
import multiprocessing
import os
import re
import statistics
import sys
import time

import numpy as np

from mitsuba_reference import Fail, load_glb, parse_size, read_views, view_of


def triangles_of(path):
    prims = load_glb(path, textures=False)
    return np.concatenate([p["positions"][p["triangles"]] for p in prims]).astype(np.float32)


def primary_rays(view, w, h):
    f = np.subtract(view["target"], view["eye"]).astype(float)
    f /= np.linalg.norm(f)
    r = np.cross(f, view["up"])
    r /= np.linalg.norm(r)
    u = np.cross(r, f)
    t = math.tan(math.radians(view["fov"]) / 2)
    x, y = np.meshgrid((2 * (np.arange(w) + .5) / w - 1) * (w / h) * t, (1 - 2 * (np.arange(h) + .5) / h) * t)
    d = (x[..., None] * r + y[..., None] * u + f).reshape(-1, 3)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return np.tile(np.array(view["eye"], np.float32), (w * h, 1)), np.ascontiguousarray(d, np.float32)


def shadow_rays(view, tri, origins, directions, hit, eps):
    """Origins, directions and lengths from the hit points to the first light, lifted off the surface by eps."""
    ok = hit["primID"] >= 0
    p = (origins[ok] + hit["tfar"][ok, None] * directions[ok]).astype(np.float64)
    t = tri[hit["primID"][ok]].astype(np.float64)
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)
    n *= np.where((n * directions[ok]).sum(1) > 0, -1, 1)[:, None]  # the viewer's side
    p += eps * n
    light = view["lights"][0]
    if light["kind"] == "sun":
        d = -np.array(light["direction"], float)
        d = np.tile(d / np.linalg.norm(d), (len(p), 1))
        far = np.full(len(p), 1e30)
    else:
        d = np.array(light["position"], float) - p
        far = np.linalg.norm(d, axis=1)
        d /= far[:, None]
        far *= 1 - 1e-5
    return tuple(np.ascontiguousarray(v, np.float32) for v in (p, d, far))


def embree_version():
    """Of the library that is loaded (Linux), or else of the package."""
    try:
        with open("/proc/self/maps") as f:
            path = next(l.split()[-1] for l in f if re.search(r"libembree\d", l))
        lib = ctypes.CDLL(path)
        lib.rtcNewDevice.restype = ctypes.c_void_p
        lib.rtcGetDeviceProperty.restype = ctypes.c_ssize_t
        lib.rtcGetDeviceProperty.argtypes = [ctypes.c_void_p, ctypes.c_int]
        lib.rtcReleaseDevice.argtypes = [ctypes.c_void_p]
        dev = lib.rtcNewDevice(None)
        v = lib.rtcGetDeviceProperty(dev, 0)  # RTC_DEVICE_PROPERTY_VERSION
        lib.rtcReleaseDevice(dev)
        return f"{v // 10000}.{v // 100 % 100}.{v % 100}"
    except Exception:
        from importlib.metadata import version
        return "embreex " + version("embreex")


def build(tri, robust):
    """(scene, mesh, seconds to hand the triangles over, seconds to build)."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh
    scene = rtcore_scene.EmbreeScene(robust=robust)
    t = time.perf_counter()
    mesh = TriangleMesh(scene, tri)
    handed = time.perf_counter()
    one = np.zeros((1, 3), np.float32)
    scene.run(one, one + 1)  # the first query builds
    return scene, mesh, handed - t, time.perf_counter() - handed


def trace(scene, job):
    o, d, far = job
    if isinstance(scene, Native):
        return scene.trace(o, d, far)[0]
    if far is None:
        return scene.run(o, d, query="INTERSECT")
    return scene.run(o, d, dists=far, query="OCCLUDED")


NATIVE = r"""
#include <stddef.h>
#include <string.h>
/* The few declarations of Embree 4 that are needed, by its public interface (RTC_MAX_INSTANCE_LEVEL_COUNT 1). */
typedef void *P;
P rtcNewDevice(const char *); P rtcNewScene(P); P rtcNewGeometry(P, int);
P rtcSetNewGeometryBuffer(P, int, unsigned, int, size_t, size_t);
void rtcCommitGeometry(P); unsigned rtcAttachGeometry(P, P); void rtcReleaseGeometry(P);
void rtcSetSceneFlags(P, int); void rtcSetSceneBuildQuality(P, int); void rtcCommitScene(P);
typedef struct { int flags; unsigned features; P context, filter, fn; float width; } Args;
void rtcIntersect1(P, P, Args *); void rtcOccluded1(P, P, Args *);
void rtcIntersect8(const int *, P, P, Args *); void rtcOccluded8(const int *, P, P, Args *);
void rtcIntersect16(const int *, P, P, Args *); void rtcOccluded16(const int *, P, P, Args *);

P make(const float *tri, size_t n, int robust, int quality) {
  P dev = rtcNewDevice(0), scene = rtcNewScene(dev), g = rtcNewGeometry(dev, 0);
  rtcSetSceneFlags(scene, robust ? 4 : 0);
  rtcSetSceneBuildQuality(scene, quality);
  float *v = rtcSetNewGeometryBuffer(g, 1, 0, 0x9003, 12, n * 3);
  unsigned *i = rtcSetNewGeometryBuffer(g, 0, 0, 0x5003, 12, n);
  memcpy(v, tri, n * 36);
  for (size_t k = 0; k < n * 3; k++) i[k] = (unsigned)k;
  rtcCommitGeometry(g); rtcAttachGeometry(scene, g); rtcReleaseGeometry(g); rtcCommitScene(scene);
  return scene;
}
/* far 0: nearest hit into t (distance) and id (triangle or -1); else any hit within far: id 1 or 0. */
#define PACKET(N)                                                                                          \
  for (size_t k = 0; k < n; k += N) {                                                                      \
    struct { float r[12][N]; float h[10][N]; } __attribute__((aligned(64))) q;                             \
    int valid[N] __attribute__((aligned(64)));                                                             \
    for (int l = 0; l < N; l++) {                                                                          \
      size_t m = k + l < n ? k + l : n - 1;                                                                \
      valid[l] = k + l < n ? -1 : 0;                                                                       \
      for (int c = 0; c < 3; c++) { q.r[c][l] = o[3 * m + c]; q.r[4 + c][l] = d[3 * m + c]; }              \
      q.r[3][l] = 0; q.r[7][l] = 0; q.r[8][l] = far ? far[m] : 1e37f;                                      \
      ((unsigned *)q.r[9])[l] = ~0u; ((unsigned *)q.r[10])[l] = 0; ((unsigned *)q.r[11])[l] = 0;           \
      ((unsigned *)q.h[6])[l] = ~0u; ((unsigned *)q.h[7])[l] = ~0u; ((unsigned *)q.h[8])[l] = ~0u;         \
    }                                                                                                      \
    if (far) rtcOccluded##N(valid, scene, &q, &a); else rtcIntersect##N(valid, scene, &q, &a);             \
    for (int l = 0; l < N && k + l < n; l++) {                                                             \
      if (far) id[k + l] = q.r[8][l] < 0;                                                                  \
      else { id[k + l] = ((unsigned *)q.h[6])[l] == ~0u ? -1                                               \
                         : (int)((unsigned *)q.h[5])[l]; t[k + l] = q.r[8][l]; }                           \
    }                                                                                                      \
  }
void trace(P scene, size_t n, const float *o, const float *d, const float *far, int *id, float *t, int width) {
  Args a = {width > 1 ? 1 << 16 : 0, ~0u, 0, 0, 0, 0};
  if (width == 16) { PACKET(16) } else if (width == 8) { PACKET(8) } else
    for (size_t k = 0; k < n; k++) {
      struct { float r[12]; float h[12]; } __attribute__((aligned(16))) q;
      for (int c = 0; c < 3; c++) { q.r[c] = o[3 * k + c]; q.r[4 + c] = d[3 * k + c]; }
      unsigned *u = (unsigned *)&q;
      q.r[3] = 0; q.r[7] = 0; q.r[8] = far ? far[k] : 1e37f;
      u[9] = ~0u; u[10] = 0; u[11] = 0; u[18] = ~0u; u[19] = ~0u; u[20] = ~0u;
      if (far) { rtcOccluded1(scene, &q, &a); id[k] = q.r[8] < 0; }
      else { rtcIntersect1(scene, &q, &a); id[k] = u[18] == ~0u ? -1 : (int)u[17]; t[k] = q.r[8]; }
    }
}
"""


class Native:
    """A scene traced by the C loop above. In an RTCHit of N rays the rows are Ng (3), u, v, primID, geomID, instID,
    instPrimID: primID is row 5, geomID row 6."""
    lib = None

    def __init__(self, tri, robust, quality):
        if Native.lib is None:
            self.compile()
        self.tri = np.ascontiguousarray(tri, np.float32)
        t = time.perf_counter()
        self.scene = Native.lib.make(self.tri.ctypes.data, len(tri), int(robust), quality)
        self.built = time.perf_counter() - t
        self.width = 1

    @staticmethod
    def compile():
        import embreex.rtcore_scene  # noqa: F401  (loads the library)
        import subprocess
        import tempfile
        with open("/proc/self/maps") as f:
            paths = {l.split()[-1] for l in f if re.search(r"lib(embree|tbb)", l)}
        embree = next(p for p in paths if "libembree" in p)
        ctypes.CDLL(embree, ctypes.RTLD_GLOBAL)
        with tempfile.TemporaryDirectory() as tmp:
            c, so = os.path.join(tmp, "loop.c"), os.path.join(tmp, "loop.so")
            with open(c, "w") as f:
                f.write(NATIVE)
            subprocess.run([os.environ.get("CC", "cc"), "-O3", "-march=native", "-shared", "-fPIC", c, "-o", so], check=True)
            Native.lib = ctypes.CDLL(so)
        v, z, i = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
        Native.lib.make.restype, Native.lib.make.argtypes = v, [v, z, i, i]
        Native.lib.trace.restype, Native.lib.trace.argtypes = None, [v, z, v, v, v, v, v, i]

    def trace(self, o, d, far):
        n = len(o)
        ids, t = np.empty(n, np.int32), np.empty(n, np.float32)
        Native.lib.trace(self.scene, n, o.ctypes.data, d.ctypes.data, None if far is None else far.ctypes.data,
                         ids.ctypes.data, t.ctypes.data, self.width)
        return ids, t


def tile_order(w, h):
    """Pixels by 4x4 tiles, these by blocks of 32x32: neighbours are traced together, as a renderer would."""
    y, x = np.divmod(np.arange(w * h), w)
    return np.lexsort((x % 4, y % 4, x % 32 // 4, y % 32 // 4, x // 32, y // 32))


def split(job, n, block=2048):
    """n shares of about equal cost: blocks of rays dealt in turn, each share contiguous in memory."""
    idx = np.arange(len(job[0])) // block % n
    return [tuple(None if v is None else np.ascontiguousarray(v[idx == i]) for v in job) for i in range(n)]


def worker(scene, shares, repeats, warm, barrier, out):
    """Trace this process's share of each job `repeats` times and report when each began and ended."""
    rows = []
    for job in shares:
        for k in range(warm + repeats):
            barrier.wait()
            t0, c0 = time.monotonic(), time.process_time()
            trace(scene, job)
            t1, c1 = time.monotonic(), time.process_time()
            if k >= warm:
                rows.append((t0, t1, c1 - c0))
    out.put(rows)


def measure(scene, jobs, n, repeats, warm=3):
    """Seconds for each job, median over the repeats, on n forked processes that share the scene.

    A repeat lasts from the first process's start to the last one's end. Also CPU seconds over wall
    seconds of a process, which shows whether a query keeps to one core, and the CPU seconds of all
    processes together, which work on the machine beside this disturbs less than the wall clock."""
    ctx = multiprocessing.get_context("fork")
    barrier, out = ctx.Barrier(n), ctx.Queue()
    parts = [split(j, n) for j in jobs]
    ps = [ctx.Process(target=worker, args=(scene, [p[i] for p in parts], repeats, warm, barrier, out)) for i in range(n)]
    for p in ps:
        p.start()
    rows = [out.get() for _ in ps]
    for p in ps:
        p.join()
    res = []
    for j in range(len(jobs)):
        at = range(j * repeats, (j + 1) * repeats)
        walls = [max(r[k][1] for r in rows) - min(r[k][0] for r in rows) for k in at]
        busy = statistics.median(r[k][2] / max(r[k][1] - r[k][0], 1e-9) for r in rows for k in at)
        cpu = statistics.median(sum(r[k][2] for r in rows) for k in at)
        res.append((statistics.median(walls), min(walls), max(walls), busy, cpu))
    return res


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--views", required=True)
    ap.add_argument("--view", required=True)
    ap.add_argument("--size", default="512x512")
    ap.add_argument("--repeats", type=int, default=15)
    ap.add_argument("--processes", help="counts, with commas; default 1 and all cores")
    ap.add_argument("--robust", action="store_true", help="Embree's robust mode; its default is the faster one")
    ap.add_argument("--native", action="store_true", help="also from C, single rays and packets")
    a = ap.parse_args()
    vs = read_views(a.views)
    if a.view not in vs:
        raise Fail(f"no view '{a.view}'; there are {', '.join(vs)}")
    view, (w, h) = view_of(vs[a.view]), parse_size(a.size)
    tri = triangles_of(os.path.join(os.path.dirname(a.views), vs[a.view]["scene"]))
    cores = len(os.sched_getaffinity(0))
    counts = [int(x) for x in a.processes.split(",")] if a.processes else sorted({1, cores})

    scene, mesh, handed, built = build(tri, a.robust)
    order = tile_order(w, h)
    o, d = (np.ascontiguousarray(v[order]) for v in primary_rays(view, w, h))
    hit = scene.run(o, d, output=True)
    eps = 1e-4 * max(1.0, float(np.abs(tri).max()) / 10)
    so, sd, sf = shadow_rays(view, tri, o, d, hit, eps)
    probe = scene.run(so, sd, dists=sf.copy(), query="OCCLUDED")
    # what 'occluded' reads as has changed between versions; anything but the 'missed' value counts
    miss = scene.run(np.full((1, 3), 1e6, np.float32), np.array([[1, 0, 0]], np.float32), query="OCCLUDED")[0]
    # the cost of the interface alone: the same rays past a scene of one far-away triangle
    far_tri = np.array([[[1e6, 1e6, 1e6], [1e6 + 1, 1e6, 1e6], [1e6, 1e6 + 1, 1e6]]], np.float32)
    empty, empty_mesh, _, _ = build(far_tri, a.robust)
    jobs = [(o, d, None), (so, sd, sf)]
    common = {"view": a.view, "triangles": len(tri), "size": a.size, "mode": "robust" if a.robust else "fast",
              "primary_rays": len(o), "primary_hits": int((hit["primID"] >= 0).sum()), "shadow_rays": len(so),
              "shadow_occluded": int((probe != miss).sum()), "repeats": a.repeats, "embree": embree_version()}

    def report(s, empty_scene, n, **more):
        (p, p0, p1, pb, pc), (q, q0, q1, qb, qc) = measure(s, jobs, n, a.repeats)
        row = {"threads": n, "primary_rays_per_s": round(len(o) / p), "shadow_rays_per_s": round(len(so) / q), **more,
               "primary_range": [round(len(o) / p1), round(len(o) / p0)],
               "shadow_range": [round(len(so) / q1), round(len(so) / q0)], "cpu_over_wall": [round(pb, 3), round(qb, 3)],
               "rays_per_cpu_second": [round(len(o) / pc), round(len(so) / qc)]}
        if empty_scene is not None:
            (ep, *_), (es, *_) = measure(empty_scene, jobs, n, a.repeats)
            row["interface_rays_per_s"] = [round(len(o) / ep), round(len(so) / es)]
        print(json.dumps({**row, **common}), flush=True)

    for n in counts:
        report(scene, empty, n, tracer="embreex, single rays", hand_over_s=round(handed, 3), build_s=round(built, 3))
    if a.native:
        for quality, name in ((1, "medium build"), (2, "high build")):
            native = Native(tri, a.robust, quality)
            for width in (1, 8, 16):
                native.width = width
                ids, t = native.trace(o, d, None)
                same = float((ids == hit["primID"]).mean())  # shared edges may fall to either triangle
                occ = native.trace(so, sd, sf)[0]
                for n in counts:
                    report(native, None, n, tracer=f"C, {'single rays' if width == 1 else f'packets of {width}'}, {name}",
                           build_s=round(native.built, 3), same_triangle_as_embreex=round(same, 6),
                           occluded=int(occ.sum()))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Fail as e:
        print(f"embree_rays: {e}", file=sys.stderr)
        sys.exit(2)
    except OSError as e:
        print(f"embree_rays: {e}", file=sys.stderr)
        sys.exit(1)
