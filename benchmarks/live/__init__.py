"""Speed of the live rig in node and in a browser, compared with the native FMUs in the orchestrator."""
