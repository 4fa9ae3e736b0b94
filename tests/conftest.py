"""What holds for every test that meshes in this process: the same surface gives the same mesh.

Where several Pythons run side by side, each slow test of what knows nothing of Blender is one's.
"""

from pathlib import Path

from core.tetwild import run_tetwild
from tests import seeded_tetwild

seeded_tetwild.use(run_tetwild)

ADDON = Path(__file__).parent / "addon"


def pytest_addoption(parser):
    parser.addoption(
        "--share",
        default="1/1",
        help="K/N: of the slow tests outside of tests/addon every N-th from the K-th on",
    )


def pytest_collection_modifyitems(config, items):
    k, n = (int(number) for number in config.getoption("--share").split("/"))
    dealt = [i for i in items if i.get_closest_marker("slow") and ADDON not in i.path.parents]
    left = {id(item) for at, item in enumerate(dealt) if at % n != k - 1}
    if left:
        config.hook.pytest_deselected(items=[item for item in items if id(item) in left])
        items[:] = [item for item in items if id(item) not in left]
