"""fjell.mesh: the bound, cracks, holes, and every kind of array that NumPy has."""

import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import fjell
from measured import covered_by_cells, measure, places, rims

FULL = os.environ.get("FJELL_TEST_ROUNDS") == "full"


def terrain(rows, columns, seed=0):
    """Ridges over noise of several widths."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:rows, 0:columns].astype(float)
    ground = 40 * np.abs(np.sin(x / 23 + seed)) + 25 * np.cos(y / 17) + 0.02 * x
    for width in (1, 4, 16):
        noise = rng.normal(size=(rows // width + 2, columns // width + 2))
        ground += width**0.7 * noise[(y // width).astype(int), (x // width).astype(int)]
    return ground


class TheBound(unittest.TestCase):
    def check(self, heights, max_error, spacing=1.0, **more):
        pair = spacing if isinstance(spacing, tuple) else (spacing, spacing)
        made = fjell.mesh(heights, spacing, max_error, **more)
        worst, covered = measure(heights, made.vertices, made.triangles, pair, more.get("up", "y"))
        ground = np.ma.filled(np.ma.asarray(heights).astype(float), np.nan)
        rounding = np.nanmax(np.abs(ground - ground.astype(np.float32)), initial=0)
        self.assertLessEqual(worst, max(max_error, rounding))
        self.assertAlmostEqual(worst, made.true_error, delta=1e-9 * max(1, np.nanmax(np.abs(ground))))
        np.testing.assert_array_equal(covered, covered_by_cells(ground))
        columns, rows, up = places(made.vertices, pair, more.get("up", "y"))
        np.testing.assert_array_equal(up, ground[rows, columns].astype(np.float32))
        self.assertEqual(len({*zip(columns.tolist(), rows.tolist())}), len(columns))
        self.assertEqual(set(np.unique(made.triangles)), set(range(len(made.vertices))))
        return made

    def test_holds_at_every_sample_of_any_size(self):
        for rows, columns in ((2, 2), (2, 9), (3, 3), (5, 4), (33, 33), (65, 100), (127, 3), (150, 130), (60, 700)):
            heights = terrain(rows, columns, rows)
            for max_error in (0, 0.3, 3, 30):
                with self.subTest(rows=rows, columns=columns, max_error=max_error):
                    made = self.check(heights, max_error)
                    for a, b in rims(made.triangles):
                        x, z = made.vertices[[a, b]][:, 0], made.vertices[[a, b]][:, 2]
                        on_rim = any(np.all(v == end) for v, last in ((x, columns - 1), (z, rows - 1)) for end in (0, last))
                        self.assertTrue(on_rim, "a crack: an edge inside the terrain has one triangle")

    def test_holds_over_several_tiles(self):
        heights = terrain(560, 1060, 7)  # 2 x 3 tiles
        made = self.check(heights, 6, (2.5, 1.25))
        self.assertLess(len(made.triangles), 0.4 * heights.size)
        self.check(heights.astype(np.int16), 9)

    def test_holds_beside_holes_and_covers_none(self):
        rng = np.random.default_rng(3)
        for rows, columns in ((40, 57), (129, 129), (90, 530)):
            heights = terrain(rows, columns, 5)
            heights[rng.random(heights.shape) < 0.002] = np.nan
            heights[rows // 3 : rows // 2, columns // 4 : columns // 2] = np.nan
            heights[0, 0] = np.nan
            self.check(heights, 2)
            mask = np.isnan(heights)
            same = self.check(np.ma.array(np.nan_to_num(heights, nan=-9999), mask=mask), 2)
            np.testing.assert_array_equal(same.triangles, fjell.mesh(heights, 1, 2).triangles)

    def test_fills_holes_or_refuses_them(self):
        heights = terrain(90, 80, 2)
        heights[30:50, 20:60] = np.nan
        made = fjell.mesh(heights, 1, 1, holes="fill")
        full = np.zeros(heights.shape, bool)
        columns, rows, _ = places(made.vertices, (1, 1))
        full[rows, columns] = True
        self.assertTrue(full[30:50, 20:60].any())
        for a, b in rims(made.triangles):
            self.assertTrue(columns[a] == columns[b] or rows[a] == rows[b])
        with self.assertRaisesRegex(ValueError, "heights: 800 of 7200 are NaN or masked, the first at row 30, column 20"):
            fjell.mesh(heights, 1, 1, holes="refuse")
        with self.assertRaisesRegex(ValueError, "no ground"):
            fjell.mesh(np.full((9, 9), np.nan))

    def test_flat_ground_takes_two_triangles(self):
        for heights in (np.zeros((257, 257)), np.add.outer(np.arange(257), 3 * np.arange(257))):
            made = self.check(heights, 0)
            self.assertEqual(len(made.triangles), 2)
        plane = np.add.outer(np.arange(100) * 0.1, np.arange(300) * 0.3)
        self.assertLess(len(fjell.mesh(plane, 1, 0.01).triangles), 500)

    def test_z_up_turns_the_axes_and_not_the_triangles(self):
        heights = terrain(50, 60)
        y, z = self.check(heights, 1, 3.0), self.check(heights, 1, 3.0, up="z")
        np.testing.assert_array_equal(y.triangles, z.triangles)
        np.testing.assert_array_equal(y.vertices[:, [0, 2, 1]] * [1, -1, 1], z.vertices)

    def test_high_ground_keeps_its_small_steps(self):
        heights = 1e5 + terrain(120, 130) * 1e-3
        self.check(heights.astype(np.float32), 0.01)
        made = fjell.mesh(heights, 1, 1e-6)  # float32 holds no more than 4 mm up there
        self.assertLessEqual(made.true_error, 0.004)


class Arrays(unittest.TestCase):
    def setUp(self):
        self.heights = np.rint(terrain(70, 90) * 4)
        self.made = fjell.mesh(self.heights, 1, 5)

    def same(self, heights, **more):
        made = fjell.mesh(heights, 1, 5, **more)
        np.testing.assert_array_equal(made.vertices, self.made.vertices)
        np.testing.assert_array_equal(made.triangles, self.made.triangles)
        self.assertEqual(made.true_error, self.made.true_error)

    def test_any_type_and_stride_gives_the_same_mesh(self):
        h = self.heights
        for dtype in ("i2", "i4", "i8", "f4", "f8", ">i2", ">f4", ">f8", "f2", "longdouble"):
            with self.subTest(dtype=dtype):
                self.same(h.astype(dtype))
        self.same(np.asfortranarray(h))
        self.same(h[::-1, ::-1].copy()[::-1, ::-1])
        wide = np.full((140, 270), np.nan)
        wide[::2, ::3] = h
        self.same(wide[::2, ::3])
        self.same(h.T.copy().T)
        read_only = h.copy()
        read_only.flags.writeable = False
        self.same(read_only)
        odd = np.zeros(h.size * 4 + 1, np.uint8)[1:].view("<f4").reshape(h.shape)  # unaligned
        odd[...] = h
        self.same(odd)
        records = np.zeros(h.shape, [("flag", "i1"), ("height", "f8")])
        records["height"] = h
        self.same(records["height"])
        self.same(h.tolist())
        self.same(np.ma.array(h))

    def test_unsigned_bytes_and_bools_are_heights_too(self):
        h = (self.heights - self.heights.min()).clip(0, 255)
        np.testing.assert_array_equal(fjell.mesh(h).triangles, fjell.mesh(h.astype(np.uint8)).triangles)
        flags = h > 100
        np.testing.assert_array_equal(fjell.mesh(flags).triangles, fjell.mesh(flags.astype(float)).triangles)

    def test_is_the_same_for_any_number_of_threads(self):
        h = terrain(560, 1060, 9)
        one = fjell.mesh(h, 1, 3, threads=1)
        for threads in (0, 2, 5):
            other = fjell.mesh(h, 1, 3, threads=threads)
            self.assertEqual(one.vertices.tobytes(), other.vertices.tobytes())
            self.assertEqual(one.triangles.tobytes(), other.triangles.tobytes())
            self.assertEqual(one.true_error, other.true_error)

    def test_what_is_no_height_field_is_refused_by_name(self):
        refused = (
            (TypeError, "heights: has dtype object", np.array([[1, None], [2, 3]], object)),
            (TypeError, "heights: has dtype complex128", np.zeros((4, 4), complex)),
            (TypeError, "heights: has dtype <U1", np.full((4, 4), "a")),
            (TypeError, "heights: has dtype datetime64", np.zeros((4, 4), "datetime64[s]")),
            (ValueError, "heights: has 1 dimensions", np.zeros(9)),
            (ValueError, "heights: has 3 dimensions", np.zeros((4, 4, 3))),
            (ValueError, "heights: has 0 x 0 samples", np.zeros((0, 0))),
            (ValueError, "heights: has 9 x 1 samples", np.zeros((1, 9))),
            (ValueError, "heights: has 1 x 9 samples", np.zeros((9, 1))),
            (ValueError, "heights: 1 of 16 are infinite.* row 1, column 2", np.array([[0] * 4, [0, 0, np.inf, 0], [0] * 4, [0] * 4])),
            (ValueError, "too large for a float", np.full((4, 4), 1e300)),
        )
        for error, text, heights in refused:
            with self.subTest(text=text), self.assertRaisesRegex(error, text):
                fjell.mesh(heights)
        for error, text, arguments in (
            (ValueError, "max_error", {"max_error": -1}),
            (ValueError, "max_error", {"max_error": np.nan}),
            (ValueError, "spacing", {"spacing": 0}),
            (ValueError, "spacing", {"spacing": (1, np.inf)}),
            (TypeError, "spacing", {"spacing": "wide"}),
            (TypeError, "spacing", {"spacing": (1, 2, 3)}),
            (ValueError, "holes", {"holes": "dig"}),
            (ValueError, "up", {"up": "x"}),
        ):
            with self.subTest(text=text, **arguments), self.assertRaisesRegex(error, text):
                fjell.mesh(self.heights, **arguments)

    def test_an_array_that_another_thread_changes_is_survived(self):
        heights = terrain(600, 600)
        stop = threading.Event()

        def change():
            rng = np.random.default_rng(1)
            while not stop.is_set():
                heights[rng.integers(600), :] = rng.choice([0, np.nan, 1e30, -5], 600)

        thread = threading.Thread(target=change)
        thread.start()
        try:
            for _ in range(5):
                try:
                    made = fjell.mesh(heights, 1, 2)
                except ValueError:
                    continue  # no ground at all is an answer too
                self.assertLess(made.triangles.max(initial=0), len(made.vertices) or 1)
        finally:
            stop.set()
            thread.join()


class Manners(unittest.TestCase):
    def test_other_threads_run_meanwhile(self):
        heights = terrain(1500, 1500)
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1

        thread = threading.Thread(target=count)
        thread.start()
        try:
            while counted[0] == 0:
                time.sleep(0.001)
            before = counted[0]
            fjell.mesh(heights, 1, 1)
            self.assertGreater(counted[0], before + 10)
        finally:
            stop.set()
            thread.join()

    def test_control_c_ends_it(self):
        script = (
            "import fjell, numpy as np, os, signal, threading\n"
            "h = np.random.default_rng(0).normal(size=(9000, 9000)).astype('f4')\n"
            "threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
            "try:\n"
            "    while True: fjell.mesh(h, 1, 0.5)\n"
            "except KeyboardInterrupt:\n"
            "    print('ended')\n"
        )
        done = subprocess.run(["env", "LD_PRELOAD=" + os.environ["PYTHON_PRELOAD"], sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual(done.stdout, "ended\n", done.stderr)

    @unittest.skipIf("ASAN_OPTIONS" in os.environ, "AddressSanitizer keeps what was freed")
    def test_calls_leave_nothing_behind(self):
        heights = terrain(24, 24)
        calls = 30_000 if FULL else 2_000

        def resident():
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        def call(times):
            for _ in range(times):
                fjell.mesh(heights, 1, 1)
                try:
                    fjell.mesh(heights, 0)
                except ValueError:
                    pass

        call(500)
        before = resident()
        call(calls)
        # In full rounds 50 bytes a call would show; threads' stacks and the allocator's own habits take less than this.
        self.assertLess(resident() - before, 1_500_000)

    @unittest.skipUnless(FULL, "2 GB of samples: with FJELL_TEST_ROUNDS=full")
    def test_2_31_samples_of_a_memory_map(self):
        with tempfile.TemporaryDirectory() as folder:
            heights = np.memmap(os.path.join(folder, "heights"), np.int8, "w+", shape=(1 << 15, 1 << 16))
            heights[1000:1010, 2000:2020] = 50
            made = fjell.mesh(heights, 1, 1)
            self.assertLessEqual(made.true_error, 1)
            columns, rows, up = places(made.vertices, (1, 1))
            np.testing.assert_array_equal(up, heights[rows, columns])
            self.assertEqual((columns.max(), rows.max()), ((1 << 16) - 1, (1 << 15) - 1))


if __name__ == "__main__":
    unittest.main()
