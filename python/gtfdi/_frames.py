"""Records and verdicts as tables of other packages, and records from such tables.

A table has a column ``time_s`` and a column a channel, which has the channel's tag as its name; a
channel's unit stands in the table's metadata where it has some.
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from gtfdi._extras import need
from gtfdi._gtfdi import Dataset, Detection, VerdictSeries
from gtfdi.errors import DataError, OptionError

TIME = "time_s"

#: How far a step between two samples may be off, relative to the sample time: what is lost where
#: times are stored in decimal digits or nanoseconds.
UNIFORM_TOLERANCE = 1e-3

Names: TypeAlias = str | Sequence[str]
Tabular: TypeAlias = Dataset | Detection | VerdictSeries


def columns(thing: Tabular) -> dict[str, Any]:
    """The columns of a table by name, in order."""
    found: dict[str, Any] = {TIME: thing.time_s}
    if isinstance(thing, Dataset):
        found |= dict(zip(thing.inputs, thing.u.T)) | dict(zip(thing.outputs, thing.y.T))
    elif isinstance(thing, Detection):
        found |= {f"residual {tag}": row for tag, row in zip(thing.outputs, thing.residuals.T)}
        found |= {f"statistic {tag}": row for tag, row in zip(thing.tests, thing.statistics.T)}
    else:
        found["gap"] = thing.gap
        for what in ("residual", "statistic", "exceeds", "alarm", "settling"):
            rows = getattr(thing, what).T
            found |= {f"{what} {tag}": row for tag, row in zip(thing.tests, rows)}
    return found


def units(thing: Tabular) -> dict[str, str]:
    """The units of the columns that have one."""
    if not isinstance(thing, Dataset):
        return {TIME: "s"}
    channels = [*zip(thing.inputs, thing.input_units), *zip(thing.outputs, thing.output_units)]
    return {TIME: "s", **{tag: unit for tag, unit in channels if unit}}


def to_pandas(thing: Tabular) -> Any:
    """A ``pandas.DataFrame`` with the time in seconds as its index; units in ``attrs``."""
    pandas = need("pandas", "pandas")
    found = columns(thing)
    time_s = pandas.Index(found.pop(TIME), name=TIME)
    frame = pandas.DataFrame(found, index=time_s)
    frame.attrs["units"] = units(thing)
    return frame


def to_polars(thing: Tabular) -> Any:
    """A ``polars.DataFrame`` with the time in seconds in its first column."""
    polars = need("polars", "polars")
    return polars.DataFrame(
        {name: np.ascontiguousarray(row) for name, row in columns(thing).items()}
    )


def arrow_stream(thing: Tabular, requested_schema: Any) -> Any:
    """A capsule with an Arrow stream of one batch; units in the fields' metadata."""
    arrow = need("pyarrow", "arrow")
    own = units(thing)
    arrays, fields = [], []
    for name, row in columns(thing).items():
        array = arrow.array(np.ascontiguousarray(row))
        metadata = {"units": own[name]} if name in own else None
        arrays.append(array)
        fields.append(arrow.field(name, array.type, metadata=metadata))
    table = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields))
    return table.__arrow_c_stream__(requested_schema)


def from_pandas(
    frame: Any, inputs: Names, outputs: Names, sample_time_s: float | None, time: str | None
) -> Dataset:
    """The record in a ``pandas.DataFrame``: time from a column, the index or a sample time."""
    pandas = need("pandas", "pandas")
    if time is not None:
        stamps = _column(frame, time)
    elif isinstance(frame.index, pandas.RangeIndex) and sample_time_s is not None:
        stamps = None
    elif isinstance(frame.index, pandas.RangeIndex) and TIME in frame.columns:
        stamps = frame[TIME]
    elif isinstance(frame.index, pandas.RangeIndex):
        stamps = None
    else:
        stamps = frame.index
    own = frame.attrs.get("units", {}) if hasattr(frame, "attrs") else {}
    table = {tag: _column(frame, tag).to_numpy() for tag in (*_list(inputs), *_list(outputs))}
    stamps = None if stamps is None else np.asarray(stamps)
    return _record(table, stamps, inputs, outputs, sample_time_s, own)


def from_arrow(
    table: Any, inputs: Names, outputs: Names, sample_time_s: float | None, time: str | None
) -> Dataset:
    """The record in anything with ``__arrow_c_stream__``."""
    if not hasattr(table, "__arrow_c_stream__"):
        raise OptionError(
            "option table: expected an object with __arrow_c_stream__, such as a table of "
            f"pyarrow, polars or pandas, found {type(table).__name__}"
        )
    arrow = need("pyarrow", "arrow")
    found = arrow.table(table)
    if time is None and sample_time_s is None:
        time = TIME
    wanted = [*_list(inputs), *_list(outputs), *([time] if time is not None else [])]
    for tag in wanted:
        _check_tag(tag, found.column_names)
    arrays = {tag: found[tag].to_numpy() for tag in wanted}
    metadata = {tag: found.schema.field(tag).metadata or {} for tag in wanted}
    own = {tag: entry[b"units"].decode() for tag, entry in metadata.items() if b"units" in entry}
    stamps = None if time is None else arrays[time]
    return _record(arrays, stamps, inputs, outputs, sample_time_s, own)


def _list(names: Names) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _column(frame: Any, tag: str) -> Any:
    _check_tag(tag, [str(name) for name in frame.columns])
    return frame[tag]


def _check_tag(tag: str, there: Sequence[str]) -> None:
    if tag not in there:
        raise DataError(
            f"channel `{tag}`: expected one of {', '.join(there)}, found no such column"
        )


def _record(
    table: dict[str, Any],
    stamps: Any,
    inputs: Names,
    outputs: Names,
    sample_time_s: float | None,
    own: dict[str, str],
) -> Dataset:
    start_s = 0.0
    if stamps is not None:
        start_s, sample_time_s = _uniform(_seconds(stamps), sample_time_s)
    elif sample_time_s is None:
        raise OptionError(
            "option sample_time_s: expected seconds, or times in an index or a column, found neither"
        )
    first, second = _list(inputs), _list(outputs)
    u, y = (_stacked([table[tag] for tag in tags]) for tags in (first, second))
    names = {"inputs": first, "outputs": second}
    input_units, output_units = ([own.get(tag, "") for tag in tags] for tags in (first, second))
    return Dataset(
        u,
        y,
        sample_time_s,
        **names,
        input_units=input_units,
        output_units=output_units,
        start_time_s=start_s,
    )


def _stacked(rows: list[Any]) -> Any:
    return np.stack([np.asarray(row) for row in rows], axis=1)


def _seconds(stamps: Any) -> Any:
    """Times in seconds: instants count from the first."""
    if np.issubdtype(stamps.dtype, np.datetime64):
        stamps = stamps - stamps[:1]
    if np.issubdtype(stamps.dtype, np.timedelta64):
        return stamps / np.timedelta64(1, "s")
    if not np.issubdtype(stamps.dtype, np.number):
        raise DataError(f"times: expected seconds or instants, found dtype {stamps.dtype}")
    return stamps.astype(np.float64)


def _uniform(time_s: Any, given_s: float | None) -> tuple[float, float]:
    """Start and sample time of times that are a constant step apart."""
    if len(time_s) < 2 and given_s is None:
        raise DataError(f"times: expected two samples or a sample_time_s, found {len(time_s)}")
    if len(time_s) < 2:
        return (float(time_s[0]) if len(time_s) else 0.0), float(given_s or 0.0)
    steps_s = np.diff(time_s)
    # What most steps are, so that one that is not is named.
    usual_s = given_s if given_s is not None else float(np.median(steps_s))
    wrong = ~(np.abs(steps_s - usual_s) <= UNIFORM_TOLERANCE * abs(usual_s))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise DataError(
            f"times, sample {row + 1}: expected {usual_s:g} s after the one before, "
            f"found {steps_s[row]:g} s"
        )
    # A mean of many steps has rounding in its last digits, a sample time has not.
    mean_s = float(f"{(time_s[-1] - time_s[0]) / len(steps_s):.12g}")
    step_s = given_s if given_s is not None else mean_s
    return float(time_s[0]), float(step_s)
