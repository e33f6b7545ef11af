"""Ground for robots: 1,000 rays in each engine that is installed land where the files claim.

Runs again with FJELL_TEST_ROUNDS=full: ./dev test --long has installed the engines by then.
"""

import ctypes
import ctypes.util
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

import numpy as np

import fjell
from mesh_test import terrain
from measured import measure

BIN = os.environ["FJELL_BIN_DIR"]
SPACING = (0.5, 0.5)
RAYS = 1000


def library(name):
    found = ctypes.util.find_library(name)
    if not found:
        raise unittest.SkipTest(f"lib{name} is not installed")
    return ctypes.CDLL(found)


# In a process of its own, which ends without destructors: dartpy's crash when two detectors are collected.
DART = """
import os, sys
import dartpy, numpy as np
path, rays, out = sys.argv[1:]
if path.endswith('.urdf'):
    skeleton = dartpy.utils.DartLoader().parseSkeleton(path)
else:
    skeleton = dartpy.utils.SdfParser.readSkeleton(path)
world = dartpy.simulation.World()
world.addSkeleton(skeleton)
group = dartpy.collision.BulletCollisionDetector().createCollisionGroup()
group.addShapeFramesOf(skeleton)
found = []
for x, y, z in np.load(rays):
    result = dartpy.collision.RaycastResult()
    hit = group.raycast(np.array([x, y, z]), np.array([x, y, -1000.0]), dartpy.collision.RaycastOption(), result)
    found.append(result.mRayHits[0].mPoint[2] if hit else np.nan)
np.save(out, found)
os._exit(0)
"""


class Ground(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.heights = (terrain(130, 170) * 0.2).astype(np.float32)
        rows, columns = cls.heights.shape
        cls.dem = os.path.join(cls.folder.name, "dem.asc")
        with open(cls.dem, "w") as file:
            file.write(f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize {SPACING[0]}\n")
            np.savetxt(file, cls.heights, fmt="%.9g")
        rng = np.random.default_rng(2)
        cls.at_columns, cls.at_rows = rng.integers(1, columns - 1, RAYS), rng.integers(1, rows - 1, RAYS)
        cls.xs, cls.ys = rng.uniform(0.1, columns - 1.1, RAYS) * SPACING[0], -rng.uniform(0.1, rows - 1.1, RAYS) * SPACING[1]
        cls.above = float(cls.heights.max()) + 50

    def made(self, simulator, *more):
        folder = os.path.join(self.folder.name, "-".join([simulator, *more]).replace("/", "_"))
        command = [os.path.join(BIN, "fjell-bake"), "simulate", self.dem, "-o", folder, "--for", simulator]
        subprocess.run([*command, "--spacing", str(SPACING[0]), "--quiet", *more], check=True)
        with open(os.path.join(folder, "ground.json")) as file:
            return folder, json.load(file)

    def full_surface(self, x, y):
        """The full resolution's surface as Fjell draws it."""
        h = self.heights.astype(float)
        u, v = x / SPACING[0], -y / SPACING[1]
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        s, t = u - i, v - j
        nw, ne, sw, se = h[j, i], h[j, i + 1], h[j + 1, i], h[j + 1, i + 1]
        falling = np.where(s >= t, nw + (ne - nw) * s + (se - ne) * t, nw + (se - sw) * s + (sw - nw) * t)
        rising = np.where(s + t <= 1, nw + (ne - nw) * s + (sw - nw) * t, se + (sw - se) * (1 - s) + (ne - se) * (1 - t))
        return np.where((i + j) % 2 == 0, falling, rising)

    def obj(self, folder):
        vertices, triangles = [], []
        with open(os.path.join(folder, "terrain.obj")) as file:
            for line in file:
                words = line.split()
                if words[0] == "v":
                    vertices.append([float(w) for w in words[1:]])
                elif words[0] == "f":
                    triangles.append([int(w) - 1 for w in words[1:]])
        return np.array(vertices, np.float32), np.array(triangles, np.uint32)

    def check_mesh_engine(self, claims, cast, slack=1e-4):
        """cast(x, y) -> heights that rays from above find. slack: the engine's own single precision, in metres."""
        found = cast(self.at_columns * SPACING[0] + 1e-4, -self.at_rows * SPACING[1] - 1e-4)
        steepest = max(np.abs(np.diff(self.heights, axis=axis)).max() / SPACING[0] for axis in (0, 1))
        self.assertFalse(np.isnan(found).any(), "a ray finds no ground")
        off = np.abs(found - self.heights[self.at_rows, self.at_columns])
        self.assertLessEqual(off.max(), claims["true_error_m"] + 3 * steepest * 1e-4 + slack)

    def test_the_mesh_is_within_what_it_claims(self):
        for simulator in ("sdf", "urdf"):
            folder, claims = self.made(simulator, "--max-error-m", "0.1")
            vertices, triangles = self.obj(folder)
            off, covered = measure(self.heights, vertices, triangles, SPACING, up="z")
            self.assertTrue(covered.all())
            self.assertLessEqual(off, 0.1)
            self.assertAlmostEqual(off, claims["true_error_m"], delta=1e-6)
            self.assertEqual(claims["triangles"], len(triangles))
            made = fjell.mesh(self.heights, SPACING, 0.1, up="z")
            np.testing.assert_array_equal(made.triangles, triangles)

    def test_ground_far_from_the_robot_is_coarser(self):
        _, all_fine = self.made("urdf", "--max-error-m", "0.02")
        folder, claims = self.made("urdf", "--max-error-m", "0.02", "--area", "20,-20,10,0.1")
        self.assertLess(claims["triangles"], 0.6 * all_fine["triangles"])
        self.assertLessEqual(claims["area_error_m"], 0.02)
        vertices, triangles = self.obj(folder)
        off, covered = measure(self.heights, vertices, triangles, SPACING, up="z")
        self.assertTrue(covered.all())
        self.assertAlmostEqual(off, claims["true_error_m"], delta=1e-6)
        centres = vertices[triangles].mean(axis=1)
        near = np.hypot(centres[:, 0] - 20, centres[:, 1] + 20) < 8
        off, _ = measure(self.heights, vertices, triangles[near], SPACING, up="z")
        self.assertLessEqual(off, 0.02)
        farthest = max(np.hypot(x - 20, y + 20) for x in (0, 84.5) for y in (0, -64.5))
        self.assertLessEqual(claims["true_error_m"], 0.02 + 0.1 * (farthest - 10))

    def test_holes_are_refused_or_filled(self):
        holed = os.path.join(self.folder.name, "holed.asc")
        heights = self.heights.copy()
        heights[40:50, 40:60] = -9999
        rows, columns = heights.shape
        with open(holed, "w") as file:
            file.write(f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n")
            np.savetxt(file, heights, fmt="%.9g")
        command = [os.path.join(BIN, "fjell-bake"), "simulate", holed, "-o", self.folder.name + "/holed", "--for", "urdf", "--spacing", "1"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("200 of 22100 samples are holes", done.stderr)
        self.assertFalse(os.path.exists(self.folder.name + "/holed"))
        subprocess.run([*command, "--nodata", "fill", "--quiet"], check=True)

    def test_mujoco_rays_land_on_it(self):
        mj = library("mujoco")
        folder, claims = self.made("mujoco")
        mj.mj_loadXML.restype = mj.mj_makeData.restype = ctypes.c_void_p
        mj.mj_loadXML.argtypes = [ctypes.c_char_p, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int]
        mj.mj_makeData.argtypes = [ctypes.c_void_p]
        mj.mj_forward.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
        triple = ctypes.c_double * 3
        mj.mj_ray.restype = ctypes.c_double
        mj.mj_ray.argtypes = [ctypes.c_void_p, ctypes.c_void_p, triple, triple, ctypes.c_void_p, ctypes.c_ubyte, ctypes.c_int, ctypes.POINTER(ctypes.c_int)]
        error = ctypes.create_string_buffer(1000)
        model = mj.mj_loadXML(os.path.join(folder, "terrain.xml").encode(), None, error, 1000)
        self.assertTrue(model, error.value)
        data = mj.mj_makeData(model)
        mj.mj_forward(model, data)
        geom = ctypes.c_int()

        def cast(xs, ys):
            down = triple(0, 0, -1)
            found = [mj.mj_ray(model, data, triple(x, y, self.above), down, None, 1, -1, ctypes.byref(geom)) for x, y in zip(xs, ys)]
            self.assertTrue(all(f > 0 for f in found))
            return self.above - np.array(found)

        single = 2e-7 * np.abs(self.heights).max() + claims["rounding_error_m"]
        at_samples = cast(self.at_columns * SPACING[0], -self.at_rows * SPACING[1])
        off = np.abs(at_samples - self.heights[self.at_rows, self.at_columns])
        self.assertLessEqual(off.max(), single + 1e-6)
        between = np.abs(cast(self.xs, self.ys) - self.full_surface(self.xs, self.ys))
        self.assertLessEqual(between.max(), claims["diagonal_error_m"] + single + 1e-6)
        # Where both cut a cell alike they agree: the difference is that of the diagonals and nothing else.
        odd = (np.floor(self.xs / SPACING[0]) + np.floor(-self.ys / SPACING[1])) % 2 == 1
        self.assertLessEqual(between[odd].max(), single + 1e-6)
        self.assertGreater(between[~odd].max(), 0.1 * claims["diagonal_error_m"])

    def test_ode_rays_land_on_it(self):
        ode = library("ode")
        folder, claims = self.made("urdf", "--max-error-m", "0.1")
        vertices, triangles = self.obj(folder)
        ode.dCheckConfiguration.restype = ctypes.c_int
        real = ctypes.c_double if ode.dCheckConfiguration(b"ODE_double_precision") else ctypes.c_float

        class Contact(ctypes.Structure):
            _fields_ = [("pos", real * 4), ("normal", real * 4), ("depth", real), ("g1", ctypes.c_void_p), ("g2", ctypes.c_void_p), ("side1", ctypes.c_int), ("side2", ctypes.c_int)]

        pointer = ctypes.c_void_p
        for name, result, arguments in (
            ("dGeomTriMeshDataCreate", pointer, []),
            ("dGeomTriMeshDataBuildSingle", None, [pointer, pointer, ctypes.c_int, ctypes.c_int, pointer, ctypes.c_int, ctypes.c_int]),
            ("dCreateTriMesh", pointer, [pointer, pointer, pointer, pointer, pointer]),
            ("dCreateRay", pointer, [pointer, real]),
            ("dGeomRaySet", None, [pointer] + [real] * 6),
            ("dGeomRaySetClosestHit", None, [pointer, ctypes.c_int]),
            ("dCollide", ctypes.c_int, [pointer, pointer, ctypes.c_int, pointer, ctypes.c_int]),
            ("dInitODE2", ctypes.c_int, [ctypes.c_uint]),
            ("dAllocateODEDataForThread", ctypes.c_int, [ctypes.c_uint]),
        ):
            getattr(ode, name).restype, getattr(ode, name).argtypes = result, arguments
        ode.dInitODE2(0)
        ode.dAllocateODEDataForThread(0xFFFFFFFF)
        data = ode.dGeomTriMeshDataCreate()
        vertices, triangles = np.ascontiguousarray(vertices), np.ascontiguousarray(triangles)
        ode.dGeomTriMeshDataBuildSingle(data, vertices.ctypes.data, 12, len(vertices), triangles.ctypes.data, 3 * len(triangles), 12)
        mesh, ray, contact = ode.dCreateTriMesh(None, data, None, None, None), ode.dCreateRay(None, 1000), Contact()
        ode.dGeomRaySetClosestHit(ray, 1)

        def cast(xs, ys):
            found = []
            for x, y in zip(xs, ys):
                ode.dGeomRaySet(ray, x, y, self.above, 0, 0, -1)
                self.assertEqual(ode.dCollide(ray, mesh, 1, ctypes.addressof(contact), ctypes.sizeof(contact)), 1)
                found.append(contact.pos[2])
            return np.array(found)

        self.check_mesh_engine(claims, cast)

    def test_dart_and_bullet_rays_land_on_it(self):
        if importlib.util.find_spec("dartpy") is None:
            self.skipTest("python3-dartpy is not installed")
        for simulator, file in (("urdf", "terrain.urdf"), ("sdf", "model.sdf")):
            with self.subTest(simulator=simulator):
                folder, claims = self.made(simulator, "--max-error-m", "0.1")

                def cast(xs, ys):
                    rays, found = os.path.join(self.folder.name, "rays.npy"), os.path.join(self.folder.name, "found.npy")
                    np.save(rays, np.stack([xs, ys, np.full(len(xs), self.above)], axis=1))
                    command = [sys.executable, "-c", DART, os.path.join(folder, file), rays, found]
                    done = subprocess.run(command, capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    return np.load(found)

                self.check_mesh_engine(claims, cast, slack=1e-3)

    def test_the_heightmap_is_a_square_in_its_place(self):
        folder, claims = self.made("sdf")
        geometry = xml.parse(os.path.join(folder, "heightmap.sdf")).find(".//heightmap")
        size = [float(v) for v in geometry.find("size").text.split()]
        pos = [float(v) for v in geometry.find("pos").text.split()]
        try:
            from osgeo import gdal
        except ImportError:
            self.skipTest("python3-gdal is not installed")
        gdal.UseExceptions()
        image = gdal.Open(os.path.join(folder, geometry.find("uri").text)).ReadAsArray()
        side = image.shape[0]
        self.assertEqual((image.shape, image.dtype), ((257, 257), np.uint16))
        self.assertEqual(size[:2], [(side - 1) * SPACING[0]] * 2)
        # As Gazebo reads it: the first row lies at the largest y, and 65535 stands for size z.
        columns = (pos[0] - size[0] / 2) / SPACING[0] + np.arange(side)
        rows = -(pos[1] + size[1] / 2) / SPACING[1] + np.arange(side)
        self.assertEqual((columns[0], rows[0]), (0, 0))
        ground = pos[2] + image / 65535 * size[2]
        rows, columns = self.heights.shape
        off = np.abs(ground[:rows, :columns] - self.heights)
        self.assertLessEqual(off.max(), claims["heightmap_quantum_m"] / 2 + 1e-5)

    def test_each_file_is_what_its_engine_reads(self):
        for simulator, files in (
            ("mujoco", {"terrain.hfield", "terrain.xml"}),
            ("sdf", {"terrain.obj", "heightmap.png", "heightmap.sdf", "model.sdf", "model.config"}),
            ("urdf", {"terrain.obj", "terrain.urdf"}),
        ):
            folder, claims = self.made(simulator)
            self.assertEqual(set(claims["files"]), files)
            self.assertEqual(set(os.listdir(folder)), files | {"ground.json"})
            for name in files:
                if name.endswith((".xml", ".sdf", ".urdf", ".config")):
                    xml.parse(os.path.join(folder, name))


if __name__ == "__main__":
    unittest.main()
