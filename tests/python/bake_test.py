"""fjell.bake, verify and info: the same packs as the command line's, from arrays and files, whatever interrupts."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import fjell
from mesh_test import terrain

BIN = os.environ.get("FJELL_BIN_DIR", "")


def content(pack):
    return fjell.info(pack)["pack_hash"]


class Bakes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def grid(self, heights, spacing):
        """An ASCII grid, which the command line reads too."""
        name = self.path("grid.asc")
        rows, columns = heights.shape
        with open(name, "w") as file:
            file.write(f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize {spacing}\nNODATA_value -9999\n")
            np.savetxt(file, np.where(np.isnan(heights), -9999, heights), fmt="%.9g")
        return name

    def test_an_array_and_a_file_of_it_give_the_same_heights(self):
        heights = np.rint(terrain(150, 200) * 10) / 10
        heights[40:60, 70:90] = np.nan
        report = fjell.bake(heights, self.path("a.fjell"), spacing=3, tile=64, threads=1)
        fjell.bake(self.grid(heights, 3), self.path("b.fjell"), spacing=3, tile=64)
        self.assertEqual((report["columns"], report["rows"], report["holes"]), (200, 150, 400))
        with fjell.Terrain(self.path("a.fjell")) as a, fjell.Terrain(self.path("b.fjell")) as b:
            np.testing.assert_array_equal(a.samples(), b.samples())
            off = np.abs(a.samples() - heights)
            self.assertLessEqual(np.nanmax(off), a.quantum_m / 2 + 1e-4)
            np.testing.assert_array_equal(np.isnan(off), np.isnan(heights))
        self.assertTrue(fjell.verify(self.path("a.fjell"), heights, spacing=3)["ok"])
        self.assertTrue(fjell.verify(self.path("b.fjell"), self.path("grid.asc"))["ok"])
        heights[7, 7] += 5
        wrong = fjell.verify(self.path("a.fjell"), heights, spacing=3)
        self.assertFalse(wrong["ok"])
        self.assertEqual(wrong["height_mismatches"], 1)

    @unittest.skipUnless(BIN, "FJELL_BIN_DIR names no fjell-bake")
    def test_options_and_reports_are_the_command_lines(self):
        heights = np.rint(terrain(140, 140))
        grid = self.grid(heights, 5)
        tool = os.path.join(BIN, "fjell-bake")
        subprocess.run(
            [tool, grid, "-o", self.path("cli.fjell"), "--spacing", "5", "--nesting", "0.1", "--zscale", "2", "--horizons", "half", "--quiet"],
            check=True,
        )
        said = fjell.bake(grid, self.path("py.fjell"), spacing=5, nesting=0.1, zscale=2, horizons="half")
        with open(self.path("cli.fjell"), "rb") as a, open(self.path("py.fjell"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        info = json.loads(subprocess.run([tool, "info", self.path("py.fjell"), "--json"], check=True, capture_output=True).stdout)
        self.assertEqual(info, fjell.info(self.path("py.fjell")))
        self.assertEqual(said["columns"], info["columns"])
        options = subprocess.run([tool, "--help"], check=True, capture_output=True, text=True).stdout
        for name in fjell.options():
            if name not in ("inputs", "output"):
                self.assertIn("--" + name.replace("_", "-"), options)

    def test_locks_hold_a_line_over_an_array(self):
        line, pack = self.path("line.geojson"), self.path("locked.fjell")
        with open(line, "w") as file:
            file.write('{"type": "LineString", "coordinates": [[100, -100], [1500, -900]]}')
        said = fjell.bake(terrain(90, 120), pack, spacing=20, locks=line, lock_error_m=0.1)
        self.assertGreater(said["always_drawn"], 50)
        self.assertEqual(said["locks"], f"1 line; {said['always_drawn']} vertices are always drawn")
        with self.assertRaisesRegex(ValueError, "lock-error-m"):
            fjell.bake(terrain(90, 120), self.path("none.fjell"), spacing=20, lock_error_m=0.1)

    def test_stamps_change_an_array_and_a_file_alike(self):
        heights = np.rint(10 * terrain(90, 120)).astype(np.int16)
        stamps, array, again = (self.path(name) for name in ("stamps.json", "array.fjell", "again.fjell"))
        with open(stamps, "w") as file:
            file.write('{"stamps": [{"shape": "crater", "at": [1200, 900], "radius_m": 200, "amount_m": 50}]}')
        fjell.bake(heights, array, spacing=20)
        fjell.bake(array, again, edits=stamps)
        fjell.bake(heights, array, spacing=20, edits=stamps)
        with fjell.Terrain(array) as a, fjell.Terrain(again) as b:
            self.assertAlmostEqual(a.height(1200, 900), float(heights[45, 60]) - 50, delta=0.6)
            self.assertLess(np.abs(a.samples() - b.samples()).max(), 1.1)
            self.assertAlmostEqual(a.height(400, 400), float(heights[20, 20]), delta=0.01)

    def test_voids_scales_and_places_of_arrays(self):
        heights = terrain(80, 100).astype(np.float32)
        heights[10:20, 30:40] = -9999
        with self.assertRaisesRegex(ValueError, "100 of 8000 heights are -9999.*--void -9999"):
            fjell.bake(heights, self.path("a.fjell"))
        self.assertFalse(os.path.exists(self.path("a.fjell")))
        self.assertEqual(fjell.bake(heights, self.path("a.fjell"), void=-9999)["holes"], 100)
        self.assertEqual(fjell.bake(heights, self.path("a.fjell"), void=[-9999], nodata="fill")["holes"], 0)
        ground = terrain(80, 100)
        fjell.bake(ground, self.path("b.fjell"), spacing=(2, 5), zscale=0.5, zoffset=100)
        with fjell.Terrain(self.path("b.fjell")) as b:
            self.assertEqual(b.spacing_m, (2, 5))
            self.assertAlmostEqual(b.height(20, 35), ground[7, 10] * 0.5 + 100, delta=b.quantum_m)
        fjell.bake(ground, self.path("c.fjell"), spacing=10, crs="EPSG:25832", origin=(400000, 5300000))
        info = fjell.info(self.path("c.fjell"))
        self.assertEqual(info["epsg"], 25832)
        self.assertEqual(info["crs_origin"], [400000, 5300000])
        for text, more in (
            ("crs: EPSG:4326: is not projected", {"crs": "EPSG:4326"}),
            ("crs: nowhere: no CRS", {"crs": "nowhere"}),
            ("bbox", {"bbox": [0, 0, 5, 5]}),
            ("tile", {"tile": 100}),
            ("nesting", {"nesting": 7}),
        ):
            with self.subTest(text=text), self.assertRaisesRegex(ValueError, text):
                fjell.bake(ground, self.path("d.fjell"), **more)
        with self.assertRaisesRegex(TypeError, "tiles: is no option"):
            fjell.bake(ground, self.path("d.fjell"), tiles=64)
        with self.assertRaisesRegex(ValueError, "missing.tif"):
            fjell.bake(self.path("missing.tif"), self.path("d.fjell"))
        with self.assertRaises(FileNotFoundError):
            fjell.info(self.path("missing.fjell"))
        self.assertEqual([n for n in os.listdir(self.folder) if n.startswith("d.")], [])

    def test_progress_is_told_here_and_may_stop_it(self):
        heights = terrain(1400, 1400)
        told, here = [], threading.get_ident()

        def progress(stage, done, total):
            self.assertEqual(threading.get_ident(), here)
            told.append((stage, done, total))

        fjell.bake(heights, self.path("a.fjell"), progress=progress)
        before = content(self.path("a.fjell"))
        self.assertTrue(told)
        self.assertTrue(all(done <= total for _, done, total in told))

        class Enough(Exception):
            pass

        def stop(stage, done, total):
            raise Enough

        with self.assertRaises(Enough):
            fjell.bake(heights + 1, self.path("a.fjell"), progress=stop)
        self.assertEqual(content(self.path("a.fjell")), before)

    def test_control_c_at_any_time_leaves_the_old_pack_or_a_new_one(self):
        out = self.path("a.fjell")
        fjell.bake(terrain(64, 64), out)
        old = content(out)
        script = (
            "import fjell, numpy as np, sys, os, signal, threading\n"
            "h = np.load(sys.argv[1])\n"
            "threading.Timer(float(sys.argv[3]), os.kill, (os.getpid(), signal.SIGINT)).start()\n"
            "try:\n"
            "    fjell.bake(h, sys.argv[2])\n"
            "    print('baked')\n"
            "except KeyboardInterrupt:\n"
            "    print('ended')\n"
        )
        heights = terrain(1500, 1500, 4)
        np.save(self.path("h.npy"), heights)
        new = content(self.bake_apart(heights))
        for after in (0.01, 0.1, 0.3, 0.7):
            done = subprocess.run(
                ["env", "LD_PRELOAD=" + os.environ["PYTHON_PRELOAD"], sys.executable, "-c", script, self.path("h.npy"), out, str(after)],
                capture_output=True,
                text=True,
            )
            with self.subTest(after=after):
                # Ctrl-C may come between the new pack's completion and the call's end.
                self.assertIn(content(out), [new] if "baked" in done.stdout else [old, new], done.stderr)
                self.assertTrue(fjell.verify(out)["ok"])
            old = content(out)
        fjell.bake(heights, out)  # goes on, or begins again
        self.assertEqual(content(out), new)
        self.assertFalse(os.path.exists(out + ".work"))

    def bake_apart(self, heights):
        fjell.bake(heights, self.path("apart.fjell"))
        return self.path("apart.fjell")

    def test_xarrays_say_where_they_lie(self):
        try:
            import xarray
        except ImportError:
            self.skipTest("python3-xarray is not installed")
        ground = terrain(60, 70)
        northwards = xarray.DataArray(
            ground[::-1], dims=("y", "x"), coords={"y": 5000 + 4.0 * np.arange(60), "x": 300 + 2.0 * np.arange(70)}
        )
        fjell.bake(northwards, self.path("a.fjell"), crs="EPSG:25833")
        info = fjell.info(self.path("a.fjell"))
        self.assertEqual(info["crs_origin"], [300, 5000 + 4 * 59])
        with fjell.Terrain(self.path("a.fjell")) as a:
            self.assertEqual(a.spacing_m, (2, 4))
            self.assertAlmostEqual(a.height(20, 40), ground[10, 10], delta=a.quantum_m)
        np.testing.assert_array_equal(fjell.mesh(northwards, 1, 1).triangles, fjell.mesh(ground[::-1], 1, 1).triangles)


if __name__ == "__main__":
    unittest.main()
