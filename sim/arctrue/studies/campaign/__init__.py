"""Runs many independent tasks on the cores of this machine, on a Dask cluster, or as shards.

A *task* is a mapping that JSON can hold; the *work* is a function ``module:function`` that turns
it into a result of the same kind. Results are lines in a folder, keyed by the task's content, so a
campaign can be stopped, resumed, split and merged, and says the same whoever computed it.
"""

from arctrue.studies.campaign.campaign import Campaign, Interrupted, Speed
from arctrue.studies.campaign.code_state import Sources
from arctrue.studies.campaign.store import Result, Store, StoreError, read_results
from arctrue.studies.campaign.task import CampaignError, Task, task_key

__all__ = [
    "Campaign",
    "CampaignError",
    "Interrupted",
    "Result",
    "Sources",
    "Speed",
    "Store",
    "StoreError",
    "Task",
    "read_results",
    "task_key",
]
