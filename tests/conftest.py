"""What holds for every test that meshes in this process: the same surface gives the same mesh."""

from core.tetwild import run_tetwild
from tests import seeded_tetwild

seeded_tetwild.use(run_tetwild)
