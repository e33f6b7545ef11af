"""fjell.Terrain: heights, rays, patches, frames, snapshots and pictures, from several threads, closed at any time."""

import json
import os
import struct
import tempfile
import threading
import unittest

import numpy as np

import fjell
from measured import measure, rims
from mesh_test import terrain

SPACING = (2.0, 3.0)


def surface(heights, x, z):
    """The full resolution's surface, as the guide describes it: two triangles a cell, whose diagonals alternate."""
    u, v = x / SPACING[0], z / SPACING[1]
    i = np.clip(np.floor(u).astype(int), 0, heights.shape[1] - 2)
    j = np.clip(np.floor(v).astype(int), 0, heights.shape[0] - 2)
    s, t = u - i, v - j
    nw, ne, sw, se = heights[j, i], heights[j, i + 1], heights[j + 1, i], heights[j + 1, i + 1]
    falling = np.where(s >= t, nw + (ne - nw) * s + (se - ne) * t, nw + (se - sw) * s + (sw - nw) * t)
    rising = np.where(s + t <= 1, nw + (ne - nw) * s + (sw - nw) * t, se + (sw - se) * (1 - s) + (ne - se) * (1 - t))
    return np.where((i + j) % 2 == 0, falling, rising)


class Terrains(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.pack = os.path.join(cls.folder.name, "t.fjell")
        fjell.bake(np.rint(terrain(300, 400) * 100) / 100, cls.pack, spacing=SPACING, tile=64)
        cls.holed = os.path.join(cls.folder.name, "holed.fjell")
        heights = terrain(130, 140)
        heights[50:70, 40:90] = np.nan
        fjell.bake(heights, cls.holed, spacing=SPACING, tile=64)

    def test_heights_are_those_of_the_surface(self):
        rng = np.random.default_rng(0)
        with fjell.Terrain(self.pack) as t:
            samples = t.samples().astype(float)
            x, z = rng.random(5000) * t.extent_m[0], rng.random(5000) * t.extent_m[1]
            found, errors = t.heights(x, z, errors=True)
            np.testing.assert_allclose(found, surface(samples, x, z), atol=1e-4)
            np.testing.assert_allclose(errors, t.quantum_m / 2, rtol=1e-6)
            self.assertEqual(t.height(x[3], z[3]), found[3])
            self.assertEqual(t.heights(x[:, None], z[:7]).shape, (5000, 7))
            self.assertEqual(t.heights(5.0, 6.0).shape, ())
            normals = t.normals(x, z)
            np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-9)
            step = 1e-4
            slope = (t.heights(x + step, z) - found) / step
            steep = np.abs(slope + normals[:, 0] / normals[:, 1]) > 1e-2
            self.assertLess(steep.sum(), 30)  # a step that crosses an edge
            self.assertTrue(np.isnan(t.height(-1, 5)))
            self.assertTrue(np.isnan(t.heights([np.nan, 1e9], [0, 0])).all())
            for bad in (("a", 1), ([1, 2], [1, 2, 3])):
                with self.assertRaisesRegex(ValueError, "xs, zs"):
                    t.heights(*bad)

    def test_holes_are_no_ground(self):
        with fjell.Terrain(self.holed) as t:
            self.assertTrue(t.has_holes)
            self.assertTrue(np.isnan(t.height(60 * 2.0, 60 * 3.0)))
            self.assertTrue(np.isnan(t.normals(60 * 2.0, 60 * 3.0)).all())
            self.assertIsNone(t.ray((120, 1000, 180), (0, -1, 0)))
            self.assertTrue(np.isnan(t.patch(40, 50, 9).heights).all())

    def test_rays_land_on_the_surface(self):
        rng = np.random.default_rng(1)
        with fjell.Terrain(self.pack) as t:
            width, depth = t.extent_m
            origins = np.stack([rng.random(1000) * width, np.full(1000, 900.0), rng.random(1000) * depth], axis=1)
            down = t.rays(origins, [0, -1, 0])
            np.testing.assert_allclose(900 - down, t.heights(origins[:, 0], origins[:, 2]), atol=1e-6)
            aims = origins[::-1].copy()
            aims[:, 1] = -50
            far = t.rays(origins, aims - origins)
            hit = origins + (aims - origins) / np.linalg.norm(aims - origins, axis=1)[:, None] * far[:, None]
            np.testing.assert_allclose(hit[:, 1], t.heights(hit[:, 0], hit[:, 2]), atol=1e-3)
            one = t.ray(origins[0], (aims - origins)[0])
            self.assertEqual(one.distance, far[0])
            np.testing.assert_allclose(one.position, hit[0], atol=1e-6)
            self.assertIsNone(t.ray(origins[0], (0, 1, 0)))
            self.assertIsNone(t.ray(origins[0], (0, -1, 0), max_distance=1))
            with self.assertRaisesRegex(TypeError, "direction"):
                t.ray(origins[0], "down")

    def test_patches_and_samples_agree(self):
        with fjell.Terrain(self.pack) as t:
            all_of_it = t.samples()
            patch = t.patch(32, 64, 33)
            np.testing.assert_array_equal(patch.heights, all_of_it[64:97, 32:65])
            self.assertLessEqual(patch.error, t.quantum_m)
            coarse = t.patch(0, 0, 9, step=8)
            np.testing.assert_array_equal(coarse.heights, all_of_it[0:65:8, 0:65:8])
            np.testing.assert_array_equal(t.samples(4)[:70, :90], all_of_it[::4, ::4][:70, :90])
            for more in ({"side": 1}, {"side": 5000}, {"side": 9, "step": 3}):
                with self.assertRaises(ValueError):
                    t.patch(0, 0, **more)

    def test_slopes_and_horizons_are_those_of_the_ground(self):
        y, x = np.mgrid[0:257, 0:257].astype(float)
        # Level in the west, then a ramp towards the east. Not of whole metres, whose slopes are those of a smooth surface.
        ground = np.where(x > 128, (x - 128) * 2.01, 0)
        pack = os.path.join(self.folder.name, "ramp.fjell")
        fjell.bake(ground, pack, spacing=2, tile=128, horizons="half")
        with fjell.Terrain(pack) as t:
            slope = t.slope()
            columns = np.arange(slope.values.shape[1]) * slope.spacing_m[0] / 2
            rows = np.arange(slope.values.shape[0]) * slope.spacing_m[1] / 2
            self.assertAlmostEqual(columns[-1], 256, delta=slope.spacing_m[0])
            self.assertAlmostEqual(rows[-1], 256, delta=slope.spacing_m[1])
            ramp = slope.values[:, (columns > 132) & (columns < 252)]
            np.testing.assert_allclose(ramp, 45, atol=0.7)
            np.testing.assert_allclose(slope.values[:, columns < 124], 0, atol=0.7)
            horizons = t.horizons()
            foot = horizons.values[:, np.abs(np.arange(horizons.values.shape[1]) * horizons.spacing_m[0] / 2 - 100).argmin()]
            middle = foot[len(foot) // 2]
            self.assertGreater(middle[4], 20)  # 96 degrees, nearly east
            self.assertEqual(middle[11], 0)  # 264 degrees, nearly west
            sky = t.sky()
            self.assertEqual(sky.values.shape, horizons.values.shape[:2])
            self.assertGreater(sky.values[len(foot) // 2, 2], sky.values[len(foot) // 2, 40])
        with fjell.Terrain(self.pack) as t, self.assertRaisesRegex(ValueError, "no horizon maps"):
            t.horizons()

    def test_terrains_are_compared_and_written_as_geotiff(self):
        with fjell.Terrain(self.pack) as t:
            samples = t.samples().astype(float)
            same = fjell.compare(t, self.pack)
            self.assertEqual((same.largest, same.compared, same.only_a), (0, samples.size, 0))
        moved = samples.copy()
        moved[40, 50] += 3
        moved[:2] = np.nan
        found = fjell.compare(self.pack, np.ma.masked_invalid(moved))
        self.assertEqual((found.largest, found.worst, found.only_a, found.only_b), (3, (40, 50), 800, 0))
        with self.assertRaisesRegex(ValueError, "a, b"):
            fjell.compare(self.pack, self.holed)
        out = os.path.join(self.folder.name, "out.tif")
        fjell.write_geotiff(self.holed, out)
        again = os.path.join(self.folder.name, "again.fjell")
        fjell.bake(out, again)
        with fjell.Terrain(self.holed) as a, fjell.Terrain(again) as b:
            np.testing.assert_array_equal(np.isnan(a.samples()), np.isnan(b.samples()))
        self.assertLessEqual(fjell.compare(self.holed, again).largest, fjell.info(again)["quantum_m"])
        with self.assertRaisesRegex(ValueError, "out"):
            fjell.write_geotiff(self.holed, "heights.png")
        try:
            import rasterio
        except ImportError:
            self.skipTest("python3-rasterio is not installed")
        with rasterio.open(out) as file:
            self.assertEqual((file.width, file.height), (140, 130))

    def view(self, t, **more):
        width, depth = t.extent_m
        return fjell.View((width / 2, 300, depth), (width / 2, 0, depth / 2), size=(320, 240), **more)

    def test_a_frame_is_a_whole_mesh_and_keeps_its_bound(self):
        for streaming in (False, True):
            with self.subTest(streaming=streaming), fjell.Terrain(self.pack, streaming=streaming) as t:
                frame = t.update(self.view(t, max_error_px=2), wait=True)
                self.assertTrue(frame.converged)
                self.assertLessEqual(frame.error_bound_px, 2)
                vertices, triangles = frame.mesh()
                self.assertEqual(len(triangles), frame.triangles_drawn)
                rims(triangles)
                off, _ = measure(t.samples(), vertices, triangles, SPACING)
                self.assertGreater(off, 0)
                eye, focal = np.array([t.extent_m[0] / 2, 300, t.extent_m[1]]), 240 / (2 * np.tan(np.radians(45) / 2))
                self.assertLess(off * focal, 2 * 3000)  # no farther than the farthest sample may be
                self.assertFalse(frame.vertices.flags.writeable)
                finer = t.update(self.view(t, max_error_px=0.5), wait=True)
                self.assertGreater(finer.triangles, frame.triangles)
                del eye

    def test_arrays_of_a_frame_outlive_their_terrain(self):
        t = fjell.Terrain(self.pack)
        frame = t.update(self.view(t), wait=True)
        indices = frame.indices
        before = indices.copy()
        t.close()
        del t, frame
        np.testing.assert_array_equal(indices, before)

    def test_profiles_are_files_or_keys(self):
        with fjell.Terrain(self.pack, {"refine.max_error_px": 40}) as t:
            self.assertEqual(t.update(self.view(t), wait=True).threshold_px, 40)
        with self.assertRaisesRegex(ValueError, "refine.nothing"):
            fjell.Terrain(self.pack, {"refine.nothing": 1})
        with self.assertRaises(ValueError):
            fjell.Terrain(self.pack, os.path.join(self.folder.name, "none.toml"))

    def test_a_snapshot_is_a_glb(self):
        out = os.path.join(self.folder.name, "s.glb")

        def of(**options):
            counts = t.snapshot(out, self.view(t), **options)
            with open(out, "rb") as file:
                magic, version, length = struct.unpack("<4sII", file.read(12))
                size, _ = struct.unpack("<I4s", file.read(8))
                scene = json.loads(file.read(size))
            self.assertEqual((magic, version, length), (b"glTF", 2, counts["file_bytes"]))
            self.assertEqual(scene["scenes"][0]["extras"]["fjell"]["triangles"], counts["triangles"])
            return length, scene.get("extensionsRequired", []), {i["mimeType"] for i in scene["images"]}

        with fjell.Terrain(self.pack) as t:
            plain, needs, kinds = of()
            self.assertEqual((needs, kinds), ([], {"image/png"}))
            rounded, needs, _ = of(quantised=True)
            self.assertEqual(needs, ["KHR_mesh_quantization"])
            packed, needs, kinds = of(quantised=True, meshopt=True, texture="jpeg")
            self.assertEqual(needs, ["EXT_meshopt_compression", "KHR_mesh_quantization"])
            self.assertEqual(kinds, {"image/png", "image/jpeg"})  # normals are never lossy
            coarse, _, _ = of(texel=500)
            self.assertTrue(packed < rounded < plain and coarse < plain, (packed, rounded, plain, coarse))
            for wrong in ({"texture": "webp"}, {"texel": -1}):
                with self.assertRaisesRegex(ValueError, next(iter(wrong))):
                    t.snapshot(out, self.view(t), **wrong)

    def test_pictures_show_ground_under_a_sky(self):
        with fjell.Terrain(self.pack) as t:
            try:
                picture = t.render(self.view(t))
            except OSError as no_gl:
                self.skipTest(f"no OpenGL: {no_gl}")
            self.assertEqual((picture.shape, picture.dtype), ((240, 320, 3), np.uint8))
            self.assertGreater(len(np.unique(picture[150:].reshape(-1, 3), axis=0)), 500)
            np.testing.assert_array_equal(picture, t.render(self.view(t)))
            self.assertFalse(np.array_equal(picture, t.render(self.view(t), mode="levels")))
            self.assertEqual(t.render(size=(64, 48)).shape, (48, 64, 3))
            with self.assertRaisesRegex(ValueError, "mode"):
                t.render(mode="x-ray")
            png = t._repr_png_()
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", png[16:24]), (960, 540))

    def test_a_map_needs_no_opengl(self):
        with fjell.Terrain(self.pack) as t:
            self.assertGreaterEqual(max(t.map(200).shape), 200)
        with fjell.Terrain(self.pack, streaming=True) as t:
            self.assertIsNone(t.map())

    def test_a_closed_terrain_says_so(self):
        t = fjell.Terrain(self.pack)
        self.assertIn("400 x 300", repr(t))
        t.close()
        t.close()
        self.assertIn("closed", repr(t))
        self.assertIsNone(t._repr_png_())
        for call in (lambda: t.height(1, 1), lambda: t.columns, lambda: t.patch(0, 0, 9), lambda: t.samples()):
            with self.assertRaisesRegex(ValueError, "the terrain is closed"):
                call()
        with self.assertRaises(FileNotFoundError):
            fjell.Terrain(self.pack + "x")
        with open(os.path.join(self.folder.name, "no.fjell"), "wb") as file:
            file.write(b"no pack at all" * 100)
        with self.assertRaisesRegex(ValueError, "no.fjell"):
            fjell.Terrain(os.path.join(self.folder.name, "no.fjell"))

    def test_many_threads_ask_while_one_updates_and_one_closes(self):
        for streaming in (False, True):
            t = fjell.Terrain(self.pack, streaming=streaming)
            width, depth = t.extent_m
            failed = []

            def ask(seed):
                rng = np.random.default_rng(seed)
                try:
                    for _ in range(100):
                        t.heights(rng.random(200) * width, rng.random(200) * depth)
                        t.rays([width / 2, 900, depth / 2], rng.normal(size=(20, 3)))
                except ValueError as closed:
                    if "closed" not in str(closed):
                        failed.append(closed)
                except BaseException as other:
                    failed.append(other)

            threads = [threading.Thread(target=ask, args=(i,)) for i in range(4)]
            for thread in threads:
                thread.start()
            for _ in range(20):
                t.update(self.view(t))
            t.close()
            for thread in threads:
                thread.join()
            self.assertEqual(failed, [])


if __name__ == "__main__":
    unittest.main()
