"""Categories of an FMU's log."""

LOG_CATEGORIES = {
    "logStatusWarning": "Something was limited or ignored.",
    "logStatusDiscard": "A request was refused, and nothing has changed.",
    "logStatusError": "The model stopped; fault_code says why.",
    "logStatusFatal": "The FMU can no longer be used.",
    "logAll": "All messages.",
}
