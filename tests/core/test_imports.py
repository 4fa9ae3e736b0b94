"""Each module of `core` may be the first one that is imported: none waits for itself."""

import subprocess
import sys
from pathlib import Path

import core

ROOT = Path(core.__file__).parent
FRESH = """
import importlib, sys
import numpy, scipy.linalg, scipy.optimize, scipy.signal, scipy.sparse.linalg, scipy.stats
sys.dont_write_bytecode, sys.pycache_prefix = False, sys.argv[1]
for name in sys.argv[2:]:
    for known in [m for m in sys.modules if m.split(".")[0] == "core"]:
        del sys.modules[known]
    importlib.import_module(name)
"""


def test_every_module_can_be_the_first(tmp_path):
    files = [f.relative_to(ROOT.parent).with_suffix("") for f in sorted(ROOT.rglob("*.py"))]
    names = [".".join(f.parts) for f in files if f.stem not in ("__init__", "__main__")]
    assert len(names) > 100
    done = subprocess.run(
        [sys.executable, "-c", FRESH, str(tmp_path), *names],
        cwd=ROOT.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
