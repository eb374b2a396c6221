"""The programs of the documents, as a reader would run them."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

TOP = pathlib.Path(__file__).parents[2]


class Documents(unittest.TestCase):
    def test_programs(self):
        for document, expected in [("README.md", 1), ("docs/python.md", 2)]:
            blocks = re.findall(r"```python\n(.*?)```", (TOP / document).read_text(), re.DOTALL)
            blocks = [block for block in blocks if "import fabric_kernel" in block]
            self.assertEqual(len(blocks), expected)
            for block in blocks:
                with self.subTest(document), tempfile.TemporaryDirectory() as folder:
                    script = pathlib.Path(folder) / "example.py"
                    script.write_text(block)
                    done = subprocess.run([sys.executable, script], cwd=folder, capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertTrue(done.stdout)


if __name__ == "__main__":
    unittest.main()
