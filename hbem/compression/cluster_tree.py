"""Cluster tree and block tree: which parts of a surface see each other from afar.

Clusters follow positions in space, so both sheets of a fold share them. Bisection at the median
along the longest side of the box; ties keep their order, so a tree is a function of its points
alone. A pair is admissible if ``diam <= eta * dist`` with the distance of the boxes, a lower
bound of the true one; boxes contain the supports of the items.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

LANES = 8  # target counts are padded to multiples: no scalar tails


@dataclass(frozen=True)
class ClusterTree:
    """Binary tree over items; node 0 is the root, children follow their parents.

    Attributes
    ----------
    order : (n_items,) int array
        Items in tree order: node k holds ``order[start[k]:stop[k]]``.
    start, stop : (n_nodes,) int array
    children : (n_nodes, 2) int array
        -1 for leaves.
    level : (n_nodes,) int array
    lower, upper : (n_nodes, 3) array
        Boxes around the supports of the items.
    """

    order: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    children: np.ndarray
    level: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @property
    def n_nodes(self) -> int:
        return self.start.size

    @property
    def sizes(self) -> np.ndarray:
        return self.stop - self.start

    @property
    def leaves(self) -> np.ndarray:
        """Leaf nodes in tree order, ``(n_leaves,)``."""
        nodes = np.flatnonzero(self.children[:, 0] < 0)
        return nodes[np.argsort(self.start[nodes], kind="stable")]

    @property
    def diameters(self) -> np.ndarray:
        return np.linalg.norm(self.upper - self.lower, axis=1)

    def distances(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Distances of the boxes of paired nodes."""
        gap = np.maximum(self.lower[a] - self.upper[b], self.lower[b] - self.upper[a])
        return np.linalg.norm(np.maximum(gap, 0.0), axis=-1)


def cluster_tree(
    lower: np.ndarray, upper: np.ndarray | None = None, *, leaf: int = 64, even: int = 1
) -> ClusterTree:
    """Bisect items with support boxes ``lower, upper (n, 3)`` down to ``leaf`` items.

    ``upper`` may be omitted for points; ``even`` divides the size of all clusters but the last.

    Raises
    ------
    ValueError
        No items, a wrong shape, positions that are not finite, or ``leaf < 1``.
    """
    lower = np.ascontiguousarray(lower, dtype=float)
    upper = lower if upper is None else np.ascontiguousarray(upper, dtype=float)
    if lower.ndim != 2 or lower.shape[1:] != (3,) or upper.shape != lower.shape or not lower.size:
        raise ValueError(f"expected boxes (n, 3), n > 0, got {lower.shape} and {upper.shape}")
    if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
        raise ValueError("positions are not finite")
    if leaf < 1:
        raise ValueError(f"leaf must be at least 1, got {leaf}")
    return _bisect(0.5 * (lower + upper), lower, upper, leaf, even)


def grouped_tree(points: np.ndarray, group: int, leaf: int) -> ClusterTree:
    """Bisect points ``(n, 3)`` that stay together in consecutive groups, those of an element."""
    boxes = points.reshape(-1, group, 3)
    even = LANES if group == 1 else 1
    box = boxes.min(axis=1), boxes.max(axis=1)
    tree = cluster_tree(*box, leaf=max(1, leaf // group), even=even)
    order = (group * tree.order[:, None] + np.arange(group)).ravel()
    return replace(tree, order=order, start=group * tree.start, stop=group * tree.stop)


def _bisect(
    centres: np.ndarray, lower: np.ndarray, upper: np.ndarray, leaf: int, even: int
) -> ClusterTree:
    order = np.arange(centres.shape[0])
    start, stop, level, children, boxes = [0], [order.size], [0], [], []
    k = 0
    while k < len(start):
        members = order[start[k] : stop[k]]
        boxes.append((lower[members].min(axis=0), upper[members].max(axis=0)))
        if members.size <= leaf:
            children.append((-1, -1))
        else:
            axis = int(np.argmax(np.ptp(centres[members], axis=0)))
            ranks = np.argsort(centres[members, axis], kind="stable")
            order[start[k] : stop[k]] = members[ranks]
            half = members.size // 2
            middle = start[k] + (half - half % even or half)
            children.append((len(start), len(start) + 1))
            start += [start[k], middle]
            stop += [middle, stop[k]]
            level += [level[k] + 1] * 2
        k += 1
    box = np.array(boxes)
    first, last, sons, depth = (np.array(v, np.int64) for v in (start, stop, children, level))
    return ClusterTree(order, first, last, sons, depth, box[:, 0], box[:, 1])


@dataclass(frozen=True)
class BlockTree:
    """Disjoint blocks that cover all pairs of items once; each pair of nodes appears once.

    Attributes
    ----------
    tree : ClusterTree
    far : (n_far, 2) int array
        Admissible pairs of nodes; (t, s) stands for (s, t) too.
    near : (n_near, 2) int array
        Pairs of leaves that are not admissible; (t, t) on the diagonal, else (t, s) for both.
    """

    tree: ClusterTree
    far: np.ndarray
    near: np.ndarray


def block_tree(tree: ClusterTree, eta: float, *, largest: bool = False) -> BlockTree:
    """Split pairs of clusters until they are admissible or leaves.

    Parameters
    ----------
    tree : ClusterTree
    eta : float
        Admissible if ``diam <= eta * dist``.
    largest : bool
        Compare the larger diameter (nested bases need it), not the smaller one.
    """
    diameter, children = tree.diameters, tree.children
    pairs, far, near = np.zeros((1, 2), dtype=np.int64), [], []
    pick = np.maximum if largest else np.minimum
    while pairs.size:
        t, s = pairs.T
        distance = tree.distances(t, s)
        apart = (distance > 0.0) & (pick(diameter[t], diameter[s]) <= eta * distance)
        far.append(pairs[apart])
        pairs = pairs[~apart]
        leaf = children[pairs, 0] < 0
        near.append(pairs[leaf.all(axis=1)])
        pairs = _split(pairs[~leaf.all(axis=1)], children)
    return BlockTree(tree, np.concatenate(far), np.concatenate(near))


def _split(pairs: np.ndarray, children: np.ndarray) -> np.ndarray:
    """Children of pairs, a leaf standing for itself; the lower half of diagonal pairs is left."""
    sons = [np.where(children[p, 0:1] < 0, p[:, None], children[p]) for p in pairs.T]
    single = [children[p, 0] < 0 for p in pairs.T]
    parts = []
    for i in range(2):
        for j in range(2):
            wanted = ~((i == 1) & single[0]) & ~((j == 1) & single[1])
            if (i, j) == (1, 0):
                wanted &= pairs[:, 0] != pairs[:, 1]
            parts.append(np.stack([sons[0][wanted, i], sons[1][wanted, j]], axis=1))
    return np.concatenate(parts)


def list_partners(pairs: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Partners of every node as index pointer, partners and numbers of the pairs.

    Pair k counts as partner of both its nodes, once if they are equal; the number is k where the
    node comes first and ``~k`` where it comes second.
    """
    number = np.arange(pairs.shape[0])
    off = pairs[:, 0] != pairs[:, 1]
    owner = np.concatenate([pairs[:, 0], pairs[off, 1]])
    partner = np.concatenate([pairs[:, 1], pairs[off, 0]])
    number = np.concatenate([number, ~number[off]])
    sort = np.lexsort((partner, owner))
    indptr = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=n_nodes))])
    return indptr, partner[sort], number[sort]


def refuse_above(limit: float | None, total: float, remedy: str) -> float:
    """The forecast ``total`` in bytes.

    Raises
    ------
    MemoryError
        A forecast above the limit, with both numbers and the remedy.
    """
    if limit is not None and total > limit:
        raise MemoryError(
            f"the compressed operator would take about {total / 1e9:.2f} GB, {limit / 1e9:.2f} GB "
            f"are allowed: raise the tolerance, or use compression = {remedy} (direct sums)"
        )
    return total
