"""Runs one file of tests, and says what was skipped, as ./dev test counts it."""

import os
import sys
import unittest

# A sanitizer's runtime is for Python alone: our programs have their own. Tests that start another Python give it this.
os.environ["PYTHON_PRELOAD"] = os.environ.pop("LD_PRELOAD", "")
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
name = os.path.splitext(os.path.basename(sys.argv[1]))[0]
result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromName(name))
for test, reason in result.skipped:
    print(f"skipped: {test}: {reason}", file=sys.stderr)
if result.testsRun == 0:
    sys.exit("there are no tests in " + name)
sys.exit(not result.wasSuccessful())
