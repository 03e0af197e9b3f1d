"""Pairs of points that lie close together, and what pairs join."""

import itertools

import numpy as np
from numpy.typing import NDArray


def close_pairs(points: NDArray[np.float64], cutoff: float) -> NDArray[np.int64]:
    """Return every pair of points nearer to each other than `cutoff`.

    Args:
        points: (N, 3) coordinates, finite.
        cutoff: distance in the unit of `points`, positive.

    Returns:
        (P, 2) indices with the smaller first, in ascending order.
    """
    if len(points) < 2:
        return np.empty((0, 2), dtype=np.int64)
    cells = np.floor((points - points.min(axis=0)) / cutoff).astype(np.int64) + 1
    strides = np.array([1, cells[:, 0].max() + 2, 0], dtype=np.int64)
    strides[2] = strides[1] * (cells[:, 1].max() + 2)
    keys = cells @ strides
    by_key = np.argsort(keys, kind="stable")
    sorted_keys = keys[by_key]

    found = []
    # Half of the 27 neighbouring cells, so that each pair of cells is visited once.
    for offset in list(itertools.product((-1, 0, 1), repeat=3))[13:]:
        target = keys + np.asarray(offset) @ strides
        begin = np.searchsorted(sorted_keys, target, side="left")
        counts = np.searchsorted(sorted_keys, target, side="right") - begin
        first = np.repeat(np.arange(len(points)), counts)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        second = by_key[np.repeat(begin, counts) + within]
        near = np.linalg.norm(points[first] - points[second], axis=1) < cutoff
        if offset == (0, 0, 0):
            near &= first < second
        found.append(np.column_stack((first[near], second[near])))
    pairs = np.sort(np.concatenate(found), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def connects(pairs: list[tuple[int, int]], atoms: list[int]) -> bool:
    """Whether the pairs join all atoms to one piece; False for no atoms."""
    parent = {atom: atom for atom in atoms}

    def root(atom: int) -> int:
        while parent[atom] != atom:
            atom = parent[atom]
        return atom

    for i, j in pairs:
        if i in parent and j in parent:
            parent[root(i)] = root(j)
    return len({root(atom) for atom in atoms}) == 1
