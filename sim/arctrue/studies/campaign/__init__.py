"""Runs many independent tasks on the cores of this machine, on a Dask cluster, or as shards.

A *task* is a mapping that JSON can represent; the *work* is a function ``module:function`` that
converts the task to a result, which JSON can represent too. A folder holds the results as lines
whose key depends on the content of the task, so a campaign can be stopped, resumed, split and
merged; its results do not depend on the machine.
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
