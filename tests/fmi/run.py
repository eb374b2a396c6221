"""Runs every test of this folder on the FMUs in target/fmu: python tests/fmi/run.py [name of a test ...]"""

import pathlib
import sys
import time
import unittest

if __name__ == "__main__":
    here = pathlib.Path(__file__).parent
    sys.path.insert(0, str(here))
    loader = unittest.defaultTestLoader
    suite = loader.loadTestsFromNames(sys.argv[1:]) if sys.argv[1:] else loader.discover(str(here), top_level_dir=str(here))
    started = time.time()
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    print(f"{time.time() - started:.0f} s")
    sys.exit(not result.wasSuccessful())
