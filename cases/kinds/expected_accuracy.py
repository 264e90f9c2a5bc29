"""What `airfold check` says of the traction's error before a run: its shares and the verdict."""

from __future__ import annotations

from hbem.accuracy import Budget
from hbem.surfaces.quadrature import QuadratureOrders

from ..output.forecast import Item


def expected_accuracy(
    asked: Budget, orders: QuadratureOrders, krylov: float = 0.0, *, compressed: bool
) -> list[Item]:
    """What the traction tolerance comes to in the narrowest gap.

    Parameters
    ----------
    asked : Budget
    orders : QuadratureOrders
        Those of the run.
    krylov : float
        True relative residual that a scene insists on; 0 for that of the budget.
    compressed : bool
        Whether the single layer is compressed at all.

    Returns
    -------
    list of Item
    """
    p, c, verdict = asked.predicted, asked.compression, asked.expected.verdict
    compression = p["compression"] if compressed else 0.0
    near = f"sinh {orders.near_offset:g} + {orders.near_slope:g} ln(1/b)"
    self_rule = f"polar {orders.radial} x {orders.angular}, far {orders.source} x {orders.source}"
    matrices = f"quadrature {p['quadrature']:.1e}, compression at most {compression:.1e}"
    return [
        Item(
            "traction tolerance", asked.traction, "", f"in a gap of thinness {asked.thinness:.2g}"
        ),
        Item("traction error", verdict.value, "", "before the run, from its three shares"),
        Item("  of the mesh", "not known", "", "the run measures it in its first step"),
        Item("  of quadrature and compression", p["quadrature"] + compression, "", matrices),
        Item("    rules", near, "", self_rule),
        Item("    matrix tolerance", f"H2 {c['h2']:.1e}", "", f"ACA {c['aca']:.1e}"),
        Item("  of Krylov", p["krylov"], "", f"true residual {krylov or asked.krylov:.1e}"),
    ]
