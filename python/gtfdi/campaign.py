"""Campaigns: many simulated runs with drawn faults, and what they say of a detector."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from contextlib import closing
from typing import Any

from gtfdi._batches import Batches, Client, executor_of, limit_of
from gtfdi._gtfdi import (
    _CampaignDesk,
    campaign_compare as compare,
    campaign_rows as rows,
    campaign_run,
)

__all__ = ["compare", "rows", "run"]


def run(
    spec: str | os.PathLike[str],
    out: str | os.PathLike[str],
    executor: Executor | Client | None = None,
    *,
    in_flight: int | None = None,
) -> dict[str, Any]:
    """Runs a campaign on all cores, or what is left of it, and says what its runs say.

    The folder then has ``rows.parquet``, ``summary.json`` and ``report.html``. Ctrl-C leaves whole
    files: the same call goes on from there, and the rows are the same bits whatever the number of
    threads (``RAYON_NUM_THREADS``).

    Parameters
    ----------
    spec : path_like
        The campaign's TOML file.
    out : path_like
        Its folder: new, or one that this campaign began.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Who makes the rows: threads, processes, or machines. Without one it is the cores of this
        process. The bank is made here, on all cores, and only this process writes: workers are
        sent what they need, use one core each and share no file system. The rows are the same
        bytes, where the workers have the same gtfdi and the same C library. Processes that are
        spawned import the main module, so a script that starts them needs
        ``if __name__ == "__main__":``.
    in_flight : int, optional
        Batches handed out at a time; twice the workers of an executor that says how many it has,
        else 64. A batch takes about 4 s, or as long as 32 runs take.

    Returns
    -------
    dict
        What ``gtfdi campaign --json`` prints.

    Raises
    ------
    DesignError
        The file says something that makes no sense, or the folder is another campaign's; a worker
        has another gtfdi.
    GtfdiError
        A worker failed: which runs it had is said, all that had come back is kept, and the same
        call goes on from there.
    OptionError
        The executor is none.

    Examples
    --------
    >>> from gtfdi import campaign
    >>> text = '''
    ... seed = 1
    ... runs = 4
    ... [record]
    ... duration_s = 40.0
    ... onset_s = [10.0, 20.0]
    ... [[faults]]
    ... case = "thermocouple_drift"
    ... size = { log_uniform = [0.5, 1.0] }
    ... shape = { ramp = { rise_s = 5.0 } }
    ... [bank]
    ... arl0_h = 0.02
    ... calibration_h = 0.2
    ... tests = [{ statistic = "cusum" }]
    ... '''
    >>> _ = open("drift.toml", "w").write(text)
    >>> summary = campaign.run("drift.toml", "drift")
    >>> summary["runs"], summary["failed"]
    (4, 0)

    On the workers of an executor:

    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as executor:
    ...     spread = campaign.run("drift.toml", "spread", executor)
    >>> spread == summary
    True
    """
    if executor is None:
        return campaign_run(spec, out)
    workers = executor_of(executor)
    limit = limit_of(workers, in_flight)
    # Closed whatever happens: an exception that is kept would keep the folder locked.
    with closing(_CampaignDesk(spec, out)) as desk:
        Batches(desk, workers, limit, os.fspath(out)).run()
        return desk.finish()
