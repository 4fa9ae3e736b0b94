import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.sparse.linalg import splu

from core import eigen, factorization
from core.data import Material
from core.elasticity import assemble, hold_points
from core.errors import DataError
from core.ordering import _cover, nested_dissection
from tests.core.solids import block

BACKENDS = [factorization.factorize_superlu]
if factorization.cholmod is not None:
    BACKENDS.append(factorization.factorize_cholmod)


@pytest.fixture(scope="module")
def beam():
    """K, M and places of a square beam: its bending modes come in exact pairs."""
    model = assemble(block((8, 2, 2), (0.4, 0.1, 0.1)), Material(1000.0, 0.4), "p1")
    model = hold_points(model, np.flatnonzero(model.points[:, 0] == 0))
    free = model.free
    places = np.repeat(model.points, 3, axis=0)[free]
    return model.stiffness[free][:, free], model.mass[free][:, free], places


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("dissect", [0, 10**9])
def test_every_factorization_solves_one_and_many_right_sides(beam, backend, dissect, monkeypatch):
    monkeypatch.setattr(factorization, "DISSECT_FROM", dissect)
    K, _, places = beam
    x = np.random.default_rng(0).standard_normal((K.shape[0], 3))
    factor = backend(K, places)
    assert factor.solve(K @ x) == pytest.approx(x, abs=1e-8)
    assert factor.solve(K @ x[:, 0]) == pytest.approx(x[:, 0], abs=1e-8)


def test_eigenvalues_agree_with_a_dense_solver(beam):
    K, M, places = beam
    got, vectors = eigen.lowest_eigenpairs(K, M, 20, places)
    want = eigh(K.toarray(), M.toarray(), eigvals_only=True)[:20]
    assert got == pytest.approx(want, rel=1e-10)
    assert vectors.T @ (M @ vectors) == pytest.approx(np.eye(20), abs=1e-9)


@pytest.mark.parametrize("times", [2, 5, 8])
def test_no_copy_of_a_multiple_eigenvalue_is_missed(times):
    n = 60
    chain = sparse.diags([np.full(n, 2.0), np.full(n - 1, -1.0), np.full(n - 1, -1.0)], [0, 1, -1])
    K = sparse.kron(sparse.eye(times), chain).tocsr()
    got, _ = eigen.lowest_eigenpairs(
        K, sparse.eye(n * times, format="csr"), 2 * times, multiplicity=8
    )
    exact = 2 - 2 * np.cos(np.pi * np.arange(1, 3) / (n + 1))
    assert got == pytest.approx(np.repeat(exact, times), rel=1e-9)


def test_the_fallback_finds_the_same_eigenvalues(beam, monkeypatch):
    K, M, places = beam
    want, _ = eigen.lowest_eigenpairs(K, M, 8, places)
    monkeypatch.setattr(factorization, "cholmod", None)
    got, _ = eigen.lowest_eigenpairs(K, M, 8, places)
    assert got == pytest.approx(want, rel=1e-10)


def test_nested_dissection_is_a_permutation_that_fills_in_less_than_none():
    model = assemble(block((12, 12, 12), (1, 1, 1)), Material(1000.0, 0.4), "p1")
    places = np.repeat(model.points, 3, axis=0)
    A = model.stiffness + model.mass
    order = nested_dissection(A, places)
    assert (np.sort(order) == np.arange(A.shape[0])).all()

    def fill(matrix):
        options = {"SymmetricMode": True}
        return splu(matrix.tocsc(), "NATURAL", diag_pivot_thresh=0.0, options=options).L.nnz

    assert fill(A[order][:, order]) < 0.65 * fill(A)


@pytest.mark.parametrize("edges", [1, 30, 60, 200])
def test_a_separator_touches_every_cut_edge_and_no_smaller_one_does(edges):
    lower, upper = np.random.default_rng(edges).integers(0, 40, (2, edges))
    upper = upper + 40
    graph = sparse.csr_matrix((np.ones(edges, int), (lower, upper)), shape=(80, 80))
    cover = _cover(lower, upper, 80)
    assert (cover[lower] | cover[upper]).all()
    assert cover.sum() == (maximum_bipartite_matching(graph) >= 0).sum()  # Koenig's theorem


def test_an_ordering_of_places_moves_unknowns_together(beam):
    K, _, places = beam
    order = nested_dissection(K, places)
    assert (np.diff(order.reshape(-1, 3), axis=1) == 1).all()
    assert (order[::3] % 3 == 0).all()


def test_an_indefinite_matrix_is_refused_by_cholmod():
    if factorization.cholmod is None:
        pytest.skip("no CHOLMOD")
    with pytest.raises(DataError, match="not positive definite"):
        factorization.factorize(sparse.diags([1.0, -1.0, 2.0]).tocsr())


def test_more_pairs_than_unknowns_are_refused(beam):
    with pytest.raises(DataError, match="asked of"):
        eigen.lowest_eigenpairs(beam[0], beam[1], beam[0].shape[0])
