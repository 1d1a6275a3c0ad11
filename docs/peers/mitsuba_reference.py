#!/usr/bin/env python3
"""Reference pictures from Mitsuba 3 under Twinlight's radiometric conventions.

    mitsuba_reference.py render SCENE.glb [options] -o OUT.exr
    mitsuba_reference.py render --view NAME --views views.json [options] -o OUT.exr
    mitsuba_reference.py references --views views.json -o DIR
    mitsuba_reference.py compare A.exr B.exr [--mask M.exr] [--png DIFF.png]
    mitsuba_reference.py selftest

The .glb is read here with numpy, not by a loader of Mitsuba's, so that every convention is
decided in this file: see `load_glb` (geometry, materials) and `build_scene` (their translation).
Needs mitsuba, numpy and pillow. See README.md.
"""

import argparse
import io
import json
import math
import os
import re
import struct
import sys
import tempfile
import time

import numpy as np

# --------------------------------------------------------------------------------------------
# glTF
# --------------------------------------------------------------------------------------------

COMPONENT = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Fail(Exception):
    """A request or a file this script cannot serve; the text says why."""


def srgb_to_linear(c):
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(c):
    c = np.clip(c, 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.power(c, 1 / 2.4) - 0.055)


class Glb:
    """A binary glTF 2.0 file: its JSON, its buffer, and readers for accessors and images."""

    def __init__(self, path):
        with open(path, "rb") as f:
            data = f.read()
        magic, version, _ = struct.unpack_from("<4sII", data)
        if magic != b"glTF" or version != 2:
            raise Fail(f"{path}: not a binary glTF 2.0 file")
        self.json, self.bin, at = None, b"", 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            body = data[at + 8:at + 8 + size]
            if kind == b"JSON":
                self.json = json.loads(body)
            elif kind == b"BIN\0":
                self.bin = body
            at += 8 + size
        if self.json is None:
            raise Fail(f"{path}: no JSON chunk")
        if self.json.get("extensionsRequired"):
            raise Fail(f"{path}: required extensions {self.json['extensionsRequired']} are not read here")

    def view(self, i):
        v = self.json["bufferViews"][i]
        o = v.get("byteOffset", 0)
        return self.bin[o:o + v["byteLength"]], v.get("byteStride")

    def accessor(self, i):
        a = self.json["accessors"][i]
        if "sparse" in a:
            raise Fail("sparse accessors are not read here")
        dt, w = np.dtype(COMPONENT[a["componentType"]]).newbyteorder("<"), WIDTH[a["type"]]
        if "bufferView" not in a:
            return np.zeros((a["count"], w), dt)
        raw, stride = self.view(a["bufferView"])
        out = np.ndarray((a["count"], w), dt, raw, a.get("byteOffset", 0), (stride or dt.itemsize * w, dt.itemsize))
        if a.get("normalized"):
            top = float(np.iinfo(dt).max)
            out = np.maximum(out.astype(np.float32) / np.float32(top), -1)
        return out

    def image(self, texture):
        """The 8-bit RGBA texels of a texture, row 0 on top."""
        from PIL import Image
        t = self.json["textures"][texture]
        image = self.json["images"][t["source"]]
        raw, _ = self.view(image["bufferView"])
        s = self.json["samplers"][t["sampler"]] if "sampler" in t else {}
        if s.get("wrapS", 10497) != 10497 or s.get("wrapT", 10497) != 10497:
            raise Fail("only repeat wrap is read here")
        return np.asarray(Image.open(io.BytesIO(raw)).convert("RGBA"))


def node_matrix(n):
    if "matrix" in n:
        return np.array(n["matrix"], float).reshape(4, 4).T
    x, y, z, w = n.get("rotation", [0, 0, 0, 1])
    r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    m = np.eye(4)
    m[:3, :3] = r * np.array(n.get("scale", [1, 1, 1]), float)
    m[:3, 3] = n.get("translation", [0, 0, 0])
    return m


def load_glb(path, textures=True):
    """Primitives in world space, each a dict: positions, normals, uv (or None), triangles, material.

    A material: name, albedo (3 numbers or an HxWx3 linear picture), opacity (None or an HxW picture of
    alpha), cutoff, emission (3 numbers, radiance on the front face), emission_picture (or None)."""
    g = Glb(path)
    j = g.json
    materials = []
    for m in j.get("materials", []) + [{}]:  # the last one is the default material
        p = m.get("pbrMetallicRoughness", {})
        factor = np.array(p.get("baseColorFactor", [1, 1, 1, 1]), float)
        out = {"name": m.get("name", ""), "albedo": factor[:3], "opacity": None, "cutoff": m.get("alphaCutoff", 0.5),
               "texcoord": 0, "emission_picture": None}
        cut = m.get("alphaMode") == "MASK"
        if m.get("alphaMode") == "BLEND":
            print(f"note: material {out['name']}: BLEND is rendered opaque", file=sys.stderr)
        if "baseColorTexture" in p and textures:
            if p["baseColorTexture"].get("texCoord", 0) or p["baseColorTexture"].get("extensions"):
                raise Fail(f"material {out['name']}: only TEXCOORD_0 without a texture transform is read here")
            rgba = g.image(p["baseColorTexture"]["index"]).astype(np.float64) / 255
            out["albedo"] = (srgb_to_linear(rgba[..., :3]) * factor[:3]).astype(np.float32)
            if cut:
                out["opacity"] = rgba[..., 3] * factor[3]
        elif cut and factor[3] < out["cutoff"]:
            out["opacity"] = np.zeros((1, 1))
        strength = m.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        out["emission"] = np.array(m.get("emissiveFactor", [0, 0, 0]), float) * strength
        if "emissiveTexture" in m and textures and out["emission"].any():
            rgb = g.image(m["emissiveTexture"]["index"])[..., :3].astype(np.float64) / 255
            out["emission_picture"] = (srgb_to_linear(rgb) * out["emission"]).astype(np.float32)
        materials.append(out)

    prims = []

    def visit(index, parent):
        n = j["nodes"][index]
        m = parent @ node_matrix(n)
        if "mesh" in n:
            for p in j["meshes"][n["mesh"]]["primitives"]:
                if p.get("mode", 4) != 4:
                    raise Fail("only triangle lists are read here")
                a = p["attributes"]
                pos = g.accessor(a["POSITION"]).astype(np.float64)
                tri = (g.accessor(p["indices"]).reshape(-1, 3) if "indices" in p
                       else np.arange(len(pos)).reshape(-1, 3)).astype(np.uint32)
                flip = np.linalg.det(m[:3, :3]) < 0
                tri = tri[:, [0, 2, 1]] if flip else tri
                nor = None
                if "NORMAL" in a:
                    nor = g.accessor(a["NORMAL"]).astype(np.float64) @ np.linalg.inv(m[:3, :3])
                    nor /= np.maximum(np.linalg.norm(nor, axis=1, keepdims=True), 1e-30)
                uv = g.accessor(a["TEXCOORD_0"]).astype(np.float32) if "TEXCOORD_0" in a else None
                pos = pos @ m[:3, :3].T + m[:3, 3]
                prims.append({"positions": pos.astype(np.float32), "uv": uv, "triangles": tri,
                              "normals": None if nor is None else nor.astype(np.float32),
                              "material": materials[p.get("material", -1)]})
        for c in n.get("children", []):
            visit(c, m)

    scene = j["scenes"][j.get("scene", 0)] if j.get("scenes") else {"nodes": []}
    for i in scene.get("nodes", []):
        visit(i, np.eye(4))
    if not prims:
        raise Fail(f"{path}: no triangles in the default scene")
    return prims


# --------------------------------------------------------------------------------------------
# The translation to Mitsuba
# --------------------------------------------------------------------------------------------

def mitsuba(variant="auto"):
    """Import Mitsuba with the first variant that works here."""
    import mitsuba as mi
    if mi.variant():
        return mi
    if variant != "auto":
        mi.set_variant(variant)
        return mi
    try:
        mi.set_variant("llvm_ad_rgb")
        import drjit as dr
        dr.eval(mi.Float([1, 2]) + 1)  # fails here where there is no LLVM library
    except Exception as e:
        print(f"note: llvm_ad_rgb does not work here ({str(e).splitlines()[0]}); using scalar_rgb", file=sys.stderr)
        mi.set_variant("scalar_rgb")
    return mi


def upsampled_cutout(alpha, cutoff, k):
    """alpha >= cutoff after bilinear filtering with repeat wrap, as a 0/1 picture of k x the size.

    Mitsuba's mask filters its opacity texture and takes the result as a fraction of light that
    passes. A cut-out compares the filtered value instead, so that is done here, on a finer grid, and
    the finer picture is looked up unfiltered: an outline is right to 1/(2k) of a texel."""
    h, w = alpha.shape

    def axis(n):
        x = (np.arange(n * k) + 0.5) / k - 0.5
        i = np.floor(x).astype(int)
        return i % n, (i + 1) % n, x - i

    y0, y1, fy = axis(h)
    x0, x1, fx = axis(w)
    rows = alpha[:, x0] * (1 - fx) + alpha[:, x1] * fx
    return (rows[y0] * (1 - fy)[:, None] + rows[y1] * fy[:, None] >= cutoff).astype(np.float32)


def texture(mi, picture, filter_type="bilinear"):
    if picture.ndim == 2:
        picture = picture[..., None]
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(picture, dtype=np.float32)), "raw": True,
            "filter_type": filter_type, "wrap_mode": "repeat"}


def rgb(v):
    return {"type": "rgb", "value": [float(x) for x in v]}


def build_scene(prims, view, size, *, emissive=False, albedo=None, cutout_scale=8, variant="auto",
                surroundings=None):
    """A Mitsuba scene. `view`: eye, target, up, fov, lights (a list of dicts), sky (or None); `surroundings`: an emitter."""
    mi = mitsuba(variant)
    T = mi.ScalarTransform4f
    scene = {"type": "scene"}
    masked = False
    with tempfile.TemporaryDirectory() as tmp:
        for i, p in enumerate(prims):
            m, uv = p["material"], p["uv"]
            mesh = mi.Mesh(f"m{i}", len(p["positions"]), len(p["triangles"]),
                           has_vertex_normals=p["normals"] is not None, has_vertex_texcoords=uv is not None)
            params = mi.traverse(mesh)
            params["vertex_positions"] = p["positions"].ravel()
            params["faces"] = p["triangles"].ravel()
            if p["normals"] is not None:
                params["vertex_normals"] = p["normals"].ravel()
            if uv is not None:
                params["vertex_texcoords"] = uv.ravel()
            params.update()
            name = os.path.join(tmp, f"{i}.ply")
            mesh.write_ply(name)  # by way of a file: the one way to add an emitter that every version has
            a = np.asarray(m["albedo"])
            if albedo is not None:
                a = np.full(3, float(albedo))
            bsdf = {"type": "twosided", "bsdf": {"type": "diffuse",
                                                 "reflectance": rgb(a) if a.ndim == 1 else texture(mi, a)}}
            if m["opacity"] is not None:
                cut = m["opacity"] if m["opacity"].shape == (1, 1) else \
                    upsampled_cutout(m["opacity"], m["cutoff"], cutout_scale)
                bsdf = {"type": "mask", "opacity": texture(mi, cut, "nearest"), "bsdf": bsdf}
                masked = True
            shape = {"type": "ply", "filename": name, "bsdf": bsdf, "face_normals": p["normals"] is None}
            if emissive and m["emission"].any():
                e = m["emission_picture"]
                shape["emitter"] = {"type": "area", "radiance": rgb(m["emission"]) if e is None else texture(mi, e)}
            scene[f"shape{i}"] = shape
        for i, l in enumerate(view["lights"]):
            if l["kind"] == "point":
                d = {"type": "point", "position": [float(x) for x in l["position"]], "intensity": rgb(l["intensity"])}
            elif l["kind"] == "spot":
                o, way = np.array(l["position"], float), np.array(l["direction"], float)
                way /= np.linalg.norm(way)
                up = [1, 0, 0] if abs(way[0]) < 0.7 else [0, 1, 0]
                outer, inner = (list(l["cone"]) * 2)[:2]
                d = {"type": "spot", "to_world": T().look_at(origin=list(o), target=list(o + way), up=up),
                     "intensity": rgb(l["intensity"]), "cutoff_angle": float(outer), "beam_width": float(inner)}
            elif l["kind"] == "sun":
                d = {"type": "directional", "direction": [float(x) for x in l["direction"]],
                     "irradiance": rgb(l["intensity"])}
            else:
                raise Fail(f"no light of kind {l['kind']}")
            scene[f"light{i}"] = d
        if view.get("sky") is not None:
            scene["sky"] = {"type": "constant", "radiance": rgb(view["sky"])}
        if surroundings is not None:
            scene["surroundings"] = surroundings
        scene["sensor"] = {
            "type": "perspective", "fov": float(view["fov"]), "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e5,
            "to_world": T().look_at(origin=[float(x) for x in view["eye"]], target=[float(x) for x in view["target"]],
                                    up=[float(x) for x in view["up"]]),
            "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"}}
        return mi.load_dict(scene), masked


def integrator(mi, bounces, masked):
    """bounces None: all of them. A path integrator's shadow rays stop at a mask, those of volpath go through
    its holes, and a hole is no scattering event there; without masks the two do the same."""
    depth = -1 if bounces is None else bounces + 2
    return mi.load_dict({"type": "volpath" if masked else "path", "max_depth": depth,
                         "rr_depth": 8 if bounces is None else 100000})


def integrate(scene, masked, depths, *, samples, passes, seed, quiet=True):
    """One float64 array passes x h x w x 3 for each entry of `depths`.

    A pass renders every depth with the same seed. In llvm variants camera rays and light samples of a
    pass are then the same for all depths, so direct light cancels exactly in their difference (the
    indirect light). That is as unbiased as with separate seeds: the expectation of a difference needs
    no independence. In scalar variants the random numbers of a pixel also depend on its neighbours,
    and direct light cancels only on average. Passes have different seeds, so the spread between them
    is the noise, correlations within a pass included."""
    mi = mitsuba()
    out = [[] for _ in depths]
    spp = max(1, -(-samples // passes))
    its = [integrator(mi, d, masked) for d in depths]
    for p in range(passes):
        for o, it in zip(out, its):
            img = mi.render(scene, integrator=it, spp=spp, seed=seed * 65536 + p)
            o.append(np.array(img, dtype=np.float64)[..., :3])
        if not quiet:
            print(f"\rpass {p + 1}/{passes}", end="" if p + 1 < passes else "\n", file=sys.stderr, flush=True)
    return [np.stack(o) for o in out], spp * passes


def statistics(stack):
    """The mean picture, the standard error of every pixel, and mean and standard error of the whole."""
    n = len(stack)
    mean = stack.mean(0)
    se = stack.std(0, ddof=1) / math.sqrt(n) if n > 1 else np.full_like(mean, np.nan)
    m = stack.mean((1, 2))
    whole = m.std(0, ddof=1) / math.sqrt(n) if n > 1 else np.full(3, np.nan)
    grey = stack.mean((1, 2, 3))
    return mean, se, {"mean": m.mean(0).tolist(), "mean_se": whole.tolist(), "grey": float(grey.mean()),
                      "grey_se": float(grey.std(ddof=1) / math.sqrt(n)) if n > 1 else None,
                      "median_pixel_relative_se": float(np.median((se / np.maximum(mean, 1e-9))[mean > 0]))
                      if n > 1 and (mean > 0).any() else None}


# --------------------------------------------------------------------------------------------
# Pictures
# --------------------------------------------------------------------------------------------

def write_exr(path, a):
    mi = mitsuba()
    b = mi.Bitmap(np.ascontiguousarray(a, dtype=np.float32), pixel_format=mi.Bitmap.PixelFormat.RGB)
    b.write(path)


def read_exr(path):
    mi = mitsuba()
    b = mi.Bitmap(path)
    b = b.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(b, dtype=np.float64)


def write_png(path, a, exposure=1.0):
    from PIL import Image
    Image.fromarray((linear_to_srgb(np.nan_to_num(a) * exposure) * 255 + 0.5).astype(np.uint8)).save(path)


def sidecar(path, what="json"):
    return os.path.splitext(path)[0] + "." + what


def save(path, stack, info, png=None, exposure=None):
    """OUT.exr, OUT.se.exr (standard error of each pixel), OUT.json (means, settings), perhaps a PNG."""
    mean, se, st = statistics(stack)
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    write_exr(path, mean)
    if len(stack) > 1:
        write_exr(sidecar(path, "se.exr"), se)
    info = {**info, **st}
    with open(sidecar(path), "w") as f:
        json.dump(info, f, indent=1)
    if png:
        lum = mean.mean(2)
        e = exposure or 0.9 / max(np.percentile(lum, 97), 1e-9)
        write_png(png, mean, e)
    return info


# --------------------------------------------------------------------------------------------
# compare
# --------------------------------------------------------------------------------------------

def known_error(path, shape):
    """(per-pixel standard error or None, standard error of channel means or None) left beside a picture."""
    se, mean_se = None, None
    if os.path.exists(sidecar(path, "se.exr")):
        se = read_exr(sidecar(path, "se.exr"))
        se = se if se.shape == shape else None
    if os.path.exists(sidecar(path)):
        with open(sidecar(path)) as f:
            v = json.load(f).get("mean_se")
        if v is not None and len(v) == 3 and all(x is not None and x == x for x in v):
            mean_se = np.array(v)
    return se, mean_se


def compare(a_path, b_path, mask=None, tiles=8, png=None, dark=0.01):
    a, b = read_exr(a_path), read_exr(b_path)
    if a.shape != b.shape:
        raise Fail(f"sizes differ: {a.shape[1]}x{a.shape[0]} and {b.shape[1]}x{b.shape[0]}")
    keep = np.ones(a.shape[:2], bool)
    if mask:
        if mask.lower().endswith(".exr"):
            m = read_exr(mask).max(2) > 0
        else:
            from PIL import Image
            m = np.asarray(Image.open(mask).convert("L")) > 127
        if m.shape != keep.shape:
            raise Fail("the mask has another size")
        keep &= m
    bad = ~(np.isfinite(a).all(2) & np.isfinite(b).all(2))
    out = {"a": a_path, "b": b_path, "pixels": int((keep & ~bad).sum()), "non_finite": int((keep & bad).sum())}
    keep &= ~bad
    if not keep.any():
        raise Fail("no pixel to compare")
    ea, ma = known_error(a_path, a.shape)
    eb, mb = known_error(b_path, b.shape)
    whole = keep.all()

    def mean_error(e, m, sel):
        """Standard error of channel means over the pixels `sel` (pixels are independent of each other)."""
        if whole and sel is keep and m is not None:
            return m
        return None if e is None else np.sqrt((e[sel] ** 2).sum(0)) / sel.sum()

    def ratio(sel):
        x, y = a[sel].mean(0), b[sel].mean(0)
        sx, sy = mean_error(ea, ma, sel), mean_error(eb, mb, sel)
        with np.errstate(divide="ignore", invalid="ignore"):
            r = x / y
            known = [s / v for s, v in ((sx, x), (sy, y)) if s is not None]
            s = np.abs(r) * np.sqrt(sum(k ** 2 for k in known)) if known else None
        return x, y, r, s, sx, sy

    def lst(v):
        return None if v is None else [float(q) for q in v]

    x, y, r, s, sx, sy = ratio(keep)
    out |= {"mean_a": lst(x), "mean_a_se": lst(sx), "mean_b": lst(y), "mean_b_se": lst(sy),
            "ratio": lst(r), "ratio_se": lst(s)}
    gx, gy = x.mean(), y.mean()
    out["grey_ratio"] = float(gx / gy) if gy else float("nan")
    d = (a - b)[keep]
    out["relative_rmse"] = float(np.sqrt((d ** 2).mean()) / max(gy, 1e-30))
    noise = [e[keep] for e in (ea, eb) if e is not None]
    out["relative_rmse_of_known_noise"] = \
        float(np.sqrt(sum((e ** 2).mean() for e in noise)) / max(gy, 1e-30)) if noise else None
    h, w = keep.shape
    grid, worst = [], None
    for ty in range(tiles):
        row = []
        for tx in range(tiles):
            sel = np.zeros_like(keep)
            sl = (slice(ty * h // tiles, (ty + 1) * h // tiles), slice(tx * w // tiles, (tx + 1) * w // tiles))
            sel[sl] = keep[sl]
            if not sel.any() or b[sel].mean() <= dark * gy:
                row.append(None)
                continue
            q = a[sel].mean() / b[sel].mean()
            row.append(float(q))
            if worst is None or abs(math.log(max(q, 1e-9))) > abs(math.log(max(worst["ratio"], 1e-9))):
                se2 = ratio(sel)[3]
                worst = {"column": tx, "row": ty, "ratio": float(q), "mean_a": float(a[sel].mean()),
                         "mean_b": float(b[sel].mean()),
                         "ratio_se": None if se2 is None else float(np.sqrt((se2 ** 2).sum()) / 3)}
        grid.append(row)
    out |= {"tiles": grid, "worst_tile": worst}
    if png:
        from PIL import Image
        q = (a - b).mean(2) / max(gy, 1e-30)
        q = np.clip(np.where(keep, q, 0) / 0.25, -1, 1)
        pic = np.stack([1 - np.maximum(-q, 0), 1 - np.abs(q), 1 - np.maximum(q, 0)], 2)  # red: A brighter; blue: B
        Image.fromarray((pic * 255 + 0.5).astype(np.uint8)).save(png)
    return out


def print_comparison(c):
    def row(v, s=None):
        return "  ".join(f"{q:10.6f}" + (f" ± {e:.6f}" if s else "") for q, e in zip(v, s or v))
    print(f"A {c['a']}\nB {c['b']}\npixels compared {c['pixels']}, not finite {c['non_finite']}")
    print("              R           G           B")
    print("mean A   ", row(c["mean_a"], c["mean_a_se"]))
    print("mean B   ", row(c["mean_b"], c["mean_b_se"]))
    print("A/B      ", row(c["ratio"], c["ratio_se"]))
    n = c["relative_rmse_of_known_noise"]
    print(f"A/B, grey {c['grey_ratio']:.6f}")
    print(f"RMSE / mean B {c['relative_rmse']:.5f}" + (f", known noise alone gives {n:.5f}" if n else ""))
    print("A/B by tile (- is too dark to say):")
    for r in c["tiles"]:
        print("  " + " ".join("     -" if v is None else f"{v:6.3f}" for v in r))
    w = c["worst_tile"]
    if w:
        se = f" ± {w['ratio_se']:.4f}" if w["ratio_se"] else ""
        print(f"worst tile: column {w['column']}, row {w['row']}: {w['ratio']:.4f}{se}")


# --------------------------------------------------------------------------------------------
# Views and options
# --------------------------------------------------------------------------------------------

def numbers(text, n, what):
    try:
        v = [float(x) for x in text.split(",")]
    except ValueError:
        v = []
    if len(v) != n:
        raise Fail(f"{what} wants {n} numbers with commas between, not '{text}'")
    return v


def parse_lights(args):
    out = []
    for t in args.point or []:
        p = t.split(":")
        if len(p) != 2:
            raise Fail("--point x,y,z:R,G,B")
        out.append({"kind": "point", "position": numbers(p[0], 3, "--point"), "intensity": numbers(p[1], 3, "--point")})
    for t in args.spot or []:
        p = t.split(":")
        if len(p) != 4:
            raise Fail("--spot x,y,z:dx,dy,dz:R,G,B:OUTER[,INNER]")
        c = [float(q) for q in p[3].split(",")]
        out.append({"kind": "spot", "position": numbers(p[0], 3, "--spot"), "direction": numbers(p[1], 3, "--spot"),
                    "intensity": numbers(p[2], 3, "--spot"), "cone": [c[0], c[1] if len(c) > 1 else c[0]]})
    for t in args.sun or []:
        p = t.split(":")
        if len(p) != 2:
            raise Fail("--sun dx,dy,dz:R,G,B")
        out.append({"kind": "sun", "direction": numbers(p[0], 3, "--sun"), "intensity": numbers(p[1], 3, "--sun")})
    return out


def read_views(path):
    with open(path) as f:
        return {v["name"]: v for v in json.load(f)["views"]}


def view_of(v):
    lights = v.get("lights") or ([v["light"]] if v.get("light") else [])
    return {"eye": v["eye"], "target": v["target"], "up": v["up"], "fov": v["fov"], "lights": lights, "sky": v.get("sky")}


def parse_size(t):
    m = re.fullmatch(r"(\d+)x(\d+)", t)
    if not m:
        raise Fail("--size WxH")
    return int(m[1]), int(m[2])


def check_passes(n):
    if n < 1:
        raise Fail("--passes must be at least 1")


def cmd_render(args):
    check_passes(args.passes)
    mi = mitsuba(args.variant)
    scene_path, view = args.scene, None
    if args.view:
        if not args.views:
            raise Fail("--view NAME wants --views FILE")
        vs = read_views(args.views)
        if args.view not in vs:
            raise Fail(f"no view '{args.view}'; there are {', '.join(vs)}")
        view = view_of(vs[args.view])
        scene_path = scene_path or os.path.join(os.path.dirname(args.views), vs[args.view]["scene"])
    if not scene_path:
        raise Fail("no scene: give a .glb or --view NAME --views FILE")
    view = view or {"eye": None, "target": None, "up": [0, 1, 0], "fov": 45.0, "lights": [], "sky": None}
    for k in ("eye", "target", "up"):
        if getattr(args, k):
            view[k] = numbers(getattr(args, k), 3, "--" + k)
    if args.fov:
        view["fov"] = args.fov
    if view["eye"] is None or view["target"] is None:
        raise Fail("no camera: give --eye and --target, or --view")
    lights = parse_lights(args)
    if lights:
        view["lights"] = lights
    if args.sky:
        view["sky"] = numbers(args.sky, 3, "--sky")
    bounces = None if args.bounces == "all" else int(args.bounces)
    start = time.time()
    prims = load_glb(scene_path)
    scene, masked = build_scene(prims, view, parse_size(args.size), emissive=args.emissive, albedo=args.albedo,
                                cutout_scale=args.cutout_scale, variant=args.variant)
    loaded = time.time()
    depths = {"all": [bounces], "direct": [0], "indirect": [bounces, 0]}[args.only]
    stacks, samples = integrate(scene, masked, depths, samples=args.samples, passes=args.passes, seed=args.seed,
                                quiet=args.quiet)
    stack = stacks[0] - stacks[1] if len(stacks) == 2 else stacks[0]
    info = {"scene": os.path.basename(scene_path), "view": view, "size": args.size, "bounces": args.bounces,
            "only": args.only, "samples": samples, "passes": args.passes, "seed": args.seed,
            "emissive": args.emissive, "albedo": args.albedo, "load_s": round(loaded - start, 2),
            "render_s": round(time.time() - loaded, 2), "mitsuba": mi.__version__, "variant": mi.variant()}
    info = save(args.output, stack, info, args.png, args.exposure)
    if args.json:
        print(json.dumps(info))
    else:
        print(f"{args.output}: mean {fmt(info['mean'], info['mean_se'])}, {samples} samples, "
              f"{info['render_s']} s ({mi.variant()})")


def fmt(m, s):
    return ", ".join(f"{a:.6g} ± {e:.2g} ({100 * e / a if a else 0:.2f} %)" for a, e in zip(m, s))


def cmd_references(args):
    """b<N>.exr for every view and every N asked, and the indirect part of each N > 0."""
    if args.passes < 2:
        raise Fail("references want --passes 2 or more, for their standard errors")
    mi = mitsuba(args.variant)
    vs = read_views(args.views)
    summary_path = os.path.join(args.output, "summary.json")
    summary = {}
    if os.path.exists(summary_path):
        with open(summary_path) as f:
            summary = json.load(f)
    os.makedirs(args.output, exist_ok=True)
    for name, v in vs.items():
        if args.only_views and name not in args.only_views.split(","):
            continue
        depths = sorted({0} | {int(b) for b in args.bounces.split(",")})
        if name.startswith("cornell-") and args.cornell_bounces:
            depths = sorted(set(depths) | {int(b) for b in args.cornell_bounces.split(",")})
        t = time.time()
        view = view_of(v)
        prims = load_glb(os.path.join(os.path.dirname(args.views), v["scene"]))
        scene, masked = build_scene(prims, view, parse_size(args.size), cutout_scale=args.cutout_scale)
        loaded = time.time()
        stacks, samples = integrate(scene, masked, depths, samples=args.samples, passes=args.passes, seed=args.seed,
                                    quiet=args.quiet)
        secs = time.time() - loaded
        for i, (d, stack) in enumerate(zip(depths, stacks)):
            for kind in ("all", "indirect") if d else ("all",):
                part = stack - stacks[0] if kind == "indirect" else stack
                key = f"{name}-b{d}" + ("-indirect" if kind == "indirect" else "")
                info = {"scene": v["scene"], "view": view, "size": args.size, "bounces": d, "only": kind,
                        "samples": samples, "passes": args.passes, "seed": args.seed, "mitsuba": mi.__version__,
                        "variant": mi.variant()}
                path = os.path.join(args.output, key + ".exr")
                info = save(path, part, info, sidecar(path, "png"))
                summary[key] = {k: info[k] for k in ("mean", "mean_se", "grey", "grey_se", "median_pixel_relative_se",
                                                     "samples", "passes", "seed", "size", "bounces", "only")}
                # time of all depths of the view together, in which they shared their passes
                summary[key] |= {"view_seconds": round(secs, 1), "load_seconds": round(loaded - t, 1)}
                print(f"{key}: {fmt(info['mean'], info['mean_se'])}", flush=True)
        with open(summary_path, "w") as f:
            json.dump(summary, f, indent=1)
        print(f"{name}: {secs:.1f} s for {samples} samples at depths {depths}", flush=True)


# --------------------------------------------------------------------------------------------
# Closed forms
# --------------------------------------------------------------------------------------------

def quad(p, normal, albedo=0.5, emission=(0, 0, 0), uv=None, opacity=None, cutoff=0.5):
    return {"positions": np.array(p, np.float32), "normals": np.tile(np.array(normal, np.float32), (4, 1)),
            "uv": None if uv is None else np.array(uv, np.float32),
            "triangles": np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
            "material": {"name": "", "albedo": np.full(3, albedo) if np.ndim(albedo) == 0 else np.asarray(albedo),
                         "opacity": opacity, "cutoff": cutoff, "emission": np.array(emission, float),
                         "emission_picture": None}}


def cube(h, albedo, emission, inward=True):
    out = []
    for axis in range(3):
        for sign in (-1, 1):
            n = np.zeros(3)
            n[axis] = sign
            u, v = np.roll([0, 1, 0], axis - 0), None
            u = np.eye(3)[(axis + 1) % 3]
            v = np.cross(n, u)
            c = n * h
            p = [c - u * h - v * h, c + u * h - v * h, c + u * h + v * h, c - u * h + v * h]  # seen from outside
            out.append(quad(p[::-1] if inward else p, -n if inward else n, albedo, emission))
    return out


def cmd_selftest(args):
    mi = mitsuba(args.variant)
    ok = True

    def check(what, got, want, tolerance):
        nonlocal ok
        got, want = np.asarray(got, float), np.asarray(want, float)
        err = float(np.max(np.abs(got - want) / np.maximum(np.abs(want), 1e-12)))
        good = err <= tolerance
        ok &= good
        print(f"{'ok  ' if good else 'FAIL'} {what}: {np.round(got, 6).tolist()} want {np.round(want, 6).tolist()} "
              f"(off by {100 * err:.4f} %, allowed {100 * tolerance:.4f} %)")

    def picture(prims, view, size=(32, 32), bounces=0, samples=64, passes=4, **kw):
        s, masked = build_scene(prims, {"up": [0, 1, 0], "fov": 40, "sky": None, "lights": [], **view}, size, **kw)
        (st,), _ = integrate(s, masked, [bounces], samples=samples, passes=passes, seed=1)
        return statistics(st)

    # 1. Furnace: every wall of a closed box emits e and reflects a: radiance e (1 + a + ... + a^(N+1)) everywhere.
    e, a = np.array([0.3, 0.2, 0.1]), 0.7
    for n in (0, 1, 4, None):
        m, _, st = picture(cube(1, a, e), {"eye": [0.1, 0.2, 0.3], "target": [1, 0.3, -0.5]}, bounces=n, samples=256,
                           emissive=True)
        want = e / (1 - a) if n is None else e * sum(a ** k for k in range(n + 2))
        check(f"furnace, bounces {'all' if n is None else n}", m.mean((0, 1)), want,
              4 * max(np.array(st["mean_se"]) / want) + 1e-4)

    # 2. Point light over a floor: radiance a/pi I cos/d^2 at the centre of every pixel (box filter: small tilt).
    h, I, alb = 1.5, np.array([2.0, 3.0, 4.0]), 0.6
    floor = quad([[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]], [0, 1, 0], alb)
    cam = {"eye": [0.4, 2, 0.1], "target": [0.4, 0, 0.0], "up": [0, 0, -1]}

    def rays(view, w, hh):
        f = np.subtract(view["target"], view["eye"]) / np.linalg.norm(np.subtract(view["target"], view["eye"]))
        r = np.cross(f, view.get("up", [0, 1, 0]))
        r /= np.linalg.norm(r)
        u = np.cross(r, f)
        t = math.tan(math.radians(view.get("fov", 40)) / 2)
        x, y = np.meshgrid((2 * (np.arange(w) + .5) / w - 1) * w / hh * t, (1 - 2 * (np.arange(hh) + .5) / hh) * t)
        d = x[..., None] * r + y[..., None] * u + f
        return np.array(view["eye"], float), d / np.linalg.norm(d, axis=-1, keepdims=True)

    def on_floor(view, w, hh):
        o, d = rays(view, w, hh)
        return o + d * (-o[1] / d[..., 1:2])

    w, hh = 48, 32
    m, _, _ = picture([floor], {**cam, "lights": [{"kind": "point", "position": [0.9, h, -0.3], "intensity": I}]},
                      (w, hh), samples=256)
    p = on_floor(cam, w, hh)
    to = np.array([0.9, h, -0.3]) - p
    d2 = (to ** 2).sum(-1)
    want = alb / math.pi * (h / d2 ** 1.5)[..., None] * I
    check("point light, picture mean", m.mean((0, 1)), want.mean((0, 1)), 1e-3)
    check("point light, worst pixel of 48x32", [np.max(m / want), np.min(m / want)], [1, 1], 5e-3)

    # 3. Spot: intensity linear in the angle between INNER and OUTER.
    L = {"kind": "spot", "position": [0.4, h, 0.0], "direction": [0.2, -1, 0.1], "cone": [30, 12], "intensity": I}
    m, _, _ = picture([floor], {**cam, "lights": [L]}, (w, hh), samples=1024)
    sub = 4  # box filter by hand: the profile has kinks
    view = {**cam}
    o, d = rays(view, w * sub, hh * sub)
    p = o + d * (-o[1] / d[..., 1:2])
    to = np.array(L["position"]) - p
    d2 = (to ** 2).sum(-1)
    ax = np.array(L["direction"]) / np.linalg.norm(L["direction"])
    ang = np.degrees(np.arccos(np.clip(-(to @ ax) / np.sqrt(d2), -1, 1)))
    fall = np.clip((30 - ang) / (30 - 12), 0, 1)
    want = (alb / math.pi * fall * h / d2 ** 1.5)[..., None] * I
    want = want.reshape(hh, sub, w, sub, 3).mean((1, 3))
    check("spot 30,12, picture mean", m.mean((0, 1)), want.mean((0, 1)), 2e-3)
    check("spot 30,12, largest difference / peak", [np.abs(m - want).max() / want.max() + 1], [1], 1e-2)
    L = {**L, "cone": [25, 25]}
    m, _, _ = picture([floor], {**cam, "lights": [L]}, (w, hh), samples=1024)
    want = ((ang < 25) * alb / math.pi * h / d2 ** 1.5)[..., None] * I
    check("spot 25,25, picture mean", m.mean((0, 1)), want.mean((0, 1)), 2e-2)
    check("spot 25,25 is finite", [np.isfinite(m).all()], [1], 0)

    # 4. Sun: irradiance facing it; both faces of a sheet.
    s = np.array([0.3, -1, 0.2])
    for flip in (False, True):
        f = dict(floor)
        if flip:
            f = {**floor, "triangles": floor["triangles"][:, ::-1].copy(), "normals": -floor["normals"]}
        m, _, _ = picture([f], {**cam, "lights": [{"kind": "sun", "direction": s, "intensity": I}]}, samples=16)
        check(f"sun, {'back' if flip else 'front'} face", m.mean((0, 1)), alb / math.pi * I / np.linalg.norm(s), 1e-4)

    # 5. Sky: an open floor gets pi times its radiance.
    m, _, st = picture([floor], {**cam, "sky": [1, 2, 3]}, samples=256)
    check("sky", m.mean((0, 1)), alb * np.array([1, 2, 3]), 4 * max(np.array(st["mean_se"]) / [.6, 1.2, 1.8]) + 1e-3)

    # 6. Textures: v = 0 on top, repeat, bilinear between texel centres; cut-outs are holes for camera and shadow.
    pic = np.zeros((4, 4, 3), np.float32)
    pic[0, 0], pic[1, 2], pic[3, 3] = [.9, 0, 0], [0, .8, 0], [0, 0, .7]
    wall = quad([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [0, 0, 1], pic, uv=[[0, 1], [1, 1], [1, 0], [0, 0]])
    front = {"eye": [0, 0, 2 / math.tan(math.radians(20)) / 2], "target": [0, 0, 0],
             "lights": [{"kind": "sun", "direction": [0, 0, -1], "intensity": [math.pi] * 3}]}
    m, _, _ = picture([wall], front, (64, 64), samples=256)
    x = (np.arange(64 * 4) + .5) / (64 * 4) * 4 - .5
    i, f = np.floor(x).astype(int), x - np.floor(x)
    t = pic[i % 4] * (1 - f)[:, None, None] + pic[(i + 1) % 4] * f[:, None, None]
    t = t[:, i % 4] * (1 - f)[None, :, None] + t[:, (i + 1) % 4] * f[None, :, None]
    t = t.reshape(64, 4, 64, 4, 3).mean((1, 3))
    check("texture, largest difference + 1", [np.abs(m - t).max() + 1], [1], 1e-2)
    alpha = np.zeros((4, 4))
    alpha[:, :2] = 1
    cut = quad([[-1, 1, 1], [1, 1, 1], [1, 1, -1], [-1, 1, -1]], [0, 1, 0], 0.5, uv=[[0, 1], [1, 1], [1, 0], [0, 0]],
               opacity=alpha)
    # seen from below the sheet, the sun casts its holes (u in (.5, 1), i.e. x > 0) on the floor
    low = {"eye": [0, 0.9, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 60,
           "lights": [{"kind": "sun", "direction": [0, -1, 0], "intensity": [math.pi] * 3}]}
    m, _, _ = picture([floor, cut], low, (32, 32), samples=64)
    check("cut-out shadow: lit share of a row", [m[16, :16].mean() + 1, m[16, 16:].mean()], [1, alb], 1e-3)
    high = {**low, "eye": [0, 3, 0], "fov": 36}
    m, _, _ = picture([floor, cut], high, (32, 32), samples=64)
    check("cut-out seen from above: sheet left, floor right", [m[16, 6, 0], m[16, 22, 0]], [0.5, alb], 1e-3)

    # 7. Camera rays against the contract's formula.
    v = {"eye": [1, 2, 3], "target": [-2, 1, 0.5], "up": [0.1, 1, 0], "fov": 50}
    s, _ = build_scene([floor], {**v, "lights": [], "sky": None}, (48, 32))
    o, d = rays(v, 48, 32)
    worst = 0
    for y in (0, 7, 31):
        for x in (0, 20, 47):
            ray, _ = s.sensors()[0].sample_ray(0, 0, mi.Point2f((x + .5) / 48, (y + .5) / 32), mi.Point2f(0.5))
            worst = max(worst, np.abs(np.array(ray.d).ravel() - d[y, x]).max())
    check("camera ray, largest difference + 1", [worst + 1], [1], 1e-5)
    print("all good" if ok else "FAILED")
    return 0 if ok else 1


# --------------------------------------------------------------------------------------------

def main(argv):
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sub = ap.add_subparsers(dest="command", required=True)
    r = sub.add_parser("render", help="one picture")
    r.add_argument("scene", nargs="?")
    r.add_argument("--views")
    r.add_argument("--view")
    for o in ("--eye", "--target", "--up", "--sky"):
        r.add_argument(o)
    r.add_argument("--fov", type=float)
    for o in ("--point", "--spot", "--sun"):
        r.add_argument(o, action="append")
    r.add_argument("--size", default="512x512")
    r.add_argument("--bounces", default="1")
    r.add_argument("--samples", type=int, default=256)
    r.add_argument("--passes", type=int, default=8, help="seeds the samples are spread over, for standard errors")
    r.add_argument("--seed", type=int, default=0)
    r.add_argument("--only", choices=["all", "direct", "indirect"], default="all")
    r.add_argument("--albedo", type=float)
    r.add_argument("--emissive", action="store_true")
    r.add_argument("--cutout-scale", type=int, default=8, help="finer grid of cut-outs, per texel")
    r.add_argument("--variant", default="auto")
    r.add_argument("--png", help="also a picture to look at")
    r.add_argument("--exposure", type=float)
    r.add_argument("--quiet", action="store_true")
    r.add_argument("--json", action="store_true")
    r.add_argument("-o", "--output", required=True)
    a = sub.add_parser("references", help="all views of a views.json")
    a.add_argument("--views", required=True)
    a.add_argument("--only-views")
    a.add_argument("--size", default="256x256")
    a.add_argument("--bounces", default="0,1")
    a.add_argument("--cornell-bounces", default="4", help="more depths for views named cornell-*")
    a.add_argument("--samples", type=int, default=256)
    a.add_argument("--passes", type=int, default=16)
    a.add_argument("--seed", type=int, default=0)
    a.add_argument("--cutout-scale", type=int, default=8)
    a.add_argument("--variant", default="auto")
    a.add_argument("--quiet", action="store_true")
    a.add_argument("-o", "--output", required=True)
    c = sub.add_parser("compare", help="two EXR pictures")
    c.add_argument("a")
    c.add_argument("b")
    c.add_argument("--mask", help="compare only where this EXR is above 0 or this PNG above one half")
    c.add_argument("--tiles", type=int, default=8)
    c.add_argument("--png", help="difference: red where A is brighter, blue where B is; full colour at 25 %% of mean B")
    c.add_argument("--json", action="store_true")
    s = sub.add_parser("selftest", help="closed forms")
    s.add_argument("--variant", default="auto")
    joined, i = [], 0  # '--eye -1,2,3' reads as two options to argparse; make it '--eye=-1,2,3'
    while i < len(argv):
        if argv[i].startswith("--") and i + 1 < len(argv) and re.match(r"-[\d.]", argv[i + 1]):
            joined.append(argv[i] + "=" + argv[i + 1])
            i += 2
        else:
            joined.append(argv[i])
            i += 1
    args = ap.parse_args(joined)
    try:
        if args.command == "render":
            cmd_render(args)
        elif args.command == "references":
            cmd_references(args)
        elif args.command == "compare":
            c = compare(args.a, args.b, args.mask, args.tiles, args.png)
            print(json.dumps(c)) if args.json else print_comparison(c)
        else:
            return cmd_selftest(args)
    except Fail as e:
        print(f"mitsuba_reference: {e}", file=sys.stderr)
        return 2
    except (OSError, RuntimeError) as e:
        print(f"mitsuba_reference: {' '.join(str(e).split())}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
