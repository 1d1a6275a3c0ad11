"""Which scene can Twinlight's soft-gi and Mitsuba both read? Balls on a floor under a soft sky, written as files.

The characters and the sky are those of Twinlight's built-in scene `spheres`; they stand closer together, and the balls
have four times as many triangles, by which their volume is 0.2 % below that of the proxies.
"""

import json
import os
import struct

import numpy as np

from mitsuba_reference import mitsuba, write_exr

# Centre and radius of one character's balls, facing +z, 1.8 m high.
PARTS = [(0, 1.6, 0, 0.2), (0, 1.15, 0, 0.3), (0, 0.8, 0, 0.26), (-0.4, 1.1, 0.06, 0.14), (0.4, 1.1, 0.06, 0.14),
         (-0.16, 0.45, 0, 0.17), (0.16, 0.45, 0, 0.17), (0, 0.14, 0.04, 0.14)]
FLOOR = (0.5, 0.5, 0.5)
COLOURS = [(0.7, 0.25, 0.2), (0.25, 0.6, 0.3), (0.25, 0.35, 0.75), (0.75, 0.65, 0.2), (0.7, 0.7, 0.7)]
SUBDIVISIONS = 4
ROWS = 128  # of the sky's map

SCENE = {
    "name": "soft-spheres", "eye": [0, 4, 4.6], "target": [0, 0.7, -0.5], "fov": 40, "only": "all", "samples": 64,
    "contestants": [("soft-gi", ["--preset", "paper-fast"]), ("soft-gi", ["--preset", "paper"]), ("soft-gi", []),
                    ("soft-gi", ["--shadow-reach", "30"]), ("reference", ["--samples", "16"])]}


def icosphere(subdivisions):
    """Unit vectors, and the triangles over them, counter-clockwise from outside."""
    g = (1 + 5 ** 0.5) / 2
    points = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
                       (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]) / np.hypot(1, g)
    corners = points[[[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
                      [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5],
                      [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]]
    for _ in range(subdivisions):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = (m / np.linalg.norm(m, axis=1, keepdims=True) for m in (a + b, b + c, c + a))
        corners = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    points, triangles = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return points, triangles.reshape(-1, 3)


def meshes():
    """Of the floor and each character: name, place, colour, spheres; about its place points, normals and triangles."""
    yield ("floor", (0, 0, 0), FLOOR, [], 150.0 * np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]),
           np.tile([0.0, 1, 0], (4, 1)), np.array([(0, 1, 2), (0, 2, 3)]))
    points, triangles = icosphere(SUBDIVISIONS)
    for i, colour in enumerate(COLOURS):
        yield (f"character {i}", (0.9 * i - 1.8, 0, -1.3 * (i % 2)), colour, PARTS,
               np.concatenate([np.array(part[:3]) + part[3] * points for part in PARTS]),
               np.tile(points, (len(PARTS), 1)),
               np.concatenate([triangles + k * len(points) for k in range(len(PARTS))]))


def write_glb(path):
    views, accessors, nodes, made, materials, data = [], [], [], [], [], b""

    def accessor(values, component, kind, **more):
        nonlocal data
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(values),
                          "type": kind, **more})
        data += values.tobytes()
        return len(accessors) - 1

    for name, place, colour, spheres, points, normals, triangles in meshes():
        p, n = points.astype("<f4"), normals.astype("<f4")
        attributes = {"POSITION": accessor(p, 5126, "VEC3", min=p.min(0).tolist(), max=p.max(0).tolist()),
                      "NORMAL": accessor(n, 5126, "VEC3")}
        made.append({"primitives": [{"attributes": attributes, "material": len(materials),
                                     "indices": accessor(triangles.astype("<u4").ravel(), 5125, "SCALAR")}]})
        materials.append({"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0}})
        extras = {"extras": {"spheres": spheres}} if spheres else {}
        nodes.append({"name": name, "mesh": len(nodes), "translation": place, **extras})
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "meshes": made, "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as f:
        f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON")
                + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def sky(polar):
    """Radiance at these angles from +y, row by row, in columns around from +z by -x, -z and +x: blue above, white near
    the horizon, darker below, with a broad warm lobe around (1, 1.2, 0.8)."""
    turn = 2 * np.pi * ((np.arange(2 * ROWS) + 0.5) / (2 * ROWS) - 0.5)
    polar, turn = np.meshgrid(polar, turn, indexing="ij")
    d = np.stack([np.sin(polar) * np.sin(turn), np.cos(polar), -np.sin(polar) * np.cos(turn)], -1)
    blue, white, sun = np.array([0.25, 0.45, 0.9]), np.array([0.8, 0.85, 0.9]), np.array([1, 1.2, 0.8])
    height, lobe = d[..., 1:2], np.maximum(d @ sun / np.linalg.norm(sun), 0)[..., None] ** 16
    return np.where(height < 0, white - height * (0.2 - white), white + height * (blue - white) + lobe * [6, 5.2, 4])


def write(folder):
    """Writes both files; returns the scene's entries about them."""
    file, environment = (os.path.join(folder, SCENE["name"] + end) for end in (".glb", "-sky.exr"))
    write_glb(file)
    write_exr(environment, sky(np.pi * (np.arange(ROWS) + 0.5) / ROWS))
    return {"file": file, "environment": environment}


def mitsuba_sky():
    """The same for Mitsuba, whose first row is the pole itself, not half a texel off, and whose middle is along +z."""
    mi = mitsuba()
    picture = sky(np.pi * np.arange(ROWS) / (ROWS - 1)).astype(np.float32)
    half_turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {"type": "envmap", "bitmap": mi.Bitmap(picture), "to_world": half_turn}
