"""What else a mass matrix can be. Consistent mass bounds frequencies from above; these do not.

Source      Hinton, Rock, Zienkiewicz, Earthq. Eng. Struct. Dyn. 4 (1976) (diagonal scaling);
            Goudreau & Taylor, Comp. Meth. Appl. Mech. Eng. 2 (1973) (the average of both)
"""

from scipy import sparse


def lumped(mass: sparse.csr_matrix) -> sparse.csr_matrix:
    """Diagonal mass in proportion to the consistent one's diagonal, with the same total.

    For linear elements of equal size these are the row sums. Of quadratic ones those have negative
    entries, this does not.
    """
    diagonal = mass.diagonal()
    return sparse.diags(diagonal * (mass.sum() / diagonal.sum())).tocsr()


def averaged(mass: sparse.csr_matrix) -> sparse.csr_matrix:
    """Half consistent, half lumped: the leading errors of linear elements cancel."""
    return (0.5 * mass + 0.5 * lumped(mass)).tocsr()
