"""Criteria of a model's order."""

from typing import Any

from matplotlib.axes import Axes

from gtfdi import EivOrderTable, OrderTable
from gtfdi.plot._argument import of_type
from gtfdi.plot._panel import panel


def orders(table: OrderTable | EivOrderTable, *, ax: Axes | None = None) -> Axes:
    """How far each order is above the best one by AIC and MDL (BIC), the best with a full mark.

    Parameters
    ----------
    table : OrderTable or EivOrderTable
        What ``order_table`` or ``eiv_order_table`` gave.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError
        ``table`` is something else.

    Examples
    --------
    >>> ax = gtfdi.plot.orders(gtfdi.order_table(u, y, orders=(1, 12)))
    >>> [line.get_label() for line in ax.lines]
    ['AIC', '_best AIC', 'MDL', '_best MDL']
    """
    of_type("table", table, OrderTable, EivOrderTable)
    drawn = panel(ax)
    criteria = ("aic", "mdl") if isinstance(table, OrderTable) else ("aic", "bic")
    rows: list[dict[str, Any]] = [dict(row) for row in table]
    for criterion, marker in zip(criteria, ("o", "s"), strict=True):
        there = [(row["order"], row[criterion]) for row in rows]
        known = [(order, value) for order, value in there if value is not None]
        least = min(value for _, value in known)
        (line,) = drawn.plot(
            [order for order, _ in known],
            [value - least for _, value in known],
            marker=marker,
            fillstyle="none",
            label=criterion.upper(),
        )
        best = min(known, key=lambda pair: pair[1])[0]
        drawn.plot([best], [0.0], marker, color=line.get_color(), label=f"_best {line.get_label()}")
    drawn.set_xlabel("order")
    drawn.set_ylabel("above the best")
    # Differences from nothing to thousands on one axis.
    drawn.set_yscale("symlog", linthresh=10.0)
    drawn.legend(loc="best")
    return drawn
