"""MCAP logs: what is in one, whether it is whole, what can be saved, and tables of it."""

from gtfdi._gtfdi import (
    log_export as export,
    log_info as info,
    log_recover as recover,
    log_verify as verify,
)

__all__ = ["export", "info", "recover", "verify"]
