"""How fast the live rig computes in node and in a browser, beside the native FMUs in the orchestrator."""
