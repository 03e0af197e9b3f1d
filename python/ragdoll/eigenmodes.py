"""Lowest eigenvalues and vectors of symmetric matrices, the same ones whatever the threads."""

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

_DENSE = 600  # rows up to which a dense solver is the quicker one


def lowest_eigenpairs(
    matrix, count: int, shift: float, *, tolerance: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest eigenvalues (n,), ascending, and vectors (size, n) of a matrix without negative ones.

    Args:
        matrix: (size, size), sparse and symmetric.
        count: how many; all where there are fewer.
        shift: what makes the matrix definite, small beside the eigenvalues that count.
        tolerance: relative, of the eigenvalues; 0: of the machine.
    """
    # several threads add up in any order
    with threadpool_limits(1):
        return _lowest(matrix, min(count, matrix.shape[0]), shift, tolerance)


def _lowest(matrix, count: int, shift: float, tolerance: float):
    # scipy takes a while to load
    from scipy import linalg, sparse
    from scipy.sparse import linalg as sparse_linalg

    size = matrix.shape[0]
    if size <= _DENSE or 3 * count > size:
        return linalg.eigh(matrix.toarray(), subset_by_index=(0, count - 1))
    factors = sparse_linalg.splu(
        matrix + shift * sparse.identity(size, format="csc"),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    inverse = sparse_linalg.LinearOperator(matrix.shape, matvec=factors.solve, dtype=float)
    # a start of our own, so that the same structure has the same modes
    first = np.random.default_rng(0).standard_normal(size)
    values, vectors = sparse_linalg.eigsh(
        matrix, k=count, sigma=-shift, which="LM", OPinv=inverse, v0=first, tol=tolerance
    )
    order = np.argsort(values)
    return values[order], vectors[:, order]


def with_signs(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same vectors (n, size), each with the sign by which its largest part points up."""
    largest = np.abs(vectors).argmax(axis=1)
    return vectors * np.sign(vectors[np.arange(len(vectors)), largest])[:, None]
