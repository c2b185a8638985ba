"""Campaigns: many simulated runs with drawn faults, and what they say of a detector."""

from gtfdi._gtfdi import (
    campaign_compare as compare,
    campaign_rows as rows,
    campaign_run as run,
)

__all__ = ["compare", "rows", "run"]
