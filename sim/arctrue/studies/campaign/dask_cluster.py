"""Runs a campaign on a Dask cluster; the module requires the optional extra ``cluster``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from arctrue.studies.campaign.task import CampaignError, Task, digest

Batch = Sequence[Task]
Results = list[tuple[Mapping[str, Any], float]]
Done = tuple[Batch, Results]
RETRIES = 3
CONNECT_S = 5.0


def cluster(
    do: partial[Results], batches: Sequence[Batch], scheduler: str, stopping: Callable[[], bool]
) -> Iterator[Done]:
    """Yield each batch as soon as a worker of the scheduler at this address finishes it.

    If a worker dies, another worker repeats its batch. Once ``stopping()`` is true, the next
    finished batch is the last. Raises CampaignError if the library is missing, the scheduler does
    not answer, or a batch kills four workers.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise CampaignError(
            "--scheduler needs the library distributed: pip install 'arctrue[cluster]'"
        ) from error
    try:
        client: Any = Client(scheduler, timeout=CONNECT_S)  # type: ignore[no-untyped-call]
    except OSError as error:
        raise CampaignError(f"no Dask scheduler answers at {scheduler}: {error}") from error
    try:
        # The key depends on work, code and batch: with equal keys the scheduler would mix two
        # campaigns.
        futures = {
            client.submit(
                do,
                list(batch),
                key=f"{do.args[0]}-{digest([*do.args, do.keywords['code'], list(batch)])[:24]}",
                retries=RETRIES,
                pure=False,
            ): batch
            for batch in batches
        }
        for future in as_completed(list(futures)):  # type: ignore[no-untyped-call]
            batch = futures.pop(future)
            try:
                results = future.result()
            except KilledWorker as error:
                raise CampaignError(f"a task kills every worker that takes it: {error}") from error
            yield batch, results
            future.release()
            if stopping():
                client.cancel(list(futures))
                break
    finally:
        client.close()
