"""The skin of a mesh has an edge where its pins end."""

import numpy as np
import pytest

from core.boundary import boundary
from core.data import Material, TetMesh, tet_volumes
from core.elasticity import assemble, hold_points
from core.rim import LEAST, along_rim
from core.stiffening import converged_eigenvalues
from tests.core.solids import block

SIZE = (0.6, 0.1, 0.15)


def slab(end):
    return lambda places, hair=0.0: places[:, 0] <= end + hair + 1e-9


def ball(places, hair=0.0):
    return np.linalg.norm(places - [0, 0.05, 0.075], axis=1) < 0.13 + hair


@pytest.mark.parametrize("counts", [(7, 2, 2), (11, 2, 3), (5, 4, 3)])
@pytest.mark.parametrize("held", [slab(0.15), slab(0.02), ball])
def test_it_is_the_same_body_with_its_own_nodes_first(counts, held):
    mesh = block(counts, SIZE, jitter=0.25)
    cut = along_rim(mesh, held)
    assert np.array_equal(cut.nodes[: len(mesh.nodes)], mesh.nodes)
    volumes = tet_volumes(cut.nodes, cut.tets)
    assert volumes.sum() == pytest.approx(mesh.volume, rel=1e-12)
    assert (volumes > 0).all()
    assert boundary(cut).areas.sum() == pytest.approx(boundary(mesh).areas.sum(), rel=1e-12)
    skin = boundary(cut).corners  # a hanging node would open the body
    edges, count = np.unique(
        np.sort(skin[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1),
        axis=0,
        return_counts=True,
    )
    assert (count == 2).all()


@pytest.mark.parametrize("end", [0.15, 0.21, 0.29])
def test_new_nodes_lie_on_the_rim(end):
    mesh = block((5, 2, 2), SIZE, jitter=0.25)
    cut = along_rim(mesh, slab(end))
    new = cut.nodes[len(mesh.nodes) :]
    longest = boundary(mesh).longest_edge.max()
    off = np.abs(new[:, 0] - end)
    assert len(new) > 5
    assert np.median(off) < 0.01 * longest
    assert off.max() < LEAST * longest


def test_a_mesh_that_follows_its_pins_stays_as_it_is():
    mesh = block((12, 3, 4), SIZE)
    assert len(along_rim(mesh, slab(0.15)).tets) == len(mesh.tets)
    assert len(along_rim(mesh, slab(1.0)).tets) == len(mesh.tets)
    assert len(along_rim(mesh, slab(-1.0)).tets) == len(mesh.tets)


def test_a_foot_that_ends_at_a_sharp_edge_stays_as_it_is():
    """Its nodes lie a trifle off where it ends, as meshing leaves them."""
    mesh = block((12, 3, 4), SIZE)
    off = 1e-4 * np.random.default_rng(1).standard_normal(mesh.nodes.shape)
    rough = TetMesh(mesh.nodes + off * 0.05, mesh.tets)
    assert len(along_rim(rough, slab(0.15)).tets) == len(mesh.tets)


def test_a_rim_through_triangles_no_longer_hides_from_the_estimate_of_the_stiffening():
    def build(mesh, element):
        model = assemble(mesh, Material(1000.0, 0.45), element)
        return hold_points(model, np.flatnonzero(slab(0.15)(model.points)))

    def limit(mesh):
        return converged_eigenvalues(build, mesh, 2).values[:2]

    true = limit(block((16, 4, 6), SIZE))  # its cells end where the pins do
    before, after = [], []
    for counts in ((7, 2, 2), (9, 2, 2), (11, 2, 3), (13, 2, 3)):
        mesh = block(counts, SIZE, jitter=0.25)
        before.append(limit(mesh) / true - 1)
        after.append(limit(along_rim(mesh, slab(0.15))) / true - 1)
    assert np.abs(before).max() > 0.03
    assert np.abs(after).max() < 0.015
    assert np.abs(after).mean() < np.abs(before).mean() / 5
