"""A folder for each test, commands that run in it, and waiting for what another process does."""

import contextlib
import io
import pathlib
import tempfile
import time
import unittest


def wait_for(done, seconds=120.0):
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.01)


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ran(self, main, scene, *words, out="out"):
        """What a command prints, its errors and its exit code. scene: a Scene, or the name of a preset or a file."""
        if not isinstance(scene, str):
            (self.folder / "scene.toml").write_text(scene.text())
            scene = str(self.folder / "scene.toml")
        code = 0
        with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()) as errors:
            try:
                main([scene, *words, "--out", str(self.folder / out)])
            except SystemExit as left:
                code = left.code
        return said.getvalue(), errors.getvalue(), code
