"""What documents promise of the module: docstrings' examples, the guide's code, the types, and how pip installs it."""

import doctest
import inspect
import os
import re
import subprocess
import sys
import tempfile
import unittest

import fjell

SOURCE = os.environ["FJELL_SOURCE_DIR"]
BUILD = os.environ["FJELL_BUILD_DIR"]
MODULES = (fjell, fjell._terrain, fjell._arrays)


class Documents(unittest.TestCase):
    def test_examples_of_docstrings_do_what_they_say(self):
        with tempfile.TemporaryDirectory() as folder:
            here = os.getcwd()
            os.chdir(folder)
            try:
                tried = 0
                for module in MODULES:
                    done = doctest.testmod(module, extraglobs={"fjell": fjell})
                    self.assertEqual(done.failed, 0, module.__name__)
                    tried += done.attempted
                self.assertGreater(tried, 12)
            finally:
                os.chdir(here)

    def test_whatever_is_public_says_what_it_is(self):
        for name in fjell.__all__:
            thing = getattr(fjell, name)
            self.assertTrue(thing.__doc__, name)
            for member, value in vars(thing).items() if inspect.isclass(thing) else ():
                if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                    if not (thing is fjell.Frame and isinstance(value, property)):  # the class says what they are
                        self.assertTrue(value.__doc__, f"{name}.{member}")

    def test_guides_run_from_top_to_bottom(self):
        for guide, calls in (("python", 8), ("simulators", 1)):
            with open(os.path.join(SOURCE, f"docs/guides/{guide}.md")) as file:
                text = file.read()
            code = "\n".join(re.findall(r"^```python\n(.*?)^```", text, re.S | re.M))
            self.assertGreaterEqual(code.count("fjell."), calls)
            with tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, guide + done.stderr)


class Types(unittest.TestCase):
    def mypy(self, *arguments, cwd=None):
        try:
            import mypy  # noqa: F401
        except ImportError:
            self.skipTest("python3-mypy is not installed")
        cache = tempfile.mkdtemp()
        command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", cache, *arguments]
        environment = {**os.environ, "MYPYPATH": os.path.join(SOURCE, "baker/python")}
        return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=environment)

    def test_the_package_and_its_stubs_are_typed(self):
        done = self.mypy(os.path.join(SOURCE, "baker/python/fjell"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_wrong_calls_are_found_before_they_run(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "use.py"), "w") as file:
                file.write(
                    "import fjell\n"
                    "made = fjell.mesh([[0, 1], [2, 3]], max_error=0.5)\n"
                    "error: float = made.true_error\n"
                    "height: str = fjell.Terrain('x').height(1, 2)\n"
                    "fjell.mesh([[0, 1], [2, 3]], max_err=1)\n"
                )
            done = self.mypy("use.py", cwd=folder)
        wrong = sorted(re.findall(r"use.py:(\d+): error", done.stdout))
        self.assertEqual(wrong, ["4", "5"], done.stdout + done.stderr)

    def test_stubs_name_what_the_native_half_has(self):
        with open(os.path.join(SOURCE, "baker/python/fjell/_native.pyi")) as file:
            stub = file.read()
        functions = set(re.findall(r"^def (\w+)", stub, re.M))
        native = fjell._native
        self.assertEqual(functions, {n for n, v in vars(native).items() if inspect.isroutine(v)})
        for name in re.findall(r"^class (\w+)", stub, re.M):
            body = re.search(rf"^class {name}:\n(.*?)(?=^\S|\Z)", stub, re.S | re.M).group(1)
            members = {m for m in vars(getattr(native, name)) if not m.startswith("_")}
            self.assertEqual(set(re.findall(r"def (\w+)", body)) - {"__init__"}, members, name)


class Installing(unittest.TestCase):
    def test_pip_makes_a_wheel_without_a_network_and_installs_it(self):
        if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
            self.skipTest("python3-pip is not installed")
        with tempfile.TemporaryDirectory() as folder:
            # What is built already is taken: a build of its own takes minutes.
            environment = {**os.environ, "FJELL_PYTHON_BUILD": BUILD, "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
            environment.pop("PYTHONPATH", None)
            target = os.path.join(folder, "site")
            command = [sys.executable, "-m", "pip", "install", "--no-deps", "--target", target, SOURCE]
            done = subprocess.run(command, capture_output=True, text=True, env=environment)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            code = "import fjell, sys; print(fjell.__file__, len(fjell.mesh([[0, 0], [0, 9]], max_error=0).triangles))"
            used = subprocess.run(
                [sys.executable, "-c", code], capture_output=True, text=True, env={**environment, "PYTHONPATH": target}, cwd=folder
            )
            self.assertEqual(used.stdout.split(), [os.path.join(target, "fjell/__init__.py"), "2"], used.stderr)
            with open(os.path.join(target, f"fjell-{fjell.__version__}.dist-info/METADATA")) as file:
                self.assertIn("Requires-Dist: numpy", file.read())
            self.assertTrue(os.path.exists(os.path.join(target, "fjell/py.typed")))


if __name__ == "__main__":
    unittest.main()
