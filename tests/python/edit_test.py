"""fjell.Terrain.edit: the ground changes, and all that speaks of it does too."""

import os
import tempfile
import threading
import unittest

import numpy as np

import fjell
from measured import measure
from mesh_test import terrain

SPACING = 2.0


class Edits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.pack = os.path.join(cls.folder.name, "t.fjell")
        fjell.bake(np.rint(terrain(257, 300) * 100) / 100, cls.pack, spacing=SPACING, tile=64)

    def open(self, **options):
        return fjell.Terrain(self.pack, edit_blocks=256, **options)

    def test_samples_heights_rays_and_patches_are_those_of_the_new_ground(self):
        with self.open() as t:
            before = t.samples()
            self.assertEqual(t.ground_changes(), [])
            j, i = np.mgrid[0:40, 0:50]
            wanted = before[100:140, 120:170] + (5 * np.sin(i / 9) * np.cos(j / 7)).astype(np.float32)
            wanted[3, 4] = np.nan  # this one stays
            changed = t.edit("heights", first=(120, 100), heights=wanted)
            after = t.samples()
            self.assertEqual(changed, int((after != before).sum()))
            wanted[3, 4] = before[103, 124]
            np.testing.assert_allclose(after[100:140, 120:170], wanted, atol=t.quantum_m / 2 + 1e-4)
            outside = np.ones(before.shape, bool)
            outside[100:140, 120:170] = False
            np.testing.assert_array_equal(after[outside], before[outside])
            np.testing.assert_array_equal(t.patch(96, 96, 65).heights, after[96:161, 96:161])
            np.testing.assert_array_equal(t.samples(step=4)[:-1, :-1], after[:-1:4, :-1:4][:64, :75])
            self.assertAlmostEqual(t.height(150 * SPACING, 120 * SPACING), float(after[120, 150]), places=4)
            hit = t.ray((150 * SPACING, 5000, 120 * SPACING), (0, -1, 0))
            self.assertAlmostEqual(hit.position[1], float(after[120, 150]), places=3)
            rects = t.ground_changes()
            covered = np.zeros(before.shape, bool)
            for column, row, columns, rows in rects:
                covered[row : row + rows, column : column + columns] = True
            self.assertTrue(covered[after != before].all())
            self.assertLess(covered.sum(), 4 * changed)
            self.assertEqual(t.ground_changes(), [])
            t.edit("restore", at=(145 * SPACING, 120 * SPACING), radius=500)
            np.testing.assert_array_equal(t.samples(), before)

    def test_paint_changes_colours_and_no_height(self):
        with self.open() as t:
            before = t.samples()
            self.assertEqual(t.edit("paint", at=(200, 200), radius=40, rgb=(200, 10, 10), strength=0.5), 0)
            self.assertEqual(t.edit("paint", points=[(100, 100), (300, 180)], radius=6, rgb=(70, 70, 70)), 0)
            self.assertEqual(t.edit("unpaint", at=(200, 200), radius=20), 0)
            np.testing.assert_array_equal(t.samples(), before)
            with self.assertRaisesRegex(ValueError, "rgb"):
                t.edit("paint", at=(200, 200), radius=40)
            with self.assertRaisesRegex(ValueError, "strength"):
                t.edit("paint", at=(200, 200), radius=40, rgb=(1, 2, 3), strength=2)

    def test_a_lock_changes_no_height(self):
        with self.open() as t:
            before = t.samples()
            self.assertEqual(t.edit("lock", points=[(100, 100), (300, 180)], radius=6, amount=0.1), 0)
            self.assertEqual(t.edit("unlock", at=(200, 200), radius=20), 0)
            np.testing.assert_array_equal(t.samples(), before)
            with self.assertRaisesRegex(ValueError, "amount_m"):
                t.edit("lock", at=(200, 200), radius=40)

    def test_a_streamed_terrain_has_the_ground_of_one_that_is_loaded(self):
        stamps = (
            ("crater", {"at": (300, 260), "radius": 40, "falloff": 20, "amount": 15}),
            ("heights", {"first": (200, 10), "heights": terrain(257, 300)[10:40, 200:220] + 2.0}),
            ("restore", {"at": (310, 260), "radius": 12}),
        )
        with self.open() as whole, self.open(streaming=True) as t:
            for shape, fields in stamps:
                self.assertEqual(t.edit(shape, **fields), whole.edit(shape, **fields))
            self.assertGreater(len(t.ground_changes()), 0)
            np.testing.assert_array_equal(t.samples(), whole.samples())
            np.testing.assert_array_equal(t.samples(step=4), whole.samples(step=4))
            before = t.samples()
            with self.assertRaisesRegex(ValueError, "too little of the ground|steeper"):
                t.edit("heights", first=(200, 10), heights=np.full((30, 20), 100.0))
            np.testing.assert_array_equal(t.samples(), before)
        with self.open() as whole, self.open(streaming=True) as t:
            for shape, fields in stamps:
                self.assertEqual(t.edit(shape, **fields), whole.edit(shape, **fields))
            view = fjell.View(eye=(300, 200 + whole.height(300, 260), 261), look=(300, 0, 260), size=(320, 200), max_error_px=0.01)
            t.update(view, wait=True)
            found, errors = t.heights(np.linspace(290, 310, 40), 260.0, errors=True)
            difference = np.abs(found - whole.heights(np.linspace(290, 310, 40), 260.0))
            self.assertTrue((difference <= errors + 1e-3).all())
            self.assertLess(errors.max(), 1)
            t.edit("raise", (300, 260), radius=20, amount=1.0)  # with a mesh in use
            whole.edit("raise", (300, 260), radius=20, amount=1.0)
            np.testing.assert_array_equal(t.samples(), whole.samples())
            before = t.samples()
            with self.assertRaisesRegex(ValueError, "Stamp"):
                t.edit("raise", (300, 260), radius=60, amount=1e6)
            np.testing.assert_array_equal(t.samples(), before)

    def test_frames_and_pictures_made_before_and_after_hold_their_bound_over_the_new_ground(self):
        with self.open() as t:
            view = fjell.View(eye=(300, 120 + t.height(300, 440), 440), look=(300, t.height(300, 260), 260), size=(320, 200), max_error_px=1)
            t.update(view, wait=True)
            try:
                plain = t.render(view)
            except OSError as why:
                plain = None
                print("skipped: pictures:", why)
            t.edit("crater", (300, 260), radius=40, falloff=20, amount=15)
            t.edit("path", points=[(100, 300, t.height(100, 300)), (500, 320, t.height(500, 320))], radius=6, falloff=10)
            frame = t.update(view, wait=True)
            self.assertTrue(frame.settled)
            self.assertLessEqual(frame.error_bound_px, 1)
            ground = t.samples().astype(float)
            whole = fjell.View(eye=(300, 3000, 260), look=(300, 0, 259.9), up=(0, 0, -1), size=(500, 500), max_error_px=0.5)
            vertices, triangles = t.update(whole, wait=True).mesh()
            m_a_px = 2 * np.tan(np.radians(22.5)) * (3000 - t.height_range_m[0]) / 500
            self.assertLess(measure(ground, vertices, triangles, (SPACING, SPACING))[0], 0.5 * m_a_px * 1.2)
            if plain is not None:
                dug = t.render(view)
                self.assertGreater((np.abs(dug.astype(int) - plain).max(axis=-1) > 16).mean(), 0.02)
            t.snapshot(os.path.join(self.folder.name, "dug.glb"), view)

    def test_what_cannot_be_is_a_sentence_and_changes_nothing(self):
        with self.open() as t:
            before = t.samples()
            for name, shape, fields in (
                ("shape", "dig", {}),
                ("amount_m", "crater", {"at": (100, 100), "radius": 10}),
                ("radius_m", "raise", {"at": (100, 100), "radius": -1, "amount": 1}),
                ("height_m", "raise", {"at": (100, 100), "radius": 9, "amount": 1, "height": 3}),
                ("points", "path", {"points": [(1, 2, 3)], "radius": 4}),
                ("first", "heights", {"heights": np.ones((3, 3))}),
                ("two", "heights", {"heights": np.ones(9), "first": (0, 0)}),
                ("mask", "heights", {"heights": np.ones((3, 3)), "mask": np.ones((3, 4), np.uint8), "first": (0, 0)}),
                ("first", "raise", {"at": (1, 1), "radius": 2, "amount": 1, "first": (0, 0)}),
                ("infinite", "raise", {"at": (1, 1), "radius": 2, "amount": np.inf}),
                ("Stamp", "raise", {"at": (300, 260), "radius": 60, "amount": 1e6}),
            ):
                with self.subTest(shape=shape, fields=fields), self.assertRaisesRegex(ValueError, name):
                    t.edit(shape, **fields)
            np.testing.assert_array_equal(t.samples(), before)
        with fjell.Terrain(self.pack, edit_blocks=1) as t:
            with self.assertRaisesRegex(ValueError, "blocks"):
                t.edit("raise", (300, 260), radius=100, amount=0.1)
            np.testing.assert_array_equal(t.samples(), before)
        with fjell.Terrain(self.pack) as t, self.assertRaisesRegex(ValueError, "edit_blocks"):
            t.edit("raise", (300, 260), radius=10, amount=0.1)
        with self.assertRaisesRegex(ValueError, "edit_blocks"):
            fjell.Terrain(self.pack, edit_blocks=-1)

    def test_threads_ask_while_one_digs(self):
        with self.open() as t:
            low, high = (np.nanmin(t.samples()) - 3, np.nanmax(t.samples()) + 3)
            wrong, done = [], threading.Event()

            def ask():
                rng = np.random.default_rng(threading.get_ident() % 1000)
                while not done.is_set():
                    found, errors = t.heights(rng.random(200) * t.extent_m[0], rng.random(200) * t.extent_m[1], errors=True)
                    if not ((found + errors >= low) & (found - errors <= high)).all():
                        wrong.append((found.min(), found.max()))

            askers = [threading.Thread(target=ask) for _ in range(3)]
            for asker in askers:
                asker.start()
            rng = np.random.default_rng(5)
            for k in range(60):
                t.edit("raise", tuple(rng.random(2) * 500), radius=12, falloff=12, amount=float(k % 2 * 4 - 2) / 2)
            done.set()
            for asker in askers:
                asker.join()
            self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
