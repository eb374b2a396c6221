"""Commands that run in a folder, and waiting for what another process does."""

import contextlib
import io
import time


def wait_for(done, seconds=120.0):
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.01)


def called(folder, main, scene, *words, out="out"):
    """What a command prints, its errors and its exit code. scene: a Scene, or the name of a preset or a file."""
    if not isinstance(scene, str):
        (folder / "scene.toml").write_text(scene.to_toml())
        scene = str(folder / "scene.toml")
    code = 0
    with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()) as errors:
        try:
            main([scene, *words, "--out", str(folder / out)])
        except SystemExit as left:
            code = left.code
    return said.getvalue(), errors.getvalue(), code
