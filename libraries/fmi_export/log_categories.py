"""Categories of an FMU's log."""

LOG_CATEGORIES = {
    "logStatusWarning": "Something was limited or ignored.",
    "logStatusDiscard": "A step was refused.",
    "logStatusError": "The model stopped; fault_code says why.",
    "logStatusFatal": "The FMU cannot be used any more.",
    "logAll": "Everything.",
}
