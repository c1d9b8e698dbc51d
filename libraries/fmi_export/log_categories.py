"""Categories of an FMU's log."""

LOG_CATEGORIES = {
    "logStatusWarning": "Something was limited or ignored.",
    "logStatusDiscard": "A question was refused, and nothing has changed.",
    "logStatusError": "The model stopped; fault_code says why.",
    "logStatusFatal": "The FMU cannot be used any more.",
    "logAll": "Everything.",
}
