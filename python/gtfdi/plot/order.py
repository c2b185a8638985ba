"""Criteria of a model's order."""

from typing import Any

from matplotlib.axes import Axes

from gtfdi import DataError, EivOrderTable, FrischOrderTable, IndexTable, OrderTable
from gtfdi.plot._argument import of_type
from gtfdi.plot._panel import panel

_Table = OrderTable | EivOrderTable | FrischOrderTable | IndexTable


def orders(table: _Table, *, ax: Axes | None = None) -> Axes:
    """How far each order is above the best one by its criteria, the best with a full mark.

    AIC and MDL (BIC); of a table of the Frisch scheme the moment selection criterion. Of a table of
    structural indices each order, their sum, has the least value that any of its indices has.

    Parameters
    ----------
    table : OrderTable, EivOrderTable, FrischOrderTable or IndexTable
        What ``order_table``, ``eiv_order_table``, ``frisch_order_table`` or ``index_table`` gave.
    ax : Axes, optional
        Where it is drawn; a new figure where left out.

    Returns
    -------
    Axes

    Raises
    ------
    TypeError
        ``table`` is something else.
    DataError
        No order of ``table`` has the criterion.

    Examples
    --------
    >>> ax = gtfdi.plot.orders(gtfdi.order_table(u, y, orders=(1, 12)))
    >>> [line.get_label() for line in ax.lines]
    ['AIC', '_best AIC', 'MDL', '_best MDL']
    """
    of_type("table", table, OrderTable, EivOrderTable, FrischOrderTable, IndexTable)
    drawn = panel(ax)
    rows: list[dict[str, Any]] = [dict(row) for row in table]
    for (criterion, label), marker in zip(_criteria(table), ("o", "s"), strict=False):
        least = _least(rows, criterion)
        if not least:
            raise DataError(f"table: expected an order with {label}, found none")
        best = min(least, key=lambda order: least[order])
        (line,) = drawn.plot(
            list(least),
            [value - least[best] for value in least.values()],
            marker=marker,
            fillstyle="none",
            label=label,
        )
        drawn.plot([best], [0.0], marker, color=line.get_color(), label=f"_best {label}")
    drawn.set_xlabel("order")
    drawn.set_ylabel("above the best")
    # Differences from nothing to thousands on one axis.
    drawn.set_yscale("symlog", linthresh=10.0)
    drawn.legend(loc="best")
    return drawn


def _criteria(table: _Table) -> list[tuple[str, str]]:
    """The keys of the criteria of a table, and what they are called."""
    if isinstance(table, FrischOrderTable):
        return [("selection", "moment selection")]
    if isinstance(table, EivOrderTable):
        return [("aic", "AIC"), ("bic", "BIC")]
    return [("aic", "AIC"), ("mdl", "MDL")]


def _least(rows: list[dict[str, Any]], criterion: str) -> dict[int, float]:
    """The least value that each order has, where one is known, from the lowest order on."""
    least: dict[int, float] = {}
    for row in rows:
        if row[criterion] is not None:
            least[row["order"]] = min(row[criterion], least.get(row["order"], row[criterion]))
    return dict(sorted(least.items()))
