"""What holds for every test that meshes in this process: the same surface gives the same mesh.

Where several Pythons run side by side, each slow test of what knows nothing of Blender is one's.
"""

from pathlib import Path
from zlib import crc32

import pytest

from core.tetwild import run_tetwild
from tests import seeded_tetwild

seeded_tetwild.use(run_tetwild)

ADDON = Path(__file__).parent / "addon"


def pytest_addoption(parser):
    parser.addoption(
        "--share",
        default="1/1",
        help="K/N: of the slow tests outside of tests/addon the K-th share of N",
    )


def pytest_collection_modifyitems(config, items):
    k, n = (int(number) for number in config.getoption("--share").split("/"))
    if not 1 <= k <= n:
        raise pytest.UsageError(f"--share {k}/{n}: K from 1 to N is needed.")

    def is_ours(item) -> bool:
        dealt = item.get_closest_marker("slow") and ADDON not in item.path.parents
        return not dealt or crc32(item.nodeid.encode()) % n == k - 1  # wherever others come and go

    ours = [item for item in items if is_ours(item)]
    if len(ours) < len(items):
        config.hook.pytest_deselected(items=[item for item in items if not is_ours(item)])
        items[:] = ours
