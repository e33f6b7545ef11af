"""Runs one file of tests, and says what was skipped, as ./dev test counts it. Full rounds run those that name FULL, if
the file has it: the others would do what they have done."""

import inspect
import os
import sys
import unittest

# A sanitizer's runtime is for Python alone: our programs have their own. Tests that start another Python give it this.
os.environ["PYTHON_PRELOAD"] = os.environ.pop("LD_PRELOAD", "")
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
name = os.path.splitext(os.path.basename(sys.argv[1]))[0]
tests = unittest.defaultTestLoader.loadTestsFromName(name)
if getattr(sys.modules.get(name), "FULL", False):
    cases = [test for suite in tests for test in suite]
    tests = unittest.TestSuite(t for t in cases if "FULL" in inspect.getsource(getattr(t, t._testMethodName)))
result = unittest.TextTestRunner(verbosity=2).run(tests)
for test, reason in result.skipped:
    print(f"skipped: {test}: {reason}", file=sys.stderr)
if result.testsRun == 0:
    sys.exit("there are no tests in " + name)
sys.exit(not result.wasSuccessful())
