"""Export for other tools: FMUs of the models, one FMU of all three models, and SSP archives."""
