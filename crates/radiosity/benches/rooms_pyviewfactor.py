"""Rows of a room by pyviewfactor: python rooms_pyviewfactor.py ROOM.obj [strict]

ROOM.obj is that of `cargo bench -q -p etendue-radiosity --bench rooms -- obj ROOM`; wants pyviewfactor, numba and pyvista. Its matrix is F[i, j] = F(j -> i), so
columns sum to one, and nothing is in the way unless the mesh is given as an obstacle, which must be triangles.
"""

import sys
import time

import numpy as np
import pyvista as pv
import pyviewfactor as pvf

points, faces = [], []
for line in open(sys.argv[1]):
    word, *rest = line.split()
    if word == "v":
        points.append([float(x) for x in rest])
    else:
        faces.append([int(k) - 1 for k in rest])
flat = lambda of: np.hstack([[len(f), *f] for f in of])
mesh = pv.PolyData(np.array(points), flat(faces))
triangles = mesh.triangulate()

strict = "strict" in sys.argv[2:]
for name, of in [("as it is", mesh), ("in triangles", triangles)]:
    run = lambda: pvf.compute_viewfactor_matrix(
        of, obstacles=[triangles], strict_visibility=strict, strict_obstruction=strict
    )
    if not strict:
        run()  # compiles
    begun = time.process_time()
    f = np.asarray(run())
    cpu = time.process_time() - begun
    sums = f.sum(0)
    print(f"{name}, {of.n_cells} facets: {cpu:.1f} CPU s, sums {sums.min():.3f} to {sums.max():.3f}")
