"""MCAP logs: what is in one, whether it is whole, what can be saved, and tables of it."""

from gtfdi._gtfdi import (
    log_attachment as attachment,
    log_export as export,
    log_info as info,
    log_messages as messages,
    log_recover as recover,
    log_verify as verify,
)

__all__ = ["attachment", "export", "info", "messages", "recover", "verify"]
