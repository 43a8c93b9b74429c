#!/usr/bin/env python3
"""Writes the meshes that the scenes beside this file use.

usage: make_meshes.py            (needs nothing but Python; writes into meshes/)

The Cornell box is the measured one of Cornell's Program of Computer Graphics: vertices in millimetres, here in metres.
"""
import os
import random
import struct

HERE = os.path.dirname(os.path.abspath(__file__))

CORNELL = {
    "floor": [[(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]],
    "ceiling": [[(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]],
    "back": [[(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]],
    "green": [[(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]],
    "red": [[(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]],
    # The published light lies in the ceiling's plane; half a millimetre below it no ray can take the one for the other.
    "light": [[(343, 548.3, 227), (343, 548.3, 332), (213, 548.3, 332), (213, 548.3, 227)]],
    "short-block": [
        [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)],
        [(290, 0, 114), (290, 165, 114), (240, 165, 272), (240, 0, 272)],
        [(130, 0, 65), (130, 165, 65), (290, 165, 114), (290, 0, 114)],
        [(82, 0, 225), (82, 165, 225), (130, 165, 65), (130, 0, 65)],
        [(240, 0, 272), (240, 165, 272), (82, 165, 225), (82, 0, 225)],
    ],
    "tall-block": [
        [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)],
        [(423, 0, 247), (423, 330, 247), (472, 330, 406), (472, 0, 406)],
        [(472, 0, 406), (472, 330, 406), (314, 330, 456), (314, 0, 456)],
        [(314, 0, 456), (314, 330, 456), (265, 330, 296), (265, 0, 296)],
        [(265, 0, 296), (265, 330, 296), (423, 330, 247), (423, 0, 247)],
    ],
}


def write_obj(name, quads):
    with open(os.path.join(HERE, "meshes", name + ".obj"), "w") as f:
        f.write("# %s of the Cornell box, metres\n" % name)
        for quad in quads:
            for p in quad:
                f.write("v %g %g %g\n" % tuple(x / 1000 for x in p))
        for i in range(len(quads)):
            f.write("f %d %d %d %d\n" % tuple(4 * i + k + 1 for k in range(4)))


def write_ply(name, vertices, triangles):
    with open(os.path.join(HERE, "meshes", name + ".ply"), "wb") as f:
        f.write(("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face %d\nproperty list uchar uint vertex_indices\nend_header\n" % (len(vertices), len(triangles))).encode())
        for v in vertices:
            f.write(struct.pack("<3f", *v))
        for t in triangles:
            f.write(struct.pack("<B3I", 3, *t))


def lamps(seed, count):
    """Small triangles that face down, scattered under a ceiling of 10 m x 10 m."""
    rng = random.Random(seed)
    vertices, triangles = [], []
    for _ in range(count):
        x, z, y, r = rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(2.6, 2.9), rng.uniform(0.004, 0.012)
        n = len(vertices)
        vertices += [(x - r, y, z - r), (x + r, y, z - r), (x, y, z + r)]
        triangles.append((n, n + 1, n + 2))
    return vertices, triangles


def main():
    os.makedirs(os.path.join(HERE, "meshes"), exist_ok=True)
    for name, quads in CORNELL.items():
        write_obj("cornell-" + name, quads)
    for i in range(5):
        write_ply("lamps-%d" % i, *lamps(i, 2000))


if __name__ == "__main__":
    main()
